#!/usr/bin/env python3
"""Writes the files of scenes/shapes, scenes/cameras and scenes/subsurface to their folders generated/: locks of hair,
balls of yarn, signed distance fields and a chess pawn. Needs numpy; the output is deterministic.

  scenes/make/make_shape_scenes.py
"""

import struct
from pathlib import Path

import numpy as np

SCENES = Path(__file__).resolve().parents[2] / "scenes"
SHAPES, CAMERAS, SUBSURFACE = (SCENES / name / "generated" for name in ("shapes", "cameras", "subsurface"))


def write_curves(path, curves):
    """Writes curves, each an array of rows x, y, z and radius."""
    path.write_text("\n\n".join("\n".join("{:.4f} {:.4f} {:.4f} {:.5f}".format(*p) for p in c) for c in curves) + "\n")


def make_lock(seed, turns, width, fibers=1800, points=22):
    """A lock of hair that hangs from y = 1: fibers in a bundle that tapers and winds into a helix of `turns` turns."""
    random = np.random.default_rng(seed)
    t = np.linspace(0, 1, points)
    curves = []
    for _ in range(fibers):
        r, a = width * np.sqrt(random.random()), 2 * np.pi * random.random()
        length = 1 - 0.42 * random.random()**2.5
        s = t * length
        # The bundle narrows to a third at the tip; its fibers twist with it and stray a little.
        phase = 2 * np.pi * turns * s**1.3 + 0.4 * random.normal()
        wave = 0.14 * s**1.2 * (turns > 0)
        spread = r * (1 - 0.78 * s) * (1 + 0.35 * np.sin(np.pi * np.minimum(2 * s, 1)))
        stray = 0.035 * random.normal(size=2)
        x = spread * np.cos(a + 0.3 * phase) + wave * np.cos(phase) + stray[0] * s
        z = 0.7 * spread * np.sin(a + 0.3 * phase) + wave * np.sin(phase) + stray[1] * s
        x += 0.012 * np.sin(9 * s + 6 * random.random()) * s
        curves.append(np.column_stack([x, 1 - 2.2 * s, z, np.interp(s, [0, 0.8, 1], [0.0042, 0.0036, 0.0012])]))
    return curves


