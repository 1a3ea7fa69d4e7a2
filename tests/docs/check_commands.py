#!/usr/bin/env python3
"""Runs every command line in the documentation: fenced blocks without a language, or of a shell.

  tests/docs/check_commands.py --sheaf build/release/sheaf [PAGE...]

`sheaf` commands run with small images and few samples. The lines of a block run one after the other in a folder of
their own. It contains the example scenes, general files such as scene.xml, model.obj and image.exr, and the scenes that
the page itself shows under a name. Example scenes that need generated files are replaced by scene.xml, because
tests/smoke/smoke.py renders them. It also runs all scripts, so that only their names and options are checked here.
CMake's presets must exist. Other commands fail unless EXEMPT lists them. Blocks that are no commands need a language,
such as `text`.
Exit status: 0 all passed, 1 something failed; each failure names the file and line of the command.
"""

import argparse
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import assets
from documents import ROOT, Failures, blocks, pages

SHELLS = ("", "sh", "bash", "shell", "console")

# Commands that are not run here, by their first words, and the reason.
EXEMPT = {
    "apt-get": "needs root", "apt": "needs root", "sudo": "needs root", "podman": "needs podman and builds",
    "docker": "needs docker and builds", "git": "needs a network", "pip": "needs a network", "squeue": "needs Slurm",
    "sbatch": "needs Slurm", "tev": "needs a display", "cp -r /usr/share/sheaf": "needs the installed package",
    "python3 -m venv": "is followed by pip, which needs a network", "xdg-open": "needs a display",
    "tar -xf": "needs the archive of a release", "bin/sheaf": "needs the archive of a release",
    "env/bin/pip": "needs a network", "env/bin/sheaf": "needs a wheel", "env/bin/python": "needs a wheel",
}
# Commands of the shell.
BUILTINS = ("cd", "export", "mkdir", "source")
# Options whose values are replaced by those of the shortest render.
REPLACED = {"--noise-target": "50%", "--time-limit": "1", "--serve": "127.0.0.1:0", "--tev": "127.0.0.1:14158",
            "--threads": "1"}
MAX_SPP = 16
# Parameters of example scenes that are numbers of photons.
PHOTONS = re.compile(r"\b(?:caustic_|volume_)?photons\b")
FEW_PHOTONS = 1000
SIZE = "16x12"
# Commands that may fail with these messages.
MAY_FAIL = {"--denoise oidn": "Open Image Denoise", "--method oidn": "Open Image Denoise"}

SCENE = """<scene version="3.0.0">
{defaults}
<integrator type="path"><integer name="max_depth" value="4"/></integrator>
<sensor type="perspective">
  <transform name="to_world"><lookat origin="0, 0, 5" target="0, 0, 0" up="0, 1, 0"/></transform>
  <film type="hdrfilm"><integer name="width" value="1280"/><integer name="height" value="720"/></film>
</sensor>
<shape type="sphere"><bsdf type="diffuse" id="{uses}"/></shape><emitter type="constant"/>
</scene>
"""


def scene_with(names):
    """A scene that knows these parameters."""
    defaults = "".join(f'<default name="{name}" value="1"/>' for name in names)
    return SCENE.format(defaults=defaults, uses="".join("$" + name for name in names))


def lines_of(block):
    """The commands of a block with their line numbers. A backslash continues a line; `$ ` is a prompt."""
    number, pending = block.line, ""
    for offset, line in enumerate(block.text.splitlines()):
        if not pending:
            number = block.line + offset
        pending += re.sub(r"^\$ ", "", line.strip())
        if pending.endswith("\\"):
            pending = pending[:-1] + " "
            continue
        words = shlex.split(pending, comments=True)
        pending = ""
        command = []
        for word in [*words, "&&"]:
            if word in ("&&", "&", ";"):
                if command:
                    yield number, command
                command = []
            else:
                command.append(word)


def shortened(words):
    """The arguments of `sheaf` with short settings. `watch` has the options of `render`, but does not end by itself."""
    if words[0] == "watch":
        words = ["render", *words[1:]]
    result, before = [], ""
    cropped = "--crop" in words
    sampled = "--samples" in words
    for word in words:
        if before == "--spp" and not sampled:
            word = str(min(int(word), 1 if cropped else MAX_SPP))
        elif before in REPLACED:
            word = REPLACED[before]
        elif before in ("-D", "--define") and PHOTONS.match(word):
            word = f"{word.split('=')[0]}={FEW_PHOTONS}"
        if word != "--submit":
            result.append(word)
        before = word
    if words[0] != "render":
        return result
    result += ["--quiet"] if "--quiet" not in words else []
    if not cropped:
        result = [word for word, last in zip(result, ["", *result]) if "--size" not in (word, last)]
        result += ["--size", SIZE]
    if not {"--spp", "--noise-target", "--time-limit"} & set(words):
        result += ["--spp", "1" if cropped else str(MAX_SPP)]
    return result


