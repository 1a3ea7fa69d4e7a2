#!/usr/bin/env python3
"""Writes the meshes of scenes/tutorials, which are part of the repository, and by make_cloud the density grid in
scenes/tutorials/generated. Needs only Python and a build; the output is deterministic.

  scenes/make/make_tutorial_scenes.py [--make-cloud PROGRAM]

Runs make_cloud from build/release, where tools/quickstart.sh builds it, or else from PATH. Surfaces of revolution have
rounded corners and exact normals. +z is up, except in lighthouse.obj, where +y is up.
"""

import argparse
import math
import subprocess
from pathlib import Path

from make_media_scenes import find_make_cloud

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / "scenes" / "tutorials" / "meshes"
GENERATED = ROOT / "scenes" / "tutorials" / "generated"


class Mesh:
    """Positions, normals, and faces of 1-based vertex indices, grouped by material."""

    def __init__(self):
        self.vertices = []
        self.faces = {}

    def add_vertex(self, position, normal):
        self.vertices.append((position, normal))
        return len(self.vertices)

    def add_face(self, material, *corners):
        """Adds a face of vertex indices; repeated corners are dropped."""
        face = [c for i, c in enumerate(corners) if c not in corners[:i]]
        if len(face) > 2:
            self.faces.setdefault(material, []).append(face)

    def write(self, name, title, library=None, y_up=False):
        """Writes an OBJ file. With `library`, faces name their materials."""
        turn = (lambda v: (v[0], v[2], -v[1])) if y_up else lambda v: v
        text = [f"# {title}, written by scenes/make/make_tutorial_scenes.py."]
        text += [f"mtllib {library}"] if library else []
        line = lambda keyword, v, digits: keyword + " " + " ".join(f"{round(c, digits) + 0.0:.7g}" for c in turn(v))
        normals = [line("vn", normal, 3) for _, normal in self.vertices]
        number = {text: i + 1 for i, text in enumerate(dict.fromkeys(normals))}
        text += [line("v", position, 4) for position, _ in self.vertices] + list(number)
        for material, faces in self.faces.items():
            text += [f"usemtl {material}"] if library else []
            text += ["f " + " ".join(f"{i}//{number[normals[i - 1]]}" for i in face) for face in faces]
        FOLDER.mkdir(parents=True, exist_ok=True)
        (FOLDER / name).write_text("\n".join(text) + "\n")


def round_corners(points, steps=4):
    """Replaces the corners (r, z, radius) of a polyline by arcs. Returns a list of ((r, z), normal); the normal is to
    the right of the direction of the polyline."""
    rows = []
    for i, (r, z, radius) in enumerate(points):
        directions = []
        for a, b in ((points[max(i - 1, 0)], points[i]), (points[i], points[min(i + 1, len(points) - 1)])):
            length = math.hypot(b[0] - a[0], b[1] - a[1])
            directions.append(((b[0] - a[0]) / length, (b[1] - a[1]) / length) if length > 0 else None)
        before, after = directions[0] or directions[1], directions[1] or directions[0]
        turn = math.atan2(before[0] * after[1] - before[1] * after[0], before[0] * after[0] + before[1] * after[1])
        if radius == 0 or abs(turn) < 1e-6:
            for along in (before, after) if abs(turn) > 1e-6 else (after,):
                rows.append(((r, z), (along[1], -along[0])))
            continue
        tangent = radius * math.tan(abs(turn) / 2)
        side = 1 if turn > 0 else -1
        center = (r - tangent * before[0] - side * radius * before[1],
                  z - tangent * before[1] + side * radius * before[0])
        for k in range(steps + 1):
            angle = turn * k / steps
            c, s = math.cos(angle), math.sin(angle)
            normal = (c * before[1] + s * before[0], -c * before[0] + s * before[1])
            rows.append(((center[0] + side * radius * normal[0], center[1] + side * radius * normal[1]), normal))
    return rows


