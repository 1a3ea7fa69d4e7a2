"""The leaves and the drops of scenes/forest: outlines, veins, textures, and the profile of a pendant drop. Needs numpy.
Lengths in centimeters. On a flat leaf x runs along the midrib from the base and y across."""

from dataclasses import dataclass

import numpy as np

from forest_shapes import Mesh, cells, encode_srgb, fbm, frames, grid_faces, noise, smoothstep, unit, write_png

# Half width of a leaf over the length, both relative; the narrow end is a drip tip.
OUTLINE = np.array([(0, 0.03), (0.03, 0.17), (0.08, 0.40), (0.15, 0.65), (0.24, 0.86), (0.34, 0.98), (0.43, 1.0),
                    (0.54, 0.92), (0.64, 0.74), (0.73, 0.51), (0.81, 0.29), (0.87, 0.155), (0.92, 0.085),
                    (0.96, 0.052), (1.0, 0.030)])


@dataclass
class Leaf:
    """Shape and colors of one kind of leaf."""
    length: float
    half_width: float
    pairs: int  # secondary veins on each side
    teeth: int  # along each edge
    seed: int
    base: tuple = (0.055, 0.150, 0.022)  # linear colors of the blade, between its veins and in its veins
    dark: tuple = (0.018, 0.070, 0.012)
    vein: tuple = (0.20, 0.30, 0.075)
    spot: tuple = (0.16, 0.085, 0.025)
    spots: float = 0.5  # 0 to 1

    def width_at(self, x):
        """Half width without teeth."""
        s = np.linspace(0, 1, 2001)
        width = np.interp(s, OUTLINE[:, 0], OUTLINE[:, 1])
        kernel = np.hanning(121)
        padded = np.concatenate([2 * width[0] - width[60:0:-1], width, 2 * width[-1] - width[-2:-62:-1]])
        smooth = np.convolve(padded, kernel / kernel.sum(), mode="valid")
        return self.half_width * np.maximum(np.interp(np.asarray(x) / self.length, s, smooth), 0.012)

    def edge_at(self, x, side):
        """Half width with teeth that point to the tip; side is -1 or 1."""
        s = np.asarray(x) / self.length
        phase = self.teeth * (s + 0.012 * noise(9 * s, 3.0 * side + 0 * s, seed=self.seed)) + 0.3 * side
        tooth = phase - np.floor(phase)
        tooth = np.where(tooth < 0.78, tooth / 0.78, (1 - tooth) / 0.22)
        size = (0.22 * self.length / self.teeth) * smoothstep(0.06, 0.2, s) * (1 - smoothstep(0.74, 0.86, s))
        return self.width_at(x) + size * (tooth - 0.5) + 0.02 * self.half_width * noise(14 * s, 7.0 * side, seed=3)

    def veins(self, x, y):
        """Distances to the midrib and to secondary veins, their half widths, and a coordinate between secondaries."""
        side, across = np.where(y < 0, -1.0, 1.0), np.abs(y)
        spacing = 0.86 * self.length / self.pairs
        wobble = 0.10 * spacing * noise(1.3 * x / spacing, 1.1 * y / spacing, seed=self.seed + 5)
        along = x - 0.55 * across - 0.16 * across**2 / self.half_width + wobble
        index = (along - 0.03 * self.length) / spacing + 0.27 * side
        jitter = 0.16 * noise(np.round(index) + 0.5, 5.3 * side, seed=self.seed)
        from_vein = (index - np.round(index) - jitter) * spacing * 0.82
        share = np.clip(across / np.maximum(self.width_at(x), 1e-6), 0, 1)
        middle_width = self.half_width * (0.040 * (1 - x / self.length) + 0.010)
        side_width = self.half_width * (0.021 * (1 - share) + 0.004)
        inside = smoothstep(-0.2, 0.3, index) * (1 - smoothstep(0.80, 0.86, x / self.length))
        return across, middle_width, np.abs(from_vein), side_width, inside, index * spacing, share

    def relief(self, x, y):
        """Height of the upper side: grooves at veins, domes between them."""
        across, middle, side_distance, side, inside, _, share = self.veins(x, y)
        groove = 0.9 * middle * np.exp(-(across / (1.2 * middle)) ** 2)
        groove = groove + 1.1 * side * inside * np.exp(-(side_distance / (1.3 * side)) ** 2)
        spacing = 0.86 * self.length / self.pairs
        dome = inside * (1 - np.exp(-(side_distance / (0.22 * spacing)) ** 2)) * smoothstep(0, 0.15, share)
        return 0.055 * spacing * dome * (1 - 0.5 * share) - groove

    def write_textures(self, folder, name, width):
        """Writes albedo, normal, roughness and transmission maps; v is 0.5 at the midrib."""
        height = width // 2
        x = self.length * (np.arange(width) + 0.5)[None, :] / width + np.zeros((height, 1))
        y = self.length / 2 * ((np.arange(height) + 0.5)[:, None] / height - 0.5) + np.zeros((1, width))
        across, middle, side_distance, side, inside, along, share = self.veins(x, y)
        spacing = 0.86 * self.length / self.pairs

        # Veins: midrib and secondaries, and two levels of nets between them.
        mesh = 3.4 / spacing
        warp = 0.25 * noise(2 * mesh * x, 2 * mesh * y, seed=self.seed + 9)
        near, second, cell = cells(mesh * along + warp, 1.1 * mesh * y - warp, seed=self.seed)
        fine_near, fine_second, _ = cells(3.1 * mesh * along + 2 * warp, 3.1 * mesh * y, seed=self.seed + 3)
        third = np.exp(-((second - near) / 0.10) ** 2)
        fourth = np.exp(-((fine_second - fine_near) / 0.13) ** 2)
        main = np.maximum(np.exp(-(across / middle) ** 2), inside * np.exp(-(side_distance / side) ** 2))
        vein = np.maximum(main, np.maximum(0.42 * third, 0.20 * fourth))

        # Colors of the blade, veins and rim, and of blots.
        u, v = x / spacing, y / spacing
        patch = fbm(0.9 * u, 0.9 * v, seed=self.seed + 20)
        grain = fbm(40 * u, 40 * v, octaves=3, seed=self.seed + 21)

        mix = np.clip(0.45 + 0.5 * patch + 0.16 * (cell - 0.5) + 0.2 * grain, 0, 1)[..., None]
        color = np.asarray(self.dark) * (1 - mix) + np.asarray(self.base) * mix
        color = color * (1 - 0.6 * vein[..., None]) + 0.6 * vein[..., None] * np.asarray(self.vein)
        rim = smoothstep(0.86, 1.0, share + 0.05 * patch)[..., None]
        color = color * (1 - 0.35 * rim) + 0.35 * rim * np.asarray(self.spot)
        blot_near, blot_second, blot = cells(1.7 * u + 0.4 * patch, 1.7 * v, seed=self.seed + 40)
        size = 0.10 + 0.22 * (blot * 7.3 % 1.0)
        spots = (blot < 0.30 * self.spots) * (1 - smoothstep(0.6, 1.0, (blot_near + 0.12 * grain) / size))
        color = color * (1 - 0.85 * spots[..., None]) + 0.85 * spots[..., None] * np.asarray(self.spot) * \
            (0.5 + 0.5 * smoothstep(0.2, 0.8, blot_near / size))[..., None]
        write_png(folder / f"{name}_albedo.png", encode_srgb(color))

        # Normals, roughness, transmission.
        relief = self.relief(x, y) - 0.010 * spacing * third - 0.004 * spacing * fourth + 0.0016 * spacing * grain
        step = self.length / width
        slope_y, slope_x = np.gradient(relief, step)
        normal = unit(np.stack([-slope_x, -slope_y, np.ones_like(slope_x)], axis=-1))
        write_png(folder / f"{name}_normal.png", 0.5 + 0.5 * normal)

        roughness = np.clip(0.40 + 0.10 * patch + 0.06 * grain + 0.12 * main + 0.10 * spots, 0.2, 0.9)
        write_png(folder / f"{name}_roughness.png", roughness)
        transmission = np.clip(0.62 + 0.12 * patch - 0.38 * main - 0.10 * third - 0.3 * spots, 0.05, 1)
        write_png(folder / f"{name}_transmission.png", transmission)

    def blade(self, midrib, side, rows, columns, fold=0.25, wave=0.05, curl=0.10, twist=0.0):
        """A mesh along a midrib (n, 3), whose length counts as that of the leaf. The upper side is the front.

        fold: slope of the halves; wave, curl: undulation of the edge and its drop, in half widths; twist: radians.
        """
        # The midrib at equal steps.
        s = np.linspace(0, 1, rows)
        x = self.length * s
        arc = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(midrib, axis=0), axis=1))])
        path = np.stack([np.interp(s * arc[-1], arc, midrib[:, i]) for i in range(3)], axis=-1)
        scale = arc[-1] / self.length
        tangent, side, normal = frames(path, side)
        turn = (twist * s)[:, None]
        side, normal = np.cos(turn) * side + np.sin(turn) * normal, np.cos(turn) * normal - np.sin(turn) * side

        # Offsets across the leaf and along its normal.
        t = np.linspace(-1, 1, columns)
        t = np.sign(t) * np.abs(t) ** 0.9
        edge = np.where(t[None] < 0, self.edge_at(x, -1)[:, None], self.edge_at(x, 1)[:, None])
        y = t[None] * edge
        body = (self.width_at(x) / self.half_width)[:, None]
        ripple = np.sin(2 * np.pi * (3.1 * s[:, None] + 0.31 * np.sign(t)[None]) + 1.3 * np.sin(5 * s)[:, None])
        z = self.relief(x[:, None], y) + fold * np.abs(y) * body - curl * body * self.half_width * np.abs(t)[None] ** 6
        z = z + wave * self.half_width * ripple * body * np.abs(t)[None] ** 2.5
        positions = path[:, None] + scale * (y[..., None] * side[:, None] + z[..., None] * normal[:, None])
        uvs = np.stack(np.broadcast_arrays(s[:, None], 0.5 - y / (self.length / 2)), axis=-1)
        return Mesh(positions, grid_faces(rows, columns), uvs)


