#!/usr/bin/env python3
"""Writes the example scenes in scenes/materials and scenes/textures with their textures. Needs only Python; the output
is deterministic."""

import math
import struct
import zlib
from pathlib import Path

from scene_text import camera

ROOT = Path(__file__).resolve().parent.parent
MATERIALS = ROOT / "scenes" / "materials"
TEXTURES = ROOT / "scenes" / "textures"
IMAGES = TEXTURES / "images"


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
    """Writes the colour texture and the normal map of a brick wall."""
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

    def hole(x, y):
        r = math.hypot(x % 16 - 7.5, y % 16 - 7.5)
        return min(max((r - 5.0) / 1.5, 0.0), 1.0)

    write_png(IMAGES / "holes.png", [[(hole(x, y),) * 3 for x in range(64)] for y in range(64)])


def sensor(origin, target, fov, width, height):
    return """  <default name="spp" value="256"/>
  <integrator type="path"/>
""" + camera(origin, target, fov, width, height)


def studio(back=-4.0, size=12.0, top=7.0):
    """A grey backdrop, a large soft light at height `top`, a smaller one from the left, and dim ambient light."""
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


def ball(x, y, z, radius, bsdf):
    return f"""  <shape type="sphere">
    <point name="center" x="{x:g}" y="{y:g}" z="{z:g}"/>
    <float name="radius" value="{radius:g}"/>
{bsdf}  </shape>
"""


def write_scene(path, title, *parts):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f'<?xml version="1.0" encoding="utf-8"?>\n<!-- {title} Written by tools/make_gallery.py. -->\n'
                    '<scene version="3.0.0">\n' + "".join(parts) + "</scene>\n")


def parameter_rows(bsdf_type, base, rows, title, path):
    """One row of 5 balls per parameter, from 0 (left) to 1 (right)."""
    parts = []
    for r, (name, extra) in enumerate(rows):
        for i in range(5):
            values = dict(base) | dict(extra) | {name: 0.25 * i}
            floats = "".join(f'      <float name="{k}" value="{v:g}"/>\n'
                             for k, v in values.items() if k != "base_color")
            bsdf = (f'    <bsdf type="{bsdf_type}">\n'
                    f'      <rgb name="base_color" value="{values["base_color"]}"/>\n{floats}    </bsdf>\n')
            parts.append(ball(-2 + i, 0.45 + 0.95 * (len(rows) - 1 - r), 0, 0.43, bsdf))
    height = 0.95 * len(rows)
    view = sensor(f"0, {height / 2 + 0.6:g}, {9 + 1.15 * len(rows):g}", f"0, {height / 2:g}, 0", 26, 480,
                  int(96 * len(rows) + 60))
    write_scene(path, title, view, studio(-1.2, 24, height + 7), *parts)


PARAMETER_ROWS = [
    ("metallic", {"roughness": 0.3}),
    ("roughness", {"metallic": 1}),
    ("specular", {"roughness": 0.2}),
    ("spec_tint", {"roughness": 0.2, "specular": 1}),
    ("anisotropic", {"metallic": 1, "roughness": 0.45}),
    ("sheen", {"roughness": 1}),
    ("sheen_tint", {"roughness": 1, "sheen": 1}),
    ("clearcoat", {"roughness": 0.7, "clearcoat_gloss": 0.9}),
    ("clearcoat_gloss", {"roughness": 0.7, "clearcoat": 1}),
]


def make_parameter_rows():
    base = {"base_color": "0.75, 0.16, 0.10"}
    parameter_rows("principled", base, PARAMETER_ROWS + [("spec_trans", {"roughness": 0.05})],
                   "Principled BSDF: one row of balls per parameter, from 0 (left) to 1 (right).",
                   MATERIALS / "principled.xml")


NORI_ROWS = [
    ("metallic", {"roughness": 0.3}), ("subsurface", {"roughness": 0.8}), ("specular", {"roughness": 0.2}),
    ("specularTint", {"roughness": 0.2, "specular": 1}), ("roughness", {"metallic": 1}),
    ("sheen", {"roughness": 1}), ("sheenTint", {"roughness": 1, "sheen": 1}),
    ("clearcoat", {"roughness": 0.7}), ("clearcoatGloss", {"roughness": 0.7, "clearcoat": 1}),
]


