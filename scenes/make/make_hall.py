#!/usr/bin/env python3
"""Writes scenes/hall/hall.xml: a hall with two rows of columns and 1000 small lamps whose powers span a factor of 1000.
Needs only Python; the output is deterministic.

  scenes/make/make_hall.py
"""

import math
import random
from pathlib import Path

from scene_text import camera

FILE = Path(__file__).resolve().parents[2] / "scenes" / "hall" / "hall.xml"

HEAD = """<?xml version="1.0" encoding="utf-8"?>
<!-- A hall with 1000 small lamps of mixed power, a benchmark for light sampling. Written by
     scenes/make/make_hall.py. Lengths in meters; y is up, the camera looks along the hall. -->
<scene version="3.0.0">
  <default name="spp" value="64"/>
  <default name="width" value="640"/>
  <default name="height" value="360"/>
  <default name="light_sampler" value="bvh"/>
  <default name="candidates" value="4"/>
  <default name="hide" value="false"/>

  <integrator type="path">
    <integer name="max_depth" value="6"/>
    <boolean name="hide_emitters" value="$hide"/>
    <string name="light_sampler" value="$light_sampler"/>
    <integer name="candidates" value="$candidates"/>
  </integrator>

""" + camera("-19, 2.6, 1.5", "0, 2.2, -0.5", 70, "$width", "$height") + """
  <bsdf type="diffuse" id="plaster">
    <rgb name="reflectance" value="0.70, 0.66, 0.58"/>
  </bsdf>
  <bsdf type="diffuse" id="vault">
    <rgb name="reflectance" value="0.55, 0.58, 0.62"/>
  </bsdf>
  <bsdf type="roughplastic" id="tiles">
    <float name="alpha" value="0.15"/>
    <texture name="diffuse_reflectance" type="checkerboard">
      <rgb name="color0" value="0.55, 0.50, 0.42"/>
      <rgb name="color1" value="0.12, 0.11, 0.10"/>
      <transform name="to_uv">
        <scale x="20" y="10"/>
      </transform>
    </texture>
  </bsdf>
  <bsdf type="roughconductor" id="bronze">
    <string name="distribution" value="ggx"/>
    <string name="material" value="Cu"/>
    <float name="alpha" value="0.25"/>
  </bsdf>
"""

WALL = """
  <shape type="rectangle">
    <transform name="to_world">{transforms}
    </transform>
    <ref id="{material}"/>
  </shape>"""
WALLS = [("tiles", (20, 10), [(1, 0, 0, -90)], (0, 0, 0)), ("vault", (20, 10), [(1, 0, 0, 90)], (0, 8, 0)),
         ("plaster", (20, 4), [], (0, 4, -10)), ("plaster", (20, 4), [(0, 1, 0, 180)], (0, 4, 10)),
         ("plaster", (10, 4), [(0, 1, 0, 90)], (-20, 4, 0)), ("plaster", (10, 4), [(0, 1, 0, -90)], (20, 4, 0))]


def wall(material, size, turns, place):
    steps = [f'<scale x="{size[0]}" y="{size[1]}"/>']
    steps += [f'<rotate x="{x}" y="{y}" z="{z}" angle="{angle}"/>' for x, y, z, angle in turns]
    steps.append('<translate x="{}" y="{}" z="{}"/>'.format(*place))
    return WALL.format(material=material, transforms="".join("\n      " + s for s in steps))


def furniture():
    """Columns, and between them bronze balls on plinths."""
    out = []
    for row in (-5, 5):
        for i in range(8):
            x = -17.5 + 5 * i
            out.append(f'  <shape type="cylinder"><point name="p0" x="{x}" y="0" z="{row}"/><point name="p1" x="{x}" '
                       f'y="8" z="{row}"/><float name="radius" value="0.45"/><ref id="plaster"/></shape>')
            out.append(f'  <shape type="cube"><transform name="to_world"><scale x="0.7" y="0.2" z="0.7"/><translate '
                       f'x="{x}" y="0.2" z="{row}"/></transform><ref id="plaster"/></shape>')
        for i in range(7):
            x = -15 + 5 * i
            out.append(f'  <shape type="cube"><transform name="to_world"><scale x="0.4" y="0.5" z="0.4"/><translate '
                       f'x="{x}" y="0.5" z="{row}"/></transform><ref id="vault"/></shape>')
            out.append(f'  <shape type="sphere"><point name="center" x="{x}" y="1.5" z="{row}"/><float name="radius" '
                       f'value="0.5"/><ref id="bronze"/></shape>')
    return out


def color(rng):
    """A random color between candlelight and overcast sky."""
    t = rng.random()
    return (1.0, 0.55 + 0.45 * t, 0.2 + 0.8 * t)


def lamp(rng, matrix, area):
    power = 10 ** rng.uniform(-2.3, 0.7)
    radiance = ", ".join(f"{power * c / (math.pi * area):.4g}" for c in color(rng))
    return f'  <shape type="{matrix[0]}">{matrix[1]}<emitter type="area"><rgb name="radiance" value="{radiance}"/>' \
           f"</emitter></shape>"


def lamps(rng):
    out = []
    for _ in range(700):  # in the ceiling, looking down
        x, z, half = rng.uniform(-19.5, 19.5), rng.uniform(-9.5, 9.5), rng.uniform(0.02, 0.07)
        matrix = f"{half:.3f} 0 0 {x:.3f} 0 0 -{half:.3f} 7.98 0 {half:.3f} 0 {z:.3f} 0 0 0 1"
        out.append(lamp(rng, ("rectangle", f'<transform name="to_world"><matrix value="{matrix}"/></transform>'),
                        4 * half * half))
    for _ in range(200):  # on the long walls, looking in
        x, y, side, half = rng.uniform(-19.5, 19.5), rng.uniform(0.3, 6), rng.choice((-1, 1)), rng.uniform(0.02, 0.05)
        turned = f"{-side * half:.3f}"
        matrix = f"{turned} 0 0 {x:.3f} 0 {half:.3f} 0 {y:.3f} 0 0 {turned} {side * 9.98:.2f} 0 0 0 1"
        out.append(lamp(rng, ("rectangle", f'<transform name="to_world"><matrix value="{matrix}"/></transform>'),
                        4 * half * half))
    for _ in range(100):  # lanterns
        x, y, z, radius = rng.uniform(-19, 19), rng.uniform(2.5, 6.5), rng.uniform(-9, 9), rng.uniform(0.02, 0.05)
        place = f'<point name="center" x="{x:.3f}" y="{y:.3f}" z="{z:.3f}"/><float name="radius" value="{radius:.3f}"/>'
        out.append(lamp(rng, ("sphere", place), 4 * math.pi * radius * radius))
    return out


def main():
    lines = [HEAD] + [wall(*w) for w in WALLS] + ["", "  <!-- Columns, plinths, balls. -->"] + furniture()
    lines += ["", "  <!-- The lamps. -->"] + lamps(random.Random(1)) + ["</scene>", ""]
    FILE.parent.mkdir(parents=True, exist_ok=True)
    FILE.write_text("\n".join(lines))


if __name__ == "__main__":
    main()
