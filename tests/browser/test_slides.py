"""Decks in a browser: every slide passes the check, keys stay the speaker's, and handouts have the slides' numbers."""

import os
import re
import shutil
import subprocess
import sys

import pytest

from book.publish import handout, scenes, site, slide_lint, slides
from book.publish.still_picture import with_poster
from omx.display.viewer import View
from tests.browser.weblook import Look, is_blank, picture, served
from tests.helpers.chapter import code, markdown

CHAPTERS = sorted(path.stem for path in site.ROOT.glob("notebooks/*.ipynb"))
SHOW = """(box) => {
  const { h, v } = Reveal.getIndices(box.closest("section"));
  Reveal.slide(h, v, 99);
}"""
WHERE = "JSON.stringify(Reveal.getIndices())"


@pytest.fixture(scope="module")
def home(built_site):
    with served(built_site / "slides") as address:
        yield address


@pytest.fixture(scope="module")
def motion():
    return "reduce"  # no film is looked at


@pytest.fixture(scope="module")
def window():
    return 1280, 720


def start(look, name):
    look.open(f"{name}.html")
    look.page.wait_for_selector("body[data-ready]", timeout=120_000)


@pytest.mark.parametrize("name", CHAPTERS)
def test_a_deck_passes_the_check_and_stays_at_home(look, name):
    look.page.add_init_script(handout.NO_SCENES)
    start(look, name)
    seen = slide_lint.measure(look.page)
    assert len(seen) > 5
    assert list(slide_lint.problems(name, seen)) == []
    assert all(slide["notes"] for slide in seen)
    assert look.page.locator(".notes .clock", has_text="NaN").count() == 0
    assert look.page.locator("mjx-merror").count() == 0
    assert look.page.locator("img:not([alt])").count() == 0
    assert look.problems == []


def test_matrices_end_on_a_slide_of_4_to_3_too(look):
    look.page.add_init_script(handout.NO_SCENES)
    look.page.set_viewport_size({"width": 1024, "height": 768})
    start(look, "03-forward-kinematics")
    seen = slide_lint.measure(look.page)
    assert [slide["title"] for slide in seen if slide["right"] > 1 or slide["below"] > 1 or slide["cut"]] == []


#: What a slide may do wrong, by the fault that the check must name.
WRONG = {
    "leaves the slide": "paragraph.style.marginTop = '900px'",
    "more than 75 words": "paragraph.append(' word'.repeat(80))",
    "type under 18 px": "paragraph.style.fontSize = '17px'",
    "code under 26 px": "paragraph.innerHTML = '<span class=code><pre style=font-size:25px>x = 1</pre></span>'",
    "printed text under 22 px": "paragraph.innerHTML = '<pre class=output style=font-size:21px>x = 1</pre>'",
    "a formula under 22 px": "paragraph.innerHTML = '<mjx-container style=font-size:21px>x</mjx-container>'",
    "a table under 22 px": "paragraph.innerHTML = '<table style=font-size:21px><tr><td>x</table>'",
    "only a heading": "for (const node of slide.querySelectorAll('.piece > :not(h2)')) node.remove()",
    "words under a picture": "const box = new Image(900, 500); box.style.position = 'absolute'; slide.prepend(box)",
}


@pytest.fixture(scope="module")
def deck(context, home):
    """A deck for all faults: each is made on its third slide, and taken back."""
    with Look(context, home) as look:
        look.page.add_init_script(handout.NO_SCENES)
        start(look, "14-other-arms")
        yield look.page


@pytest.mark.parametrize("fault", WRONG)
def test_the_check_names_each_fault(deck, fault):
    kept = deck.evaluate("Reveal.getSlides()[2].innerHTML")
    change = f"const slide = Reveal.getSlides()[2], paragraph = slide.querySelector('p'); {WRONG[fault]}"
    deck.evaluate(f"() => {{ {change} }}")
    assert fault in slide_lint.faults(slide_lint.measure(deck)[2])
    deck.evaluate("(kept) => { Reveal.getSlides()[2].innerHTML = kept; }", kept)
    assert slide_lint.faults(slide_lint.measure(deck)[2]) == []


def test_code_without_its_sentence_is_a_fault(look):
    look.page.add_init_script(handout.NO_SCENES)
    start(look, "14-other-arms")
    look.page.evaluate("""() => {
      const slide = document.querySelector(".code").closest("section");
      slide.id = "bare";
      for (const words of slide.querySelectorAll("p, li, td")) words.remove();
    }""")
    number = look.page.evaluate("Reveal.getSlides().findIndex((slide) => slide.id === 'bare')")
    assert "code without a sentence" in slide_lint.faults(slide_lint.measure(look.page)[number])


@pytest.mark.parametrize("name", CHAPTERS[::5])
def test_the_first_scene_of_a_deck_is_live(look, name):
    start(look, name)
    boxes = look.page.locator(".omx-scene[data-scene]")
    if not boxes.count():
        pytest.skip("this deck has no scene")
    boxes.first.evaluate(SHOW)
    frame = look.scene(boxes.first)
    assert not is_blank(picture(frame))
    assert look.problems == []


def test_the_clicker_works_after_a_hand_on_a_slider_or_in_a_scene(look):
    start(look, "02-frames-and-dh")
    panel = look.page.locator(".omx-panel").first
    panel.evaluate(SHOW)
    here = look.page.evaluate(WHERE)
    frame = look.scene(panel.locator(".omx-scene"))
    slider = panel.locator("input").first
    before, box = slider.input_value(), slider.bounding_box()
    look.page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    look.page.mouse.down()
    look.page.mouse.move(box["x"] + 10, box["y"] + box["height"] / 2)
    look.page.mouse.up()
    value = slider.input_value()
    assert value != before
    assert_keys_turn_pages(look.page, here)
    panel.evaluate(SHOW)
    frame.locator("canvas").first.click(position={"x": 40, "y": 40})
    assert look.page.evaluate("document.activeElement.tagName") == "IFRAME"
    assert_keys_turn_pages(look.page, here)
    slider.focus()  # by Tab: arrows are the slider's, the clicker's keys are not
    slider.press("ArrowRight")
    assert int(slider.input_value()) == int(value) + 1
    assert look.page.evaluate(WHERE) == here
    slider.press("PageDown")
    assert look.page.evaluate(WHERE) != here


