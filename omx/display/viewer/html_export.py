"""A scene without a kernel: HTML for pages and slides that fetches nothing and cannot touch the page around it."""

import base64
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


def scene_data(log: dict) -> tuple[str, dict[str, bytes]]:
    """The scene of a channel's `log` as text (its commands' keys and bytes, gzipped, base64), and its objects apart.

    Objects are named by their content, and only their names are in the text.
    """
    names = {key: name_of(data) for key, data in log.items() if key[0] == "set_object"}
    head = [[*key, names.get(key, len(data))] for key, data in log.items()]
    rest = [data for key, data in log.items() if key not in names]
    return _text(head, rest), {name: log[key] for key, name in names.items()}


def packed_objects(objects: dict[str, bytes]) -> str:
    """Objects by their names as text, as a placeholder and the site's script carry them."""
    return _text([[name, len(data)] for name, data in objects.items()], objects.values())


def unpacked_objects(text: str) -> dict[str, bytes]:
    """What `packed_objects` packed."""
    data = gzip.decompress(base64.b64decode(text))
    (size,) = struct.unpack("<I", data[:4])
    out, at = {}, 4 + size
    for name, length in json.loads(data[4:at]):
        out[name] = data[at : at + length]
        at += length
    return out


def page(log: dict, config: dict) -> str:
    """The whole scene as one page that needs nothing else."""
    scene = _text([[*key, len(data)] for key, data in log.items()], log.values())
    texts = {"scene": scene, "viewer": _base64(packed()[1])}.items()
    data = "".join(f'<script type="text/plain" id="{name}">{text}</script>' for name, text in texts)
    return shell(config).replace("<!--viewer-->", f"{data}<script>{script('start.js')}</script>")


def frame(log: dict, config: dict, height: int, title: str) -> str:
    """A sandboxed frame that holds `page`: scripts run, but cannot reach the page around it."""
    style = f"width:100%;height:{height}px;border:0;display:block"
    return (
        f'<iframe class="omx-scene" sandbox="allow-scripts allow-downloads" loading="lazy" '
        f'title="{html.escape(title)}" style="{style}" srcdoc="{html.escape(page(log, config))}"></iframe>'
    )


def placeholder(log: dict, config: dict, height: int, title: str) -> str:
    """A mark that the site's script (`write_site_script`) turns into a frame when the reader comes near.

    It holds the whole scene. A site may take out of it (`data-objects`) what its script already has. For paper there is
    a picture in it (`data-poster`).
    """
    from .poster import poster

    scene, objects = scene_data(log)
    config = html.escape(json.dumps(config, separators=(",", ":")), quote=False).replace("'", "&#39;")
    return (
        f'<div class="omx-scene" role="img" aria-label="{html.escape(title)}" style="width:100%;height:{height}px" '
        f'data-config=\'{config}\' data-scene="{scene}" data-objects="{packed_objects(objects)}" '
        f'data-poster="{_base64(poster(log, height))}"></div>'
    )


def write_site_script(folder, objects: dict[str, bytes] | None = None) -> Path:
    """Write `omx-view.js` into `folder`, the script that a site loads once for all its scenes; returns its path.

    `objects`: what many scenes of the site share, by name, and what their placeholders may do without.
    """
    values = {"viewer": _base64(packed()[1]), "stock": packed_objects(objects or {}), "shell": script("shell.html"),
              "start": script("start.js")}  # fmt: skip
    path = Path(folder, "omx-view.js")
    text = f"const OMX_VIEW = {json.dumps(values)};\n{script('placeholders.js')}"
    path.write_text(text, encoding="utf-8", newline="\n")
    return path


def name_of(data: bytes) -> str:
    """The name of an object: a hash of its content."""
    return hashlib.sha256(data).hexdigest()[:12]


def _text(head: list, parts) -> str:
    """A length, a JSON head, and bytes, gzipped, as text: what `start.js` takes apart."""
    told = json.dumps(head).encode()
    return _base64(gzip.compress(struct.pack("<I", len(told)) + told + b"".join(parts), 9, mtime=0))


def _base64(data: bytes) -> str:
    return base64.b64encode(data).decode("ascii")
