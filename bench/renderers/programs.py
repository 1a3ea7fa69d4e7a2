"""Runs Sheaf and other renderers on the same scene, and returns their images with times and peak memory."""

import json
import os
import struct
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from rendering import ROOT

sys.path.insert(0, str(ROOT / "tools/validation"))
from exr import read_header, read_rgb  # noqa: E402

HERE = Path(__file__).resolve().parent


class RenderError(RuntimeError):
    """A renderer failed; the message holds the end of its output."""


@dataclass(frozen=True)
class Scene:
    """`defines`: values for the variables of an XML file. `twin`: name of the description in bench/twins, which also
    renderers with other formats render."""
    name: str
    file: Path
    defines: dict = field(default_factory=dict)
    twin: str | None = None


@dataclass(frozen=True)
class Render:
    """One process of a renderer, and its images: independent renders with equal samples per pixel.

    seconds: wall time of the last image, rendering alone. cpu_seconds: CPU time of all threads for the last image.
    process_seconds: wall time from the start of the process to the first image. report: Sheaf's statistics."""
    images: list
    seconds: float
    cpu_seconds: float
    process_seconds: float
    peak_bytes: int
    report: dict | None = None


def launch(command, folder, environment=None):
    """Runs a command and returns the report of launch.py and the output on both streams."""
    result = folder / "launch.json"
    done = subprocess.run([sys.executable, "-I", "-S", HERE / "launch.py", result, *[str(c) for c in command]],
                          check=False, text=True, env=environment, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT)
    if done.returncode != 0:
        lines = done.stdout.strip().splitlines() or [f"exit status {done.returncode}"]
        # An exception ends with its message, LLVM begins with it.
        message = next((line for line in lines if "ERROR" in line), lines[-1])
        raise RenderError(f"{Path(command[0]).name}: {message.strip()}")
    return json.loads(result.read_text(encoding="utf-8")), done.stdout


class Sheaf:
    def __init__(self, program, folder, options=(), name="Sheaf"):
        self.program, self.folder, self.options, self.name = program, folder, options, name

    def reads(self, _scene):
        return True

    def render(self, scene, spp, seed, threads):
        output, stats = self.folder / "sheaf.exr", self.folder / "sheaf.json"
        defines = [part for name, value in scene.defines.items() for part in ("-D", f"{name}={value}")]
        usage, _ = launch([self.program, "render", scene.file, "-o", output, "--spp", spp, "--seed", seed, "--threads",
                           threads, "--stats", stats, "--quiet", *defines, *self.options], self.folder)
        report = json.loads(stats.read_text(encoding="utf-8"))
        return Render([read_rgb(output)], report["render_seconds"], usage["cpu_seconds"], usage["seconds"],
                      usage["peak_bytes"], report)


def versions(python, worker, folder):
    """Returns {package: version} of the renderer of a worker."""
    try:
        return json.loads(launch([python, worker, "version"], folder)[1].strip().splitlines()[-1])
    except (RenderError, OSError) as error:
        raise RenderError(f"{python} cannot run {worker.name}: {error}") from None


class PythonRenderer:
    """A renderer that is a Python package. Its worker renders one image per seed; with more than one, the last gives
    the time of rendering, without what a first image compiles or builds."""

    def __init__(self, name, worker, python, folder, images=1, environment=None):
        self.name, self.worker, self.python, self.folder = name, worker, python, folder
        self.images, self.environment = images, environment
        self.ignored = {}

    def job(self, scene):
        """The scene's part of the job that the worker reads."""
        raise NotImplementedError

    def render(self, scene, spp, seed, threads):
        output, job = self.folder / "images.npz", self.folder / "job.json"
        seeds = [self.images * seed + i for i in range(self.images)]
        job.write_text(json.dumps(self.job(scene) | {"spp": spp, "seeds": seeds, "threads": threads,
                                                     "output": str(output)}))
        usage, _ = launch([self.python, self.worker, "render", job], self.folder, self.environment)
        with np.load(output) as result:
            images = [np.nan_to_num(image.astype(float), posinf=0, neginf=0) for image in result["images"]]
            if "ignored" in result and result["ignored"].size:
                self.ignored[scene.name] = [str(name) for name in result["ignored"]]
            return Render(images, float(result["seconds"][-1]), float(result["cpu_seconds"][-1]),
                          float(result["finished"][0]) - usage["start"], usage["peak_bytes"])


class Mitsuba(PythonRenderer):
    """A variant of Mitsuba. `home` is the folder of Dr.Jit's kernel cache. It renders no twin scenes, because the
    compiling variants take minutes for thousands of instances."""
    WORKER = HERE / "mitsuba_worker.py"

    def __init__(self, python, variant, folder, home):
        self.variant, self.compiles = variant, not variant.startswith("scalar")
        super().__init__(f"Mitsuba {variant}", self.WORKER, python, folder, 2 if self.compiles else 1,
                         os.environ | {"HOME": str(home)})

    def reads(self, scene):
        return scene.file.suffix == ".xml" and not scene.twin

    def job(self, scene):
        return {"scene": str(scene.file), "defines": scene.defines, "variant": self.variant}


class TwinRenderer(PythonRenderer):
    """A renderer of the twin scenes, from their descriptions and the meshes in the folder of the scene file."""

    def reads(self, scene):
        return scene.twin is not None

    def job(self, scene):
        return {"twin": scene.twin, "folder": str(scene.file.parent), "width": int(scene.defines["width"]),
                "height": int(scene.defines["height"])}


class Cycles(TwinRenderer):
    WORKER = HERE / "cycles_worker.py"

    def __init__(self, python, folder):
        super().__init__("Cycles", self.WORKER, python, folder, 2)


class LuxCore(TwinRenderer):
    WORKER = HERE / "luxcore_worker.py"

    def __init__(self, python, folder):
        super().__init__("LuxCore", self.WORKER, python, folder)


def pbrt_version(program):
    """The version that pbrt-v4 prints before a render."""
    printed = subprocess.run([program, "/dev/null"], text=True, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL).stdout
    line = next((line for line in printed.splitlines() if "version" in line), "")
    return line.removeprefix("pbrt version ") or "unknown"


class Pbrt:
    name = "pbrt-v4"

    def __init__(self, program, folder):
        self.program, self.folder = program, folder

    def reads(self, scene):
        return scene.file.name.endswith((".pbrt", ".pbrt.gz"))

    def render(self, scene, spp, seed, threads):
        output = self.folder / "pbrt.exr"
        usage, _ = launch([self.program, "--quiet", "--seed", seed, "--spp", spp, "--nthreads", threads, "--outfile",
                           output, scene.file], self.folder)
        header, _ = read_header(output.read_bytes())
        seconds = header.get("renderTimeSeconds", b"")
        if len(seconds) != 4:
            raise RenderError(f"{Path(self.program).name}: the image has no attribute renderTimeSeconds")
        return Render([read_rgb(output)], struct.unpack("<f", seconds)[0], usage["cpu_seconds"], usage["seconds"],
                      usage["peak_bytes"])
