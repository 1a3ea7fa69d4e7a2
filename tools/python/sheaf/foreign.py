"""Values of other packages in dictionaries: images and meshes of Mitsuba 3. Transforms and arrays need no conversion, see
transform.matrix_of().
"""

import atexit
import shutil
import sys
import tempfile
from pathlib import Path
from typing import Any, Dict, Optional

import numpy as np

from ._native import native
from .errors import SceneError, converted_errors


def _is_image(value: Any) -> bool:
    """Whether this is an image that knows its encoding: a Bitmap."""
    return hasattr(type(value), "srgb_gamma") and (hasattr(value, "__array__") or hasattr(value, "__array_interface__"))


def _image_array(value: Any) -> np.ndarray:
    """Pixels as they are, but floats and 16-bit integers as linear floats."""
    pixels = np.asarray(value)
    if not _is_image(value) or pixels.dtype == np.uint8:
        return pixels
    if pixels.dtype.kind == "u":
        pixels = pixels / np.float32(np.iinfo(pixels.dtype).max)
    pixels = pixels.astype(np.float32)
    return decoded(pixels) if value.srgb_gamma() else pixels


def decoded(values: np.ndarray) -> np.ndarray:
    """Linear values of sRGB values (IEC 61966-2-1)."""
    values = np.asarray(values, dtype=np.float32)
    return np.where(values <= 0.04045, values / np.float32(12.92),
                    ((np.maximum(values, 0) + np.float32(0.055)) / np.float32(1.055)) ** np.float32(2.4))


class _Files:
    """A folder for images of environment maps, which are files to the scene. Removed at exit."""

    folder: Optional[str] = None
    count = 0

    @classmethod
    def write(cls, pixels: np.ndarray, raw: bool) -> str:
        """The name of a new file with these pixels."""
        if cls.folder is None:
            cls.folder = tempfile.mkdtemp(prefix="sheaf-")
            atexit.register(shutil.rmtree, cls.folder, ignore_errors=True)
        cls.count += 1
        if pixels.dtype == np.uint8:
            pixels = pixels / np.float32(255)
            pixels = pixels if raw else decoded(pixels)
        with converted_errors():
            image = native.Image.from_array(pixels.astype(np.float32))
            name = str(Path(cls.folder) / f"image_{cls.count}.exr")
            image.write(name, {"compression": "none"})
        return name


def with_images_as_arrays(value: Dict[str, Any], where: str) -> Dict[str, Any]:
    """A dictionary of a plugin with `data` instead of Mitsuba's `bitmap` (images) and `grid` (volumes)."""
    out = dict(value)
    for key, kind in (("bitmap", "an image"), ("grid", "a grid")):
        if key in out and not isinstance(out[key], (str, dict)):
            if not hasattr(out[key], "__array__") and not hasattr(out[key], "__array_interface__"):
                raise SceneError.at(f"{where}.{key}", f"is a {type(out[key]).__name__}, expected {kind}")
            out["data"] = out.pop(key)
    data = out.get("data")
    if hasattr(type(data), "_pixels"):  # a Result
        out["data"] = data = data._pixels()
    if _is_image(data):
        if np.asarray(data).dtype == np.uint8 and not data.srgb_gamma():
            out.setdefault("raw", True)
        out["data"] = data = _image_array(data)
    if out.get("type") == "envmap" and data is not None:
        out.pop("data")
        pixels = np.asarray(data)
        if pixels.ndim != 3 or pixels.shape[2] not in (1, 3, 4):
            raise SceneError.at(f"{where}.data",
                                f"has the shape {pixels.shape}, expected (H, W, C) with 1, 3 or 4 channels")
        out["filename"] = _Files.write(pixels[..., :3], bool(out.pop("raw", False)))
    return out


def _mesh(mesh: Any, where: str) -> Dict[str, Any]:
    """The dictionary of a mitsuba.Mesh."""
    def rows(buffer, columns, kind):
        return np.array(buffer, dtype=kind).reshape(-1, columns)

    out = {"type": "mesh", "vertices": rows(mesh.vertex_positions_buffer(), 3, np.float32),
           "faces": rows(mesh.faces_buffer(), 3, np.uint32), "face_normals": bool(mesh.has_face_normals())}
    if mesh.has_vertex_normals() and np.size(mesh.vertex_normals_buffer()):
        out["normals"] = rows(mesh.vertex_normals_buffer(), 3, np.float32)
    if mesh.has_vertex_texcoords() and np.size(mesh.vertex_texcoords_buffer()):
        out["uv"] = rows(mesh.vertex_texcoords_buffer(), 2, np.float32)
    parameters = sys.modules["mitsuba"].traverse(mesh)
    attributes = {}
    for name in parameters.keys():
        if name.startswith(("vertex_", "face_")) and name not in ("vertex_positions", "vertex_normals", "vertex_texcoords"):
            values = np.array(parameters[name], dtype=np.float32).reshape(-1)
            count = len(out["vertices"] if name.startswith("vertex_") else out["faces"])
            attributes[name] = values.reshape(count, -1) if len(values) != count else values
    if attributes:
        out["attributes"] = attributes
    material = [name for name in parameters.keys() if name.startswith(("bsdf.", "emitter."))]
    if any(name != "bsdf.reflectance.value" for name in material):
        raise SceneError.at(where, "is a mesh whose BSDF or emitter cannot be read: put a dictionary "
                            "{'type': 'mesh', ...} with arrays and a 'bsdf' in its place")
    for name in material:
        color = np.array(parameters[name], dtype=np.float64).reshape(-1)
        out["bsdf"] = {"type": "diffuse", "reflectance": {"type": "rgb", "value": [float(v) for v in color]}}
    return out


def dictionary_of(value: Any, where: str) -> Any:
    """The dictionary of a mesh of Mitsuba, or of an object that knows its own; other values as they are."""
    if hasattr(type(value), "_dictionary"):
        return value._dictionary()
    if hasattr(type(value), "vertex_positions_buffer") and hasattr(type(value), "faces_buffer"):
        return _mesh(value, where)
    return value
