"""Noise, image files and the textures of make_hourglass.py: wood, brass, paper, cloth and the environment."""

import struct
import zlib

import numpy as np


def lattice(*coordinates, seed=0):
    """Uniform numbers in [0, 1) that depend only on integer coordinates and the seed."""
    start = (seed * 0x9E3779B9 + 0x7F4A7C15) & 0xFFFFFFFF
    h = np.full(np.broadcast(*coordinates).shape or (1,), start, dtype=np.uint32)
    for c in coordinates:
        h = (h ^ np.asarray(c).astype(np.int64).astype(np.uint32)) * np.uint32(0xCC9E2D51)
        h ^= h >> np.uint32(15)
    h *= np.uint32(0x2C1B3C6D)
    h ^= h >> np.uint32(13)
    return (h >> np.uint32(8)).astype(np.float32) * np.float32(2**-24)


def value_noise(*coordinates, seed=0):
    """Value noise with quintic interpolation in any number of dimensions, in [0, 1)."""
    cells = [np.floor(c) for c in coordinates]
    t = [c - cell for c, cell in zip(coordinates, cells)]
    t = [x * x * x * (x * (6 * x - 15) + 10) for x in t]
    total = 0.0
    for corner in range(1 << len(coordinates)):
        bits = [corner >> k & 1 for k in range(len(coordinates))]
        weight = np.prod([x if bit else 1 - x for x, bit in zip(np.broadcast_arrays(*t), bits)], axis=0)
        total = total + weight * lattice(*(cell + bit for cell, bit in zip(cells, bits)), seed=seed)
    return total


def fractal(*coordinates, octaves=4, seed=0):
    """Octaves of value noise with halving amplitude, in [0, 1) with a mean of 1/2."""
    total, weight = 0.0, 0.5
    for octave in range(octaves):
        shifted = [c * 2.03**octave + 17.3 * octave for c in coordinates]
        total = total + weight * value_noise(*shifted, seed=seed + octave)
        weight *= 0.5
    return total / (1 - 0.5**octaves)


def smooth_step(low, high, x):
    t = np.clip((x - low) / (high - low), 0, 1)
    return t * t * (3 - 2 * t)


def mix(t, a, b):
    """Colors from `a` (t = 0) to `b` (t = 1)."""
    t = np.asarray(t, dtype=float)[..., None]
    return a + t * (b - a)


def encoded(color):
    """Linear colors encoded as sRGB."""
    color = np.clip(color, 0, 1)
    return np.where(color <= 0.0031308, 12.92 * color, 1.055 * color**(1 / 2.4) - 0.055)


def write_png(path, values):
    """Writes 8-bit gray (rows x columns) or RGB (rows x columns x 3) from values in [0, 1]."""
    values = np.clip(np.rint(255 * np.asarray(values)), 0, 255).astype(np.uint8)
    height, width = values.shape[:2]
    kind = 2 if values.ndim == 3 else 0
    rows = values.reshape(height, -1)
    raw = np.hstack([np.zeros((height, 1), np.uint8), rows]).tobytes()

    def chunk(name, data):
        body = name + data
        return struct.pack(">I", len(data)) + body + struct.pack(">I", zlib.crc32(body))

    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">2I5B", width, height, 8, kind, 0, 0, 0))
                     + chunk(b"IDAT", zlib.compress(raw, 4)) + chunk(b"IEND", b""))


def write_pfm(path, values):
    """Writes linear RGB as a little-endian PFM file; the first row is the top."""
    height, width = values.shape[:2]
    path.write_bytes(f"PF\n{width} {height}\n-1.0\n".encode() + values[::-1].astype("<f4").tobytes())


def normal_map(heights, texels_per_unit, strength):
    """Normals (n + 1) / 2 of a height field in units of length; u runs along columns, v along rows."""
    dv, du = np.gradient(heights * strength * texels_per_unit)
    normals = np.stack([-du, -dv, np.ones_like(du)], -1)
    return 0.5 + 0.5 * normals / np.linalg.norm(normals, axis=-1, keepdims=True)


