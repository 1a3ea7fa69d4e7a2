"""The Markdown files of the documentation, and their fenced blocks."""

import re
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent


def pages():
    """All documents that the tests read."""
    others = [ROOT / name for name in ("README.md", "CONTRIBUTING.md", "bench/README.md")]
    return sorted((ROOT / "docs").rglob("*.md")) + others


@dataclass
class Block:
    """A fenced block of a document."""
    page: Path
    line: int        # of its first line, counted from 1
    language: str    # after the opening fence; may be empty
    text: str
    before: str      # the text above it, up to the previous block
    skip: str        # the reason in the comment <!-- not tested: REASON --> above it, or empty

    @property
    def place(self):
        return f"{self.page.relative_to(ROOT)}:{self.line}"


def blocks(page):
    """The fenced blocks of a document, in order."""
    found, opening, before = [], None, []
    for number, line in enumerate(page.read_text().splitlines(), 1):
        fence = re.match(r"( *)(```+) *([\w+-]*)", line)
        if opening is not None:
            indent, marks, language, first, lines = opening
            if fence and fence[2] == marks and not fence[3]:
                above = "\n".join(before)
                skip = re.search(r"<!-- not tested: (.+?) -->\s*$", above, re.DOTALL)
                found.append(Block(page, first, language, "\n".join(lines), above, skip[1] if skip else ""))
                opening, before = None, []
            else:
                lines.append(line.removeprefix(indent))
        elif fence:
            opening = (fence[1], fence[2], fence[3], number + 1, [])
        else:
            before.append(line)
    if opening is not None:
        raise ValueError(f"{page}:{opening[3] - 1}: the block has no end")
    return found


class Failures:
    """Prints failures and counts them."""

    def __init__(self):
        self.count = 0

    def add(self, place, why):
        self.count += 1
        print(f"FAILED {place}: {why}", flush=True)
