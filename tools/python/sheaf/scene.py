"""Scenes, and the objects in them."""

import difflib
import os
import re
import warnings
from typing import Any, Dict, Iterator, List, Mapping, Optional, Tuple, Union

import numpy as np

from . import tree
from ._native import native
from .errors import SceneError, SheafWarning, UsageError, converted_errors
from .options import values
from .transform import Transform

# Elements of the dialects of Mitsuba and Nori by their names in Scene.
_KINDS = {
    "materials": ["bsdf"],
    "textures": ["texture"],
    "shapes": ["shape", "mesh"],
    "lights": ["emitter"],
    "media": ["medium"],
    "sensors": ["sensor", "camera"],
}
_OBJECT = ["sensor", "camera", "film", "sampler", "rfilter", "integrator", "shape", "mesh", "bsdf", "emitter",
           "medium", "phase", "volume", "subsurface", "texture"]


def _key(name: str) -> str:
    """The form of a name by which parameters are compared, as files are read: max_depth equals maxDepth."""
    return name.replace("_", "").lower()


def _numbers(text: str) -> Optional[List[float]]:
    try:
        return [float(word) for word in text.replace(",", " ").split()]
    except ValueError:
        return None


class Object:
    """An element of a scene. Its parameters and nested objects are attributes."""

    __slots__ = ("_scene", "_path")

    def __init__(self, scene: "Scene", path: Tuple[int, ...]):
        object.__setattr__(self, "_scene", scene)
        object.__setattr__(self, "_path", (scene._structure, tuple(path)))

    def _child(self, index: int) -> "Object":
        return Object(self._scene, (*self._path[1], index))

    def _element(self) -> tuple:
        """The element with all that it contains, for another scene."""
        element, attributes, children, where = self._get()
        if element == "array":
            with converted_errors():
                return (element, attributes, [], where, self._scene._session.array(self._path[1]))
        return (element, attributes, [self._child(index)._element() for index in range(len(children))], where)

    def _get(self):
        structure, path = self._path
        if structure != self._scene._structure:
            raise UsageError("objects were added to the scene or removed: take this one from the scene again")
        with converted_errors():
            return self._scene._session.get(path)

    @property
    def type(self) -> str:
        """The name of the plugin."""
        return self._get()[1].get("type", "")

    @property
    def id(self) -> str:
        """The name in the scene; may be empty."""
        return self._get()[1].get("id", "")

    def _find(self, name: str):
        """(index, element, attributes) of a parameter or nested object; None if absent."""
        children = self._get()[2]
        for by_kind in (False, True):
            for index, (element, attributes) in enumerate(children):
                given = element if by_kind else attributes.get("name", "")
                if _key(given) == _key(name):
                    return index, element, attributes
        # References by the element that they refer to
        for index, (element, attributes) in enumerate(children):
            if element == "ref":
                target = self._scene._find_id(attributes.get("id", ""))
                if target is not None and _key(target._get()[0]) == _key(name):
                    return index, element, attributes
        return None

    def _array(self, index: int) -> np.ndarray:
        """A copy of the array of a child."""
        with converted_errors():
            return self._scene._session.array((*self._path[1], index))

    def _attributes(self) -> Dict[str, np.ndarray]:
        """The attributes of a mesh by name."""
        return {attributes["name"]: self._array(index)
                for index, (element, attributes) in enumerate(self._get()[2])
                if element == "array" and tree.is_attribute(attributes["name"])}

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        found = self._find(name)
        if found is None and name == "attributes":
            attributes = self._attributes()
            if attributes:
                return attributes
        if found is None:
            near = difflib.get_close_matches(name, dir(self), 1)
            raise AttributeError(f"{self!r} sets no parameter '{name}'" + (f", did you mean '{near[0]}'?" if near else ""))
        index, element, attributes = found
        path = (*self._path[1], index)
        if element == "ref":
            return self._scene._find_id(attributes.get("id", ""))
        if element in _OBJECT:
            return Object(self._scene, path)
        if element == "transform":
            with converted_errors():
                return Transform(np.reshape(self._scene._session.matrix(path), (4, 4)))
        if element == "array":
            return self._array(index)
        text = attributes.get("value", "")
        if not text and any(axis in attributes for axis in "xyz"):
            text = " ".join(attributes.get(axis, "0") for axis in "xyz")
        numbers = _numbers(text)
        if element == "boolean":
            return text.lower() == "true"
        if element == "string" or numbers is None:
            return text
        if element == "integer":
            return int(numbers[0])
        return numbers[0] if len(numbers) == 1 else tuple(numbers)

    def __setattr__(self, name: str, value: Any) -> None:
        element, _, _, place = self._get()
        found = self._find(name)
        now = found[1] if found else None
        if isinstance(value, Object) and value._scene is self._scene:
            if not value.id:
                raise UsageError("the object has no id, to which another one could refer")
            value = {"type": "ref", "id": value.id}
        choices = [tree.property_of(found[2].get("name", name) if found else name, value, element, place, now)]
        if choices[0][0] == "vector" and now is None:  # the reader may expect a color or a vector
            choices.insert(0, ("rgb", *choices[0][1:]))
        for last, choice in zip([*[False] * (len(choices) - 1), True], choices):
            try:
                with converted_errors():
                    self._scene._session.set([(self._path[1], found[0] if found else None, choice)])
                return
            except SceneError:
                if last:
                    raise

    def __delattr__(self, name: str) -> None:
        found = self._find(name)
        if found is None:
            raise AttributeError(f"{self!r} sets no parameter '{name}'")
        with converted_errors():
            self._scene._session.remove(self._path[1], found[0])
        self._scene._structure += 1
        object.__setattr__(self, "_path", (self._scene._structure, self._path[1]))

    def __dir__(self) -> List[str]:
        names = [attributes.get("name") or element for element, attributes in self._get()[2]]
        return sorted({"type", "id", *names})

    def __repr__(self) -> str:
        element, attributes, _, _ = self._get()
        return f"<{element} '{attributes.get('type', '')}'" + (f" {attributes['id']!r}>" if "id" in attributes else ">")


