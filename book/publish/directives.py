"""The directives of the book's pages: `arm`, the 3-D arm under sliders without Python, and `chapters`, their cards."""

import html
import math
from functools import cache

from docutils import nodes
from docutils.parsers.rst import Directive, directives

import omx
from book.chapters import cells, normalise
from book.publish import markup, runs, scenes
from book.publish.still_picture import with_poster
from book.setup.paths import NOTEBOOKS


class Arm(Directive):
    """The arm under sliders. `kind`: `joints` or `pose`; `q`: four angles in degrees; `height` of the scene in px."""

    option_spec = {  # noqa: RUF012 - docutils reads it as it is
        "kind": lambda word: directives.choice(word, ("joints", "pose")),
        "q": lambda text: tuple(math.radians(float(word)) for word in text.split(",")),
        "height": directives.positive_int,
    }

    def run(self):
        options = self.options
        for file in (runs.stock_of(), scenes.__file__):
            self.state.document.settings.env.note_dependency(str(file))
        text = arm(options.get("kind", "joints"), options.get("q", omx.HOME), options.get("height", 420))
        return [nodes.raw("", text, format="html")]


class Chapters(Directive):
    """A card for each chapter: its title and its hook, both from the notebook. For pages in book/."""

    def run(self):
        chapters = sorted(NOTEBOOKS.glob("*.ipynb"))
        for path in chapters:
            self.state.document.settings.env.note_dependency(str(path))
        cards = "\n".join(card(path) for path in chapters)
        return [nodes.raw("", f'<div class="omx-cards">{cards}</div>', format="html")]


def card(path):
    """One chapter's card: the H1 of its notebook and the paragraph below."""
    first = cells.source(normalise.read(path)["cells"][0])
    title, hook, *_ = [part.strip() for part in first.split("\n\n")]
    link = f'<a href="../notebooks/{path.stem}.html">{html.escape(title.lstrip("# "))}</a>'
    return f'<div class="omx-card"><h3>{link}</h3>{markup.prose(hook)}</div>'


@cache
def arm(kind, q, height):
    """The HTML of an arm under sliders, for pages that load omx-view.js and omx-panels.js."""
    from omx.display.panels import JointPanel, PosePanel
    from omx.display.viewer import View

    panel = JointPanel if kind == "joints" else PosePanel
    return scenes.html_of(with_poster(panel(View(q, height=height), q=q).page_data()), runs.stock())


def setup(app):
    app.add_directive("arm", Arm)
    app.add_directive("chapters", Chapters)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
