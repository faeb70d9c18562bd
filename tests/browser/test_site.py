"""The site in a browser without a network: every page loads, shows formulas and scenes, and leads nowhere else."""

import math
import re
import time
from urllib.parse import urljoin

import numpy as np
import pytest

import omx
from book.publish import site
from tests.browser.weblook import Look, image_of, is_blank, picture

LIMIT = 1_500_000
SHARED = ("_static/omx-view.js", "_static/mathjax/tex-svg-full.js")


@pytest.fixture(scope="module")
def window():
    return 1280, 860


@pytest.fixture(scope="module")
def motion():
    return "reduce"  # films stand until a test starts them: software draws them all the time


def pages():
    """Every page's path; the chapters and what stands in book/."""
    root = site.ROOT
    sources = [*root.glob("notebooks/*.ipynb"), *root.glob("book/*.md"), *root.glob("book/*/*.md")]
    return sorted(path.relative_to(root).with_suffix(".html").as_posix() for path in sources)


CHAPTERS = [path for path in pages() if path.startswith("notebooks/")]


def name_of(path):
    """The words of a chapter's name, without its number."""
    return path.split("/")[1][3:].removesuffix(".html")


@pytest.fixture(scope="module", params=CHAPTERS)
def chapter(request, context, home):
    """A chapter's page, its formulas typeset: opened once for all tests that ask for it, which come in this order."""
    with Look(context, home) as look:
        yield look.open(request.param).settle()


def is_whole_and_light(look):
    own = {name: size for name, size in look.weight().items() if name not in SHARED}
    assert look.problems == []
    assert sum(own.values()) < LIMIT, f"{sum(own.values())} bytes: {sorted(own.items(), key=lambda item: -item[1])[:4]}"


def has_all_in_sight(look):
    """At 400 %, a page of 1280 px is 320 px wide."""
    look.page.set_viewport_size({"width": 320, "height": 640})
    assert look.page.evaluate("document.documentElement.scrollWidth") <= 320
    for box in look.page.locator(".omx-panel :is(input, button, output, .omx-plot)").all():
        place = box.bounding_box()
        assert place is None or (place["x"] >= 0 and place["x"] + place["width"] <= 320)


@pytest.mark.parametrize("path", [path for path in pages() if path not in CHAPTERS])
def test_a_page_loads_whole_is_light_stays_at_home_and_loses_nothing_at_four_hundred_percent(look, path):
    look.open(path).settle()
    is_whole_and_light(look)
    has_all_in_sight(look)


def test_a_chapter_loads_whole_is_light_and_stays_at_home(chapter):
    is_whole_and_light(chapter)


def test_every_play_is_reached_by_tab_and_works_by_keys(chapter):
    """All that can be moved on a chapter's page can be focused, is named, and answers the arrow keys or Enter."""
    for panel in chapter.page.locator(".omx-panel").all():
        for control in panel.locator("input, button").all():
            control.focus()
            assert control.evaluate("(c) => c === document.activeElement && c.tabIndex === 0")
            assert control.evaluate("(c) => c.ariaLabel || c.textContent")
    for slider in chapter.page.locator(".omx-panel input[type=range]").all():
        before = slider.input_value()
        slider.press("ArrowRight" if before != slider.get_attribute("max") else "ArrowLeft")
        assert slider.input_value() != before
    for box in chapter.page.locator(".omx-scene[data-scene]").all()[:1]:
        box.focus()  # where Tab comes to a scene that is not loaded yet
        frame = chapter.scene(box)
        chapter.page.keyboard.press("Tab")
        chapter.page.wait_for_function("document.activeElement.tagName === 'IFRAME'")
        assert frame.locator("canvas").get_attribute("tabindex") == "0"
        if frame.evaluate("omxScene.viewer.animator.actions.length"):
            play = frame.get_by_role("button", name="Play or pause")
            playing = frame.evaluate("omxScene.viewer.animator.playing")
            play.press("Enter")
            assert frame.evaluate("omxScene.viewer.animator.playing") != playing
            play.press("Enter")  # software draws a film at the price of a core
    assert chapter.problems == []


