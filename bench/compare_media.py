#!/usr/bin/env python3
"""Compares medium estimators on a cloud: time and mean squared error. Needs only Python, a build, and the cloud of
scenes/make/make_media_scenes.py.

  bench/compare_media.py [--scene scenes/media/cloud_box.xml] [--spp 32] [--seeds 2] [--reference-spp 768]

Prints a table: estimator; CPU seconds, minus those of a render with 1 spp; mean squared error against a long render
with null_mis; time to equal error over that of null_mis; null collisions (for ray marching: steps) per real collision;
and CPU nanoseconds per collision in the medium stage.
"""

import argparse
import tempfile
from pathlib import Path

from rendering import ROOT, mean_squared_error, render


def render_media(arguments, output, options, spp, seed):
    """Renders and returns the statistics report."""
    return render(arguments.sheaf, arguments.scene, output, spp, seed, "--threads", str(arguments.threads), *options,
                  "-D", f"width={arguments.width}", "-D", f"height={arguments.width * 5 // 8}")


def step_cost(report, seconds):
    """Returns CPU nanoseconds per collision in the medium stage, and null collisions per real one.

    The stages' timers include time taken by other programs, so only the stage's share of the total is used.
    """
    stages = {stage["name"]: stage["seconds"] for stage in report["stages"]}
    collisions = report["collisions"]
    real, null = collisions["real"], collisions["null"]
    return 1e9 * seconds * stages["medium"] / sum(stages.values()) / max(real + null, 1), null / max(real, 1)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sheaf", default=str(ROOT / "build/release/sheaf"))
    parser.add_argument("--scene", default=str(ROOT / "scenes/media/cloud_box.xml"))
    parser.add_argument("--width", type=int, default=100)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--spp", type=int, default=32)
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--reference-spp", type=int, default=768)
    parser.add_argument("--steps", type=float, nargs="+", default=[0.02, 0.08], help="ray marching steps in meters")
    arguments = parser.parse_args()
    cases = [(name, ["--medium-estimator", name]) for name in ("null_mis", "delta", "ratio")]
    cases += [(f"marching {step:g}", ["--medium-estimator", "marching", "--step-size", str(step)])
              for step in arguments.steps]
    with tempfile.TemporaryDirectory() as folder:
        reference, image = Path(folder) / "reference.exr", Path(folder) / "image.exr"
        render_media(arguments, reference, ["--medium-estimator", "null_mis"], arguments.reference_spp, 1000)
        print("estimator      cpu s         MSE   time  null/real  ns/collision")
        first = None
        for name, options in cases:
            start = render_media(arguments, image, options, 1, 1)["cpu_seconds"]
            seconds = error = 0
            for seed in range(2, 2 + arguments.seeds):
                report = render_media(arguments, image, options, arguments.spp, seed)
                seconds += (report["cpu_seconds"] - start) / arguments.seeds
                error += mean_squared_error(arguments.sheaf, image, reference) / arguments.seeds
            cost = error * seconds  # error is inversely proportional to time
            first = first or cost
            nanoseconds, null = step_cost(report, seconds)
            print(f"{name:14} {seconds:5.2f} {error:11.4g} {cost / first:6.2f} {null:10.2f} {nanoseconds:13.0f}", flush=True)


if __name__ == "__main__":
    main()
