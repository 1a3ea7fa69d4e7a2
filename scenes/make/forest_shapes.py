"""Noise, meshes and image files for the scripts that write scenes/forest. Needs numpy."""

import struct
import zlib

import numpy as np


def hash01(*cells, seed=0):
    """Pseudo-random numbers in [0, 1) of integer lattice points."""
    shape = np.broadcast(*cells).shape
    h = np.full(shape or (1,), (seed * 0x9E3779B1) & 0xFFFFFFFF, dtype=np.uint32)
    for i, cell in enumerate(cells):
        h = (h ^ np.asarray(cell).astype(np.int32).view(np.uint32)) * np.uint32(0x85EBCA6B + 2 * i)
        h ^= h >> np.uint32(15)
        h *= np.uint32(0xC2B2AE35)
        h ^= h >> np.uint32(13)
    return h.reshape(shape).astype(np.float64) / 2**32


def noise(*x, seed=0):
    """Value noise in [-1, 1] over coordinates of 1 to 3 dimensions with cells of size 1."""
    x = np.broadcast_arrays(*[np.asarray(c, dtype=np.float64) for c in x])
    cell = [np.floor(c) for c in x]
    weight = [c - f for c, f in zip(x, cell)]
    weight = [w * w * w * (w * (6 * w - 15) + 10) for w in weight]
    total = 0.0
    for corner in range(1 << len(x)):
        bits = [corner >> i & 1 for i in range(len(x))]
        factor = 1.0
        for w, b in zip(weight, bits):
            factor = factor * (w if b else 1 - w)
        total = total + factor * hash01(*[f + b for f, b in zip(cell, bits)], seed=seed)
    return 2 * total - 1


def fbm(*x, octaves=4, gain=0.5, seed=0):
    """Sum of octaves of noise, roughly in [-1, 1]."""
    total, norm = 0.0, 0.0
    for i in range(octaves):
        total = total + gain**i * noise(*[np.asarray(c) * 2.03**i + 17.3 * i for c in x], seed=seed + 31 * i)
        norm += gain**i
    return total / norm


def cells(x, y, seed=0):
    """Distances to the nearest and the second nearest point of a jittered grid, and a random number of the nearest."""
    column, row = np.floor(x), np.floor(y)
    nearest = np.full(np.shape(x), 9.0)
    second, identity = nearest.copy(), np.zeros(np.shape(x))
    for i in (-1, 0, 1):
        for j in (-1, 0, 1):
            c, r = column + i, row + j
            px, py = c + 0.1 + 0.8 * hash01(c, r, seed=seed), r + 0.1 + 0.8 * hash01(c, r, seed=seed + 1)
            distance = np.hypot(px - x, py - y)
            closer = distance < nearest
            second = np.where(closer, nearest, np.minimum(second, distance))
            identity = np.where(closer, hash01(c, r, seed=seed + 2), identity)
            nearest = np.minimum(nearest, distance)
    return nearest, second, identity


def smoothstep(low, high, x):
    t = np.clip((x - low) / (high - low), 0, 1)
    return t * t * (3 - 2 * t)


def unit(v):
    return v / np.maximum(np.linalg.norm(v, axis=-1, keepdims=True), 1e-12)


