#!/usr/bin/env python3
"""Measures the noise of spectral mode: mean squared error over that of RGB mode at equal samples per pixel. Needs only
Python and a build.

  bench/compare_color.py [--scenes scenes/cornell/cornell.xml ...] [--spp 64] [--seeds 4]

Prints per scene: mean squared error over R, G and B in RGB mode and in spectral mode, and their ratio. Renders the
window --crop --seeds times with the scene's own sampler; half the mean squared difference of two renders estimates
the error of one.
"""

import argparse
import itertools
import tempfile
from pathlib import Path

from rendering import ROOT, mean_squared_error, render


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sheaf", default=str(ROOT / "build/release/sheaf"))
    parser.add_argument("--scenes", nargs="+", default=[str(ROOT / "scenes" / name / f"{name}.xml")
                                                        for name in ("cornell", "material_room")])
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--seeds", type=int, default=4)
    parser.add_argument("--crop", default="100,100,228,196")
    arguments = parser.parse_args()
    print("scene                 MSE rgb  MSE spectral   ratio")
    with tempfile.TemporaryDirectory() as folder:
        images = [Path(folder) / f"{i}.exr" for i in range(arguments.seeds)]
        for scene in arguments.scenes:
            error = {}
            for color in ("rgb", "spectral"):
                for seed, image in enumerate(images, 1):
                    render(arguments.sheaf, scene, image, arguments.spp, seed, "--color", color, "--crop",
                           arguments.crop)
                pairs = list(itertools.combinations(images, 2))
                error[color] = sum(mean_squared_error(arguments.sheaf, a, b) for a, b in pairs) / (2 * len(pairs))
            print(f"{Path(scene).stem:16} {error['rgb']:12.4g}  {error['spectral']:12.4g}  "
                  f"{error['spectral'] / error['rgb']:6.3f}", flush=True)


if __name__ == "__main__":
    main()
