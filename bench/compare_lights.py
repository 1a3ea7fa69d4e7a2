#!/usr/bin/env python3
"""Compares light samplers: mean squared error at equal render time with 1, 4, 8 and 32 candidates per vertex. Needs
only Python and a build.

  bench/compare_lights.py [--scene scenes/hall/hall.xml] [--seconds 10] [--reference-spp 4096]

Prints a table: light sampler, candidates, samples per pixel, seconds, mean squared error against a long render, gain
(error times time of uniform sampling with one candidate over that of the row), and rays traced. Lamps are hidden from
the camera, because the pixels at their edges would dominate the error of every sampler.
"""

import argparse
import tempfile
from pathlib import Path

from rendering import ROOT, mean_squared_error, render


def render_lights(arguments, output, selector, candidates, spp, seed):
    """Returns the render time in seconds and the number of rays traced."""
    report = render(arguments.sheaf, arguments.scene, output, spp, seed, "--light-sampler", selector, "--candidates",
                    str(candidates), "-D", f"width={arguments.width}", "-D", f"height={arguments.width * 9 // 16}", "-D",
                    "hide=true")
    return report["render_seconds"], sum(report["rays"].values())


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sheaf", default=str(ROOT / "build/release/sheaf"))
    parser.add_argument("--scene", default=str(ROOT / "scenes/hall/hall.xml"))
    parser.add_argument("--seconds", type=float, default=10, help="render time per image")
    parser.add_argument("--width", type=int, default=240)
    parser.add_argument("--reference-spp", type=int, default=4096)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        reference, image = Path(folder) / "reference.exr", Path(folder) / "image.exr"
        render_lights(arguments, reference, "bvh", 8, arguments.reference_spp, 1000)
        print("sampler  candidates    spp  seconds         MSE   gain     Mrays")
        first = None
        for selector in ("uniform", "power", "bvh"):
            for candidates in (1, 4, 8, 32):
                seconds, _ = render_lights(arguments, image, selector, candidates, 4, 1)
                spp = max(1, round(4 * arguments.seconds / seconds))
                seconds, rays = render_lights(arguments, image, selector, candidates, spp, 2)
                error = mean_squared_error(arguments.sheaf, image, reference)
                # Correct for the remaining difference in time: error is inversely proportional to time.
                cost = error * seconds
                first = first or cost
                print(f"{selector:8} {candidates:10d} {spp:6d} {seconds:8.2f} {error:11.4g} {first / cost:6.2f} "
                      f"{rays / 1e6:9.1f}", flush=True)


if __name__ == "__main__":
    main()