def revolve(mesh, points, sides, material="", center=(0.0, 0.0), steps=4):
    """Adds the surface of revolution of a polyline (r, z, corner radius). A polyline that runs from the bottom outside
    to the top has its normals outside."""
    rows = round_corners(points, steps)
    rings = []
    for (r, z), (across, up) in rows:
        r = max(r, 0.0)
        ring = []
        for k in range(sides):
            c, s = math.cos(2 * math.pi * k / sides), math.sin(2 * math.pi * k / sides)
            if r < 1e-9 and k > 0:
                ring.append(ring[0])
            else:
                normal = (0.0, 0.0, math.copysign(1, up)) if r < 1e-9 else (across * c, across * s, up)
                ring.append(mesh.add_vertex((center[0] + r * c, center[1] + r * s, z), normal))
        rings.append(ring)
    for (lower, upper), (a, b) in zip(zip(rings, rings[1:]), zip(rows, rows[1:])):
        if math.dist(a[0], b[0]) < 1e-9:
            continue
        for k in range(sides):
            n = (k + 1) % sides
            mesh.add_face(material, lower[k], lower[n], upper[n], upper[k])


def box(mesh, center, size, material="", bevel=0.01, steps=3, turn=0.0):
    """Adds a box with rounded edges: an octant of a sphere at every corner. `turn`: degrees around +z."""
    half = [s / 2 - bevel for s in size]
    cos_turn, sin_turn = math.cos(math.radians(turn)), math.sin(math.radians(turn))
    rings = []
    for row in range(2 * steps + 2):
        top = row > steps
        elevation = math.radians(90.0 * (row - top) / steps - 90)
        ring = []
        for quadrant in range(4):
            signs = ((1, 1), (-1, 1), (-1, -1), (1, -1))[quadrant]
            for k in range(steps + 1):
                azimuth = math.radians(90 * quadrant + 90.0 * k / steps)
                n = (math.cos(elevation) * math.cos(azimuth), math.cos(elevation) * math.sin(azimuth),
                     math.sin(elevation))
                p = (signs[0] * half[0] + bevel * n[0], signs[1] * half[1] + bevel * n[1],
                     (half[2] if top else -half[2]) + bevel * n[2])
                p, n = (tuple((v[0] * cos_turn - v[1] * sin_turn, v[0] * sin_turn + v[1] * cos_turn, v[2]))
                        for v in (p, n))
                if k > 0 and row in (0, 2 * steps + 1):
                    ring.append(ring[-1])
                else:
                    ring.append(mesh.add_vertex(tuple(c + o for c, o in zip(center, p)), n))
        rings.append(ring)
    count = 4 * (steps + 1)
    for lower, upper in zip(rings, rings[1:]):
        for k in range(count):
            n = (k + 1) % count
            mesh.add_face(material, lower[k], lower[n], upper[n], upper[k])
    corners = [quadrant * (steps + 1) for quadrant in range(4)]
    mesh.add_face(material, *[rings[-1][c] for c in corners])
    mesh.add_face(material, *[rings[0][c] for c in reversed(corners)])


