"""The servo's set-point: continuous, on time, within its limits, and arriving where it should."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from omx.hardware.simulator import profile

ticks = st.floats(-4000, 4000)
speeds = st.floats(-3000, 3000)
cruises = st.floats(20, 3000)
accelerations = st.floats(50, 20000)


def milliseconds(low, high):
    return st.integers(low, high).map(lambda ms: ms / 1000)


def samples(trajectory, start, n=400):
    """(time, position, speed) from `start` to a little after the end."""
    span = trajectory.end - start + 0.01
    return [(start + span * i / n, *trajectory.at(start + span * i / n)) for i in range(n + 1)]


def joints(trajectory):
    """Position and speed just before and just after each change of piece, and the end."""
    for piece in trajectory.pieces[1:]:
        yield trajectory.at(piece.start - 1e-9), trajectory.at(piece.start)
    yield trajectory.at(trajectory.end - 1e-9), trajectory.at(trajectory.end)


def close(a, b, scale):
    return abs(a - b) <= 1e-6 * max(1.0, scale)


@settings(deadline=None)
@given(ticks, speeds, ticks, cruises, accelerations)
def test_by_speed_starts_as_it_was_ends_at_the_goal_and_never_jumps(position, speed, goal, cruise, acceleration):
    trajectory = profile.by_speed(1.0, position, speed, goal, cruise, acceleration)
    if trajectory.pieces:
        p, v = trajectory.at(1.0)
        assert close(p, position, 4000)
        assert close(v, speed, 3000)
    for (p0, v0), (p1, v1) in joints(trajectory):
        assert abs(p0 - p1) <= 3000 * 2e-9 + 1e-6
        assert abs(v0 - v1) <= acceleration * 2e-9 + 1e-6
    assert trajectory.at(trajectory.end) == (goal, 0.0)


@settings(deadline=None)
@given(ticks, ticks, cruises, accelerations)
def test_by_speed_keeps_to_its_speed_and_acceleration(position, goal, cruise, acceleration):
    trajectory = profile.by_speed(0.0, position, 0.0, goal, cruise, acceleration)
    assert all(abs(v) <= cruise * (1 + 1e-9) for _, _, v in samples(trajectory, 0.0))
    assert all(abs(piece.acceleration) <= acceleration * (1 + 1e-9) for piece in trajectory.pieces)


@settings(deadline=None)
@given(ticks, speeds, ticks, milliseconds(20, 20000), milliseconds(0, 10000))
def test_by_time_arrives_on_time_whatever_the_speed_was(position, speed, goal, total, ramp):
    trajectory = profile.by_time(5.0, position, speed, goal, total, ramp)
    assert trajectory.end == pytest.approx(5.0 + total)
    p, v = trajectory.at(trajectory.end - 1e-9)
    assert p == pytest.approx(goal, abs=0.05)
    if ramp > 0.01:
        assert trajectory.at(5.0) == pytest.approx((position, speed), abs=1e-6)
        assert abs(v) <= abs(trajectory.pieces[-1].acceleration) * 2e-9 + 1e-6  # 1 ns before the end


def test_the_manuals_times_for_a_trapezoid():
    # t1 = 64 V / A ms, t2 = 64 dPos / V ms, t3 = t1 + t2, in register units
    velocity, acceleration, distance = 100, 20, 2048
    unit_v, unit_a = 0.229 * 4096 / 60, 214.577 * 4096 / 3600
    trajectory = profile.by_speed(0.0, 0.0, 0.0, distance, velocity * unit_v, acceleration * unit_a)
    t1 = 0.064 * velocity / acceleration
    assert trajectory.shape == profile.TRAPEZOID
    assert trajectory.pieces[1].start == pytest.approx(t1, rel=2e-3)
    assert trajectory.end == pytest.approx(t1 + 0.064 * distance / velocity, rel=2e-3)


def test_cruise_speed_of_a_time_based_trapezoid():
    trajectory = profile.by_time(0.0, 0.0, 0.0, 1000.0, 2.0, 0.5)
    assert trajectory.at(1.0)[1] == pytest.approx(1000 / (2.0 - 0.5))


@pytest.mark.parametrize(
    ("trajectory", "shape"),
    [
        (profile.step(0, 100), profile.STEP),
        (profile.by_speed(0, 0, 0, 100, 50, 0), profile.RECTANGLE),
        (profile.by_speed(0, 0, 0, 100, 5000, 100), profile.TRIANGLE),
        (profile.by_speed(0, 0, 0, 1000, 50, 100), profile.TRAPEZOID),
        (profile.by_time(0, 0, 0, 100, 1, 0), profile.RECTANGLE),
        (profile.by_time(0, 0, 0, 100, 1, 9), profile.TRIANGLE),
        (profile.by_time(0, 0, 0, 100, 1, 0.2), profile.TRAPEZOID),
    ],
)
def test_shapes_have_the_manuals_names(trajectory, shape):
    assert trajectory.shape == shape


@settings(deadline=None)
@given(speeds, speeds, accelerations)
def test_velocity_mode_ramps_and_then_stays(speed, wanted, acceleration):
    trajectory = profile.to_speed(0.0, speed, wanted, acceleration)
    assert trajectory.at(0.0)[1] == pytest.approx(speed if speed != wanted else wanted)
    assert trajectory.at(1000.0)[1] == wanted
    assert trajectory.steady_from == pytest.approx(abs(wanted - speed) / acceleration)


def test_a_goal_behind_a_moving_set_point_turns_it_round_smoothly():
    trajectory = profile.by_speed(0.0, 0.0, 500.0, -100.0, 600.0, 1000.0)
    positions = [p for _, p, _ in samples(trajectory, 0.0)]
    assert max(positions) == pytest.approx(500**2 / 2000, rel=1e-3)  # its braking distance
    assert positions[-1] == -100.0