def test_a_chapter_shows_formulas_scenes_and_no_dead_widget(chapter):
    assert chapter.page.locator("mjx-container").count() == chapter.page.locator(".math").count() or is_typeset(chapter)
    assert chapter.page.locator("mjx-merror").count() == 0
    assert chapter.page.locator("script[type*='widget']").count() == 0
    assert chapter.page.locator(".cell_output >> text=JointPanel:").count() == 0
    pictures = chapter.page.locator("article img:not(.omx-print)")
    for i in range(pictures.count()):
        assert len(pictures.nth(i).get_attribute("alt") or "") > 20, f"picture {i} has no alt text"
    for box in scenes(chapter):
        frame = chapter.scene(box)
        assert not is_blank(picture(frame)), "a scene is blank"
        if frame.evaluate("omxScene.viewer.animator.actions.length"):
            plays_and_pauses(frame)
    assert chapter.problems == []


#: Blocks of code, and those among them that scroll sideways; the smallest type among them, px.
CODE = """() => {
  const blocks = [...document.querySelectorAll("div.cell_input pre")].filter((block) => block.offsetHeight);
  const wide = blocks.filter((block) => block.scrollWidth > block.clientWidth + 1);
  return [blocks.length, wide.length, Math.min(...blocks.map((block) => parseFloat(getComputedStyle(block).fontSize)))];
}"""


def test_nearly_all_code_is_seen_without_scrolling(chapter):
    blocks, wide, type_px = chapter.page.evaluate(CODE)
    assert wide <= 0.15 * blocks
    assert type_px >= 10.5


def test_a_chapter_loses_nothing_at_four_hundred_percent(chapter):
    has_all_in_sight(chapter)


def is_typeset(look):
    """No dollar and no backslash command of a formula is left in the text."""
    words = "a => [...a.querySelectorAll('.math')].map(m => m.innerText).join(' ')"
    return "\\" not in look.page.locator("article").evaluate(words)


def scenes(look):
    boxes = look.page.locator(".omx-scene[data-scene]")
    return [boxes.nth(i) for i in range(boxes.count())]


def plays_and_pauses(frame):
    button = frame.locator("button[aria-label='Play or pause']")
    if not frame.evaluate("omxScene.viewer.animator.playing"):
        button.click()
    before, start = picture(frame), time.monotonic()
    while not (moves := abs(picture(frame) - before).max() > 30) and time.monotonic() < start + 10:
        frame.wait_for_timeout(100)
    assert moves, "the scene plays and nothing moves"
    button.click()
    stopped = frame.evaluate("omxScene.viewer.animator.time")
    frame.wait_for_timeout(200)
    assert frame.evaluate("omxScene.viewer.animator.time") == stopped


def test_joint_sliders_move_the_arm_and_the_numbers(look):
    look.open("book/index.html")
    panel = look.page.locator(".omx-panel").first
    frame = look.scene(panel.locator(".omx-scene"))
    before, numbers = picture(frame), panel.locator(".omx-values").inner_text()
    slider = panel.locator("input[type=range]").first
    slider.focus()
    for _ in range(3):
        slider.press("PageUp")
    look.page.wait_for_timeout(400)
    assert panel.locator(".omx-values").inner_text() != numbers
    assert abs(picture(frame) - before).max() > 30
    panel.get_by_role("button", name="zero").click()
    assert "x = 274.0 mm" in panel.locator(".omx-values").inner_text()
    assert "z = 204.8 mm" in panel.locator(".omx-values").inner_text()
    assert look.problems == []


LIVE = {
    "forward-kinematics": "JointPanel", "jacobian": "JointPanel", "servos-and-the-wire": "answer", "lab-ik": "log",
    "trajectories": "ways", "accuracy": "cloud", "differential-ik": "damping",
}  # fmt: skip


