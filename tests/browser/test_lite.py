"""The book in a browser tab: built whole or not at all, complete, light, and alive with the network cut.

Every chapter, cell by cell: `python run.py test lite` (lite_chapters.py).
"""

import hashlib
import json
import math
import os
import re
import shutil
import subprocess
import sys
import urllib.request
import zipfile
from contextlib import contextmanager
from pathlib import Path

import numpy
import pytest

from book.chapters import cells, normalise
from book.publish import lite, runs, site
from book.setup.paths import Stop
from omx import HOME, Robot
from omx.hardware.simulator import SteppedClock, VirtualArm, VirtualPort
from tests.browser.conftest import FLAGS
from tests.browser.weblook import NOISE, serious, served
from tests.helpers.lite import IDLE, PATIENCE_MS, SHOWN, chapter, python, run_all, texts


@pytest.fixture(scope="module")
def built():
    try:
        lite.build()
    except Stop as stop:
        pytest.skip(str(stop))
    return lite.LITE


def test_every_chapter_is_there_as_a_sheet_and_says_where_it_runs(built):
    names = sorted(path.name for path in (built / "files").glob("*.ipynb"))
    assert names == [path.name for path in runs.chapters()]
    for name in names:
        first, *rest = json.loads((built / "files" / name).read_text(encoding="utf-8"))["cells"]
        assert "runs in your browser" in "".join(first["source"])
        assert f"path={name}" in (built / "index.html").read_text(encoding="utf-8")
        exercises = next(i for i, cell in enumerate(rest) if "exercise" in cells.tags(cell))
        book = normalise.read(normalise.NOTEBOOKS / name)["cells"]
        stored = {cell["id"]: [lite.uncounted(output) for output in cell.get("outputs", [])] for cell in book}
        read = [cell for cell in rest[:exercises] if cells.is_code(cell)]
        assert all(normalise.clean_outputs(cell["outputs"]) == stored[cell["id"]] for cell in read)
        assert not any(output.get("execution_count") for cell in rest for output in cell.get("outputs", []))
        assert not any(cell.get("outputs") for cell in rest[exercises:]), "no answer can be read there"


def test_every_link_between_chapters_and_pages_leads_somewhere(built):
    files = built / "files"
    texts = [*files.glob("*.ipynb"), *files.glob("book/*.md")]
    links = [
        (path, link) for path in texts for link in re.findall(r"\]\(([^):#]+)\)", path.read_text(encoding="utf-8"))
    ]
    there = [
        (files / link.removeprefix("../") if path.suffix == ".ipynb" else path.parent / link) for path, link in links
    ]
    assert [str(path) for path in there if not path.exists()] == []
    assert {path.name for path in there} > {"notation.md", "errata.md", "bibliography.md"}


def test_it_is_light_and_its_list_knows_what_lies_beside_it(built):
    assert sum(path.stat().st_size for path in built.rglob("*") if path.is_file()) < 56e6
    python = built / "static" / "pyodide"
    packages = json.loads((python / "pyodide-lock.json").read_text(encoding="utf-8"))["packages"].values()
    assert {about["file_name"] for about in packages} == {path.name for path in python.glob("*.whl")}
    for about in packages:
        assert hashlib.sha256((python / about["file_name"]).read_bytes()).hexdigest() == about["sha256"]
        with zipfile.ZipFile(python / about["file_name"]) as wheel:
            recorded = [line.split(",")[0] for line in text_of(wheel, "RECORD").splitlines()]
            assert not [name for name in wheel.namelist() if lite.UNUSED.match(name)]
            assert not [name for name in recorded if lite.UNUSED.match(name)]


def text_of(wheel, name):
    (found,) = [one for one in wheel.namelist() if one.endswith(f".dist-info/{name}")]
    return wheel.read(found).decode()


# ---- how it begins ---------------------------------------------------------------------------------------------------

#: Everything that the page says while it opens, and when Python was there.
LISTEN = """() => {
  window.heard = [];
  const listen = () => {
    const box = document.getElementById("omx-begins");
    const said = box ? [...box.querySelectorAll("p")].map((p) => p.textContent).join("|") : "";
    if (said && window.heard.at(-1) !== said) window.heard.push(said);
  };
  setInterval(listen, 50);
}"""


@contextmanager
def tab_of(playwright, chromium, **settings):
    """An empty tab of a browser that was never here, with its `problems`."""
    browser = playwright.chromium.launch(executable_path=chromium, args=FLAGS)
    tab = browser.new_context(**settings).new_page()
    tab.set_default_timeout(PATIENCE_MS)
    tab.add_init_script(f"({LISTEN})()")
    tab.problems = []
    tab.on("pageerror", lambda error: tab.problems.append(str(error)))
    tab.on("console", lambda message: is_error(message) and tab.problems.append(message.text))
    try:
        yield tab
    finally:
        browser.close()


