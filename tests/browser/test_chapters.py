"""Every chapter as a reader meets it: it runs without an error, its scene shows, its sliders move the arm."""

import pytest

from book.chapters import generate, normalise
from tests.book.test_notebooks import checked_in
from tests.browser.pages import fatal, is_blank, pixels, share_changed

CHAPTERS = sorted(path.name for path in normalise.NOTEBOOKS.glob("*.ipynb"))


@pytest.fixture(scope="module")
def motion():
    """Films are for test_scenes and test_static_pages: software draws them all the time, and the next chapter waits."""
    return "reduce"


@pytest.fixture(scope="module")
def sharpness():
    """Fine pictures are looked at in test_scenes and test_static_pages; here an arm is there, and moves."""
    return 0.5


@pytest.mark.parametrize("name", CHAPTERS)
def test_chapter(name, lab, open_page):
    page = open_page(lab.root / "notebooks" / name)
    ports = lab.listening()
    cells = page.run_all()
    check_outputs(cells)
    sure = any("Panel(" in "".join(cell["source"]) for cell in cells if cell["cell_type"] == "code")
    panel = page.panel(sure) if has_widgets(cells) else None
    assert panel or not sure, "its panel does not come"
    scene = panel.locator(".omx-scene").first if panel else page.scene() if has_widgets(cells) else None
    if scene is not None:
        page.settle()
        assert page.until(lambda: not is_blank(pixels(scene))), "the 3-D scene shows nothing"
        assert lab.listening() == ports, "a scene opens no port"
        assert {address for address, _ in ports} == {"127.0.0.1"}
    if panel is not None:
        check_slider(page, scene, panel.locator(".noUi-handle").first)
    assert name[:2] != "00" or panel is not None, "the first chapter has the arm under sliders"
    assert not page.errors


def test_what_they_wrote_is_what_is_checked_in(lab):
    """To the byte, under another hash seed than that of the runs that test_notebooks.py looks at."""
    if not checked_in() <= {path.name for path in lab.generated.iterdir()}:
        pytest.skip("not all of the chapters that write have run here")
    for name in checked_in():
        assert (lab.generated / name).read_bytes() == (generate.GENERATED / name).read_bytes(), generate.FIX


def has_widgets(cells):
    mimes = {mime for cell in cells for output in cell.get("outputs", ()) for mime in output.get("data", ())}
    return "application/vnd.jupyter.widget-view+json" in mimes


def check_outputs(cells):
    for cell in cells:
        if "raises-exception" not in cell["metadata"].get("tags", ()):
            failed = [output for output in cell.get("outputs", ()) if fatal(output)]
            assert not failed, f"{''.join(cell['source'])}\n{failed}"


def check_slider(page, scene, handle):
    """Drag a slider by mouse, then go back by keys until that is seen: the picture changes both times."""
    before = pixels(scene)
    handle.scroll_into_view_if_needed()
    box = handle.bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    mouse = page.page.mouse
    mouse.move(x, y)
    mouse.down()
    for step in range(1, 7):
        mouse.move(x - 6 * step, y)
        page.page.wait_for_timeout(30)
    mouse.up()
    assert page.changes(scene, before, 0.002), "dragging a slider did not move the arm"
    page.settle()
    dragged = pixels(scene)
    was = handle.get_attribute("aria-valuenow")
    handle.press("ArrowRight")
    assert page.until(lambda: handle.get_attribute("aria-valuenow") != was), "the slider takes no arrow key"

    def seen():
        for key in ("ArrowRight", "PageUp", "PageUp"):
            handle.press(key)
        return share_changed(dragged, pixels(scene)) > 0.001

    assert page.until(seen), "the keys did not move the arm"
