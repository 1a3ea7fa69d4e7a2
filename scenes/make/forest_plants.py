"""The plants, stones and trunks of scenes/forest as meshes with colors of vertices. Needs numpy. Lengths in
centimeters; +y is up and plants stand on y = 0."""

import numpy as np

from forest_leaf import bezier
from forest_shapes import (Mesh, aligned, copies, fbm, grid_faces, icosphere, joined, noise, rotation, smoothstep,
                           strip, tube, unit)


def tint(rng, color, spread):
    """A color with random brightness and hue."""
    return np.asarray(color) * rng.uniform(1 - spread, 1 + spread) * rng.uniform(1 - 0.5 * spread, 1 + 0.5 * spread, 3)


def turns(rng, directions):
    return aligned(directions, rng.uniform(0, 2 * np.pi, len(directions)))


def lobe(length, half_width, droop, fold, color, rows=5):
    """A small leaf that starts at the origin along +y, with its upper side towards +z."""
    t = np.linspace(0, 1, rows)
    path = np.stack([0 * t, length * t, -droop * length * t**2], axis=-1)
    width = half_width * np.array([0.45, 0.95, 1.0, 0.65, 0.05]) if rows == 5 else \
        half_width * np.sin(np.pi * np.clip(0.12 + 0.88 * t, 0, 1)) ** 0.8
    shade = np.asarray(color) * (0.8 + 0.4 * t[:, None])
    return strip(path, (1, 0, 0), width, fold=-fold, color=shade)


def pinna(rng, length, color, count):
    """One side leaf of a fern along +y: a thin stalk and two rows of lobes, upper side towards +z."""
    t = (np.arange(count) + 0.6) / count
    size = length * 0.30 * (1 - t) ** 0.75 * (0.5 + 0.5 * smoothstep(0, 0.12, t)) + 0.02 * length
    parts = []
    leaf = lobe(1, 0.30, 0.25, 0.25, color)
    for side in (-1, 1):
        angle = side * (1.12 - 0.35 * t) + rng.normal(0, 0.05, count)
        tilt = rng.normal(0, 0.18, count)
        x = np.stack([np.cos(angle), -np.sin(angle), 0 * t], -1)
        y = np.stack([np.sin(angle), np.cos(angle), 0 * t], -1)
        z = np.array([0.0, 0, 1]) + tilt[:, None] * x
        turn = np.stack([x, y, unit(z)], axis=-1) * size[:, None, None]
        at = np.stack([0 * t, length * (t + 0.015 * side), -0.18 * length * t**2], -1)
        parts.append(copies(leaf, turn, at, rng.uniform(0.8, 1.2, (count, 1)) * np.ones(3)))
    s = np.linspace(0, 1, 6)
    stalk = np.stack([0 * s, length * s, -0.18 * length * s**2], -1)
    parts.append(strip(stalk, (1, 0, 0), 0.012 * length * (1.1 - s), color=np.asarray(color) * 0.8))
    return joined([Mesh(p.positions, p.faces, None, p.colors, p.normals) for p in parts])


def frond(rng, length, color, pairs=20, lean=0.35, bend=1.2, lobes=9):
    """A fern frond that grows up from the origin and arches towards +z."""
    s = np.linspace(0, 1, 40)
    angle = lean + bend * s**1.4
    step = length / len(s)
    path = np.cumsum(np.stack([0.04 * length * np.sin(3 * s) / len(s), step * np.cos(angle), step * np.sin(angle)], -1),
                     axis=0)
    parts = []
    stem = tube(path, length * 0.011 * (1.15 - s), 6, np.array([0.10, 0.085, 0.03]))
    parts.append(Mesh(stem.positions, stem.faces, None, stem.colors, stem.normals))
    for i in range(pairs):
        t = 0.20 + 0.79 * (i / pairs) ** 0.95
        size = 0.30 * length * np.sin(np.pi * (0.16 + 0.84 * (t - 0.2) / 0.8) ** 0.85) ** 0.9 + 0.015 * length
        place = np.array([np.interp(t, s, path[:, k]) for k in range(3)])
        a = np.interp(t, s, angle)
        along, up = np.array([0, np.cos(a), np.sin(a)]), np.array([0, np.sin(a), -np.cos(a)])
        for side in (-1, 1):
            lift = rng.normal(-0.12, 0.12)
            y = unit(side * np.array([1.0, 0, 0]) + (0.25 + 0.5 * t) * along + lift * up)
            z = unit(up - y * (up @ y))
            leaf = pinna(rng, size * rng.uniform(0.88, 1.08), tint(rng, color, 0.12), lobes)
            parts.append(leaf.moved(np.stack([np.cross(y, z), y, z], -1), 1.0, place))
    return joined(parts)


