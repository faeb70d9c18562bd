"""The arm of most tests in this folder."""

import pytest

from omx.hardware.robot import Robot
from omx.hardware.simulator import SteppedClock


@pytest.fixture
def robot():
    """Motors on, in stepped time; whatever a test leaves, its end moves nothing."""
    robot = Robot(clock=SteppedClock())
    robot.write_motor_state(True)
    yield robot
    robot.bus.close()
