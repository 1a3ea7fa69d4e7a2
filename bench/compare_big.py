#!/usr/bin/env python3
"""Compares the time to the first pixel and the peak memory of big scenes, beside Mitsuba 3. Needs only Python and a
build.

  bench/compare_big.py [--sheaf OLD/sheaf NEW/sheaf] [--mitsuba-python ENVIRONMENT/bin/python] [--variant scalar_rgb]
                       [--side 300] [--instances 500] [--runs 3]

Writes two scenes with one PLY mesh of 2 x SIDE^2 triangles: the mesh itself, and INSTANCES instances of it. Every round
renders each scene once with each program, at 1 sample in an image of 8 x 8 pixels. Prints medians: wall-clock and CPU
seconds of the whole process, peak memory, and the same per triangle of the mesh. Mitsuba's include Python's start. For
20 million triangles: --side 3162.
"""

import argparse
import math
import os
import statistics
import subprocess
import tempfile
import time
from pathlib import Path

from compare_loading import ROOT, write_ply

MITSUBA = """
import sys, mitsuba as mi
mi.set_variant(sys.argv[1])
mi.render(mi.load_file(sys.argv[2]), spp=1).numpy()
"""
HEAD = """<scene version="3.0.0"><integrator type="path"/><emitter type="constant"/><sensor type="perspective">
<transform name="to_world"><lookat origin="0.5, -1, 1" target="0.5, 0.5, 0" up="0, 0, 1"/></transform>
<film type="hdrfilm"><integer name="width" value="8"/><integer name="height" value="8"/></film>
<sampler type="independent"><integer name="sample_count" value="1"/></sampler></sensor>
"""
MESH = '<shape type="ply"><string name="filename" value="mesh.ply"/></shape>'


def write_scenes(folder, side, instances):
    write_ply(folder / "mesh.ply", side)
    columns = math.isqrt(max(instances - 1, 0)) + 1
    placed = "\n".join(f'<shape type="instance"><ref id="group"/><transform name="to_world"><translate x="{i % columns}" '
                       f'y="{i // columns}"/></transform></shape>' for i in range(instances))
    unique, instanced = folder / "unique.xml", folder / "instances.xml"
    unique.write_text(f"{HEAD}{MESH}</scene>\n")
    instanced.write_text(f'{HEAD}<shape type="shapegroup" id="group">{MESH}</shape>{placed}</scene>\n')
    return [unique, instanced]


def measure(command):
    """Seconds of wall clock and CPU, and peak memory in bytes, of one process."""
    start = time.monotonic()
    with subprocess.Popen(command, stdout=subprocess.DEVNULL) as process:
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise SystemExit(f"failed: {' '.join(command)}")
    return time.monotonic() - start, usage.ru_utime + usage.ru_stime, usage.ru_maxrss * 1024


def commands(arguments, folder):
    """The command line of each program for a scene."""
    programs = {sheaf: lambda scene, sheaf=sheaf: [sheaf, "render", str(scene), "-qq", "-o", str(folder / "out.exr")]
                for sheaf in arguments.sheaf}
    if arguments.mitsuba_python:
        programs["Mitsuba " + arguments.variant] = lambda scene: [arguments.mitsuba_python, "-c", MITSUBA,
                                                                  arguments.variant, str(scene)]
    return programs


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sheaf", nargs="+", default=[str(ROOT / "build/release/sheaf")])
    parser.add_argument("--mitsuba-python")
    parser.add_argument("--variant", default="scalar_rgb")
    parser.add_argument("--side", type=int, default=300)
    parser.add_argument("--instances", type=int, default=500)
    parser.add_argument("--runs", type=int, default=3)
    arguments = parser.parse_args()
    print(f"{'scene':12} {'program':44} {'wall, s':>8} {'CPU, s':>8} {'MB':>8} {'bytes/triangle':>15}")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        programs = commands(arguments, folder)
        for scene in write_scenes(folder, arguments.side, arguments.instances):
            rows = {program: [] for program in programs}
            for _ in range(arguments.runs):
                for program, command in programs.items():
                    rows[program].append(measure(command(scene)))
            for program, runs in rows.items():
                wall, cpu, memory = (statistics.median(column) for column in zip(*runs))
                print(f"{scene.stem:12} {program:44} {wall:8.2f} {cpu:8.2f} {memory * 1e-6:8.0f} "
                      f"{memory / (2 * arguments.side ** 2):15.0f}")


if __name__ == "__main__":
    main()
