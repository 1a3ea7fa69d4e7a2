#!/usr/bin/env python3
"""Packs a folder with the contents of the Python package into a wheel (PEP 427). tools/packaging/make_release.sh runs it.

  tools/packaging/pack_wheel.py CONTENTS OUTPUT_FOLDER [--tag TAG] [--script FILE]

--tag: versions of Python and platforms, as in the name of the wheel. --script: a file in Python that installs as the
command `sheaf`.
Name, version, description and dependencies are those of pyproject.toml and CMakeLists.txt.
"""

import argparse
import base64
import hashlib
import re
import stat
import sys
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def value(text, pattern, file):
    found = re.search(pattern, text)
    if not found:
        sys.exit(f"pack_wheel: {file}: no text matches {pattern}")
    return found[1]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("contents", type=Path)
    parser.add_argument("output", type=Path)
    interpreter = f"cp{sys.version_info.major}{sys.version_info.minor}"
    parser.add_argument("--tag", default=f"{interpreter}-{interpreter}-linux_x86_64")
    parser.add_argument("--script", type=Path)
    arguments = parser.parse_args()
    project = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    version = value((ROOT / "CMakeLists.txt").read_text(encoding="utf-8"), r"project\(sheaf VERSION ([0-9.]+)", "CMakeLists.txt")
    tag = arguments.tag
    info = f"sheaf-{version}.dist-info"
    files = {str(path.relative_to(arguments.contents)): path.read_bytes()
             for path in sorted(arguments.contents.rglob("*")) if path.is_file() and "__pycache__" not in path.parts}
    programs = {name for name in files if (arguments.contents / name).stat().st_mode & stat.S_IXUSR}
    if arguments.script:
        script = f"sheaf-{version}.data/scripts/sheaf"
        files[script] = arguments.script.read_bytes()
        programs.add(script)
    files[f"{info}/METADATA"] = "\n".join([
        "Metadata-Version: 2.1", "Name: sheaf", f"Version: {version}",
        "Summary: " + value(project, r'description = "(.*)"', "pyproject.toml"),
        "Requires-Python: " + value(project, r'requires-python = "(.*)"', "pyproject.toml"),
        "Requires-Dist: " + value(project, r'dependencies = \["(.*)"\]', "pyproject.toml"), ""]).encode()
    files[f"{info}/WHEEL"] = f"Wheel-Version: 1.0\nGenerator: sheaf\nRoot-Is-Purelib: false\nTag: {tag}\n".encode()
    files[f"{info}/LICENSE"] = (ROOT / "LICENSE").read_bytes()
    record = [f"{name},sha256={base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b'=').decode()},{len(data)}"
              for name, data in files.items()]
    files[f"{info}/RECORD"] = "\n".join([*record, f"{info}/RECORD,,", ""]).encode()
    wheel = arguments.output / f"sheaf-{version}-{tag}.whl"
    with zipfile.ZipFile(wheel, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in files.items():
            entry = zipfile.ZipInfo(name)  # always of 1980, so that equal contents make equal wheels
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = (stat.S_IFREG | (0o755 if name in programs else 0o644)) << 16  # pip wants the type as well
            archive.writestr(entry, data)
    print(wheel)


if __name__ == "__main__":
    main()
