"""The arm in the course's words, on a virtual arm in stepped time: it does what it is told, or says why not."""

import math
import threading
import time

import numpy as np
import pytest

import omx
from omx.arm import ARM_IDS, JOINT_IDS, REST
from omx.errors import (
    BadInput,
    BusTimeout,
    Collision,
    JointLimit,
    NotReady,
    PortError,
    ServoFault,
    Stalled,
    Stopped,
    TooFast,
    TorqueOff,
    Unreachable,
)
from omx.hardware.dynamixel import registers as reg
from omx.hardware.dynamixel.bus import Bus
from omx.hardware.log import read_log
from omx.hardware.robot import Robot
from omx.hardware.robot.driver import Driver
from omx.hardware.simulator import Clock, SteppedClock, VirtualArm, VirtualPort
from omx.motion.trajectory import joint_move, line

TARGETS = ([15, -45, -60, 90], [-90, 15, 30, -45])  # the two of the first lab


@pytest.fixture
def robot():
    robot = Robot(clock=SteppedClock())
    yield robot
    robot.bus.close()


@pytest.fixture
def driven(robot):
    robot.write_motor_state(True)
    return robot


def goals(robot):
    return robot.bus.read_all(JOINT_IDS, "goal_position")


def connected(arm, **kwargs):
    return Driver(Bus(VirtualPort(arm, clock=SteppedClock())), **kwargs)


# ---- connecting ----


def test_making_a_robot_only_reads(robot):
    sent = [transaction.sent[7] for transaction in robot.bus.history]
    assert set(sent) <= {0x01, 0x02, 0x82}  # ping, read, sync read
    assert not robot.driver.torque


def test_everything_that_is_wrong_is_said_at_once():
    arm = VirtualArm()
    arm.faults.inject("dead", servo=12)
    arm.faults.inject("wrong_model", servo=14)
    arm.supply = 9.0
    with pytest.raises(NotReady) as caught:
        connected(arm)
    text = str(caught.value)
    for words in ("servo 12", "servo 14 is model", "9.0 V"):
        assert words in text
    assert len(caught.value.problems) >= 4


def test_an_arm_without_a_gripper_moves_and_says_so():
    arm = VirtualArm()
    arm.faults.inject("dead", servo=15)
    driver = connected(arm)
    assert "servo 15" in driver.condition.warnings[0]
    driver.torque_on()
    driver.command(omx.HOME)
    with pytest.raises(NotReady, match="gripper"):
        driver.grip(0.0)


def test_a_port_that_is_not_there_is_one_clear_error():
    with pytest.raises(PortError, match="nowhere"):
        Robot("/dev/nowhere")


# ---- moving ----


def test_nothing_moves_before_the_motors_are_switched_on(robot):
    with pytest.raises(TorqueOff, match="write_motor_state"):
        robot.write_joints([0, 0, 0, 0])


def test_switching_on_does_not_move_the_arm(robot):
    before = robot.arm.q
    robot.write_motor_state(True)
    robot.clock.sleep(1.0)
    np.testing.assert_allclose(robot.arm.q[:4], before[:4], atol=math.radians(1.0))  # it settles under its weight


@pytest.mark.parametrize("target", TARGETS)
def test_the_joints_arrive_at_the_targets_of_the_lab_in_the_time_given(driven, target):
    driven.write_time(10)
    start = driven.clock.now()
    sent = driven.write_joints(target)
    np.testing.assert_allclose(sent, target, atol=0.5 * 360 / 4096)
    driven.clock.sleep(5.0)
    assert np.abs(driven.get_joints_readings()[1]).max() > 1.0  # halfway it is on its way
    driven.driver.wait()
    assert driven.clock.now() - start == pytest.approx(10.0, abs=0.5)
    np.testing.assert_allclose(driven.get_joints_readings()[0], target, atol=1.0)


def test_a_factory_fresh_servo_takes_the_time_commanded_and_not_0_3_seconds():
    arm = VirtualArm(settings={servo: {"drive_mode": 0, "torque_enable": 1} for servo in ARM_IDS})
    driver = connected(arm)
    driver.torque_on()
    assert set(driver.bus.read_all(JOINT_IDS, "drive_mode").values()) == {reg.DRIVE_TIME_BASED}
    driver.command((1.0, -1.05, 0.35, 0.7), 2.0)
    driver.clock.sleep(0.6)
    assert abs(driver.read().q[0]) < 0.5
    driver.clock.sleep(1.6)
    assert driver.read().q[0] == pytest.approx(1.0, abs=0.02)


def test_one_reading_is_one_transaction(driven):
    before = len(driven.bus.history)
    readings = driven.get_joints_readings()
    assert len(driven.bus.history) == before + 1
    assert readings.shape == (3, 4)


