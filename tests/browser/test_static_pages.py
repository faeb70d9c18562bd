"""Scenes in plain pages: from the disk, with every request watched, they draw, play and stay in their frame."""

import base64
import io
import math

import numpy as np
import pytest
from PIL import Image

import omx
from book.chapters import normalise
from book.publish import page_scripts, scenes
from book.publish.still_picture import poster
from book.reader import handin
from omx import Chain, rotation
from omx.analysis import Inverse
from omx.derive import write_inverse
from omx.display.panels import HandPanel, JointPanel, PosePanel, RowPanel, tables
from omx.display.viewer import View
from omx.display.viewer.arm_data import chain_data
from tests.browser.latency import percentile
from tests.browser.pages import is_blank, pixels, share_changed
from tests.browser.weblook import image_of, serious
from tests.helpers.six_joint_arms import ARMS


@pytest.fixture(scope="module")
def window():
    return 900, 700


@pytest.fixture
def show(context):
    """Open a page of the disk; returns it, and the addresses that it asked for."""
    pages = []

    def opener(path, size=None):
        pages.append(context.new_page())
        page, asked = pages[-1], []
        if size:
            page.set_viewport_size(size)
        page.on("request", lambda request: asked.append(request.url))
        page.goto(path.as_uri())
        return page, asked

    yield opener
    for page in pages:
        page.close()


def write(folder, *bodies, script=""):
    path = folder / "page.html"
    head = f'<!DOCTYPE html><html><head><meta charset="utf-8">{script}</head>'
    path.write_text(f"{head}<body>{''.join(bodies)}<p id='words'>Around.</p></body></html>", encoding="utf-8")
    return path


def with_panels(folder, *panels):
    """A page with panels, as the site has them."""
    (folder / "omx-view.js").write_text(scenes.page_script({}), encoding="utf-8")
    (folder / "omx-kinematics.js").write_text(page_scripts.kinematics(), encoding="utf-8")
    (folder / "omx-panels.js").write_text(page_scripts.panels(), encoding="utf-8")
    style = f"<style>{(page_scripts.ROOT / 'book/static/house.css').read_text(encoding='utf-8')}</style>"
    names = ("omx-view.js", "omx-kinematics.js", "omx-panels.js")
    scripts = "".join(f'<script src="{name}" defer></script>' for name in names)
    return write(folder, *(scenes.html_of(panel.page_data()) for panel in panels), script=style + scripts)


def frames(page, count):
    """The scenes' frames, once all of them are drawn."""
    page.wait_for_function(f"document.querySelectorAll('iframe').length === {count}")
    inner = [frame for frame in page.frames if frame != page.main_frame]
    for frame in inner:
        frame.wait_for_selector("body[data-ready]", timeout=30_000)
    page.wait_for_timeout(700)
    return inner


#: How many frames of the screen a scene asks for.
ASKED = """(ms) => new Promise((done) => {
  const ask = window.requestAnimationFrame;
  let asked = 0;
  window.requestAnimationFrame = (draw) => { asked++; return ask(draw); };
  setTimeout(() => { window.requestAnimationFrame = ask; done(asked); }, ms);
})"""
#: How many messages a scene hears.
HEARD = """(ms) => new Promise((done) => {
  let heard = 0;
  const hear = () => heard++;
  window.addEventListener("message", hear);
  setTimeout(() => { window.removeEventListener("message", hear); done(heard); }, ms);
})"""


def test_a_scene_plays_in_a_page_that_fetches_nothing(show, tmp_path):
    view = View()
    view.animate([omx.HOME, (0.9, 0.2, 0.2, 0.5), omx.HOME], seconds=2)
    path = write(tmp_path, view.static_html())
    page, asked = show(path)
    (frame,) = frames(page, 1)
    assert [url for url in asked if not url.startswith(("data:", "blob:"))] == [path.as_uri()]
    one = pixels(page.locator("iframe"))
    assert frame.evaluate(ASKED, 500) > 2
    two = pixels(page.locator("iframe"))
    assert not is_blank(one)
    assert share_changed(one, two) > 0.002, "the animation plays"
    frame.locator("#omx-bar button[aria-label='Play or pause']").click()
    page.wait_for_timeout(300)
    still = pixels(page.locator("iframe"))
    assert frame.evaluate(ASKED, 400) == 0
    assert share_changed(still, pixels(page.locator("iframe"))) < 0.001, "and stops"


