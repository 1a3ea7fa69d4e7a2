#!/usr/bin/env python3
"""Measures the time to equal error beside Mitsuba 3, pbrt-v4, Cycles and LuxCore, thread scaling and peak memory. Needs
Python with numpy and a build.

  bench/compare_renderers.py --mitsuba-python ENVIRONMENT/bin/python [--runs 5] [--markdown docs/performance.md]
  bench/compare_renderers.py --cycles-python ENVIRONMENT/bin/python --luxcore-python ENVIRONMENT/bin/python
  bench/compare_renderers.py --scenes room.xml -D width=400           any scenes that the renderers read
  bench/compare_renderers.py --scenes kitchen.pbrt --pbrt PROGRAM     scenes of pbrt-v4

Renders each scene with all renderers in turn, at equal samples per pixel and threads, --runs times. Prints medians of
times, mean squared errors and, for each other renderer, its error times time over Sheaf's. References are two renders
by Sheaf with --reference-spp each, kept in --references; delete them if meshes or textures of a scene change.
docs/performance.md explains the columns.

Mitsuba needs a Python with the package mitsuba. Its variant llvm_ad_rgb needs LLVM 16 or newer (Debian: libllvm19), or
DRJIT_LIBLLVM_PATH. Cycles and LuxCore need a Python with the package bpy or pyluxcore, and render the twin scenes,
whose files are written to --twins. Without other renderers, the script measures Sheaf alone.
Exit status: 0 measured, 1 Sheaf failed or rejected a scene or a Python lacks its renderer, 2 wrong usage. Other
renderers that fail at a scene are reported.
"""

import argparse
import dataclasses
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from make_twins import write_twins
from rendering import ROOT
from renderers import machine, page
from renderers.errors import Measurement, efficiency_ratio, measure_errors, render_reference, speed_ratio
from renderers.programs import (Cycles, LuxCore, Mitsuba, Pbrt, RenderError, Scene, Sheaf, TwinRenderer, pbrt_version,
                                versions)
from twins.scene import HEIGHT, WIDTH
from twins.scenes import SCENES as TWINS

SCENES = [
    Scene("cornell", ROOT / "scenes/cornell/cornell.xml", {"width": "320", "height": "240"}),
    Scene("cornell.pbrt", ROOT / "scenes/cornell/cornell.pbrt"),
    Scene("material_room", ROOT / "scenes/material_room/material_room.xml", {"width": "320", "height": "240"}),
    Scene("hall", ROOT / "scenes/hall/hall.xml", {"width": "320", "height": "180"}),
    Scene("gap", ROOT / "scenes/gap/gap.xml", {"width": "320", "height": "213"}),
    Scene("coloured_glass", ROOT / "scenes/validation/coloured_glass.xml"),
    # Mitsuba does not read NanoVDB, so both read the same voxels from a .vol file.
    Scene("cloud", ROOT / "scenes/validation/cloud.xml", {"grid": "generated/cloud.vol"}),
]
MAX_TWIN_DIFFERENCE = 0.03  # of means; larger ones show that a renderer renders another scene
CURVE_SCENES = ["cornell", "coloured_glass"]
SCALING_SCENE = "hall"
STAGES_SCENE = "material_room"


