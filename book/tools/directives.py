"""The directives of the book's pages: `arm` puts the 3-D arm with sliders that work without Python into a page."""

import math
from functools import cache

from docutils import nodes
from docutils.parsers.rst import Directive, directives

import omx


class Arm(Directive):
    """The arm under sliders. `kind`: `joints` or `pose`; `q`: four angles in degrees; `height` of the scene in px."""

    option_spec = {  # noqa: RUF012 - docutils reads it as it is
        "kind": lambda word: directives.choice(word, ("joints", "pose")),
        "q": lambda text: tuple(math.radians(float(word)) for word in text.split(",")),
        "height": directives.positive_int,
    }

    def run(self):
        options = self.options
        text = arm(options.get("kind", "joints"), options.get("q", omx.HOME), options.get("height", 420))
        return [nodes.raw("", text, format="html")]


@cache
def arm(kind, q, height):
    """The HTML of an arm under sliders, for pages that load omx-view.js and panel.js."""
    from omx.panel import JointPanel, PosePanel
    from omx.view import View

    panel = JointPanel if kind == "joints" else PosePanel
    return panel(View(q, height=height), q=q).static_html(shared=True)


def setup(app):
    app.add_directive("arm", Arm)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
