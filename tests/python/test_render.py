"""Renders of scenes from files: the same bits as the command line's, results, stopping and speed."""

import copy
import io
import os
import pickle
import signal
import sys
import tempfile
import threading
import time
import unittest
import warnings
from pathlib import Path
from unittest import mock

import numpy as np

import scenes
import sheaf


class SameBits(unittest.TestCase):
    """Files are byte-identical to those of the program."""

    def compare(self, options, words, **read):
        with tempfile.TemporaryDirectory() as folder:
            ours, theirs = Path(folder) / "ours.exr", Path(folder) / "theirs.exr"
            scene = sheaf.load(scenes.CORNELL, defines=scenes.SMALL, **read)
            sheaf.render(scene, spp=1, integrator="ao")  # a render of white surfaces in between
            sheaf.render(scene, no_timestamps=True, **options).write(ours)
            scenes.program("render", scenes.CORNELL, "-D", "width=24", "-D", "height=16", "--no-timestamps", "-o", theirs,
                           *words)
            self.assertEqual(ours.read_bytes(), theirs.read_bytes())

    def test_path(self):
        self.compare({"spp": 4, "seed": 7, "threads": 1}, ["--spp", 4, "--seed", 7])

    def test_layers_and_sets(self):
        self.compare({"spp": 8, "aovs": ["albedo", "depth", "variance"], "light_groups": True, "replicates": 4,
                      "size": (20, 10)},
                     ["--spp", 8, "--aov", "albedo,depth,variance", "--light-groups", "--replicates", 4, "--size", "20x10"])

    def test_spectral_and_denoised(self):
        self.compare({"spp": 4, "color": "spectral", "denoise": "nlm", "sampler": "stratified"},
                     ["--spp", 4, "--color", "spectral", "--denoise", "nlm", "--sampler", "stratified"])

    def test_part(self):
        self.compare({"spp": 8, "samples": (4, 4), "replicates": 2},
                     ["--spp", 8, "--samples", "4:4", "--replicates", 2])

    def test_photons(self):
        self.compare({"integrator": "ptracer", "spp": 2}, ["--integrator", "ptracer", "--spp", 2])

    def test_image_is_what_the_file_holds(self):
        with tempfile.TemporaryDirectory() as folder:
            result = sheaf.render(scenes.cornell(), spp=2, float=True, aovs=["normal"])
            result.write(Path(folder) / "a.exr")
            read = sheaf.read_image(Path(folder) / "a.exr")
        np.testing.assert_array_equal(read.image, result.image)
        np.testing.assert_array_equal(read["normal"], result["normal"])


