#!/usr/bin/env python3
"""Writes the meshes of the example and test scenes. Needs only Python; the output is deterministic.

  scenes/make/make_meshes.py            small meshes of scenes/cornell and tests/references (part of the repository) and
                                  large meshes of scenes/mesh_box and scenes/material_room (3 MB, not part of it)
  scenes/make/make_meshes.py large      only the large meshes
"""

import math
import struct
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
CORNELL = ROOT / "scenes" / "cornell" / "meshes"
MESH_BOX = ROOT / "scenes" / "mesh_box" / "generated"
MATERIAL_ROOM = ROOT / "scenes" / "material_room" / "generated"
TESTS = ROOT / "tests" / "references" / "scenes" / "meshes"


def sub(a, b):
    return tuple(x - y for x, y in zip(a, b))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def normalize(a):
    length = math.sqrt(sum(x * x for x in a))
    return tuple(x / length for x in a)


def number(x):
    text = f"{x:.6f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def write_obj(path, title, positions, faces, normals=(), uvs=(), negative=False):
    """Writes an OBJ file. Faces list 0-based vertex indices, shared by positions, normals and uvs.

    With `negative`, faces use OBJ's negative indices, which count back from the last vertex.
    """
    lines = [f"# {title}"]
    lines += ["v " + " ".join(map(number, p)) for p in positions]
    lines += ["vt " + " ".join(map(number, t)) for t in uvs]
    lines += ["vn " + " ".join(map(number, n)) for n in normals]
    for face in faces:
        corners = []
        for i in face:
            index = str(i - len(positions) if negative else i + 1)
            if normals:
                corners.append(f"{index}/{index if uvs else ''}/{index}")
            else:
                corners.append(f"{index}/{index}" if uvs else index)
        lines.append("f " + " ".join(corners))
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join(lines) + "\n")


def write_ply(path, title, positions, triangles, normals=(), encoding="binary_little_endian", uvs=()):
    """Writes a PLY file: float positions (and normals and uvs), faces with a uchar count and int indices."""
    header = ["ply", f"format {encoding} 1.0", f"comment {title}", f"element vertex {len(positions)}"]
    header += [f"property float {axis}" for axis in "xyz"]
    header += [f"property float n{axis}" for axis in "xyz"] if normals else []
    header += [f"property float {axis}" for axis in "uv"] if uvs else []
    header += [f"element face {len(triangles)}", "property list uchar int vertex_indices", "end_header"]
    rows = [tuple(p) + tuple(n) for p, n in zip(positions, normals)] if normals else positions
    rows = [tuple(row) + tuple(t) for row, t in zip(rows, uvs)] if uvs else rows
    path.parent.mkdir(parents=True, exist_ok=True)
    with open(path, "wb") as out:
        out.write(("\n".join(header) + "\n").encode())
        if encoding == "ascii":
            out.writelines((" ".join(map(number, row)) + "\n").encode() for row in rows)
            out.writelines(("3 " + " ".join(map(str, t)) + "\n").encode() for t in triangles)
        else:
            order = "<" if encoding == "binary_little_endian" else ">"
            out.writelines(struct.pack(f"{order}{len(row)}f", *row) for row in rows)
            out.writelines(struct.pack(f"{order}B3i", 3, *t) for t in triangles)


def torus_surface(center_line, radius, rings, sides):
    """Returns positions, normals and triangles of a tube of `rings` x `sides` quads around a closed curve.

    center_line(t) and radius(t, angle) take t and angle in turns. The normals are averaged over adjacent quads.
    """
    positions = []
    for i in range(rings):
        t = i / rings
        here, ahead = center_line(t), center_line(t + 1e-4)
        tangent = normalize(sub(ahead, here))
        side = normalize(cross(tangent, here))
        up = cross(side, tangent)
        for j in range(sides):
            angle = 2 * math.pi * j / sides
            r = radius(t, j / sides)
            c, s = r * math.cos(angle), r * math.sin(angle)
            positions.append(tuple(h + c * a + s * b for h, a, b in zip(here, side, up)))
    triangles = []
    for i in range(rings):
        for j in range(sides):
            a, b = i * sides + j, i * sides + (j + 1) % sides
            c, d = (i + 1) % rings * sides + j, (i + 1) % rings * sides + (j + 1) % sides
            triangles += [(a, c, d), (a, d, b)]
    return positions, vertex_normals(positions, triangles), triangles


def vertex_normals(positions, triangles):
    sums = [[0.0, 0.0, 0.0] for _ in positions]
    for t in triangles:
        p = [positions[i] for i in t]
        n = cross(sub(p[1], p[0]), sub(p[2], p[0]))
        for i in t:
            for axis in range(3):
                sums[i][axis] += n[axis]
    return [normalize(s) for s in sums]


def knot_line(p, q):
    def at(t):
        a = 2 * math.pi * t
        r = 1 + 0.42 * math.cos(q * a)
        return (r * math.cos(p * a), r * math.sin(p * a), 0.5 * math.sin(q * a))

    return at


def box_mesh(low, high):
    """Returns the 8 corners and 6 outward-facing quads of a box."""
    corners = [(x, y, z) for z in (low[2], high[2]) for y in (low[1], high[1]) for x in (low[0], high[0])]
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    return corners, quads