@pytest.mark.parametrize("path", [path for path in CHAPTERS if name_of(path) in LIVE])
def test_a_chapter_has_the_live_figure_of_its_idea(look, path):
    """By keyboard alone: each slider changes what is said; what is drawn follows."""
    look.open(path).settle()
    figure = LIVE[name_of(path)]
    kind = "joints" if figure == "JointPanel" else "figure"
    panel = look.page.locator(f".omx-panel[data-kind={kind}]").last
    assert kind == "joints" or f'"figure": "{figure}"' in panel.get_attribute("data-panel")
    answer = panel.locator(".omx-answer")
    for i in range(panel.locator("input[type=range]").count()):
        slider, before = panel.locator("input[type=range]").nth(i), answer.inner_text()
        slider.focus()
        for _ in range(2):
            slider.press("ArrowRight")
        assert answer.inner_text() != before, slider.get_attribute("aria-label")
    if kind == "figure":
        name = panel.locator("svg[role=img]").get_attribute("aria-label") if figure != "answer" else answer.inner_text()
        assert all(words.inner_text() in name for words in answer.locator("p").all())
        look.page.wait_for_timeout(700)
        assert panel.locator(".omx-spoken").inner_text() == " ".join(answer.locator("p").all_inner_texts())
    assert look.problems == []


ELLIPSE = """() => {
  const { children } = omxScene.viewer.scene_tree.find(["meshcat"]).object;
  const tube = children.find((o) => o.geometry?.type === "TubeGeometry");
  const at = tube.geometry.attributes.position.array, points = [];
  for (let i = 0; i < at.length; i += 3) points.push([at[i], at[i + 1], at[i + 2]].map((v) => 1e3 * v));
  return { q: omxScene.tool.state().q, points };
}"""


def test_the_velocity_ellipse_follows_sliders_and_the_dragged_tool(look):
    look.open(next(path for path in CHAPTERS if "-jacobian" in path)).settle()
    panel = look.page.locator(".omx-panel").last
    frame = look.scene(panel.locator(".omx-scene"))
    frame.wait_for_timeout(500)

    def check():
        frame.wait_for_timeout(600)
        seen = frame.evaluate(ELLIPSE)
        J = omx.jacobian(seen["q"])[:3]
        held = 0.15 * (J[:, 1:3] - J[:, 3:])
        out = np.array(seen["points"]) - omx.pose(seen["q"])[:3]
        size = np.linalg.norm(np.linalg.pinv(held) @ out.T, axis=0)  # 1 on the ellipse; the line is 1.3 mm thick
        assert np.abs(size - 1).max() < 1.4 / np.linalg.svd(held, compute_uv=False)[1]
        return seen["q"]

    first = check()
    slider = panel.locator("input[type=range]").nth(1)
    slider.focus()
    slider.press("PageUp")
    second = check()
    assert second[1] > first[1]
    frame.evaluate("(pose) => omxScene.tool.move(pose)", [*np.add(omx.pose(second), [-20, 30, -25, 0]).tolist()])
    assert check()[0] > 0.1
    assert look.problems == []


def test_axes_of_frames_ride_on_the_arm(look):
    """In chapter 03, when sliders or the reader's hand move it."""
    look.open(next(path for path in CHAPTERS if "-forward-kinematics" in path)).settle()
    panel = look.page.locator(".omx-panel[data-kind=joints]").last
    frame = look.scene(panel.locator(".omx-scene"))
    where = "(i) => omxScene.viewer.scene_tree.find(['meshcat', 'frames', `${i}`]).object.position.toArray()"
    for move in ("(pose) => omxScene.tool.move(pose)", None):
        if move:
            frame.evaluate(move, [200, 60, 180, -0.3])
        else:
            panel.get_by_role("button", name="home").click()
        frame.wait_for_timeout(600)
        q = frame.evaluate("omxScene.tool.state().q")
        for i in range(1, 5):
            assert 1e3 * np.array(frame.evaluate(where, i)) == pytest.approx(omx.frames(q)[i, :3, 3], abs=1e-6)
    assert look.problems == []


def test_pose_sliders_tell_four_verdicts(look):
    look.open("book/index.html")
    panel = look.page.locator(".omx-panel").nth(1)
    frame = look.scene(panel.locator(".omx-scene"))
    assert panel.locator("tbody tr").count() == 4
    before = picture(frame)
    slider = panel.get_by_role("slider", name="z in mm")
    slider.fill("160")
    look.page.wait_for_timeout(400)
    assert abs(picture(frame) - before).max() > 30
    slider.fill("450")
    assert "out of reach" in panel.locator("table").inner_text()
    assert "The arm stays" in panel.locator("[role=status]").first.inner_text()


