"""Sheaf, a physically based path tracer for the CPU.

    import sheaf
    scene = sheaf.load("scene.xml")
    sheaf.render(scene, spp=64).write("image.png")
"""

import warnings as _warnings
from typing import Any, Callable, Dict, Optional, Union

from ._native import native as _module
from .errors import (CheckpointError, Error, OutputError, RuntimeError, SceneError, SheafWarning, UsageError,
                     converted_errors as _converted_errors)
from .options import options, values as _values
from .parameters import SceneParameters, traverse
from .progress import bar_for as _bar_for
from .query import Bsdf, BsdfSample, Hits, bsdf, trace
from .result import Result, compare, denoise, merge, read_image
from .scene import Object, Objects, Scene, load, load_dict
from .transform import Transform
from .tree import object_of as _object_of

__version__ = _module.version
__all__ = ["Bsdf", "BsdfSample", "CheckpointError", "Error", "Hits", "Object", "Objects", "OutputError", "Result",
           "RuntimeError", "Scene", "SceneError", "SceneParameters", "SheafWarning", "Transform", "UsageError", "bsdf",
           "compare", "denoise", "load", "load_dict", "merge", "options", "read_image", "render", "trace", "traverse"]


def _replacements(scene: Scene, sensor: Any, integrator: Any) -> list:
    """The elements of another sensor and integrator."""
    if isinstance(sensor, int) and not isinstance(sensor, bool):
        sensors = scene.sensors()
        if not 0 <= sensor < len(sensors):
            raise UsageError(f"sensor {sensor} does not exist: the scene has {len(sensors)}")
        sensor = sensors[sensor]
    return [_object_of(key, value, key) for key, value in (("sensor", sensor), ("integrator", integrator))
            if value is not None]


def render(scene: Scene, progress: Union[Callable[[int, int], Any], bool, None] = None, stop: Any = None,
           sensor: Union[Object, Dict[str, Any], int, None] = None,
           integrator: Union[Object, Dict[str, Any], str, None] = None,
           **options: Any) -> Result:  # pylint: disable=redefined-outer-name
    """Renders a scene.

    progress(done, total): called with numbers of samples, at most ten times per second; True shows a bar, None does so
    in notebooks. stop: a threading.Event or a function that returns whether to stop. sensor: a sensor of the scene by its
    number, an Object or a dictionary, instead of the first one. integrator: the name of one, an Object or a dictionary,
    instead of the scene's. options: those of `sheaf render` with underscores, see sheaf.options(). Several threads may
    render a scene: their calls wait for each other.
    """
    if not isinstance(scene, Scene):
        raise UsageError(f"render() of a {type(scene).__name__}, expected a sheaf.Scene")
    shown = _bar_for(progress)
    for name, function in (("progress", shown), ("stop", getattr(stop, "is_set", stop))):
        if function is not None and not callable(function):
            raise UsageError(f"{name} is a {type(function).__name__}, expected a function")
    if isinstance(integrator, str):
        options["integrator"], integrator = integrator, None
    if sensor is None:
        scene._require_sensor()
    replaced = _replacements(scene, sensor, integrator)
    try:
        with _converted_errors():
            image = scene._session.render(_values("render", options), replaced, shown, getattr(stop, "is_set", stop))
    finally:
        if shown is not progress and hasattr(shown, "close"):
            shown.close()
    for text in image.warnings:
        _warnings.warn(text, SheafWarning, stacklevel=2)
    return Result(image)
