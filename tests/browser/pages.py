"""A notebook in a browser: run it, find its scenes, move its sliders, and look at the pixels."""

import contextlib
import io
import json
import time

import numpy as np
from PIL import Image

RUN_TIMEOUT_S = 90
#: What Chromium prints about its own software rendering.
NOISE = ("GPU stall", "GL Driver Message", "WebGL-")


#: The notebook in front.
SHOWN = ".jp-NotebookPanel:not(.lm-mod-hidden)"


#: What scrolls, and in it all scenes in sight are drawn, and no widget is still to come.
OUTER = f"{SHOWN} .jp-WindowedPanel-outer"
ALL_DRAWN = """(outer) => {
  const box = document.querySelector(outer).getBoundingClientRect();
  const inside = ({ top, bottom }, least) => Math.min(bottom, box.bottom) - Math.max(top, box.top) > least;
  const waiting = [...document.querySelectorAll(outer + " .omx-scene:not([data-ready])")].map((scene) => [scene, 20]);
  for (const output of document.querySelectorAll(outer + " .jp-OutputArea-output")) {
    if (output.textContent === "Loading widget...") waiting.push([output, 0]);
  }
  return !waiting.some(([node, least]) => node.checkVisibility() && inside(node.getBoundingClientRect(), least));
}"""
#: How far it is scrolled, and how far it can still be.
SCROLLED = "({ scrollTop, scrollHeight, clientHeight }) => [scrollTop, scrollHeight - clientHeight - scrollTop]"
IS_SCROLLED = "([outer, before]) => document.querySelector(outer).scrollTop !== before"


FRAMES = """async () => {
  for (let i = 0; i < 4; i++) await new Promise(requestAnimationFrame);
}"""


