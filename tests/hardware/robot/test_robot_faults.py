"""Faults while a robot moves and logs: the arm ends safe, the message names the cause, the log keeps every sample.

Safe means: all joints stand, and every motor that its own servo did not switch off is on.
"""

import contextlib
import itertools
import math
import os
import signal
import subprocess
import sys
import textwrap
import threading
import time

import numpy as np
import pytest

import omx
from omx import errors
from omx.arm import ARM_IDS, JOINT_IDS
from omx.errors import LogError, NotReady, ServoLost, ServoRestarted, Stalled, Stopped, TorqueOff
from omx.hardware.dynamixel.bus import Bus
from omx.hardware.log import read_log
from omx.hardware.robot import Robot
from omx.hardware.simulator import SteppedClock, VirtualPort
from omx.hardware.simulator.virtual_port import VirtualSerial
from omx.motion.trajectory import joint_move
from tests.helpers.served_arm import Served

TARGET = [60, -25, 5, 25]
SECONDS, FAULT_AT, LOGGED = 3.0, 1.0, 4.0
JOINTS = JOINT_IDS


def run(robot, path, *faults, each=None):
    """Move and log, with `faults` a second after the start; the error that ended it, or None."""
    robot.write_time(SECONDS)
    robot.write_joints(TARGET)
    start = robot.clock.now()
    for kind, options in faults:
        robot.arm.at(robot.arm.now + FAULT_AT, lambda k=kind, o=options: robot.arm.faults.inject(k, **o))
    try:
        robot.log(LOGGED, path, progress=each)
    except (errors.OmxError, KeyboardInterrupt) as error:
        error.after = robot.clock.now() - start
        return error
    return None


def stands(robot, limp=(), settle=1.5):
    """Does the arm stand after `settle` s, with all motors on but those in `limp`?"""
    time_passes(robot, settle)
    before = np.array(robot.arm.q)
    time_passes(robot, 0.5)
    still = [i for i, servo in enumerate(JOINTS) if servo not in limp]
    np.testing.assert_allclose(np.array(robot.arm.q)[still], before[still], atol=math.radians(0.3))
    off = {servo for servo in JOINTS if not robot.arm.servo(servo).torque_on}
    assert off <= set(limp), f"limp: {off}"
    return True


def time_passes(robot, seconds):
    robot.clock.sleep(seconds)
    robot.arm.advance(robot.arm.now + (0 if robot.bus.is_open else seconds))


def kept(path):
    """The log on the disk has every sample up to the fault, 20 ms apart."""
    log = read_log(path)
    t = log["t"]
    assert (t < FAULT_AT).sum() >= FAULT_AT * 50
    np.testing.assert_allclose(np.diff(t[t < FAULT_AT]), 0.02, atol=1e-6)
    return log


# ---- what a motion survives ----

HARMLESS = {
    "one answer lost": [("lost", {"servo": 12, "count": 1})],
    "one answer damaged": [("corrupt", {"servo": 13, "count": 1})],
    "one answer cut short": [("truncated", {"servo": 14, "count": 1})],
    "one answer late": [("late", {"servo": 11, "count": 1, "value": 0.02})],
    "one answer far too late": [("late", {"servo": 11, "count": 1, "value": 0.06})],
    "noise before every tenth answer": [("noise", {"count": 1, "after": n}) for n in range(0, 300, 10)],
    "much noise before every answer": [("noise", {"value": 400})],
    "all answers twice": [("duplicated", {})],
    "one of each": [(kind, {"count": 1, "after": 9 * i}) for i, kind in
                    enumerate(("lost", "corrupt", "truncated", "duplicated", "noise"))],
    "the gripper dies": [("dead", {"servo": 15})],
    "a rather low voltage": [("low_voltage", {"value": 10.7})],
    "a warm servo": [("hot", {"servo": 12, "value": 62.0})],
}  # fmt: skip


