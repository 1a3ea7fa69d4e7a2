#!/usr/bin/env python3
"""Runs every example scene, every script and program of tools/ and bench/, and every benchmark once, with the shortest
settings. Needs only Python and a build.

  tests/smoke/smoke.py generate|scenes|scripts|benchmarks --build build/release --programs NAME...

Scenes, scripts and benchmarks are found automatically. Scripts and programs need their shortest arguments in SCRIPTS
and PROGRAMS below, or a reason in EXEMPT. `generate` copies the tree to BUILD/smoke and runs the scripts that generate
files of scenes there. `scenes` and `scripts` run in copies of that copy. Benchmarks read their scenes from the original
tree, where missing meshes are generated.
Exit status: 0 all passed, 1 something failed; the output of each failure is printed.
"""

import argparse
import gzip
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent

# Scripts that generate files of scenes, in this order. The largest scenes are made small.
MAKERS = {
    "scenes/make/make_meshes.py": [],
    "scenes/make/make_material_scenes.py": [],
    "scenes/make/make_texture_scenes.py": [],
    "scenes/make/make_measured.py": [],
    "scenes/make/make_gltf_scene.py": [],
    "scenes/make/make_shape_scenes.py": [],
    "scenes/make/make_hall.py": [],
    "scenes/make/make_sky.py": [],
    "scenes/make/make_instances.py": ["500"],
    "scenes/make/make_media_scenes.py": ["--make-cloud", "{build}/make_cloud"],
    "scenes/make/make_caustic_scenes.py": [],
    "scenes/make/make_hourglass.py": ["--make-cloud", "{build}/make_cloud"],
    "scenes/make/make_forest.py": [],
    "scenes/make/make_tutorial_scenes.py": ["--make-cloud", "{build}/make_cloud"],
    "scenes/make/make_validation_scenes.py": ["--make-cloud", "{build}/make_cloud"],
}

# The shortest arguments of the other scripts. {build} is the build folder, {out} an empty one.
SCRIPTS = {
    "bench/compare_adaptive.py": ["--sheaf", "{build}/sheaf", "--target", "0.5", "--max-spp", "64", "--width", "32",
                                  "--seeds", "2", "--scenes", "scenes/cornell/cornell.xml"],
    "bench/compare_color.py": ["--sheaf", "{build}/sheaf", "--spp", "1", "--seeds", "2", "--crop", "100,100,132,132"],
    "bench/compare_denoise.py": ["--sheaf", "{build}/sheaf", "--spp", "4", "--width", "24", "--reference-spp", "4",
                                 "--scenes", "scenes/cornell/cornell.xml"],
    "bench/compare_guiding.py": ["--sheaf", "{build}/sheaf", "--spp", "4", "--width", "24", "--seeds", "2", "--scenes",
                                 "scenes/gap/gap.xml"],
    "bench/compare_lights.py": ["--sheaf", "{build}/sheaf", "--seconds", "0.01", "--width", "48", "--reference-spp", "4"],
    "bench/compare_big.py": ["--sheaf", "{build}/sheaf", "--side", "8", "--meshes", "2", "--instances", "4",
                             "--texture-side", "16", "--runs", "1"],
    "bench/compare_loading.py": ["--sheaf", "{build}/sheaf", "--side", "8", "--files", "4", "--runs", "1"],
    "bench/compare_media.py": ["--sheaf", "{build}/sheaf", "--width", "32", "--spp", "2", "--seeds", "1",
                               "--reference-spp", "2", "--steps", "0.1"],
    "bench/compare_motion.py": ["--sheaf", "{build}/sheaf", "--side", "8", "--curves", "8", "--spp", "1", "--runs", "1"],
    "bench/compare_photons.py": ["--sheaf", "{build}/sheaf", "--seconds", "0.01", "--width", "24", "--seeds", "1",
                                 "--reference-spp", "1", "--photons", "0.01"],
    "bench/compare_renderers.py": ["--sheaf", "{build}/sheaf", "--spp", "1", "--runs", "2", "--reference-spp", "2",
                                   "--references", "{out}/references", "--twins", "{out}/twins", "--scenes", "cornell",
                                   "optics", "-D", "width=32", "-D", "height=24", "--curve-spp", "1", "2", "--variants",
                                   "--markdown", "{out}/performance.md"],
    "bench/compare_roulette.py": ["--sheaf", "{build}/sheaf", "--spp", "1", "--scale", "0.03", "--seeds", "2", "--depths",
                                  "5", "2", "--scenes", "scenes/cornell/cornell.xml"],
    "bench/compare_samplers.py": ["--sheaf", "{build}/sheaf", "--spp", "1", "--scale", "0.05"],
    "bench/make_twins.py": ["--output", "{out}/twins", "--sheaf", "{build}/sheaf"],
    "tools/compare_builds.py": ["{build}/sheaf", "{build}/sheaf", "--spp", "1", "--only", "cornell"],
    "tools/color/fit_rgb_basis.py": ["--step", "20"],
    "tools/color/fit_wavelengths.py": ["--colors", "2", "--iterations", "1"],
    "scenes/make/make_cloudy_sky.py": ["{out}/sky.hdr", "--width", "64"],
    "tools/documentation/make_gallery.py": ["--sheaf", "{build}/sheaf", "--output", "{out}/gallery", "--draft", "wall", "denoising",
                              "layers"],
    "tools/documentation/make_notebook.py": ["--check"],
    "tools/documentation/make_manual.py": ["--sheaf", "{build}/sheaf", "--output", "{out}/manual"],
    "tools/documentation/plot_samplers.py": ["--sheaf", "{build}/sheaf", "--size", "8", "--reference-spp", "16", "--max-spp", "4",
                               "--output", "{out}/samplers.png"],
    "tools/documentation/plot_progressive.py": ["--sheaf", "{build}/sheaf", "--size", "8", "--reference-spp", "16", "--max-passes",
                                  "1", "--photons", "100", "--output", "{out}/progressive.png"],
    "tools/validation/validate.py": ["--sheaf", "{build}/sheaf", "--quick", "--output", "{out}"],
}

