#!/usr/bin/env python3
"""Compares the time to the first pixel and the peak memory of big scenes, beside Mitsuba 3 and pbrt-v4. Needs only
Python and a build.

  bench/compare_big.py [--sheaf OLD/sheaf NEW/sheaf] [--mitsuba-python ENVIRONMENT/bin/python] [--variant scalar_rgb]
                       [--pbrt build/pbrt] [--side 300] [--meshes 1] [--instances 500] [--texture-side 512]
                       [--runs 3] [--only NAME...]

Writes scenes with one mesh of 2 x SIDE^2 triangles, as PLY and OBJ, of INSTANCES instances of MESHES such PLY
files, and of four images of TEXTURE-SIDE^2 pixels as textures (PNG, 8 bits, stored). Every round renders each scene once with each program, at 1
sample in an image of 8 x 8 pixels; pbrt reads no OBJ files. Prints medians: wall-clock and CPU seconds of the whole
process, peak memory, and the same per triangle of the mesh, or per pixel of the images. Mitsuba's include Python's
start. For 20 million triangles and 4 GB of texels: --side 3162 --texture-side 16384; for 50 million triangles in 20,000
instances: --only instances --side 707 --meshes 50 --instances 20000.
"""

import argparse
import math
import os
import random
import statistics
import struct
import subprocess
import tempfile
import time
import zlib
from pathlib import Path

from compare_loading import ROOT, write_obj, write_ply

MITSUBA = """
import sys, mitsuba as mi
mi.set_variant(sys.argv[1])
mi.render(mi.load_file(sys.argv[2]), spp=1).numpy()
"""
HEAD = """<scene version="3.0.0"><integrator type="path"/><emitter type="constant"/><sensor type="perspective">
<transform name="to_world"><lookat origin="0.5, -1, 1" target="0.5, 0.5, 0" up="0, 0, 1"/></transform>
<film type="hdrfilm"><integer name="width" value="8"/><integer name="height" value="8"/></film>
<sampler type="independent"><integer name="sample_count" value="1"/></sampler></sensor>
"""
MESH = '<shape type="ply"><string name="filename" value="mesh.ply"/></shape>'
PBRT_HEAD = """LookAt 0.5 -1 1  0.5 0.5 0  0 0 1
Camera "perspective" "float fov" 39
Film "rgb" "integer xresolution" 8 "integer yresolution" 8
Sampler "independent" "integer pixelsamples" 1
WorldBegin
LightSource "infinite" "rgb L" [1 1 1]
"""
IMAGES = 4
PBRT_MESH = 'Shape "plymesh" "string filename" "mesh.ply"'


def write_png(file, side, seed):
    """Writes a square image of noise, which repeats after 64 rows, without compression."""
    generator = random.Random(seed)
    rows = b"".join(b"\0" + generator.randbytes(3 * side) for _ in range(64))
    compress = zlib.compressobj(level=0)
    with file.open("wb") as out:
        def chunk(kind, data):
            out.write(struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data)))

        out.write(b"\x89PNG\r\n\x1a\n")
        chunk(b"IHDR", struct.pack(">IIBBBBB", side, side, 8, 2, 0, 0, 0))
        for y in range(0, side, 64):
            chunk(b"IDAT", compress.compress(rows[:(1 + 3 * side) * (side - y)]))
        chunk(b"IDAT", compress.flush())
        chunk(b"IEND", b"")


def write_texture_scene(folder, side):
    """Writes a scene of four squares, each with an image of its own."""
    squares, pbrt_squares = [], []
    for i in range(IMAGES):
        write_png(folder / f"image{i}.png", side, i)
        x = i * 0.25
        squares.append(f'<shape type="rectangle"><transform name="to_world"><scale x="0.12" y="0.5"/>'
                       f'<translate x="{x + 0.125}" y="0.5"/></transform><bsdf type="diffuse"><texture type="bitmap" '
                       f'name="reflectance"><string name="filename" value="image{i}.png"/></texture></bsdf></shape>')
        pbrt_squares.append(f'Texture "image{i}" "spectrum" "imagemap" "string filename" "image{i}.png"\n'
                            f'Material "diffuse" "texture reflectance" "image{i}"\n'
                            f'Shape "bilinearmesh" "point3 P" [{x} 0 0  {x + 0.24} 0 0  {x} 1 0  {x + 0.24} 1 0] '
                            f'"point2 uv" [0 0 1 0 0 1 1 1]')
    lines = "\n".join(squares)
    (folder / "textures.xml").write_text(f"{HEAD}{lines}</scene>\n")
    lines = "\n".join(pbrt_squares)
    (folder / "textures.pbrt").write_text(f"{PBRT_HEAD}{lines}\n")


