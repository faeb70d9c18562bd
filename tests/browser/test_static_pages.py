"""Scenes in plain pages: from the disk, with every request watched, they draw, play and stay in their frame."""

import pytest

import omx
from book.chapters import normalise
from book.reader import handin
from omx.display.viewer import View, write_site_script
from tests.browser.pages import is_blank, pixels, share_changed


@pytest.fixture
def show(browser):
    """Open a page of the disk; returns it, and the addresses that it asked for."""
    context = browser.new_context(viewport={"width": 900, "height": 700})

    def opener(path):
        page = context.new_page()
        asked = []
        page.on("request", lambda request: asked.append(request.url))
        page.goto(path.as_uri())
        return page, asked

    yield opener
    context.close()


def write(folder, *bodies, script=""):
    path = folder / "page.html"
    head = f'<!DOCTYPE html><html><head><meta charset="utf-8">{script}</head>'
    path.write_text(f"{head}<body>{''.join(bodies)}<p id='words'>Around.</p></body></html>", encoding="utf-8")
    return path


def frames(page, count):
    """The scenes' frames, once all of them are drawn."""
    page.wait_for_function(f"document.querySelectorAll('iframe').length === {count}")
    inner = [frame for frame in page.frames if frame != page.main_frame]
    for frame in inner:
        frame.wait_for_selector("body[data-ready]", timeout=30_000)
    page.wait_for_timeout(700)
    return inner


def test_a_scene_plays_in_a_page_that_fetches_nothing(show, tmp_path):
    view = View()
    view.animate([omx.HOME, (0.9, 0.2, 0.2, 0.5), omx.HOME], seconds=2)
    path = write(tmp_path, view.static_html())
    page, asked = show(path)
    (frame,) = frames(page, 1)
    assert [url for url in asked if not url.startswith(("data:", "blob:"))] == [path.as_uri()]
    one = pixels(page.locator("iframe"))
    page.wait_for_timeout(500)
    two = pixels(page.locator("iframe"))
    assert not is_blank(one)
    assert share_changed(one, two) > 0.002, "the animation plays"
    frame.locator("#omx-bar button[aria-label='Play or pause']").click()
    page.wait_for_timeout(300)
    still = pixels(page.locator("iframe"))
    page.wait_for_timeout(400)
    assert share_changed(still, pixels(page.locator("iframe"))) < 0.001, "and stops"


def test_a_scene_cannot_reach_the_page_around_it(show, tmp_path):
    page, _ = show(write(tmp_path, View().static_html()))
    (frame,) = frames(page, 1)
    reach = "(() => { try { parent.document.getElementById('words').remove(); return true } catch { return false } })()"
    assert frame.evaluate(reach) is False
    assert page.locator("#words").count() == 1


def test_scenes_share_one_script_and_wait_for_the_reader(show, tmp_path):
    write_site_script(tmp_path)
    gap = '<div style="height:4000px"></div>'
    path = write(
        tmp_path, View().static_html(shared=True), gap, View(omx.ZERO, dark=True).static_html(shared=True),
        script='<script src="omx-view.js" defer></script>',
    )  # fmt: skip
    page, asked = show(path)
    frames(page, 1)
    assert {url.rsplit("/", 1)[1] for url in asked if url.startswith("file:")} == {"page.html", "omx-view.js"}
    assert not is_blank(pixels(page.locator("iframe").first))
    page.locator(".omx-scene").nth(1).scroll_into_view_if_needed()
    frames(page, 2)
    assert not is_blank(pixels(page.locator("iframe").nth(1)))


def test_the_camera_buttons_turn_the_scene(show, tmp_path):
    page, _ = show(write(tmp_path, View().static_html()))
    (frame,) = frames(page, 1)
    seen = [pixels(page.locator("iframe"))]
    for name in ("side", "front", "top"):
        frame.locator("#omx-bar button", has_text=name).click()
        page.wait_for_timeout(300)
        seen.append(pixels(page.locator("iframe")))
        assert share_changed(seen[-2], seen[-1]) > 0.02


CHAPTER = {
    "scene": ("code", "from omx import JointPanel\nJointPanel()", []),
    "formula": ("markdown", r"The angle $\alpha_1$ is" + "\n\n$$\n\\frac{a}{b}\n$$", []),
}


def test_a_file_to_hand_in_is_alive_and_fetches_nothing(show, tmp_path):
    cells = [
        {"id": name, "cell_type": kind, "source": source, "metadata": {"tags": tags}, "outputs": []}
        for name, (kind, source, tags) in CHAPTER.items()
    ]
    normalise.write(tmp_path / "07.ipynb", normalise.normalise({"cells": cells, "nbformat": 4}))
    handin.write(tmp_path / "07.ipynb", tmp_path / "07.html")
    page, asked = show(tmp_path / "07.html")
    frames(page, 1)
    assert {url for url in asked if not url.startswith(("data:", "blob:", "about:"))} == {page.url}
    assert page.locator("math").count() == 2
    assert page.locator("mfrac").bounding_box()["height"] > 20, "drawn, not only there"
    before = pixels(page.locator("iframe"))
    page.locator(".omx-panel input").first.focus()
    for _ in range(40):
        page.keyboard.press("ArrowRight")
    page.wait_for_timeout(500)
    assert share_changed(before, pixels(page.locator("iframe"))) > 0.002, "the slider turns the arm"
