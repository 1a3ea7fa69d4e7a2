"""Pages of the command line, from the help of `sheaf` and its commands."""

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
    kind = {"none": "", "integer": "integer", "number": "number", "time": "time"}.get(entry.kind, entry.kind)
    if entry.count > 1:
        return f"{entry.count} {kind}s"
    if entry.placeholder not in ("", "N", "X", "TIME", "TEXT", "FILE", "FOLDER"):
        kind = f"`{entry.placeholder}`"
    if entry.min is not None:
        low, high = (f"{int(limit):,}" if limit == int(limit) else f"{limit:g}" for limit in (entry.min, entry.max))
        return f"{kind}, {low} to {high}"
    return f"{kind}, > 0" if entry.positive else kind


def meaning_of(entry):
    """Returns the text of an option without its default; its list is part of the sentence."""
    return cell(DEFAULT.sub("", entry.text.replace("\n", " "), count=1).strip().rstrip("."))


def table(title, entries):
    """Returns the table of arguments or options. Each row has an anchor, such as #--spp."""
    rows = [f"| {title} | values | default | meaning |", "| --- | --- | --- | --- |"]
    for entry in entries:
        match = DEFAULT.search(entry.text)
        default = cell(match[1]) if match else "required" if entry.required else ""
        names = ", ".join(f"`{name}`" for name in entry.names) + f"{{ #{entry.names[-1]} }}"
        names = names.replace("`{ #", "`{: #")
        rows.append(f"| {names} | {value_of(entry)} | {default} | {meaning_of(entry)} |")
    return "\n".join(rows)


def exit_codes(footer):
    """Returns the table of exit codes, from the end of the help."""
    text = footer.replace("\n", " ").removeprefix("Exit codes: ")
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
    if page.arguments():
        out += ["## Arguments", table("argument", page.arguments())]
    for title, entries in page.sections().items():
        out += [f"## {title}", table("option", entries)]
    return "\n\n".join(out) + "\n"


def index_page(program, commands):
    """Returns the page that lists the subcommands."""
    out = ["# Command line", cell(program.text), f"```\n{program.usage}\n```"]
    rows = ["| subcommand | meaning |", "| --- | --- |"]
    for command in program.commands:
        rows.append(f"| [`{command.name}`]({command.name}.md) | {cell(command.text)} |")
    out += ["\n".join(rows), "`sheaf help SUBCOMMAND` prints these pages. The package also installs them as manual pages, "
            "and completion for bash, zsh and fish.", "## Exit codes", exit_codes(program.footer)]
    return "\n\n".join(out) + "\n"


def command_pages(program, pages):
    """Returns all pages of the command line: names of files and contents."""
    return {"index.md": index_page(program, pages)} | {f"{name}.md": command_page(name, page)
                                                       for name, page in pages.items()}
