"""The names of Mitsuba 3 for programs that were written for it: `import sheaf.mitsuba as mi`.

Rendering and scenes only: there are no derivatives, no plugins in Python, and no rays or BSDFs by Mitsuba's names (see
sheaf.trace() and sheaf.bsdf()). Arrays are NumPy's.
"""

import os
import re
from typing import Any, Dict, List, Optional, Tuple, Union

import numpy as np

from . import load as _load, render as _render
from ._native import native as _native
from .errors import UsageError, converted_errors as _converted_errors
from .foreign import decoded as _decoded
from .parameters import SceneParameters, smooth_normals as _smooth_normals, traverse
from .result import Result, read_image as _read_image
from .scene import Object, Scene, load_dict
from .transform import Transform

__all__ = ["Bitmap", "Mesh", "Properties", "ScalarColor3f", "ScalarPoint3f", "ScalarTransform4f", "ScalarVector3f",
           "SceneParameters", "Struct", "TensorXf", "Transform4f", "cornell_box", "load_dict", "load_file", "render",
           "set_variant", "traverse", "util", "variant"]

ScalarTransform4f = Transform4f = Transform
_state = {"variant": "scalar_rgb"}
# Layers of Sheaf by the names of Mitsuba's integrator `aov`.
_AOVS = {"albedo": "albedo", "depth": "depth", "position": "position", "uv": "uv", "sh_normal": "normal",
         "geo_normal": "geometric_normal", "shape_index": "object_id"}


def set_variant(*names: str) -> None:
    """Chooses between RGB and spectral rendering by the name of a variant. All run on the CPU, without derivatives."""
    if not names or not all(re.fullmatch("(scalar|llvm|cuda)(_ad)?_(rgb|spectral)(_double)?", name) for name in names):
        raise UsageError(f"set_variant{names}: expected names such as 'scalar_rgb' or 'llvm_ad_spectral'")
    _state["variant"] = names[0]


def variant() -> str:
    """The name given to set_variant()."""
    return _state["variant"]


def _vector3(*values: Any) -> np.ndarray:
    """Three numbers: from three, one or a sequence."""
    out = np.array(values[0] if len(values) == 1 else values, dtype=np.float64)
    return np.full(3, out) if out.ndim == 0 else out


ScalarColor3f = ScalarPoint3f = ScalarVector3f = _vector3


def TensorXf(values: Any = (), shape: Optional[Tuple[int, ...]] = None) -> np.ndarray:  # pylint: disable=invalid-name
    """An array of float32."""
    out = np.array(values, dtype=np.float32)
    return out if shape is None else out.reshape(shape)


def load_file(file: Any, **defines: Any) -> Scene:
    """Reads a scene. defines: values of its parameters `$name`."""
    return _load(file, defines=defines)


def _layers_of(integrator: Optional[Object]) -> List[str]:
    """The layers that the integrator `aov` requests."""
    if integrator is None or integrator.type != "aov" or integrator._find("aovs") is None:
        return []
    kinds = [entry.split(":")[-1].strip() for entry in integrator.aovs.split(",")]
    unknown = [kind for kind in kinds if kind not in _AOVS]
    if unknown:
        raise UsageError(f"aovs: unknown layer '{unknown[0]}', expected {', '.join(_AOVS)}")
    return [_AOVS[kind] for kind in kinds]


def render(scene: Scene, params: Any = None, sensor: Union[int, Object, Dict[str, Any]] = 0,
           integrator: Union[Object, Dict[str, Any], None] = None, seed: int = 0, spp: int = 0,
           **options: Any) -> np.ndarray:
    """Renders a scene. Returns float32, H x W x C: the channels of the film's `pixel_format`, and layers of the integrator
    `aov`. params: ignored. spp: 0 takes that of the sampler. options: those of sheaf.render().
    """
    if _state["variant"].endswith(("spectral", "spectral_double")):
        options.setdefault("color", "spectral")
    method = load_dict(integrator) if isinstance(integrator, dict) else integrator or scene._first(["integrator"])
    layers = _layers_of(method)
    view: Any = load_dict(sensor) if isinstance(sensor, dict) else sensor
    film_of = scene.sensors()[view] if isinstance(view, int) and len(scene.sensors) > 0 else view
    film = film_of.film if isinstance(film_of, Object) and film_of._find("film") else None
    pixel_format = film.pixel_format if film is not None and film._find("pixel_format") else "rgba"
    given = options.pop("aovs", [])
    first = isinstance(view, int) and view == 0
    result = _render(scene, sensor=None if first else view, integrator=integrator, seed=seed, spp=spp or None,
                     aovs=[*given, *layers], **options)
    image = result.image
    parts = {"rgb": image[..., :3], "luminance": image[..., :3] @ np.array([[0.2126], [0.7152], [0.0722]], np.float32)}
    layer_arrays = [result[name].reshape(*image.shape[:2], -1) for name in layers]
    return np.concatenate([parts.get(pixel_format, image), *layer_arrays], axis=2)


