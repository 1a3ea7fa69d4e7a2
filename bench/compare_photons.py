#!/usr/bin/env python3
"""Compares path tracing, guiding, manifold next-event estimation, light tracing and variants of photon mapping on
caustics: time and error. Needs Python with numpy, a build, and the meshes of scenes/make/make_caustic_scenes.py.

  bench/compare_photons.py [--scenes scenes/caustics/ring.xml ...] [--seconds 20] [--width 160] [--reference-spp 8192]

Prints a table for each scene: samples per pixel; CPU seconds; peak memory in MB; and, for the whole image and for the
part with the caustic: mean squared error, relative mean squared error, mean over that of the reference, and gain. The
gain is the time that path tracing needs for the same mean squared error (inversely proportional to time) over the time
taken. It is omitted if light tracing misses some of the light. Methods without samples per pixel in METHODS take as
many as fit into --seconds of CPU time.

References are two renders by path tracing with --caustics mnee; for the part, by light tracing if the camera sees only diffuse surfaces
there. Errors exclude the noise of the references: they are means of (x - a) (x - b) for an image x and renders a and
b. "<" marks an error below twice its own uncertainty.
"""

import argparse
import re
import struct
import subprocess
import tempfile
import zlib
from pathlib import Path

import numpy as np

from rendering import ROOT, render

# The part with the caustic (x0, y0, x1, y1 as fractions of width and height), the integrator of its reference, and the
# radii of the maps. Other scenes use the default radii, relative to the size of the scene.
SCENES = {
    "ring": {"part": (0.245, 0.385, 0.42, 0.60), "part_reference": "ptracer", "radius": 0.08, "caustic_radius": 0.012},
    "pool": {"part": (0.25, 0.40, 0.75, 0.70), "part_reference": "path", "radius": 0.12, "caustic_radius": 0.02},
}
OTHER_SCENE = {"part": (0, 0, 1, 1), "part_reference": "path", "radius": 0, "caustic_radius": 0}

ALL_IN_RADIUS = {"lookupSize": 0}
GLOBAL_MAP = ALL_IN_RADIUS | {"photonCount": 250000, "photonRadius": "radius"}
CAUSTIC_MAP = {"causticPhotonCount": 500000, "causticRadius": "caustic_radius"}

# Name, integrator, properties, samples per pixel, options of sheaf render. A string value of a property names an entry
# of the scene in SCENES.
METHODS = [
    ("path", "path", {}, None, "--guiding off"),
    ("path, guiding", "path", {}, None, "--guiding on"),
    ("path, mnee", "path", {}, None, "--guiding off --caustics mnee"),
    ("mnee, guiding", "path", {}, None, "--guiding on --caustics mnee"),
    ("ptracer", "ptracer", {}, None, ""),
    ("map, 1M photons", "photonmapper",
     ALL_IN_RADIUS | {"photonCount": 1000000, "photonRadius": "caustic_radius", "sampleDirect": False}, 64, ""),
    ("gather", "photonmapper", GLOBAL_MAP | {"finalGather": True, "causticPhotonCount": 0}, 64, ""),
    ("gather, caustics", "photonmapper", GLOBAL_MAP | {"finalGather": True} | CAUSTIC_MAP, 64, ""),
    ("sppm", "sppm", {"photonCount": 250000, "initialRadius": "caustic_radius", "alpha": 0.7}, None, ""),
]

# Options of references by path tracing.
PATH_REFERENCE = "--guiding off --caustics mnee"

# Properties of a scene's integrator that are kept for the other integrators.
KEPT = r'<\w+ name="(?:max_?depth|rr_?depth|hide_?emitters)"[^>]*/>'


def integrator_element(kind, properties, settings, kept):
    elements = list(kept)
    for name, value in properties.items():
        if isinstance(value, str):
            value = float(settings[value])
        element = {bool: "boolean", int: "integer", float: "float"}[type(value)]
        elements.append(f'<{element} name="{name}" value="{str(value).lower()}"/>')
    return f'<integrator type="{kind}">{"".join(elements)}</integrator>'


