"""Ways without times: through their points, with the derivatives that they claim, corners cut by what was asked."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import omx
from omx.errors import BadInput, PathBlocked
from omx.motion import in_joints, rounded, spline_path

POINTS = np.array([omx.ZERO, (0.5, -0.5, 0.3, 0.4), (1.0, 0.2, -0.3, 0.2), (1.4, -0.4, 0.6, -0.2)])
CORNERS = np.array([(150, -80, 150, 0), (200, 80, 150, 0), (220, 0, 250, 0.3), (180, -60, 200, 0)], dtype=float)


def assert_derivatives(path):
    """Central differences, inside; where the third derivative jumps they are good to a step."""
    for value, slope in ((path.q, path.dq), (path.dq, path.ddq)):
        found = np.gradient(value, path.s, axis=0)[2:-2]
        np.testing.assert_allclose(found, slope[2:-2], atol=1e-2 * np.abs(slope).max())


def test_a_spline_goes_through_its_points_and_ends_straight():
    path = spline_path(POINTS, samples=3001)
    assert_derivatives(path)
    for point in POINTS:
        assert np.abs(path.q - point).max(axis=1).min() < 1e-3
    np.testing.assert_allclose(path.ddq[[0, -1]], 0, atol=1e-12)
    assert path.s[-1] == pytest.approx(np.linalg.norm(np.diff(POINTS, axis=0), axis=1).sum())


units = (
    st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda v: np.linalg.norm(v) > 0.1).map(lambda v: v / np.linalg.norm(v))
)


@settings(deadline=None)
@given(units, units, st.floats(5, 300), st.floats(0.1, 30))
def test_a_corner_is_cut_by_exactly_the_error_or_by_what_its_legs_allow(before, after, length, error):
    """Equal legs and three samples: the one in the middle belongs to the corner."""
    corner, bend = np.array([150.0, 20.0, 100.0]), np.linalg.norm(after - before)
    if bend < 1e-6:
        return
    corners = np.zeros((3, 4))
    corners[:, :3] = corner - length * before, corner, corner + length * after
    way = rounded(corners, error, samples=3)
    np.testing.assert_allclose(way.q[[0, -1]], corners[[0, -1]], atol=1e-9)
    cut = np.linalg.norm(way.q[1, :3] - corner)
    assert cut == pytest.approx(min(error, 3 / 16 * bend * length / 2), abs=1e-9)


def test_a_rounded_way_bends_without_a_jump_and_its_lines_are_straight():
    way = rounded(CORNERS, 5.0, samples=8001)
    assert_derivatives(way)
    assert np.abs(np.diff(way.ddq[:, :3], axis=0)).max() < 0.01 * np.abs(way.ddq[:, :3]).max()
    assert np.count_nonzero(np.abs(way.ddq[:, :3]).max(axis=1) == 0) > 3000


def test_the_joints_follow_the_tool_with_its_derivatives():
    way = rounded(CORNERS, 5.0, samples=2001)
    path = in_joints(way, omx.HOME)
    np.testing.assert_allclose(omx.pose(path.q), way.q, atol=1e-9)
    assert_derivatives(path)


def test_a_way_out_of_reach_says_how_far_it_gets():
    with pytest.raises(PathBlocked) as caught:
        in_joints(rounded([(200, 0, 200, 0), (500, 0, 200, 0)], 5.0), omx.HOME)
    assert 0.3 < caught.value.fraction < 0.7


@pytest.mark.parametrize(
    ("attempt", "message"),
    [
        (lambda: spline_path([omx.ZERO]), "at least two"),
        (lambda: spline_path([omx.ZERO, omx.ZERO]), "the same"),
        (lambda: spline_path(POINTS, samples=2), "samples"),
        (lambda: rounded(CORNERS, 0.0), "error"),
        (lambda: rounded([(1, 2, 3, 0), (1, 2, 3, 1)], 1.0), "one place"),
        (lambda: in_joints(CORNERS, omx.HOME), "Path of the tool"),
    ],
)
def test_what_is_no_way_is_refused(attempt, message):
    with pytest.raises(BadInput, match=message):
        attempt()
