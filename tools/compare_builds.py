#!/usr/bin/env python3
"""Renders every example and reference scene with two builds of Sheaf in both color modes and lists the images that
are not byte-identical, apart from the names in their headers. For changes that must not alter images. Needs only
Python.

  tools/compare_builds.py OLD/sheaf NEW/sheaf [--spp 8] [--only SUBSTRING] [--list]

Scenes with a configurable size are rendered at 160 x 100 pixels, other example scenes as a centered crop of 160 x 120.
Scenes whose meshes or grids have not been generated (see README.md) are reported and skipped. Exit status: 0 if all
images are identical, 1 if some differ or fail with only one of the builds.
"""

import argparse
import re
import struct
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def scenes():
    """Yields each scene file with the options for a small image."""
    for folder in (ROOT / "scenes", ROOT / "tests/references/scenes"):
        for file in sorted(folder.rglob("*.xml")):
            text = file.read_text()
            if "generated" in file.parts or not re.search(r"<(sensor|camera)\b", text):
                continue
            sizes = [re.search(rf'name="{name}" value="(\d+)"/>', text) for name in ("width", "height")]
            if '"$width"' in text:
                yield file, ["-D", "width=160", "-D", "height=100"]
            elif folder.name == "scenes" and folder.parent == ROOT and all(sizes):
                x, y = (int(size[1]) // 2 for size in sizes)
                yield file, ["--crop", f"{max(x - 80, 0)},{max(y - 60, 0)},{x + 80},{y + 60}"]
            else:
                yield file, []


# Attributes of images that name the version, or settings that versions of Sheaf name differently.
NAMES = {b"Software", b"sheaf/version", b"sheaf/integrator"}


def contents(exr):
    """The attributes of an OpenEXR file, without NAMES, and the bytes of its pixels."""
    attributes, at = {}, 8
    while exr[at] != 0:
        name, kind = exr[at:at + 512].split(b"\0", 2)[:2]
        begin = at + len(name) + len(kind) + 2
        at = begin + 4 + struct.unpack_from("<i", exr, begin)[0]
        if name not in NAMES:
            attributes[name] = exr[begin:at]
    return attributes, exr[struct.unpack_from("<Q", exr, at + 1)[0]:]  # from the first chunk


def render(sheaf, scene, options, image):
    """Returns the contents of the image, or the error message."""
    done = subprocess.run([sheaf, "render", scene, "-o", image, "--no-timestamps", "--quiet", "--threads", "1",
                           "--seed", "1", *options], check=False, capture_output=True, text=True)
    return contents(image.read_bytes()) if done.returncode == 0 else done.stderr.strip()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("old", type=lambda p: Path(p).resolve())
    parser.add_argument("new", type=lambda p: Path(p).resolve())
    parser.add_argument("--spp", type=int, default=8)
    parser.add_argument("--only", default="", help="render only scenes whose path contains this")
    parser.add_argument("--list", action="store_true", help="list the result of every image, not only differences")
    arguments = parser.parse_args()

    def compare(job):
        (scene, options), color = job
        options = [*options, "--spp", str(arguments.spp), "--color", color]
        with tempfile.TemporaryDirectory() as folder:
            a, b = (render(sheaf, scene, options, Path(folder) / f"{i}.exr")
                    for i, sheaf in enumerate((arguments.old, arguments.new)))
        if isinstance(a, str) and isinstance(b, str):
            return "neither renders: " + b
        if isinstance(a, str) or isinstance(b, str):
            return "FAILS with one build: " + (a if isinstance(a, str) else b)
        return "same" if a == b else "DIFFERS"

    jobs = [(scene, color) for scene in scenes() if arguments.only in str(scene[0]) for color in ("rgb", "spectral")]
    counts = {}
    with ThreadPoolExecutor(2) as pool:
        for ((scene, _), color), found in zip(jobs, pool.map(compare, jobs)):
            kind = found.split(":")[0]
            counts[kind] = counts.get(kind, 0) + 1
            if kind != "same" or arguments.list:
                print(f"{found.splitlines()[0]}  {scene.relative_to(ROOT)} {color}", flush=True)
    print(", ".join(f"{count} {kind}" for kind, count in sorted(counts.items())))
    sys.exit(1 if any(kind.startswith(("DIFFERS", "FAILS")) for kind in counts) else 0)


if __name__ == "__main__":
    main()
