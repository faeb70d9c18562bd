"""Build the slides: `python run.py slides` writes build/slides, a folder of decks, each with its handouts.

    python -m book.publish.slides                       # every chapter
    python -m book.publish.slides notebooks/03-*.ipynb  # these
    python -m book.publish.slides --no-pdf              # decks only; the handouts need Chromium or Chrome
    python -m book.publish.slides --check               # decks only, looked over as `slide_lint` does

A deck opens from the folder by a double click and needs no network. Keys: arrows and space move, S opens the
speaker's notes, F fills the screen, O shows all slides, B is black.
"""

import argparse
import html
import shutil
import sys
import time

from book.chapters import cells, execute, normalise
from book.publish import deck, handout, notices, npm, page_scripts, runs, slide_code, slide_lint
from book.setup.paths import ROOT, Stop

SLIDES = ROOT / "build" / "slides"
SHARED = ("mathjax/tex-svg-full.js", "omx-view.js", "omx-kinematics.js", "omx-panels.js", "live_figure.css")
LIBRARIES = ("reveal.js/dist/reveal.js", "reveal.js/dist/reveal.css", "reveal.js/plugin/notes/notes.js")
OWN = ("deck.js", "deck.css", "arm.svg")


def build(paths=None, folder=SLIDES):
    """Write the decks of these chapters (default: all) into `folder`; the paths of the decks."""
    libraries = npm.modules()
    runs.run_all(paths)
    page_scripts.share(libraries, runs.stock())
    lay_out_libraries(libraries, folder / "lib")
    decks = [write(path, folder) for path in paths or runs.chapters()]
    write_list(folder)
    notices.write(folder, notices.SLIDES, [libraries / name for name in notices.NPM])
    return decks


def lay_out_libraries(libraries, lib):
    """What the decks load: reveal.js and MathJax from npm, the viewer, the kinematics, the house's own."""
    lib.mkdir(parents=True, exist_ok=True)
    sources = [libraries / name for name in LIBRARIES] + [ROOT / "book/static" / name for name in OWN]
    sources += [page_scripts.SHARED / name for name in SHARED]
    for source in sources:
        shutil.copyfile(source, lib / source.name)


def write(path, folder):
    """One chapter's deck; rewritten only when it changes, so that its handout stays current."""
    notebook = runs.merged(path)
    return write_deck(cells.title(notebook), notebook, folder / f"{path.stem}.html")


def write_deck(title, notebook, target):
    """The deck of an executed notebook (parsed JSON), at the path `target`, which is returned."""
    page = (ROOT / "book/templates/deck.html").read_text(encoding="utf-8")
    sections = deck.sections(slide_code.narrowed(notebook))
    page = page.replace("{{title}}", html.escape(title)).replace("{{sections}}", sections)
    page_scripts.update(target, page.encode())
    return target


def write_list(folder):
    """A page that lists the decks, with the time that each takes and what is printed of it."""
    rows = [row(path, folder) for path in runs.chapters() if (folder / f"{path.stem}.html").exists()]
    page = (ROOT / "book/templates/decks.html").read_text(encoding="utf-8")
    page_scripts.update(folder / "index.html", page.replace("{{rows}}", "\n".join(rows)).encode())


def row(path, folder):
    notebook, target = runs.merged(path), folder / f"{path.stem}.html"
    links = [f'<a href="{target.name}">{html.escape(cells.title(notebook))}</a>', f"{deck.minutes(notebook):.0f} min"]
    return f"<li>{' · '.join(links + handouts(target))}</li>"


def handouts(target, where=""):
    """Links to the PDFs beside the deck `target`, where there are any; `where` leads to their folder."""
    words = ("PDF", "four a page", "with notes")
    printed = zip(handout.prints(target), words, strict=True)
    return [f'<a href="{where}{path.name}">{word}</a>' for path, word in printed if path.exists()]


def print_handouts(decks, folder):
    """The PDFs of these decks, and a list that names them."""
    handout.print_all(decks)
    write_list(folder)


def main(argv=None):
    parser = argparse.ArgumentParser("python run.py slides", description=__doc__.split("\n")[0])
    parser.add_argument("notebooks", nargs="*", help="default: every chapter")
    parser.add_argument("--no-pdf", action="store_true", help="decks only, no handouts")
    parser.add_argument("--check", action="store_true", help="decks only; is every slide fit to be shown?")
    options = parser.parse_args(argv)
    start = time.perf_counter()
    try:
        decks = build(normalise.chapters(options.notebooks))
        if options.check:
            return 1 if slide_lint.check(decks) else 0
        if not options.no_pdf:
            print_handouts(decks, SLIDES)
    except (Stop, execute.Failed) as error:
        print(f"slides: {error}", file=sys.stderr)
        return 1
    print(f"The slides are in {SLIDES.relative_to(ROOT)} ({time.perf_counter() - start:.0f} s).")
    return 0


if __name__ == "__main__":
    sys.exit(main())