# Python modules outside of the standard library that scripts import, and their Debian packages.
PACKAGES = {"numpy": "python3-numpy", "scipy": "python3-scipy", "matplotlib": "python3-matplotlib",
            "PIL": "python3-pil"}

# The shortest arguments of programs without tests of their own, as a list of commands.
PROGRAMS = {
    "make_cloud": [[kind, "--kind", kind.split(".")[0], "--resolution", "8", "--temperature"]
                   for kind in ("cloud.nvdb", "smoke.nvdb", "ramp.nvdb", "constant.nvdb")] +
                  [["ramp.vol", "--kind", "ramp", "--resolution", "8"]],
    "trace_limit": [["scenes/cornell/cornell.xml", "--spp", "1", "--runs", "1", "--memory", "8", "--scaling",
                     "-D", "width=64", "-D", "height=48"],
                    ["scenes/cornell/cornell.xml", "--spp", "1", "--runs", "1", "--null", "-D", "width=64",
                     "-D", "height=48"],
                    ["scenes/cornell/cornell.xml", "--runs", "1", "--photons", "1000"]],
    "make_vdb_files": [["."]],
    "vdb_to_nanovdb": [["ball.vdb", "ball.nvdb"]],
}

# Scripts and programs that are not run here, and the reason.
EXEMPT = {
    "tools/packaging/arm64_root.sh": "functions, which other scripts use",
    "tools/packaging/build_levels.sh": "functions, which other scripts use",
    "tools/packaging/bundle_libraries.py": "make_release.sh runs it; tests/package/check_release.sh tests the release",
    "tools/packaging/sheaf_script.py": "part of wheels; tests/package/check_release.sh runs it",
    "tools/packaging/check_arm64.sh": "needs QEMU and a mirror, and builds",
    "tools/packaging/check_debian13.sh": "needs root, debootstrap and a mirror",
    "tools/packaging/debian_root.sh": "functions, which other scripts use",
    "tools/documentation/make_site.sh": "needs root; the test docs_links builds the site",
    "tools/packaging/make_release.sh": "builds twice; tests/package/check_release.sh tests the release",
    "tools/packaging/pack_wheel.py": "make_release.sh runs it; the test python packs a wheel",
    "tools/packaging/make_package.sh": "builds twice; tests/package/check_package.sh tests the package",
    "tools/install_packages.sh": "needs root; .ci/run runs it through tools/quickstart.sh and tools/test.sh",
    "tools/quickstart.sh": "builds; .ci/run runs it",
    "tools/farm/slurm.sh": "needs root and Slurm; the test slurm runs it",
    "tools/check_format.sh": "a test of its own, format",
    "tools/test.sh": "builds, and runs this test; .ci/run runs it",
    "sheaf": "smoke_scenes runs it",
    "sheaf_bench": "smoke_benchmarks runs it",
}


