"""The bus: exceptions instead of tuples, mistakes found before the wire, nothing left behind by an interrupt."""

import os
import threading
import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from omx import errors
from omx.arm import ARM_IDS, JOINT_IDS
from omx.hardware.clock import SteppedClock
from omx.hardware.dynamixel import packet as pk
from omx.hardware.dynamixel import registers as reg
from omx.hardware.dynamixel.bus import Bus
from omx.hardware.dynamixel.packet import Instruction as Do
from omx.hardware.dynamixel.sdk import Port
from omx.hardware.simulator import VirtualArm, VirtualPort
from tests.helpers.rigs import PTY_BAUD, rig, stiffen


@pytest.fixture
def bus_arm_clock():
    with rig() as parts:
        yield parts


# ---- what it does ----


def test_ping_and_scan(bus_arm_clock):
    bus, _, _ = bus_arm_clock
    assert bus.ping(11) == (1020, 45)
    assert list(bus.scan(range(9, 17))) == list(ARM_IDS)


def test_what_is_written_is_read(bus_arm_clock):
    bus, _, _ = bus_arm_clock
    bus.write(13, "homing_offset", -17)
    assert bus.read(13, "homing_offset") == -17
    bus.write_all("goal_position", {servo: 2000 + servo for servo in ARM_IDS})
    assert bus.read_all(ARM_IDS, "goal_position") == {servo: 2000 + servo for servo in ARM_IDS}


def test_one_look_is_one_transaction_and_agrees_with_single_reads(bus_arm_clock):
    bus, _, clock = bus_arm_clock
    stiffen(bus)
    bus.write_all("goal_position", dict.fromkeys(JOINT_IDS, 1700))
    clock.sleep(0.4)
    before = len(bus.history)
    block = bus.read_block(JOINT_IDS)
    assert len(bus.history) == before + 1
    assert any(value < 0 for row in block.values() for value in row)  # FF FF is on the wire
    for servo in JOINT_IDS:
        singly = tuple(bus.read(servo, row.name) for row in reg.PRESENT.registers)
        assert block[servo] == singly


@settings(deadline=None)
@given(st.integers(-1_048_575, 1_048_575))
def test_every_goal_survives_the_wire_stuffed_or_not(goal):
    with rig(settings={11: {"operating_mode": 4}}) as (bus, _, _):
        bus.write(11, "goal_position", goal)
        assert bus.read(11, "goal_position") == goal


@pytest.mark.parametrize("goal", [-131073, -769, -131072 + 0xFD])
def test_byte_stuffing_when_sending_which_the_sdk_loses(goal):
    with rig(settings={11: {"operating_mode": 4}}) as (bus, _, _):
        bus.write(11, "goal_position", goal)
        assert bus.read(11, "goal_position") == goal


@settings(max_examples=200, deadline=None)
@given(st.lists(st.sampled_from([0xFF, 0xFD, 0x00, 1]), min_size=28, max_size=28).map(bytes))
def test_received_stuffing_comes_off_whatever_the_bytes(data):
    # The SDK's own removal goes wrong after the first stuffed byte: an FF FD FD later on loses a byte.
    with rig() as (bus, arm, _):
        for i, byte in enumerate(data, start=1):
            arm.servo(11).table.put(f"indirect_data_{i}", byte)
        block = reg.block(*(f"indirect_data_{i}" for i in range(1, 29)))
        assert bytes(bus.read_block([11], block)[11]) == data


def test_history_keeps_bytes_and_words(bus_arm_clock):
    bus, _, _ = bus_arm_clock
    bus.read_block([11, 12])
    sync = bus.history[-1]
    assert sync.sent == pk.build(pk.BROADCAST, Do.SYNC_READ, b"\x7e\x00\x0a\x00\x0b\x0c")
    assert "present_position 2048 = 0 rad" in sync.explain()
    assert "of 11, 12" in sync.explain()
    assert sync.hex().startswith("> ff ff fd 00 fe")
    bus.write(11, "goal_position", 2048)
    assert "write, servo 11: goal_position 2048 = 0 rad" in bus.history[-1].explain()
    bus.write_all("goal_position", {11: 2048, 12: 1024})
    assert "12: goal_position 1024 = -1.571 rad" in bus.history[-1].explain()


def test_history_forgets_the_oldest():
    with Bus(VirtualPort(clock=SteppedClock()), history=5) as bus:
        for _ in range(9):
            bus.ping(11)
        assert len(bus.history) == 5