def write_scenes(folder, side, meshes, instances, texture_side):
    """Writes the scenes and returns their files with the number of triangles or pixels; those of pbrt have the same
    names."""
    write_ply(folder / "mesh.ply", side)
    write_obj(folder / "mesh.obj", side)
    write_texture_scene(folder, texture_side)
    columns = math.isqrt(max(instances - 1, 0)) + 1
    places = [(i % columns, i // columns) for i in range(instances)]
    names = ["mesh.ply"] + [f"mesh{i}.ply" for i in range(1, meshes)]
    for name in names[1:]:
        os.link(folder / "mesh.ply", folder / name)
    groups = "".join(f'<shape type="shapegroup" id="group{i}">{MESH.replace("mesh.ply", name)}</shape>'
                     for i, name in enumerate(names))
    placed = "\n".join(f'<shape type="instance"><ref id="group{i % meshes}"/><transform name="to_world">'
                       f'<translate x="{x}" y="{y}"/></transform></shape>' for i, (x, y) in enumerate(places))
    scenes = {"ply": MESH, "obj": MESH.replace("ply", "obj"),
              "instances": groups + placed}
    for name, shapes in scenes.items():
        (folder / f"{name}.xml").write_text(f"{HEAD}{shapes}</scene>\n")
    groups = "".join(f'ObjectBegin "group{i}" {PBRT_MESH.replace("mesh.ply", name)} ObjectEnd\n'
                     for i, name in enumerate(names))
    placed = "\n".join(f'AttributeBegin Translate {x} {y} 0 ObjectInstance "group{i % meshes}" AttributeEnd'
                       for i, (x, y) in enumerate(places))
    (folder / "ply.pbrt").write_text(f"{PBRT_HEAD}{PBRT_MESH}\n")
    (folder / "instances.pbrt").write_text(f"{PBRT_HEAD}{groups}{placed}\n")
    counts = dict.fromkeys(scenes, 2 * side ** 2) | {"instances": 2 * side ** 2 * meshes,
                                                     "textures": IMAGES * texture_side ** 2}
    return {folder / f"{name}.xml": count for name, count in counts.items()}


def measure(command):
    """Seconds of wall clock and CPU, and peak memory in bytes, of one process."""
    start = time.monotonic()
    with subprocess.Popen(command, stdout=subprocess.DEVNULL) as process:
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise SystemExit(f"failed: {' '.join(command)}")
    return time.monotonic() - start, usage.ru_utime + usage.ru_stime, usage.ru_maxrss * 1024


def commands(arguments, folder):
    """The command line of each program for a scene."""
    programs = {sheaf: lambda scene, sheaf=sheaf: [sheaf, "render", str(scene), "-qq", "-o", str(folder / "out.exr")]
                for sheaf in arguments.sheaf}
    if arguments.mitsuba_python:
        programs["Mitsuba " + arguments.variant] = lambda scene: [arguments.mitsuba_python, "-c", MITSUBA,
                                                                  arguments.variant, str(scene)]
    if arguments.pbrt:
        programs["pbrt"] = lambda scene: [arguments.pbrt, "--quiet", "--outfile", str(folder / "out.exr"),
                                          str(scene.with_suffix(".pbrt"))]
    return programs


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sheaf", nargs="+", default=[str(ROOT / "build/release/sheaf")])
    parser.add_argument("--mitsuba-python")
    parser.add_argument("--variant", default="scalar_rgb")
    parser.add_argument("--pbrt")
    parser.add_argument("--side", type=int, default=300)
    parser.add_argument("--meshes", type=int, default=1)
    parser.add_argument("--instances", type=int, default=500)
    parser.add_argument("--texture-side", type=int, default=512)
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--only", nargs="+", help="names of scenes")
    arguments = parser.parse_args()
    print(f"{'scene':12} {'program':44} {'wall, s':>8} {'CPU, s':>8} {'MB':>8} {'bytes/element':>14}")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        programs = commands(arguments, folder)
        for scene, count in write_scenes(folder, arguments.side, arguments.meshes,
                                         arguments.instances, arguments.texture_side).items():
            if arguments.only and scene.stem not in arguments.only:
                continue
            rows = {program: [] for program in programs}
            for _ in range(arguments.runs):
                for program, command in programs.items():
                    if program != "pbrt" or scene.with_suffix(".pbrt").exists():
                        rows[program].append(measure(command(scene)))
            for program, runs in rows.items():
                if not runs:
                    continue
                wall, cpu, memory = (statistics.median(column) for column in zip(*runs))
                print(f"{scene.stem:12} {program:44} {wall:8.2f} {cpu:8.2f} {memory * 1e-6:8.0f} "
                      f"{memory / count:14.1f}")


if __name__ == "__main__":
    main()
