"""Dictionaries and values as elements of a scene: tuples (name, attributes, children, location[, array])."""

import functools
import numbers
import re
from typing import Any, Dict, Iterator, List, Optional

import numpy as np

from . import foreign
from ._native import native
from .errors import SceneError
from .transform import has_matrix, matrix_of

# Elements in the order in which a plugin name that several have is understood, by the element around it.
_PREFERRED = {
    "scene": ["shape", "emitter", "bsdf", "integrator", "sensor", "texture", "medium"],
    "shape": ["bsdf", "emitter", "medium", "sensor", "shape", "subsurface"],
    "bsdf": ["bsdf", "texture", "spectrum"],
    "medium": ["volume", "phase"],
}
_COLORS = ("rgb", "srgb", "color")
_DIMENSIONS = {2: "vector2", 3: "vector"}
# The id of the camera that stands in for a missing one, which scenes need to be read.
NO_SENSOR = "__no_sensor__"
_HEX_COLOR = re.compile("#[0-9a-fA-F]{6}")


@functools.lru_cache(maxsize=None)
def plugins() -> Dict[str, List[str]]:
    """The names of plugins by element: {"bsdf": ["conductor", ...], ...}."""
    return native.plugins()


def element_of(plugin: str, parent: str, where: str) -> str:
    """The element of a plugin inside of another element."""
    found = [element for element, names in plugins().items() if plugin in names]
    if not found:
        known = sorted({name for names in plugins().values() for name in names})
        import difflib
        near = difflib.get_close_matches(plugin, known, 1)
        raise SceneError.at(where, f"unknown plugin '{plugin}'" + (f", did you mean '{near[0]}'?" if near else ""))
    for element in _PREFERRED.get(parent, []):
        if element in found:
            return element
    return found[0]


def _number(value) -> str:
    return repr(float(value)) if not isinstance(value, numbers.Integral) else str(int(value))


def _finite(values: np.ndarray, where: str) -> np.ndarray:
    if not np.isfinite(values).all():
        raise SceneError.at(where, "has values that are not finite")
    return values


def array(name: str, value: Any, where: str) -> tuple:
    """An element with an array: of floats or bytes, or of indices if its name is `faces`."""
    values = np.asarray(value)
    if name == "faces":
        if values.dtype.kind not in "iu":
            raise SceneError.at(where, f"is an array of {values.dtype}, expected integers")
        if values.size and (values.min() < 0 or values.max() >= 2**32):
            raise SceneError.at(where, f"has indices from {values.min()} to {values.max()}, expected 0 to 4294967295")
        kind = np.uint32
    elif values.dtype == np.uint8:
        kind = np.uint8
    elif values.dtype.kind in "fiu":
        kind = np.float32
        if values.dtype.kind == "f":
            _finite(values, where)
    else:
        raise SceneError.at(where, f"is an array of {values.dtype}, expected numbers")
    with np.errstate(over="ignore"):
        values = np.ascontiguousarray(values, dtype=kind)
    return ("array", {"name": name}, [], where, values)


def is_attribute(name: str) -> bool:
    """Whether an array of a mesh is one of its attributes."""
    return name.startswith(("vertex_", "face_"))


def _transform(name: str, matrix: np.ndarray, where: str) -> tuple:
    text = " ".join(_number(v) for v in _finite(matrix, where).flat)
    return ("transform", {"name": name}, [("matrix", {"value": text}, [], where)], where)


def color(kind: str, name: str, value: Any, where: str) -> tuple:
    """An element with a color: one or three numbers."""
    values = np.asarray(value, dtype=np.float64).reshape(-1)
    if len(values) not in (1, 3):
        raise SceneError.at(where, f"is a color of {len(values)} numbers, expected 3")
    return (kind, {"name": name, "value": ", ".join(_number(v) for v in _finite(values, where))}, [], where)


def _spectrum(name: str, value: Any, where: str) -> tuple:
    if isinstance(value, (str, numbers.Real)):
        text = value if isinstance(value, str) else _number(value)
    else:
        try:
            text = ", ".join(f"{_number(wavelength)}:{_number(v)}" for wavelength, v in value)
        except (TypeError, ValueError):
            raise SceneError.at(where, "expected a number or pairs (wavelength, value)") from None
    return ("spectrum", {"name": name, "value": text}, [], where)


def _from_dict(name: str, value: Dict[str, Any], parent: str, where: str) -> tuple:
    kind = value.get("type")
    if not isinstance(kind, str):
        raise SceneError.at(where, "has no 'type', expected the name of a plugin")
    if kind == "ref":
        return ("ref", {"name": name, "id": str(value.get("id", ""))}, [], where)
    if kind in _COLORS and "value" in value:
        if isinstance(value["value"], str):
            return (kind, {"name": name, "value": value["value"]}, [], where)
        return color(kind, name, value["value"], where)
    if kind == "spectrum":
        return _spectrum(name, value.get("value"), where)
    return from_dict(name, value, parent, where)


def from_dict(name: str, value: Dict[str, Any], parent: str, where: str, identify: bool = False) -> tuple:
    """The element of a plugin. identify: `name` becomes its id instead of its name."""
    kind = value.get("type")
    if not isinstance(kind, str):
        raise SceneError.at(where, "has no 'type', expected the name of a plugin")
    value = foreign.with_images_as_arrays(value, where)
    element = value.get("element") or element_of(kind, parent, where)
    attributes = {"type": kind}
    if identify:
        attributes["id"] = name
    else:
        attributes["name"] = name
        if "id" in value:
            attributes["id"] = str(value["id"])
    children = []
    for key, each in value.items():
        if key in ("type", "id", "element"):
            continue
        place = f"{where}.{key}"
        if not isinstance(key, str):
            raise SceneError.at(place, f"the key is a {type(key).__name__}, expected a text")
        if key == "attributes" and isinstance(each, dict) and "type" not in each:
            children += [array(str(k), v, f"{place}.{k}") for k, v in each.items()]
        else:
            children.append(property_of(key, each, element, place))
    return (element, attributes, children, where)


