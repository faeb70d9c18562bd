"""The exact section: every sampled tip is inside, the arm draws every arc, Green and Pappus agree with counting."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import omx
from omx.analysis import workspace
from omx.hardware.safety import Guard

LOW, HIGH = np.array(omx.LIMITS).T
WHOLE_TURN = 2 * math.pi


def random_joints(count, seed=0, limits=omx.LIMITS):
    low, high = np.array(limits).T
    return np.random.default_rng(seed).uniform(low, high, (count, 4))


def tips_in_plane(q, geometry=omx.COURSE):
    """(r, z) of the tip with q1 = 0."""
    q = np.array(q)
    q[:, 0] = 0.0
    return omx.pose(q, geometry)[:, [0, 2]]


def random_points(count, seed=0, size=500.0):
    return np.random.default_rng(seed).uniform(-size, size, (count, 2))


@st.composite
def arms(draw):
    """Lengths (whole mm) and limits (whole hundredths of a rad) of an arm that nobody built."""
    lengths = {name: float(draw(st.integers(20, 250))) for name in ("L1", "L2", "L3", "L4")}
    limits = [(-math.pi, math.pi)]
    for _ in range(3):
        middle, half = draw(st.integers(-150, 150)), draw(st.integers(5, 300))
        limits.append(((middle - half) / 100, (middle + half) / 100))
    return omx.COURSE.replace("drawn", **lengths, delta=draw(st.integers(-60, 60)) / 100), tuple(limits)


# ---- the arcs --------------------------------------------------------------------------------------------


def test_there_are_about_twenty_arcs():
    assert len(workspace.critical_arcs()) == 20


def test_every_arc_is_drawn_by_the_arm():
    for arc in workspace.critical_arcs():
        assert workspace.reaches(arc.points(5.0)).all(), arc


def test_arc_distance_is_the_distance_to_its_points():
    arc = workspace.Arc((10.0, -20.0), 100.0, 0.4, 4.0)
    points = random_points(200)
    near = np.linalg.norm(points[:, None] - arc.points(0.05), axis=2).min(axis=1)
    assert arc.distance(points) == pytest.approx(near, abs=0.03)


def test_a_mirrored_arc_holds_the_mirrored_points():
    arc = workspace.Arc((10.0, -20.0), 100.0, 0.4, 4.0)
    assert np.allclose(arc.mirrored().points(1.0)[::-1] * (-1, 1), arc.points(1.0))


# ---- reach -----------------------------------------------------------------------------------------------


def test_reach_agrees_with_the_inverse_at_many_pitches():
    """Where some pitch is legal the point is reached; where none of 1440 is, it may be reached with a narrow choice."""
    points = random_points(1500)
    pitches = np.linspace(-math.pi, math.pi, 1440, endpoint=False)
    poses = np.zeros((len(points), len(pitches), 4))
    poses[..., 0], poses[..., 2], poses[..., 3] = points[:, :1], points[:, 1:], pitches
    q, _, legal = omx.ik_batch(poses.reshape(-1, 4))
    in_front = np.abs(q[..., 0]) < 1.0  # the branches with q1 = 0
    found = (legal & in_front).any(axis=1).reshape(poses.shape[:2]).any(axis=1)
    reached = workspace.reaches(points)
    assert not (found & ~reached).any()
    assert (reached & ~found).mean() < 0.01


@given(arms())
@settings(max_examples=25, deadline=None)
def test_every_tip_of_any_arm_is_reached(arm):
    geometry, limits = arm
    assert workspace.reaches(tips_in_plane(random_joints(2000, 1, limits), geometry), geometry, limits).all()


@pytest.mark.parametrize("points", [[1.0, 2.0, 3.0], [[math.nan, 0.0]], "here", []])
def test_bad_points_are_refused(points):
    with pytest.raises(omx.BadInput, match="r and z"):
        workspace.reaches(points)


# ---- the section -----------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def course():
    return workspace.section()


@given(arms())
@settings(max_examples=25, deadline=None)
def test_the_boundary_of_any_arm_closes_around_what_it_reaches(arm):
    geometry, limits = arm
    section = workspace.section(geometry, limits)
    points = random_points(1000)
    sure = section.distance(points) > 1e-3
    assert (section.contains(points) == workspace.reaches(points, geometry, limits))[sure].all()


def test_four_million_tips_are_inside_and_leave_no_gap(course):
    """At most a handful of tips outside; no cell of 5 mm without a tip lies further than 3 mm from an arc."""
    outside = 0
    for seed in range(8):
        outside += np.count_nonzero(~workspace.reaches(tips_in_plane(random_joints(500_000, seed))))
    assert outside <= 5
    counts = workspace.count_plane(4_000_000, seed=1, step=5.0)
    r, z = np.meshgrid(*counts.axes, indexing="ij")
    unhit = np.column_stack((r[counts.counts == 0], z[counts.counts == 0]))
    unhit = unhit[course.contains(unhit)]
    to_arc = np.min([arc.distance(unhit) for arc in course.critical], axis=0)
    print(f"{outside} tips outside, {len(unhit)} cells of 5 mm unhit, the furthest {to_arc.max():.2f} mm from an arc")
    assert to_arc.max() < 3.0


def test_the_outermost_points_are_those_of_the_straight_arm(course):
    _, r_high, _, z_high = course.bounds
    reach = omx.COURSE.L2 + omx.COURSE.L3 + omx.COURSE.L4
    assert r_high == pytest.approx(reach)
    assert z_high == pytest.approx(omx.COURSE.L1 + reach)


def test_bounds_are_those_of_the_polygons(course):
    points = np.vstack(course.polygons(0.2))
    r_low, r_high, z_low, z_high = course.bounds
    assert [r_low, z_low] == pytest.approx(points.min(axis=0), abs=1e-3)
    assert [r_high, z_high] == pytest.approx(points.max(axis=0), abs=1e-3)


def test_area_and_moment_agree_with_counting_cells(course):
    r, _, inside = course.fill(0.5)
    assert course.area == pytest.approx(0.25 * inside.sum(), rel=2e-4)
    assert course.moment == pytest.approx(0.25 * (np.abs(r) * inside).sum(), rel=2e-4)


def test_area_and_holes_agree_with_the_polygons(course):
    def shoelace(p):
        r, z = p.T
        return 0.5 * float(np.sum(r * np.roll(z, -1) - z * np.roll(r, -1)))

    outer, *rest = (shoelace(p) for p in course.polygons(0.05))
    assert outer > 0 > max(rest)
    assert course.holes == pytest.approx([-area for area in rest], rel=1e-5)
    assert course.area == pytest.approx(outer + sum(rest), rel=1e-6)


def test_there_is_one_hole_of_some_cm2_near_the_axis(course):
    assert len(course.holes) == 1
    assert 700 < course.holes[0] < 900
    hole = course.polygons()[-1]
    assert np.abs(hole[:, 0]).max() < 40


def test_fill_decides_each_cell_at_its_centre(course):
    r, z, inside = course.fill(7.0)
    points = np.stack(np.meshgrid(r, z), axis=-1)
    assert (inside == workspace.reaches(points)).all()


# ---- volume ----------------------------------------------------------------------------------------------


def turned_limits(low, high):
    return ((low, high), *omx.LIMITS[1:])


def counted_volume(limits, step=5.0):
    """The reachable space (mm3), counted: at each (r, z), the share of the turn that front or back can face."""
    section = workspace.section(limits=limits)
    r, z, _ = section.both_sides.fill(step)
    front = section.contains(np.stack(np.meshgrid(r, z), axis=-1))
    back = front[:, ::-1]
    angles = (np.arange(7200) + 0.5) * WHOLE_TURN / 7200
    low, high = limits[0]
    ahead, behind = (np.mod(angles - low - turn, WHOLE_TURN) < high - low for turn in (0.0, math.pi))
    width = front * ahead.mean() + back * behind.mean() - front * back * (ahead & behind).mean()
    return float((width * WHOLE_TURN * np.maximum(r, 0)).sum() * step**2)


@pytest.mark.parametrize("turn", [(-math.pi, math.pi), (-1.5, 1.5), (-2.8, 2.8), (0.0, 0.5), (-0.5, 3.0)])
def test_volume_agrees_with_counting(turn):
    limits = turned_limits(*turn)
    assert workspace.section(limits=limits).volume == pytest.approx(counted_volume(limits), rel=3e-3)


def test_a_full_turn_sweeps_the_mirrored_section(course):
    assert course.volume == pytest.approx(math.pi * course.both_sides.moment)


def test_more_turning_never_reaches_less():
    volumes = [workspace.section(limits=turned_limits(-half, half)).volume for half in (0.5, 1.0, 1.6, 2.0, 2.8, 3.1)]
    assert np.all(np.diff(volumes) > 0)


def test_limits_of_a_turn_or_more_are_refused():
    with pytest.raises(omx.BadInput, match="q3"):
        workspace.section(limits=(*omx.LIMITS[:2], (-4.0, 4.0), omx.LIMITS[3]))


# ---- clearance -------------------------------------------------------------------------------------------


def test_clearance_is_that_of_the_guard():
    q = random_joints(500)
    gaps = [Guard().clearance(row)[0] for row in q.tolist()]
    assert workspace.clearance(q) == pytest.approx(gaps, abs=1e-9)
    assert (workspace.clear(q) == (np.array(gaps) >= 0)).all()


def test_without_a_table_there_is_no_less_room():
    q = random_joints(500)
    with_table, without = workspace.clearance(q), workspace.clearance(q, table=None)
    assert (without >= with_table).all()
    assert (without > with_table).any()
