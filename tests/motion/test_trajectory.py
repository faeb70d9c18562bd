"""Trajectories: scalings start and end at rest, derivatives are derivatives, lines are straight or refused."""

import numpy as np
import pytest

import omx
from omx.errors import BadInput, JointLimit, PathBlocked, Unreachable
from omx.motion.trajectory import cubic, joint_move, line, quintic, trapezoid

SCALINGS = {"cubic": cubic, "quintic": quintic, "trapezoid": trapezoid(0.2), "triangle": trapezoid(0.5)}


@pytest.fixture(params=SCALINGS.values(), ids=SCALINGS.keys())
def scaling(request):
    return request.param


def test_a_scaling_goes_from_0_to_1_and_never_back(scaling):
    s, ds, _ = scaling(np.linspace(0, 1, 1001))
    assert s[0] == pytest.approx(0, abs=1e-15)
    assert s[-1] == pytest.approx(1, abs=1e-15)
    assert ds[0] == pytest.approx(0, abs=1e-15)
    assert ds[-1] == pytest.approx(0, abs=1e-15)
    assert (np.diff(s) > 0).all()


def test_the_derivatives_of_a_scaling_are_its_derivatives(scaling):
    u, h = np.linspace(0.013, 0.987, 76), 1e-6
    s_after, ds_after, _ = scaling(u + h)
    s_before, ds_before, _ = scaling(u - h)
    _, ds, dds = scaling(u)
    np.testing.assert_allclose(ds, (s_after - s_before) / (2 * h), atol=1e-6)
    np.testing.assert_allclose(dds, (ds_after - ds_before) / (2 * h), atol=1e-4)


def test_only_the_quintic_starts_without_a_jerk_of_the_hand():
    assert quintic(0.0)[2] == 0
    assert cubic(0.0)[2] == 6


def test_a_trapezoid_cruises_at_the_speed_of_the_servo_profile():
    _, ds, _ = trapezoid(0.25)(0.5)  # cruise speed = way / (t3 - t1), with t1 = 0.25 t3
    assert ds == pytest.approx(1 / 0.75)


def test_a_joint_move_starts_and_ends_where_it_should(scaling):
    q0, q1 = np.array(omx.HOME), np.array([0.5, 0.2, -0.4, 0.9])
    move = joint_move(q0, q1, 2.0, scaling)
    np.testing.assert_allclose(move.q[0], q0)
    np.testing.assert_allclose(move.q[-1], q1, atol=1e-12)
    np.testing.assert_allclose(move.at(99.0), q1, atol=1e-12)
    assert move.seconds == 2.0


def test_velocities_integrate_to_the_way(scaling):
    move = joint_move(omx.ZERO, [1.0, -0.5, 0.25, 0.75], 3.0, scaling, rate=1000)
    way = np.trapezoid(move.qd, move.t, axis=0)
    np.testing.assert_allclose(way, [1.0, -0.5, 0.25, 0.75], atol=2e-6)


def test_a_point_to_point_move_is_not_a_straight_line_of_the_tool_but_line_is():
    q0 = np.array(omx.solve_ik([150, -80, 150, 0]))
    target = [200, 120, 220, 0.0]
    q1 = np.array(omx.solve_ik(target, start=q0))
    assert _distance_to_line(joint_move(q0, q1, 2.0).poses()) > 5.0
    assert _distance_to_line(line(q0, target, 2.0).poses()) < 1e-9


def test_the_velocities_of_a_line_are_the_differences_of_its_angles():
    move = line(omx.HOME, [180, 60, 200, -0.3], 2.0, rate=500)
    np.testing.assert_allclose(np.gradient(move.q, move.t, axis=0)[1:-1], move.qd[1:-1], atol=2e-4)


@pytest.mark.parametrize(
    ("target", "reason"),
    [([600, 0, 204, 0], Unreachable), ([-200, 0, 200, 0], omx.OmxError), ([60, 0, 60, 0], JointLimit)],
)
def test_a_line_that_cannot_be_followed_says_how_far_it_gets_and_why(target, reason):
    with pytest.raises(PathBlocked) as caught:
        line(omx.HOME, target, 2.0)
    error = caught.value
    assert 0 <= error.fraction < 1
    assert isinstance(error.reason, reason)
    np.testing.assert_allclose(error.reached, omx.pose(error.q))