def property_of(name: str, value: Any, parent: str, where: str, now: Optional[str] = None) -> tuple:
    """The element of a parameter. now: the element that the parameter has, as far as it is known."""
    value = foreign.dictionary_of(value, where)
    if isinstance(value, dict):
        return _from_dict(name, value, parent, where)
    if hasattr(type(value), "_element"):
        return placed(value._element(), {"name": name})
    if isinstance(value, (bool, np.bool_)):
        return ("boolean", {"name": name, "value": "true" if value else "false"}, [], where)
    if isinstance(value, numbers.Integral):
        return ("integer", {"name": name, "value": str(int(value))}, [], where)
    if isinstance(value, numbers.Real):
        return ("float", {"name": name, "value": _number(_finite(np.float64(value), where))}, [], where)
    if isinstance(value, str):
        kind = "rgb" if _HEX_COLOR.fullmatch(value) else "string"
        return (kind, {"name": name, "value": value}, [], where)
    if has_matrix(value):
        matrix = matrix_of(value)
        if matrix is None:
            raise SceneError.at(where, "is a transform without a matrix of 4 x 4 numbers")
        return _transform(name, matrix, where)
    if hasattr(value, "__fspath__"):
        return ("string", {"name": name, "value": value.__fspath__()}, [], where)
    if hasattr(value, "__array__") and np.size(value) == 1 and np.ndim(value) < 2:
        return property_of(name, np.asarray(value).item(), parent, where, now)
    if not hasattr(value, "__len__") and not hasattr(value, "__array__"):
        raise SceneError.at(where, f"is a {type(value).__name__}, expected a number, a text, a sequence or a dictionary")
    values = np.asarray(value)
    if values.dtype.kind not in "fiu":
        if isinstance(value, np.ndarray):
            return array(name, value, where)
        raise SceneError.at(where, f"is a {type(value).__name__} without numbers, expected numbers")
    if name.lower().replace("_", "") in ("toworld", "touv"):
        matrix = matrix_of(values, planar=True)
        if matrix is not None:
            return _transform(name, matrix, where)
    if values.ndim == 2 and values.shape[1] == 1 and not isinstance(value, (np.ndarray, list, tuple)):
        values = values[:, 0]  # a vector of a package that computes several at once
    is_array = now == "array" or (parent in ("shape", "mesh") and is_attribute(name))
    if values.ndim == 1 and len(values) in _DIMENSIONS and not is_array:
        if now in _COLORS or now == "spectrum" or now == "texture":
            return color("rgb", name, values, where)
        text = ", ".join(_number(v) for v in _finite(values, where))
        return (_DIMENSIONS[len(values)], {"name": name, "value": text}, [], where)
    return array(name, value, where)


def placed(element: tuple, attributes: Dict[str, str]) -> tuple:
    """The element with another name or id."""
    kept = {key: text for key, text in element[1].items() if key != "name" and key not in attributes}
    return (element[0], {**kept, **attributes}, *element[2:])


def object_of(key: Any, value: Any, where: str) -> tuple:
    """The element of an object of the scene, whose id is the key."""
    value = foreign.dictionary_of(value, where)
    if isinstance(key, str) and hasattr(type(value), "_element"):
        return placed(value._element(), {"id": key})
    if not isinstance(key, str) or not isinstance(value, dict) or not isinstance(value.get("type"), str):
        raise SceneError.at(where, "expected a text as the key, and a dictionary with a 'type'")
    return from_dict(key, value, "scene", where, identify=True)


def _elements(element: tuple) -> Iterator[tuple]:
    yield element
    for child in element[2]:
        yield from _elements(child)


def _identify_referenced(root: tuple) -> None:
    """Gives nested objects an id to which references refer by their keys: "ball.bsdf"."""
    known = {element[1]["id"] for element in _elements(root) if element[0] != "ref" and "id" in element[1]}
    wanted = {f"dictionary.{element[1]['id']}": element[1]["id"] for element in _elements(root)
              if element[0] == "ref" and element[1].get("id") not in known}
    for element in _elements(root):
        if "type" in element[1] and element[3] in wanted:
            element[1].setdefault("id", wanted[element[3]])


def scene_tree(dictionary: Dict[str, Any]) -> tuple:
    """The tree of a whole scene."""
    if not isinstance(dictionary, dict) or dictionary.get("type") != "scene":
        raise SceneError.at("dictionary", "expected a dictionary whose 'type' is 'scene'")
    children = [object_of(key, value, f"dictionary.{key}") for key, value in dictionary.items() if key != "type"]
    if not any(child[0] == "sensor" for child in children):
        children.append(("sensor", {"type": "perspective", "id": NO_SENSOR}, [], "dictionary"))
    root = ("scene", {"version": "3.0.0"}, children, "dictionary")
    _identify_referenced(root)
    return root


def part_tree(value: Dict[str, Any]) -> tuple:
    """The tree of a scene that contains a single object, and a camera if it needs one."""
    part = from_dict("", value, "scene", "dictionary")
    part[1].pop("name")
    children = [part]
    if part[0] != "sensor":
        children.append(("sensor", {"type": "perspective", "id": NO_SENSOR}, [], "dictionary"))
    return ("scene", {"version": "3.0.0"}, children, "dictionary")
