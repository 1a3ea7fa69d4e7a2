"""The tutorial and the examples, at tiny sizes."""

import os
import runpy
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from unittest import mock

import numpy as np

import scenes
import sheaf

os.environ["MPLBACKEND"] = "Agg"
EXAMPLES = scenes.ROOT / "tools/python/examples"
TINY = ["--size", "16", "12", "--spp", "2"]
ARGUMENTS = {
    "bsdf_lobes.py": ["{out}/lobes.png", "--samples", "50"],
    "convergence.py": [*TINY, "{out}/convergence.png", "--reference-spp", "4"],
    "dataset.py": [*TINY, "{out}/views", "--count", "2"],
    "light_tracing.py": [*TINY, "{out}/caustic.png"],
    "roughness_slider.py": [*TINY, "--save", "{out}/strip.png"],
    "turntable.py": [*TINY, "{out}/turntable.gif", "--frames", "2"],
}

try:
    import matplotlib
except ImportError:
    matplotlib = None


@unittest.skipIf(matplotlib is None, "needs Matplotlib")
class Examples(unittest.TestCase):
    def test_all_are_listed(self):
        self.assertEqual({file.name for file in EXAMPLES.glob("*.py")} - {"common.py"}, set(ARGUMENTS))

    def test_examples(self):
        for name, arguments in ARGUMENTS.items():
            with self.subTest(name), tempfile.TemporaryDirectory() as folder, \
                 mock.patch.object(sys, "path", [str(EXAMPLES), *sys.path]), \
                 mock.patch.object(sys, "argv", [name, *(word.format(out=folder) for word in arguments)]):
                runpy.run_path(str(EXAMPLES / name), run_name="__main__")
                self.assertTrue(list(Path(folder).rglob("*.png")))
                if name == "dataset.py":
                    self.check_view(Path(folder) / "views/view_0001.npz")

    def check_view(self, file):
        """Depth and hits agree where an object covers the pixel."""
        view = np.load(file)
        self.assertEqual(view["depth"].shape, view["object"].shape)
        nothing = view["object"] < 0
        self.assertTrue((view["depth"][nothing] < 12).all() and (view["depth"][~nothing] > 0).all())

    def test_tutorial(self):
        """Runs all cells, with few samples and pixels."""
        render = sheaf.render
        with mock.patch.object(sheaf, "render", lambda scene, **options: render(
                scene, **(options | {"spp": min(options["spp"], 8), "size": (16, 12)}))):
            out = runpy.run_path(str(scenes.ROOT / "docs/tutorials/python_source.py"))
        self.assertTrue(out["changed"]._native.kept_accel)
        matplotlib.pyplot.close("all")
        subprocess.run([sys.executable, scenes.ROOT / "tools/documentation/make_notebook.py", "--check"], check=True)


if __name__ == "__main__":
    unittest.main()
