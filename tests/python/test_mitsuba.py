"""Dictionaries and scripts of Mitsuba 3. Tests that need the package `mitsuba` are skipped where it is missing."""

import contextlib
import io
import os
import pickle
import re
import runpy
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np

import scenes
import sheaf
import sheaf.mitsuba as mi

try:
    import mitsuba
    mitsuba.set_variant("scalar_rgb")
except ImportError:
    mitsuba = None

SCRIPTS = scenes.ROOT / "tools/python/examples/mitsuba"
# Scripts whose images must equal Mitsuba's, with the largest difference of means. The two Cornell boxes differ.
COMPARED = {"editing_a_scene": 0.01, "image_io": 0.002, "layers": 0.02, "mesh_io": 0.01, "multi_view": 0.01,
            "ray_casting": 1e-5, "textures": 0.01, "transforms": 1e-6, "volumes": 0.02}


def arrays_of(folder):
    """The images and arrays that a script has written."""
    out = {file.name: np.load(file) for file in Path(folder).glob("*.npy")}
    out.update({file.name: np.array(sheaf.read_image(file)) for file in Path(folder).glob("*.exr")})
    return out


def run_in(folder, run):
    before = os.getcwd()
    os.chdir(folder)
    try:
        run()
    finally:
        os.chdir(before)


class Scripts(unittest.TestCase):
    def test_scripts(self):
        """Each runs, and writes what Mitsuba writes. Lines that differ have Mitsuba's line as a comment."""
        scripts = sorted(SCRIPTS.glob("*.py"))
        self.assertEqual(len(scripts), 10)
        for script in scripts:
            with self.subTest(script.stem), tempfile.TemporaryDirectory() as mine, tempfile.TemporaryDirectory() as theirs:
                with contextlib.redirect_stdout(io.StringIO()):
                    run_in(mine, lambda: runpy.run_path(str(script), run_name="__main__"))
                found = arrays_of(mine)
                self.assertTrue(found)
                if mitsuba is None or script.stem not in COMPARED:
                    continue
                text = script.read_text(encoding="utf-8")
                text = re.sub(r"^( *).*  # Mitsuba: ?(.*)$", r"\1\2", text, flags=re.MULTILINE)
                self.assertNotIn("sheaf", text)
                (Path(theirs) / "script.py").write_text(text, encoding="utf-8")
                subprocess.run([sys.executable, "script.py"], cwd=theirs, check=True, stdout=subprocess.DEVNULL)
                expected = arrays_of(theirs)
                self.assertEqual(set(found), set(expected))
                for name, values in expected.items():
                    axes = tuple(range(min(values.ndim, 2)))
                    np.testing.assert_allclose(found[name].mean(axis=axes), values.mean(axis=axes), err_msg=name,
                                               rtol=COMPARED[script.stem], atol=COMPARED[script.stem])