def test_nothing_is_seen_of_a_scene_before_it_is_there(context, tmp_path):
    """No blue sky of the viewer's own: when its canvas comes, the pane is hidden."""
    page = context.new_page()
    page.add_init_script("""new MutationObserver(() => {
      const pane = document.querySelector("#meshcat-pane");
      if (pane?.querySelector("canvas")) window.omxFirst ??= getComputedStyle(pane).visibility;
    }).observe(document, { childList: true, subtree: true });""")
    (tmp_path / "scene.html").write_text(View().channel.get_scene(), encoding="utf-8")
    page.goto((tmp_path / "scene.html").as_uri())
    page.wait_for_selector("body[data-ready]", timeout=30_000)
    assert page.evaluate("omxFirst") == "hidden"
    assert page.evaluate("getComputedStyle(document.querySelector('#meshcat-pane')).visibility") == "visible"
    page.close()


def test_the_picture_for_paper_shows_what_the_viewer_shows(show, tmp_path):
    """The same silhouette within a few hundredths, though NumPy drew one and WebGL the other."""
    view = View((0.5, -0.6, 0.4, 0.5))
    page, _ = show(write(tmp_path, view.static_html()))
    (frame,) = frames(page, 1)
    seen = image_of(frame.evaluate("omxScene.picture(1)"))
    size = seen.shape[:2]
    drawn = np.asarray(Image.open(io.BytesIO(poster(view.channel.log, *size))).convert("RGB"), float)
    one, two = (image.max(axis=2) < 130 for image in (seen, drawn))
    assert one.sum() > 5000
    assert (one & two).sum() / (one | two).sum() > 0.9


def test_a_scene_cannot_reach_the_page_around_it(show, tmp_path):
    page, _ = show(write(tmp_path, View().static_html()))
    (frame,) = frames(page, 1)
    reach = "(() => { try { parent.document.getElementById('words').remove(); return true } catch { return false } })()"
    assert frame.evaluate(reach) is False
    assert page.locator("#words").count() == 1


def test_scenes_share_one_script_and_wait_for_the_reader(show, tmp_path):
    (tmp_path / "omx-view.js").write_text(scenes.page_script({}), encoding="utf-8")
    gap = '<div style="height:4000px"></div>'
    one, two = (scenes.html_of(view.page_data()) for view in (View(), View(omx.ZERO)))
    path = write(tmp_path, one, gap, two, script='<script src="omx-view.js" defer></script>')
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


# ---- the tool under the reader's hand --------------------------------------------------------------------------

STATE = "omxScene.tool.state()"
WORDS = "[document.querySelector('#omx-words').textContent, document.querySelector('#omx-note').textContent]"
ON_SCREEN = """(point) => {
  const { viewer } = omxScene, box = viewer.renderer.domElement.getBoundingClientRect();
  const at = new MeshCat.THREE.Vector3(...point).multiplyScalar(1e-3)
    .applyMatrix4(viewer.scene_tree.children.meshcat.object.matrixWorld).project(viewer.camera);
  return [box.left + (at.x + 1) * box.width / 2, box.top + (1 - at.y) * box.height / 2];
}"""
#: Note when each pointer event happened and when the frame that shows it was drawn.
WATCH = """() => {
  const { viewer } = omxScene, render = viewer.render;
  let since = 0;
  window.omxTimes = [];
  window.omxWork = [];
  window.addEventListener("pointerrawupdate", (e) => { since ||= e.timeStamp; }, { capture: true });
  viewer.render = function () {
    const begin = performance.now();
    render.call(this);
    if (!since) return;
    viewer.renderer.getContext().finish();
    omxTimes.push(performance.now() - since);
    omxWork.push(performance.now() - begin);
    since = 0;
  };
}"""


RED_GHOSTS = """(() => {
  const red = ({ opacity, color }) => opacity > 0.5 && opacity < 0.9 && color?.getHexString() === "c8102e";
  let count = 0;
  omxScene.viewer.scene.traverse((o) => { if (o.isMesh && o.visible && red(o.material)) count++; });
  return count;
})()"""
WIDTH = """(scale) => new Promise((done) => {
  const image = new Image();
  image.onload = () => done(image.width);
  image.src = omxScene.picture(scale);
})"""


def where(page, frame, point):
    """A point (mm) of the first scene in the page's pixels."""
    box = page.locator("iframe").bounding_box()
    x, y = frame.evaluate(ON_SCREEN, list(point))
    return box["x"] + x, box["y"] + y


def drag(page, start, end, steps=12, pause=18):
    page.mouse.move(*start)
    page.mouse.down()
    for k in range(1, steps + 1):
        page.mouse.move(*(a + (b - a) * k / steps for a, b in zip(start, end, strict=True)))
        page.wait_for_timeout(pause)
    page.mouse.up()
    page.wait_for_timeout(1000)


