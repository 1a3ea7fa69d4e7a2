"""Parameters under flat names: traverse()."""

import tempfile
import unittest
from pathlib import Path

import numpy as np

import scenes
import sheaf

T = sheaf.Transform


def room():
    """A floor with a box, a ball of a shared material and a lamp."""
    return sheaf.load_dict({
        "type": "scene", "integrator": {"type": "path", "max_depth": 4},
        "sensor": {"type": "perspective", "fov": 40, "to_world": T.look_at((0, 2, 6), (0, 0.5, 0), (0, 1, 0)),
                   "film": {"type": "hdrfilm", "width": 24, "height": 16}},
        "paint": {"type": "diffuse", "reflectance": {"type": "rgb", "value": (0.2, 0.4, 0.6)}},
        "floor": {"type": "rectangle", "to_world": T.rotate((1, 0, 0), -90).scale(4),
                  "bsdf": {"type": "ref", "id": "paint"}},
        "box": {"type": "cube", "to_world": T.translate((0.8, 0.5, 0)).scale(0.5)},
        "ball": {"type": "sphere", "center": (-0.9, 0.5, 0), "radius": 0.5,
                 "bsdf": {"type": "roughplastic", "alpha": 0.2, "diffuse_reflectance": "#ff8000"}},
        "lamp": {"type": "point", "position": (1, 4, 3), "intensity": {"type": "rgb", "value": (20, 20, 20)}},
        "sky": {"type": "constant", "radiance": {"type": "rgb", "value": (0.3, 0.4, 0.5)}},
    })


class Names(unittest.TestCase):
    def test_names_of_mitsuba(self):
        params = sheaf.traverse(room())
        for name in ("integrator.max_depth", "sensor.x_fov", "sensor.to_world", "sensor.film.size",
                     "paint.reflectance.value", "floor.to_world", "box.vertex_positions", "box.faces",
                     "ball.bsdf.diffuse_reflectance.value", "ball.bsdf.alpha", "lamp.position", "lamp.intensity.value",
                     "sky.radiance.value"):
            self.assertIn(name, params)
        listed = list(params)
        self.assertEqual(len(listed), len(set(listed)))
        self.assertEqual(params._ipython_key_completions_(), listed)
        self.assertIn("paint.reflectance.value", repr(params))

    def test_through_references_and_other_spellings(self):
        params = sheaf.traverse(room())
        for name in ("paint.reflectance", "floor.bsdf.reflectance.value", "floor.bsdf.reflectance"):
            np.testing.assert_array_equal(params[name], (0.2, 0.4, 0.6))
        self.assertEqual(params["ball.bsdf.alpha.value"], 0.2)
        np.testing.assert_allclose(params["ball.bsdf.diffuse_reflectance.value"], (1, 0.2158605, 0), rtol=1e-5)
        for name, message in (("paint.reflectanse", "did you mean 'paint.reflectance.value'"),
                              ("floor.bsdf.alpha", "no parameter"), ("nothing.at.all", "no parameter")):
            with self.assertRaisesRegex(KeyError, message):
                params[name]
            with self.assertRaises(KeyError):
                params[name] = 1
            self.assertNotIn(name, params)
        with self.assertRaises(sheaf.UsageError):
            params[3]
        self.assertNotIn(3, params)

    def test_keep_and_delete(self):
        params = sheaf.traverse(room())
        del params["sky.radiance.value"]
        self.assertNotIn("sky.radiance.value", params)
        params.keep(r".*\.reflectance\.value")
        self.assertEqual(list(params), ["paint.reflectance.value"])
        self.assertEqual(len(params), 1)
        with self.assertRaises(KeyError):
            params["lamp.position"]
        with self.assertRaises(KeyError):
            params.keep(["nothing"])

    def test_of_objects(self):
        scene = room()
        params = sheaf.traverse(scene.shapes["ball"])
        self.assertIn("bsdf.alpha", params)
        params["bsdf.alpha"] = 0.4
        params.update()
        self.assertEqual(scene.shapes["ball"].bsdf.alpha, 0.4)
        with self.assertRaisesRegex(sheaf.UsageError, "traverse\\(\\) of a dict"):
            sheaf.traverse({})

    def test_unnamed_objects_of_files(self):
        params = sheaf.traverse(scenes.cornell())
        self.assertIn("brick.reflectance.value", params)
        self.assertIn("floor.bsdf.reflectance.value", params)