class Scene:
    """A scene file with a replaceable integrator."""

    def __init__(self, arguments, file, folder):
        self.sheaf, self.photons = arguments.sheaf, arguments.photons
        self.file, self.folder = Path(file).resolve(), folder
        self.settings = SCENES.get(self.file.stem, OTHER_SCENE)
        text = self.file.read_text()
        integrator = re.search(r"<integrator\b[^>]*/>|<integrator\b.*?</integrator>", text, re.DOTALL)
        self.kept = re.findall(KEPT, integrator[0], re.IGNORECASE)
        start = re.search(r"<scene\b[^>]*>", text).end()
        self.before = text[:start] + f'<path value="{self.file.parent}"/>' + text[start:integrator.start()]
        self.after = text[integrator.end():]
        width, height = (re.search(rf'name="{name}" value="(\d+)"', text) for name in ("width", "height"))
        self.size = [arguments.width, round(arguments.width * int(height[1]) / int(width[1]))]
        self.defines = ["-D", f"width={self.size[0]}", "-D", f"height={self.size[1]}"]

    def write(self, kind, properties):
        """Writes the scene with this integrator and returns the file."""
        properties = {name: round(self.photons * value) if name.lower().endswith("photoncount") else value
                      for name, value in properties.items()}
        file = self.folder / "scene.xml"
        file.write_text(self.before + integrator_element(kind, properties, self.settings, self.kept) + self.after)
        return file

    def objection(self, kind, properties):
        """Returns the error message if Sheaf rejects this integrator, else None."""
        done = subprocess.run([self.sheaf, "info", self.write(kind, properties), *self.defines], check=False, text=True,
                              capture_output=True)
        return None if done.returncode == 0 else done.stderr.strip().split(" (known")[0]

    def render(self, kind, properties, spp, seed, options=""):
        """Returns the statistics report and the image."""
        image = self.folder / "image.exr"
        report = render(self.sheaf, self.write(kind, properties), image, spp, seed, *self.defines, *options.split())
        return report, read_colors(image)

    def part(self, image):
        height, width, _ = image.shape
        x0, y0, x1, y1 = self.settings["part"]
        return image[round(y0 * height):round(y1 * height), round(x0 * width):round(x1 * width)]


def read_colors(file):
    """Returns R, G and B of an EXR file."""
    return read_channels(file, "RGB")


def read_channels(file, wanted):
    """Returns channels of an EXR file written by Sheaf: 32-bit floats, ZIP compression in blocks of 16 lines."""
    data = file.read_bytes()
    header, at = {}, 8
    while data[at]:
        name, kind, rest = data[at:].split(b"\0", 2)
        at = len(data) - len(rest) + 4
        length = struct.unpack_from("<i", rest)[0]
        header[name.decode()] = data[at:at + length]
        at += length
    names = [c.decode() for c in re.findall(rb"([^\0]+)\0.{16}", header["channels"], re.DOTALL)]
    x0, y0, x1, y1 = struct.unpack("<4i", header["dataWindow"])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    image = np.empty((height, len(names), width), np.float32)
    for offset in struct.unpack_from(f"<{-(-height // 16)}q", data, at + 1):
        y, length = struct.unpack_from("<2i", data, offset)
        lines = image[y - y0:y - y0 + 16]
        block = np.frombuffer(data, np.uint8, length, offset + 8)
        if length < lines.nbytes:
            packed = np.frombuffer(zlib.decompress(block), np.uint8)
            packed = np.cumsum(packed, dtype=np.uint8) - (128 * np.arange(packed.size)).astype(np.uint8)
            half = (packed.size + 1) // 2
            block = np.empty_like(packed)
            block[0::2], block[1::2] = packed[:half], packed[half:]
        lines[...] = block.view("<f4").reshape(lines.shape)
    return image[:, [names.index(c) for c in wanted]].transpose(0, 2, 1).astype(float)


