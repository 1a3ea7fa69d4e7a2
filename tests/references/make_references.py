#!/usr/bin/env python3
"""Renders the references of the tests with Mitsuba 3, an independent renderer.

  pip install mitsuba
  tests/references/make_references.py [--spp N] [--variant NAME] [NAME ...]

Without names, all scenes of tests/references/scenes and the Cornell box are rendered, which takes some minutes. The
variant llvm_ad_rgb needs a shared library of LLVM (16 or later). If Mitsuba does not find it, set DRJIT_LIBLLVM_PATH.

Two files are written per scene, with the channels R, G and B:
  NAME.exr      32-bit float: the mean of all samples. The string attribute "samples" holds their number per pixel.
  NAME_var.exr  16-bit float: the variance of one sample of a pixel. Divided by a sample count, it is the variance
                of the mean of that many samples.

The variant scalar_spectral makes the references of spectral mode, NAME_spectral.exr and NAME_spectral_var.exr, for the
scenes in SPECTRAL. Their variance is estimated between images of few samples each. The same holds for sunsky and for
scenes with media (medium_NAME), which are made with scalar_rgb.

For filters w without negative lobes, the variance is the mean of the squares minus the square of the mean. For the
others, it is that of filter importance sampling: samples have a pdf proportional to |w|, and are weighted by the sign
of w and the factor int |w| / int w. The mean is Mitsuba's for every filter. Scenes with a wide filter set
sample_border, so that the whole filter applies to the border pixels.
"""

import argparse
import re
import sys
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).resolve().parent
SCENES = FOLDER / "scenes"
CORNELL = FOLDER.parent.parent / "scenes" / "cornell" / "cornell.xml"
CORNELL_BLOCK = 20  # pixels per side of one pixel of the Cornell reference
# Excluded: metals by name, whose data differ, and textured emitters, whose color differs between Mitsuba's spectral
# and RGB variants.
SPECTRAL = ["constant_environment", "glass_sphere", "medium_chromatic", "medium_dielectric", "medium_hg_forward",
            "plastics", "point_light", "spectra_emission", "spectra_reflectance", "textures"]
WAVEFRONT = 1 << 21  # samples that are processed at once


def mitsuba(variant="llvm_ad_rgb"):
    import mitsuba as mi

    if mi.variant() is None:
        mi.set_variant(variant)
        mi.set_log_level(mi.LogLevel.Error)
    return mi


def blackbody_rgb(temperature):
    """Linear Rec.709 of Planck's law in W / (m^2 sr nm), by the CIE 1931 observer divided by the integral of its y."""
    mi = mitsuba()
    wavelengths = np.linspace(360, 830, 4701)
    observer = np.array(mi.cie1931_xyz(mi.Float(wavelengths.astype(np.float32)))).astype(float)
    meters = wavelengths * 1e-9
    h, c, k = 6.62607015e-34, 299792458.0, 1.380649e-23
    radiance = 2e-9 * h * c * c / meters**5 / np.expm1(h * c / (meters * k * temperature))
    xyz = (observer * radiance).sum(axis=1) / observer[1].sum()
    return np.array(mi.xyz_to_srgb(mi.Color3f([float(v) for v in xyz]))).ravel()


def adapt(text):
    """Replaces black bodies by colors, because Mitsuba supports them in spectral variants only."""
    def color(match):
        rgb = ", ".join(f"{max(v, 0):.7g}" for v in blackbody_rgb(float(match[2])))
        return f'<rgb name="{match[1]}" value="{rgb}"/>'

    pattern = r'<spectrum name="(\w+)" type="blackbody">\s*<float name="temperature" value="([\d.]+)"/>\s*</spectrum>'
    return re.sub(pattern, color, text)


def positive_indices(obj):
    """Converts negative indices of an OBJ file to positive ones, which Mitsuba requires."""
    vertices = sum(line.startswith("v ") for line in obj.splitlines())
    return "\n".join(re.sub(r"-\d+", lambda m: str(vertices + 1 + int(m[0])), line) if line.startswith("f ") else line
                     for line in obj.splitlines())


def load(path, replacements=(), **defines):
    """The scene of an XML file, after adapt() and textual replacements."""
    text = path.read_text()
    if not mitsuba().variant().endswith("spectral"):
        text = adapt(text)
    for pattern, new in replacements:
        text, count = re.subn(pattern, new, text)
        assert count == 1, f"{path}: {pattern} found {count} times"
    copy = path.with_name(f".{path.stem}_adapted.xml")
    cube = SCENES / "meshes" / ".cube_positive.obj"
    try:
        if "cube_negative.obj" in text:
            cube.write_text(positive_indices((SCENES / "meshes" / "cube_negative.obj").read_text()))
            text = text.replace("cube_negative.obj", cube.name)
        copy.write_text(text)
        return mitsuba().load_file(str(copy), **defines)
    finally:
        copy.unlink(missing_ok=True)
        cube.unlink(missing_ok=True)


def with_squares(integrator):
    """An integrator whose extra channels are the squares of the nested one's R, G and B."""
    mi = mitsuba()

    class Squares(mi.SamplingIntegrator):
        def sample(self, scene, sampler, ray, medium=None, active=True):
            radiance, valid, _ = integrator.sample(scene, sampler, ray, medium, active)
            return radiance, valid, [radiance.x * radiance.x, radiance.y * radiance.y, radiance.z * radiance.z]

        def aov_names(self):
            return ["square.R", "square.G", "square.B"]

    return Squares(mi.Properties())


