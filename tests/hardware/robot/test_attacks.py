"""Attacks that no list had: threads and signals in the middle, garbage collection, fingers at a stop, damaged files."""

import contextlib
import gc
import math
import threading

import numpy as np
import pytest

from omx.arm import ARM_IDS, JOINT_IDS
from omx.errors import (
    BadInput,
    Collision,
    ObjectLost,
    OmxError,
    PortBusy,
    PortLost,
    ServoFault,
    ServoLost,
    ServoRestarted,
    Stopped,
    TorqueOff,
)
from omx.geometry import COURSE
from omx.hardware.dynamixel.registers import MODES, PRESENT
from omx.hardware.robot import Robot, modes, rescue
from omx.hardware.robot.calibration import Calibration
from omx.hardware.simulator import SteppedClock, VirtualArm, VirtualPort
from omx.hardware.simulator.virtual_port import VirtualSerial
from omx.motion.trajectory import Trajectory, joint_move

TARGET = [60, -25, 5, 25]


def on(robot):
    """The joints whose motors are on, by the servos' own registers."""
    return [servo for servo in JOINT_IDS if robot.arm.servo(servo).torque_on]


def at_the(n, name, happens, monkeypatch):
    """`happens()` inside the n-th call of the line's `name`, in the same thread, as a signal's handler would."""
    original, left = getattr(VirtualSerial, name), [n]

    def called(line, *args):
        left[0] -= 1
        if left[0] == 0:
            happens()
        return original(line, *args)

    monkeypatch.setattr(VirtualSerial, name, called)
    return left


def meanwhile(action):
    """A thread that does `action` when it is started, and the errors that it met."""
    met = []

    def run():
        try:
            action()
        except OmxError as error:
            met.append(error)

    return threading.Thread(target=run), met


def watches_still(robot, caplog):
    """Does the watch notice a joint that is held, though nobody asks?"""
    robot.write_joints([*np.degrees(robot.q)[:1] + 30, -60, 20, 40])
    robot.arm.faults.inject("blocked", servo=11, value=0.01, after=0.2)
    robot.clock.sleep(3)
    robot.arm.faults.clear()
    return "joint 1 is pushing on something" in caplog.text


# ---- signals: in the same thread, inside a transaction ----


def stopped_and_resumed(robot):
    robot.stop()
    robot.resume()


@pytest.mark.parametrize("name", ["write", "read"])
@pytest.mark.parametrize(("n", "resumed"), [*((n, False) for n in range(1, 13)), (1, True), (4, True), (8, True)])
def test_a_stop_from_a_signals_handler_wins_wherever_it_comes(robot, monkeypatch, name, n, resumed):
    robot.clock.sleep(0.5)
    before = robot.arm.q
    with monkeypatch.context() as patch:
        left = at_the(n, name, lambda: stopped_and_resumed(robot) if resumed else robot.stop(), patch)
        with contextlib.suppress(Stopped):
            robot.write_joints(TARGET)
            assert left[0] > 0
    if left[0] > 0 or resumed:
        robot.stop()
    robot.clock.sleep(0.3)
    there = robot.arm.q
    robot.clock.sleep(2.0)
    np.testing.assert_allclose(robot.arm.q, there, atol=math.radians(0.3))
    np.testing.assert_allclose(there, before, atol=math.radians(1.0))
    assert robot.bus.is_open
    with pytest.raises(Stopped):
        robot.write_joints(TARGET)
    robot.resume()
    robot.move_to(TARGET)


@pytest.mark.parametrize("act", ["write_gripper", "write_joints", "park"])
def test_a_stop_just_after_the_look_at_the_latch_wins(robot, monkeypatch, act):
    robot.clock.sleep(0.5)
    servos = [robot.arm.servo(servo) for servo in (11, 12, 13, 14, 15)]
    before, brake = [servo.joint.angle for servo in servos], robot.driver.brake
    look = brake.refuse_if_latched

    def late():
        look()
        monkeypatch.undo()
        robot.stop()

    monkeypatch.setattr(brake, "refuse_if_latched", late)
    with pytest.raises(Stopped):
        {"write_gripper": lambda: robot.write_gripper(False), "write_joints": lambda: robot.write_joints(TARGET)}.get(
            act, robot.park
        )()
    robot.clock.sleep(3.0)
    np.testing.assert_allclose([servo.joint.angle for servo in servos], before, atol=math.radians(1.0))


