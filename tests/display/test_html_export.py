"""Scenes without a kernel: nothing is fetched, nothing gets out of the frame, and the scene is all there."""

import base64
import gzip
import html
import json
import re
import struct

import pytest

import omx
from omx.display.viewer import View, html_export, write_site_script
from omx.display.viewer.assets import packed, viewer_source


@pytest.fixture(scope="module")
def view():
    view = View()
    view.frames(4)
    view.label("w", 'a "quoted" <b>word</b>', (0, 0, 100))
    view.animate([omx.HOME, omx.ZERO])
    return view


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


def embedded(page, name):
    return re.search(rf'<script type="text/plain" id="{name}">([^<]*)</script>', page)[1]


def inner_page(frame):
    return html.unescape(re.search(r'srcdoc="([^"]*)"', frame)[1])


def test_a_static_scene_is_a_sandboxed_lazy_frame(view):
    frame = view.static_html()
    assert frame.startswith("<iframe ")
    assert re.findall(r'sandbox="([^"]*)"', frame) == ["allow-scripts allow-downloads"]
    assert 'loading="lazy"' in frame
    assert f'title="{html.escape(repr(view))}"' in frame


def test_a_static_scene_fetches_nothing(view):
    page = inner_page(view.static_html())
    outside = re.findall(r'(?:src|href|url)\s*[=(]\s*["\']?(?!data:|blob:)(\w+:[^"\')\s]*)', page)
    assert not outside
    assert "import(" not in page
    assert "fetch(" not in page


def test_a_static_scene_holds_the_whole_scene_and_the_unmodified_viewer(view):
    page = inner_page(view.static_html())
    assert dict(take_apart(embedded(page, "scene"))) == view.channel.log
    source = gzip.decompress(base64.b64decode(embedded(page, "viewer"))).decode()
    assert source.startswith(viewer_source())


def test_an_animation_is_in_it(view):
    keys = [key for key, _ in take_apart(embedded(inner_page(view.static_html()), "scene"))]
    assert ("set_animation", "", "") in keys


def test_words_in_a_scene_cannot_end_the_script(view):
    page = inner_page(view.static_html())
    assert page.count("<script") == page.count("</script>") == len(re.findall(r"<script[^>]*>[^<]", page))


def test_the_same_scene_gives_the_same_bytes():
    assert View().static_html() == View().static_html()


def test_visualizer_static_html_is_a_whole_page(view):
    page = view.vis.static_html()
    assert page.startswith("<!DOCTYPE html>")
    assert dict(take_apart(embedded(page, "scene"))) == view.channel.log


# ---- shared by a site ----------------------------------------------------------------------------------


def shared(view):
    """The rows of a placeholder's scene, and its objects by name."""
    placeholder = view.page_html()
    scene, objects = (re.search(rf'data-{name}="([^"]*)"', placeholder)[1] for name in ("scene", "objects"))
    return take_apart(scene), html_export.unpacked_objects(objects)


def test_a_placeholder_holds_its_scene_and_names_its_objects_by_content():
    view = View((0.1, 0.2, 0.3, 0.4))
    view.ghosts([omx.HOME, omx.ZERO])
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