KNOTS = [(-31.0, -14.5, 0.9), (13.0, 13.5, 1.0), (-12.0, 8.5, 0.75), (38.0, -4.0, 1.1), (-2.0, -22.0, 0.7)]


def wood(x, z, plank):
    """Ring position, darkness of knots, pores and fibers of planks along x; lengths in cm."""
    # Each plank is cut from a trunk of its own, whose axis is nearly parallel to x
    number = np.floor(z / plank)
    k, local = number * 31.7, z - (number + 0.5) * plank
    center = plank * 1.6 * (lattice(number, seed=3) - 0.5)
    depth = 1.5 + 5 * lattice(number, seed=4) + 0.012 * x * (lattice(number, seed=5) - 0.5) * 4
    bend = 1.6 * (fractal(x * 0.035 + k, local * 0.06, octaves=3, seed=6) - 0.5) * 3
    # Knots bend the fibers around them
    knot = np.zeros_like(x)
    for kx, kz, size in KNOTS:
        across = np.where(number == np.floor(kz / plank), z - kz, 1e3)
        distance = np.hypot((x - kx) / 1.5, across) / size
        angle = np.arctan2(across, x - kx)
        distance = distance * (1 + 0.16 * np.sin(3 * angle + kx) + 0.1 * np.sin(7 * angle))
        bend = bend + 2.2 * size * np.exp(-0.5 * (distance / 1.7)**2) * np.sign(across + 1e-6) * 0.8
        knot = np.maximum(knot, smooth_step(1.25, 0.75, distance) * (0.65 + 0.35 * np.sin(distance * 16)))
    # Annual rings, fibers and pores
    rings = np.hypot(local - center + bend, depth + 0.5 * (fractal(x * 0.05, k, octaves=2, seed=8) - 0.5))
    rings = rings / 0.62 + 0.5 * fractal(x * 0.08 + k, local * 0.9, octaves=4, seed=9)
    fibers = fractal(x * 0.55 + k, z * 14, octaves=3, seed=10)
    pores = smooth_step(0.62, 0.78, value_noise(x * 0.9 + k, z * 26, seed=12) * 0.7 + 0.3 * fibers)
    return rings, knot, pores, fibers, lattice(number, seed=7)


def make_wood(folder, x_range, z_range, plank, texels_per_cm):
    """Writes color, roughness and normals of the table's planks."""
    columns = int((x_range[1] - x_range[0]) * texels_per_cm)
    rows = int((z_range[1] - z_range[0]) * texels_per_cm)
    x = np.linspace(*x_range, columns)[None, :] + np.zeros((rows, 1))
    z = np.linspace(*z_range, rows)[:, None] + np.zeros((1, columns))
    rings, knot, pores, fibers, tint = wood(x, z, plank)
    # Color: dark latewood, pores and knots, and stains
    phase = rings - np.floor(rings)
    late = smooth_step(0.35, 0.92, phase) * smooth_step(1.0, 0.93, phase)
    pores = pores * (0.35 + 0.65 * smooth_step(0.5, 0.1, phase))
    light, dark = np.array([0.40, 0.205, 0.092]), np.array([0.155, 0.066, 0.027])
    color = mix(np.clip(0.75 * late + 0.45 * (fibers - 0.5) + 0.18, 0, 1), light, dark)
    color = mix(0.62 * pores, color, np.array([0.055, 0.024, 0.011]))
    color = mix(0.85 * knot, color, np.array([0.045, 0.018, 0.009]))
    stains = fractal(x * 0.09, z * 0.11, octaves=4, seed=20)
    color = color * (0.72 + 0.5 * tint + 0.35 * (stains - 0.5))[..., None]
    # Wear: scratches and smudges
    scratches = smooth_step(0.80, 0.9, value_noise(x * 0.5 + 0.45 * z, z * 17 - x * 5.1, seed=30))
    scratches = scratches * smooth_step(0.5, 0.7, fractal(x * 0.14, z * 0.14, octaves=2, seed=31))
    smudges = smooth_step(0.4, 0.75, fractal(x * 0.2, z * 0.2, octaves=5, seed=33))
    roughness = 0.36 + 0.14 * smudges + 0.16 * pores + 0.10 * late + 0.10 * knot + 0.12 * scratches
    heights = -0.010 * pores + 0.004 * late + 0.004 * fibers - 0.006 * scratches + 0.004 * knot
    write_png(folder / "wood_color.png", encoded(color * (1 + 0.18 * scratches[..., None])))
    write_png(folder / "wood_roughness.png", roughness)
    write_png(folder / "wood_normal.png", normal_map(heights, texels_per_cm, 0.55))


