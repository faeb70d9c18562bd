"""A page of the site, or a deck, in a browser that reaches nothing but this machine."""

import base64
import functools
import http.server
import io
import threading
from contextlib import contextmanager

import numpy as np
from PIL import Image

from book.publish import npm

#: What Chromium prints about its own software rendering.
NOISE = ("GPU stall", "GL Driver Message", "WebGL-")


class Quiet(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *_):
        pass


class Beside(Quiet):
    """A server of one folder with others in it, which lie elsewhere: by name."""

    def __init__(self, *args, others, **kwargs):
        self.others = others
        super().__init__(*args, **kwargs)

    def translate_path(self, path):
        name, _, rest = path.removeprefix("/").partition("/")
        if name not in self.others:
            return super().translate_path(path)
        self.directory, kept = str(self.others[name]), self.directory
        try:
            return super().translate_path(f"/{rest}")
        finally:
            self.directory = kept


@contextmanager
def served(folder, **others):
    """The address of a folder served on the loopback address; `others` appear in it under their names."""
    handler = functools.partial(Beside, directory=folder, others=others)
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        try:
            yield f"http://127.0.0.1:{server.server_port}/"
        finally:
            server.shutdown()


class Look:
    """A page with its `problems`: errors in the console, requests that fail or would leave."""

    def __init__(self, context, home):
        self.problems, self.weights, self._home = [], {}, home
        self.page = context.new_page()
        self.page.on("console", self._console)
        self.page.on("pageerror", lambda error: self.problems.append(f"page error: {error}"))
        self.page.on("request", self._request)
        self.page.on("response", self._response)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.page.close()

    def open(self, path):
        self.page.goto(self._home + path)
        self.page.wait_for_load_state("load")
        return self

    def _stays(self, url):
        return url.startswith((self._home, "data:", "blob:", "about:"))

    def _console(self, message):
        if message.type == "error" and not any(noise in message.text for noise in NOISE):
            self.problems.append(f"console: {message.text}")

    def _request(self, request):
        if not self._stays(request.url):
            self.problems.append(f"request leaves: {request.url}")

    def _response(self, response):
        if response.status >= 400:
            self.problems.append(f"status {response.status}: {response.url}")
        elif response.url.startswith(self._home):
            self.weights[response.url[len(self._home) :].split("?")[0]] = response

    def weight(self):
        """Bytes of each file that the page loaded."""
        return {name: len(response.body()) for name, response in self.weights.items()}

    def settle(self):
        """Wait until the formulas are typeset."""
        self.page.wait_for_selector("body[data-settled]", timeout=90_000)
        return self

    # ---- scenes ------------------------------------------------------------------------------------------

    def scene(self, box):
        """The frame of a scene, ready; `box` is its element."""
        box.scroll_into_view_if_needed()
        box.locator("iframe").wait_for()
        frame = box.locator("iframe").element_handle().content_frame()
        frame.wait_for_selector("body[data-ready]", timeout=60_000)
        return frame


def serious(page, where="body", rules=()):
    """What axe finds serious or critical in a page, or in a scene's frame, below `where`; by all rules, or by these."""
    page.evaluate(f"{(npm.modules() / 'axe-core/axe.min.js').read_text(encoding='utf-8')}; 0")
    options = {"iframes": False, "resultTypes": ["violations"]} | ({"runOnly": list(rules)} if rules else {})
    run = "([where, options]) => axe.run(document.querySelector(where), options)"
    found = page.evaluate(run, [where, options])["violations"]
    return [
        f"{v['id']}: {v['help']}: {v['nodes'][0]['html'][:150]} ({len(v['nodes'])} times)"
        for v in found
        if v["impact"] in ("serious", "critical")
    ]


def picture(frame):
    """What a scene shows, as an array (rows, columns, 3)."""
    return image_of(frame.evaluate("omxScene.picture(1)"))


def image_of(url):
    """The picture of a `data:` address, as an array."""
    return np.asarray(Image.open(io.BytesIO(base64.b64decode(url.split(",")[1]))).convert("RGB"), float)


def is_blank(image):
    """Does the picture show nothing but a background that runs from one tone to another?"""
    return np.abs(image - np.median(image, axis=1, keepdims=True)).max() < 40
