#!/usr/bin/env python3
"""Renders the images of docs/gallery.md and the plots of docs/. Needs numpy and Pillow, the font DejaVu Sans (Debian:
python3-numpy python3-pil fonts-dejavu-core), and for the plots python3-matplotlib.

  tools/documentation/make_gallery.py [NAME ...] [--sheaf PROGRAM] [--output FOLDER] [--draft] [--plots] [--list]

NAME is the name of an image, such as balls; the default is all images. The commands are those of docs/gallery.md: the
image gallery/NAME.jpg shows the output of the last code block before it. Several outputs become one labeled sheet; see
tools/documentation/gallery/sheets.py. The frames of an animation also become an animated gallery/NAME.png. Scripts that write the
files of scenes run first if files are missing.
"""

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from gallery.page import read_images, read_scripts
from gallery.sheets import make_sheet, write_film

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "gallery.md"
PLOTS = ["plot_samplers.py", "plot_progressive.py"]
QUALITY = 88


def make_missing_files(images, sheaf):
    """Runs the scripts that write missing files of scenes."""
    scripts = {command[0]: command for command in read_scripts(PAGE)}
    commands = [command for image in images for command in image.commands if command[1] == "render"]
    for scene in sorted({ROOT / command[2] for command in commands}):
        folder = scene.parent.parent if scene.parent.name == "generated" else scene.parent
        origin = folder / "generated.txt"
        done = subprocess.run([sheaf, "info", scene], check=False, text=True, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT)
        if done.returncode == 0 or not origin.exists():
            continue
        script = re.search(r"scenes/make/\w+\.py", origin.read_text())[0]
        if script in scripts:
            command = scripts.pop(script)
            print(" ".join(command), flush=True)
            subprocess.run([sys.executable, *command], cwd=ROOT, check=True)


def shortened(words):
    """The words of a command for an image of a quarter of the size with 16 samples per pixel."""
    if "--spp" in words:
        at = words.index("--spp")
        words = words[:at] + words[at + 2:]
    return [*words, "--scale", "25%", "--spp", "16"]


def render(image, arguments):
    """Runs the commands of an image and writes its JPEG file."""
    start = time.monotonic()
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        for part in ("scenes", "tools"):
            (folder / part).symlink_to(ROOT / part)
        for command in image.commands:
            words = command[1:]
            if words[0] == "render":
                words = [*(shortened(words) if arguments.draft else words), "--quiet"]
            subprocess.run([arguments.sheaf, *words], cwd=folder, check=True, stdout=subprocess.DEVNULL)
        path = arguments.output / f"{image.name}.jpg"
        outputs = [folder / name for name in image.outputs()]
        make_sheet(image.name, outputs).save(path, quality=QUALITY, optimize=True, progressive=True)
        if image.has_frames():
            write_film(outputs, path.with_suffix(".png"))
    print(f"{image.name}.jpg: {path.stat().st_size / 1000:.0f} kB, {time.monotonic() - start:.0f} s", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME")
    parser.add_argument("--sheaf", default=str(ROOT / "build/release/sheaf"))
    parser.add_argument("--output", type=Path, default=ROOT / "docs" / "gallery")
    parser.add_argument("--draft", action="store_true", help="a quarter of the size, 16 samples per pixel")
    parser.add_argument("--plots", action="store_true", help="also make the plots, which takes several minutes")
    parser.add_argument("--list", action="store_true", help="only print the names of the images")
    arguments = parser.parse_args()
    images = read_images(PAGE)
    unknown = set(arguments.names) - {image.name for image in images}
    if unknown:
        sys.exit(f"docs/gallery.md has no image named {', '.join(sorted(unknown))}")
    images = [image for image in images if not arguments.names or image.name in arguments.names]
    if arguments.list:
        print("\n".join(image.name for image in images))
        return
    arguments.sheaf = shutil.which(os.path.abspath(arguments.sheaf)) or sys.exit(f"no program {arguments.sheaf}")
    arguments.output.mkdir(parents=True, exist_ok=True)
    make_missing_files(images, arguments.sheaf)
    for image in images:
        render(image, arguments)
    for plot in PLOTS if arguments.plots else []:
        subprocess.run([sys.executable, ROOT / "tools/documentation" / plot, "--sheaf", arguments.sheaf], check=True)


if __name__ == "__main__":
    main()
