#!/usr/bin/env python3
"""Writes the scenes that tests/package/check_release.sh renders: textures of all formats, compressed and imported models,
and a script in Python. Needs the standard library only.

  tests/package/release_inputs.py FOLDER

textures.xml also needs t.jpg, which `sheaf render picture.xml -o t.jpg` writes.
"""

import json
import math
import struct
import sys
import zlib
from pathlib import Path

SIZE = 32
FORMATS = ("png", "jpg", "tga", "hdr", "tif")


def pixel(x, y):
    """A color of the test image, with bytes as components: red grows to the right, green downward, with a checkerboard."""
    return (x * 255 // (SIZE - 1), y * 255 // (SIZE - 1), 255 * ((x // 8 + y // 8) % 2))


def rows():
    return [[pixel(x, y) for x in range(SIZE)] for y in range(SIZE)]


def png():
    data = b"".join(b"\0" + bytes(c for color in row for c in color) for row in rows())
    chunks = [(b"IHDR", struct.pack(">IIBBBBB", SIZE, SIZE, 8, 2, 0, 0, 0)), (b"IDAT", zlib.compress(data)), (b"IEND", b"")]
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))
        for kind, content in chunks)


def tga():
    header = struct.pack("<BBBHHBHHHHBB", 0, 0, 2, 0, 0, 0, 0, 0, SIZE, SIZE, 24, 0x20)
    return header + bytes(c for row in rows() for color in row for c in reversed(color))


def tif():
    data = bytes(c for row in rows() for color in row for c in color)
    bits_at = 8 + 2 + 10 * 12 + 4
    entries = [(256, 3, 1, SIZE), (257, 3, 1, SIZE), (258, 3, 3, bits_at), (259, 3, 1, 1), (262, 3, 1, 2),
               (273, 4, 1, bits_at + 6), (277, 3, 1, 3), (278, 3, 1, SIZE), (279, 4, 1, len(data)), (284, 3, 1, 1)]
    return (b"II*\0" + struct.pack("<IH", 8, len(entries)) +
            b"".join(struct.pack("<HHII", *entry) for entry in entries) + struct.pack("<I", 0) +
            struct.pack("<HHH", 8, 8, 8) + data)


def hdr():
    def rgbe(color):
        linear = [(c / 255) ** 2.2 for c in color]
        largest = max(linear)
        if largest < 1e-32:
            return bytes(4)
        mantissa, exponent = math.frexp(largest)
        return bytes([*(int(c * mantissa * 256 / largest) for c in linear), exponent + 128])

    head = f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {SIZE} +X {SIZE}\n".encode()
    return head + b"".join(rgbe(color) for row in rows() for color in row)


PICTURE = f"""<scene version="3.0.0">
  <integrator type="direct"/>
  <sensor type="orthographic">
    <transform name="to_world"><lookat origin="0, 0, 5" target="0, 0, 0" up="0, 1, 0"/></transform>
    <sampler type="independent"><integer name="sample_count" value="16"/></sampler>
    <film type="hdrfilm"><integer name="width" value="{SIZE}"/><integer name="height" value="{SIZE}"/></film></sensor>
  <shape type="rectangle"><emitter type="area"><texture type="bitmap" name="radiance">
    <string name="filename" value="t.png"/><string name="filter_type" value="nearest"/></texture></emitter></shape>
</scene>
"""


def textures_scene():
    squares = "".join(f"""
  <shape type="rectangle"><transform name="to_world"><translate x="{2.2 * (i - 2)}"/></transform>
    <bsdf type="diffuse"><texture type="bitmap" name="reflectance"><string name="filename" value="t.{name}"/></texture></bsdf>
  </shape>""" for i, name in enumerate(FORMATS))
    return f"""<scene version="3.0.0">
  <integrator type="direct"/>
  <sensor type="orthographic">
    <transform name="to_world"><scale value="5.6"/><lookat origin="0, 0, 5" target="0, 0, 0" up="0, 1, 0"/></transform>
    <film type="hdrfilm"><integer name="width" value="280"/><integer name="height" value="60"/></film></sensor>
  <emitter type="constant"/>{squares}
</scene>
"""


