"""Every chapter in the browser's Python, cell by cell against its stored outputs: `python run.py test lite`.

A plain static server, the network cut, no Python but the tab's. It takes a quarter of an hour, so the ordinary tests
leave it out. What may differ, and why, is listed in `lite_differences.json`.
"""

import json
from pathlib import Path
from unittest import mock

import pytest
from playwright.sync_api import sync_playwright

from book.chapters import cells, normalise, runs
from book.publish import lite
from tests.browser.conftest import FLAGS
from tests.browser.weblook import served

DIFFERENCES = json.loads(Path(__file__).with_name("lite_differences.json").read_text(encoding="utf-8"))
CHAPTERS = [path.name for path in runs.chapters()]
#: Nothing but this machine has an address.
CUT_OFF = "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1"
PATIENCE_MS = 300_000

IDLE = """() => {
  const panel = window.jupyterapp?.shell.currentWidget;
  return panel?.sessionContext?.session?.kernel?.status === "idle" && panel.content.model.cells.length > 3;
}"""
RUN_ALL = """async () => {
  await jupyterapp.commands.execute("notebook:run-all-cells");
  return jupyterapp.shell.currentWidget.content.model.toJSON();
}"""


@pytest.fixture(scope="module")
def home(tmp_path_factory):
    root = tmp_path_factory.mktemp("lite")
    with mock.patch.multiple(lite, SOURCE=root / "source", LITE=root / "lite"):
        lite.build(solutions=True)
    with served(root / "lite") as address:
        yield address


@pytest.fixture
def page(chromium, home):
    """A tab of a browser that reaches this machine only; `page.outside` lists what it asked of others."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=(*FLAGS, CUT_OFF))
        context = browser.new_context(viewport={"width": 1300, "height": 1000})
        page = context.new_page()
        page.outside, page.complaints = [], []
        local = (home, "data:", "blob:", "about:")
        context.on("request", lambda request: request.url.startswith(local) or page.outside.append(request.url))
        page.on("pageerror", lambda error: page.complaints.append(str(error)))
        page.on("console", lambda message: message.type == "error" and page.complaints.append(message.text))
        yield page
        browser.close()


@pytest.mark.parametrize("name", CHAPTERS)
def test_a_chapter_prints_in_the_browser_what_is_stored(name, home, page, capsys):
    page.goto(f"{home}lab/index.html?path={name}")
    page.wait_for_function(IDLE, timeout=PATIENCE_MS)
    page.set_default_timeout(PATIENCE_MS)
    ready = page.evaluate("performance.now() / 1e3")
    done = page.evaluate(RUN_ALL)["cells"][1:]  # without the line that says where it runs
    took = page.evaluate("performance.now() / 1e3") - ready
    stored = normalise.read(normalise.NOTEBOOKS / name)["cells"]
    accepted = DIFFERENCES.get(name[:2], {})
    code = [(here, there) for here, there in zip(done, stored, strict=True) if cells.is_code(there)]
    ran = [here for here, _ in code if here["execution_count"]]
    differing = {there["id"]: (texts(here), texts(there)) for here, there in code if differs(here, there)}
    with capsys.disabled():
        print(f"\n{name}: {len(ran)} of {len(code)} cells, {len(differing)} differ, ready in {ready:.0f} s, ", end="")
        print(f"run in {took:.0f} s, {len(page.outside)} requests to others, {len(page.complaints)} complaints")
    assert len(ran) == len(code), failures(code)
    assert failures(code) == []
    assert {key: value for key, value in differing.items() if key not in accepted} == {}
    assert set(accepted) <= set(differing), "a difference that is gone is still listed"
    assert page.outside == []


def failures(code):
    """Cells that end with an error which the chapter does not mean to show."""
    return [
        (there["id"], output["ename"], output["evalue"][:300])
        for here, there in code
        if "raises-exception" not in cells.tags(there)
        for output in here["outputs"]
        if output["output_type"] == "error"
    ]


def differs(here, there):
    return "nbval-ignore-output" not in cells.tags(there) and texts(here) != texts(there)


def texts(cell):
    """What of a cell's outputs is stored, without the numbers of cells."""
    kept = normalise.clean_outputs(json.loads(json.dumps(cell["outputs"])))
    return [{key: value for key, value in output.items() if key != "execution_count"} for output in kept]


def test_a_panel_is_dragged_and_a_log_is_kept(home, page):
    """Chapter 00 under the hand: its slider moves the arm in the tab, and so does the tool's handle."""
    page.goto(f"{home}lab/index.html?path={CHAPTERS[0]}")
    page.wait_for_function(IDLE, timeout=PATIENCE_MS)
    page.set_default_timeout(PATIENCE_MS)
    page.evaluate(RUN_ALL)
    page.locator(".omx-scene[data-ready]").first.scroll_into_view_if_needed()
    page.wait_for_timeout(2000)
    frame = next(f for f in page.frames if f != page.main_frame and f.evaluate("!!window.omxScene?.tool"))
    before = frame.evaluate("omxScene.tool.state().q")
    page.locator(".noUi-handle").first.press("ArrowRight")
    page.wait_for_timeout(2000)
    assert frame.evaluate("omxScene.tool.state().q") != before
    assert page.outside == []
