"""The parameters of a scene under flat names, as Mitsuba's traverse() lists them."""

import difflib
import re
from typing import Any, Dict, Iterable, Iterator, List, MutableMapping, NamedTuple, Optional, Tuple, Union

import numpy as np

from . import tree
from .errors import SceneError, UsageError, converted_errors
from .foreign import decoded
from .result import read_image
from .scene import _OBJECT, Object, Scene, _key

# Names of nested objects and of arrays in Mitsuba's traverse().
_NESTED = {"interior": "interior_medium", "exterior": "exterior_medium", "phase": "phase_function"}
_ARRAYS = {"vertex_positions": "vertices", "vertex_normals": "normals", "vertex_texcoords": "uv", "faces": "faces"}
_COLUMNS = {"vertices": 3, "normals": 3, "uv": 2, "faces": 3}
# Shapes that are triangle meshes, whose vertices can be set.
_MESHES = ("mesh", "obj", "ply", "serialized", "cube")
_COLORS = ("rgb", "srgb", "color", "spectrum")


class _Parameter(NamedTuple):
    owner: Tuple[int, ...]  # path of the object
    name: str               # in the scene format
    kind: str               # "value", "mesh", "film", "image" or "fov"


def smooth_normals(vertices: np.ndarray, faces: np.ndarray, shared: np.ndarray) -> np.ndarray:
    """Normals of the vertices, of unit length: means of the faces' normals by their angles (Thuermer and Wuethrich 1998).
    Vertices with equal rows of `shared` get the same one.
    """
    corners = vertices.astype(np.float64)[faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    _, place = np.unique(shared, axis=0, return_inverse=True)
    place = place.reshape(-1)
    sums = np.zeros((place.max() + 1, 3))
    for k in range(3):
        a, b = corners[:, (k + 1) % 3] - corners[:, k], corners[:, (k + 2) % 3] - corners[:, k]
        lengths = np.maximum(np.linalg.norm(a, axis=1) * np.linalg.norm(b, axis=1), 1e-300)
        angle = np.arccos(np.clip((a * b).sum(axis=1) / lengths, -1, 1))
        np.add.at(sums, place[faces[:, k]], angle[:, None] * normal)
    sums /= np.maximum(np.linalg.norm(sums, axis=1, keepdims=True), 1e-300)
    return sums[place].astype(np.float32)


class SceneParameters(MutableMapping[str, Any]):
    """The parameters of a scene by flat names such as "small-box.bsdf.reflectance.value".

    The names are Mitsuba's where it has them: ids or keys of objects, and the names of nested objects and parameters.
    Parameters of an object with an id are listed under that id, and also found under the objects that refer to it. New
    values take effect with update(), all at once. Colors and vectors are arrays; vertex_positions and other arrays of
    meshes are flat, in world space; setting the vertices computes normals again if the mesh has any.
    """

    def __init__(self, root: Union[Scene, Object]):
        self._object = root if isinstance(root, Object) else None
        self._scene: Scene = root._scene if isinstance(root, Object) else root
        self._changed: Dict[str, Any] = {}
        self._hidden: set = set()
        self._list()

    # Finding parameters

    def _at(self, path: Tuple[int, ...]) -> Object:
        if self._structure != self._scene._structure:
            raise UsageError("objects were added to the scene or removed: call traverse() again")
        return Object(self._scene, path)

    def _list(self) -> None:
        """Finds all parameters. Names are unique; the first one of a name is listed."""
        self._names: Dict[str, _Parameter] = {}
        self._prefixes: Dict[str, Tuple[int, ...]] = {}
        self._structure = self._scene._structure
        named = {path: name for objects in (self._scene.materials, self._scene.shapes, self._scene.lights,
                                            self._scene.textures, self._scene.media, self._scene.sensors)
                 for name, path in objects._paths().items()}
        if self._object is not None:
            self._add_object("", self._object._path[1], named)
        else:
            children = self._at(())._get()[2]
            for index, (element, _) in enumerate(children):
                if element in _OBJECT:
                    self._add_object(named.get((index,), element), (index,), named)

    def _add_object(self, prefix: str, path: Tuple[int, ...], named: Dict[Tuple[int, ...], str]) -> None:
        element, attributes, children, _ = self._at(path)._get()
        if "id" in attributes and prefix:
            prefix = attributes["id"]
        self._prefixes.setdefault(prefix, path)
        dot = prefix + "." if prefix else ""
        is_mesh = element in ("shape", "mesh") and attributes.get("type") in _MESHES
        for name in _ARRAYS if is_mesh else ():
            self._names.setdefault(dot + name, _Parameter(path, _ARRAYS[name], "mesh"))
        if element == "film":
            self._names.setdefault(dot + "size", _Parameter(path, "size", "film"))
        for index, (kind, given) in enumerate(children):
            name = given.get("name") or kind
            if kind in ("bsdf", "emitter") and element in ("shape", "mesh"):
                name = kind
            if kind in _OBJECT:
                self._add_object(dot + _NESTED.get(name, name), (*path, index), named)
            elif kind != "ref" and not (is_mesh and name in _COLUMNS):
                self._add_value(dot, path, name, kind, attributes.get("type", ""))

    def _add_value(self, dot: str, path: Tuple[int, ...], name: str, kind: str, plugin: str) -> None:
        if plugin == "bitmap" and name == "filename":
            self._names.setdefault(dot + "data", _Parameter(path, "data", "image"))
        elif plugin == "bitmap" and name == "data":
            self._names.setdefault(dot + "data", _Parameter(path, "data", "value"))
        elif name == "fov":
            self._names.setdefault(dot + "x_fov", _Parameter(path, "fov", "fov"))
        self._names.setdefault(dot + name + (".value" if kind in _COLORS else ""), _Parameter(path, name, "value"))

    def _owner(self, words: List[str]) -> Optional[Object]:
        """The object with this name, by ids and by references."""
        for count in range(len(words), -1, -1):
            path = self._prefixes.get(".".join(words[:count]))
            if path is None:
                continue
            found: Any = self._at(path)
            for word in words[count:]:
                plain = next((k for k, v in _NESTED.items() if v == word), word)
                if not isinstance(found, Object) or found._find(plain) is None:
                    break
                found = getattr(found, plain)
            else:
                return found if isinstance(found, Object) else None
        return None

    def _find(self, key: str) -> _Parameter:
        """The parameter of a name: as listed, with or without ".value", or through references."""
        if not isinstance(key, str):
            raise UsageError(f"the name of a parameter is a {type(key).__name__}, expected a text")
        for name in (key, key + ".value", key[:-len(".value")] if key.endswith(".value") else key):
            if name in self._names and name not in self._hidden:
                return self._names[name]
        words = (key[:-len(".value")] if key.endswith(".value") else key).split(".")
        owner = self._owner(words[:-1])
        if owner is not None:
            alias = SceneParameters(owner)._names
            hidden = {self._names[name] for name in self._hidden if name in self._names}
            for name in (words[-1], words[-1] + ".value"):
                if name in alias and alias[name] not in hidden:
                    return alias[name]
        near = difflib.get_close_matches(key, self, 1)
        raise KeyError(f"no parameter is named '{key}'" + (f", did you mean '{near[0]}'?" if near else ""))

    # Values

    def __getitem__(self, key: str) -> Any:
        if key in self._changed:
            return self._changed[key]
        at = self._find(key)
        owner = self._at(at.owner)
        if at.kind == "film":
            return np.array([owner.width, owner.height])
        if at.kind == "mesh":
            return self._mesh(at.owner).get(at.name, np.zeros(0, np.float32)).reshape(-1)
        if at.kind == "image":
            return self._image(owner)
        value = getattr(owner, at.name)
        if at.kind == "fov":
            return self._x_fov(owner, value)
        if isinstance(value, str) and value.startswith("#"):
            return decoded(np.array([int(value[k:k + 2], 16) for k in (1, 3, 5)]) / 255)
        return np.array(value) if isinstance(value, tuple) else value

    def _x_fov(self, camera: Object, fov: float, inverse: bool = False) -> float:
        """Converts between the horizontal field of view and that along the axis `fov_axis`, degrees."""
        axis = str(camera.fov_axis) if camera._find("fov_axis") else "x"
        width, height = self._scene.size
        along = {"x": width, "y": height, "diagonal": np.hypot(width, height), "smaller": min(width, height),
                 "larger": max(width, height)}.get(axis, width)
        ratio = along / width if inverse else width / along
        return float(np.degrees(2 * np.arctan(np.tan(np.radians(fov) / 2) * ratio)))

    def _image(self, texture: Object) -> np.ndarray:
        """The pixels of a texture's file, linear unless it is raw."""
        with converted_errors():
            file = self._scene._session.find_file(texture.filename, texture._get()[3])
        image = read_image(file)
        raw = texture.raw if texture._find("raw") else False
        is_float = str(file).lower().endswith((".exr", ".hdr", ".pfm"))
        return image._pixels().copy() if raw or is_float else decoded(image._pixels())

    def _mesh(self, path: Tuple[int, ...]) -> Dict[str, np.ndarray]:
        if len(path) != 1:
            raise UsageError("the vertices of a shape in a group cannot be changed")
        with converted_errors():
            return self._scene._session.mesh(path[0])

    def __setitem__(self, key: str, value: Any) -> None:
        self._find(key)
        self._changed[key] = value

    def __delitem__(self, key: str) -> None:
        self._find(key)
        self._hidden.add(key)
        self._changed.pop(key, None)

    def __iter__(self) -> Iterator[str]:
        return (name for name in self._names if name not in self._hidden)

    def __len__(self) -> int:
        return len(self._names) - len(self._hidden)

    def __contains__(self, key: object) -> bool:
        try:
            self._find(key)  # type: ignore[arg-type]
        except (KeyError, UsageError):
            return False
        return True

    def _ipython_key_completions_(self) -> List[str]:
        return list(self)

    def keep(self, keys: Union[str, Iterable[str]]) -> None:
        """Hides all parameters but these: a list of names, or a regular expression that matches whole names."""
        kept = {key for key in self if re.fullmatch(keys, key)} if isinstance(keys, str) else set(keys)
        for key in kept:
            self._find(key)
        self._hidden |= set(self._names) - kept

    # Changes

    def update(self, *others: Any, **more: Any) -> List[str]:
        """Sets these values as dict.update() does, and gives all new values to the scene. Returns the names of those.

        If the scene rejects one of them, it stays as it was.
        """
        super().update(*others, **more)
        changes, meshes = [], {}
        for key, value in self._changed.items():
            at = self._find(key)
            if at.kind == "mesh":
                meshes.setdefault(at.owner, {})[at.name] = value
            else:
                changes += self._changes(at, value)
        is_restructured = False
        for path, arrays in meshes.items():
            made = self._mesh_changes(path, arrays)
            is_restructured |= made[0][0] != path
            changes += made
        done = list(self._changed)
        self._changed.clear()
        if changes:
            with converted_errors():
                self._scene._session.set(changes)
        if is_restructured:  # objects have other numbers
            self._scene._structure += 1
            if self._object is not None:
                self._object = Object(self._scene, self._object._path[1])
            self._list()
        return done

    def _changes(self, at: _Parameter, value: Any) -> List[tuple]:
        owner = self._at(at.owner)
        element, _, _, where = owner._get()
        if at.kind == "film":
            width, height = (int(v) for v in value)
            return [self._change(owner, name, number) for name, number in (("width", width), ("height", height))]
        if at.kind == "fov":
            return [self._change(owner, "fov", self._x_fov(owner, float(value), inverse=True))]
        if at.kind == "image":
            index = owner._find("filename")[0]
            return [(at.owner, index, tree.array("data", np.asarray(value), where))]
        return [self._change(owner, at.name, value)]

    def _change(self, owner: Object, name: str, value: Any) -> tuple:
        """The change of one parameter. Colors remain colors."""
        element, _, _, where = owner._get()
        index, now, attributes = owner._find(name) or (None, None, {"name": name})
        place = f"{where}.{name}"
        name = attributes.get("name", name)
        if now in _COLORS and not isinstance(value, (str, dict)):
            return (owner._path[1], index, tree.color("rgb", name, value, place))
        return (owner._path[1], index, tree.property_of(name, value, element, place, now))

    def _mesh_changes(self, path: Tuple[int, ...], arrays: Dict[str, Any]) -> List[tuple]:
        """Changes of the arrays of a mesh; or the whole shape, as a mesh in world space, which keeps its material, light
        and media.
        """
        shape = self._at(path)
        element, attributes, children, where = shape._get()
        mesh = self._mesh(path)
        shared = np.concatenate([mesh["vertices"], mesh.get("normals", mesh["vertices"])], axis=1)
        for name, value in arrays.items():
            values = np.asarray(value)
            if values.size % _COLUMNS[name] != 0:
                raise SceneError.at(f"{where}.{name}",
                                    f"has {values.size} values, expected a multiple of {_COLUMNS[name]}")
            mesh[name] = values.reshape(-1, _COLUMNS[name])
        if "vertices" in arrays and "normals" in mesh and "normals" not in arrays and len(mesh["vertices"]) == len(shared):
            vertices = np.asarray(mesh["vertices"], dtype=np.float32)
            mesh["normals"] = smooth_normals(vertices, np.asarray(mesh["faces"]), shared)
            arrays = {**arrays, "normals": mesh["normals"]}
        found = {name: shape._find(name) for name in arrays}
        if attributes["type"] == "mesh" and all(found.values()) and not shape._find("to_world"):
            return [(path, found[name][0], tree.array(name, mesh[name], f"{where}.{name}")) for name in arrays]
        children = shape._element()[2]
        keep = [child for child in children
                if child[0] in (*_OBJECT, "ref") or _key(child[1].get("name", "")) == "facenormals"
                or tree.is_attribute(child[1].get("name", ""))]
        made = [tree.array(name, values, f"{where}.{name}") for name, values in mesh.items() if np.size(values)]
        return [(path[:-1], path[-1], (element, {**attributes, "type": "mesh"}, [*made, *keep], where))]

    def __repr__(self) -> str:
        rows = []
        for name in self:
            value = self._changed[name] if name in self._changed else None
            at = self._names[name]
            if at.kind == "mesh" or at.kind == "image":
                rows.append((name, "array"))
                continue
            value = self[name] if value is None else value
            if isinstance(value, np.ndarray):
                kind = "x".join(map(str, value.shape)) + f" {value.dtype}"
            else:
                kind = type(value).__name__
            rows.append((name, kind))
        width = max((len(name) for name, _ in rows), default=0)
        return "SceneParameters[\n" + "".join(f"  {name:{width}}  {kind}\n" for name, kind in rows) + "]"


def traverse(scene: Union[Scene, Object]) -> SceneParameters:
    """The parameters of a scene or an object under flat names, to read and to change; see SceneParameters."""
    if hasattr(type(scene), "_parameters"):
        return scene._parameters()
    if not isinstance(scene, (Scene, Object)):
        raise UsageError(f"traverse() of a {type(scene).__name__}, expected a sheaf.Scene")
    return SceneParameters(scene)