def bezier(points, count):
    """Points on a Bezier curve of any degree."""
    points = np.asarray(points, dtype=np.float64)
    t = np.linspace(0, 1, count)[:, None]
    while len(points) > 1:
        points = [(1 - t) * a + t * b for a, b in zip(points[:-1], points[1:])]
    return points[0]


def pendant_profile(apex_radius, capillary=0.0744, step=0.0005):
    """Radius and height over the apex of a drop that hangs in equilibrium, up to its neck, by the Young-Laplace
    equation in arc length (Bashforth and Adams 1883). `capillary` is surface tension / (density * gravity), in cm^2."""
    radius, height, angle, widest = 1e-6, 0.0, 0.0, False
    points = [(0.0, 0.0)]
    while not widest or angle > 0.5 * np.pi:
        bend = np.sin(angle) / radius if len(points) > 1 else 1 / apex_radius
        angle += step * (2 / apex_radius - height / capillary - bend)
        radius, height = radius + step * np.cos(angle), height + step * np.sin(angle)
        widest = widest or angle > 0.5 * np.pi
        points.append((radius, height))
    return np.array(points)


def pendant_drop(tail, side, tip_half_width, apex_radius, scale, overlap):
    """A closed surface around the end of a leaf: the profile of a pendant drop, times `scale`, whose neck becomes a
    film around the last `overlap` of the leaf. `tail` (n, 3) is the midrib from the tip upwards."""
    # Radii across the leaf and along its normal, and heights over the apex.
    profile = pendant_profile(apex_radius) * scale
    neck_radius, neck_height = profile[-1]
    keep = np.unique(np.concatenate([np.linspace(0, 60, 13), np.linspace(60, len(profile) - 1, 150)]).astype(int))
    rings = [(r, r, h) for r, h in profile[keep]]
    count = 60
    for i in range(1, count + 1):
        t = i / count
        shrink = (1 - t) ** 2 * (1 + 2 * t)
        film = 0.004 * (1 - t) ** 0.5
        rings.append((neck_radius * shrink + (1 - shrink) * (tip_half_width * (1 + 0.6 * t) + film),
                      neck_radius * shrink + (1 - shrink) * (film + 0.0005), neck_height + overlap * t))
    rings = np.array(rings)

    # Centers: the film follows the leaf, the drop hangs straight below its tip.
    lift = neck_height - 0.05 * overlap
    arc = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(tail, axis=0), axis=1))])
    above = np.maximum(rings[:, 2] - lift, 0)
    centers = np.stack([np.interp(above, arc, tail[:, i]) for i in range(3)], axis=-1)
    centers[:, 1] += np.minimum(rings[:, 2] - lift, 0)
    weight = smoothstep(0, overlap, rings[:, 2] - neck_height)[:, None]
    tangent = unit(np.gradient(centers, axis=0) * weight + (1 - weight) * np.array([[0, 1.0, 0]]))
    side = unit(side - tangent * (tangent @ np.asarray(side))[:, None])
    normal = np.cross(side, tangent)

    sides = 128
    angle = 2 * np.pi * np.arange(sides) / sides
    positions = centers[:, None] + rings[:, 0, None, None] * np.cos(angle)[None, :, None] * side[:, None] + \
        rings[:, 1, None, None] * np.sin(angle)[None, :, None] * normal[:, None]
    faces = grid_faces(len(rings), sides, wrap=True)
    mesh = Mesh(positions, faces)
    outward = np.sum(mesh.normals * (mesh.positions - np.repeat(centers, sides, axis=0)))
    return mesh if outward > 0 else mesh.flipped()