def node(frame, name):
    """Where a mark of a scene stands, (4, 4), as the viewer has it, and whether it is shown."""
    find = "(name) => omxScene.viewer.scene_tree.find(['meshcat', 'notes', ...name.split('/')]).object"
    elements = f"(name) => {{ const o = ({find})(name); o.updateMatrix(); return [o.matrix.elements, o.visible]; }}"
    elements, visible = frame.evaluate(elements, name)
    return np.array(elements, float).reshape(4, 4).T, visible


def test_the_sliders_of_a_row_move_its_frames_and_its_matrix(look):
    look.open("notebooks/02-frames-and-dh.html").settle()
    panel = look.page.locator(".omx-panel[data-kind=row]")
    frame = look.scene(panel.locator(".omx-scene"))
    before = picture(frame)
    for name, value in {"θ in °": -60, "d in mm": -75, "a in mm": 0, "α in °": 135}.items():
        panel.get_by_role("slider", name=name).fill(str(value))
    look.page.wait_for_timeout(400)
    assert abs(picture(frame) - before).max() > 30
    row = (math.radians(-60), -75.0, 0.0, math.radians(135))
    A = omx.Chain([omx.DHRow(*row)]).fk([0.0])
    told = [float(text.replace("−", "-")) for text in panel.locator(".omx-matrix td").all_inner_texts()]
    assert np.reshape(told, (4, 4)) == pytest.approx(A, abs=0.051)
    frames = {"last": A, "next_axis": A, "d": np.eye(4), "theta": np.eye(4)}
    for name, matrix in frames.items():
        drawn, _ = node(frame, name)
        drawn[:3, 3] *= 1e3
        assert drawn == pytest.approx(matrix, abs=1e-4), name
    shown = {"theta": True, "d": True, "a": False, "alpha": True}
    assert {name: node(frame, name)[1] for name in shown} == shown
    assert {name: node(frame, f"{name}_name")[1] for name in shown} == shown
    assert look.problems == []


def test_the_marks_of_a_row_are_drawn_as_python_draws_them(look):
    """A scene above the panel shows the same row, drawn by Python; the panel has drawn its own anew, there and back."""
    look.open("notebooks/02-frames-and-dh.html").settle()
    panel = look.page.locator(".omx-panel[data-kind=row]")
    same = "[aria-label='DH row: theta = 70.0 deg, d = 90.0 mm, a = 110.0 mm, alpha = 50.0 deg']"
    drawn = look.scene(look.page.locator(f".omx-scene{same}").first)
    frame = look.scene(panel.locator(".omx-scene"))
    box = "(name) => { const { min, max } = new MeshCat.THREE.Box3().setFromObject(omxScene.viewer.scene_tree.find("
    box += "['meshcat', 'notes', name]).object); return [...min.toArray(), ...max.toArray()].map((v) => 1e3 * v); }"
    sliders = [panel.get_by_role("slider", name=name) for name in ("θ in °", "d in mm", "a in mm", "α in °")]
    first = [slider.input_value() for slider in sliders]
    for values in ([-170, -100, -30, -90], [0, 0, 0, 0], first):
        for slider, value in zip(sliders, values, strict=True):
            slider.fill(str(value))
        look.page.wait_for_timeout(300)
    for name in ("theta", "d", "a", "alpha", "theta_name", "d_name", "a_name", "alpha_name"):
        assert frame.evaluate(box, name) == pytest.approx(drawn.evaluate(box, name), abs=3.0), name
    assert look.problems == []


def test_a_robots_panel_says_what_it_can_do_elsewhere(look):
    look.open("notebooks/10-lab-fk.html").settle()
    box = look.page.locator(".omx-robot")
    frame = look.scene(box.locator(".omx-scene"))
    box.get_by_role("button", name="zero").click()
    look.page.wait_for_timeout(400)
    assert not frame.evaluate("omxScene.viewer.scene_tree.find(['meshcat', 'ghosts']).object.visible"), "no pale arm"
    assert "hold-to-move" in box.locator(".omx-note").inner_text()
    assert look.problems == []


