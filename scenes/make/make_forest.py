#!/usr/bin/env python3
"""Writes the meshes, textures and instances of scenes/forest to scenes/forest/generated: a drop on the tip of a leaf
over a pond in a forest at night. Needs Python with numpy; the output is deterministic.

  scenes/make/make_forest.py
"""

from pathlib import Path

import numpy as np

import forest_plants as plants
from forest_leaf import Leaf, bezier, droplet_placements, pendant_drop, sessile_drop, surface_points
from forest_shapes import (Mesh, aligned, fbm, grid_faces, joined, noise, rotation, smoothstep, tube, unit, write_hdr)

FOLDER = Path(__file__).resolve().parents[2] / "scenes" / "forest" / "generated"

# The camera of forest.xml, in centimeters: position, downward tilt, and tangents of half the field of view.
EYE = np.array([0.0, 2.4, 12.0])
TILT = np.radians(3.0)
TAN_X, TAN_Y = 16 / 9 * np.tan(np.radians(14.0)), np.tan(np.radians(14.0))

DROP_X = -1.6
TIP = np.array([DROP_X, 3.36, 0.0])
# Stones in the water near the camera: center, radii, seed, heading in degrees.
NEAR_STONES = [((5.3, 0.15, -3.2), (2.3, 1.25, 1.9), 3, 20), ((3.5, -0.05, -5.2), (1.05, 0.55, 0.9), 8, 70),
               ((8.4, 0.4, -7.0), (2.4, 1.9, 2.2), 5, 200), ((-7.3, 0.2, -6.8), (2.5, 1.3, 1.9), 6, 130),
               ((-5.3, -0.1, -8.6), (1.2, 0.6, 1.0), 9, 10), ((3.3, -0.12, -2.4), (0.5, 0.30, 0.45), 12, 250)]

HERO = Leaf(length=7.2, half_width=1.30, pairs=9, teeth=34, seed=4)
SMALL_LEAVES = [Leaf(1.0, 0.24, 7, 22, 11), Leaf(1.0, 0.27, 6, 16, 23, base=(0.075, 0.150, 0.020)),
                Leaf(1.0, 0.20, 8, 26, 37, base=(0.040, 0.125, 0.035), dark=(0.012, 0.055, 0.018))]
AUTUMN_LEAVES = [Leaf(1.0, 0.27, 7, 18, 51, (0.30, 0.10, 0.025), (0.14, 0.045, 0.014), (0.36, 0.20, 0.07), spots=0.9),
                 Leaf(1.0, 0.24, 6, 20, 67, (0.26, 0.17, 0.03), (0.15, 0.08, 0.02), (0.33, 0.24, 0.09), spots=0.9)]


def in_view(u, v, distance):
    """The point at fractions u and v of the image, from its upper left corner, at a distance along the axis."""
    right, up = (2 * u - 1) * TAN_X * distance, (1 - 2 * v) * TAN_Y * distance
    c, s = np.cos(TILT), np.sin(TILT)
    return EYE + np.array([right, up * c - distance * s, -up * s - distance * c])


def inland(x, z):
    """Approximate distance from the shore, positive on land."""
    bend = 3.0 * fbm(x / 16, z / 16, octaves=3, seed=2)
    far = -z - 41 + 0.004 * x * x + 6 * noise(x / 37, seed=9)
    left = -x - (7.6 + 0.20 * (12 - z))
    right = x - (7.0 + 0.13 * (12 - z))
    edges = np.stack(np.broadcast_arrays(far, left, right))
    return 2.0 * np.log(np.sum(np.exp(np.clip(edges, -400, 400) / 2.0), axis=0)) + bend


def ground_height(x, z):
    d = inland(x, z)
    land = np.maximum(d, 0)
    bank = 1.1 * (1 - np.exp(-land / 3.0)) + 0.035 * land + 0.0003 * np.minimum(land, 300) ** 1.6
    bumps = (0.25 + 0.012 * np.minimum(land, 200)) * fbm(x / 9, z / 9, octaves=5, seed=12)
    hills = smoothstep(30, 200, land) * 8 * fbm(x / 130, z / 130, octaves=2, seed=15)
    bed = -3.2 * (1 - np.exp(np.minimum(d, 0) / 5.0))
    return np.where(d > 0, bank, bed) + bumps * smoothstep(-2, 2, d) + hills