def fern(rng, height, fronds=9):
    """A rosette of fronds."""
    parts = []
    for i in range(fronds):
        color = tint(rng, (0.050, 0.130, 0.020) if rng.random() < 0.8 else (0.14, 0.13, 0.025), 0.25)
        leaf = frond(rng, height * rng.uniform(0.7, 1.15), color, lean=rng.uniform(0.15, 0.5),
                     bend=rng.uniform(0.8, 1.6), pairs=18, lobes=8)
        parts.append(leaf.moved(rotation((0, 1, 0), 2 * np.pi * (i + rng.uniform(-0.3, 0.3)) / fronds)))
    return joined(parts)


def grass(rng, height, blades=16):
    """A tuft of grass."""
    parts = []
    s = np.linspace(0, 1, 12)
    for _ in range(blades):
        length, azimuth = height * rng.uniform(0.45, 1.1), rng.uniform(0, 2 * np.pi)
        angle = rng.uniform(0.05, 0.4) + rng.uniform(0.1, 1.9) * s**2
        step = length / len(s)
        out = np.cumsum(step * np.sin(angle))
        root = rng.normal(0, 0.045 * height, 2)
        path = np.stack([root[0] + out * np.cos(azimuth), np.cumsum(step * np.cos(angle)),
                         root[1] + out * np.sin(azimuth)], -1)
        width = height * 0.014 * rng.uniform(0.6, 1.3) * (1 - s) ** 0.6 * (0.5 + s) + 1e-3
        dry = rng.random() < 0.18
        color = tint(rng, (0.20, 0.16, 0.06) if dry else (0.055, 0.125, 0.020), 0.3)
        turn = rng.normal(0, 0.5)
        side = (-np.sin(azimuth + turn), 0, np.cos(azimuth + turn))
        parts.append(strip(path, side, width, fold=0.5, color=color * (0.55 + 0.6 * s[:, None])))
    return joined(parts)


def moss(rng, height, stems=70):
    """A tuft of moss: short stems with spiral leaves, densest in the middle."""
    leaf = lobe(1, 0.22, 0.5, 0.5, (1, 1, 1))
    parts = []
    for _ in range(stems):
        root = rng.normal(0, 0.42 * height, 2)
        lean = unit(np.array([0.5 * root[0] / height, 1, 0.5 * root[1] / height]) + rng.normal(0, 0.15, 3))
        length = height * rng.uniform(0.6, 1.05) * np.exp(-0.35 * (root @ root) / height**2)
        count = 14
        t = (np.arange(count) + 0.5) / count
        azimuth = 2.4 * np.arange(count) + rng.uniform(0, 6)
        open_angle = 0.95 - 0.65 * t
        out = np.stack([np.cos(azimuth), 0 * t, np.sin(azimuth)], -1)
        y = np.sin(open_angle)[:, None] * out + np.cos(open_angle)[:, None] * lean
        z = np.cos(open_angle)[:, None] * -out + np.sin(open_angle)[:, None] * lean
        y, z = unit(y), unit(z)
        x = np.cross(y, z)
        size = 0.26 * height * (0.7 + 0.3 * np.sin(np.pi * t)) * rng.uniform(0.8, 1.2, count)
        at = np.array([root[0], 0, root[1]]) + (length * t)[:, None] * lean
        color = tint(rng, (0.125, 0.235, 0.035), 0.25) * (0.35 + 0.9 * t[:, None] ** 0.8)
        parts.append(copies(leaf, np.stack([x, y, z], -1) * size[:, None, None], at, color))
    return joined(parts)


