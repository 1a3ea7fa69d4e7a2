"""Sheaf, a physically based path tracer for the CPU.

    import sheaf
    scene = sheaf.load("scene.xml")
    sheaf.render(scene, spp=64).write("image.png")
"""

import warnings as _warnings
from typing import Any, Callable, Optional

from ._native import native as _module
from .errors import (CheckpointError, Error, OutputError, RuntimeError, SceneError, SheafWarning, UsageError,
                     converted_errors as _converted_errors)
from .options import options, values as _values
from .query import Bsdf, BsdfSample, Hits, bsdf, trace
from .result import Result, compare, denoise, merge, read_image
from .scene import Object, Objects, Scene, load, load_dict
from .transform import Transform

__version__ = _module.version
__all__ = ["Bsdf", "BsdfSample", "CheckpointError", "Error", "Hits", "Object", "Objects", "OutputError", "Result",
           "RuntimeError", "Scene", "SceneError", "SheafWarning", "Transform", "UsageError", "bsdf", "compare",
           "denoise", "load", "load_dict", "merge", "options", "read_image", "render", "trace"]


def render(scene: Scene, progress: Optional[Callable[[int, int], Any]] = None, stop: Any = None,
           **options: Any) -> Result:  # pylint: disable=redefined-outer-name
    """Renders a scene.

    progress(done, total): called with numbers of samples, at most ten times per second. stop: a threading.Event or a
    function that returns whether to stop. options: those of `sheaf render` with underscores, see sheaf.options().
    """
    if not isinstance(scene, Scene):
        raise UsageError(f"render() of a {type(scene).__name__}, expected a sheaf.Scene")
    for name, function in (("progress", progress), ("stop", getattr(stop, "is_set", stop))):
        if function is not None and not callable(function):
            raise UsageError(f"{name} is a {type(function).__name__}, expected a function")
    with _converted_errors():
        image = scene._session.render(_values("render", options), progress, getattr(stop, "is_set", stop))
    for text in image.warnings:
        _warnings.warn(text, SheafWarning, stacklevel=2)
    return Result(image)
