#!/usr/bin/env python3
"""Compares the parameters that the reader of pbrt's scenes asks for with docs/scene-format/pbrt.md.

  tests/docs/check_pbrt.py

Every name of a parameter in scene/dialects/pbrt/, ignored ones included, must be in inline code of the page. Every name
in the parameter columns of its tables must be in that code. Needs only Python.
Exit status: 0 all passed, 1 something failed.
"""

import argparse
import re
import sys

from documents import ROOT, Failures

PAGE = ROOT / "docs/scene-format/pbrt.md"
SOURCES = ROOT / "scene/dialects/pbrt"

# Calls that ask for a parameter: p.number("fov", ...), find_scalar_input(p, "amount"), p.ignore({"S", "faceIndices"}).
GETTERS = ("boolean", "choice", "file", "find", "find_boolean", "find_integer", "find_number", "find_string", "find_vec3",
           "has", "integer", "number", "numbers", "string", "vec3")
CALL = re.compile(rf'\b\w+\.(?:{"|".join(GETTERS)})\(\s*"(\w+)"|\((?:p|parameters), "(\w+)"|\.ignore\(\{{([^}}]*)\}}')


def names_in_code():
    """Maps the names of parameters to the files that ask for them."""
    found = {}
    for file in sorted([*SOURCES.glob("*.cpp"), *SOURCES.glob("*.h")]):
        for direct, helper, ignored in CALL.findall(file.read_text()):
            for name in re.findall(r'"(\w+)"', ignored) or [direct or helper]:
                found.setdefault(name, file.name)
    return found


def literals_in_code():
    """All words in the reader's string literals. It reads some parameters by names in lists."""
    return {word for file in SOURCES.glob("*.*") for word in re.findall(r'"(\w+)"', file.read_text())}


def words(text):
    """Words of inline code that is not an option."""
    return {word for code in re.findall(r"`([^`]+)`", text) if not code.startswith("-")
            for word in re.findall(r"[A-Za-z]\w*", code)}


def names_in_tables(text):
    """Names in the columns "parameters" of the page's tables, without the values in brackets."""
    found, column = set(), None
    for line in text.splitlines():
        cells = [cell.strip() for cell in line.strip("|").split(" | ")] if line.startswith("|") else None
        if cells is None:
            column = None
        elif "parameters" in cells:
            column = cells.index("parameters")
        elif column is not None and len(cells) > column and not cells[column].startswith("---"):
            found |= words(re.sub(r"\([^)]*\)|: `[^`]*`(, `[^`]*`)*$", "", cells[column]))
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sheaf", help="accepted as by the other checks, but not needed")
    parser.parse_args()
    failures = Failures()
    text = re.sub(r"```.*?```", "", PAGE.read_text(), flags=re.DOTALL)
    known, documented, listed, literals = names_in_code(), words(text), names_in_tables(text), literals_in_code()
    if len(known) < 100 or len(listed) < 50:
        failures.add(PAGE, "found too few parameters to compare")
    for name, file in sorted(known.items()):
        if name not in documented:
            failures.add(PAGE, f"lacks the parameter '{name}' of scene/dialects/pbrt/{file}")
    for name in sorted(listed - literals):
        failures.add(PAGE, f"lists the parameter '{name}', which scene/dialects/pbrt/ does not read")
    print(f"{len(known)} parameters in the code, {len(listed)} in tables")
    sys.exit(1 if failures.count else 0)


if __name__ == "__main__":
    main()