# ---- mistakes of the caller ----


@pytest.mark.parametrize(
    ("call", "word"),
    [
        (lambda bus: bus.read(11, "presnt_position"), "present_position"),
        (lambda bus: bus.read(253, "id"), "0 .. 252"),
        (lambda bus: bus.read("11", "id"), "'11'"),
        (lambda bus: bus.read(True + 0.5, "id"), "whole"),
        (lambda bus: bus.write(11, "goal_position", 2048.0), "whole"),
        (lambda bus: bus.write(11, "torque_enable", 2), "nearest"),
        (lambda bus: bus.write(11, "present_position", 2048), "read-only"),
        (lambda bus: bus.write_all("goal_position", {}), "one or more"),
        (lambda bus: bus.write_all("goal_position", {11: 2048, 12: None}), "None"),
        (lambda bus: bus.read_block([11, 11]), "once"),
        (lambda bus: bus.scan([]), "one or more"),
    ],
)
def test_mistakes_are_found_before_the_wire_and_are_no_bus_errors(bus_arm_clock, call, word):
    bus, _, _ = bus_arm_clock
    before = len(bus.history)
    with pytest.raises(errors.BadInput, match=word) as caught:
        call(bus)
    assert not isinstance(caught.value, errors.BusError)
    assert isinstance(caught.value, ValueError)
    assert len(bus.history) == before


def test_numpy_integers_are_integers(bus_arm_clock):
    bus, _, _ = bus_arm_clock
    bus.write(np.int64(11), "goal_position", np.int32(2222))
    assert bus.read(11, "goal_position") == 2222


def test_an_unknown_baud_rate_is_a_mistake():
    with pytest.raises(errors.BadInput, match="1000000"):
        Bus(VirtualPort(), baud=123)


# ---- what servos say no to ----


def test_a_refusal_says_who_what_and_why(bus_arm_clock):
    bus, _, _ = bus_arm_clock
    stiffen(bus)
    with pytest.raises(errors.ServoRefused, match=r"servo 12 .*drive_mode.*torque") as caught:
        bus.write(12, "drive_mode", 0)
    assert (caught.value.servo, caught.value.code) == (12, pk.ACCESS)
    with pytest.raises(errors.ServoRefused, match="limit"):
        bus.write(12, "goal_position", 5000)


def test_hardware_errors_are_all_told(bus_arm_clock):
    bus, arm, _ = bus_arm_clock
    bus.check_hardware(ARM_IDS)
    arm.faults.inject("overheated", servo=11)
    arm.faults.inject("encoder", servo=15)
    with pytest.raises(errors.ServoFault, match=r"overheated.*encoder") as caught:
        bus.check_hardware(ARM_IDS)
    assert caught.value.faults == {11: 4, 15: 8}


# ---- interrupts, threads, ports ----


class Interrupting(VirtualPort):
    """A port in which the user presses stop after so many reads of a transaction."""

    reads_left = None

    def readPort(self, length):
        if self.reads_left is not None:
            self.reads_left -= 1
            if self.reads_left < 0:
                self.reads_left = None
                raise KeyboardInterrupt
        return super().readPort(length)


@pytest.mark.parametrize("reads", range(8))
def test_an_interrupt_inside_a_transaction_leaves_nothing_behind(reads):
    port = Interrupting(VirtualArm(), SteppedClock())
    with Bus(port) as bus:
        port.reads_left = reads
        with pytest.raises(KeyboardInterrupt):
            bus.read_block(JOINT_IDS)
        assert "KeyboardInterrupt" in bus.history[-1].fault
        assert bus.read(15, "present_temperature") == 25
        assert bus.read_block(JOINT_IDS)[11][2] == 2048


def test_threads_take_turns():
    wrong = []

    def work(servo):
        for i in range(60):
            bus.write(servo, "goal_position", 1000 + servo * 10 + i % 7)
            if bus.read(servo, "goal_position") != 1000 + servo * 10 + i % 7:
                wrong.append(servo)

    with Bus(VirtualPort()) as bus:
        threads = [threading.Thread(target=work, args=(servo,)) for servo in ARM_IDS]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(30)
    assert not wrong


def test_a_closed_bus_says_so(bus_arm_clock):
    bus, _, _ = bus_arm_clock
    bus.close()
    bus.close()
    assert not bus.is_open
    with pytest.raises(errors.PortLost, match="reopen"):
        bus.ping(11)
    bus.reopen()
    assert bus.ping(11)


