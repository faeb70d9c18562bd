"""Print decks as PDF, with the slides' numbers, a picture in place of each 3-D scene. Needs Chromium or Chrome.

Beside `NN-topic.html` come `NN-topic.pdf`, a slide a page; `NN-topic-four.pdf`, four a page, to write on; and
`NN-topic-notes.pdf`, each slide with what is said to it.
"""

import contextlib
import functools
import hashlib
import os
import re
import shutil
import sys
from pathlib import Path

from book.setup.paths import Stop

NAMES = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
PLACES = (
    "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
    os.path.expandvars(r"%ProgramFiles%\Google\Chrome\Application\chrome.exe"),
)
#: A browser for printing and testing: software WebGL, and not a word to the network.
FLAGS = (
    *("--disable-gpu", "--enable-unsafe-swiftshader", "--disable-quic", "--no-first-run"),
    *("--disable-background-networking", "--disable-component-update", "--disable-sync"),
)
PATIENCE_MS = 120_000
#: What is printed, by the end of the file's name; `deck.js` lays it out.
PRINTS = {"": "slides", "-four": "four", "-notes": "notes"}
#: What the browser adds of its own, the time and its name; words of the same length in their place keep the file whole.
TIME, BROWSER = re.compile(rb"(?<=Date \(D:)\d{14}(?=[+-])"), re.compile(rb"(?<=/Creator \()(?:\\.|[^()\\])*(?=\))")

#: What depends on the moment, too: by which number the browser knows a table's cell.
CELL = re.compile(rb"(?<=\(node)\d{8}(?=\))")
#: A link to a file beside the deck leads from the PDF, wherever both lie, and not from the folder of this build.
BESIDE = re.compile(rb"\(beside:([^)]*)\)")
MARK_LINKS = """() => {
  for (const link of document.querySelectorAll("a[href]")) {
    const to = link.getAttribute("href");
    if (!/^(#|[a-z][a-z0-9+.-]*:)/i.test(to)) link.setAttribute("href", "beside:" + to);
  }
}"""

#: Scenes keep their room and are not loaded.
NO_SCENES = "window.IntersectionObserver = class { observe() {} unobserve() {} disconnect() {} };"


@functools.cache
def browser():
    """The path of Chromium or Chrome on this machine. Raises `Stop`."""
    for found in [*map(shutil.which, NAMES), *PLACES]:
        if found and Path(found).exists():
            return found
    raise Stop(
        "The handouts are printed by Chromium or Chrome, and neither is on this machine: install one, or write the "
        "decks without handouts by `python run.py slides --no-pdf`."
    )


@contextlib.contextmanager
def chromium():
    """A headless Chromium, driven by Playwright."""
    from playwright.sync_api import sync_playwright

    flags = [*FLAGS, *(["--no-sandbox"] if sys.platform == "linux" and os.geteuid() == 0 else [])]
    with sync_playwright() as playwright:
        running = playwright.chromium.launch(executable_path=browser(), args=flags)
        try:
            yield running
        finally:
            running.close()


def is_here():
    """Is there a browser to print with?"""
    try:
        return bool(browser())
    except Stop:
        return False


def print_all(decks):
    """Write the PDFs beside each deck that changed since they were made."""
    stale = [deck for deck in decks if not is_current(deck)]
    if not stale:
        return
    with chromium() as running:
        for deck in stale:
            print_one(running, deck)
            mark(deck).write_text(fingerprint(deck))


def print_one(running, deck):
    """Print a deck in each layout."""
    page = running.new_page(viewport={"width": 1280, "height": 720})
    page.set_default_timeout(PATIENCE_MS)
    page.add_init_script(NO_SCENES)
    try:
        page.goto(deck.as_uri() + "?print=slides")
        page.wait_for_selector("body[data-ready]")
        for target, layout in zip(prints(deck), PRINTS.values(), strict=True):
            page.evaluate("omxLay", layout)
            page.evaluate(MARK_LINKS)
            data = page.pdf(prefer_css_page_size=True, print_background=True, tagged=True, outline=True)
            target.write_bytes(unstamped(data))
    finally:
        page.close()


def unstamped(pdf):
    """The same file from every day, folder and browser's name; nothing in it moves."""
    order = {name: b"%08d" % rank for rank, name in enumerate(sorted(set(CELL.findall(pdf))))}
    pdf = CELL.sub(lambda found: order[found[0]], TIME.sub(b"20000101000000", pdf))
    pdf = BESIDE.sub(lambda found: (b"(%s)" % found[1]).ljust(len(found[0])), pdf)
    return BROWSER.sub(lambda found: b"The slides of the book".ljust(len(found[0])), pdf)


def prints(deck):
    """The paths of a deck's PDFs: one a page, four a page, with notes."""
    return [deck.with_name(f"{deck.stem}{end}.pdf") for end in PRINTS]


def is_current(deck):
    whole = all(path.exists() for path in (mark(deck), *prints(deck)))
    return whole and mark(deck).read_text() == fingerprint(deck)


def mark(deck):
    return deck.parent / "lib" / f"{deck.stem}.printed"


def fingerprint(deck):
    """A hash of all that the handout shows: the deck, its scripts, its style."""
    digest = hashlib.sha256(deck.read_bytes())
    for path in sorted(deck.parent.glob("lib/*.[jc]s*")):
        digest.update(path.read_bytes())
    return digest.hexdigest()
