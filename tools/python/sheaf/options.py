"""Options of the command line as keyword arguments. Their list comes from the command line's own."""

import difflib
import functools
import os
from typing import Any, Dict, List, Union

from ._native import native
from .errors import UsageError

_LISTS = {
    "render": native.render_options,
    "load": native.read_options,
    "write": native.output_options,
}
# Other names of options in Python.
_SYNONYMS = {"aovs": "aov", "defines": "define"}
# The separators of values with several numbers.
_SEPARATORS = {"size": "x", "samples": ":", "shutter": ":"}


@functools.lru_cache(maxsize=None)
def _table(function: str) -> Dict[str, tuple]:
    return {name.replace("-", "_"): (name, *rest) for name, *rest in _LISTS[function]()}


def options(function: str = "render") -> Dict[str, str]:
    """The keyword arguments of render(), load() or Result.write() with their help texts."""
    if function not in _LISTS:
        raise UsageError(f"options of '{function}': expected {', '.join(_LISTS)}")
    return {name: entry[1] for name, entry in _table(function).items()}


def _plain(name: str, value: Any) -> Any:
    """A text or a number."""
    if isinstance(value, (str, os.PathLike)):
        return os.fspath(value)
    if isinstance(value, bool):
        raise UsageError(f"{name} is {value}, expected a value")
    if hasattr(value, "item"):  # a number of NumPy
        value = value.item()
    if not isinstance(value, (int, float)):
        raise UsageError(f"{name} is a {type(value).__name__}, expected a number, a text or a sequence of these")
    return value


def _text(name: str, value: Any) -> str:
    if hasattr(value, "__iter__") and not isinstance(value, str):
        return _SEPARATORS.get(name, ",").join(_text(name, each) for each in value)
    value = _plain(name, value)
    return value if isinstance(value, str) else repr(value)


def _number(name: str, value: Any) -> Union[str, float, List[float]]:
    """A number, several numbers, or a text that C++ converts, such as "5%"."""
    if hasattr(value, "__iter__") and not isinstance(value, str):
        return [float(_plain(name, each)) for each in value]
    value = _plain(name, value)
    return value if isinstance(value, str) else float(value)


def values(function: str, given: Dict[str, Any]) -> Dict[str, Any]:
    """The values of options by their names on the command line. None and False leave an option out."""
    table = _table(function)
    out: Dict[str, Any] = {}
    for name, value in given.items():
        name = _SYNONYMS.get(name, name)
        if name not in table:
            near = difflib.get_close_matches(name, table, 1)
            raise UsageError(f"unknown option '{name}' of {function}()" + (f", did you mean '{near[0]}'?" if near else ""))
        option, _, kind, choices, repeats = table[name]
        if value is None or value is False:
            continue
        if kind == "flag":
            if value is not True:
                raise UsageError(f"{name} is {value!r}, expected True or False")
            out[option] = True
        elif value is True and choices:  # an option that implies a value
            out[option] = True
        elif repeats:
            texts = [str(each) for each in value]
            if texts:
                out[option] = texts
        elif kind in ("integer", "number", "time"):
            out[option] = _number(name, value)
        else:
            out[option] = _text(name, value)
    return out