class NotebookPage:
    """A notebook opened in JupyterLab; `errors` collects what the page's console complains about."""

    def __init__(self, context, lab, path):
        self.path, self._lab = path, lab
        self.errors = []
        self.page = context.new_page()
        self.page.on("console", self._console)
        self.page.on("pageerror", lambda error: self.errors.append(f"page error: {error}"))
        # a workspace of its own, or JupyterLab would open the notebooks of earlier tests again
        address = lab.page(path.relative_to(lab.root).as_posix())
        self.page.goto(address.replace("/lab/tree/", f"/lab/workspaces/{path.stem}/tree/"))
        self._wait_for_notebook()

    def leave(self):
        """Close the notebook, as a reader does who goes on to another; False if JupyterLab is gone, or asks back."""
        if not self.page.url.startswith(self._lab.url) or self.page.locator(".jp-Dialog").count():
            return False
        self.menu("File", "Close All Tabs")
        self.page.locator(".jp-NotebookPanel").first.wait_for(state="detached")
        return True

    def go_on_to(self, path):
        """Open another notebook in the JupyterLab that is there: half the work of a new page."""
        self.path, self.errors = path, []
        self.menu("File", "Open from Path…")
        self.page.locator(".jp-Dialog input").fill(path.relative_to(self._lab.root).as_posix())
        self.page.locator(".jp-Dialog .jp-mod-accept").click()
        self._wait_for_notebook()
        return self

    def menu(self, name, entry):
        """Choose an entry of the menu bar."""
        self.page.locator(".lm-MenuBar-item", has_text=name).first.click()
        self.page.locator(".lm-Menu-item", has_text=entry).first.click()

    def _console(self, message):
        if message.type == "error" and not any(noise in message.text for noise in NOISE):
            self.errors.append(message.text)

    def _wait_for_notebook(self):
        self.page.locator(f"{SHOWN} .jp-Cell").first.wait_for(timeout=60_000)
        self.wait_for_kernel()

    @property
    def kernel(self):
        """The kernel of this notebook as the server describes it, or None."""
        sessions = self._lab.ask("sessions")
        return next((s["kernel"] for s in sessions if s["path"].endswith(self.path.name)), None)

    def wait_for_kernel(self):
        """Until the kernel is idle, on the server and in the page."""
        deadline = time.monotonic() + RUN_TIMEOUT_S
        while not (self.kernel and self.kernel["execution_state"] == "idle"):
            if time.monotonic() > deadline:
                raise TimeoutError(f"the kernel of {self.path.name} is busy after {RUN_TIMEOUT_S} s")
            self.page.wait_for_timeout(400)
        idle = f"{SHOWN} .jp-Notebook-ExecutionIndicator[data-status=idle]"
        self.page.locator(idle).first.wait_for(timeout=60_000, state="attached")
        self.page.wait_for_timeout(300)

    # -- running ------------------------------------------------------------------------------------------

    def start(self):
        """Begin to run every cell."""
        self.menu("Run", "Run All Cells")

    def run_all(self):
        """Run every cell, wait for the last, and return the cells as JupyterLab saved them."""
        self.start()
        deadline = time.monotonic() + RUN_TIMEOUT_S
        while time.monotonic() < deadline:
            self.wait_for_kernel()
            cells = self.save()
            if all(cell["execution_count"] for cell in cells if cell["cell_type"] == "code" and cell["source"]):
                return cells
            if any(fatal(output) for cell in cells for output in cell.get("outputs", ())):
                return cells
        raise TimeoutError(f"{self.path.name} does not finish in {RUN_TIMEOUT_S} s")

    def save(self):
        """Save, and read the cells back from the disk."""
        before = self.path.stat().st_mtime_ns
        self.page.keyboard.press("Control+s")
        deadline = time.monotonic() + 10
        while time.monotonic() < deadline:
            self.page.wait_for_timeout(100)
            if self.path.stat().st_mtime_ns != before:
                with contextlib.suppress(json.JSONDecodeError):  # it is being written
                    return json.loads(self.path.read_text(encoding="utf-8"))["cells"]
        raise TimeoutError(f"{self.path.name} was not saved")

    def reload(self):
        """Load the page again, as a reader does whose browser was closed; the kernel lives on."""
        self.page.reload()
        self._wait_for_notebook()

    # -- scenes -------------------------------------------------------------------------------------------

    def scene(self, selector=".omx-scene[data-ready]"):
        """The first live scene, scrolled into view; None if the notebook has none."""
        return self._scroll_to(selector, sure=True)

    def panel(self, sure=True):
        """The first output with both a live scene and sliders, or None. `sure`: there must be one."""
        return self._scroll_to(".jp-OutputArea-output:has(.omx-scene[data-ready]):has(.noUi-handle)", sure)

    def _scroll_to(self, selector, sure):
        """JupyterLab draws only the cells near the window: turn the wheel until the element is there.

        A scene that is just being made cannot be waited for yet: where there must be one, the next rounds wait longer.
        """
        rounds = (80, 1000, 3000) if sure else (80,)
        return next(filter(None, (self._scrolled(selector, pause_ms) for pause_ms in rounds)), None)

    def _scrolled(self, selector, pause_ms):
        found = self.page.locator(selector)
        box = self.page.locator(OUTER).bounding_box()
        self.page.mouse.move(box["x"] + 20, box["y"] + box["height"] / 2)
        if (top := self._scroll_place()[0]) > 0:
            self._turn_wheel(-top - 1000)
        at_end = False
        while not at_end:
            self.page.wait_for_timeout(pause_ms)
            self._wait_for_scenes()
            if found.count():
                found.first.scroll_into_view_if_needed()
                return found.first
            at_end = not self._turn_wheel(0.9 * box["height"])
        return None

    def _wait_for_scenes(self):
        """Until every scene in sight is drawn; a strip below the tool bar may hide a scene's last line."""
        self.page.wait_for_function(ALL_DRAWN, arg=OUTER, timeout=30_000, polling=50)

    def _scroll_place(self):
        return self.page.locator(OUTER).evaluate(SCROLLED)

    def _turn_wheel(self, distance):
        """Scroll, and wait until that is seen; False at the end of the notebook."""
        before, left = self._scroll_place()
        if distance > 0 and left < 2:
            return False
        self.page.mouse.wheel(0, distance)
        self.page.wait_for_function(IS_SCROLLED, arg=[OUTER, before], timeout=30_000, polling=50)
        return True

    def settle(self):
        """Until what was asked for is drawn: messages have arrived, the kernel is idle, a few frames have passed."""
        self.page.wait_for_timeout(300)
        self.wait_for_kernel()
        self.page.evaluate(FRAMES)

    def until(self, condition, timeout_s=60):
        """Look again and again until `condition()` holds; its last value. A busy machine takes its time."""
        deadline = time.monotonic() + timeout_s
        while not (found := condition()) and time.monotonic() < deadline:
            self.page.wait_for_timeout(100)
        return found

    def changes(self, element, before, share):
        """Does the picture of the element come to differ from the one `before` in more than this share of it?"""
        return self.until(lambda: share_changed(before, pixels(element)) > share)

    def close(self):
        self.page.close()


def fatal(output):
    return output["output_type"] == "error"


def pixels(element):
    """A screenshot of an element as an array (height, width, 3)."""
    return np.asarray(Image.open(io.BytesIO(element.screenshot())).convert("RGB")).astype(int)


def is_blank(image):
    """True if hardly anything stands out from the background, row by row."""
    return share_changed(image, np.median(image, axis=1, keepdims=True).astype(int)) < 0.004


def share_changed(one, two, threshold=40):
    """The share of pixels that differ visibly."""
    return float((np.abs(one - two).max(axis=2) > threshold).mean())
