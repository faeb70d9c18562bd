"""The output cell's end of the channel: an anywidget that runs the MeshCat viewer in a frame."""

import uuid

import anywidget
import ipywidgets
import traitlets

from .assets import packed, script
from .channel import Channel


class Bundle(ipywidgets.Widget):
    """The packed viewer, sent to the page once, however many scenes a notebook shows."""

    key = traitlets.Unicode().tag(sync=True)
    data = traitlets.Bytes().tag(sync=True)


#: Figures are drawn on white paper; a dark theme dims the paper, as the site does.
NIGHT_FIGURES = """
body[data-jp-theme-light="false"] .jp-RenderedImage img { filter: brightness(0.82); border-radius: 6px; }
"""

_bundle: Bundle | None = None


def bundle() -> Bundle:
    """The kernel's one `Bundle`, made again if somebody closed it."""
    global _bundle
    if _bundle is None or _bundle.comm is None:
        key, data = packed()
        _bundle = Bundle(key=key, data=data)
    return _bundle


class SceneWidget(anywidget.AnyWidget):
    """One scene in the page. Its state holds the whole scene whenever the page asks for it."""

    _esm = script("widget.js")
    _css = NIGHT_FIGURES

    key = traitlets.Unicode().tag(sync=True)
    height = traitlets.Int(420).tag(sync=True)
    title = traitlets.Unicode("3-D scene").tag(sync=True)
    config = traitlets.Dict().tag(sync=True)
    bundle = traitlets.Instance(ipywidgets.Widget).tag(sync=True, **ipywidgets.widget_serialization)
    scene = traitlets.Dict().tag(sync=True)

    def __init__(self, channel: Channel, on_drag, **traits):
        """`on_drag(pose, q)` hears where the reader drags the tool: see `Scene.on_drag`."""
        self._channel, self._on_drag = channel, on_drag
        super().__init__(key=uuid.uuid4().hex, bundle=bundle(), **traits)
        channel.attach(self._post)
        self.on_msg(self._on_message)

    def get_state(self, key=None, drop_defaults=False):
        """The widget's state, with the scene as it is now: a reloaded page asks for this and nothing else."""
        state = super().get_state(key=key, drop_defaults=drop_defaults)
        if "scene" in state:
            content, buffers = self._channel.replay()
            state["scene"] = {**content, "data": buffers[0]}
        return state

    def _post(self, content: dict, buffers: list) -> None:
        if self.comm is not None:
            self.send(content, buffers)

    def _on_message(self, _, content, __) -> None:
        """A page says how far it is (one that has missed something is sent the whole scene), or where it is dragged."""
        if content.get("event") == "hello" and content.get("seq") != self._channel.seq:
            self._post(*self._channel.replay())
        if content.get("event") == "dragged":
            self._on_drag(content["pose"], content["q"])
