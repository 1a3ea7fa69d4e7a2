#!/usr/bin/env python3
"""Measures the gain from adaptive sampling: time to a given noise level over that of uniform sampling. Needs Python
with numpy and a build.

  bench/compare_adaptive.py [--scenes scenes/hall/hall.xml ...] [--target 0.05] [--max-spp 16384] [--width 240] [--seeds 3]

Renders each scene with --noise-target, then uniformly with the mean number of samples that this took. Prints for both:
samples per pixel; CPU seconds of the whole process; the noise of the frame (root mean square of the relative error);
and the 95th percentile of the noise over tiles. `time` is the time of adaptive over uniform sampling to equal noise,
assuming that squared noise is inversely proportional to time: by the noisy tiles, and by the frame, whose noise is the
target.

No reference is needed: half the squared difference of two renders with different seeds is an unbiased estimate of the
squared error of each. Tiles are 32 pixels wide; the worst 0.1 % of a tile's pixels are excluded.
"""

import argparse
import tempfile
from pathlib import Path

import numpy as np

from compare_guiding import frame_options
from compare_photons import read_colors
from rendering import ROOT, render

SCENES = ["scenes/hall/hall.xml", "scenes/caustics/ring.xml", "scenes/caustics/cornell_glass.xml",
          "scenes/material_room/material_room.xml"]
TILE = 32


def tile_errors(images):
    """Returns the mean squared relative error of each tile, averaged over consecutive pairs of images."""
    light = [image @ np.array([0.2126, 0.7152, 0.0722]) for image in images]
    mean = np.mean(light, 0)
    scale = mean**2 + (0.1 * mean.mean())**2
    square = np.mean([(a - b)**2 / 2 for a, b in zip(light, light[1:])], 0) / scale
    tiles = []
    for y in range(0, square.shape[0], TILE):
        for x in range(0, square.shape[1], TILE):
            values = np.sort(square[y:y + TILE, x:x + TILE].ravel())
            tiles.append(values[:int(len(values) * 0.999)].mean())
    return np.array(tiles)


def measure(arguments, scene, spp, options, folder):
    """Returns seconds, samples per pixel, and squared noise: mean over tiles and 95th percentile."""
    seconds, samples, images = [], [], []
    for seed in range(1, arguments.seeds + 1):
        report = render(arguments.sheaf, scene, Path(folder) / "image.exr", spp, seed, *options)
        seconds.append(report["cpu_seconds"])
        samples.append(report["spp"])
        images.append(read_colors(Path(folder) / "image.exr"))
    errors = tile_errors(images)
    return np.mean(seconds), round(np.mean(samples)), errors.mean(), np.quantile(errors, 0.95)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sheaf", default=str(ROOT / "build/release/sheaf"))
    parser.add_argument("--scenes", nargs="+", default=[str(ROOT / scene) for scene in SCENES])
    parser.add_argument("--target", type=float, default=0.05)
    parser.add_argument("--max-spp", type=int, default=16384)
    parser.add_argument("--width", type=int, default=240)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--arguments", default="", help="further options of sheaf render, for both")
    arguments = parser.parse_args()
    print(f"{'scene':16s} {'sampling':9s} {'spp':>6s} {'seconds':>8s} {'noise':>7s} {'noisy tiles':>12s}   time: tiles   frame")
    with tempfile.TemporaryDirectory() as folder:
        for scene in arguments.scenes:
            options = frame_options(scene, arguments.width) + arguments.arguments.split()
            adaptive = measure(arguments, scene, arguments.max_spp, options + ["--noise-target", str(arguments.target)],
                               folder)
            uniform = measure(arguments, scene, adaptive[1], options, folder)
            for name, (seconds, spp, frame, worst) in (("adaptive", adaptive), ("uniform", uniform)):
                line = f"{Path(scene).stem:16s} {name:9s} {spp:6d} {seconds:8.2f} {frame**0.5:7.4f} {worst**0.5:12.4f}"
                if name == "adaptive":
                    tiles, whole = (adaptive[0] * adaptive[k] / (uniform[0] * uniform[k]) for k in (3, 2))
                    line += f"   {tiles:11.2f} {whole:7.2f}"
                print(line, flush=True)


if __name__ == "__main__":
    main()