@unittest.skipIf(mitsuba is None, "needs the package mitsuba")
class Values(unittest.TestCase):
    """Values of Mitsuba's types in dictionaries."""

    def test_cornell_box(self):
        dictionary = mitsuba.cornell_box()
        dictionary["sensor"]["film"].update(width=64, height=64)
        result = sheaf.render(sheaf.load_dict(dictionary), spp=64)
        expected = np.array(mitsuba.render(mitsuba.load_dict(dictionary), spp=256))
        np.testing.assert_allclose(result.image[..., :3].mean(axis=(0, 1)), expected.mean(axis=(0, 1)), rtol=0.03)
        half = [image[:, :32].mean(axis=(0, 1))[:3] for image in (result.image, expected)]
        np.testing.assert_allclose(*half, rtol=0.05)

    def test_transforms(self):
        theirs = mitsuba.ScalarTransform4f().translate([1, 2, 3]).rotate([0, 1, 0], 30)
        mine = sheaf.Transform().translate((1, 2, 3)).rotate((0, 1, 0), 30)
        np.testing.assert_allclose(sheaf.Transform(theirs).matrix, mine.matrix, atol=1e-6)
        np.testing.assert_allclose((mine @ theirs).matrix, (mine @ mine).matrix, atol=1e-5)
        scene = sheaf.load_dict(scenes.wall({"to_world": theirs}))
        np.testing.assert_allclose(scene.shapes["square"].to_world.matrix, mine.matrix, atol=1e-6)
        scene.shapes["square"].to_world = mitsuba.ScalarTransform4f().scale(2)
        np.testing.assert_allclose(scene.shapes["square"].to_world.matrix, np.diag([2, 2, 2, 1]))

    def test_numbers_and_points(self):
        scene = sheaf.load_dict(scenes.wall(ball={"type": "sphere", "center": mitsuba.ScalarPoint3f(1, 2, 3),
                                                  "radius": mitsuba.Float(2)}))
        self.assertEqual((scene.shapes["ball"].center, scene.shapes["ball"].radius), ((1, 2, 3), 2))

    def test_bitmaps(self):
        def albedo(pixels):
            material = {"type": "diffuse", "reflectance": {"type": "bitmap", "bitmap": pixels}}
            scene = sheaf.load_dict(scenes.wall(bsdf=material))
            return sheaf.render(scene, spp=4, aovs=["albedo"])["albedo"][2, 2, 0]

        byte = np.full((2, 2, 3), 128, np.uint8)
        linear = ((128 / 255 + 0.055) / 1.055) ** 2.4
        self.assertAlmostEqual(albedo(mitsuba.Bitmap(byte)), linear, places=3)
        raw = mitsuba.Bitmap(byte)
        raw.set_srgb_gamma(False)
        self.assertAlmostEqual(albedo(raw), 128 / 255, places=3)
        self.assertAlmostEqual(albedo(mitsuba.Bitmap(np.full((2, 2, 3), 0.25, np.float32))), 0.25, places=3)
        words = mitsuba.Bitmap(byte).convert(component_format=mitsuba.Struct.Type.UInt16)
        self.assertAlmostEqual(albedo(words), linear, places=3)

    def test_environment_map(self):
        sky = {"type": "envmap", "bitmap": mitsuba.Bitmap(np.full((4, 8, 3), 2, np.float32))}
        scene = sheaf.load_dict(scenes.wall(sky=sky))
        np.testing.assert_allclose(sheaf.render(scene, spp=64).image[..., :3].mean(axis=(0, 1)), (0.4, 0.8, 1.2), rtol=0.05)

    def test_meshes(self):
        mesh = mitsuba.Mesh("square", 4, 2, has_vertex_texcoords=True)
        params = mitsuba.traverse(mesh)
        params["vertex_positions"], params["faces"] = scenes.VERTICES.ravel(), scenes.FACES.ravel()
        params["vertex_texcoords"] = scenes.UV.ravel()
        params.update()
        mesh.add_attribute("vertex_color", 3, [0.25] * 12)
        dictionary = scenes.wall()
        dictionary["square"] = mesh
        scene = sheaf.load_dict(dictionary)
        square = scene.shapes["square"]
        np.testing.assert_array_equal(square.vertices, scenes.VERTICES)
        np.testing.assert_array_equal(square.faces, scenes.FACES)
        np.testing.assert_array_equal(square.uv, scenes.UV)
        np.testing.assert_allclose(square.vertex_color, 0.25)
        np.testing.assert_allclose(sheaf.render(scene, spp=16).image[..., :3].mean(), 0.5, rtol=0.05)
        shiny = mitsuba.load_dict({"type": "cube", "bsdf": {"type": "plastic"}})
        with self.assertRaisesRegex(sheaf.SceneError, "dictionary.square: is a mesh whose BSDF"):
            sheaf.load_dict({**dictionary, "square": shiny})

    def test_names_of_parameters(self):
        """Names that Mitsuba lists for a scene exist, but for those of its sampling."""
        dictionary = scenes.wall(ball={"type": "sphere", "to_world": mitsuba.ScalarTransform4f().scale(2), "bsdf": {
            "type": "roughconductor", "alpha": 0.3}})
        dictionary["square"] = {"type": "cube", "emitter": {"type": "area", "radiance": {"type": "rgb", "value": 3.0}}}
        dictionary["camera"]["to_world"] = mitsuba.ScalarTransform4f().look_at([0, 0, 3], [0, 0, 0], [0, 1, 0])
        theirs = set(mitsuba.traverse(mitsuba.load_dict(dictionary)).keys())
        mine = sheaf.traverse(sheaf.load_dict(dictionary))
        for name in ("square.vertex_positions", "square.emitter.radiance.value", "ball.to_world", "ball.bsdf.alpha.value",
                     "camera.to_world", "camera.x_fov", "camera.film.size"):
            self.assertIn(name, theirs)
            self.assertIn(name, mine)


