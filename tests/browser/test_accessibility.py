"""Everybody can use it: axe, the keyboard alone, and what a screen reader hears.

Pages of 320 px, and the keys of every Play, are in test_site.py, which has all chapters open.

`book/accessibility.md` names these tests as its evidence.
"""

import re
from pathlib import Path

import numpy as np
import pytest

import omx
from book.publish import site
from tests.browser.test_site import CHAPTERS
from tests.browser.weblook import serious

#: One page of each kind of figure and scene.
LIVE = [path for path in CHAPTERS if re.search("start-here|forward|jacobian|servos|other-arms|differential|pick", path)]


@pytest.fixture(scope="module")
def window():
    return 1280, 860


@pytest.fixture(scope="module")
def motion():
    return "reduce"  # no film is looked at but one, and that is started by its button


# ---- axe ------------------------------------------------------------------------------------


OTHERS = ("notation", "accessibility", "teach/course", "api/kinematics")
LIGHT = ["book/index.html", *(f"book/{name}.html" for name in OTHERS), *LIVE]
OF_COLOURS = ("color-contrast", "link-in-text-block")
DARK = ["book/index.html", "book/notation.html", *LIVE[1:4]]


@pytest.mark.parametrize("path", LIGHT)
def test_axe_finds_nothing_serious_on_a_page(look, path):
    """In the light; some pages in the dark, too, where nothing but colours is another."""
    look.open(path).settle()
    for theme, rules in {"light": (), "dark": OF_COLOURS}.items() if path in DARK else (("light", ()),):
        look.page.emulate_media(color_scheme=theme)
        look.page.locator(f"html[data-theme={theme}]").wait_for()
        look.page.wait_for_timeout(400)
        assert serious(look.page, rules=rules) == [], theme


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_axe_finds_nothing_serious_in_a_scene_with_its_menu_open(look, theme):
    look.page.emulate_media(color_scheme=theme)
    look.open("book/index.html").settle()
    frame = look.scene(look.page.locator(".omx-scene[data-scene]").first)
    frame.locator("#omx-bar button[aria-label^=More]").click()
    frame.wait_for_timeout(300)
    assert serious(frame) == []


@pytest.mark.parametrize("name", ["03-forward-kinematics", "09-servos-and-the-wire"])
def test_axe_finds_nothing_serious_in_a_deck(look, name):
    look.open(f"slides/{name}.html").page.wait_for_selector("body[data-ready]", timeout=120_000)
    assert serious(look.page) == []


# ---- 400 %: a page of 1280 px is 320 px wide then ----------------------------------------------------------


BOX = "(b) => { const { left, top, right, bottom } = b.getBoundingClientRect(); return [left, top, right, bottom]; }"


def test_a_scenes_buttons_are_all_in_sight_at_four_hundred_percent(look):
    look.page.set_viewport_size({"width": 320, "height": 640})
    look.open("book/index.html").settle()
    frame = look.scene(look.page.locator(".omx-scene[data-scene]").first)
    frame.locator("#omx-bar button[aria-label^=More]").click()
    width, height = frame.evaluate("[innerWidth, innerHeight]")
    for button in frame.locator("#omx-bar button:visible").all():
        left, top, right, bottom = button.evaluate(BOX)
        assert 0 <= left < right <= width
        assert 0 <= top < bottom <= height
        assert min(right - left, bottom - top) >= 24, "large enough for a finger"


SPACED = "* { line-height: 1.5 !important; letter-spacing: 0.12em !important; word-spacing: 0.16em !important; }"


def test_words_set_wider_stay_on_the_page(look):
    look.open("notebooks/09-servos-and-the-wire.html").settle().page.add_style_tag(content=SPACED)
    assert look.page.evaluate("document.documentElement.scrollWidth") <= 1280
    answer = look.page.locator(".omx-panel .omx-answer")
    assert answer.evaluate("(a) => a.scrollHeight <= a.clientHeight + 1")


