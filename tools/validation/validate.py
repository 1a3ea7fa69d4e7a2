#!/usr/bin/env python3
"""Validates Sheaf against Mitsuba 3, pbrt-v4, closed forms and its own path tracer, and writes docs/validation.md.

  tools/validation/validate.py --mitsuba-python ENVIRONMENT/bin/python       all rows
  tools/validation/validate.py --list                                        names of the rows
  tools/validation/validate.py --only spot mis [--update]                    some rows, to out/validation.md or into the page
  tools/validation/validate.py --quick                                       few samples and Sheaf alone, to out/validation.md

Needs python3-numpy, a build, the files of scenes/make/make_validation_scenes.py and, except with --quick, a Python with
Mitsuba 3 (pip install mitsuba). Without Mitsuba its comparisons are not run. pbrt is used if it is in PATH.
Exit status: 0 all comparisons passed, 1 one failed or a renderer did, 2 wrong usage.
"""

import argparse
import os
import shutil
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import closed_forms
import page
from comparison import BLOCK, Image, Measures, compare
from renderers import QUICK_SCALE, REPLICATES, Mitsuba, Pbrt, RenderError, Sheaf, run
from rows import LONG, ROWS

ROOT = Path(__file__).resolve().parents[2]
SCENES = ROOT / "scenes" / "validation"
SIGNIFICANCE = 0.01  # probability that a correct renderer fails in any line
LONG_SPP = 1024


@dataclass
class Result:
    """A line of the page: Sheaf's image of a case, or a band of it, against one reference. `image` and
    `reference_picture` are names of files."""
    label: str
    reference: str
    image: str
    reference_picture: str
    measures: Measures | None
    seconds: float | None
    reference_seconds: float | None
    is_tested: bool
    case: object
    verdict: str = "not run"


class Validation:
    """Renders cases and collects their results and images."""

    def __init__(self, arguments, folder):
        self.arguments = arguments
        self.sheaf = Sheaf(arguments.sheaf, SCENES, folder, arguments.threads, arguments.quick)
        self.mitsuba = self.pbrt = None
        if not arguments.quick:
            if arguments.mitsuba_python:
                self.mitsuba = Mitsuba(arguments.mitsuba_python, arguments.variant, SCENES, folder, arguments.threads)
            if arguments.pbrt:
                self.pbrt = Pbrt(arguments.pbrt, SCENES, folder, arguments.threads)
        self.images = {}

    def reference(self, case, kind):
        """Returns the image of a reference, or None if there is no such renderer."""
        if kind == "closed form":
            scale = QUICK_SCALE if self.arguments.quick else 1
            pixels = closed_forms.render(case.closed_form, SCENES / case.scene, scale)
            return Image(pixels, pixels, np.zeros_like(pixels))
        if kind == LONG:
            return self.sheaf.render(case.long_scene or case.scene, LONG_SPP, case.long_options)
        if kind == "Mitsuba" and self.mitsuba:
            return self.mitsuba.render(case.mitsuba_scene or case.scene, case.mitsuba_spp or case.spp,
                                       (*case.defines, *case.mitsuba_defines), case.color, case.wavelengths)
        if kind == "pbrt" and self.pbrt:
            return self.pbrt.render(case.scene, case.spp)
        return None

    def run_row(self, row):
        """Returns the results of a row. A renderer that fails is a result, too."""
        results = []
        for case in row.cases:
            try:
                results += self.run_case(row, case)
            except RenderError as error:
                print(f"validate.py: {error}", file=sys.stderr)
                results.append(Result(case.label, "", "", "", None, None, None, False, case, "fails"))
        return results

    def run_case(self, row, case):
        image = self.sheaf.render(case.scene, case.spp, case.sheaf_options, case.color, case.runs, case.is_unbiased,
                                  case.layer)
        results = []
        for kind in case.references:
            if kind != "pbrt" or self.pbrt:
                results += self.results(row, case, kind, image, self.reference(case, kind))
        return results

    @staticmethod
    def reference_name(name, case, kind):
        """Name of the image of a reference. Cases share the one of LONG."""
        if kind == LONG:
            return f"{Path(case.long_scene or case.scene).stem.replace('_', '-')}-reference"
        return f"{name}-{kind.lower().replace(' ', '-')}"

    def results(self, row, case, kind, image, reference):
        """One result, or one per band."""
        bands, height = row.bands or (case.label,), len(image.pixels)
        results = []
        for i, label in enumerate(bands):
            begin, end = height * i // len(bands), height * (i + 1) // len(bands)
            name = f"{case.name}-{label.split()[0].replace('_', '-')}" if row.bands else case.name
            part, other = image.rows(begin, end), reference and reference.rows(begin, end)
            self.images[f"{name}-sheaf"] = page.tone_map(part.pixels, case.exposure)
            other_name = ""
            if other:
                other_name = self.reference_name(name, case, kind)
                self.images[other_name] = page.tone_map(other.pixels, case.exposure)
            results.append(Result(label, kind, f"{name}-sheaf", other_name,
                                  compare(part, other, case.tolerance, case.block) if other else None,
                                  part.seconds if i == 0 else None, other and i == 0 and other.seconds or None,
                                  case.is_unbiased, case))
        return results


