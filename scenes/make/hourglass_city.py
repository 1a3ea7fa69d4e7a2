"""The city of make_hourglass.py: beveled buildings with lit windows, blocks, trees, lamps, and their placement."""

import numpy as np

from hourglass_meshes import Mesh, box, merged, oriented, quads, revolved
from hourglass_textures import fractal

FLOOR, WINDOW = 0.155, (0.078, 0.098)  # height of a floor, size of a window, in cm
BLOCK, STREET = 0.98, 0.25
RADIUS = 4.6


def facade_windows(low, high, rng, lit_share, ribbon):
    """Windows on the four sides of a box, as quads and normals: those that are lit and those that are dark."""
    lit, dark = ([], []), ([], [])
    # Find the size of a window and of a floor
    floors = int((high[1] - low[1] - 0.08) / FLOOR)
    width = WINDOW[0] * (1.25 if ribbon else 1)
    busy = rng.uniform(0.6, 1.3, floors)  # whole floors work late, others have gone home
    # Place windows on each side
    for axis, side in ((0, 0), (0, 1), (2, 0), (2, 1)):
        other = 2 - axis
        length = high[other] - low[other] - 0.07
        count = int(length / (width + (0.012 if ribbon else 0.045)))
        pitch = length / max(count, 1)
        normal = np.zeros(3)
        normal[axis] = 2 * side - 1
        plane = (low, high)[side][axis] + 0.004 * normal[axis]
        for floor in range(floors):
            bottom = low[1] + 0.07 + FLOOR * floor
            for i in range(count):
                start = low[other] + 0.035 + pitch * i + 0.5 * (pitch - width)
                corners = np.empty((4, 3))
                corners[:, axis] = plane
                corners[:, other] = [start, start + width, start + width, start]
                corners[:, 1] = [bottom, bottom, bottom + WINDOW[1], bottom + WINDOW[1]]
                chosen = lit if rng.random() < lit_share * busy[floor] else dark
                if np.dot(np.cross(corners[1] - corners[0], corners[2] - corners[0]), normal) < 0:
                    corners = corners[::-1]
                chosen[0].append(corners)
                chosen[1].append(normal)
    return lit, dark


def roof_details(top, half, rng):
    """A parapet, boxes of machinery, and now and then a water tank or a mast."""
    parts = []
    x, z, rim = half[0], half[1], 0.025
    for low, high in (((-x, -z), (x, -z + rim)), ((-x, z - rim), (x, z)), ((-x, -z), (-x + rim, z)),
                      ((x - rim, -z), (x, z))):
        parts.append(box((low[0], top - 0.01, low[1]), (high[0], top + 0.045, high[1]), 0.006))
    for _ in range(rng.integers(1, 4)):
        w, d, h = rng.uniform(0.05, 0.12), rng.uniform(0.05, 0.12), rng.uniform(0.04, 0.11)
        cx, cz = rng.uniform(-x + w, x - w) * 0.7, rng.uniform(-z + d, z - d) * 0.7
        parts.append(box((cx - w / 2, top - 0.01, cz - d / 2), (cx + w / 2, top + h, cz + d / 2), 0.006))
    if rng.random() < 0.4:
        tank = revolved([(0.0, 0.06), (0.055, 0.06), (0.06, 0.065), (0.06, 0.155), (0.0, 0.20)], 14)
        parts.append(tank.moved((0.3 * x, top, -0.3 * z)))
    return parts


def make_building(height, width, depth, kind, rng, lit_share):
    """Returns the walls, the lit and the dark windows of a building on the origin. Tall ones step back twice."""
    tiers = [(0.0, height, 1.0)]
    if kind == "setback":
        a, b = rng.uniform(0.45, 0.6), rng.uniform(0.75, 0.86)
        tiers = [(0.0, a * height, 1.0), (a * height, b * height, 0.78), (b * height, height, 0.54)]
    elif kind == "podium":
        tiers = [(0.0, 0.32, 1.0), (0.32, height, 0.74)]
    # Walls and windows of each tier
    walls, lit, dark = [], ([], []), ([], [])
    for bottom, top, scale in tiers:
        x, z = 0.5 * width * scale, 0.5 * depth * scale
        start = bottom - (0.45 if bottom == 0 else 0.02)
        walls.append(box((-x, start, -z), (x, top, z), 0.016))
        windows = facade_windows((-x, bottom, -z), (x, top, z), rng, lit_share, kind == "podium")
        for target, found in zip((lit, dark), windows):
            target[0].extend(found[0])
            target[1].extend(found[1])
        walls.extend(roof_details(top, (x, z), rng))
    # Roof
    if kind == "setback":
        x = 0.5 * width * 0.54
        spire = [(x * 0.7, 0.0), (x * 0.5, 0.08), (0.022, 0.24), (0.012, 0.46), (0.0, 0.47)]
        walls.append(revolved(spire, 16).moved((0, height, 0)))
    if kind == "gable":
        walls.append(gable(width * 0.5 + 0.02, depth * 0.5 + 0.02, height, 0.55 * depth))
    return merged(walls), quads(*lit) if lit[0] else None, quads(*dark)


