"""Renders with Mitsuba 3 and encodes JPEG files; run by renderers.py with the Python that has Mitsuba.

  mitsuba_worker.py render JOB.json      writes the mean, the variance of the mean and one run to the job's .npz
  mitsuba_worker.py encode IMAGES.npz    writes each 8-bit array to the .jpg file of its name in the same folder
  mitsuba_worker.py version              prints Mitsuba's version
"""

import json
import re
import sys
import time
from pathlib import Path

import drjit
import mitsuba as mi
import numpy as np

JPEG_QUALITY = 88
CIE_Y_INTEGRAL = 106.856895  # of the CIE 1931 observer, in nm
BIN = 10  # nm


def render_runs(scene, job):
    """Returns the independent runs of a job as an array of R, G and B."""
    each = max(job["spp"] // job["runs"], 1)
    return np.array([np.array(mi.render(scene, spp=each, seed=job["seed"] + i), dtype=float)[..., :3]
                     for i in range(job["runs"])])


def with_index(text, wavelength):
    """Replaces Cauchy's formula A + B / w^2 by the index at a wavelength in nm. Mitsuba has no dispersion."""
    def index(match):
        a, b = (float(v) for v in match[2].split(","))
        return f'<float name="{match[1]}_ior" value="{a + b / (wavelength * 1e-3) ** 2:.7f}"/>'

    return re.sub(r'<string name="(int|ext)_cauchy" value="([^"]*)"/>', index, text)


def render_wavelengths(job):
    """Renders once per bin of wavelengths, and integrates over the CIE 1931 observer to linear Rec. 709.

    The scene must be gray under illuminant E in all but its indices of refraction.
    """
    path = Path(job["scene"])
    text = re.sub(r"<spectrum (name=\"\w+\") value", r"<float \1 value", path.read_text())
    total = 0
    for wavelength in np.arange(360 + BIN / 2, 830, BIN):
        scene = mi.load_string(with_index(text, wavelength))
        observer = np.array([float(v) for v in mi.cie1931_xyz(float(wavelength))]) * BIN / CIE_Y_INTEGRAL
        color = np.array(mi.xyz_to_srgb(mi.Color3f([float(v) for v in observer]))).ravel()
        runs = render_runs(scene, job | {"seed": job["seed"] + 1000 * int(wavelength)})
        total = total + runs.mean(axis=-1, keepdims=True) * color
    return total


def render(job):
    mi.set_variant(job["variant"])
    mi.set_log_level(mi.LogLevel.Error)
    if job["threads"]:
        drjit.set_thread_count(job["threads"])
    start = time.process_time()
    if job["wavelengths"]:
        runs = render_wavelengths(job)
    else:
        scene = mi.load_file(job["scene"], **job["defines"])
        start = time.process_time()
        runs = render_runs(scene, job)
    np.savez(job["output"], mean=runs.mean(axis=0), variance=runs.var(axis=0, ddof=1) / len(runs),
             seconds=time.process_time() - start)


def encode(path):
    mi.set_variant("scalar_rgb")
    with np.load(path) as images:
        for name, image in images.items():
            mi.Bitmap(np.ascontiguousarray(image)).write(str(path.parent / f"{name}.jpg"), quality=JPEG_QUALITY)


def main():
    command, *files = sys.argv[1:]
    if command == "version":
        print(mi.__version__)
    elif command == "render":
        render(json.loads(Path(files[0]).read_text()))
    elif command == "encode":
        encode(Path(files[0]))
    else:
        sys.exit(__doc__)


if __name__ == "__main__":
    main()
