"""A calibration kept in a file and used by the robot: angles and lengths are then the arm's own."""

import json
import math

import numpy as np
import pytest

import omx
from omx.analysis import accuracy
from omx.errors import BadInput
from omx.hardware.doctor.__main__ import main
from omx.hardware.doctor.examination import doctor
from omx.hardware.robot import Robot, load_calibration, save_calibration
from omx.hardware.robot.calibration import Calibration
from omx.hardware.simulator import SteppedClock, VirtualArm, VirtualPort

OFF = (0.02, -0.03, 0.04, 0.01)
FOUND = Calibration(omx.MAKER, OFF)


def crooked_arm():
    """Every horn sits a little askew: where the joint really is, is its reading and `OFF`."""
    arm = VirtualArm()
    for servo, offset in zip(arm.servos, OFF, strict=False):
        servo.mount = -offset
    return arm


def test_a_file_says_all_of_it_to_the_last_bit(tmp_path):
    path = save_calibration(FOUND, tmp_path / "arm-3.json")
    again = load_calibration(path)
    assert again == FOUND._replace(name="arm-3.json")
    assert again.geometry.name == "maker"
    assert save_calibration(again, path) == path  # an arm has one calibration


def test_what_chapter_12_finds_is_saved_and_driven_by(tmp_path):
    rng = np.random.default_rng(0)
    readings = rng.uniform(-1.2, 1.2, (40, 4))
    points = omx.pose(readings + OFF, omx.MAKER)[:, :3]
    path = save_calibration(accuracy.calibrate(readings, points), tmp_path / "arm.json")
    arm = crooked_arm()
    with Robot(VirtualPort(arm, clock=SteppedClock()), calibration=path) as robot:
        robot.write_motor_state(True)
        robot.move_to([20, -40, 10, 30])
        np.testing.assert_allclose(robot.q, arm.q, atol=math.radians(0.1))
        np.testing.assert_allclose(np.degrees(arm.q), [20, -40, 10, 30], atol=0.7)
        sent = robot.write_joints([0, -40, 10, 30])
        assert sent == pytest.approx([0, -40, 10, 30], abs=0.05)
        assert abs(robot.geometry.L1 - omx.MAKER.L1) < 1e-6
        assert all(servo.table["homing_offset"] == 0 for servo in arm.servos)
        robot.driver.wait()
        robot.driver.halt()
        stood = arm.q
        robot.clock.sleep(1.0)
        np.testing.assert_allclose(arm.q, stood, atol=1e-3)  # holding does not creep by the offsets
        assert "calibrated by arm.json: offsets +1.15" in str(doctor(robot))


def test_without_it_the_arm_is_beside_where_it_believes_to_be():
    arm = crooked_arm()
    with Robot(VirtualPort(arm, clock=SteppedClock())) as robot:
        robot.write_motor_state(True)
        robot.move_to([20, -40, 10, 30])
        assert np.abs(np.degrees(np.subtract(robot.q, arm.q))).max() > 2


def test_a_geometry_of_your_own_comes_first(tmp_path):
    path = save_calibration(FOUND, tmp_path / "arm.json")
    with Robot(calibration=path, geometry=omx.COURSE) as robot:
        assert robot.geometry == omx.COURSE
    with Robot(calibration=load_calibration(path)) as robot:
        assert robot.geometry == omx.MAKER


def test_the_doctor_shows_it(tmp_path, capsys):
    path = save_calibration(FOUND, tmp_path / "arm-3.json")
    main(["--virtual", "--calibration", str(path)])
    assert "calibrated by arm-3.json" in capsys.readouterr().out
    assert main(["--virtual", "--calibration", str(tmp_path / "none.json")]) == 2
    assert "cannot read none.json" in capsys.readouterr().err


@pytest.mark.parametrize(
    "change",
    [
        {"format": "omx calibration, format 2"},
        {"offsets_rad": [0, 0, 0]},
        {"offsets_rad": [0, 0, 0, None]},
        {"offsets_rad": [0, 0, 0, 0.5]},
        {"geometry": {"name": "x", "L1": 77}},
        {"geometry": None},
    ],
)
def test_a_file_that_is_none_is_refused_with_its_name(tmp_path, change):
    path = save_calibration(FOUND, tmp_path / "arm.json")
    path.write_text(json.dumps({**json.loads(path.read_text()), **change}))
    with pytest.raises(BadInput):
        Robot(calibration=path)
    path.write_text("{")
    with pytest.raises(BadInput, match=r"arm\.json is not a calibration"):
        load_calibration(path)


def test_a_horn_that_is_off_is_no_calibration(tmp_path):
    with pytest.raises(BadInput, match="in joint 2 is no calibration"):
        save_calibration(Calibration(omx.COURSE, (0.0, 1.5, 0.0, 0.0)), tmp_path / "arm.json")
