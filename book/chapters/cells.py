"""What a notebook's cells hold, for the tools: source, tags, headings, words. Works on parsed JSON."""

import re

TAGS = {
    *("recall", "exercise", "broken", "solution", "check"),
    *("predict", "play", "on-the-arm", "self-test", "parameters"),
    *("edit", "your-arm"),
    *("hide-input", "hide-output", "remove-cell"),
    *("raises-exception", "nbval-ignore-output"),
}
SLIDE_TYPES = ("slide", "subslide", "fragment", "notes", "skip", "-")
FENCED = re.compile(r"^(```|~~~).*?^\1", re.DOTALL | re.MULTILINE)
MATHS = re.compile(r"\$\$.*?\$\$|\$[^$\n]+\$", re.DOTALL)
WORD = re.compile(r"[^\W\d_][\w'’-]*")


def text_of(value):
    """The multi-line string of a notebook field, which the format stores as a string or a list of lines."""
    return value if isinstance(value, str) else "".join(value)


def source(cell):
    return text_of(cell["source"])


def tags(cell):
    return cell.get("metadata", {}).get("tags", [])


def slide_type(cell):
    """The cell's own slide type, or else the one that its heading gives it."""
    return cell.get("metadata", {}).get("slideshow", {}).get("slide_type") or default_slide_type(cell)


def default_slide_type(cell):
    """H1 and H2 begin a slide, H3 a slide below it; all else continues the slide before."""
    levels = [level for level, _ in headings(cell)]
    return {1: "slide", 2: "slide", 3: "subslide"}.get(min(levels, default=0), "-")


def is_code(cell):
    return cell["cell_type"] == "code"


def is_note(cell):
    """Is this a remark for the speaker, and no part of the text?"""
    return cell["cell_type"] == "markdown" and slide_type(cell) == "notes"


def prose(cell):
    """The text of a Markdown cell without fenced code; '' for code."""
    return FENCED.sub("", source(cell)) if cell["cell_type"] == "markdown" else ""


def headings(cell):
    """The (level, title) of each heading in a Markdown cell."""
    return [(len(marks), title.strip()) for marks, title in re.findall(r"^(#{1,6})\s+(.+)$", prose(cell), re.M)]


def title(notebook):
    """A chapter's H1."""
    return next(words for cell in notebook["cells"] for level, words in headings(cell) if level == 1)


def word_count(cell):
    """Words of prose: formulas, code and the targets of links are none."""
    text = re.sub(r"\]\([^)]*\)", "]", MATHS.sub(" ", prose(cell)))
    return len(WORD.findall(re.sub(r"`[^`]*`", " x ", text)))


def code_lines(cell):
    """The lines of a code cell that are neither blank nor comments only."""
    lines = source(cell).splitlines() if is_code(cell) else []
    return [line for line in lines if line.strip() and not line.lstrip().startswith("#")]