def on_ring(pose, pitch):
    """The point (mm) of the handle's ring that stands for a pitch."""
    x, y, z, _ = pose
    out, up = 52 * math.cos(pitch) / math.hypot(x, y), 52 * math.sin(pitch)
    return x + out * x, y + out * y, z + up


def tell(frame, what, capsys):
    """How long from the pointer to the drawn frame that shows it: printed, for a shared machine is slow at times."""
    times, work = frame.evaluate("[omxTimes, omxWork]")
    with capsys.disabled():
        told = f"median {np.median(times):.0f} ms, p95 {percentile(times):.0f} ms"
        print(f"\npointer to drawn frame, {what}: {told}; drawing {np.median(work):.0f} ms of it ({len(times)} frames)")


def drawn(frame, joints=4):
    """The moving frames as the viewer draws them, (joints, 4, 4), mm."""
    find = "(i) => omxScene.viewer.scene_tree.find(['meshcat', 'arm', `${i}`]).object"
    elements = f"(i) => {{ const o = ({find})(i); o.updateMatrix(); return o.matrix.elements; }}"
    matrices = np.array([frame.evaluate(elements, i) for i in range(1, joints + 1)])
    matrices = matrices.reshape(-1, 4, 4).transpose(0, 2, 1)
    matrices[:, :3, 3] *= 1e3
    return matrices


def opened(show, folder, view):
    path = write(folder, getattr(view, "view", view).static_html())
    page, _ = show(path)
    (frame,) = frames(page, 1)
    return page, frame


def test_dragging_the_tool_moves_the_arm_as_python_would(show, tmp_path, capsys):
    start = (0.3, -0.4, 0.4, 0.5)
    view = View(start)
    page, frame = opened(show, tmp_path, view)
    frame.locator("#omx-bar button", has_text="tool").click()
    page.wait_for_timeout(500)
    before = omx.pose(start)
    assert frame.evaluate(STATE)["asked"] == pytest.approx(before, abs=1e-9)
    frame.evaluate(WATCH)
    x, y, z, pitch = before
    drag(page, where(page, frame, (x, y, z + 60)), where(page, frame, (x, y, z + 100)), steps=30)
    asked = frame.evaluate(STATE)["asked"]
    assert asked[:2] == pytest.approx(before[:2], abs=1e-6), "the arrow of z moves z alone"
    assert asked[2] == pytest.approx(z + 40, abs=1.5)
    drag(page, *(where(page, frame, on_ring(asked, p)) for p in (pitch, pitch + 0.6)), steps=30)
    state = frame.evaluate(STATE)
    assert state["asked"][:3] == pytest.approx(asked[:3], abs=1e-9), "the ring turns the pitch alone"
    assert state["asked"][3] == pytest.approx(pitch + 0.6, abs=0.03)
    q = omx.solve_ik(state["asked"], start).q
    assert state["q"] == pytest.approx(q, abs=1e-9)
    np.testing.assert_allclose(drawn(frame), omx.frames(q)[1:], atol=1e-6)
    tell(frame, "tool", capsys)


def test_what_a_limit_refuses_is_told_and_red_and_the_arm_stays(show, tmp_path):
    page, frame = opened(show, tmp_path, View())
    frame.locator("#omx-bar button", has_text="tool").click()
    tool = frame.locator("#omx-grip")
    tool.focus()
    for _ in range(12):
        tool.press("Shift+PageDown")
    page.wait_for_timeout(1000)
    state = frame.evaluate(STATE)
    solutions = omx.ik(state["asked"])
    assert not any(s.legal for s in solutions)
    assert state["chosen"] is None
    assert omx.pose(state["q"])[2] > state["asked"][2] + 5, "the arm stays where it last could be"
    least = min((s for s in solutions if s.reachable), key=lambda s: max(v.excess for v in s.violations))
    spoken, shown = frame.evaluate(WORDS)
    for violation in least.violations:
        degrees = f"{math.degrees(violation.excess):.1f}° beyond its limit"
        assert f"{violation.joint} = " in shown
        assert degrees in shown
        assert degrees in spoken
    assert frame.evaluate(RED_GHOSTS) > 3
    tool.press("Shift+PageUp")
    tool.press("Shift+PageUp")
    page.wait_for_timeout(1000)
    assert frame.evaluate(STATE)["chosen"] is not None
    assert frame.locator("#omx-note").is_hidden()