# ---- light and dark ------------------------------------------------------------------------------------------


def brightness(frame):
    """The scene's lower corners, 0 to 255: nothing but the ground is there."""
    image = picture(frame)
    return max(image[-12:, :12].mean(), image[-12:, -12:].mean())


def turn_to(look, theme):
    """Choose the theme in the page's own menu."""
    look.page.locator("button.theme-switch-button:visible").first.click()
    look.page.locator(f"button.theme-change-button[data-mode={theme}]:visible").first.click()
    look.page.locator(f"html[data-theme={theme}]").wait_for()
    look.page.wait_for_timeout(400)


POSED = "omxScene.viewer.scene_tree.find(['meshcat', 'arm', '4']).object.matrix.elements.join()"
SEEN_FROM = "omxScene.viewer.camera.getWorldPosition(new MeshCat.THREE.Vector3()).toArray()"


def test_scenes_follow_the_theme_without_a_reload(look):
    look.open("book/index.html").settle()
    turn_to(look, "light")
    panel = look.page.locator(".omx-panel").first
    frame = look.scene(panel.locator(".omx-scene"))
    panel.get_by_role("button", name="zero").click()
    frame.locator("#omx-bar button", has_text="side").click()
    look.page.wait_for_timeout(300)
    kept = frame.evaluate(POSED), frame.evaluate(SEEN_FROM)
    assert brightness(frame) > 220
    turn_to(look, "dark")
    assert brightness(frame) < 90
    assert (frame.evaluate(POSED), frame.evaluate(SEEN_FROM)) == kept
    turn_to(look, "light")
    assert brightness(frame) > 220
    assert (frame.evaluate(POSED), frame.evaluate(SEEN_FROM)) == kept
    look.page.evaluate("localStorage.clear()")  # the choice, for the pages of other tests
    assert look.problems == []


def test_a_page_opened_in_the_dark_has_dark_scenes_and_pale_words(look):
    look.page.emulate_media(color_scheme="dark")
    look.open("notebooks/02-frames-and-dh.html").settle()
    box = look.page.locator(".omx-panel[data-kind=row] .omx-scene")
    frame = look.scene(box)
    frame.wait_for_timeout(900)
    assert brightness(frame) < 90
    words = frame.evaluate(
        "() => { const found = []; omxScene.viewer.scene.traverse((o) => { if (o.isSprite) found.push("
        "atob(o.material.map.image.src.split(',')[1])); }); return found; }"
    )
    assert len(words) >= 10
    assert not [word for word in words if 'stroke="#ffffff"' in word]
    assert look.problems == []


VISIBLE = "(e) => e.offsetHeight > 100 && getComputedStyle(e).visibility === 'visible'"
PAINTED = """(e) => [getComputedStyle(e).color, getComputedStyle(document.body).backgroundColor]
  .map((c) => c.match(/[0-9.]+/g).slice(0, 3).reduce((sum, v) => sum + Number(v), 0) / 3)"""


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_paper_is_white_and_shows_every_scene(look, theme):
    """Without having been scrolled to; and the reader's theme comes back."""
    look.page.emulate_media(color_scheme=theme)
    look.open("notebooks/02-frames-and-dh.html").settle()
    look.page.emulate_media(media="print")
    look.page.evaluate("dispatchEvent(new Event('beforeprint'))")
    printed = look.page.locator("img.omx-print")
    assert printed.count() == len(scenes(look)) > 5
    for i in range(printed.count()):
        assert printed.nth(i).evaluate(VISIBLE)
        assert not is_blank(image_of(printed.nth(i).get_attribute("src")))
    for box in scenes(look):
        assert not box.is_visible()
    for words in ("h1", "article p", "article h2"):
        ink, paper = look.page.locator(words).first.evaluate(PAINTED)
        assert ink < 90
        assert paper > 240
    look.page.evaluate("dispatchEvent(new Event('afterprint'))")
    assert look.page.evaluate("document.documentElement.dataset.theme") == theme