def make_brass(folder, name, profile, seed, size=(1024, 512)):
    """Writes color and roughness of a turned part: columns run along its profile of (radius, height), rows around.

    Convex edges are polished by touch; grooves keep a dark patina.
    """
    # Find edges and grooves from the curvature of the profile
    steps = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(profile, axis=0), axis=1))])
    position = np.linspace(0, steps[-1], size[0])
    line = np.stack([np.interp(position, steps, profile[:, k]) for k in (0, 1)], -1)
    along = np.gradient(line, axis=0)
    angle = np.unwrap(np.arctan2(along[:, 1], along[:, 0]))
    curvature = np.gradient(angle, position)  # positive where the profile is convex
    window = np.hanning(15) / np.hanning(15).sum()
    curvature = np.convolve(curvature, window, "same")
    edge = smooth_step(0.8, 5.0, curvature)[None, :]
    groove = smooth_step(-0.5, -3.5, curvature)[None, :]
    # Spots, lines of the lathe and dents, periodic around the axis
    s = position[None, :] + np.zeros((size[1], 1))
    t = np.linspace(0, 1, size[1], endpoint=False)[:, None] + np.zeros((1, size[0]))
    c, d = np.cos(2 * np.pi * t) * 3, np.sin(2 * np.pi * t) * 3
    spots = fractal(s * 0.9, c, d, octaves=5, seed=seed)
    broad = fractal(s * 0.3, c * 0.5, d * 0.5, octaves=3, seed=seed + 7)
    lines = value_noise(s * 28, c * 0.4, d * 0.4, seed=seed + 11) - 0.5
    dents = smooth_step(0.78, 0.86, value_noise(s * 5, c * 6, d * 6, seed=seed + 13))
    # Combine them
    patina = np.clip(smooth_step(0.47, 0.60, spots) * 0.62 + 0.95 * groove + 0.9 * (broad - 0.40) - 0.7 * edge, 0, 1)
    patina = np.clip(patina + 0.5 * dents, 0, 1)
    color = mix(patina, np.array([0.80, 0.56, 0.235]), np.array([0.24, 0.125, 0.045]))
    color = mix(0.8 * edge * (0.5 + spots), color, np.array([0.93, 0.74, 0.42]))
    roughness = 0.27 + 0.26 * patina + 0.18 * lines + 0.16 * (broad - 0.5) - 0.09 * edge
    write_png(folder / f"{name}_color.png", encoded(color * (1 + 0.30 * lines[..., None])))
    write_png(folder / f"{name}_roughness.png", np.clip(roughness, 0.12, 0.8))


def make_snow(folder, points, normals):
    """Writes where frost and snow cover the iceberg, and its color, on the grid of the iceberg's vertices."""
    x, y, z = np.moveaxis(points, -1, 0)
    patches = fractal(1.3 * x, 1.3 * y, 1.3 * z, octaves=5, seed=300)
    snow = smooth_step(0.05, 0.55, normals[..., 1] + 1.3 * (patches - 0.5))
    veins = smooth_step(0.10, 0.0, np.abs(fractal(0.9 * x + 0.6 * y, 0.5 * y, 0.9 * z, octaves=3, seed=310) - 0.5))
    cover = np.clip(0.42 + 0.50 * snow - 0.30 * veins, 0, 0.94)
    write_png(folder / "snow_cover.png", cover)
    write_png(folder / "snow_color.png", encoded(mix(snow, np.array([0.50, 0.76, 0.90]), np.array([0.92, 0.94, 0.96]))))


