"""Rays and BSDFs: the renderer's own functions for arrays."""

from typing import NamedTuple, List, Optional

import numpy as np

from ._native import native
from .errors import UsageError, converted_errors
from .scene import Scene

# Largest coordinate of rays.
_LARGEST = 1e18


def _vectors(name: str, values, like: Optional[np.ndarray] = None, dtype=np.float32) -> np.ndarray:
    """An array N x 3. One vector is repeated as often as `like` has rows."""
    try:
        out = np.ascontiguousarray(values, dtype=dtype)
    except (TypeError, ValueError):
        raise UsageError(f"{name} is no array of numbers") from None
    if out.ndim == 1 and out.shape == (3,):
        out = np.ascontiguousarray(np.broadcast_to(out, (1 if like is None else len(like), 3)))
    if out.ndim != 2 or out.shape[1] != 3:
        raise UsageError(f"{name} has the shape {out.shape}, expected (N, 3)")
    if not np.isfinite(out).all():
        raise UsageError(f"{name} has values that are not finite")
    if like is not None and len(out) != len(like):
        raise UsageError(f"{name} has {len(out)} rows, expected {len(like)}")
    return out


def _directions(name: str, values, like: Optional[np.ndarray] = None) -> np.ndarray:
    """Directions of unit length."""
    out = _vectors(name, values, like)
    length = np.linalg.norm(out.astype(np.float64), axis=1, keepdims=True)
    if (length == 0).any():
        raise UsageError(f"{name} has a vector of length 0")
    return (out / length).astype(np.float32)


class Hits:
    """Nearest hits of N rays. Rays that miss have an infinite distance, numbers of -1, and zeros elsewhere.

    hit: N booleans. distance: N, in units of the direction's length. position, normal (geometric), shading_normal: N x 3,
    world space, positions in double precision; normals have unit length and point to the front of the surface. uv: N x 2. barycentric: N x 2, weights of
    the second and third vertex of a triangle. primitive: N, number of the triangle, curve segment or cell of the shape.
    instance: N, -1 for shapes outside of groups. object, material: N, into object_names and material_names.
    """

    distance: np.ndarray
    position: np.ndarray
    normal: np.ndarray
    shading_normal: np.ndarray
    uv: np.ndarray
    barycentric: np.ndarray
    primitive: np.ndarray
    instance: np.ndarray
    object: np.ndarray
    material: np.ndarray
    object_names: List[str]
    material_names: List[str]

    def __init__(self, arrays: dict):
        self.__dict__.update(arrays)

    @property
    def hit(self) -> np.ndarray:
        """Which rays hit something."""
        return self.object >= 0

    def __len__(self) -> int:
        return len(self.distance)

    def __repr__(self) -> str:
        return f"<sheaf.Hits: {int(self.hit.sum())} of {len(self)} rays>"


def trace(scene: Scene, origins, directions) -> Hits:
    """The nearest hits of rays.

    origins: N x 3, or one point for all rays. directions: N x 3, of any length but 0. Moving objects are where they are
    when the shutter opens. Masks, media and the sides of surfaces play no part.
    """
    along = _vectors("directions", directions)
    start = _vectors("origins", origins, along, np.float64)
    if np.abs(start).max(initial=0) > _LARGEST or np.abs(along).max(initial=0) > _LARGEST:
        raise UsageError("the coordinates of rays must be below 1e18")
    if (np.abs(along).max(axis=1, initial=0) == 0).any():
        raise UsageError("directions has a vector of length 0")
    with converted_errors():
        return Hits(native.trace(scene._session, start, along))


class BsdfSample(NamedTuple):
    """Directions sampled from a BSDF."""

    wi: np.ndarray         #: N x 3; zero if absorbed
    weight: np.ndarray     #: N x 3, f |cos(wi)| / pdf in linear RGB; zero if absorbed
    pdf: np.ndarray        #: N, per solid angle; 0 for delta lobes and if absorbed
    eta_scale: np.ndarray  #: N, 1 or the squared relative index of refraction of the medium entered
    valid: np.ndarray      #: N booleans; False: absorbed


class Bsdf:
    """The BSDF of a material. Directions are in the shading frame, whose z axis is the normal, and point away from the
    surface: N x 3, or one direction for all. They are normalized.
    """

    def __init__(self, scene: Scene, name: str):
        self._scene, self.name = scene, name
        self.evaluate((0, 0, 1), (0, 0, 1))  # raises errors now

    def _values(self, wo, wi):
        shape = np.shape(wo) if np.ndim(wo) > 1 else np.shape(wi)
        like = np.empty(shape if len(shape) > 1 else (1, 3))
        with converted_errors():
            return native.evaluate_bsdf(self._scene._session, self.name, _directions("wo", wo, like),
                                        _directions("wi", wi, like))

    def evaluate(self, wo, wi) -> np.ndarray:
        """f |cos(wi)| in linear RGB, N x 3, without delta lobes."""
        return self._values(wo, wi)[0]

    def pdf(self, wo, wi) -> np.ndarray:
        """Probability density per solid angle with which sample() returns wi, N."""
        return self._values(wo, wi)[1]

    def sample(self, wo, u=None, seed: int = 0, count: Optional[int] = None) -> BsdfSample:
        """Samples one direction for each of wo.

        u: N x 3 uniform numbers in [0, 1); otherwise random numbers from `seed`. count: with one direction wo, the number
        of samples.
        """
        if u is not None and np.ndim(wo) == 1:
            count = len(_vectors("u", u))
        like = np.empty((count or 1, 3)) if np.ndim(wo) == 1 else None
        outgoing = _directions("wo", wo, like)
        numbers = _vectors("u", np.random.default_rng(seed).random(outgoing.shape, dtype=np.float32) if u is None else u,
                           outgoing)
        if ((numbers < 0) | (numbers >= 1)).any():
            raise UsageError("u has values outside of [0, 1)")
        with converted_errors():
            return BsdfSample(*native.sample_bsdf(self._scene._session, self.name, outgoing, numbers))

    def __repr__(self) -> str:
        return f"<sheaf.Bsdf {self.name!r}>"


def bsdf(scene: Scene, name: str) -> Bsdf:
    """The BSDF of the material with this name (`Hits.material_names`), with constant parameters: a material with textures
    or maps is an error. Materials for the two sides of a surface are selected by the sign of wo's z.
    """
    return Bsdf(scene, name)
