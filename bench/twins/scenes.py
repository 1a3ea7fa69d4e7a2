"""The twin scenes. Each function returns one; SCENES lists them."""

import numpy as np

from twins.meshes import (box, lattice, merged, placed, prism, product, quad, revolved, rounded, scale, shift, tube,
                          turn, waves)
from twins.scene import Diffuse, Fog, Glass, Metal, PointLight, QuadLight, Scene

GOLD = Metal((0.16, 0.42, 1.38), (3.98, 2.38, 1.92), 0.1)
STEEL = Metal((2.9, 2.9, 2.6), (3.1, 3.0, 2.7), 0.06)
BRASS = Metal((0.44, 0.53, 1.09), (3.70, 2.77, 1.83), 0.12)
BLACK = Diffuse((0, 0, 0))


def stairwell():
    """A round tower with winding stairs. One lamp shines at the dome, so everything else is lit indirectly."""
    scene = Scene("stairwell", (-1.9, -1.15, 1.45), (0.5, 0.35, 1.75), 84)
    scene.materials = {"plaster": Diffuse((0.74, 0.7, 0.62)), "stone": Diffuse((0.5, 0.47, 0.45)), "brass": BRASS,
                       "tiles": Diffuse((0.35, 0.2, 0.14)), "glaze": Diffuse((0.1, 0.28, 0.36)), "black": BLACK}
    inner, outer, rise, steps = 0.35, 2.6, 0.17, 26
    dome = [(outer * np.cos(t), 5.2 + 1.3 * np.sin(t)) for t in np.linspace(0, np.pi / 2, 25)]
    scene.add("wall", revolved([(outer, 0), (outer, 1.7), (outer, 3.4), *dome], 128), "plaster")
    scene.add("floor", revolved([(0, 0), (outer / 2, 0), (outer, 0)], 128), "tiles")
    column = [(0, 0), (0.5, 0), (0.5, 0.2), (inner, 0.3), (inner, 2.5), (inner, 4.7), (0, 4.7)]
    scene.add("column", revolved(rounded(column), 64), "stone")
    angle = np.radians(18)
    arc = [(r * np.cos(a), r * np.sin(a)) for r, turned in ((inner - 0.05, False), (outer + 0.05, True))
           for a in np.linspace(0, angle, 7)[::-1 if not turned else 1]]
    step = prism(arc, 0, 0.07)
    wedges = [placed(step, turn("z", 200 + 15 * i), shift(0, 0, rise * (i + 1))) for i in range(steps)]
    scene.add("steps", merged(*wedges), "stone")
    turns = np.radians(200 + 15 * np.linspace(0.5, steps + 0.5, 160))
    rail = np.stack([1.95 * np.cos(turns), 1.95 * np.sin(turns), rise * np.linspace(1, steps, 160) + 1.0], axis=1)
    posts = [placed(revolved([(0, 0), (0.016, 0), (0.016, 0.95), (0, 0.95)], 12),
                    shift(*rail[int((i + 0.5) * 160 / steps) - 1][:2], rise * (i + 1) + 0.06)) for i in range(steps)]
    scene.add("rail", merged(tube(rail, 0.03, 16), *posts), "brass")
    urn = revolved(rounded([(0, 0), (0.14, 0), (0.32, 0.3), (0.3, 0.62), (0.12, 0.74), (0.2, 0.86), (0.16, 0.86),
                            (0.08, 0.74), (0.24, 0.6), (0.26, 0.3), (0, 0.04)]), 96)
    scene.add("urn", urn, "glaze", shift(0.45, -1.15), product(shift(-0.55, 1.5), scale(0.8)),
              product(shift(1.0, -0.65), scale(0.55)))
    scene.add("tray", box((-0.45, -0.45, 4.9), (0.45, 0.45, 4.95)), "black")
    scene.lights = [QuadLight((0, 0, 4.96), (0.4, 0, 0), (0, 0.4, 0), (62, 56, 46))]
    return scene