@pytest.mark.parametrize("name", HARMLESS)
def test_what_a_motion_survives(robot, tmp_path, name):
    assert run(robot, tmp_path / "a.csv", *HARMLESS[name]) is None
    log = kept(tmp_path / "a.csv")
    assert len(log) == LOGGED * 50 + 1
    assert 0 <= np.diff(log["t"]).min() <= np.diff(log["t"]).max() < 0.1  # a late one is caught up with at once
    np.testing.assert_allclose(robot.get_joints_readings()[0], TARGET, atol=1.5)
    np.testing.assert_allclose(np.diff(log["q1"])[:145] >= -0.1, True)  # no value is from another motion
    assert stands(robot)


# ---- what ends it ----

ENDS = {
    **{f"servo {s} dies": ([("dead", {"servo": s})], ServoLost, [f"servo {s} no longer"], [s]) for s in JOINTS},
    **{f"the chain breaks before {s}": ([("broken_chain", {"servo": s})], ServoLost,
                                       [f"between servo {s - 1} and servo {s}"], range(s, 16)) for s in (12, 13, 14)},
    "no power": ([("no_power", {})], ServoLost, ["12 V supply"], JOINTS),
    **{f"servo 12: only {kind} answers": ([(kind, {"servo": 12})], errors.BusTimeout, ["servo 12"], [])
       for kind in ("lost", "corrupt", "truncated", "late")},
    **{f"servo {s} is not heard any more": ([("lost", {"servo": s})], ServoLost, [f"servo {s}"], []) for s in JOINTS},
    "two answers lost in a row": ([("lost", {"servo": 13, "count": 2})], errors.BusTimeout, ["servo 13"], []),
    **{f"overload of {s}": ([("overload", {"servo": s})], errors.ServoFault, [f"servo {s}: overload"], [s])
       for s in JOINTS},
    "shock": ([("shock", {"servo": 13})], errors.ServoFault, ["servo 13: electrical shock"], [13]),
    "overheated": ([("overheated", {"servo": 12})], errors.ServoFault, ["servo 12: overheated"], [12]),
    "encoder": ([("encoder", {"servo": 11})], errors.ServoFault, ["servo 11: encoder"], []),
    **{f"servo {s} restarts": ([("reboots", {"servo": s})], ServoRestarted, [f"servo {s} restarted"], [])
       for s in JOINTS},
    "all restart": ([("reboots", {"servo": s}) for s in ARM_IDS], ServoRestarted, ["11, 12, 13 and 14"], []),
    "the supply sags": ([("low_voltage", {"value": 9.8})], NotReady, ["9.", "12 V"], []),
    "the supply sags below what servos stand": ([("low_voltage", {"value": 9.0})], errors.OmxError, ["servo"], []),
    "hot": ([("hot", {"servo": 13, "value": 74.0})], NotReady, ["servo 13 is at 7"], []),
    "too hot": ([("hot", {"servo": 13, "value": 95.0})], errors.OmxError, ["13"], [13]),
    **{f"joint {s - 10} is held": ([("blocked", {"servo": s})], (Stalled, errors.ServoFault), [str(s - 10)], [s])
       for s in (11, 12)},
    "a servo loses its baud rate": ([("wrong_baud", {"servo": 14})], ServoLost, ["servo 14"], []),
    "a servo loses its id": ([("wrong_id", {"servo": 13})], ServoLost, ["servo 13"], []),
    "two servos with one id": ([("wrong_id", {"servo": 13, "value": 12})], errors.BusError, ["1"], []),
    "a servo falls silent": ([("silent", {"servo": 12})], errors.BusError, ["servo 12"], []),
    # combinations
    "overload while answers are lost": ([("overload", {"servo": 12}), ("lost", {"servo": 13, "count": 3})],
                                        errors.BusError, ["servo 1"], [12]),
    "restart while answers are damaged": ([("reboots", {"servo": 12}), ("corrupt", {"servo": 11, "count": 2})],
                                          ServoRestarted, ["servo 12"], []),
    "dead and noisy": ([("dead", {"servo": 14}), ("noise", {"count": 40})], errors.BusError, ["servo 14"], [14]),
    "restart and sag": ([("reboots", {"servo": 13}), ("low_voltage", {"value": 9.8})], errors.BusError,
                        ["servo 13 restarted"], []),
    "one dead, one overloaded": ([("dead", {"servo": 13}), ("overload", {"servo": 12})], errors.BusError, ["servo 1"],
                                 [12, 13]),
    "held and hot": ([("blocked", {"servo": 12}), ("hot", {"servo": 12, "value": 72.0})], errors.OmxError, ["2"], [12]),
    "two overloaded": ([("overload", {"servo": 12}), ("overload", {"servo": 13})], errors.ServoFault,
                       ["servo 12: overload", "servo 13: overload"], [12, 13]),
}  # fmt: skip