def make_lighthouse():
    """A lighthouse on a rock; 1 unit is 1 m."""
    mesh, sides = Mesh(), 32
    revolve(mesh, [(4.6, -0.6, 0), (3.9, 0.5, 0.4), (2.9, 0.9, 0.3), (0, 0.9, 0)], 11, "rock")
    radius = lambda z: 1.75 - 0.075 * z
    bands = [0.9, 2.7, 4.5, 6.3, 8.1, 9.9]
    for i, (low, high) in enumerate(zip(bands, bands[1:])):
        revolve(mesh, [(radius(low), low, 0), (radius(high), high, 0)], sides, "red" if i % 2 else "white")
    revolve(mesh, [(1.0, 9.9, 0), (1.75, 10.0, 0.05), (1.75, 10.25, 0.05), (0, 10.25, 0)], sides, "dark")
    for height in (10.55, 10.85):
        revolve(mesh, [(1.66, height, 0), (1.7, height, 0), (1.7, height + 0.05, 0), (1.66, height + 0.05, 0),
                       (1.66, height, 0)], sides, "dark")
    for k in range(12):
        c, s = math.cos(math.pi * k / 6), math.sin(math.pi * k / 6)
        revolve(mesh, [(0.03, 10.2, 0), (0.03, 10.88, 0)], 6, "dark", (1.68 * c, 1.68 * s))
        if k % 2 == 0:
            revolve(mesh, [(0.04, 10.2, 0), (0.04, 11.9, 0)], 6, "dark", (0.88 * c, 0.88 * s))
    revolve(mesh, [(0.86, 10.25, 0), (0.86, 11.8, 0)], 24, "pane")
    revolve(mesh, [(0, 10.6, 0), (0.35, 10.75, 0.1), (0.35, 11.4, 0.1), (0, 11.55, 0)], 24, "lamp")
    revolve(mesh, [(0, 11.75, 0), (1.15, 11.75, 0.04), (1.1, 11.95, 0.05), (0.25, 12.75, 0.1), (0.1, 12.95, 0.03),
                   (0.16, 13.1, 0.08), (0, 13.26, 0)], sides, "red")
    box(mesh, (0, -1.62, 1.75), (0.8, 0.3, 1.7), "dark", 0.04)
    box(mesh, (0, -1.72, 0.95), (1.3, 0.9, 0.2), "rock", 0.05)
    for angle, z in ((-90, 4.4), (-40, 6.2), (-140, 6.2), (-90, 8.2)):
        c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
        r = radius(z) - 0.02
        box(mesh, (r * c, r * s, z), (0.16, 0.46, 0.75), "dark", 0.04, turn=angle)
    mesh.write("lighthouse.obj", "A lighthouse", "lighthouse.mtl", y_up=True)
    (FOLDER / "lighthouse.mtl").write_text("""# Written by scenes/make/make_tutorial_scenes.py.
newmtl white
Kd 0.75 0.73 0.68
newmtl red
Kd 0.55 0.05 0.04
Ks 0.04 0.04 0.04
Ns 60
illum 2
newmtl rock
Kd 0.2 0.18 0.16
newmtl dark
Kd 0.04 0.045 0.05
Ks 0.04 0.04 0.04
Ns 40
illum 2
newmtl pane
Kd 0 0 0
Tf 0.95 0.97 0.97
Ni 1.0
d 0.15
newmtl lamp
Kd 0.9 0.75 0.3
Ks 0.04 0.04 0.04
Ns 200
illum 2
""")


def make_vessel(name, outside, inside, level, sides, medium=False):
    """A vessel of glass with a liquid up to `level`, as three surfaces that meet: NAME_dry.obj between glass and air,
    NAME_wet.obj between liquid and glass, NAME_top.obj between liquid and air. `medium`: also NAME_medium.obj, a closed
    surface just inside of the liquid. `inside` runs from the rim down; its wall is straight at `level`."""
    below = next(i for i, point in enumerate(inside) if point[1] < level)
    (r0, z0, _), (r1, z1, _) = inside[below - 1], inside[below]
    edge = (r1 + (r0 - r1) * (level - z1) / (z0 - z1), level, 0)
    wet = inside[below:][::-1] + [edge]
    parts = [("dry", "The glass", outside + inside[:below] + [edge]), ("wet", "The wet wall", wet),
             ("top", "The liquid's surface", [edge, (0, level, 0)])]
    if medium:
        shrunk = [(0.999 * r, level + 0.999 * (z - level) - 0.001, radius) for r, z, radius in wet + [(0, level, 0)]]
        parts.append(("medium", "The liquid's medium", shrunk))
    for part, title, points in parts:
        mesh = Mesh()
        revolve(mesh, points, sides)
        mesh.write(f"{name}_{part}.obj", f"{title} of a {name}")


