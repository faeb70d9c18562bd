"""One DH row in 3-D: its frames stand where the link matrix says, and its marks come and go with its parameters."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import omx
from omx.panel import RowPanel
from omx.view import RowView

from .scenes import objects, placed

angles = st.floats(-math.pi, math.pi)
lengths = st.floats(-150, 150)
NOTES = "/meshcat/notes"
FULL = (1.2, 90.0, 110.0, 0.9)


def marks(view):
    """The names of the marks that the scene holds."""
    return {path.removeprefix(f"{NOTES}/").split("/")[0] for path in objects(view.channel, NOTES)}


@given(st.tuples(angles, lengths, lengths, angles))
@settings(max_examples=40, deadline=None)
def test_the_frames_stand_where_the_link_matrix_says(row):
    view = test_the_frames_stand_where_the_link_matrix_says.view
    view.row = row
    np.testing.assert_allclose(placed(view.channel, f"{NOTES}/first"), np.eye(4), atol=1e-9)
    np.testing.assert_allclose(placed(view.channel, f"{NOTES}/last"), omx.Chain([omx.DHRow(*row)]).fk([0.0]), atol=1e-6)


test_the_frames_stand_where_the_link_matrix_says.view = RowView()


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
    with pytest.raises(omx.BadInput, match="four finite numbers"):
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


def test_without_a_kernel_the_scene_is_shown(monkeypatch):
    monkeypatch.setenv("OMX_VIEW", "shared")
    assert "omx-scene" in RowPanel(FULL)._repr_mimebundle_()["text/html"]