def errors(images, references):
    """Returns mean squared error, twice its uncertainty, relative mean squared error, and mean over the reference's."""
    a, b = references
    middle = (a + b) / 2
    squares = np.mean([(image - a) * (image - b) for image in images], 0)
    relative = squares / (middle**2 + 0.01)
    return (squares.mean(), 2 * squares.std() / squares.size**0.5, relative.mean(),
            np.mean(images) / middle.mean())


def columns(measured, paths_cost, seconds):
    """Formats the result of errors() and the gain over paths; `paths_cost` is their error times seconds, or None."""
    error, uncertainty, relative, mean = measured
    sign, error = ("<", uncertainty) if error < uncertainty else ("", error)
    gain = f"{'>' if sign else ''}{paths_cost / (error * seconds):.3g}" if paths_cost else "-"
    return f"{f'{sign}{error:.3g}':>9} {max(relative, 0):9.3g} {mean:6.3f} {gain:>7}"


def samples_in(arguments, scene, kind, properties, options):
    """Returns the samples per pixel that fit into --seconds of CPU time."""
    spp = 4
    while True:
        seconds = scene.render(kind, properties, spp, 1, options)[0]["cpu_seconds"]
        if seconds > 0.2 * arguments.seconds:
            return max(1, round(spp * arguments.seconds / seconds))
        spp *= 4


def compare(arguments, scene):
    settings = scene.settings
    print(f"{scene.file.stem}, {scene.size[0]} x {scene.size[1]} pixels", flush=True)
    references = {kind: [scene.render(kind, {}, arguments.reference_spp, seed,
                                      PATH_REFERENCE if kind == "path" else "")[1] for seed in (1001, 1002)]
                  for kind in {"path", settings["part_reference"]}}
    print(f"{'method':16} {'spp':>7} {'cpu s':>7} {'MB':>5} {'MSE':>9} {'relMSE':>9} {'mean':>6} {'gain':>7} |"
          f"{'part: MSE':>9} {'relMSE':>9} {'mean':>6} {'gain':>7}")
    paths_cost = None
    for name, kind, properties, spp, options in METHODS:
        objection = scene.objection(kind, properties)
        if objection:
            print(f"{name:16} skipped: {objection}", flush=True)
            continue
        spp = spp or samples_in(arguments, scene, kind, properties, options)
        renders = [scene.render(kind, properties, spp, seed, options) for seed in range(2, 2 + arguments.seeds)]
        seconds = np.mean([report["cpu_seconds"] for report, _ in renders])
        memory = max(report["peak_rss_bytes"] for report, _ in renders) / 1e6
        whole = errors([image for _, image in renders], references["path"])
        part = errors([scene.part(image) for _, image in renders],
                      [scene.part(image) for image in references[settings["part_reference"]]])
        paths_cost = paths_cost or [whole[0] * seconds, part[0] * seconds]
        blind = kind == "ptracer", kind == "ptracer" != settings["part_reference"]
        texts = [columns(measured, None if misses else cost, seconds)
                 for measured, misses, cost in zip((whole, part), blind, paths_cost)]
        print(f"{name:16} {spp:7d} {seconds:7.2f} {memory:5.0f} {' |'.join(texts)}", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sheaf", default=str(ROOT / "build/release/sheaf"))
    parser.add_argument("--scenes", nargs="+", default=[ROOT / "scenes/caustics" / f"{name}.xml" for name in SCENES])
    parser.add_argument("--seconds", type=float, default=20, help="CPU time per image of methods without a fixed spp")
    parser.add_argument("--width", type=int, default=160)
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--reference-spp", type=int, default=8192)
    parser.add_argument("--photons", type=float, default=1, help="factor on the photon counts of METHODS")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        for scene in arguments.scenes:
            compare(arguments, Scene(arguments, scene, Path(folder)))


if __name__ == "__main__":
    main()
