#!/usr/bin/env python3
"""Measures the gain from path guiding: time to equal error with --guiding over that without. Needs Python with numpy
and a build.

  bench/compare_guiding.py [--scenes scenes/gap/gap.xml ...] [--spp 64 256] [--width 240] [--seeds 3] [--arguments "..."]

Prints for each scene and number of samples per pixel, without and with guiding: CPU seconds of the whole process,
training included; mean squared error; relative squared error (over the squared mean of the pixel, without the worst 0.1
%); and the mean. `ratio` is error times seconds with guiding over that without; guiding pays off below 1.

No reference is needed: half the squared difference of two renders with different seeds is an unbiased estimate of the
squared error of each. A few very bright pixels dominate the mean squared error, so use several seeds. Frames are
--width pixels wide if the scene file has the variables "width" and "height" (or "resx" and "resy").
"""

import argparse
import re
import tempfile
from pathlib import Path

import numpy as np

from compare_photons import read_colors
from rendering import ROOT, render

SCENES = ["scenes/gap/gap.xml", "scenes/cornell/cornell.xml", "scenes/material_room/material_room.xml"]


def frame_options(scene, width):
    """Returns options that set the frame width and keep its aspect ratio."""
    text = Path(scene).read_text(encoding="utf-8", errors="replace")
    for names in (("width", "height"), ("resx", "resy")):
        found = [re.search(rf'<default name="{name}" value="(\d+)"', text) for name in names]
        if all(found):
            height = round(width * int(found[1][1]) / int(found[0][1]))
            return ["-D", f"{names[0]}={width}", "-D", f"{names[1]}={height}"]
    return []


def errors(images):
    """Returns mean squared error, relative squared error and mean, averaged over consecutive pairs of images."""
    results = []
    for a, b in zip(images, images[1:]):
        square, mean = (a - b)**2 / 2, (a + b) / 2
        relative = np.sort((square / (mean**2 + 0.01 * mean.mean()**2 + 1e-9)).ravel())
        results.append((square.mean(), relative[:int(len(relative) * 0.999)].mean(), mean.mean()))
    return np.mean(results, 0)


def measure(arguments, scene, spp, options, folder):
    image = Path(folder) / "image.exr"
    seconds, images, report = [], [], None
    for seed in range(1, arguments.seeds + 1):
        report = render(arguments.sheaf, scene, image, spp, seed, *options)
        seconds.append(report["cpu_seconds"])
        images.append(read_colors(image))
    return min(seconds), errors(images), report["guiding"]


def compare(arguments, scene, folder):
    options = [*arguments.arguments.split(), *frame_options(scene, arguments.width)]
    for spp in arguments.spp:
        off, error, _ = measure(arguments, scene, spp, [*options, "--guiding", "off"], folder)
        on, guided, guide = measure(arguments, scene, spp, [*options, "--guiding", "on"], folder)
        name = f"{Path(scene).parent.name} {spp} spp"
        print(f"{name:22} {'off':4} {off:7.2f} {error[0]:10.3e} {error[1]:8.4f} {error[2]:9.5f}")
        ratios = guided[:2] * on / (error[:2] * off)
        print(f"{'':22} {'on':4} {on:7.2f} {guided[0]:10.3e} {guided[1]:8.4f} {guided[2]:9.5f}   ratio mse {ratios[0]:.2f}"
              f"  rel {ratios[1]:.2f}   {guide['cells']} cells", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sheaf", default=str(ROOT / "build/release/sheaf"))
    parser.add_argument("--scenes", nargs="+", default=[ROOT / scene for scene in SCENES])
    parser.add_argument("--spp", nargs="+", type=int, default=[64, 256])
    parser.add_argument("--width", type=int, default=240)
    parser.add_argument("--seeds", type=int, default=3, help="renders per configuration, at least 2")
    parser.add_argument("--arguments", default="", help="further options of sheaf render")
    arguments = parser.parse_args()
    print(f"{'scene':22} {'':4} {'cpu s':>7} {'mse':>10} {'rel':>8} {'mean':>9}")
    with tempfile.TemporaryDirectory() as folder:
        for scene in arguments.scenes:
            compare(arguments, scene, folder)


if __name__ == "__main__":
    main()
