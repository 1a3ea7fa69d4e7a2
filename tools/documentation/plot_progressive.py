#!/usr/bin/env python3
"""Plots the convergence of progressive photon mapping to path tracing in docs/progressive.png. Needs
python3-matplotlib.

  tools/documentation/plot_progressive.py [--sheaf build/release/sheaf] [--size 120] [--reference-spp 16384] [--max-passes 256]
    [--scene SCENE.xml]

Renders a small scenes/cornell with `sppm` for several values of alpha and 1, 4, 16 ... passes, and with `path` at the
same numbers of samples, a few seeds each. `sheaf compare` measures the bias of the mean and the mean squared error
against one long render with `path`. Prints the plotted figures.
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
ALPHAS = {0.5: "#d08020", 0.7: "#c02040", 0.9: "#3060c0"}
SEEDS = [1, 2]
SPPM = """<integrator type="sppm"><integer name="photonCount" value="{photons}"/><float name="initialRadius"
 value="{radius}"/><float name="alpha" value="{alpha}"/></integrator>"""


def render(arguments, scene, output, spp, seed):
    subprocess.run([arguments.sheaf, "render", scene, "-o", output, "--spp", str(spp), "--seed", str(seed), "--quiet",
                    "-D", f"width={arguments.size}", "-D", f"height={arguments.size * 3 // 4}"], check=True)


def compare(arguments, image, reference):
    """Returns the mean squared error and the relative bias of the mean."""
    out = subprocess.run([arguments.sheaf, "compare", image, reference], check=False, text=True,
                         stdout=subprocess.PIPE).stdout
    value = {name: float(re.search(rf"^{name} +(\S+)", out, re.MULTILINE).group(1)) for name in ("MSE", "mean ratio")}
    return value["MSE"], abs(value["mean ratio"] - 1)


def measure(arguments, folder, reference, name, scene):
    errors, biases = [], []
    for passes in arguments.passes:
        found = []
        for seed in SEEDS:
            render(arguments, scene, folder / "image.exr", passes, seed)
            found.append(compare(arguments, folder / "image.exr", reference))
        errors.append(sum(error for error, _ in found) / len(found))
        biases.append(sum(bias for _, bias in found) / len(found))
    print(f"{name:10} error", *(f"{error:10.3e}" for error in errors), flush=True)
    print(f"{name:10} bias ", *(f"{bias:10.3e}" for bias in biases), flush=True)
    return errors, biases


def plot(panels, arguments, name, color, errors, biases):
    for axes, values in zip(panels, (biases, errors)):
        axes.loglog(arguments.passes, values, "o-", color=color, label=name, markersize=4)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sheaf", default=str(ROOT / "build/release/sheaf"))
    parser.add_argument("--scene", type=Path, default=ROOT / "scenes/cornell/cornell.xml",
                        help="scene file with $width, $height and an empty <integrator/>")
    parser.add_argument("--size", type=int, default=120, help="width of the image")
    parser.add_argument("--photons", type=int, default=20000, help="photons per pass")
    parser.add_argument("--radius", type=float, default=0.1, help="radius of the first pass, in scene units")
    parser.add_argument("--reference-spp", type=int, default=16384)
    parser.add_argument("--max-passes", type=int, default=256)
    parser.add_argument("--output", default=str(ROOT / "docs/progressive.png"))
    arguments = parser.parse_args()
    arguments.passes = [4**i for i in range(12) if 4**i <= arguments.max_passes]
    text = arguments.scene.read_text(encoding="utf-8")
    figure, panels = plt.subplots(1, 2, figsize=(10, 4.2))
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        # Resolve meshes relative to the original scene file.
        for entry in arguments.scene.resolve().parent.iterdir():
            if entry.is_dir():
                (folder / entry.name).symlink_to(entry)
        reference = folder / "reference.exr"
        render(arguments, arguments.scene, reference, arguments.reference_spp, 1000)
        for alpha, color in ALPHAS.items():
            scene = folder / f"alpha_{alpha}.xml"
            sppm = SPPM.format(photons=arguments.photons, radius=arguments.radius, alpha=alpha)
            scene.write_text(re.sub(r"<integrator [^>]*/>", sppm, text), encoding="utf-8")
            label = f"alpha {alpha}"
            plot(panels, arguments, label, color, *measure(arguments, folder, reference, label, scene))
        plot(panels, arguments, "path", "#888888", *measure(arguments, folder, reference, "path", arguments.scene))
    for axes, title in zip(panels, ("bias: distance of the mean", "mean squared error")):
        axes.set_title(title, fontsize=10)
        axes.set_xlabel("passes, or samples per pixel")
        axes.set_xticks(arguments.passes, [str(n) for n in arguments.passes])
        axes.grid(True, which="major", alpha=0.3)
        axes.legend(fontsize=8)
    figure.tight_layout()
    figure.savefig(arguments.output, dpi=100)


if __name__ == "__main__":
    main()