def is_error(message):
    return message.type == "error" and not any(noise in message.text for noise in NOISE)


def test_python_begins_in_words_and_what_went_wrong_is_one_of_them(built, playwright, chromium, tmp_path):
    name = runs.chapters()[0].name
    with served(built) as home, tab_of(playwright, chromium, viewport={"width": 390, "height": 844}) as tab:
        tab.goto(home)
        tab.locator(f"a[href*='{name}']").click()
        tab.wait_for_function(IDLE, polling=250)
        box = tab.locator("#omx-begins")
        box.get_by_text("Python is ready: run the cells from the top").wait_for()
        assert serious(tab, "#omx-begins") == []
        place = box.bounding_box()
        assert 0 <= place["x"] < place["x"] + place["width"] <= 390
        box.wait_for(state="hidden")
        heard = tab.evaluate("window.heard")
        assert heard[0].startswith("JupyterLab is loaded")
        assert any("10 to 60 seconds" in words for words in heard)
        counts = [re.search(r"(\d+) of (\d+) files, (\d+) of (\d+) MB", words) for words in heard]
        counts = [tuple(map(int, count.groups())) for count in counts if count]
        assert counts == sorted(counts), "they only grow"
        assert len(counts) > 2
        assert any("Python is here and sets itself up" in words for words in heard)
        tab.goto(f"{home}lab/index.html?path={name}")
        tab.get_by_text("Here it took").wait_for()
        assert tab.problems == []
    shutil.copytree(built, tmp_path / "lite")
    (missing,) = (tmp_path / "lite").rglob("sympy-*.whl")
    missing.unlink()
    with served(tmp_path / "lite") as home, tab_of(playwright, chromium) as tab:
        tab.goto(f"{home}lab/index.html?path={name}")
        tab.get_by_text(f"Python did not start: {missing.name} could not be had").wait_for()


def test_around_it_the_site_shows_the_chapter_at_once_and_leads_to_it(
    built, built_site, playwright, chromium, tmp_path
):
    around, name = tmp_path / "site", runs.chapters()[0].stem
    shutil.copytree(built_site, around, ignore=lambda at, _: [site.LITE] if Path(at) == built_site else [])
    lite.lay_into(around)
    with served(around) as home, tab_of(playwright, chromium) as tab:
        tab.goto(f"{home}{site.LITE}/index.html")
        assert tab.get_by_role("link", name="the pages of the book").get_attribute("href") == "../index.html"
        tab.locator(f"a[href*='{name}']").click()
        page = tab.frame_locator("#omx-page")
        page.get_by_role("heading", level=1).wait_for()
        assert tab.evaluate("!window.jupyterapp") or not tab.evaluate(IDLE), "before Python is there"
        page.frame_locator(".omx-scene iframe").locator("body[data-ready]").first.wait_for()
        tab.wait_for_function("document.getElementById('main')?.inert")  # JupyterLab, behind the page
        tab.wait_for_function(IDLE, polling=250)
        tab.get_by_role("button", name="To the notebook").click()
        tab.locator("#omx-page").wait_for(state="hidden")
        tab.get_by_role("menuitem", name="Kernel").click()
        tab.goto(f"{home}notebooks/{name}.html")
        tab.get_by_role("link", name="Run it in your browser").click()
        tab.get_by_role("button", name="Read the chapter's page").wait_for()
        assert tab.locator("#omx-page").is_hidden(), "whoever has gone on once, or comes from the page, is not held up"
        tab.wait_for_function(IDLE, polling=250)
        assert tab.problems == []