def make_disney_rows():
    """The same for the BRDF of Burley (2012), in the Nori dialect, which only has meshes and spheres."""
    parts = []
    for r, (name, extra) in enumerate(NORI_ROWS):
        for i in range(5):
            values = dict(extra) | {name: 0.25 * i}
            floats = "".join(f'      <float name="{k}" value="{v:g}"/>\n' for k, v in values.items())
            parts.append(f'''  <mesh type="sphere">
    <point name="center" value="{-2 + i:g}, {0.45 + 0.95 * (len(NORI_ROWS) - 1 - r):g}, 0"/>
    <float name="radius" value="0.43"/>
    <bsdf type="disney">
      <color name="baseColor" value="0.12, 0.35, 0.60"/>
{floats}    </bsdf>
  </mesh>
''')
    height = 0.95 * len(NORI_ROWS)
    light = '''  <mesh type="sphere">
    <point name="center" value="{0}"/>
    <float name="radius" value="{1}"/>
    <emitter type="area"><color name="radiance" value="{2}"/></emitter>
  </mesh>
'''
    path = MATERIALS / "disney.xml"
    path.write_text(f'''<?xml version="1.0" encoding="utf-8"?>
<!-- Disney BRDF in the Nori dialect: one row of balls per parameter, from 0 (left) to 1 (right). Written by
     tools/make_gallery.py. -->
<scene>
  <integrator type="path_mis"/>
  <sampler type="independent"><integer name="sampleCount" value="256"/></sampler>
  <camera type="perspective">
    <transform name="toWorld">
      <scale value="-1, 1, 1"/>
      <lookat origin="0, {height / 2 + 0.6:g}, 19" target="0, {height / 2:g}, 0" up="0, 1, 0"/>
    </transform>
    <float name="fov" value="26"/>
    <integer name="width" value="480"/>
    <integer name="height" value="920"/>
  </camera>
''' + light.format("-6, 14, 10", 3, "12, 12, 12") + light.format("9, 6, 12", 1.5, "10, 11, 13") + "".join(parts) +
                    "</scene>\n")


def make_material_balls():
    """One ball per material type."""
    def simple(kind, inner=""):
        return f'    <bsdf type="{kind}">\n{inner}    </bsdf>\n'

    def rgb(name, value):
        return f'      <rgb name="{name}" value="{value}"/>\n'

    def number(name, value):
        return f'      <float name="{name}" value="{value}"/>\n'

    def string(name, value):
        return f'      <string name="{name}" value="{value}"/>\n'

    def nested(kind, inner=""):
        return f'      <bsdf type="{kind}">{inner.strip()}</bsdf>\n'

    kinds = [
        simple("diffuse", rgb("reflectance", "0.2, 0.5, 0.3")),
        simple("plastic", rgb("diffuse_reflectance", "0.6, 0.1, 0.08")),
        simple("roughplastic", rgb("diffuse_reflectance", "0.6, 0.1, 0.08") + number("alpha", 0.2)),
        simple("conductor", string("material", "Ag")),
        simple("roughconductor", string("material", "Au") + number("alpha", 0.15) + string("distribution", "ggx")),
        simple("roughconductor", string("material", "Cu") + number("alpha_u", 0.4) + number("alpha_v", 0.05)),
        simple("dielectric", string("int_ior", "bk7")),
        simple("thindielectric", string("int_ior", "bk7")),
        simple("roughdielectric", number("alpha", 0.2) + string("distribution", "ggx")),
        simple("principled", rgb("base_color", "0.1, 0.25, 0.6") + number("roughness", 0.4) + number("clearcoat", 1)),
        simple("principledthin", rgb("base_color", "0.7, 0.6, 0.2") + number("diff_trans", 1.2)),
        simple("blendbsdf", number("weight", 0.5) + nested("conductor", string("material", "Al")) +
               nested("diffuse", rgb("reflectance", "0.7, 0.3, 0.1"))),
        simple("mask", number("opacity", 0.5) + nested("twosided", '<bsdf type="diffuse"/>')),
        simple("twosided", nested("plastic") + nested("diffuse")),
    ]
    parts = [ball(-3 + i % 7, 0.42 + (0.9 if i < 7 else 0), 0 if i >= 7 else -0.9, 0.42, k)
             for i, k in enumerate(kinds)]
    write_scene(MATERIALS / "balls.xml", "One ball per material type.",
                sensor("0, 3.0, 8.5", "0, 0.75, -0.3", 42, 800, 320), studio(-4, 20), *parts)


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
    <point name="center" x="-3.5" y="2.2" z="1.2"/>
    <float name="radius" value="0.25"/>
    <emitter type="area"><rgb name="radiance" value="120, 112, 100"/></emitter>
  </shape>
  <emitter type="constant"><rgb name="radiance" value="0.08, 0.09, 0.11"/></emitter>
"""
    write_scene(TEXTURES / "wall.xml", "A brick wall without (left) and with (right) its normal map.",
                sensor("0.4, 0.3, 4.4", "0.1, 0, 0", 54, 640, 340), light, half(-1.02, f"      {diffuse}\n"),
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
                "A small texture: nearest, bilinear, mirrored and clamped; above, a copper sheet with holes.",
                sensor("0, 2.6, 7.5", "0, 1.2, 0", 52, 720, 360), studio(-3, 16), *parts)


def main():
    make_bricks()
    make_small_images()
    MATERIALS.mkdir(parents=True, exist_ok=True)
    make_parameter_rows()
    make_disney_rows()
    make_material_balls()
    make_wall()
    make_filters()


if __name__ == "__main__":
    main()