def clover(rng, height, stalks=14):
    """A clump of stalks with three heart-shaped leaflets each."""
    t = np.linspace(0, 1, 7)
    width = np.array([0.04, 0.20, 0.36, 0.48, 0.52, 0.46, 0.30])
    path = np.stack([0 * t, t, -0.22 * t**2], -1)
    leaflet = strip(path, (1, 0, 0), width, fold=-0.3, color=np.ones(3) * (0.75 + 0.5 * (1 - t[:, None])), columns=5)
    parts = []
    for _ in range(stalks):
        azimuth, lean = rng.uniform(0, 2 * np.pi), rng.uniform(0.05, 0.75)
        length = height * rng.uniform(0.5, 1.05)
        end = length * np.array([np.sin(lean) * np.cos(azimuth), np.cos(lean), np.sin(lean) * np.sin(azimuth)])
        stem = tube(bezier([(0, 0, 0), (0.1 * end[0], 0.7 * end[1], 0.1 * end[2]), end], 6), 0.012 * height, 5,
                    tint(rng, (0.11, 0.13, 0.03), 0.2))
        parts.append(Mesh(stem.positions, stem.faces, None, stem.colors, stem.normals))
        up = unit(np.array([0.5 * end[0] / length, 1, 0.5 * end[2] / length]) + rng.normal(0, 0.15, 3))
        color, spin = tint(rng, (0.045, 0.135, 0.025), 0.25), rng.uniform(0, 2)
        frame = aligned(up[None], [spin])[0]
        for k in range(3):
            a = 2 * np.pi * k / 3 + rng.normal(0, 0.06)
            y = frame @ np.array([np.cos(a), -0.18, np.sin(a)])
            z = unit(up - y * (up @ y) / (y @ y))
            turn = np.stack([np.cross(unit(y), z), unit(y), z], -1)
            leaf = leaflet.moved(turn, 0.24 * height * rng.uniform(0.85, 1.1), end)
            parts.append(Mesh(leaf.positions, leaf.faces, None, leaf.colors * color, leaf.normals))
    return joined(parts)


def leafy_plant(rng, leaf, height, count=11):
    """Leaves of one kind on arching stalks. Returns the leaves, with texture coordinates, and the stalks."""
    leaves, stalks = [], []
    for i in range(count):
        azimuth = 2.4 * i + rng.normal(0, 0.25)
        out = np.array([np.cos(azimuth), 0, np.sin(azimuth)])
        lean, length = rng.uniform(0.15, 0.8), height * rng.uniform(0.45, 1.0)
        end = length * (np.sin(lean) * out + np.cos(lean) * np.array([0, 1.0, 0]))
        stem = tube(bezier([(0, 0, 0), 0.3 * end + np.array([0, 0.35 * length, 0]), end], 8), 0.010 * height, 6,
                    tint(rng, (0.09, 0.10, 0.03), 0.2))
        stalks.append(Mesh(stem.positions, stem.faces, None, stem.colors, stem.normals))
        size = height * rng.uniform(0.42, 0.62)
        droop = rng.uniform(0.3, 1.1)
        tip = end + size * (np.cos(droop) * out - np.sin(droop) * np.array([0, 1.0, 0]) * 0.7)
        middle = end + 0.5 * size * out + np.array([0, 0.16 * size, 0])
        side = np.cross(out, (0, 1.0, 0)) + rng.normal(0, 0.12, 3)
        leaves.append(leaf.blade(bezier([end, middle, tip], 24), -side, 40, 15, fold=0.22, wave=0.12, curl=0.06))
    return joined(leaves), joined(stalks)


def fallen_leaf(rng, leaf):
    """A curled leaf that lies on y = 0."""
    length = leaf.length
    arch = rng.uniform(0.05, 0.28)
    top = (0, 2 * arch * length, rng.normal(0, 0.1) * length)
    midrib = bezier([(-length / 2, 0.05, 0), top, (length / 2, 0.03, 0)], 30)
    return leaf.blade(midrib, (0, 0, -1), 50, 17, fold=rng.uniform(0.15, 0.6), wave=0.2, curl=0.1,
                      twist=rng.normal(0, 0.4))


def stone(seed, radii, steps=5, green=0.5):
    """A weathered stone around the origin, wider than high, with moss-colored patches on top."""
    directions, faces = icosphere(steps)
    x, y, z = (directions + 11.7 * seed).T
    shape = 1 + 0.22 * fbm(1.3 * x, 1.3 * y, 1.3 * z, seed=seed)
    shape = shape + 0.10 * np.abs(noise(2.9 * x, 2.9 * y, 2.9 * z, seed=5))
    shape = shape + 0.035 * fbm(9 * x, 9 * y, 9 * z, octaves=5, gain=0.65, seed=seed + 1)
    positions = directions * shape[:, None] * np.asarray(radii)
    grain = fbm(14 * x, 14 * y, 14 * z, octaves=4, gain=0.7, seed=seed + 2)[:, None]
    vein = smoothstep(0.72, 0.95, 1 - np.abs(fbm(2.2 * x, 4 * y, 2.2 * z, seed=seed + 3)))[:, None]
    color = np.array([0.085, 0.080, 0.072]) * (1 + 0.55 * grain) + 0.05 * vein
    top = smoothstep(0.2, 0.8, directions[:, 1] + 0.6 * fbm(3 * x, 3 * y, 3 * z, seed=seed + 4))[:, None]
    lichen = smoothstep(0.25, 0.45, fbm(6 * x, 6 * y, 6 * z, seed=seed + 6))[:, None]
    color = color * (1 - 0.5 * lichen * (1 - top)) + 0.5 * lichen * (1 - top) * np.array([0.17, 0.19, 0.12])
    color = color * (1 - green * top) + green * top * np.array([0.045, 0.075, 0.015]) * (1 + 0.5 * grain)
    return Mesh(positions, faces, None, np.clip(color, 0.004, 0.9))