def gable(x, z, bottom, rise):
    corners = np.array([(-x, bottom, -z), (x, bottom, -z), (x, bottom, z), (-x, bottom, z), (-x, bottom + rise, 0),
                        (x, bottom + rise, 0)])
    faces = [(0, 1, 5), (0, 5, 4), (3, 2, 5), (3, 5, 4), (0, 3, 4), (1, 2, 5)]
    positions = corners[np.array(faces)].reshape(-1, 3)
    mesh = oriented(Mesh(positions, positions, np.zeros((18, 2)), np.arange(18).reshape(-1, 3)),
                    np.array((0, bottom + 0.3 * rise, 0)))
    a, b, c = (mesh.positions[mesh.triangles[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    for triangle, normal in zip(mesh.triangles, normals):
        mesh.normals[triangle] = normal / np.linalg.norm(normal)
    return mesh


# Height, width, depth, kind and material of each kind of building.
MODELS = [(4.35, 0.66, 0.66, "setback", "limestone"), (3.9, 0.60, 0.60, "podium", "steel"),
          (3.5, 0.60, 0.52, "setback", "brick"), (2.9, 0.52, 0.52, "flat", "steel"),
          (2.5, 0.56, 0.48, "podium", "concrete"), (2.1, 0.50, 0.50, "setback", "limestone"),
          (1.8, 0.44, 0.50, "flat", "concrete"), (1.5, 0.42, 0.42, "flat", "brick"),
          (1.25, 0.46, 0.40, "flat", "limestone"), (1.0, 0.40, 0.42, "flat", "brick"),
          (0.8, 0.42, 0.38, "flat", "concrete"), (0.62, 0.40, 0.36, "gable", "brick"),
          (0.48, 0.36, 0.34, "gable", "limestone"), (0.40, 0.36, 0.32, "gable", "concrete")]


def ground_height(x, z):
    """The island under the city: a low dome whose shore lies under water."""
    r = np.hypot(x, z) / RADIUS
    return 0.42 * (1 - r * r) - 0.22 - 0.16 * np.clip(r - 0.7, 0, None)


def placements(rng):
    """Returns (model, x, z, angle, scale) of buildings, (low, high) of blocks, and (x, z) of trees and of lamps."""
    buildings, blocks, trees, lamps = [], [], [], []
    pitch = BLOCK + STREET
    heights = np.array([m[0] for m in MODELS])
    for i in range(-5, 6):
        for j in range(-5, 6):
            cx, cz = pitch * (i + 0.15), pitch * (j - 0.1)
            reach = np.hypot(cx, cz)
            if reach + 0.45 > RADIUS:
                continue
            blocks.append(((cx - BLOCK / 2, cz - BLOCK / 2), (cx + BLOCK / 2, cz + BLOCK / 2)))
            lamps += [(cx + a * (BLOCK / 2 - 0.05), cz + b * 0.22) for a in (-1, 1) for b in (-1, 1)]
            if (i, j) in ((1, 1), (-2, 2)):  # parks
                trees += [(cx + rng.uniform(-0.4, 0.4), cz + rng.uniform(-0.4, 0.4)) for _ in range(16)]
                continue
            if (i, j) == (0, 0):  # the tower under the drops
                buildings.append((0, cx, cz, 0, 1.0))
                continue
            # High buildings near the center, four to a block further out
            target = 0.45 + 4.6 * np.exp(-(reach / 1.9)**2)
            lots = [(0, 0)] if target > 2.4 and rng.random() < 0.45 else [(a, b) for a in (-1, 1) for b in (-1, 1)]
            for a, b in lots:
                wanted = target * rng.uniform(0.5, 1.15)
                model = int(np.argmin(np.abs(heights - wanted) + rng.uniform(0, 0.35, len(heights))))
                size = max(MODELS[model][1:3])
                scale = min(rng.uniform(0.92, 1.08), 0.44 / size) if len(lots) > 1 else 0.80 / size
                scale = min(scale, 1.0 if MODELS[model][0] > 3 else 1.3)
                buildings.append((model, cx + 0.225 * a, cz + 0.225 * b, 90 * rng.integers(4), scale))
    return buildings, blocks, trees, lamps


def group(name, parts):
    shapes = "".join(f"""
    <shape type="ply">
      <string name="filename" value="{file}"/>
      {inner}
    </shape>""" for file, inner in parts)
    return f'  <shape type="shapegroup" id="{name}">{shapes}\n  </shape>\n'


def emitter(radiance):
    return f'<emitter type="area"><rgb name="radiance" value="{radiance}"/></emitter>'


def instance(name, x, y, z, angle=0.0, scale=1.0):
    return (f'  <shape type="instance"><ref id="{name}"/><transform name="to_world"><scale value="{scale:.4f}"/>'
            f'<rotate y="1" angle="{angle:.2f}"/><translate value="{x:.4f}, {y:.4f}, {z:.4f}"/></transform></shape>\n')


def make_models(folder, rng):
    """Writes the meshes of all models, of a tree and of a lamp. Returns their groups as scene text."""
    text = []
    for k, (height, width, depth, kind, material) in enumerate(MODELS):
        walls, lit, dark = make_building(height, width, depth, kind, rng, 0.30 if height > 1 else 0.24)
        parts = [(f"building_{k}_walls.ply", f'<ref id="{material}"/>'),
                 (f"building_{k}_dark.ply", '<ref id="window"/>')]
        walls.write(folder / parts[0][0])
        dark.write(folder / parts[1][0])
        if lit:
            lit.write(folder / f"building_{k}_lit.ply")
            color = ("1.0, 0.60, 0.26", "1.0, 0.70, 0.38", "1.0, 0.52, 0.20", "0.95, 0.80, 0.62")[k % 4]
            radiance = ", ".join(f"{float(c) * 2.0:.3f}" for c in color.split(","))
            parts.append((f"building_{k}_lit.ply", emitter(radiance)))
        text.append(group(f"building_{k}", parts))
    # Tree and lamp
    crown = revolved([(0, 0.05), (0.05, 0.06), (0.075, 0.11), (0.06, 0.17), (0.03, 0.21), (0, 0.225)], 10)
    p = crown.positions
    bumps = 1 + 0.5 * (fractal(p[:, 0] * 40, p[:, 1] * 40, p[:, 2] * 40, octaves=2, seed=91) - 0.5)
    p *= np.stack([bumps, np.ones_like(bumps), bumps], -1)
    crown.write(folder / "tree.ply")
    revolved([(0.012, 0), (0.012, 0.16), (0.0, 0.165)], 6).write(folder / "lamp_post.ply")
    revolved([(0, 0.155), (0.020, 0.16), (0.020, 0.185), (0, 0.19)], 8).write(folder / "lamp_light.ply")
    text.append(group("tree", [("tree.ply", '<ref id="leaves"/>')]))
    text.append(group("lamp", [("lamp_post.ply", '<ref id="asphalt"/>'), ("lamp_light.ply", emitter("7, 4, 1.6"))]))
    return text


def make_city(folder, center, level, turn):
    """Writes the city at `center` (x, z), with streets around the height `level`, turned about the vertical."""
    rng = np.random.default_rng(5)
    text = make_models(folder, rng)
    buildings, blocks, trees, lamps = placements(rng)
    c, s = np.cos(np.radians(turn)), np.sin(np.radians(turn))

    def placed(x, z, lift=0.0):
        return center[0] + c * x + s * z, level + ground_height(x, z) + lift, center[1] - s * x + c * z

    for model, x, z, angle, scale in buildings:
        text.append(instance(f"building_{model}", *placed(x, z, 0.02), angle + turn, scale))
    for x, z in trees:
        text.append(instance("tree", *placed(x, z, 0.0), 360 * rng.random(), rng.uniform(0.8, 1.5)))
    for x, z in lamps:
        text.append(instance("lamp", *placed(x, z, 0.03), turn))
    # Pavements
    pavements = []
    for low, high in blocks:
        y = ground_height(0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]))
        pavements.append(box((low[0], y - 0.5, low[1]), (high[0], y + 0.03, high[1]), 0.012))
    merged(pavements).turned(1, turn).moved((center[0], level, center[1])).write(folder / "pavements.ply")
    head = ('<?xml version="1.0" encoding="utf-8"?>\n<!-- The city, written by scenes/make/make_hourglass.py. -->\n'
            '<scene version="3.0.0">\n')
    (folder / "city.xml").write_text(head + "".join(text) + "</scene>\n")
