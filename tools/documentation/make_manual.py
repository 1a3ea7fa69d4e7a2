#!/usr/bin/env python3
"""Writes manual pages and the completion scripts of shells from `sheaf help --json` and `sheaf completion SHELL`.

  tools/documentation/make_manual.py --sheaf build/release/sheaf --output build/release/manual

Writes sheaf.1, sheaf-COMMAND.1 for each subcommand, sheaf.bash, sheaf.zsh and sheaf.fish to the output folder. Fails if
an option has no description. Needs only Python.
"""

import argparse
import json
import subprocess
from dataclasses import dataclass, field
from pathlib import Path

SHELLS = ("bash", "zsh", "fish")


@dataclass
class Entry:
    """An option or a positional argument."""
    names: list
    text: str
    group: str
    kind: str  # "none", "integer", "number", "time", "text", "file" or "folder"
    placeholder: str
    words: list
    only_words: bool
    positive: bool
    count: int
    repeats: bool
    required: bool
    argument: bool
    min: float = None
    max: float = None

    def choices(self):
        return self.words if self.only_words else []


@dataclass
class Help:
    name: str
    text: str
    usage: str
    footer: str
    groups: list
    options: list = field(default_factory=list)
    commands: list = field(default_factory=list)

    def arguments(self):
        return [entry for entry in self.options if entry.argument]

    def sections(self):
        """Returns the titles of the groups of options, in the order of the help, and their options."""
        found = {}
        for title in ["", *self.groups]:
            entries = [entry for entry in self.options if entry.group == title and not entry.argument]
            if entries:
                found[title or "Options"] = entries
        return found


def make_help(description):
    """Converts the JSON object of a program or command. Fails if an option has no description."""
    fields = {name: description[name] for name in ("name", "text", "usage", "footer", "groups")}
    page = Help(**fields, options=[Entry(**option) for option in description["options"]],
                commands=[make_help(each) for each in description["commands"]])
    for entry in page.options:
        if not entry.text:
            raise SystemExit(f"make_manual: '{entry.names[0]}' of '{page.name}' has no description")
    return page


def output_of(program, *words):
    """Runs the program, a list of words, with arguments. Returns what it prints."""
    return subprocess.run([*program, *words], check=True, capture_output=True, text=True).stdout


def read_all_help(program):
    """Returns the help of the program, a list of words, and that of each subcommand by its name."""
    page = make_help(json.loads(output_of(program, "help", "--json")))
    return page, {command.name: command for command in page.commands}


def roff(text):
    """Escapes text for a line of roff."""
    text = text.replace("\\", "\\e").replace("-", "\\-").replace("\n", " ")
    return "\\&" + text if text.startswith((".", "'")) else text


def limit(value):
    return f"{value:.0f}" if value == int(value) else f"{value:g}"


def roff_entry(entry):
    names = ", ".join(f"\\fB{roff(name)}\\fR" for name in entry.names)
    value = ""
    if entry.argument:
        value = ""
    elif entry.choices():
        value = " " + "|".join(f"\\fB{roff(word)}\\fR" for word in entry.choices())
    elif entry.placeholder:
        value = f" \\fI{roff(entry.placeholder)}\\fR"
        if entry.min is not None:
            value += roff(f" ({limit(entry.min)} to {limit(entry.max)})")
        elif entry.positive:
            value += " (above 0)"
    return f".TP\n{names}{value}{' ...' if entry.repeats else ''}\n{roff(entry.text)}\n"


def manual_page(version, page, command, commands):
    """Returns the manual page of a command, or of the program if `command` is empty."""
    name = f"sheaf-{command}" if command else "sheaf"
    title = page.text.split(". ")[0].rstrip(".")
    out = [f'.TH {name.upper()} 1 "" "{version}" "User Commands"', ".SH NAME", f"{name} \\- {roff(title)}",
           ".SH SYNOPSIS", f".B {roff(page.usage)}", ".SH DESCRIPTION", roff(page.text)]
    if page.arguments():
        out += [".SH ARGUMENTS", "".join(map(roff_entry, page.arguments())).rstrip("\n")]
    if page.commands:
        out.append(".SH COMMANDS")
        out += [f".TP\n\\fB{each.name}\\fR\n{roff(each.text)}" for each in page.commands]
    sections = page.sections()
    if list(sections) != ["Options"]:
        out.append(".SH OPTIONS")
    for section, entries in sections.items():
        out.append(".SH OPTIONS" if section == "Options" else f".SS {section}")
        out.append("".join(map(roff_entry, entries)).rstrip("\n"))
    if page.footer:
        out += [".SH EXIT STATUS", roff(page.footer.removeprefix("Exit codes: "))]
    others = ["sheaf"] * bool(command) + [f"sheaf-{each}" for each in commands if each != command]
    out += [".SH SEE ALSO", ", ".join(f"\\fB{roff(each)}\\fR(1)" for each in others)]
    return "\n".join(out) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sheaf", required=True, help="the sheaf executable")
    parser.add_argument("--output", type=Path, required=True, help="output folder, created if missing")
    parser.add_argument("emulator", nargs="*", help="command that runs the executable")
    arguments = parser.parse_args()
    program = [*arguments.emulator, arguments.sheaf]
    version = " ".join(output_of(program, "--version").split()[:2])
    page, pages = read_all_help(program)
    arguments.output.mkdir(parents=True, exist_ok=True)
    for command, page in {"": page, **pages}.items():
        name = f"sheaf-{command}.1" if command else "sheaf.1"
        (arguments.output / name).write_text(manual_page(version, page, command, pages))
    for shell in SHELLS:
        (arguments.output / f"sheaf.{shell}").write_text(output_of(program, "completion", shell))


if __name__ == "__main__":
    main()
