"""Small files of every format that scenes refer to, written with the standard library."""

import gzip
import json
import math
import struct
import subprocess
import zlib
from pathlib import Path

from documents import ROOT

VERTICES = [(-1, -1, -1), (1, -1, -1), (1, 1, -1), (-1, 1, -1), (-1, -1, 1), (1, -1, 1), (1, 1, 1), (-1, 1, 1)]
TRIANGLES = [(0, 2, 1), (0, 3, 2), (4, 5, 6), (4, 6, 7), (0, 1, 5), (0, 5, 4), (3, 6, 2), (3, 7, 6), (0, 4, 7),
             (0, 7, 3), (1, 2, 6), (1, 6, 5)]


def png(side=4):
    """An RGB image that varies along both axes."""
    rows = b"".join(b"\0" + bytes(v for x in range(side) for v in (60 * x + 20, 60 * y + 20, 200)) for y in range(side))

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", side, side, 8, 2, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def obj():
    lines = [f"v {x} {y} {z}" for x, y, z in VERTICES] + [f"vt {0.5 + x / 2} {0.5 + y / 2}" for x, y, _ in VERTICES]
    return "\n".join(lines + ["f " + " ".join(f"{i + 1}/{i + 1}" for i in t) for t in TRIANGLES]) + "\n"


def ply():
    """A cube with texture coordinates and vertex colors."""
    header = ["ply", "format ascii 1.0", f"element vertex {len(VERTICES)}"]
    header += [f"property float {name}" for name in ("x", "y", "z", "u", "v", "r", "g", "b")]
    header += [f"element face {len(TRIANGLES)}", "property list uchar int vertex_indices", "end_header"]
    rows = [f"{x} {y} {z} {0.5 + x / 2} {0.5 + y / 2} 0.2 0.5 0.8" for x, y, z in VERTICES]
    return "\n".join(header + rows + [f"3 {a} {b} {c}" for a, b, c in TRIANGLES]) + "\n"


def stl():
    """The cube in the binary format."""
    corners = [struct.pack("<12fH", 0, 0, 0, *(x for i in t for x in VERTICES[i]), 0) for t in TRIANGLES]
    return b" " * 80 + struct.pack("<I", len(TRIANGLES)) + b"".join(corners)


def glb():
    """The cube with a camera and an animation of its node."""
    buffer = struct.pack(f"<{3 * len(VERTICES)}f", *(x for v in VERTICES for x in v))
    buffer += struct.pack(f"<{3 * len(TRIANGLES)}H", *(i for t in TRIANGLES for i in t))
    keys = len(buffer)
    buffer += struct.pack("<8f", 0, 1, 0, 0, 0, 0.5, 0, 0)
    views = [(0, 96), (96, keys - 96), (keys, 8), (keys + 8, 24)]
    accessors = [(0, 5126, 8, "VEC3"), (1, 5123, 36, "SCALAR"), (2, 5126, 2, "SCALAR"), (3, 5126, 2, "VEC3")]
    text = json.dumps({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}],
        "nodes": [{"mesh": 0}, {"camera": 0, "name": "front", "translation": [0, 0, 6]}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.6, "znear": 0.1}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "animations": [{"channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
                        "samplers": [{"input": 2, "output": 3}]}],
        "buffers": [{"byteLength": len(buffer)}],
        "bufferViews": [{"buffer": 0, "byteOffset": at, "byteLength": size} for at, size in views],
        "accessors": [{"bufferView": v, "componentType": c, "count": n, "type": t} for v, c, n, t in accessors],
    }).encode()
    text += b" " * (-len(text) % 4)
    return (struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(buffer)) + struct.pack("<I4s", len(text), b"JSON") +
            text + struct.pack("<I4s", len(buffer), b"BIN\0") + buffer)