def make_ground():
    """Writes the ground as a grid that is finest near the camera."""
    s = np.linspace(-1, 1, 420)
    x = 45 * s + 600 * np.abs(s) ** 4 * s
    t = np.linspace(0, 1, 420)
    z = 14 - 75 * t - 700 * t**4
    gx, gz = np.meshgrid(x, z)
    y = ground_height(gx, gz)
    soil = 0.5 + 0.5 * fbm(gx / 3, gz / 3, octaves=5, seed=33)[..., None]
    green = smoothstep(-0.25, 0.35, fbm(gx / 14, gz / 14, octaves=4, seed=34) + 0.02 * np.minimum(inland(gx, gz), 20))
    color = np.array([0.050, 0.036, 0.024]) * (0.35 + soil)
    color = color * (1 - green[..., None]) + green[..., None] * np.array([0.034, 0.058, 0.014]) * (0.35 + soil)
    color = color * (0.30 + 0.70 * smoothstep(-0.3, 1.2, y))[..., None]
    Mesh(np.stack([gx, y, gz], -1), grid_faces(420, 420), None, color.reshape(-1, 3)).write(FOLDER / "ground.ply")


def ripple(r, front, length, slope, width):
    """Height of a packet of rings whose waves are shorter at its front."""
    count = 4000
    radius = np.linspace(0, 80, count)
    wavelength = length * (1.45 - 0.62 * np.clip(radius / front, 0, 1.3))
    phase = np.interp(r, radius, np.cumsum(2 * np.pi / wavelength) * (radius[1] - radius[0]))
    local = np.interp(r, radius, wavelength)
    rise = np.exp(-((r - 0.62 * front) / width) ** 2)
    return slope * local / (2 * np.pi) * rise * np.cos(phase) * smoothstep(0, 0.25 * length, r + 0.1 * length)


def water_height(x, z):
    r = np.hypot(x - DROP_X, z)
    h = ripple(r, 3.5, 0.50, 0.23, 1.5)
    h = h + 0.050 * np.exp(-(r / 0.16) ** 2) - 0.020 * np.exp(-((r - 0.33) / 0.14) ** 2)
    h = h + ripple(np.hypot(x - DROP_X - 0.05, z + 0.1), 9.5, 0.95, 0.050, 1.9)
    h = h + ripple(np.hypot(x - 3.6, z + 15.0), 5.5, 0.8, 0.07, 2.0)
    for length, slope, seed in ((7.0, 0.010, 1), (3.1, 0.009, 2), (1.3, 0.005, 3)):
        h = h + slope * length / 3 * noise(x / length, 0.8 * z / length, seed=50 + seed)
    for (cx, _, cz), (rx, _, rz), _, heading in NEAR_STONES:
        a = np.radians(heading)
        u, w = np.cos(a) * (x - cx) - np.sin(a) * (z - cz), np.sin(a) * (x - cx) + np.cos(a) * (z - cz)
        outside = (np.hypot(u / rx, w / rz) - 1) * min(rx, rz)
        h = h + 0.10 * np.exp(-np.maximum(outside, 0) / 0.22)
    return h


def make_water():
    """Writes the water as rings around the place where the last drop fell."""
    radius = np.concatenate([np.linspace(0.004, 12, 760), 12 * 1.0095 ** np.arange(1, 250)])
    angle = 2 * np.pi * np.arange(640) / 640
    x = DROP_X + radius[:, None] * np.cos(angle)
    z = -radius[:, None] * np.sin(angle)
    mesh = Mesh(np.stack([x, water_height(x, z), z], -1), grid_faces(len(radius), 640, wrap=True))
    (mesh if mesh.normals[:, 1].sum() > 0 else mesh.flipped()).write(FOLDER / "water.ply")