def test_a_scene_warns_when_the_arm_is_below_the_table_or_in_itself(show, tmp_path):
    page, frame = opened(show, tmp_path, View((0, math.radians(39), 0.7, 0.5)))
    page.wait_for_timeout(600)
    spoken, shown = frame.evaluate(WORDS)
    gap = -float(omx.collision.clearance((0, math.radians(39), 0.7, 0.5)))
    assert shown == f"Fingers {gap:.0f}\u2009mm below the table."
    assert "below the table" in spoken
    page, frame = opened(show, tmp_path, View())
    page.wait_for_timeout(600)
    spoken, shown = frame.evaluate(WORDS)
    assert shown == ""
    assert spoken.startswith("Tool at x = 122.0, y = 0.0, z = 241.3 mm, pitch = 0.0°; front, elbow up;")


def test_a_finger_drags_too_and_the_sliders_of_a_panel_follow(browser, tmp_path):
    """On a touch screen, in a page with a panel: the finger pulls the ball, the sliders and verdicts follow."""
    path = with_panels(tmp_path, PosePanel(q=(0.3, -0.4, 0.4, 0.5)))
    context = browser.new_context(viewport={"width": 390, "height": 800}, has_touch=True, is_mobile=True)
    page = context.new_page()
    page.goto(path.as_uri())
    (frame,) = frames(page, 1)
    page.wait_for_timeout(600)
    before = frame.evaluate(STATE)["asked"]
    x, y = where(page, frame, before[:3])
    finger = context.new_cdp_session(page)

    def touch(kind, *points):
        at = [{"x": x, "y": y} for x, y in points]
        finger.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": at})

    touch("touchStart", (x, y))
    for k in range(1, 9):
        touch("touchMove", (x, y - 3 * k))
        page.wait_for_timeout(30)
    touch("touchEnd")
    page.wait_for_timeout(1000)
    state = frame.evaluate(STATE)
    assert state["asked"][2] > before[2] + 5
    assert state["q"] == pytest.approx(omx.solve_ik(state["asked"], (0.3, -0.4, 0.4, 0.5)).q, abs=1e-9)
    sliders = [float(s.input_value()) for s in page.locator(".omx-sliders input").all()]
    assert sliders[:3] == pytest.approx(state["asked"][:3], abs=0.51)
    angles = page.locator(".omx-chosen .omx-angles").inner_text().replace("−", "-").split()
    assert [float(a) for a in angles] == pytest.approx(np.degrees(state["q"]), abs=0.06)
    context.close()


def test_the_sliders_of_a_page_are_those_of_the_notebook(show, tmp_path):
    """Their names, units, ends and steps, for every kind of joint end; another arm on the page brings its own."""
    rows = [omx.DHRow(0, 77, 0, 1.0), omx.DHRow(0, 0, 100, 0), omx.DHRow(0, 10, 0, 0, True), omx.DHRow(0, 0, 50, 0.3)]
    chain = omx.Chain(rows, [(-math.inf, math.inf), (-1.0, math.inf), (3.2, 4.6), (-0.011, 0.007)])
    panels = [JointPanel(View.of_chain(chain, [0, 0, 4, 0])), RowPanel((0.5, 10, 20, 0.3)), PosePanel(), JointPanel()]
    page, _ = show(with_panels(tmp_path, *panels))
    ends = "(all) => all.map((s) => [s.ariaLabel.split(' in ')[1], ...[s.min, s.max, s.step].map(Number)])"
    for box, panel in zip(page.locator(".omx-panel").all(), panels, strict=True):
        limits = [
            line.children[1].value.split() for line in panel.children[1].children[0].children[: len(panel.sliders)]
        ]
        units = [{"deg": "\u00b0", "mm": "mm"}[words[-1]] for words in limits]
        wanted = [[unit, s.min, s.max, s.step] for unit, s in zip(units, panel.sliders, strict=True)]
        found = box.locator(".omx-sliders input").evaluate_all(ends)
        assert [row[0] for row in found] == units
        np.testing.assert_allclose([row[1:] for row in found], [row[1:] for row in wanted], rtol=1e-12)
    longer = omx.Chain([*rows, omx.DHRow(0.1, 5, 5, 0)])
    become = "([box], about) => box.omxPanel.become(about, [])"
    page.locator(".omx-panel").evaluate_all(become, chain_data(longer, None))
    found = page.locator(".omx-panel").first.locator(".omx-sliders input").evaluate_all(ends)
    assert found == [
        ["\u00b0", -180, 180, 1],
        ["\u00b0", -180, 180, 1],
        ["mm", 0, 100, 1],
        *[["\u00b0", -180, 180, 1]] * 2,
    ]