class Changes(unittest.TestCase):
    def test_values_take_effect_with_update(self):
        scene = room()
        params = sheaf.traverse(scene)
        before = sheaf.render(scene, spp=4).image
        params["paint.reflectance.value"] = (0.6, 0.4, 0.2)
        params["lamp.intensity.value"] *= 2
        params["lamp.position"] += (0, 1, 0)
        params["sensor.to_world"] = T.translate((0, 0.5, 0)) @ params["sensor.to_world"]
        params["ball.bsdf.diffuse_reflectance"] = 0.5
        params["integrator.max_depth"] = 3
        np.testing.assert_array_equal(sheaf.render(scene, spp=4).image, before)
        self.assertEqual(len(params.update()), 6)
        self.assertEqual(params.update(), [])
        self.assertEqual(scene.materials["paint"].reflectance, (0.6, 0.4, 0.2))
        self.assertEqual(scene.lights["lamp"].intensity, (40, 40, 40))
        self.assertEqual(scene.lights["lamp"].position, (1, 5, 3))
        self.assertEqual(scene.integrator.max_depth, 3)
        self.assertGreater(np.abs(sheaf.render(scene, spp=4).image - before).mean(), 0.01)
        params.update({"paint.reflectance.value": "#ffffff"}, **{"integrator.max_depth": 2})
        np.testing.assert_array_equal(params["paint.reflectance"], 1)

    def test_rejected_values_leave_the_scene(self):
        scene = room()
        params = sheaf.traverse(scene)
        params["lamp.position"] = (9, 9, 9)
        params["paint.reflectance.value"] = (3, 0, 0)
        with self.assertRaises(sheaf.SceneError):
            params.update()
        self.assertEqual(scene.lights["lamp"].position, (1, 4, 3))
        params["box.vertex_positions"] = np.zeros(7)
        with self.assertRaisesRegex(sheaf.SceneError, "box.vertices: has 7 values"):
            params.update()

    def test_film_and_field_of_view(self):
        scene = room()
        params = sheaf.traverse(scene)
        np.testing.assert_array_equal(params["sensor.film.size"], (24, 16))
        params["sensor.film.size"] = (12, 20)
        params.update()
        self.assertEqual(scene.size, (12, 20))
        self.assertAlmostEqual(params["sensor.x_fov"], 40)
        scene.camera.fov_axis = "y"
        params = sheaf.traverse(scene)
        expected = np.degrees(2 * np.arctan(np.tan(np.radians(20)) * 12 / 20))
        self.assertAlmostEqual(params["sensor.x_fov"], expected)
        params["sensor.x_fov"] = expected
        params.update()
        self.assertAlmostEqual(scene.camera.fov, 40, places=5)

    def test_textures(self):
        data = np.full((2, 2, 3), 0.25, dtype=np.float32)
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "texture.png"
            sheaf._native.native.Image.from_array(data).write(str(file), {})
            for texture in ({"data": data}, {"filename": "texture.png"}):
                material = {"type": "diffuse", "reflectance": {"type": "bitmap", "filter_type": "nearest", **texture}}
                scene = sheaf.load_dict(scenes.wall(bsdf=material), folder=folder)
                params = sheaf.traverse(scene)
                np.testing.assert_allclose(params["square.bsdf.reflectance.data"], 0.25, atol=0.004)
                params["square.bsdf.reflectance.data"] = np.full((4, 4, 3), (0.5, 0.1, 0.2))
                params.update()
                found = sheaf.render(scene, spp=4, aovs=["albedo"])["albedo"]
                np.testing.assert_allclose(found[2, 2], (0.5, 0.1, 0.2), rtol=1e-3)


