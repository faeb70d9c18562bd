"""What comes back on the wire, byte for byte, and who stays silent."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from omx.arm import ARM_IDS
from omx.hardware.dynamixel import packet as pk
from omx.hardware.dynamixel import registers as reg
from omx.hardware.dynamixel.packet import Instruction as Do
from omx.hardware.simulator import VirtualArm
from omx.hardware.simulator.wire_timing import Wire
from tests.hardware.dynamixel.test_packets import FAST_BULK, FAST_SYNC, HEX, INSTRUCTIONS, STATUS
from tests.helpers.rigs import parse


def wire_to(ids, **registers):
    """A wire to as many servos as `ids`, renamed to them, the others off; `registers` are set in all of them."""
    arm = VirtualArm()
    for servo in arm.servos[len(ids) :]:
        servo.powered = False
    for servo, own_id in zip(arm.servos, ids, strict=False):
        servo.table.put("id", own_id)
        servo.table.put("return_delay_time", 0)
        for name, value in registers.items():
            servo.table.put(name, value)
    return arm, Wire(arm)


def ask(wire, data, now=0.01):
    wire.send(data, now)
    return wire.receive(10_000, now)


def at(servo, ticks):
    """Put the servo's joint where its position reads `ticks`."""
    servo.joint.angle = (ticks - 2048) * 2 * 3.141592653589793 / 4096
    servo.disturb()


# ---- the manual's own examples ----


def test_ping_of_one_and_of_all():
    _, wire = wire_to([2, 1], model_number=1030, firmware_version=38)
    assert ask(wire, HEX(INSTRUCTIONS["ping 1"][1])) == HEX(STATUS["ping 1"][1])
    assert ask(wire, HEX(INSTRUCTIONS["ping all"][1])) == HEX(STATUS["ping 1"][1]) + HEX(STATUS["ping 2"][1])


def test_read_and_sync_read():
    arm, wire = wire_to([1, 2])
    at(arm.servos[0], 166)
    at(arm.servos[1], 2079)
    assert ask(wire, HEX(INSTRUCTIONS["read"][1])) == HEX(STATUS["position 1"][1])
    both = HEX(STATUS["position 1"][1]) + HEX(STATUS["position 2"][1])
    assert ask(wire, HEX(INSTRUCTIONS["sync read"][1])) == both


@pytest.mark.parametrize("name", ["write", "reg write", "factory reset", "reboot", "clear"])
def test_instructions_that_are_answered_with_done(name):
    _, wire = wire_to([1], velocity_limit=1023)
    assert ask(wire, HEX(INSTRUCTIONS[name][1])) == HEX(STATUS["done"][1])


def test_action_does_what_was_registered_and_nothing_twice():
    arm, wire = wire_to([1], velocity_limit=1023)
    ask(wire, HEX(INSTRUCTIONS["reg write"][1]))
    assert arm.servos[0].table["goal_velocity"] == 0
    assert arm.servos[0].table["registered_instruction"] == 1
    assert ask(wire, HEX(INSTRUCTIONS["action"][1])) == HEX(STATUS["done"][1])
    assert arm.servos[0].table["goal_velocity"] == 200
    assert ask(wire, HEX(INSTRUCTIONS["action"][1])) == pk.build_status(1, pk.INSTRUCTION_ERROR)


def test_sync_write_and_bulk_write_are_not_answered():
    arm, wire = wire_to([1, 2])
    assert ask(wire, HEX(INSTRUCTIONS["sync write"][1])) == b""
    assert [s.table["goal_position"] for s in arm.servos[:2]] == [150, 170]
    arm.servos[0].table.put("max_voltage_limit", 150)
    arm.servos[1].table.put("temperature_limit", 70)
    assert ask(wire, HEX(INSTRUCTIONS["bulk write"][1])) == b""
    assert (arm.servos[0].table["max_voltage_limit"], arm.servos[1].table["temperature_limit"]) == (160, 80)


def test_bulk_read():
    arm, wire = wire_to([1, 2])
    arm.supply, arm.servos[1].temperature = 11.9, 36.0
    arm.servos[0].volts = 11.9
    answer = HEX(STATUS["voltage"][1]) + HEX(STATUS["temperature"][1])
    assert ask(wire, HEX(INSTRUCTIONS["bulk read"][1]), now=0.0) == answer


def test_fast_sync_read_is_the_manuals_reply():
    arm, wire = wire_to([3, 7, 4])
    for servo, ticks in zip(arm.servos, (166, 2079, 1023), strict=False):
        at(servo, ticks)
    assert ask(wire, HEX(INSTRUCTIONS["fast sync read"][1])) == HEX(FAST_SYNC[1])


def test_fast_bulk_read_is_the_manuals_reply():
    arm, wire = wire_to([3, 7, 4])
    at(arm.servos[0], 166)
    arm.servos[2].temperature = 31.0
    # PWM 421: the effort of a motor that pushes with 421/885 of what 12 V give
    arm.servos[1].volts = 12.0
    arm.servos[1].table.put("torque_enable", 1)
    arm.servos[1].joint.effort = 421 / 885 * 4.1
    params = HEX("03 84 00 04 00 07 7C 00 02 00 04 92 00 01 00")
    assert ask(wire, pk.build(pk.BROADCAST, Do.FAST_BULK_READ, params), now=0.0) == HEX(FAST_BULK[1])


# ---- who answers ----


def test_servos_after_a_missing_one_stay_silent():
    _, wire = wire_to([11, 12, 14])
    request = pk.build(pk.BROADCAST, Do.SYNC_READ, HEX("84 00 04 00") + bytes([11, 12, 13, 14]))
    assert [p.id for p in pk.Reader().feed(ask(wire, request))] == [11, 12]


