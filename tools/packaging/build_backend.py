"""Build backend of the Python package: that of scikit-build-core, with a line about what it builds. pip shows the output
of backends only with -v, so the line goes to the terminal."""

import os
import sys

from scikit_build_core import build as _backend
from scikit_build_core.build import *  # noqa: F403, the hooks that are not replaced below

CORE_MINUTES = 10  # on an AMD EPYC of 2021


def announce():
    """Writes what is built, and how long it takes about."""
    cores = len(os.sched_getaffinity(0))
    minutes = max(1, round(CORE_MINUTES / cores))
    text = (f"\nsheaf: compiling the program and the Python module for this processor takes about {minutes} "
            f"minute{'s' if minutes > 1 else ''} on {cores} core{'s' if cores > 1 else ''} "
            "(`pip install -v .` shows each file)\n")
    try:
        with open("/dev/tty", "w", encoding="utf-8") as terminal:
            terminal.write(text)
    except OSError:  # no terminal
        sys.stderr.write(text)


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    announce()
    return _backend.build_wheel(wheel_directory, config_settings, metadata_directory)


def build_editable(wheel_directory, config_settings=None, metadata_directory=None):
    announce()
    return _backend.build_editable(wheel_directory, config_settings, metadata_directory)