def ellipsoids():
    names = ["x", "y", "z", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"]
    header = ["ply", "format ascii 1.0", "element vertex 2", *(f"property float {name}" for name in names)]
    return "\n".join(header + ["end_header", "0 0 0 -1 -2 -1 1 0 0 0", "0.5 0 0 -2 -1 -2 1 0.5 0 0"]) + "\n"


def serialized(meshes=3):
    """The cube, several times."""
    data = struct.pack("<I", 0x1000) + b"cube\0" + struct.pack("<QQ", len(VERTICES), len(TRIANGLES))
    data += struct.pack(f"<{3 * len(VERTICES)}f", *(x for v in VERTICES for x in v))
    data += struct.pack(f"<{3 * len(TRIANGLES)}I", *(i for t in TRIANGLES for i in t))
    mesh = struct.pack("<HH", 0x041c, 4) + zlib.compress(data)
    offsets = struct.pack(f"<{meshes}Q", *(i * len(mesh) for i in range(meshes)))
    return mesh * meshes + offsets + struct.pack("<I", meshes)


def vol(side=4):
    """A grid of distances to a sphere, so that it is a density and has a zero level set."""
    header = b"VOL\x03" + struct.pack("<5i6f", 1, side, side, side, 1, 0, 0, 0, 1, 1, 1)
    axis = [i / (side - 1) - 0.5 for i in range(side)]
    return header + b"".join(struct.pack("<f", math.hypot(x, y, z) - 0.3) for z in axis for y in axis for x in axis)


def density(side=4):
    header = b"VOL\x03" + struct.pack("<5i6f", 1, side, side, side, 1, 0, 0, 0, 1, 1, 1)
    return header + b"".join(struct.pack("<f", i % 5 / 5) for i in range(side ** 3))


def tensor(fields):
    """A tensor file of fields: names, shapes, types of the module struct, and values that are repeated."""
    kinds = {"B": 1, "H": 3, "f": 10}
    size = 18 + sum(2 + len(name) + 2 + 1 + 8 + 8 * len(shape) for name, shape, _, _ in fields)
    header, data = b"tensor_file\0\1\0" + struct.pack("<I", len(fields)), b""
    for name, shape, code, values in fields:
        header += struct.pack("<H", len(name)) + name.encode()
        header += struct.pack("<HBQ", len(shape), kinds[code], size + len(data)) + struct.pack(f"<{len(shape)}Q", *shape)
        count = math.prod(shape)
        data += struct.pack(f"<{count}{code}", *(values * (count // len(values))))
    return header + data


def measured():
    """A constant BRDF in the format of the RGL database, with spectra."""
    wavelengths = [360.0, 550.0, 830.0]
    grid = (2, 2)
    return tensor([("jacobian", (1,), "B", [0]), ("phi_i", (1,), "f", [0]), ("theta_i", (2,), "f", [0, 1.5]),
                   ("ndf", grid, "f", [1]), ("sigma", grid, "f", [1]), ("vndf", (1, 2, *grid), "f", [1]),
                   ("luminance", (1, 2, *grid), "f", [1]), ("wavelengths", (3,), "f", wavelengths),
                   ("spectra", (1, 2, 3, *grid), "f", [0.3])])


def polarized():
    """A constant, depolarizing BRDF in the format of Baek et al. 2020."""
    return tensor([("phi_d", (1, 3), "f", [-math.pi, 0, math.pi]), ("theta_d", (1, 2), "f", [0, math.pi / 2]),
                   ("theta_h", (1, 2), "f", [0, math.pi / 2]), ("wvls", (2,), "H", [450, 650]),
                   ("M", (3, 2, 2, 2, 4, 4), "f", [0.2] + 15 * [0])])


def vdb():
    return gzip.decompress((ROOT / "tests/scene/formats/vdb/small_zip.vdb.gz").read_bytes())


CURVES = "-1 0 0 0.1\n-0.3 0.4 0 0.1\n0.3 -0.4 0 0.1\n1 0 0 0.1\n"
HAIR = "-1 0 0\n0 0.5 0\n1 0 0\n\n-1 0.3 0\n0 0.8 0\n1 0.3 0\n"
SPECTRUM = "400 0.1\n550 0.5\n700 0.9\n"


def content(path, text):
    """The content of a file that `text`, a part of a scene, names."""
    suffix = Path(path).suffix.lower()
    if suffix == ".ply" and "ellipsoids" in text:
        return ellipsoids()
    if suffix == ".vol":
        return vol() if "sdfgrid" in text else density()
    if suffix == ".txt":
        return CURVES
    makers = {".obj": obj, ".ply": ply, ".stl": stl, ".glb": glb, ".serialized": serialized, ".bsdf": measured,
              ".pbsdf": polarized, ".vdb": vdb, ".mitshair": lambda: HAIR, ".hair": lambda: HAIR,
              ".spd": lambda: SPECTRUM}
    images = (".png", ".jpg", ".jpeg", ".exr", ".hdr", ".bmp", ".tif", ".tiff", ".pfm")
    return makers[suffix]() if suffix in makers else png() if suffix in images else None


def write(folder, path, text, build):
    """Writes a file that `text`, a part of a scene, names. Returns whether its format is known."""
    file = Path(folder) / path
    file.parent.mkdir(parents=True, exist_ok=True)
    if file.exists():
        return True
    if file.suffix == ".nvdb":
        subprocess.run([build / "make_cloud", file, "--kind", "cloud", "--resolution", "8", "--temperature"],
                       check=True, stdout=subprocess.DEVNULL)
        return True
    made = content(path, text)
    if made is not None:
        file.write_bytes(made.encode() if isinstance(made, str) else made)
    return made is not None