class Objects(Mapping[str, Object]):
    """The objects of a kind by their ids. BSDFs without an id are named like in Cryptomatte and hits, such as "material_2";
    other objects without an id by element and number, such as "shape_2". Calls return a list: scene.sensors()[0].
    """

    def __init__(self, scene: "Scene", elements: List[str]):
        self._scene, self._elements = scene, elements

    def _paths(self) -> Dict[str, Tuple[int, ...]]:
        with converted_errors():
            found = self._scene._session.list(self._elements)
        numbers = self._scene._material_numbers() if self._elements == _KINDS["materials"] else {}
        out = {}
        for number, (path, element, identity, _, _) in enumerate(found, 1):
            if identity == tree.NO_SENSOR:
                continue
            name = f"material_{numbers[tuple(path)]}" if tuple(path) in numbers else f"{element}_{number}"
            out[identity or name] = tuple(path)
        return out

    def __call__(self) -> List[Object]:
        return list(self.values())

    def __getitem__(self, name: str) -> Object:
        paths = self._paths()
        numbered = re.fullmatch("bsdf_([1-9][0-9]*)", name)
        if name not in paths and numbered and int(numbered[1]) <= len(paths):  # by the number of its element
            return Object(self._scene, list(paths.values())[int(numbered[1]) - 1])
        if name not in paths:
            near = difflib.get_close_matches(name, paths, 1)
            raise KeyError(f"no {self._elements[0]} is named '{name}'" + (f", did you mean '{near[0]}'?" if near else ""))
        return Object(self._scene, paths[name])

    def __iter__(self) -> Iterator[str]:
        return iter(self._paths())

    def __len__(self) -> int:
        return len(self._paths())

    def __repr__(self) -> str:
        return f"<{len(self)} of {self._elements[0]}: {', '.join(self)}>"


