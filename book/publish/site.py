"""Build the site: `python run.py book` writes build/site, a folder to open or to put on any web server.

Chapters that changed are run, pages that changed are written.

    python -m book.publish.site                # build it
    python -m book.publish.site --fresh        # everything anew
    python -m book.publish.site --no-pdf       # without the slides as PDF, which need Chromium or Chrome
    python -m book.publish.site --serve        # and show it at 127.0.0.1

With --serve, Ctrl-C ends it.
"""

import argparse
import json
import re
import shutil
import sys
import time
from pathlib import Path

from book.chapters import execute
from book.publish import handout, notices, npm, pages, runs, slides, start
from book.publish.page_scripts import SHARED, share, update
from book.setup.paths import BUILD, ROOT, Stop

SITE, DOCTREES = BUILD / "site", BUILD / "doctrees"
#: Sphinx's note of how the pages were made, for its next build. It knows the folder of this one, so it is no page's.
NOTE = DOCTREES / ".buildinfo"
ICON = re.compile(r'("?)([a-z0-9-]+)\1:\[\d+,\d+,\[[^\]]*\],"[0-9a-f]*",(?:"[^"]*"|\[[^\]]*\])\],?')
EXERCISE = re.compile(r"Exercise \d+\.\d+")
SEARCH = re.compile(r'<script src="[^"]*(?:searchtools|searchindex|language_data)\.js[^"]*"></script>\s*')
#: `{div}` comes from an extension for cards and tabs, and these with it, which no page uses: 60 kB.
UNUSED = re.compile(r"<link [^>]*sphinx-design[^>]*>\s*|<script [^>]*design-tabs\.js[^>]*></script>\s*")
#: The browser edition, where `python run.py lite --site` has laid it into the site.
LITE = "lite"
#: A formula in a line, and the full stop behind it, which no line begins with.
INLINE = re.compile(
    r'(?<!<span class="omx-one">)(<span class="math notranslate nohighlight">(?:(?!</span>).)*</span>)'
    r"([.,;:!?)\u201d]+)",
    re.DOTALL,
)
HANDOUTS = re.compile(f"{pages.HANDOUTS}.*?<!--/-->")
ICON_FONT = re.compile(r'@font-face\{[^}]*Font Awesome[^}]*\}|(?:\.fa-[a-z0-9-]+,?)+\{--fa:"[^}]*\}')


def build(fresh=False, pdf=False):
    """Build everything into build/site; the exit status. Raises `Stop`, or `execute.Failed` for a chapter.

    `pdf`: with the slides' handouts, half a minute of a browser's time for each deck that changed.
    """
    from sphinx.cmd.build import build_main

    if fresh:
        for folder in (SITE, DOCTREES, runs.FOLDER, SHARED):
            shutil.rmtree(folder, ignore_errors=True)
    libraries = npm.modules()
    runs.run_all()
    share(libraries, runs.stock())
    arguments = ["-b", "html", "-c", ROOT / "book", "-d", DOCTREES, "-W", "--keep-going", "-q", ROOT, SITE]
    if NOTE.exists() and SITE.exists():
        NOTE.replace(SITE / NOTE.name)
    status = build_main([str(a) for a in arguments])
    if (SITE / NOTE.name).exists():
        (SITE / NOTE.name).replace(NOTE)
    if status == 0:
        decks = slides.build(folder=SITE / "slides")
        if pdf:
            slides.print_handouts(decks, SITE / "slides")
        finish()
        notices.write(SITE, notices.SITE, [libraries / name for name in notices.NPM])
    return status