class Failures:
    def __init__(self):
        self.count = 0

    def add(self, what, why):
        self.count += 1
        print(f"FAILED {what}: {why}", flush=True)


def run(command, folder, **variables):
    """Returns whether a command succeeds, and its output on both streams. `variables`: of its environment."""
    environment = dict(os.environ, MPLBACKEND="Agg", PYTHONDONTWRITEBYTECODE="1", **variables)
    start = time.monotonic()
    done = subprocess.run([str(c) for c in command], cwd=folder, check=False, text=True, stdin=subprocess.DEVNULL,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, env=environment)
    print(f"{time.monotonic() - start:6.1f} s  {' '.join(Path(str(c)).name for c in command[:3])}", flush=True)
    return done.returncode == 0, f"exit status {done.returncode}\n{done.stdout}"


def copy_tree(folder):
    """Copies the files that scripts read and write, without generated ones."""
    generated = shutil.ignore_patterns("generated", "__pycache__")
    for part in ("scenes", "tools", "bench", "core", "docs/tutorials", "tests/references/scenes", "tests/smoke"):
        shutil.copytree(ROOT / part, folder / part, ignore=generated)
    shutil.copy(ROOT / "docs/gallery.md", folder / "docs")


def check_generated(arguments, _, failures):
    """Runs the scripts of MAKERS whose packages are installed, in a new copy of the tree."""
    folder = arguments.build / "smoke"
    shutil.rmtree(folder, ignore_errors=True)
    copy_tree(folder)
    check_origins(arguments, folder, failures)
    for script, options in MAKERS.items():
        missing = list(missing_packages(folder / script))
        if missing and not any("doesn't know" in m for m in missing):
            print(f"skipped  {script}: needs {', '.join(missing)}", flush=True)
            continue
        options = [option.format(build=arguments.build) for option in options]
        good, output = run([sys.executable, folder / script, *options], folder)
        if not good:
            failures.add(script, output)
    check_differences(folder, failures)


def skipped_makers(folder):
    """Scripts of MAKERS whose packages are missing."""
    return {script for script in MAKERS if any(missing_packages(folder / script))}


def check_origins(arguments, folder, failures):
    """Checks that scenes with missing generated files name the script that makes them, and that such scenes exist."""
    needy = [f for f in sorted((folder / "scenes").rglob("*.xml")) if "generated/" in f.read_text()]
    for scene in needy:
        good, output = run([arguments.build / "sheaf", "info", scene], folder)
        named = re.search(r"generated\.txt: run (scenes/make/\w+\.py) ", output)
        if good or not named or named[1] not in MAKERS or not (folder / named[1]).exists():
            failures.add(f"info {scene.relative_to(folder)}", f"should name the script that makes its files: {output}")
    if not needy:
        failures.add("scenes", "none needs a script")


def check_scenes(arguments, folder, failures):
    """Renders a few pixels in the middle of every scene with few photons, in both or alternating color modes. With
    --dirty-memory it does so twice, the second time in memory that malloc fills with 0x55 instead of the system's
    zeros, and compares the images."""
    skipped = skipped_makers(folder)
    sheaf, image, stats = arguments.build / "sheaf", folder / "image.exr", folder / "stats.json"
    scenes = sorted(f for kind in ("*.xml", "*.pbrt") for f in (folder / "scenes").rglob(kind)
                    if "generated" not in f.parts)
    parts = {name for scene in scenes for name in re.findall(r'<include filename="([^"]+)"', scene.read_text())}
    for i, scene in enumerate(scenes):
        name = str(scene.relative_to(folder))
        origin = scene.parent / "generated.txt"
        if origin.exists() and origin.read_text().split()[1] in skipped:
            continue
        good, output = run([sheaf, "info", scene], folder)
        size = re.search(r"(\d+) x (\d+) pixels", output)
        if not good or not size:
            failures.add(f"info {name}", output)
            continue
        x, y = int(size[1]) // 2, int(size[2]) // 2
        few = [f"-D{count}=1000" for count in ("photons", "caustic_photons", "volume_photons")
               if f'"${count}"' in scene.read_text()]
        for color in [("rgb", "spectral")[i % 2]] if arguments.one_color else ("rgb", "spectral"):
            command = [sheaf, "render", scene, "-o", image, "--spp", "1", "--color", color, "--no-timestamps", "--crop",
                       f"{x - 12},{y - 8},{x + 12},{y + 8}", "--stats", stats, *few]
            good, output = run(command, folder)
            notes = [line for line in output.splitlines()[1:] if not line.startswith("sheaf: rendered ")]
            if not good:
                failures.add(f"render {name} --color {color}", output)
            elif notes and scene.name not in parts:
                failures.add(f"render {name} --color {color}", "prints notes:\n" + "\n".join(notes))
            elif any(json.loads(stats.read_text())["dropped"].values()):
                failures.add(f"render {name} --color {color}", "samples were dropped:\n" + stats.read_text())
            elif arguments.dirty_memory:
                pixels = image.read_bytes()
                good, output = run(command, folder, MALLOC_PERTURB_="170")
                if not good or image.read_bytes() != pixels:
                    failures.add(f"render {name} --color {color}", "depends on what memory held before:\n" + output)
    check_layers(sheaf, image, folder, failures)


