"""Reads the OpenEXR files that `sheaf render` and Blender write."""

import struct
import zlib

import numpy as np

LINES_PER_BLOCK = {0: 1, 2: 1, 3: 16}  # uncompressed, ZIPS, ZIP
LONG_NAMES = 0x400  # bit of the version
TYPES = {0: "<u4", 1: "<f2", 2: "<f4"}


def read_channels(path):
    """Returns {name: height x width array} of a single-part scanline file without compression or with ZIP."""
    data = path.read_bytes()
    if data[:8] not in [struct.pack("<2I", 20000630, 2 | flag) for flag in (0, LONG_NAMES)]:
        raise ValueError(f"{path} is not a single-part scanline EXR file")
    header, at = read_header(data)
    channels = read_channel_list(header["channels"])
    x0, y0, x1, y1 = struct.unpack("<4i", header["dataWindow"])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    lines = LINES_PER_BLOCK[header["compression"][0]]
    line_bytes = sum(np.dtype(kind).itemsize for _, kind in channels) * width
    image = {name: np.empty((height, width), np.float32) for name, _ in channels}
    for offset in struct.unpack_from(f"<{-(-height // lines)}q", data, at):
        top, length = struct.unpack_from("<2i", data, offset)
        count = min(lines, y1 + 1 - top)
        block = data[offset + 8:offset + 8 + length]
        if length < count * line_bytes:
            block = unzip(block)
        position = 0
        for line in range(top - y0, top - y0 + count):
            for name, kind in channels:
                values = np.frombuffer(block, kind, width, position)
                image[name][line] = values
                position += values.nbytes
    return image


def read_header(data):
    """Returns {attribute: bytes} and the position behind the header."""
    header, at = {}, 8
    while data[at]:
        name, _, rest = data[at:at + 1024].split(b"\0", 2)
        at += data[at:].index(b"\0", len(name) + 1) + 1
        length = struct.unpack_from("<i", data, at)[0]
        header[name.decode()] = data[at + 4:at + 4 + length]
        at += 4 + length
    return header, at + 1


def read_channel_list(text):
    """Returns [(name, dtype)] in the order of the file."""
    channels = []
    while text != b"\0":
        name, rest = text.split(b"\0", 1)
        channels.append((name.decode(), TYPES[struct.unpack_from("<i", rest)[0]]))
        text = rest[16:]
    return channels


def unzip(block):
    """Decodes OpenEXR's ZIP compression: zlib, byte deltas, and even bytes stored before odd ones."""
    deltas = np.frombuffer(zlib.decompress(block), np.uint8).astype(np.int64)
    deltas[1:] -= 128
    halves = np.cumsum(deltas).astype(np.uint8)
    values = np.empty_like(halves)
    middle = (len(halves) + 1) // 2
    values[0::2], values[1::2] = halves[:middle], halves[middle:]
    return values.tobytes()


def read_rgb(path, layer=""):
    """Returns R, G and B, or those of a layer such as "variance.", as a height x width x 3 array of doubles."""
    channels = read_channels(path)
    return np.stack([channels[layer + c] for c in "RGB"], axis=-1).astype(float)
