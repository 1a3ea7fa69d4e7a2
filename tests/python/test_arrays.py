"""Arrays of meshes, images and grids read back as they were set."""

import unittest

import numpy as np

import scenes
import sheaf

NORMALS = np.array([(0, 0, 1), (0.6, 0, 0.8), (0, 0.6, 0.8), (0, 0, 1)], dtype=np.float32)
ATTRIBUTES = {"vertex_weight": np.array([0.25, 0.5, 0.75, 1], dtype=np.float32),
              "face_color": np.array([(0.1, 0.2, 0.3), (0.4, 0.5, 0.6)], dtype=np.float32)}


def mesh(**more):
    return {"type": "mesh", "vertices": scenes.VERTICES, "faces": scenes.FACES, "uv": scenes.UV, "normals": NORMALS,
            "attributes": ATTRIBUTES, "bsdf": {"type": "diffuse"}, **more}


class ReadBack(unittest.TestCase):
    def check(self, found, expected, dtype):
        self.assertIsInstance(found, np.ndarray)
        self.assertEqual(found.dtype, dtype)
        self.assertEqual(found.shape, np.shape(expected))
        np.testing.assert_array_equal(found, expected)

    def check_mesh(self, shape):
        self.check(shape.vertices, scenes.VERTICES, np.float32)
        self.check(shape.faces, scenes.FACES, np.uint32)
        self.check(shape.uv, scenes.UV, np.float32)
        self.check(shape.normals, NORMALS, np.float32)
        self.assertEqual(list(shape.attributes), list(ATTRIBUTES))
        for name, values in ATTRIBUTES.items():
            self.check(shape.attributes[name], values, np.float32)
            self.check(getattr(shape, name), values, np.float32)

    def test_meshes(self):
        scene = sheaf.load_dict(scenes.wall(mesh()))
        self.check_mesh(scene.shapes["square"])
        # Meshes of groups, and those that are added later
        scene.add("group", {"type": "shapegroup", "part": mesh()})
        scene.add("copy", {"type": "instance", "group": {"type": "ref", "id": "group"}})
        scene.add("late", mesh())
        self.check_mesh(scene.shapes["group"].part)
        self.check_mesh(scene.shapes["late"])
        self.check_mesh(scene.shapes["copy"].group.part)

    def test_values_of_other_types(self):
        scene = sheaf.load_dict(scenes.wall())
        square = scene.shapes["square"]
        moved = (scenes.VERTICES.astype(np.float64) * 1.5 + 0.1)
        square.vertices = np.asfortranarray(moved)
        self.check(square.vertices, moved.astype(np.float32), np.float32)
        square.vertices = moved[::-1].tolist()
        self.check(square.vertices, moved[::-1].astype(np.float32), np.float32)
        square.faces = [(0, 2, 1), (0, 3, 2)]
        self.check(square.faces, [(0, 2, 1), (0, 3, 2)], np.uint32)
        square.uv = scenes.UV.astype(np.float64) / 3
        self.check(square.uv, (scenes.UV.astype(np.float64) / 3).astype(np.float32), np.float32)
        square.face_level = (0.5, 0.75)
        self.check(square.face_level, (0.5, 0.75), np.float32)
        square.normals = NORMALS
        self.check(square.normals, NORMALS, np.float32)

    def test_copies(self):
        scene = sheaf.load_dict(scenes.wall())
        square = scene.shapes["square"]
        before = sheaf.render(scene, spp=2).image
        vertices = square.vertices
        vertices *= 0.25
        self.check(square.vertices, scenes.VERTICES, np.float32)
        np.testing.assert_array_equal(sheaf.render(scene, spp=2, seed=0).image, before)
        square.vertices = vertices
        self.check(square.vertices, scenes.VERTICES * np.float32(0.25), np.float32)
        view = 2 * np.tan(np.radians(20))  # width at the square, and 3/4 of it the height
        albedo = sheaf.render(scene, spp=16, aovs=["albedo"])["albedo"].mean()
        self.assertAlmostEqual(albedo, 0.4 * 0.5**2 / (0.75 * view**2), delta=0.01)
        # A copy outlives the scene
        kept = square.faces
        del scene, square
        self.check(kept, scenes.FACES, np.uint32)

    def test_rejected_arrays_leave_the_last(self):
        scene = sheaf.load_dict(scenes.wall())
        square = scene.shapes["square"]
        for name, value in (("vertices", scenes.VERTICES[:, :2]), ("faces", scenes.FACES + 2), ("uv", scenes.UV[:3])):
            with self.assertRaises(sheaf.SceneError):
                setattr(square, name, value)
        self.check(square.vertices, scenes.VERTICES, np.float32)
        self.check(square.faces, scenes.FACES, np.uint32)
        self.check(square.uv, scenes.UV, np.float32)
        for name in ("normals", "attributes", "vertex_color"):
            with self.assertRaisesRegex(AttributeError, f"sets no parameter '{name}'"):
                getattr(square, name)
        square.normals = NORMALS
        del square.normals
        with self.assertRaises(AttributeError):
            square.normals

    def test_images_and_grids(self):
        image = np.arange(24, dtype=np.float32).reshape(2, 4, 3) / 24
        gray = np.arange(6, dtype=np.uint8).reshape(3, 2)
        grid = np.arange(24, dtype=np.float32).reshape(2, 3, 4)
        smoke = {"type": "heterogeneous", "albedo": 0.5, "sigma_t": {"type": "gridvolume", "data": grid}}
        scene = sheaf.load_dict(scenes.wall(
            bsdf={"type": "diffuse", "reflectance": {"type": "bitmap", "data": image}},
            other={"type": "sphere", "bsdf": {"type": "diffuse", "reflectance": {"type": "bitmap", "data": gray}}},
            cloud={"type": "cube", "interior": smoke, "bsdf": {"type": "null"}}))
        self.check(scene.shapes["square"].bsdf.reflectance.data, image, np.float32)
        self.check(scene.shapes["other"].bsdf.reflectance.data, gray, np.uint8)
        self.check(scene.shapes["cloud"].interior.sigma_t.data, grid, np.float32)
        scene.shapes["other"].bsdf.reflectance.data = gray.astype(np.float64) / 255
        self.check(scene.shapes["other"].bsdf.reflectance.data, (gray / 255.0).astype(np.float32), np.float32)

    def test_shapes_from_files(self):
        scene = scenes.cornell()
        for shape in scene.shapes.values():
            with self.assertRaises(AttributeError):
                shape.vertices


if __name__ == "__main__":
    unittest.main()
