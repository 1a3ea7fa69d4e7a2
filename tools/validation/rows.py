"""The table of rows: what docs/validation.md compares, with which options, and against which references."""

from collections.abc import Callable
from dataclasses import dataclass

import closed_forms
from comparison import BLOCK

LONG = "Sheaf, 1024 spp"  # the path tracer with many samples


@dataclass(frozen=True)
class Case:
    """One image of Sheaf and its references.

    label: the line in the table of the row.
    scene: file in scenes/validation.
    options, defines: further options of `sheaf render`, and (name, value) pairs of -D for both renderers.
    references: any of "Mitsuba", "pbrt", "closed form" and LONG.
    mitsuba_scene, mitsuba_defines: what Mitsuba renders instead, and in addition to `defines`.
    mitsuba_spp: samples of Mitsuba if they differ from `spp`; `wavelengths`: per wavelength, as it has no dispersion.
    closed_form: radiance of rays, see closed_forms.py.
    long_scene, long_options: scene and options of the reference LONG, without defines.
    tolerance: relative difference that the test ignores. block: pixels per side of the blocks that it compares.
    max_ratio_error, max_error: limits of |ratio of means - 1| and of the relative MSE; instead of the test, for biased
    images.
    """
    name: str
    label: str
    scene: str
    options: tuple = ()
    defines: tuple = ()
    references: tuple = ("Mitsuba",)
    spp: int = 64
    color: str = "rgb"
    runs: int = 1
    layer: str = ""
    mitsuba_scene: str = ""
    mitsuba_defines: tuple = ()
    mitsuba_spp: int = 0
    wavelengths: bool = False
    closed_form: Callable | None = None
    long_scene: str = ""
    long_options: tuple = ()
    tolerance: float = 0.002
    block: int = BLOCK
    max_ratio_error: float | None = None
    max_error: float | None = None
    exposure: float = 1

    @property
    def is_unbiased(self):
        return self.max_error is None

    @property
    def sheaf_options(self):
        return (*self.options, *(word for name, value in self.defines for word in ("-D", f"{name}={value}")))


@dataclass(frozen=True)
class Row:
    """A section of the page: cases of one feature. `difference` says where renderers differ by design, and why.

    bands: labels of equal bands of the image, which are compared separately.
    """
    name: str
    title: str
    text: str
    difference: str
    cases: tuple[Case, ...]
    bands: tuple[str, ...] = ()


MITSUBA_GRID = (("grid", "generated/cloud.vol"),)


def cloud(name, label, options=(), **defines):
    """The cloud with these definitions. Mitsuba reads the twin of the grid."""
    return Case(name, label, "cloud.xml", options, tuple(defines.items()), spp=32, mitsuba_defines=MITSUBA_GRID)


def fog(name, label, albedo):
    """The homogeneous media with an albedo."""
    return Case(name, label, "homogeneous.xml", defines=(("albedo", albedo),))


def samples(sampler, spp):
    """Soft shadows with a sampler, whose variance comes from several renders."""
    return Case(f"sampling-{sampler}-{spp}", f"{sampler}, {spp} spp", "soft_shadows.xml", ("--sampler", sampler),
                references=(LONG,), spp=spp, runs=4)


def lights(name, label, *options, references=(LONG,)):
    """The lamps with options of `sheaf render`."""
    return Case(name, label, "many_lights.xml", options, references=references, block=32, exposure=0.6)


def photons(name, label, max_error, **defines):
    """The room by photon mapping, against a path traced reference."""
    return Case(name, label, "photons.xml", defines=tuple(defines.items()), references=(LONG,), spp=16,
                long_scene="caustics.xml", max_ratio_error=0.03, max_error=max_error, exposure=0.8)


LIGHT_ROWS = (
    Row("spot", "Spot lights",
        "Spot lights with soft and hard edges, by Mitsuba's falloff and by pbrt's.",
        "The falloff depends on the dialect. In Mitsuba's it is linear in the angle, in pbrt's and Nori's a smooth "
        "step in the cosine. Each file thus looks as in the renderer that it was written for.",
        (Case("spot-linear", "linear (Mitsuba)", "spot.xml", exposure=1.5),
         Case("spot-smooth", "smooth (pbrt)", "spot_smooth.pbrt", references=("closed form", "pbrt"),
              closed_form=closed_forms.spot_smooth))),
    Row("directional", "Directional lights", "Two directional lights: the sun and a dim, bluish one.", "",
        (Case("directional", "two lights", "directional.xml"),)),
    Row("environment", "Environment map", "A rotated map of latitude and longitude, and how four materials reflect it.",
        "",
        (Case("environment", "sky", "environment.xml", spp=128),)),
)