def test_each_link_has_its_term_and_a_row_of_the_table_lights_its_frame(show, tmp_path):
    """On a small screen the arm and its sliders are in sight together; numbers are Python's."""
    path = with_panels(tmp_path, JointPanel(q=omx.HOME, terms=True))
    page, _ = show(path, {"width": 853, "height": 533})
    (frame,) = frames(page, 1)
    boxes = [page.locator(".omx-panel .omx-scene").bounding_box(), page.locator(".omx-sliders").bounding_box()]
    assert max(box["y"] + box["height"] for box in boxes) <= 533
    assert frame.evaluate(HEARD, 300) == 0, "what its panel has told it is heard once"
    q = [math.radians(angle) for angle in (20, -30, 40, 10)]
    for slider, angle in zip(page.locator(".omx-sliders input").all(), (20, -30, 40, 10), strict=True):
        slider.fill(str(angle))
    for sum_of, name in zip(page.locator(".omx-sum").all(), "rz", strict=True):
        told = sum_of.locator("span").all_inner_texts()
        numbers = [float(term.split("\n")[-1].replace("−", "-").replace("+", "").replace(" ", "")) for term in told]
        assert numbers == pytest.approx(
            [v for v in tables.term_values(omx.frames(q))[name] if abs(v) > 1e-9], abs=0.051
        )
    shown = "[0, 1, 2, 3, 4].map((i) => omxScene.viewer.scene_tree.find(['meshcat', 'frames', `${i}`]).object.visible)"
    assert frame.evaluate(shown) == [False] * 5
    page.locator(".omx-dh tbody tr").nth(2).hover()
    page.wait_for_timeout(400)
    assert frame.evaluate(shown) == [False, False, False, True, False]
    place = "(i) => omxScene.viewer.scene_tree.find(['meshcat', 'frames', `${i}`]).object.position.toArray()"
    ridden = [frame.evaluate(place, i) for i in range(5)]
    assert 1e3 * np.array(ridden) == pytest.approx(omx.frames(q)[:, :3, 3], abs=1e-6)
    page.locator(".omx-dh tbody tr").nth(0).focus()
    page.wait_for_timeout(400)
    assert frame.evaluate(shown)[1] is True
    nobody_leads = "({ omxPanel: p }) => p.become(p.about, [{ omx: 'arm', about: null, modules: {} }])"
    page.locator(".omx-panel").evaluate(nobody_leads)
    page.locator(".omx-sliders input").first.fill("-70")
    page.wait_for_timeout(400)
    ridden = 1e3 * np.array([frame.evaluate(place, i) for i in range(5)])
    assert ridden == pytest.approx(omx.frames([math.radians(-70), *q[1:]])[:, :3, 3], abs=1e-6)


def test_a_scene_is_kept_as_picture_and_as_one_file(show, tmp_path):
    page, frame = opened(show, tmp_path, View())
    frame.evaluate("omxScene.tool.move([200, 60, 150, -0.4])")
    page.wait_for_timeout(900)
    small, large = (frame.evaluate(WIDTH, scale) for scale in (1, 2))
    assert large == 2 * small
    frame.locator("#omx-bar button[aria-label^=More]").click()
    with page.expect_download() as download:
        frame.locator("#omx-bar button", has_text="html").click()
    kept = tmp_path / "kept.html"
    download.value.save_as(kept)
    again, asked = show(kept)
    again.wait_for_selector("body[data-ready]", timeout=30_000)
    again.wait_for_timeout(500)
    assert again.evaluate(STATE)["asked"] == pytest.approx([200, 60, 150, -0.4], abs=1e-9)
    assert [url for url in asked if not url.startswith(("data:", "blob:"))] == [kept.as_uri()]


FILM = """async (data) => {
  const video = document.createElement("video");
  video.src = URL.createObjectURL(new Blob([Uint8Array.from(atob(data), (c) => c.charCodeAt(0))]));
  video.muted = true;
  await video.play();
  const size = [video.videoWidth, video.videoHeight];
  const canvas = new OffscreenCanvas(...size).getContext("2d", { willReadFrequently: true });
  const seen = new Set(), start = performance.now();
  while (!video.ended && performance.now() - start < 6000) {
    canvas.drawImage(video, 0, 0);
    seen.add(canvas.getImageData(0, 0, ...size).data.reduce((sum, v, i) => (sum + v * (i % 997)) | 0, 0));
    await new Promise((resolve) => setTimeout(resolve, 60));
  }
  return [video.videoWidth, seen.size];
}"""


