"""Safety: what may not happen is refused with its reason, and what is refused names what would pass."""

import numpy as np
import pytest

import omx
from omx.arm import SPEED_CAP, STALL_TORQUE
from omx.errors import BadInput, Collision, JointLimit, TooFast
from omx.hardware.safety import Guard, stalled

RNG = np.random.default_rng(11)
INTO_THE_TABLE = (0.0, 1.2, -1.0, 1.0)


@pytest.mark.parametrize(
    "q_deg", [(0, 0, 0, 0), (15, -45, -60, 90), (-90, 15, 30, -45)], ids=["zero", "target 1", "target 2"]
)
def test_the_poses_of_the_labs_pass(q_deg):
    q = tuple(np.radians(q_deg))
    assert Guard().check(q, omx.HOME) == pytest.approx(q)


@pytest.mark.parametrize("pose", [(25, -100, 150, -60), (150, 80, 300, 0), (250, -115, 75, -45)])
def test_the_waypoints_of_lab_3_pass(pose):
    q = omx.solve_ik([*pose[:3], np.radians(pose[3])])
    Guard().check(q, omx.HOME)


def test_a_goal_outside_the_soft_limits_is_refused_with_the_nearest_legal_value():
    guard = Guard()
    with pytest.raises(JointLimit, match="q3") as caught:
        guard.check((0, 0, -1.49, 0), omx.ZERO)  # inside the hard limit of -1.5, beyond the soft one
    guard.check(caught.value.nearest, omx.ZERO)


def test_the_table_is_not_hit_and_the_last_safe_point_is_named():
    with pytest.raises(Collision) as caught:
        Guard().check(INTO_THE_TABLE, omx.HOME)
    assert caught.value.second == "table"
    Guard().check(caught.value.nearest, omx.HOME)


def test_without_a_table_the_same_goal_is_fine():
    Guard(table=None).check(INTO_THE_TABLE, omx.ZERO)


def test_a_collision_on_the_way_is_found_even_if_both_ends_are_clear():
    """Both hands are raised, one bent down and one bent up; between them the fingers sweep the table."""
    guard = Guard()
    start, goal = (0.0, 0.7, -0.6, 0.8), (0.0, 0.7, 0.8, -1.4)
    assert guard.clearance(start)[0] > 0
    assert guard.clearance(goal)[0] > 0
    with pytest.raises(Collision) as caught:
        guard.check(goal, start)
    assert caught.value.second == "table"
    guard.check(caught.value.nearest, start)


def test_an_arm_whose_parts_overlap_may_take_a_way_on_which_they_do_less():
    """The start counts as commanded, and as it sags: here the one is 36 mm deeper than the other."""
    goal, start = np.radians([15.12, -39.19, 34.94, 109.43]), np.radians([0, -34.14, 48.72, 106.48])
    assert Guard().check(goal, start) == pytest.approx(goal)
    with pytest.raises(Collision, match="fingers"):
        Guard().check(start, goal)


def test_an_arm_that_starts_outside_may_come_back_in_but_not_go_further_out():
    guard = Guard()
    outside = (0.0, -1.55, 0.5, 0.3)
    guard.check((0.0, -1.2, 0.5, 0.3), outside)
    guard.check((0.0, -1.52, 0.5, 0.3), outside)
    with pytest.raises(JointLimit, match="q2"):
        guard.check((0.0, -1.6, 0.5, 0.3), outside)
    with pytest.raises(Collision):
        guard.check((0.0, 1.3, -1.0, 1.0), INTO_THE_TABLE)


