#!/usr/bin/env python3
"""Writes the mesh and the instances of scenes/million: copies of one mesh of 100,000 triangles, scattered over a plane
with a fixed seed. Needs only Python. The output (about 200 MB for 1,000,000 instances) is not part of the repository.

  scenes/make/make_instances.py [COUNT]   default: 1000000
"""

import math
import random
import sys

from make_meshes import ROOT, knot_line, torus_surface, write_ply

FOLDER = ROOT / "scenes" / "million" / "generated"


def make_mesh():
    def radius(t, angle):
        return 0.24 + 0.025 * math.cos(2 * math.pi * (9 * angle + 12 * t)) + 0.02 * math.sin(2 * math.pi * 90 * t)

    positions, normals, triangles = torus_surface(knot_line(2, 3), radius, 1000, 50)
    write_ply(FOLDER / "knot.ply", "torus knot", positions, triangles, normals)


def matrix(rng, spread):
    """Returns a random rotation, scale and position on the plane y = 0."""
    q = [rng.gauss(0, 1) for _ in range(4)]
    norm = math.sqrt(sum(c * c for c in q))
    w, x, y, z = (c / norm for c in q)
    size = 0.15 + 0.2 * rng.random()
    turn = ((1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
            (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
            (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)))
    place = (spread * (2 * rng.random() - 1), 1.2 * size, spread * (2 * rng.random() - 1))
    rows = [tuple(size * c for c in row) + (p,) for row, p in zip(turn, place)]
    return " ".join(f"{c:.6g}" for row in rows for c in row) + " 0 0 0 1"


def make_instances(count):
    rng = random.Random(1)
    spread = 0.5 * math.sqrt(count)
    with open(FOLDER / "instances.xml", "w", encoding="ascii") as out:
        out.write("<scene version='3.0.0'>\n")
        for _ in range(count):
            out.write('<shape type="instance"><ref id="knot"/><transform name="to_world">'
                      f'<matrix value="{matrix(rng, spread)}"/></transform></shape>\n')
        out.write("</scene>\n")


def main(arguments):
    if len(arguments) > 1 or not all(a.isdecimal() for a in arguments):
        sys.exit(__doc__)
    make_mesh()
    make_instances(int(arguments[0]) if arguments else 1_000_000)


if __name__ == "__main__":
    main(sys.argv[1:])