class Vertices(unittest.TestCase):
    def test_cube(self):
        """Vertices of a cube are in world space, and its corners stay sharp."""
        scene = room()
        params = sheaf.traverse(scene)
        vertices = params["box.vertex_positions"].reshape(-1, 3)
        np.testing.assert_allclose([vertices.min(axis=0), vertices.max(axis=0)], [(0.3, 0, -0.5), (1.3, 1, 0.5)], atol=1e-6)
        vertices[:, 1] *= 2
        params["box.vertex_positions"] = vertices
        params.update()
        expected = room()
        expected.shapes["box"].to_world = T.translate((0.8, 1, 0)).scale((0.5, 1, 0.5))
        options = {"spp": 4, "aovs": ["normal", "depth"]}
        mine, theirs = sheaf.render(scene, **options), sheaf.render(expected, **options)
        np.testing.assert_allclose(mine["depth"], theirs["depth"], rtol=1e-5, atol=1e-5)
        np.testing.assert_allclose(mine["normal"], theirs["normal"], atol=2e-3)
        np.testing.assert_allclose(mine.image, theirs.image, atol=2e-3)
        # Again, now that the shape is a mesh of arrays
        params["box.vertex_positions"] = params["box.vertex_positions"] * 0.5
        params.update()
        self.assertAlmostEqual(float(params["box.vertex_positions"].max()), 1)

    def test_files_and_normals(self):
        """A sphere of a file stays smooth when it becomes an ellipsoid."""
        angle = np.linspace(0.2, np.pi - 0.2, 20)[:, None]
        around = np.linspace(0, 2 * np.pi, 40, endpoint=False)[None]
        points = np.stack([np.sin(angle) * np.cos(around), np.cos(angle) + 0 * around, np.sin(angle) * np.sin(around)], -1)
        points = points.reshape(-1, 3)
        with tempfile.TemporaryDirectory() as folder:
            lines = [f"v {x} {y} {z}" for x, y, z in points]
            for i in range(19):
                for k in range(40):
                    a, b = 40 * i + k + 1, 40 * i + (k + 1) % 40 + 1
                    lines.append(f"f {a} {b} {b + 40} {a + 40}")
            (Path(folder) / "ball.obj").write_text("\n".join(lines), encoding="utf-8")
            more = {"ball": {"type": "obj", "filename": "ball.obj", "bsdf": {"type": "diffuse"}}}
            scene = sheaf.load_dict(scenes.wall({"to_world": T.translate((0, 0, -5))}, **more), folder=folder)
            params = sheaf.traverse(scene)
            scaled = params["ball.vertex_positions"].reshape(-1, 3) * (1, 3, 1)
            params["ball.vertex_positions"] = scaled
            params.update()
            normals = params["ball.vertex_normals"].reshape(-1, 3)
            expected = scaled / (1, 9, 1)
            expected /= np.linalg.norm(expected, axis=1, keepdims=True)
            middle = np.abs(scaled[:, 1]) < 2
            self.assertGreater((normals * expected).sum(axis=1)[middle].min(), 0.999)
            self.assertEqual(scene.shapes["ball"].bsdf.type, "diffuse")

    def test_arrays(self):
        scene = sheaf.load_dict(scenes.wall())
        params = sheaf.traverse(scene)
        np.testing.assert_array_equal(params["square.faces"], scenes.FACES.ravel())
        material = scene.shapes["square"].bsdf
        params["square.vertex_positions"] = 0.5 * scenes.VERTICES.ravel()
        params["square.vertex_texcoords"] = scenes.UV * 0.5
        params.update()
        self.assertEqual(material.type, "diffuse")  # in place: other objects stay valid
        np.testing.assert_array_equal(scene.shapes["square"].vertices, 0.5 * scenes.VERTICES)

    def test_only_the_changed_geometry_is_rebuilt(self):
        """The first change of vertices builds a structure that later ones update. Images equal those of new scenes."""
        def dictionary(height):
            vertices = scenes.VERTICES * (1, height, 1)
            return scenes.wall({"vertices": vertices}, **{f"ball_{k}": {
                "type": "cube", "to_world": T.translate((0.6 * k - 0.9, 0.3 * k - 0.3, 0.3)).scale(0.1)} for k in range(4)})

        scene = sheaf.load_dict(dictionary(1))
        params = sheaf.traverse(scene)
        for step, height in enumerate((1, 0.5, 0.25, 0.75, 0.75)):
            params["square.vertex_positions"] = scenes.VERTICES * (1, height, 1)
            params.update()
            result = sheaf.render(scene, spp=16, size=(24, 18))
            self.assertEqual(result.stats["kept"]["acceleration_structure"], step > 1, step)
            expected = sheaf.render(sheaf.load_dict(dictionary(height)), spp=16, size=(24, 18))
            np.testing.assert_allclose(result.image, expected.image, rtol=1e-4, atol=1e-4)
        scene.camera.fov = 30
        self.assertTrue(sheaf.render(scene, spp=1).stats["kept"]["acceleration_structure"])

    def test_groups_are_rejected(self):
        scene = sheaf.load_dict(scenes.wall(group={"type": "shapegroup", "inner": {"type": "cube"}}))
        params = sheaf.traverse(scene)
        name = next(each for each in params if each.endswith("inner.vertex_positions"))
        with self.assertRaisesRegex(sheaf.UsageError, "in a group"):
            params[name]

    def test_stale_parameters(self):
        scene = room()
        params = sheaf.traverse(scene)
        scene.remove("sky")
        with self.assertRaisesRegex(sheaf.UsageError, "traverse\\(\\) again"):
            params["lamp.position"]


if __name__ == "__main__":
    unittest.main()