class Struct:
    """Names of number types."""

    class Type:
        """Types of the numbers in a Bitmap."""

        UInt8, UInt16, Float16, Float32 = "uint8", "uint16", "float16", "float32"


class Bitmap:
    """An image with its encoding. Integers are sRGB-encoded unless `srgb_gamma` says otherwise; floats are linear."""

    UInt8, UInt16, Float16, Float32 = Struct.Type.UInt8, Struct.Type.UInt16, Struct.Type.Float16, Struct.Type.Float32

    class PixelFormat:
        """Channels of a Bitmap."""

        Y, YA, RGB, RGBA, MultiChannel = "y", "ya", "rgb", "rgba", "multichannel"

    def __init__(self, data: Any):
        """data: an array H x W or H x W x C, a file, a Result or a Bitmap."""
        self._layers: Optional[Result] = None
        file = ".exr"
        if isinstance(data, (str, os.PathLike)):
            file = os.fspath(data)
            data = self._layers = _read_image(file)
        if isinstance(data, Result):
            names = data._native.channels
            has_color, has_alpha = "R" in names, "A" in names
            values = data.image if has_color and has_alpha else data._pixels()
            steps = values * np.float32(255)
            is_float = file.lower().endswith((".exr", ".hdr", ".pfm"))
            is_bytes = not is_float and np.allclose(steps, np.rint(steps), rtol=0, atol=1e-3)
            data = np.rint(steps).astype(np.uint8) if is_bytes else values
        pixels = np.array(data)
        self._gamma = data.srgb_gamma() if hasattr(data, "srgb_gamma") else pixels.dtype == np.uint8
        if pixels.ndim == 2:
            pixels = pixels[..., None]
        if pixels.ndim != 3 or pixels.dtype.kind not in "uf":
            raise UsageError(f"a bitmap of {pixels.dtype} and the shape {pixels.shape}, expected (H, W, C) numbers")
        self._values = pixels.astype(np.float32) if pixels.dtype == np.float64 else pixels

    def width(self) -> int:
        """Width, pixels."""
        return self._values.shape[1]

    def height(self) -> int:
        """Height, pixels."""
        return self._values.shape[0]

    def size(self) -> np.ndarray:
        """Width and height, pixels."""
        return np.array([self.width(), self.height()])

    def channel_count(self) -> int:
        """Number of channels."""
        return self._values.shape[2]

    def pixel_format(self) -> str:
        """Which channels there are, a name of PixelFormat."""
        return {1: "y", 2: "ya", 3: "rgb", 4: "rgba"}.get(self.channel_count(), "multichannel")

    def component_format(self) -> str:
        """The type of the numbers, a name of Struct.Type."""
        return self._values.dtype.name

    def srgb_gamma(self) -> bool:
        """Whether the colors are sRGB-encoded."""
        return bool(self._gamma)

    def set_srgb_gamma(self, value: bool) -> None:
        """Declares the encoding, without a conversion."""
        self._gamma = bool(value)

    def _linear(self) -> np.ndarray:
        """Linear float32; alpha as it is."""
        kind = self._values.dtype
        values = self._values.astype(np.float32) / np.float32(np.iinfo(kind).max if kind.kind == "u" else 1)
        if self._gamma:
            colors = slice(0, 3 if self.channel_count() > 2 else 1)
            values[..., colors] = _decoded(values[..., colors])
        return values

    def convert(self, pixel_format: Optional[str] = None, component_format: Optional[str] = None,
                srgb_gamma: Optional[bool] = None) -> "Bitmap":
        """A bitmap with other channels, another type of numbers or another encoding."""
        values = self._linear()
        color = values[..., :3] if self.channel_count() > 2 else np.repeat(values[..., :1], 3, axis=2)
        has_alpha = self.channel_count() in (2, 4)
        alpha = values[..., -1:] if has_alpha else np.ones_like(values[..., :1])
        gray = color @ np.array([[0.2126], [0.7152], [0.0722]], np.float32)
        values = {"y": gray, "ya": np.concatenate([gray, alpha], 2), "rgb": color,
                  "rgba": np.concatenate([color, alpha], 2)}.get(pixel_format or "", values)
        kind = np.dtype(component_format or self._values.dtype)
        gamma = self._gamma if srgb_gamma is None else srgb_gamma
        if gamma:
            colors = slice(0, 3 if values.shape[2] > 2 else 1)
            linear = np.maximum(values[..., colors], 0)
            values = values.copy()
            values[..., colors] = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
        if kind.kind == "u":
            values = np.rint(np.clip(values, 0, 1) * np.iinfo(kind).max)
        out = Bitmap(values.astype(kind))
        out._gamma = bool(gamma)
        return out

    def split(self) -> List[Tuple[str, "Bitmap"]]:
        """The layers by name: the image as "root", and those of its file."""
        named = [(name, Bitmap(self._layers[name])) for name in self._layers.layers] if self._layers is not None else []
        return [("root", Bitmap(self)), *named]

    def write(self, file: Any, quality: int = -1) -> None:
        """Writes an image file of any format that Result.write() knows. quality: ignored."""
        with _converted_errors():
            _native.Image.from_array(self._linear()).write(os.fspath(file), {})

    def _repr_png_(self) -> bytes:
        with _converted_errors():
            return _native.Image.from_array(self._linear()).png({})

    def __array__(self, dtype: Any = None, copy: Any = None) -> np.ndarray:
        return np.array(self._values, dtype=dtype)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Bitmap) and self._gamma == other._gamma and np.array_equal(self._values, other._values)

    __hash__ = None

    def __repr__(self) -> str:
        return f"Bitmap[{self.width()} x {self.height()}, {self.pixel_format()}, {self.component_format()}]"