def finish(site=SITE):
    """What Sphinx leaves to do: a start page at the root, and an icon font without the icons nobody sees.

    It may come to a page a second time, and then changes nothing.
    """
    target = "book/index.html"
    (site / "index.html").write_text(
        f'<!DOCTYPE html><html lang="en"><head><meta charset="utf-8"><title>OpenMANIPULATOR-X</title>'
        f'<meta http-equiv="refresh" content="0; url={target}"></head>'
        f'<body><p><a href="{target}">To the book</a></p></body></html>\n',
        encoding="utf-8",
    )
    for page in site.rglob("*.html"):
        text = UNUSED.sub("", page.read_text(encoding="utf-8"))
        if page.name != "search.html":  # the only page that searches
            text = SEARCH.sub("", text)
        words = handouts(site / "slides" / page.name) + to_run(site, page.stem)
        text = INLINE.sub(r'<span class="omx-one">\1\2</span>', text)
        update(page, HANDOUTS.sub(f"{pages.HANDOUTS}{words}<!--/-->", text).encode())
    name_exercises(site / "searchindex.js")
    thin_icons(site)
    for path in [*site.rglob("*.map"), *site.glob("_static/sphinx-design*"), *site.glob("_static/design-*")]:
        path.unlink()


def name_exercises(index):
    """Let a search for "exercise 4.4" find that first: Sphinx asks that the words be half of a title."""
    call, _, data = index.read_text(encoding="utf-8").partition("(")
    found = json.loads(data.rstrip().removesuffix(")"))
    for title, places in found["alltitles"].items():
        if short := EXERCISE.match(title):
            found["indexentries"][short[0].lower()] = [[*place, True] for place in places]
    update(index, f"{call}({json.dumps(found, separators=(',', ':'), sort_keys=True)})".encode())


def handouts(deck):
    """What stands on a chapter's page for the PDFs of its deck."""
    links = slides.handouts(deck, "../slides/")
    words = f"The slides as {' · '.join(links)}" if links else ""
    return f'<span class="omx-handouts">{words}</span>'


def to_run(site, name):
    """What stands there for the same chapter in the browser edition; `edit.js` finds Python by this link, too."""
    if not (site / LITE / "static/pyodide/pyodide-lock.json").is_file():
        return ""
    address = f"../{LITE}/lab/index.html?path={name}.ipynb"
    return f' <a class="omx-button omx-run" href="{address}">Run it in your browser</a>'


def thin_icons(site):
    """Drop from the theme's icons, which are 1.7 MB, those that no page uses, and a second copy of all of them."""
    import pydata_sphinx_theme

    theme = Path(pydata_sphinx_theme.__file__).parent / "theme/pydata_sphinx_theme/static"
    script, style = Path("scripts/fontawesome.js"), Path("styles/pydata-sphinx-theme.css")
    wanted = {"xmark", "bars", "angle-right", "chevron-down", "chevron-up"}
    for page in [*site.rglob("*.html"), *site.glob("_static/scripts/*.js")]:
        if page.name != script.name:
            wanted |= set(re.findall(r"fa-([a-z0-9-]+)", page.read_text(encoding="utf-8", errors="replace")))
    whole = (theme / script).read_text(encoding="utf-8")
    thin = ICON.sub(lambda m: m.group(0) if m.group(2) in wanted else "", whole)
    update(site / "_static" / script, thin.encode())
    update(site / "_static" / style, ICON_FONT.sub("", (theme / style).read_text(encoding="utf-8")).encode())


def main(argv=None):
    parser = argparse.ArgumentParser("python run.py book", description=__doc__.split("\n")[0])
    parser.add_argument("--fresh", action="store_true", help="build everything anew")
    parser.add_argument("--no-pdf", action="store_true", help="without the slides as PDF")
    parser.add_argument("--serve", action="store_true", help="show the site at 127.0.0.1 when it is built")
    options = parser.parse_args(argv)
    began = time.perf_counter()
    try:
        printing = not options.no_pdf and handout.is_here()
        status = build(options.fresh, printing)
    except (Stop, execute.Failed) as error:
        print(f"book: {error}", file=sys.stderr)
        return 1
    if status == 0:
        print(f"The site is in {Path(SITE).relative_to(ROOT)} ({time.perf_counter() - began:.0f} s).")
        if options.serve:
            start.serve(SITE)
    return status


if __name__ == "__main__":
    sys.exit(main())
