"""The window that a `meshcat.Visualizer` writes to, when the scene lives in a notebook's output cell.

MeshCat's own window is a socket to a server. This one keeps the scene on the Python side, as the last
command of each kind for each path, and posts what changed over the notebook's own comm channel: nothing
listens on a port. A page that comes late, or comes back, is sent the whole scene first.
"""

import asyncio
import threading
import time
import weakref
from contextlib import contextmanager

import umsgpack

from .commands import pack, plain, set_transform

#: Seconds between two messages: 60 a second are all that a screen shows.
INTERVAL = 1 / 60
#: Root of everything that Python draws; what lies outside (lights, camera) belongs to the viewer.
ROOT = "/meshcat"

_open_channels = weakref.WeakSet()


class Channel:
    """The scene as a log of commands, and the part of it that the pages have not seen yet.

    A key is `(type, path, property)`. Only the newest command of a key is kept, at the place in the order
    where it was last written, so replaying the log rebuilds the scene, and a burst of poses costs one
    message: the newest pose always wins. `post(content, buffers)` carries a message to the pages; without
    it (no page yet) commands only go into the log.
    """

    def __init__(self, clock=time.monotonic):
        self.seq = 0
        self._clock = clock
        self._log: dict[tuple, bytes] = {}
        self._pending: dict[tuple, bytes] = {}
        self._post = None
        self._loop = None
        self._due = 0.0
        self._armed = False
        self._depth = 0
        self._lock = threading.RLock()

    # -- writing ------------------------------------------------------------------------------------------

    def put(self, kind: str, path: str, data: bytes, name: str = "") -> None:
        """Record one packed command; it is posted when the outermost `batch` ends."""
        with self.batch():
            if kind == "delete":
                _forget(self._log, path)
                _forget(self._pending, path)
            key = (kind, path, name)
            if kind != "delete" or not path.startswith(ROOT + "/"):
                _append(self._log, key, data)
            if self._post is not None:
                _append(self._pending, key, data)

    def draw(self, path: str, drawing) -> None:
        """Put a `Drawing` at `path`."""
        self.put("set_object", path, pack("set_object", path, object=drawing.lower()))

    def set(self, path: str, name: str, value) -> None:
        """Set one property of the node at `path`: `visible`, `color`, `position`, ..."""
        self.put("set_property", path, pack("set_property", path, property=name, value=plain(value)), name)

    def place(self, path: str, T) -> None:
        """Move the node at `path` to `T` (4, 4), mm."""
        self.put("set_transform", path, set_transform(path, T))

    def delete(self, path: str) -> None:
        """Remove the node at `path` and all below it."""
        self.put("delete", path, pack("delete", path))

    @contextmanager
    def batch(self):
        """Everything written inside goes out as one message, so that a pose is never seen half done."""
        with self._lock:
            self._depth += 1
            try:
                yield self
            finally:
                self._depth -= 1
                if self._depth == 0 and self._pending:
                    self._flush_when_due()

    # -- what meshcat.Visualizer asks of its window -------------------------------------------------------

    web_url = None

    def send(self, command) -> None:
        """Accept a command object of `meshcat.commands`."""
        lowered = plain(command.lower())
        if lowered["type"] == "capture_image":
            raise NotImplementedError("Save a picture with the camera button of the scene, or in Playwright.")
        self.put(lowered["type"], lowered["path"], umsgpack.packb(lowered), str(lowered.get("property", "")))

    def open(self):
        raise NotImplementedError("The scene has no address of its own: it lives in the notebook's output cell.")

    wait = open

    def get_scene(self) -> str:
        """The whole scene as one HTML page (what `Visualizer.static_html()` returns)."""
        from .html_export import page

        return page(self.log, {})

    # -- posting ------------------------------------------------------------------------------------------

    def attach(self, post) -> None:
        """Post every later change with `post`; the notebook's event loop is looked up here."""
        self._post = post
        self._loop = running_loop()
        _open_channels.add(self)
        _flush_after_cells()

    def flush(self) -> None:
        """Post what is pending now, whatever the rate."""
        with self._lock:
            if not self._pending or self._post is None:
                return
            pending, self._pending = self._pending, {}
            self._due = self._clock() + INTERVAL
            self.seq += 1
            self._post(*_message(self.seq, pending))

    def replay(self) -> tuple[dict, list]:
        """The whole scene as one message, pending changes included."""
        with self._lock:
            content, buffers = _message(self.seq, self._log)
            return {**content, "replay": True}, buffers

    @property
    def log(self) -> dict[tuple, bytes]:
        """A copy of the scene: `(type, path, property)` -> packed command, in the order to replay them."""
        with self._lock:
            return dict(self._log)

    def _flush_when_due(self) -> None:
        wait = self._due - self._clock()
        if wait <= 0:
            self.flush()
        elif self._loop is not None and not self._armed:
            self._armed = True
            self._loop.call_soon_threadsafe(self._loop.call_later, wait, self._flush_late)

    def _flush_late(self) -> None:
        self._armed = False
        self.flush()


def running_loop():
    """The event loop that runs here, or None."""
    try:
        return asyncio.get_running_loop()
    except RuntimeError:
        return None


def _append(log: dict, key: tuple, data: bytes) -> None:
    log.pop(key, None)
    log[key] = data


def _forget(log: dict, path: str) -> None:
    below = path + "/"
    for key in [key for key in log if key[1] == path or key[1].startswith(below)]:
        del log[key]


def _message(seq: int, commands: dict) -> tuple[dict, list]:
    """One message: the keys and lengths of the commands as JSON, their bytes joined as one buffer."""
    content = {"seq": seq, "keys": [list(key) for key in commands], "sizes": [len(d) for d in commands.values()]}
    return content, [b"".join(commands.values())]


def _flush_after_cells() -> None:
    """Have IPython flush every open channel at the end of each cell: the last pose of a loop is shown."""
    try:
        from IPython import get_ipython
    except ImportError:
        return
    shell = get_ipython()
    if shell is not None and flush_all not in shell.events.callbacks["post_run_cell"]:
        shell.events.register("post_run_cell", flush_all)


def flush_all(*_) -> None:
    """Flush every channel that a page may be looking at."""
    for channel in list(_open_channels):
        channel.flush()
