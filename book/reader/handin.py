"""`python run.py handin 03`: a chapter as one HTML file that needs nothing else: formulas, live scenes, check results.

The notebook is run from top to bottom, errors and all, with modules written to a folder of its own. One that names
a real port is not run, since that would move the arm: it is shown as it was saved.
"""

import argparse
import datetime
import html
import os
import re
import sys
import tempfile
from pathlib import Path

import nbformat
from latex2mathml.converter import convert

from book.chapters import execute, normalise
from book.chapters.cells import headings, is_code, source, tags
from book.chapters.student import title
from book.publish import markup, page_scripts, scenes
from book.setup import names
from book.setup.paths import ROOT, WORK, Stop, in_a_sentence, whole

HAND_IN = WORK / "hand-in"
REAL_PORT = re.compile(r"/dev/|\bCOM\d")
MATHS = re.compile(r"\\\((.+?)\\\)|\\\[(.+?)\\\]", re.S)
IN_WORDS = "in words, for your teacher"  # an exercise without a check
THERE = "there, to be marked"  # one whose check stays with the teacher
MARKS = {True: "\u2713", False: "\u2717", None: "\u2013", IN_WORDS: "\u270e", THERE: "\u270e"}
WORDS = {True: "passed", False: "not yet", None: "not checked", IN_WORDS: IN_WORDS, THERE: THERE}


def write(path, target, run=True):
    """Write the page of a notebook file; (exercise, passed) of each, None where nothing was checked, or `IN_WORDS`."""
    notebook = normalise.read(path)
    is_run = run and not any(REAL_PORT.search(source(cell)) for cell in notebook["cells"] if is_code(cell))
    if is_run:
        notebook = executed(path)
    results = results_of(notebook["cells"])
    target.parent.mkdir(parents=True, exist_ok=True)
    with whole(target) as partial:
        partial.write_text(page(notebook, path, results, is_run), encoding="utf-8", newline="\n")
    return results


def executed(path):
    """The notebook with the outputs of a run in a fresh kernel, errors kept; scenes as data."""
    with tempfile.TemporaryDirectory(prefix="omx-") as folder:
        env = {**os.environ, "OMX_VIEW": "data", "OMX_GENERATED": folder}
        return execute.run(path, allow_errors=True, env=env)


def results_of(cells):
    """(exercise, passed) in order; an exercise has passed when all its checks have, or is one of the words above."""
    found = []
    for cell in cells:
        if "exercise" in tags(cell):
            found.append([title(source(cell)), []])
        elif "check" in tags(cell) and found:
            found[-1][1].append(result(cell))
    return [(name, next((kind for kind in (None, False, THERE) if kind in checks), True) if checks else IN_WORDS)
            for name, checks in found]  # fmt: skip


def result(check):
    """What the run of a check's cell says: passed or not, `THERE`, or None where it was not run."""
    if not check.get("outputs"):
        return None
    if any(output["output_type"] == "error" for output in check["outputs"]):
        return False
    return THERE if source(check).startswith("check.handed_in(") else True


def page(notebook, path, results, is_run):
    """The whole page."""
    cells = [cell for cell in notebook["cells"] if not str(cell.get("id", "")).startswith("omx-links")]
    name = next((text for cell in cells for level, text in headings(cell) if level == 1), path.stem)
    checked = [result for _, result in results if result in (True, False)]
    rows = "".join(
        f'<tr class="{WORDS[result].replace(" ", "-")}"><td>{MARKS[result]}</td><td>{html.escape(exercise)}</td>'
        f"<td>{WORDS[result]}</td></tr>"
        for exercise, result in results
    )
    how = "run from top to bottom" if is_run else "as it was saved, not run again"
    when = datetime.datetime.now().astimezone().strftime("%Y-%m-%d %H:%M %Z")
    count = f"{sum(checked)} of {len(checked)} exercises pass their checks"
    if to_mark := sum(result == THERE for _, result in results):
        count += f"; {to_mark} more {'is' if to_mark == 1 else 'are'} there, to be marked"
    about = f"<p>{html.escape(path.name)}, {how}, {when}. {count}.</p>"
    body = "\n".join(f'<section class="cell">{piece}</section>' for cell in cells if (piece := shown(cell)))
    template = (ROOT / "book" / "templates" / "handin.html").read_text(encoding="utf-8")
    values = {"title": html.escape(name), "about": f"{about}<table>{rows}</table>", "body": body, "scripts": scripts()}
    styles = (ROOT / "book" / "static" / "house.css", page_scripts.LIVE)
    values["house"] = "\n".join(style.read_text(encoding="utf-8") for style in styles)
    return re.sub(r"\{\{(\w+)\}\}", lambda found: values[found[1]], template)


def shown(cell):
    """The HTML of one cell: all code, unlike a slide, and formulas that need no script."""
    if not is_code(cell):
        return mathml(markup.prose(markup.LINK.sub(r"\1", source(cell))))  # a single file has no neighbours
    pieces = [markup.code(source(cell))]
    for output in scenes.as_html(cell.get("outputs", [])):
        if output["output_type"] == "error":
            pieces.append(f'<pre class="output error">{html.escape(said(output))}</pre>')
        elif "text/html" in output.get("data", {}):
            pieces.append(normalise.text_of(output["data"]["text/html"]))
        elif output["output_type"] == "stream":
            pieces.append(f'<pre class="output">{html.escape(normalise.text_of(output["text"]))}</pre>')
        else:
            pieces.append(mathml(markup.rich(output["data"], output.get("metadata", {}))))
    return "".join(pieces)


def said(output):
    """What an error says, in at most a few lines."""
    first = execute.ANSI.sub("", "\n".join(output["traceback"]))
    return first if first.count("\n") < 3 else f"{output['ename']}: {output['evalue']}"


def mathml(text):
    """HTML with its TeX formulas as MathML, which browsers draw by themselves; what cannot be turned stays TeX."""

    def turned(found):
        tex, display = html.unescape(found[1] or found[2]), "inline" if found[1] else "block"
        try:
            return convert(tex, display=display)
        except Exception:  # the student's own formula may be anything
            return found[0]

    return MATHS.sub(turned, text)


def scripts():
    """The scripts of the site, in the page: the viewer, the kinematics, the panels' sliders."""
    parts = (scenes.page_script({}), page_scripts.kinematics(), page_scripts.panels())
    safe = [part.replace("</script", "<\\/script") for part in parts]
    return "\n".join(f"<script>{part}</script>" for part in safe)


@in_a_sentence
def main(argv=None):
    parser = argparse.ArgumentParser("python run.py handin", description=__doc__.split("\n")[0])
    parser.add_argument("chapters", nargs="+", metavar="chapter", help="such as 03; one of yours, in work/")
    parser.add_argument("--to", type=Path, default=HAND_IN, metavar="FOLDER", help="default: work/hand-in")
    parser.add_argument("--as-saved", action="store_true", help="do not run it, show it as it was saved")
    options = parser.parse_args(argv)
    try:
        for name in options.chapters:
            path = names.chapter(name, WORK)
            if not path.exists():
                raise Stop(f"You have no {path.name} in work/ yet: `python run.py lab {name}` makes your copy.")
            target = options.to / f"{path.stem}.html"
            for exercise, result in write(path, target, run=not options.as_saved):
                print(f"{MARKS[result]} {exercise}: {WORDS[result]}")
            saved = datetime.datetime.fromtimestamp(path.stat().st_mtime)
            print(f"Hand in this file: {target} (your work as saved {saved:%d %B, %H:%M}; save again to add to it)")
    except (execute.Failed, nbformat.ValidationError) as error:
        print(f"run.py: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