# A square of two triangles in the plane z = 0
CORNERS = ((-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0))
TRIANGLES = ((0, 1, 2), (0, 2, 3))


def draco_mesh():
    """The square by Draco's sequential encoding with raw indices and positions; see its bitstream specification."""
    head = b"DRACO" + bytes([2, 2, 1, 0, 0, 0])
    connectivity = bytes([len(TRIANGLES), len(CORNERS), 1]) + bytes(i for triangle in TRIANGLES for i in triangle)
    # One decoder with one attribute: positions (0) of float (9), 3 components, not normalized, id 0, stored as they are (0)
    attributes = bytes([1, 1, 0, 9, 3, 0, 0, 0])
    return head + connectivity + attributes + b"".join(struct.pack("<fff", *corner) for corner in CORNERS)


def draco_gltf():
    mesh = draco_mesh()
    padded = mesh + bytes(-len(mesh) % 4)
    extension = "KHR_draco_mesh_compression"
    content = {
        "asset": {"version": "2.0"}, "extensionsUsed": [extension], "extensionsRequired": [extension],
        "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}], "buffers": [{"byteLength": len(padded)}],
        "bufferViews": [{"buffer": 0, "byteLength": len(mesh)}],
        "accessors": [{"componentType": 5121, "count": 3 * len(TRIANGLES), "type": "SCALAR"},
                      {"componentType": 5126, "count": len(CORNERS), "type": "VEC3", "min": [-1, -1, 0], "max": [1, 1, 0]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 1}, "indices": 0,
                                    "extensions": {extension: {"bufferView": 0, "attributes": {"POSITION": 0}}}}]}]}
    text = json.dumps(content).encode()
    text += b" " * (-len(text) % 4)
    return (struct.pack("<4sII", b"glTF", 2, 12 + 8 + len(text) + 8 + len(padded)) +
            struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(padded), b"BIN\0") + padded)


def fbx():
    def numbers(name, values):
        return f"{name}: *{len(values)} {{ a: {','.join(map(str, values))} }}"

    corners = [100 * c for corner in CORNERS for c in corner]
    return f"""; FBX 7.4.0 project file
FBXHeaderExtension:  {{ FBXVersion: 7400 }}
GlobalSettings:  {{ Version: 1000 }}
Objects:  {{
  Geometry: 1, "Geometry::square", "Mesh" {{ {numbers("Vertices", corners)}
    {numbers("PolygonVertexIndex", [0, 1, 2, -4])} }}
  Model: 2, "Model::square", "Mesh" {{ Version: 232 }}
}}
Connections:  {{
  C: "OO",2,0
  C: "OO",1,2
}}
"""


CONFIG = """ocio_profile_version: 1
roles: {default: linear, scene_linear: linear}
displays: {monitor: [!<View> {name: standard, colorspace: display}]}
colorspaces:
  - !<ColorSpace> {name: linear}
  - !<ColorSpace> {name: display, from_reference: !<ExponentTransform> {value: [0.4545, 0.4545, 0.4545, 1]}}
"""

SCRIPT = """import sheaf

scene = sheaf.load("textures.xml")
result = sheaf.render(scene, spp=4, threads=2)
result.write("script.png")
model = sheaf.render(sheaf.load("square.fbx"), spp=4, size=(64, 48))
model.write("model.png")
"""


def main():
    folder = Path(sys.argv[1])
    for name, make in {"t.png": png, "t.tga": tga, "t.tif": tif, "t.hdr": hdr, "draco.glb": draco_gltf}.items():
        (folder / name).write_bytes(make())
    for name, text in {"picture.xml": PICTURE, "textures.xml": textures_scene(), "square.fbx": fbx(), "config.ocio": CONFIG,
                       "script.py": SCRIPT}.items():
        (folder / name).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
