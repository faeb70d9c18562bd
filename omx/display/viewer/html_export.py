"""A scene without a kernel: HTML for pages and slides that fetches nothing and cannot touch the page around it."""

import base64
import functools
import gzip
import hashlib
import html
import json
import struct
from pathlib import Path

from .assets import packed, script


def shell(config: dict) -> str:
    """The frame's page: a pane, our style, and a mark where the viewer's script goes."""
    return script("shell.html").replace("/*config*/{}", json.dumps(config).replace("<", "\\u003c"))


def scene_data(channel, known: dict[str, bytes] | None = None, night: dict[tuple, bytes] | None = None) -> str:
    """The scene as text: its commands' keys and bytes, gzipped, base64; `known` commands only by their name.

    Commands of `night` have a fourth word in their key, `night`; they are for a page whose theme is dark.
    """
    commands = channel.log | {(*key, "night"): data for key, data in (night or {}).items()}
    names = {key: _name(data) for key, data in commands.items()} if known else {}
    kept = {key: data for key, data in commands.items() if names.get(key) not in (known or ())}
    head = [[*key, len(data) if key in kept else names[key]] for key, data in commands.items()]
    return _base64(_gzip(_packed(head, kept.values())))


@functools.cache
def stock() -> dict[str, bytes]:
    """What many scenes hold (the course's arm, its ghosts, a row's marks, light and ground), by name."""
    from .row_view import RowView
    from .view import View

    out = {}
    for dark in (False, True):
        view = View(dark=dark)
        view.ghosts([view.q] * 4)
        for scene in (view, RowView(dark=dark)):
            out |= {_name(data): data for key, data in scene.channel.log.items() if key[0] == "set_object"}
    return out


def page(channel, config: dict | None = None) -> str:
    """The whole scene as one page that needs nothing else."""
    data = f'<script type="text/plain" id="scene">{scene_data(channel)}</script>'
    viewer = f'<script type="text/plain" id="viewer">{_base64(packed()[1])}</script>'
    start = f"<script>{script('start.js')}</script>"
    return shell(config or {}).replace("<!--viewer-->", data + viewer + start)


def frame(channel, config: dict, height: int, title: str) -> str:
    """A sandboxed frame that holds `page`: scripts run, but cannot reach the page around it."""
    style = f"width:100%;height:{height}px;border:0;display:block"
    return (
        f'<iframe class="omx-scene" sandbox="allow-scripts" loading="lazy" title="{html.escape(title)}" '
        f'style="{style}" srcdoc="{html.escape(page(channel, config))}"></iframe>'
    )


def placeholder(channel, config: dict, height: int, title: str, night: dict | None = None) -> str:
    """A mark that the site's script (`write_site_script`) turns into a frame when the reader comes near."""
    data = scene_data(channel, stock(), night)
    return (
        f'<div class="omx-scene" role="img" aria-label="{html.escape(title)}" style="width:100%;height:{height}px" '
        f'data-config="{html.escape(json.dumps(config))}" data-scene="{data}"></div>'
    )


def write_site_script(folder) -> Path:
    """Write `omx-view.js` into `folder`: the script that a site loads once for all its scenes. Returns its path."""
    shapes = _packed([[name, len(data)] for name, data in stock().items()], stock().values())
    values = {"viewer": _base64(packed()[1]), "stock": _base64(_gzip(shapes)), "shell": script("shell.html"),
              "start": script("start.js")}  # fmt: skip
    path = Path(folder, "omx-view.js")
    path.write_text(f"const OMX_VIEW = {json.dumps(values)};\n{script('page.js')}", encoding="utf-8", newline="\n")
    return path


def _packed(head: list, parts) -> bytes:
    """A length, a JSON head, and bytes: what `start.js` takes apart."""
    text = json.dumps(head).encode()
    return struct.pack("<I", len(text)) + text + b"".join(parts)


def _name(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()[:12]


def _gzip(data: bytes) -> bytes:
    return gzip.compress(data, 9, mtime=0)


def _base64(data: bytes) -> str:
    return base64.b64encode(data).decode("ascii")
