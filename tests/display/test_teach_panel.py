"""The panel for teaching: what it does it does while a button is held; then the arm holds."""

import math

import numpy as np
import pytest

from omx.display.panels.robot_panel import BEAT_S
from omx.display.panels.teach_panel import TeachPanel
from omx.hardware.log import read_log
from omx.hardware.robot import Robot
from omx.hardware.simulator import Clock
from tests.display.test_robot_panel import Stepped


@pytest.fixture
def robot():
    robot = Robot(clock=Stepped())
    robot.write_motor_state(True)
    yield robot
    robot.bus.close()


@pytest.fixture
def panel(robot, tmp_path):
    panel = TeachPanel(robot, leader=lambda: [40, -60, 20, 40], path=tmp_path / "taught.csv", watch=False)
    yield panel
    panel.close()


def hold(panel, button, seconds, release=True):
    """Hold `button`, as its page would tell; without `release` the page dies then."""
    clock, beats = panel.robot.clock, round(seconds / BEAT_S)
    button.press += 1

    def beat(held):
        button.held = held
        button.beat += 1

    for i in range(1, beats):
        clock.later(i * BEAT_S, lambda: beat(True))
    if release:
        clock.later(seconds, lambda: beat(False))
    beat(True)


def where(panel):
    return np.array(panel.robot.arm.q)


def stands(panel, q, within_deg=1.0):
    panel.robot.clock.sleep(2.0)
    np.testing.assert_allclose(where(panel), q, atol=math.radians(within_deg))


def test_what_was_taught_while_the_button_was_held_is_replayed_while_another_is(panel):
    arm = panel.robot.arm
    arm.at(arm.now + 0.5, lambda: arm.push(0.4))
    arm.at(arm.now + 1.5, arm.push)
    hold(panel, panel.teach_button, 2.0)
    led = where(panel)
    assert led[0] > math.radians(8)
    stands(panel, led)
    assert 90 <= len(read_log(panel.path)) <= 125
    assert math.degrees(panel.joints.q[0]) == pytest.approx(math.degrees(led[0]), abs=1)
    hold(panel, panel.replay_button, 10.0)
    assert "Replayed" in panel.message.value
    stands(panel, led)


@pytest.mark.parametrize("release", [True, False], ids=["let go", "page gone"])
def test_a_replay_ends_in_the_middle_with_its_button(panel, release):
    arm = panel.robot.arm
    arm.at(arm.now + 0.2, lambda: arm.push(0.4))
    hold(panel, panel.teach_button, 3.0)
    arm.push()
    led = where(panel)
    panel.robot.move_to([0, -60, 20, 40])
    hold(panel, panel.replay_button, 1.5, release)
    between = where(panel)
    assert math.radians(1) < between[0] < led[0] - math.radians(5)
    stands(panel, between, 3.0)
    assert "holds" in panel.message.value


def test_one_press_is_one_replay_however_long_it_is_held(panel):
    hold(panel, panel.teach_button, 0.5)
    panel.robot.move_to([20, -60, 20, 40])
    hold(panel, panel.replay_button, 20.0)
    panel.robot.clock.sleep(1.0)
    sent = len(panel.robot.bus.history)
    panel.robot.bus.history.clear()
    panel.robot.clock.sleep(5.0)  # the button is held all the while
    assert sent > 100 > len(panel.robot.bus.history)
    assert "Replayed" in panel.message.value
    panel.robot.clock.sleep(20.0)
    hold(panel, panel.replay_button, 5.0)
    assert len(panel.robot.bus.history) > 100, "the next press does it again"


def test_a_hand_that_leads_too_far_is_told_and_the_teaching_does_not_begin_again_by_itself(panel):
    arm = panel.robot.arm
    arm.push(0.0, 0.9)
    hold(panel, panel.teach_button, 20.0)
    arm.push()
    said = panel.message.value
    assert "the arm holds in position mode: q2 turned at" in said
    panel.robot.clock.sleep(2.0)  # the button is still held
    assert panel.message.value == said
    assert not panel.robot.driver.push


def test_a_leader_is_followed_while_the_button_is_held(panel):
    hold(panel, panel.follow_button, 0.5)
    between = where(panel)
    assert math.radians(5) < between[0] < math.radians(35)
    stands(panel, between, 3.0)
    hold(panel, panel.follow_button, 3.0)
    assert math.degrees(where(panel)[0]) == pytest.approx(40, abs=1)


def test_stop_ends_the_teaching_and_nothing_goes_on_before_resume(panel):
    panel.robot.clock.later(1.0, panel.stop)
    hold(panel, panel.teach_button, 2.0)
    assert panel.robot.driver.stopped
    before = where(panel)
    hold(panel, panel.follow_button, 1.0)
    assert "Press Resume" in panel.message.value
    stands(panel, before)


def test_what_is_missing_is_said_in_the_panel(panel):
    hold(panel, panel.replay_button, 0.5)
    assert "taught.csv" in panel.message.value
    panel.robot.park()
    hold(panel, panel.teach_button, 0.5)
    assert "Press Motors on" in panel.message.value


def test_with_threads_a_beat_returns_at_once_and_the_arm_holds_when_no_more_come(tmp_path):
    robot = Robot(clock=Clock(10.0))
    robot.write_motor_state(True)
    panel = TeachPanel(robot, leader=lambda: [40, -60, 20, 40], path=tmp_path / "taught.csv")
    panel.follow_button.held = True
    panel.follow_button.press += 1
    panel.follow_button.beat += 1
    while panel._released_at:
        robot.clock.sleep(0.1)
    with panel._running:
        assert robot.driver.brake.holding
    assert math.degrees(robot.q[0]) < 39
    panel.close()
    robot.bus.close()