SURFACE_ROWS = (
    Row("textures", "Image textures",
        "An image of 8 x 8 texels on panels. Above `nearest`, below `bilinear`. From left to right: once; repeated "
        "3 x 2 times; clamped; mirrored and turned.", "",
        (Case("textures", "filters and wrap modes", "textures.xml"),)),
    Row("normal-maps", "Normal maps",
        "A map made for OpenGL (green points up); the same map made for DirectX (green points down); and a mesh whose "
        "texture coordinates are all equal, with a map (left) and without (right).",
        "Mitsuba has no `flip_green`: it renders the OpenGL map in the second line too.",
        (Case("normal-opengl", "OpenGL", "normal_map.xml"),
         Case("normal-directx", "DirectX", "normal_map_directx.xml", mitsuba_scene="normal_map.xml"),
         Case("normal-degenerate", "degenerate uv", "normal_map_degenerate.xml"))),
    Row("disney", "Disney BSDF",
        "`principled`, a strip for each parameter, from 0 (left) to 1 (right).", "",
        (Case("disney", "all strips", "principled.xml", spp=32),),
        ("metallic", "roughness (metal)", "specular", "spec_tint", "anisotropic (metal)", "sheen", "sheen_tint",
         "clearcoat", "clearcoat_gloss", "flatness", "spec_trans")),
    Row("instancing", "Instancing", "35 instances of a group of three shapes, turned, stretched and mirrored.", "",
        (Case("instancing", "35 instances", "instances.xml"),)),
)

SAMPLING_ROWS = (
    Row("sampling", "Stratified sampling",
        "Independent and stratified samples. The relative MSE is that of one image; the means of 4 images are tested.",
        "",
        tuple(samples(sampler, spp) for spp in (32, 512) for sampler in ("independent", "stratified"))),
    Row("ris", "Resampled importance sampling",
        "240 lamps, with one of them chosen uniformly, by the light tree, or by resampling 8 candidates. "
        "The test has blocks of 32 x 32 pixels, because few bright samples carry much of the light.",
        "Mitsuba chooses lights uniformly, which is the option of the first line.",
        (lights("ris-uniform", "uniform", "--light-sampler", "uniform", references=("Mitsuba", LONG)),
         lights("ris-tree", "light tree"),
         lights("ris-resampled", "8 uniform candidates", "--integrator", "path_ris", "--light-sampler", "uniform"))),
    Row("mis", "Multiple importance sampling",
        "Plates of increasing smoothness from front to back reflect lamps of increasing size. `path_mats` samples the "
        "BSDF, `path_ems` the lights, `path` both. The test has blocks of 64 x 64 pixels for the first two, "
        "because few bright samples carry most of their light.",
        "Mitsuba always combines both. All three estimators have its mean; their noise differs.",
        (Case("mis-mats", "BSDF sampling", "plates.xml", ("--integrator", "path_mats"), spp=128, block=64,
              exposure=0.25),
         Case("mis-ems", "light sampling", "plates.xml", ("--integrator", "path_ems"), spp=128, block=64,
              exposure=0.25),
         Case("mis-both", "both", "plates.xml", spp=128, exposure=0.25))),
)