def make_hero():
    """Writes the leaf, its stalk, a second leaf behind it and the hanging drop. Returns centers, normals and radii of
    droplets on the leaf."""
    HERO.write_textures(FOLDER, "hero", 2048)
    side = (-0.22, -0.72, 0.66)
    midrib = bezier([TIP + (-6.6, 0.30, -1.2), TIP + (-4.6, 1.30, -0.9), TIP + (-2.3, 1.30, -0.3),
                     TIP + (-0.6, 0.78, 0.0), TIP + (-0.02, 0.55, 0), TIP], 400)
    leaf = HERO.blade(midrib, side, 900, 91, fold=0.16, wave=0.07, curl=0.12)
    leaf.write(FOLDER / "hero.ply")
    drop = pendant_drop(midrib[::-1], (0.55, 0.0, -0.83), 0.055, 0.165, 1.75, 0.55)
    drop.write(FOLDER / "drop.ply")
    stem = tube(bezier([midrib[0], midrib[0] + (-1.5, -0.7, -0.2), midrib[0] + (-3, -3.5, -1)], 20),
                0.07 * np.linspace(0.8, 1.2, 20), 12, (0.09, 0.085, 0.03))
    second = bezier([(-9.5, 3.9, -4.5), (-7.6, 5.2, -5.0), (-5.4, 4.9, -5.6), (-4.4, 3.5, -5.8)], 200)
    other = HERO.blade(second, (0.1, -0.6, 0.7), 300, 41, fold=0.3, wave=0.08)
    other.write(FOLDER / "second.ply")
    stem.write(FOLDER / "stalk.ply")
    rng = np.random.default_rng(6)
    points, normals, sizes = droplet_placements(leaf, 90, (0.016, 0.105), rng, up=np.array([0, 0.7, 0.7]))
    return points, normals, sizes


class Scene:
    """Shape groups and instances as text."""

    def __init__(self):
        self.groups, self.instances, self.names = [], [], {}

    def group(self, kind, meshes):
        """Adds a group of (mesh, material) pairs as one more variant of a kind."""
        name = f"{kind}_{len(self.names.setdefault(kind, []))}"
        self.names[kind].append(name)
        shapes = []
        for i, (mesh, material) in enumerate(meshes):
            file = f"{name}_{i}.ply"
            mesh.write(FOLDER / file)
            shapes.append(f'<shape type="ply"><string name="filename" value="generated/{file}"/>'
                          f'<ref id="{material}"/></shape>')
        self.groups.append(f'<shape type="shapegroup" id="{name}">{"".join(shapes)}</shape>')

    def place(self, name, matrix, offset):
        rows = np.hstack([matrix, np.reshape(offset, (3, 1))])
        numbers = " ".join(f"{c:.5g}" for c in rows.ravel())
        self.instances.append(f'<shape type="instance"><ref id="{name}"/><transform name="to_world">'
                              f'<matrix value="{numbers} 0 0 0 1"/></transform></shape>')

    def scatter(self, rng, kind, points, normals, sizes):
        """Places random variants upright along normals with random headings."""
        frames = aligned(normals, rng.uniform(0, 2 * np.pi, len(points)))
        for point, frame, size in zip(points, frames, sizes):
            self.place(rng.choice(self.names[kind]), frame * size, point)

    def write(self, path):
        path.write_text("<scene version=\"3.0.0\">\n" + "\n".join(self.groups + self.instances) + "\n</scene>\n")


def make_groups(scene):
    """Makes several variants of every plant. All have a height or length near 1."""
    rng = np.random.default_rng(1)
    for i in range(4):
        scene.group("fern", [(plants.fern(rng, 1.0, fronds=7 + i), "plant")])
    for i in range(6):
        scene.group("grass", [(plants.grass(rng, 1.0, blades=9 + 2 * i), "plant")])
    for i in range(4):
        scene.group("moss", [(plants.moss(rng, 1.0, stems=46 + 8 * i), "moss")])
    for _ in range(3):
        scene.group("clover", [(plants.clover(rng, 1.0), "plant")])
    for i, leaf in enumerate(SMALL_LEAVES):
        leaf.write_textures(FOLDER, f"leaf{i}", 512)
        for _ in range(2):
            leaves, stalks = plants.leafy_plant(rng, leaf, 1.0, count=int(rng.integers(8, 14)))
            scene.group("leafy", [(leaves, f"leaf{i}"), (stalks, "plant")])
    for i, leaf in enumerate(AUTUMN_LEAVES):
        leaf.write_textures(FOLDER, f"autumn{i}", 512)
        for _ in range(2):
            scene.group("litter", [(plants.fallen_leaf(rng, leaf), f"autumn{i}")])
    for seed in range(4):
        scene.group("stone", [(plants.stone(20 + seed, (1.0, 0.6, 0.8), 4), "stone")])
    for seed in range(4):
        scene.group("trunk", [(plants.trunk(40 + seed, 1.0, 26, (rng.normal(0, 0.02), rng.normal(0, 0.02))), "bark")])
    for i in range(3):
        color = [(0.30, 0.09, 0.03), (0.34, 0.16, 0.05), (0.25, 0.07, 0.03)][i]
        scene.group("mushroom", [(plants.mushroom(rng, 1.0, color), "mushroom")])
    scene.group("droplet", [(sessile_drop(), "water_small")])


