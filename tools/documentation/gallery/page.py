"""Reads the images of docs/gallery.md and the commands that render them."""

import re
import shlex
from dataclasses import dataclass


@dataclass
class GalleryImage:
    name: str  # docs/gallery/NAME.jpg
    commands: list  # lists of words, each a `sheaf` command

    def has_frames(self):
        return any("--frames" in command for command in self.commands)

    def outputs(self):
        """The files that the commands write, in their order; with --frames, one per frame."""
        files = []
        for command in self.commands:
            pairs = list(zip(command, command[1:]))
            names = [word for before, word in pairs if before in ("-o", "--output")]
            frames = next((word for before, word in pairs if before == "--frames"), None)
            if frames:
                first, last = map(int, frames.split(":"))
                names = [name.replace("$frame4", f"{k:04}") for k in range(first, last + 1) for name in names]
            files += names
        return files


def read_images(page):
    """Returns the images of the page. The commands of an image are those of the last code block before it."""
    images, commands = [], []
    for block, name in re.findall(r"^```\n(.*?)^```|!\[[^]]*\]\(gallery/(\w+)\.jpg\)", page.read_text(),
                                  re.MULTILINE | re.DOTALL):
        if name:
            if not commands:
                raise ValueError(f"{page}: no code block with a command before gallery/{name}.jpg")
            images.append(GalleryImage(name, commands))
            commands = []
        else:
            lines = [shlex.split(line, comments=True) for line in block.splitlines()]
            commands = [line for line in lines if line[:1] == ["sheaf"]]
    return images


def read_scripts(page):
    """Returns the commands that write the files of scenes, as lists of words."""
    return [line.split() for line in re.findall(r"^scenes/make/make_\w+\.py.*$", page.read_text(), re.MULTILINE)]