@pytest.mark.parametrize("name", ENDS)
def test_what_ends_a_motion(robot, tmp_path, name):
    faults, kind, words, limp = ENDS[name]
    error = run(robot, tmp_path / "a.csv", *faults)
    assert isinstance(error, kind), repr(error)
    for word in words:
        assert word in str(error)
    assert error.after < FAULT_AT + 2.5
    assert stands(robot, limp)
    kept(tmp_path / "a.csv")
    if not limp:
        assert abs(math.degrees(robot.arm.q[0]) - TARGET[0]) > 1  # it did not go on as if nothing had been


def test_there_are_at_least_thirty_of_them():
    assert len(ENDS) + len(HARMLESS) >= 30


# ---- restarts: full speed lurks behind them ----


@pytest.mark.parametrize("servo", JOINTS)
def test_a_servo_that_restarted_unseen_is_caught_before_the_next_goal(robot, servo):
    robot.arm.faults.inject("reboots", servo=servo)
    robot.clock.sleep(1.0)  # nobody looks meanwhile
    before = robot.bus.read_all(JOINTS, "goal_position")
    with pytest.raises(ServoRestarted, match=f"servo {servo}"):
        robot.write_joints(TARGET)
    assert stands(robot)
    moved = {s for s, goal in robot.bus.read_all(JOINTS, "goal_position").items() if goal != before[s]}
    assert moved <= {servo}  # no goal went out; the one that restarted stays where it is
    assert all(robot.bus.read_all(JOINTS, "profile_velocity").values())


def test_after_a_restart_the_next_move_takes_its_time(robot, tmp_path):
    assert isinstance(run(robot, tmp_path / "a.csv", ("reboots", {"servo": 11})), ServoRestarted)
    robot.arm.faults.clear()
    start = robot.q[0]
    robot.write_time(4)
    robot.write_joints([-30, -60, 20, 40])
    robot.clock.sleep(0.5)
    assert abs(robot.q[0] - start) < math.radians(15)  # at full speed it would be there
    robot.driver.wait()
    assert robot.get_joints_readings()[0][0] == pytest.approx(-30, abs=1)


def test_a_profile_that_someone_zeroed_is_written_again_before_the_goal(robot):
    robot.move_to([10, -60, 20, 40], 2)
    for servo in JOINTS:
        robot.bus.write(servo, "profile_acceleration", 0)
        robot.bus.write(servo, "profile_velocity", 0)
    robot.driver.command(np.radians([40, -60, 20, 40]), 2.0)
    assert set(robot.bus.read_all(JOINTS, "profile_velocity").values()) == {2000}


def test_another_program_that_changed_the_drive_mode_is_noticed_before_the_goal(robot):
    for servo in JOINTS:
        robot.bus.write(servo, "torque_enable", 0)
        robot.bus.write(servo, "drive_mode", 0)
        robot.bus.write(servo, "torque_enable", 1)
    with pytest.raises(NotReady, match="drive mode 0"):
        robot.write_joints(TARGET)
    robot.write_motor_state(True)
    robot.move_to(TARGET, 3)


def test_a_robot_that_finds_the_motors_on_and_not_set_up_does_not_move_at_full_speed(robot):
    for servo in JOINTS:
        robot.bus.write(servo, "torque_enable", 0)
        robot.bus.write(servo, "drive_mode", 0)
        robot.bus.write(servo, "torque_enable", 1)
    arm = robot.arm
    robot.bus.close()
    from omx.hardware.robot.driver import Driver

    driver = Driver(Bus(VirtualPort(arm, clock=SteppedClock())))
    with pytest.raises(NotReady, match="drive mode"):
        driver.command(np.radians(TARGET), 3.0)


# ---- streams and the watchdog ----


def path_ahead(robot, seconds=4.0):
    return joint_move(robot.q, np.radians(TARGET), seconds)