@pytest.mark.parametrize(
    ("goal", "error"),
    [([0, 0, 0, 200], JointLimit), ([0, 80, -60, 60], Collision), ([0, 0, float("nan"), 0], BadInput),
     ([0, 0, 0], BadInput), ("home", BadInput), (None, BadInput), ([0, 0, 0, "up"], BadInput)],
)  # fmt: skip
def test_what_is_refused_is_not_sent(driven, goal, error):
    before = goals(driven)
    with pytest.raises(error):
        driven.write_joints(goal)
    assert goals(driven) == before


def test_a_time_too_short_is_refused_with_the_seconds_it_takes(driven):
    driven.write_time(0.3)
    with pytest.raises(TooFast, match=r"at least 2\.\d\d s"):  # the top of a trapezoid is 4/3 of its mean
        driven.write_joints([90, -60, 20, 40])


@pytest.mark.parametrize("seconds", [0, -1, 100, float("nan"), "fast", None])
def test_a_time_that_is_none_is_refused(robot, seconds):
    with pytest.raises(BadInput, match="seconds"):
        robot.write_time(seconds)


def test_without_a_time_the_speed_cap_decides(driven):
    start = driven.clock.now()
    driven.move_to([60, -60, 20, 40])
    assert driven.clock.now() - start == pytest.approx(1.33, abs=0.2)  # 60 deg, 60 deg/s at the top of the trapezoid


@pytest.mark.parametrize("pose", [[25, -100, 150, -60], [150, 80, 300, 0], [250, -115, 75, -45]])
def test_the_waypoints_of_the_second_lab_are_reached(driven, pose):
    reading = driven.move_to_pose(pose, 4)
    reached = driven.get_ee_pos(reading[0])
    np.testing.assert_allclose(reached[:3], pose[:3], atol=7.0)  # it sags
    np.testing.assert_allclose(reached[3], pose[3], atol=2.0)


def test_a_pose_out_of_reach_names_the_distance(driven):
    with pytest.raises(Unreachable, match=r"236\.7"):
        driven.move_to_pose([600, 0, 204, 0])


def test_an_arm_outside_its_limits_comes_back_slowly_and_only_inwards():
    arm = VirtualArm(q=(0.0, -1.55, 0.5, 0.3))
    driver = connected(arm)
    driver.torque_on()
    driver.command((0.0, -1.2, 0.5, 0.3))
    seconds = driver.brake.arrival - driver.clock.now()
    assert seconds == pytest.approx(0.35 / math.radians(10) * 4 / 3, rel=0.05)
    with pytest.raises(JointLimit):
        driver.command((0.0, -1.6, 0.5, 0.3))


def test_the_gripper_opens_and_closes_whichever_way_its_servo_counts():
    for drive_mode in (4, 5):
        arm = VirtualArm(settings={15: {"drive_mode": drive_mode}})
        driver = connected(arm)
        driver.torque_on()
        driver.grip(math.radians(-45))
        driver.clock.sleep(1.0)
        opened = arm.opening
        assert driver.gripper.look().angle == pytest.approx(math.radians(-45), abs=0.02)
        driver.grip(math.radians(45))
        driver.clock.sleep(1.0)
        assert opened - arm.opening > 20


# ---- kinematics in the course's words ----


def test_the_kinematics_are_those_of_omx(robot):
    q = np.radians(TARGETS[0])
    np.testing.assert_array_equal(robot.get_fk(TARGETS[0]), omx.fk(q))
    np.testing.assert_array_equal(robot.get_jacobian(TARGETS[0]), omx.jacobian(q))
    product = np.linalg.multi_dot(robot.get_int_mat(TARGETS[0]))
    np.testing.assert_allclose(product, omx.fk(q), atol=1e-10)
    x, y, z, pitch, yaw = robot.get_ee_pos(TARGETS[0])
    np.testing.assert_allclose([x, y, z], omx.fk(q)[:3, 3])
    assert (pitch, yaw) == pytest.approx((15, 15))


def test_a_dh_row_is_one_link_matrix(robot):
    np.testing.assert_allclose(robot.get_dh_row_mat([30, 77, 0, -90]), robot.get_int_mat([30, 0, 0, 0])[0], atol=1e-12)


def test_the_two_solutions_of_the_course(robot):
    up, down = robot.get_ik([274, 0, 204, 0])
    np.testing.assert_allclose(up, [0.0, 0.344, 0.347, -0.691], atol=0.5)
    for q in (up, down):
        np.testing.assert_allclose(robot.get_ee_pos(q)[:4], [274, 0, 204, 0], atol=1e-9)
    with pytest.raises(Unreachable):
        robot.get_ik([600, 0, 204, 0])


# ---- stopping ----