def place_on_water(scene):
    """Floating leaves near the rings, and grass close to the camera at the edges of the image."""
    rng = np.random.default_rng(9)
    for x, z, size in ((2.75, 0.9, 1.9), (2.3, -3.4, 1.1), (-4.9, -2.2, 1.4), (1.1, -12.5, 1.8), (-3.4, -15.0, 1.6)):
        frame = aligned(upright(rng, 1, 0.03), [rng.uniform(0, 6.28)])[0]
        place = (x, float(water_height(x, z)) + 0.02, z)
        scene.place(rng.choice(scene.names["litter"]), frame * size * [1, 0.45, 1], place)
    for x, z, size in ((2.75, 5.4, 2.3), (2.45, 6.1, 1.5), (-2.95, 5.3, 1.7)):
        frame = aligned(upright(rng, 1, 0.1), [rng.uniform(0, 6.28)])[0]
        scene.place(rng.choice(scene.names["grass"]), frame * size, (x, -0.3, z))


def land_points(rng, count, near, far, shore, spread=1.15):
    """Random points on land within view: distances from the camera and from the shore in ranges."""
    points = np.zeros((0, 3))
    while len(points) < count:
        distance = near * (far / near) ** rng.random(4 * count)
        x = rng.uniform(-spread, spread, 4 * count) * TAN_X * distance
        z = EYE[2] - distance
        d = inland(x, z)
        keep = (d > shore[0]) & (d < shore[1])
        points = np.vstack([points, np.stack([x, ground_height(x, z), z], -1)[keep]])
    return points[:count]


def tallest(points):
    """Sizes of plants that leave the view of the trunks and lamps open, more at the sides of the image."""
    distance = EYE[2] - points[:, 2]
    off_center = np.abs(points[:, 0] / (distance * TAN_X) - 0.06)
    return distance * (0.050 + 0.17 * smoothstep(0.35, 1.05, off_center)) + 0.3


def upright(rng, count, spread=0.12):
    return unit(np.array([0, 1.0, 0]) + rng.normal(0, spread, (count, 3)) * [1, 0, 1])


def scatter_plants(scene):
    rng = np.random.default_rng(2)
    # kind, number, distances, distances from the shore, median size and its spread
    layers = [("moss", 1300, (17, 70), (-0.4, 9), 1.0, 0.3), ("moss", 350, (60, 140), (0, 60), 1.8, 0.35),
              ("grass", 260, (17, 60), (-0.6, 7), 4.2, 0.4), ("grass", 650, (50, 130), (-0.5, 60), 8.0, 0.4),
              ("grass", 500, (120, 400), (10, 400), 16, 0.4), ("clover", 170, (20, 70), (0.8, 12), 2.3, 0.3),
              ("clover", 260, (50, 130), (1, 50), 4.5, 0.3), ("leafy", 46, (24, 70), (1.5, 14), 5.0, 0.3),
              ("leafy", 160, (55, 160), (3, 90), 11, 0.35), ("fern", 26, (30, 75), (2, 18), 8.5, 0.25),
              ("fern", 90, (60, 150), (3, 80), 17, 0.3), ("fern", 150, (130, 420), (10, 400), 32, 0.3),
              ("leafy", 120, (140, 420), (10, 400), 28, 0.35), ("litter", 420, (17, 120), (0.1, 60), 2.4, 0.35),
              ("stone", 120, (18, 90), (-1.2, 1.4), 0.8, 0.5), ("stone", 40, (60, 200), (2, 120), 4.5, 0.5),
              ("mushroom", 26, (22, 90), (1.0, 14), 1.6, 0.35)]
    for kind, count, distances, shore, size, spread in layers:
        points = land_points(rng, count, *distances, shore)
        if kind in ("litter", "mushroom"):  # none of these bright shapes behind the drop
            points = points[np.abs(points[:, 0] / ((EYE[2] - points[:, 2]) * TAN_X) - DROP_X / (EYE[2] * TAN_X)) > 0.1]
            count = len(points)
        sizes = np.minimum(size * np.exp(np.clip(rng.normal(0, spread, count), -2 * spread, 2 * spread)),
                           tallest(points) * rng.uniform(0.5, 1, count))
        lean = 0.35 if kind == "litter" else 0.12
        lift = {"litter": 0.12, "moss": -0.12}.get(kind, -0.02) * sizes
        scene.scatter(rng, kind, points + lift[:, None] * [0, 1, 0], upright(rng, count, lean), sizes)


