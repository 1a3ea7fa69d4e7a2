"""Scenes from dictionaries, arrays, and changes."""

import tempfile
import unittest
from pathlib import Path

import numpy as np

import scenes
import sheaf

T = sheaf.Transform


def color(dictionary, spp=16, **options):
    """The mean color of the image."""
    scene = dictionary if isinstance(dictionary, sheaf.Scene) else sheaf.load_dict(dictionary)
    return sheaf.render(scene, spp=spp, **options).image[..., :3].mean(axis=(0, 1))


class Dictionaries(unittest.TestCase):
    def test_equal_to_a_file(self):
        text = """<scene version="3.0.0">
          <integrator type="path"><integer name="max_depth" value="3"/></integrator>
          <sensor type="perspective"><float name="fov" value="45"/>
            <transform name="to_world"><lookat origin="0, 1, 4" target="0, 0, 0" up="0, 1, 0"/></transform>
            <film type="hdrfilm"><integer name="width" value="16"/><integer name="height" value="12"/></film></sensor>
          <bsdf type="roughconductor" id="metal"><string name="material" value="Au"/><float name="alpha" value="0.2"/></bsdf>
          <shape type="sphere"><point name="center" value="0, 0.5, 0"/><ref id="metal"/></shape>
          <shape type="rectangle"><transform name="to_world"><rotate x="1" angle="-90"/><scale value="4"/></transform>
            <bsdf type="diffuse"><texture type="checkerboard" name="reflectance"><rgb name="color0" value="0.1, 0.2, 0.3"/>
              </texture></bsdf></shape>
          <emitter type="point"><point name="position" value="2, 4, 2"/>
            <spectrum name="intensity" value="400:20, 700:30"/></emitter></scene>"""
        dictionary = {
            "type": "scene", "integrator": {"type": "path", "max_depth": 3},
            "sensor": {"type": "perspective", "fov": 45,
                       "to_world": T.look_at(origin=(0, 1, 4), target=(0, 0, 0), up=(0, 1, 0)),
                       "film": {"type": "hdrfilm", "width": 16, "height": 12}},
            "metal": {"type": "roughconductor", "material": "Au", "alpha": 0.2},
            "ball": {"type": "sphere", "center": (0, 0.5, 0), "bsdf": {"type": "ref", "id": "metal"}},
            "floor": {"type": "rectangle", "to_world": T.scale(4) @ T.rotate((1, 0, 0), -90),
                      "bsdf": {"type": "diffuse", "reflectance": {"type": "checkerboard", "color0": {
                          "type": "rgb", "value": [0.1, 0.2, 0.3]}}}},
            "lamp": {"type": "point", "position": np.array([2, 4, 2]),
                     "intensity": {"type": "spectrum", "value": [(400, 20), (700, 30)]}},
        }
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / "scene.xml").write_text(text, encoding="utf-8")
            expected = sheaf.render(sheaf.load(Path(folder) / "scene.xml"), spp=4).image
        np.testing.assert_allclose(sheaf.render(sheaf.load_dict(dictionary), spp=4).image, expected, rtol=2e-4, atol=1e-4)

    def test_errors_name_the_key(self):
        cases = [
            ({"type": "bsdf"}, "'type' is 'scene'"), (["scene"], "'type' is 'scene'"),
            (scenes.wall(more={"type": "difuse"}), "dictionary.more: unknown plugin 'difuse', did you mean 'diffuse'"),
            (scenes.wall(more=3), "dictionary.more: expected a text as the key, and a dictionary"),
            (scenes.wall(bsdf={"type": "diffuse", "reflectanse": 0.5}), "dictionary.square.bsdf.* 'reflectance'"),
            (scenes.wall(bsdf={"type": "diffuse", "reflectance": 0.5, "x": None}), "dictionary.square.bsdf.x: is a NoneType"),
            (scenes.wall(bsdf={"type": "ref", "id": "clay"}), "no object has the id 'clay'"),
            (scenes.wall(bsdf={"reflectance": 0.5}), "dictionary.square.bsdf: has no 'type'"),
            (scenes.wall(bsdf={"type": "diffuse", "reflectance": {"type": "rgb", "value": (1, 2)}}), "2 numbers"),
            (scenes.wall(bsdf={"type": "diffuse", "reflectance": {"type": "rgb", "value": (0.1, np.nan, 0)}}), "not finite"),
            (scenes.wall(bsdf={"type": "diffuse", "reflectance": {"type": "spectrum", "value": 3j}}), "pairs"),
            (scenes.wall(bsdf={"type": "diffuse", "reflectance": ["a", "b"]}), "without numbers"),
            (scenes.wall({"vertices": scenes.VERTICES[:, :2]}), "float32 \\(4, 2\\), expected float32 \\(N, 3\\)"),
            (scenes.wall({"vertices": np.full((4, 3), np.inf)}), "dictionary.square.vertices: has values that are not finite"),
            (scenes.wall({"vertices": scenes.VERTICES * 1e300}), "dictionary.square"),
            (scenes.wall({"vertices": np.zeros((0, 3))}), "expected float32 \\(N, 3\\)"),
            (scenes.wall({"vertices": np.array([["a"] * 3])}), "is an array of <U1, expected numbers"),
            (scenes.wall({"faces": scenes.FACES + 2}), "index 5 in face 1, but there are 4 vertices|index 4 in face 0"),
            (scenes.wall({"faces": scenes.FACES.astype(int) - 1}), "indices from -1"),
            (scenes.wall({"faces": scenes.FACES.astype(float)}), "float64, expected integers"),
            (scenes.wall({"uv": scenes.UV[:3]}), "float32 \\(3, 2\\), expected float32 \\(4, 2\\)"),
            (scenes.wall({"normals": scenes.UV}), "expected float32 \\(4, 3\\)"),
            (scenes.wall({"attributes": {"vertex_color": np.zeros((4, 2))}}), "expected float32 \\(4\\) or \\(4, 3\\)"),
            (scenes.wall({"attributes": {"colour": np.zeros((4, 3))}}), "colour"),
            (scenes.wall({"radius": np.zeros((4, 3))}), "radius"),
            (scenes.wall(bsdf={"type": "diffuse", "reflectance": {"type": "bitmap", "data": np.zeros((2, 2, 5))}}), "channels"),
            (scenes.wall(bsdf={"type": "diffuse", "reflectance": {"type": "bitmap", "data": 1.5}}), "an array"),
            (scenes.wall({"type": "sphere"}), "dictionary.square"),
        ]
        for dictionary, message in cases:
            with self.subTest(message), self.assertRaisesRegex(sheaf.SceneError, message) as caught:
                sheaf.load_dict(dictionary)
            self.assertTrue(caught.exception.file.startswith("dictionary"))
        nested = {"type": "diffuse"}
        for _ in range(200):
            nested = {"type": "twosided", "bsdf": nested}
        with self.assertRaises(sheaf.Error):
            sheaf.load_dict(scenes.wall(bsdf=nested))

    def test_arrays_in_other_layouts(self):
        expected = color(scenes.wall())
        np.testing.assert_allclose(expected, (0.2, 0.4, 0.6), rtol=0.03)
        for vertices in (np.asfortranarray(scenes.VERTICES.astype(np.float64)), scenes.VERTICES.tolist(),
                         np.repeat(scenes.VERTICES, 2, axis=0)[::2]):
            np.testing.assert_array_equal(color(scenes.wall({"vertices": vertices, "faces": scenes.FACES.astype(np.int16)})),
                                          expected)

    def test_attributes_and_normals(self):
        mesh = {"attributes": {"face_color": np.array([(0.1, 0.2, 0.3)] * 2)},
                "normals": np.array([(0, 0, 1)] * 4, dtype=np.float32)}
        found = color(scenes.wall(mesh, {"type": "diffuse", "reflectance": {"type": "mesh_attribute", "name": "face_color"}}))
        np.testing.assert_allclose(found, (0.1, 0.2, 0.3), rtol=0.03)

    def test_textures(self):
        def image_of(data, **more):
            texture = {"type": "bitmap", "data": data, "filter_type": "nearest", **more}
            scene = sheaf.load_dict(scenes.wall(bsdf={"type": "diffuse", "reflectance": texture}))
            return sheaf.render(scene, spp=64, size=(8, 8), aovs=["albedo"])["albedo"]

        # The first row of an array is at v = 0, as that of a file: at the bottom of the square
        data = np.full((2, 2, 3), 0.25, dtype=np.float32)
        data[0, 0] = (0.5, 0.1, 0.2)
        found = image_of(data)
        np.testing.assert_allclose(found[-1, 0], (0.5, 0.1, 0.2), rtol=1e-3)
        for corner in (found[0, 0], found[0, -1], found[-1, -1]):
            np.testing.assert_allclose(corner, 0.25, rtol=1e-3)
        # Bytes are decoded unless they are raw
        byte = np.full((1, 1), 128, dtype=np.uint8)
        np.testing.assert_allclose(image_of(byte)[0, 0], ((128 / 255 + 0.055) / 1.055) ** 2.4, rtol=1e-3)
        np.testing.assert_allclose(image_of(byte, raw=True)[0, 0], 128 / 255, rtol=1e-3)

    def test_grids(self):
        """The transmittance of a grid of constant density, by Beer and Lambert's law."""
        def mean(data):
            medium = {"type": "heterogeneous", "albedo": 0.0, "scale": 1.0,
                      "sigma_t": {"type": "gridvolume", "data": data, "to_world": T.translate((-0.5, -0.5, -0.5))}}
            look_at = T.look_at(origin=(0, 0, 4), target=(0, 0, 0), up=(0, 1, 0))
            return color({"type": "scene", "integrator": {"type": "volpath"}, "sky": {"type": "constant"},
                          "camera": {"type": "orthographic", "to_world": look_at @ T.scale((0.2, 0.2, 1)),
                                     "film": {"type": "hdrfilm", "width": 4, "height": 4}},
                          "cloud": {"type": "cube", "to_world": T.scale(0.5), "interior": medium,
                                    "bsdf": {"type": "null"}}}, spp=1024)

        np.testing.assert_allclose(mean(np.full((3, 4, 5), 1.5, dtype=np.float32)), np.exp(-1.5), rtol=0.03)
        np.testing.assert_allclose(mean(np.zeros((2, 2, 2, 1))), 1, rtol=1e-4)
        for data, message in ((np.zeros((2, 2)), "Z, Y, X"), (np.zeros((2, 2, 2), np.uint8), "expected float32"),
                              (np.zeros((2, 2, 2, 2)), "Z, Y, X"), (np.full((2, 2, 2), np.nan), "not finite")):
            with self.assertRaisesRegex(sheaf.SceneError, message):
                mean(data)


