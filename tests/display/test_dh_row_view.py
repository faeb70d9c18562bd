"""One DH row in 3-D: its frames stand where the link matrix says, and its marks come and go with its parameters."""

import json
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import omx
from omx.display.panels import RowPanel
from omx.display.viewer import RowView
from tests.helpers.scenes import bounds, decoded, objects, placed

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


@given(st.tuples(angles, lengths, lengths, angles))
@settings(max_examples=40, deadline=None)
def test_the_marks_lead_from_frame_to_frame(row):
    """Each arrow ends where the next move begins; each arc lies about its axis, on the side to which it turns."""
    view = test_the_frames_stand_where_the_link_matrix_says.view
    view.row = row
    shown = marks(view)
    for name, length in (("d", row[1]), ("a", row[2])):
        assert (name in shown) == (f"{name}_name" in shown) == (abs(length) >= 1)
        if name in shown:
            (low, high), z = bounds(view.channel, f"{NOTES}/{name}"), 2
            assert (low[z], high[z]) == pytest.approx(sorted((0, length)), abs=0.01)
            start = omx.Chain([omx.DHRow(row[0], row[1] if name == "a" else 0, 0, 0)]).fk([0.0])
            frame = placed(view.channel, f"{NOTES}/{name}")
            np.testing.assert_allclose(frame[:3, 3], start[:3, 3], atol=1e-6)
            np.testing.assert_allclose(frame[:3, 2], start[:3, 0 if name == "a" else 2], atol=1e-9)
    for name, angle in (("theta", row[0]), ("alpha", row[3])):
        if name in shown:
            low, high = bounds(view.channel, f"{NOTES}/{name}")
            inside, outside = (low[1], high[1]) if angle < 0 else (-high[1], -low[1])
            assert inside <= -min(75 * abs(math.sin(angle)), 75) + 1.2 or abs(angle) > math.pi / 2
            assert outside < 3.0
            assert abs(low[2]) < 2.7
            assert abs(high[2]) < 2.7


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


def test_without_a_kernel_a_page_is_told_all_that_its_sliders_need():
    told = RowPanel(FULL).page_data()
    data = json.loads(json.dumps(told["panel"], allow_nan=False))
    assert data["kind"] == "row"
    assert data["q"] == pytest.approx(FULL)
    assert [slider[0] for slider in data["sliders"]] == ["theta", "d", "a", "alpha"]
    assert told["config"]["row"]
