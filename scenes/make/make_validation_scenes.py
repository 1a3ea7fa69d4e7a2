#!/usr/bin/env python3
"""Writes the assets and the longer scenes of scenes/validation: meshes, images, principled.xml, many_lights.xml,
instances.xml and textures.xml, and the cloud (scenes/validation/generated, by make_cloud) as an .nvdb file and as its
.vol twin. Needs only Python and a build; the output is deterministic.

  scenes/make/make_validation_scenes.py [--make-cloud PROGRAM] [--grids-only | --no-grids]
"""

import argparse
import math
import subprocess
from pathlib import Path

from make_texture_scenes import noise, write_png
from make_media_scenes import find_make_cloud

FOLDER = Path(__file__).resolve().parents[2] / "scenes" / "validation"
PARAMETERS = [  # of the principled BSDF, from 0 to 1 in each strip, with the values of the other parameters
    ("metallic", {"roughness": 0.3}),
    ("roughness", {"metallic": 1}),
    ("specular", {"roughness": 0.2}),
    ("spec_tint", {"roughness": 0.2, "specular": 1}),
    ("anisotropic", {"metallic": 1, "roughness": 0.45}),
    ("sheen", {"roughness": 1, "base_color": "0.04, 0.03, 0.12"}),
    ("sheen_tint", {"roughness": 1, "sheen": 1, "base_color": "0.04, 0.03, 0.12"}),
    ("clearcoat", {"roughness": 0.7, "clearcoat_gloss": 0.9}),
    ("clearcoat_gloss", {"roughness": 0.7, "clearcoat": 1}),
    ("flatness", {"roughness": 0.9}),
    ("spec_trans", {"roughness": 0.2}),
]
BALLS = 6  # per strip


def scene(comment, depth, sensor, *parts):
    """Returns a scene file; `sensor` is the result of film() and a camera."""
    return f"""<?xml version="1.0" encoding="utf-8"?>
<!-- {comment} Written by scenes/make/make_validation_scenes.py. -->
<scene version="3.0.0">
  <default name="spp" value="64"/>
  <integrator type="path"> <integer name="max_depth" value="{depth}"/> </integrator>
{sensor}{"".join(parts)}</scene>
"""


def camera(kind, place, width, height, fov=""):
    return f"""  <sensor type="{kind}">
    <transform name="to_world"> {place} </transform>
{fov}    <film type="hdrfilm">
      <integer name="width" value="{width}"/> <integer name="height" value="{height}"/> <rfilter type="box"/>
    </film>
    <sampler type="independent"> <integer name="sample_count" value="$spp"/> </sampler>
  </sensor>
"""


def perspective(origin, target, fov, width=320, height=240):
    return camera("perspective", f'<lookat origin="{origin}" target="{target}" up="0, 1, 0"/>', width, height,
                  f'    <float name="fov" value="{fov}"/>\n')


def rectangle(transform, bsdf):
    return f"""  <shape type="rectangle">
    <transform name="to_world"> {transform} </transform>
    {bsdf}
  </shape>
"""


def diffuse(color):
    return f'<bsdf type="diffuse"> <rgb name="reflectance" value="{color}"/> </bsdf>'


def emitter(radiance):
    return f'<emitter type="area"> <rgb name="radiance" value="{radiance}"/> </emitter>'


def sphere(center, radius, content):
    return f"""  <shape type="sphere">
    <point name="center" value="{center}"/> <float name="radius" value="{radius:g}"/>
    {content}
  </shape>
"""


def constant(radiance):
    return f'  <emitter type="constant"> <rgb name="radiance" value="{radiance}"/> </emitter>\n'


def make_principled():
    """A strip of balls per parameter, seen by an orthographic camera, so that strips are equal bands of the image."""
    strips = len(PARAMETERS)
    width, height = 56 * BALLS, 56 * strips
    parts = [rectangle('<scale x="20" y="20"/> <translate z="-1.2"/>', """<bsdf type="diffuse">
      <texture type="checkerboard" name="reflectance">
        <rgb name="color0" value="0.35"/> <rgb name="color1" value="0.2"/>
        <transform name="to_uv"> <scale x="40" y="40"/> </transform>
      </texture>
    </bsdf>"""),
             rectangle('<scale x="5" y="4"/> <rotate x="1" angle="40"/> <rotate y="1" angle="-150"/> '
                       f'<translate x="-7" y="{strips / 2 + 6:g}" z="9"/>', emitter("7, 6.7, 6")),
             rectangle('<scale x="2" y="8"/> <rotate y="1" angle="-110"/> <translate x="8" z="4"/>',
                       emitter("3, 3.5, 4.5")),
             constant("0.3, 0.32, 0.35")]
    for row, (name, others) in enumerate(PARAMETERS):
        for i in range(BALLS):
            values = {"base_color": "0.75, 0.16, 0.10"} | others | {name: i / (BALLS - 1)}
            color = values.pop("base_color")
            floats = " ".join(f'<float name="{key}" value="{value:g}"/>' for key, value in values.items())
            center = f"{1.05 * (i - (BALLS - 1) / 2):g}, {1.05 * ((strips - 1) / 2 - row):g}, 0"
            parts.append(sphere(center, 0.45, f"""<bsdf type="principled">
      <rgb name="base_color" value="{color}"/> {floats}
    </bsdf>"""))
    side = 1.05 * BALLS / 2  # half of the width of the image
    place = f'<scale x="{side:g}" y="{side:g}"/> <lookat origin="0, 0, 20" target="0, 0, 0" up="0, 1, 0"/>'
    (FOLDER / "principled.xml").write_text(scene(
        "Strips of balls, one for each parameter of the principled BSDF, from 0 (left) to 1 (right).", 6,
        camera("orthographic", place, width, height), *parts))


