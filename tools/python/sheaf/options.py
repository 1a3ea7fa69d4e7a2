"""Options of the command line as keyword arguments. Their list comes from the command line's own."""

import difflib
import functools
import os
from typing import Any, Dict, List

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


def _text(name: str, value: Any) -> str:
    if isinstance(value, (str, os.PathLike)):
        return os.fspath(value)
    if isinstance(value, bool):
        raise UsageError(f"{name} is {value}, expected a value")
    if hasattr(value, "__iter__"):
        return _SEPARATORS.get(name, ",").join(_text(name, each) for each in value)
    if hasattr(value, "item"):  # a number of NumPy
        value = value.item()
    if not isinstance(value, (int, float)):
        raise UsageError(f"{name} is a {type(value).__name__}, expected a number, a text or a sequence of these")
    return repr(value)


def words(function: str, given: Dict[str, Any]) -> List[str]:
    """The words of a command line with these options. None and False leave an option out."""
    table = _table(function)
    out = []
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
            out.append(f"--{option}")
        elif value is True and choices:  # an option that implies a value
            out += [f"--{option}"]
        elif repeats:
            out += [f"--{option}={each}" for each in value]
        else:
            out.append(f"--{option}={_text(name, value)}")
    return out
