#!/usr/bin/env python3
"""Writes scenes/lights/images/sky.hdr: a clear sky over dark ground, with a sun of 1 pixel that is 10,000 times as
bright as the sky. Needs only Python; the output is deterministic.

  scenes/make/make_sky.py
"""

import math
from pathlib import Path

WIDTH, HEIGHT = 128, 64
SUN = (93, 20)  # column and row
FILE = Path(__file__).resolve().parents[2] / "scenes" / "lights" / "images" / "sky.hdr"


def radiance(column, row):
    if (column, row) == SUN:
        return (10400, 10000, 8800)
    up = math.cos(math.pi * row / (HEIGHT - 1))
    if up <= 0:
        return (0.10, 0.09, 0.07)
    haze = (1 - up) ** 4
    return (0.55 + 0.9 * haze, 0.85 + 0.6 * haze, 1.5 + 0.1 * haze)


def rgbe(color):
    """Encodes a color as RGBE (Ward): three mantissas and a shared exponent."""
    mantissa, exponent = math.frexp(max(color))
    scale = mantissa * 256 / max(color)
    return bytes([*(int(c * scale) for c in color), exponent + 128])


def main():
    FILE.parent.mkdir(parents=True, exist_ok=True)
    with open(FILE, "wb") as file:
        file.write(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n" % (HEIGHT, WIDTH))
        for row in range(HEIGHT):
            file.write(b"".join(rgbe(radiance(column, row)) for column in range(WIDTH)))


if __name__ == "__main__":
    main()