def make_stones(scene):
    """Writes the stones near the camera and covers their tops with moss, grass and mushrooms."""
    rng = np.random.default_rng(3)
    stones = []
    for center, radii, seed, heading in NEAR_STONES:
        turn = rotation((0, 1, 0), np.radians(heading))
        stones.append(plants.stone(seed, radii, 6).moved(turn, 1.0, center))
    mesh = joined(stones)
    mesh.write(FOLDER / "stones.ply")
    points, normals = surface_points(mesh, 5200, rng)
    cover = fbm(points[:, 0], points[:, 2], points[:, 1], octaves=3, seed=70)
    keep = (normals[:, 1] > 0.35) & (points[:, 1] > 0.28) & (cover > -0.12)
    points, normals = points[keep], normals[keep]
    up = unit(0.6 * normals + np.array([0, 0.6, 0]))
    sizes = 0.34 * np.exp(rng.normal(0, 0.28, len(points))) * smoothstep(-0.2, 0.2, cover[keep])
    scene.scatter(rng, "moss", points - 0.1 * sizes[:, None] * up, up, sizes)
    for kind, count, size in (("grass", 12, 2.2), ("clover", 9, 1.0), ("mushroom", 5, 0.75), ("litter", 3, 1.3)):
        chosen = rng.choice(len(points), count)
        scene.scatter(rng, kind, points[chosen], upright(rng, count, 0.2), size * np.exp(rng.normal(0, 0.3, count)))


def place_trunks(scene):
    rng = np.random.default_rng(5)
    # Place across the image, distance, radius.
    placed = [(0.045, 78, 2.4), (0.17, 150, 4.2), (0.265, 240, 6.0), (0.455, 185, 3.6), (0.575, 300, 7.0),
              (0.675, 125, 2.3), (0.79, 210, 5.0), (0.955, 92, 2.8), (0.875, 150, 2.9), (0.355, 330, 6.5),
              (0.515, 420, 6.0)]
    for u, distance, radius in placed:
        place_trunk(scene, rng, in_view(u, 0.4, distance), radius)
    for _ in range(16):
        distance = rng.uniform(320, 800)
        place_trunk(scene, rng, in_view(rng.uniform(-0.1, 1.1), 0.4, distance), rng.uniform(3, 8))


def place_trunk(scene, rng, point, radius):
    frame = aligned(upright(rng, 1, 0.03), [rng.uniform(0, 6.28)])[0]
    base = (point[0], float(ground_height(point[0], point[2])) - 0.3 * radius, point[2])
    scene.place(rng.choice(scene.names["trunk"]), frame * [radius, radius * rng.uniform(0.9, 1.4), radius], base)


# Strings of lamps: ends and lowest point in the image with their distances, number of lamps, radius of a lamp.
STRINGS = [((0.44, 0.03, 150), (0.70, 0.27, 118), (0.985, 0.02, 92), 7, 0.95),
           ((0.00, 0.15, 118), (0.14, 0.36, 130), (0.31, 0.10, 150), 4, 0.95),
           ((0.46, 0.15, 200), (0.63, 0.31, 215), (0.84, 0.17, 225), 6, 1.35)]