def test_nothing_moves_by_itself_for_those_who_ask_for_rest(look):
    look.open("notebooks/09-servos-and-the-wire.html").settle()
    frame = look.scene(look.page.locator(".omx-scene[data-scene]").last)
    assert frame.evaluate("omxScene.viewer.animator.actions.length") > 0
    assert not frame.evaluate("omxScene.viewer.animator.playing")


# ---- the keyboard alone ------------------------------------------------------------------------------------

STOPS = "() => (document.activeElement?.ariaLabel || document.activeElement?.textContent || '').trim()"
SEEN_FROM = "omxScene.viewer.camera.getWorldPosition(new MeshCat.THREE.Vector3()).toArray()"


def test_a_scene_is_turned_and_its_tool_is_moved_by_keys_alone(look):
    look.open("book/index.html").settle()
    frame = look.scene(look.page.locator(".omx-scene[data-scene]").first)
    keyboard = look.page.keyboard
    frame.locator("canvas").focus()
    seen = [frame.evaluate(SEEN_FROM)]
    for key in ("ArrowLeft", "ArrowUp", "+"):
        keyboard.press(key)
        seen.append(frame.evaluate(SEEN_FROM))
        assert np.linalg.norm(np.subtract(*seen[-2:])) > 0.02, key
    assert np.linalg.norm(seen[3]) < np.linalg.norm(seen[2])
    stops = []
    while not stops or not stops[-1].startswith("More"):
        keyboard.press("Tab")
        stops.append(frame.evaluate(STOPS))
        if stops[-1] == "Drag the tool" and not frame.evaluate("omxScene.tool.state().on"):
            keyboard.press("Enter")
    assert stops == [*(f"View: {name}" for name in ("iso", "side", "front", "top")), "Drag the tool", stops[-1]]
    before = frame.evaluate("omxScene.tool.state().asked")
    while not frame.evaluate(STOPS).startswith("The tool"):
        keyboard.press("Tab")
    keyboard.press("PageUp")
    frame.wait_for_timeout(900)
    state = frame.evaluate("omxScene.tool.state()")
    assert state["asked"][2] == pytest.approx(round(before[2]) + 1)
    assert omx.pose(state["q"])[2] == pytest.approx(state["asked"][2])
    assert look.problems == []


# ---- what is heard ------------------------------------------------------------------------------------


def test_a_scene_says_pose_branch_and_verdict_when_it_settles(look):
    look.open("book/index.html").settle()
    panel = look.page.locator(".omx-panel").first
    frame = look.scene(panel.locator(".omx-scene"))
    frame.wait_for_timeout(700)
    panel.locator("input").nth(1).press("PageUp")
    frame.wait_for_timeout(1200)
    said = frame.get_by_role("status").inner_text()
    x, y, z, pitch = omx.pose(frame.evaluate("omxScene.tool.state().q"))
    where = f"x = {x:.1f}, y = {y + 0:.1f}, z = {z:.1f} mm, pitch = {np.degrees(pitch):.1f}°"
    assert said.replace("\u2212", "-") == f"Tool at {where}; front, elbow up; within its limits, touching nothing."


def test_a_row_and_an_arm_of_another_kind_say_where_they_lead(look):
    look.open(next(path for path in CHAPTERS if "-frames-and-dh" in path)).settle()
    panel = look.page.locator(".omx-panel[data-kind=row]")
    panel.get_by_role("slider", name="d in mm").fill("77")
    look.page.wait_for_timeout(700)
    assert re.fullmatch(
        r"The next frame's origin is at x = .*, z = 77\.0 mm\.", panel.locator(".omx-spoken").inner_text()
    )


# ---- the page that states it -------------------------------------------------------------------------------


def test_the_page_names_tests_that_exist():
    text = (site.ROOT / "book/accessibility.md").read_text(encoding="utf-8")
    named = set(re.findall(r"`(test_\w+)`", text))
    files = [file.read_text(encoding="utf-8") for file in Path(site.ROOT / "tests").rglob("test_*.py")]
    defined = {name for file in files for name in re.findall(r"def (test_\w+)", file)}
    assert len(named) > 10
    assert named <= defined, named - defined
