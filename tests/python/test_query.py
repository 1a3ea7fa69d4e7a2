"""Rays and BSDFs against closed forms."""

import unittest

import numpy as np

import scenes
import sheaf

TAU = 2 * np.pi


def scene_of(**materials):
    """A scene with a unit sphere for each material, far apart."""
    out = {"type": "scene", "camera": {"type": "perspective"}, "sky": {"type": "constant"}}
    for k, (name, material) in enumerate(materials.items()):
        out[name] = material
        out["ball_" + name] = {"type": "sphere", "center": (30 * k, 0, 0), "radius": 1.0,
                               "bsdf": {"type": "ref", "id": name}}
    return sheaf.load_dict(out)


def rgb(*values):
    return {"type": "rgb", "value": values}


def uniform_directions(count, seed):
    z, phi = np.random.default_rng(seed).random((2, count)) * [[2], [TAU]]
    z = z - 1
    r = np.sqrt(1 - z * z)
    return np.stack([r * np.cos(phi), r * np.sin(phi), z], axis=1)


class Trace(unittest.TestCase):
    def test_sphere(self):
        scene = scene_of(a={"type": "diffuse"}, b={"type": "diffuse"})
        random = np.random.default_rng(1)
        origins = np.array([30, 0, 0]) + 4 * uniform_directions(100, 2)
        targets = np.array([30, 0, 0]) + 1.4 * random.uniform(-1, 1, (100, 3))
        directions = (targets - origins) * random.uniform(0.5, 2, (100, 1))
        hits = sheaf.trace(scene, origins, directions)
        # The nearest root of |o + t d - c|^2 = 1
        o, a = origins - [30, 0, 0], (directions ** 2).sum(1)
        b = (o * directions).sum(1)
        discriminant = b * b - a * ((o ** 2).sum(1) - 1)
        in_b = hits.hit & (hits.object == hits.object_names.index("ball_b"))
        sure = np.abs(discriminant) > 1e-3
        np.testing.assert_array_equal(in_b[sure], (discriminant > 0)[sure])
        self.assertTrue(30 < in_b.sum() < 95)
        t = (-b - np.sqrt(np.maximum(discriminant, 0))) / a
        both = in_b & sure
        np.testing.assert_allclose(hits.distance[both], t[both], rtol=1e-4)
        normal = (o + t[:, None] * directions)[both]
        np.testing.assert_allclose(hits.normal[both], normal, atol=1e-4)
        np.testing.assert_allclose(hits.position[both], normal + [30, 0, 0], atol=1e-4)
        self.assertEqual({hits.material_names[k] for k in hits.material[both]}, {"b"})
        misses = ~hits.hit
        self.assertTrue(misses.any() and np.isinf(hits.distance[misses]).all())
        self.assertTrue((hits.material[misses] == -1).all() and (hits.normal[misses] == 0).all())

    def test_mesh(self):
        scene = sheaf.load_dict(scenes.wall({"normals": np.array([(0, 0, 1)] * 3 + [(0, 0.6, 0.8)], np.float32)}))
        hits = sheaf.trace(scene, [[0.5, -0.5, 2], [-0.5, 0.5, 2], [5, 0, 2]], (0, 0, -2) * np.ones((3, 1)))
        np.testing.assert_array_equal(hits.hit, [True, True, False])
        np.testing.assert_allclose(hits.distance[:2], 1)
        np.testing.assert_array_equal(hits.primitive[:2], [0, 1])
        np.testing.assert_allclose(hits.uv[:2], [[0.75, 0.25], [0.25, 0.75]], atol=1e-6)
        corners = scenes.VERTICES[scenes.FACES[hits.primitive[:2]]]
        u, v = hits.barycentric[:2].T
        point = corners[:, 0] * (1 - u - v)[:, None] + corners[:, 1] * u[:, None] + corners[:, 2] * v[:, None]
        np.testing.assert_allclose(hits.position[:2], point, atol=1e-6)
        np.testing.assert_allclose(hits.normal[:2], [[0, 0, 1]] * 2, atol=1e-6)
        expected = np.array([0, 0.3, 0.9]) / np.hypot(0.3, 0.9)  # the mean of the diagonal's ends
        np.testing.assert_allclose(hits.shading_normal[1], expected, atol=1e-3)

    def test_is_the_same_in_any_order(self):
        scene = scenes.cornell()
        directions = uniform_directions(37, 5)
        whole = sheaf.trace(scene, (0, 1, 0), directions)
        parts = [sheaf.trace(scene, (0, 1, 0), d) for d in directions]
        np.testing.assert_array_equal(whole.distance, [part.distance[0] for part in parts])
        np.testing.assert_array_equal(whole.shading_normal, [part.shading_normal[0] for part in parts])

    def test_errors(self):
        scene = scene_of(a={"type": "diffuse"})
        for origins, directions, message in (((0, 0, 0), (0, 0, 0), "length 0"), ((0, 0), (0, 0, 1), "shape"),
                                             ((0, 0, np.nan), (0, 0, 1), "finite"), ((1e20, 0, 0), (0, 0, 1), "1e18"),
                                             (np.zeros((2, 3)), np.ones((3, 3)), "2 rows"), ("a", (0, 0, 1), "numbers")):
            with self.assertRaisesRegex(sheaf.UsageError, message):
                sheaf.trace(scene, origins, directions)
        self.assertEqual(len(sheaf.trace(scene, np.empty((0, 3)), np.empty((0, 3)))), 0)


class BsdfTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rough = {"type": "roughconductor", "alpha": 0.3, "eta": rgb(0.2, 0.9, 1.0), "k": rgb(3.0, 2.4, 2.2)}
        cls.scene = scene_of(
            wall={"type": "diffuse", "reflectance": rgb(0.2, 0.4, 0.6)}, metal=rough,
            glass={"type": "dielectric", "int_ior": 1.5, "ext_ior": 1.0}, both={"type": "twosided", "bsdf": dict(rough)},
            mixed={"type": "blendbsdf", "weight": 0.25, "a": {"type": "diffuse", "reflectance": rgb(0.8, 0.8, 0.8)},
                   "b": dict(rough)},
            half={"type": "mask", "opacity": 0.25, "bsdf": {"type": "diffuse", "reflectance": rgb(1.0, 1.0, 1.0)}},
            paper={"type": "diffuse", "reflectance": {"type": "checkerboard"}})

    def test_diffuse_is_lambertian(self):
        wall = sheaf.bsdf(self.scene, "wall")
        wi = uniform_directions(33, 1)
        cosine = np.maximum(wi[:, 2:], 0)
        np.testing.assert_allclose(wall.evaluate((0, 0.6, 0.8), wi), cosine * [0.2, 0.4, 0.6] / np.pi, atol=1e-6)
        np.testing.assert_allclose(wall.pdf((0, 0.6, 0.8), wi), cosine[:, 0] / np.pi, atol=1e-6)

    def test_pdfs_integrate_to_one(self):
        wi = uniform_directions(400000, 2)
        for name, bound in (("wall", 1), ("metal", 0.9), ("mixed", 0.9)):
            bsdf = sheaf.bsdf(self.scene, name)
            values = bsdf.pdf((0.3, 0, 0.9), wi) * 2 * TAU
            valid = bsdf.sample((0.3, 0, 0.9), count=20000).valid.mean()
            self.assertGreaterEqual(valid, bound)
            error = 4.5 * np.hypot(values.std() / np.sqrt(len(wi)), np.sqrt(valid * (1 - valid) / 20000))
            self.assertLess(abs(values.mean() - valid), error + 1e-9, name)

    def test_samples_agree_with_values(self):
        wo = np.array([0.5, 0.2, 0.7])
        for name in ("wall", "metal", "mixed", "both"):
            bsdf = sheaf.bsdf(self.scene, name)
            sample = bsdf.sample(wo, count=50000, seed=3)
            some = sample.valid
            np.testing.assert_allclose(bsdf.pdf(wo, sample.wi[some]), sample.pdf[some], rtol=2e-3)
            np.testing.assert_allclose(bsdf.evaluate(wo, sample.wi[some]) / sample.pdf[some][:, None],
                                       sample.weight[some], rtol=2e-3, atol=1e-6)
            # The mean of a function of the sampled direction equals its integral by the pdf
            wi = uniform_directions(400000, 4)
            density = bsdf.pdf(wo, wi) * 2 * TAU
            for function in (lambda w: w[:, 0], lambda w: w[:, 2] ** 2):
                a, b = function(sample.wi) * some, function(wi) * density
                error = 4.5 * np.hypot(a.std() / np.sqrt(len(a)), b.std() / np.sqrt(len(b)))
                self.assertLess(abs(a.mean() - b.mean()), error, name)

    def test_glass_obeys_snell(self):
        glass = sheaf.bsdf(self.scene, "glass")
        sample = glass.sample((0.6, 0, 0.8), count=1000)
        self.assertTrue(sample.valid.all() and (sample.pdf == 0).all())
        through = sample.wi[:, 2] < 0
        np.testing.assert_allclose(sample.wi[~through], [[-0.6, 0, 0.8]] * (~through).sum(), atol=1e-5)
        np.testing.assert_allclose(sample.wi[through, 0], -0.6 / 1.5, atol=1e-5)
        self.assertTrue(0.01 < 1 - through.mean() < 0.08)  # Fresnel: 3.9 %
        self.assertEqual(glass.evaluate((0, 0, 1), (0, 0, 1)).max(), 0)

    def test_sides(self):
        up, down = (0.5, 0.2, 0.7), (0.5, 0.2, -0.7)
        metal, both = sheaf.bsdf(self.scene, "metal"), sheaf.bsdf(self.scene, "both")
        wi = uniform_directions(50, 6)
        np.testing.assert_array_equal(both.evaluate(up, wi), metal.evaluate(up, wi))
        np.testing.assert_allclose(both.evaluate(down, wi * [1, 1, -1]), metal.evaluate(up, wi), rtol=1e-5)
        self.assertEqual(metal.evaluate(down, wi).max(), 0)
        self.assertTrue((both.sample(down, count=100).wi[:, 2] <= 0).all())

    def test_composites(self):
        wi = uniform_directions(50, 7)
        wo = (0.1, 0.5, 0.6)
        metal = sheaf.bsdf(self.scene, "metal").evaluate(wo, wi)
        diffuse = 0.8 * np.maximum(wi[:, 2:], 0) / np.pi
        np.testing.assert_allclose(sheaf.bsdf(self.scene, "mixed").evaluate(wo, wi), 0.75 * diffuse + 0.25 * metal,
                                   rtol=1e-5, atol=1e-7)
        half = sheaf.bsdf(self.scene, "half")
        sample = half.sample((0.6, 0, 0.8), count=20000)
        passed = sample.pdf == 0
        self.assertLess(abs(passed.mean() - 0.75), 4.5 * np.sqrt(0.75 * 0.25 / 20000))
        np.testing.assert_allclose(sample.wi[passed], [[-0.6, 0, -0.8]] * passed.sum(), atol=1e-6)

    def test_parts_of_blends_get_uniform_numbers(self):
        """The number that chooses a part must not decide about its lobes again."""
        glass = {"type": "dielectric", "int_ior": 3.0, "ext_ior": 1.0}  # reflects 1/4 at normal incidence
        black = {"type": "diffuse", "reflectance": rgb(0.0, 0.0, 0.0)}
        coat = {"type": "plastic", "diffuse_reflectance": rgb(0.6, 0.6, 0.6)}
        scene = scene_of(first={"type": "blendbsdf", "weight": 0.5, "a": glass, "b": black},
                         second={"type": "blendbsdf", "weight": 0.5, "a": black, "b": glass},
                         third={"type": "blendbsdf", "weight": 0.8,
                                "a": {"type": "blendbsdf", "weight": 0.5, "a": black, "b": glass}, "b": black},
                         coated={"type": "blendbsdf", "weight": 0.5, "a": black, "b": coat}, coat=coat)
        count = 20000
        for name, share in (("first", 0.5), ("second", 0.5), ("third", 0.1)):
            sample = sheaf.bsdf(scene, name).sample((0, 0, 1), count=count)
            delta = sample.valid & (sample.pdf == 0)
            self.assertLess(abs(delta.mean() - share), 4.5 * np.sqrt(share * (1 - share) / count), name)
            reflected = (delta & (sample.wi[:, 2] > 0)).mean()
            self.assertLess(abs(reflected - share / 4), 4.5 * np.sqrt(share / 4 / count), name)
        # Plastic: as often as alone, the delta lobe is chosen
        wo = (0.8, 0, 0.6)
        alone = (sheaf.bsdf(scene, "coat").sample(wo, count=count).pdf == 0).mean()
        self.assertTrue(0.05 < alone < 0.95)
        blended = (sheaf.bsdf(scene, "coated").sample(wo, count=count).pdf == 0).mean()
        self.assertLess(abs(blended - 0.5 * alone), 4.5 * np.sqrt(0.5 / count))

    def test_numbers_and_errors(self):
        wall = sheaf.bsdf(self.scene, "wall")
        u = np.random.default_rng(8).random((20, 3))
        np.testing.assert_array_equal(wall.sample((0, 0, 1), u).wi[7], wall.sample((0, 0, 1), u[7]).wi[0])
        np.testing.assert_array_equal(wall.sample((0, 0, 1), seed=2, count=9).wi, wall.sample((0, 0, 1), seed=2, count=9).wi)
        for call, message in ((lambda: sheaf.bsdf(self.scene, "wal"), "no shape has the material 'wal'"),
                              (lambda: sheaf.bsdf(self.scene, "paper"), "textures or maps"),
                              (lambda: wall.evaluate((0, 0, 0), (0, 0, 1)), "length 0"),
                              (lambda: wall.sample((0, 0, 1), [[0, 1, 0]]), "outside"),
                              (lambda: wall.evaluate(np.ones((2, 3)), np.ones((3, 3))), "3 rows, expected 2")):
            with self.assertRaisesRegex(sheaf.UsageError, message):
                call()
