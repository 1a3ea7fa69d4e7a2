#!/usr/bin/env python3
"""Writes the small grids of tests/references/scenes/volumes. Needs only Python, and always writes the same bytes."""

import math
import struct
from pathlib import Path

FOLDER = Path(__file__).resolve().parent / "scenes" / "volumes"


def write_vol(name, size, channels, value):
    """Writes version 3, 32-bit floats, x fastest, from value(x, y, z, channel). The box is the unit cube."""
    x, y, z = size
    header = b"VOL\x03" + struct.pack("<5i6f", 1, x, y, z, channels, 0, 0, 0, 1, 1, 1)
    values = [value(i, j, k, c) for k in range(z) for j in range(y) for i in range(x) for c in range(channels)]
    (FOLDER / name).write_bytes(header + struct.pack(f"<{len(values)}f", *values))


def main():
    FOLDER.mkdir(exist_ok=True)
    write_vol("density.vol", (4, 3, 2), 1, lambda x, y, z, c: 0.5 + 0.5 * math.sin(2.1 * x + 3.7 * y * y + 1.3 * z))
    write_vol("albedo.vol", (2, 2, 2), 3, lambda x, y, z, c: 0.9 - 0.5 * ((x + 2 * y + z + c) % 3) / 2)


if __name__ == "__main__":
    main()