class Comparison:
    """Renders scenes with all programs. `notes` says what could not be measured, and why."""

    def __init__(self, arguments, scenes, folder):
        self.arguments, self.scenes, self.folder = arguments, scenes, folder
        self.sheaf = Sheaf(arguments.sheaf, folder, arguments.arguments.split())
        self.versions = {"Sheaf": subprocess.run([arguments.sheaf, "--version"], check=True, text=True,
                                                 stdout=subprocess.PIPE).stdout.split(maxsplit=1)[1].strip()}
        self.others = [Sheaf(arguments.sheaf, folder, [*self.sheaf.options, *options.split()], f"Sheaf {options}")
                       for options in arguments.also]
        self.notes = []
        for name, option, python, make in self.python_renderers():
            if python:
                programs = make(python)
                self.versions |= versions(python, programs[0].worker, folder) if programs else {}
                self.others += programs
            if not python or not programs:
                self.note(f"{name} is not measured: {option}")
        if arguments.pbrt:
            self.versions["pbrt-v4"] = pbrt_version(arguments.pbrt)
            self.others.append(Pbrt(arguments.pbrt, folder))
        else:
            self.note("pbrt-v4 is not measured: it is not in PATH, and --pbrt is not given")

    def python_renderers(self):
        """Yields the name of each renderer that is a Python package, why it may be missing, its Python, and a function
        that returns its variants."""
        arguments, folder = self.arguments, self.folder
        home = folder / "home"
        home.mkdir()
        yield ("Mitsuba", "--mitsuba-python names no Python that has it, or --variants is empty",
               arguments.mitsuba_python, lambda python: [Mitsuba(python, v, folder, home) for v in arguments.variants])
        yield "Cycles", "--cycles-python is not given", arguments.cycles_python, lambda p: [Cycles(p, folder)]
        yield "LuxCore", "--luxcore-python is not given", arguments.luxcore_python, lambda p: [LuxCore(p, folder)]

    def note(self, text):
        if text not in self.notes:
            self.notes.append(text)
            print(f"compare_renderers.py: {text}", file=sys.stderr, flush=True)

    def usable(self, scene):
        """The programs that render the scene, each with the time of a first process. It fills the caches of files and
        of compiled kernels. Only programs that compile take all samples."""
        programs = {}
        for program in [self.sheaf, *(p for p in self.others if p.reads(scene))]:
            spp = self.arguments.spp if getattr(program, "compiles", False) else 1
            try:
                programs[program] = program.render(scene, spp, 0, self.arguments.threads).process_seconds
            except RenderError as error:
                if program is self.sheaf:
                    raise
                self.note(f"{program.name} does not render {scene.name}: {error}".replace(f"{ROOT}/", ""))
        return programs

    @staticmethod
    def rounds(programs, scene, spp, threads, runs):
        """Returns {program: renders}, from rounds in which each program renders once."""
        renders = {program: [] for program in programs}
        for seed in range(1, runs + 1):
            for program in programs:
                renders[program].append(program.render(scene, spp, seed, threads))
        return renders

    def measure(self, scene):
        """Returns the measurements of a scene, Sheaf's first."""
        arguments = self.arguments
        reference = render_reference(self.sheaf, scene, arguments.reference_spp, arguments.threads,
                                     arguments.references)
        firsts = self.usable(scene)
        results = []
        for program, renders in self.rounds(firsts, scene, arguments.spp, arguments.threads, arguments.runs).items():
            try:
                errors = measure_errors(renders, reference, False if program is self.sheaf else None)
            except ValueError as error:
                self.note(f"{program.name}, {scene.name}: {error}")
                continue
            if isinstance(program, TwinRenderer) and errors.differs_by(MAX_TWIN_DIFFERENCE):
                self.note(f"{program.name} is not compared in {scene.name}: its mean is {errors.mean_ratio:.3f} of "
                          "Sheaf's")
                continue
            results.append(Measurement(program.name, renders, errors, firsts[program]))
        return results

    def curves(self, scene, measured):
        """Returns {program: [(spp, seconds of the fastest round, relative error)]}. `measured`: what measure()
        returned."""
        arguments = self.arguments
        reference = render_reference(self.sheaf, scene, arguments.reference_spp, arguments.threads,
                                     arguments.references)
        measured = {m.program: m for m in measured}
        programs = [p for p in [self.sheaf, *self.others] if p.name in measured]
        points = {p.name: [] for p in programs}
        for spp in arguments.curve_spp:
            renders = self.rounds(programs, scene, spp, arguments.threads, max(2, arguments.runs // 2))
            for program, of_program in renders.items():
                errors = measure_errors(of_program, reference, measured[program.name].errors.is_own)
                seconds = min(render.seconds for render in of_program)
                points[program.name].append((spp, seconds, float(np.mean(errors.relative))))
        return points

    def scaling(self, scene, measured):
        """Returns {program: {threads: renders}} for powers of two and all threads. Half the rounds must do."""
        counts = [2**i for i in range(16) if 2**i < self.arguments.threads] + [self.arguments.threads]
        names = [m.program for m in measured]
        programs = [self.sheaf, *(p for p in self.others if p.name in names and not isinstance(p, Sheaf))]
        results = {p.name: {count: [] for count in counts} for p in programs}
        for seed in range(1, max(2, self.arguments.runs // 2) + 1):
            for count in counts:
                for program in programs:
                    results[program.name][count].append(program.render(scene, self.arguments.spp, seed, count))
        return results


def print_measurements(scene, measurements):
    ours = measurements[0]
    for m in measurements:
        print(f"{scene.name:15} {m.program:27} {m.time():7.2f} {m.time('cpu_seconds'):7.2f} "
              f"{m.time('process_seconds'):7.2f} {m.mse:10.3e} {np.mean(m.errors.relative):9.3e} "
              f"{m.errors.mean_ratio:7.4f} {'own' if m.errors.is_own else 'Sheaf':>9} {m.peak_bytes / 1e6:6.0f}",
              flush=True)
    for m in measurements[1:]:
        print(f"{scene.name:15} {m.program:27} over Sheaf's: mse {efficiency_ratio(ours, m)}, "
              f"rel {efficiency_ratio(ours, m, 'relative')}, mse by CPU time "
              f"{efficiency_ratio(ours, m, which='cpu_seconds')}, speed {speed_ratio(ours, m)}", flush=True)


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    names = ", ".join([*(scene.name for scene in SCENES), *TWINS])
    parser.add_argument("--scenes", nargs="+", help=f"files, or names of the default scenes: {names} (the last "
                        f"{len(TWINS)} are twins, rendered by default if Cycles or LuxCore are measured)")
    parser.add_argument("-D", "--define", action="append", default=[], metavar="NAME=VALUE",
                        help="variable of the scene files, for Sheaf and Mitsuba; may be repeated")
    parser.add_argument("--spp", type=int, default=16)
    parser.add_argument("--runs", type=int, default=5, help="rounds, at least 2")
    parser.add_argument("--threads", type=int, default=os.cpu_count())
    parser.add_argument("--reference-spp", type=int, default=256, help="of each of the two references")
    parser.add_argument("--references", type=Path, default=ROOT / "out/references", help="folder that keeps references")
    parser.add_argument("--sheaf", default=str(ROOT / "build/release/sheaf"))
    parser.add_argument("--arguments", default="", help="further options of sheaf render")
    parser.add_argument("--also", nargs="*", default=["--sampler independent"], metavar="OPTIONS",
                        help="options of Sheaf that are measured like another renderer; may be empty")
    parser.add_argument("--mitsuba-python", help="Python with Mitsuba 3; default: this one, if it has it")
    parser.add_argument("--variants", nargs="*", default=["llvm_ad_rgb", "scalar_rgb"], help="of Mitsuba; may be empty")
    parser.add_argument("--cycles-python", help="Python with Cycles, the package bpy")
    parser.add_argument("--luxcore-python", help="Python with LuxCore, the package pyluxcore")
    parser.add_argument("--twins", type=Path, default=ROOT / "out/twins", help="folder for the files of twin scenes")
    parser.add_argument("--pbrt", default=shutil.which("pbrt"), help="program of pbrt-v4")
    parser.add_argument("--curve-scenes", nargs="*", default=CURVE_SCENES, help="for the plot of error over time")
    parser.add_argument("--curve-spp", nargs="+", type=int, default=[1, 4, 16, 64])
    parser.add_argument("--scaling-scene", default=SCALING_SCENE, help="scene for thread scaling")
    parser.add_argument("--stages-scene", default=STAGES_SCENE, help="scene for the cost of the stages")
    parser.add_argument("--markdown", type=Path, help="write the page to this file, and its plot beside it")
    arguments = parser.parse_args()
    if arguments.runs < 2 or arguments.threads < 1 or min(arguments.spp, *arguments.curve_spp) < 1:
        parser.error("--runs must be at least 2, and --threads, --spp and --curve-spp at least 1")
    if not arguments.mitsuba_python and subprocess.run([sys.executable, "-c", "import mitsuba"], check=False,
                                                       stderr=subprocess.DEVNULL).returncode == 0:
        arguments.mitsuba_python = sys.executable
    if not all("=" in define for define in arguments.define):
        parser.error("-D expects NAME=VALUE")
    arguments.define = dict(define.split("=", 1) for define in arguments.define)
    arguments.scenes = chosen_scenes(arguments)
    for scene in arguments.scenes:
        if not scene.file.is_file():
            parser.error(f"no file {scene.file}; the default scenes are {names}")
    return arguments


def chosen_scenes(arguments):
    """The scenes of the command line. Files other than the default scenes are named after themselves."""
    size = {"width": str(WIDTH), "height": str(HEIGHT)}
    twins = {name: Scene(name, arguments.twins.resolve() / name / "scene.xml", size, name) for name in TWINS}
    usual = {scene.name: scene for scene in SCENES}
    default = [*usual, *(twins if arguments.cycles_python or arguments.luxcore_python else [])]
    known = usual | twins
    scenes = []
    for name in arguments.scenes or default:
        file = Path(name).resolve()
        stem = file.name.split(".")[0]
        if stem == "scene" or any(scene.name == stem for scene in scenes):
            stem = f"{file.parent.name}-{stem}"
        scene = known.get(name) or Scene(stem, file)
        scenes.append(dataclasses.replace(scene, defines=scene.defines | arguments.define))
    write_twins([scene.twin for scene in scenes if scene.twin], arguments.twins)
    return scenes


def main():
    load = machine.load()
    arguments = parse_arguments()
    scenes = arguments.scenes
    if arguments.markdown:
        arguments.markdown.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        comparison = Comparison(arguments, scenes, Path(folder))
        print(f"{'scene':15} {'renderer':27} {'seconds':>7} {'cpu':>7} {'process':>7} {'mse':>10} {'relative':>9} "
              f"{'mean':>7} {'reference':>9} {'MB':>6}")
        results = {}
        for scene in scenes:
            results[scene.name] = comparison.measure(scene)
            print_measurements(scene, results[scene.name])
        if arguments.markdown:
            curves = {s.name: comparison.curves(s, results[s.name]) for s in scenes if s.name in arguments.curve_scenes}
            scaled = next((s for s in scenes if s.name == arguments.scaling_scene), scenes[0])
            staged = arguments.stages_scene if arguments.stages_scene in results else scenes[0].name
            scaling = comparison.scaling(scaled, results[scaled.name])
            facts = [*machine.describe(arguments, comparison.versions),
                     ("load", machine.describe_load(load, machine.load()))]
            page.write_page(arguments, comparison, facts, results,
                            [page.curves_section(arguments, curves), page.DIFFERENCES,
                             page.stages_section(staged, results[staged][0]),
                             page.scaling_section(scaled.name, scaling, arguments.threads)])
            print(f"wrote {arguments.markdown}")


if __name__ == "__main__":
    try:
        main()
    except RenderError as error:
        sys.exit(f"compare_renderers.py: {error}")