def check_layers(sheaf, image, folder, failures):
    """Renders one scene with all layers, and checks that `info` lists them."""
    for color in ("rgb", "spectral"):
        good, output = run([sheaf, "render", "scenes/cornell/cornell.xml", "-o", image, "--spp", "2", "--color", color,
                            "--scale", "0.05", "--aov", "all", "--light-groups", "--quiet"], folder)
        good_info, told = run([sheaf, "info", image], folder)
        if not good or not good_info or "albedo.R (half)" not in told or "CryptoObject02.a (float)" not in told:
            failures.add(f"render with all layers --color {color}", output + told)


def missing_packages(script):
    """Debian packages of the missing modules that a script imports."""
    texts = [script.read_text()]
    package = {"make_gallery.py": "gallery", "make_twins.py": "twins"}.get(script.name)
    if package:
        texts += [module.read_text() for module in (script.parent / package).glob("*.py")]
    modules = set(re.findall(r"^(?:import|from) (\w+)", "\n".join(texts), re.MULTILINE))
    for module in sorted(modules - set(sys.stdlib_module_names)):
        folders = (script.parent, ROOT / "scenes/make", ROOT / "tools/validation")
        if any((folder / f"{module}.py").exists() for folder in folders) or (script.parent / module).is_dir():
            continue
        if module not in PACKAGES:
            yield f"{module}, which PACKAGES in tests/smoke/smoke.py doesn't know"
        elif subprocess.run([sys.executable, "-c", f"import {module}"], check=False,
                            stderr=subprocess.DEVNULL).returncode != 0:
            yield PACKAGES[module]


def check_differences(folder, failures):
    """Checks that scripts regenerate the files of the repository. Images are excluded, because their compression
    depends on the version of zlib."""
    for file in sorted([*(folder / "scenes").rglob("*"), *(folder / "tests/references").rglob("*")]):
        kept = ROOT / file.relative_to(folder)
        if file.suffix in (".xml", ".obj", ".ply", ".hdr") and "generated" not in file.parts:
            if not kept.exists() or kept.read_bytes() != file.read_bytes():
                failures.add(str(file.relative_to(folder)), "differs from the output of the script that writes it")


def check_quotations(failures):
    """Checks that the documents quote scenes/tutorials literally. A block of XML below a line with the name of such a
    scene must be a part of it; one that begins with <scene must be all of it, except for the comment above."""
    count = 0
    for page in [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]:
        for above, block in re.findall(r"((?:[^\n]*\n){4})```xml\n(.*?)```", page.read_text(), re.DOTALL):
            named = re.findall(r"`(scenes/tutorials/\w+\.xml)`", above)
            if not named:
                continue
            quoted, scene = ([line.strip() for line in text.splitlines()] for text in (block, (ROOT / named[-1]).read_text()))
            text, count = "\n".join(scene), count + 1
            whole = text[text.index("<scene"):] if quoted[0].startswith("<scene") else ""
            if "\n".join(quoted) not in text or len(whole) > len("\n".join(quoted)):
                failures.add(str(page.relative_to(ROOT)), f"differs from {named[-1]}, which it quotes: {quoted[0]}")
    if count == 0:
        failures.add("docs", "no document quotes a scene of scenes/tutorials")