# ---- threads ----


def test_a_look_while_the_motors_go_off_does_not_switch_them_on_again(robot, monkeypatch):
    """A panel looks ten times a second, and once a second whether every motor is on."""

    def look():
        robot.driver.monitor._health_at = 0.0
        robot.get_joints_readings()

    (other, met), put, calls = meanwhile(look), robot.driver.servos.put, []

    def slow(*args):
        put(*args)
        calls.append(args)
        if len(calls) == 2:
            other.start()
            other.join(0.3)

    monkeypatch.setattr(robot.driver.servos, "put", slow)
    robot.relax()
    other.join()
    assert not on(robot)
    assert met == []


def test_a_stop_while_joints_change_their_mode_leaves_all_on_and_the_watch_awake(robot, monkeypatch, caplog):
    robot.write_mode("current")
    robot.write_currents([0, 0, 0, 0])
    (other, met), put = meanwhile(robot.stop), robot.driver.servos.put

    def slow(servo, name, value):
        put(servo, name, value)
        if (servo, name, value) == (12, "torque_enable", 0) and not other.ident:
            other.start()
            other.join(0.3)

    monkeypatch.setattr(robot.driver.servos, "put", slow)
    robot.hold()
    other.join()
    assert met == []
    assert on(robot) == list(JOINT_IDS)
    assert set(robot.bus.read_all(JOINT_IDS, "operating_mode").values()) == {MODES["position"]}
    robot.resume()
    assert watches_still(robot, caplog)


def test_nothing_sets_off_between_the_rest_pose_and_the_torque(robot, monkeypatch):
    (other, met), relax = meanwhile(lambda: robot.write_joints(TARGET)), robot.driver.relax

    def slow():
        other.start()
        other.join(0.3)
        robot.clock.sleep(0.5)
        relax()

    monkeypatch.setattr(robot.driver, "relax", slow)
    robot.park()
    other.join()
    assert [type(error) for error in met] == [TorqueOff]
    assert robot.arm.q[1] < math.radians(-80)


def test_fingers_are_not_switched_on_again_while_another_thread_switches_off(robot, monkeypatch):
    robot.bus.write(15, "torque_enable", 0)
    (other, _), catch = meanwhile(robot.relax), rescue.catch

    def slow(*args):
        other.start()
        other.join(0.3)
        catch(*args)

    monkeypatch.setattr(rescue, "catch", slow)
    with pytest.raises(ServoRestarted):
        robot.write_gripper(True)
    other.join()
    assert not on(robot)
    assert not robot.arm.servo(15).torque_on
    assert not robot.driver.torque


@pytest.mark.parametrize("act", ["recover", "grip", "push", "hold"])
def test_motors_that_another_thread_let_go_just_before_stay_off(robot, monkeypatch, act):
    alone = robot.driver.watcher.alone
    if act in ("push", "hold"):
        robot.write_mode("current")
    if act == "hold":
        robot.write_currents([0, 0, 0, 0])

    def late():
        monkeypatch.undo()
        robot.relax()
        return alone()

    monkeypatch.setattr(robot.driver.watcher, "alone", late)
    acts = {"recover": robot.recover, "grip": robot.grip, "push": lambda: robot.write_currents([0] * 4)}
    with contextlib.suppress(TorqueOff) if act in ("recover", "hold") else pytest.raises(TorqueOff):
        acts.get(act, robot.hold)()
    robot.clock.sleep(3.0)
    assert not on(robot)
    assert not robot.arm.servo(15).torque_on
    assert not robot.driver.torque


