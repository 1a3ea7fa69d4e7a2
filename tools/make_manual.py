#!/usr/bin/env python3
"""Writes manual pages and a bash completion from the output of `sheaf --help` and `sheaf COMMAND --help`.

  tools/make_manual.py --sheaf build/release/sheaf --output build/release/manual

Writes sheaf.1, sheaf-COMMAND.1 for each subcommand, and sheaf.bash to the output folder. Fails if it cannot parse the
help. Needs only Python.
"""

import argparse
import re
import subprocess
from dataclasses import dataclass, field
from pathlib import Path

# An option in the help: names, value type, limits, and number of values.
SPEC = re.compile(r"(?P<names>-[^ ]+|[A-Za-z][\w-]*)(?: (?P<value>[A-Z]+)(?P<limits>:\S+(?: in \[[^\]]*\])?)?)?"
                  r"(?P<count> x \d+)?(?P<rest>(?: \.\.\.| REQUIRED)*)$")

# Section titles of manual pages that are not just the capitalised title of the help.
TITLES = {"Positionals": "ARGUMENTS", "Subcommands": "COMMANDS"}


@dataclass
class Entry:
    """An option, a positional argument or a subcommand."""
    names: list
    value: str = ""  # TEXT, INT ...; empty: none
    limits: str = ""  # e.g. ":{rgb,spectral}"
    count: str = ""
    repeats: bool = False
    required: bool = False
    text: str = ""

    def choices(self):
        inside = re.fullmatch(r":\{(.*)\}", self.limits)
        return inside.group(1).split(",") if inside else []

    def takes_files(self):
        """Returns True for free text: the help does not distinguish file names from other text."""
        return self.value == "TEXT" and not self.choices()


@dataclass
class Help:
    text: str = ""
    usage: str = ""
    sections: dict = field(default_factory=dict)  # e.g. "Options" -> list of Entry
    footer: list = field(default_factory=list)


def make_entry(spec):
    match = SPEC.fullmatch(spec)
    if not match:
        raise SystemExit(f"make_manual: cannot parse '{spec}'")
    return Entry(match["names"].split(","), match["value"] or "", match["limits"] or "", match["count"] or "",
                 "..." in match["rest"], "REQUIRED" in match["rest"])


def read_help(sheaf, command):
    words = [sheaf] + ([command] if command else []) + ["--help"]
    lines = subprocess.run(words, check=True, capture_output=True, text=True).stdout.splitlines()
    page, section, entry = Help(), None, None
    for line in lines:
        if line.startswith("Usage: "):
            page.usage = line.removeprefix("Usage: ")
        elif re.fullmatch(r"[A-Z]\w+:", line):
            section = page.sections.setdefault(line[:-1], [])
        elif section is not None and re.match(r"  \S", line):
            spec, _, text = line.strip().partition("  ")
            # A name that just fits its column is followed by a single space.
            if not text and not SPEC.fullmatch(spec):
                spec, text = line[:29].strip(), line[30:]
            entry = make_entry(spec)
            entry.text = text.strip()
            section.append(entry)
        elif entry is not None and line.startswith(" " * 30):
            entry.text = f"{entry.text} {line.strip()}".strip()
        elif line and section is None:
            page.text = f"{page.text} {line}".strip()
        elif line:
            page.footer.append(line)
    if not page.text or not page.usage or not page.sections.get("Options"):
        raise SystemExit(f"make_manual: cannot parse the help of '{' '.join(words)}'")
    for entries in page.sections.values():
        for each in entries:
            if not each.text:
                raise SystemExit(f"make_manual: '{each.names[0]}' of '{' '.join(words)}' has no description")
    return page


def read_all_help(sheaf):
    """Returns the help of the program, and that of each subcommand by its name."""
    program = read_help(sheaf, "")
    commands = [entry.names[0] for entry in program.sections.get("Subcommands", [])]
    if not commands:
        raise SystemExit("make_manual: the help lists no subcommands")
    return program, {command: read_help(sheaf, command) for command in commands}


def roff(text):
    """Escapes text for a line of roff."""
    text = text.replace("\\", "\\e").replace("-", "\\-")
    return "\\&" + text if text.startswith((".", "'")) else text


