"""Meshes as numpy arrays for make_hourglass.py: surfaces of revolution, beveled boxes, grids, and PLY files."""

import numpy as np


class Mesh:
    """Triangles with a normal and texture coordinates per vertex."""

    def __init__(self, positions, normals, uvs, triangles):
        self.positions = np.asarray(positions, dtype=float).reshape(-1, 3)
        self.normals = np.asarray(normals, dtype=float).reshape(-1, 3)
        self.uvs = np.asarray(uvs, dtype=float).reshape(-1, 2)
        self.triangles = np.asarray(triangles, dtype=int).reshape(-1, 3)

    def moved(self, offset):
        return Mesh(self.positions + np.asarray(offset, dtype=float), self.normals, self.uvs, self.triangles)

    def turned(self, axis, degrees):
        """Rotates about a coordinate axis (0, 1 or 2) through the origin."""
        c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
        matrix = np.eye(3)
        i, j = (axis + 1) % 3, (axis + 2) % 3
        matrix[i, i], matrix[i, j], matrix[j, i], matrix[j, j] = c, -s, s, c
        return Mesh(self.positions @ matrix.T, self.normals @ matrix.T, self.uvs, self.triangles)

    def flipped(self):
        """The same surface with its normals and its orientation reversed."""
        return Mesh(self.positions, -self.normals, self.uvs, self.triangles[:, ::-1])

    def smoothed(self):
        """Replaces the normals by the mean of the triangles around each position, weighted by area."""
        a, b, c = (self.positions[self.triangles[:, k]] for k in range(3))
        faces = np.cross(b - a, c - a)
        places, place = np.unique(self.positions.round(7) + 0.0, axis=0, return_inverse=True)
        sums = np.zeros_like(places)
        for k in range(3):
            np.add.at(sums, place.ravel()[self.triangles[:, k]], faces)
        return Mesh(self.positions, unit(sums)[place.ravel()], self.uvs, self.triangles)

    def agreeing(self):
        """Tilts the normals of vertices towards triangles that face away from the sum of their normals. Readers would
        flip such triangles."""
        a, b, c = (self.positions[self.triangles[:, k]] for k in range(3))
        faces = unit(np.cross(b - a, c - a))
        normals = self.normals.copy()
        for _ in range(100):
            away = np.sum(faces * normals[self.triangles].sum(axis=1), axis=1) < 0.01
            away &= np.linalg.norm(faces, axis=1) > 0.5  # not degenerate
            if not away.any():
                break
            for k in range(3):
                np.add.at(normals, self.triangles[away, k], 0.2 * faces[away])
            normals = unit(normals)
        return Mesh(self.positions, normals, self.uvs, self.triangles)

    def write(self, path):
        """Writes a binary PLY file with normals and texture coordinates, without degenerate triangles."""
        positions = self.positions.astype("<f4").astype(float)
        a, b, c = (positions[self.triangles[:, k]] for k in range(3))
        triangles = self.triangles[np.linalg.norm(np.cross(b - a, c - a), axis=1) > 1e-12]
        names = ["x", "y", "z", "nx", "ny", "nz", "u", "v"]
        header = ["ply", "format binary_little_endian 1.0", "comment written by scenes/make/make_hourglass.py",
                  f"element vertex {len(self.positions)}", *(f"property float {name}" for name in names),
                  f"element face {len(triangles)}", "property list uchar int vertex_indices", "end_header"]
        faces = np.zeros(len(triangles), dtype=[("count", "u1"), ("indices", "<i4", 3)])
        faces["count"], faces["indices"] = 3, triangles
        with open(path, "wb") as file:
            file.write(("\n".join(header) + "\n").encode())
            file.write((np.hstack([self.positions, self.normals, self.uvs]) + 0.0).astype("<f4").tobytes())  # no -0
            file.write(faces.tobytes())


def unit(vectors):
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-20)


def merged(meshes):
    offsets = np.cumsum([0] + [len(m.positions) for m in meshes])
    return Mesh(np.vstack([m.positions for m in meshes]), np.vstack([m.normals for m in meshes]),
                np.vstack([m.uvs for m in meshes]),
                np.vstack([m.triangles + start for m, start in zip(meshes, offsets)]))


def grid_triangles(rows, columns):
    """Triangles of a grid of vertices, counter-clockwise where columns run to the right and rows run up."""
    i, j = np.meshgrid(np.arange(rows - 1), np.arange(columns - 1), indexing="ij")
    a = (i * columns + j).ravel()
    b, c, d = a + 1, a + columns, a + columns + 1
    return np.concatenate([np.stack([a, b, d], 1), np.stack([a, d, c], 1)])


def surface(positions):
    """A smooth mesh through a grid of points of shape (rows, columns, 3)."""
    rows, columns = positions.shape[:2]
    v, u = np.meshgrid(np.linspace(0, 1, rows), np.linspace(0, 1, columns), indexing="ij")
    flat = positions.reshape(-1, 3)
    return Mesh(flat, flat, np.stack([u, v], -1), grid_triangles(rows, columns)).smoothed()


