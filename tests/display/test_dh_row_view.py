"""One DH row in 3-D: its frames stand where the link matrix says, and its marks come and go with its parameters."""

import html
import json
import math
import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import omx
from omx.display.panels import RowPanel
from omx.display.viewer import RowView
from omx.display.viewer.dh_row_view import places
from tests.helpers.scenes import decoded, objects, placed

angles = st.floats(-math.pi, math.pi)
lengths = st.floats(-150, 150)
NOTES = "/meshcat/notes"
FULL = (1.2, 90.0, 110.0, 0.9)


def marks(view):
    """The names of the marks that the scene shows."""
    names = {path.removeprefix(f"{NOTES}/").split("/")[0] for path in objects(view.channel, NOTES)}
    commands = decoded(view.channel)
    told = {name: commands.get(("set_property", f"{NOTES}/{name}", "visible"), {}) for name in names}
    return {name for name in names if told[name].get("value", True)}


@given(st.tuples(angles, lengths, lengths, angles))
@settings(max_examples=40, deadline=None)
def test_the_frames_stand_where_the_link_matrix_says(row):
    view = test_the_frames_stand_where_the_link_matrix_says.view
    view.row = row
    np.testing.assert_allclose(placed(view.channel, f"{NOTES}/first"), np.eye(4), atol=1e-9)
    np.testing.assert_allclose(placed(view.channel, f"{NOTES}/last"), omx.Chain([omx.DHRow(*row)]).fk([0.0]), atol=1e-6)


test_the_frames_stand_where_the_link_matrix_says.view = RowView()


def tip(nodes, path, point):
    """Where a point (3,) of a mark's part is, seen from frame {0}, mm."""
    name, _, _ = path.partition("/")
    return (nodes[name] @ nodes[path] @ (*point, 1.0))[:3]


@given(st.tuples(angles, lengths, lengths, angles))
@settings(max_examples=60, deadline=None)
def test_the_marks_lead_from_frame_to_frame(row):
    """Each arrow ends where the next move begins, and each arc at the axis that was turned."""
    theta, d, a, _ = row
    nodes, _ = places(row)
    lifted, shifted, end = (omx.Chain([omx.DHRow(*r)]).fk([0.0]) for r in ((theta, d, 0, 0), (theta, d, a, 0), row))
    np.testing.assert_allclose(tip(nodes, "d/head", (0, 0, 10.4)), lifted[:3, 3], atol=5e-3)
    np.testing.assert_allclose(tip(nodes, "a/head", (0, 0, 10.4)), shifted[:3, 3], atol=5e-3)
    np.testing.assert_allclose(tip(nodes, "theta/head", (75, 0, 0)), 75 * end[:3, 0], atol=1e-9)
    np.testing.assert_allclose(tip(nodes, "alpha/head", (75, 0, 0)), shifted[:3, 3] + 75 * end[:3, 2], atol=1e-9)
    for matrix in nodes.values():
        assert np.linalg.det(matrix[:3, :3]) > 0, "a mirrored mark"


@given(angles)
@settings(max_examples=60, deadline=None)
def test_the_pieces_of_an_arc_follow_each_other_up_to_its_head(angle):
    nodes, shown = places((angle, 0, 0, 0))
    at = 0.0
    for size in (128, 64, 32, 16, 8, 4, 2, 1):
        if shown[f"theta/{size}"]:
            piece = nodes[f"theta/{size}"]
            assert math.degrees(math.atan2(piece[1, 0], piece[0, 0])) % 360 == pytest.approx(at % 360, abs=1e-9)
            at += size
    assert -3.0 <= at - abs(math.degrees(angle)) <= 0 or abs(math.degrees(angle)) < 3


@pytest.mark.parametrize(("index", "name"), list(enumerate(("theta", "d", "a", "alpha"))))
def test_a_parameter_that_is_zero_has_no_mark(index, name):
    assert name in marks(RowView(FULL))
    without = [0.0 if i == index else value for i, value in enumerate(FULL)]
    view = RowView(FULL)
    view.row = without
    assert marks(view) == marks(RowView(without))
    assert name not in marks(view)
    assert {"theta", "d", "a", "alpha"} - marks(view) == {name}


def test_it_tells_the_row_in_words():
    assert repr(RowView(FULL)) == "DH row: theta = 68.8 deg, d = 90.0 mm, a = 110.0 mm, alpha = 51.6 deg"


@pytest.mark.parametrize("row", [None, (1, 2, 3), (1, 2, 3, math.nan), "abcd", (1, 2, 3, 4, 5)])
def test_what_is_no_row_is_refused(row):
    with pytest.raises(omx.BadInput, match=r"theta \(rad\), d \(mm\), a \(mm\), alpha \(rad\), shape \(4,\)"):
        RowView(row)


def test_sliders_move_the_frames_and_the_other_way_round():
    panel = RowPanel(FULL)
    assert [slider.description for slider in panel.sliders] == ["theta", "d", "a", "alpha"]
    panel.sliders[0].value = 30.0
    panel.sliders[1].value = -40.0
    assert panel.view.row.theta == pytest.approx(math.radians(30))
    np.testing.assert_allclose(placed(panel.view.channel, f"{NOTES}/last")[2, 3], -40)
    panel.row = omx.DHRow(0.5, 10, 20, 0.1)
    assert [round(slider.value) for slider in panel.sliders] == [29, 10, 20, 6]
    assert panel.view.row.d == 10


def test_the_panel_shows_the_link_matrix():
    panel = RowPanel((0, 0, 0, 0))
    panel.row = FULL
    numbers = [f"{omx.Chain([omx.DHRow(*FULL)]).fk([0.0])[0, 3]:.1f}", f"{90.0:.1f}"]
    assert all(number in panel._text.value for number in numbers)


def test_without_a_kernel_a_page_is_told_all_that_its_sliders_need(monkeypatch):
    monkeypatch.setenv("OMX_VIEW", "shared")
    text = RowPanel(FULL)._repr_mimebundle_()["text/html"]
    data = json.loads(html.unescape(re.search(r'data-panel="([^"]*)"', text)[1]))
    assert data["kind"] == "row"
    assert data["q"] == pytest.approx(FULL)
    assert [slider[0] for slider in data["sliders"]] == ["theta", "d", "a", "alpha"]
    assert "omx-scene" in text