def test_a_change_of_mode_and_a_push_do_not_mix_with_what_another_thread_commands(robot, monkeypatch):
    (other, met), stiffen = meanwhile(lambda: robot.write_joints(TARGET)), robot.driver.stiffen

    def slow():
        other.start()
        other.join(0.3)
        stiffen()

    with monkeypatch.context() as patch:
        patch.setattr(robot.driver, "stiffen", slow)
        robot.write_mode("velocity")
    other.join()
    assert [type(error) for error in met] == [BadInput]  # joints in velocity mode
    for push in (lambda: robot.write_currents([0, 0, 0, 0]), lambda: modes.balance(robot.driver)):
        robot.write_mode("current")
        (other, met), forecast = meanwhile(lambda: robot.write_mode("position")), robot.driver.push.forecast

        def held_up(*args, other=other, forecast=forecast):
            if not other.ident:
                other.start()
                other.join(0.3)
            return forecast(*args)

        with monkeypatch.context() as patch:
            patch.setattr(robot.driver.push, "forecast", held_up)
            push()
        other.join()
        assert met == []
        assert robot.driver.mode == "position"
        assert not robot.driver.push
        assert set(robot.bus.read_all(JOINT_IDS, "operating_mode").values()) == {MODES["position"]}


def test_two_that_ask_at_once_are_told_once(robot):
    class Emptied(list):
        def __bool__(self):
            self.clear()  # the other was first
            return True

    robot.driver.watcher.troubles = Emptied([TorqueOff()])
    with contextlib.suppress(TorqueOff):
        robot.get_joints_readings()


def test_a_bus_that_another_thread_asks_is_waited_for(robot, monkeypatch):
    """The watch lets its own thread end a transaction first; a thread that reads without a pause does not blind it."""
    asking = []

    def look():
        asking.append(robot.bus.asking)
        other = threading.Thread(target=lambda: asking.append(robot.bus.asking))
        other.start()
        other.join()

    at_the(1, "read", look, monkeypatch)
    robot.bus.read(11, "led")
    assert asking == [True, False]


def test_an_error_of_a_kind_that_nobody_expects_does_not_end_the_watch(robot, monkeypatch, caplog):
    with monkeypatch.context() as patch:
        patch.setattr(robot.driver.monitor, "look", lambda: {}["no such servo"])
        with pytest.raises(KeyError):
            robot.clock.sleep(2)
    assert watches_still(robot, caplog)


def test_a_motion_that_was_stopped_does_not_go_on_because_somebody_resumed(robot):
    robot.clock.later(1.0, lambda: stopped_and_resumed(robot))
    with pytest.raises(Stopped):
        robot.move_to(TARGET, 3)
    there = robot.arm.q
    path = joint_move(robot.q, np.radians([0, -60, 20, 40]), 4.0)
    steps = []

    def pressed(reading, t):
        steps.append(t)
        if len(steps) == 20:
            stopped_and_resumed(robot)

    with pytest.raises(Stopped):
        robot.follow(path, each=pressed)
    assert len(steps) == 20
    leader = [*np.degrees(robot.q)]

    def led():
        steps.append(0.0)
        if len(steps) == 40:
            stopped_and_resumed(robot)
        return leader

    with pytest.raises(Stopped):
        robot.follow_leader(led, 5.0)
    assert len(steps) == 40
    robot.clock.sleep(1.0)
    np.testing.assert_allclose(robot.arm.q[1:], there[1:], atol=math.radians(6))


def test_a_stop_between_two_calls_ends_what_the_first_began_though_somebody_resumed(robot):
    sent = robot.driver.command(np.radians(TARGET), 3)
    stopped_and_resumed(robot)
    with pytest.raises(Stopped):
        robot.driver.arrive(sent)
    for opened in (True, False):
        robot.write_gripper(opened)
        stopped_and_resumed(robot)
        with pytest.raises(Stopped):
            robot.driver.settle()
    robot.write_joints(TARGET)
    robot.clock.sleep(0.5)
    robot.clock.later(0.02, lambda: stopped_and_resumed(robot))
    with pytest.raises(Stopped):  # it was only coming to rest for this one
        robot.write_joints([0, -60, 20, 40])
    there = robot.arm.q
    robot.clock.sleep(2.0)
    np.testing.assert_allclose(robot.arm.q, there, atol=math.radians(2))


