#!/usr/bin/env python3
"""Compares the time before the first ray: reading, textures, compiling and the acceleration structure. Needs only Python
and one or more builds.

  bench/compare_loading.py [--sheaf OLD/sheaf NEW/sheaf] [--scenes SCENE ...] [--side 1000] [--files 500] [--runs 5]

Without --scenes it writes meshes of 2 x SIDE^2 triangles with normals and texture coordinates as OBJ and PLY, and a scene
of FILES small OBJ and PLY files. Every round renders each scene once with each build, at 1 sample in an image of 8 x 8
pixels. Prints medians: wall-clock and CPU seconds of the whole process, peak memory, and the times by cause.
"""

import argparse
import json
import math
import os
import resource
import statistics
import struct
import subprocess
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
CAUSES = ["reading_seconds", "texture_seconds", "compile_seconds", "accel_seconds"]


def grid(side):
    """Yields the rows x, y, z, normal, u, v of a wavy square with side + 1 vertices along each edge."""
    for j in range(side + 1):
        for i in range(side + 1):
            x, y = i / side, j / side
            slope = (-math.cos(20 * x) * math.cos(17 * y), 0.85 * math.sin(20 * x) * math.sin(17 * y))
            length = math.sqrt(1 + slope[0] ** 2 + slope[1] ** 2)
            yield (x, y, 0.05 * math.sin(20 * x) * math.cos(17 * y), slope[0] / length, slope[1] / length, 1 / length,
                   x, y)


def triangles(side):
    for j in range(side):
        for i in range(side):
            a = j * (side + 1) + i
            yield a, a + 1, a + side + 2
            yield a, a + side + 2, a + side + 1


def write_obj(file, side):
    with open(file, "w", encoding="ascii") as out:
        out.writelines("v %.6f %.6f %.6f\n" % row[:3] for row in grid(side))
        out.writelines("vt %.6f %.6f\n" % row[6:] for row in grid(side))
        out.writelines("vn %.6f %.6f %.6f\n" % row[3:6] for row in grid(side))
        out.writelines("f %d/%d/%d %d/%d/%d %d/%d/%d\n" % tuple(i + 1 for i in t for _ in range(3))
                       for t in triangles(side))


def write_ply(file, side):
    names = "".join(f"property float {name}\n" for name in ["x", "y", "z", "nx", "ny", "nz", "u", "v"])
    header = (f"ply\nformat binary_little_endian 1.0\nelement vertex {(side + 1) ** 2}\n{names}"
              f"element face {2 * side * side}\nproperty list uchar int vertex_indices\nend_header\n")
    with open(file, "wb") as out:
        out.write(header.encode())
        out.writelines(struct.pack("<8f", *row) for row in grid(side))
        out.writelines(struct.pack("<Biii", 3, *t) for t in triangles(side))


def write_scene(file, meshes):
    columns = math.isqrt(len(meshes) - 1) + 1
    shapes = "\n".join(f'<shape type="{mesh.suffix[1:]}"><string name="filename" value="{mesh.name}"/><transform '
                       f'name="to_world"><translate x="{i % columns}" y="{i // columns}"/></transform></shape>'
                       for i, mesh in enumerate(meshes))
    file.write_text('<scene version="3.0.0"><integrator type="path"/><sensor type="perspective">'
                    '<transform name="to_world"><lookat origin="0.5, -1, 1" target="0.5, 0.5, 0" up="0, 0, 1"/>'
                    '</transform></sensor><emitter type="constant"/>\n' + shapes + "\n</scene>\n")
    return file


def write_scenes(folder, side, files):
    write_obj(folder / "large.obj", side)
    write_ply(folder / "large.ply", side)
    small = [folder / f"small{i}.{'obj' if i % 2 == 0 else 'ply'}" for i in range(files)]
    for mesh in small:
        (write_obj if mesh.suffix == ".obj" else write_ply)(mesh, 16)
    return [write_scene(folder / "obj.xml", [folder / "large.obj"]),
            write_scene(folder / "ply.xml", [folder / "large.ply"]), write_scene(folder / "files.xml", small)]


def measure(sheaf, scene, folder):
    """Seconds of wall clock and CPU, peak memory in MB, and the times by cause (0 in builds that lack them)."""
    stats = Path(folder) / "stats.json"
    command = [str(sheaf), "render", str(scene), "-o", str(Path(folder) / "out.exr"), "--spp", "1", "--size", "8x8",
               "-qq", "--stats", str(stats)]
    start, before = time.monotonic(), resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(command, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    report = json.loads(stats.read_text())
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return [time.monotonic() - start, cpu, report["peak_rss_bytes"] * 1e-6,
            *(report.get("loading", {}).get(cause, 0) for cause in CAUSES)]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sheaf", nargs="+", default=[str(ROOT / "build/release/sheaf")])
    parser.add_argument("--scenes", nargs="+", type=Path, help="instead of generated ones")
    parser.add_argument("--side", type=int, default=1000)
    parser.add_argument("--files", type=int, default=500)
    parser.add_argument("--runs", type=int, default=5)
    arguments = parser.parse_args()
    print(f"{'scene':24} {'build':20} {'wall, s':>8} {'CPU, s':>8} {'MB':>7} {'reading':>8} {'textures':>8} "
          f"{'compile':>8} {'BVH':>8}")
    with tempfile.TemporaryDirectory() as folder:
        scenes = arguments.scenes or write_scenes(Path(folder), arguments.side, arguments.files)
        for scene in scenes:
            runs = {sheaf: [] for sheaf in arguments.sheaf}
            for _ in range(arguments.runs):
                for sheaf in arguments.sheaf:
                    runs[sheaf].append(measure(sheaf, scene, folder))
            for sheaf, rows in runs.items():
                wall, cpu, memory, *causes = (statistics.median(column) for column in zip(*rows))
                name = os.path.join(scene.parent.name, scene.name)[-24:]
                print(f"{name:24} {sheaf[-20:]:20} {wall:8.3f} {cpu:8.3f} {memory:7.0f} "
                      + " ".join(f"{seconds:8.3f}" for seconds in causes), flush=True)


if __name__ == "__main__":
    main()