def test_the_speed_cap_sets_the_fewest_seconds():
    guard = Guard()
    fewest = guard.seconds(omx.ZERO, (0.0, np.radians(45), 0.0, 0.0))
    assert fewest == pytest.approx(1.0)  # 45 deg, 60 deg/s at the top of the trapezoid, 45 deg/s in the mean
    assert guard.seconds(omx.ZERO, (0.0, np.radians(45), 0.0, 0.0), 2.0) == 2.0
    with pytest.raises(TooFast, match=r"at least 1\.00 s") as caught:
        guard.seconds(omx.ZERO, (0.0, np.radians(45), 0.0, 0.0), 0.5)
    assert caught.value.speed == pytest.approx(np.radians(120))
    assert caught.value.cap == SPEED_CAP


@pytest.mark.parametrize("bad", [(0, 0, float("nan"), 0), (0, 0, 0), "home", None, (0, 0, 0, float("inf"))])
def test_nothing_but_four_finite_angles_gets_through(bad):
    with pytest.raises(BadInput, match="goal"):
        Guard().check(bad)


@pytest.mark.parametrize("seconds", [0, -1, float("nan")])
def test_seconds_must_be_positive(seconds):
    with pytest.raises(BadInput, match="seconds"):
        Guard().seconds(omx.ZERO, omx.HOME, seconds)


NAN = float("nan")


@pytest.mark.parametrize(
    "settings",
    [{"speed_cap": NAN}, {"speed_cap": -1}, {"speed_cap": 0}, {"speed_cap": 10}, {"speed_cap": "fast"}, {"margin": NAN},
     {"margin": -10}, {"margin": 1.5}, {"table": NAN}, {"table": "low"}, {"limits": omx.LIMITS[:3]},
     {"limits": [(1, -1)] * 4}, {"limits": [(-4, 4)] * 4}, {"limits": [(NAN, 1)] * 4}, {"limits": None},
     {"geometry": (77, 130, 124, 126)}],
)  # fmt: skip
def test_a_guard_refuses_settings_that_it_cannot_keep(settings):
    with pytest.raises(BadInput, match=next(iter(settings))):
        Guard(**settings)


def test_the_push_that_a_hand_may_feel_is_the_one_that_the_docstring_states():
    assert Guard().push() == pytest.approx(2.1, abs=0.05)
    assert Guard(payload_g=100).push() > Guard().push()
    assert Guard(speed_cap=4.8, payload_g=500).push() == STALL_TORQUE


def test_a_joint_that_pushes_without_moving_is_found():
    assert stalled([620, 620, 20, 20], [0.0, 1.0, 0.0, 1.0]) == [1]
    assert stalled([0, 0, -620, 0], [0.0, 0.0, 0.001, 0.0]) == [3]


def test_every_configuration_the_guard_lets_through_is_above_the_table():
    guard = Guard()
    low, high = np.array(guard.soft_limits).T
    passed = 0
    for q in RNG.uniform(low, high, (300, 4)):
        try:
            guard.check(q)
        except Collision:
            continue
        passed += 1
        assert omx.frames(q)[2:, 2, 3].min() > 10.0
    assert passed > 100


@pytest.mark.parametrize("mm", [30.0, 60.0])
def test_what_is_carried_is_a_ball_about_the_tool_that_stays_clear_of_table_and_base(mm):
    guard, empty = Guard(payload_mm=mm), Guard()
    for radius, z in ((140, 40.0), (140, 60.0), (140, 90.0), (70, 45.0)):
        q = omx.solve_ik([radius, 0, z, -np.pi / 2]).q
        table, base = z - mm, radius - mm - 24.0  # the base is a post of this radius, 15 to 52 mm high
        found, *names = guard.clearance(q)
        assert found <= min(table, empty.clearance(q)[0]) + 1e-9
        if min(table, base) < 0:
            assert found == pytest.approx(min(table, base), abs=1e-9)
            assert set(names) == {"load", "table" if table < base else "base"}
            with pytest.raises(Collision, match="load"):
                guard.check(q)


@pytest.mark.parametrize("bad", [-1, 151, float("nan"), "30", None, True])
def test_a_load_that_no_hand_carries_is_refused(bad):
    with pytest.raises(BadInput, match="payload_mm"):
        Guard(payload_mm=bad)
