"""Runs Sheaf, Mitsuba and pbrt on the scenes of the rows, and returns their images with variances and CPU times."""

import json
import resource
import subprocess
from pathlib import Path

import numpy as np

from comparison import Image
from exr import read_rgb

WORKER = Path(__file__).resolve().parent / "mitsuba_worker.py"
REPLICATES = 16  # independent sets of samples from which the variance is estimated
QUICK_SPP = 2
QUICK_SCALE = 0.25


class RenderError(RuntimeError):
    """A renderer failed; the message holds its output."""


def run(command, **options):
    """Runs a command and returns its output on both streams and its CPU seconds."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run([str(c) for c in command], check=False, text=True, stdin=subprocess.DEVNULL,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, **options)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode != 0:
        raise RenderError(f"{' '.join(str(c) for c in command)}: exit status {done.returncode}\n{done.stdout}")
    return done.stdout, after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


class Sheaf:
    """`quick` takes a few samples of a small image."""

    def __init__(self, program, scenes, folder, threads, quick=False):
        self.program, self.scenes, self.folder, self.threads, self.quick = program, scenes, folder, threads, quick
        self.images = {}

    def render(self, scene, spp, options=(), color="rgb", runs=1, has_variance=True, layer=""):
        """Renders a scene, or returns the image of an earlier call with the same arguments.

        With one run, the variance comes from the layers variance.R/G/B, with several from the spread of the runs.
        `layer` names the layer to read instead of R, G and B; it has no variance.
        """
        key = (scene, spp, tuple(options), color, runs, has_variance, layer)
        if key not in self.images:
            self.images[key] = self.render_runs(*key)
        return self.images[key]

    def render_runs(self, scene, spp, options, color, runs, has_variance, layer):
        if self.quick:
            spp, options = QUICK_SPP, (*options, "--scale", QUICK_SCALE)
        replicates = min(REPLICATES, spp) if has_variance and runs == 1 else 0
        output = self.folder / "sheaf.exr"
        renders, seconds = [], []
        for seed in range(1, runs + 1):
            command = [self.program, "render", self.scenes / scene, "-o", output, "--spp", spp, "--seed", seed,
                       "--threads", self.threads, "--color", color, "--quiet", *options]
            if replicates:
                command += ["--replicates", replicates]
            seconds.append(run(command)[1])
            renders.append(read_rgb(output, layer))
        mean = np.mean(renders, axis=0)
        if runs > 1:
            return Image(renders[0], mean, np.var(renders, axis=0, ddof=1) / runs, runs, runs, seconds[0])
        variance = read_rgb(output, "variance.") if replicates else None
        return Image(renders[0], mean, variance, replicates, 1, seconds[0])


class Mitsuba:
    """Raises RenderError if `python` cannot import Mitsuba."""

    def __init__(self, python, variant, scenes, folder, threads):
        self.python, self.variant, self.scenes, self.folder, self.threads = python, variant, scenes, folder, threads
        self.images = {}
        self.version = run([python, WORKER, "version"])[0].strip()

    def render(self, scene, spp, defines=(), color="rgb", wavelengths=False):
        """Renders REPLICATES independent runs with `spp` samples per pixel in total. `defines`: (name, value) pairs.

        `wavelengths` renders a dispersive scene at each wavelength in turn, with `spp` samples for each of them.
        """
        key = (scene, spp, tuple(defines), color, wavelengths)
        if key not in self.images:
            output = self.folder / "mitsuba.npz"
            variant = "scalar_spectral" if color == "spectral" and not wavelengths else self.variant
            runs = min(REPLICATES, spp)
            job = {"scene": str(self.scenes / scene), "defines": dict(defines), "spp": spp, "runs": runs, "seed": 1,
                   "variant": variant, "threads": self.threads, "wavelengths": wavelengths, "output": str(output)}
            path = self.folder / "job.json"
            path.write_text(json.dumps(job))
            run([self.python, WORKER, "render", path])
            with np.load(output) as result:
                mean, variance, seconds = result["mean"], result["variance"], float(result["seconds"])
            self.images[key] = Image(mean, mean, variance, runs, 1, seconds)
        return self.images[key]

    def encode(self, images, folder):
        """Writes {name: 8-bit array} as JPEG files."""
        path = folder / "images.npz"
        np.savez(path, **images)
        try:
            run([self.python, WORKER, "encode", path])
        finally:
            path.unlink()


class Pbrt:
    """pbrt-v4, from PATH or --pbrt."""

    def __init__(self, program, scenes, folder, threads):
        self.program, self.scenes, self.folder, self.threads = program, scenes, folder, threads
        self.images = {}

    def render(self, scene, spp):
        """Renders REPLICATES independent runs with `spp` samples per pixel in total."""
        if scene not in self.images:
            runs = min(REPLICATES, spp)
            output = self.folder / "pbrt.exr"
            threads = ["--nthreads", self.threads] if self.threads else []
            renders, seconds = [], 0
            for seed in range(1, runs + 1):
                command = [self.program, "--quiet", "--seed", seed, "--spp", spp // runs, *threads, "--outfile", output]
                seconds += run([*command, self.scenes / scene])[1]
                renders.append(read_rgb(output))
            mean = np.mean(renders, axis=0)
            self.images[scene] = Image(mean, mean, np.var(renders, axis=0, ddof=1) / runs, runs, 1, seconds)
        return self.images[scene]