@pytest.mark.parametrize("animated", [True, False])
def test_a_scene_is_recorded_as_a_film(show, tmp_path, animated):
    """Once through the animation; without one, what the reader does until the button is pressed again."""
    view = View()
    if animated:
        view.animate([omx.HOME, (0.9, 0.2, 0.2, 0.5)], seconds=5, loop=False)
    page, frame = opened(show, tmp_path, view)
    frame.locator("#omx-bar button[aria-label^=More]").click()
    button = frame.locator("#omx-bar button", has_text="film")
    with page.expect_download() as download:
        button.click()
        assert button.get_attribute("aria-pressed") == "true"
        for k in range(0 if animated else 8):
            frame.evaluate("(pose) => omxScene.tool.move(pose)", [150, 10 * k, 200, 0])
            page.wait_for_timeout(150)
        if not animated:
            button.click()
    assert download.value.suggested_filename == "scene.webm"
    download.value.save_as(tmp_path / "scene.webm")
    film = base64.b64encode((tmp_path / "scene.webm").read_bytes()).decode()
    width, pictures = page.evaluate(FILM, film)
    assert width > 300
    assert pictures >= 4, "the arm moves in the film"
    assert button.get_attribute("aria-pressed") == "false"


# ---- six joints, and a link under the reader's hand ------------------------------------------------------------

START = (0.4, 0.9, 220.0, 0.5, 0.3, -0.8)
CHOSEN = ".omx-chosen [role=cell]"


@pytest.fixture(scope="module")
def stanford(tmp_path_factory):
    rows, folder = ARMS["Stanford"].rows, tmp_path_factory.mktemp("stanford")
    ends = [(-math.pi, math.pi), (-1.5, 1.5), (100, 300), (-math.pi, math.pi), (-1.2, 1.2), (-math.pi, math.pi)]
    return Inverse(Chain(rows, ends, name="Stanford"), write_inverse("dragged", Chain(rows), folder=folder))


def numbers(words):
    return [float(word) for word in words.replace("\u2212", "-").split()]


def taken(inverse, target, start):
    """What a panel takes for a target, from `start`."""
    panel = HandPanel(inverse, start)
    panel.target = target
    return panel


def test_a_hand_is_moved_and_turned_as_python_would(show, tmp_path, capsys, stanford):
    """Six joints: an arrow moves, a ring turns about its own axis alone, seven ghosts, and the sliders follow."""
    page, _ = show(with_panels(tmp_path, HandPanel(stanford, START)))
    (frame,) = frames(page, 1)
    page.evaluate("scrollTo(0, 0)")
    frame.evaluate(WATCH)
    T = stanford.chain.fk(START)
    at = T[:3, 3]
    scale, z = frame.evaluate("OMX_CONFIG.arm.reach") / 320, np.array([0, 0, 1])
    arrow = at + 60 * scale * z
    drag(page, where(page, frame, arrow), where(page, frame, arrow + 40 * z), steps=30)
    asked = np.array(frame.evaluate(STATE)["asked"])
    np.testing.assert_allclose(asked[:3, :3], T[:3, :3], atol=1e-12)
    assert asked[:3, 3] - at == pytest.approx([0, 0, 40], abs=1.5)
    on_circle = [asked[:3, 3] + 52 * scale * np.array([math.cos(t), math.sin(t), 0]) for t in (-0.9, -0.5)]
    drag(page, *(where(page, frame, point) for point in on_circle), steps=30)
    state = frame.evaluate(STATE)
    turned = np.array(state["asked"])
    np.testing.assert_allclose(turned[:, 3], asked[:, 3], atol=1e-9)
    vector = rotation.to_vector(turned[:3, :3] @ asked[:3, :3].T)
    assert vector == pytest.approx([0, 0, 0.4], abs=0.04)
    assert vector[:2] == pytest.approx([0, 0], abs=1e-9), "the ring of z turns about z alone"
    wanted = taken(stanford, turned, START)
    assert state["q"] == pytest.approx(wanted.q, abs=1e-9)
    np.testing.assert_allclose(drawn(frame, 6), stanford.chain.frames(state["q"])[1:], atol=1e-6)
    sliders = [float(s.input_value()) for s in page.locator(".omx-sliders input").all()]
    assert sliders == pytest.approx([s.value for s in wanted.sliders], abs=0.51)
    branch, values, _ = page.locator(CHOSEN).all_inner_texts()
    in_units = [v if row.prismatic else math.degrees(v) for v, row in zip(wanted.q, stanford.chain.rows, strict=True)]
    assert branch.lstrip("\u25cf ") == next(s.branch for s in wanted.solutions if s.q == wanted.q)
    assert numbers(values) == pytest.approx(in_units, abs=0.06)
    tell(frame, "hand with seven ghosts", capsys)


