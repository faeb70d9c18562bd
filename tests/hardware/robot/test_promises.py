"""What an arm must never do, tried on the true joints of the virtual one. book/teach/safety.md names these tests."""

import math
import os
import random
import re
import subprocess
import sys
import textwrap
import time
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

import omx
from omx.arm import HOLDING_TORQUE, JOINT_IDS, OVERLOAD_TORQUE, REST
from omx.errors import (
    BadInput,
    Collision,
    JointLimit,
    NotArrived,
    NotReady,
    OutOfBounds,
    PortBusy,
    PortError,
    ReadOnly,
    Stalled,
    Stopped,
    TooFast,
    TooHeavy,
    TorqueOff,
)
from omx.hardware.dynamixel import packet as pk
from omx.hardware.dynamixel.bus import Bus
from omx.hardware.dynamixel.registers import REGISTERS
from omx.hardware.fault_table import CONDITIONS
from omx.hardware.robot import Robot, discovery, modes
from omx.hardware.robot.move_rules import way_to_rest
from omx.hardware.safety import Guard
from omx.hardware.simulator import SteppedClock, VirtualArm, VirtualPort
from omx.motion.trajectory import joint_move
from tests.helpers.served_arm import Served
from tests.helpers.witness import Witness

QUICK = settings(
    max_examples=40,
    deadline=None,
    derandomize=True,
    phases=[Phase.explicit, Phase.generate],
    suppress_health_check=list(HealthCheck),
)
OUTSIDE = ((-0.078, -2.05, 1.53, 0.623), (0.0, -1.6, 0.35, 0.7), (0.0, -1.05, 1.45, 0.7), (0.0, -1.05, -1.571, 0.7))


def on(arm=None, **options):
    """A robot on `arm` in stepped time, motors on."""
    robot = Robot(VirtualPort(arm or VirtualArm(), clock=SteppedClock()), **options)
    robot.write_motor_state(True)
    return robot


def torque(robot_or_arm):
    arm = getattr(robot_or_arm, "arm", robot_or_arm)
    return any(arm.servo(servo).torque_on for servo in JOINT_IDS)


# ---- parking, from anywhere and at any speed cap ----


@pytest.mark.parametrize("cap_deg", [0.5, 5, 10, 29, 30, 31, 60, 200])
def test_closing_parks_under_any_speed_cap_and_keeps_it(cap_deg):
    robot = on(guard=Guard(speed_cap=math.radians(cap_deg)))
    robot.clock.sleep(0.5)
    witness, arm = Witness(robot.bus._port.arm), robot.bus._port.arm
    robot.close()
    assert not torque(arm)
    assert arm.q[1] < math.radians(-75)
    assert witness.top_speed() <= math.radians(min(cap_deg, 30)) * 1.05


def test_an_arm_that_sank_when_it_was_parked_is_parked_again(robot):
    for _ in range(3):
        robot.park()
        robot.clock.sleep(3)
        assert not torque(robot)
        robot.write_motor_state(True)
    robot.park()


@pytest.mark.parametrize("q", OUTSIDE)
def test_an_arm_outside_its_limits_is_closed_parked_and_its_first_move_slows_down_by_itself_and_says_so(q, caplog):
    arm = VirtualArm(q)
    with on(arm) as robot:
        assert robot
    assert not torque(arm)
    robot = on(arm := VirtualArm(q))
    witness = Witness(arm)
    robot.move_to(np.degrees(omx.HOME), 1.0)
    assert "the way back in takes" in caplog.text
    assert witness.top_speed() <= math.radians(10) * 1.05
    np.testing.assert_allclose(arm.q, omx.HOME, atol=math.radians(1.5))


def test_parking_folds_the_arm_where_it_stands(robot):
    robot.move_to([150, -60, 20, 40])
    robot.park()
    assert math.degrees(robot.arm.q[0]) == pytest.approx(150, abs=0.5)
    assert robot.arm.q[1] == pytest.approx(REST[1], abs=0.05)