# ---- a robot that nobody has any more, and a port that two have ----


def test_an_arm_that_nobody_has_any_more_holds_and_its_motors_are_spoken_of(caplog):
    arm = VirtualArm()
    port = VirtualPort(arm, clock=SteppedClock())
    port.port_name = "/dev/ttyUSB0"

    def program():
        robot = Robot(port)
        robot.write_motor_state(True)
        robot.write_time(4)
        robot.write_joints(TARGET)
        robot.clock.sleep(1.0)

    program()
    gc.collect()
    assert "MOTORS ARE ON" in caplog.text
    assert "Robot('/dev/ttyUSB0')" in caplog.text
    assert not port.is_open
    arm.advance(arm.now + 0.5)
    there = arm.q
    arm.advance(arm.now + 4.0)
    np.testing.assert_allclose(arm.q, there, atol=math.radians(0.2))
    assert 1 < math.degrees(there[0]) < 30


def test_one_port_has_one_bus(robot):
    with pytest.raises(PortBusy, match="another bus"):
        Robot(robot.bus._port)
    robot.move_to(TARGET)


def test_a_robot_that_was_closed_leaves_the_port_to_the_one_in_use():
    port = VirtualPort(clock=SteppedClock())
    with Robot(port) as robot:
        pass
    first = robot.bus
    with Robot(port) as robot:  # the name is bound anew: nobody has the first any more
        gc.collect()
        robot.write_motor_state(True)
        first.close()
        assert not first.is_open
        with pytest.raises(PortLost, match="closed"):
            first.ping(11)
        for steal in (first.reopen, lambda: first.tune(57_600)):
            with pytest.raises(PortBusy, match="another bus"):
                steal()
        robot.move_to(TARGET)
        robot.stop()
    robot = Robot(port)  # motors on
    gc.collect()
    assert robot.bus.is_open
    robot.park()


@pytest.mark.parametrize("options", [
    {"port": 5}, {"port": ["/dev/ttyUSB0"]}, {"idle_s": -1}, {"idle_s": float("nan")}, {"idle_s": "60"},
    {"calibration": 5}, {"calibration": {"offsets": [0, 0, 0, 0]}},
    {"calibration": Calibration(COURSE, (0, 0.5, 0, 0))},
    {"calibration": Calibration(COURSE, (0, math.nan, 0, 0))},
])  # fmt: skip
def test_what_an_arm_cannot_be_opened_with_is_bad_input(options):
    with pytest.raises(BadInput):
        Robot(**options)


def test_a_number_that_is_too_small_is_told_how_small_it_may_be(robot, tmp_path):
    robot.log(0.1, tmp_path / "log.csv")
    for least, ask in {
        "0.001 s": lambda: Robot(idle_s=1e-4),
        "0.001 ..": lambda: robot.write_time(1e-4),
        "0.001,": lambda: robot.replay(tmp_path / "log.csv", speed=1e-4),
        "1e-9 s": lambda: robot.driver.guard.seconds(robot.q, robot.q, 1e-10),
    }.items():
        with pytest.raises(BadInput, match=least):
            ask()


# ---- the gripper ----


@pytest.mark.parametrize("after", [0.0, 0.002, 0.01, 0.05, 0.25, 0.5])
def test_a_stop_stops_the_fingers_too(robot, after):
    robot.write_gripper(True)
    robot.clock.sleep(2.0)
    robot.write_gripper(False)
    robot.clock.sleep(after)
    opening = robot.arm.opening
    robot.stop()
    robot.clock.sleep(2.0)
    assert robot.arm.opening == pytest.approx(opening, abs=8)
    assert robot.arm.opening > 10
    with pytest.raises(Stopped):
        robot.write_gripper(False)