class Scene:
    """A scene, made by load() or load_dict()."""

    def __init__(self, dictionary: Dict[str, Any], folder: str = ".", lenient: bool = False, **options: Any):
        with converted_errors():
            given = values("load", {"lenient": lenient, **options})
            self._take(native.Session(tree.scene_tree(dictionary), "dictionary", os.fspath(folder), given))

    @classmethod
    def _from_file(cls, file: str, options: List[str]) -> "Scene":
        with converted_errors():
            return cls._of(native.Session(file, options))

    @classmethod
    def _of(cls, session) -> "Scene":
        scene = cls.__new__(cls)
        scene._take(session)
        return scene

    def _take(self, session) -> None:
        self._session = session
        self._structure = 0
        for text in session.substitutions:
            warnings.warn(text, SheafWarning, stacklevel=4)

    @property
    def size(self) -> Tuple[int, int]:
        """Width and height of the frame, pixels."""
        return self._session.size

    @property
    def notes(self) -> List[str]:
        """Remarks about the scene that are no warnings."""
        return self._session.notes

    def _material_numbers(self) -> Dict[Tuple[int, ...], int]:
        """The numbers of BSDFs in Cryptomatte and hits, by path: in the order of reading, nested ones first."""
        with converted_errors():
            found = self._session.list(_KINDS["materials"])
            places: Dict[str, List[int]] = {}
            for number, where in enumerate(self._session.materials, 1):
                places.setdefault(where, []).append(number)
        out = {}
        for path, _, _, _, where in sorted(found, key=lambda entry: (*entry[0], float("inf"))):
            if places.get(where):
                out[tuple(path)] = places[where].pop(0)
        return out

    def _first(self, element: List[str]) -> Optional[Object]:
        with converted_errors():
            found = self._session.list(element)
        return Object(self, tuple(found[0][0])) if found and found[0][2] != tree.NO_SENSOR else None

    def _find_id(self, identity: str) -> Optional[Object]:
        with converted_errors():
            for path, _, known, _, _ in self._session.list(_OBJECT):
                if known == identity:
                    return Object(self, tuple(path))
        return None

    @property
    def camera(self) -> Object:
        """The first sensor."""
        self._require_sensor()
        return self._first(_KINDS["sensors"])

    def _require_sensor(self) -> None:
        if self._session.has_tree and self._first(_KINDS["sensors"]) is None:
            raise UsageError("the scene has no sensor: add one, or render with the argument `sensor`")

    @property
    def film(self) -> Object:
        """The film of the first sensor."""
        return self.camera.film

    @property
    def integrator(self) -> Object:
        """The integrator."""
        found = self._first(["integrator"])
        if found is None:
            raise UsageError("the scene has no integrator")
        return found

    @property
    def materials(self) -> Objects:
        """All BSDFs, also nested ones."""
        return Objects(self, _KINDS["materials"])

    @property
    def textures(self) -> Objects:
        """All textures."""
        return Objects(self, _KINDS["textures"])

    @property
    def shapes(self) -> Objects:
        """All shapes."""
        return Objects(self, _KINDS["shapes"])

    @property
    def lights(self) -> Objects:
        """All emitters, also those of shapes."""
        return Objects(self, _KINDS["lights"])

    emitters = lights

    @property
    def media(self) -> Objects:
        """All participating media."""
        return Objects(self, _KINDS["media"])

    @property
    def sensors(self) -> Objects:
        """All sensors."""
        return Objects(self, _KINDS["sensors"])

    def add(self, key: str, dictionary: Dict[str, Any]) -> Object:
        """Adds an object with this id."""
        element = tree.object_of(key, dictionary, f"dictionary.{key}")
        missing = self._find_id(tree.NO_SENSOR) if element[0] == "sensor" else None
        with converted_errors():
            self._session.set([((), missing._path[1][0] if missing else None, element)])
        self._structure += 1
        return self._find_id(key)

    def remove(self, key: str) -> None:
        """Removes the object with this id."""
        found = self._find_id(key)
        if found is None:
            raise KeyError(f"no object is named '{key}'")
        path = found._path[1]
        with converted_errors():
            self._session.remove(path[:-1], path[-1])
        self._structure += 1

    def __repr__(self) -> str:
        return f"<sheaf.Scene '{self._session.name}', {self.size[0]} x {self.size[1]} pixels>"


def load(file, defines: Optional[Dict[str, Any]] = None, lenient: bool = False, **options: Any) -> Scene:
    """Reads a scene or a model of any format that `sheaf render` reads.

    defines: values of the parameters `$name` of the scene. lenient: substitutes or drops what cannot be read, with
    warnings. options: as on the command line, see sheaf.options("load").
    """
    given = [f"{name}={value}" for name, value in (defines or {}).items()]
    return Scene._from_file(os.fspath(file), values("load", {"defines": given, "lenient": lenient, **options}))


def load_dict(dictionary: Dict[str, Any], folder: str = ".", lenient: bool = False,
              **options: Any) -> Union[Scene, Object]:
    """Makes a scene from a dictionary as Mitsuba's load_dict() does. Relative paths refer to `folder`.

    Of a dictionary of another plugin, makes an Object, which dictionaries may contain.
    """
    names = {name for names in tree.plugins().values() for name in names}
    if not isinstance(dictionary, dict) or dictionary.get("type") not in names:
        return Scene(dictionary, folder, lenient, **options)
    with converted_errors():
        given = values("load", {"lenient": lenient, **options})
        session = native.Session(tree.part_tree(dictionary), "dictionary", os.fspath(folder), given)
    return Object(Scene._of(session), (0,))