def make_paper(folder):
    """Writes a letter: lines of words in ink on paper of uneven color."""
    rows, columns = 1400, 1000
    y, x = np.mgrid[0:rows, 0:columns].astype(float)
    # Write lines of words
    ink = np.zeros((rows, columns))
    for line in range(26):
        base = 150 + 44 * line + 3 * np.sin(x / 130 + line)
        words = value_noise(x / 26, np.full_like(x, line * 7.7), seed=41)
        end = columns - 90 - 380 * (line in (8, 17, 25)) - 60 * lattice(np.array(line), seed=42)
        inside = (x > 90 + 40 * (line in (0, 9, 18))) & (x < end) & (words > 0.28)
        stroke = base + 9 * (value_noise(x / 4.3, np.full_like(x, line), seed=43) - 0.5) * 2.2
        stroke = stroke - 12 * smooth_step(0.66, 0.8, value_noise(x / 7, np.full_like(x, line), seed=44))
        ink = np.maximum(ink, inside * smooth_step(2.6, 0.9, np.abs(y - stroke)))
    # Darken the paper towards its edges
    tone = 0.86 + 0.09 * (fractal(x / 240, y / 240, octaves=5, seed=45) - 0.5)
    edge = np.minimum(np.minimum(x, columns - x), np.minimum(y, rows - y))
    tone = tone - 0.12 * smooth_step(90, 0, edge + 60 * fractal(x / 60, y / 60, octaves=3, seed=46) - 30)
    paper = tone[..., None] * np.array([0.88, 0.82, 0.68])
    write_png(folder / "paper_color.png", encoded(mix(0.88 * ink, paper, np.array([0.03, 0.035, 0.09]))))


def make_book(folder):
    """Writes the cloth cover of the book, with a frame stamped in gold, and the layered edge of its pages."""
    rows, columns = 900, 640
    y, x = np.mgrid[0:rows, 0:columns].astype(float)
    # Cloth, worn at the edges
    weave = 0.5 * np.sin(x * 1.9) * np.sin(y * 1.9) + 0.6 * (fractal(x / 3, y / 3, octaves=2, seed=50) - 0.5)
    edge = np.minimum(np.minimum(x, columns - x), np.minimum(y, rows - y))
    wear = smooth_step(34, 0, edge + 26 * (fractal(x / 30, y / 30, octaves=4, seed=51) - 0.5))
    color = np.array([0.012, 0.045, 0.075]) * (1 + 0.35 * weave + 0.5 * fractal(x / 150, y / 150, seed=52))[..., None]
    color = mix(0.55 * wear, color, np.array([0.30, 0.27, 0.22]))
    # A frame and an hourglass in gold
    gold = (np.abs(edge - 52) < 4) | (np.abs(edge - 68) < 1.6)
    radius = np.hypot(x - columns / 2, y - rows / 2)
    gold |= (np.abs(radius - 95) < 4) | ((radius < 78) & (np.abs(x - columns / 2) < 0.55 * np.abs(y - rows / 2) + 3))
    gold = gold & (fractal(x / 9, y / 9, octaves=3, seed=53) > 0.36)
    write_png(folder / "book_color.png", encoded(mix(gold.astype(float), color, np.array([0.80, 0.55, 0.22]))))
    write_png(folder / "book_metal.png", 0.9 * gold)
    # The edges of the pages
    sheets = value_noise(y[:, :64] / 1.7, x[:, :64] / 300, seed=54)
    pages = (0.55 + 0.45 * sheets)[..., None] * np.array([0.74, 0.66, 0.50])
    write_png(folder / "pages_color.png", encoded(pages))


