#!/usr/bin/env python3
"""Compares samplers at equal samples per pixel: error as rendered and after a blur, as the eye or a denoiser sees it.
Needs python3-numpy and a build.

  bench/compare_samplers.py [--scenes scenes/cornell/cornell.xml ...] [--samplers sobol zsobol ...] [--spp 16]
    [--scale 0.5] [--seeds 2] [--blur 1 2]

Prints a table: scene, sampler, mean squared error over R, G and B, error relative to the pixel's brightness (without
the worst 0.1 % of the values), and both for each blurred image; --blur gives the standard deviations of the Gaussians
in pixels. In brackets: error of the first sampler over that of the row, so 2 is half the error. Half the mean squared
difference of two images estimates the error of one.
"""

import argparse
import itertools
import struct
import tempfile
import zlib
from pathlib import Path

import numpy

from rendering import ROOT, render

SCENES = ("cornell/cornell", "material_room/material_room", "materials/balls", "lights/stage", "textures/wall")
SAMPLERS = ("independent", "stratified", "multijitter", "sobol", "zsobol")


def read_header(file):
    """Returns {name: bytes} of a single-part EXR file, and leaves the file positioned after the header."""
    assert file.read(8) == struct.pack("<II", 20000630, 2), "not a single-part scanline EXR file"

    def text():
        return b"".join(iter(lambda: file.read(1), b"\0")).decode()

    header = {}
    for name in iter(text, ""):
        text()
        header[name] = file.read(struct.unpack("<I", file.read(4))[0])
    return header


def read_rgb(path):
    """Returns R, G and B of a ZIP-compressed EXR file of `sheaf render` as height x width x 3."""
    with open(path, "rb") as file:
        header = read_header(file)
        lines_per_block = {0: 1, 2: 1, 3: 16}[header["compression"][0]]
        x0, y0, x1, y1 = struct.unpack("<4i", header["dataWindow"])
        width, height = x1 - x0 + 1, y1 - y0 + 1
        channels, rest = [], header["channels"]
        while rest != b"\0":
            name, rest = rest.split(b"\0", 1)
            channels.append((name.decode(), {0: "<u4", 1: "<f2", 2: "<f4"}[struct.unpack("<I", rest[:4])[0]]))
            rest = rest[16:]
        line_bytes = sum(numpy.dtype(kind).itemsize for _, kind in channels) * width
        image = numpy.empty((height, width, 3))
        file.read(8 * -(-height // lines_per_block))
        for top in range(0, height, lines_per_block):
            count = min(lines_per_block, height - top)
            data = file.read(struct.unpack("<ii", file.read(8))[1])
            if len(data) < count * line_bytes:
                data = unpack(data)
            at = 0
            for line in range(top, top + count):
                for name, kind in channels:
                    values = numpy.frombuffer(data, kind, width, at)
                    at += values.nbytes
                    if name in "RGB":
                        image[line, :, "RGB".index(name)] = values
    return image


def unpack(data):
    """Decodes OpenEXR's ZIP compression: zlib, byte deltas, and even bytes stored before odd ones."""
    data = numpy.frombuffer(zlib.decompress(data), numpy.uint8).astype(numpy.int64)
    data[1:] -= 128
    data = numpy.cumsum(data).astype(numpy.uint8)
    bytes_in_order = numpy.empty_like(data)
    bytes_in_order[0::2], bytes_in_order[1::2] = data[:(len(data) + 1) // 2], data[(len(data) + 1) // 2:]
    return bytes_in_order.tobytes()


def blurred(image, sigma):
    """Blurs by a Gaussian and crops the border that the kernel does not fully cover."""
    if sigma == 0:
        return image
    reach = min(round(4 * sigma), (min(image.shape[:2]) - 1) // 2)
    kernel = numpy.exp(-numpy.arange(-reach, reach + 1) ** 2 / (2 * sigma**2))
    kernel /= kernel.sum()
    for axis in (0, 1):
        size = image.shape[axis] - 2 * reach
        image = sum(w * image.take(range(i, i + size), axis) for i, w in enumerate(kernel))
    return image


def errors(a, b, sigma):
    """Returns the mean squared error and the squared error relative to brightness."""
    square, mean = blurred(a - b, sigma) ** 2 / 2, blurred(a + b, sigma) / 2
    relative = numpy.sort((square / (mean**2 + 0.01 * mean.mean() ** 2 + 1e-12)).ravel())
    return numpy.array([square.mean(), relative[:max(1, int(len(relative) * 0.999))].mean()])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sheaf", default=str(ROOT / "build/release/sheaf"))
    parser.add_argument("--scenes", nargs="+", default=[str(ROOT / "scenes" / f"{name}.xml") for name in SCENES])
    parser.add_argument("--samplers", nargs="+", default=SAMPLERS)
    parser.add_argument("--spp", type=int, default=16)
    parser.add_argument("--scale", type=float, default=0.5)
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--blur", nargs="*", type=float, default=[1, 2])
    arguments = parser.parse_args()
    sigmas = [0, *arguments.blur]
    names = "".join(f"{f'MSE, blur {s:g}' if s else 'MSE':>22}{f'rel, blur {s:g}' if s else 'rel':>22}" for s in sigmas)
    print(f"{'scene':16}{'sampler':12}{names}")
    with tempfile.TemporaryDirectory() as folder:
        for scene in arguments.scenes:
            first = None
            for sampler in arguments.samplers:
                images = []
                for seed in range(1, arguments.seeds + 1):
                    path = Path(folder) / "image.exr"
                    render(arguments.sheaf, scene, path, arguments.spp, seed, "--sampler", sampler, "--scale",
                           str(arguments.scale))
                    images.append(read_rgb(path))
                pairs = list(itertools.combinations(images, 2))
                found = [sum(errors(a, b, s) for a, b in pairs) / len(pairs) for s in sigmas]
                first = first or found
                cells = "".join(f"{value:12.3e} ({base / max(value, 1e-30):7.2f})" for now, then in zip(found, first)
                                for value, base in zip(now, then))
                print(f"{Path(scene).stem:16}{sampler:12}{cells}", flush=True)


if __name__ == "__main__":
    main()
