"""A chapter as a page: the executed notebook, with its solutions folded away and its speaker's notes left out."""

import copy
import html
import json

from book.chapters import normalise
from book.chapters.cells import is_note, tags
from book.publish.editable_lines import recipe

#: What a reader sees on the fold of a cell with this tag.
FOLDED = {"solution": "Show a solution", "check": "Show the check"}

#: Where the links to a chapter's handouts and to its notebook in the browser edition go, if the site has them.
HANDOUTS = "<!--handouts-->"


def page(notebook, name, slides=True):
    """The notebook (parsed JSON, with outputs) as MyST-NB should see it; `name` is the chapter's file name."""
    notebook = copy.deepcopy(notebook)
    cells = [prepared(cell) for cell in notebook["cells"] if not is_note(cell)]
    if yours := next((i for i, cell in enumerate(cells) if "your-arm" in tags(cell)), None):
        cells.insert(yours + 1, markdown("edit", editor(name)))
    notebook["cells"] = [cells[0], markdown("links", links(name, slides)), *cells[1:]]
    return notebook


def editor(name):
    """Where the reader changes lines of the chapter, below the panel that then shows their arm: `edit.js` fills it."""
    data = html.escape(json.dumps(recipe(normalise.NOTEBOOKS / f"{name}.ipynb")))
    return f'<div class="omx-edit" role="group" aria-label="Your arm" data-recipe="{data}"></div>'


def prepared(cell):
    """One cell with the tags that fold it, or boxes for its kind."""
    tags = cell["metadata"].get("tags", [])
    for tag in tags:
        if cell["cell_type"] == "code" and tag in FOLDED:
            cell["metadata"]["tags"] = [*tags, "hide-cell" if tag == "solution" else "hide-input"]
            prompts = {"code_prompt_show": FOLDED[tag], "code_prompt_hide": "Hide"}
            cell["metadata"]["mystnb"] = {**cell["metadata"].get("mystnb", {}), **prompts}
    if cell["cell_type"] == "code" and (about := picture_of(cell)):
        cell["metadata"]["mystnb"] = {**cell["metadata"].get("mystnb", {}), "image": about}
    if cell["cell_type"] == "markdown":
        cell["source"] = boxed(normalise.text_of(cell["source"]), tags)
    return cell


def picture_of(cell):
    """Alt text and width of a cell's picture, from where `omx.display.plots` puts them, as MyST-NB wants them."""
    for output in cell.get("outputs", []):
        about = output.get("metadata", {}).get("image/png")
        if about:
            return {"alt": about.get("alt", ""), "width": f"{about['width']}px"} if "width" in about else about
    return None


def boxed(text, tags):
    """Prose with the tag `predict` in a box of its own, below its heading, which a box cannot hold."""
    if "predict" not in tags:
        return text
    lines = text.splitlines()
    first = 1 + max((i for i, line in enumerate(lines) if line.startswith("#")), default=-1)
    return "\n".join([*lines[:first], "", "::::::{div} omx-predict", *lines[first:], "::::::"])


def links(name, slides):
    """The row of buttons under a chapter's title."""
    source = f'<a class="omx-button" href="../_sources/notebooks/{name}.ipynb" download>Download this notebook</a>'
    deck = f'<a class="omx-button" href="../slides/{name}.html">Slides</a>' if slides else ""
    return f'<p class="omx-links">{source} {deck} {HANDOUTS}<!--/--></p>'


def markdown(name, text):
    return {"cell_type": "markdown", "id": name, "metadata": {}, "source": text}