LEGAL = st.tuples(*(st.floats(low, high) for low, high in Guard().soft_limits))


@settings(QUICK, max_examples=300)
@given(LEGAL)
def test_there_is_a_way_to_the_rest_pose_from_every_legal_pose(q):
    guard = Guard()
    if guard.clearance(q)[0] > 0:
        assert way_to_rest(guard, q)[-1][1:] == REST[1:]


# ---- the arm's own weight ----


@pytest.mark.parametrize("grams", [0, 150])
@settings(QUICK, max_examples=15)
@given(st.floats(0.3, 1.1), st.floats(-0.9, 0.3), st.floats(-0.3, 0.8))
def test_where_the_arm_may_go_it_does_not_sag_into_the_table(grams, q2, q3, q4):
    """As near to the table as the guard allows, and then some time there."""
    robot = on(VirtualArm(payload_g=grams), payload_g=grams)
    witness, goal = Witness(robot.arm), (0.0, q2, q3, q4)
    try:
        robot.move_to(np.degrees(goal))
    except (Collision, TooHeavy) as error:
        if isinstance(error, Collision):
            robot.move_to(np.degrees(error.nearest))
    robot.write_motor_state(True)
    robot.clock.sleep(1.0)
    assert witness.lowest() > -1.0


@pytest.mark.parametrize("q", [(0.0, 0.0, 0.0, 0.0), (0.3, 0.9, 0.1, -0.7), (0.0, -1.0, 0.3, 0.7)])
def test_motors_that_go_on_hold_the_arm_just_where_it_is(q):
    """A limp arm that lies on the table, or in a hand, must not sag into it by its weight."""
    robot = Robot(VirtualPort(VirtualArm(q), clock=SteppedClock()))
    for limp_s in (0.0, 10.0):
        robot.relax()
        robot.clock.sleep(limp_s)
        limp, witness = np.array(robot.arm.q), Witness(robot.arm)
        robot.write_motor_state(True)
        robot.clock.sleep(1.0)
        np.testing.assert_allclose(witness.q, np.tile(limp, (len(witness.q), 1)), atol=math.radians(0.25))


# ---- a goal sent in mid-motion ----

MOVE = st.tuples(LEGAL, st.floats(0.0, 3.0), st.floats(0.3, 5.0))


@QUICK
@given(st.lists(MOVE, min_size=2, max_size=5))
def test_whatever_is_commanded_in_mid_motion_the_joints_stay_in_what_was_checked(moves):
    """Neither the limits, nor the table, nor the hull of poses and goals is left, and the cap is on the peak."""
    robot = Robot(clock=SteppedClock())
    robot.write_motor_state(True)
    robot.clock.sleep(0.3)
    witness = Witness(robot.arm)
    for goal, pause, more in moves:
        present = np.array(robot.q)
        try:
            sent = robot.driver.command(goal, robot.driver.guard.seconds(present, goal) + more)
        except omx.OmxError:
            continue
        first = len(witness.rows)
        robot.clock.sleep(pause)
        path = witness.q[first:]
        if len(path):  # from the moment the goal is out, every joint stays between where it stood and its goal
            hull = np.sort([path[0], sent], axis=0)
            assert (path >= hull[0] - math.radians(1.0)).all()
            assert (path <= hull[1] + math.radians(1.0)).all()
    robot.clock.sleep(3.0)
    assert witness.lowest() > -2.0  # it sags
    assert witness.beyond() < math.radians(1.0)
    assert witness.top_speed() <= robot.driver.guard.speed_cap * 1.05
    robot.bus.close()


def test_the_goal_that_used_to_run_on_to_77_degrees_goes_to_10(robot):
    robot.move_to([-80, -60, 20, 40])
    robot.write_time(4)
    robot.write_joints([80, -60, 20, 40])
    robot.clock.sleep(1.5)
    witness = Witness(robot.arm)
    robot.write_time(10)
    robot.write_joints([10, -60, 20, 40])
    robot.clock.sleep(11)
    assert np.degrees(witness.q[:, 0].max()) < 11