def test_a_chapter_lives_with_the_network_cut(built, playwright, chromium):
    """The student's copy of chapter 00, as stored, then run up to its first TODO; slider and tool move the arm."""
    path = runs.chapters()[0]
    with served(built) as home, chapter(playwright, chromium, home, path.name) as tab:
        book = {cell["id"]: texts(cell) for cell in normalise.read(path)["cells"] if cells.is_code(cell)}
        shown = [cell for cell in tab.evaluate(SHOWN)["cells"] if cell.get("outputs")]
        assert len(shown) > 5
        assert all(texts(cell) == book[cell["id"]] for cell in shown)
        done, _ = run_all(tab)
        assert sum(bool(cell.get("execution_count")) for cell in done) >= 5
        tab.evaluate("jupyterapp.shell.currentWidget.content.scrollToItem(2)")
        tab.locator(".omx-scene[data-ready]").first.wait_for()
        tab.wait_for_timeout(1500)
        frame = next(f for f in tab.frames if f != tab.main_frame and f.evaluate("!!window.omxScene?.tool"))
        q = frame.evaluate("omxScene.tool.state().q")
        tab.locator(".noUi-handle").first.press("ArrowRight")
        tab.wait_for_timeout(1500)
        moved = frame.evaluate("omxScene.tool.state().q")
        assert moved != q
        asked = frame.evaluate("omxScene.tool.state().asked")
        frame.evaluate("(pose) => omxScene.tool.move(pose)", [*asked[:2], asked[2] - 30, asked[3]])
        tab.wait_for_timeout(1500)
        shown = float(tab.locator(".widget-readout").nth(1).inner_text().replace("\N{MINUS SIGN}", "-"))
        assert shown == pytest.approx(math.degrees(frame.evaluate("omxScene.tool.state().q[1]")), abs=0.51)
        assert serious(tab, ".jp-OutputArea:has(.omx-scene)") == []
        assert tab.outside == []


def test_work_is_kept_as_one_file_and_comes_back_beside_what_is_there(built, playwright, chromium, tmp_path):
    """A notebook that JupyterLab saves by itself, and a log of the tab's Python; then a browser that was never here."""
    name, kept = runs.chapters()[0].name, tmp_path / "work.json"
    with served(built) as home:
        with chapter(playwright, chromium, home, name) as tab:
            tab.evaluate("""async () => {
              const kernel = jupyterapp.shell.currentWidget.sessionContext.session.kernel;
              await kernel.requestExecute({ code: "print('t,q1', file=open('log.csv', 'w'))" }).done;
              jupyterapp.shell.currentWidget.content.model.cells.get(1).sharedModel.setSource("my own words");
            }""")
            tab.wait_for_function("!jupyterapp.shell.currentWidget.context.model.dirty")  # it saves by itself
            tab.goto(home)
            with tab.expect_download() as download:
                tab.get_by_role("button", name="Keep my work").click()
            download.value.save_as(kept)
            files = json.loads(kept.read_text(encoding="utf-8"))["files"]
            assert sorted(files) == [name, "log.csv"]
            assert files["log.csv"]["content"] == "t,q1\n"
            assert "my own words" in json.dumps(files[name]["content"])
            tab.get_by_label("Bring it back").set_input_files(kept)
            tab.get_by_text("Brought back: 0. Here already, the same: 2.").wait_for()
        files["log.csv"]["content"] = "another\n"
        changed = tmp_path / "changed.json"
        changed.write_text(json.dumps({"format": "openmanipulator-x-work", "files": files}), encoding="utf-8")
        browser = playwright.chromium.launch(executable_path=chromium, args=FLAGS)
        tab = browser.new_page()
        tab.goto(home)
        tab.get_by_label("Bring it back").set_input_files(kept)
        tab.get_by_text("Brought back: 2.").wait_for()
        tab.get_by_label("Bring it back").set_input_files(changed)
        tab.get_by_text("Brought back: 1. Here already, the same: 1. Beside yours").wait_for()
        tab.get_by_label("Bring it back").set_input_files({"name": "x.json", "mimeType": "text/json", "buffer": b"{}"})
        tab.get_by_text("x.json is not a file that this page has kept.").wait_for()
        tab.goto(f"{home}lab/index.html")
        tab.wait_for_function("window.jupyterapp?.serviceManager?.contents")
        read = "async (path) => (await jupyterapp.serviceManager.contents.get(path, { content: true })).content"
        assert tab.evaluate(read, "log.csv") == "t,q1\n"
        assert tab.evaluate(read, "log-brought-back-1.csv") == "another\n"
        browser.close()


def test_the_folder_starts_itself(built):
    """`python start.py` in a copy of the folder: on the loopback address, with the types that workers insist on."""
    code = "import runpy, webbrowser; webbrowser.open = print; runpy.run_path('start.py', run_name='__main__')"
    run = subprocess.Popen([sys.executable, "-c", code], cwd=built, stdout=subprocess.PIPE, text=True)
    try:
        home = run.stdout.readline().split()[0]
        assert home.startswith("http://127.0.0.1:")
        for name, kind in ("pyodide.mjs", "text/javascript"), ("pyodide.asm.wasm", "application/wasm"):
            with urllib.request.urlopen(f"{home}static/pyodide/{name}") as answer:
                assert answer.headers.get_content_type() == kind
        again = subprocess.run([sys.executable, "start.py"], cwd=built, capture_output=True, text=True, check=False)
        assert again.returncode == 1
        assert again.stderr.count("\n") == 1
        assert "is taken" in again.stderr
    finally:
        run.kill()
        run.wait()


