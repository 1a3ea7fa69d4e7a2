#!/usr/bin/env python3
"""Writes the example scenes in scenes/materials except measured.xml. Needs only Python; the output is deterministic."""

import math
import re
from pathlib import Path

from scene_text import sensor, write_scene

ROOT = Path(__file__).resolve().parents[2]
MATERIALS = ROOT / "scenes" / "materials"
SCRIPT = "make_material_scenes.py"


class FrontView:
    """A camera that looks along -z at the rectangle from (x0, y0) to (x1, y1) of the plane z = 0."""
    FOV = 20

    def __init__(self, x0, y0, x1, y1, width):
        self.x0, self.y1, self.size = x0, y1, (x1 - x0, y1 - y0)
        self.center = ((x0 + x1) / 2, (y0 + y1) / 2)
        self.distance = self.size[0] / 2 / math.tan(math.radians(self.FOV / 2))
        self.width, self.height = width, 2 * round(width * self.size[1] / self.size[0] / 2)

    def sensor(self, spp=128):
        x, y = self.center
        return sensor(f"{x:g}, {y:g}, {self.distance:.4f}", f"{x:g}, {y:g}, 0", self.FOV, self.width, self.height, spp)

    def place(self, x, y, z=0):
        """The point of the image, in [0, 1]^2 from the upper left corner, that shows a point."""
        scale = self.distance / (self.distance - z)
        return (0.5 + (x - self.center[0]) * scale / self.size[0], 0.5 - (y - self.center[1]) * scale / self.size[1])


def ball(x, y, z, radius, bsdf):
    """A sphere. Its poles are on the z axis; the rotation turns them up."""
    return f"""  <shape type="sphere">
    <transform name="to_world">
      <scale value="{radius:g}"/> <rotate x="1" angle="-90"/> <translate x="{x:g}" y="{y:g}" z="{z:g}"/>
    </transform>
{bsdf}  </shape>
"""


# Strips of balls, one per parameter, in two columns: radius, distance of the balls, height of a strip with its label,
# and width of a column.
RADIUS, PITCH, STRIP, COLUMN = 0.46, 1.0, 1.34, 5.4
STEPS = [0, 0.25, 0.5, 0.75, 1]