class Properties(Dict[str, Any]):
    """Parameters of a Mesh, such as its BSDF."""


class Mesh:
    """A triangle mesh, whose arrays traverse() gives access to. Dictionaries of scenes may contain it."""

    def __init__(self, name: str, vertex_count: int, face_count: int, has_vertex_normals: bool = False,
                 has_vertex_texcoords: bool = False, props: Optional[Dict[str, Any]] = None):
        self._name, self._props = name, dict(props or {})
        self._wants_normals = has_vertex_normals
        self._arrays: Dict[str, Any] = {
            "vertex_positions": np.zeros(3 * vertex_count, np.float32), "faces": np.zeros(3 * face_count, np.uint32),
            "vertex_normals": np.zeros(0, np.float32),
            "vertex_texcoords": np.zeros(2 * vertex_count if has_vertex_texcoords else 0, np.float32)}

    def _parameters(self) -> Dict[str, Any]:
        return self._arrays

    def id(self) -> str:
        """The name."""
        return self._name

    def add_attribute(self, name: str, size: int, buffer: Any) -> None:
        """Adds values per vertex or face; `name` begins with vertex_ or face_."""
        self._arrays[name] = np.array(buffer, dtype=np.float32).reshape(-1, size)

    def _rows(self, name: str, columns: int, kind: Any = np.float32) -> np.ndarray:
        return np.asarray(self._arrays[name], dtype=kind).reshape(-1, columns)

    def vertex_count(self) -> int:
        """Number of vertices."""
        return len(self._rows("vertex_positions", 3))

    def face_count(self) -> int:
        """Number of triangles."""
        return len(self._rows("faces", 3, np.uint32))

    def recompute_vertex_normals(self) -> None:
        """Computes smooth normals."""
        vertices = self._rows("vertex_positions", 3)
        order = np.arange(len(vertices))[:, None]
        self._arrays["vertex_normals"] = _smooth_normals(vertices, self._rows("faces", 3, np.uint32), order).reshape(-1)

    def _dictionary(self) -> Dict[str, Any]:
        if self._wants_normals and not np.size(self._arrays["vertex_normals"]):
            self.recompute_vertex_normals()
        out: Dict[str, Any] = {"type": "mesh", "vertices": self._rows("vertex_positions", 3),
                               "faces": self._rows("faces", 3, np.uint32)}
        for name, own, columns in (("vertex_normals", "normals", 3), ("vertex_texcoords", "uv", 2)):
            if np.size(self._arrays[name]):
                out[own] = self._rows(name, columns)
        known = ("vertex_positions", "vertex_normals", "vertex_texcoords", "faces")
        attributes = {name: np.squeeze(values, 1) if np.ndim(values) == 2 and np.shape(values)[1] == 1 else values
                      for name, values in self._arrays.items() if name not in known}
        if attributes:
            out["attributes"] = attributes
        return {**out, **self._props}

    def write_ply(self, file: Any) -> None:
        """Writes a binary PLY file with normals and texture coordinates, if there are any."""
        columns = [("x y z", self._rows("vertex_positions", 3)), ("nx ny nz", self._rows("vertex_normals", 3)),
                   ("u v", self._rows("vertex_texcoords", 2))]
        columns = [(names, values) for names, values in columns if len(values)]
        faces = self._rows("faces", 3, np.uint32)
        names = [name for group, _ in columns for name in group.split()]
        header = ["ply", "format binary_little_endian 1.0", f"element vertex {self.vertex_count()}",
                  *(f"property float {name}" for name in names), f"element face {len(faces)}",
                  "property list uchar int vertex_indices", "end_header", ""]
        rows = np.zeros(len(faces), dtype=[("count", "u1"), ("indices", "<i4", 3)])
        rows["count"], rows["indices"] = 3, faces
        with open(file, "wb") as out:
            out.write("\n".join(header).encode())
            out.write(np.concatenate([values for _, values in columns], axis=1).astype("<f4").tobytes())
            out.write(rows.tobytes())