# ---- a real arm ------------------------------------------------------------------------------------------------------

#: A lab with the motors off, in `port`'s words; it ends with what it found in `said`.
LAB = """
import numpy as np
from omx import Robot, ReadOnly
with Robot(port) as robot:
    said = [np.degrees(robot.q).round(6).tolist(), robot.get_current_fk().round(6).tolist(), robot.read_gripper()]
    log = robot.log(0.2, "by-hand.csv")
    said += log.array(*log.columns[1:]).round(6).tolist()
"""
#: What the browser's programmes begin with.
BEGIN = "import js, json\nfrom pyodide.code import run_js\n"
#: The page's half of the browser: the reader chooses nothing, then the arm; an adapter of another day is remembered.
CHOOSING = """() => {
  const arm = {}, other = { forget: async () => { window.forgotten = true; } };
  const serial = {
    requestPort: async ({ filters }) => {
      window.filters = filters;
      if (!navigator.userActivation.isActive) throw new DOMException("no gesture", "SecurityError");
      if (!window.chooses) throw new DOMException(...window.refusal ?? ["No port selected.", "NotFoundError"]);
      return arm;
    },
    getPorts: async () => [other, arm],
  };
  Object.defineProperty(navigator, "serial", { value: serial });
}"""

#: What a browser says of a port that it does not ask for, and what its reader is told.
REFUSALS = (
    (("Access denied.", "SecurityError"), "This page may not ask for an adapter"),
    (("Already asking.", "InvalidStateError"), "The browser could not ask for an adapter (Already asking.)"),
)


def test_a_real_arm_is_read_in_the_browser_byte_for_byte_and_only_after_a_click(built, playwright, chromium, tmp_path):
    """The same programme here on the virtual servos, and there on a line that knows these very bytes."""
    here = {"port": VirtualPort(VirtualArm(q=HOME), clock=SteppedClock())}
    exec(LAB.replace("by-hand.csv", str(tmp_path / "by-hand.csv")), here)
    talk = [(one.sent.hex(), one.received.hex()) for one in here["robot"].bus.history]
    opening = len(Robot(VirtualPort(VirtualArm(q=HOME), clock=SteppedClock())).bus.history)
    stand_in = (Path(__file__).parents[1] / "helpers" / "serial_stand_in.js").read_text(encoding="utf-8")
    with served(built) as home, chapter(playwright, chromium, home, runs.chapters()[0].name) as tab:
        tab.evaluate(CHOOSING)
        python(tab, BEGIN + f"run_js({f'({stand_in})({json.dumps(talk)})'!r})")
        refused = (
            BEGIN
            + """
import omx
from omx import Robot, find_ports
said = [find_ports()]
for port in ("auto", "webserial", "/dev/ttyUSB0"):
    try:
        Robot(port)
    except omx.PortError as error:
        said.append(str(error))
print(json.dumps([said, js.stand.opens]))"""
        )
        for _ in range(2):  # before anything is pressed, and after a choice that was cancelled
            (ports, auto, named, other), opens = json.loads(python(tab, refused))
            assert (ports, opens) == ([], 0)
            assert "none is connected to this page: press *Connect the arm*" in auto
            assert "no arm is connected to this page: press *Connect the arm*" in named
            assert "there is no such port" in other
            tab.get_by_role("button", name="Connect the arm").click()
        for refusal, words in REFUSALS:
            tab.evaluate("(refusal) => { window.refusal = refusal; }", refusal)
            tab.get_by_role("button", name="Connect the arm").click()
            tab.get_by_role("status").get_by_text(words).wait_for()
        assert {"usbVendorId": 0x0403, "usbProductId": 0x6014} in tab.evaluate("filters")
        assert not tab.evaluate("window.forgotten")
        tab.evaluate("window.chooses = true")
        tab.get_by_role("button", name="Connect the arm").click()
        tab.get_by_role("button", name="Arm connected, to be read").wait_for()
        assert tab.get_by_text("The browser could not ask").count() == 0
        assert tab.evaluate("window.forgotten")
        lab = python(
            tab,
            BEGIN
            + "port = 'webserial'\n"
            + LAB
            + """
print(json.dumps([said, js.stand.asked.to_py(), js.stand.wrong, js.stand.opens, js.stand.baud, robot.bus.is_open]))""",
        )
        said, asked, wrong, *how = json.loads(lab)
        assert wrong == ""
        assert asked == [question for question, _ in talk]
        assert said == here["said"]
        assert how == [1, 1_000_000, False]
        ended = python(
            tab,
            BEGIN
            + f"""
js.stand.asked.length = 0
robot = Robot("webserial")
said = []
try:
    Robot("webserial")
except omx.PortBusy as error:
    said.append(str(error))
for act in (lambda: robot.write_motor_state(True), lambda: robot.bus.write(11, "goal_position", 2048),
            lambda: robot.bus.write_all("torque_enable", dict.fromkeys(range(11, 15), 1)), robot.relax):
    try:
        act()
    except ReadOnly as error:
        said.append(str(error))
js.stand.unplugAfter = {opening} + 2
try:
    robot.log(10.0, "cut-off.csv")
except omx.PortLost as error:
    said.append(str(error))
robot.close()
print(json.dumps([said, len(js.stand.asked), robot.bus.is_open]))""",
        )
        (busy, *refusals, lost), sent, is_open = json.loads(ended)
        assert "this very notebook has it open: go on with that robot" in busy
        assert len(refusals) == 4
        assert all("only read in a browser: refused to" in refusal for refusal in refusals)
        assert "webserial: the port has gone" in lost
        assert "Is the USB plug in?" in lost
        assert (sent, is_open) == (opening + 2, False)
        assert python(tab, "from omx.hardware.log import read_log; print(len(read_log('cut-off.csv')))").strip() == "2"
        assert tab.outside == []
        assert tab.complaints == []


