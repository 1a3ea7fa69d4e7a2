#!/usr/bin/env python3
"""Renders the caustic of a glass ball by path tracing and by light tracing, and the difference. Needs Matplotlib.

  python3 light_tracing.py caustic.png
"""

import matplotlib.pyplot as plt
import numpy as np

import common
import sheaf


def main():
    parser = common.parser(__doc__, 64, (320, 240))
    parser.add_argument("output")
    arguments = parser.parse_args()

    scene = common.still_life()
    scene.remove("sky")  # light tracing has no paths from the sky to begin with
    figure, axes = plt.subplots(1, 3, figsize=(12, 3.5))
    images = []
    for integrator, title in (("path", "path tracing"), ("ptracer", "light tracing")):
        result = sheaf.render(scene, spp=arguments.spp, size=arguments.size, integrator=integrator)
        images.append(result.image[:, :, :3])
        axes[len(images) - 1].imshow(np.clip(images[-1], 0, 1) ** (1 / 2.2))
        axes[len(images) - 1].set_title(f"{title}, {arguments.spp} spp")
    difference = (images[1] - images[0]).mean(axis=2)
    axes[2].imshow(difference, cmap="RdBu", vmin=-0.5, vmax=0.5)
    axes[2].set_title(f"difference, mean {difference.mean():.4f}")
    for axis in axes:
        axis.axis("off")
    figure.tight_layout()
    figure.savefig(arguments.output)


if __name__ == "__main__":
    main()