def test_a_stop_with_a_dead_joint_stops_the_fingers_first(robot):
    robot.write_gripper(True)
    robot.clock.sleep(2.0)
    robot.write_gripper(False)
    robot.clock.sleep(0.1)
    opening = robot.arm.opening
    robot.arm.faults.inject("dead", servo=12)
    with pytest.raises(ServoLost):
        robot.stop()
    robot.clock.sleep(2.0)
    assert robot.arm.opening == pytest.approx(opening, abs=12)
    assert robot.arm.opening > 20


def test_a_stop_ends_the_wait_for_the_fingers_though_somebody_resumed(robot):
    robot.driver.carry(100)
    for act in (robot.grip, robot.release):
        robot.clock.later(0.2, lambda: stopped_and_resumed(robot))
        with pytest.raises(Stopped):
            act()
    assert robot.driver.guard.payload_g == 100


def test_a_stop_does_not_let_go_of_what_is_held(robot):
    robot.arm.grip(30.0, 100.0)
    assert robot.grip().holding
    robot.stop()
    robot.clock.sleep(5.0)
    assert robot.arm.grasped.carried
    assert robot.holding


def test_a_stop_just_after_the_fingers_were_told_to_open_keeps_what_they_press_on(robot):
    robot.arm.grip(30.0, 100.0)
    assert robot.grip().holding
    robot.write_gripper(True)
    robot.stop()
    robot.clock.sleep(5.0)
    assert robot.arm.grasped.carried
    assert robot.holding


def test_a_speed_of_one_step_is_noise_to_fingers_that_hold_something(robot, monkeypatch):
    robot.arm.grip(30.0, 100.0)
    assert robot.grip().holding
    read_block = robot.bus.read_block

    def noisy(servos, *what):
        found = read_block(servos, *what)
        if list(servos) != [15]:
            return found
        names = [row.name for row in (what[0] if what else PRESENT).registers]
        speed = names.index("present_velocity") if "present_velocity" in names else None
        return {15: tuple(1 if i == speed else value for i, value in enumerate(found[15]))}

    with monkeypatch.context() as patch:
        patch.setattr(robot.bus, "read_block", noisy)
        robot.stop()
        assert robot.holding
    robot.clock.sleep(5.0)
    assert robot.arm.grasped.carried
    assert robot.holding


def test_an_interrupt_while_the_fingers_close_stops_them(robot, monkeypatch):
    robot.release()
    sleep, left = robot.clock.sleep, [3]

    def interrupted(seconds):
        left[0] -= 1
        if left[0] == 0:
            raise KeyboardInterrupt
        sleep(seconds)

    with monkeypatch.context() as patch:
        patch.setattr(robot.clock, "sleep", interrupted)
        with pytest.raises(KeyboardInterrupt):
            robot.grip()
    opening = robot.arm.opening
    robot.clock.sleep(2.0)
    assert robot.arm.opening == pytest.approx(opening, abs=8)
    assert robot.driver.stopped == "interrupted"


@pytest.mark.parametrize("kind", ["reboots", "overload"])
def test_a_gripper_whose_motor_goes_off_has_lost_what_it_held(robot, kind):
    robot.arm.grip(30.0, 100.0)
    assert robot.grip().holding
    robot.arm.faults.inject(kind, servo=15, after=0.1)
    told = []
    for _ in range(4):
        robot.clock.sleep(1.5)
        try:
            robot.get_joints_readings()
        except OmxError as error:  # that it was silent for a moment, if anybody looked just then
            told.append(error)
    assert [error.limp for error in told if isinstance(error, ObjectLost)] == [True]
    robot.move_to(TARGET)  # told once; the arm goes on, and parks
    with pytest.raises((ServoFault, ServoRestarted), match="servo 15"):
        robot.write_gripper(False)
    robot.park()


# ---- what is said ----


