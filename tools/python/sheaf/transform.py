"""Affine transforms."""

import functools
from typing import Any, Callable, Optional

import numpy as np

from .errors import UsageError


def _vector(value, what: str) -> np.ndarray:
    vector = np.asarray(value, dtype=np.float64)
    if vector.ndim == 0:
        vector = np.full(3, vector)
    if vector.shape != (3,) or not np.isfinite(vector).all():
        raise UsageError(f"{what} is {value!r}, expected three finite numbers")
    return vector


def has_matrix(value: Any) -> bool:
    """Whether this is a transform of any package. Mitsuba's vectors answer to all attributes with x, y or z."""
    return hasattr(type(value), "matrix") or "matrix" in getattr(value, "__dict__", ())


def matrix_of(value: Any, planar: bool = False) -> Optional[np.ndarray]:
    """The 4 x 4 matrix of a transform of any package: of objects with `matrix`, and of arrays. planar: 3 x 3 arrays are
    affine transforms of the plane, as those of objects. None for other values.
    """
    planar |= has_matrix(value)
    value = value.matrix if has_matrix(value) else value
    if not hasattr(value, "__array__") and not isinstance(value, (list, tuple)):
        return None
    try:
        matrix = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        return None
    if matrix.ndim == 3 and matrix.shape[2] == 1:  # of a package that computes several at once
        matrix = matrix[..., 0]
    if matrix.shape == (3, 3) and planar:
        out = np.eye(4)
        out[np.ix_((0, 1, 3), (0, 1, 3))] = matrix
        return out
    return matrix if matrix.shape == (4, 4) else None


class _Composable:
    """A method that makes a transform. Of an instance, it returns the instance's transform after the one that it makes."""

    def __init__(self, make: Callable[..., "Transform"]):
        self._make = make
        self.__doc__ = make.__doc__

    def __get__(self, instance: Optional["Transform"], owner: type) -> Callable[..., "Transform"]:
        make = functools.wraps(self._make)(functools.partial(self._make, owner))
        if instance is None:
            return make
        return functools.wraps(self._make)(lambda *values, **named: instance @ make(*values, **named))


class Transform:
    """A 4 x 4 matrix for column vectors. `a @ b` applies `b` first; `a @ points` transforms an array of points.

    `translate`, `scale`, `rotate` and `look_at` make transforms, and chain: `Transform().translate(t).scale(s)` is
    `translate(t) @ scale(s)`, which scales first.
    """

    def __init__(self, matrix=None):
        self.matrix = np.eye(4) if matrix is None else matrix_of(matrix)
        if self.matrix is None or not np.isfinite(self.matrix).all():
            raise UsageError(f"a transform of the shape {np.shape(matrix)}, expected 4 x 4 finite numbers")

    @_Composable
    def translate(cls, by) -> "Transform":
        """Moves by a vector."""
        matrix = np.eye(4)
        matrix[:3, 3] = _vector(by, "translate")
        return cls(matrix)

    @_Composable
    def scale(cls, by) -> "Transform":
        """Scales by a number, or by one number per axis."""
        return cls(np.diag([*_vector(by, "scale"), 1.0]))

    @_Composable
    def rotate(cls, axis, degrees: Optional[float] = None, angle: Optional[float] = None) -> "Transform":
        """Rotates counter-clockwise about an axis through the origin (Rodrigues' formula). `angle`: another name of
        `degrees`.
        """
        x, y, z = axis = _vector(axis, "axis")
        length = np.linalg.norm(axis)
        if not length > 0:
            raise UsageError("the axis of a rotation is zero")
        if (degrees is None) == (angle is None):
            raise UsageError("a rotation needs an angle in degrees")
        cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]) / length
        radians = np.radians(angle if degrees is None else degrees)
        matrix = np.eye(4)
        matrix[:3, :3] += np.sin(radians) * cross + (1 - np.cos(radians)) * cross @ cross
        return cls(matrix)

    @_Composable
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

    def __matmul__(self, other):
        matrix = other.matrix if isinstance(other, Transform) else matrix_of(other)
        if matrix is not None:
            return Transform(self.matrix @ matrix)
        if np.ndim(other) > 0 and np.shape(other)[-1] == 3:
            return self.points(other)
        return NotImplemented

    def __rmatmul__(self, other):
        matrix = matrix_of(other)
        return NotImplemented if matrix is None else Transform(matrix @ self.matrix)

    __array_ufunc__ = None  # `array @ transform` is __rmatmul__()

    def inverse(self) -> "Transform":
        """The inverse transform."""
        try:
            return Transform(np.linalg.inv(self.matrix))
        except np.linalg.LinAlgError:
            raise UsageError("the transform is singular and has no inverse") from None

    def points(self, points) -> np.ndarray:
        """Transforms an array of N x 3 points."""
        return np.asarray(points) @ self.matrix[:3, :3].T + self.matrix[:3, 3]

    def vectors(self, vectors) -> np.ndarray:
        """Transforms an array of N x 3 vectors, which translations leave as they are."""
        return np.asarray(vectors) @ self.matrix[:3, :3].T

    def normals(self, normals) -> np.ndarray:
        """Transforms an array of N x 3 normals, by the inverse transpose. Their length changes."""
        return np.asarray(normals) @ self.inverse().matrix[:3, :3]

    def translation(self) -> np.ndarray:
        """The image of the origin."""
        return self.matrix[:3, 3].copy()

    def __array__(self, dtype=None, copy=None) -> np.ndarray:
        return self.matrix.astype(dtype or np.float64)

    def __eq__(self, other) -> bool:
        return isinstance(other, Transform) and np.array_equal(self.matrix, other.matrix)

    __hash__ = None

    def __repr__(self) -> str:
        return f"Transform({self.matrix.tolist()})"
