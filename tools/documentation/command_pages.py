"""Pages of the command line, from the output of `sheaf --help` and `sheaf COMMAND --help`."""

import re

# The sentence of the help that states a default.
DEFAULT = re.compile(r" ?Default: (.*?)(?:\.(?= |$)|$)")


def cell(text):
    """Escapes text for a cell of a table. Options, files and names with underscores become code."""
    text = re.sub(r"docs/([\w/-]+\.md)", r"[\1](../\1)", text)
    text = re.sub(r"(?<![\w`\[/-])(--?[A-Za-z][\w-]*(?:[ =][\w-]+=\w+)?|\w+_\w+(?:_\w+)*)(?![\w`])", r"`\1`", text)
    text = re.sub(r"'(sheaf[^']*)'", r"`\1`", text)
    text = re.sub(r"(?<= )--(?=[ .,]|$)", "`--`", text)
    return text.replace("|", "\\|").replace("<", "&lt;").replace("*", "\\*")


def value_of(entry):
    """Returns the values that an option accepts."""
    if entry.choices():
        return ", ".join(f"`{choice}`" for choice in entry.choices())
    limits = re.search(r"\[(.*) - (.*)\]", entry.limits)
    kind = {"TEXT": "text", "INT": "integer", "UINT": "integer", "FLOAT": "number"}.get(entry.value, "")
    if limits:
        low, high = (f"{int(limit):,}" if limit.lstrip("-").isdigit() else limit for limit in limits.groups())
        kind = f"{kind}, {low} to {high}"
    elif entry.limits == ":POSITIVE":
        kind += ", > 0"
    return f"{entry.count.removeprefix(' x ')} {kind}s" if entry.count else kind


def table(title, entries):
    """Returns the table of arguments or options. Each row has an anchor, such as #--spp."""
    rows = [f"| {title} | values | default | meaning |", "| --- | --- | --- | --- |"]
    for entry in entries:
        match = DEFAULT.search(entry.text)
        default = cell(match[1]) if match else "required" if entry.required else ""
        text = DEFAULT.sub("", entry.text, count=1).strip().rstrip(".")
        names = ", ".join(f"`{name}`" for name in entry.names) + f"{{ #{entry.names[-1]} }}"
        names = names.replace("`{ #", "`{: #")
        rows.append(f"| {names} | {value_of(entry)} | {default} | {cell(text)} |")
    return "\n".join(rows)


def exit_codes(footer):
    """Returns the table of exit codes, from the last lines of the help."""
    text = " ".join(footer).removeprefix("Exit codes: ")
    parts = re.split(r"[,;] (?=\d)", text)
    rows = ["| exit code | meaning |", "| --- | --- |"]
    pending = []
    for part in parts:
        code, _, meaning = part.partition(" ")
        pending.append(code.rstrip(":"))
        if meaning:
            rows.append(f"| {', '.join(pending)} | {meaning.rstrip('.')} |")
            pending = []
    return "\n".join(rows)


def command_page(command, page):
    """Returns the page of a subcommand."""
    out = [f"# sheaf {command}", cell(page.text), f"```\n{page.usage}\n```"]
    if page.sections.get("Positionals"):
        out += ["## Arguments", table("argument", page.sections["Positionals"])]
    out += ["## Options", table("option", page.sections["Options"])]
    return "\n\n".join(out) + "\n"


def index_page(program, commands):
    """Returns the page that lists the subcommands."""
    out = ["# Command line", cell(program.text), f"```\n{program.usage}\n```"]
    rows = ["| subcommand | meaning |", "| --- | --- |"]
    for entry in program.sections["Subcommands"]:
        rows.append(f"| [`{entry.names[0]}`]({entry.names[0]}.md) | {cell(entry.text)} |")
    out += ["\n".join(rows), "`sheaf SUBCOMMAND --help` prints these pages. The package also installs them as manual "
            "pages, and completion for bash.", "## Exit codes", exit_codes(program.footer)]
    return "\n\n".join(out) + "\n"


def command_pages(program, pages):
    """Returns all pages of the command line: names of files and contents."""
    return {"index.md": index_page(program, pages)} | {f"{name}.md": command_page(name, page)
                                                       for name, page in pages.items()}