def moments(scene, spp):
    """Per-pixel means of the samples and of their squares, and the number of samples per pixel."""
    mi = mitsuba()
    integrator = with_squares(scene.integrator())
    size = scene.sensors()[0].film().crop_size()
    per_pass = max(1, min(spp, WAVEFRONT // (int(size[0]) * int(size[1]))))
    passes = -(-spp // per_pass)
    total = 0
    for seed in range(passes):
        total = total + np.array(mi.render(scene, integrator=integrator, spp=per_pass, seed=1000 + seed), dtype=float)
    total /= passes
    return total[..., :3], total[..., -3:], passes * per_pass


def filter_weight(kind, x):
    """The filters with negative lobes in one dimension, with the distance in pixels."""
    x = np.abs(x)
    if kind.startswith("lanczos"):
        lobes = 2 if kind.endswith("two") else 3
        return np.where(x < lobes, np.sinc(x) * np.sinc(x / lobes), 0)
    b, c = {"mitchell": (1 / 3, 1 / 3), "mitchell_sharp": (0.1, 0.45), "catmullrom": (0, 0.5)}[kind]
    near = (12 - 9 * b - 6 * c) * x**3 + (-18 + 12 * b + 6 * c) * x**2 + (6 - 2 * b)
    far = (-b - 6 * c) * x**3 + (6 * b + 30 * c) * x**2 + (-12 * b - 48 * c) * x + (8 * b + 24 * c)
    return np.where(x < 1, near, np.where(x < 2, far, 0)) / 6


def importance_sampling_square(kind, path, spp):
    """The mean square of a filter importance sample: squares on a grid of quarter pixels, weighted by |w|."""
    fine = 4
    scale = [(f'name="{side}" value="(\\d+)"', lambda m, side=side: f'name="{side}" value="{int(m[1]) * fine}"')
             for side in ("width", "height")]
    _, squares, _ = moments(load(path, scale + [(r'<rfilter.*?(/>|(?s:.*?)</rfilter>)', '<rfilter type="box"/>')]),
                            max(spp // fine**2, 64))
    margin = 3
    edges = np.linspace(-margin, margin, 6000 * margin + 1)
    centers = (edges[1:] + edges[:-1]) / 2
    weights = filter_weight(kind, centers)
    taps = np.bincount(np.floor((centers + margin) * fine).astype(int), np.abs(weights)) / np.abs(weights).sum()
    factor = np.abs(weights).sum() / weights.sum()
    for axis in (0, 1):
        pad = [(0, 0)] * 3
        pad[axis] = (margin * fine, margin * fine)
        padded = np.pad(squares, pad, mode="edge")
        count = squares.shape[axis] // fine
        start = np.arange(count) * fine + fine // 2
        squares = factor**2 * sum(tap * np.take(padded, start + i, axis=axis) for i, tap in enumerate(taps))
    return squares


def write(name, mean, variance, samples):
    mi = mitsuba()
    image = mi.Bitmap(mean.astype(np.float32), mi.Bitmap.PixelFormat.RGB)
    image.metadata()["samples"] = str(samples)
    image.write(str(FOLDER / f"{name}.exr"))
    mi.Bitmap(variance.astype(np.float16), mi.Bitmap.PixelFormat.RGB).write(str(FOLDER / f"{name}_var.exr"))
    print(f"{name}: {samples} samples, mean {mean.mean(axis=(0, 1))}, one sample's standard deviation "
          f"{np.sqrt(variance.mean(axis=(0, 1)))}", flush=True)


def make(name, spp):
    if name.startswith("medium_") or name == "sunsky":
        make_by_images(name, name, spp)
        return
    path = SCENES / f"{name}.xml"
    mean, square, samples = moments(load(path), spp)
    kind = name.removeprefix("filter_")
    if kind.startswith(("mitchell", "catmullrom", "lanczos")):
        square = importance_sampling_square(kind, path, spp)
    write(name, mean, np.maximum(square - mean**2, 0) * (samples / (samples - 1)), samples)


def make_by_images(name, output, spp):
    """Estimates the variance from 32 images, because spectral variants do not expose the colors of single samples."""
    images = 32
    scene = load(SCENES / f"{name}.xml")
    each = max(spp // images, 1)
    means = np.array([np.array(mitsuba().render(scene, spp=each, seed=2000 + i), dtype=float)[..., :3]
                      for i in range(images)])
    write(output, means.mean(axis=0), means.var(axis=0, ddof=1) * each, each * images)


def make_cornell(spp):
    """Averages over square blocks. The variance is the mean variance of a sample within its pixel."""
    def blocks(a):
        n = CORNELL_BLOCK
        return a.reshape(a.shape[0] // n, n, a.shape[1] // n, n, 3).mean(axis=(1, 3))

    mean, square, samples = moments(load(CORNELL), spp)
    variance = np.maximum(square - mean**2, 0) * (samples / (samples - 1))
    write("cornell", blocks(mean), blocks(variance), samples * CORNELL_BLOCK**2)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--spp", type=int, default=4096, help="samples per pixel (1/32 of it for the Cornell box)")
    parser.add_argument("--variant", default="llvm_ad_rgb",
                        help="scalar_rgb needs no LLVM. principled_thin was made with it, because the default "
                        "variant is up to 4 %% darker on its cube")
    parser.add_argument("names", nargs="*")
    arguments = parser.parse_args()
    mitsuba(arguments.variant)
    names = sorted(p.stem for p in SCENES.glob("*.xml")) + ["cornell"]
    unknown = set(arguments.names) - set(names)
    if unknown:
        sys.exit(f"no such scene: {', '.join(sorted(unknown))}")
    if arguments.variant.endswith("spectral"):
        for name in arguments.names or SPECTRAL:
            make_by_images(name, f"{name}_spectral", arguments.spp)
        return
    for name in arguments.names or names:
        if name == "cornell":
            make_cornell(max(arguments.spp // 32, 2))
        else:
            make(name, arguments.spp)


if __name__ == "__main__":
    main()