def test_leaving_a_with_block_in_mid_move_does_not_dive_into_the_table():
    robot = Robot(clock=SteppedClock())
    with robot:
        robot.write_motor_state(True)
        robot.move_to([-90, -80, -20, 60])
        witness = Witness(robot.arm)
        robot.write_joints([-90, 3, 20, 40])
        robot.clock.sleep(1.2)
    assert not torque(robot)
    assert witness.lowest() > -2.0


@pytest.mark.parametrize("seed", range(4))
def test_a_program_that_is_held_up_for_seconds_keeps_the_cap_and_still_sees_the_arm_arrive(seed):
    """A busy computer, between any answer of the servos and what is made of it."""
    chance = random.Random(seed)
    robot = Robot(clock=SteppedClock())
    robot.write_motor_state(True)
    read, witness = robot.bus.read_block, Witness(robot.arm)

    def held_up(*args):
        found = read(*args)
        robot.clock.sleep(chance.uniform(0.2, 3.0) if chance.random() < 0.05 else 0.0)
        return found

    robot.bus.read_block = held_up
    for _ in range(6):
        goal = [chance.uniform(low, high) for low, high in ((-90, 90), (-70, -10), (-20, 40), (0, 50))]
        robot.write_joints(goal)
        robot.clock.sleep(chance.uniform(0.0, 1.0))
        robot.move_to([-goal[0], *goal[1:]])
    assert witness.top_speed() <= robot.driver.guard.speed_cap * 1.05
    robot.bus.close()


# ---- velocities and currents ----


def test_a_velocity_ends_by_itself_however_many_read(robot, tmp_path):
    robot.move_to([0, -60, 20, 40])
    robot.write_mode("velocity")
    robot.write_velocities([0, 20, 0, 0])
    robot.log(3, tmp_path / "a.csv")
    assert math.degrees(robot.arm.q[1]) == pytest.approx(-52, abs=1.5)  # 0.4 s at 20 deg/s
    for _ in range(30):
        Bus.read(robot.bus, 12, "present_position")  # nor does a read past the driver feed it
        robot.clock.sleep(0.1)
    assert math.degrees(robot.arm.q[1]) == pytest.approx(-52, abs=1.5)


@QUICK
@given(st.lists(st.tuples(*[st.floats(-1.1, 1.1)] * 4), min_size=3, max_size=30))
def test_repeated_velocities_never_leave_limits_or_table(speeds):
    robot = Robot(clock=SteppedClock())
    robot.write_motor_state(True)
    robot.write_mode("velocity")
    robot.clock.sleep(0.3)
    witness = Witness(robot.arm)
    for v in speeds:
        for _ in range(4):
            try:
                modes.velocities(robot.driver, v)
            except omx.OmxError:
                break
            robot.clock.sleep(0.1)
    robot.clock.sleep(1.0)
    assert witness.lowest() > -2.0
    assert witness.beyond() < math.radians(1.0)
    assert witness.top_speed() <= robot.driver.guard.speed_cap * 1.05
    robot.bus.close()


def test_a_push_that_is_not_repeated_ends_in_position_hold(robot):
    """In current mode a servo that stops is limp: the arm fell 78 degrees."""
    robot.move_to([0, 0, 0, 0])
    robot.write_mode("current")
    robot.write_currents([0, -300, 0, 0])
    robot.clock.sleep(3.0)  # nobody reads
    there = np.array(robot.arm.q)
    assert math.degrees(abs(there[1])) < 25
    robot.clock.sleep(3.0)
    np.testing.assert_allclose(robot.arm.q, there, atol=math.radians(0.2))
    robot.write_currents([0, -300, 0, 0])  # the mode is what it was
    robot.hold()
    assert set(robot.bus.read_all(JOINT_IDS, "operating_mode").values()) == {3}