class Changes(unittest.TestCase):
    def test_materials_keep_the_acceleration_structure(self):
        scene = sheaf.load_dict(scenes.wall())
        first = sheaf.render(scene, spp=4)
        self.assertEqual(first.stats["kept"], {"scene": False, "acceleration_structure": False})
        self.assertEqual(sheaf.render(scene, spp=4, seed=2).stats["kept"], {"scene": True, "acceleration_structure": True})
        material = scene.shapes["square"].bsdf
        self.assertEqual(material.reflectance, (0.2, 0.4, 0.6))
        material.reflectance = (0.6, 0.4, 0.2)
        second = sheaf.render(scene, spp=4)
        self.assertEqual(second.stats["kept"], {"scene": False, "acceleration_structure": True})
        np.testing.assert_allclose(second.image[..., :3], first.image[..., 2::-1], rtol=1e-5)
        # A change of the geometry builds it again
        scene.shapes["square"].to_world = T.scale(2)
        self.assertEqual(sheaf.render(scene, spp=4).stats["kept"], {"scene": False, "acceleration_structure": False})

    def test_equal_to_a_new_scene(self):
        scene = scenes.cornell()
        sheaf.render(scene, spp=1)
        scene.materials["brick"].reflectance = (0.1, 0.2, 0.3)
        scene.camera.fov = 30
        scene.camera.to_world = T.translate((0, 0.1, 0)) @ scene.camera.to_world
        with tempfile.TemporaryDirectory() as folder:
            text = Path(scenes.CORNELL).read_text(encoding="utf-8").replace("0.62, 0.13, 0.06", "0.1, 0.2, 0.3")
            text = text.replace('"fov" value="37"', '"fov" value="30"').replace(
                'origin="0, 1, 5" target="0, 1, 0"', 'origin="0, 1.1, 5" target="0, 1.1, 0"')
            (Path(folder) / "scene.xml").write_text(text, encoding="utf-8")
            other = sheaf.load(Path(folder) / "scene.xml", defines=scenes.SMALL)
        np.testing.assert_allclose(sheaf.render(scene, spp=4).image, sheaf.render(other, spp=4).image, rtol=1e-4, atol=1e-4)

    def test_rejected_changes_leave_the_scene(self):
        scene = sheaf.load_dict(scenes.wall())
        before = sheaf.render(scene, spp=2).image
        square, material = scene.shapes["square"], scene.materials["bsdf_1"]
        for change, message in ((lambda: setattr(material, "reflectance", (3, 0, 0)), "within"),
                                (lambda: setattr(material, "reflectanse", 0.5), "did you mean 'reflectance'"),
                                (lambda: setattr(square, "faces", [(0, 1, 9)]), "index 9"),
                                (lambda: setattr(scene.camera, "fov", -1), "fov"),
                                (lambda: scene.add("new", {"type": "sphere", "radius": 0}), "radius"),
                                (lambda: scene.add("square", {"type": "sphere"}), "already taken"),
                                (lambda: scene.add("new", 3), "dictionary")):
            with self.assertRaisesRegex(sheaf.SceneError, message):
                change()
        np.testing.assert_array_equal(sheaf.render(scene, spp=2).image, before)

    def test_objects(self):
        scene = scenes.cornell()
        brick = scene.materials["brick"]
        self.assertEqual((brick.type, brick.id), ("diffuse", "brick"))
        self.assertIn("reflectance", dir(brick))
        self.assertIn("brick", repr(scene.materials))
        self.assertEqual(scene.film.width, 24)
        self.assertEqual(scene.size, (24, 16))
        self.assertEqual(scene.integrator.type, "path")
        self.assertEqual(scene.materials["mirror"].material, "none")
        self.assertEqual(len(scene.shapes["mirror_sphere"].center), 3)
        self.assertEqual((len(scene.sensors), len(scene.textures), len(scene.media)), (1, 0, 0))
        self.assertGreater(len(scene.lights), 0)
        self.assertEqual(scene.shapes["floor"].bsdf.id, "plaster")
        with self.assertRaisesRegex(AttributeError, "did you mean 'reflectance'"):
            brick.reflectanc
        with self.assertRaisesRegex(KeyError, "did you mean 'brick'"):
            scene.materials["brik"]
        with self.assertRaises(AttributeError):
            del brick.alpha
        scene.shapes["floor"].bsdf = scene.materials["slate"]
        self.assertEqual(scene.shapes["floor"].bsdf.id, "slate")
        with self.assertRaisesRegex(sheaf.UsageError, "no id"):
            scene.shapes["floor"].bsdf = scene.integrator
        del brick.reflectance
        self.assertNotIn("reflectance", dir(brick))
        brick.reflectance = (0.5, 0.5, 0.5)
        self.assertEqual(brick.reflectance, (0.5, 0.5, 0.5))

    def test_add_and_remove(self):
        scene = sheaf.load_dict(scenes.wall())
        camera = scene.camera
        lit = color(scene)
        scene.remove("sky")
        with self.assertRaisesRegex(sheaf.UsageError, "again"):
            camera.fov
        with self.assertRaises(KeyError):
            scene.remove("sky")
        with self.assertWarnsRegex(sheaf.SheafWarning, "no lights"):
            np.testing.assert_array_equal(color(scene), 0)
        scene.add("lamp", {"type": "constant", "radiance": {"type": "rgb", "value": (2, 2, 2)}})
        np.testing.assert_allclose(color(scene), 2 * lit, rtol=1e-4)

    def test_sensors_of_a_call(self):
        scene = sheaf.load_dict(scenes.wall(second={"type": "perspective", "fov": 10, "film": {
            "type": "hdrfilm", "width": 4, "height": 3}, "to_world": T.look_at((0, 0, 1), (0, 0, 0), (0, 1, 0))}))
        self.assertEqual([sensor.id for sensor in scene.sensors()], ["camera", "second"])
        first = sheaf.render(scene, spp=2)
        self.assertEqual(first.image.shape, (6, 8, 4))
        loose = sheaf.load_dict({"type": "perspective", "film": {"type": "hdrfilm", "width": 5, "height": 2}})
        self.assertEqual(loose.type, "perspective")
        for sensor, shape in ((1, (3, 4, 4)), (scene.sensors["second"], (3, 4, 4)), (loose, (2, 5, 4)), (0, (6, 8, 4))):
            result = sheaf.render(scene, spp=2, sensor=sensor)
            self.assertEqual(result.image.shape, shape)
        self.assertTrue(result.stats["kept"]["acceleration_structure"])
        np.testing.assert_array_equal(sheaf.render(scene, spp=2).image, first.image)
        self.assertEqual(scene.size, (8, 6))
        direct = sheaf.render(scene, spp=2, integrator={"type": "path", "max_depth": 1})
        np.testing.assert_array_equal(direct.image[..., :3], 0)
        with self.assertRaisesRegex(sheaf.UsageError, "sensor 2 does not exist: the scene has 2"):
            sheaf.render(scene, sensor=2)

    def test_without_sensors(self):
        dictionary = scenes.wall()
        camera = dictionary.pop("camera")
        scene = sheaf.load_dict(dictionary)
        self.assertEqual(len(scene.sensors), 0)
        with self.assertRaisesRegex(sheaf.UsageError, "the scene has no sensor"):
            sheaf.render(scene)
        self.assertTrue(sheaf.trace(scene, (0, 0, 1), [(0, 0, -1)]).hit.all())
        lit = sheaf.render(scene, spp=4, sensor=camera).image
        scene.add("camera", camera)
        np.testing.assert_array_equal(sheaf.render(scene, spp=4).image, lit)

    def test_parts(self):
        material = sheaf.load_dict({"type": "twosided", "inner": {"type": "diffuse", "reflectance": "#800000"}})
        scene = sheaf.load_dict(scenes.wall(bsdf=material, paint=sheaf.load_dict({"type": "plastic"})))
        self.assertEqual(scene.shapes["square"].bsdf.inner.reflectance, "#800000")
        self.assertEqual(scene.materials["paint"].type, "plastic")
        np.testing.assert_allclose(color(scene), (0.2158605, 0, 0), rtol=0.05)
        mesh = sheaf.load_dict({"type": "mesh", "vertices": scenes.VERTICES, "faces": scenes.FACES})
        scene.add("again", mesh)
        np.testing.assert_array_equal(scene.shapes["again"].faces, scenes.FACES)

    def test_nested_references(self):
        scene = sheaf.load_dict(scenes.wall(
            ball={"type": "sphere", "center": (0, 0, -9), "bsdf": {"type": "ref", "id": "square.bsdf"}},
            other={"type": "sphere", "center": (0, 0, -9), "bsdf": {"type": "ref", "id": "named"}},
            third={"type": "sphere", "center": (0, 0, -9), "bsdf": {"type": "conductor", "id": "named"}}))
        self.assertEqual(scene.shapes["ball"].bsdf.type, "diffuse")
        self.assertEqual(scene.shapes["other"].bsdf.type, "conductor")
        scene.shapes["square"].bsdf.reflectance = (0.1, 0.1, 0.1)
        self.assertEqual(scene.shapes["ball"].bsdf.reflectance, (0.1, 0.1, 0.1))

    def test_hexadecimal_colors(self):
        scene = sheaf.load_dict(scenes.wall(bsdf={"type": "diffuse", "reflectance": "#ff8000"}))
        np.testing.assert_allclose(color(scene), (1, 0.2158605, 0), rtol=0.05, atol=1e-6)
        scene.shapes["square"].bsdf.reflectance = "#0000ff"
        np.testing.assert_allclose(color(scene), (0, 0, 1), rtol=0.05, atol=1e-6)

    def test_names_of_materials(self):
        """BSDFs without an id have the names of hits and of Cryptomatte."""
        scene = sheaf.load_dict(scenes.wall(
            bsdf={"type": "twosided", "front": {"type": "diffuse", "reflectance": 0.25}},
            far={"type": "sphere", "center": (5, 0, 0), "bsdf": {"type": "ref", "id": "last"}},
            near={"type": "sphere", "center": (9, 0, 0), "bsdf": {"type": "conductor"}}, last={"type": "plastic"}))
        hits = sheaf.trace(scene, [(0, 0, 1), (5, 0, 9), (9, 0, 9)], np.array([(0, 0, -1)] * 3))
        found = [scene.materials[hits.material_names[k]].type for k in hits.material]
        self.assertEqual(found, ["twosided", "plastic", "conductor"])
        self.assertEqual(set(scene.materials), set(hits.material_names) - {"default"})
        self.assertEqual(scene.materials["bsdf_1"].type, "twosided")  # by the order in the scene

    def test_other_formats(self):
        scene = sheaf.load(scenes.ROOT / "scenes" / "cornell" / "cornell.pbrt")
        self.assertGreater(sheaf.render(scene, spp=1, size=(8, 8)).image[..., :3].max(), 0)
        with self.assertRaisesRegex(sheaf.UsageError, "cannot be changed or inspected"):
            scene.materials["brick"]