def make_cornell():
    """Writes the room, the light and the block of scenes/cornell for its Nori version."""
    w, h, d = 1.36, 2.0, 1.1
    walls = {
        "floor": [(-w, 0, d), (w, 0, d), (w, 0, -d), (-w, 0, -d)],
        "ceiling": [(-w, h, -d), (w, h, -d), (w, h, d), (-w, h, d)],
        "back": [(-w, 0, -d), (w, 0, -d), (w, h, -d), (-w, h, -d)],
        "left": [(-w, 0, d), (-w, 0, -d), (-w, h, -d), (-w, h, d)],
        "right": [(w, 0, -d), (w, 0, d), (w, h, d), (w, h, -d)],
        "light": [(-0.5, 1.995, -0.38), (0.5, 1.995, -0.38), (0.5, 1.995, 0.32), (-0.5, 1.995, 0.32)],
    }
    for name, corners in walls.items():
        write_obj(CORNELL / f"{name}.obj", f"{name} of the box, facing inwards", corners, [(0, 1, 2, 3)])
    corners, quads = box_mesh((-0.34, 0, -0.34), (0.34, 1.18, 0.34))
    write_obj(CORNELL / "block.obj", "upright block, centered on the y axis", corners, quads)


def make_mesh_box():
    """Writes a torus knot of 80,000 triangles with fluted, bumpy tubes."""
    line = knot_line(2, 3)

    def radius(t, angle):
        return 0.24 + 0.025 * math.cos(2 * math.pi * (9 * angle + 12 * t)) + 0.02 * math.sin(2 * math.pi * 90 * t)

    positions, normals, triangles = torus_surface(line, radius, 800, 50)
    write_ply(MESH_BOX / "knot.ply", "torus knot", positions, triangles, normals)


def make_material_room():
    """Writes a knot of 25,600 triangles with uvs, which the scene uses 8 times."""
    rings, sides = 256, 50
    positions, normals, triangles = torus_surface(
        knot_line(2, 3), lambda t, angle: 0.24 + 0.02 * math.cos(2 * math.pi * (5 * angle + 6 * t)), rings, sides)
    uvs = [(24 * i / rings, 4 * j / sides) for i in range(rings) for j in range(sides)]
    write_ply(MATERIAL_ROOM / "knot.ply", "torus knot with uv", positions, triangles, normals, uvs=uvs)


def octahedron_sphere(steps):
    """Returns a coarse sphere: latitude rings of quads between two triangle fans; positions equal normals."""
    positions = [(0.0, 0.0, 1.0)]
    around = 2 * steps
    for i in range(1, steps):
        theta = math.pi * i / steps
        for j in range(around):
            phi = 2 * math.pi * j / around
            positions.append((math.sin(theta) * math.cos(phi), math.sin(theta) * math.sin(phi), math.cos(theta)))
    positions.append((0.0, 0.0, -1.0))
    last = len(positions) - 1
    faces = [(0, 1 + j, 1 + (j + 1) % around) for j in range(around)]
    for i in range(steps - 2):
        a, b = 1 + i * around, 1 + (i + 1) * around
        faces += [(a + j, b + j, b + (j + 1) % around, a + (j + 1) % around) for j in range(around)]
    base = 1 + (steps - 2) * around
    faces += [(base + j, last, base + (j + 1) % around) for j in range(around)]
    return positions, faces


def fan(faces):
    return [(f[0], f[i], f[i + 1]) for f in faces for i in range(1, len(f) - 1)]


def make_tests():
    ball, faces = octahedron_sphere(5)
    write_obj(TESTS / "ball_smooth.obj", "coarse sphere with vertex normals, triangles and quads", ball, faces, ball)
    write_obj(TESTS / "ball_flat.obj", "coarse sphere without vertex normals", ball, faces)
    corners, quads = box_mesh((-1, -1, -1), (1, 1, 1))
    write_obj(TESTS / "cube_negative.obj", "cube of quads, indices counted from the end", corners, quads, negative=True)
    hexagon = [(math.cos(math.pi * i / 3), math.sin(math.pi * i / 3), 0.0) for i in range(6)]
    uvs = [(0.5 + 0.5 * x, 0.5 + 0.5 * y) for x, y, _ in hexagon]
    write_obj(TESTS / "hexagon.obj", "one face of six corners with texture coordinates", hexagon, [tuple(range(6))],
              uvs=uvs)
    ring = torus_surface(lambda t: (math.cos(2 * math.pi * t), math.sin(2 * math.pi * t), 0.0),
                         lambda t, angle: 0.4 + 0.05 * math.cos(2 * math.pi * 6 * t), 24, 10)
    write_ply(TESTS / "ring_ascii.ply", "ring without normals", ring[0], ring[2], encoding="ascii")
    write_ply(TESTS / "ring_little.ply", "ring with normals", ring[0], ring[2], ring[1])
    write_ply(TESTS / "ring_big.ply", "ring with normals", ring[0], ring[2], ring[1], "binary_big_endian")


def main(arguments):
    if arguments not in ([], ["large"]):
        sys.exit(__doc__)
    make_mesh_box()
    make_material_room()
    if not arguments:
        make_cornell()
        make_tests()


if __name__ == "__main__":
    main(sys.argv[1:])
