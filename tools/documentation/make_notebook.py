#!/usr/bin/env python3
"""Makes the tutorial on Python from docs/tutorials/python_source.py: the notebook python.ipynb with its outputs, and the
page python.md. In the source, lines `# %%` begin cells of code, and lines `# %% [markdown]` begin cells of text in comments.

  PYTHONPATH=build/release/python tools/documentation/make_notebook.py --run
  tools/documentation/make_notebook.py [--check]

--run: runs the cells for new outputs and images; needs the package sheaf and Matplotlib. Otherwise the notebook keeps the
outputs up to the first cell that has changed. --check: writes nothing; the exit status is 1 if a file differs or a cell
has not been run.
"""

import argparse
import ast
import base64
import contextlib
import io
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


def image_output(file):
    """The output of a cell that shows an image."""
    data = base64.b64encode(file.read_bytes()).decode()
    return {"output_type": "display_data", "metadata": {}, "data": {"image/jpeg": data}}


def run_cell(text, number, names):
    """Runs a cell of code as notebooks do. Returns its outputs, and writes its image, python_<number>.jpg."""
    import matplotlib.pyplot as plt
    body = ast.parse(text).body
    last = body.pop() if isinstance(body[-1], ast.Expr) else None
    printed, outputs, file = io.StringIO(), [], FOLDER / f"python_{number}.jpg"
    file.unlink(missing_ok=True)
    with contextlib.redirect_stdout(printed):
        exec(compile(ast.Module(body, []), f"cell {number}", "exec"), names)
        value = eval(compile(ast.Expression(last.value), f"cell {number}", "eval"), names) if last else None
    if printed.getvalue():
        outputs.append({"output_type": "stream", "name": "stdout", "text": printed.getvalue().splitlines(keepends=True)})
    if hasattr(value, "_repr_png_"):
        value.write(file)
    elif plt.get_fignums():
        plt.savefig(file, bbox_inches="tight", dpi=80)
    elif value is not None:
        outputs.append({"output_type": "execute_result", "execution_count": number, "metadata": {},
                        "data": {"text/plain": [repr(value)]}})
    plt.close("all")
    return outputs + ([image_output(file)] if file.exists() else [])


def run(cells):
    """The outputs of the cells of code, in order."""
    import matplotlib
    matplotlib.use("Agg")
    names = {"__name__": "__main__"}
    return [run_cell(text, number, names)
            for number, text in enumerate((text for kind, text in cells if kind == "code"), 1)]


def kept_outputs(cells):
    """The outputs in the present notebook, up to the first cell of code that has changed."""
    try:
        found = json.loads((FOLDER / "python.ipynb").read_text(encoding="utf-8"))["cells"]
    except FileNotFoundError:
        return []
    out = []
    for text, cell in zip((text for kind, text in cells if kind == "code"),
                          (cell for cell in found if cell["cell_type"] == "code")):
        if "".join(cell["source"]) != text or cell["execution_count"] is None:
            break
        out.append(cell["outputs"])
    return out


def notebook(cells, outputs):
    """outputs: of the first cells of code; the others have not been run."""
    out, count = [], 0
    for number, (kind, text) in enumerate(cells):
        cell = {"cell_type": kind, "id": f"cell-{number}", "metadata": {}, "source": text.splitlines(keepends=True)}
        if kind == "code":
            count += 1
            is_run = count <= len(outputs)
            cell |= {"execution_count": count if is_run else None, "outputs": outputs[count - 1] if is_run else []}
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
    parser.add_argument("--run", action="store_true")
    parser.add_argument("--check", action="store_true")
    arguments = parser.parse_args()
    cells = list(read_cells((FOLDER / "python_source.py").read_text(encoding="utf-8")))
    outputs = run(cells) if arguments.run else kept_outputs(cells)
    status = 0
    if arguments.check and len(outputs) < sum(kind == "code" for kind, _ in cells):
        print("cells of the tutorial have not been run: run tools/documentation/make_notebook.py --run")
        status = 1
    for name, text in (("python.ipynb", notebook(cells, outputs)), ("python.md", page(cells))):
        file = FOLDER / name
        if arguments.check and (not file.exists() or file.read_text(encoding="utf-8") != text):
            print(f"{file} differs from python_source.py: run tools/documentation/make_notebook.py")
            status = 1
        if not arguments.check:
            file.write_text(text, encoding="utf-8")
    return status


if __name__ == "__main__":
    sys.exit(main())
