#!/usr/bin/env python3
"""Writes the example scenes in scenes/textures with their images. Needs only Python; the output is deterministic."""

import math
import struct
import zlib
from pathlib import Path

from scene_text import sensor, write_scene

ROOT = Path(__file__).resolve().parents[2]
TEXTURES = ROOT / "scenes" / "textures"
IMAGES = TEXTURES / "images"
SCRIPT = "make_texture_scenes.py"


def write_png(path, rows):
    """Writes 8-bit RGB from rows of (r, g, b) in [0, 1], top row first."""
    height, width = len(rows), len(rows[0])
    raw = b"".join(b"\0" + bytes(round(255 * min(max(c, 0.0), 1.0)) for texel in row for c in texel) for row in rows)

    def chunk(kind, data):
        body = kind + data
        return struct.pack(">I", len(data)) + body + struct.pack(">I", zlib.crc32(body))

    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">2I5B", width, height, 8, 2, 0, 0, 0)) +
                     chunk(b"IDAT", zlib.compress(raw, 9)) + chunk(b"IEND", b""))


def noise(x, y):
    """Hash of integers: a pseudo-random number in [0, 1)."""
    n = (x * 374761393 + y * 668265263) & 0xFFFFFFFF
    n = ((n ^ (n >> 13)) * 1274126177) & 0xFFFFFFFF
    return (n ^ (n >> 16)) / 2**32


def brick_at(u, v):
    """Height and brick index at a point of the wall; 4 bricks across, 8 courses, tileable."""
    course = math.floor(8 * v)
    along = 4 * u + 0.5 * (course % 2)
    x, y = along % 1.0, (8 * v) % 1.0
    edge = min(min(x, 1 - x) * 2, min(y, 1 - y)) / 0.16
    height = 1.0 if edge > 1 else edge * edge * (3 - 2 * edge)
    return height, (int(along) % 4, course)


def make_bricks(size=192):
    """Writes the color texture and the normal map of a brick wall."""
    heights = [[brick_at((x + 0.5) / size, 1 - (y + 0.5) / size)[0] for x in range(size)] for y in range(size)]
    colors, normals = [], []
    for y in range(size):
        colors.append([])
        normals.append([])
        for x in range(size):
            height, brick = brick_at((x + 0.5) / size, 1 - (y + 0.5) / size)
            shade = 0.75 + 0.25 * noise(*brick)
            grain = 0.06 * (noise(x + 999, y) - 0.5)
            brick_color = (0.62 * shade + grain, 0.30 * shade + grain, 0.22 * shade + grain)
            mortar = (0.62 + grain, 0.60 + grain, 0.56 + grain)
            colors[-1].append(tuple(m + height * (b - m) for m, b in zip(mortar, brick_color)))
            slope = 3.0
            dx = slope * (heights[y][(x + 1) % size] - heights[y][x - 1]) / 2
            dy = slope * (heights[y - 1][x] - heights[(y + 1) % size][x]) / 2
            length = math.sqrt(dx * dx + dy * dy + 1)
            normals[-1].append(tuple(0.5 + 0.5 * c / length for c in (-dx, -dy, 1)))
    write_png(IMAGES / "bricks.png", colors)
    write_png(IMAGES / "bricks_normal.png", normals)


