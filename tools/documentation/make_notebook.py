#!/usr/bin/env python3
"""Makes the tutorial on Python from docs/tutorials/python_source.py: the notebook python.ipynb and the page python.md. In
the source, lines `# %%` begin cells of code, and lines `# %% [markdown]` begin cells of text in comments.

  tools/documentation/make_notebook.py [--check]

--check: writes nothing; the exit status is 1 if a file differs.
"""

import argparse
import json
import re
import sys
from pathlib import Path

FOLDER = Path(__file__).resolve().parents[2] / "docs/tutorials"


def read_cells(text):
    """Pairs of kind (markdown or code) and text."""
    for part in re.split(r"^# %%", text, flags=re.MULTILINE)[1:]:
        head, body = part.split("\n", 1)
        if head.strip() == "[markdown]":
            yield "markdown", re.sub(r"^# ?", "", body, flags=re.MULTILINE).strip()
        else:
            yield "code", body.strip()


def notebook(cells):
    out = []
    for number, (kind, text) in enumerate(cells):
        cell = {"cell_type": kind, "id": f"cell-{number}", "metadata": {}, "source": text.splitlines(keepends=True)}
        if kind == "code":
            cell |= {"execution_count": None, "outputs": []}
        out.append(cell)
    metadata = {"kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"},
                "language_info": {"name": "python"}}
    return json.dumps({"cells": out, "metadata": metadata, "nbformat": 4, "nbformat_minor": 5}, indent=1) + "\n"


def page(cells):
    """Images that exist beside the page, python_<number of the cell>.jpg, follow their cells."""
    out, number = [], 0
    for kind, text in cells:
        if kind == "markdown":
            out.append(text)
            title = text.splitlines()[0].lstrip("# ") if text.startswith("#") else "Result"
            continue
        number += 1
        out.append(f"```python\n{text}\n```")
        if (FOLDER / f"python_{number}.jpg").exists():
            out.append(f"![{title}](python_{number}.jpg)")
    return "\n\n".join(out) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true")
    check = parser.parse_args().check
    cells = list(read_cells((FOLDER / "python_source.py").read_text(encoding="utf-8")))
    status = 0
    for name, text in (("python.ipynb", notebook(cells)), ("python.md", page(cells))):
        file = FOLDER / name
        if check and (not file.exists() or file.read_text(encoding="utf-8") != text):
            print(f"{file} differs from python_source.py: run tools/documentation/make_notebook.py")
            status = 1
        if not check:
            file.write_text(text, encoding="utf-8")
    return status


if __name__ == "__main__":
    sys.exit(main())