class util:  # pylint: disable=invalid-name
    """Functions for images."""

    @staticmethod
    def convert_to_bitmap(data: Any, uint8_srgb: bool = True) -> Bitmap:
        """A Bitmap of linear pixels: for the screen, or with linear floats."""
        bitmap = data if isinstance(data, Bitmap) else Bitmap(data)
        return bitmap.convert(component_format="uint8", srgb_gamma=True) if uint8_srgb else bitmap

    @staticmethod
    def write_bitmap(filename: Any, data: Any, write_async: bool = True, quality: int = -1) -> None:
        """Writes linear pixels or a Bitmap to a file. write_async, quality: ignored."""
        (data if isinstance(data, Bitmap) else Bitmap(data)).write(filename)


def cornell_box() -> Dict[str, Any]:
    """The dictionary of a Cornell box: a room of 2 x 2 x 2 units around the origin, with two boxes and a lamp."""
    T = Transform

    def wall(transform: Transform, material: str = "white", **more: Any) -> Dict[str, Any]:
        return {"type": "rectangle", "to_world": transform, "bsdf": {"type": "ref", "id": material}, **more}

    def diffuse(*rgb: float) -> Dict[str, Any]:
        return {"type": "diffuse", "reflectance": {"type": "rgb", "value": rgb}}

    def box(x: float, z: float, turn: float, height: float) -> Dict[str, Any]:
        place = T().translate((x, height - 1, z)).rotate((0, 1, 0), turn).scale((0.3, height, 0.3))
        return {"type": "cube", "to_world": place, "bsdf": {"type": "ref", "id": "white"}}

    return {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 8},
        "sensor": {"type": "perspective", "fov": 39, "to_world": T.look_at((0, 0, 3.9), (0, 0, 0), (0, 1, 0)),
                   "sampler": {"type": "independent", "sample_count": 64},
                   "film": {"type": "hdrfilm", "width": 256, "height": 256, "pixel_format": "rgb"}},
        "white": diffuse(0.73, 0.71, 0.68), "green": diffuse(0.14, 0.45, 0.09), "red": diffuse(0.63, 0.06, 0.05),
        "light": wall(T().translate((0, 0.99, 0)).rotate((1, 0, 0), 90).scale((0.25, 0.2, 1)),
                      emitter={"type": "area", "radiance": {"type": "rgb", "value": (18, 14, 7)}}),
        "floor": wall(T().translate((0, -1, 0)).rotate((1, 0, 0), -90)),
        "ceiling": wall(T().translate((0, 1, 0)).rotate((1, 0, 0), 90)),
        "back": wall(T().translate((0, 0, -1))),
        "green-wall": wall(T().translate((1, 0, 0)).rotate((0, 1, 0), -90), "green"),
        "red-wall": wall(T().translate((-1, 0, 0)).rotate((0, 1, 0), 90), "red"),
        "small-box": box(0.35, 0.3, -17, 0.3), "large-box": box(-0.35, -0.3, 18, 0.6),
    }
