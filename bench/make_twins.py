#!/usr/bin/env python3
"""Writes the twin scenes, which compare_renderers.py renders with Sheaf, Cycles and LuxCore, as scene files for Sheaf
and Mitsuba. Needs Python with numpy, whose version may change last digits of coordinates.

  bench/make_twins.py [SCENE...] [--output out/twins] [--sheaf PROGRAM]

With --sheaf, it also renders each scene once, with 1 sample per pixel and a fifth of its size, into its folder.
Exit status: 0 written, 1 Sheaf failed, 2 wrong usage.
"""

import argparse
import subprocess
import sys
from pathlib import Path

from rendering import ROOT
from twins import sheaf_writer
from twins.scenes import SCENES


def write_twins(names, folder):
    """Writes scenes into folders of their names and returns {name: scene file}."""
    return {name: sheaf_writer.write(SCENES[name](), folder / name) for name in names}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", metavar="SCENE", help=f"default: {' '.join(SCENES)}")
    parser.add_argument("--output", type=Path, default=ROOT / "out/twins", help="folder")
    parser.add_argument("--sheaf", help="program that renders each scene as a test")
    arguments = parser.parse_args()
    unknown = [name for name in arguments.scenes if name not in SCENES]
    if unknown:
        parser.error(f"no scene {unknown[0]} (known: {', '.join(SCENES)})")
    for name, file in write_twins(arguments.scenes or SCENES, arguments.output).items():
        print(f"wrote {file}", flush=True)
        test = [arguments.sheaf, "render", file, "-o", file.with_name("test.exr"), "--spp", "1", "--scale", "0.2", "-q"]
        if arguments.sheaf and subprocess.run(test, check=False).returncode != 0:
            sys.exit(f"make_twins.py: {arguments.sheaf} does not render {name}")


if __name__ == "__main__":
    main()
