"""Every fault that can be ordered: what it does to a program on the bus, and that clearing it helps."""

import math
from pathlib import Path

import pytest

import omx
from omx import errors
from omx.arm import ARM_IDS, JOINT_IDS
from omx.hardware.dynamixel import registers as reg
from omx.hardware.simulator.faults import KINDS
from tests.helpers.rigs import rig, send_to, stiffen

WIRE = [name for name, kind in KINDS.items() if kind.of == "wire"]


@pytest.fixture
def parts():
    with rig() as made:
        yield made


def recovered(bus, clock):
    """True if all is as before, after the time that a servo needs to start."""
    clock.sleep(0.5)
    return list(bus.scan(ARM_IDS)) == list(ARM_IDS) and len(bus.read_block(ARM_IDS)) == 5


# ---- on the wire ----


@pytest.mark.parametrize("servo", ARM_IDS)
@pytest.mark.parametrize("kind", ["lost", "corrupt", "truncated"])
def test_a_spoilt_answer_is_an_error_and_the_next_one_is_right(parts, kind, servo):
    bus, arm, _ = parts
    arm.faults.inject(kind, servo=servo, count=1)
    with pytest.raises((errors.BusTimeout, errors.BusCorrupt)) as caught:
        bus.read_block(ARM_IDS)
    assert str(servo) in str(caught.value)
    assert bus.history[-1].fault
    assert not arm.faults.active
    assert bus.read_block(ARM_IDS)[15][2] == 2048


@pytest.mark.parametrize("kind", ["duplicated", "noise"])
def test_too_much_on_the_wire_does_no_harm(parts, kind):
    bus, arm, _ = parts
    position = bus.read(12, "present_position")
    arm.faults.inject(kind, count=6)
    for _ in range(3):
        assert bus.read(12, "present_position") == position
        assert bus.read(12, "present_temperature") == 25
    assert not arm.faults.active


@pytest.mark.parametrize("seconds", [0.02, 0.04, 0.1, 0.5])
def test_a_late_answer_is_waited_for_or_thrown_away(parts, seconds):
    bus, arm, _ = parts
    arm.faults.inject("late", servo=12, count=1, value=seconds)
    if seconds < 0.034:
        assert bus.read(12, "present_temperature") == 25
        return
    with pytest.raises(errors.BusTimeout):
        bus.read(12, "present_temperature")
    while True:
        try:
            assert bus.read(12, "hardware_error") == 0  # and not the temperature
            break
        except errors.BusTimeout:
            assert arm.now < 1.0


@pytest.mark.parametrize("kind", WIRE)
def test_many_faults_of_the_wire_in_a_row_never_give_a_wrong_value(parts, kind):
    bus, arm, _ = parts
    arm.faults.inject(kind, count=7)
    seen = set()
    for _ in range(20):
        try:
            assert bus.read(12, "present_temperature") == 25
            assert bus.read(12, "hardware_error") == 0
            assert bus.read(12, "led") == 0
        except (errors.BusTimeout, errors.BusCorrupt) as error:
            seen.add(type(error))
    assert seen or kind in ("duplicated", "noise")
    assert bus.read(12, "present_temperature") == 25


def test_a_fault_of_the_wire_can_begin_later(parts):
    bus, arm, _ = parts
    arm.faults.inject("lost", after=2, count=1)
    bus.ping(11)
    bus.ping(11)
    with pytest.raises(errors.BusTimeout):
        bus.ping(11)
    bus.ping(11)


# ---- servos ----


@pytest.mark.parametrize("servo", ARM_IDS)
def test_a_dead_servo_is_named_and_so_are_those_after_it(parts, servo):
    bus, arm, clock = parts
    arm.faults.inject("dead", servo=servo)
    with pytest.raises(errors.BusTimeout) as caught:
        bus.read_block(ARM_IDS)
    assert caught.value.missing == tuple(i for i in ARM_IDS if i >= servo)
    assert caught.value.answered == tuple(i for i in ARM_IDS if i < servo)
    assert set(bus.scan(ARM_IDS)) == set(ARM_IDS) - {servo}
    arm.faults.clear()
    assert recovered(bus, clock)


def test_a_broken_chain_loses_all_after_the_break(parts):
    bus, arm, clock = parts
    arm.faults.inject("broken_chain", servo=13)
    assert list(bus.scan(ARM_IDS)) == [11, 12]
    arm.faults.clear()
    assert recovered(bus, clock)


def test_without_power_nobody_answers_and_the_arm_falls(parts):
    bus, arm, clock = parts
    stiffen(bus)
    arm.faults.inject("no_power")
    clock.sleep(5.0)
    assert not bus.scan(ARM_IDS)
    assert max(abs(a - b) for a, b in zip(arm.q, omx.HOME, strict=True)) > 0.3
    arm.faults.clear()
    assert recovered(bus, clock)
    assert bus.read(12, "torque_enable") == 0


@pytest.mark.parametrize(
    ("kind", "name", "value"),
    [
        ("wrong_model", "model_number", 1060),
        ("old_firmware", "firmware_version", 36),
        ("drive_mode", "drive_mode", 5),
        ("slow_answer", "return_delay_time", 250),
    ],
)
def test_a_wrong_register_shows_and_is_restored(parts, kind, name, value):
    bus, arm, _ = parts
    before = bus.read(14, name)
    arm.faults.inject(kind, servo=14)
    assert bus.read(14, name) == value
    arm.faults.clear()
    assert bus.read(14, name) == before