def make_environment(path, sun, height=512):
    """Writes the view from the window (towards -z) and, behind the camera, the dim room with two other windows."""
    width = 2 * height
    v, u = np.meshgrid((np.arange(height) + 0.5) / height, (np.arange(width) + 0.5) / width, indexing="ij")
    sine = np.sin(np.pi * v)
    direction = np.stack([sine * np.sin(2 * np.pi * u), np.cos(np.pi * v), -sine * np.cos(2 * np.pi * u)], -1)
    x, y, z = np.moveaxis(direction, -1, 0)
    # Sky with a glow around the sun
    near_sun = np.clip(direction @ (np.asarray(sun) / np.linalg.norm(sun)), -1, 1)
    elevation = np.degrees(np.arcsin(y))
    clouds = fractal(4.5 * x, 13.0 * y, 4.5 * z, octaves=6, seed=60)
    veils = fractal(1.6 * x + 5, 14.0 * y, 1.6 * z, octaves=5, seed=70)
    sky = mix(smooth_step(-7, 14, elevation), np.array([0.78, 0.42, 0.22]), np.array([0.16, 0.23, 0.36]))
    glow = np.exp(-(1 - near_sun) * 9)[..., None] * np.array([1.15, 0.62, 0.27])
    sky = sky + glow
    # Clouds, bright at their edges near the sun
    shade = mix(smooth_step(-4, 25, elevation), np.array([0.17, 0.12, 0.125]), np.array([0.055, 0.07, 0.105]))
    cover = smooth_step(0.47, 0.66, 0.7 * clouds + 0.3 * veils)
    lining = smooth_step(0.0, 0.5, cover) * smooth_step(1.0, 0.5, cover)
    sky = mix(0.82 * cover, sky, shade) + 0.5 * lining[..., None] * glow
    # Hills at the horizon, and the core of the glow
    hills = -4.5 + 3.0 * fractal(4 * x, 4 * z, octaves=5, seed=80)
    haze = np.array([0.11, 0.10, 0.125]) * (0.7 + 0.5 * np.exp(-(1 - near_sun) * 4))[..., None]
    sky = mix(smooth_step(0.6, -0.6, elevation - hills), sky, haze)
    core = np.exp(-(np.degrees(np.arccos(near_sun)) / 11)**2)
    sky = sky + core[..., None] * np.array([17, 10.2, 4.6])
    # The room
    room = np.array([0.13, 0.105, 0.085]) * (0.55 + 0.9 * smooth_step(-0.5, 0.8, y))[..., None]
    room = room + soft_box(direction, (-0.93, 0.42, 0.40), 0.36, 0.48, 4.4)[..., None] * np.array([0.72, 0.95, 1.25])
    room = room + soft_box(direction, (0.95, 0.25, 0.35), 0.16, 0.30, 1.1)[..., None] * np.array([1.2, 0.92, 0.62])
    write_pfm(path, mix(smooth_step(-0.04, 0.04, z), sky, room))


def soft_box(direction, center, half_width, half_height, radiance):
    """A window with two mullions, as seen on the sphere of directions."""
    n = np.asarray(center) / np.linalg.norm(center)
    side = np.cross((0, 1, 0), n)
    side /= np.linalg.norm(side)
    up = np.cross(n, side)
    depth = direction @ n
    safe = np.where(depth > 0.05, depth, 1)
    a, b = direction @ side / safe, direction @ up / safe
    inside = smooth_step(half_width, 0.94 * half_width, np.abs(a))
    inside = inside * smooth_step(half_height, 0.94 * half_height, np.abs(b))
    bars = smooth_step(0.012, 0.02, np.abs(a)) * smooth_step(0.012, 0.02, np.abs(b - 0.1))
    return np.where(depth > 0.05, radiance * inside * bars, 0)