def test_a_hand_by_keys_and_by_branch_and_what_refuses_it(show, tmp_path, stanford):
    page, _ = show(with_panels(tmp_path, HandPanel(stanford, START)))
    (frame,) = frames(page, 1)
    tool = frame.locator("#omx-grip")
    assert "x, y and z choose an axis, plus and minus turn about it" in tool.get_attribute("aria-label")
    tool.focus()
    T = stanford.chain.fk(START)
    for key in ("ArrowUp", "y", "Shift++"):
        tool.press(key)
        page.wait_for_timeout(700)
    asked = np.array(frame.evaluate(STATE)["asked"])
    assert asked[:3, 3] == pytest.approx(np.add(np.round(T[:3, 3]), [1, 0, 0]))
    turn = rotation.from_vector([0, math.radians(10), 0])
    np.testing.assert_allclose(asked[:3, :3], turn @ T[:3, :3], atol=1e-9)
    for _ in range(16):
        tool.press("Shift+PageUp")
    page.wait_for_timeout(1000)
    state = frame.evaluate(STATE)
    refused = taken(stanford, np.array(state["asked"]), START)
    assert state["chosen"] is None
    nearest = refused.message.split("Nearest is ")[1].split(": ")[0]
    spoken, shown = frame.evaluate(WORDS)
    assert shown.startswith("The arm stays: ")
    assert shown.endswith(f"({nearest}).")
    for violation in next(s for s in refused.solutions if s.branch == nearest).violations:
        by = f"{violation.excess:.1f}\u2009mm" if violation.prismatic else f"{math.degrees(violation.excess):.1f}\u00b0"
        assert f"{violation.joint} = " in shown
        assert f"{by} beyond its limit" in spoken
    assert frame.evaluate(RED_GHOSTS) > 3
    for _ in range(16):
        tool.press("Shift+PageDown")
    page.locator(".omx-choice select").select_option("front, out, flip")
    page.wait_for_timeout(900)
    tool.press("ArrowUp")
    page.wait_for_timeout(900)
    state = frame.evaluate(STATE)
    assert state["chosen"]["name"] == "front, out, flip"
    assert state["q"][4] < 0
    assert "The arm takes front, out, flip." in page.locator(".omx-answer").inner_text()
    page.locator(".omx-choice select").select_option("back, in, flip")
    page.wait_for_timeout(900)
    assert "back, in, flip is not legal here" in page.locator(".omx-answer").inner_text()
    assert frame.evaluate(STATE)["q"] == pytest.approx(state["q"], abs=1e-9)
    assert serious(page) == []


SEEN_FROM = "omxScene.viewer.camera.getWorldPosition(new MeshCat.THREE.Vector3()).toArray()"