def optics():
    """A lens, a prism, a ring and a pane of glass, a cogwheel and washers of metal, under a soft box and a dim sky."""
    scene = Scene("optics", (0.3, -3.6, 1.75), (0.05, 0, 0.36), 34)
    scene.materials = {"table": Diffuse((0.62, 0.58, 0.52)), "wall": Diffuse((0.3, 0.4, 0.42)), "glass": Glass(1.52),
                       "gold": GOLD, "steel": STEEL, "red": Diffuse((0.6, 0.1, 0.07)), "black": BLACK}
    scene.add("table", quad((0, 0, 0), (5, 0, 0), (0, 5, 0)), "table")
    scene.add("wall", quad((0, 2.4, 2), (5, 0, 0), (0, 0, 2)), "wall")
    t = np.linspace(0, 1, 40)
    lens = [*zip(0.5 * t, -0.17 * (1 - t**2) - 0.012), *zip(0.5 * t[::-1], 0.17 * (1 - t[::-1]**2) + 0.012)]
    scene.add("lens", placed(revolved(lens, 160), shift(-0.35, 0.25, 0.502), turn("z", 12), turn("x", 90)), "glass")
    scene.add("prism", placed(prism([(-0.28, -0.16), (0.28, -0.16), (0, 0.325)], -0.3, 0.3), shift(0.62, -0.62, 0.161),
                              turn("z", -35), turn("x", 90)), "glass")
    a = 2 * np.pi * np.arange(49) / 48
    scene.add("ring", placed(revolved(np.column_stack([0.3 + 0.075 * np.cos(a), 0.075 * np.sin(a)]), 160),
                             shift(-0.5, -0.85, 0.077)), "glass")
    x = np.linspace(-0.45, 0.45, 121)
    front = np.column_stack([x, -0.02 - 0.012 * np.cos(60 * x)])
    scene.add("pane", placed(prism(np.concatenate([front, [(0.45, 0.03), (-0.45, 0.03)]]), 0, 0.75),
                             shift(0.95, 0.75, 0.001), turn("z", -15)), "glass")
    teeth = [(r * np.cos(b), r * np.sin(b)) for i in range(24)
             for r, b in zip((0.3, 0.36, 0.36, 0.3), np.radians(15 * i + np.array([0, 3, 7, 10])))]
    scene.add("cogwheel", placed(prism(teeth, 0, 0.09), shift(0.22, 0.45, 0.36), turn("z", 25), turn("x", 75)), "gold")
    washer = revolved([(0.09, 0), (0.2, 0), (0.21, 0.012), (0.21, 0.028), (0.2, 0.04), (0.09, 0.04), (0.09, 0)], 120)
    scene.add("washer", washer, "steel", *(shift(-1.0 + 0.02 * (i % 3), -0.2 - 0.015 * (i % 2), 0.001 + 0.042 * i)
                                           for i in range(7)))
    scene.add("cone", placed(revolved([(0, 0), (0.17, 0), (0, 0.5)], 96), shift(0.12, -0.25)), "red")
    scene.environment = (0.16, 0.19, 0.24)
    u, v = np.array([0.6, 0.15, 0]), np.array([0.08, -0.32, -0.18])
    center, normal = np.array([-0.9, 0.6, 2.7]), np.cross(u, v) / np.linalg.norm(np.cross(u, v))
    scene.add("case", quad(center - 0.01 * normal, 1.02 * u, 1.02 * v), "black")
    scene.lights = [QuadLight(center, u, v, (19, 18, 16))]
    return scene


def sky(sun, width=512, height=256):
    """A clear sky above brown ground, with a sun of about 2 degrees."""
    azimuth = 2 * np.pi * (0.5 - (np.arange(width) + 0.5) / width)
    elevation = np.pi * (0.5 - (np.arange(height) + 0.5) / height)
    azimuth, elevation = np.meshgrid(azimuth, elevation)
    up = np.sin(elevation)
    direction = np.stack([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), up], axis=-1)
    haze = np.exp(-4 * np.maximum(up, 0))[..., None]
    pixels = haze * [0.95, 0.9, 0.8] + (1 - haze) * [0.2, 0.4, 0.85]
    pixels = np.where(up[..., None] < 0, [0.16, 0.13, 0.1], pixels)
    away = np.degrees(np.arccos(np.clip(direction @ (np.asarray(sun) / np.linalg.norm(sun)), -1, 1)))[..., None]
    return pixels + np.array([1, 0.86, 0.66]) * (1900 * np.exp(-((away / 1.2) ** 2)) + 1.5 * np.exp(-away / 8))


def bundle(random, stalks, height, spread, waist):
    """Stalks of three sides that lean through a waist at 0.55 of their height."""
    parts = []
    for _ in range(stalks):
        direction, radius = random.uniform(0, 2 * np.pi), np.sqrt(random.uniform())
        knee = np.array([np.cos(direction), np.sin(direction)]) * radius
        foot, middle = knee * spread * random.uniform(0.8, 1), knee * waist
        tip = middle + (knee * spread + random.normal(0, 0.05, 2)) * 0.9
        tall = height * random.uniform(0.85, 1.1)
        ear = 0.4 * middle + 0.6 * tip
        path = [[*foot, 0], [*middle, 0.55 * height], [*ear, 0.87 * tall], [*tip, tall]]
        parts.append(tube(path, [0.008, 0.007, 0.016, 0.003], 3))
    return merged(*parts)