def run(command, folder):
    """Returns the exit status of a command, and its output on both streams."""
    environment = dict(os.environ, PYTHONDONTWRITEBYTECODE="1", MPLBACKEND="Agg")
    try:
        done = subprocess.run([str(word) for word in command], cwd=folder, check=False, text=True, timeout=120,
                              stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              env=environment)
    except subprocess.TimeoutExpired:
        return 124, "takes longer than 120 s"
    return done.returncode, done.stdout


class Runner:
    """Runs the commands of one block."""

    def __init__(self, block, folder, general, build):
        self.block, self.folder, self.build = block, folder, build
        shutil.copytree(general, folder, symlinks=True)
        self.add_own_scenes()

    def add_own_scenes(self):
        """Writes the scenes of the page whose names the text above them ends with: "Save this as `room.xml`:"."""
        for block in blocks(self.block.page):
            name = re.findall(r"`([\w./-]+\.(?:xml|pbrt))`", "\n".join(block.before.strip().splitlines()[-3:]))
            if block.language not in ("xml", "pbrt") or not name or name[-1].startswith("scenes/"):
                continue
            (self.folder / name[-1]).write_text(block.text)
            for file in re.findall(r'"([\w./-]+\.[a-z]+)"', block.text):
                assets.write(self.folder, file, block.text, self.build)

    def run_sheaf(self, words):
        """Runs a command of `sheaf`."""
        words = shortened(words)
        words += self.few_photons(words)
        names = [word.split("=")[0].removeprefix("-D") for last, word in zip(["", *words], words)
                 if last in ("-D", "--define") or re.match(r"-D\w+=", word)]
        outputs = {word for last, word in zip(["", *words], words)
                   if last in ("-o", "--output", "--stats", "--checkpoint", "--folder")}
        for i, word in enumerate(words[1:], 1):
            if word.startswith("-") or word in outputs or not re.search(r"\.(xml|pbrt|obj|ply|stl|glb|serialized|hdr|exr)$", word):
                continue
            file = self.folder / word
            if word.endswith((".xml", ".pbrt")) and "scenes/" in word:
                if not file.exists():
                    return f"there is no {word}"
                if "generated/" in file.read_text():
                    words[i] = "scene.xml"
            elif word.endswith(".exr") and not file.exists():
                shutil.copy(self.folder / "image.exr", file)
            elif not file.exists() and not word.endswith(".xml"):
                assets.write(self.folder, word, "", self.build)
            if words[i].endswith(".xml") and "scenes/" not in words[i]:
                target = self.folder / words[i]
                if not target.exists() or words[i] == "scene.xml":
                    known = ["turns", *(["frame"] if "--frames" in words else []), *names]
                    target.write_text(scene_with(sorted(set(known))))
        status, output = run([self.build / "sheaf", *words], self.folder)
        for option, message in MAY_FAIL.items():
            if status != 0 and option in " ".join(words) and message in output:
                return ""
        return f"exit status {status} of sheaf {shlex.join(words)}\n{output}" if status != 0 else ""

    def few_photons(self, words):
        """Options that reduce the photons of an example scene."""
        scene = self.folder / words[1] if words[0] == "render" else None
        if scene is None or "scenes/" not in words[1] or not scene.exists() or scene.suffix != ".xml":
            return []
        counts = set(re.findall(rf'<default name="({PHOTONS.pattern})"', scene.read_text()))
        given = {word.split("=")[0] for word in words}
        return [part for count in sorted(counts - given) for part in ("-D", f"{count}={FEW_PHOTONS}")]

    def run_script(self, words):
        """Checks that a script exists and knows the options."""
        if not (ROOT / words[0]).exists():
            return f"there is no {words[0]}"
        if words[0].endswith(".sh"):
            return ""
        options = [word for word in words[1:] if word.startswith("--")]
        text = (ROOT / words[0]).read_text()
        for option in options:
            if f'"{option}"' not in text:
                return f"{words[0]} has no option {option}"
        return ""

    def run_program(self, words):
        """Checks that a program of the build exists and knows the options."""
        name = Path(words[0]).name
        build_file = (ROOT / "CMakeLists.txt").read_text()
        is_test = name.startswith("sheaf_tests_") and f"sheaf_tests({name.removeprefix('sheaf_tests_')} " in build_file
        if not is_test and not re.search(rf"sheaf_program\({name}\b", build_file):
            return f"CMakeLists.txt has no program {name}"
        if is_test or name == "sheaf_bench" or not (self.build / name).exists():
            return ""
        known = run([self.build / name, "--help"], self.folder)[1]
        for option in (word.split("=")[0] for word in words[1:] if word.startswith("--")):
            if not re.search(rf"{option}\b", known):
                return f"{name} has no option {option}"
        return ""

    def run_cmake(self, words):
        """Checks that the presets exist."""
        presets = json.loads((ROOT / "CMakePresets.json").read_text())
        names = {preset["name"] for preset in presets["configurePresets"]}
        for last, word in zip(words, words[1:]):
            if last == "--preset" and word not in names:
                return f"CMakePresets.json has no preset {word}"
        return ""

    def run(self, words):
        """Runs or checks a command. Returns the reason of the failure, or nothing."""
        program = Path(words[0]).name
        if any(words[:len(prefix.split())] == prefix.split() for prefix in EXEMPT) or program in BUILTINS:
            return ""
        if program == "sheaf":
            return self.run_sheaf(words[1:])
        if words[0].startswith("build/"):
            return self.run_program(words)
        if words[0] in ("python3", "python") and len(words) > 1:
            words = words[1:]
        if words[0].startswith(("tools/", "bench/", "tests/", "scenes/make/")):
            return self.run_script(words)
        if program in ("cmake", "ctest"):
            return self.run_cmake(words)
        return ("is neither run nor listed: add it to EXEMPT in tests/docs/check_commands.py, or give the block a "
                "language if it is no command")


