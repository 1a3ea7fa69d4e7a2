"""Exceptions and warnings."""

import contextlib
import re
from typing import Iterator, Optional

from ._native import native


class SheafWarning(UserWarning):
    """A message about a scene or a render, as the command line prints it after "warning:"."""


class Error(Exception):
    """An error with a message for the user.

    file, line: location in the scene, of the first of several errors; None if unknown. kind: "runtime", "usage", "scene", "output" or "checkpoint".
    exit_code: that of the command line.
    """

    kind = "runtime"
    exit_code = 1

    def __init__(self, message: str, file: Optional[str] = None, line: Optional[int] = None):
        super().__init__(message)
        self.file = file
        self.line = line


class RuntimeError(Error, RuntimeError):  # pylint: disable=redefined-builtin
    """Something is missing or failed while running (exit code 1)."""


class UsageError(Error, ValueError):
    """An option or an argument is wrong (exit code 2)."""

    kind, exit_code = "usage", 2


class SceneError(Error):
    """The scene or a file of it is wrong (exit code 3)."""

    kind, exit_code = "scene", 3

    @classmethod
    def at(cls, file: str, message: str) -> "SceneError":
        """An error at a file, or at an entry of a dictionary."""
        return cls(f"{file}: {message}", file)


class OutputError(Error, OSError):
    """A file cannot be written (exit code 4)."""

    kind, exit_code = "output", 4


class CheckpointError(Error):
    """A checkpoint does not match (exit code 5)."""

    kind, exit_code = "checkpoint", 5


_BY_CODE = {kind.exit_code: kind for kind in (RuntimeError, UsageError, SceneError, OutputError, CheckpointError)}


@contextlib.contextmanager
def converted_errors() -> Iterator[None]:
    """Converts errors of the module in C++, where options have the names of the command line."""
    try:
        yield
    except native.NativeError as error:
        message, code, file, line = error.args
        message = re.sub(r"(?<![\w-])--([a-z][a-z-]*)", lambda m: m[1].replace("-", "_"), message)
        raise _BY_CODE.get(code, RuntimeError)(message, file, line) from None