def harvest():
    """A field with 6800 instances of sheaves, their bands, stubble and rolls under a sky with a sun."""
    random = np.random.default_rng(60)
    scene = Scene("harvest", (0, -9, 1.9), (0.5, 6, 0.75), 58, environment=sky((0.5, 0.35, 0.55)))
    scene.materials = {"soil": Diffuse((0.27, 0.2, 0.13)), "straw": Diffuse((0.66, 0.5, 0.22)),
                       "ripe": Diffuse((0.74, 0.53, 0.19)), "band": Diffuse((0.4, 0.16, 0.08))}
    hills = waves(1, 16, 25, 90)
    height = lambda points: 1.4 * hills(points)  # noqa: E731
    across, away = np.meshgrid(np.linspace(-120, 120, 241), np.linspace(-30, 210, 241))
    flat = np.stack([across, away], axis=-1)
    scene.add("ground", lattice(np.concatenate([flat, height(flat)[..., None]], axis=-1)), "soil")

    def scattered(count, low, high, smallest, largest):
        points = np.column_stack([random.uniform(a, b, count) for a, b in zip(low, high)])
        return [product(shift(x, y, z - 0.03), turn("z", random.uniform(0, 360)),
                        scale(random.uniform(smallest, largest))) for (x, y), z in zip(points, height(points))]

    rows = scattered(1400, (-45, -5), (45, 80), 1.2, 1.7)
    scene.add("sheaf", bundle(random, 110, 1.25, 0.3, 0.07), "ripe", *rows)
    band = revolved([(0.085, 0.66), (0.1, 0.7), (0.085, 0.74)], 20)
    scene.add("band", band, "band", *rows)
    scene.add("stubble", bundle(random, 40, 0.16, 0.4, 0.4), "straw", *scattered(3000, (-14, -8), (14, 22), 0.7, 1.3),
              *scattered(1000, (-40, 15), (40, 60), 1, 1.6))
    roll = revolved(rounded([(0, -0.6), (0.75, -0.6), (0.8, 0), (0.75, 0.6), (0, 0.6)]), 64)
    scene.add("roll", placed(roll, shift(0, 0, 0.75), turn("x", 90)), "straw",
              *scattered(24, (-40, 4), (40, 70), 1, 1.3))
    return scene


def bazaar():
    """A hall with 300 hanging lamps below shades and 120 lamps without size, whose powers differ by a factor of 60."""
    random = np.random.default_rng(7)
    scene = Scene("bazaar", (-8.3, -5.2, 2.9), (1.5, 1, 1.3), 66, hides_lights=True)
    scene.materials = {"plaster": Diffuse((0.62, 0.56, 0.46)), "tiles": Diffuse((0.36, 0.24, 0.2)), "copper": BRASS,
                       "wood": Diffuse((0.3, 0.2, 0.11)), "cloth": Diffuse((0.45, 0.12, 0.16)),
                       "clay": Diffuse((0.5, 0.3, 0.2)), "enamel": Diffuse((0.55, 0.6, 0.5)), "black": BLACK}
    scene.add("floor", quad((0, 0, 0), (9, 0, 0), (0, 6, 0)), "tiles")
    up = (0, 0, 2.25)
    walls = [quad((0, y, 2.25), (9, 0, 0), up) for y in (-6, 6)] + [quad((x, 0, 2.25), (0, 6, 0), up) for x in (-9, 9)]
    scene.add("walls", merged(*walls, quad((0, 0, 4.5), (9, 0, 0), (0, 6, 0))), "plaster")
    table = merged(box((-0.9, -0.45, 0.78), (0.9, 0.45, 0.84)), *(box((x, y, 0), (x + 0.08, y + 0.08, 0.78))
                                                                  for x in (-0.88, 0.8) for y in (-0.43, 0.35)))
    tables = [product(shift(x, y), turn("z", random.uniform(-12, 12)))
              for x in np.arange(-6, 8, 3) for y in (-3.2, 0, 3.2)]
    scene.add("table", table, "wood", *tables)
    pot = revolved(rounded([(0, 0), (0.1, 0), (0.19, 0.16), (0.14, 0.3), (0.07, 0.36), (0.1, 0.42), (0.07, 0.42),
                            (0.04, 0.36), (0.1, 0.28), (0.14, 0.16), (0, 0.03)]), 48)
    on_tables = [product(place, shift(random.uniform(-0.65, 0.65), random.uniform(-0.25, 0.25), 0.841),
                         scale(random.uniform(0.6, 1.1))) for place in tables for _ in range(4)]
    scene.add("pot", pot, "clay", *on_tables[::2])
    scene.add("ewer", pot, "copper", *on_tables[1::2])
    u, v = np.meshgrid(np.linspace(-2.2, 2.2, 60), np.linspace(0, 1, 40))
    for k, y in enumerate((-4.6, 1.6, 4.7)):
        awning = np.stack([u - 1.5 + 2.5 * k, y + 0.6 * v, 3.6 - 0.7 * v**2 + 0.06 * np.sin(9 * u) * v], axis=-1)
        scene.add(f"awning{k}", lattice(awning), "cloth")
    lamps = [(random.uniform(-8.5, 8.5), random.uniform(-5.6, 5.6), random.uniform(2.1, 4.1)) for _ in range(300)]
    shade = revolved([(0.02, 0.1), (0.05, 0.09), (0.12, -0.03), (0.115, -0.03), (0.048, 0.082), (0.02, 0.1)], 24)
    scene.add("shade", shade, "enamel", *(shift(*lamp) for lamp in lamps))
    scene.add("socket", box((-0.03, -0.03, 0.001), (0.03, 0.03, 0.02)), "black", *(shift(*lamp) for lamp in lamps))
    for lamp in lamps:
        color = (1, random.uniform(0.5, 0.9), random.uniform(0.2, 0.6))
        power = 60 ** random.uniform() * 14
        scene.lights.append(QuadLight(lamp, (0.028, 0, 0), (0, -0.028, 0), tuple(power * c for c in color)))
    for _ in range(120):
        position = (random.uniform(-8.4, 8.4), random.uniform(-5.4, 5.4), random.uniform(1.3, 2.0))
        color = np.array([1, random.uniform(0.4, 1), random.uniform(0.3, 1)])
        scene.lights.append(PointLight(position, tuple(60 ** random.uniform() * 0.006 * color)))
    return scene


