"""The panel on a robot: sliders alone move nothing, the arm moves while the button is held, and silence stops it."""

import math

import numpy as np
import pytest

import omx
from omx.display.panels.robot_panel import BEAT_S, RobotPanel
from omx.hardware.robot import Robot
from omx.hardware.simulator import SteppedClock, VirtualArm, VirtualPort


@pytest.fixture
def panel():
    robot = Robot(clock=SteppedClock())
    panel = RobotPanel(robot, watch=False)
    yield panel
    panel.close()
    robot.bus.close()


def beat(panel, times=1):
    for _ in range(times):
        panel.hold.held = True
        panel.hold.beat += 1
        panel.robot.clock.sleep(BEAT_S)


def release(panel):
    panel.hold.held = False
    panel.hold.beat += 1


def where(panel):
    return np.array(panel.robot.arm.q[:4])


def test_the_panel_starts_where_the_arm_is_and_moves_nothing(panel):
    before = where(panel)
    np.testing.assert_allclose(panel.joints.q, before, atol=math.radians(0.2))
    panel.joints.sliders[0].value = 40
    panel.robot.clock.sleep(1.0)
    np.testing.assert_array_equal(where(panel), before)
    assert not panel.motors.value


def test_a_limp_arm_outside_its_limits_gets_a_panel_whose_ghost_is_inside():
    """As after `park`: without torque the folded arm sinks until its links rest on each other."""
    q = (0.0, -1.45, 1.53, 0.2)
    low_high = omx.LIMITS[2]
    assert q[2] > low_high[1]
    robot = Robot(VirtualPort(VirtualArm(q=q), clock=SteppedClock()))
    panel = RobotPanel(robot, watch=False)
    assert panel.joints.q[2] == pytest.approx(robot.driver.guard.soft_limits[2][1])
    np.testing.assert_allclose(panel.joints.q[:2], q[:2], atol=math.radians(2.1))
    panel.look()
    assert math.degrees(panel.joints.view.q[2]) == pytest.approx(math.degrees(q[2]), abs=0.2)
    panel.close()
    robot.bus.close()


def test_without_motors_the_held_button_says_what_is_missing(panel):
    beat(panel)
    assert "write_motor_state" in panel.message.value
    assert not panel.driver.torque


def test_the_arm_goes_to_the_ghost_while_the_button_is_held_and_no_longer(panel):
    panel.motors.value = True
    panel.speed.value = 20
    panel.joints.sliders[0].value = 40
    beat(panel, 10)
    release(panel)
    panel.robot.clock.sleep(0.5)
    held = where(panel)
    assert 10 < math.degrees(held[0]) < 25  # one second at 20 deg/s
    panel.robot.clock.sleep(2.0)
    np.testing.assert_allclose(where(panel), held, atol=math.radians(0.1))
    beat(panel, 20)
    release(panel)
    panel.robot.clock.sleep(0.5)
    assert math.degrees(where(panel)[0]) == pytest.approx(40, abs=1)


def test_when_the_page_goes_silent_the_arm_stops(panel):
    panel.motors.value = True
    panel.joints.sliders[0].value = 60
    beat(panel, 5)
    for _ in range(10):  # no beat any more, and no release
        panel.robot.clock.sleep(0.1)
        panel.look()
    stopped = where(panel)
    assert "silent" in panel.message.value
    panel.robot.clock.sleep(2.0)
    np.testing.assert_allclose(where(panel), stopped, atol=math.radians(0.1))
    assert math.degrees(stopped[0]) < 30


def test_when_even_the_kernel_is_gone_the_servos_stop_by_themselves(panel):
    panel.motors.value = True
    panel.joints.sliders[0].value = 60
    beat(panel, 5)
    panel.robot.clock.sleep(3.0)  # nobody looks, nobody sends
    assert math.degrees(where(panel)[0]) < 30


def test_stop_holds_and_latches_until_resume(panel):
    panel.motors.value = True
    panel.joints.sliders[0].value = 60
    beat(panel, 5)
    panel.stop_button.click()
    panel.robot.clock.sleep(0.5)
    stopped = where(panel)
    beat(panel, 5)
    assert "Resume" in panel.message.value or "resume" in panel.message.value
    np.testing.assert_allclose(where(panel), stopped, atol=math.radians(0.2))
    release(panel)
    panel.resume_button.click()
    beat(panel, 5)
    assert where(panel)[0] > stopped[0] + math.radians(2)


def test_the_solid_arm_is_the_measured_one_and_the_ghost_the_commanded(panel):
    panel.joints.sliders[1].value = -30
    panel.look()
    np.testing.assert_allclose(panel.joints.view.q, panel.driver.read().q)
    assert panel.joints.q[1] == pytest.approx(math.radians(-30))


def test_what_is_refused_is_told_in_the_panel(panel):
    panel.motors.value = True
    panel.joints.q = (0.0, 1.2, -1.0, 1.0)  # into the table
    beat(panel, 80)
    assert "table" in panel.message.value
    assert panel.driver.torque
    assert omx.frames(where(panel))[4, 2, 3] > 0


def test_the_state_of_each_servo_is_shown(panel):
    for joint in range(1, 5):
        assert f"joint {joint}" in panel.state.value
    for unit in ("C", "V", "mA", "ok"):
        assert unit in panel.state.value


def test_switching_the_motors_off_parks_first(panel):
    panel.motors.value = True
    panel.motors.value = False
    assert "Parked" in panel.message.value
    assert where(panel)[1] < math.radians(-70)


def test_its_text_is_deterministic(panel):
    assert repr(panel).startswith("RobotPanel: OpenMANIPULATOR-X at q =")
