#!/usr/bin/env python3
"""Measures the gain from denoising: mean squared error before and after, against long renders. Needs Python with
numpy and a build.

  bench/compare_denoise.py [--scenes scenes/cornell/cornell.xml ...] [--spp 64] [--width 400] [--reference-spp 1024]

Frames are --width pixels wide; 0 keeps the width of the scene. Prints for each scene the error of

  plain      a render with --spp samples and default options
  8 x        the same with 8 times as many samples
  noisy      a render for the denoiser, with its samples in 4 sets
  denoised   `noisy` after `sheaf denoise`

and `gain`, noisy over denoised, and the CPU seconds of denoising. `relative`: the same for the squared error over the
squared mean of the pixel.

There are two references of --reference-spp samples each, with different seeds. If a and b are the differences of an
image from them, the mean of a b is the squared error without the noise of the references.
"""

import argparse
import resource
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from compare_guiding import frame_options
from compare_photons import read_channels
from rendering import ROOT, render

SCENES = ["scenes/cornell/cornell.xml", "scenes/material_room/material_room.xml", "scenes/media/cloud_box.xml"]
LAYERS = ["denoised.R", "denoised.G", "denoised.B"]


def cpu_seconds(command):
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    subprocess.run(command, check=True)
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before


def errors(image, references):
    square = (image - references[0]) * (image - references[1])
    mean = (references[0] + references[1]) / 2
    return square.mean(), (square / (mean**2 + 0.01)).mean()


def compare(arguments, scene, folder):
    options = frame_options(scene, arguments.width) if arguments.width > 0 else []
    noisy, plain, out = (Path(folder) / name for name in ("noisy.exr", "plain.exr", "out.exr"))
    references, plains = [], []
    for seed in (9, 10):
        render(arguments.sheaf, scene, plain, arguments.reference_spp, seed, *options)
        references.append(read_channels(plain, "RGB"))
    for spp in (arguments.spp, 8 * arguments.spp):
        render(arguments.sheaf, scene, plain, spp, 1, *options)
        plains.append(errors(read_channels(plain, "RGB"), references))
    render(arguments.sheaf, scene, noisy, arguments.spp, 1, "--replicates", "4", *options, *arguments.arguments.split())
    seconds = cpu_seconds([str(arguments.sheaf), "denoise", str(noisy), "-o", str(out), "--quiet", "--method",
                           arguments.method])
    before, after = (errors(read_channels(out, names), references) for names in ("RGB", LAYERS))
    for i, name in enumerate((Path(scene).stem, "  relative")):
        print(f"{name:16} {plains[0][i]:10.3e} {plains[1][i]:10.3e} {before[i]:10.3e} {after[i]:10.3e}"
              f" {before[i] / after[i]:6.1f}" + (f" {seconds:8.2f}" if i == 0 else ""), flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sheaf", default=str(ROOT / "build/release/sheaf"))
    parser.add_argument("--scenes", nargs="+", default=[ROOT / scene for scene in SCENES])
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--width", type=int, default=400)
    parser.add_argument("--reference-spp", type=int, default=1024)
    parser.add_argument("--method", default="nlm")
    parser.add_argument("--arguments", default="--aov albedo,normal,depth,variance,half --float",
                        help="further options of sheaf render for the noisy image; default: %(default)s")
    arguments = parser.parse_args()
    print(f"{'':16} {'plain':>10} {'8 x':>10} {'noisy':>10} {'denoised':>10} {'gain':>6} {'cpu s':>8}")
    with tempfile.TemporaryDirectory() as folder:
        for scene in arguments.scenes:
            compare(arguments, scene, folder)


if __name__ == "__main__":
    main()