def make_many_lights():
    """Small lamps of many colors and powers above a floor with pillars."""
    parts = [rectangle('<scale value="12"/> <rotate x="1" angle="-90"/>', diffuse("0.6, 0.6, 0.6")),
             rectangle('<scale x="12" y="3"/> <translate y="3" z="-6"/>', diffuse("0.5, 0.5, 0.5"))]
    for i in range(12):
        x, z = -5.5 + 2.2 * (i % 6) + 0.5 * noise(i, 1), -4 + 3.4 * (i // 6) + noise(i, 2)
        parts.append(f"""  <shape type="cube">
    <transform name="to_world"> <scale x="0.22" y="{0.6 + noise(i, 3):.3f}" z="0.22"/>
      <translate x="{x:.3f}" z="{z:.3f}"/> </transform>
    {diffuse("0.6, 0.55, 0.5")}
  </shape>
""")
    for i in range(240):
        x, y, z = -6 + 12 * noise(i, 11), 0.1 + 1.9 * noise(i, 12) ** 2, -5.5 + 7 * noise(i, 13)
        radius, hue = 0.02 + 0.05 * noise(i, 14) ** 3, 6 * noise(i, 15)
        power = 0.02 * 10 ** (1.2 * noise(i, 16)) / radius**2
        color = ", ".join(f"{power * (0.25 + max(0, min(1, abs((hue + k) % 6 - 3) - 1))):.4g}" for k in (0, 4, 2))
        parts.append(sphere(f"{x:.3f}, {y:.3f}, {z:.3f}", round(radius, 4), emitter(color)))
    (FOLDER / "many_lights.xml").write_text(scene("240 small lamps among pillars.", 3,
                                                  perspective("0, 2.6, 6.5", "0, 0.9, -1.5", 62), *parts))


def make_instances():
    """A group of a ball, a cube and a lamp, instanced with rotations, mirrored and stretched."""
    group = ['  <shape type="shapegroup" id="toy">\n', sphere("0, 0.5, 0", 0.3, diffuse("0.75, 0.3, 0.2")),
             f"""  <shape type="cube">
    <transform name="to_world">
      <scale x="0.35" y="0.1" z="0.2"/> <rotate z="1" angle="20"/> <translate x="0.1" y="0.15"/> </transform>
    <bsdf type="roughconductor">
      <float name="eta" value="1.2"/> <float name="k" value="3"/> <float name="alpha" value="0.3"/>
    </bsdf>
  </shape>
  <shape type="obj">
    <string name="filename" value="meshes/ball.obj"/>
    <transform name="to_world"> <scale value="0.14"/> <translate x="0.4" y="0.5"/> </transform>
    {diffuse("0.2, 0.4, 0.7")}
  </shape>
  </shape>
"""]
    parts = [rectangle('<scale value="6"/> <rotate x="1" angle="-90"/>', diffuse("0.55, 0.55, 0.5")),
             rectangle('<scale value="0.8"/> <rotate x="1" angle="90"/> <translate x="-2" y="4.5" z="2"/>',
                       emitter("14, 13, 11")), constant("0.35, 0.4, 0.5")]
    for i in range(35):
        x, z = -2.4 + 0.8 * (i % 7), -2.2 + 0.85 * (i // 7)
        size = 0.45 + 0.35 * noise(i, 21)
        mirror = -1 if i % 3 == 0 else 1
        parts.append(f"""  <shape type="instance">
    <ref id="toy"/>
    <transform name="to_world">
      <scale x="{mirror * size:.3f}" y="{size * (0.7 + 0.8 * noise(i, 22)):.3f}" z="{size:.3f}"/>
      <rotate y="1" angle="{360 * noise(i, 23):.1f}"/> <rotate x="1" angle="{30 * noise(i, 24) - 15:.1f}"/>
      <translate x="{x:.3f}" y="0.05" z="{z:.3f}"/>
    </transform>
  </shape>
""")
    (FOLDER / "instances.xml").write_text(scene(
        "35 instances of a group, turned, stretched, and every third one mirrored.", 5,
        perspective("0, 3, 5", "0, 0.1, -0.5", 50), *group, *parts))


def make_textures():
    """Panels with the filters and wrap modes of `bitmap`, and with scaled and offset texture coordinates."""
    rows = [[(0.15 + 0.8 * ((x ^ y) & 1), 0.1 + 0.1 * x, 0.1 + 0.1 * y) for x in range(8)] for y in range(8)]
    for x in range(4):
        rows[0][x] = (0.95, 0.9, 0.2)  # marks the corner and the first row
    write_png(FOLDER / "images" / "panel.png", rows)
    columns = [("repeat", '<scale x="1" y="1"/>'), ("repeat", '<scale x="3" y="2"/>'),
               ("clamp", '<scale x="2" y="2"/> <translate x="-0.5" y="-0.5"/>'),
               ("mirror", '<scale x="2" y="2"/> <rotate z="1" angle="20"/>')]
    parts = [constant("0.9, 0.9, 0.9")]
    for row, kind in enumerate(("nearest", "bilinear")):
        for column, (wrap, to_uv) in enumerate(columns):
            place = f'<scale value="0.47"/> <translate x="{column - 1.5:g}" y="{0.5 - row:g}"/>'
            parts.append(rectangle(place, f"""<bsdf type="diffuse">
      <texture type="bitmap" name="reflectance">
        <string name="filename" value="images/panel.png"/> <string name="filter_type" value="{kind}"/>
        <string name="wrap_mode" value="{wrap}"/> <transform name="to_uv"> {to_uv} </transform>
      </texture>
    </bsdf>"""))
    (FOLDER / "textures.xml").write_text(scene(
        "An image of 8 x 8 texels on panels. Above nearest, below bilinear. From left to right: once; repeated; "
        "clamped; mirrored and turned.", 2, perspective("0, 0, 4.6", "0, 0, 0", 48, 320, 180), *parts))


def make_normal_maps(size=128):
    """Rounded bumps with flat ground between them, with green upwards (OpenGL) and downwards (DirectX)."""
    def normal(x, y):
        u, v = 2 * ((x + 0.5) / size) % 1 - 0.5, 2 * (1 - (y + 0.5) / size) % 1 - 0.5
        r = math.hypot(u, v)
        slope = 1.1 * math.sin(math.pi * r / 0.36) if r < 0.36 else 0.0
        nx, ny = (slope * u / r, slope * v / r) if slope else (0.0, 0.0)
        length = math.sqrt(nx * nx + ny * ny + 1)
        return nx / length, ny / length, 1 / length

    rows = [[tuple(round(255 * (0.5 + 0.5 * n)) / 255 for n in normal(x, y)) for x in range(size)]
            for y in range(size)]
    write_png(FOLDER / "images" / "normals_opengl.png", rows)
    # The same normals after rounding: 0 is 128 in one map and 127 in the other.
    write_png(FOLDER / "images" / "normals_directx.png", [[(r, 1 - g, b) for r, g, b in row] for row in rows])


def make_balls(slices=32, stacks=16):
    """A ball with texture coordinates, and one whose texture coordinates are all equal."""
    for name, is_degenerate in (("ball", False), ("ball_degenerate", True)):
        lines, faces = ["# A ball, written by scenes/make/make_validation_scenes.py."], []
        for j in range(stacks + 1):
            for i in range(slices + 1):
                theta, phi = math.pi * j / stacks, 2 * math.pi * i / slices
                n = (math.sin(theta) * math.sin(phi), math.cos(theta), math.sin(theta) * math.cos(phi))
                lines.append("v {:.5f} {:.5f} {:.5f}".format(*n))
                lines.append("vn {:.5f} {:.5f} {:.5f}".format(*n))
                lines.append("vt 0 0" if is_degenerate else f"vt {4 * i / slices:.5f} {2 - 2 * j / stacks:.5f}")
        for j in range(stacks):
            for i in range(slices):
                a, b = j * (slices + 1) + i + 1, (j + 1) * (slices + 1) + i + 1
                corners = [(a, b, b + 1)] * (j < stacks - 1) + [(a, b + 1, a + 1)] * (j > 0)
                faces += ["f " + " ".join(f"{k}/{k}/{k}" for k in corner) for corner in corners]
        (FOLDER / "meshes").mkdir(parents=True, exist_ok=True)
        (FOLDER / "meshes" / f"{name}.obj").write_text("\n".join(lines + faces) + "\n")


def make_grids(program):
    """The density of a cloud as an .nvdb file for Sheaf and as a .vol file of the same values for Mitsuba."""
    (FOLDER / "generated").mkdir(parents=True, exist_ok=True)
    for name in ("cloud.nvdb", "cloud.vol"):
        subprocess.run([program, str(FOLDER / "generated" / name), "--resolution", "48"], check=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--make-cloud", default=find_make_cloud())
    choice = parser.add_mutually_exclusive_group()
    choice.add_argument("--grids-only", action="store_true")
    choice.add_argument("--no-grids", action="store_true")
    arguments = parser.parse_args()
    if not arguments.no_grids:
        if not Path(arguments.make_cloud).is_file():
            parser.error(f"no program {arguments.make_cloud}: build it, or say --make-cloud where it is")
        make_grids(arguments.make_cloud)
    if not arguments.grids_only:
        make_textures()
        make_normal_maps()
        make_balls()
        make_principled()
        make_many_lights()
        make_instances()


if __name__ == "__main__":
    main()