class Results(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scene = scenes.cornell()
        cls.result = sheaf.render(cls.scene, spp=16, aovs=["albedo", "depth", "half"], replicates=4)

    def test_arrays(self):
        result = self.result
        self.assertEqual((result.image.shape, result.image.dtype), ((16, 24, 4), np.float32))
        self.assertEqual(result["albedo"].shape, (16, 24, 3))
        self.assertEqual(result["depth"].shape, (16, 24))
        np.testing.assert_array_equal(result["albedo.G"], result["albedo"][..., 1])
        self.assertTrue((result.variance > 0).any())
        self.assertIn("depth", result)
        self.assertNotIn("normal", result)
        self.assertTrue({"albedo", "depth", "variance", "half"} <= set(result.layers))
        with self.assertRaisesRegex(KeyError, "no layer 'normal'"):
            result["normal"]

    def test_arrays_outlive_results(self):
        image = sheaf.render(self.scene, spp=1).image
        expected = image.copy()
        for _ in range(3):
            sheaf.render(self.scene, spp=2)
        np.testing.assert_array_equal(image, expected)

    def test_stats_and_attributes(self):
        stats = self.result.stats
        self.assertEqual((stats["spp"], stats["width"], stats["height"]), (16, 24, 16))
        self.assertEqual(self.result.attributes["sheaf/samplesPerPixel"], 16)
        self.assertIn("24 x 16", repr(self.result))

    def test_array_and_copies(self):
        result = self.result
        np.testing.assert_array_equal(np.array(result), result.image)
        self.assertEqual(np.asarray(result, dtype=np.float64).dtype, np.float64)
        with tempfile.TemporaryDirectory() as folder:
            result.write(Path(folder) / "a.exr")
            for other in (pickle.loads(pickle.dumps(result)), copy.copy(result), copy.deepcopy(result)):
                self.assertEqual((other.layers, other.stats, other.attributes, other.warnings, other.interrupted),
                                 (result.layers, result.stats, result.attributes, result.warnings, result.interrupted))
                np.testing.assert_array_equal(other["half"], result["half"])
                other.write(Path(folder) / "b.exr")
                self.assertEqual((Path(folder) / "b.exr").read_bytes(), (Path(folder) / "a.exr").read_bytes())
        for value in (sheaf.Transform.scale(2), sheaf.read_image):
            self.assertEqual(pickle.loads(pickle.dumps(value)), value)
        state = list(result.__getstate__())
        state[2] = state[2][:-4]
        with self.assertRaisesRegex(sheaf.UsageError, "broken"):
            sheaf.Result.__new__(sheaf.Result).__setstate__(tuple(state))

    def test_merge_of_pickled_parts(self):
        parts = [pickle.loads(pickle.dumps(sheaf.render(self.scene, spp=8, samples=(first, 4)))) for first in (0, 4)]
        np.testing.assert_allclose(sheaf.merge(parts).image, sheaf.render(self.scene, spp=8).image, rtol=1e-3, atol=1e-3)

    def test_png(self):
        from_memory = self.result.png()
        self.assertTrue(from_memory.startswith(b"\x89PNG\r\n"))
        self.assertEqual(self.result._repr_png_(), from_memory)
        self.assertNotEqual(self.result.png(exposure=2), from_memory)
        with tempfile.TemporaryDirectory() as folder:
            self.result.write(Path(folder) / "a.png", tone_map="agx")
            self.assertEqual((Path(folder) / "a.png").read_bytes(), self.result.png(tone_map="agx"))
            self.assertEqual(sheaf.read_image(Path(folder) / "a.png").image.shape, (16, 24, 4))

    def test_denoise(self):
        denoised = sheaf.denoise(self.result)
        noisy, clean = self.result.image[..., :3], denoised["denoised"]
        reference = sheaf.render(self.scene, spp=1024).image[..., :3]
        self.assertLess(np.mean((clean - reference) ** 2), np.mean((noisy - reference) ** 2))
        with self.assertRaisesRegex(sheaf.UsageError, "variance"):
            sheaf.denoise(self.result.image)

    def test_compare(self):
        other = sheaf.render(self.scene, spp=16, seed=1, replicates=4)
        found = sheaf.compare(self.result, other)
        a, b = (r.image[..., :3].astype(np.float64) for r in (self.result, other))
        self.assertAlmostEqual(found["mse"], np.mean((a - b) ** 2), places=6)
        self.assertGreater(found["accepted"], 0.9)
        self.assertEqual(sheaf.compare(self.result, self.result.image)["mse"], 0)
        self.assertEqual(sheaf.compare(np.full((2, 2), 0.5), np.full((2, 2), 0.25))["mse"], 0.0625)
        for wrong in (np.zeros((2, 2, 2)), np.zeros(3), np.array("a"), np.zeros((0, 2, 3))):
            with self.assertRaises(sheaf.UsageError):
                sheaf.compare(self.result, wrong)
        with self.assertRaises(sheaf.UsageError):
            sheaf.compare(self.result, other, significance=2)

    def test_merge(self):
        whole = sheaf.render(self.scene, spp=8, replicates=2)
        tiles = [sheaf.render(self.scene, spp=8, replicates=2, crop=crop) for crop in ((0, 0, 9, 16), (9, 0, 24, 16))]
        np.testing.assert_array_equal(sheaf.merge(tiles[::-1]).image, whole.image)
        halves = [sheaf.render(self.scene, spp=8, replicates=2, samples=samples) for samples in ("0:4", "4:4")]
        np.testing.assert_allclose(sheaf.merge(halves).image, whole.image, rtol=1e-5, atol=1e-6)
        self.assertEqual(sheaf.merge(tiles[:1], incomplete=True).image.shape, (16, 9, 4))
        with self.assertRaisesRegex(sheaf.SceneError, "incomplete"):
            sheaf.merge(tiles[:1])
        with self.assertRaisesRegex(sheaf.UsageError, "no parts"):
            sheaf.merge([])
        with self.assertRaisesRegex(sheaf.SceneError, "not a part"):
            sheaf.merge([whole])


class Models(unittest.TestCase):
    """Models without cameras and lights."""

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.file = Path(cls.folder.name) / "model.obj"
        cls.file.write_text("v 0 0 0\nv 4 0 0\nv 4 1 0\nv 0 1 0\nf 1 2 3 4\n", encoding="utf-8")

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_framing_follows_the_size(self):
        scene = sheaf.load(self.file, view=(0, 0))
        for size in ((96, 32), (32, 32), (96, 32)):
            result = sheaf.render(scene, spp=16, size=size, aov="albedo")
            model = np.abs(result["albedo"][..., 0] - 0.6) < 0.02
            columns = np.flatnonzero(model.any(axis=0))
            self.assertAlmostEqual((columns[-1] - columns[0] + 1) / model.shape[1], 2 / 3, delta=0.08, msg=size)

    def test_exposure_is_automatic(self):
        result = sheaf.render(sheaf.load(self.file), spp=4, size=(24, 16))
        self.assertEqual(result.png(), result.png(exposure="auto"))
        self.assertNotEqual(result.png(), result.png(exposure=0))
        self.assertEqual(pickle.loads(pickle.dumps(result)).png(), result.png())


class Running(unittest.TestCase):
    """Long renders, which end early."""

    long = {"spp": 1 << 20, "size": (64, 64)}

    def test_progress_and_stop(self):
        stop, seen = threading.Event(), []

        def progress(done, total):
            seen.append((done, total))
            stop.set()

        start = time.monotonic()
        result = sheaf.render(scenes.cornell(), progress=progress, stop=stop, **self.long)
        self.assertLess(time.monotonic() - start, 10)
        self.assertTrue(result.interrupted)
        self.assertGreater(result.attributes["sheaf/samplesTaken"], 0)
        self.assertTrue(0 < seen[0][0] < seen[0][1])
        self.assertTrue(np.isfinite(result.image).all() and result.image.max() > 0)
        with self.assertRaisesRegex(sheaf.UsageError, "progress is a int"):
            sheaf.render(scenes.cornell(), progress=3)

    def test_stop_function_and_errors(self):
        start = time.monotonic()
        self.assertTrue(sheaf.render(scenes.cornell(), stop=lambda: time.monotonic() > start + 0.2, **self.long).interrupted)

        def fail(done, total):
            raise LookupError("of the user")

        with self.assertRaisesRegex(LookupError, "of the user"):
            sheaf.render(scenes.cornell(), progress=fail, **self.long)

    def test_control_c(self):
        timer = threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT))
        timer.start()
        self.assertTrue(sheaf.render(scenes.cornell(), **self.long).interrupted)
        timer.join()

    def test_other_threads_run(self):
        scene, counted, stop = scenes.cornell(), [], threading.Event()

        def count():
            while not stop.is_set():
                counted.append(1)
                time.sleep(0.001)

        def use():
            time.sleep(0.1)
            try:
                scene.camera.fov = 20
            except sheaf.UsageError as error:
                problems.append(str(error))
            stop.set()

        problems = []
        threads = [threading.Thread(target=count), threading.Thread(target=use)]
        for thread in threads:
            thread.start()
        sheaf.render(scene, stop=stop, **self.long)
        for thread in threads:
            thread.join()
        self.assertGreater(len(counted), 10)
        self.assertEqual(problems, ["the scene is in use by another call"])

    def test_threads_render_one_scene(self):
        """Calls of several threads, with other cameras and queries, give the bits of calls in order."""
        scene, found, problems = scenes.cornell(), {}, []

        def view(number):
            look_at = sheaf.Transform.look_at((0, 1, 4 + number % 3), (0, 1, 0), (0, 1, 0))
            camera = {"type": "perspective", "fov": 30, "to_world": look_at,
                      "film": {"type": "hdrfilm", "width": 20, "height": 12}}
            return np.array(sheaf.render(scene, spp=4, seed=number, sensor=camera if number % 2 else None))

        def work(first):
            try:
                for number in range(first, 24, 6):
                    found[number] = view(number)
                    self.assertTrue(sheaf.trace(scene, (0, 1, 3), [(0, 0, -1)]).hit.all())
                    self.assertEqual(scene.materials["brick"].type, "diffuse")
            except Exception as problem:  # pylint: disable=broad-except
                problems.append(problem)

        threads = [threading.Thread(target=work, args=(first,)) for first in range(6)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(problems, [])
        for number in range(24):
            np.testing.assert_array_equal(found[number], view(number))

    def test_stop_while_waiting(self):
        scene, stop, first = scenes.cornell(), threading.Event(), threading.Event()
        thread = threading.Thread(target=sheaf.render, args=(scene,), kwargs={
            "stop": stop, "progress": lambda done, total: first.set(), **self.long})
        thread.start()
        self.assertTrue(first.wait(20))
        with self.assertRaisesRegex(sheaf.Error, "stopped while another call used the scene"):
            sheaf.render(scene, spp=1, stop=lambda: True)
        stop.set()
        thread.join()

    def test_progress_bar(self):
        class Bar:
            """Stands in for tqdm."""

            def __init__(self, total, **_):
                self.n, self.total, self.closed = 0, total, False
                bars.append(self)

            def update(self, count):
                self.n += count

            def close(self):
                self.closed = True

        bars = []
        with mock.patch.dict(sys.modules, {"tqdm": mock.Mock(), "tqdm.auto": mock.Mock(tqdm=Bar)}):
            sheaf.render(scenes.cornell(), spp=4, progress=True)
            self.assertTrue(bars[0].closed and bars[0].n == bars[0].total > 0)
            sheaf.render(scenes.cornell(), spp=4)  # not in a notebook
            self.assertEqual(len(bars), 1)
            shell = type("ZMQInteractiveShell", (), {})()
            with mock.patch.dict(sys.modules, {"IPython": mock.Mock(get_ipython=lambda: shell)}):
                sheaf.render(scenes.cornell(), spp=4)
                sheaf.render(scenes.cornell(), spp=4, progress=False)
            self.assertEqual(len(bars), 2)
        with mock.patch.dict(sys.modules, {"tqdm": None, "tqdm.auto": None}), \
             mock.patch("sys.stderr", new_callable=io.StringIO) as written:
            sheaf.render(scenes.cornell(), spp=4, progress=True)
            self.assertIn("render: 100 %", written.getvalue())

    def test_overhead(self):
        """A call takes below 5 ms beyond rendering: the median of 21 calls."""
        scene = scenes.cornell()
        times = []
        for _ in range(22):
            start = time.perf_counter()
            result = sheaf.render(scene, spp=1, size=(4, 4), threads=1)
            times.append(time.perf_counter() - start - result.stats["render_seconds"])
        self.assertLess(np.median(times[1:]), 0.005)

    def test_memory(self):
        """Renders leave nothing behind: the resident memory stops growing."""
        def resident():
            return int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1]) * 4096

        def renders(count):
            for number in range(count):
                scene = sheaf.load_dict(scenes.wall())
                scene.materials["bsdf_1"].reflectance = (0.1, 0.2, number % 10 / 10)
                sheaf.render(scene, spp=1, threads=2, size=(64, 64))

        renders(40)
        before = resident()
        renders(60)
        self.assertLess(resident() - before, 3 << 20)


