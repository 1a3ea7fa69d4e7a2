#!/usr/bin/env python3
"""Tests the Blender add-on without Blender: a fake `bpy` calls the engine, and the exporter is replaced by a program that
writes a small glTF file. Sheaf renders it. compare_cycles.py tests the exporter in Blender.

  tests/blender/test_sheaf_render.py --sheaf build/release/sheaf
"""

import argparse
import importlib.util
import json
import math
import struct
import subprocess
import sys
import tempfile
import types
import unittest
from pathlib import Path

try:
    import numpy as np
except ImportError:
    print("skipped: numpy is missing")
    sys.exit(0)

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
import fake_bpy  # noqa: E402


def load_addon(sheaf):
    fake_bpy.install(sheaf)
    file = HERE.parent.parent / "tools/blender/sheaf_render.py"
    spec = importlib.util.spec_from_file_location("sheaf_render", file)
    module = importlib.util.module_from_spec(spec)
    sys.modules["sheaf_render"] = module
    spec.loader.exec_module(module)
    return module


# An emissive square of 2 x 2 at z = -3 faces a camera at the origin. Written by the program that replaces the exporter.
EXPORTER = """
import json, struct, sys
job = json.load(open(sys.argv[1]))
corners = struct.pack("<12f", -1, -1, -3, 1, -1, -3, 1, 1, -3, -1, 1, -3) + struct.pack("<6H", 0, 1, 2, 0, 2, 3)
gltf = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}], "nodes": [{"mesh": 0}, {"camera": 0}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 1.0, "znear": 0.1}}],
        "materials": [{"emissiveFactor": [1, 0.5, 0.25]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-1, -1, -3],
                       "max": [1, 1, -3]}, {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"}],
        "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 12}],
        "buffers": [{"byteLength": 60}]}
text = json.dumps(gltf).encode()
text += b" " * (-len(text) % 4)
with open(job["model"], "wb") as file:
    file.write(struct.pack("<4sIIII", b"glTF", 2, 28 + len(text) + 60, len(text), 0x4E4F534A) + text)
    file.write(struct.pack("<II", 60, 0x004E4942) + corners)
json.dump({"environment": None, "shutter": 0, "warnings": ["light Lamp: its nodes are ignored"]}, open(job["result"], "w"))
"""


class RenderTest(unittest.TestCase):
    def render(self, settings=None, exporter=EXPORTER, breaks_after=None, **render):
        """Renders as Blender does. Returns the engine."""
        engine = addon.SheafEngine()
        engine.breaks_after = breaks_after
        scene = fake_bpy.scene({"samples": 4} | (settings or {}), **render)
        depsgraph = types.SimpleNamespace(scene=scene, view_layer=types.SimpleNamespace(name="ViewLayer"))
        addon.exporter_command = lambda job: [sys.executable, "-c", exporter, job]
        engine.update(fake_bpy.data(), depsgraph)
        engine.render(depsgraph)
        self.assertFalse(Path(engine.folder).exists())
        return engine

    def test_passes(self):
        engine = self.render()
        self.assertIn(("WARNING", "light Lamp: its nodes are ignored"), engine.reports)
        self.assertFalse([report for report in engine.reports if report[0] == "ERROR"])
        middle = (8, 12)
        self.assertEqual(engine.passes["Combined"].shape, (16, 24, 4))
        np.testing.assert_allclose(engine.passes["Combined"][middle], [1, 0.5, 0.25, 1], rtol=1e-3)
        np.testing.assert_allclose(engine.passes["Depth"][middle], 3, rtol=1e-3)
        np.testing.assert_allclose(engine.passes["Normal"][middle], [0, -1, 0], atol=1e-3)  # Blender's -y is glTF's +z
        self.assertEqual(engine.passes["Depth"][0, 0, 0], addon.FAR)
        self.assertTrue(engine.ended)

    def test_border_is_measured_from_the_bottom(self):
        whole = self.render().passes["Combined"]
        part = self.render(use_border=True, border_min_x=0.25, border_max_x=1, border_min_y=0, border_max_y=0.5)
        np.testing.assert_array_equal(part.passes["Combined"], whole[:8, 6:])

    def test_escape_keeps_the_unfinished_image(self):
        engine = self.render({"samples": 1 << 20}, breaks_after=2)
        self.assertGreaterEqual(len(engine.shown), 2)
        np.testing.assert_allclose(engine.shown[-1].reshape(16, 24, 4)[8, 12], [1, 0.5, 0.25, 1], rtol=1e-3)
        np.testing.assert_allclose(engine.passes["Combined"][8, 12], [1, 0.5, 0.25, 1], rtol=1e-3)
        self.assertFalse([report for report in engine.reports if report[0] == "ERROR"])
        self.assertLess(max(engine.progress), 1)

    def test_errors_are_reported(self):
        for settings, exporter, message in (
                ({"options": "--bogus 3"}, EXPORTER, "Sheaf: unknown option '--bogus'"),
                ({}, "raise SystemExit(3)", "the scene cannot be exported: Blender ends with the code 3"),
                ({}, "import json, sys; json.dump({'error': 'camera A: panoramic'}, open(json.load(open(sys.argv[1]))"
                     "['result'], 'w'))", "camera A: panoramic")):
            with self.subTest(message):
                errors = [text for kind, text in self.render(settings, exporter).reports if kind == "ERROR"]
                self.assertEqual(len(errors), 1)
                self.assertIn(message, errors[0])
        with self.assertRaisesRegex(addon.RenderError, "/nonexistent is not a program"):
            addon.find_sheaf("/nonexistent")


