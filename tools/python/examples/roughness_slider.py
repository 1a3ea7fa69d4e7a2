#!/usr/bin/env python3
"""Shows the scene with a slider for the roughness of the metal. Needs Matplotlib.

  python3 roughness_slider.py
  python3 roughness_slider.py --save strip.png     # without a window: several values beside each other
"""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.widgets import Slider

import common
import sheaf


def main():
    parser = common.parser(__doc__, 8, (320, 240))
    parser.add_argument("--save", help="an image instead of a window")
    arguments = parser.parse_args()
    scene = common.still_life()

    def render(alpha):
        scene.materials["metal"].alpha = float(alpha)
        image = sheaf.render(scene, spp=arguments.spp, size=arguments.size, denoise="nlm")["denoised"]
        return np.clip(image, 0, 1) ** (1 / 2.2)

    if arguments.save:
        figure, axes = plt.subplots(1, 4, figsize=(12, 2.6))
        for axis, alpha in zip(axes, (0.02, 0.1, 0.3, 0.6)):
            axis.imshow(render(alpha))
            axis.set_title(f"alpha = {alpha}")
            axis.axis("off")
        figure.tight_layout()
        figure.savefig(arguments.save)
        return
    _, axis = plt.subplots()
    shown = axis.imshow(render(0.15))
    axis.axis("off")
    slider = Slider(plt.axes((0.2, 0.03, 0.6, 0.04)), "alpha", 0.01, 1, valinit=0.15)

    def update(alpha):
        shown.set_data(render(alpha))
        plt.draw()

    slider.on_changed(update)
    plt.show()


if __name__ == "__main__":
    main()