@pytest.mark.parametrize("kind", ["ours", "six joints", "by a finger"])
def test_a_link_is_pulled_and_the_camera_is_left_alone(kind, browser, tmp_path, capsys, stanford):
    """Which joints follow, how far, and within their limits; beside the arm the same hand turns the camera."""
    start = START if kind == "six joints" else (0.3, -0.4, 0.4, 0.5)
    panel = JointPanel(View.of_chain(stanford.chain, start)) if kind == "six joints" else PosePanel(q=start)
    chain, (low, high) = panel.view.chain, np.transpose(stanford.chain.limits if kind == "six joints" else omx.LIMITS)
    finger = kind == "by a finger"
    size = {"width": 390, "height": 800} if finger else {"width": 900, "height": 700}
    context = browser.new_context(viewport=size, has_touch=finger, is_mobile=finger)
    page = context.new_page()
    page.goto(with_panels(tmp_path, panel).as_uri())
    (frame,) = frames(page, 1)
    page.wait_for_timeout(700)
    frame.evaluate(WATCH)
    touch = context.new_cdp_session(page)

    def move(start, end):
        if not finger:
            return drag(page, start, end, steps=25)
        ways = [("touchStart", 0), *(("touchMove", k / 8) for k in range(1, 9)), ("touchEnd", None)]
        for name, share in ways:
            at = [] if share is None else [{c: a + (b - a) * share for c, a, b in zip("xy", start, end, strict=True)}]
            touch.send("Input.dispatchTouchEvent", {"type": name, "touchPoints": at})
            page.wait_for_timeout(30)
        return page.wait_for_timeout(1000)

    link, point = 3, [0, 0, -120, 1] if kind == "six joints" else [-40, 0, 0, 1]
    grabbed = where(page, frame, (chain.frames(start)[link] @ point)[:3])
    seen = frame.evaluate(SEEN_FROM)
    move(grabbed, grabbed)
    assert frame.evaluate(STATE)["q"] == pytest.approx(start, abs=1e-9), "a click pulls nothing"
    move(grabbed, (grabbed[0] + 8, grabbed[1] - 16))
    state = frame.evaluate(STATE)
    assert state["stopped"] == ""
    assert state["q"][link:] == pytest.approx(start[link:], abs=1e-9), "joints beyond the link stand still"
    assert np.abs(np.subtract(state["q"], start)[:link]).max() > 0.03
    np.testing.assert_allclose(drawn(frame, len(chain)), chain.frames(state["q"])[1:], atol=1e-6)
    assert frame.evaluate(SEEN_FROM) == pytest.approx(seen, abs=1e-9)
    sliders = [float(s.input_value()) for s in page.locator(".omx-sliders input").all()]
    if kind == "six joints":
        assert sliders == pytest.approx([v if i == 2 else math.degrees(v) for i, v in enumerate(state["q"])], abs=0.51)
    else:
        assert sliders[:3] == pytest.approx(omx.pose(state["q"])[:3], abs=0.51)
    grabbed = where(page, frame, (chain.frames(state["q"])[link] @ point)[:3])
    move(grabbed, (grabbed[0] - 150, grabbed[1] + 150))
    state = frame.evaluate(STATE)
    assert (np.array(state["q"]) >= low - 1e-9).all()
    assert (np.array(state["q"]) <= high + 1e-9).all()
    spoken, shown = frame.evaluate(WORDS)
    assert state["stopped"]
    assert shown == f"The arm comes no nearer: {state['stopped']}."
    assert f"the arm comes no nearer: {state['stopped']}." in spoken
    box = page.locator("iframe").bounding_box()
    corner = (box["x"] + 0.85 * box["width"], box["y"] + 0.25 * box["height"])
    move(corner, (corner[0] - 60, corner[1] + 10))
    assert np.linalg.norm(np.subtract(frame.evaluate(SEEN_FROM), seen)) > 0.02, "empty space turns the camera"
    assert frame.evaluate(STATE)["q"] == pytest.approx(state["q"], abs=1e-9)
    tell(frame, f"link, {kind}", capsys)
    context.close()


def test_a_robots_arm_stays_where_the_robot_is_when_its_link_is_pulled(show, tmp_path):
    """Only a ghost obeys, and the page is told where it stands."""
    start = (0.3, -0.4, 0.4, 0.5)
    panel = JointPanel(View(start))
    panel.command_a_ghost()
    page, frame = opened(show, tmp_path, panel)
    page.evaluate("window.told = []; window.addEventListener('message', ({ data }) => told.push(data))")
    grabbed = where(page, frame, (omx.frames(start)[3] @ [-40, 0, 0, 1])[:3])
    drag(page, grabbed, (grabbed[0] + 8, grabbed[1] - 16))
    np.testing.assert_allclose(drawn(frame), omx.frames(start)[1:], atol=1e-6)
    told = page.evaluate("told.filter(({ omx }) => omx === 'dragged')")[-1]
    assert told["done"] is True
    assert told["pose"] is None
    assert np.abs(np.subtract(told["q"], start)[:3]).max() > 0.03
    assert told["q"][3] == pytest.approx(start[3])


def test_the_tool_of_a_planar_arm_stays_in_its_plane_and_comes_as_near_as_it_can(show, tmp_path):
    chain = Chain([(0, 0, 200, 0), (0, 0, 150, 0), (0, 0, 80, 0)], [(-1.5, 1.5)] * 3)
    page, frame = opened(show, tmp_path, View.of_chain(chain, (0.3, 0.4, 0.5)))
    frame.locator("#omx-bar button", has_text="tool").click()
    tool = frame.locator("#omx-grip")
    assert "plus" not in tool.get_attribute("aria-label")
    tool.focus()
    before = chain.fk((0.3, 0.4, 0.5))[:3, 3]
    tool.press("Shift+ArrowLeft")
    page.wait_for_timeout(900)
    state = frame.evaluate(STATE)
    assert state["asked"] == pytest.approx(np.round(before) + np.array([0, 10, 0]))
    assert chain.fk(state["q"])[:3, 3] == pytest.approx(state["asked"], abs=0.01)
    np.testing.assert_allclose(drawn(frame, 3), chain.frames(state["q"])[1:], atol=1e-6)
    for _ in range(12):
        tool.press("Shift+PageUp")
    page.wait_for_timeout(900)
    state = frame.evaluate(STATE)
    assert state["stopped"].startswith("out of reach, 120.0 mm")
    assert chain.fk(state["q"])[:2, 3] == pytest.approx(state["asked"][:2], abs=0.1)