def spline(points, steps):
    """Points of the Catmull-Rom spline (Catmull and Rom 1974) through `points`, with `steps` points per segment."""
    points = np.asarray(points, dtype=float)
    padded = np.vstack([2 * points[0] - points[1], points, 2 * points[-1] - points[-2]])
    t = (np.arange(steps) / steps)[:, None]
    out = []
    for p0, p1, p2, p3 in zip(padded, padded[1:], padded[2:], padded[3:]):
        out.append(0.5 * (2 * p1 + t * (p2 - p0) + t**2 * (2 * p0 - 5 * p1 + 4 * p2 - p3)
                          + t**3 * (3 * p1 - p0 - 3 * p2 + p3)))
    return np.vstack([*out, points[-1:]])


def rounded(points, radius, steps=6):
    """Replaces the inner corners of a polyline by quadratic Bezier curves that start `radius` from the corner."""
    points = np.asarray(points, dtype=float)
    out = [points[:1]]
    t = np.linspace(0, 1, steps)[:, None]
    for before, corner, after in zip(points, points[1:], points[2:]):
        a, b = before - corner, after - corner
        a *= min(radius / np.linalg.norm(a), 0.45)
        b *= min(radius / np.linalg.norm(b), 0.45)
        out.append(corner + (1 - t)**2 * a + t**2 * b)
    return np.vstack([*out, points[-1:]])


def profile_normals(profile):
    """Normals of a profile of (radius, height), to the right of its direction: outwards where it runs upwards."""
    along = np.gradient(profile, axis=0)
    if profile[0, 0] < 1e-9:
        along[0] = (1, 0)
    if profile[-1, 0] < 1e-9:
        along[-1] = (-1, 0)
    return unit(np.stack([along[:, 1], -along[:, 0]], -1))


def revolved(profile, sides, normals=None):
    """Revolves a profile of (radius, height) about the y axis. u runs along the profile, v around the axis."""
    profile = np.asarray(profile, dtype=float)
    normals = profile_normals(profile) if normals is None else normals
    steps = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(profile, axis=0), axis=1))])
    angle = np.linspace(0, 2 * np.pi, sides + 1)
    c, s = np.cos(angle)[None, :], np.sin(angle)[None, :]
    c[0, -1], s[0, -1] = c[0, 0], s[0, 0]

    def around(values):
        radius, height = values[:, 0:1], values[:, 1:2]
        return np.stack([radius * c, np.broadcast_to(height, (len(values), sides + 1)), -radius * s], -1)

    u, v = np.meshgrid(steps / steps[-1], np.linspace(0, 1, sides + 1), indexing="ij")
    return Mesh(around(profile), around(normals), np.stack([u, v], -1), grid_triangles(len(profile), sides + 1))


def box(low, high, bevel=0.0):
    """A box with beveled edges that shade smoothly. uv are the two coordinates along each face."""
    low, high = np.asarray(low, dtype=float), np.asarray(high, dtype=float)
    positions, normals, uvs, faces = [], [], [], []
    # Each corner has a vertex on each of its three faces, at 8 * axis + the corner's bits
    for axis in range(3):
        for corner in np.ndindex(2, 2, 2):
            p = np.where(corner, high - bevel, low + bevel)
            p[axis] = (low, high)[corner[axis]][axis]
            positions.append(p)
            normals.append((2 * corner[axis] - 1) * np.eye(3)[axis])
            uvs.append(p[list(((2, 1), (0, 2), (0, 1))[axis])])

    def vertex(face, axis, along, side_i, side_j):
        """The vertex on the face of axis `face` at a corner given by its sides along `axis` and the next two axes."""
        bits = {axis: along, (axis + 1) % 3: side_i, (axis + 2) % 3: side_j}
        return 8 * face + 4 * bits[0] + 2 * bits[1] + bits[2]

    for axis in range(3):
        i, j = (axis + 1) % 3, (axis + 2) % 3
        for side in (0, 1):
            faces.append([vertex(axis, axis, side, *ab) for ab in ((0, 0), (1, 0), (1, 1), (0, 1))])
        for ab in np.ndindex(2, 2):
            faces.append([vertex(face, axis, end, *ab) for face, end in ((i, 0), (i, 1), (j, 1), (j, 0))])
    triangles = [t for q in faces for t in ((q[0], q[1], q[2]), (q[0], q[2], q[3]))]
    triangles += [(corner, 8 + corner, 16 + corner) for corner in range(8)]
    return oriented(Mesh(positions, normals, uvs, triangles), 0.5 * (low + high))


def oriented(mesh, center):
    """Turns all triangles so that they face away from `center`; drops degenerate ones."""
    a, b, c = (mesh.positions[mesh.triangles[:, k]] for k in range(3))
    faces = np.cross(b - a, c - a)
    inwards = np.einsum("ij,ij->i", faces, (a + b + c) / 3 - center) < 0
    triangles = np.where(inwards[:, None], mesh.triangles[:, ::-1], mesh.triangles)
    mesh.triangles = triangles[np.linalg.norm(faces, axis=1) > 1e-14]
    return mesh


def quads(corners, normals):
    """Separate quads: corners of shape (count, 4, 3), one normal per quad."""
    corners = np.asarray(corners, dtype=float).reshape(-1, 4, 3)
    count = len(corners)
    uvs = np.tile([(0, 0), (1, 0), (1, 1), (0, 1)], (count, 1))
    first = 4 * np.arange(count)[:, None]
    triangles = np.concatenate([first + [0, 1, 2], first + [0, 2, 3]])
    return Mesh(corners, np.repeat(np.asarray(normals, dtype=float), 4, axis=0), uvs, triangles)
