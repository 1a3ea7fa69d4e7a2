"""The description of a twin scene. It holds only what all renderers model alike."""

from dataclasses import dataclass, field

import numpy as np

WIDTH, HEIGHT = 240, 160  # pixels, unless a run asks for others
MAX_DEPTH = 64  # segments of a path; so many that Russian roulette ends all paths


@dataclass(frozen=True)
class Diffuse:
    """Lambertian on both sides."""
    color: tuple


@dataclass(frozen=True)
class Metal:
    """A conductor with GGX microfacets. eta, k: complex index of refraction for red, green and blue."""
    eta: tuple
    k: tuple
    alpha: float


@dataclass(frozen=True)
class Glass:
    """A smooth dielectric in air; meshes are closed, with normals pointing outwards."""
    ior: float


@dataclass(frozen=True)
class QuadLight:
    """Emits from one side, u x v, with half edges u and v that are perpendicular. Renderers disagree about the other
    side, so an opaque object is right behind it."""
    center: tuple
    u: tuple
    v: tuple
    radiance: tuple


@dataclass(frozen=True)
class PointLight:
    position: tuple
    intensity: tuple


@dataclass(frozen=True)
class Fog:
    """A homogeneous, isotropically scattering medium in a box that does not contain the camera; coefficients per
    meter, equal for all colors."""
    low: tuple
    high: tuple
    scattering: float
    absorption: float


@dataclass
class Scene:
    """z is up. fov: horizontal, in degrees. meshes: {name: (mesh, name of its material)}. objects: pairs of the name of
    a mesh and a 4 x 4 matrix. environment: a constant radiance, or the pixels of a sky (height x width x 3), whose
    center is seen along +x and whose left half lies at +y. hides_lights: from the camera."""
    name: str
    eye: tuple
    target: tuple
    fov: float
    materials: dict = field(default_factory=dict)
    meshes: dict = field(default_factory=dict)
    objects: list = field(default_factory=list)
    lights: list = field(default_factory=list)
    environment: object = None
    fog: Fog | None = None
    hides_lights: bool = False

    def add(self, name, mesh, material, *matrices):
        """Adds a mesh and an object for each matrix; without any, one as it is."""
        self.meshes[name] = (mesh, material)
        self.objects += [(name, matrix) for matrix in matrices or [np.eye(4)]]

    def count(self, name):
        """Number of objects with a mesh."""
        return sum(mesh == name for mesh, _ in self.objects)

    @property
    def has_sky(self):
        return isinstance(self.environment, np.ndarray)

    def camera_axes(self):
        """Right, up and forward of the camera."""
        forward = np.subtract(self.target, self.eye)
        forward = forward / np.linalg.norm(forward)
        right = np.cross(forward, [0, 0, 1])
        right /= np.linalg.norm(right)
        return right, np.cross(right, forward), forward