@pytest.mark.parametrize("pause", [0.15, 0.7, 5.0])
def test_a_stream_that_stutters_waits_on_the_path_and_goes_on(robot, pause):
    """Even if the watchdog trips meanwhile (0.4 s). A catch-up at 5 s would be a leap to the end."""
    path = path_ahead(robot)
    seen = []

    def stutter(reading, t):
        seen.append((t, *reading.q))
        if len(seen) in (40, 41, 90):
            robot.clock.sleep(pause)

    robot.follow(path, each=stutter)
    t, q = np.array(seen)[:, 0], np.array(seen)[:, 1:]
    assert np.diff(t).max() < 0.021
    wanted = np.array([path.at(moment) for moment in t])
    np.testing.assert_allclose(q, wanted, atol=math.radians(3))
    np.testing.assert_allclose(robot.get_joints_readings()[0], TARGET, atol=1.5)
    assert set(robot.bus.read_all(JOINTS, "bus_watchdog").values()) == {0}


def test_a_program_that_is_always_late_comes_to_the_end_all_the_same(robot):
    path = joint_move(robot.q, (robot.q[0] + 0.1, *robot.q[1:]), 1.0)
    robot.follow(path, each=lambda reading, t: robot.clock.sleep(0.2))
    assert robot.q[0] == pytest.approx(path.q[-1][0], abs=0.02)


def test_a_stream_that_breaks_off_stops_by_itself_and_the_next_command_works(robot):
    path = path_ahead(robot)
    for t in robot.ticks(1.0):
        robot.driver.stream_to(path.at(t + 0.02), 0.04)
    robot.clock.sleep(0.04)  # the program hangs: the last goal is all that is left
    assert stands(robot, settle=0.1)
    assert robot.arm.q[0] == pytest.approx(path.at(1.02)[0], abs=math.radians(1))
    assert set(robot.bus.read_all(JOINTS, "bus_watchdog").values()) == {0}  # no watchdog is needed for that
    robot.move_to(TARGET, 3)
    np.testing.assert_allclose(robot.get_joints_readings()[0], TARGET, atol=1.5)


def test_velocities_work_again_after_a_pause(robot):
    robot.write_mode("velocity")
    for _ in range(3):
        robot.write_velocities([15, 0, 0, 0])
        robot.clock.sleep(1.0)  # each ends by itself in between
        assert robot.get_joints_readings()[1][0] == 0
    robot.write_velocities([15, 0, 0, 0])
    robot.clock.sleep(0.2)
    assert robot.get_joints_readings()[1][0] == pytest.approx(15, abs=3)
    robot.hold()
    assert stands(robot)


@pytest.mark.parametrize("kind", ["dead", "overload", "reboots", "lost"])
def test_a_fault_in_a_stream_makes_the_arm_hold(robot, kind):
    path = path_ahead(robot)
    robot.arm.at(robot.arm.now + 1.0, lambda: robot.arm.faults.inject(kind, servo=13))
    with pytest.raises(errors.BusError, match="servo 13"):
        robot.follow(path)
    assert stands(robot, [13] if kind in ("dead", "overload") else ())
    assert abs(robot.arm.q[0]) < math.radians(45)


def test_entering_current_mode_does_not_fling_the_arm(robot):
    robot.move_to([0, -20, 0, 20], 3)
    before = np.array(robot.arm.q)
    robot.write_mode("current")
    robot.driver.soften(JOINTS)
    robot.clock.sleep(0.1)
    np.testing.assert_allclose(robot.arm.q, before, atol=math.radians(1))
    robot.hold()
    assert stands(robot)


# ---- the plug ----


def test_the_plug_pulled_out_in_mid_move(robot, tmp_path):
    error = run(robot, tmp_path / "a.csv", ("unplugged", {}))
    assert isinstance(error, errors.PortLost)
    for word in ("USB plug", "holds there", "reopen"):
        assert word in str(error)
    kept(tmp_path / "a.csv")
    assert stands(robot, settle=SECONDS)
    robot.arm.faults.clear()
    robot.bus.reopen()
    np.testing.assert_allclose(robot.get_joints_readings()[0], TARGET, atol=1.5)  # it ended its move, and held
    robot.move_to([0, -60, 20, 40], 4)
    assert stands(robot)


