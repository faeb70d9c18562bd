"""The arm as a whole: its state does not depend on who looks how often, gravity pulls it, a hand holds it."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import omx
from omx.arm import ARM_IDS, JOINT_IDS
from omx.errors import BadInput
from omx.hardware import gravity
from omx.hardware.dynamixel import packet as pk
from omx.hardware.dynamixel import registers as reg
from omx.hardware.simulator import VirtualArm
from omx.hardware.simulator.wire_timing import Wire
from tests.helpers.rigs import rig, send_to, stiffen

LOOK = pk.build(pk.BROADCAST, pk.Instruction.SYNC_READ, b"\x7e\x00\x0a\x00" + bytes(ARM_IDS))


def told(servo, name, value):
    row = reg.register(name)
    return pk.build(servo, pk.Instruction.WRITE, row.address.to_bytes(2, "little") + row.encode(value))


def commands():
    """A little history: (time, packet). Torque on, two moves, a watchdog that trips, torque off."""
    yield from ((0.1, told(servo, "profile_velocity", 60)) for servo in JOINT_IDS)
    yield from ((0.11, told(servo, "torque_enable", 1)) for servo in JOINT_IDS)
    yield 0.5, told(12, "goal_position", 1800)
    yield 0.9003, told(13, "goal_position", 2100)
    yield 1.30007, told(12, "goal_position", 1500)
    yield 1.5, told(14, "bus_watchdog", 20)
    yield 1.6, told(14, "goal_position", 2300)
    yield 3.2, told(13, "torque_enable", 0)


def history(looks):
    """The whole state after 5 s, and what `looks`, times at which someone reads, saw."""
    arm = VirtualArm()
    arm.faults.inject("reboots", servo=11, after=2.1)
    wire = Wire(arm)
    events = sorted([*commands(), *((t, None) for t in looks)], key=lambda event: event[0])
    seen = []
    for time, packet in events:
        arm.advance(time)
        if packet:
            wire.send(packet, time)
        else:
            seen.append((time, [(s.read(132, 4, time), s.table["hardware_error"]) for s in arm.servos]))
    arm.advance(5.0)
    state = [(j.angle, j.speed, j.effort) for j in arm.joints]
    return state, [s.temperature for s in arm.servos], [dict(s.table) for s in arm.servos], seen


@settings(max_examples=15, deadline=None)
@given(st.lists(st.floats(0.0, 5.0), max_size=60))
def test_the_state_is_the_same_however_often_someone_looks(looks):
    state, temperatures, tables, _ = history([])
    other, warm, others, _ = history(looks)
    assert other == state
    assert others == tables
    assert warm == pytest.approx(temperatures, abs=1e-9)


def test_a_thousand_small_steps_are_one_large_step():
    looks = [i * 0.005 for i in range(1000)]
    once, often = history([]), history(looks)
    assert once[0] == often[0]
    assert once[2] == often[2]


def test_what_one_sees_does_not_depend_on_what_one_saw_before():
    all_times = [0.37 * i for i in range(14)]
    seen_all = dict(history(all_times)[3])
    for time in all_times[::5]:
        assert history([time])[3] == [(time, seen_all[time])]


def test_a_hand_holds_the_arm_until_its_torque_has_been_on():
    with rig() as (bus, arm, clock):
        clock.sleep(10.0)
        assert arm.q == pytest.approx(omx.HOME)
        stiffen(bus)
        for servo in ARM_IDS:
            bus.write(servo, "torque_enable", 0)
        clock.sleep(5.0)
        assert max(abs(a - b) for a, b in zip(arm.q, omx.HOME, strict=True)) > 0.3


@pytest.mark.parametrize("q", [omx.HOME, omx.ZERO, (0.3, 0.5, -0.5, 0.2), (0.0, -0.5, -0.9, 1.0)])
def test_a_limp_arm_falls_to_rest_above_the_table_and_lower_than_before(q):
    with rig(q=q) as (bus, arm, clock):
        stiffen(bus)
        for servo in ARM_IDS:
            bus.write(servo, "torque_enable", 0)
        clock.sleep(20.0)
        rest = arm.q
        assert all(joint.speed == 0 for joint in arm.joints)
        assert gravity.lowest(*rest[1:]) > -1.0
        assert omx.fk(rest)[2, 3] < omx.fk(q)[2, 3]
        clock.sleep(5.0)
        assert arm.q == rest


def test_it_goes_where_it_is_sent_within_what_the_real_arm_manages():
    with rig() as (bus, arm, clock):
        stiffen(bus, 2.0)
        for degrees in ((0, 0, 0, 0), (15, -45, -60, 80), (-90, 15, 30, -45)):
            q = [math.radians(d) for d in degrees]
            send_to(bus, q)
            clock.sleep(4.0)
            assert max(abs(a - b) for a, b in zip(arm.q, q, strict=True)) < math.radians(1.0)


def test_currents_carry_the_weight():
    with rig(q=omx.ZERO) as (bus, arm, clock):
        stiffen(bus)
        clock.sleep(1.0)
        for servo, torque in zip((12, 13, 14), gravity.torques(*arm.q[1:]), strict=True):
            current = bus.read(servo, "present_current") * 2.69
            assert abs(current + torque / 4.1 * 2300) < 60  # friction of 0.1 Nm hides 56 mA


def test_temperature_rises_under_load_and_voltage_sags():
    with rig(q=omx.ZERO) as (bus, _, clock):
        before = bus.read(12, "present_voltage")
        stiffen(bus)
        clock.sleep(900.0)
        assert bus.read(12, "present_temperature") > bus.read(11, "present_temperature") >= 25
        assert bus.read(12, "present_voltage") <= before


def test_by_hand_only_without_torque():
    with rig() as (bus, arm, _):
        arm.place((0.1, 0.2, 0.3, 0.4))
        assert arm.q == pytest.approx((0.1, 0.2, 0.3, 0.4))
        stiffen(bus)
        with pytest.raises(BadInput, match="torque"):
            arm.place(omx.HOME)


def test_an_arm_outlives_its_connections():
    arm = VirtualArm()
    from omx.hardware.dynamixel.bus import Bus
    from omx.hardware.simulator import SteppedClock, VirtualPort

    for goal in (1800, 2200):
        clock = SteppedClock()
        with Bus(VirtualPort(arm, clock)) as bus:
            bus.write(11, "torque_enable", 1)
            bus.write(11, "goal_position", goal)
            clock.sleep(2.0)
            assert bus.read(11, "present_position") == pytest.approx(goal, abs=4)


def test_wrong_arguments_are_named():
    with pytest.raises(BadInput, match="four"):
        VirtualArm(q=(0, 0))
    with pytest.raises(BadInput, match="11, 12"):
        VirtualArm().servo(3)
    with pytest.raises(BadInput, match="drive_mode"):
        VirtualArm(settings={11: {"drivemode": 4}})