def strip_place(i, rows):
    """The first ball of strip `i`: the first half of the strips is in the left column."""
    half = -(-rows // 2)
    return COLUMN * (i // half), STRIP * (half - 1 - i % half)


def strip_view(rows, width=1440):
    """The view of all strips, with room for labels."""
    half = -(-rows // 2)
    return FrontView(-0.8, -0.72, COLUMN + 4.8, STRIP * (half - 1) + 1.1, width)


def strip_labels(rows):
    """[(text, x, y, anchor)] of the names above the strips, and of the values above the columns. x and y are places in
    the image, `anchor` is "left" or "centre"."""
    view, labels = strip_view(len(rows)), []
    for i, (name, _) in enumerate(rows):
        x, y = strip_place(i, len(rows))
        labels.append((re.sub(r"([a-z])([A-Z])", r"\1 \2", name).replace("_", " ").lower(),
                       *view.place(x - RADIUS, y + 0.64), "left"))
        if y == strip_place(0, len(rows))[1]:
            labels += [(f"{value:g}", *view.place(x + PITCH * k, y + 0.9), "centre") for k, value in enumerate(STEPS)]
    return labels


def front_lights():
    """A bright wall of faint squares far behind, a soft light from the front, and a rim light from above and behind."""
    return """  <emitter type="constant">
    <rgb name="radiance" value="0.42, 0.43, 0.45"/>
  </emitter>
  <shape type="rectangle">
    <transform name="to_world">
      <scale value="60"/>
      <translate x="4.6" y="2.7" z="-60"/>
    </transform>
    <emitter type="area">
      <texture name="radiance" type="checkerboard">
        <rgb name="color0" value="0.50, 0.51, 0.53"/><rgb name="color1" value="0.56, 0.57, 0.58"/>
        <transform name="to_uv"><scale x="40" y="40"/></transform>
      </texture>
    </emitter>
  </shape>
  <shape type="rectangle">
    <transform name="to_world">
      <scale x="9" y="6"/>
      <lookat origin="-12, 26, 24" target="4, 2, 0" up="0, 1, 0"/>
    </transform>
    <emitter type="area"><rgb name="radiance" value="10, 9.7, 9.2"/></emitter>
  </shape>
  <shape type="rectangle">
    <transform name="to_world">
      <scale x="24" y="3.5"/>
      <lookat origin="4.6, 18, -42" target="4.6, 2.7, 0" up="0, 1, 0"/>
    </transform>
    <emitter type="area"><rgb name="radiance" value="34, 35, 36"/></emitter>
  </shape>
"""


# Lamps that light the balls of some strips, each one ball: the half width of its cone in degrees; and the beginning of the
# names of the strips, where the lamps stand relative to a ball, and their intensity.
LAMP_CONE = 2.6
LAMPS = [("sheen", [(-5, 6.5, -5.7), (5, 6.5, -5.7)], 700), ("clearcoat", [(-4.5, 5.5, 7)], 900)]


def strip_lamps(rows):
    """[(position, target, intensity)] of the lamps of all strips."""
    lamps = []
    for r, (name, _) in enumerate(rows):
        x, y = strip_place(r, len(rows))
        for prefix, offsets, intensity in LAMPS:
            if name.startswith(prefix):
                lamps += [((x + PITCH * i + dx, y + dy, dz), (x + PITCH * i, y, 0), intensity)
                          for i in range(len(STEPS)) for dx, dy, dz in offsets]
    return lamps


DARK_RED = "0.02, 0.004, 0.003"
PARAMETER_ROWS = [
    ("metallic", {"roughness": 0.3}),
    ("roughness", {"metallic": 1}),
    ("specular", {"roughness": 0.2}),
    ("spec_tint", {"roughness": 0.2, "specular": 1}),
    ("anisotropic", {"metallic": 1, "roughness": 0.45}),
    ("sheen", {"roughness": 1, "specular": 0, "base_color": DARK_RED}),
    ("sheen_tint", {"roughness": 1, "specular": 0, "sheen": 1, "base_color": DARK_RED}),
    ("clearcoat", {"roughness": 1, "specular": 0, "clearcoat_gloss": 0.4, "base_color": DARK_RED}),
    ("clearcoat_gloss", {"roughness": 1, "specular": 0, "clearcoat": 1, "base_color": DARK_RED}),
    ("spec_trans", {"roughness": 0.05}),
]


def vector(values):
    return ", ".join(f"{value:g}" for value in values)


def make_parameter_rows():
    """Strips of the principled BSDF."""
    view, parts = strip_view(len(PARAMETER_ROWS)), []
    for r, (name, extra) in enumerate(PARAMETER_ROWS):
        x, y = strip_place(r, len(PARAMETER_ROWS))
        for i, value in enumerate(STEPS):
            values = {"base_color": "0.75, 0.16, 0.10"} | extra | {name: value}
            floats = "".join(f'      <float name="{k}" value="{v:g}"/>\n'
                             for k, v in values.items() if k != "base_color")
            bsdf = (f'    <bsdf type="principled">\n'
                    f'      <rgb name="base_color" value="{values["base_color"]}"/>\n{floats}    </bsdf>\n')
            parts.append(ball(x + PITCH * i, y, 0, RADIUS, bsdf))
    for position, target, intensity in strip_lamps(PARAMETER_ROWS):
        parts.append(f"""  <emitter type="spot">
    <transform name="to_world"><lookat origin="{vector(position)}" target="{vector(target)}" up="0, 0, 1"/></transform>
    <rgb name="intensity" value="{intensity}"/>
    <float name="cutoff_angle" value="{LAMP_CONE}"/> <float name="beam_width" value="{LAMP_CONE}"/>
  </emitter>
""")
    write_scene(MATERIALS / "principled.xml",
                "Principled BSDF: a strip of balls per parameter, from 0 (left) to 1 (right).",
                SCRIPT, view.sensor(), front_lights(), *parts)


NORI_ROWS = [
    ("metallic", {"roughness": 0.3}), ("subsurface", {"roughness": 0.8}), ("specular", {"roughness": 0.2}),
    ("specularTint", {"roughness": 0.2, "specular": 1}), ("roughness", {"metallic": 1}),
    ("anisotropic", {"metallic": 1, "roughness": 0.45}), ("sheen", {"roughness": 1, "specular": 0, "dark": 1}),
    ("sheenTint", {"roughness": 1, "specular": 0, "sheen": 1, "dark": 1}),
    ("clearcoat", {"roughness": 1, "specular": 0, "clearcoatGloss": 0.4, "dark": 1}),
    ("clearcoatGloss", {"roughness": 1, "specular": 0, "clearcoat": 1, "dark": 1}),
]


def make_disney_rows():
    """The same for the BRDF of Burley (2012), in the Nori dialect, which only has meshes and spheres."""
    view, parts = strip_view(len(NORI_ROWS)), []
    for r, (name, extra) in enumerate(NORI_ROWS):
        x, y = strip_place(r, len(NORI_ROWS))
        for i, value in enumerate(STEPS):
            values = extra | {name: value}
            color = "0.004, 0.01, 0.03" if values.pop("dark", 0) else "0.12, 0.35, 0.60"
            floats = "".join(f'      <float name="{k}" value="{v:g}"/>\n' for k, v in values.items())
            parts.append(f'''  <mesh type="sphere">
    <point name="center" value="{x + PITCH * i:g}, {y:g}, 0"/>
    <float name="radius" value="{RADIUS}"/>
    <bsdf type="disney">
      <color name="baseColor" value="{color}"/>
{floats}    </bsdf>
  </mesh>
''')
    for position, target, intensity in strip_lamps(NORI_ROWS):
        parts.append(f'''  <emitter type="spot">
    <point name="position" value="{vector(position)}"/> <point name="lookAt" value="{vector(target)}"/>
    <color name="intensity" value="{vector([intensity] * 3)}"/>
    <float name="totalWidth" value="{LAMP_CONE}"/> <float name="falloffStart" value="{LAMP_CONE}"/>
  </emitter>
''')
    light = '''  <mesh type="sphere">
    <point name="center" value="{0}"/>
    <float name="radius" value="{1}"/>
    <emitter type="area"><color name="radiance" value="{2}"/></emitter>
  </mesh>
'''
    (x, y), lights = view.center, [light.format("-12, 26, 24", 6, "19, 18.4, 17.5"),
                                   light.format("4.6, 20, -42", 6, "34, 35, 36")]
    path = MATERIALS / "disney.xml"
    path.write_text(f'''<?xml version="1.0" encoding="utf-8"?>
<!-- Disney BRDF in the Nori dialect: a strip of balls per parameter, from 0 (left) to 1 (right). Written by
     scenes/make/make_material_scenes.py. -->
<scene>
  <integrator type="path_mis"/>
  <sampler type="independent"><integer name="sampleCount" value="128"/></sampler>
  <camera type="perspective">
    <transform name="toWorld">
      <scale value="-1, 1, 1"/>
      <lookat origin="{x:g}, {y:g}, {view.distance:.4f}" target="{x:g}, {y:g}, 0" up="0, 1, 0"/>
    </transform>
    <float name="fov" value="{FrontView.FOV}"/>
    <integer name="width" value="{view.width}"/>
    <integer name="height" value="{view.height}"/>
    <rfilter type="gaussian"/>
  </camera>
  <emitter type="constant"><color name="radiance" value="0.52, 0.53, 0.55"/></emitter>
''' + "".join(lights + parts) + "</scene>\n")


# Shelves of balls, one per material: columns, distance of the shelves, and their half depth and thickness.
COLUMNS, SHELF, DEPTH, BOARD = 7, 1.38, 0.6, 0.3


def rgb(name, value):
    return f'      <rgb name="{name}" value="{value}"/>\n'


def number(name, value):
    return f'      <float name="{name}" value="{value}"/>\n'


def string(name, value):
    return f'      <string name="{name}" value="{value}"/>\n'


def bsdf(kind, inner=""):
    return f'    <bsdf type="{kind}">\n{inner}    </bsdf>\n'


def nested(kind, inner=""):
    return f'      <bsdf type="{kind}">{inner.strip()}</bsdf>\n'


def material_kinds():
    """[(label, BSDF)] of all balls."""
    red, checks = rgb("diffuse_reflectance", "0.6, 0.1, 0.08"), '''      <texture name="{}" type="checkerboard">
        {} name="color0" value="{}"/>{} name="color1" value="{}"/>
        <transform name="to_uv"><scale x="12" y="6"/></transform>
      </texture>
'''
    gold, ggx = string("material", "Au"), string("distribution", "ggx")
    waves = '''      <texture type="bitmap"><string name="filename" value="../textures/images/bumps.png"/>
        <boolean name="raw" value="true"/><transform name="to_uv"><scale x="12" y="6"/></transform></texture>
      <float name="scale" value="0.25"/>
'''
    bricks = '''      <texture name="normalmap" type="bitmap">
        <string name="filename" value="../textures/images/bricks_normal.png"/>
        <boolean name="raw" value="true"/><transform name="to_uv"><scale x="3" y="-2"/></transform></texture>
'''
    return [
        ("diffuse", bsdf("diffuse", rgb("reflectance", "0.2, 0.5, 0.3"))),
        ("Oren-Nayar", bsdf("roughdiffuse", rgb("reflectance", "0.2, 0.5, 0.3") + number("alpha", 0.7))),
        ("Phong", bsdf("phong", red + number("exponent", 60))),
        ("Ward", bsdf("ward", red + number("alpha_u", 0.08) + number("alpha_v", 0.35))),
        ("plastic", bsdf("plastic", red)),
        ("rough plastic", bsdf("roughplastic", red + number("alpha", 0.2))),
        ("coated copper", bsdf("coating", rgb("sigma_a", "0.1, 0.5, 1.2") +
                               nested("roughconductor", string("material", "Cu") + number("alpha", 0.3)))),
        ("silver", bsdf("conductor", string("material", "Ag"))),
        ("rough gold", bsdf("roughconductor", gold + number("alpha", 0.2) + ggx)),
        ("anisotropic copper",
         bsdf("roughconductor", string("material", "Cu") + number("alpha_u", 0.4) + number("alpha_v", 0.06))),
        ("glass", bsdf("dielectric", string("int_ior", "bk7"))),
        ("thin glass", bsdf("thindielectric", string("int_ior", "bk7"))),
        ("rough glass", bsdf("roughdielectric", number("alpha", 0.2) + ggx)),
        ("diffuse transmission", bsdf("difftrans", rgb("transmittance", "0.75, 0.72, 0.5"))),
        ("principled, clearcoat",
         bsdf("principled", rgb("base_color", "0.1, 0.25, 0.6") + number("roughness", 0.4) + number("clearcoat", 1))),
        ("principled, thin", bsdf("principledthin", rgb("base_color", "0.7, 0.6, 0.2") + number("diff_trans", 1.2))),
        ("blend", bsdf("blendbsdf", checks.format("weight", "<float", 0, "<float", 1) + nested("conductor", gold) +
                       nested("diffuse", rgb("reflectance", "0.08, 0.12, 0.25")))),
        ("mask", bsdf("mask", checks.format("opacity", "<float", 0, "<float", 1) +
                      nested("twosided", '<bsdf type="diffuse"/>'))),
        ("mask, two-sided", bsdf("mask", checks.format("opacity", "<float", 0, "<float", 1) +
                                 nested("twosided", nested("roughplastic", red) +
                                        nested("diffuse", rgb("reflectance", "0.1, 0.3, 0.7"))))),
        ("bump map", bsdf("bumpmap", waves + nested("roughplastic", rgb("diffuse_reflectance", "0.5, 0.4, 0.2")))),
        ("normal map", bsdf("normalmap", bricks + nested("roughconductor", string("material", "Ag") +
                                                         number("alpha", 0.25)))),
    ]


def ball_view(rows=3):
    return FrontView(-0.62, -SHELF * (rows - 1) - 0.46 - BOARD, 1.06 * (COLUMNS - 1) + 0.62, 0.64, 1440)


def ball_labels():
    """The names of the materials on the front of the shelves; see strip_labels()."""
    view, labels = ball_view(), []
    for i, (label, _) in enumerate(material_kinds()):
        x, _ = view.place(1.06 * (i % COLUMNS), 0)
        _, y = view.place(0, -SHELF * (i // COLUMNS) - 0.44 - BOARD / 2, DEPTH)
        labels.append((label, x, y, "centre"))
    return labels


def make_material_balls():
    """One ball per material type, on shelves."""
    parts = ["""  <emitter type="constant">
    <rgb name="radiance" value="0.34, 0.35, 0.37"/>
  </emitter>
  <shape type="rectangle">
    <transform name="to_world"><scale x="24" y="24"/><translate z="-0.62"/></transform>
    <bsdf type="diffuse">
      <texture name="reflectance" type="checkerboard">
        <rgb name="color0" value="0.62, 0.61, 0.58"/><rgb name="color1" value="0.42, 0.42, 0.43"/>
        <transform name="to_uv"><scale x="80" y="80"/></transform>
      </texture>
    </bsdf>
  </shape>
  <shape type="rectangle">
    <transform name="to_world">
      <scale x="6" y="2.5"/>
      <lookat origin="-1, 7, 16" target="3, -1.5, 0" up="0, 1, 0"/>
    </transform>
    <emitter type="area"><rgb name="radiance" value="9, 8.8, 8.4"/></emitter>
  </shape>
  <shape type="rectangle">
    <transform name="to_world">
      <scale x="1" y="4"/>
      <lookat origin="16, 0, 7" target="3, -1.5, 0" up="0, 1, 0"/>
    </transform>
    <emitter type="area"><rgb name="radiance" value="8, 8.8, 10"/></emitter>
  </shape>
  <bsdf type="roughplastic" id="board">
    <rgb name="diffuse_reflectance" value="0.72, 0.72, 0.70"/><float name="alpha" value="0.3"/>
  </bsdf>
"""]
    kinds = material_kinds()
    for row in range(len(kinds) // COLUMNS):
        parts.append(f"""  <shape type="cube">
    <transform name="to_world">
      <scale x="8" y="{BOARD / 2}" z="{DEPTH}"/>
      <translate x="3" y="{-SHELF * row - 0.44 - BOARD / 2:g}"/>
    </transform>
    <ref id="board"/>
  </shape>
""")
    parts += [ball(1.06 * (i % COLUMNS), -SHELF * (i // COLUMNS), 0, 0.44, text) for i, (_, text) in enumerate(kinds)]
    write_scene(MATERIALS / "balls.xml", "One ball per material type.", SCRIPT, ball_view().sensor(192), *parts)


def main():
    MATERIALS.mkdir(parents=True, exist_ok=True)
    make_parameter_rows()
    make_disney_rows()
    make_material_balls()


if __name__ == "__main__":
    main()