def make_product():
    """A perfume bottle with a cap before a seamless background. 1 unit is 1 cm."""
    make_vessel("bottle", [(0, 0.15, 0), (1.9, 0, 0.3), (2.6, 0, 0.45), (2.75, 5.2, 1.3), (0.85, 6.1, 0.35),
                           (0.85, 7.0, 0.05)],
                [(0.62, 7.0, 0.05), (0.62, 5.9, 0.3), (2.35, 5.0, 1.0), (2.2, 0.9, 0.5), (0, 0.9, 0)], 3.7, 64, True)
    cap = Mesh()
    revolve(cap, [(0, 6.5, 0), (1.12, 6.5, 0.06), (1.12, 6.85, 0.06), (1.02, 6.9, 0.03), (1.02, 7.0, 0.03),
                  (1.2, 7.05, 0.06), (1.2, 9.4, 0.22), (0, 9.4, 0)], 48, steps=3)
    cap.write("cap.obj", "A cap")
    sweep = Mesh()
    rows = round_corners([(-60, -0.002, 0), (50, -0.002, 30), (50, 80, 0)], 24)
    ends = [[sweep.add_vertex((x, y, z), (0, -across, -up)) for x in (-120, 120)] for (y, z), (across, up) in rows]
    for a, b in zip(ends, ends[1:]):
        sweep.add_face("", a[0], a[1], b[1], b[0])
    sweep.write("sweep.obj", "A seamless background")


def make_tumbler():
    """A drinking glass with water. 1 unit is 1 cm."""
    make_vessel("tumbler", [(0, 0.1, 0), (2.3, 0, 0.3), (2.75, 0, 0.3), (3.6, 8.6, 0.12)],
                [(3.35, 8.6, 0.12), (2.5, 1.3, 0.7), (0, 1.1, 0)], 6.4, 96)


def make_gem(sides=8):
    """A brilliant: table, crown, girdle and pavilion with flat facets. The girdle has a radius of 1."""
    mesh = Mesh()
    ring = lambda count, radius, z, turn: [(radius * math.cos(2 * math.pi * (k + turn) / count),
                                            radius * math.sin(2 * math.pi * (k + turn) / count), z)
                                           for k in range(count)]
    table, crown = ring(sides, 0.56, 0.33, 0.5), ring(sides, 0.80, 0.19, 0.0)
    upper, lower = ring(2 * sides, 1, 0.02, 0.0), ring(2 * sides, 1, -0.02, 0.0)
    middle, culet = ring(sides, 0.22, -0.66, 0.5), (0, 0, -0.86)

    def facet(*corners):
        a, b, c = corners[:3]
        u, v = [q - p for p, q in zip(a, b)], [q - p for p, q in zip(a, c)]
        n = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
        length = math.hypot(*n)
        mesh.add_face("", *[mesh.add_vertex(p, [x / length for x in n]) for p in corners])

    facet(*table)
    for k in range(sides):
        n, before = (k + 1) % sides, (k - 1) % sides
        facet(table[before], crown[k], table[k])
        facet(crown[k], upper[2 * k + 1], table[k])
        facet(crown[n], table[k], upper[2 * k + 1])
        facet(crown[k], upper[2 * k], upper[2 * k + 1])
        facet(crown[n], upper[2 * k + 1], upper[(2 * k + 2) % (2 * sides)])
        facet(lower[2 * k + 1], lower[2 * k], middle[k])
        facet(lower[(2 * k + 2) % (2 * sides)], lower[2 * k + 1], middle[k])
        facet(middle[before], middle[k], lower[2 * k])
        facet(middle[before], culet, middle[k])
    for k in range(2 * sides):
        n = (k + 1) % (2 * sides)
        facet(lower[k], lower[n], upper[n], upper[k])
    mesh.write("gem.obj", "A brilliant")