def test_a_line_refuses_a_joint_that_would_be_too_fast():
    with pytest.raises(PathBlocked, match="deg/s"):
        line(omx.HOME, [180, 60, 200, -0.3], 0.1, max_speed=np.radians(60))


def test_a_line_turns_the_pitch_the_short_way_round():
    """From 174.8 deg to -176.7 deg it is 8.6 deg, over the half turn, and not 351 deg back."""
    a, b = (0, -1.2, -1, -0.85), (0, -1.2, -1, -1.0)
    move = line(a, omx.pose(b), 2)
    np.testing.assert_allclose(move.q[-1], b, atol=1e-9)
    turned = np.unwrap(move.poses()[:, 3])
    assert np.ptp(turned) == pytest.approx(abs(np.degrees(0.15)) * np.pi / 180, abs=1e-9)
    assert line(a, np.add(omx.pose(b), (0, 0, 0, 2 * np.pi)), 2).q[-1] == pytest.approx(b)


def test_half_a_turn_of_the_pitch_goes_up():
    free = [(-np.inf, np.inf)] * 4
    start = omx.solve_ik([150, 0, 120, -np.pi / 2], limits=free)
    move = line(start, [150, 0, 120, np.pi / 2], 3.0, limits=free)
    assert np.ptp(np.unwrap(move.poses()[:, 3])) == pytest.approx(np.pi)
    assert np.all(np.diff(np.unwrap(move.poses()[:, 3])) > -1e-9)


def test_joint_1_passes_behind_where_its_limits_allow_and_says_so_where_not():
    start = np.array(omx.solve_ik([-200, -20, 150, 0], start=(-3, 0, 0, 0)))
    with pytest.raises(PathBlocked, match=r"q1 is at its limit, and would have to turn \d+ deg back"):
        line(start, [-200, 20, 150, 0], 3.0)
    around = line(start, [-200, 20, 150, 0], 3.0, limits=[(-6.2, 6.2), *omx.LIMITS[1:]])
    assert np.abs(np.diff(around.q[:, 0])).max() < 0.05
    assert around.q[-1, 0] < -np.pi


def test_a_line_from_outside_the_limits_names_the_joint():
    with pytest.raises(JointLimit, match=r"the line starts outside the limits: q2 = -85.95 deg"):
        line([0, -1.5001, 0.2, 0.3], [100, 0, 250, 0], 2)


@pytest.mark.parametrize("seconds", [0, -1, float("nan"), float("inf"), "2", None, True, [1, 2], 1e300])
def test_seconds_must_be_positive(seconds):
    with pytest.raises(BadInput, match="seconds"):
        joint_move(omx.ZERO, omx.HOME, seconds)


@pytest.mark.parametrize(
    ("attempt", "message"),
    [
        (lambda: line(omx.HOME, (200, 0, 150, 0), 1, limits=None), "`limits` must be 4 pairs"),
        (lambda: line(omx.HOME, (200, 0, 150, 0), 1, geometry=omx.HOME), "`geometry` must be a Geometry"),
        (lambda: line(omx.HOME, (200, 0, 150, 0), 1, max_speed=-1), "`max_speed`"),
        (lambda: joint_move(omx.ZERO, omx.HOME, 2, trapezoid), r"write `trapezoid\(\)`"),
        (lambda: joint_move(omx.ZERO, omx.HOME, 2, len), "`scaling` must turn"),
        (lambda: joint_move(omx.ZERO, omx.HOME, 2, rate=float("inf")), "`rate`"),
        (lambda: trapezoid(0.0), "`ramp`"),
        (lambda: joint_move(omx.ZERO, omx.HOME, 2).then(None), "`other` must be a Trajectory"),
    ],
)
def test_mistakes_are_named_and_not_called_blocked(attempt, message):
    with pytest.raises(BadInput, match=message):
        attempt()


def _distance_to_line(poses):
    """The largest distance (mm) of the tool from the straight line between its first and last position."""
    points = poses[:, :3] - poses[0, :3]
    way = points[-1] / np.linalg.norm(points[-1])
    return np.linalg.norm(points - np.outer(points @ way, way), axis=1).max()
