#!/usr/bin/env python3
"""Writes scenes/gltf/generated/swatches.glb: twelve balls, each with a part of glTF's materials, and a camera that moves
around them in four seconds. Needs only Python; the output is deterministic.

  scenes/make/make_gltf_scene.py

Row by row from the back left: plastic, metal, textured roughness, normal map; clearcoat, sheen, anisotropy, colored
specular reflection; a refracting volume, a rough thin wall, an alpha mask, emission.
"""

import json
import math
import struct
import zlib
from pathlib import Path

FOLDER = Path(__file__).resolve().parents[2] / "scenes" / "gltf" / "generated"
SIDE = 256  # texels
FLOAT, UNSIGNED_SHORT = 5126, 5123


class Document:
    """A glTF document under construction."""

    def __init__(self):
        self.bytes = bytearray()
        self.json = {"asset": {"version": "2.0", "generator": "scenes/make/make_gltf_scene.py"}, "scene": 0,
                     "scenes": [{"nodes": []}]}

    def add(self, kind, member):
        """Appends a member to a list of the document and returns its index."""
        self.json.setdefault(kind, []).append(member)
        return len(self.json[kind]) - 1

    def view(self, data):
        self.bytes += b"\0" * (-len(self.bytes) % 4)
        offset = len(self.bytes)
        self.bytes += data
        return self.add("bufferViews", {"buffer": 0, "byteOffset": offset, "byteLength": len(data)})

    def accessor(self, rows, kind, component=FLOAT):
        """Adds tuples of numbers."""
        code = "f" if component == FLOAT else "H"
        flat = [x for row in rows for x in row]
        accessor = {"bufferView": self.view(struct.pack(f"<{len(flat)}{code}", *flat)), "componentType": component,
                    "count": len(rows), "type": kind}
        if kind == "VEC3":
            accessor["min"] = [min(row[k] for row in rows) for k in range(3)]
            accessor["max"] = [max(row[k] for row in rows) for k in range(3)]
        if kind == "SCALAR" and component == FLOAT:
            accessor["min"], accessor["max"] = [min(flat)], [max(flat)]
        return self.add("accessors", accessor)

    def texture(self, pixel):
        """Adds an image whose pixels are pixel(u, v), and a texture that shows it. u and v lie in [0, 1)."""
        rows = b"".join(b"\0" + bytes(max(0, min(255, round(255 * c))) for x in range(SIDE)
                                      for c in pixel((x + 0.5) / SIDE, (y + 0.5) / SIDE)) for y in range(SIDE))

        def chunk(name, data):
            return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

        png = (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", SIDE, SIDE, 8, 6, 0, 0, 0)) +
               chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b""))
        image = self.add("images", {"bufferView": self.view(png), "mimeType": "image/png"})
        return {"index": self.add("textures", {"source": image})}

    def material(self, color=(0.8, 0.8, 0.8, 1), metallic=0.0, roughness=0.5, extensions=None, core=None, **members):
        members["pbrMetallicRoughness"] = {"baseColorFactor": list(color), "metallicFactor": metallic,
                                           "roughnessFactor": roughness, **(core or {})}
        if extensions:
            members["extensions"] = {f"KHR_materials_{name}": values for name, values in extensions.items()}
            used = self.json.setdefault("extensionsUsed", [])
            used += [name for name in members["extensions"] if name not in used]
        return self.add("materials", members)

    def node(self, **members):
        self.json["scenes"][0]["nodes"].append(self.add("nodes", members))

    def write(self, path):
        self.json["buffers"] = [{"byteLength": len(self.bytes)}]
        text = json.dumps(self.json).encode()
        text += b" " * (-len(text) % 4)
        data = bytes(self.bytes) + b"\0" * (-len(self.bytes) % 4)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(data)) +
                         struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(data), b"BIN\0") + data)


def grid(columns, rows, point, has_poles=False):
    """Vertices point(u, v), each a position, a normal and uv, of a grid of quadrilaterals, and its indices. With poles,
    the first and the last row are triangles."""
    vertices = [point(i / columns, j / rows) for j in range(rows + 1) for i in range(columns + 1)]
    indices = []
    for j in range(rows):
        for i in range(columns):
            a = j * (columns + 1) + i
            b = a + columns + 1
            indices += [] if has_poles and j == rows - 1 else [(a,), (b,), (b + 1,)]
            indices += [] if has_poles and j == 0 else [(a,), (b + 1,), (a + 1,)]
    return vertices, indices


def sphere(u, v):
    phi, theta = 2 * math.pi * u, math.pi * v
    n = (math.sin(theta) * math.sin(phi), math.cos(theta), math.sin(theta) * math.cos(phi))
    return n, n, (2 * u, v)


def ground(u, v):
    return (60 * (u - 0.5), -1, 60 * (v - 0.5)), (0, 1, 0), (20 * u, 20 * v)


def add_mesh(document, material, shape):
    """Adds a mesh of vertices and indices that share accessors with other meshes of the same shape."""
    return document.add("meshes", {"primitives": [{**shape, "material": material}]})


def add_shape(document, vertices, indices):
    positions, normals, uvs = zip(*vertices)
    return {"attributes": {"POSITION": document.accessor(positions, "VEC3"),
                           "NORMAL": document.accessor(normals, "VEC3"),
                           "TEXCOORD_0": document.accessor(uvs, "VEC2")},
            "indices": document.accessor(indices, "SCALAR", UNSIGNED_SHORT)}


def checker(u, v, cells=8):
    return (int(u * cells) + int(v * cells)) % 2