def add_sofa(mesh):
    """A sofa at the back wall, with cushions."""
    for x, y, z, size in ((0, 1.35, 0.27, (2.0, 0.85, 0.22)), (0, 1.72, 0.55, (2.0, 0.22, 0.6)),
                          (-0.92, 1.35, 0.42, (0.2, 0.85, 0.36)), (0.92, 1.35, 0.42, (0.2, 0.85, 0.36))):
        box(mesh, (x, y, z), size, "fabric", 0.06, 3)
    for x in (-0.41, 0.41):
        box(mesh, (x, 1.3, 0.45), (0.8, 0.7, 0.18), "fabric", 0.07, 3)
        box(mesh, (x, 1.56, 0.72), (0.76, 0.18, 0.42), "fabric", 0.08, 3)
    box(mesh, (-0.66, 1.42, 0.70), (0.36, 0.14, 0.34), "mustard", 0.065, 3, 24)
    box(mesh, (0.64, 1.40, 0.70), (0.36, 0.14, 0.34), "teal", 0.065, 3, -18)
    for x in (-0.85, 0.85):
        for y in (1.0, 1.7):
            revolve(mesh, [(0.015, 0, 0), (0.025, 0.17, 0)], 12, "wood", (x, y))


def add_round_table(mesh):
    """A round table with a bowl and books."""
    revolve(mesh, [(0, 0.38, 0), (0.46, 0.38, 0.012), (0.46, 0.415, 0.012), (0, 0.415, 0)], 64, "wood", (0.1, 0.35))
    for k in range(3):
        angle = 2 * math.pi * (k / 3 + 0.1)
        center = (0.1 + 0.3 * math.cos(angle), 0.35 + 0.3 * math.sin(angle))
        revolve(mesh, [(0.018, 0, 0), (0.022, 0.39, 0)], 12, "wood", center)
    for z, size, material, turn in ((0.43, (0.24, 0.17, 0.03), "teal", 20), (0.456, (0.21, 0.15, 0.022), "paper", 32),
                                    (0.477, (0.19, 0.13, 0.02), "mustard", 14)):
        box(mesh, (-0.08, 0.27, z), size, material, 0.004, 2, turn)
    revolve(mesh, [(0, 0.417, 0), (0.05, 0.415, 0.01), (0.06, 0.43, 0.01), (0.13, 0.5, 0.05), (0.14, 0.53, 0.002),
                   (0.133, 0.53, 0.002), (0.12, 0.5, 0.05), (0.045, 0.44, 0.01), (0, 0.437, 0)], 48, "ceramic",
            (0.28, 0.45))


def add_cabinet(mesh):
    """A cabinet at the right wall, with books and a vase."""
    box(mesh, (2.2, 0.9, 0.40), (0.44, 1.5, 0.62), "wood", 0.012, 2)
    for y in (0.53, 1.27):
        box(mesh, (1.975, y, 0.40), (0.02, 0.7, 0.55), "wood", 0.006, 2)
        revolve(mesh, [(0, 0.42, 0), (0.012, 0.42, 0.002), (0.012, 0.444, 0.002), (0, 0.444, 0)], 16, "brass",
                (1.955, y + (0.28 if y < 0.9 else -0.28)))
    for y, height, material in ((0.30, 0.26, "teal"), (0.345, 0.24, "paper"), (0.39, 0.28, "mustard"),
                                (0.435, 0.23, "fabric"), (0.48, 0.27, "paper"), (0.52, 0.25, "teal")):
        box(mesh, (2.2, y, 0.71 + height / 2), (0.18, 0.036, height), material, 0.004, 2)
    revolve(mesh, [(0, 0.711, 0), (0.05, 0.711, 0.02), (0.115, 0.86, 0.08), (0.04, 1.0, 0.03), (0.055, 1.06, 0),
                   (0.05, 1.06, 0), (0.035, 1.0, 0.03), (0, 0.99, 0)], 48, "ceramic", (2.2, 0.72))


