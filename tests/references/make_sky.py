#!/usr/bin/env python3
"""Writes scenes/images/sky.exr, the environment map of the references: a sky, a sun of a few pixels, the ground."""

from pathlib import Path

import mitsuba as mi
import numpy as np

WIDTH, HEIGHT = 64, 32


def main():
    mi.set_variant("scalar_rgb")
    x, y = np.meshgrid((np.arange(WIDTH) + 0.5) / WIDTH, np.arange(HEIGHT) / (HEIGHT - 1))
    up = np.cos(np.pi * y)
    sky = np.where(up > 0, 1.0, 0.0)[..., None] * (np.array([0.3, 0.5, 0.9]) + (1 - up)[..., None] * [0.5, 0.3, 0.0])
    ground = np.where(up > 0, 0.0, 1.0)[..., None] * (np.array([0.25, 0.2, 0.12]) * (1 + np.cos(4 * np.pi * x))[..., None])
    image = 0.6 * (sky + ground)
    image[8:10, 41:43] = [90, 75, 50]
    folder = Path(__file__).resolve().parent / "scenes" / "images"
    folder.mkdir(exist_ok=True)
    mi.Bitmap(image.astype(np.float32)).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float16, False).write(
        str(folder / "sky.exr"))


if __name__ == "__main__":
    main()
