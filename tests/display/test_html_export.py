"""Scenes without a kernel: the scene is all there, and its viewer is named by what it holds."""

import base64
import gzip
import json
import re
import struct

import omx
from omx.display.viewer import View, html_export, write_site_script
from omx.display.viewer.assets import packed, viewer_source


def take_apart(text):
    """The rows and bytes of a packed scene, as `start.js` reads them."""
    data = gzip.decompress(base64.b64decode(text))
    (size,) = struct.unpack("<I", data[:4])
    head, at, out = json.loads(data[4 : 4 + size]), 4 + size, []
    for *row, last in head:
        if isinstance(last, str):
            out.append((tuple(row), last))
        else:
            out.append((tuple(row), data[at : at + last]))
            at += last
    assert at == len(data)
    return out


def test_the_same_scene_gives_the_same_bytes():
    assert View().static_html() == View().static_html()


def shared(view):
    """The rows of a placeholder's scene, and its objects by name."""
    placeholder = view.static_html()
    scene, objects = (re.search(rf'data-{name}="([^"]*)"', placeholder)[1] for name in ("scene", "objects"))
    return take_apart(scene), html_export.unpacked_objects(objects)


def test_a_placeholder_holds_its_scene_and_names_its_objects_by_content():
    view = View((0.1, 0.2, 0.3, 0.4))
    view.ghosts([omx.HOME, omx.ZERO])
    view.label("w", 'a "quoted" <b>word</b>', (0, 0, 100))
    view.animate([omx.HOME, omx.ZERO])
    scene, objects = shared(view)
    assert {key: objects.get(data, data) for key, data in scene} == view.channel.log
    assert all(html_export.name_of(data) == name for name, data in objects.items())
    other = shared(View((0.3, 0.2, 0.1, 0.0)))[1]
    assert other.keys() < objects.keys(), "another pose is the same arm"


def test_the_sites_script_holds_what_it_is_given(tmp_path):
    _, objects = shared(View())
    script = write_site_script(tmp_path, objects)
    assert script.name == "omx-view.js"
    values = json.loads(re.match(r"const OMX_VIEW = (\{.*\});\n", script.read_text(encoding="utf-8"))[1])
    assert html_export.unpacked_objects(values["stock"]) == objects


def test_a_site_script_is_written_in_place_of_an_old_one(tmp_path):
    assert write_site_script(tmp_path).read_bytes() == write_site_script(tmp_path).read_bytes()


# ---- in cells ------------------------------------------------------------------------------------------


def test_a_cell_shows_html_where_a_page_is_built(monkeypatch):
    monkeypatch.setenv("OMX_VIEW", "shared")
    view = View()
    data = view._repr_mimebundle_()
    assert set(data) == {"text/plain", "text/html"}
    assert data["text/plain"] == repr(view)
    assert 'class="omx-scene"' in data["text/html"]
    assert view._widget is None


def test_the_packed_viewer_is_named_by_content_and_small():
    key, data = packed()
    assert re.fullmatch(r"[0-9a-f]{16}", key)
    assert len(data) < 250_000
    source = gzip.decompress(data).decode()
    assert source.startswith(viewer_source()), "unmodified"
    assert "import(" not in source.removeprefix(viewer_source())
    assert "fetch(" not in source.removeprefix(viewer_source())