def test_an_overload_is_called_so_wherever_it_comes(monkeypatch):
    def on_and_off(n):
        robot = Robot(clock=SteppedClock())
        with monkeypatch.context() as patch, robot:
            at_the(n, "write", lambda: robot.arm.faults.inject("overload", servo=13), patch)
            robot.write_motor_state(True)
            robot.move_to(TARGET)

    for n in range(1, 20):
        with pytest.raises(ServoFault, match="servo 13: overload"):
            on_and_off(n)


def test_a_weak_supply_is_told_once_until_it_has_been_away(caplog):
    def told():
        return sum("has only 10." in record.getMessage() for record in caplog.records)

    arm = VirtualArm()
    arm.faults.inject("low_voltage", value=10.7)
    arm.advance(0.1)
    robot = Robot(VirtualPort(arm, clock=SteppedClock()), idle_s=None)
    assert told() == 1
    assert all(f"servo {servo} has only" in caplog.text for servo in ARM_IDS)
    robot.write_motor_state(True)
    for goal in (TARGET, [0, -60, 20, 40]):
        robot.move_to(goal)
        robot.clock.sleep(60.0)
    assert told() == 1
    arm.faults.clear()
    robot.clock.sleep(90.0)
    arm.faults.inject("low_voltage", value=10.7)
    robot.clock.sleep(60.0)
    assert told() == 2


def test_each_servo_that_gets_warm_is_told(robot, caplog):
    for servo, degrees in ((11, 61), (13, 65)):
        robot.arm.faults.inject("hot", servo=servo, value=degrees)
        robot.clock.sleep(70.0)
    told = [record.getMessage() for record in caplog.records if "servo 1" in record.getMessage()]
    assert len(told) == 2
    assert "servo 11" in told[0]
    assert "servo 13" in told[1]


# ---- paths and files that are not what they seem ----


def bent(path, **changed):
    """`path` with other samples."""
    return Trajectory(**{**{name: getattr(path, name).copy() for name in ("t", "q", "qd", "qdd")}, **changed})


def test_a_path_is_looked_through_whole_before_its_first_step(robot):
    before = robot.arm.q
    path = joint_move(robot.q, np.radians(TARGET), 8.0)
    many = joint_move(robot.q, np.radians(TARGET), 80.0)
    nan, fast, dips, wide = path.q.copy(), path.qd.copy(), many.q.copy(), np.zeros((len(path.t), 6))
    nan[7, 2], fast[9, 1] = math.nan, math.nan
    middle = len(dips) // 2
    dips[middle + 1 : middle + 4, 1] = 1.3  # into the table, between two of 200 looks
    for wrong in (bent(path, q=nan), bent(path, qd=fast), bent(path, q=wide), "path", None):
        with pytest.raises(BadInput):
            robot.follow(wrong)
    with pytest.raises(Collision):
        robot.follow(bent(many, q=dips))
    assert robot.arm.q == before


def test_an_arm_does_not_lead_itself(robot):
    with pytest.raises(BadInput, match="this very arm"):
        robot.follow_leader(robot, 1.0)


@pytest.mark.parametrize(("old", "new"), [
    ("0.1,", "inf,"), ("0.1,", "0.0,"), ("0.2,", "1e9,"), ("q2 (deg)", "q2 (rad)"), ("q3 (deg)", "p3 (deg)"),
    ("11.0", "nan"), ("11.0", "1e30"), ("11.0", "eleven"), ("0.1,", "-1e308,"),
])  # fmt: skip
def test_a_damaged_recording_is_refused_before_anything_moves(robot, tmp_path, old, new):
    before, path = robot.arm.q, tmp_path / "taught.csv"
    rows = "0.0,10.0,-60,20,40\n0.1,11.0,-60,20,40\n0.2,12.0,-60,20,40\n"
    text = f"# omx log, format 1\nt (s),q1 (deg),q2 (deg),q3 (deg),q4 (deg)\n{rows}"
    assert old in text
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(OmxError):
        robot.replay(path)
    assert robot.arm.q == before
    path.write_text(text)
    robot.replay(path)
    assert math.degrees(robot.arm.q[0]) == pytest.approx(12, abs=0.5)