class Options(unittest.TestCase):
    def test_list(self):
        self.assertTrue({"spp", "aov", "seed", "guiding", "denoise"} <= set(sheaf.options()))
        self.assertFalse({"output", "lenient", "exposure", "checkpoint", "serve", "verbose"} & set(sheaf.options()))
        self.assertTrue({"exposure", "tone_map"} <= set(sheaf.options("write")))
        self.assertTrue({"define", "camera"} <= set(sheaf.options("load")))
        with self.assertRaises(sheaf.UsageError):
            sheaf.options("plot")

    def test_errors(self):
        scene = scenes.cornell()
        cases = [({"ssp": 4}, "unknown option 'ssp' of render\\(\\), did you mean 'spp'"), ({"spp": 0}, "spp.*not in range"),
                 ({"spp": "many"}, "is not a number"), ({"spp": None, "size": (0, 4)}, "size"), ({"spp": object()}, "object"),
                 ({"light_groups": 3}, "expected True or False"), ({"integrator": "pth"}, "did you mean 'path'"),
                 ({"aovs": ["depht"]}, "depht"), ({"crop": (0, 0, 99, 99)}, "crop"), ({"spp": True}, "expected a value")]
        for options, message in cases:
            with self.subTest(options), self.assertRaisesRegex(sheaf.UsageError, message) as caught:
                sheaf.render(scene, **options)
            self.assertEqual((caught.exception.kind, caught.exception.exit_code), ("usage", 2))
        with self.assertRaises(sheaf.UsageError):
            sheaf.render("scene.xml")
        self.assertEqual(sheaf.render(scene, spp=np.int64(2), guiding=True, light_groups=False).stats["spp"], 2)

    def test_files(self):
        with self.assertRaisesRegex(sheaf.SceneError, "nothing.xml: file not found"):
            sheaf.load("nothing.xml")
        with self.assertRaises(sheaf.OutputError) as caught:
            sheaf.render(scenes.cornell(), spp=1).write("/nonexistent/a.exr")
        self.assertIsInstance(caught.exception, OSError)
        with self.assertRaisesRegex(sheaf.UsageError, "must end in"):
            sheaf.render(scenes.cornell(), spp=1).write("a.gif")
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "broken.xml"
            file.write_text('<scene version="3.0.0">\n <sensor type="perspective"/>\n <shape type="spere"/>\n</scene>')
            with self.assertRaises(sheaf.SceneError) as caught:
                sheaf.load(file)
            self.assertEqual((caught.exception.file, caught.exception.line), (str(file), 3))
            with warnings.catch_warnings(record=True) as caught:
                warnings.simplefilter("always")
                sheaf.load(file, lenient=True)
            self.assertTrue(any(issubclass(each.category, sheaf.SheafWarning) for each in caught))


if __name__ == "__main__":
    unittest.main()
