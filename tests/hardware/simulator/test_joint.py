"""One motor with its gearbox: what a torque, a target, a stop and a load make of it."""

from math import radians

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from omx.arm import STALL_CURRENT, STIFFNESS
from omx.hardware.simulator import joint as jt
from omx.hardware.simulator.joint import Drive, Joint

DT = 0.002
HOLDS = jt.FRICTION * jt.STICTION
loads = st.floats(-3, 3)


def run(joint, drive, load, seconds):
    for _ in range(round(seconds / DT)):
        joint.settle(drive, load, DT)
        joint.angle += joint.speed * DT
    joint.settle(drive, load, DT)


@settings(deadline=None)
@given(st.floats(-1, 1), loads)
def test_it_comes_to_rest_within_sag_and_friction_of_its_target(target, load):
    joint = Joint(0.0)
    run(joint, Drive(jt.STALL_TORQUE, stiffness=STIFFNESS, target=target), load, 2.0)
    assert joint.speed == 0.0
    assert abs(joint.angle - (target + load / STIFFNESS)) <= HOLDS / STIFFNESS + 1e-9


@settings(deadline=None)
@given(loads)
def test_at_rest_the_motor_holds_the_load_but_for_friction(load):
    joint = Joint(0.0)
    run(joint, Drive(jt.STALL_TORQUE, stiffness=STIFFNESS, target=0.3), load, 2.0)
    assert abs(joint.effort + load) <= HOLDS + 1e-9


def test_full_voltage_turns_it_at_the_no_load_speed_and_stalls_it_at_the_stall_torque():
    joint = Joint(0.0, friction=0.0)
    joint.settle(Drive(jt.STALL_TORQUE, torque=jt.STALL_TORQUE), 0.0, DT)
    assert joint.speed == pytest.approx(jt.NO_LOAD_SPEED)
    joint.settle(Drive(jt.STALL_TORQUE, torque=jt.STALL_TORQUE), -jt.STALL_TORQUE, DT)
    assert joint.speed == 0.0
    assert joint.current == pytest.approx(STALL_CURRENT)


@settings(deadline=None)
@given(st.floats(1, 5000), st.floats(-1, 1))
def test_no_stiffness_makes_it_overshoot(stiffness, target):
    joint = Joint(0.0, friction=0.0)
    side = target
    for _ in range(200):
        joint.settle(Drive(jt.STALL_TORQUE, stiffness=stiffness, target=target), 0.0, DT)
        joint.angle += joint.speed * DT
        assert (target - joint.angle) * side >= -1e-9


@settings(deadline=None)
@given(st.floats(-2, 2), st.floats(0.01, 0.5))
def test_a_stop_stops_it_and_the_motor_pushes(target, stop):
    joint = Joint(0.0, -stop, stop)
    drive = Drive(jt.STALL_TORQUE, stiffness=STIFFNESS, target=target)
    run(joint, drive, 0.0, 2.0)
    assert -stop - 1e-9 <= joint.angle <= stop + 1e-9
    if abs(target) > stop + 0.01:
        pushing = min(STIFFNESS * (abs(target) - stop), jt.STALL_TORQUE)
        assert abs(joint.effort) == pytest.approx(pushing, rel=1e-6)


@settings(deadline=None)
@given(st.floats(-4, 4), st.floats(-1, 1))
def test_velocity_control_keeps_its_speed_under_load(speed, load):
    joint = Joint(0.0)
    joint.settle(Drive(jt.STALL_TORQUE, speed=speed), load, DT)
    free = (jt.STALL_TORQUE - abs(load) - jt.FRICTION) / jt.DAMPING
    assert abs(joint.speed - speed) <= max(abs(speed) - free, 0.0) + 1e-9


def test_without_torque_it_falls_and_friction_alone_holds_a_little():
    joint = Joint(0.0)
    joint.settle(jt.COAST, 0.5, DT)
    assert joint.speed > radians(20)
    assert joint.current == 0.0  # nobody powers it
    joint.settle(jt.COAST, jt.FRICTION * 0.9, DT)
    assert joint.speed == 0.0


def test_a_load_beyond_the_limit_pushes_the_motor_back():
    joint = Joint(0.0)
    joint.settle(Drive(limit=0.2, stiffness=STIFFNESS, target=0.5), -1.0, DT)
    assert joint.speed < 0