def bumps(u, v):
    """The normals of a grid of round bumps."""
    x, y = 2 * math.pi * 6 * u, 2 * math.pi * 6 * v
    slope = 0.7
    n = (-slope * math.cos(x) * math.sin(y), slope * math.sin(x) * math.cos(y), 1)
    length = math.sqrt(sum(c * c for c in n))
    return tuple(0.5 + 0.5 * c / length for c in n) + (1,)


def add_materials(document):
    """The materials of the balls, in order."""
    stripes = document.texture(lambda u, v: (0, 0.15 + 0.6 * checker(u, v), 1 - checker(u, v), 1))
    holes = document.texture(lambda u, v: (0.9, 0.45, 0.1, 1 if (u * 8 % 1 - 0.5)**2 + (v * 8 % 1 - 0.5)**2 > 0.1 else 0))
    spots = document.texture(lambda u, v: (1, 0.55, 0.2, 1) if checker(u, v, 4) else (0, 0, 0, 1))
    normals = document.texture(bumps)
    volume = {"thicknessFactor": 1, "attenuationDistance": 1.5, "attenuationColor": [0.35, 0.8, 0.75]}
    add = document.material
    return [
        add((0.7, 0.06, 0.05, 1), roughness=0.3, name="plastic"),
        add((1, 0.77, 0.34, 1), metallic=1, roughness=0.35, name="metal"),
        add((0.9, 0.9, 0.9, 1), metallic=1, roughness=1, core={"metallicRoughnessTexture": stripes}, name="textured"),
        add((0.25, 0.45, 0.7, 1), roughness=0.35, normalTexture=normals, name="normal map"),
        add((0.05, 0.1, 0.4, 1), metallic=0.6, roughness=0.5, name="clearcoat",
            extensions={"clearcoat": {"clearcoatFactor": 1, "clearcoatRoughnessFactor": 0.03}}),
        add((0.12, 0.01, 0.05, 1), roughness=1, name="sheen",
            extensions={"sheen": {"sheenColorFactor": [0.9, 0.25, 0.45], "sheenRoughnessFactor": 0.4}}),
        add((0.85, 0.87, 0.9, 1), metallic=1, roughness=0.3, name="anisotropy",
            extensions={"anisotropy": {"anisotropyStrength": 0.9, "anisotropyRotation": 0.0}}),
        add((0.02, 0.02, 0.02, 1), roughness=0.2, name="specular", extensions={
            "specular": {"specularFactor": 1, "specularColorFactor": [1, 0.3, 0.1]}, "ior": {"ior": 2.2}}),
        add((1, 1, 1, 1), roughness=0, name="volume", extensions={
            "transmission": {"transmissionFactor": 1}, "volume": volume, "ior": {"ior": 1.45},
            "dispersion": {"dispersion": 0.4}}),
        add((0.95, 0.85, 0.6, 1), roughness=0.45, name="thin wall", doubleSided=True,
            extensions={"transmission": {"transmissionFactor": 0.9}}),
        add((1, 1, 1, 1), roughness=0.6, core={"baseColorTexture": holes}, alphaMode="MASK", doubleSided=True, name="mask"),
        add((0.05, 0.05, 0.05, 1), roughness=0.4, emissiveFactor=[1, 1, 1], emissiveTexture=spots, name="emission",
            extensions={"emissive_strength": {"emissiveStrength": 4}}),
    ]


def add_camera(document):
    """Adds a camera that moves on an arc around the balls."""
    times, translations, rotations = [], [], []
    for step in range(9):
        angle = math.radians(-20 + 5 * step)
        tilt = math.radians(-33)
        times.append((0.5 * step,))
        translations.append((17 * math.sin(angle), 11, 17 * math.cos(angle)))
        # First the tilt about x, then the angle about y
        s, c, t, k = math.sin(angle / 2), math.cos(angle / 2), math.sin(tilt / 2), math.cos(tilt / 2)
        rotations.append((c * t, s * k, -s * t, c * k))
    camera = document.add("cameras", {"type": "perspective", "name": "front", "perspective": {
        "yfov": math.radians(28), "aspectRatio": 4 / 3, "znear": 0.1}})
    document.node(camera=camera, name="camera", translation=translations[4], rotation=rotations[4])
    node = len(document.json["nodes"]) - 1
    inputs = document.accessor(times, "SCALAR")
    outputs = [document.accessor(translations, "VEC3"), document.accessor(rotations, "VEC4")]
    document.add("animations", {
        "name": "arc",
        "channels": [{"sampler": k, "target": {"node": node, "path": path}}
                     for k, path in enumerate(("translation", "rotation"))],
        "samplers": [{"input": inputs, "output": output} for output in outputs]})


def main():
    document = Document()
    ball = add_shape(document, *grid(64, 32, sphere, has_poles=True))
    for i, material in enumerate(add_materials(document)):
        document.node(mesh=add_mesh(document, material, ball), name=document.json["materials"][material]["name"],
                      translation=[2.6 * (i % 4 - 1.5), 0, 3.2 * (i // 4 - 1)])
    tiles = document.texture(lambda u, v: (0.42, 0.42, 0.42, 1) if checker(u, v, 2) else (0.55, 0.55, 0.55, 1))
    floor = document.material((1, 1, 1, 1), roughness=0.8, core={"baseColorTexture": tiles}, name="floor")
    document.node(mesh=add_mesh(document, floor, add_shape(document, *grid(1, 1, ground))), name="floor")
    add_camera(document)
    document.write(FOLDER / "swatches.glb")
    print(f"wrote {FOLDER / 'swatches.glb'}")


if __name__ == "__main__":
    main()