def test_the_plug_pulled_out_of_a_stream(robot):
    robot.arm.at(robot.arm.now + 1.0, lambda: robot.arm.faults.inject("unplugged"))
    with pytest.raises(errors.PortLost):
        robot.follow(path_ahead(robot))
    assert stands(robot)  # the servos' own watchdog
    robot.arm.faults.clear()
    robot.bus.reopen()
    robot.clock.sleep(1.0)
    robot.move_to(TARGET, 4)


def test_closing_after_the_plug_was_pulled_is_quiet(robot):
    robot.arm.faults.inject("unplugged")
    with pytest.raises(errors.PortLost):
        robot.get_joints_readings()
    robot.close()
    robot.close()


def test_a_second_opener_is_refused_and_does_no_harm(robot, tmp_path):
    def second(share):
        with pytest.raises(errors.PortBusy):
            Bus(VirtualPort(robot.arm))

    assert run(robot, tmp_path / "a.csv", each=second) is None
    np.testing.assert_allclose(robot.get_joints_readings()[0], TARGET, atol=1.5)


# ---- interrupts ----


class Interrupts:
    """A Ctrl-C at the n-th time that bytes are read or written, and not again; or something else that `happens`."""

    def __init__(self, monkeypatch, name, n, happens=None):
        self.left, original = n, getattr(VirtualSerial, name)

        def interrupted(line, *args):
            self.left -= 1
            if self.left == 0 and happens is None:
                raise KeyboardInterrupt
            if self.left == 0:
                happens()
            return original(line, *args)

        monkeypatch.setattr(VirtualSerial, name, interrupted)


@pytest.mark.parametrize("name", ["read", "write"])
@pytest.mark.parametrize("n", [80, 81, 82, 83])
def test_an_interrupt_inside_a_transaction(robot, tmp_path, monkeypatch, name, n):
    robot.write_time(SECONDS)
    robot.write_joints(TARGET)
    Interrupts(monkeypatch, name, n)
    with pytest.raises(KeyboardInterrupt):
        robot.log(LOGGED, tmp_path / "a.csv")
    assert stands(robot)
    assert math.degrees(robot.arm.q[0]) < TARGET[0] - 10
    assert len(read_log(tmp_path / "a.csv")) >= 5
    with pytest.raises(Stopped, match="interrupted"):
        robot.move_to([0, -60, 20, 40], 4)
    robot.resume()
    robot.move_to([0, -60, 20, 40], 4)


def calls_of(action):
    """1, 2, 3 ... up to the last transaction of `action(n)`, which is False when no interrupt came."""
    return itertools.takewhile(action, itertools.count(1))


def test_no_interrupt_anywhere_in_a_change_of_mode_leaves_a_motor_off(monkeypatch):
    def interrupted_at(n):
        robot = Robot(clock=SteppedClock())
        robot.write_motor_state(True)
        with monkeypatch.context() as patch:
            interrupts = Interrupts(patch, "write", n)
            try:
                robot.write_mode("current")
                robot.write_currents([0, 0, 0, 0])
            except KeyboardInterrupt:
                assert all(robot.arm.servo(servo).torque_on for servo in JOINTS)
        robot.hold()
        assert stands(robot)
        robot.bus.close()
        return interrupts.left <= 0

    assert len(list(calls_of(interrupted_at))) > 40


def test_no_interrupt_anywhere_in_a_command_leaves_the_arm_moving(robot, monkeypatch):
    def interrupted_at(n):
        with monkeypatch.context() as patch:
            interrupts = Interrupts(patch, "write", n)
            try:
                robot.write_joints([60 * (-1) ** n, -60, 20, 40])
            except KeyboardInterrupt:
                assert stands(robot)
        robot.resume()
        robot.hold()
        return interrupts.left <= 0

    assert len(list(calls_of(interrupted_at))) >= 5


