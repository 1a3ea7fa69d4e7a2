"""Triangle meshes of the twin scenes, as pairs of vertices (n x 3) and triangles (m x 3), and matrices to place them.

All meshes are flat-shaded, so that renderers need not agree on shading normals. z is up."""

import numpy as np


def lattice(points, is_closed=False):
    """Triangles between the rows of an array of points (rows x columns x 3). `is_closed`: the last column is joined to
    the first one. Triangles without area, as at poles, are left out."""
    rows, columns = points.shape[:2]
    index = np.arange(rows * columns).reshape(rows, columns)
    if is_closed:
        index = np.concatenate([index, index[:, :1]], axis=1)
    a, b, c, d = (part.ravel() for part in (index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]))
    triangles = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    vertices = points.reshape(-1, 3)
    p, q, r = (vertices[triangles[:, k]] for k in range(3))
    return vertices, triangles[np.linalg.norm(np.cross(q - p, r - p), axis=1) > 1e-12]


def outward(mesh):
    """The mesh with its triangles turned such that a closed one has normals pointing out of it."""
    vertices, triangles = mesh
    p, q, r = (vertices[triangles[:, k]] for k in range(3))
    return (vertices, triangles[:, ::-1]) if np.sum(p * np.cross(q, r)) < 0 else mesh


def quad(center, u, v):
    """A parallelogram with half edges u and v and the normal u x v."""
    center, u, v = (np.asarray(x, float) for x in (center, u, v))
    return np.array([center - u - v, center + u - v, center + u + v, center - u + v]), np.array([[0, 1, 2], [0, 2, 3]])


def prism(outline, bottom, top):
    """A solid above a star-shaped outline (n x 2, counterclockwise), closed by fans around the mean of its points."""
    outline = np.asarray(outline, float)
    middle = np.broadcast_to(outline.mean(axis=0), outline.shape)
    rings = [(middle, bottom), (outline, bottom), (outline, top), (middle, top)]
    return outward(lattice(np.array([np.column_stack([ring, np.full(len(ring), z)]) for ring, z in rings]), True))


def box(low, high):
    (x0, y0, z0), (x1, y1, z1) = low, high
    return prism([(x0, y0), (x1, y0), (x1, y1), (x0, y1)], z0, z1)


def revolved(profile, sides=96):
    """A surface of revolution about z. `profile`: radii and heights."""
    radius, height = np.asarray(profile, float).T
    angle = 2 * np.pi * np.arange(sides) / sides
    points = np.stack([np.outer(radius, np.cos(angle)), np.outer(radius, np.sin(angle)),
                       np.repeat(height[:, None], sides, 1)], axis=-1)
    return outward(lattice(points, True))


def rounded(profile, rounds=4):
    """A profile with its corners cut by Chaikin's algorithm; its ends stay."""
    profile = np.asarray(profile, float)
    for _ in range(rounds):
        a, b = profile[:-1], profile[1:]
        inner = np.stack([0.75 * a + 0.25 * b, 0.25 * a + 0.75 * b], axis=1).reshape(-1, 2)
        profile = np.concatenate([profile[:1], inner, profile[-1:]])
    return profile


def tube(path, radius, sides=12):
    """A tube with open ends around a path (n x 3). `radius`: one or n of them. The path may not turn vertical."""
    path = np.asarray(path, float)
    along = np.gradient(path, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    side = np.cross(along, [0, 0, 1])
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    up = np.cross(side, along)
    angle = 2 * np.pi * np.arange(sides) / sides
    offset = side[:, None] * np.cos(angle)[None, :, None] + up[:, None] * np.sin(angle)[None, :, None]
    return outward(lattice(path[:, None] + offset * np.reshape(radius, (-1, 1, 1)), True))


def merged(*meshes):
    counts = np.cumsum([0, *(len(vertices) for vertices, _ in meshes)])
    return (np.concatenate([vertices for vertices, _ in meshes]),
            np.concatenate([triangles + first for (_, triangles), first in zip(meshes, counts)]))


def placed(mesh, *matrices):
    """The mesh transformed by the product of 4 x 4 matrices, whose determinant is positive."""
    matrix = product(*matrices)
    return mesh[0] @ matrix[:3, :3].T + matrix[:3, 3], mesh[1]


def product(*matrices):
    result = np.eye(4)
    for matrix in matrices:
        result = result @ matrix
    return result


def shift(x, y, z=0.0):
    matrix = np.eye(4)
    matrix[:3, 3] = x, y, z
    return matrix


def scale(factor):
    return np.diag([factor, factor, factor, 1.0])


def turn(axis, degrees):
    """A rotation about an axis of coordinates: "x", "y" or "z"."""
    i = "xyz".index(axis)
    j, k = (i + 1) % 3, (i + 2) % 3
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    matrix = np.eye(4)
    matrix[j, j], matrix[j, k], matrix[k, j], matrix[k, k] = c, -s, s, c
    return matrix


def waves(seed, count, shortest, longest):
    """A smooth random function of points (n x 2) with values in about [-1, 1]: a sum of sines of these wavelengths."""
    random = np.random.default_rng(seed)
    length = np.exp(random.uniform(np.log(shortest), np.log(longest), count))
    angle, phase = random.uniform(0, 2 * np.pi, (2, count))
    vectors = 2 * np.pi / length * np.stack([np.cos(angle), np.sin(angle)])
    return lambda points: np.sin(points @ vectors + phase) @ length / np.sqrt(0.5 * np.sum(length**2)) / 2
