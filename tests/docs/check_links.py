#!/usr/bin/env python3
"""Checks every link, anchor and image of the documentation: in the Markdown files, as a code host shows them, and in
the site that `mkdocs build --strict` makes from them.

  tests/docs/check_links.py --sheaf build/release/sheaf [--site FOLDER]

--site: checks this site instead of building one. Links to other hosts are not followed, but pages that load anything
from another host are an error. Without mkdocs and its theme only the Markdown files are checked, and "skipped: " is
printed. Exit status: 0 all links lead somewhere, 1 some do not, or the site cannot be built.
"""

import argparse
import os
import posixpath
import re
import shutil
import subprocess
import sys
import tempfile
from functools import lru_cache
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "tools/documentation"))

import markdown_source  # noqa: E402

# Folders of the repository without documentation.
IGNORED = {".git", "build", "out", "generated"}


class Page(HTMLParser):
    """A page of the site: its anchors, its links and images, and the files that it loads."""

    LOADED = {"script": "src", "img": "src", "source": "src", "video": "src", "iframe": "src"}

    def __init__(self, path):
        super().__init__()
        self.anchors, self.links, self.loaded = set(), [], []
        self.feed(path.read_text())

    def handle_starttag(self, tag, attrs):
        attributes = dict(attrs)
        self.anchors |= {attributes[name] for name in ("id", "name") if attributes.get(name)}
        if tag == "a" and attributes.get("href"):
            self.links.append(attributes["href"])
        if tag == "link" and attributes.get("rel") not in ("canonical", "prev", "next"):
            self.loaded.append(attributes.get("href") or "")
        if attributes.get(self.LOADED.get(tag, "")):
            self.loaded.append(attributes[self.LOADED[tag]])


def tracked_files():
    """Returns the paths of all files that a code host has, relative to the repository."""
    if (ROOT / ".git").exists() and shutil.which("git"):
        found = subprocess.run(["git", "-c", "safe.directory=*", "ls-files", "-z", "--cached", "--others",
                                "--exclude-standard"], cwd=ROOT, check=True, capture_output=True, text=True).stdout
        return {path for path in found.split("\0") if path and (ROOT / path).exists()}
    return {str(path.relative_to(ROOT)) for path in ROOT.rglob("*")
            if path.is_file() and not IGNORED & set(path.relative_to(ROOT).parts)}


def check_markdown(files):
    """Yields a message for each dead link in Markdown files."""
    folders = {str(parent) for path in files for parent in Path(path).parents}
    anchors = lru_cache(maxsize=None)(lambda path: markdown_source.anchors((ROOT / path).read_text()))
    for path in sorted(path for path in files if path.endswith(".md")):
        for target in markdown_source.targets((ROOT / path).read_text()):
            link = urlsplit(target)
            if link.scheme or link.netloc:
                continue
            there = posixpath.join(posixpath.dirname(path), unquote(link.path)) if link.path else path
            there = posixpath.normpath(there)
            if there not in files and there not in folders:
                yield f"{path}: {target}: no such file"
            elif link.fragment and there.endswith(".md") and anchors(there).count(link.fragment) != 1:
                yield f"{path}: {target}: {anchors(there).count(link.fragment)} headings with this anchor"


def check_site(site):
    """Yields a message for each dead link in the pages of the site, and for each file that is loaded from elsewhere."""
    parsed = lru_cache(maxsize=None)(Page)
    for path in sorted(site.rglob("*.html")):
        page = parsed(path)
        name = path.relative_to(site)
        # The error page is shown at any address, so its links begin at the root.
        base = site if name == Path("404.html") else path.parent
        for target in page.links + page.loaded:
            link = urlsplit(target)
            if link.scheme == "data" or link.scheme == "mailto":
                continue
            if link.scheme or link.netloc:
                if target in page.loaded:
                    yield f"{name}: loads {target} from another host"
                continue
            there = Path(os.path.normpath(base / unquote(link.path).lstrip("/"))) if link.path else path
            there = there / "index.html" if there.is_dir() else there
            if not there.is_file():
                yield f"{name}: {target}: no such file"
            elif link.fragment and there.suffix == ".html" and unquote(link.fragment) not in parsed(there).anchors:
                yield f"{name}: {target}: no such anchor"
    for path in sorted(site.rglob("*.css")):
        for target in re.findall(r"url\(['\"]?((?:https?:)?//[^)'\"]+)", path.read_text()):
            yield f"{path.relative_to(site)}: loads {target} from another host"


def mkdocs_command():
    """Returns the command of mkdocs if it and its theme Material are installed, otherwise None."""
    for python in (sys.executable, "/usr/bin/python3"):
        script = "import pymdownx; from mkdocs.utils import get_theme_names; print(*get_theme_names())"
        done = subprocess.run([python, "-c", script], check=False, capture_output=True, text=True)
        if done.returncode == 0 and "material" in done.stdout.split():
            return [python, "-m", "mkdocs"]
    return None


def build_site(command, sheaf, folder):
    """Builds the site, and returns the errors and warnings of mkdocs if that fails."""
    done = subprocess.run([*command, "build", "--strict", "--site-dir", folder], cwd=ROOT, check=False,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          env=dict(os.environ, SHEAF=str(sheaf), PYTHONDONTWRITEBYTECODE="1"))
    if done.returncode == 0:
        return []
    lines = done.stdout.splitlines()
    return [line for line in lines if re.search(r"WARNING|ERROR|Error|Abort", line)] or lines


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sheaf", type=lambda p: Path(p).resolve(), default=ROOT / "build/release/sheaf")
    parser.add_argument("--site", type=Path, help="folder of a site that has been built")
    arguments = parser.parse_args()
    files = tracked_files()
    messages = list(check_markdown(files))
    mkdocs = mkdocs_command()
    with tempfile.TemporaryDirectory() as folder:
        site = arguments.site or Path(folder)
        if not arguments.site and mkdocs:
            messages += build_site(mkdocs, arguments.sheaf, site)
        pages = len(list(site.rglob("*.html")))
        messages += check_site(site)
    for message in messages:
        print(f"links: {message}")
    if messages:
        sys.exit(1)
    if not pages:
        print("skipped: the site, because mkdocs or its theme Material is not installed")
        return
    print(f"links: {sum(path.endswith('.md') for path in files)} Markdown files and {pages} pages have no dead links")


if __name__ == "__main__":
    main()