class Transforms(unittest.TestCase):
    def test_values(self):
        point = np.array([[1.0, 2.0, 3.0]])
        np.testing.assert_allclose((T.translate((1, 0, 0)) @ T.scale(2)).points(point), [[3, 4, 6]])
        np.testing.assert_allclose(T.rotate((0, 0, 2), 90).points(point), [[-2, 1, 3]], atol=1e-12)
        moved = T.rotate((1, 2, 3), 40) @ T.translate((4, 5, 6))
        np.testing.assert_allclose((moved @ moved.inverse()).matrix, np.eye(4), atol=1e-12)
        np.testing.assert_allclose(T.look_at((0, 0, 5), (0, 0, 0), (0, 1, 0)).points([[0, 0, 1]]), [[0, 0, 4]])
        self.assertEqual(T(), T(np.eye(4)))
        self.assertIn("Transform", repr(T()))

    def test_chains(self):
        """Methods of an instance apply before its transform, as `@` does."""
        a, b, c = T.translate((1, 2, 3)), T.rotate((0, 1, 0), 30), T.scale((1, 2, 3))
        for chain in (T().translate((1, 2, 3)).rotate((0, 1, 0), 30).scale((1, 2, 3)),
                      T.translate((1, 2, 3)).rotate(axis=(0, 1, 0), angle=30).scale((1, 2, 3))):
            np.testing.assert_allclose(chain.matrix, (a @ b @ c).matrix)
        look = T.look_at((0, 0, 5), (0, 0, 0), (0, 1, 0))
        np.testing.assert_allclose(a.look_at((0, 0, 5), (0, 0, 0), (0, 1, 0)).matrix, (a @ look).matrix)
        np.testing.assert_allclose((a @ np.diag([2, 2, 2, 1])).matrix, (a @ T.scale(2)).matrix)
        np.testing.assert_allclose((np.diag([2.0, 2, 2, 1]) @ a).matrix, (T.scale(2) @ a).matrix)
        np.testing.assert_allclose(a @ (1, 1, 1), (2, 3, 4))
        np.testing.assert_allclose(c.vectors([(1, 1, 1)]), [(1, 2, 3)])
        np.testing.assert_allclose(c.normals([(0, 1, 0)]), [(0, 0.5, 0)])
        np.testing.assert_allclose(a.translation(), (1, 2, 3))
        np.testing.assert_array_equal(np.array(a), a.matrix)
        self.assertIn("Moves", T.translate.__doc__)
        self.assertIn("Moves", a.translate.__doc__)

    def test_errors(self):
        for make in (lambda: T(np.eye(3)), lambda: T.translate((1, 2)), lambda: T.rotate((0, 0, 0), 3),
                     lambda: T.look_at((0, 0, 0), (0, 0, 0), (0, 1, 0)), lambda: T.scale(np.nan), lambda: T.scale(0).inverse()):
            with self.assertRaises(sheaf.UsageError):
                make()
        for other in (3, "scale", None, (1, 2), np.eye(3)[:2, :2]):
            with self.assertRaises(TypeError):
                T() @ other
        for make in (lambda: T.rotate((0, 1, 0)), lambda: T.rotate((0, 1, 0), 30, angle=30), lambda: T().scale(by="x")):
            with self.assertRaises((sheaf.UsageError, ValueError)):
                make()
        with self.assertRaises(AttributeError):
            T().shear(3)


if __name__ == "__main__":
    unittest.main()
