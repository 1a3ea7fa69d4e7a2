"""Markdown files as code hosts read them: code blocks, headings, anchors and links."""

import re

FENCE = re.compile(r" *(`{3,}|~{3,})")
CODE = re.compile(r"(?<!`)(`+)(?!`).*?(?<!`)\1(?!`)", re.DOTALL)
# The end of a link or image, or an attribute of HTML.
TARGET = re.compile(r"(?P<before>\]\(|(?:src|href)=\")(?P<target>[^()\s\"]+)(?P<after>(?:\s+\"[^\"]*\")?\)|\")")
HEADING = re.compile(r"#+ +(.*?)#* *$", re.MULTILINE)
LIST_ITEM = re.compile(r" *(?:[-*+]|\d+\.) ")


def blocks(text):
    """Divides a text into pairs: lines, and whether they are a fenced code block."""
    lines, fence = [], None
    for line in text.splitlines(keepends=True):
        match = FENCE.match(line)
        if fence is None and match:
            yield "".join(lines), False
            lines, fence = [line], match[1]
        elif fence is not None and match and match[1].startswith(fence):
            yield "".join([*lines, line]), True
            lines, fence = [], None
        else:
            lines.append(line)
    yield "".join(lines), fence is not None


def replace_targets(text, replace):
    """Returns the text with the target of each link and image outside of code replaced by `replace(target)`. None
    leaves only the text of the link."""

    def new_target(match):
        target = replace(match["target"])
        return match["before"] + ("\0" if target is None else target) + match["after"]

    def in_prose(prose):
        code = []

        def hide(match):
            code.append(match[0])
            return f"\1{len(code) - 1}\1"

        prose = TARGET.sub(new_target, CODE.sub(hide, prose))
        prose = re.sub(r"\[([^\[\]]*)\]\(\0\)", r"\1", prose)
        return re.sub("\1(\\d+)\1", lambda match: code[int(match[1])], prose)

    return "".join(block if is_code else in_prose(block) for block, is_code in blocks(text))


def targets(text):
    """Returns the targets of all links and images."""
    found = []
    replace_targets(text, lambda target: found.append(target) or target)
    return found


def anchor(heading):
    """Returns the anchor that code hosts give to a heading."""
    text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading)
    return re.sub(r"[^\w\- ]", "", text.strip().lower()).replace(" ", "-")


def anchors(text):
    """Returns the anchors of all headings, in order."""
    return [anchor(heading) for block, is_code in blocks(text) if not is_code for heading in HEADING.findall(block)]


def indent_lists(text):
    """Returns the text with the contents of list items indented by 4 columns per level, as Python-Markdown requires."""
    out, levels, is_code = [], [], False  # levels: columns where the contents of the surrounding items begin
    for line in text.splitlines():
        stripped = line.lstrip(" ")
        column = len(line) - len(stripped)
        if stripped and not is_code:
            while levels and column < levels[-1]:
                levels.pop()
        if stripped:
            line = " " * (4 * len(levels) + column - (levels[-1] if levels else 0)) + stripped
        if FENCE.match(stripped):
            is_code = not is_code
        elif not is_code and LIST_ITEM.match(stripped):
            levels.append(column + len(LIST_ITEM.match(stripped)[0]))
        out.append(line)
    return "\n".join(out) + "\n"
