"""Led by hand, recorded, run again; and one arm that leads another."""

import math

import numpy as np
import pytest

import omx
from omx.errors import BadInput, BusError, Collision, JointLimit, OutOfBounds, Stopped
from omx.hardware.log import Log, read_log
from omx.hardware.robot import Robot
from omx.hardware.robot.robot import COLUMNS
from omx.hardware.simulator import SteppedClock, VirtualArm, VirtualPort


@pytest.fixture
def robot():
    with Robot() as robot:
        robot.write_motor_state(True)
        yield robot


def hand(robot, *strokes):
    """A hand that pushes: (at s, torques in Nm) from now on, by the arm's own time."""
    arm = robot.arm
    for when, *torques in strokes:
        arm.at(arm.now + when, lambda torques=torques: arm.push(*torques))


def test_an_arm_led_by_hand_stays_where_it_is_left(robot, tmp_path):
    robot.move_to([0, -30, 10, 20])
    before = np.array(robot.arm.q)
    hand(robot, (1.0, 0.3, 0.25), (2.0,), (3.0, 0, 0, -0.25), (3.5,))
    log = robot.teach(6.0, tmp_path / "taught.csv", student="Ann")
    led = np.array(robot.arm.q)
    assert np.abs(led - before).max() > math.radians(8)
    q = np.radians(log.array("q1", "q2", "q3", "q4"))
    nobody_pushes = log["t"] > 4.0
    assert np.ptp(q[nobody_pushes], axis=0).max() < math.radians(0.5)
    robot.clock.sleep(5.0)
    assert np.abs(np.array(robot.arm.q) - led).max() < math.radians(1.0)  # and then it holds
    assert set(robot.bus.read_all((11, 12, 13, 14), "operating_mode").values()) == {3}
    assert read_log(tmp_path / "taught.csv").notes == {"student": "Ann"}


@pytest.mark.parametrize("grams", [0, 300])
def test_nothing_sinks_while_nobody_pushes(grams, tmp_path):
    with Robot(VirtualPort(VirtualArm(payload_g=grams), clock=SteppedClock()), payload_g=grams) as robot:
        robot.write_motor_state(True)
        robot.move_to([0, -20, 10, 20])
        before = robot.get_joints_readings()[0]
        robot.teach(5.0, tmp_path / "still.csv")
        assert np.abs(robot.get_joints_readings()[0] - before).max() < 1.0


def test_only_the_joints_that_were_named_give_way(robot, tmp_path):
    robot.move_to([0, -30, 10, 20])
    before = np.degrees(robot.arm.q)
    hand(robot, (0.5, 0.4, 0.4, 0.4, 0.4), (1.5,))
    robot.teach(2.5, tmp_path / "one.csv", joints=[1])
    moved = np.abs(np.degrees(robot.arm.q) - before)
    assert moved[0] > 10
    assert moved[1:].max() < 2


def test_a_hand_that_goes_too_far_is_stopped_and_the_log_is_kept(robot, tmp_path):
    robot.move_to([0, -60, 20, 40])
    hand(robot, (0.5, 0, 1.0))
    with pytest.raises((JointLimit, Collision, OutOfBounds)):
        robot.teach(20.0, tmp_path / "far.csv")
    robot.arm.push()
    robot.clock.sleep(1.0)
    assert len(read_log(tmp_path / "far.csv")) > 25
    assert omx.fk(robot.arm.q)[2, 3] > 0
    robot.move_to([0, -60, 20, 40])


def test_stop_ends_the_teaching(robot, tmp_path):
    robot.clock.later(1.0, robot.stop)
    with pytest.raises(Stopped):
        robot.teach(5.0, tmp_path / "stopped.csv")
    robot.resume()


@pytest.mark.parametrize("joints", [(), (0,), (1, 1), (5,), "1"])
def test_joints_are_named_by_number(robot, joints):
    with pytest.raises(BadInput, match="`joints`"):
        robot.teach(1.0, joints=joints)


# ---- again ----


def taught(*rows, rate=50.0, seconds=4.0):
    """A log of a motion through `rows` (deg), with the tremor of a hand."""
    t = np.arange(0.0, seconds, 1 / rate)
    rows = np.array(rows, dtype=float)
    q = np.array([np.interp(t, np.linspace(0, seconds, len(rows)), column) for column in rows.T]).T
    q += np.random.default_rng(1).normal(0.0, 0.05, q.shape)
    samples = [(time, *row, *[0.0] * 12) for time, row in zip(t.tolist(), q.tolist(), strict=True)]
    return Log(tuple(COLUMNS), dict(COLUMNS), samples)


MOTION = taught([0, -40, 10, 30], [25, -30, 0, 40], [25, -50, 20, 30])


@pytest.mark.parametrize("speed", [0.5, 1.0, 2.0])
def test_what_was_taught_is_run_again_at_any_speed(robot, speed):
    began, seen = robot.clock.now(), []
    robot.replay(MOTION, speed, each=lambda reading, t: seen.append((t * speed, *np.degrees(reading.q))))
    assert robot.clock.now() - began > 4.0 / speed
    seen = np.array(seen)
    for column, wanted in zip(seen.T[1:], MOTION.array("q1", "q2", "q3", "q4").T, strict=True):
        behind = np.interp(seen[:, 0] - 0.2, MOTION["t"], wanted)
        assert np.abs(column - behind).max() < 1.5 + 3 * speed  # smoothed, and a little late
    np.testing.assert_allclose(np.degrees(robot.arm.q), [25, -50, 20, 30], atol=1.5)


