#!/usr/bin/env python3
"""Writes the meshes of scenes/caustics to scenes/caustics/generated: a ring and the water surface of a pool. Needs only
Python; the output is deterministic.

  scenes/make/make_caustic_scenes.py
"""

import math
import random
from pathlib import Path

FOLDER = Path(__file__).resolve().parents[2] / "scenes" / "caustics" / "generated"

# The ring: outer and inner radius, and height, in meters.
OUTER, INNER, HEIGHT = 1.0, 0.94, 0.42
RING_SIDES = 360

# The water: half extents along x and z in meters, cells along x and z, and waves (length in meters, slope).
HALF_X, HALF_Z = 2.02, 1.52
CELLS_X, CELLS_Z = 268, 202
WAVES = [(1.55, 0.030), (1.10, 0.035), (0.81, 0.050), (0.60, 0.060), (0.44, 0.050), (0.33, 0.035)]
DIRECTIONS_PER_WAVE = 3


def write_obj(path, what, places, normals, faces):
    """Writes an OBJ file. Faces are tuples of 0-based indices, shared by positions and normals."""
    lines = [f"# {what}, written by scenes/make/make_caustic_scenes.py."]
    lines += ["v {:.6g} {:.6g} {:.6g}".format(*p) for p in places]
    lines += ["vn {:.6f} {:.6f} {:.6f}".format(*n) for n in normals]
    lines += ["f " + " ".join(f"{i + 1}//{i + 1}" for i in face) for face in faces]
    path.write_text("\n".join(lines) + "\n")


# Profile of the ring: per wall, radius and height of both ends and the normal, counter-clockwise from the outer wall.
# The edges are sharp, so that the camera sees no reflection of the lamp in a rounded edge.
RING_WALLS = [
    ((OUTER, 0), (OUTER, HEIGHT), (1, 0)),
    ((OUTER, HEIGHT), (INNER, HEIGHT), (0, 1)),
    ((INNER, HEIGHT), (INNER, 0), (-1, 0)),
    ((INNER, 0), (OUTER, 0), (0, -1)),
]


def make_ring():
    """Writes a closed surface of revolution about +y that stands on y = 0, with smooth normals around the axis."""
    places, normals, faces = [], [], []
    stride = 2 * len(RING_WALLS)
    for k in range(RING_SIDES):
        c, s = math.cos(2 * math.pi * k / RING_SIDES), math.sin(2 * math.pi * k / RING_SIDES)
        for *ends, normal in RING_WALLS:
            for radius, height in ends:
                places.append((radius * c, height, radius * s))
                normals.append((normal[0] * c, normal[1], normal[0] * s))
        a, b = k * stride, (k + 1) % RING_SIDES * stride
        faces += [(a + i, a + i + 1, b + i + 1, b + i) for i in range(0, stride, 2)]
    write_obj(FOLDER / "ring.obj", "A ring", places, normals, faces)


def make_water():
    """Writes a sheet near y = 0 displaced by a sum of sines, normals upwards."""
    numbers = random.Random(5)
    waves = []
    for length, slope in WAVES:
        for _ in range(DIRECTIONS_PER_WAVE):
            angle, phase = numbers.uniform(0, 2 * math.pi), numbers.uniform(0, 2 * math.pi)
            k = 2 * math.pi / (length * numbers.uniform(0.9, 1.1))
            waves.append((k * math.cos(angle), k * math.sin(angle), phase, slope / k))
    places, normals, faces = [], [], []
    for j in range(CELLS_Z + 1):
        z = HALF_Z * (2 * j / CELLS_Z - 1)
        for i in range(CELLS_X + 1):
            x = HALF_X * (2 * i / CELLS_X - 1)
            y = slope_x = slope_z = 0.0
            for kx, kz, phase, amplitude in waves:
                argument = kx * x + kz * z + phase
                y += amplitude * math.sin(argument)
                slope_x += kx * amplitude * math.cos(argument)
                slope_z += kz * amplitude * math.cos(argument)
            length = math.sqrt(1 + slope_x * slope_x + slope_z * slope_z)
            places.append((x, y, z))
            normals.append((-slope_x / length, 1 / length, -slope_z / length))
            if i < CELLS_X and j < CELLS_Z:
                a = j * (CELLS_X + 1) + i
                b = a + CELLS_X + 1
                faces.append((a, b, b + 1, a + 1))
    write_obj(FOLDER / "water.obj", "The surface of water", places, normals, faces)


def main():
    FOLDER.mkdir(parents=True, exist_ok=True)
    make_ring()
    make_water()


if __name__ == "__main__":
    main()