def sessile_drop(sides=28, rings=12, contact=1.25):
    """A drop of contact radius 1 that sits on the plane y = 0: a cap flattened by gravity, closed below the plane."""
    radius = 1 / np.sin(contact)
    angle = np.linspace(0, contact, rings)
    profile = [(radius * np.sin(a), 0.86 * (radius * np.cos(a) - radius * np.cos(contact))) for a in angle]
    profile += [(0.97, -0.08), (0.6, -0.12), (0.0, -0.13)]
    profile = np.array(profile)
    turn = 2 * np.pi * np.arange(sides) / sides
    positions = np.stack(np.broadcast_arrays(profile[:, 0, None] * np.cos(turn), profile[:, 1, None],
                                             profile[:, 0, None] * np.sin(turn)), axis=-1)
    mesh = Mesh(positions, grid_faces(len(profile), sides, wrap=True))
    top = np.sum(mesh.normals * mesh.positions)
    return mesh if top > 0 else mesh.flipped()


def surface_points(mesh, count, rng):
    """Uniform random points on a mesh, and the normals of their faces."""
    a, b, c = (mesh.positions[mesh.faces[:, i]] for i in range(3))
    normals = np.cross(b - a, c - a)
    area = np.linalg.norm(normals, axis=1)
    face = rng.choice(len(area), size=count, p=area / area.sum())
    w = rng.random((2, count))
    w = np.where(w.sum(axis=0) > 1, 1 - w, w)
    return a[face] + w[0][:, None] * (b - a)[face] + w[1][:, None] * (c - a)[face], unit(normals[face])


def droplet_placements(mesh, count, radii, rng, up):
    """Centers, normals and radii of droplets on a mesh, none of which overlap; small ones are more frequent."""
    points, normals = surface_points(mesh, 6 * count, rng)
    normals = np.where((normals @ up)[:, None] < 0, -normals, normals)
    sizes = np.sort(radii[0] * (radii[1] / radii[0]) ** (rng.random(len(points)) ** 2.2))[::-1]
    kept = []
    for i, point in enumerate(points):
        distance = np.linalg.norm(points[kept] - point, axis=1)
        if len(kept) < count and np.all(distance > 1.25 * (sizes[i] + sizes[kept])):
            kept.append(i)
    return points[kept], normals[kept], sizes[kept]