MEDIA_ROWS = (
    Row("phase", "Phase functions",
        "Henyey and Greenstein's phase function in a ball of fog between a lamp behind it and one in front of it.", "",
        tuple(Case(f"phase-{name}", f"g = {g}", "phase.xml", defines=(("g", g),), exposure=1.5)
              for name, g in (("backward", "-0.8"), ("isotropic", "0"), ("forward", "0.8")))),
    Row("homogeneous", "Homogeneous media",
        "The same media with three albedos, inside of a rough glass ball with a solid core, in a box around a cube, "
        "and in a ball beside another one.", "",
        (fog("homogeneous-scattering", "scattering", "1, 1, 1"), fog("homogeneous-absorption", "absorption", "0, 0, 0"),
         fog("homogeneous-both", "both", "0.8, 0.9, 0.95"))),
    Row("beer", "Beer's law",
        "Absorbing media in smooth glass (slabs of three thicknesses and a ball) and behind null interfaces.", "",
        (Case("beer-glass", "colored glass", "coloured_glass.xml"),
         Case("beer-null", "null interface", "null_ball.xml", references=("Mitsuba", "closed form"), spp=256,
              closed_form=closed_forms.null_ball))),
    Row("emission", "Emissive media",
        "A ball that emits and absorbs lights a floor. The reference integrates the light over the ball numerically.",
        "Media of Mitsuba 3 do not emit.",
        (Case("emission", "emissive ball", "emission.xml", references=("closed form",), spp=256,
              closed_form=closed_forms.emission, exposure=0.5),)),
    Row("heterogeneous", "Heterogeneous media",
        "A cloud of 48^3 voxels with sun and sky, as a NanoVDB file. Mitsuba reads the same voxels from a .vol file.",
        "Mitsuba does not read NanoVDB. A .vol grid is constant outside of its voxels, a NanoVDB grid is 0. The cloud "
        "does not reach its outermost voxels, so that both are equal here.",
        (cloud("cloud-box", "in a box"), cloud("cloud-ball", "in a ball", shape="sphere"),
         cloud("cloud-scaled", "scaled", size="1.2, 0.6, 1"), cloud("cloud-rotated", "rotated", angle="60"),
         cloud("cloud-moved", "moved", offset="0.25, -0.25, -0.5"),
         cloud("cloud-coloured", "coloured", albedo="0.95, 0.6, 0.3"))),
    Row("tracking", "Tracking in media",
        "The estimators of free paths and transmittance, in the cloud above.",
        "Ray marching is biased by design: with a step of 0.02 m it transmits slightly too much light. Its error is "
        "limited instead of tested. Mitsuba has delta tracking for paths and ratio tracking for transmittance.",
        (cloud("tracking-null", "null scattering", ("--medium-estimator", "null_mis")),
         cloud("tracking-delta", "delta tracking", ("--medium-estimator", "delta")),
         cloud("tracking-ratio", "ratio tracking", ("--medium-estimator", "ratio")),
         Case("tracking-marching", "ray marching", "cloud.xml",
              ("--medium-estimator", "marching", "--step-size", "0.02"), spp=32, mitsuba_defines=MITSUBA_GRID,
              max_ratio_error=0.01, max_error=0.05))),
)

COLOR_ROWS = (
    Row("spectral", "Spectral rendering",
        "Reflectances, indices and lights given as spectra, and a ball of glass whose index depends on the wavelength.",
        "Mitsuba 3 has no dispersion. For the second line it renders the scene at each of 47 wavelengths, with the "
        "index of Cauchy's formula and 8 spp, and the colors are the integral over the CIE observer.",
        (Case("spectral", "spectra", "spectra.xml", color="spectral"),
         Case("dispersion", "dispersion", "dispersion.xml", color="spectral", spp=256, mitsuba_spp=8, wavelengths=True,
              exposure=0.6))),
)

PHOTON_ROWS = (
    Row("photons", "Photon mapping",
        "The same room by photon mapping: the global map alone; with final gathering; and with final gathering and a "
        "map of caustics. Last, by path tracing.",
        "Mitsuba 3 has no photon mapping, so the references are path traced. Photon maps blur within the lookup radius "
        "and are dark near edges, as in any renderer: their errors are limited instead of tested.",
        (photons("photons-plain", "global map", 0.06),
         photons("photons-gathered", "final gathering", 0.25, gather="true"),
         photons("photons-caustics", "gathering and caustics", 0.03, gather="true", caustic_photons="200000"),
         Case("photons-path", "path tracing", "caustics.xml", exposure=0.8))),
    Row("denoising", "NL-means",
        "An image of 16 spp before and after `--denoise nlm`.", "Mitsuba 3 has no such filter.",
        (Case("denoising-noisy", "noisy", "soft_shadows.xml", ("--sampler", "independent"),
              references=("Mitsuba", LONG), spp=16),
         Case("denoising-denoised", "denoised", "soft_shadows.xml", ("--sampler", "independent", "--denoise", "nlm"),
              references=(LONG,), spp=16, layer="denoised.", max_ratio_error=0.01, max_error=0.001))),
)

ROWS = LIGHT_ROWS + SURFACE_ROWS + SAMPLING_ROWS + MEDIA_ROWS + COLOR_ROWS + PHOTON_ROWS
