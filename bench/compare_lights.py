#!/usr/bin/env python3
"""Measures how lights are best chosen: the mean squared error at equal render time of every light sampler with 1, 4, 8
and 32 candidates per vertex. Needs nothing but Python and a build.

  bench/compare_lights.py [--scene scenes/hall/hall.xml] [--seconds 10] [--reference-spp 4096]

Prints a table: light sampler, candidates, samples per pixel, seconds, mean squared error against a long render, that of
uniform choice with one candidate over it, and rays traced. Lamps are hidden from the camera: the pixels at their edges
would be most of the error, whatever the choice.
"""

import argparse
import tempfile
from pathlib import Path

from rendering import ROOT, mean_squared_error, render


def render_lights(arguments, output, selector, candidates, spp, seed):
    """Seconds spent rendering, and rays traced."""
    report = render(arguments.sheaf, arguments.scene, output, spp, seed, "--light-sampler", selector, "--candidates",
                    str(candidates), "-D", f"width={arguments.width}", "-D", f"height={arguments.width * 9 // 16}", "-D",
                    "hide=true")
    return report["render_seconds"], sum(report["rays"].values())


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sheaf", default=str(ROOT / "build/release/sheaf"))
    parser.add_argument("--scene", default=str(ROOT / "scenes/hall/hall.xml"))
    parser.add_argument("--seconds", type=float, default=10, help="render time of each picture")
    parser.add_argument("--width", type=int, default=240)
    parser.add_argument("--reference-spp", type=int, default=4096)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        reference, picture = Path(folder) / "reference.exr", Path(folder) / "picture.exr"
        render_lights(arguments, reference, "bvh", 8, arguments.reference_spp, 1000)
        print("sampler  candidates    spp  seconds         MSE   gain     Mrays")
        first = None
        for selector in ("uniform", "power", "bvh"):
            for candidates in (1, 4, 8, 32):
                seconds, _ = render_lights(arguments, picture, selector, candidates, 4, 1)
                spp = max(1, round(4 * arguments.seconds / seconds))
                seconds, rays = render_lights(arguments, picture, selector, candidates, spp, 2)
                error = mean_squared_error(arguments.sheaf, picture, reference)
                # What is left of the difference in time counts as if error went with its inverse.
                cost = error * seconds
                first = first or cost
                print(f"{selector:8} {candidates:10d} {spp:6d} {seconds:8.2f} {error:11.4g} {first / cost:6.2f} "
                      f"{rays / 1e6:9.1f}", flush=True)


if __name__ == "__main__":
    main()
