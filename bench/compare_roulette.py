#!/usr/bin/env python3
"""Compares start depths of Russian roulette: error times cost at equal samples per pixel. Needs Python with numpy and a
build.

  bench/compare_roulette.py [--scenes scenes/hall/hall.xml ...] [--depths 5 4 3 2] [--spp 16] [--scale 0.2] [--seeds 4]

Prints for each scene and each --rr-depth the number of rays, the mean squared error and the relative squared error
(over the squared mean of the pixel, without the worst 0.1 %), all relative to the first depth. `mse x rays` and `rel
x rays` are the products; a depth pays off below 1. Rays stand in for time: they take most of it and are the same in
every run.

No reference is needed: half the squared difference of two renders with different seeds is an unbiased estimate of the
squared error of each.
"""

import argparse
import tempfile
from pathlib import Path

import numpy as np

from compare_guiding import errors
from compare_photons import read_colors
from rendering import ROOT, render

SCENES = ["cornell/cornell.xml", "material_room/material_room.xml", "gap/gap.xml", "hall/hall.xml"]


def measure(arguments, scene, depth, folder):
    image = Path(folder) / "image.exr"
    rays, images = [], []
    for seed in range(1, arguments.seeds + 1):
        report = render(arguments.sheaf, scene, image, arguments.spp, seed, "--rr-depth", str(depth), "--scale",
                        str(arguments.scale))
        rays.append(sum(report["rays"].values()))
        images.append(read_colors(image))
    mse, rel, _ = errors(images)
    return np.array([np.mean(rays), mse, rel])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sheaf", default=str(ROOT / "build/release/sheaf"))
    parser.add_argument("--scenes", nargs="+", default=[str(ROOT / "scenes" / scene) for scene in SCENES])
    parser.add_argument("--depths", nargs="+", type=int, default=[5, 4, 3, 2])
    parser.add_argument("--spp", type=int, default=16)
    parser.add_argument("--scale", type=float, default=0.2)
    parser.add_argument("--seeds", type=int, default=4, help="renders per configuration, at least 2")
    arguments = parser.parse_args()
    print(f"{'scene':16} {'depth':>5} {'rays':>6} {'mse':>6} {'rel':>6} {'mse x rays':>11} {'rel x rays':>11}")
    with tempfile.TemporaryDirectory() as folder:
        for scene in arguments.scenes:
            base = None
            for depth in arguments.depths:
                found = measure(arguments, scene, depth, folder)
                base = found if base is None else base
                rays, mse, rel = found / base
                print(f"{Path(scene).parent.name:16} {depth:5} {rays:6.3f} {mse:6.3f} {rel:6.3f} {mse * rays:11.3f} "
                      f"{rel * rays:11.3f}", flush=True)


if __name__ == "__main__":
    main()
