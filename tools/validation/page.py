"""Writes docs/validation.md and its images."""

import re
import struct
import zlib

import numpy as np

INTRODUCTION = """# Validation

`tools/validation/validate.py` renders the scenes of [scenes/validation](../scenes/validation) with Sheaf and with other renderers,
or compares them with closed forms. It needs a build, Python with numpy, and Mitsuba 3 (`pip install mitsuba`):

```
scenes/make/make_validation_scenes.py
tools/validation/validate.py --mitsuba-python ENVIRONMENT/bin/python
```

`--list` lists the rows, `--only NAME ...` selects some of them, `--pbrt PROGRAM` adds pbrt-v4. The exit status is 1
if a row fails.

This page was written by Sheaf {sheaf} and {others}, with {threads}. Both renderers read the
same files. Mitsuba's variant is `{variant}`.

- **ratio of means**: the mean of Sheaf's image over that of the reference.
- **relative MSE**: the mean of (a - b)^2 / (b^2 + 0.01) over pixels and channels. In parentheses: its expectation if
  both images differ by their noise alone.
- **largest z, p**: Welch's t-test compares the means of each block of {block} x {block} pixels and of the frame, for
  each channel. Some rows state larger blocks. Variances come from {replicates} independent sets of samples, or from
  several renders. z is the quantile of the normal distribution for the smallest p-value. p is this value times the
  number of tests in the line (Bonferroni). With {tests} lines, a line fails if p < {level:.2g}, so that a correct
  renderer fails anywhere with a probability of about {significance:.0%}. The test assumes that block means are normally
  distributed. It ignores relative differences below 0.2 %. Lines without p are biased by design: their ratio of means
  and relative MSE have limits instead.
- **CPU time**: seconds of all threads together. Sheaf and Mitsuba take the same samples per pixel, unless a row says
  otherwise. Mitsuba's variant `llvm_ad_rgb` takes less than `scalar_rgb`; [bench/README.md](../bench/README.md)
  compares with it.

Sheaf renders with its default sampler and Mitsuba with `independent`, unless a row says otherwise. All images have a
box filter, so that pixels are independent.
"""

OTHER_DIFFERENCES = """## Other differences

The scenes avoid two differences, which would hide others:

- **`roughplastic`**: Mitsuba's diffuse part is up to 2 % darker. Example: a coat of `alpha` 0.2 without specular
  reflection, on a base of albedo 0.4, under an environment of radiance 1, at normal incidence. Mitsuba's radiance is
  0.3573 and Sheaf's 0.3634. Integrating the coat's transmittance and internal reflectance numerically gives 0.3637.
- **`rotate`**: Mitsuba 3 does not normalize the axis, so a rotation around (1, 1, 0) also stretches. Sheaf
  normalizes it.
"""


def tone_map(image, exposure):
    """Linear Rec. 709 to 8-bit sRGB."""
    v = np.clip(image * exposure, 0, 1)
    return np.round(255 * np.where(v <= 0.0031308, 12.92 * v, 1.055 * v ** (1 / 2.4) - 0.055)).astype(np.uint8)


def write_png(path, image):
    height, width, _ = image.shape
    raw = b"".join(b"\0" + line.tobytes() for line in image)

    def chunk(kind, data):
        body = kind + data
        return struct.pack(">I", len(data)) + body + struct.pack(">I", zlib.crc32(body))

    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">2I5B", width, height, 8, 2, 0, 0, 0)) +
                     chunk(b"IDAT", zlib.compress(raw, 9)) + chunk(b"IEND", b""))


def write_images(images, folder, mitsuba):
    """Writes {name: 8-bit array}, as JPEG with Mitsuba or else as PNG. Returns the file extension."""
    folder.mkdir(parents=True, exist_ok=True)
    for name in images:
        for extension in ("jpg", "png"):
            (folder / f"{name}.{extension}").unlink(missing_ok=True)
    if mitsuba:
        mitsuba.encode(images, folder)
        return "jpg"
    for name, image in images.items():
        write_png(folder / f"{name}.png", image)
    return "png"


def table(head, lines):
    return "\n".join(f"| {' | '.join(cells)} |" for cells in [head, ["---"] * len(head), *lines]) + "\n"


def seconds(value):
    return "" if value is None else f"{value:.1f} s"


def result_cells(result):
    """Cells of the table of measures for one result."""
    m = result.measures
    if m is None:
        return [result.label, result.reference, "", "", "", "", seconds(result.seconds), "", result.verdict]
    error = f"{m.relative_mse:.2g}"
    if m.expected_mse is not None:
        error += f" ({m.expected_mse:.2g})"
    z, p = ("", "") if m.p is None or not result.is_tested else (f"{m.largest_z:.1f}", f"{m.p:.2g}")
    return [result.label, result.reference, f"{m.mean_ratio:.4f}", error, z, p, seconds(result.seconds),
            seconds(result.reference_seconds), result.verdict]


def row_section(row, results, extension):
    """The section of a row: text, images and measures."""
    parts = [f"## {row.title}\n", row.text + "\n"]
    if row.difference:
        parts.append(f"**Differences by design.** {row.difference}\n")
    labels = list(dict.fromkeys(result.label for result in results))
    references = list(dict.fromkeys(r.reference for r in results if r.reference_picture))
    lines = []
    for label in labels:
        of_label = [r for r in results if r.label == label]
        shown = {r.reference: r.reference_picture for r in of_label if r.reference_picture}
        images = [of_label[0].image, *(shown.get(reference, "") for reference in references)]
        names = ["Sheaf", *references]
        lines.append([label] + [f"![{label}, {n}](validation/{p}.{extension})" if p else ""
                                for n, p in zip(names, images)])
    parts.append(table(["", "Sheaf", *references], lines))
    parts.append(table(["", "reference", "ratio of means", "relative MSE", "largest z", "p", "CPU time", "reference's",
                        "result"], [result_cells(r) for r in results]))
    return "\n".join(parts)


def summary_cells(row, results):
    """Link, references, number of lines, and the worst verdict of a row."""
    verdicts = [r.verdict for r in results]
    worst = "fails" if "fails" in verdicts else "passes" if "passes" in verdicts else "not run"
    anchor = row.title.lower().replace(" ", "-").replace("'", "")
    references = ", ".join(dict.fromkeys(r.reference.replace(", 1024 spp", "") for r in results))
    return [f"[{row.title}](#{anchor})", references, str(len(results)), worst]


def write_page(path, rows, results, extension, facts):
    """Writes the page; `facts` fills the introduction."""
    summary = [summary_cells(row, results[row.name]) for row in rows]
    parts = [INTRODUCTION.format(**facts), table(["row", "references", "lines", "result"], summary)]
    parts += [row_section(row, results[row.name], extension) for row in rows]
    parts.append(OTHER_DIFFERENCES)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join(parts))


def update_page(path, rows, results, extension):
    """Replaces the sections of some rows, and their lines in the summary, in an existing page."""
    text = path.read_text()
    for row in rows:
        section = row_section(row, results[row.name], extension) + "\n"
        line = f"| {' | '.join(summary_cells(row, results[row.name]))} |"
        title = re.escape(row.title)
        text = re.sub(rf"^## {title}\n.*?(?=^## |\Z)", lambda _, new=section: new, text, flags=re.MULTILINE | re.DOTALL)
        text = re.sub(rf"^\| \[{title}\]\(#.*$", lambda _, new=line: new, text, flags=re.MULTILINE)
    path.write_text(text)
