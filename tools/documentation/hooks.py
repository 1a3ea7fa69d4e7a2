"""Hooks of MkDocs: adds the pages that are made from other sources, and rewrites links for the site.

Links in the sources are those of a code host, relative to the file. Targets that are not part of the site become text.
The environment variable SHEAF names the executable whose help becomes the pages of the command line; the default is
build/release/sheaf.
"""

import os
import posixpath
import re
import sys
import tempfile
from pathlib import Path

from mkdocs.exceptions import PluginError
from mkdocs.structure.files import File

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "tools/documentation"))

import command_pages  # noqa: E402
import make_manual  # noqa: E402
import markdown_source  # noqa: E402

# Pages of the site whose sources lie outside of docs/.
OUTSIDE = {
    "benchmarks.md": "bench/README.md",
    "changelog.md": "CHANGELOG.md",
    "contributing.md": "CONTRIBUTING.md",
    "fuzzing.md": "tests/fuzz/README.md",
}

# Files of the repository that a page of the site replaces.
REPLACED = {source: page for page, source in OUTSIDE.items()} | {"README.md": "index.md"}

# Text that becomes a link wherever it stands alone as code.
COMMAND = re.compile(r"(?<!\[)`sheaf (?:([a-z]+) )?--help`")

# Links whose text is the name of a file. On the site it becomes the title of the page.
FILE_LINK = re.compile(r"\[([\w/.-]+\.md)\]\(([^()#\s]+\.md)\)")

# Holds the generated pages while the site is built.
GENERATED = tempfile.TemporaryDirectory(prefix="sheaf_site_")  # pylint: disable=consider-using-with


def repository_path(page):
    """Returns the path in the repository from which a page's links are relative."""
    return OUTSIDE.get(page, f"docs/{page}")


def site_target(page, target, pages):
    """Returns the target of a link for the site, relative to the page. None if it is not part of the site."""
    path, mark, fragment = target.partition("#")
    if not path or ":" in path:
        return target
    path = posixpath.normpath(posixpath.join(posixpath.dirname(repository_path(page)), path))
    found = REPLACED.get(path)
    if not found and path.startswith("docs/"):
        found = path.removeprefix("docs/")
    if not found and (ROOT / path).exists():
        return None
    # Unknown targets remain, so that MkDocs reports them.
    if found not in pages:
        return target
    return posixpath.relpath(found, posixpath.dirname(page) or ".") + mark + fragment


def generate_pages():
    """Writes the pages that are not in docs/ to the temporary folder, and returns their names."""
    sheaf = Path(os.environ.get("SHEAF", ROOT / "build/release/sheaf"))
    if not sheaf.exists():
        raise PluginError(f"{sheaf} does not exist: build Sheaf, or set SHEAF to the executable")
    pages = {f"command-line/{name}": text
             for name, text in command_pages.command_pages(*make_manual.read_all_help([sheaf])).items()}
    pages |= {page: (ROOT / path).read_text() for page, path in OUTSIDE.items()}
    for name, text in pages.items():
        path = Path(GENERATED.name, name)
        path.parent.mkdir(exist_ok=True)
        path.write_text(text)
    return list(pages)


def on_files(files, config):
    for name in generate_pages():
        files.append(File(name, GENERATED.name, config["site_dir"], config["use_directory_urls"]))
    return files


def on_nav(nav, config, files):
    missing = {file.src_uri for file in files.documentation_pages()} - {page.file.src_uri for page in nav.pages}
    if missing:
        raise PluginError(f"pages that the nav of mkdocs.yml lacks: {', '.join(sorted(missing))}")


def on_page_markdown(markdown, page, config, files):
    name = page.file.src_uri
    # The sidebar of a page outside of sections would list this page alone.
    if page.parent is None:
        page.meta["hide"] = ["navigation", "toc"] if name == "index.md" else ["navigation"]
    pages = set(files.src_uris)

    def command_link(match):
        target = f"command-line/{match[1] or 'index'}.md"
        return f"[{match[0]}]({posixpath.relpath(target, posixpath.dirname(name) or '.')})"

    def title_link(match):
        target = files.get_file_from_path(posixpath.normpath(posixpath.join(posixpath.dirname(name), match[2])))
        title = re.search(r"^# (.*)", Path(target.abs_src_path).read_text(), re.MULTILINE) if target else None
        return f"[{title[1]}]({match[2]})" if title else match[0]

    text = markdown_source.replace_targets(markdown, lambda target: site_target(name, target, pages))
    for pattern, link in ((COMMAND, command_link), (FILE_LINK, title_link)):
        text = "".join(block if is_code else pattern.sub(link, block)
                       for block, is_code in markdown_source.blocks(text))
    return markdown_source.indent_lists(text)


def on_page_content(html, page, config, files):
    """Links each image that is not a link to its file in full size."""
    parts = re.split(r"(<a .*?</a>)", html, flags=re.DOTALL)
    return "".join(part if part.startswith("<a ") else
                   re.sub(r"<img [^>]*?src=\"([^\"]+)\"[^>]*>", r'<a class="image" href="\1">\g<0></a>', part)
                   for part in parts)
