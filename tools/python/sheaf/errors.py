"""Exceptions and warnings."""

import contextlib
import os
import re
from typing import Iterator, Optional

from ._native import native


class SheafWarning(UserWarning):
    """A message about a scene or a render, as the command line prints it after "warning:"."""


class Error(Exception):
    """An error with a message for the user.

    file, line: location in the scene; None if unknown. kind: "runtime", "usage", "scene", "output" or "checkpoint".
    exit_code: that of the command line.
    """

    kind = "runtime"
    exit_code = 1

    def __init__(self, message: str):
        super().__init__(message)
        self.file: Optional[str] = None
        self.line: Optional[int] = None
        located = re.match(r"(?P<file>.+?):(?P<line>\d+): ", message)
        start = message.split(": ", 1)[0]
        if located:
            self.file, self.line = located["file"], int(located["line"])
        elif " " not in start and start != message or os.path.exists(start):
            self.file = start


class RuntimeError(Error, RuntimeError):  # pylint: disable=redefined-builtin
    """Something is missing or failed while running (exit code 1)."""


class UsageError(Error, ValueError):
    """An option or an argument is wrong (exit code 2)."""

    kind, exit_code = "usage", 2


class SceneError(Error):
    """The scene or a file of it is wrong (exit code 3)."""

    kind, exit_code = "scene", 3


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
        message, code = error.args
        message = re.sub(r"(?<![\w-])--([a-z][a-z-]*)", lambda m: m[1].replace("-", "_"), message)
        raise _BY_CODE.get(code, RuntimeError)(message) from None
