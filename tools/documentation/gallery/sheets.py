"""Composes labeled sheets of several images. Needs numpy and Pillow, and the font DejaVu Sans."""

import sys
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

ROOT = Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT / "scenes/make"), str(ROOT / "tools/validation")]
import make_material_scenes  # noqa: E402
import make_texture_scenes  # noqa: E402
from exr import read_channels  # noqa: E402

GAP = 6  # pixels between tiles
FONT = "DejaVuSans.ttf"
FRAME_DURATION = 50  # ms


@dataclass
class Sheet:
    """Labels of the tiles, one per image that the commands write. Tiles fill rows of `columns` tiles."""
    labels: list = field(default_factory=list)
    columns: int = 0  # 0: one row
    shrink: int = 1  # factor by which the width and height of tiles are reduced


# Images that several commands render, and their labels.
SHEETS = {
    "animation": Sheet(columns=8, shrink=2),
    "cameras": Sheet(["perspective", "radial distortion", "orthographic", "spherical"]),
    "denoising": Sheet(["16 samples per pixel", "denoised by non-local means"]),
    "guiding": Sheet(["path tracing", "with path guiding, equal samples"]),
    "integrators": Sheet(["path", "direct", "whitted", "ao", "normals"]),
    "media_phase": Sheet(["g = -0.8: backwards", "g = 0: isotropic", "g = 0.8: forwards"]),
    "sunsky": Sheet(["4:42", "7:00", "12:00", "20:00"]),
}

# Labels within one rendered image: functions that return [(text, x, y, anchor)] with places in [0, 1]^2.
OVERLAYS = {
    "balls": make_material_scenes.ball_labels,
    "wall": make_texture_scenes.wall_labels,
    "filters": make_texture_scenes.filter_labels,
    "principled": lambda: make_material_scenes.strip_labels(make_material_scenes.PARAMETER_ROWS),
    "disney": lambda: make_material_scenes.strip_labels(make_material_scenes.NORI_ROWS),
}


def draw_overlay(image, labels):
    """Draws dark text at places of the image, or text in boxes (anchor "box")."""
    font = ImageFont.truetype(FONT, max(round(image.width / 80), 6))
    for text, x, y, anchor in labels:
        place = (x * image.width, y * image.height)
        if anchor == "box":
            image = draw_boxed(image, text, place, font)
        else:
            ImageDraw.Draw(image).text(place, text, fill=(24, 24, 26), font=font,
                                       anchor="lm" if anchor == "left" else "mm")
    return image


def draw_boxed(image, text, place, font):
    """Draws white text on a dark, translucent box; `place` is its left end."""
    layer = Image.new("RGBA", image.size)
    draw = ImageDraw.Draw(layer)
    pad = 0.45 * font.size
    x0, y0, x1, y1 = draw.textbbox(place, text, font=font, anchor="lm")
    draw.rounded_rectangle((x0 - pad, y0 - pad, x1 + pad, y1 + pad), radius=0.3 * font.size, fill=(0, 0, 0, 150))
    draw.text(place, text, fill=(255, 255, 255, 255), font=font, anchor="lm")
    return Image.alpha_composite(image.convert("RGBA"), layer).convert("RGB")


def draw_label(image, text):
    """Draws a label into the lower left corner of a tile."""
    size = min(max(round(image.width / 26), 7), 18)
    return draw_boxed(image, text, (0.9 * size, image.height - 1.1 * size), ImageFont.truetype(FONT, size))


def compose(tiles, columns=0):
    """Places tiles of one size in rows, with white gaps."""
    columns = columns or len(tiles)
    width, height = tiles[0].size
    rows = -(-len(tiles) // columns)
    sheet = Image.new("RGB", (columns * (width + GAP) - GAP, rows * (height + GAP) - GAP), "white")
    for i, tile in enumerate(tiles):
        sheet.paste(tile, (i % columns * (width + GAP), i // columns * (height + GAP)))
    return sheet


def open_image(path):
    """Opens a PNG file as RGB; what its alpha leaves transparent becomes black."""
    image = Image.open(path)
    if image.mode == "RGBA":
        image = Image.alpha_composite(Image.new("RGBA", image.size, "black"), image)
    return image.convert("RGB")


def to_bytes(values):
    return Image.fromarray((255 * np.clip(values, 0, 1) + 0.5).astype(np.uint8), "RGB")


def srgb(values):
    values = np.clip(values, 0, 1)
    return np.where(values <= 0.0031308, 12.92 * values, 1.055 * np.maximum(values, 1e-9)**(1 / 2.4) - 0.055)


def cryptomatte_colors(channels, layer):
    """The coverage of each id in a color of its own; ids are the bits of floats."""
    total = 0
    for level in range(3):
        for ids, cover in ("rg", "ba"):
            bits = channels[f"{layer}{level:02}.{ids}"].view(np.uint32)
            hue = np.stack([(bits * np.uint32(k) >> np.uint32(8)) % np.uint32(997) / 996
                            for k in (2654435761, 40503, 69069)], axis=-1)
            total = total + (0.15 + 0.85 * hue) * channels[f"{layer}{level:02}.{cover}"][..., None]
    return total


def layer_tiles(path, beauty):
    """[(label, image)] of the layers of an EXR file beside its PNG file."""
    channels = read_channels(path)

    def stack(layer, parts="RGB"):
        return np.stack([channels[f"{layer}.{part}"] for part in parts], axis=-1)

    depth = channels["Z"]
    near, far = np.percentile(depth[depth > 0], (1, 99))
    depth = np.repeat(np.where(depth > 0, 1 - 0.85 * (depth - near) / (far - near), 0)[..., None], 3, axis=-1)
    return [("image", open_image(beauty)), ("albedo", to_bytes(srgb(stack("albedo")))),
            ("normal", to_bytes(0.5 + 0.5 * stack("N", "XYZ"))), ("depth", to_bytes(depth)),
            ("Cryptomatte objects", to_bytes(cryptomatte_colors(channels, "CryptoObject"))),
            ("Cryptomatte materials", to_bytes(cryptomatte_colors(channels, "CryptoMaterial")))]


def make_sheet(name, paths):
    """Returns the image of the gallery from the files that its commands wrote."""
    exr = [p for p in paths if p.suffix == ".exr"]
    png = [p for p in paths if p.suffix == ".png"]
    if name == "layers":
        return compose([draw_label(image, text) for text, image in layer_tiles(exr[0], png[0])], 3)
    tiles = [open_image(p) for p in png]
    if name in OVERLAYS:
        return draw_overlay(tiles[0], OVERLAYS[name]())
    sheet = SHEETS.get(name, Sheet())
    if len(tiles) == 1 and len(sheet.labels) > 1:  # a batch of cameras on one film
        width = tiles[0].width // len(sheet.labels)
        tiles = [tiles[0].crop((i * width, 0, (i + 1) * width, tiles[0].height)) for i in range(len(sheet.labels))]
    if sheet.labels:
        tiles = [draw_label(tile, text) for tile, text in zip(tiles, sheet.labels)]
    tiles = [tile.reduce(sheet.shrink) for tile in tiles]
    return compose(tiles, sheet.columns)


def write_film(paths, film):
    """Writes an animated PNG of the frames, with a palette of 128 colors that all frames share."""
    frames = [open_image(path) for path in paths]
    palette = compose([frame.reduce(2) for frame in frames[::4]]).quantize(128, method=Image.Quantize.MEDIANCUT)
    frames = [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
    frames[0].save(film, save_all=True, append_images=frames[1:], duration=FRAME_DURATION, loop=0, optimize=True)
