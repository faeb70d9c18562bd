"""Sphinx's settings: the site over book/ and notebooks/. Built by `python run.py book`; warnings are errors."""

import json
import os
import re
import sys
from pathlib import Path

from sphinx import addnodes
from sphinx.ext import napoleon
from sphinx.ext.napoleon import GoogleDocstring

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from book.publish import page_scripts, pages, runs, scenes  # noqa: E402

project = "Kinematics of the OpenMANIPULATOR-X"
author = "the OpenMANIPULATOR-X kinematics book authors"
copyright = "the authors. Text: CC BY 4.0. Code: BSD 3-Clause"
html_title = "Kinematics of the OpenMANIPULATOR-X"
language = "en"

root_doc = "book/index"
include_patterns = ["book/*.md", "book/*/*.md", "notebooks/*.ipynb"]
exclude_patterns = [".venv", "build", ".git", "omx", "tests", "**/.ipynb_checkpoints"]
extensions = ["myst_nb", "sphinx_design", "sphinx.ext.autodoc", "book.publish.directives", "book.publish.teacher_pages"]
myst_enable_extensions = ["amsmath", "attrs_inline", "colon_fence", "deflist", "dollarmath", "substitution"]
myst_heading_anchors = 3
default_role = "code"
nitpicky = False

# The chapters come executed from build/executed; see `source_read` below.
nb_execution_mode = "off"
nb_ipywidgets_js = {}
nb_merge_streams = True
nb_mime_priority_overrides = [("html", "text/html", 5), ("html", "image/svg+xml", 10)]

autodoc_default_options = {"members": True, "member-order": "bysource", "undoc-members": False}
autodoc_typehints = "signature"
MOST_SHOWN = 120  # characters of a constant's value
autodoc_preserve_defaults = True

html_theme = "sphinx_book_theme"
html_theme_options = {
    "show_navbar_depth": 1,
    "show_toc_level": 2,
    "use_fullscreen_button": False,
    "back_to_top_button": False,  # it would lie over the text, in a colour that few can read
    "navigation_with_keys": False,  # arrows scroll wide formulas and code
    "logo": {"text": "OpenMANIPULATOR-X", "alt_text": "Kinematics of the OpenMANIPULATOR-X: start page"},
    "pygments_light_style": "a11y-high-contrast-light",
    "pygments_dark_style": "a11y-high-contrast-dark",
}
html_context = {"default_mode": "auto"}
html_logo = "static/arm.svg"
html_favicon = "static/arm.svg"
html_static_path = ["static", os.path.relpath(page_scripts.SHARED, Path(__file__).parent)]
html_css_files = ["house.css", "live_figure.css"]
scripts = ("omx-view.js", "omx-kinematics.js", "omx-panels.js", "reading.js")
html_js_files = [(script, {"defer": "defer"}) for script in scripts]
html_copy_source = True
html_show_sphinx = False
html_last_updated_fmt = None
mathjax_path = "mathjax/tex-svg-full.js"
mathjax3_config = {"svg": {"fontCache": "local", "mtextInheritFont": True}, "options": {"enableMenu": False}}


def source_read(app, docname, source):
    """Hand MyST-NB the chapter with its outputs, prepared as a page."""
    path = ROOT / f"{docname}.ipynb"
    if docname.startswith("notebooks/"):
        for file in (runs.kept(path), runs.stock_of(), scenes.__file__):
            app.env.note_dependency(str(file))
        source[0] = json.dumps(pages.page(runs.merged(path), path.stem))


def plain_docstring(app, what, name, obj, options, lines):
    """The docstrings are prose with code in single backticks; keep reST from reading more into them.

    Lists of arguments are read, but not a value's "what it is: why".
    """
    if what not in ("attribute", "data"):
        lines[:] = GoogleDocstring(lines, napoleon.Config(), app, what, name, obj, options).lines()
    lines[:] = ["".join(escaped(part) for part in re.split(r"(`[^`]*`)", line)) for line in lines]


def escaped(text):
    return text if text.startswith("`") else re.sub(r"([*|]|_(?=\W|$))", r"\\\1", text)


def skipped(app, what, name, obj, skip, options):
    """A field of a named tuple stands in the signature of its class; its docstring says no more than its number."""
    return True if (getattr(obj, "__doc__", None) or "").startswith("Alias for field number") else None


def shortened(app, domain, kind, content):
    """A value too long to be read is left out of the line that names it."""
    for value in content.parent[0].findall(addnodes.desc_annotation):
        if len(value.astext()) > MOST_SHOWN:
            value.parent.remove(value)


def editor(app, pagename, templatename, context, doctree):
    """The script of a page on which lines of the chapter can be changed."""
    if "omx-edit" in context.get("body", ""):
        app.add_js_file("edit.js", defer="defer")


def setup(app):
    app.connect("html-page-context", editor)
    app.connect("source-read", source_read)
    app.connect("autodoc-skip-member", skipped)
    app.connect("object-description-transform", shortened)
    app.connect("autodoc-process-docstring", plain_docstring)
