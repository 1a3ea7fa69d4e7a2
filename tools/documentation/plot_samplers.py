#!/usr/bin/env python3
"""Plots the mean squared error of each sampler over samples per pixel in docs/samplers.png. Needs python3-matplotlib.

  tools/documentation/plot_samplers.py [--sheaf build/release/sheaf] [--size 200] [--reference-spp 65536] [--max-spp 1024]
    [--scene SCENE.xml]

Renders a small scenes/cornell with every sampler and 1, 4, 16 ... samples per pixel, a few seeds each, and measures the
error against one long render with `sheaf compare`. Prints the plotted figures.
"""

import argparse
import re
import subprocess
import tempfile
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

ROOT = Path(__file__).resolve().parents[2]
SAMPLERS = {"independent": "#888888", "stratified": "#d08020", "multijitter": "#3060c0", "sobol": "#c02040"}
PANELS = [("path, direct light only", 2), ("path, all light", -1)]
SEEDS = [1, 2]


def render(arguments, output, sampler, spp, seed, max_depth):
    subprocess.run([arguments.sheaf, "render", arguments.scene, "-o", output, "--sampler", sampler, "--spp", str(spp),
                    "--seed", str(seed), "--max-depth", str(max_depth), "--quiet", "-D", f"width={arguments.size}",
                    "-D", f"height={arguments.size * 3 // 4}"], check=True)


def mean_squared_error(arguments, image, reference):
    out = subprocess.run([arguments.sheaf, "compare", image, reference], check=False, text=True,
                         stdout=subprocess.PIPE).stdout
    return float(re.search(r"^MSE +(\S+)", out, re.MULTILINE).group(1))


def measure(arguments, folder, max_depth):
    """Returns {sampler: [error per number of samples]}."""
    reference, image = folder / "reference.exr", folder / "image.exr"
    render(arguments, reference, "sobol", arguments.reference_spp, 1000, max_depth)
    errors = {}
    for sampler in SAMPLERS:
        errors[sampler] = []
        for spp in arguments.samples:
            total = 0.0
            for seed in SEEDS:
                render(arguments, image, sampler, spp, seed, max_depth)
                total += mean_squared_error(arguments, image, reference)
            errors[sampler].append(total / len(SEEDS))
        print(f"depth {max_depth:2d} {sampler:12}", *(f"{error:10.3e}" for error in errors[sampler]), flush=True)
    return errors


def plot(axes, title, samples, errors):
    for sampler, color in SAMPLERS.items():
        axes.loglog(samples, errors[sampler], "o-", color=color, label=sampler, markersize=4)
    start = errors["independent"][0]
    axes.loglog(samples, [start / n for n in samples], ":", color="black", linewidth=1, label="1 / n")
    axes.set_title(title, fontsize=10)
    axes.set_xlabel("samples per pixel")
    axes.set_ylabel("mean squared error")
    axes.set_xticks(samples, [str(n) for n in samples])
    axes.grid(True, which="major", alpha=0.3)
    axes.legend(fontsize=8)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sheaf", default=str(ROOT / "build/release/sheaf"))
    parser.add_argument("--scene", default=str(ROOT / "scenes/cornell/cornell.xml"))
    parser.add_argument("--size", type=int, default=200, help="width of the image")
    parser.add_argument("--reference-spp", type=int, default=65536)
    parser.add_argument("--output", default=str(ROOT / "docs/samplers.png"))
    parser.add_argument("--max-spp", type=int, default=1024, help="maximum number of samples per pixel")
    arguments = parser.parse_args()
    arguments.samples = [4**i for i in range(12) if 4**i <= arguments.max_spp]
    figure, panels = plt.subplots(1, len(PANELS), figsize=(10, 4.2))
    with tempfile.TemporaryDirectory() as folder:
        for axes, (title, max_depth) in zip(panels, PANELS):
            plot(axes, title, arguments.samples, measure(arguments, Path(folder), max_depth))
    figure.tight_layout()
    figure.savefig(arguments.output, dpi=100)


if __name__ == "__main__":
    main()
