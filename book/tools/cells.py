"""What a notebook's cells hold, for the tools: source, tags, headings, words. Works on parsed JSON."""

import re

from book.tools.normalise import text_of

TAGS = {
    *("exercise", "solution", "check"),
    *("predict", "play", "on-the-arm", "self-test", "parameters"),
    *("hide-input", "hide-output", "remove-cell"),
    *("raises-exception", "nbval-ignore-output"),
}
SLIDE_TYPES = ("slide", "subslide", "fragment", "notes", "skip", "-")
FENCED = re.compile(r"^(```|~~~).*?^\1", re.DOTALL | re.MULTILINE)
MATHS = re.compile(r"\$\$.*?\$\$|\$[^$\n]+\$", re.DOTALL)
WORD = re.compile(r"[^\W\d_][\w'’-]*")


def source(cell):
    return text_of(cell["source"])


def tags(cell):
    return cell.get("metadata", {}).get("tags", [])


def slide_type(cell):
    return cell.get("metadata", {}).get("slideshow", {}).get("slide_type")


def is_code(cell):
    return cell["cell_type"] == "code"


def prose(cell):
    """The text of a Markdown cell without fenced code; '' for code."""
    return FENCED.sub("", source(cell)) if cell["cell_type"] == "markdown" else ""


def headings(cell):
    """The (level, title) of each heading in a Markdown cell."""
    return [(len(marks), title.strip()) for marks, title in re.findall(r"^(#{1,6})\s+(.+)$", prose(cell), re.M)]


def word_count(cell):
    """Words of prose: formulas, code and the targets of links are none."""
    text = re.sub(r"\]\([^)]*\)", "]", MATHS.sub(" ", prose(cell)))
    return len(WORD.findall(re.sub(r"`[^`]*`", " x ", text)))


def code_lines(cell):
    """The lines of a code cell that are neither blank nor comments only."""
    lines = source(cell).splitlines() if is_code(cell) else []
    return [line for line in lines if line.strip() and not line.lstrip().startswith("#")]
