"""Decks in a browser: nothing overflows at 16:9, nothing is too small for the last row, every scene shows something."""

import subprocess
import sys

import pytest

from book.publish import handout, site, slides
from tests.browser.weblook import is_blank, picture, served

CHAPTERS = sorted(path.stem for path in site.ROOT.glob("notebooks/*.ipynb"))

#: Every slide's overflow in px (below, right), its smallest type in px (and of code), and whether it had to shrink.
MEASURE = """() => Reveal.getSlides().map((slide) => {
  Reveal.slide(...Object.values(Reveal.getIndices(slide)).slice(0, 2));
  const parts = [...slide.children].filter((c) => !c.matches("aside") && c.offsetHeight);
  const bottom = Math.max(0, ...parts.map((c) => c.offsetTop + c.offsetHeight));
  const blocks = [...slide.querySelectorAll("pre, table, .formula, p, img")];
  const wide = blocks.filter((c) => c.scrollWidth > c.clientWidth + 3);
  const type = [...slide.querySelectorAll("p, li")].filter((c) => !c.closest(".omx-panel, .again"));
  return {
    title: slide.innerText.slice(0, 60),
    below: bottom - 720,
    wide: wide.filter((c) => c.offsetLeft + c.scrollWidth > 1280).length,
    type: Math.min(...type.map((c) => parseFloat(getComputedStyle(c).fontSize)), 99),
    code: Math.min(...[...slide.querySelectorAll("pre")].map((c) => parseFloat(getComputedStyle(c).fontSize)), 99),
    shrunk: slide.dataset.small || "",
  };
})"""


#: For measuring: scenes keep their room and are not loaded.
NO_SCENES = "window.IntersectionObserver = class { observe() {} unobserve() {} disconnect() {} };"
SHOW = """(box) => {
  const { h, v } = Reveal.getIndices(box.closest("section"));
  Reveal.slide(h, v, 99);
}"""


@pytest.fixture(scope="module")
def home(built_site):
    with served(built_site / "slides") as address:
        yield address


@pytest.fixture(scope="module")
def window():
    return 1280, 720


def start(look, name):
    look.open(f"{name}.html")
    look.page.wait_for_selector("body[data-ready]", timeout=120_000)


@pytest.mark.parametrize("name", CHAPTERS)
def test_a_deck_fits_is_readable_and_stays_at_home(look, name):
    look.page.add_init_script(NO_SCENES)
    start(look, name)
    seen = look.page.evaluate(MEASURE)
    assert len(seen) > 5
    assert [slide for slide in seen if slide["below"] > 0 or slide["wide"]] == []
    assert [slide for slide in seen if slide["type"] < 18 or slide["code"] < 14 or slide["shrunk"]] == []
    assert look.page.locator("mjx-merror").count() == 0
    assert look.page.locator("img:not([alt])").count() == 0
    assert look.problems == []


@pytest.mark.parametrize("name", CHAPTERS)
def test_the_first_scene_of_a_deck_is_live(look, name):
    start(look, name)
    boxes = look.page.locator(".omx-scene[data-scene]")
    if not boxes.count():
        pytest.skip("this deck has no scene")
    boxes.first.evaluate(SHOW)
    frame = look.scene(boxes.first)
    assert not is_blank(picture(frame))
    assert look.problems == []


def test_notes_and_fragments_work(look):
    start(look, "03-forward-kinematics")
    assert look.page.locator("aside.notes").count() > 0
    hidden = look.page.locator(".fragment:not(.visible)").count()
    assert hidden > 3
    look.page.evaluate("Reveal.nextFragment() || (Reveal.next(), Reveal.nextFragment())")
    assert look.page.evaluate("typeof Reveal.getPlugin('notes').open") == "function"


def test_a_handout_is_printed_with_pictures_of_the_scenes(built_site, tmp_path):
    folder = tmp_path / "slides"
    slides.build([site.ROOT / "notebooks" / "03-forward-kinematics.ipynb"], folder)
    deck = folder / "03-forward-kinematics.html"
    program = f"from book.publish import handout; from pathlib import Path; handout.print_all([Path({str(deck)!r})])"
    subprocess.run([sys.executable, "-c", program], cwd=site.ROOT, check=True, timeout=300)  # one Playwright a process
    data = deck.with_suffix(".pdf").read_bytes()
    assert data.startswith(b"%PDF")
    assert data.count(b"/Type /Page\n") + data.count(b"/Type /Page ") + data.count(b"/Type/Page") >= 10
    assert data.count(b"/Subtype /Image") + data.count(b"/Subtype/Image") >= 1
    assert handout.is_current(deck)
