"""Scenes in JupyterLab: they come back, they agree, they are quick, and they leave nothing behind."""

import statistics

import numpy as np
import psutil
import pytest

import omx
from tests.browser.latency import PANEL, PROBE, latencies, summary
from tests.browser.pages import is_blank, pixels, share_changed
from tests.browser.weblook import serious
from tests.helpers.lab import run_in_kernel

SCENE = "from omx.display.viewer import Camera, View\nview = View()\nview.frames(4)\nview"


def test_a_reload_brings_the_scene_back(open_page, notebook):
    page = open_page(notebook(SCENE, "view.q = (0.4, -0.5, 0.3, 0.9)"))
    page.run_all()
    page.scene()
    page.settle()
    before = pixels(page.scene())
    page.save()
    page.reload()
    page.page.locator(".omx-scene[data-ready]").first.wait_for(timeout=30_000)
    after = page.scene()
    assert after is not None, "no scene after a reload with a live kernel"
    page.settle()
    assert share_changed(before, pixels(after)) < 0.01
    assert not page.errors


THEME = "light => document.body.dataset.jpThemeLight = light"


def test_a_scene_follows_the_theme_and_leaves_room_on_a_small_screen(open_page, notebook):
    """Both without the kernel: the theme is the page's, and so is the height of the window."""
    page = open_page(notebook(SCENE, "view.q = (0.4, -0.5, 0.3, 0.9)"))
    page.run_all()
    scene = page.scene()
    page.settle()
    light = pixels(scene)
    page.page.evaluate(THEME, "false")
    page.settle()
    dark = pixels(scene)
    assert light[:60].mean() > 230
    assert dark[:60].mean() < 110
    page.page.evaluate(THEME, "true")
    page.settle()
    assert share_changed(light, pixels(scene)) < 0.01
    heights = []
    for height in (1000, 533):  # 533: a 13-inch screen at 150 %
        page.page.set_viewport_size({"width": 1300, "height": height})
        heights.append(page.page.locator(".omx-scene").first.bounding_box()["height"])
    assert heights == [420, pytest.approx(0.45 * 533, abs=1)]
    page.page.set_viewport_size({"width": 1300, "height": 1000})
    assert not page.errors


def test_two_views_of_a_scene_agree_and_the_last_pose_is_shown(open_page, notebook):
    """The loop writes far more poses than can be shown; both views end at the last, and so does a view made later."""
    loop = "for k in range(3000):\n    view.q = (0.0001 * k, -0.4, 0.3, 0.9)\nview.channel.seq"
    page = open_page(notebook(SCENE, "view", loop, "View(view.q)"))
    cells = page.run_all()
    sent = int("".join(cells[2]["outputs"][0]["data"]["text/plain"]))
    assert sent < 3000 / 5, "poses are coalesced"
    page.page.locator(".omx-scene[data-ready]").nth(1).wait_for(timeout=20_000)
    page.settle()
    page.settle()
    states = [tool_position(frame) for frame in scene_frames(page.page)]
    assert len(states) >= 2
    for state in states:
        assert state == pytest.approx(states[0], abs=1e-12)
    assert not page.errors


def test_many_scenes_share_few_graphics_contexts(open_page, notebook):
    """Browsers drop the oldest of about 16 WebGL contexts; scenes out of sight let go of theirs and come back."""
    page = open_page(notebook("from omx.display.viewer import View", *["View(height=300)"] * 14))
    page.run_all()
    wheel = page.page.mouse
    for _ in range(14):
        wheel.wheel(0, 500)
        page.page.wait_for_timeout(250)
    page.settle()
    assert 0 < len(scene_frames(page.page)) <= 12
    first = page.scene()
    page.settle()
    assert not is_blank(pixels(first)), "the first scene comes back"
    assert not [error for error in page.errors if "context" in error.lower()]


def test_a_killed_kernel_leaves_no_process(lab, open_page, notebook):
    page = open_page(notebook(SCENE, "import os\nos.getpid()"))
    cells = page.run_all()
    kernel = psutil.Process(int("".join(cells[1]["outputs"][0]["data"]["text/plain"])))
    family = [kernel, *kernel.children(recursive=True)]
    kernel.kill()
    assert not psutil.wait_procs(family, timeout=10)[1]
    scene = page.scene()
    assert scene is not None, "the picture stays"
    assert not is_blank(pixels(scene))


def test_a_slider_moves_the_whole_arm_quickly(open_page, notebook, capsys):
    """From a key on a slider to the drawn scene, against a bare round trip of a message in the same run.

    Printed, not asserted tightly: shared machines are slow at times. The aim is a median within twice the round
    trip's, and 95 in 100 below 80 ms. A slider without an arm shows what the slider itself costs.
    """
    page = open_page(notebook(PANEL, PROBE))
    page.run_all()
    times = latencies(page, 40)
    bare, plain, arm = (statistics.median(times[name]) for name in ("message", "slider", "arm"))
    with capsys.disabled():
        print(f"\nmessage there and back: {summary(times['message'])}")
        print(f"slider there and back: {summary(times['slider'])}")
        print(f"slider to drawn arm: {summary(times['arm'])}, {arm / bare:.2f} and {arm / plain:.2f} times as long")
    assert arm < 1000
    assert not page.errors


