#!/usr/bin/env python3
"""Writes a large environment map for benchmarks: fractal clouds, a sun of realistic size with glare, and ground of
uneven brightness. Needs only Python; the output is deterministic. A width of 4096 pixels takes 1 min.

  scenes/make/make_cloudy_sky.py sky.hdr [--width 4096]
"""

import argparse
import math
import random

from make_sky import rgbe

SUN = (0.37, 0.28)  # longitude over 2 pi, polar angle over pi
SUN_RADIUS = math.radians(0.2665)


class Noise:
    """Fractal value noise, periodic in x: each octave doubles the frequency and halves the amplitude."""

    def __init__(self, seed, octaves, first=8):
        numbers = random.Random(seed)
        self.lattices = []
        for octave in range(octaves):
            columns, rows = first << octave, (first << octave) // 2 + 2
            values = [[numbers.random() for _ in range(columns)] for _ in range(rows)]
            self.lattices.append((0.5 ** (octave + 1), columns, values))

    def row(self, v, width):
        """Returns noise in [0, 1] at `width` points of the row at v in [0, 1]."""
        total = [0.0] * width
        for weight, columns, values in self.lattices:
            y = v * columns / 2
            j = int(y)
            above, below, t = values[j], values[j + 1], y - j
            line = [weight * (a + t * (b - a)) for a, b in zip(above, below)]
            line.append(line[0])
            step = columns / width
            for i in range(width):
                x = i * step
                k = int(x)
                x -= k
                total[i] += line[k] + x * x * (3 - 2 * x) * (line[k + 1] - line[k])
        return total


def sky_row(v, width, noise):
    up, glare_row = math.cos(math.pi * v), []
    haze = (1 - up) ** 4
    sine, sun_sine = math.sin(math.pi * v), math.sin(math.pi * SUN[1])
    for i, n in enumerate(noise):
        turn = math.cos(2 * math.pi * (i / width - SUN[0]))
        cosine = up * math.cos(math.pi * SUN[1]) + sine * sun_sine * turn
        angle = math.acos(max(-1.0, min(1.0, cosine)))
        cloud = max(0.0, n - 0.5) * 6
        glare = math.exp(-angle * 6)
        light = cloud * (0.5 + 3 * glare) + 2 * glare ** 3
        color = (0.15 + 0.5 * haze + light, 0.25 + 0.5 * haze + light, 0.55 + 0.3 * haze + 0.95 * light)
        if angle < SUN_RADIUS:
            color = (22000, 20000, 17000)
        glare_row.append(color)
    return glare_row


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file")
    parser.add_argument("--width", type=int, default=4096)
    arguments = parser.parse_args()
    width, height = arguments.width, arguments.width // 2
    octaves = max(1, int(math.log2(width)) - 3)
    clouds, ground = Noise(1, octaves), Noise(2, octaves)
    with open(arguments.file, "wb") as file:
        file.write(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n" % (height, width))
        for row in range(height):
            v = (row + 0.5) / height
            if v < 0.5:
                colors = sky_row(v, width, clouds.row(v, width))
            else:
                colors = [(0.3 * n * n, 0.28 * n * n, 0.2 * n * n) for n in ground.row(v, width)]
            file.write(b"".join(rgbe(color) for color in colors))


if __name__ == "__main__":
    main()
