#!/usr/bin/env python3
"""Runs the commands in the documentation of an installed package, with smaller images and fewer samples: the generating
scripts of docs/gallery.md, every `sheaf` command of docs/gallery.md and README.md, and the commands of docs/tutorials
and docs/get-started that render an example. Needs Python with numpy, and
`sheaf` and `make_cloud` in PATH.

  tests/package/check_examples.py EXAMPLES DOCUMENTATION      e.g. /usr/share/sheaf /usr/share/doc/sheaf

EXAMPLES is copied to a temporary folder. Exit status: 0 done, 1 a command failed, or an example has no command.
"""

import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

SCENE = """<scene version="3.0.0">
  <default name="turns" value="1"/><default name="frame" value="1"/>
  <sensor type="perspective"><transform name="to_world"><lookat origin="0,0,5" target="0,0,0" up="0,1,0"/></transform>
    <film type="hdrfilm"><integer name="width" value="1280"/><integer name="height" value="720"/></film>
    <sampler type="independent"><integer name="sample_count" value="4"/></sampler></sensor>
  <shape type="sphere"><transform name="to_world"><scale value="$turns"/><translate x="$(0.01 * frame)"/></transform></shape>
  <emitter type="constant"/></scene>
"""
MODEL = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"

# Commands that are skipped, and the reason.
LEFT_OUT = {"farm": "submits jobs to a Slurm cluster", "--serve": "shows a page until the render ends",
            "--tev": "needs the viewer tev", "--samples": "its range fits the full number of samples"}


def commands_of(text):
    """The lines of fenced blocks without a language, without comments."""
    lines = []
    for language, block in re.findall(r"^```(\w*)\n(.*?)^```", text, re.MULTILINE | re.DOTALL):
        lines += [line.split(" #")[0].strip() for line in block.splitlines() if not language]
    return [line for line in lines if line]


def shortened(words):
    """The command with few samples and, for examples, a small image."""
    if words[:2] != ["sheaf", "render"]:
        return words
    short = []
    for word, before in zip(words, ["", *words]):
        if before in ("--spp", "--noise-target", "--time-limit", "--size") or word in ("--noise-target", "--time-limit"):
            continue
        if word not in ("--spp", "--size"):
            short.append(word)
    short += ["--spp", "16" if "--denoise" in words or "--guiding" in words else "4", "--quiet"]
    if words[2].startswith("scenes/"):
        short += ["--size", "64x48"]
    return short


def run(words, folder):
    done = subprocess.run(words, cwd=folder, check=False, text=True, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT)
    if done.returncode != 0:
        print(f"examples: FAILED: {shlex.join(words)}: exit status {done.returncode}\n{done.stdout}", flush=True)
    return done.returncode == 0


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    examples, documentation = Path(sys.argv[1]), Path(sys.argv[2])
    gallery = commands_of((documentation / "docs/gallery.md").read_text())
    readme = commands_of((documentation / "README.md").read_text())
    pages = sorted([*documentation.glob("docs/tutorials/*.md"), *documentation.glob("docs/get-started/*.md")])
    tutorials = [line for page in pages for line in commands_of(page.read_text())
                 if line.startswith("sheaf render scenes/")]
    failed = 0
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary) / "examples"
        shutil.copytree(examples, folder, ignore=shutil.ignore_patterns("generated", "__pycache__"))
        (folder / "scene.xml").write_text(SCENE)
        (folder / "model.obj").write_text(MODEL)
        # Inputs of the commands of README.md that denoise and compare.
        for name in ("noisy.exr", "a.exr", "b.exr"):
            failed += not run(["sheaf", "render", "scene.xml", "--spp", "4", "--scale", "0.05", "--replicates", "4",
                               "--quiet", "-o", name], folder)
        for command in gallery + [line for line in readme if line.startswith("sheaf ")] + tutorials:
            words = shlex.split(command)
            if words[0] == "cp" or any(word in LEFT_OUT for word in words):
                continue
            if words[0].startswith("scenes/make/"):
                words = [sys.executable, *words]
                if words[1] == "scenes/make/make_instances.py":
                    words.append("500")
            elif words[0] != "sheaf":
                print(f"examples: FAILED: unknown command: {command}")
                failed += 1
                continue
            failed += not run(shortened(words), folder)
        for scene in sorted([*folder.glob("scenes/**/*.xml"), *folder.glob("scenes/**/*.pbrt")]):
            name = str(scene.relative_to(folder))
            if "generated" not in scene.parts and not any(name in command.split() for command in gallery + tutorials):
                print(f"examples: FAILED: no page has a command for {name}")
                failed += 1
    if failed:
        sys.exit(1)
    print("examples: all passed")


if __name__ == "__main__":
    main()
