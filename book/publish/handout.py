"""Print decks as PDF handouts, one slide a page, a picture in place of each 3-D scene. Needs Chromium or Chrome."""

import contextlib
import functools
import hashlib
import os
import shutil
import sys
from pathlib import Path

from book.setup.paths import Stop

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
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

#: Shows each scene in turn, far too large for no screen, and keeps the picture that it sends back.
CAPTURE = """async () => {
  const pictures = [];
  for (const box of document.querySelectorAll(".omx-scene[data-scene]")) {
    pictures.push(await new Promise((done) => {
      const frame = document.createElement("iframe");
      frame.setAttribute("sandbox", "allow-scripts");
      frame.style.cssText = "position:fixed;left:0;top:0;width:960px;height:540px;border:0;z-index:9";
      const hear = ({ data, source }) => {
        if (source !== frame.contentWindow) return;
        if (data.omx === "ready") setTimeout(() => source.postMessage({ omx: "capture" }, "*"), 250);
        if (data.omx !== "captured") return;
        window.removeEventListener("message", hear);
        frame.remove();
        done(data.url);
      };
      window.addEventListener("message", hear);
      frame.srcdoc = window.omxPage(box);
      document.body.append(frame);
    }));
  }
  return pictures;
}"""


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


def print_all(decks):
    """Write a PDF beside each deck that changed since its PDF was made."""
    stale = [deck for deck in decks if not is_current(deck)]
    if not stale:
        return
    with chromium() as running:
        for deck in stale:
            print_one(running, deck)
            mark(deck).write_text(fingerprint(deck))


def print_one(running, deck):
    """Take the pictures of a deck's scenes, then print the deck with them."""
    page = running.new_page(viewport={"width": 1280, "height": 720})
    page.set_default_timeout(PATIENCE_MS)
    try:
        page.goto(deck.as_uri())
        page.wait_for_selector("body[data-ready]")
        pictures = page.evaluate(CAPTURE)
        page.add_init_script(f"window.OMX_PICTURES = {pictures!r};")
        page.goto(deck.as_uri() + "?print-pdf")
        page.wait_for_selector("body[data-ready]")
        page.wait_for_timeout(300)
        page.pdf(path=deck.with_suffix(".pdf"), prefer_css_page_size=True, print_background=True)
    finally:
        page.close()


def is_current(deck):
    return deck.with_suffix(".pdf").exists() and mark(deck).exists() and mark(deck).read_text() == fingerprint(deck)


def mark(deck):
    return deck.parent / "lib" / f"{deck.stem}.printed"


def fingerprint(deck):
    """A hash of all that the handout shows: the deck, its scripts, its style."""
    digest = hashlib.sha256(deck.read_bytes())
    for path in sorted(deck.parent.glob("lib/*.[jc]s*")):
        digest.update(path.read_bytes())
    return digest.hexdigest()