class Mesh:
    """Triangles with positions, and with normals, texture coordinates and linear colors of vertices if given."""

    def __init__(self, positions, faces, uvs=None, colors=None, normals=None):
        self.positions = np.asarray(positions, dtype=np.float64).reshape(-1, 3)
        self.faces = np.asarray(faces, dtype=np.int64).reshape(-1, 3)
        count = len(self.positions)
        self.uvs = None if uvs is None else np.asarray(uvs, dtype=np.float64).reshape(-1, 2)
        self.colors = None if colors is None else np.broadcast_to(np.asarray(colors, dtype=np.float64), (count, 3))
        self.normals = self.smooth_normals() if normals is None else np.asarray(normals).reshape(-1, 3)

    def smooth_normals(self):
        """Normals averaged over adjacent faces by area."""
        a, b, c = (self.positions[self.faces[:, i]] for i in range(3))
        normal = np.cross(b - a, c - a)
        count = len(self.positions)
        sums = np.stack([sum(np.bincount(self.faces[:, i], normal[:, axis], count) for i in range(3))
                         for axis in range(3)], axis=-1)
        return unit(sums)

    def areas(self):
        a, b, c = (self.positions[self.faces[:, i]] for i in range(3))
        return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)

    def moved(self, rotation=None, scale=1.0, offset=(0, 0, 0)):
        rotation = np.eye(3) if rotation is None else rotation
        positions = self.positions * scale @ np.transpose(rotation) + np.asarray(offset)
        return Mesh(positions, self.faces, self.uvs, self.colors, self.normals @ np.transpose(rotation))

    def colored(self, colors):
        return Mesh(self.positions, self.faces, self.uvs, colors, self.normals)

    def flipped(self):
        return Mesh(self.positions, self.faces[:, ::-1], self.uvs, self.colors, -self.normals)

    def write(self, path):
        """Writes a binary PLY file. Colors become the attribute vertex_color."""
        columns = [self.positions, self.normals]
        names = ["x", "y", "z", "nx", "ny", "nz"]
        for values, more in ((self.uvs, ["u", "v"]), (self.colors, ["r", "g", "b"])):
            if values is not None:
                columns.append(values)
                names += more
        faces = self.faces[self.areas() > 1e-14]
        header = ["ply", "format binary_little_endian 1.0", "comment written by scenes/make/make_forest.py",
                  f"element vertex {len(self.positions)}"] + [f"property float {name}" for name in names]
        header += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header"]
        rows = np.zeros(len(faces), dtype=[("count", "u1"), ("indices", "<i4", 3)])
        rows["count"], rows["indices"] = 3, faces
        path.parent.mkdir(parents=True, exist_ok=True)
        with open(path, "wb") as out:
            out.write(("\n".join(header) + "\n").encode())
            out.write(np.hstack(columns).astype("<f4").tobytes())
            out.write(rows.tobytes())


def joined(meshes):
    """One mesh of several that have the same attributes."""
    starts = np.cumsum([0] + [len(m.positions) for m in meshes[:-1]])

    def stack(name):
        parts = [getattr(m, name) for m in meshes]
        return None if any(p is None for p in parts) else np.vstack(parts)

    return Mesh(stack("positions"), np.vstack([m.faces + s for m, s in zip(meshes, starts)]), stack("uvs"),
                stack("colors"), stack("normals"))


def copies(mesh, rotations, offsets, colors=None):
    """One mesh of many copies: rotations (n, 3, 3) may scale; colors (n, 3) multiply those of the mesh."""
    count, size = len(offsets), len(mesh.positions)
    positions = np.einsum("nij,vj->nvi", rotations, mesh.positions) + np.asarray(offsets)[:, None, :]
    normals = unit(np.einsum("nij,vj->nvi", rotations, mesh.normals))
    faces = mesh.faces[None] + (np.arange(count) * size)[:, None, None]
    shade = None if mesh.colors is None else mesh.colors[None] * (
        np.ones((count, 1, 3)) if colors is None else np.asarray(colors)[:, None, :])
    uvs = None if mesh.uvs is None else np.tile(mesh.uvs, (count, 1))
    return Mesh(positions, faces, uvs, None if shade is None else shade.reshape(-1, 3), normals)


def grid_faces(rows, columns, wrap=False):
    """Triangles of a grid of vertices; row i + 1 lies to the left of the direction in which columns grow."""
    i, j = np.meshgrid(np.arange(rows - 1), np.arange(columns if wrap else columns - 1), indexing="ij")
    a, b = i * columns + j, i * columns + (j + 1) % columns
    c, d = a + columns, b + columns
    return np.stack([np.stack([a, b, d], -1), np.stack([a, d, c], -1)], axis=-2).reshape(-1, 3)


def frames(path, side):
    """Unit tangents, sides and normals along a path (n, 3), with sides close to the vector `side`."""
    tangent = unit(np.gradient(path, axis=0))
    side = np.broadcast_to(np.asarray(side, dtype=np.float64), path.shape)
    side = unit(side - tangent * np.sum(side * tangent, axis=-1, keepdims=True))
    return tangent, side, np.cross(side, tangent)


def tube(path, radii, sides=8, color=(1, 1, 1)):
    """A tube around a path, without caps. Rows have `sides` vertices."""
    path = np.asarray(path, dtype=np.float64)
    main = unit(path[-1] - path[0])
    helper = (1, 0, 0) if abs(main[0]) < 0.7 else (0, 0, 1)
    _, side, normal = frames(path, helper)
    angle = 2 * np.pi * np.arange(sides) / sides
    radii = np.broadcast_to(np.asarray(radii, dtype=np.float64), (len(path),))
    ring = np.cos(angle)[None, :, None] * side[:, None] + np.sin(angle)[None, :, None] * normal[:, None]
    positions = path[:, None] + radii[:, None, None] * ring
    mesh = Mesh(positions, grid_faces(len(path), sides, wrap=True), None, color)
    outward = np.sum(mesh.normals * ring.reshape(-1, 3))
    return mesh if outward > 0 else mesh.flipped()