def judge(results, level, quick):
    """Sets the verdicts: tests at a significance level, or the limits of the case."""
    for result in results:
        m, case = result.measures, result.case
        if m is None or quick:
            continue
        if case.is_unbiased:
            good = m.p is not None and m.p >= level
        else:
            good = abs(m.mean_ratio - 1) <= case.max_ratio_error and m.relative_mse <= case.max_error
        result.verdict = "passes" if good else "fails"


def facts(arguments, validation, tests):
    """What the introduction of the page says about this run."""
    version = run([arguments.sheaf, "--version"])[0].split()[1]
    others = [f"Mitsuba {validation.mitsuba.version}"] if validation.mitsuba else []
    others += ["pbrt-v4"] if validation.pbrt else []
    threads = f"{arguments.threads} threads each" if arguments.threads != 1 else "1 thread each"
    return {"sheaf": version, "others": " and ".join(others) or "no other renderer", "variant": arguments.variant,
            "threads": threads, "block": BLOCK, "replicates": REPLICATES, "tests": tests,
            "level": SIGNIFICANCE / tests, "significance": SIGNIFICANCE}


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    names = [row.name for row in ROWS]
    parser.add_argument("--list", action="store_true", help="list the rows and exit")
    parser.add_argument("--only", nargs="+", choices=names, metavar="NAME", help="rows to run")
    parser.add_argument("--update", action="store_true", help="replace the rows of --only in docs/validation.md")
    parser.add_argument("--quick", action="store_true", help="few samples, small images and Sheaf alone; tests nothing")
    parser.add_argument("--sheaf", default=str(ROOT / "build/release/sheaf"))
    parser.add_argument("--mitsuba-python", help="Python with Mitsuba 3; default: this one, if it has it")
    parser.add_argument("--variant", default="scalar_rgb", help="Mitsuba's variant for RGB")
    parser.add_argument("--pbrt", default=shutil.which("pbrt"), help="program of pbrt-v4")
    parser.add_argument("--threads", type=int, default=os.cpu_count())
    parser.add_argument("--output", type=Path, help="folder of validation.md; default: docs, or out for partial runs")
    arguments = parser.parse_args()
    arguments.rows = [row for row in ROWS if row.name in (arguments.only or names)]
    is_partial = (arguments.only and not arguments.update) or arguments.quick
    arguments.output = arguments.output or ROOT / ("out" if is_partial else "docs")
    if not arguments.mitsuba_python:
        try:
            run([sys.executable, "-c", "import mitsuba"])
            arguments.mitsuba_python = sys.executable
        except RenderError:
            pass
    return arguments


def main():
    arguments = parse_arguments()
    if arguments.list:
        print("\n".join(f"{row.name:14} {row.title}" for row in arguments.rows))
        return 0
    results = {}
    with tempfile.TemporaryDirectory() as folder:
        validation = Validation(arguments, Path(folder))
        # Count lines first, because they share the significance level.
        tests = sum(len(case.references) * max(len(row.bands), 1) for row in ROWS for case in row.cases)
        for row in arguments.rows:
            results[row.name] = validation.run_row(row)
            judge(results[row.name], SIGNIFICANCE / tests, arguments.quick)
            for result in results[row.name]:
                print(f"{row.name:14}", "  ".join(f"{cell:>12}" for cell in page.result_cells(result)), flush=True)
        extension = page.write_images(validation.images, arguments.output / "validation", validation.mitsuba)
        if arguments.update:
            page.update_page(arguments.output / "validation.md", arguments.rows, results, extension)
        else:
            page.write_page(arguments.output / "validation.md", arguments.rows, results, extension,
                            facts(arguments, validation, tests))
    failed = any(result.verdict == "fails" for of_row in results.values() for result in of_row)
    print(f"wrote {arguments.output / 'validation.md'}")
    return 1 if failed else 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except RenderError as error:
        sys.exit(f"validate.py: {error}")