def test_a_fast_answer_with_a_missing_part_is_never_whole():
    _, wire = wire_to([11, 12, 14])
    request = pk.build(pk.BROADCAST, Do.FAST_SYNC_READ, HEX("84 00 04 00") + bytes([11, 12, 13, 14]))
    answer = ask(wire, request)
    assert answer
    assert parse(answer) is None


@pytest.mark.parametrize(("level", "answers"), [(0, "ping"), (1, "ping read sync"), (2, "ping read sync write")])
def test_status_return_level(level, answers):
    _, wire = wire_to([1], status_return_level=level)
    requests = {
        "ping": pk.build(1, Do.PING),
        "read": pk.build(1, Do.READ, HEX("84 00 04 00")),
        "sync": pk.build(pk.BROADCAST, Do.SYNC_READ, HEX("84 00 04 00 01")),
        "write": pk.build(1, Do.WRITE, HEX("41 00 01")),
    }
    assert [name for name, request in requests.items() if ask(wire, request)] == answers.split()


def test_broadcast_writes_reach_all_and_are_not_answered():
    arm, wire = wire_to([1, 2])
    assert ask(wire, pk.build(pk.BROADCAST, Do.WRITE, HEX("41 00 01"))) == b""
    assert all(servo.table["led"] for servo in arm.servos[:2])


def test_a_factory_reset_of_all_ids_at_once_is_not_done():
    arm, wire = wire_to([1, 2])
    ask(wire, pk.build(pk.BROADCAST, Do.FACTORY_RESET, b"\xff"))
    assert [servo.id for servo in arm.servos[:2]] == [1, 2]


def test_a_secondary_id_is_obeyed_in_silence():
    arm, wire = wire_to([1, 2], secondary_id=50)
    assert ask(wire, pk.build(50, Do.WRITE, HEX("41 00 01"))) == b""
    assert all(servo.table["led"] for servo in arm.servos[:2])


def test_another_baud_rate_is_not_heard():
    arm = VirtualArm()
    request = pk.build(11, Do.PING)
    assert ask(Wire(arm, baud=1_000_000), request)
    assert not ask(Wire(arm, baud=57600), request)


def test_two_servos_with_one_id_garble_each_other_unless_they_say_the_same():
    arm, wire = wire_to([11, 11])
    at(arm.servos[0], 1000)
    at(arm.servos[1], 2000)
    assert parse(ask(wire, pk.build(11, Do.PING))).intact
    answer = parse(ask(wire, pk.build(11, Do.READ, HEX("84 00 04 00"))))
    assert answer is None or not answer.intact


def test_the_alert_bit_is_in_every_answer():
    arm, wire = wire_to([1, 2])
    arm.servos[0].fail(0x20)
    both = pk.build(pk.BROADCAST, Do.SYNC_READ, HEX("84 00 04 00 01 02"))
    fast = pk.build(pk.BROADCAST, Do.FAST_SYNC_READ, HEX("84 00 04 00 01 02"))
    assert parse(ask(wire, pk.build(1, Do.PING))).error == pk.ALERT
    assert [p.error for p in pk.Reader().feed(ask(wire, both))] == [pk.ALERT, 0]
    assert parse(ask(wire, fast)).error == pk.ALERT


@pytest.mark.parametrize(
    ("packet", "error"),
    [
        (pk.build(1, 0x77), pk.INSTRUCTION_ERROR),
        (pk.build(1, Do.READ, HEX("84 00")), pk.DATA_LENGTH),
        (pk.build(1, Do.READ, HEX("84 00 00 00")), pk.DATA_LENGTH),
        (pk.build(1, Do.WRITE, HEX("74 00")), pk.DATA_LENGTH),
        (pk.build(1, Do.FACTORY_RESET, HEX("07")), pk.DATA_RANGE),
        (pk.build(1, Do.CLEAR, HEX("01 00 00 00 00")), pk.DATA_RANGE),
        (pk.build(1, Do.SYNC_READ, HEX("84 00 04 00 01")), pk.INSTRUCTION_ERROR),
        (pk.build(1, Do.PING)[:-1] + b"\x00", pk.CRC_ERROR),
    ],
)
def test_nonsense_is_answered_with_its_number(packet, error):
    _, wire = wire_to([1])
    assert parse(ask(wire, packet)) == pk.Packet(1, Do.STATUS, b"", error)


# ---- rubbish ----

parameters = st.binary(max_size=30) | st.lists(st.sampled_from([0, 1, 4, 11, 12, 64, 116, 254, 255, 253])).map(bytes)


@settings(max_examples=200, deadline=None)
@given(st.lists(st.binary(max_size=60), max_size=5))
def test_random_bytes_are_survived_and_the_next_ping_is_answered(pieces):
    _, wire = wire_to(ARM_IDS)
    for i, piece in enumerate(pieces):
        ask(wire, piece, 0.001 * i)
    assert parse(ask(wire, pk.build(11, Do.PING), now=1.0)) is not None


@settings(max_examples=300, deadline=None)
@given(st.lists(st.tuples(st.sampled_from([1, 11, 15, 254]), st.sampled_from(list(Do)), parameters), max_size=8))
def test_whole_packets_with_random_parameters_are_survived(packets):
    arm, wire = wire_to(ARM_IDS)
    for i, packet in enumerate(packets):
        answers = pk.Reader().feed(ask(wire, pk.build(*packet), 0.1 * i))
        assert all(answer.instruction == Do.STATUS for answer in answers if answer.intact)
    arm.advance(3.0)
    assert all(abs(joint.angle) < 10 for joint in arm.joints)
    for servo in arm.servos:
        for name in ("operating_mode", "drive_mode", "torque_enable", "goal_velocity"):
            row = reg.register(name)
            assert row.low <= servo.table[name] <= row.high
