"""The site in a browser without a network: every page loads, shows formulas and scenes, and leads nowhere else."""

from urllib.parse import urljoin

import pytest

from book.tools import site

from .weblook import Look, is_blank, picture, served

LIMIT = 1_500_000
SHARED = ("_static/omx-view.js", "_static/mathjax/tex-svg-full.js")
AXE = site.BUILD / "npm" / "node_modules" / "axe-core" / "axe.min.js"


@pytest.fixture(scope="module")
def home(built_site):
    """The address of the site, built from what is here now."""
    with served(site.SITE) as address:
        yield address


@pytest.fixture(scope="module")
def context(browser):
    context = browser.new_context(viewport={"width": 1280, "height": 860})
    yield context
    context.close()


@pytest.fixture
def look(context, home):
    with Look(context, home) as look:
        yield look


def pages():
    """Every page's path; the chapters and what stands in book/."""
    root = site.ROOT
    sources = [*root.glob("notebooks/*.ipynb"), *root.glob("book/*.md"), *root.glob("book/*/*.md")]
    return sorted(path.relative_to(root).with_suffix(".html").as_posix() for path in sources)


CHAPTERS = [path for path in pages() if path.startswith("notebooks/")]


@pytest.mark.parametrize("path", pages())
def test_a_page_loads_whole_is_light_and_stays_at_home(look, path):
    look.open(path).settle()
    weight = look.weight()
    own = sum(size for name, size in weight.items() if name not in SHARED)
    assert look.problems == []
    assert own < LIMIT, f"{path} weighs {own / 1e6:.2f} MB: {sorted(weight.items(), key=lambda item: -item[1])[:4]}"


@pytest.mark.parametrize("path", CHAPTERS)
def test_a_chapter_shows_formulas_scenes_and_no_dead_widget(look, path):
    look.open(path).settle()
    assert look.page.locator("mjx-container").count() == look.page.locator(".math").count() or maths_is_typeset(look)
    assert look.page.locator("mjx-merror").count() == 0
    assert look.page.locator("script[type*='widget']").count() == 0
    assert look.page.locator(".cell_output >> text=JointPanel:").count() == 0
    pictures = look.page.locator("article img:not(.omx-print)")
    for i in range(pictures.count()):
        assert len(pictures.nth(i).get_attribute("alt") or "") > 20, f"picture {i} has no alt text"
    for box in scenes(look):
        frame = look.scene(box)
        assert not is_blank(picture(frame)), "a scene is blank"
        if frame.evaluate("omxScene.viewer.animator.actions.length"):
            plays_and_pauses(frame)
    assert look.problems == []


def maths_is_typeset(look):
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
    before = picture(frame)
    frame.wait_for_timeout(700)
    assert abs(picture(frame) - before).max() > 30, "the scene plays and nothing moves"
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
    assert "The arm stays" in panel.locator("[role=status]").inner_text()


def test_search_finds_a_word_of_a_chapter(look):
    look.open("search.html?q=singularity")
    look.page.locator("#search-results li").first.wait_for(timeout=30_000)
    assert look.problems == []


def test_a_chapter_offers_its_notebook(look, home):
    look.open(CHAPTERS[0])
    link = look.page.get_by_role("link", name="Download this notebook").get_attribute("href")
    stored = site.ROOT / CHAPTERS[0].replace(".html", ".ipynb")
    assert look.page.request.get(urljoin(home + CHAPTERS[0], link)).body() == stored.read_bytes()


@pytest.mark.parametrize("theme", ["light", "dark"])
@pytest.mark.parametrize("path", ["book/index.html", "notebooks/03-forward-kinematics.html", "book/notation.html",
                                  "book/teach/course.html", "book/api/kinematics.html"])  # fmt: skip
def test_no_serious_accessibility_error(browser, home, path, theme):
    context = browser.new_context(viewport={"width": 1280, "height": 860}, color_scheme=theme)
    with Look(context, home) as look:
        look.open(path).settle()
        look.page.add_script_tag(path=AXE)
        found = look.page.evaluate("axe.run(document, {iframes: false})")["violations"]
    context.close()
    serious = [
        f"{v['id']}: {v['help']}: {v['nodes'][0]['html'][:150]} ({len(v['nodes'])} times)"
        for v in found
        if v["impact"] in ("serious", "critical")
    ]
    assert serious == []


def test_the_page_fits_a_phone(browser, home):
    context = browser.new_context(viewport={"width": 390, "height": 844}, is_mobile=True, has_touch=True)
    with Look(context, home) as look:
        for path in ["book/index.html", *CHAPTERS]:
            look.open(path).settle()
            assert look.page.evaluate("document.documentElement.scrollWidth") <= 390, path
    context.close()