def add_lamps(mesh, shades):
    """A side table with a lamp, and a lamp on the cabinet."""
    revolve(mesh, [(0, 0.5, 0), (0.22, 0.5, 0.008), (0.22, 0.525, 0.008), (0, 0.525, 0)], 48, "wood", (-1.5, 1.45))
    revolve(mesh, [(0.16, 0, 0), (0.16, 0.02, 0.01), (0.02, 0.025, 0.01), (0.018, 0.5, 0)], 32, "brass", (-1.5, 1.45))
    for x, y, z in ((-1.5, 1.45, 0.525), (2.2, 1.3, 0.711)):
        revolve(mesh, [(0, z, 0), (0.08, z, 0.01), (0.08, z + 0.02, 0.01), (0.014, z + 0.035, 0.02),
                       (0.014, z + 0.33, 0)], 32, "brass", (x, y))
        revolve(shades, [(0.17, z + 0.22, 0), (0.12, z + 0.46, 0)], 48, center=(x, y))


def add_wall_and_floor(mesh):
    """Two framed images, skirting boards and a rug."""
    for x, width in ((-0.48, 0.62), (0.42, 0.86)):
        box(mesh, (x, 1.975, 1.55), (width, 0.03, 0.66), "dark", 0.006, 2)
        box(mesh, (x, 1.96, 1.55), (width - 0.06, 0.02, 0.6), "paper", 0.004, 2)
        box(mesh, (x, 1.952, 1.55), (width - 0.24, 0.02, 0.4), "teal" if x > 0 else "mustard", 0.004, 2)
    box(mesh, (0, 1.99, 0.05), (5, 0.02, 0.1), "wall", 0.004, 2)
    for x in (-2.49, 2.49):
        box(mesh, (x, -0.3, 0.05), (0.02, 4.6, 0.1), "wall", 0.004, 2)
    box(mesh, (0.05, 0.25, 0.006), (2.6, 1.7, 0.016), "rug", 0.006, 2)


def make_interior():
    """Furniture of a room at night, with materials in interior.mtl. 1 unit is 1 m; the room is 5 x 4.6 x 2.6 m."""
    mesh, shades = Mesh(), Mesh()
    add_sofa(mesh)
    add_round_table(mesh)
    add_cabinet(mesh)
    add_lamps(mesh, shades)
    add_wall_and_floor(mesh)
    mesh.write("interior.obj", "Furniture", "interior.mtl")
    shades.write("shades.obj", "Lamp shades")
    colors = {"fabric": (0.32, 0.31, 0.33), "mustard": (0.60, 0.33, 0.05), "teal": (0.04, 0.20, 0.22),
               "paper": (0.75, 0.71, 0.62), "rug": (0.38, 0.30, 0.24), "wall": (0.66, 0.62, 0.56)}
    glossy = {"wood": (0.22, 0.10, 0.045, 80), "dark": (0.03, 0.03, 0.03, 60), "ceramic": (0.55, 0.56, 0.52, 300)}
    text = ["# Written by scenes/make/make_tutorial_scenes.py."]
    for name, color in colors.items():
        text += [f"newmtl {name}", "Kd {:g} {:g} {:g}".format(*color)]
    for name, (r, g, b, exponent) in glossy.items():
        text += [f"newmtl {name}", f"Kd {r:g} {g:g} {b:g}", "Ks 0.04 0.04 0.04", f"Ns {exponent}", "illum 2"]
    text += ["newmtl brass", "Kd 0 0 0", "Ks 0.8 0.6 0.3", "Ns 120", "illum 2"]
    (FOLDER / "interior.mtl").write_text("\n".join(text) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--make-cloud", default=find_make_cloud())
    arguments = parser.parse_args()
    make_lighthouse()
    make_product()
    make_tumbler()
    make_gem()
    make_interior()
    if not Path(arguments.make_cloud).is_file():
        parser.error(f"{arguments.make_cloud} not found: build it, or pass its path with --make-cloud")
    GENERATED.mkdir(exist_ok=True)
    cloud = [arguments.make_cloud, str(GENERATED / "cloud.nvdb"), "--resolution", "200", "--seed", "2"]
    subprocess.run(cloud, check=True)


if __name__ == "__main__":
    main()