def test_too_fast_names_the_speed_that_would_do(robot):
    with pytest.raises(BadInput, match=r"speed=\d\.\d+ is the most") as caught:
        robot.replay(MOTION, 8.0)
    most = float(str(caught.value).split("speed=")[1].split(" is")[0])
    robot.replay(MOTION, most)
    for wrong in (0, -1, float("nan"), "2"):
        with pytest.raises(BadInput, match="`speed`"):
            robot.replay(MOTION, wrong)


def test_a_path_into_the_table_is_refused_before_anything_moves(robot):
    before = robot.arm.q
    with pytest.raises((Collision, JointLimit)):
        robot.replay(taught([0, -40, 10, 30], [0, 60, 20, 40]))
    assert robot.arm.q == before


def test_a_log_is_replayed_from_its_file(robot, tmp_path):
    from omx.hardware.log import write_log

    robot.replay(write_log(MOTION, tmp_path / "taught.csv"), 2.0)
    np.testing.assert_allclose(np.degrees(robot.arm.q), [25, -50, 20, 30], atol=1.5)


# ---- leader and follower ----


def two_arms():
    clock = SteppedClock()
    return [Robot(VirtualPort(VirtualArm(), clock=clock)) for _ in range(2)]


def test_an_arm_follows_another_that_a_hand_leads():
    leader, follower = two_arms()
    with follower, leader:
        follower.write_motor_state(True)
        leader.driver.bus._port.arm.place((0.4, -0.8, 0.2, 0.6))
        arm = leader.driver.bus._port.arm
        for i in range(1, 30):
            arm.at(arm.now + 0.1 * i, lambda i=i: arm.place((0.4 - 0.02 * i, -0.8 + 0.01 * i, 0.2, 0.6)))
        led = follower.follow_leader(leader, 5.0, rate=100)
        np.testing.assert_allclose(follower.q, leader.q, atol=math.radians(1.0))
        assert led.sent == 501
        assert led.refused == 0
        leader.driver.relax()


def test_where_the_leader_may_go_and_the_follower_not_it_waits(robot):
    angles = [0.0, -60.0, 20.0, 40.0]
    asked = []

    def sliders():
        asked.append(None)
        angles[1] = -60.0 + (80.0 if 100 < len(asked) < 400 else 0.0)  # down through the table, and back
        return angles

    lowest = []
    watch = robot.driver.watch
    robot.driver.watch = lambda: (watch(), lowest.append(omx.fk(robot.arm.q)[2, 3]))[0]
    led = robot.follow_leader(sliders, 7.0, rate=100)
    assert led.refused > 50
    assert isinstance(led.reason, (Collision, JointLimit))
    assert min(lowest) > 0
    np.testing.assert_allclose(np.degrees(robot.arm.q), [0, -60, 20, 40], atol=1.0)


def test_a_leader_that_leaps_is_followed_no_faster_than_the_cap(robot):
    peak, watch = [], robot.driver.watch
    robot.driver.watch = lambda: (reading := watch(), peak.append(max(map(abs, reading.speed))))[0]
    robot.follow_leader(lambda: [70, -30, 10, 30], 3.0)
    assert max(peak) <= robot.driver.guard.speed_cap * 1.05
    assert math.degrees(robot.arm.q[0]) == pytest.approx(70, abs=1)


def test_a_follower_that_was_held_up_catches_up_without_leaping(robot):
    angle = [0.0]

    def leader():
        angle[0] += 0.2
        if abs(angle[0] - 20) < 0.05:
            robot.clock.sleep(1.0)  # the computer was busy: a hundred steps are due at once
        return [angle[0], -60, 20, 40]

    peak, watch = [], robot.driver.watch
    robot.driver.watch = lambda: (reading := watch(), peak.append(max(map(abs, reading.speed))))[0]
    robot.follow_leader(leader, 4.0, rate=100)
    assert max(peak) <= robot.driver.guard.speed_cap * 1.05
    assert math.degrees(robot.arm.q[0]) == pytest.approx(angle[0], abs=5.5)


def test_a_leader_that_fails_makes_the_follower_hold(robot):
    angles = iter([[10, -60, 20, 40]] * 50)

    def gone():
        try:
            return next(angles)
        except StopIteration:
            raise BusError("leader", "gone") from None

    with pytest.raises(BusError, match="gone"):
        robot.follow_leader(gone, 3.0)
    stood = robot.arm.q
    robot.clock.sleep(2.0)
    np.testing.assert_allclose(robot.arm.q, stood, atol=math.radians(1.0))
    for bad in ([1, 2, 3], [float("nan")] * 4):
        with pytest.raises(BadInput):
            robot.follow_leader(lambda bad=bad: bad, 1.0)


@pytest.mark.parametrize("rate", [0, -1, float("nan"), "50"])
def test_a_rate_is_a_positive_number(robot, rate):
    before = robot.arm.q
    for call in (
        lambda: robot.follow(omx.trajectory.joint_move(robot.q, omx.HOME, 2.0), rate),
        lambda: robot.follow_leader(lambda: [0, -60, 20, 40], 1.0, rate),
        lambda: robot.replay(MOTION, rate=rate),
        lambda: list(robot.ticks(1.0, rate)),
    ):
        with pytest.raises(BadInput, match="`rate`"):
            call()
    assert robot.arm.q == before