def pier():
    """A wooden pier in thin fog, with eight lamps under hoods and four without size."""
    scene = Scene("pier", (1.3, -9.2, 2.3), (-0.35, 0, 1.25), 56, environment=(0.006, 0.008, 0.012))
    scene.materials = {"water": Diffuse((0.05, 0.08, 0.09)), "planks": Diffuse((0.4, 0.31, 0.22)),
                       "iron": Diffuse((0.12, 0.12, 0.13)), "hull": Diffuse((0.55, 0.16, 0.1)), "black": BLACK}
    scene.add("water", quad((0, 10, -0.4), (40, 0, 0), (0, 24, 0)), "water")
    planks = [box((-1.5, y, 0.35), (1.5, y + 0.21, 0.42)) for y in np.arange(-7.5, 14, 0.24)]
    piles = [placed(revolved([(0, -0.4), (0.13, -0.4), (0.13, 0.75), (0.1, 0.82), (0, 0.82)], 20), shift(x, y))
             for x in (-1.6, 1.6) for y in np.arange(-7, 14, 2.4)]
    scene.add("planks", merged(*planks, *piles), "planks")
    post = [revolved([(0, 0.42), (0.1, 0.42), (0.05, 0.7), (0.045, 2.8), (0, 2.8)], 20),
            box((-0.03, -0.5, 2.74), (0.03, 0, 2.8))]
    hood = placed(revolved([(0, 0.16), (0.06, 0.14), (0.2, 0), (0.19, 0), (0.055, 0.12), (0, 0.14)], 32),
                  shift(0, -0.5, 2.6))
    places = [product(shift(x, y), turn("z", 90 if x > 0 else -90)) for x in (-1.35, 1.35) for y in (-5.2, -1, 3.4, 8)]
    scene.add("post", merged(*post, hood), "iron", *places)
    scene.add("plate", placed(box((-0.1, -0.1, 0), (0.1, 0.1, 0.02)), shift(0, -0.5, 2.62)), "black", *places)
    for place in places:
        center = (place @ [0, -0.5, 2.619, 1])[:3]
        scene.lights.append(QuadLight(tuple(center), (0.09, 0, 0), (0, -0.09, 0), (130, 104, 66)))
    t, s = np.meshgrid(np.linspace(0.002, 0.998, 60), np.linspace(-1, 1, 41))
    width = 0.75 * np.sin(np.pi * t ** 0.8) ** 0.7
    hull = np.stack([width * s, 4.2 * (t - 0.5), 0.55 * np.abs(s) ** 2.2 * (1 + 0.5 * (2 * t - 1) ** 2) - 0.1], axis=-1)
    scene.add("boat", lattice(hull), "hull", product(shift(-3.4, -0.6, -0.25), turn("z", 8)),
              product(shift(3.3, 2.2, -0.25), turn("z", -14)), product(shift(-4.2, 6, -0.25), turn("z", 24)))
    for position in ((-3.4, -0.9, 0.75), (3.4, 2.0, 0.8), (-4.1, 5.6, 0.8), (0.2, 11, 1.5)):
        scene.lights.append(PointLight(position, (1.6, 2.2, 2.6)))
    scene.fog = Fog((-16, -8.6, -0.39), (16, 26, 7), 0.05, 0.006)
    return scene


SCENES = {make.__name__: make for make in (stairwell, optics, harvest, bazaar, pier)}