# ---- what cannot be had ------------------------------------------------------------------------------------------


@pytest.fixture
def elsewhere(tmp_path, monkeypatch):
    """A build in folders of its own, beside one that is already there."""
    for name in ("SOURCE", "LITE", "WHEELS"):
        monkeypatch.setattr(lite, name, tmp_path / name)
    lite.LITE.mkdir()
    (lite.LITE / "kept").touch()


def test_without_the_package_index_one_sentence_and_nothing_half_built(built, elsewhere, monkeypatch, capsys):
    monkeypatch.setenv("PIP_INDEX_URL", "http://127.0.0.1:9/")
    monkeypatch.setenv("PIP_CONFIG_FILE", os.devnull)
    monkeypatch.setenv("PIP_RETRIES", "0")
    assert lite.main([]) == 1
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "numpy" in said
    assert "--pyodide FOLDER" in said
    assert [path.name for path in lite.LITE.iterdir()] == ["kept"]
    assert not lite.SOURCE.exists()


def test_another_pyodide_is_refused_in_one_sentence(built, elsewhere, tmp_path, capsys):
    folder = tmp_path / "pyodide"
    folder.mkdir()
    (folder / "pyodide-lock.json").write_text('{"info": {"version": "314.0.7"}, "packages": {}}')
    assert lite.main(["--pyodide", str(folder)]) == 1
    assert "holds Pyodide 314.0.7, but the kernel was made for 0.27." in capsys.readouterr().err
    assert lite.main(["--pyodide", str(tmp_path)]) == 1
    assert "holds no Pyodide" in capsys.readouterr().err


def test_without_a_site_there_is_nothing_to_lay_it_into(built, elsewhere, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(site, "SITE", tmp_path / "site")
    assert lite.main(["--site"]) == 1
    said = capsys.readouterr().err
    assert said == "lite: there is no site in build/site to lay it into: `python run.py book` builds one.\n"
    assert [path.name for path in lite.LITE.iterdir()] == ["kept"]


def test_what_a_package_offers_by_a_star_is_not_left_out():
    """SymPy's `lambdify` imports all of NumPy by a star, `numpy.f2py` with it."""
    offered = [f"numpy/{name}/__init__.py" for name in numpy.__all__]
    assert [path for path in offered if lite.UNUSED.search(path)] == []


def test_a_build_with_another_hash_is_not_taken(tmp_path):
    about = {"file_name": "numpy-2.0.2.whl", "sha256": "0" * 64}
    carrier = tmp_path / "carrier.whl"
    with zipfile.ZipFile(carrier, "w") as archive:
        archive.writestr("somewhere/numpy-2.0.2.whl", b"something else")
    assert lite.built(about, tmp_path, carrier) is None
    assert not (tmp_path / "numpy-2.0.2.whl").exists()


def test_what_the_builder_needs_is_pinned():
    for name in lite.EXTRA:
        assert name == "omx" or lite.pinned(name)