def assert_keys_turn_pages(page, here):
    for there, back in (("PageDown", "PageUp"), ("ArrowRight", "ArrowLeft"), ("n", "p")):
        page.keyboard.press(there)
        page.wait_for_function(f"(here) => {WHERE} !== here", arg=here, timeout=5000)
        page.keyboard.press(back)
        page.wait_for_function(f"(here) => {WHERE} === here", arg=here, timeout=5000)


def test_notes_and_fragments_work(look):
    start(look, "03-forward-kinematics")
    assert re.fullmatch(
        r"Slide 1 of \d+: .*, from minute 0 of \d+\.", look.page.locator(".notes .clock").first.text_content()
    )
    assert look.page.locator(".notes .say").count() > 10
    assert (
        look.page.locator(".notes mjx-assistive-mml").count() > 10
    )  # each formula once, in a window without our style
    assert look.page.locator(".notes mjx-assistive-mml:not([style])").count() == 0
    hidden = look.page.locator(".fragment:not(.visible)").count()
    assert hidden > 3
    look.page.evaluate("Reveal.nextFragment() || (Reveal.next(), Reveal.nextFragment())")
    assert look.page.evaluate("typeof Reveal.getPlugin('notes').open") == "function"


EARLY = """() => [...document.querySelectorAll(".slides > section > section")].filter((slide) => {
  const shown = [...slide.querySelectorAll(".piece")].map((piece) => !piece.matches(".fragment"));
  return shown.lastIndexOf(true) > shown.indexOf(false) && shown.includes(false);
}).map((slide) => slide.innerText.slice(0, 40))"""


@pytest.mark.parametrize("name", ["05-inverse-kinematics", "15-six-joints"])
def test_what_follows_a_step_comes_with_it(look, name):
    """A conclusion does not stand on the slide before that from which it is drawn."""
    start(look, name)
    assert look.page.locator(".fragment").count() > 3
    assert look.page.evaluate(EARLY) == []


def test_handouts_have_the_slides_numbers_tags_and_pictures_of_the_scenes(built_site, tmp_path, look):
    folder = tmp_path / "slides"
    slides.build([site.ROOT / "notebooks" / "03-forward-kinematics.ipynb"], folder)
    deck = folder / "03-forward-kinematics.html"
    program = f"from book.publish import handout; from pathlib import Path; handout.print_all([Path({str(deck)!r})])"
    subprocess.run([sys.executable, "-c", program], cwd=site.ROOT, check=True, timeout=300)  # one Playwright a process
    start(look, "03-forward-kinematics")
    count = look.page.evaluate("Reveal.getTotalSlides()")
    one, four, notes = (path.read_bytes() for path in handout.prints(deck))
    assert pages(one) == count
    assert pages(four) == -(-count // 4)
    assert count / 4 < pages(notes) < count / 2
    said = "[...document.querySelectorAll('aside.notes mjx-container svg')].map((svg) => svg.getAttribute('width'))"
    assert (widths := look.page.evaluate(said))
    assert all(width.endswith("ex") for width in widths), "a formula in the notes is as large as on the slide"
    for data in (one, four, notes):
        assert data.startswith(b"%PDF")
        assert b"/MarkInfo" in data
        assert b"/StructTreeRoot" in data
        assert b"Headless" not in data
        assert data.count(b"/Subtype /Image") >= 1
    assert handout.is_current(deck)
    (link,) = [line for line in slides.handouts(deck) if "notes" in line]
    assert link == '<a href="03-forward-kinematics-notes.pdf">with notes</a>'


PRINT = """import sys
from pathlib import Path
from book.publish import handout
handout.print_all([Path(sys.argv[1])])"""


def test_a_deck_with_a_scene_prints_the_same_bytes_in_another_folder_and_time_zone(built_site, tmp_path):
    view = View()
    view.trail()
    shown = scenes.html_of(with_poster(view.page_data()))
    scene = {"output_type": "display_data", "metadata": {}, "data": {"text/html": shown}}
    cells = [markdown("# A\n\nA [link](02-frames-and-dh.ipynb) to another deck.\n\n| a |\n|-|\n| 1 |", "slide"),
             code("2 + 3"), markdown("## B\n\nThe arm."), code("view", outputs=[scene])]  # fmt: skip
    made = []
    for folder, zone in (("one", "UTC"), ("two and more", "Asia/Kolkata")):
        shutil.copytree(
            built_site / "slides/lib", tmp_path / folder / "lib", ignore=shutil.ignore_patterns("*.printed")
        )
        path = slides.write_deck("A", {"cells": cells}, tmp_path / folder / "00-small.html")
        environment = {**os.environ, "TZ": zone, "PYTHONHASHSEED": str(len(folder))}
        subprocess.run([sys.executable, "-c", PRINT, path], cwd=site.ROOT, check=True, timeout=300, env=environment)
        made.append([file.read_bytes() for file in (path, *handout.prints(path))])
    assert all(data.count(b"/Subtype /Image") for data in made[0][1:])
    assert made[0] == made[1]


def pages(pdf):
    """How many pages a PDF of Chromium's has."""
    return len(re.findall(rb"/Type /Page\b(?!s)", pdf))
