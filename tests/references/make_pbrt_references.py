#!/usr/bin/env python3
"""Renders the references of moving scenes with pbrt-v4, an independent renderer.

  tests/references/make_pbrt_references.py --pbrt PROGRAM [--spp N] [--images N] [NAME ...]

Needs pbrt-v4, and Mitsuba's Python package to write the files. Without names, all scenes of tests/references/pbrt are
rendered. Each is rendered N times with different seeds: the mean of the images is the reference, and their variance
times the samples of an image is that of one sample. See make_references.py for the files.
"""

import argparse
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from make_references import FOLDER, mitsuba, write

SCENES = FOLDER / "pbrt"


def render(pbrt, scene, spp, seed, folder):
    """Pixels of one image, linear Rec.709."""
    file = Path(folder) / "image.exr"
    # In other coordinates, pbrt's interpolation of turning instances depends on the position of the camera.
    subprocess.run([pbrt, "--quiet", "--render-coord-sys", "world", "--spp", str(spp), "--seed", str(seed), "--outfile",
                    file, scene], check=True)
    return np.array(mitsuba().Bitmap(str(file)))[..., :3].astype(float)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME")
    parser.add_argument("--pbrt", required=True, help="the program pbrt")
    parser.add_argument("--spp", type=int, default=256, help="samples per pixel of an image")
    parser.add_argument("--images", type=int, default=48, help="number of images")
    arguments = parser.parse_args()
    for name in arguments.names or sorted(scene.stem for scene in SCENES.glob("*.pbrt")):
        with tempfile.TemporaryDirectory() as folder:
            images = np.array([render(arguments.pbrt, SCENES / f"{name}.pbrt", arguments.spp, seed, folder)
                               for seed in range(arguments.images)])
        write(name, images.mean(axis=0), images.var(axis=0, ddof=1) * arguments.spp, arguments.spp * arguments.images)


if __name__ == "__main__":
    main()