def test_hold_stops_a_motion_where_it_is(driven):
    driven.write_time(5)
    driven.write_joints([90, -60, 20, 40])
    driven.clock.sleep(2.0)
    driven.hold()
    driven.clock.sleep(0.5)
    held = driven.get_joints_readings()[0]
    driven.clock.sleep(2.0)
    np.testing.assert_allclose(driven.get_joints_readings()[0], held, atol=0.1)
    assert 10 < held[0] < 80
    assert driven.driver.torque


def test_stop_holds_from_another_thread_and_latches_until_resume():
    robot = Robot(clock=Clock())  # real time: another thread has to get in between
    robot.write_motor_state(True)
    threading.Timer(0.5, robot.stop).start()
    with pytest.raises(Stopped, match="resume"):
        robot.move_to([60, -60, 20, 40], 3.0)
    with pytest.raises(Stopped):
        robot.write_joints([0, -60, 20, 40])
    assert robot.driver.torque
    assert robot.get_joints_readings()[0][0] < 30
    robot.resume()
    robot.write_joints([0, -60, 20, 40])
    robot.bus.close()


def test_park_ends_at_rest_with_the_motors_off(driven):
    driven.move_to(TARGETS[0], 5)
    driven.park()
    assert not any(driven.bus.read_all(JOINT_IDS, "torque_enable").values())
    np.testing.assert_allclose(driven.arm.q[:2], [math.radians(TARGETS[0][0]), REST[1]], atol=0.05)  # where it stands


def test_an_error_in_a_with_block_parks_and_never_drops_the_arm():
    robot = Robot(clock=SteppedClock())

    def program():
        with robot:
            robot.write_motor_state(True)
            robot.write_time(5)
            robot.write_joints(TARGETS[1])
            robot.clock.sleep(2.0)
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        program()
    assert not robot.bus.is_open
    np.testing.assert_allclose(robot.arm.q[1], REST[1], atol=0.05)


def test_an_interrupt_while_waiting_makes_the_arm_hold(driven):
    class Interrupting:
        def __init__(self, clock):
            self.clock, self.end = clock, clock.now() + 1.0

        def now(self):
            return self.clock.now()

        def sleep(self, seconds):
            self.clock.sleep(seconds)
            if self.clock.now() > self.end:
                self.end = math.inf
                raise KeyboardInterrupt

    driven.driver.clock = Interrupting(driven.clock)
    with pytest.raises(KeyboardInterrupt):
        driven.move_to([90, -60, 20, 40], 4.0)
    driven.clock.sleep(1.0)
    assert driven.driver.torque
    assert 5 < driven.get_joints_readings()[0][0] < 60


# ---- when something goes wrong ----


def test_a_joint_that_pushes_on_something_is_named_and_the_arm_holds(driven):
    driven.arm.faults.inject("blocked", servo=13)
    with pytest.raises((Stalled, ServoFault)) as caught:
        driven.move_to([0, -60, 70, 40], 3.0)
    assert "3" in str(caught.value)
    assert driven.get_joints_readings()[0][2] < 60


def test_a_servo_lost_in_mid_move_is_named_and_the_others_hold(driven):
    driven.write_time(6)
    driven.write_joints([60, -30, 20, 10])
    driven.clock.sleep(2.0)
    driven.arm.faults.inject("dead", servo=13)
    with pytest.raises(BusTimeout, match="servo 13"):
        driven.driver.wait()
    with pytest.raises(BusTimeout):
        driven.hold()
    here = driven.arm.q[0]
    driven.clock.sleep(3.0)
    assert driven.arm.q[0] == pytest.approx(here, abs=0.05)
    driven.arm.faults.clear()


def test_one_answer_lost_is_asked_for_again_and_two_are_told(driven):
    driven.arm.faults.inject("lost", servo=12, count=1)
    assert driven.get_joints_readings().shape == (3, 4)
    driven.arm.faults.inject("corrupt", servo=12, count=1)
    assert driven.get_joints_readings().shape == (3, 4)
    driven.arm.faults.inject("lost", servo=12, count=2)
    with pytest.raises(BusTimeout, match="servo 12"):
        driven.get_joints_readings()
    assert driven.get_joints_readings().shape == (3, 4)


def test_an_overloaded_servo_is_explained_and_recovered(driven):
    driven.arm.faults.inject("overload", servo=12)
    with pytest.raises(ServoFault, match=r"servo 12: .*overload"):
        driven.move_to([0, -30, 20, 40], 3.0)
    driven.arm.faults.clear()
    assert driven.recover() == [12]
    driven.move_to([0, -40, 20, 40], 4.0)
    np.testing.assert_allclose(driven.get_joints_readings()[0], [0, -40, 20, 40], atol=1.0)


