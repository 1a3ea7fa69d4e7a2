"""Affine transforms."""

import numpy as np

from .errors import UsageError


def _vector(value, what: str) -> np.ndarray:
    vector = np.asarray(value, dtype=np.float64)
    if vector.ndim == 0:
        vector = np.full(3, vector)
    if vector.shape != (3,) or not np.isfinite(vector).all():
        raise UsageError(f"{what} is {value!r}, expected three finite numbers")
    return vector


class Transform:
    """A 4 x 4 matrix for column vectors. `a @ b` applies `b` first."""

    def __init__(self, matrix=None):
        self.matrix = np.eye(4) if matrix is None else np.array(matrix, dtype=np.float64)
        if self.matrix.shape != (4, 4) or not np.isfinite(self.matrix).all():
            raise UsageError(f"a transform of the shape {self.matrix.shape}, expected 4 x 4 finite numbers")

    @classmethod
    def translate(cls, by) -> "Transform":
        """Moves by a vector."""
        matrix = np.eye(4)
        matrix[:3, 3] = _vector(by, "translate")
        return cls(matrix)

    @classmethod
    def scale(cls, by) -> "Transform":
        """Scales by a number, or by one number per axis."""
        return cls(np.diag([*_vector(by, "scale"), 1.0]))

    @classmethod
    def rotate(cls, axis, degrees: float) -> "Transform":
        """Rotates counter-clockwise about an axis through the origin (Rodrigues' formula)."""
        x, y, z = axis = _vector(axis, "axis")
        length = np.linalg.norm(axis)
        if not length > 0:
            raise UsageError("the axis of a rotation is zero")
        cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]) / length
        angle = np.radians(degrees)
        matrix = np.eye(4)
        matrix[:3, :3] += np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
        return cls(matrix)

    @classmethod
    def look_at(cls, origin, target, up) -> "Transform":
        """Places a camera: +z points from `origin` to `target`, +y is nearest to `up`."""
        origin, target, up = (_vector(v, w) for v, w in ((origin, "origin"), (target, "target"), (up, "up")))
        forward = target - origin
        left = np.cross(up, forward)
        if not (np.linalg.norm(forward) > 0 and np.linalg.norm(left) > 0):
            raise UsageError("look_at: 'origin' and 'target' coincide, or 'up' is parallel to the view direction")
        forward /= np.linalg.norm(forward)
        left /= np.linalg.norm(left)
        matrix = np.eye(4)
        matrix[:3, :] = np.stack([left, np.cross(forward, left), forward, origin], axis=1)
        return cls(matrix)

    def __matmul__(self, other: "Transform") -> "Transform":
        return Transform(self.matrix @ other.matrix) if isinstance(other, Transform) else NotImplemented

    def inverse(self) -> "Transform":
        """The inverse transform."""
        try:
            return Transform(np.linalg.inv(self.matrix))
        except np.linalg.LinAlgError:
            raise UsageError("the transform is singular and has no inverse") from None

    def points(self, points) -> np.ndarray:
        """Transforms an array of N x 3 points."""
        return np.asarray(points) @ self.matrix[:3, :3].T + self.matrix[:3, 3]

    def __eq__(self, other) -> bool:
        return isinstance(other, Transform) and np.array_equal(self.matrix, other.matrix)

    __hash__ = None

    def __repr__(self) -> str:
        return f"Transform({self.matrix.tolist()})"