@pytest.mark.parametrize("grams", [0, 200])
def test_a_program_that_dies_while_the_arm_is_balanced_leaves_it_standing(grams):
    arm = VirtualArm((0.0, -0.35, 0.17, 0.35), payload_g=grams)
    robot = on(arm, payload_g=grams)
    robot.write_mode("current")
    for _ in range(5):
        modes.balance(robot.driver)
        robot.clock.sleep(0.1)
    there = np.array(arm.q)
    robot.bus.close()
    arm.advance(arm.now + 30.0)
    np.testing.assert_allclose(arm.q, there, atol=math.radians(1.5))
    again = Robot(VirtualPort(arm, clock=SteppedClock()))
    assert set(again.bus.read_all(JOINT_IDS, "operating_mode").values()) == {3}
    np.testing.assert_allclose(arm.q, there, atol=math.radians(2))


@QUICK
@given(st.lists(st.tuples(*[st.floats(-500, 500)] * 4), min_size=1, max_size=12), st.booleans())
def test_pushes_never_leave_limits_or_table(pushes, reads):
    robot = Robot(clock=SteppedClock())
    robot.write_motor_state(True)
    robot.write_mode("current")
    witness = Witness(robot.arm)
    for push in pushes:
        try:
            robot.write_currents(push)
        except (JointLimit, OutOfBounds, TooFast, omx.Collision, Stopped, Stalled):
            continue
        for _ in range(6):
            robot.clock.sleep(0.05)
            if reads:
                try:
                    robot.get_joints_readings()
                except (OutOfBounds, Stalled):
                    break
    robot.clock.sleep(2.0)
    assert witness.lowest() > -2.0
    assert witness.beyond() < math.radians(1.0)
    assert witness.top_speed() <= robot.driver.guard.speed_cap * 1.05
    robot.bus.close()


def test_a_robot_opened_on_an_arm_that_turns_makes_it_hold(caplog):
    arm = VirtualArm(settings={s: {"operating_mode": 1, "torque_enable": 1} for s in JOINT_IDS})
    with Bus(VirtualPort(arm, clock=SteppedClock())) as bus:
        bus.write(11, "goal_velocity", 15)
    robot = Robot(VirtualPort(arm, clock=SteppedClock()))
    robot.clock.sleep(0.5)
    there = arm.q[0]
    for _ in range(10):
        robot.get_joints_readings()
        robot.clock.sleep(0.1)
    assert arm.q[0] == pytest.approx(there, abs=1e-3)
    assert "the motors are on" in caplog.text


# ---- stop, stall, interrupt ----


def test_nothing_moves_after_a_stop_until_somebody_resumes_in_so_many_words(caplog):
    robot = Robot(clock=SteppedClock())

    def program():
        with robot:
            robot.write_motor_state(True)
            robot.move_to([60, -60, 20, 40])
            robot.stop()
            for refused in (robot.park, lambda: robot.move_to([0, -60, 20, 40])):
                with pytest.raises(Stopped, match="resume"):
                    refused()
            robot.move_to([0, -60, 20, 40])

    with pytest.raises(Stopped):
        program()
    before = robot.arm.q
    robot.arm.advance(robot.arm.now + 5)
    np.testing.assert_allclose(robot.arm.q, before, atol=math.radians(0.3))
    assert math.degrees(robot.arm.q[0]) == pytest.approx(60, abs=0.5)
    assert torque(robot)
    assert "MOTORS ARE ON" in caplog.text
    assert "robot.park()" in caplog.text


def test_a_stall_latches_too_and_names_the_joint(robot):
    robot.arm.faults.inject("blocked", servo=12, value=0.01)
    with pytest.raises(Stalled, match="joint 2"):
        robot.move_to([0, 0, 20, 40], 3)
    with pytest.raises(Stopped, match="joint 2 pushed on something"):
        robot.write_joints([0, -60, 20, 40])
    robot.arm.faults.clear()
    robot.resume()
    robot.move_to([0, -60, 20, 40])


