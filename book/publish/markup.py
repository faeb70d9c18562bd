"""Prose, code and outputs of a notebook as the HTML of slides and of other pages without Sphinx."""

import functools
import html
import itertools
import math
import re
import textwrap
from itertools import accumulate, groupby

from markdown_it import MarkdownIt
from mdit_py_plugins.amsmath import amsmath_plugin
from mdit_py_plugins.dollarmath import dollarmath_plugin
from pygments import highlight
from pygments.formatters import HtmlFormatter
from pygments.lexers import PythonLexer

from book.chapters import cells
from book.chapters.cells import text_of
from book.publish import slide_code, slide_content

MOST_LINES, MOST_COLUMNS = 18, 88  # of printed text, in type of 22 of a slide's 720 pixels
EQUALS = re.compile(r"(?<=\\right\]) = (?=\\left\[)")
INLINE = re.compile(r"(\\\((?:(?!\\\)).)*\\\))([.,;:!?)\u201d\"]+)", re.DOTALL)
SHOWN = re.compile("omx-scene|omx-panel")
LINK = re.compile(r"\[([^\[\]]*)\]\((?!https?:)[^()#]*?([\w-]+)\.(ipynb|md)(?:#[^()]*)?\)")


def rendered(cell):
    """The pieces of a code cell's HTML: the code, and its outputs."""
    if "hide-input" not in cells.tags(cell) and not shows_picture(cell):
        yield listed_code(cells.source(cell))
    if "hide-output" not in cells.tags(cell):
        pieces = [piece for output in cell.get("outputs", []) for piece in result(output)]
        for are_formulas, group in groupby(pieces, lambda piece: piece.startswith('<div class="formula')):
            together = "".join(map(parted, group))
            yield f'<div class="formulas">{together}</div>' if are_formulas else together


def shows_picture(cell):
    """Does the cell show a scene or a figure? On a slide that speaks for itself, without the call that drew it."""
    data = [output.get("data", {}) for output in cell.get("outputs", [])]
    return any(SHOWN.search(text_of(d.get("text/html", ""))) or any(m.startswith("image/") for m in d) for d in data)


def code(source):
    return highlight(source, PythonLexer(), HtmlFormatter(cssclass="code"))


@functools.cache
def listed_code(source):
    """Code whose lines, should one be too long for a slide, go on indented; marked where a slide may end."""
    before, inside, after = re.split(r"(?<=<span></span>)|(?=</pre>)", code(source))
    begin = slide_code.beginnings(source)
    kinds = ("line begins" if number in begin else "line" for number in itertools.count())
    lines = zip(kinds, inside.rstrip("\n").split("\n"), strict=False)
    return before + "".join(f'<span class="{kind}">{line or " "}</span>' for kind, line in lines) + after


def result(output):
    """One output: a scene or table as it is, a picture with its alt text, a formula, or text."""
    if output["output_type"] == "stream":
        yield from listing(text_of(output["text"]))
    elif output["output_type"] == "error":
        yield f'<pre class="output error">{html.escape(output["ename"] + ": " + output["evalue"])}</pre>'
    else:
        yield rich(output["data"], output.get("metadata", {}))


def listing(text):
    """Printed text, in blocks that fit a slide."""
    lines = [part for line in text.rstrip("\n").splitlines() for part in folded(line)]
    for block in blocks(lines):
        words = "\n".join(block)
        yield f'<pre class="output">{html.escape(words)}</pre>'


def folded(line):
    """A printed line in pieces that a slide holds, the later ones indented."""
    indent = line[: len(line) - len(line.lstrip())] + "    "
    return textwrap.wrap(line, MOST_COLUMNS, subsequent_indent=indent, replace_whitespace=False) or [line]