@pytest.mark.parametrize("end", ["close", "hold"])
def test_no_interrupt_anywhere_in_the_end_of_a_program_leaves_the_arm_moving(monkeypatch, end):
    def interrupted_at(n):
        robot = Robot(clock=SteppedClock())
        robot.write_motor_state(True)
        robot.write_time(3)
        robot.write_joints([60, -60, 20, 40])
        robot.clock.sleep(1.0)
        with monkeypatch.context() as patch:
            interrupts = Interrupts(patch, "write", n)
            with contextlib.suppress(KeyboardInterrupt):
                getattr(robot, end)()
        robot.bus.close()
        for _ in range(2):
            robot.arm.advance(robot.arm.now + 0.5)
            before, after = (robot.arm.q, robot.arm.advance(robot.arm.now + 0.5))[0], robot.arm.q
        if interrupts.left <= 0:
            np.testing.assert_allclose(before, after, atol=1e-3)
        return interrupts.left <= 0 and n < 9

    assert len(list(calls_of(interrupted_at))) >= 3


@pytest.mark.parametrize("servo", JOINTS)
def test_a_servo_lost_in_a_change_of_mode_leaves_the_others_on(robot, servo):
    robot.write_mode("current")
    robot.arm.faults.inject("lost", servo=servo, after=6)
    with pytest.raises(errors.BusTimeout):
        robot.write_currents([0, 0, 0, 0])
    robot.arm.faults.clear()
    robot.hold()
    assert stands(robot)


@pytest.mark.parametrize("k", [5, 15, 30, 45])
def test_a_servo_that_restarts_while_its_mode_is_changed_is_caught_before_the_line_is_closed(monkeypatch, k):
    robot = Robot(clock=SteppedClock())
    robot.write_motor_state(True)
    robot.move_to([0, -40, 10, 30])
    Interrupts(monkeypatch, "write", k, lambda: robot.arm.faults.inject("reboots", servo=12))
    with contextlib.suppress(errors.BusError), robot:
        robot.write_mode("current")
        robot.write_currents([0, 0, 0, 0])
    assert not robot.bus.is_open
    on = [robot.arm.servo(servo).torque_on for servo in JOINTS]
    assert all(on) or (not any(on) and robot.arm.q[1] < math.radians(-70)), "it holds, or it has been parked"


@pytest.mark.parametrize("look", range(5))
def test_a_servo_that_restarts_while_the_arm_parks_does_not_let_it_fall(robot, look):
    """Whoever notices, the watch, which looks at every fifth look of the parking, or the parking itself."""
    robot.arm.faults.inject("reboots", servo=14, after=0.5 + 0.02 * look)
    with pytest.raises(ServoRestarted, match="servo 14"):
        robot.park()
    assert stands(robot)
    robot.park()
    assert not robot.driver.torque


def test_an_arm_that_does_not_come_to_its_rest_pose_keeps_its_motors_on(robot):
    robot.arm.servo(14).table.put("goal_pwm", 20)  # another program
    with pytest.raises(errors.NotArrived, match="servo 14 pushes with at most 2 %"):
        robot.park()
    assert all(robot.arm.servo(servo).torque_on for servo in JOINTS)


def test_a_packet_that_a_servo_got_damaged_is_sent_again(robot, monkeypatch):
    """Its answer says so: nothing was done, and nothing is wrong with the servo."""
    sent, left = VirtualSerial.write, [1, 1]

    def garbled(line, data):
        spoilt = left.pop() if left and data[7] in (2, 3) else 0  # READ, WRITE
        return sent(line, data[:-1] + bytes([data[-1] ^ spoilt]))

    monkeypatch.setattr(VirtualSerial, "write", garbled)
    robot.write_gripper(True)
    assert not left


@pytest.mark.parametrize("error", [ZeroDivisionError, KeyboardInterrupt, SystemExit])
def test_an_error_in_a_callback_makes_the_arm_hold_and_keeps_the_log(robot, tmp_path, error):
    def broken(share):
        if share > 0.3:
            raise error

    robot.write_time(SECONDS)
    robot.write_joints(TARGET)
    with pytest.raises(error):
        robot.log(LOGGED, tmp_path / "a.csv", progress=broken)
    assert stands(robot)
    assert abs(math.degrees(robot.arm.q[0]) - TARGET[0]) > 5
    assert len(read_log(tmp_path / "a.csv")) >= 50