def check_scripts(arguments, folder, failures):
    """Runs every script of tools/, bench/ and scenes/make/, and every program built from them."""
    known = MAKERS.keys() | SCRIPTS.keys() | PROGRAMS.keys() | EXEMPT.keys()
    scripts = {str(f.relative_to(ROOT)) for part in ("tools", "bench", "scenes/make") for f in (ROOT / part).rglob("*")
               if f.suffix == ".sh" or f.suffix == ".py" and os.access(f, os.X_OK) and "examples" not in f.parts}
    for name in sorted((scripts | set(arguments.programs)) - known):
        failures.add(name, "is not tested: add its shortest arguments to SCRIPTS or PROGRAMS in tests/smoke/smoke.py")
    for name in sorted(n for n in known - scripts if n.endswith((".py", ".sh"))):
        failures.add(name, "is listed in tests/smoke/smoke.py, but there is no such script")
    for name in sorted(n for n in scripts if n.endswith(".sh")):
        good, output = run(["bash", "-n", ROOT / name], folder)
        if not good:
            failures.add(name, output)

    out = folder / "out"
    out.mkdir()
    for script, options in SCRIPTS.items():
        missing = list(missing_packages(folder / script))
        if missing:
            message = f"needs {', '.join(missing)}"
            if any("doesn't know" in m for m in missing):
                failures.add(script, message)
            else:
                print(f"skipped  {script}: {message}", flush=True)
            continue
        options = [option.format(build=arguments.build, out=out) for option in options]
        good, output = run([sys.executable, folder / script, *options], folder)
        if not good:
            failures.add(script, output)
    (folder / "ball.vdb").write_bytes(gzip.decompress((ROOT / "tests/smoke/ball.vdb.gz").read_bytes()))
    for program in sorted(PROGRAMS.keys() & set(arguments.programs)):
        for options in PROGRAMS[program]:
            good, output = run([arguments.build / program, *options], folder)
            if not good:
                failures.add(program, output)


def check_benchmarks(arguments, folder, failures):
    """Runs every benchmark of sheaf_bench for the shortest time. Not every stage has items in every scene."""
    good, output = True, ""
    if not (ROOT / "scenes/mesh_box/generated").exists():
        good, output = run([sys.executable, ROOT / "scenes/make/make_meshes.py", "large"], folder)
    if not good:
        return failures.add("scenes/make/make_meshes.py", output)
    report = folder / "report.json"
    good, output = run([arguments.build / "sheaf_bench", "--benchmark_min_time=0.0001", f"--benchmark_out={report}",
                        "--benchmark_out_format=json"], folder)
    if not good:
        return failures.add("sheaf_bench", output)
    benchmarks = json.loads(report.read_text())["benchmarks"]
    nothing_to_do = ("no items reach this stage", "the scene does not use this stage")
    idle = [b for b in benchmarks if b.get("error_message") in nothing_to_do]
    print(f"{len(benchmarks)} benchmarks, {len(idle)} of them without items: {', '.join(b['name'] for b in idle)}")
    if len(benchmarks) == len(idle):
        failures.add("sheaf_bench", "there are no benchmarks")
    for benchmark in benchmarks:
        if benchmark.get("error_occurred") and benchmark not in idle:
            failures.add(benchmark["name"], benchmark["error_message"])
    return None


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    kinds = {"generate": check_generated, "scenes": check_scenes, "scripts": check_scripts, "benchmarks": check_benchmarks}
    parser.add_argument("kind", choices=kinds)
    parser.add_argument("--build", type=lambda p: Path(p).resolve(), default=ROOT / "build/release")
    parser.add_argument("--generated", type=Path,
                        help="folder with the copy of the tree that `generate` made (default: BUILD/smoke)")
    parser.add_argument("--one-color", action="store_true",
                        help="alternate between RGB and spectral mode instead of using both")
    parser.add_argument("--dirty-memory", action="store_true",
                        help="check that images don't depend on uninitialized memory; needs the malloc of glibc")
    parser.add_argument("--programs", nargs="*", default=[], help="programs of the build except tests")
    arguments = parser.parse_args()
    failures = Failures()
    with tempfile.TemporaryDirectory() as folder:
        if arguments.kind in ("scenes", "scripts"):
            shutil.copytree(arguments.generated or arguments.build / "smoke", folder, dirs_exist_ok=True)
        kinds[arguments.kind](arguments, Path(folder), failures)
    sys.exit(1 if failures.count else 0)


if __name__ == "__main__":
    main()