def test_a_slider_flood_ends_at_the_last_position(lab, open_page, notebook):
    """However fast the slider is dragged, the scene ends where the panel is."""
    page = open_page(notebook("from omx.display.panels import JointPanel\npanel = JointPanel()\npanel"))
    page.run_all()
    panel = page.panel()
    handle = panel.locator(".noUi-handle").first
    box = handle.bounding_box()
    mouse = page.page.mouse
    mouse.move(box["x"] + 8, box["y"] + 8)
    mouse.down()
    for step in range(120):
        mouse.move(box["x"] + 8 - step % 60, box["y"] + 8)
    mouse.up()
    page.settle()
    page.settle()
    code = "import omx\nprint(*(1e-3 * omx.fk(panel.view.q)[:3, 3]))"
    wanted = [float(word) for word in run_in_kernel(lab, page.kernel["id"], code).split()]
    assert tool_position(scene_frames(page.page)[0]) == pytest.approx(wanted, abs=1e-9)


def test_the_tool_is_dragged_in_a_notebook(lab, open_page, notebook):
    """The scene follows at once, the kernel hears of it, and both end at the same joint angles."""
    page = open_page(notebook("from omx.display.panels import PosePanel\npanel = PosePanel()\npanel"))
    page.run_all()
    page.panel()
    (frame,) = scene_frames(page.page)
    page.settle()
    tool = frame.locator("#omx-grip")
    tool.focus()
    for key in ("PageDown", "ArrowLeft", "+"):
        for _ in range(3):
            tool.press(f"Shift+{key}")
    page.settle()
    page.settle()
    state = frame.evaluate("omxScene.tool.state()")
    code = "print(*panel.pose, *panel.view.q, *[s.value for s in panel.sliders])"
    told = [float(word) for word in run_in_kernel(lab, page.kernel["id"], code).split()]
    assert told[:4] == pytest.approx(state["asked"], abs=1e-9)
    assert told[4:8] == pytest.approx(state["q"], abs=1e-9)
    assert told[8:11] == pytest.approx(state["asked"][:3], abs=1e-9)
    assert state["asked"][1] == pytest.approx(30)
    assert tool_position(frame) == pytest.approx(1e-3 * omx.fk(state["q"])[:3, 3], abs=1e-9)
    assert not page.errors


HAND = """import math
from omx import Chain, DHRow, HandPanel
from omx.analysis import Inverse
from omx.derive import write_inverse
up = math.pi / 2
rows = [DHRow(0, 100, 0, -up), DHRow(0, 100, 0, up), DHRow(0, 0, 0, 0, True)]
rows += [DHRow(0, 0, 0, -up), DHRow(0, 0, 0, up), DHRow(0, 100, 0, 0)]
limits = [(-4, 4), (-1.5, 1.5), (100, 300), (-4, 4), (-1.2, 1.2), (-4, 4)]
module = write_inverse("dragged_hand", Chain(rows), folder="../build/arms")
panel = HandPanel(Inverse(Chain(rows, limits), module), (0.4, 0.9, 220.0, 0.5, 0.3, -0.8))
panel"""


def test_a_hand_is_dragged_and_a_link_is_pulled_in_a_notebook(lab, open_page, notebook):
    """Six joints: page and kernel end at the same values, keep to the same branch, and axe finds nothing of ours."""
    page = open_page(notebook(HAND))
    page.run_all()
    panel = page.panel()
    (frame,) = scene_frames(page.page)
    page.settle()

    def both():
        page.settle()
        page.settle()
        code = "print(*panel.target.ravel(), *panel.q, *panel.view.q, *[s.value for s in panel.sliders])"
        told = [float(word) for word in run_in_kernel(lab, page.kernel["id"], code).split()]
        return told, frame.evaluate("omxScene.tool.state()")

    tool = frame.locator("#omx-grip")
    tool.focus()
    for key in ("Shift+PageUp", "Shift+ArrowLeft", "x", "Shift++"):
        tool.press(key)
    told, state = both()
    assert told[:16] == pytest.approx([v for row in state["asked"] for v in row], abs=1e-9)
    assert told[16:22] == pytest.approx(state["q"], abs=1e-9)
    assert told[22:28] == pytest.approx(state["q"], abs=1e-9)
    assert told[28:31] == pytest.approx([row[3] for row in state["asked"][:3]], abs=1e-9)
    panel.locator("select").select_option("front, out, flip")
    page.settle()
    tool.press("Shift+ArrowUp")
    told, state = both()
    assert state["chosen"]["name"] == "front, out, flip"
    assert told[16:22] == pytest.approx(state["q"], abs=1e-9)
    frame.evaluate("omxScene.tool.offer(false)")
    box = panel.locator("iframe").bounding_box()
    q = np.array(state["q"])
    boom = "omxScene.viewer.scene_tree.find(['meshcat', 'arm', '3']).object"
    x, y = frame.evaluate(f"""() => {{
      const {{ viewer }} = omxScene, {{ width, height }} = viewer.renderer.domElement.getBoundingClientRect();
      const at = {boom}.localToWorld(new MeshCat.THREE.Vector3(0, 0, -0.12)).project(viewer.camera);
      return [(at.x + 1) * width / 2, (1 - at.y) * height / 2];
    }}""")
    mouse = page.page.mouse
    mouse.move(box["x"] + x, box["y"] + y)
    mouse.down()
    for k in range(1, 9):
        mouse.move(box["x"] + x + 2 * k, box["y"] + y - k)
    mouse.up()
    told, state = both()
    assert np.abs(np.subtract(state["q"], q)[:3]).max() > 0.01
    assert state["q"][3:] == pytest.approx(q[3:], abs=1e-9)
    assert told[16:22] == pytest.approx(state["q"], abs=1e-9)
    assert panel.locator("select").input_value() == "nearest"
    assert serious(page.page, ".jp-OutputArea") == []
    assert not page.errors


