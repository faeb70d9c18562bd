"""Gripping and carrying: a force that can be kept up, something held or lost, a weight that the arm allows for."""

import math

import pytest

import omx
from omx.arm import HOLDING_MA, OVERLOAD_TORQUE, TORQUE_PER_MA
from omx.errors import BadInput, ObjectLost, Stalled, TooHeavy, TorqueOff
from omx.hardware import gravity
from omx.hardware.robot import Robot
from omx.hardware.safety import STALL_MA
from omx.hardware.simulator import SteppedClock, VirtualArm, VirtualPort
from omx.motion.trajectory import joint_move


@pytest.fixture
def robot():
    with Robot() as robot:
        robot.write_motor_state(True)
        robot.write_gripper(True)
        robot.clock.sleep(1.0)
        yield robot


@pytest.mark.parametrize("force", [5.0, 10.0, 30.0])
def test_it_presses_with_the_force_that_it_was_told(robot, force):
    robot.arm.grip(30.0, mass_g=100)
    found = robot.grip(force)
    assert found.holding
    assert found.force == pytest.approx(force, abs=0.5)
    assert robot.arm.grasped.pressed(robot.arm.joints[4].angle) == pytest.approx(force, abs=0.5)
    assert found.opening == pytest.approx(30.0, abs=0.5)


def test_what_is_gripped_is_carried_for_minutes_while_the_arm_moves(robot):
    robot.arm.grip(30.0, mass_g=250)
    assert robot.grip(payload_g=250).holding
    for _ in range(3):
        robot.move_to([40, -30, 10, 30], 4.0)
        robot.move_to([-40, -60, 20, 40], 4.0)
        robot.clock.sleep(60.0)
    assert robot.holding
    assert robot.arm.grasped.carried
    assert robot.bus.read(15, "present_temperature") < 40
    assert robot.bus.read(15, "hardware_error") == 0
    robot.release()
    assert not robot.holding
    assert robot.driver.guard.payload_g == 0.0


def test_nothing_between_the_fingers_is_no_object(robot):
    assert not robot.grip(payload_g=300).holding
    assert robot.driver.guard.payload_g == 0.0
    assert not robot.holding


def test_a_loss_is_told_once_and_the_arm_holds(robot, tmp_path):
    robot.arm.grip(35.0, mass_g=50)
    assert robot.grip().holding
    robot.write_time(10.0)
    robot.write_joints([60, -60, 20, 40])
    robot.clock.sleep(1.0)
    robot.arm.grip(None)  # somebody takes it away
    with pytest.raises(ObjectLost, match=r"were 34\.9 mm apart") as caught:
        robot.log(5.0, tmp_path / "carry.csv")
    assert caught.value.now < 33
    stood = robot.arm.q[0]
    robot.clock.sleep(2.0)
    assert robot.arm.q[0] == pytest.approx(stood, abs=0.01)
    assert stood < math.radians(40)
    robot.get_joints_readings()
    robot.move_to([0, -60, 20, 40])


def test_without_motors_the_gripper_says_so():
    with Robot() as robot, pytest.raises(TorqueOff):
        robot.write_gripper(True)


@pytest.mark.parametrize("force", [0, 1.9, 41, float("nan"), "10"])
def test_a_force_that_it_cannot_keep_up_is_refused(robot, force):
    with pytest.raises(BadInput, match="`force`"):
        robot.grip(force)


# ---- weight ----


def loaded(grams, stated):
    robot = Robot(VirtualPort(VirtualArm(payload_g=grams), clock=SteppedClock()), payload_g=stated)
    robot.write_motor_state(True)
    return robot


@pytest.mark.parametrize("grams", [0, 100, 200, 300, 500])
def test_a_stated_payload_is_carried_wherever_a_motor_can_hold_it(grams):
    with loaded(grams, grams) as robot:
        reached = 0
        for goal in ([0, 40, -30, -10], [0, 0, 0, 0], [60, -15, 20, 40], [0, -60, 20, 40]):
            currents = gravity.holding_currents([math.radians(a) for a in goal], grams)
            if max(map(abs, currents)) <= HOLDING_MA:
                robot.move_to(goal)
                reached += 1
            else:
                with pytest.raises(TooHeavy, match=f"with {grams} g joint [23] .* at most") as caught:
                    robot.move_to(goal)
                assert 200 < caught.value.most_g < grams
        assert reached >= (2 if grams == 500 else 3)


def test_an_arm_that_stands_where_its_new_load_is_too_heavy_may_come_back():
    with loaded(0, 0) as robot:
        robot.move_to([0, 0, 0, 0])
        robot.driver.carry(500)
        with pytest.raises(TooHeavy):
            robot.move_to([0, 15, -20, 10])
        robot.move_to([0, -60, 20, 40])


def test_a_trajectory_that_gets_too_heavy_is_refused_before_its_first_step():
    with loaded(500, 500) as robot:
        before = robot.q
        with pytest.raises(TooHeavy):
            robot.follow(joint_move(before, omx.ZERO, 6.0))
        assert robot.q == pytest.approx(before, abs=0.005)


def test_something_in_the_way_is_noticed_at_any_load():
    with loaded(300, 300) as robot:
        robot.driver.bus._port.arm.faults.inject("blocked", servo=12, after=0.5, value=0.01)
        with pytest.raises(Stalled):
            robot.move_to([0, -20, 20, 20])
        robot.resume()
        robot.driver.bus._port.arm.faults.clear()


@pytest.mark.parametrize("grams", [-1, 501, float("nan"), "100"])
def test_a_payload_beyond_the_makers_is_refused(grams):
    with pytest.raises(BadInput, match="500 g"):
        Robot(payload_g=grams)


def test_holding_currents_are_what_the_motors_draw():
    with loaded(200, 200) as robot:
        reading = robot.move_to([0, -10, 10, 20])
        expected = gravity.holding_currents(robot.q, 200)
        friction = 0.102 / 4.1 * 2300
        assert all(abs(a - b) <= friction + 3 for a, b in zip(reading[2], expected, strict=True))
        most = OVERLOAD_TORQUE / TORQUE_PER_MA
        assert max(map(abs, expected)) + STALL_MA < most  # noticed before the servo overloads
        assert gravity.holding_currents(omx.ZERO)[0] == 0.0
