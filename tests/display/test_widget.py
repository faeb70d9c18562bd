"""The widget: the viewer travels once, a page gets the whole scene whenever it asks, stored notebooks still pass."""

import json
import os
import subprocess
import sys

import pytest

from omx.display.viewer import View
from omx.display.viewer import widget as widgets
from tests.helpers.scenes import decoded


def keys(content):
    return {tuple(key) for key in content["keys"]}


def test_a_cell_shows_a_widget_and_a_sentence():
    view = View()
    data = view._repr_mimebundle_()
    assert set(data) == {"text/plain", "application/vnd.jupyter.widget-view+json"}
    assert data["application/vnd.jupyter.widget-view+json"]["model_id"] == view.widget.model_id
    assert view._repr_mimebundle_() == data, "a second cell shows the same widget"


def test_the_viewer_travels_once():
    one, two = View().widget, View().widget
    assert one.bundle is two.bundle
    assert len(one.bundle.data) > 100_000
    assert one.key != two.key
    own = {name: value for name, value in one.get_state().items() if name not in ("scene", "bundle")}
    assert len(json.dumps(own, default=str)) < 30_000


def test_a_closed_bundle_is_made_again():
    widgets.bundle().close()
    assert View().widget.bundle.comm is not None


def test_a_page_that_asks_gets_the_scene_as_it_is_now():
    view = View()
    before = view.widget.get_state()["scene"]
    view.frames(1)
    view.q = (0.5, 0, 0, 0)
    after = view.widget.get_state()["scene"]
    assert keys(after) == set(view.channel.log)
    assert keys(after) - keys(before) == {k for k in view.channel.log if k[1] == "/meshcat/frames/1"}
    assert sum(after["sizes"]) == len(after["data"])


@pytest.fixture
def sent(monkeypatch):
    """A view whose widget's messages are collected."""
    view = View()
    messages = []
    monkeypatch.setattr(view.widget, "send", lambda content, buffers=None: messages.append(content))
    view.sent = messages
    return view


def test_changes_are_posted_and_numbered(sent):
    sent.q = (0.1, 0.2, 0.3, 0.4)
    sent.channel.flush()
    assert sent.sent[-1]["seq"] == sent.channel.seq == 1
    assert keys(sent.sent[-1]) == {("set_transform", f"/meshcat/arm/{i}", "") for i in range(5)}


def test_a_page_that_missed_something_gets_everything(sent):
    sent.q = (0.1, 0.2, 0.3, 0.4)
    sent.channel.flush()
    count = len(sent.sent)
    sent.widget._on_message(sent.widget, {"event": "hello", "seq": sent.channel.seq}, [])
    assert len(sent.sent) == count, "this page has it all"
    sent.widget._on_message(sent.widget, {"event": "hello", "seq": 0}, [])
    assert sent.sent[-1]["replay"]
    assert keys(sent.sent[-1]) == set(decoded(sent.channel))


def test_a_closed_widget_takes_no_messages(sent):
    sent.widget.close()
    sent.q = (0.1, 0.2, 0.3, 0.4)
    sent.channel.flush()
    assert sent.sent == []
    assert sent.q == (0.1, 0.2, 0.3, 0.4)


NOTEBOOK = """
from omx.display.panels import JointPanel, PosePanel
from omx.display.viewer import View
view = View()
view
---
view.q = (0.1, 0.2, 0.3, 0.4)
view.animate([view.q, (0, 0, 0, 0)])
---
JointPanel(view)
---
PosePanel()
"""


@pytest.mark.parametrize("wrong", [False, True], ids=["as stored", "another sentence"])
def test_a_stored_notebook_passes_strict_nbval(tmp_path, wrong):
    """Only the sentence is stored (the normaliser drops the widget's part); nbval compares it, and can fail."""
    outputs = [repr(View()), None, "JointPanel: " + repr(View((0.1, 0.2, 0.3, 0.4))), "PosePanel: " + repr(View())]
    cells = []
    for count, (source, text) in enumerate(zip(NOTEBOOK.strip().split("\n---\n"), outputs, strict=True), 1):
        text = text and text.replace("deg", "degrees") if wrong else text
        stored = {
            "output_type": "execute_result",
            "metadata": {},
            "execution_count": count,
            "data": {"text/plain": text},
        }
        cell = {"cell_type": "code", "id": f"c{count}", "metadata": {}, "source": source, "execution_count": count}
        cells.append({**cell, "outputs": [stored] if text else []})
    kernel = {"name": "python3", "display_name": "Python 3", "language": "python"}
    notebook = {"cells": cells, "metadata": {"kernelspec": kernel}, "nbformat": 4, "nbformat_minor": 5}
    path = tmp_path / "scene.ipynb"
    path.write_text(json.dumps(notebook), encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "--nbval", "--nbval-current-env", "-q", "-p", "no:cacheprovider", str(path)],
        cwd=tmp_path, env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}, capture_output=True, text=True,
        timeout=180, check=False,
    )  # fmt: skip
    assert (done.returncode == 0) is not wrong, done.stdout[-3000:]
