"""A scene without a kernel: HTML that fetches nothing and cannot touch the page around it."""

import base64
import gzip
import html
import json
import struct

from .assets import packed, script


def shell(config: dict) -> str:
    """The frame's page: a pane, our style, and a mark where the viewer's script goes."""
    return script("shell.html").replace("/*config*/{}", json.dumps(config).replace("<", "\\u003c"))


def page(log: dict, config: dict) -> str:
    """The whole scene as one page that needs nothing else."""
    texts = {"scene": as_text(log), "viewer": _base64(packed()[1])}.items()
    data = "".join(f'<script type="text/plain" id="{name}">{text}</script>' for name, text in texts)
    return shell(config).replace("<!--viewer-->", f"{data}<script>{script('static_scene.js')}</script>")


def frame(log: dict, config: dict, height: int, title: str) -> str:
    """A sandboxed frame that holds `page`: scripts run, but cannot reach the page around it."""
    style = f"width:100%;height:{height}px;border:0;display:block"
    return (
        f'<iframe class="omx-scene" sandbox="allow-scripts allow-downloads" loading="lazy" '
        f'title="{html.escape(title)}" style="{style}" srcdoc="{html.escape(page(log, config))}"></iframe>'
    )


def as_text(parts: dict) -> str:
    """Bytes by their keys (tuples of words) as text that `static_scene.js` takes apart: length, JSON head, bytes.

    All this is gzipped, base64. In place of bytes there may be the name of some that the frame knows.
    """
    told = json.dumps([[*key, part if isinstance(part, str) else len(part)] for key, part in parts.items()]).encode()
    data = b"".join(part for part in parts.values() if not isinstance(part, str))
    return _base64(gzip.compress(struct.pack("<I", len(told)) + told + data, 9, mtime=0))


def _base64(data: bytes) -> str:
    return base64.b64encode(data).decode("ascii")
