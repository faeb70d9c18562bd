"""The book in a browser tab: built whole or not at all, complete, light, and alive with the network cut.

Every chapter, cell by cell: `python run.py test lite` (lite_chapters.py).
"""

import json
import math
import os
import subprocess
import sys
import urllib.request
import zipfile
from pathlib import Path

import pytest

from book.chapters import runs
from book.publish import lite
from book.setup.paths import Stop
from omx import HOME, Robot
from omx.hardware.simulator import SteppedClock, VirtualArm, VirtualPort
from tests.browser.conftest import FLAGS
from tests.browser.weblook import serious, served
from tests.helpers.lite import chapter, python, run_all


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
        assert not any(cell.get("outputs") for cell in rest)
        assert f"path={name}" in (built / "index.html").read_text(encoding="utf-8")


def test_it_is_light(built):
    assert sum(path.stat().st_size for path in built.rglob("*") if path.is_file()) < 60e6


def test_a_chapter_lives_with_the_network_cut(built, playwright, chromium):
    """The student's copy of chapter 00 runs up to its first TODO; slider and tool move the arm, in the tab's Python."""
    with served(built) as home, chapter(playwright, chromium, home, runs.chapters()[0].name) as tab:
        cells, _ = run_all(tab)
        assert sum(bool(cell.get("execution_count")) for cell in cells) >= 5
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
    """A notebook and a log, saved by JupyterLab and by Python in the tab; then into a browser that was never here."""
    name, kept = runs.chapters()[0].name, tmp_path / "work.json"
    with served(built) as home:
        with chapter(playwright, chromium, home, name) as tab:
            tab.evaluate("""async () => {
              const kernel = jupyterapp.shell.currentWidget.sessionContext.session.kernel;
              await kernel.requestExecute({ code: "print('t,q1', file=open('log.csv', 'w'))" }).done;
              await jupyterapp.commands.execute("docmanager:save");
            }""")
            tab.goto(home)
            with tab.expect_download() as download:
                tab.get_by_role("button", name="Keep my work").click()
            download.value.save_as(kept)
            files = json.loads(kept.read_text(encoding="utf-8"))["files"]
            assert sorted(files) == [name, "log.csv"]
            assert files["log.csv"]["content"] == "t,q1\n"
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
      if (!window.chooses) throw new DOMException("No port selected by the user.", "NotFoundError");
      return arm;
    },
    getPorts: async () => [other, arm],
  };
  Object.defineProperty(navigator, "serial", { value: serial });
}"""


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
        assert {"usbVendorId": 0x0403, "usbProductId": 0x6014} in tab.evaluate("filters")
        assert not tab.evaluate("window.forgotten")
        tab.evaluate("window.chooses = true")
        tab.get_by_role("button", name="Connect the arm").click()
        tab.get_by_role("button", name="Arm connected, to be read").wait_for()
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


def test_another_pyodide_is_refused_in_one_sentence(built, elsewhere, tmp_path, capsys):
    folder = tmp_path / "pyodide"
    folder.mkdir()
    (folder / "pyodide-lock.json").write_text('{"info": {"version": "314.0.7"}, "packages": {}}')
    assert lite.main(["--pyodide", str(folder)]) == 1
    assert "holds Pyodide 314.0.7, but the kernel was made for 0.27." in capsys.readouterr().err
    assert lite.main(["--pyodide", str(tmp_path)]) == 1
    assert "holds no Pyodide" in capsys.readouterr().err


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