def trunk(seed, radius, height, lean=(0.0, 0.0), rows=150, sides=110):
    """A trunk with ridged bark, a flared foot and moss on one side, from a little below the ground upwards."""
    y = np.linspace(-0.05, 1, rows) * height
    angle = 2 * np.pi * np.arange(sides) / sides
    height_at, angle_at = np.broadcast_arrays(y[:, None], angle[None])
    cx, cz = np.cos(angle_at), np.sin(angle_at)
    flare = 1 + 0.55 * np.exp(-np.maximum(height_at, 0) / (0.8 * radius)) * (0.6 + 0.4 * np.cos(5 * angle_at + seed))
    warp = 0.4 * noise(2 * cx, 2 * cz, height_at / (3 * radius), seed=seed)
    ridge = 1 - np.abs(fbm(5 * cx + warp, 5 * cz + warp, height_at / (2.6 * radius), gain=0.6, seed=seed + 1))
    bump = fbm(1.1 * cx, 1.1 * cz, height_at / (5 * radius), seed=seed + 2)
    r = radius * (1 - 0.25 * height_at / height) * flare * (1 + 0.13 * (ridge - 0.7) + 0.10 * bump)
    wander_x = 1.3 * radius * noise(y / (0.3 * height), seed=seed + 3) + lean[0] * y
    wander_z = 1.3 * radius * noise(y / (0.3 * height), seed=seed + 4) + lean[1] * y
    positions = np.stack([r * cx + wander_x[:, None], height_at, r * cz + wander_z[:, None]], axis=-1)
    color = np.array([0.085, 0.064, 0.046]) * (0.25 + 1.1 * smoothstep(0.45, 1.0, ridge))[..., None]
    mossy = smoothstep(-0.1, 0.5, 0.5 * np.cos(angle_at - 1.0) + 0.9 * np.exp(-height_at / (5 * radius)) - 0.35 +
                       0.5 * fbm(4 * cx, 4 * cz, height_at / radius, seed=seed + 5))[..., None]
    color = color * (1 - 0.75 * mossy) + 0.75 * mossy * np.array([0.050, 0.085, 0.016]) * (0.4 + 0.9 * ridge[..., None])
    mesh = Mesh(positions, grid_faces(rows, sides, wrap=True), None, color.reshape(-1, 3))
    outward = np.sum(mesh.normals * np.stack([cx, 0 * cx, cz], -1).reshape(-1, 3))
    return mesh if outward > 0 else mesh.flipped()


def mushroom(rng, height, color):
    """A mushroom: a cap with pale gills below on a bent stem."""
    bend = rng.normal(0, 0.16 * height, 2)
    stem = tube(bezier([(0, -0.05 * height, 0), (0, 0.6 * height, 0), (bend[0], height, bend[1])], 14),
                0.07 * height * np.linspace(1.25, 0.85, 14), 14, (0.42, 0.36, 0.26))
    profile = np.array([(0, 1.20), (0.12, 1.195), (0.24, 1.165), (0.36, 1.09), (0.44, 0.99), (0.47, 0.90),
                        (0.455, 0.875), (0.40, 0.90), (0.25, 0.96), (0.06, 0.99)]) * height
    turn = 2 * np.pi * np.arange(36) / 36
    positions = np.stack(np.broadcast_arrays(profile[:, 0, None] * np.cos(turn), profile[:, 1, None] + 0.006 * height *
                                             np.sin(18 * turn) * (profile[:, 0, None] > 0.1 * height),
                                             profile[:, 0, None] * np.sin(turn)), -1)
    shade = np.repeat(np.array([color] * 6 + [(0.5, 0.42, 0.3)] * 4), 36, axis=0)
    shade = shade * (1 + 0.3 * noise(9 * positions[..., 0].ravel() / height, 9 * positions[..., 2].ravel() / height,
                                     seed=3))[:, None]
    cap = Mesh(positions, grid_faces(len(profile), 36, wrap=True), None, np.clip(shade, 0, 1))
    if np.sum(cap.normals[:36 * 4, 1]) < 0:
        cap = cap.flipped()
    return joined([stem, cap.moved(rotation((1, 0, 0), rng.normal(0, 0.15)), 1.0, (bend[0], 0, bend[1]))])