@pytest.mark.parametrize("kind", ["wrong_baud", "wrong_id"])
def test_a_servo_that_listens_elsewhere(parts, kind):
    bus, arm, clock = parts
    arm.faults.inject(kind, servo=13)
    assert 13 not in bus.scan(ARM_IDS)
    assert (1 in bus.scan([1])) == (kind == "wrong_id")
    arm.faults.clear()
    assert recovered(bus, clock)


def test_two_servos_with_one_id_damage_each_others_answers(parts):
    bus, arm, _ = parts
    arm.faults.inject("wrong_id", servo=13, value=12)
    with pytest.raises(errors.BusCorrupt, match="one id"):
        bus.read(12, "present_position")


def test_a_silent_servo_answers_pings_only(parts):
    bus, arm, _ = parts
    arm.faults.inject("silent", servo=12)
    assert bus.ping(12)
    with pytest.raises(errors.BusTimeout):
        bus.read(12, "led")


@pytest.mark.parametrize(
    ("kind", "bit"), [("overload", 0x20), ("shock", 0x10), ("encoder", 0x08), ("overheated", 0x04)]
)
def test_a_hardware_error_in_mid_move_drops_that_joint_until_it_reboots(parts, kind, bit):
    bus, arm, clock = parts
    stiffen(bus, 2.0)
    send_to(bus, (0, 0, 0, 0))
    arm.faults.inject(kind, servo=13, after=0.8)
    clock.sleep(0.7)
    assert bus.read(13, "hardware_error") == 0
    clock.sleep(0.2)
    assert bus.read(13, "hardware_error") == bit
    limp = bit & reg.REGISTERS["shutdown"].default
    assert bus.read(13, "torque_enable") == (not limp)
    with pytest.raises(errors.ServoFault) as caught:
        bus.check_hardware(ARM_IDS)
    assert caught.value.causes == {13: reg.hardware_errors(bit)}
    arm.faults.clear()
    assert bus.read(13, "hardware_error") == bit  # only a reboot clears it
    bus.reboot(13)
    clock.sleep(0.5)
    assert bus.read(13, "hardware_error") == 0


def test_a_blocked_joint_pushes_and_then_overloads(parts):
    bus, arm, clock = parts
    stiffen(bus, 2.0)
    arm.faults.inject("blocked", servo=12)
    send_to(bus, (0, -0.3, 0.35, 0.7))
    clock.sleep(1.0)
    block = bus.read_block([12])[12]
    assert abs(block[0] * 2.69) > 600
    assert block[1] == 0
    clock.sleep(5.0)
    assert bus.read(12, "hardware_error") == 0x20


def test_a_cleared_block_lets_the_joint_go_on(parts):
    bus, arm, clock = parts
    stiffen(bus, 1.0)
    arm.faults.inject("blocked", servo=11)
    bus.write(11, "goal_position", 2070)
    clock.sleep(1.5)
    assert bus.read(11, "present_position") == pytest.approx(2048, abs=1)
    arm.faults.clear()
    clock.sleep(1.0)
    assert bus.read(11, "present_position") == pytest.approx(2070, abs=3)


def test_a_servo_restarts_in_mid_move(parts):
    bus, arm, clock = parts
    stiffen(bus, 2.0)
    send_to(bus, (0, 0, 0, 0))
    arm.faults.inject("reboots", servo=12, after=0.5)
    clock.sleep(0.6)
    with pytest.raises(errors.BusTimeout):
        bus.ping(12)
    clock.sleep(0.5)
    assert bus.read(12, "torque_enable") == bus.read(12, "profile_velocity") == 0


def test_a_horn_that_is_a_quarter_turn_off(parts):
    bus, arm, _ = parts
    before = bus.read(12, "present_position")
    arm.faults.inject("horn", servo=12)
    assert bus.read(12, "present_position") - before == 1024
    arm.faults.inject("horn", servo=12, value=math.radians(-90))
    assert bus.read(12, "present_position") - before == -1024


def test_a_hot_servo_shows_its_temperature(parts):
    bus, arm, _ = parts
    arm.faults.inject("hot", servo=13)
    assert bus.read_all(ARM_IDS, "present_temperature") == {11: 25, 12: 25, 13: 75, 14: 25, 15: 25}


def test_low_voltage_shows_and_alerts(parts):
    bus, arm, clock = parts
    arm.faults.inject("low_voltage", value=9.2)
    clock.sleep(0.1)
    assert bus.read(12, "present_voltage") in (91, 92)
    assert bus.alerts
    arm.faults.clear()
    clock.sleep(0.1)
    assert bus.read(12, "present_voltage") in (119, 120)


def test_a_pulled_plug_is_a_lost_port_until_it_is_back(parts):
    bus, arm, _ = parts
    arm.faults.inject("unplugged", value=1)  # whatever the value
    with pytest.raises(errors.PortLost, match="USB"):
        bus.ping(11)
    with pytest.raises(errors.PortLost):
        bus.read_block(JOINT_IDS)
    with pytest.raises(errors.PortError, match="pulled"):
        bus.reopen()
    arm.faults.clear()
    bus.reopen()
    assert bus.ping(11)


def test_every_fault_has_a_test_here():
    tests = Path(__file__).read_text(encoding="utf-8")
    assert not [kind for kind in KINDS if f'"{kind}"' not in tests]


def test_wrong_faults_are_refused(parts):
    _, arm, _ = parts
    with pytest.raises(errors.BadInput, match="overload"):
        arm.faults.inject("explosion")
    with pytest.raises(errors.BadInput, match="11, 12"):
        arm.faults.inject("dead")
    with pytest.raises(errors.BadInput, match="11, 12"):
        arm.faults.inject("lost", servo=16)
