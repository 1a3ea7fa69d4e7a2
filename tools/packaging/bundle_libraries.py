#!/usr/bin/env python3
"""Makes a folder of programs and libraries independent of the machine: copies the shared libraries that they need into
it, except those of glibc, and makes all of them search there only. Works on files of other processors as well. Needs
readelf, patchelf, and on Debian dpkg for the licenses.

  tools/packaging/bundle_libraries.py FOLDER [--into lib] [--search DIR]... [--licenses LICENSES] [--keep NAME]...

LICENSES receives the copyright file of the package of each copied library, the licenses that these files refer to, and
a list of the libraries with their versions. Rerunning it changes nothing. Exit status: 1 if a library is missing.
"""

import argparse
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

# Libraries of glibc, which every Linux system has: its versions are compatible with programs of older ones.
GLIBC = r"(ld-linux.*|lib(c|m|dl|pthread|rt|util|resolv|anl|nsl|mvec|thread_db))\.so\.\d+"
COMMON_LICENSES = Path("/usr/share/common-licenses")


def output_of(*command):
    return subprocess.run([str(word) for word in command], check=True, capture_output=True, text=True).stdout


def is_elf(file):
    with open(file, "rb") as content:
        return content.read(4) == b"\x7fELF"


def elf_files(folder):
    return sorted(file for file in folder.rglob("*") if file.is_file() and not file.is_symlink() and is_elf(file))


def needed(file):
    """The names of the libraries that a file needs directly."""
    return re.findall(r"\(NEEDED\).*\[(.*)\]", output_of("readelf", "--dynamic", "--wide", file))


def copy_libraries(folder, libraries, search, keep):
    """Copies what the files in the folder need, directly or not. Returns the copied files by name."""
    copied = {}
    waiting = elf_files(folder)
    present = {file.name for file in waiting}
    while waiting:
        file = waiting.pop()
        for name in needed(file):
            if name in present or keep.fullmatch(name):
                continue
            source = next((place / name for place in search if (place / name).exists()), None)
            if source is None:
                sys.exit(f"bundle: {file} needs {name}, which is missing")
            target = libraries / name
            shutil.copy(source.resolve(), target)
            target.chmod(0o644)
            copied[name] = source.resolve()
            present.add(name)
            waiting.append(target)
    return copied


def copy_licenses(copied, licenses):
    """Copies the license of the package that installed each library. Packages have the same one for each processor."""
    licenses.mkdir(parents=True, exist_ok=True)
    lines = []
    for name, source in sorted(copied.items()):
        owner = subprocess.run(["dpkg", "--search", f"*/{source.name}"], capture_output=True, text=True,
                               check=False).stdout
        if not owner:
            sys.exit(f"bundle: no package owns {source.name}, so its license is unknown")
        package = owner.split(":", 1)[0]
        version, origin = output_of("dpkg-query", "--show", "--showformat=${Version}\t${source:Package}\n",
                                    package).splitlines()[0].split("\t")
        shutil.copy(f"/usr/share/doc/{package}/copyright", licenses / f"{package}.txt")
        lines.append(f"{name}: {package}.txt, Debian's source package {origin}, version {version}\n")
    (licenses / "libraries.txt").write_text("".join(lines), encoding="utf-8")


def copy_common_licenses(licenses):
    """Copies the licenses in /usr/share/common-licenses to which the copyright files refer."""
    for file in licenses.glob("*.txt"):
        for name in re.findall(rf"{COMMON_LICENSES}/([\w.+-]*\w)", file.read_text(encoding="utf-8", errors="replace")):
            if (COMMON_LICENSES / name).is_file():
                shutil.copy((COMMON_LICENSES / name).resolve(), licenses / name)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--into", default="lib", help="folder of the libraries, relative to FOLDER")
    parser.add_argument("--search", type=Path, action="append", help="folder to search for libraries")
    parser.add_argument("--licenses", type=Path)
    parser.add_argument("--keep", action="append", default=[], metavar="NAME",
                        help="library of the system that is not copied, besides those of glibc")
    arguments = parser.parse_args()
    folder = arguments.folder.resolve()
    libraries = folder / arguments.into
    libraries.mkdir(parents=True, exist_ok=True)
    search = arguments.search or [Path("/usr/lib") / output_of("gcc", "-print-multiarch").strip(), Path("/usr/lib")]
    keep = re.compile("|".join([GLIBC, *map(re.escape, arguments.keep)]))

    copied = copy_libraries(folder, libraries, search, keep)
    if arguments.licenses and copied:
        copy_licenses(copied, arguments.licenses)
        copy_common_licenses(arguments.licenses)
    for file in elf_files(folder):
        if needed(file):
            place = os.path.relpath(libraries, file.parent)
            subprocess.run(["patchelf", "--set-rpath", "$ORIGIN" if place == "." else f"$ORIGIN/{place}", file],
                           check=True)
    print(f"bundle: {len(copied)} libraries copied to {libraries}")


if __name__ == "__main__":
    main()