def make_small_images():
    """Writes a pattern of a few texels and an opacity map with round holes."""
    palette = [(0.93, 0.76, 0.20), (0.16, 0.32, 0.58), (0.80, 0.25, 0.18), (0.92, 0.90, 0.84)]
    write_png(IMAGES / "quilt.png",
              [[palette[(x * y + x // 2 + y // 3) % 4] for x in range(8)] for y in range(8)])

    def bump(x, y):
        return 0.5 - 0.25 * (math.cos(math.pi * x / 16) + math.cos(math.pi * y / 16))

    write_png(IMAGES / "bumps.png", [[(bump(x + 0.5, y + 0.5),) * 3 for x in range(32)] for y in range(32)])

    def hill(x, y):
        fade = math.sin(math.pi * x / 64) * math.sin(math.pi * y / 64)
        waves = math.sin(0.21 * x + 0.4) * math.cos(0.17 * y) + math.sin(0.31 * y + 0.12 * x)
        return (fade * (0.5 + 0.25 * waves))**0.45

    write_png(IMAGES / "hills.png", [[(hill(x + 0.5, y + 0.5),) * 3 for x in range(64)] for y in range(64)])

    def hole(x, y):
        r = math.hypot(x % 16 - 7.5, y % 16 - 7.5)
        return min(max((r - 5.0) / 1.5, 0.0), 1.0)

    write_png(IMAGES / "holes.png", [[(hole(x, y),) * 3 for x in range(64)] for y in range(64)])


def studio(back=-4.0, size=12.0, top=7.0):
    """A gray backdrop, a large soft light at height `top`, a smaller one from the left, and dim ambient light."""
    return f"""  <emitter type="constant">
    <rgb name="radiance" value="0.35, 0.37, 0.40"/>
  </emitter>
  <bsdf type="twosided" id="sweep">
    <bsdf type="diffuse"><rgb name="reflectance" value="0.45, 0.45, 0.46"/></bsdf>
  </bsdf>
  <shape type="rectangle">
    <transform name="to_world">
      <scale value="{size}"/>
      <rotate x="1" angle="-90"/>
    </transform>
    <ref id="sweep"/>
  </shape>
  <shape type="rectangle">
    <transform name="to_world">
      <scale value="{size}"/>
      <translate z="{back}"/>
    </transform>
    <ref id="sweep"/>
  </shape>
  <shape type="rectangle">
    <transform name="to_world">
      <scale x="3.5" y="1.5"/>
      <rotate x="1" angle="78"/>
      <translate y="{top}" z="3"/>
    </transform>
    <emitter type="area"><rgb name="radiance" value="7, 6.8, 6.4"/></emitter>
  </shape>
  <shape type="rectangle">
    <transform name="to_world">
      <scale x="0.8" y="1.6"/>
      <rotate y="1" angle="60"/>
      <translate x="-8" y="3.5" z="5"/>
    </transform>
    <emitter type="area"><rgb name="radiance" value="9, 10, 12"/></emitter>
  </shape>
"""


def wall_labels():
    return [("without a normal map", 0.05, 0.95, "box"), ("with its normal map", 0.55, 0.95, "box")]


def filter_labels():
    return [(text, 0.125 + 0.25 * i, 0.955, "centre")
            for i, text in enumerate(["nearest, repeat", "bilinear, repeat", "bilinear, mirror", "bilinear, clamp"])]


def make_wall():
    """A brick wall without (left) and with (right) its normal map, lit from the upper left. In this dialect the first
    row of a texture is at v = 0, so to_uv flips it."""
    def half(x, bsdf):
        return f"""  <shape type="rectangle">
    <transform name="to_world">
      <translate x="{x}"/>
    </transform>
{bsdf}  </shape>
"""
    diffuse = """<bsdf type="diffuse">
        <texture name="reflectance" type="bitmap">
          <string name="filename" value="images/bricks.png"/>
          <transform name="to_uv"><scale x="1" y="-1"/></transform>
        </texture>
      </bsdf>"""
    mapped = f"""    <bsdf type="normalmap">
      <texture name="normalmap" type="bitmap">
        <string name="filename" value="images/bricks_normal.png"/>
        <boolean name="raw" value="true"/>
        <transform name="to_uv"><scale x="1" y="-1"/></transform>
      </texture>
      {diffuse}
    </bsdf>
"""
    light = """  <shape type="sphere">
    <point name="center" x="-3.6" y="2.4" z="1.5"/>
    <float name="radius" value="0.25"/>
    <emitter type="area"><rgb name="radiance" value="340, 318, 284"/></emitter>
  </shape>
  <emitter type="constant"><rgb name="radiance" value="0.08, 0.09, 0.11"/></emitter>
"""
    write_scene(TEXTURES / "wall.xml", "A brick wall without (left) and with (right) its normal map.", SCRIPT,
                sensor("0, 0, 5", "0, 0, 0", 44.5, 1080, 536), light, half(-1.02, f"      {diffuse}\n"),
                half(1.02, mapped))


def make_filters():
    """A small texture on cubes: nearest and bilinear; repeated, mirrored and clamped; and a sheet with holes."""
    parts = []
    for i, (filtering, wrap) in enumerate([("nearest", "repeat"), ("bilinear", "repeat"), ("bilinear", "mirror"),
                                           ("bilinear", "clamp")]):
        parts.append(f"""  <shape type="cube">
    <transform name="to_world">
      <scale value="0.55"/>
      <rotate y="1" angle="{28 - 6 * i}"/>
      <translate x="{-2.55 + 1.7 * i:g}" y="0.55"/>
    </transform>
    <bsdf type="diffuse">
      <texture name="reflectance" type="bitmap">
        <string name="filename" value="images/quilt.png"/>
        <string name="filter_type" value="{filtering}"/>
        <string name="wrap_mode" value="{wrap}"/>
        <transform name="to_uv"><scale x="{1 if i < 2 else 2}" y="{1 if i < 2 else 2}"/></transform>
      </texture>
    </bsdf>
  </shape>
""")
    parts.append("""  <shape type="rectangle">
    <transform name="to_world">
      <scale x="1.6" y="0.7"/>
      <translate y="2.05" z="-0.7"/>
    </transform>
    <bsdf type="mask">
      <texture name="opacity" type="bitmap">
        <string name="filename" value="images/holes.png"/>
        <boolean name="raw" value="true"/>
        <transform name="to_uv"><scale x="2" y="1"/></transform>
      </texture>
      <bsdf type="twosided">
        <bsdf type="roughconductor"><string name="material" value="Cu"/><float name="alpha" value="0.25"/></bsdf>
      </bsdf>
    </bsdf>
  </shape>
""")
    write_scene(TEXTURES / "filters.xml",
                "A small texture: nearest, bilinear, mirrored and clamped; above, a copper sheet with holes.", SCRIPT,
                sensor("0, 2.3, 7.5", "0, 1.14, 0", 50.5, 1080, 540), studio(-3, 16), *parts)


def main():
    make_bricks()
    make_small_images()
    make_wall()
    make_filters()


if __name__ == "__main__":
    main()
