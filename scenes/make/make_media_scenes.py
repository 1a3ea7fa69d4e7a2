#!/usr/bin/env python3
"""Writes the assets of scenes/media: a glass bowl and glass steps (scenes/media/meshes), and the cloud and fire grids
(scenes/media/generated, by make_cloud). Needs only Python and a build; the output is deterministic.

  scenes/make/make_media_scenes.py [--make-cloud PROGRAM] [--meshes-only]

Runs make_cloud from build/release, where tools/quickstart.sh builds it, or else from PATH.
"""

import argparse
import math
import shutil
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / "scenes" / "media"

# Profile of the bowl as radius and height: from the center of the foot outwards, up, and down on the inside.
BOWL = [(0.0, 0.0), (0.34, 0.0), (0.36, 0.02), (0.34, 0.06), (0.27, 0.12), (0.30, 0.20), (0.46, 0.30), (0.62, 0.44),
        (0.72, 0.62), (0.76, 0.82), (0.77, 0.92), (0.755, 0.945), (0.735, 0.92), (0.71, 0.80), (0.65, 0.64),
        (0.53, 0.50), (0.36, 0.41), (0.18, 0.37), (0.0, 0.36)]
SIDES = 48
STEPS_PER_SPAN = 2


def spline(points, t):
    """Evaluates the Catmull-Rom spline through the points; t is in units of points."""
    i = min(int(t), len(points) - 2)
    f = t - i
    p = [points[min(max(i + k, 0), len(points) - 1)] for k in (-1, 0, 1, 2)]
    return tuple(0.5 * (2 * p[1][c] + f * (p[2][c] - p[0][c]) + f * f * (2 * p[0][c] - 5 * p[1][c] + 4 * p[2][c] - p[3][c])
                        + f**3 * (3 * p[1][c] - p[0][c] - 3 * p[2][c] + p[3][c])) for c in (0, 1))


def make_bowl():
    """Returns a closed surface of revolution about +y, with normals pointing out of the glass."""
    count = (len(BOWL) - 1) * STEPS_PER_SPAN
    outline = [spline(BOWL, i / STEPS_PER_SPAN) for i in range(count + 1)]
    outline[0], outline[-1] = BOWL[0], BOWL[-1]
    lines, faces = [], []
    for i, (radius, height) in enumerate(outline):
        before, after = outline[max(i - 1, 0)], outline[min(i + 1, count)]
        along = (after[0] - before[0], after[1] - before[1])
        length = math.hypot(*along)
        normal = (along[1] / length, -along[0] / length) if 0 < i < count else (0.0, -1.0 if i == 0 else 1.0)
        for k in range(SIDES):
            c, s = math.cos(2 * math.pi * k / SIDES), math.sin(2 * math.pi * k / SIDES)
            lines.append(f"v {max(radius, 0.0) * c:.4f} {height:.4f} {max(radius, 0.0) * s:.4f}")
            lines.append(f"vn {normal[0] * c:.3f} {normal[1]:.3f} {normal[0] * s:.3f}")
    for i in range(count):
        for k in range(SIDES):
            a, b = i * SIDES + k + 1, i * SIDES + (k + 1) % SIDES + 1
            c, d = a + SIDES, b + SIDES
            if i > 0:
                faces.append(f"f {a}//{a} {c}//{c} {b}//{b}")
            if i < count - 1:
                faces.append(f"f {b}//{b} {c}//{c} {d}//{d}")
    return "# A bowl of glass, written by scenes/make/make_media_scenes.py.\n" + "\n".join(lines + faces) + "\n"


def make_stairs(steps=5):
    """Returns a solid block without inner faces whose thickness in z grows in steps; x from 0 to `steps`."""
    vertices, faces = [], []

    def polygon(*corners):
        start = len(vertices)
        vertices.extend(corners)
        faces.append("f " + " ".join(str(start + k + 1) for k in range(len(corners))))

    def depth(step):
        return 0.25 * 1.8**step if 0 <= step < steps else 0.0

    for i in range(steps):
        z, before = depth(i), depth(i - 1)
        polygon((i, 0, 0), (i, 1, 0), (i + 1, 1, 0), (i + 1, 0, 0))
        polygon((i, 0, z), (i + 1, 0, z), (i + 1, 1, z), (i, 1, z))
        # The sides have the upper corners of the step before, so that the surface is closed
        polygon(*([(i, 0, before)] if i > 0 else []), (i, 0, 0), (i + 1, 0, 0), (i + 1, 0, z), (i, 0, z))
        polygon(*([(i, 1, before)] if i > 0 else []), (i, 1, z), (i + 1, 1, z), (i + 1, 1, 0), (i, 1, 0))
        polygon((i, 0, before), (i, 0, z), (i, 1, z), (i, 1, before))
    z = depth(steps - 1)
    polygon((steps, 0, 0), (steps, 1, 0), (steps, 1, z), (steps, 0, z))
    lines = [f"v {x:g} {y:g} {c:.5g}" for x, y, c in vertices]
    return "# Steps of glass, written by scenes/make/make_media_scenes.py.\n" + "\n".join(lines + faces) + "\n"


def find_make_cloud():
    """Returns the path of make_cloud in build/release, or else in PATH."""
    built = ROOT / "build/release/make_cloud"
    return str(built) if built.is_file() else shutil.which("make_cloud") or str(built)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--make-cloud", default=find_make_cloud())
    parser.add_argument("--meshes-only", action="store_true")
    arguments = parser.parse_args()
    (FOLDER / "meshes").mkdir(parents=True, exist_ok=True)
    (FOLDER / "meshes" / "bowl.obj").write_text(make_bowl())
    (FOLDER / "meshes" / "stairs.obj").write_text(make_stairs())
    if arguments.meshes_only:
        return
    generated = FOLDER / "generated"
    if not Path(arguments.make_cloud).is_file():
        parser.error(f"{arguments.make_cloud} not found: build it, or pass its path with --make-cloud")
    generated.mkdir(exist_ok=True)
    for options in (["cloud.nvdb", "--resolution", "160"],
                    ["fire.nvdb", "--kind", "smoke", "--temperature", "--resolution", "128"]):
        subprocess.run([arguments.make_cloud, str(generated / options[0]), *options[1:]], check=True)


if __name__ == "__main__":
    main()