def test_velocity_mode_stops_by_itself_when_nobody_repeats_the_command(driven):
    driven.write_mode("velocity")
    for _ in range(10):
        driven.write_velocities([20, 0, 0, 0])
        driven.clock.sleep(0.05)
    assert driven.get_joints_readings()[1][0] == pytest.approx(20, abs=2)
    driven.clock.sleep(1.0)
    assert driven.get_joints_readings()[1][0] == 0
    driven.hold()
    driven.move_to([0, -60, 20, 40])


def test_a_velocity_that_would_leave_the_limits_is_refused(driven):
    driven.move_to([0, -80, 20, 40])
    driven.write_mode("velocity")
    with pytest.raises(JointLimit, match="q2"):
        driven.write_velocities([0, -50, 0, 0])
    with pytest.raises(BadInput, match="60 deg/s"):
        driven.write_velocities([100, 0, 0, 0])
    with pytest.raises(BadInput, match="position"):
        driven.write_joints([0, 0, 0, 0])


# ---- trajectories and logs ----


def test_a_straight_line_is_followed(driven):
    driven.move_to_pose([160, -60, 150, -20], 3)
    path = line(driven.q, [200, 80, 150, -0.35], 4.0, max_speed=1.0)
    seen = []
    driven.follow(path, each=lambda reading, t: seen.append((t, reading.q)))
    lag = [np.abs(np.array(q) - path.at(t)).max() for t, q in seen]
    assert len(seen) == 201
    assert max(lag) < math.radians(3.0)
    assert not any(driven.bus.read_all(JOINT_IDS, "bus_watchdog").values())


def test_a_trajectory_that_starts_elsewhere_or_is_too_fast_is_refused_before_its_first_step(driven):
    elsewhere = joint_move(omx.ZERO, omx.HOME, 4.0)
    with pytest.raises(BadInput, match="move_to"):
        driven.follow(elsewhere)
    with pytest.raises(BadInput, match="deg/s"):
        driven.follow(joint_move(driven.q, (1.0, *omx.HOME[1:]), 0.5))


def test_a_log_has_every_sample_and_its_units(driven, tmp_path):
    driven.write_time(3)
    driven.write_joints([30, -30, 10, 20])
    shares = []
    log = driven.log(3.0, tmp_path / "run.csv", rate=50, progress=shares.append, program="test")
    assert len(log) == 151
    assert shares[-1] == 1.0
    again = read_log(tmp_path / "run.csv")
    assert again.samples == log.samples
    assert again.units["q1"] == "deg"
    assert again.units["x"] == "mm"
    poses = np.array(omx.pose(np.radians(again.array("q1", "q2", "q3", "q4"))))
    np.testing.assert_allclose(again.array("x", "y", "z"), poses[:, :3], atol=1e-9)
    np.testing.assert_allclose(np.diff(again["t"]), 0.02, atol=2e-3)


def test_a_log_cut_short_by_a_fault_keeps_its_samples(driven, tmp_path):
    driven.write_time(5)
    driven.write_joints([30, -30, 10, 20])
    driven.arm.faults.inject("overload", servo=12, after=1.0)
    with pytest.raises(ServoFault):
        driven.log(4.0, tmp_path / "cut.csv")
    assert 40 < len(read_log(tmp_path / "cut.csv")) < 60


COURSE_SCRIPT = """
import time
import numpy as np

robot = Robot()
robot.write_motor_state(True)
robot.write_time(TIME)
robot.write_joints([0, 0, 0, 0])
time.sleep(TIME)
robot.write_joints([-90, 15, 30, -45])
started = time.time()
while time.time() - started < TIME:
    readings = robot.get_joints_readings()
    T = robot.get_fk(readings[0])
    printed.append((readings[0].copy(), T.copy(), robot.get_ee_pos(readings[0])))
    time.sleep(0.02)
robot.close()
"""


def test_a_script_of_the_course_runs_unchanged_but_for_its_import(monkeypatch):
    """The script homes, commands the second target over 10 s and samples every 20 ms; its time is the arm's."""
    printed, clock = [], SteppedClock()
    monkeypatch.setattr(time, "sleep", clock.sleep)
    monkeypatch.setattr(time, "time", clock.now)
    exec(COURSE_SCRIPT, {"Robot": lambda: Robot(clock=clock), "TIME": 10, "printed": printed})
    assert len(printed) >= 500
    for q_deg, T, ee in printed:
        np.testing.assert_array_equal(T, omx.fk(np.radians(q_deg)))
        np.testing.assert_allclose(ee[:3], T[:3, 3], atol=1e-12)  # mm, once
    np.testing.assert_allclose(printed[-1][0], [-90, 15, 30, -45], atol=1.5)
    assert abs(printed[-1][2][0]) < 10  # x of the second target is 0 mm, not thousands
