"""Scenes on pages: a mark holds what a cell told of a scene, less what many scenes hold, which the script has once."""

import html
import json
import re

import pytest

import omx
from book.chapters.normalise import normalise
from book.publish import deck, runs, scenes
from omx.display.panels import JointPanel
from omx.display.viewer import View
from tests.helpers.chapter import chapter, code
from tests.helpers.scenes import take_apart


def told_of(view):
    """What a cell's output says of a scene, after its way through a message and a file."""
    return json.loads(json.dumps(view.page_data()))


def output_of(told):
    return {"output_type": "display_data", "metadata": {}, "data": {"text/plain": "shown", scenes.SCENE: told}}


def held(text):
    """The rows of the scene in a mark, and its own objects by their names."""
    scene, own = (re.search(rf'data-{name}="([^"]*)"', text)[1] for name in ("scene", "objects"))
    return take_apart(scene), {name: data for (name,), data in take_apart(own).items()}


def test_a_mark_holds_its_scene_and_names_its_objects_by_content():
    view = View((0.1, 0.2, 0.3, 0.4))
    view.ghosts([omx.HOME, omx.ZERO])
    scene, own = held(scenes.html_of(told_of(view)))
    assert {key: own.get(data, data) for key, data in scene.items()} == view.channel.log
    assert [*scene] == [*view.channel.log], "commands are replayed in their order"
    assert own == {name: data for (name,), data in scenes.objects(told_of(view)).items()}
    _, other = held(scenes.html_of(told_of(View((0.3, 0.2, 0.1, 0.0)))))
    assert other.keys() < own.keys(), "another pose is the same arm"


def test_words_of_a_scene_cannot_leave_its_mark():
    told = {**told_of(View()), "title": '"><b>', "config": {"words": "'\"><b>", "chain": [None, -0.5]}}
    text = scenes.html_of(told)
    assert text.count("<") == 2
    assert json.loads(html.unescape(re.search(r"data-config='([^']*)'", text)[1])) == told["config"]
    panel = {"title": "'<i>\"", "panel": {"words": "'<i>\""}}
    assert re.findall(r"<\w+", scenes.html_of(panel)) == ["<div", "<p"]
    assert json.loads(html.unescape(re.search(r'data-panel="([^"]*)"', scenes.html_of(panel))[1])) == panel["panel"]


def test_the_pages_script_holds_what_it_is_given():
    common = scenes.objects(told_of(View()))
    values = json.loads(re.match(r"const OMX_VIEW = (\{.*\});\n", scenes.page_script(common))[1])
    assert take_apart(values["stock"]) == common
    assert scenes.page_script(common) == scenes.page_script(common)


@pytest.fixture
def kept(tmp_path, monkeypatch):
    """The path of a chapter, and the folder of its kept run, whose last cell shows two scenes and a live figure."""
    shown = [View(omx.HOME), View(omx.ZERO)]
    shown[1].label("mine", "only here", (0, 0, 100))
    outputs = [output_of(told_of(view)) for view in shown]
    outputs.append(output_of({"title": "A figure", "panel": {"kind": "figure"}}))
    notebook = normalise({"cells": [*chapter(), code("view", outputs=outputs)], "nbformat": 4})
    assert not notebook["cells"][-1]["outputs"], "the normaliser stores no scenes"
    path, folder = tmp_path / "07-lines.ipynb", tmp_path / "kept"
    folder.mkdir()
    path.write_text(json.dumps(notebook))
    notebook["cells"][-1]["outputs"] = outputs
    (folder / path.name).write_text(json.dumps(notebook))
    monkeypatch.setattr(runs, "chapters", lambda: [path])
    return path, folder, shown


def test_what_two_scenes_hold_goes_to_the_script_once(kept):
    """The scenes of the kept runs give up their common objects, and nothing is lost."""
    path, folder, shown = kept
    runs.gather(folder)
    stock = {name: data for (name,), data in runs.stock(folder).items()}
    *marks, figure = (output["data"]["text/html"] for output in runs.merged(path, folder)["cells"][-1]["outputs"])
    assert [len(held(mark)[1]) for mark in marks] == [0, 1]
    for mark, view in zip(marks, shown, strict=True):
        scene, own = held(mark)
        assert not stock.keys() & own.keys()
        assert {key: {**stock, **own}.get(data, data) for key, data in scene.items()} == view.channel.log
    assert figure.endswith("<p>A figure</p></div>")


def test_a_robots_panel_says_what_is_missing_on_a_page():
    told = JointPanel().page_data()
    cells = [code("panel", outputs=[*scenes.as_html([output_of({**told, "robot": True}), output_of(told)])])]
    robots, plain = (output["data"]["text/html"] for output in cells[0]["outputs"])
    assert "hold-to-move" in robots
    assert "hold-to-move" not in plain
    assert deck.sections({"cells": cells}).count("hold-to-move") == 1
