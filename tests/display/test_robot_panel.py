"""The panel on a robot: sliders alone move nothing, the arm moves while the button is held, and silence stops it."""

import math

import numpy as np
import pytest

import omx
from omx.display.panels.robot_panel import BEAT_S, RobotPanel
from omx.hardware.robot import Robot
from omx.hardware.safety import Guard
from omx.hardware.simulator import SteppedClock, VirtualArm, VirtualPort
from tests.helpers.scenes import Page


class Stepped(SteppedClock):
    """The test says how time passes, also when a panel looks on."""

    def run(self):
        pass


@pytest.fixture
def panel():
    robot = Robot(clock=Stepped())
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


def test_an_arm_at_rest_is_looked_at_and_not_drawn_again_but_a_film_ends(panel):
    page = Page(panel.view.channel)
    panel.motors.value = True
    panel.robot.clock.sleep(1.0)
    panel.look()
    panel.view.channel.flush()
    drawn = len(page.messages)
    for _ in range(5):
        panel.robot.clock.sleep(0.1)
        panel.look()
        panel.view.channel.flush()
    assert len(page.messages) == drawn
    panel.view.animate([panel.view.q, omx.HOME])
    panel.look()
    assert not panel.view.animated
    np.testing.assert_allclose(panel.view.q, where(panel), atol=math.radians(0.2))


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
    assert "Press Motors on" in panel.message.value
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


def hold(panel, button, seconds):
    """The page's beats of a button that is held for so long."""
    for _ in range(round(seconds / BEAT_S)):
        button.held = True
        button.beat += 1
        panel.robot.clock.sleep(BEAT_S)


def let_go(button):
    button.held = False
    button.beat += 1


def test_switching_the_motors_off_moves_nothing_and_names_the_two_buttons_that_do(panel):
    panel.motors.value = True
    before = where(panel)
    panel.motors.value = False
    panel.robot.clock.sleep(1.0)
    assert panel.motors.value
    assert panel.driver.torque
    assert "Park" in panel.message.value
    assert "Relax" in panel.message.value
    np.testing.assert_allclose(where(panel), before, atol=math.radians(1))


def test_the_arm_parks_while_the_button_is_held_and_no_longer(panel):
    panel.motors.value = True
    panel.speed.value = 30
    hold(panel, panel.park_button, 0.5)
    let_go(panel.park_button)
    panel.robot.clock.sleep(0.3)
    held = where(panel)
    panel.robot.clock.sleep(1.0)
    np.testing.assert_allclose(where(panel), held, atol=math.radians(0.2))
    assert panel.driver.torque
    hold(panel, panel.park_button, 8.0)
    assert "Parked" in panel.message.value
    assert not panel.driver.torque
    assert where(panel)[1] < math.radians(-70)


def test_an_arm_that_sank_out_of_its_limits_is_parked_again(panel):
    for _ in range(2):
        panel.motors.value = True
        panel.speed.value = 30
        hold(panel, panel.park_button, 15.0)
        assert "Parked" in panel.message.value, panel.message.value
        panel.robot.clock.sleep(2.0)


def test_the_motors_go_off_only_when_relax_is_held_to_its_end(panel):
    panel.motors.value = True
    hold(panel, panel.relax_button, 1.5)
    let_go(panel.relax_button)
    hold(panel, panel.relax_button, 1.5)
    assert panel.driver.torque
    assert "SUPPORT" in panel.message.value
    panel.robot.clock.sleep(1.0)  # the page is silent: it begins again
    hold(panel, panel.relax_button, 1.5)
    assert panel.driver.torque
    hold(panel, panel.relax_button, 1.0)
    assert not panel.driver.torque
    assert not panel.motors.value


def test_the_slider_ends_at_the_speed_cap_and_the_arm_keeps_it():
    robot = Robot(guard=Guard(speed_cap=math.radians(10)), clock=Stepped())
    panel = RobotPanel(robot, watch=False)
    panel.motors.value = True
    panel.speed.value = 60
    assert panel.speed.value == 10
    panel.joints.sliders[0].value = 60
    fastest = Fastest(robot.arm)
    beat(panel, 15)
    assert math.degrees(fastest.speed) == pytest.approx(10, rel=0.05)
    panel.close()
    robot.bus.close()


class Fastest:
    """The top speed (rad/s) of joint 1 from now on: it has no load, so it does not sag."""

    def __init__(self, arm):
        self.speed, live = 0.0, arm._live

        def watched(steps):
            self.speed = max(self.speed, abs(arm.joints[0].speed))
            return live(steps)

        arm._live = watched


CODE = ("write_motor_state", "robot.", "resume()", "recover()")


def test_the_panel_speaks_of_its_buttons_and_not_of_code(panel):
    told = []
    beat(panel)
    told.append(panel.message.value)
    panel.motors.value = True
    panel.stop_button.click()
    beat(panel)
    told.append(panel.message.value)
    release(panel)
    panel.resume_button.click()
    panel.robot.arm.faults.inject("overload", servo=12)
    panel._try(panel.look)
    told.append(panel.message.value)
    assert not panel.resume_button.disabled
    panel.robot.arm.faults.clear()
    panel.resume_button.click()
    assert panel.driver.torque
    assert not any(panel.robot.bus.read_all([11, 12, 13, 14], "hardware_error").values())
    assert all(text for text in told)
    assert not [text for text in told if any(word in text for word in CODE)]


def test_the_cell_run_again_ends_the_older_panel():
    robot = Robot(clock=SteppedClock())
    panels = [RobotPanel(robot) for _ in range(5)]
    assert sum(not panel._closing.is_set() for panel in panels) == 1
    panels[0]._thread.join(10)
    assert not panels[0]._thread.is_alive()
    assert panels[-1]._thread.is_alive()
    panels[-1].close()
    robot.bus.close()


def test_warnings_of_the_opening_are_shown():
    arm = VirtualArm()
    arm.faults.inject("dead", servo=15)
    robot = Robot(VirtualPort(arm, clock=SteppedClock()))
    panel = RobotPanel(robot, watch=False)
    assert "gripper" in panel.message.value
    panel.close()
    robot.bus.close()


def test_a_page_gets_its_joint_sliders_and_hears_that_they_are_a_robots(panel):
    told = panel.page_data()
    assert told["panel"]["kind"] == "joints"
    assert told["robot"]


def test_its_text_is_deterministic(panel):
    assert repr(panel).startswith("RobotPanel: OpenMANIPULATOR-X at q =")