@pytest.mark.skipif(sys.platform == "win32", reason="needs a limit on the size of files")
def test_a_disk_that_fills_up_in_mid_move_makes_the_arm_hold_and_loses_no_sample(robot, tmp_path):
    import resource

    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    robot.write_time(SECONDS)
    robot.write_joints(TARGET)
    try:
        resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, limits[1]))
        with pytest.raises(LogError, match=r"File too large after \d+ samples on the disk") as caught:
            robot.log(LOGGED, tmp_path / "a.csv")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    samples = np.array(caught.value.samples)
    assert len(samples) > 50
    np.testing.assert_allclose(np.diff(samples[:, 0]), 0.02, atol=1e-6)
    assert len(read_log(tmp_path / "a.csv")) == len(samples) - 1  # the last one did not fit
    assert stands(robot)
    assert abs(math.degrees(robot.arm.q[0]) - TARGET[0]) > 5


def test_a_stop_between_the_check_and_the_goal_wins(robot, monkeypatch):
    """Whenever the stop comes, the arm stands afterwards."""
    sent = robot.driver.servos.send

    def stopped_before(*motion):
        robot.driver.brake.latch()
        sent(*motion)

    monkeypatch.setattr(robot.driver.servos, "send", stopped_before)
    with pytest.raises(Stopped):
        robot.write_joints(TARGET)
    monkeypatch.undo()
    assert stands(robot)
    with pytest.raises(Stopped):
        robot.write_joints(TARGET)


@pytest.mark.parametrize("other", ["write_joints", "velocities"])
def test_a_second_thread_cannot_get_between_the_check_and_the_goal(robot, monkeypatch, other):
    """A goal that is sent in mid-motion would leave the line that was checked: two cells, or a cell and a panel."""
    sent, speeds = robot.driver.send, []
    if other == "velocities":
        robot.write_mode("velocity")
        second = threading.Thread(target=lambda: robot.write_velocities([-20, 0, 0, 0]))
    else:
        second = threading.Thread(target=lambda: robot.write_joints([-60, -60, 20, 40]))

    def disturbed(*motion, **more):
        if not second.ident:
            second.start()
            second.join(0.5)
            robot.clock.sleep(0.3)
        speeds.append(max(map(abs, robot.driver.monitor.look().aim_speed)))
        return sent(*motion, **more)

    monkeypatch.setattr(robot.driver, "send", disturbed)
    if other == "velocities":
        robot.write_velocities([20, 0, 0, 0])
        second.join()
        assert len(speeds) == 2
        assert robot.driver.monitor.look().aim_speed[0] < 0, "one after the other"
    else:
        robot.write_joints(TARGET)
        second.join()
        assert speeds == [0.0, 0.0]


@pytest.mark.parametrize("again", ["hold", "stop"])
def test_holding_again_and_again_does_not_let_the_arm_sink(robot, again):
    robot.move_to([0, 0, 0, 0])
    robot.hold()
    time_passes(robot, 1.0)
    before = robot.arm.q
    for _ in range(20):
        getattr(robot, again)()
        time_passes(robot, 0.3)
    np.testing.assert_allclose(robot.arm.q, before, atol=math.radians(0.2))


# ---- after the fault ----


def test_a_with_block_whose_servo_is_dead_ends_holding_and_closed():
    robot = Robot(clock=SteppedClock())

    def program():
        with robot:
            robot.write_motor_state(True)
            robot.write_time(3)
            robot.write_joints(TARGET)
            robot.arm.faults.inject("dead", servo=14, after=1.0)
            robot.driver.wait()

    with pytest.raises(ServoLost, match="servo 14"):
        program()
    assert not robot.bus.is_open
    assert stands(robot, [14])


def test_nothing_is_commanded_while_a_joint_is_limp(robot):
    robot.arm.faults.inject("overload", servo=13)
    with pytest.raises(errors.ServoFault):
        robot.get_joints_readings()
    before = robot.bus.read_all(JOINTS, "goal_position")
    for attempt in (lambda: robot.write_joints(TARGET), robot.park, lambda: robot.move_to(TARGET)):
        with pytest.raises(errors.ServoFault, match="servo 13"):
            attempt()
    assert robot.bus.read_all(JOINTS, "goal_position") == before
    assert stands(robot, [13])
    robot.arm.faults.clear()
    assert robot.recover() == [13]
    robot.move_to([0, -60, 20, 40])  # slowly, as it sank out of its limits