def strip(path, side, half_widths, fold=0.2, color=(1, 1, 1), columns=3):
    """A blade along a path: `columns` vertices across, folded along the middle by `fold` of the half width."""
    path = np.asarray(path, dtype=np.float64)
    _, side, normal = frames(path, side)
    across = np.linspace(-1, 1, columns)
    half = np.broadcast_to(np.asarray(half_widths), (len(path),))[:, None, None]
    positions = path[:, None] + half * (across[None, :, None] * side[:, None] +
                                        fold * np.abs(across)[None, :, None] * normal[:, None])
    color = np.asarray(color, dtype=np.float64)
    colors = np.repeat(color, columns, axis=0) if color.ndim == 2 else color
    uvs = np.stack(np.broadcast_arrays(np.linspace(0, 1, len(path))[:, None], 0.5 - 0.5 * across[None]), -1)
    return Mesh(positions, grid_faces(len(path), columns), uvs, colors)


def icosphere(steps):
    """A sphere of 20 * 4^steps triangles as directions and faces."""
    t = (1 + 5**0.5) / 2
    points = [(-1, t, 0), (1, t, 0), (-1, -t, 0), (1, -t, 0), (0, -1, t), (0, 1, t), (0, -1, -t), (0, 1, -t),
              (t, 0, -1), (t, 0, 1), (-t, 0, -1), (-t, 0, 1)]
    faces = np.array([(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2),
                      (10, 7, 6), (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5),
                      (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1)])
    points = unit(np.array(points, dtype=np.float64))
    for _ in range(steps):
        edges = np.sort(np.vstack([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
        unique, inverse = np.unique(edges, axis=0, return_inverse=True)
        a, b, c = (len(points) + inverse.reshape(3, -1))
        points = np.vstack([points, unit(points[unique[:, 0]] + points[unique[:, 1]])])
        x, y, z = faces.T
        faces = np.vstack([np.stack(f, -1) for f in ((x, a, c), (a, y, b), (c, b, z), (a, b, c))])
    return points, faces


def rotation(axis, angle):
    """Rotation matrix around a unit axis by an angle in radians."""
    x, y, z = axis
    skew = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]], dtype=np.float64)
    return np.eye(3) + np.sin(angle) * skew + (1 - np.cos(angle)) * skew @ skew


def aligned(directions, spins):
    """Rotations (n, 3, 3) that turn +y to unit directions after a spin around +y by angles in radians."""
    y = unit(np.asarray(directions, dtype=np.float64))
    helper = np.where(np.abs(y[:, :1]) < 0.9, [[1.0, 0, 0]], [[0, 0, 1.0]])
    x = unit(np.cross(y, np.cross(helper, y)))
    z = np.cross(x, y)
    c, s = np.cos(spins)[:, None], np.sin(spins)[:, None]
    return np.stack([c * x - s * z, y, s * x + c * z], axis=-1)


def encode_srgb(x):
    x = np.clip(x, 0, 1)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)


def write_png(path, image):
    """Writes 8-bit RGB or gray from values in [0, 1], shape (height, width[, 3]), first row at the top."""
    pixels = np.round(255 * np.clip(image, 0, 1)).astype(np.uint8)
    height, width = pixels.shape[:2]
    raw = np.hstack([np.zeros((height, 1), np.uint8), pixels.reshape(height, -1)]).tobytes()

    def chunk(kind, data):
        body = kind + data
        return struct.pack(">I", len(data)) + body + struct.pack(">I", zlib.crc32(body))

    path.parent.mkdir(parents=True, exist_ok=True)
    kind = 2 if pixels.ndim == 3 else 0
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">2I5B", width, height, 8, kind, 0, 0, 0)) +
                     chunk(b"IDAT", zlib.compress(raw, 6)) + chunk(b"IEND", b""))


def write_hdr(path, image):
    """Writes linear RGB as a Radiance file, first row at the top."""
    image = np.maximum(image, 0)
    mantissa, exponent = np.frexp(np.max(image, axis=-1))
    scale = np.where(mantissa > 0, 256 * np.ldexp(1.0, -exponent), 0)
    pixels = np.dstack([np.minimum(image * scale[..., None], 255), exponent + 128]).astype(np.uint8)
    path.parent.mkdir(parents=True, exist_ok=True)
    header = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n" % image.shape[:2]
    path.write_bytes(header + pixels.tobytes())