def blocks(lines):
    """Lines in even blocks of at most `MOST_LINES`, cut where no bracket is open, at best at a blank line."""
    while len(lines) > MOST_LINES:
        depth = list(accumulate(sum(map(line.count, "([{")) - sum(map(line.count, ")]}")) for line in lines))
        even = math.ceil(len(lines) / math.ceil(len(lines) / MOST_LINES))
        cuts = [i for i in range(even // 2, MOST_LINES + 1) if depth[i - 1] == 0] or [even]
        cut = min(cuts, key=lambda i: (bool(lines[i].strip()), abs(i - even)))
        yield lines[:cut]
        lines = lines[cut:]
    yield lines


def rich(data, metadata):
    if "text/html" in data:
        return text_of(data["text/html"])
    if "image/svg+xml" in data:
        return f'<div class="figure">{text_of(data["image/svg+xml"])}</div>'
    if "image/png" in data:
        about = metadata.get("image/png", {})
        alt = html.escape(about.get("alt") or text_of(data.get("text/plain", "")))
        width = f' width="{about["width"]}"' if about.get("width") else ""
        return f'<img alt="{alt}"{width} src="data:image/png;base64,{text_of(data["image/png"]).strip()}">'
    if "text/latex" in data:
        return formula(text_of(data["text/latex"]))
    if "text/markdown" in data:
        return prose(text_of(data["text/markdown"]))
    return f'<pre class="output">{html.escape(text_of(data.get("text/plain", "")))}</pre>'


def formula(latex):
    """SymPy's `$\\displaystyle ...$` as a displayed formula."""
    body = re.sub(r"^\$+(\\displaystyle)?|\$+$", "", latex.strip()).strip()
    return f'<div class="formula">\\[{html.escape(body)}\\]</div>'


def parted(shown):
    """A displayed formula in which a matrix and its numbers can part at the equals sign."""
    body = shown.removeprefix('<div class="formula">\\[').removesuffix("\\]</div>")
    first, *others = EQUALS.split(body) if shown.startswith('<div class="formula">') else [shown]
    sides = "".join(f"<div>\\[{side}\\]</div>" for side in (first, *(f"{{}} = {other}" for other in others)))
    return f'<div class="formula equation">{sides}</div>' if others else shown


def prose(text):
    """Markdown as HTML: the dialect of the pages, with links to chapters leading to their decks."""
    return html_of(_MARKDOWN.parse(LINK.sub(link, text)))


def screened(source, whole=False, alone=False):
    """The HTML of prose for the screen, and of what is only said (`slide_content.split`)."""
    tokens = _MARKDOWN.parse(LINK.sub(link, slide_content.COMMENT.sub("", source)))
    shown, said = slide_content.split(tokens, _MARKDOWN.parseInline, whole, alone)
    return html_of(shown).strip(), html_of(said).strip()


def html_of(tokens):
    """HTML in which no line begins with the full stop after a formula."""
    text = _MARKDOWN.renderer.render(tokens, _MARKDOWN.options, {})
    return INLINE.sub(r'<span class="one">\1\2</span>', text)


def link(found):
    """Another chapter is another deck; what is only on the site keeps its words and loses its link."""
    words, name, kind = found.groups()
    return f"[{words}]({name}.html)" if kind == "ipynb" else words


def _maths(tokens, index, _options, _env, *, display):
    body = html.escape(tokens[index].content.strip())
    if not display:
        return f"\\({body}\\)"
    parts = [body] if "\\begin" in body else body.split("\\qquad")  # side by side where there is room
    shown = "".join(f'<div class="formula">\\[{part.strip()}\\]</div>' for part in parts)
    return f'<div class="formulas">{shown}</div>' if len(parts) > 1 else shown


def _reader():
    reader = MarkdownIt("commonmark", {"html": True}).enable("table").use(dollarmath_plugin).use(amsmath_plugin)
    rules = reader.renderer.rules
    rules["math_inline"] = lambda *a: _maths(*a[:4], display=False)
    for name in ("math_block", "math_block_label", "math_inline_double", "amsmath"):
        rules[name] = lambda *a: _maths(*a[:4], display=True)
    return reader


_MARKDOWN = _reader()