def make_yarn(seed, windings, thickness=0.035, plies=3, points=100):
    """A ball of radius 1 wound from yarn, each ply a curve around the middle of the yarn."""
    random = np.random.default_rng(seed)
    count = windings * points
    angle = 2 * np.pi * np.arange(count) / points
    # The plane of the winding turns slowly, and jumps between layers.
    turn = np.arange(count) / points
    lean = 0.5 * np.pi + 1.15 * np.sin(0.613 * turn) + np.interp(turn, range(windings + 1),
                                                                  0.25 * random.normal(size=windings + 1))
    around = 2.4 * np.floor(turn / 9) + 0.217 * turn
    first = np.stack([np.cos(around), np.zeros(count), np.sin(around)], axis=-1)
    second = np.stack([-np.sin(around) * np.cos(lean), np.sin(lean), np.cos(around) * np.cos(lean)], axis=-1)
    out = first * np.cos(angle)[:, None] + second * np.sin(angle)[:, None]
    middle = out * (0.93 + 0.045 * turn / windings + 0.02 * np.sin(0.31 * angle))[:, None]
    along = np.gradient(middle, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    side = np.cross(along, out)
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    up = np.cross(side, along)
    twist = np.cumsum(np.linalg.norm(np.gradient(middle, axis=0), axis=1)) * 2 * np.pi / (7 * thickness)
    curves = []
    for ply in range(plies):
        phase = (twist + 2 * np.pi * ply / plies)[:, None]
        curves.append(np.column_stack([middle + 0.52 * thickness * (np.cos(phase) * side + np.sin(phase) * up),
                                       np.full(count, 0.55 * thickness)]))
    return curves


def make_basket(ribs=36, rings=9):
    """A bowl of wire, of radius 1: meridians, and rings that close on themselves."""
    curves = []
    for k in range(ribs):
        a, s = 2 * np.pi * k / ribs, np.linspace(0.08, 1, 24)
        curves.append(bowl(s, np.full(24, a) + 0.5 * s, 0.009))
    for ring in range(rings):
        s = 0.12 + 0.88 * ring / (rings - 1)
        a = np.linspace(0, 2 * np.pi, 97)
        curves.append(bowl(np.full(97, s), a, 0.022 if ring == rings - 1 else 0.009))
    return curves


def bowl(s, angle, radius):
    """Points of a bowl of unit radius and height 0.5 at the parameter s along its profile."""
    r = np.sin(0.5 * np.pi * s)**0.8
    return np.column_stack([r * np.cos(angle), 0.5 * (1 - np.cos(0.5 * np.pi * s)), r * np.sin(angle),
                            np.full(len(s), radius)])


def write_vol(path, function, low, high, resolution):
    """Writes a function at the points of a grid over a box; it is an array function of x, y and z."""
    axes = [np.linspace(low[k], high[k], resolution[k]) for k in (2, 1, 0)]
    z, y, x = np.meshgrid(*axes, indexing="ij")
    values = function(x, y, z).astype("<f4")
    path.write_bytes(b"VOL\x03" + struct.pack("<5i6f", 1, *resolution, 1, *low, *high) + values.tobytes())


def net_vertices(value):
    """Surface nets: a vertex per cell that the zero level set crosses, at the mean of its crossings with the edges.
    Returns their positions in units of cells, and the number of the vertex of each cell, or -1."""
    cells = tuple(n - 1 for n in value.shape)
    total, count = np.zeros((*cells, 3)), np.zeros(cells)

    def corner(c):
        return value[tuple(slice(c[k], c[k] + cells[k]) for k in range(3))]

    for a in np.ndindex(2, 2, 2):
        for k in range(3):
            if a[k]:
                continue
            va, vb = corner(a), corner(tuple(a[j] + (j == k) for j in range(3)))
            crosses = (va < 0) != (vb < 0)
            t = np.where(crosses, va / np.where(crosses, va - vb, 1), 0)
            for j in range(3):
                total[..., j] += crosses * (a[j] + t * (j == k))
            count += crosses
    used = count > 0
    number = np.full(cells, -1)
    number[used] = np.arange(used.sum())
    return np.argwhere(used) + total[used] / count[used][:, None], number


def net_faces(value, number):
    """Returns a quadrilateral per grid edge that the zero level set crosses, counter-clockwise seen from outside."""
    faces = []
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        inner = [slice(1, -1)] * 3
        low, high = list(inner), list(inner)
        low[k], high[k] = slice(0, -1), slice(1, None)
        va, vb = value[tuple(low)], value[tuple(high)]
        edges = np.argwhere((va < 0) != (vb < 0))
        quad = []
        for di, dj in ((0, 0), (1, 0), (1, 1), (0, 1)):
            cell = edges.copy()
            cell[:, i] += di
            cell[:, j] += dj
            quad.append(number[tuple(cell.T)])
        quad = np.stack(quad, axis=-1)
        faces.append(np.where((va[tuple(edges.T)] < 0)[:, None], quad, quad[:, ::-1]))
    return np.concatenate(faces)


def write_mesh(path, function, low, high, resolution):
    """Writes the zero level set of a function in a box as a closed mesh with smooth normals."""
    axes = [np.linspace(low[k], high[k], resolution[k]) for k in range(3)]
    value = function(*np.meshgrid(*axes, indexing="ij"))
    vertices, number = net_vertices(value)
    points = vertices * (np.array(high) - low) / (np.array(resolution) - 1) + low
    steps = 1e-3 * np.eye(3)
    normals = np.stack([function(*(points + h).T) - function(*(points - h).T) for h in steps], axis=-1)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    faces = net_faces(value, number)
    rows = np.zeros(len(faces), dtype=[("count", "u1"), ("indices", "<i4", 4)])
    rows["count"], rows["indices"] = 4, faces
    properties = "".join(f"property float {name}\n" for name in ("x", "y", "z", "nx", "ny", "nz"))
    header = ("ply\nformat binary_little_endian 1.0\ncomment written by scenes/make/make_shape_scenes.py\n"
              f"element vertex {len(points)}\n{properties}"
              f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n")
    floats = np.concatenate([points, normals], axis=1).astype("<f4")
    path.write_bytes(header.encode() + floats.tobytes() + rows.tobytes())


def ellipsoid(p, center, axes):
    """About the distance from an ellipsoid."""
    q = [(p[k] - center[k]) / axes[k] for k in range(3)]
    return (np.sqrt(q[0]**2 + q[1]**2 + q[2]**2) - 1) * min(axes)


def smooth_union(a, b, width=0.05):
    h = np.maximum(width - np.abs(a - b), 0) / width
    return np.minimum(a, b) - 0.25 * h * h * width


def bear(x, y, z):
    """A sitting bear of height 1 that looks along +z."""
    p = (np.abs(x), y, z)  # symmetric
    parts = [
        ((0, 0.76, 0.02), (0.20, 0.175, 0.165)), ((0.155, 0.905, 0), (0.078, 0.078, 0.05)),
        ((0, 0.725, 0.165), (0.09, 0.068, 0.07)), ((0.215, 0.47, 0.14), (0.078, 0.08, 0.14)),
        ((0.165, 0.12, 0.16), (0.10, 0.115, 0.16)),
    ]
    d = ellipsoid(p, (0, 0.36, 0), (0.25, 0.33, 0.2))
    for center, axes in parts:
        d = smooth_union(d, ellipsoid(p, center, axes), 0.07)
    for center, axes in [((0.075, 0.80, 0.165), (0.026, 0.028, 0.024)), ((0, 0.752, 0.235), (0.034, 0.024, 0.02))]:
        d = smooth_union(d, ellipsoid(p, center, axes), 0.015)
    return np.maximum(d, 0.004 - y)  # a flat base


def gyroid_ball(x, y, z):
    """A ball cut out of a gyroid wall."""
    k = 11.0
    wall = np.abs(np.sin(k * x) * np.cos(k * y) + np.sin(k * y) * np.cos(k * z) + np.sin(k * z) * np.cos(k * x))
    return -smooth_union(0.9 - np.sqrt(x * x + y * y + z * z), 0.09 * (0.42 - wall), 0.06)


def carved_cube(x, y, z):
    """A rounded cube with three bores and a ball inside."""
    q = [np.abs(v) - 0.62 for v in (x, y, z)]
    outside = np.sqrt(sum(np.maximum(v, 0)**2 for v in q)) + np.minimum(np.maximum.reduce(q), 0) - 0.12
    for a, b in ((x, y), (y, z), (z, x)):
        outside = -smooth_union(-outside, np.sqrt(a * a + b * b) - 0.5, 0.08)
    return np.minimum(outside, np.sqrt(x * x + y * y + z * z) - 0.42)


# Profile of the pawn as radius and height.
PAWN = [(0.0, 0.0), (0.46, 0.0), (0.48, 0.03), (0.48, 0.10), (0.44, 0.14), (0.45, 0.18), (0.40, 0.26), (0.27, 0.36),
        (0.20, 0.50), (0.165, 0.68), (0.15, 0.80), (0.16, 0.84), (0.27, 0.87), (0.28, 0.90), (0.26, 0.93), (0.17, 0.95),
        (0.15, 0.98)] + [(0.235 * np.sin(a), 1.16 - 0.235 * np.cos(a)) for a in np.linspace(0.75, np.pi, 14)]


def make_pawn(path, sides=64):
    """Writes a closed surface of revolution about +y; smoothing groups make it smooth."""
    outline = [(max(r, 0.0), h) for r, h in PAWN]
    ring = outline[1:-1]
    lines = ["# A chess pawn, written by scenes/make/make_shape_scenes.py.", "s 1"]
    for r, h in ring:
        lines += [f"v {r * np.cos(a):.5f} {h:.5f} {r * np.sin(a):.5f}"
                  for a in 2 * np.pi * np.arange(sides) / sides]
    lines += [f"v 0 {outline[0][1]:.5f} 0", f"v 0 {outline[-1][1]:.5f} 0"]
    bottom, top = len(ring) * sides + 1, len(ring) * sides + 2
    for k in range(sides):
        n = (k + 1) % sides
        for i in range(len(ring) - 1):
            a, b = i * sides + 1, (i + 1) * sides + 1
            lines.append(f"f {a + k} {b + k} {b + n} {a + n}")
        lines += [f"f {bottom} {k + 1} {n + 1}", f"f {top} {top - 2 - sides + n + 1} {top - 2 - sides + k + 1}"]
    path.write_text("\n".join(lines) + "\n")


def main():
    for folder in (SHAPES, CAMERAS, SUBSURFACE):
        folder.mkdir(parents=True, exist_ok=True)
    for name, turns, width in (("straight", 0.0, 0.34), ("wavy", 1.6, 0.30), ("curly", 4.2, 0.24)):
        write_curves(SHAPES / f"{name}.txt", make_lock(7, turns, width))
    write_curves(SHAPES / "yarn.txt", make_yarn(3, 130))
    write_curves(SHAPES / "basket.txt", make_basket())
    write_vol(SHAPES / "gyroid.vol", gyroid_ball, (-1, -1, -1), (1, 1, 1), (128, 128, 128))
    write_vol(SHAPES / "cube.vol", carved_cube, (-1, -1, -1), (1, 1, 1), (80, 80, 80))
    write_mesh(SUBSURFACE / "bear.ply", bear, (-0.4, -0.04, -0.3), (0.4, 1.04, 0.4), (104, 140, 92))
    make_pawn(CAMERAS / "pawn.obj")


if __name__ == "__main__":
    main()
