"""The part of Blender's Python modules that tools/blender/sheaf_render.py needs to render, without Blender: a scene with
settings, and an engine that records what the add-on reports and shows."""

import sys
import tempfile
import types
from pathlib import Path

import numpy as np


class Rect:
    """The pixels of a render pass."""

    def __init__(self, count):
        self.values = np.zeros(count, np.float32)

    def foreach_set(self, values):
        assert values.dtype == np.float32 and values.shape == self.values.shape, (values.dtype, values.shape)
        self.values[:] = values


class RenderEngine:
    camera_override = None
    wanted = {"Combined": 4, "Depth": 1, "Normal": 3}

    def __init__(self):
        self.reports, self.shown, self.progress, self.ended = [], [], [], False
        self.breaks_after = None  # number of images after which the user presses Esc

    def report(self, kind, text):
        self.reports.append((*kind, text))

    def update_stats(self, _stats, _info):
        pass

    def update_progress(self, progress):
        self.progress.append(progress)

    def test_break(self):
        return self.breaks_after is not None and len(self.shown) >= self.breaks_after

    def begin_result(self, _x, _y, width, height, layer=""):
        passes = {name: types.SimpleNamespace(rect=Rect(width * height * channels), shape=(height, width, channels))
                  for name, channels in self.wanted.items()}
        return types.SimpleNamespace(layers=[types.SimpleNamespace(name=layer, passes=passes)])

    def update_result(self, result):
        self.shown.append(result.layers[0].passes["Combined"].rect.values.copy())

    def end_result(self, result):
        self.ended = True
        self.passes = {name: part.rect.values.reshape(part.shape)
                       for name, part in result.layers[0].passes.items()}


def property_of(**keywords):
    return keywords


def install(sheaf):
    """Adds the module bpy. `sheaf`: the program in the preferences of the add-on."""
    module = types.ModuleType("bpy")
    module.types = types.SimpleNamespace(RenderEngine=RenderEngine, AddonPreferences=object, PropertyGroup=object,
                                         Panel=type("Panel", (), {}), Scene=type("Scene", (), {}))
    module.props = types.SimpleNamespace(**{name + "Property": property_of for name in (
        "String", "Int", "Float", "Bool", "Enum", "Pointer")})
    module.registered = []
    module.utils = types.SimpleNamespace(register_class=module.registered.append,
                                         unregister_class=module.registered.remove)
    module.app = types.SimpleNamespace(binary_path="", tempdir=tempfile.gettempdir())
    preferences = types.SimpleNamespace(program=sheaf)
    module.context = types.SimpleNamespace(preferences=types.SimpleNamespace(
        addons={"sheaf_render": types.SimpleNamespace(preferences=preferences)},
        filepaths=types.SimpleNamespace(use_scripts_auto_execute=False)))
    sys.modules["bpy"] = module
    return module


def scene(settings, **render):
    """A scene of 24 x 16 pixels with the default settings of the add-on, except `settings`."""
    out = types.SimpleNamespace(name="Scene", frame_current_final=3.0, camera=types.SimpleNamespace(name="Camera"))
    defaults = {name: keywords.get("default", False if keywords["name"] in {"Spectral", "Lenient"} else "")
                for name, keywords in sys.modules["sheaf_render"].SheafSettings.__annotations__.items()}
    out.sheaf = types.SimpleNamespace(**(defaults | settings))
    out.render = types.SimpleNamespace(**({
        "resolution_x": 48, "resolution_y": 32, "resolution_percentage": 50, "use_border": False, "border_min_x": 0.0,
        "border_max_x": 1.0, "border_min_y": 0.0, "border_max_y": 1.0, "film_transparent": False, "threads": 1,
        "use_multiview": False, "pixel_aspect_x": 1.0, "pixel_aspect_y": 1.0, "threads_mode": "FIXED",
        "use_motion_blur": False, "motion_blur_shutter": 0.5, "motion_blur_position": "CENTER"} | render))
    out.original = "the original scene"
    return out


def data():
    """bpy.data, which writes an empty file instead of a copy of the scene."""
    def write(path, _blocks, **_options):
        Path(path).write_bytes(b"")
    return types.SimpleNamespace(libraries=types.SimpleNamespace(write=write))