class LogicTest(unittest.TestCase):
    def test_command(self):
        job = {"model": "m.glb", "image": "i.exr"}
        settings = fake_bpy.scene({"samples": 9, "denoiser": "nlm", "noise_target": 0.02, "lenient": True,
                                   "options": "--rr-depth '3'"}).sheaf
        command = " ".join(addon.render_command("sheaf", settings, job, {"environment": "w.exr", "shutter": 2}, (40, 30),
                                                (5, 6, 20, 10), 3))
        for part in ("render m.glb -o i.exr", "--size 40x30", "--crop 5,6,25,16", "--env w.exr", "--spp 9",
                     "--denoise nlm", "--noise-target 0.02", "--time 0 --shutter 0:2", "--threads 3", "--lenient",
                     "--guiding=auto", "--rr-depth 3"):
            self.assertIn(part, command)
        self.assertNotIn("--integrator", command)

    def test_shutter(self):
        render = fake_bpy.scene({}, use_motion_blur=True).render
        for position, times in (("START", [3, 3.25, 3.5]), ("CENTER", [2.75, 3, 3.25]), ("END", [2.5, 2.75, 3])):
            render.motion_blur_position = position
            self.assertEqual(addon.shutter_times(render, 3.0), times)
        render.use_motion_blur = False
        self.assertEqual(addon.shutter_times(render, 3.0), [3.0])

    def test_lamps_have_the_area_and_the_direction_of_blender(self):
        def light(**values):
            return types.SimpleNamespace(**({"type": "AREA", "size": 2.0, "size_y": 0.5, "shape": "SQUARE",
                                             "shadow_soft_size": 0.5} | values))
        for lamp, area in ((light(), 4 * 3 * 2), (light(shape="RECTANGLE"), 2 * 0.5 * 6),
                           (light(shape="ELLIPSE"), math.pi * 0.25 * 6), (light(type="POINT"), math.pi)):
            vertices, triangles = addon.lamp_mesh(lamp, (3, 2, 1))
            self.assertAlmostEqual(addon.area_of(vertices, triangles) / area, 1, delta=0.05)
            a, b, c = (np.array(vertices[k]) for k in triangles[0])
            normal = np.cross(b - a, c - a)
            outwards = a + b + c if lamp.type == "POINT" else np.array([0, 0, -1])
            self.assertGreater(normal @ outwards, 0)

    def test_transmissive_materials_get_a_volume(self):
        gltf = {"materials": [{"extensions": {"KHR_materials_transmission": {"transmissionFactor": 1}}}, {},
                              {"extensions": {"KHR_materials_transmission": {"transmissionFactor": 1},
                                              "KHR_materials_volume": {"thicknessFactor": 0.1}}}]}
        with tempfile.TemporaryDirectory() as folder:
            file, tail = Path(folder) / "a.glb", struct.pack("<II", 4, 0x004E4942) + b"data"
            text = json.dumps(gltf).encode()
            text += b" " * (-len(text) % 4)
            file.write_bytes(struct.pack("<4sIIII", b"glTF", 2, 20 + len(text) + 12, len(text), 0x4E4F534A) + text + tail)
            addon.edit_glb(file, addon.complete_materials)
            data = file.read_bytes()
        length, = struct.unpack_from("<I", data, 12)
        out = json.loads(data[20:20 + length])
        self.assertEqual(struct.unpack_from("<I", data, 8)[0], len(data))
        self.assertEqual(data[20 + length:], tail)
        self.assertEqual(out["materials"][0]["extensions"]["KHR_materials_volume"], {"thicknessFactor": 1.0})
        self.assertEqual(out["materials"][2], gltf["materials"][2])
        self.assertEqual(out["extensionsUsed"], ["KHR_materials_volume"])

    def test_integrators_are_those_of_the_program(self):
        program = json.loads(subprocess.run([sheaf, "help", "--json"], capture_output=True, check=True).stdout)
        render, = [command for command in program["commands"] if command["name"] == "render"]
        option, = [option for option in render["options"] if "--integrator" in option["names"]]
        items = addon.SheafSettings.__annotations__["integrator"]["items"]
        self.assertGreater(len(items), 1)
        self.assertLessEqual({item[0] for item in items}, set(option["words"]))

    def test_registers_its_classes(self):
        bpy = sys.modules["bpy"]
        addon.register()
        self.assertEqual(set(bpy.registered), set(addon.CLASSES))
        addon.unregister()
        self.assertEqual(bpy.registered, [])


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--sheaf", required=True)
    sheaf = str(Path(parser.parse_args().sheaf).resolve())
    addon = load_addon(sheaf)
    unittest.main(argv=[sys.argv[0]])