@pytest.mark.parametrize("joint", [1, 2, 3, 4])
def test_a_joint_that_was_held_back_stays_when_it_is_let_go(robot, joint, caplog):
    """It stalled a little behind its set-point: holding that would make it spring there."""
    robot.arm.faults.inject("blocked", servo=10 + joint)
    goal = np.degrees([each.angle for each in robot.arm.joints[:4]])
    goal[joint - 1] += 2.6
    robot.write_time(1)
    robot.write_joints(goal)
    robot.clock.sleep(4)
    assert f"joint {joint} is pushing on something" in caplog.text
    held = robot.arm.joints[joint - 1].angle
    robot.arm.faults.clear()
    robot.clock.sleep(2)
    assert abs(robot.arm.joints[joint - 1].angle - held) < math.radians(0.6)


def test_a_plain_write_is_watched_though_nobody_reads(robot, caplog):
    """A hand holds joint 2; the program only sleeps."""
    robot.write_time(3)
    robot.write_joints([0, -10, 20, 40])
    robot.clock.sleep(0.3)
    robot.arm.faults.inject("blocked", servo=12, value=0.01)
    pressed = Witness(robot.arm)
    robot.clock.sleep(4)
    assert "joint 2 is pushing on something" in caplog.text
    assert torque(robot)
    assert abs(robot.arm.joints[1].current) < 500  # it has let go
    assert not robot.arm.servo(12).table["hardware_error"]
    assert pressed.rows
    with pytest.raises(Stalled, match="joint 2"):
        robot.write_joints([0, -10, 20, 40])


def test_a_hand_in_the_way_of_the_fingertips_feels_at_most_eight_newtons(robot):
    """Joint 2 of the stretched arm is held while it goes down: the motor's torque and the arm's weight, at 0.38 m."""
    robot.move_to([0, 10, 0, 0])
    robot.arm.faults.inject("blocked", servo=12, value=0.001)
    most = []
    live = robot.arm._live

    def felt(steps):
        most.append(robot.arm.joints[1].effort)
        live(steps)

    robot.arm._live = felt
    robot.write_time(1)
    robot.write_joints([0, 40, -30, 0])
    robot.clock.sleep(2)
    assert max(map(abs, most)) <= robot.driver.guard.push() + 0.02
    assert (max(map(abs, most)) + HOLDING_TORQUE) / 0.38 <= 8.0
    assert robot.driver.guard.push() < OVERLOAD_TORQUE  # so it does not end in overload and a limp joint


# ---- the speed cap is on what moves ----


@pytest.mark.parametrize("rate", [20, 50, 200])
def test_a_trajectory_at_any_rate_keeps_the_cap_also_after_hiccups(robot, rate):
    robot.move_to([-40, -60, 20, 40])
    path = joint_move(robot.q, np.radians([40, -60, 20, 40]), 3.0)
    witness, count = Witness(robot.arm), [0]

    def hiccup(reading, t):
        count[0] += 1
        if count[0] % 40 == 0:
            robot.clock.sleep(0.09)

    robot.follow(path, rate, each=hiccup)
    assert witness.top_speed() <= math.radians(60) * 1.05
    assert math.degrees(robot.arm.q[0]) == pytest.approx(40, abs=1)


@pytest.mark.parametrize("cap_deg", [10, 60])
@pytest.mark.parametrize("step_deg", [1, 5.9, 7.5])
def test_a_stream_keeps_the_cap_whatever_its_steps(cap_deg, step_deg):
    robot = on(guard=Guard(speed_cap=math.radians(cap_deg)))
    robot.clock.sleep(0.3)
    witness = Witness(robot.bus._port.arm)
    for _ in range(30):
        q = np.array(robot.q)
        try:
            robot.driver.stream_to(q + math.radians(step_deg) * np.eye(4)[0], 0.05)
        except TooFast:
            break
        robot.clock.sleep(0.05)
    robot.clock.sleep(0.5)
    assert witness.top_speed() <= math.radians(cap_deg) * 1.05


def test_a_step_longer_than_the_cap_allows_is_refused(robot):
    with pytest.raises(TooFast):
        robot.driver.stream_to(robot.q + math.radians(7.9) * np.eye(4)[0], 0.02)
    with pytest.raises(BadInput, match="seconds"):
        robot.driver.stream_to(robot.q, float("nan"))