def test_a_scene_is_saved_as_one_page_that_needs_no_notebook(open_page, notebook, context, tmp_path):
    page = open_page(notebook(SCENE, "view.q = (0.4, -0.5, 0.3, 0.9)"))
    page.run_all()
    page.scene()
    page.settle()
    (frame,) = scene_frames(page.page)
    frame.locator("#omx-bar button[aria-label^=More]").click()
    with page.page.expect_download() as download:
        frame.locator("#omx-bar button", has_text="html").click()
    download.value.save_as(tmp_path / "scene.html")
    alone = context.new_page()
    asked = []
    alone.on("request", lambda request: asked.append(request.url))
    alone.goto((tmp_path / "scene.html").as_uri())
    alone.wait_for_selector("body[data-ready]", timeout=30_000)
    assert tool_position(alone) == pytest.approx(1e-3 * omx.fk((0.4, -0.5, 0.3, 0.9))[:3, 3], abs=1e-9)
    assert len([url for url in asked if not url.startswith(("data:", "blob:"))]) == 1
    alone.close()


#: Rules of axe that JupyterLab itself breaks, outside of our outputs; `book/accessibility.md` lists them.
JUPYTERLABS_OWN = {"aria-allowed-attr", "aria-input-field-name", "aria-required-children"}
PANELS = """from omx import DHRow, JointPanel, LiveFigure, PosePanel, Robot, RobotPanel, RowPanel
from IPython.display import display
figure = LiveFigure("cloud", {"sigma (deg)": (0, 1, 0.5, 0.1)}, "Tips", draws=[[0, 1, 0, 0]])
for panel in (JointPanel(), PosePanel(), RowPanel(DHRow(0, 77, 0, -1.57)), RobotPanel(Robot(), watch=False), figure):
    display(panel)"""


def test_axe_finds_nothing_serious_in_the_panels_of_a_notebook(open_page, notebook):
    """What JupyterLab and its own widgets bring is in `book/accessibility.md`: all else is ours."""
    page = open_page(notebook(PANELS))
    page.run_all()
    page.page.locator(".omx-panel[data-kind=figure]").wait_for()
    assert serious(page.page, ".jp-OutputArea") == []
    assert {found.split(":")[0] for found in serious(page.page)} <= JUPYTERLABS_OWN
    assert not page.errors


LIVE = """import numpy as np
from omx import LiveFigure
sliders = {"sigma (deg)": (0.05, 1, 0.5, 0.05), "q2 (deg)": (-80, 80, 0), "q3 (deg)": (-80, 80, 0)}
LiveFigure("cloud", sliders, "Tips", draws=np.eye(4))"""


def test_a_live_figure_lives_without_the_kernel(open_page, notebook):
    page = open_page(notebook(LIVE))
    page.run_all()
    panel = page.page.locator(".omx-panel[data-kind=figure]")
    panel.scroll_into_view_if_needed()
    before, words = pixels(panel), panel.locator(".omx-says").inner_text()
    slider = panel.get_by_role("slider", name="sigma in")
    slider.focus()
    for _ in range(4):
        slider.press("ArrowRight")
    assert panel.locator(".omx-says").inner_text() != words
    assert share_changed(before, pixels(panel)) > 0.002
    assert not page.errors


def scene_frames(page):
    return [frame for frame in page.frames if frame != page.main_frame and frame.evaluate("!!window.omxScene")]


def tool_position(frame):
    return frame.evaluate('omxScene.viewer.scene_tree.find(["meshcat", "arm", "4"]).object.position.toArray()')
