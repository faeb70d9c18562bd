"""Scenes and panels on pages: of what a cell tells of them (`SCENE`, where OMX_VIEW=data) their HTML, and its script.

On a page each is a mark of a few kB, which `placeholders.js` turns into a frame when the reader comes near. Objects are
named by their content: what many scenes hold (the arm, light, ground), the marks leave out and the script has once.
"""

import base64
import gzip
import hashlib
import html
import json
import struct
from pathlib import Path

from omx.display.viewer.assets import packed, script
from omx.display.viewer.html_export import as_text
from omx.display.viewer.scene import SCENE

PLACEHOLDERS = Path(__file__).with_name("placeholders.js")
#: Under the sliders of a `RobotPanel`, which have no robot on a page.
WITHOUT_ROBOT = (
    "Here the sliders move the drawn arm at once. In JupyterLab this panel also has motors, speed, hold-to-move and a "
    "stop button, and the state of each servo."
)


def as_html(outputs, common=()):
    """Outputs of a cell, with its scenes and panels as HTML; `common`: the keys of objects that the script has."""
    for output in outputs:
        data = output.get("data", {})
        if SCENE in data:
            shown = {"text/plain": data["text/plain"], "text/html": html_of(data[SCENE], common)}
            output = {**output, "data": shown}
        yield output


def html_of(told, common=()):
    """A scene, a panel or a live figure as HTML for a page that loads the scripts of `page_scripts.py`."""
    text = mark(told, common) if "log" in told else f"<p>{html.escape(told['title'])}</p>"
    if "panel" in told:
        text = f'<div class="omx-panel" data-panel="{html.escape(json.dumps(told["panel"]))}">{text}</div>'
    if "robot" in told:
        text = f'<div class="omx-robot">{text}<p class="omx-note">{WITHOUT_ROBOT}</p></div>'
    return text


def mark(told, common):
    """The mark of a scene, with all of it but the objects in `common`, and with the picture that is printed, if any."""
    log = from_text(told["log"])
    names = {key: name_of(data) for key, data in log.items() if key[0] == "set_object"}
    own = {(name,): log[key] for key, name in names.items() if (name,) not in common}
    config = html.escape(json.dumps(told["config"], separators=(",", ":")), quote=False).replace("'", "&#39;")
    picture = f' data-poster="{told["poster"]}"' if "poster" in told else ""
    return (
        f'<div class="omx-scene" role="img" aria-label="{html.escape(told["title"])}" '
        f'style="width:100%;height:{told["height"]}px" data-config=\'{config}\' data-scene="{as_text(log | names)}" '
        f'data-objects="{as_text(own)}"{picture}></div>'
    )


def objects(told):
    """The objects of a scene: bytes by their keys, which are names alone."""
    log = from_text(told["log"]) if "log" in told else {}
    return {(name_of(data),): data for (kind, *_), data in log.items() if kind == "set_object"}


def name_of(data):
    """The name of an object: a hash of its content."""
    return hashlib.sha256(data).hexdigest()[:12]


def from_text(text):
    """Bytes by their keys, of which `as_text` made this text."""
    data = gzip.decompress(base64.b64decode(text))
    (size,) = struct.unpack("<I", data[:4])
    parts, at = {}, 4 + size
    for *key, length in json.loads(data[4:at]):
        parts[tuple(key)] = data[at : at + length]
        at += length
    return parts


def page_script(common):
    """What a page loads once for all its marks; `common`: objects that these leave out."""
    values = {"viewer": base64.b64encode(packed()[1]).decode(), "stock": as_text(common),
              "shell": script("shell.html"), "start": script("static_scene.js")}  # fmt: skip
    return f"const OMX_VIEW = {json.dumps(values)};\n{PLACEHOLDERS.read_text(encoding='utf-8')}"