def test_a_move_without_a_time_peaks_at_the_cap(robot):
    robot.move_to([-80, -60, 20, 40])
    witness = Witness(robot.arm)
    robot.move_to([80, -60, 20, 40])
    assert math.radians(55) < witness.top_speed(slack_deg=0) <= math.radians(60) * 1.05


# ---- arrival ----


def test_a_move_that_does_not_arrive_names_joint_gap_and_cause(robot):
    robot.bus.write(13, "goal_pwm", 30)
    with pytest.raises(NotArrived, match="servo 13 pushes with at most 3 %") as caught:
        robot.move_to([0, -30, -20, 0], 3)
    assert caught.value.joint == 3
    assert math.degrees(abs(caught.value.gap)) > 4
    assert robot.driver.torque


# ---- what is said, and the idle arm ----


def test_warnings_are_said_when_the_arm_is_opened_and_when_they_come_up(caplog):
    arm = VirtualArm()
    arm.faults.inject("low_voltage", value=10.6)
    arm.advance(0.1)
    robot = on(arm)
    assert "only 10." in caplog.text
    caplog.clear()
    arm.faults.inject("hot", servo=12, value=64.0)
    robot.clock.sleep(3)
    assert caplog.text.count("servo 12 is at 6") == 1  # said once


def test_a_forgotten_arm_parks_after_a_settable_while(caplog):
    robot = on(idle_s=60)
    robot.move_to([20, -30, 10, 20])
    arm = robot.bus._port.arm
    robot.clock.sleep(50)
    assert torque(arm)
    robot.clock.sleep(30)
    assert not torque(arm)
    assert "left to itself" in caplog.text


def test_a_stopped_arm_is_never_parked_by_itself():
    robot = on(idle_s=5)
    robot.stop()
    robot.clock.sleep(60)
    assert torque(robot.bus._port.arm)


def test_an_idle_arm_that_gets_too_hot_parks_before_its_servo_gives_up(caplog):
    robot = on()
    robot.move_to([0, 0, 0, 0])
    arm = robot.bus._port.arm
    arm.faults.inject("hot", servo=12, value=79.0)
    robot.clock.sleep(60)
    assert not torque(arm)
    assert arm.q[1] < math.radians(-75)  # folded, not fallen
    assert "servo 12 is at 7" in caplog.text


# ---- transactions ----


def count(robot, action):
    robot.bus.history.clear()
    action()
    return len(robot.bus.history)


def test_a_stop_takes_two_transactions_until_all_joints_stand_and_a_third_to_see_it(robot):
    robot.write_joints([60, -60, 20, 40])
    robot.clock.sleep(0.5)
    assert count(robot, robot.stop) == 3
    robot.resume()
    assert count(robot, robot.driver.hold) == 3


def test_switching_the_motors_on_takes_few_transactions(robot):
    assert count(robot, lambda: robot.write_motor_state(True)) <= 12
    robot.park()
    assert count(robot, lambda: robot.write_motor_state(True)) <= 14
    fresh = Robot(clock=SteppedClock())
    assert count(fresh, lambda: fresh.write_motor_state(True)) <= 16


def test_a_command_takes_few_transactions_and_a_step_of_a_stream_two(robot):
    assert count(robot, lambda: robot.write_joints([10, -60, 20, 40])) <= 6
    robot.driver.wait()
    robot.driver.stream_to(robot.q, 0.04)
    assert count(robot, lambda: robot.driver.stream_to(np.array(robot.q) + 0.001, 0.04)) == 3  # robot.q is one


# ---- what another program left behind: LEFT_BEHIND in test_doctor goes through the rows of CONDITIONS ----


def test_a_homing_offset_is_refused_by_name():
    arm = VirtualArm(settings={12: {"homing_offset": -400}})
    with pytest.raises(NotReady, match=r"servo 12 has a homing offset of -400 ticks.*homing_offset', 0"):
        Robot(VirtualPort(arm, clock=SteppedClock()))