# Single lamps: place in the image, distance, radius.
SINGLES = [(0.535, 0.335, 82, 0.75), (0.865, 0.33, 58, 0.55), (0.235, 0.36, 96, 0.8), (0.418, 0.235, 118, 0.9),
           (0.74, 0.36, 105, 0.7)]
# Glow-worms close to the ground.
GLOW_WORMS = [(0.62, 0.415, 58, 0.13), (0.73, 0.44, 40, 0.10), (0.97, 0.47, 26, 0.07), (0.10, 0.43, 44, 0.10),
              (0.33, 0.425, 66, 0.13), (0.46, 0.43, 75, 0.13), (0.785, 0.405, 70, 0.14)]


def make_lamps():
    """Writes lamps as spheres with caps on wires."""
    spheres, metal = [], []
    for start, middle, end, count, radius in STRINGS:
        a, c = in_view(*start), in_view(*end)
        wire = bezier([a, 2 * in_view(*middle) - 0.5 * (a + c), c], 60)
        metal.append(tube(wire, 0.07, 5, (0.02, 0.02, 0.02)))
        for i in range(count):
            hook = wire[int(59 * (i + 0.5 + 0.22 * np.sin(5.1 * i + count)) / count)]
            spheres.append((hook - (0, 2.1 * radius, 0), radius * (0.9 + 0.2 * (0.5 + 0.5 * np.sin(3.7 * i)))))
    for u, v, distance, radius in SINGLES:
        spheres.append((in_view(u, v, distance), radius))
        center = spheres[-1][0]
        wire = [center, center + (0.2, 10 * radius, 0.1), center + (2.0, 30 * radius, 1)]
        metal.append(tube(wire, 0.05, 5, (0.02, 0.02, 0.02)))
    for center, radius in spheres:
        path = center + np.array([(0, 0.93, 0), (0, 1.0, 0), (0, 1.5, 0), (0, 1.55, 0)]) * radius
        metal.append(tube(path, radius * np.array([0.45, 0.42, 0.36, 0.05]), 12, (0.03, 0.025, 0.02)))
    lines = [lamp(center, radius, "lamp") for center, radius in spheres]
    lines += [lamp(in_view(u, v, d), radius, "glow_worm") for u, v, d, radius in GLOW_WORMS]
    (FOLDER / "lamps.xml").write_text("<scene version=\"3.0.0\">\n" + "\n".join(lines) + "\n</scene>\n")
    joined(metal).write(FOLDER / "wires.ply")


def lamp(center, radius, color):
    place = ", ".join(f"{c:.4g}" for c in center)
    return f'<shape type="sphere"><point name="center" value="{place}"/><float name="radius" value="{radius:.4g}"/>' \
           f'<emitter type="area"><rgb name="radiance" value="${color}"/></emitter></shape>'


def make_sky():
    """Writes a dim blue sky that is brightest above the trees behind the pond."""
    v, u = np.meshgrid((np.arange(64) + 0.5) / 64, (np.arange(128) + 0.5) / 128, indexing="ij")
    up, azimuth = np.cos(np.pi * v), 2 * np.pi * u
    behind = np.cos(azimuth)
    glow = np.exp(-((up - 0.12) / 0.22) ** 2) * (0.55 + 0.45 * behind)
    base = 0.25 + 0.5 * np.maximum(up, 0)
    sky = base[..., None] * np.array([0.20, 0.34, 0.60]) + glow[..., None] * np.array([0.30, 0.52, 0.75])
    write_hdr(FOLDER / "sky.hdr", np.where(up[..., None] > -0.05, sky, sky * 0.15))


def main():
    FOLDER.mkdir(parents=True, exist_ok=True)
    scene = Scene()
    make_groups(scene)
    make_ground()
    make_water()
    points, normals, sizes = make_hero()
    scene.scatter(np.random.default_rng(8), "droplet", points, normals, sizes)
    make_stones(scene)
    scatter_plants(scene)
    place_trunks(scene)
    place_on_water(scene)
    make_lamps()
    make_sky()
    scene.write(FOLDER / "plants.xml")


if __name__ == "__main__":
    main()
