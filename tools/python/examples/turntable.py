#!/usr/bin/env python3
"""Renders a camera that turns around a scene, as PNG files and an animated GIF. The GIF needs Pillow (python3-pil).

  python3 turntable.py turntable.gif --frames 36
"""

from pathlib import Path

import common
import sheaf


def main():
    parser = common.parser(__doc__, 32, (320, 240))
    parser.add_argument("output", type=Path, help="the GIF; the PNG files are written beside it")
    parser.add_argument("--frames", type=int, default=36)
    arguments = parser.parse_args()

    scene = common.still_life()
    files = []
    for frame in range(arguments.frames):
        # Only the camera changes: the acceleration structure is kept
        scene.camera.to_world = common.look_from(360 * frame / arguments.frames, 20)
        files.append(arguments.output.with_name(f"{arguments.output.stem}_{frame:04}.png"))
        sheaf.render(scene, spp=arguments.spp, size=arguments.size, denoise="nlm").write(files[-1])

    try:
        from PIL import Image
    except ImportError:
        print(f"Pillow is not installed: wrote {len(files)} PNG files, but no GIF")
        return
    images = [Image.open(file).convert("RGB") for file in files]
    images[0].save(arguments.output, save_all=True, append_images=images[1:], duration=80, loop=0)


if __name__ == "__main__":
    main()
