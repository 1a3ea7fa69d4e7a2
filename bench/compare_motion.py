#!/usr/bin/env python3
"""Measures what motion blur costs: renders of a mesh of many triangles and of many curves that stand still, move,
deform, or are seen by a moving camera, in alternation. Needs only Python and a build.

  bench/compare_motion.py [--sheaf build/release/sheaf] [--side 316] [--curves 20000] [--spp 32] [--runs 5]
                          [--only curves]

The shapes that deform look like the others in the middle of the exposure.
Prints for each scene the median of the user CPU time of the process and of the wall-clock time of rendering, over
those of the static scene, and the wall-clock time of building the acceleration structure.
"""

import argparse
import math
import random
import statistics
import tempfile
from pathlib import Path

from rendering import ROOT, render

STILL = '<transform name="to_world"> <translate y="1"/> </transform>'
MESH = '<shape type="obj"> <string name="filename" value="mesh.obj"/> {} </shape>'
CURVES = '<shape type="bsplinecurve"> <string name="filename" value="curves.txt"/> {} </shape>'
CAMERA = '<transform name="to_world"> <lookat origin="0, 2, 4" target="0, 1, 0" up="0, 1, 0"/> </transform>'

# Name, the shape, transform of the camera. The exposure is from 0 to 1. Static scenes come before those that move.
CASES = [
    ("static", MESH.format(STILL), CAMERA),
    ("mesh moves", MESH.format("""<animation name="to_world">
        <transform time="0"> <translate y="1"/> </transform>
        <transform time="1"> <translate x="0.3" y="1.1"/> </transform> </animation>"""), CAMERA),
    ("mesh turns", MESH.format("""<animation name="to_world">
        <transform time="0"> <translate y="1"/> </transform>
        <transform time="1"> <rotate y="1" angle="40"/> <translate y="1"/> </transform> </animation>"""), CAMERA),
    ("mesh deforms", """<shape type="deformable"> <string name="times" value="0, 1"/>
        <shape type="obj"> <string name="filename" value="start.obj"/> </shape>
        <shape type="obj"> <string name="filename" value="end.obj"/> </shape>
        <transform name="to_world"> <translate y="1"/> </transform> </shape>""", CAMERA),
    ("camera moves", MESH.format(STILL), """<animation name="to_world">
        <transform time="0"> <lookat origin="0, 2, 4" target="0, 1, 0" up="0, 1, 0"/> </transform>
        <transform time="1"> <lookat origin="0.4, 2, 4" target="0, 1, 0" up="0, 1, 0"/> </transform> </animation>"""),
    ("static curves", CURVES.format(STILL), CAMERA),
    ("curves move", CURVES.format("""<animation name="to_world">
        <transform time="0"> <translate y="1"/> </transform>
        <transform time="1"> <translate x="0.3" y="1.1"/> </transform> </animation>"""), CAMERA),
    ("curves deform", """<shape type="deformable"> <string name="times" value="0, 1"/>
        <shape type="bsplinecurve"> <string name="filename" value="start.txt"/> </shape>
        <shape type="bsplinecurve"> <string name="filename" value="end.txt"/> </shape>
        <transform name="to_world"> <translate y="1"/> </transform> </shape>""", CAMERA),
]

SCENE = """<scene version="3.0.0">
  <integrator type="path"> <integer name="max_depth" value="5"/> </integrator>
  <sensor type="perspective">
    <float name="fov" value="45"/> <float name="shutter_close" value="1"/> {camera}
    <film type="hdrfilm"> <integer name="width" value="480"/> <integer name="height" value="360"/> </film>
  </sensor>
  {mesh}
  <shape type="rectangle"> <transform name="to_world"> <rotate x="1" angle="-90"/> <scale value="6"/> </transform> </shape>
  <shape type="sphere">
    <point name="center" x="3" y="5" z="3"/> <float name="radius" value="0.5"/>
    <emitter type="area"> <rgb name="radiance" value="40"/> </emitter>
  </shape>
  <emitter type="constant"> <rgb name="radiance" value="0.3"/> </emitter>
</scene>
"""


def write_mesh(file, side, height):
    """Writes a sphere with bumps of 2 side^2 triangles."""
    with open(file, "w") as out:
        for i in range(side + 1):
            polar = 0.02 + (math.pi - 0.04) * i / side
            for j in range(side + 1):
                turn = 2 * math.pi * j / side
                radius = 1 + height * math.sin(9 * turn) * math.sin(11 * polar)
                out.write(f"v {radius * math.sin(polar) * math.cos(turn):.6g} {radius * math.cos(polar):.6g} "
                          f"{radius * math.sin(polar) * math.sin(turn):.6g}\n")
        for i in range(side):
            for j in range(side):
                a = i * (side + 1) + j + 1
                c = a + side + 1
                out.write(f"f {a} {a + 1} {c}\nf {a + 1} {c + 1} {c}\n")


def write_curves(file, count, bend):
    """Writes curves of five segments that grow out of a sphere, with tips displaced along x by `bend`."""
    numbers = random.Random(1)
    with open(file, "w") as out:
        for _ in range(count):
            z, turn = numbers.uniform(-1, 1), numbers.uniform(0, 2 * math.pi)
            around = math.sqrt(1 - z * z)
            direction = around * math.cos(turn), around * math.sin(turn), z
            for k in range(8):
                length = 0.7 + 0.06 * k
                x, y, z = (length * d for d in direction)
                out.write(f"{x + bend * (k / 7) ** 2:.6g} {y:.6g} {z:.6g} {0.006 * (1 - k / 10):.6g}\n")
            out.write("\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sheaf", default=str(ROOT / "build/release/sheaf"))
    parser.add_argument("--side", type=int, default=316, help="the mesh has 2 side^2 triangles")
    parser.add_argument("--curves", type=int, default=20000)
    parser.add_argument("--only", default="", help="render only the scenes whose name contains this")
    parser.add_argument("--spp", type=int, default=32)
    parser.add_argument("--runs", type=int, default=5)
    arguments = parser.parse_args()
    cases = [case for case in CASES if arguments.only in case[0]]
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        write_mesh(folder / "mesh.obj", arguments.side, 0.08)
        write_mesh(folder / "start.obj", arguments.side, 0.02)
        write_mesh(folder / "end.obj", arguments.side, 0.14)
        for file, bend in ("curves.txt", 0.2), ("start.txt", 0.1), ("end.txt", 0.3):
            write_curves(folder / file, arguments.curves, bend)
        reports = {name: [] for name, *_ in cases}
        for _ in range(arguments.runs):
            for name, mesh, camera in cases:
                scene = folder / "scene.xml"
                scene.write_text(SCENE.format(mesh=mesh, camera=camera))
                reports[name].append(render(arguments.sheaf, scene, folder / "image.exr", arguments.spp, 1, "--guiding",
                                            "off"))

        def median(name, value):
            return statistics.median(value(report) for report in reports[name])

        print(f"{'scene':14} {'process':>8} {'rendering':>10} {'BVH, s':>8}")
        static = cases[0][0]
        for name, *_ in cases:
            if name.startswith("static"):
                static = name
            whole, rendering = (median(name, value) / median(static, value)
                                for value in (lambda r: r["cpu_seconds"], lambda r: r["render_seconds"]))
            print(f"{name:14} {whole:8.3f} {rendering:10.3f} {median(name, lambda r: r['loading']['accel_seconds']):8.3f}")


if __name__ == "__main__":
    main()