def roff_entry(entry):
    names = ", ".join(f"\\fB{roff(name)}\\fR" for name in entry.names)
    value = ""
    if entry.choices():
        value = " " + "|".join(f"\\fB{roff(word)}\\fR" for word in entry.choices())
    elif entry.value:
        limits = re.search(r"\[(.*) - (.*)\]", entry.limits)
        value = f" \\fI{entry.value.lower()}\\fR"
        if limits:
            value += roff(f" ({limits[1]} to {limits[2]})")
        elif entry.limits == ":POSITIVE":
            value += " (above 0)"
    return f".TP\n{names}{value}{roff(entry.count)}{' ...' if entry.repeats else ''}\n{roff(entry.text)}\n"


def manual_page(version, command, page, commands):
    name = f"sheaf-{command}" if command else "sheaf"
    title = page.text.split(". ")[0].rstrip(".")
    out = [f'.TH {name.upper()} 1 "" "{version}" "User Commands"', ".SH NAME", f"{name} \\- {roff(title)}",
           ".SH SYNOPSIS", f".B {roff(page.usage)}", ".SH DESCRIPTION", roff(page.text)]
    for section, entries in page.sections.items():
        out.append(f".SH {TITLES.get(section, section.upper())}")
        out.append("".join(roff_entry(entry) for entry in entries).rstrip("\n"))
    if page.footer:
        out += [".SH EXIT STATUS", roff(" ".join(page.footer).removeprefix("Exit codes: "))]
    others = ["sheaf"] * bool(command) + [f"sheaf-{each}" for each in commands if each != command]
    out += [".SH SEE ALSO", ", ".join(f"\\fB{roff(each)}\\fR(1)" for each in others)]
    return "\n".join(out) + "\n"


def words_of(entries):
    return " ".join(name for entry in entries for name in entry.names)


def completion(program, pages):
    """Returns a bash completion function. It completes option values from their list of choices, if there is one, and
    other text as file names; it does not complete numbers."""
    out = ["# bash completion for sheaf, written by tools/make_manual.py.",
           '_sheaf_words() { mapfile -t COMPREPLY < <(compgen -W "$1" -- "$word"); }',
           '_sheaf_files() { mapfile -t COMPREPLY < <(compgen -f -- "$word"); compopt -o filenames 2>/dev/null; }',
           "_sheaf() {",
           '  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} command="" i',
           "  COMPREPLY=()",
           '  if [[ $word == "=" ]]; then word=""',
           '  elif [[ $before == "=" ]]; then before=${COMP_WORDS[COMP_CWORD-2]}; fi',
           "  for ((i = 1; i < COMP_CWORD; i++)); do",
           f"    case ${{COMP_WORDS[i]}} in {'|'.join(pages)}) command=${{COMP_WORDS[i]}}; break ;; esac", "  done",
           "  case $command in"]
    for command, page in pages.items():
        out += [f"    {command})", "      case $before in"]
        for entry in page.sections["Options"]:
            pattern = "|".join(entry.names)
            if entry.choices():
                out.append(f'        {pattern}) _sheaf_words "{" ".join(entry.choices())}"; return ;;')
            elif entry.takes_files():
                out.append(f"        {pattern}) _sheaf_files; return ;;")
            elif entry.value:
                out.append(f"        {pattern}) return ;;")
        out += ["      esac",
                f'      if [[ $word == -* ]]; then _sheaf_words "{words_of(page.sections["Options"])}"',
                "      else _sheaf_files; fi ;;"]
    first = words_of(program.sections["Subcommands"]) + " " + words_of(program.sections["Options"])
    out += [f'    *) _sheaf_words "{first}" ;;', "  esac", "}", "complete -F _sheaf sheaf"]
    return "\n".join(out) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sheaf", required=True, help="the sheaf executable")
    parser.add_argument("--output", type=Path, required=True, help="output folder, created if missing")
    arguments = parser.parse_args()
    version = subprocess.run([arguments.sheaf, "--version"], check=True, capture_output=True, text=True).stdout
    version = " ".join(version.split()[:2])
    program, pages = read_all_help(arguments.sheaf)
    arguments.output.mkdir(parents=True, exist_ok=True)
    for command, page in {"": program, **pages}.items():
        name = f"sheaf-{command}.1" if command else "sheaf.1"
        (arguments.output / name).write_text(manual_page(version, command, page, pages))
    (arguments.output / "sheaf.bash").write_text(completion(program, pages))


if __name__ == "__main__":
    main()
