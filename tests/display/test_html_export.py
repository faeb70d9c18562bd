"""Scenes without a kernel: nothing is fetched, nothing gets out of the frame, and the scene is all there."""

import base64
import gzip
import html
import json
import re

import pytest

import omx
from omx.display.viewer import View
from omx.display.viewer.assets import packed, viewer_source
from omx.display.viewer.scene import SCENE
from tests.helpers.scenes import take_apart


@pytest.fixture(scope="module")
def view():
    view = View()
    view.frames(4)
    view.label("w", 'a "quoted" <b>word</b>', (0, 0, 100))
    view.animate([omx.HOME, omx.ZERO])
    return view


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
    assert take_apart(embedded(page, "scene")) == view.channel.log
    source = gzip.decompress(base64.b64decode(embedded(page, "viewer"))).decode()
    assert source.startswith(viewer_source())


def test_an_animation_is_in_it(view):
    assert ("set_animation", "", "") in take_apart(embedded(inner_page(view.static_html()), "scene"))


def test_words_in_a_scene_cannot_end_the_script(view):
    page = inner_page(view.static_html())
    assert page.count("<script") == page.count("</script>") == len(re.findall(r"<script[^>]*>[^<]", page))


def test_the_same_scene_gives_the_same_bytes():
    assert View().static_html() == View().static_html()


def test_visualizer_static_html_is_a_whole_page(view):
    page = view.vis.static_html()
    assert page.startswith("<!DOCTYPE html>")
    assert take_apart(embedded(page, "scene")) == view.channel.log


# ---- in cells ------------------------------------------------------------------------------------------


def test_a_cell_shows_data_where_a_page_is_built(monkeypatch):
    monkeypatch.setenv("OMX_VIEW", "data")
    view = View()
    shown = view._repr_mimebundle_()
    told = json.loads(json.dumps(shown.pop(SCENE), allow_nan=False))
    assert shown == {"text/plain": repr(view)}
    assert (told["title"], told["height"]) == (repr(view), view.height)
    assert take_apart(told["log"]) == view.channel.log
    assert view._widget is None


def test_the_packed_viewer_is_named_by_content_and_small():
    key, data = packed()
    assert re.fullmatch(r"[0-9a-f]{16}", key)
    assert len(data) < 250_000