@pytest.mark.parametrize(
    ("name", "word"),
    [("/dev/ttyNOT_THERE", "no such port"), ("COM99", "no such port"), ("socket://127.0.0.1:9", "nobody listens")],
)
def test_a_port_that_cannot_be_opened_says_why(name, word):
    with pytest.raises(errors.PortError, match=word) as caught:
        Bus(name)
    assert caught.value.port == name


@pytest.mark.skipif(not hasattr(os, "openpty"), reason="pseudo-terminals are a POSIX thing")
def test_a_real_port_has_one_opener():
    master, slave = os.openpty()
    name = os.ttyname(slave)
    try:
        first = Bus(name, baud=PTY_BAUD)
        with pytest.raises(errors.PortBusy, match="Close"):
            Bus(name, baud=PTY_BAUD)
        first.close()
        Bus(name, baud=PTY_BAUD).close()
    finally:
        os.close(master)
        os.close(slave)


@pytest.mark.skipif(not hasattr(os, "openpty"), reason="pseudo-terminals are a POSIX thing")
def test_waiting_for_silence_sleeps():
    master, slave = os.openpty()
    try:
        with Bus(os.ttyname(slave), baud=PTY_BAUD) as bus:
            began, cpu = time.perf_counter(), time.process_time()
            assert not bus.scan(range(20, 30))
            assert time.process_time() - cpu < 0.25 * (time.perf_counter() - began)
    finally:
        os.close(master)
        os.close(slave)


# ---- a line that says anything ----


class Scripted:
    """A serial line that answers with given bytes, whatever it is asked."""

    timeout = 0.002

    def __init__(self, answers, clock):
        self.answers, self.clock, self.buffer = list(answers), clock, b""

    @property
    def in_waiting(self):
        return len(self.buffer)

    def write(self, data):
        self.buffer += self.answers.pop(0) if self.answers else b""
        return len(data)

    def read(self, size):
        data, self.buffer = self.buffer[:size], self.buffer[size:]
        if not data:
            self.clock.sleep(self.timeout)
        return data

    def reset_input_buffer(self):
        self.buffer = b""

    def close(self):
        pass


def bus_that_hears(*answers):
    clock = SteppedClock()
    port = Port("scripted", clock)
    port.open_line = lambda: Scripted(answers, clock)
    return Bus(port)


HEADERS = st.sampled_from([b"", pk.HEADER, b"\xff\xff\xfd", pk.HEADER + b"\x0b\x08\x00\x55"])
RUBBISH = st.builds(lambda head, body: head + body, HEADERS, st.binary(max_size=120))


@settings(max_examples=300, deadline=None)
@given(st.lists(RUBBISH, max_size=4))
def test_random_answers_are_errors_never_values(answers):
    bus = bus_that_hears(*answers)
    for _ in range(3):
        with pytest.raises(errors.BusError):
            bus.read_block([11, 12])


@settings(max_examples=150, deadline=None)
@given(RUBBISH, st.integers(-(2**31) + 1, 2**31 - 1))
def test_a_right_answer_after_rubbish_is_right_or_an_error(rubbish, value):
    answer = pk.build_status(11, 0, value.to_bytes(4, "little", signed=True))
    bus = bus_that_hears(rubbish + answer)
    try:
        assert bus.read(11, "present_position") == value
    except errors.BusError:
        assert rubbish


@pytest.mark.parametrize("noise", [b"\xff\xff\xfd\x00" * 50_000, bytes(200_000), b"\x55" * 200_000])
def test_a_line_that_never_stops_ends_in_an_error(noise):
    bus = bus_that_hears(noise, noise)
    with pytest.raises(errors.BusCorrupt):
        bus.read(11, "present_position")


def test_a_late_answer_is_never_taken_for_the_next():
    stale = pk.build_status(11, 0, b"\x20")
    bus = bus_that_hears(b"", stale + pk.build_status(11, 0, b"\xfc\x03\x2d"), pk.build_status(11, 0, b"\x00"))
    with pytest.raises(errors.BusTimeout):
        bus.read(11, "present_temperature")
    assert bus.read(11, "hardware_error") == 0
    assert bus.strays == 1


def test_answers_of_others_are_skipped_and_counted():
    bus = bus_that_hears(pk.build_status(14, 0, b"\x01") + pk.build_status(11, 0, b"\x02"))
    assert bus.read(11, "led") == 2
    assert bus.strays == 1