def test_motors_that_are_off_are_not_switched_on_by_a_fault(robot):
    robot.park()
    robot.arm.faults.inject("lost", servo=12, count=2)
    with pytest.raises(errors.BusTimeout):
        robot.get_joints_readings()
    assert not any(robot.bus.read_all(JOINTS, "torque_enable").values())
    with pytest.raises(TorqueOff):
        robot.write_joints(TARGET)


# ---- the kernel is killed ----

VICTIM = """
    import sys, numpy as np
    from omx.hardware.robot import Robot
    from omx.motion.trajectory import joint_move
    robot = Robot(sys.argv[1])
    robot.write_motor_state(True)
    def tell(reading, t=0):
        if reading.q[0] > 0.2:
            print("on its way", flush=True)
    if sys.argv[2] == "move":
        robot.write_time(2)
        robot.write_joints([60, -25, 5, 25])
        robot.log(60, sys.argv[3], progress=lambda share: tell(robot.driver.read()))
    else:
        robot.follow(joint_move(robot.q, np.radians([60, -25, 5, 25]), 2), each=tell)
"""


def until(true, seconds=30.0):
    """Wait for it, as long as a busy computer may take."""
    end = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < end
        time.sleep(0.05)


@pytest.mark.parametrize("how", ["move", "stream"])
def test_the_kernel_is_killed_while_the_arm_moves(tmp_path, how):
    with Served("--tcp", "0") as served:
        command = [sys.executable, "-c", textwrap.dedent(VICTIM), served.name, how, str(tmp_path / "a.csv")]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as victim:
            assert victim.stdout.readline() == "on its way\n"
            victim.kill()
            assert victim.wait() == (-signal.SIGKILL if sys.platform != "win32" else 1)
        robot = Robot(served.name)
        assert robot.driver.torque
        until(lambda: not any(robot.driver.read().aim_speed))
        until(lambda: np.abs(robot.get_joints_readings()[1]).max() < 1.0)
        if how == "move":
            np.testing.assert_allclose(robot.get_joints_readings()[0], TARGET, atol=1.5)
            assert len(read_log(tmp_path / "a.csv")) > 10
        robot.move_to(np.degrees(omx.HOME), 1.5)
        np.testing.assert_allclose(robot.q, omx.HOME, atol=0.03)
        robot.bus.close()


NOTEBOOK = """
    from IPython.core.interactiveshell import InteractiveShell
    shell = InteractiveShell.instance()
    def cell(text):
        return shell.run_cell(text)
    cell("from omx.hardware.robot import Robot\\nrobot = Robot()\\nrobot.write_motor_state(True)\\nrobot.write_time(3)")
    cell("robot.write_joints([60, -25, 5, 25]); robot.clock.sleep(0.5); raise KeyboardInterrupt")
    cell("robot.clock.sleep(3.5); q = robot.get_joints_readings()[0]; robot.resume()")
    cell("robot.write_gripper(True); robot.clock.sleep(2)")
    cell("robot.write_gripper(False); robot.clock.sleep(0.2); raise KeyboardInterrupt")
    cell("robot.clock.sleep(2); opening = robot.arm.opening; on = robot.driver.torque; robot.bus.close()")
    print("stood at", round(shell.user_ns["q"][0]), round(shell.user_ns["opening"]), shell.user_ns["on"])
"""


def test_an_interrupted_cell_makes_a_moving_arm_hold_and_its_fingers(tmp_path):
    command = [sys.executable, "-c", textwrap.dedent(NOTEBOOK)]
    env = {**os.environ, "IPYTHONDIR": str(tmp_path)}
    done = subprocess.run(command, capture_output=True, text=True, timeout=90, check=False, env=env)
    where, opening, on = done.stdout.splitlines()[-1].removeprefix("stood at ").split()
    assert on == "True"
    assert 0 < int(where) < 45
    assert 45 < int(opening) < 60
