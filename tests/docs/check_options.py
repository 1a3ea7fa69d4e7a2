#!/usr/bin/env python3
"""Compares the options of `sheaf` with the documentation.

  tests/docs/check_options.py --sheaf build/release/sheaf

Every option in inline code of the documents must be an option of `sheaf`, or of a script or program that the document
names. Every option in the source code of `sheaf` must be in --help of a subcommand, with a description.
Exit status: 0 all passed, 1 something failed; failures in documents name file and line.
"""

import argparse
import re
import subprocess
import sys
from pathlib import Path

from documents import ROOT, Failures, pages

OPTION = r"(?<![\w=-])--[a-z][\w-]*"
# Commands of other programs, by their first words.
OTHERS = ("cmake ", "ctest ", "podman ", "docker ", "apt-get ", "pip ", "git ", "sbatch ", "mkdocs ", "clang-tidy ",
          "python3 -m ")
# Bare options of other programs, and whose they are.
FOREIGN = {"--requeue": "sbatch", "--label-regex": "ctest", "--benchmark_filter": "Google Benchmark"}


def helps(sheaf):
    """The options of each subcommand with their descriptions."""
    text = subprocess.run([sheaf, "--help"], check=True, text=True, stdout=subprocess.PIPE).stdout
    names = re.findall(r"^  ([a-z]\w*) ", text.split("Commands:")[1].split("\n\n")[0], re.MULTILINE)
    found = {"": parsed(text)}
    for name in names:
        found[name] = parsed(subprocess.run([sheaf, "help", name], check=True, text=True,
                                            stdout=subprocess.PIPE).stdout)
    return found


def parsed(text):
    """The options of a --help text with their descriptions."""
    options, name = {}, ""
    for line in text.splitlines():
        head = re.match(r"  (?:-\w, |    )(--[\w-]+)(.*)", line)
        if head:
            name = head[1]
            # The value, then at least two spaces and the description, unless that is on the next line
            options[name] = head[2].partition("  ")[2].strip()
        elif name and line.startswith(" " * 20):
            options[name] += line.strip()
        else:
            name = ""
    return options


def known_to_programs(text):
    """The options in the source code of scripts and programs that a document names."""
    options = set()
    for name in set(re.findall(r"\b(\w+\.(?:py|sh))", text)):
        for file in (*ROOT.glob(f"tools/**/{name}"), *ROOT.glob(f"bench/{name}"), *ROOT.glob(f"tests/*/{name}"),
                     *ROOT.glob(f"scenes/make/{name}")):
            source = file.read_text()
            imported = re.findall(r"^(?:import|from) (\w+)", source, re.MULTILINE)
            modules = [file.parent / f"{module}.py" for module in imported]
            for each in (source, *(module.read_text() for module in modules if module.exists())):
                options |= set(re.findall(OPTION, each))
    for name in set(re.findall(r"\b(trace_limit|make_cloud|vdb_to_nanovdb|sheaf_bench)\b", text)):
        for source in [*ROOT.glob(f"tools/{name}*.cpp"), *ROOT.glob(f"bench/{name}*.cpp"),
                       *ROOT.glob(f"scenes/make/{name}*.cpp")]:
            options |= set(re.findall(OPTION, source.read_text()))
    return options


def check_documents(known, failures):
    """Checks the options in inline code."""
    count = 0
    for page in pages():
        text = page.read_text()
        own = known | known_to_programs(text)
        # Blocks are left to tests/docs/check_commands.py
        prose = re.sub(r"^ *```.*?^ *```", lambda block: "\n" * block[0].count("\n"), text,
                       flags=re.MULTILINE | re.DOTALL)
        for code in re.finditer(r"`([^`\n]+)`", prose):
            if code[1].startswith(OTHERS):
                continue
            for option in re.findall(OPTION, code[1]):
                count += 1
                if option not in own and option not in FOREIGN:
                    line = prose[:code.start()].count("\n") + 1
                    failures.add(f"{page.relative_to(ROOT)}:{line}",
                                 f"'{code[1]}': neither sheaf nor a program that the page names has an option {option}")
    if count == 0:
        failures.add("docs", "no option found")
    return count


def check_help(options, failures):
    """Checks that --help lists every option of the source code, with a description."""
    for command, described in options.items():
        for name, description in described.items():
            if len(description) < 10:
                failures.add(f"sheaf {command} --help", f"{name} has no description")
    listed = {name for described in options.values() for name in described}
    declared = set()
    sources = [file for kind in ("*.cpp", "*.h") for file in ROOT.glob(f"tools/*/{kind}")]
    for source in sources:
        text = source.read_text()
        for call in re.finditer(r'add_(?:option|flag|counter)\(\s*"([-\w,]+)"', text):
            for name in call[1].split(","):
                declared.add(name)
                if name.startswith("--") and name not in listed:
                    line = text[:call.start()].count("\n") + 1
                    failures.add(f"{source.relative_to(ROOT)}:{line}", f"{name} is in no --help of sheaf")
    for name in sorted(listed - declared - {"--help", "--version"}):
        failures.add("tests/docs/check_options.py", f"does not find {name} in the source code")
    return len(listed)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sheaf", type=lambda p: Path(p).resolve(), required=True)
    arguments = parser.parse_args()
    failures = Failures()
    options = helps(arguments.sheaf)
    known = {name for described in options.values() for name in described}
    mentioned = check_documents(known, failures)
    listed = check_help(options, failures)
    print(f"{mentioned} options in documents, {listed} options in --help, {failures.count} failures")
    sys.exit(1 if failures.count else 0)


if __name__ == "__main__":
    main()