def test_every_row_that_is_not_mended_says_what_to_do():
    for row in CONDITIONS:
        assert row.remedy
        assert row.mend is None or "write_motor_state" in row.remedy


# ---- which arm, and whose ----


def two_ports(monkeypatch, arms, others=()):
    names = [f"/dev/ttyUSB{i}" for i in range(len(arms))]
    asked = []

    def opened(name):
        asked.append(name)
        port = VirtualPort(arms[names.index(name)], clock=SteppedClock())
        port.port_name = name
        return Bus(port)

    monkeypatch.setattr(
        discovery, "find_ports", lambda adapters_only=False: [*names, *(() if adapters_only else others)]
    )
    monkeypatch.setattr(discovery, "_opened", opened)
    return names, asked


def test_auto_refuses_to_choose_between_two_arms(monkeypatch):
    names, _ = two_ports(monkeypatch, [VirtualArm(), VirtualArm()])
    with pytest.raises(PortError, match=f"{names[0]} and {names[1]}"):
        Robot("auto")


def test_auto_asks_nobody_but_the_adapters_of_arms(monkeypatch):
    names, asked = two_ports(monkeypatch, [VirtualArm()], others=["/dev/ttyACM7"])
    assert Robot("auto").bus.name == names[0]
    arm = VirtualArm()
    arm.faults.inject("no_power")
    two_ports(monkeypatch, [arm], others=["/dev/ttyACM7"])
    with pytest.raises(PortError, match="/dev/ttyACM7: not asked"):
        Robot("auto")
    assert "/dev/ttyACM7" not in asked


def test_a_second_client_of_a_served_arm_hears_that_it_is_busy():
    with Served("--tcp", "0") as served, Bus(served.name) as bus:
        assert bus.scan(JOINT_IDS)
        here = f"from omx import Robot; Robot({served.name!r})"
        done = subprocess.run([sys.executable, "-c", here], capture_output=True, text=True, timeout=60, check=False)
        assert "another program is connected" in done.stderr
        with pytest.raises(PortBusy, match=r"robot.close\(\)|another program"):
            Robot(served.name)


@pytest.mark.skipif(sys.platform == "win32", reason="a pseudo-terminal")
def test_the_cell_that_opens_the_arm_run_again_says_that_this_notebook_has_it():
    with Served("--pty") as served:
        robot = Robot(served.name)
        with pytest.raises(PortBusy, match=r"this very notebook has it open.*robot\.close\(\)"):
            Robot(served.name)
        robot.close()


# ---- the end of a program ----

FORKED = """
    import math, os, sys
    from omx.hardware.robot import Robot
    from omx.errors import PortLost
    robot = Robot(sys.argv[1])
    robot.write_motor_state(True)
    robot.move_to([60, -60, 20, 40])
    child = os.fork()
    if not child:
        try:
            robot.move_to([0, -60, 20, 40])
        except PortLost:
            sys.exit(7)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7
    print(round(robot.get_joints_readings()[0][0]))
    robot.resume()
    robot.close()
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs os.fork")
def test_a_forked_child_neither_drives_the_arm_nor_hangs_up():
    with Served("--tcp", "0") as served:
        command = [sys.executable, "-c", textwrap.dedent(FORKED), served.name]
        done = subprocess.run(command, capture_output=True, text=True, timeout=90, check=False)
        assert done.stdout == "60\n", done.stderr


ENDED = """
    import sys, time
    from omx.hardware.robot import Robot
    robot = Robot(sys.argv[1])
    robot.write_motor_state(True)
    robot.write_joints([40, -60, 20, 40])
    time.sleep(0.5)