class Names(unittest.TestCase):
    """The names of sheaf.mitsuba."""

    def test_documentation(self):
        text = (scenes.ROOT / "docs" / "python.md").read_text(encoding="utf-8")
        for name in mi.__all__:
            self.assertTrue(getattr(mi, name).__doc__, name)
            self.assertRegex(text, rf"\b{name}\b")

    def test_variants(self):
        mi.set_variant("llvm_ad_rgb", "scalar_rgb")
        self.assertEqual(mi.variant(), "llvm_ad_rgb")
        mi.set_variant("scalar_spectral")
        scene = mi.load_dict(scenes.wall())
        spectral = mi.render(scene, spp=64)
        mi.set_variant("scalar_rgb")
        np.testing.assert_allclose(spectral.mean(axis=(0, 1))[:3], (0.2, 0.4, 0.6), rtol=0.1)
        for names in ((), ("scalar_mono",), ("scalar_rgb_polarized",)):
            with self.assertRaisesRegex(sheaf.UsageError, "expected names such as"):
                mi.set_variant(*names)

    def test_channels(self):
        for pixel_format, channels in (("rgb", 3), ("rgba", 4), ("luminance", 1)):
            dictionary = scenes.wall()
            dictionary["camera"]["film"]["pixel_format"] = pixel_format
            image = mi.render(mi.load_dict(dictionary), spp=4)
            self.assertEqual((image.shape, image.dtype), ((6, 8, channels), np.float32))
        dictionary["integrator"] = {"type": "aov", "aovs": "a:depht", "image": {"type": "path"}}
        with self.assertRaisesRegex(sheaf.UsageError, "unknown layer 'depht'"):
            mi.render(mi.load_dict(dictionary), spp=1)

    def test_bitmaps(self):
        values = np.linspace(0, 1, 6 * 4 * 3, dtype=np.float32).reshape(4, 6, 3)
        bitmap = mi.Bitmap(values)
        self.assertEqual((bitmap.width(), bitmap.height(), bitmap.channel_count(), bitmap.pixel_format(),
                          bitmap.component_format(), bitmap.srgb_gamma()), (6, 4, 3, "rgb", "float32", False))
        encoded = bitmap.convert("rgba", mi.Struct.Type.UInt8, True)
        self.assertEqual(encoded.channel_count(), 4)
        self.assertTrue((np.array(encoded)[..., 3] == 255).all())
        back = encoded.convert("rgb", "float32", False)
        np.testing.assert_allclose(np.array(back), values, atol=0.005)
        self.assertEqual(pickle.loads(pickle.dumps(encoded)), encoded)
        self.assertTrue(encoded._repr_png_().startswith(b"\x89PNG"))
        self.assertIn("6 x 4", repr(encoded))
        self.assertEqual([name for name, _ in bitmap.split()], ["root"])
        with self.assertRaises(sheaf.UsageError):
            mi.Bitmap(np.zeros(3))
        with tempfile.TemporaryDirectory() as folder:
            result = sheaf.render(sheaf.load_dict(scenes.wall()), spp=1, aovs=["albedo"])
            result.write(Path(folder) / "layers.exr")
            self.assertIn("albedo", dict(mi.Bitmap(Path(folder) / "layers.exr").split()))
            mi.util.write_bitmap(Path(folder) / "a.png", values)
            self.assertEqual(np.array(mi.Bitmap(Path(folder) / "a.png")).dtype, np.uint8)
            self.assertEqual(mi.util.convert_to_bitmap(values).component_format(), "uint8")

    def test_meshes(self):
        mesh = mi.Mesh("square", 4, 2, has_vertex_normals=True, has_vertex_texcoords=True)
        params = mi.traverse(mesh)
        params.update(vertex_positions=scenes.VERTICES, faces=scenes.FACES.ravel(), vertex_texcoords=scenes.UV)
        mesh.add_attribute("face_heat", 1, [1, 2])
        self.assertEqual((mesh.vertex_count(), mesh.face_count(), mesh.id()), (4, 2, "square"))
        dictionary = scenes.wall()
        dictionary["square"] = mesh
        square = mi.load_dict(dictionary).shapes["square"]
        np.testing.assert_allclose(square.normals, [(0, 0, 1)] * 4)
        np.testing.assert_array_equal(square.face_heat, (1, 2))
        with tempfile.TemporaryDirectory() as folder:
            mesh.write_ply(Path(folder) / "a.ply")
            dictionary["square"] = {"type": "ply", "filename": str(Path(folder) / "a.ply")}
            params = mi.traverse(mi.load_dict(dictionary))
            np.testing.assert_array_equal(params["square.vertex_texcoords"], scenes.UV.ravel())


if __name__ == "__main__":
    unittest.main()
