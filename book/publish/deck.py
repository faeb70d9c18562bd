"""One executed chapter as the HTML of a slide deck: cells sorted into slides by their `slide_type`."""

import html
import re
from dataclasses import dataclass, field

from markdown_it import MarkdownIt
from mdit_py_plugins.amsmath import amsmath_plugin
from mdit_py_plugins.dollarmath import dollarmath_plugin
from pygments import highlight
from pygments.formatters import HtmlFormatter
from pygments.lexers import PythonLexer

from book.chapters import cells
from book.chapters.cells import text_of
from book.publish import pages

MOST_LINES = 20
LINK = re.compile(r"\[([^\[\]]*)\]\((?!https?:)[^()#]*?([\w-]+)\.(ipynb|md)(?:#[^()]*)?\)")
HIDDEN = ("remove-cell", "solution", "check")


@dataclass
class Slide:
    """One slide: pieces of HTML in order, and the speaker's notes."""

    pieces: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)


def stacks(notebook):
    """The deck as a list of stacks (one an H2), each a list of `Slide`s; cells of type `skip` are left out."""
    out = []
    for cell in notebook["cells"]:
        kind = cells.slide_type(cell)
        if kind == "skip" or any(tag in HIDDEN for tag in cells.tags(cell)):
            continue
        if kind == "slide" or not out:
            out.append([Slide()])
        elif kind == "subslide":
            out[-1].append(Slide())
        slide = out[-1][-1]
        if kind == "notes":
            slide.notes.append(prose(cells.source(cell)))
        elif piece := "".join(rendered(cell)):
            slide.pieces.append(f'<div class="{"fragment" if kind == "fragment" else "piece"}">{piece}</div>')
    return [[slide for slide in stack if slide.pieces] for stack in out]


def sections(notebook):
    """The deck's <section> elements."""
    inner = ["\n".join(section(slide) for slide in stack) for stack in stacks(notebook) if stack]
    return "\n".join(f"<section>\n{text}\n</section>" for text in inner)


def section(slide):
    notes = f'<aside class="notes">{"".join(slide.notes)}</aside>' if slide.notes else ""
    return f"<section>{''.join(slide.pieces)}{notes}</section>"


def rendered(cell):
    """The pieces of one cell's HTML: prose, or code and outputs."""
    if not cells.is_code(cell):
        yield prose(cells.source(cell))
        return
    if "hide-input" not in cells.tags(cell) and not shows_picture(cell):
        yield code(cells.source(cell))
    if "hide-output" not in cells.tags(cell):
        for output in cell.get("outputs", []):
            yield from result(output)


def shows_picture(cell):
    """Does the cell show a scene or a figure? On a slide that speaks for itself, without the call that drew it."""
    data = [output.get("data", {}) for output in cell.get("outputs", [])]
    return any("omx-scene" in text_of(d.get("text/html", "")) or any(m.startswith("image/") for m in d) for d in data)


def code(source):
    return highlight(source, PythonLexer(), HtmlFormatter(cssclass="code"))


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
    lines = text.rstrip("\n").splitlines()
    for start in range(0, len(lines), MOST_LINES):
        block = "\n".join(lines[start : start + MOST_LINES])
        yield f'<pre class="output">{html.escape(block)}</pre>'


def rich(data, metadata):
    if "text/html" in data:
        return pages.explained(data)
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


def prose(text):
    """Markdown as HTML: the dialect of the pages, with links to chapters leading to their decks."""
    return _MARKDOWN.render(LINK.sub(link, text))


def link(found):
    """Another chapter is another deck; what is only on the site keeps its words and loses its link."""
    words, name, kind = found.groups()
    return f"[{words}]({name}.html)" if kind == "ipynb" else words


def _maths(tokens, index, _options, _env, *, display):
    body = html.escape(tokens[index].content.strip())
    return f'<div class="formula">\\[{body}\\]</div>' if display else f"\\({body}\\)"


def _reader():
    reader = MarkdownIt("commonmark", {"html": True}).enable("table").use(dollarmath_plugin).use(amsmath_plugin)
    rules = reader.renderer.rules
    rules["math_inline"] = lambda *a: _maths(*a[:4], display=False)
    for name in ("math_block", "math_block_label", "math_inline_double", "amsmath"):
        rules[name] = lambda *a: _maths(*a[:4], display=True)
    return reader


_MARKDOWN = _reader()