"""


def test_a_program_that_ends_leaves_the_arm_holding_and_says_so_and_the_next_one_finds_it(caplog):
    with Served("--tcp", "0") as served:
        command = [sys.executable, "-c", textwrap.dedent(ENDED), served.name]
        started = time.monotonic()
        done = subprocess.run(command, capture_output=True, text=True, timeout=90, check=False)
        assert done.returncode == 0
        assert "MOTORS ARE ON" in done.stderr
        assert f"Robot({served.name!r})" in done.stderr
        robot = Robot(served.name)
        here = robot.get_joints_readings()[0][0]
        assert 1 < here < 35, time.monotonic() - started  # neither at its goal, nor parked
        assert "the motors are on" in caplog.text
        time.sleep(0.5)
        assert robot.get_joints_readings()[0][0] == pytest.approx(here, abs=0.3)
        robot.close()


# ---- an arm that is only read, as in a browser ----


def only_read(arm):
    """A port to `arm` over which nothing but questions may go."""
    port = VirtualPort(arm, clock=SteppedClock())
    port.read_only = True
    return port


def tables(arm):
    """What is in the registers of all servos that only a packet changes, and where the joints are."""
    rows = [row.name for row in REGISTERS.values() if row.writable]
    return [[servo.table[name] for name in rows] for servo in arm.servos], arm.q


def test_to_an_arm_that_is_only_read_nothing_but_questions_goes_out(tmp_path):
    arm = VirtualArm(q=omx.HOME)
    before = tables(arm)
    robot = Robot(only_read(arm))
    home, log = np.degrees(omx.HOME), tmp_path / "log.csv"
    path = joint_move(omx.HOME, REST, 3.0)
    for act in (
        lambda: robot.write_motor_state(True), lambda: robot.write_motor_state(False), robot.relax, robot.recover,
        lambda: robot.driver.carry(100.0) or robot.write_motor_state(True), lambda: omx.RobotPanel(robot),
    ):  # fmt: skip
        with pytest.raises(ReadOnly, match="only read in a browser"):
            act()
    for act in (
        lambda: robot.write_joints(home), lambda: robot.move_to(home), lambda: robot.follow(path), robot.grip,
        lambda: robot.write_gripper(True), lambda: robot.teach(0.1, log), lambda: robot.replay(robot.log(0.1, log)),
        lambda: robot.write_mode("velocity") or robot.write_velocities([1, 0, 0, 0]),
        lambda: robot.write_mode("current") or robot.write_currents([1, 0, 0, 0]),
        lambda: robot.write_mode("position") or robot.follow_leader(lambda: home, 0.1),
    ):  # fmt: skip
        with pytest.raises(TorqueOff):
            act()
    for act in (robot.hold, robot.stop, robot.resume, robot.park):
        act()
    robot.clock.sleep(2000.0)  # nobody parks it either
    assert robot.q == pytest.approx(omx.HOME, abs=0.002)
    bus = robot.bus
    for instruction in set(pk.Instruction) - pk.QUESTIONS:
        with pytest.raises(ReadOnly):
            bus._ask(11, instruction, b"", [], "do something else")
    robot.close()
    sent = {pk.Reader().feed(transaction.sent)[0].instruction for transaction in bus.history}
    assert sent <= pk.QUESTIONS
    assert len(sent) > 1
    assert tables(arm) == before


def test_an_arm_that_is_only_read_and_has_its_motors_on_is_refused_by_name():
    arm = VirtualArm()
    left = on(arm)
    left.write_time(5.0)
    left.write_joints([30, 0, 0, 0])
    left.bus.close()
    before = tables(arm)[0]
    with pytest.raises(ReadOnly, match="its motors, which another program has left on"):
        Robot(only_read(arm))
    assert tables(arm)[0] == before
    assert arm.q[0] < 0.1  # in stepped time it has hardly gone on


# ---- the page ----


def test_the_safety_page_names_tests_that_exist():
    root = Path(__file__).parents[3]
    named = set(re.findall(r"`(test_\w+)`", (root / "book" / "teach" / "safety.md").read_text(encoding="utf-8")))
    folders = (root / "tests" / "hardware", root / "tests" / "display")
    there = {name for folder in folders for file in folder.rglob("test_*.py")
             for name in re.findall(r"^def (test_\w+)", file.read_text(encoding="utf-8"), re.M)}  # fmt: skip
    assert len(named) > 30
    assert named <= there, named - there