def test_the_safety_card_is_one_page(look):
    look.open("book/teach/safety-card.html").settle()
    paper = look.page.pdf(format="A4", print_background=True)
    assert len(re.findall(rb"/Type\s*/Page\b", paper)) == 1


def test_arrows_in_a_wide_formula_scroll_it_and_the_page_stays(look):
    look.page.set_viewport_size({"width": 390, "height": 844})
    look.open("notebooks/02-frames-and-dh.html").settle()
    box = look.page.locator("div.math[tabindex], mjx-container[tabindex], pre[tabindex]").first
    box.focus()
    for _ in range(3):
        box.press("ArrowRight")
    look.page.wait_for_timeout(300)
    assert look.page.url.endswith("02-frames-and-dh.html")
    assert box.evaluate("(e) => e.scrollLeft") > 0


def test_a_formula_in_a_line_is_never_cut_off_on_a_phone(browser, home):
    context = browser.new_context(viewport={"width": 390, "height": 844}, is_mobile=True, has_touch=True)
    with Look(context, home) as look:
        look.open("notebooks/03-forward-kinematics.html").settle()
        wide = look.page.locator("span.math[tabindex]")
        assert wide.count() >= 2
        for formula in wide.all():
            formula.evaluate("(e) => { e.scrollLeft = 1e4; }")
            assert formula.evaluate("(e) => e.scrollLeft + e.clientWidth >= e.scrollWidth - 1")
    context.close()


def test_the_section_of_the_workspace_turns_with_the_arm(look):
    look.open("notebooks/16-workspace.html").settle()
    panel = look.page.locator(".omx-panel").first
    frame = look.scene(panel.locator(".omx-scene"))
    panel.get_by_role("slider").first.fill("60")
    look.page.wait_for_timeout(500)
    find = "omxScene.viewer.scene_tree.find(['meshcat', 'section']).object"
    elements = frame.evaluate(f"(() => {{ const o = {find}; o.updateMatrix(); return o.matrix.elements; }})()")
    assert elements[:2] == pytest.approx([math.cos(math.radians(60)), math.sin(math.radians(60))], abs=1e-6)


def test_search_finds_an_exercise_by_its_number(look):
    look.open("search.html?q=exercise+4.4")
    first = look.page.locator("#search-results li a").first
    first.wait_for(timeout=30_000)
    look.page.wait_for_timeout(300)
    assert "#exercise-4-4-" in look.page.locator("#search-results li a").first.get_attribute("href")


@pytest.mark.parametrize("words", ["elbow up", "overload"])
def test_search_finds_a_word_of_the_glossary_first(look, words):
    look.open(f"search.html?q={words.replace(' ', '+')}")
    first = look.page.locator("#search-results li a").first
    first.wait_for(timeout=30_000)
    look.page.wait_for_timeout(300)
    assert f"glossary.html#term-{words.replace(' ', '-')}" in first.get_attribute("href")


def test_search_finds_a_word_of_a_chapter(look):
    look.open("search.html?q=singularity")
    look.page.locator("#search-results li").first.wait_for(timeout=30_000)
    assert look.problems == []


def test_a_chapter_offers_its_notebook(look, home):
    look.open(CHAPTERS[0])
    link = look.page.get_by_role("link", name="Download this notebook").get_attribute("href")
    stored = site.ROOT / CHAPTERS[0].replace(".html", ".ipynb")
    assert look.page.request.get(urljoin(home + CHAPTERS[0], link)).body() == stored.read_bytes()


def test_no_name_is_broken_on_a_phone(browser, home):
    context = browser.new_context(viewport={"width": 390, "height": 844}, is_mobile=True, has_touch=True)
    with Look(context, home) as look:
        look.open("book/notation.html").settle()
        code = "all => all.filter((e) => !/[ (]/.test(e.innerText) && e.offsetHeight > 30).map((e) => e.innerText)"
        assert look.page.locator("td code").evaluate_all(code) == []
    context.close()