def prepare(folder, build):
    """Makes the files of all blocks: a link to the example scenes, and general inputs."""
    (folder / "scenes").symlink_to(ROOT / "scenes")
    (folder / "scene.xml").write_text(scene_with(["turns"]))
    (folder / "model.obj").write_text(assets.obj())
    (folder / "model.ply").write_text(assets.ply())
    images = ["image.exr", "noisy.exr", "a.exr"]
    outputs = [argument for image in images for argument in ("-o", folder / image)]
    status, output = run([build / "sheaf", "render", folder / "scene.xml", "--size", SIZE, "--spp", "16", "--denoise",
                          "nlm", "--aov", "albedo,normal,depth", "--quiet", *outputs], folder)
    if status != 0:
        sys.exit(f"general files: {output}")
    shutil.copy(folder / "a.exr", folder / "b.exr")


def run_block(block, folder, general, build):
    """Runs the commands of a block. Returns failures: places and reasons."""
    runner, failures = Runner(block, folder, general, build), []
    page = block.page.relative_to(ROOT)
    try:
        for number, words in lines_of(block):
            reason = runner.run(words)
            if reason:
                failures.append((f"{page}:{number}", f"'{shlex.join(words)}' {reason}"))
            if reason.startswith("is neither run"):
                break
    except ValueError as error:
        failures.append((block.place, f"is no command: {error}"))
    shutil.rmtree(folder)
    return failures


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sheaf", type=lambda p: Path(p).resolve(), required=True, help="its folder has make_cloud")
    parser.add_argument("pages", nargs="*", type=lambda p: Path(p).resolve(), help="default: all documents")
    arguments = parser.parse_args()
    failures = Failures()
    found = [block for page in arguments.pages or pages() for block in blocks(page)
             if block.language in SHELLS and not block.skip]
    with tempfile.TemporaryDirectory() as temporary, ThreadPoolExecutor(os.cpu_count()) as pool:
        general = Path(temporary) / "general"
        general.mkdir()
        prepare(general, arguments.sheaf.parent)
        folders = [Path(temporary) / f"{block.page.stem}_{block.line}" for block in found]
        count = len(found)
        for each in pool.map(run_block, found, folders, [general] * count, [arguments.sheaf.parent] * count):
            for place, reason in each:
                failures.add(place, reason)
    print(f"{count} blocks of commands, {failures.count} failures")
    if not found:
        failures.add("docs", "no block found")
    sys.exit(1 if failures.count else 0)


if __name__ == "__main__":
    main()
