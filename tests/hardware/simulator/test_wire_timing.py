"""The cable: bytes take their time if asked to, arrive in order, and a packet may come in pieces."""

import pytest

from omx.arm import ARM_IDS
from omx.errors import BadInput
from omx.hardware.dynamixel import packet as pk
from omx.hardware.dynamixel.packet import Instruction as Do
from omx.hardware.simulator import VirtualArm
from omx.hardware.simulator.wire_timing import GAP_S, Wire
from tests.helpers.rigs import parse, rig

PING = pk.build(11, Do.PING)
SYNC = pk.build(pk.BROADCAST, Do.SYNC_READ, b"\x7e\x00\x0a\x00" + bytes(ARM_IDS))


def quick():
    return VirtualArm(settings={servo: {"return_delay_time": 0} for servo in ARM_IDS})


def test_untimed_the_answer_is_there_at_once():
    wire = Wire(quick())
    wire.send(PING, 0.0)
    assert wire.waiting(0.0) == 14
    assert parse(wire.receive(100, 0.0)).id == 11


@pytest.mark.parametrize("baud", [57600, 1_000_000, 4_000_000])
def test_timed_every_byte_takes_ten_bits(baud):
    arm = quick()
    arm.servo(11).table.put("baud_rate", {57600: 1, 1_000_000: 3, 4_000_000: 6}[baud])
    wire = Wire(arm, baud, timed=True)
    wire.send(PING, 0.0)
    due = (len(PING) + 14) * 10 / baud
    assert wire.next_due == pytest.approx(due)
    assert not wire.receive(100, due * 0.99)
    assert wire.receive(100, due * 1.01)


def test_the_return_delay_and_the_latency_timer_come_on_top():
    arm = VirtualArm()  # return delay 250 x 2 us
    wire = Wire(arm, 1_000_000, timed=True, latency_s=0.016)
    wire.send(PING, 0.0)
    assert wire.next_due == pytest.approx((len(PING) + 14) * 1e-5 + 500e-6 + 0.016)


@pytest.mark.parametrize(("latency_s", "low", "high"), [(0.0, 580, 640), (0.001, 360, 420), (0.016, 54, 60)])
def test_loop_rates_of_reading_and_commanding_five_servos(latency_s, low, high):
    # The physical limit is 613 Hz; a latency timer of 1 ms leaves about 400 Hz, one of 16 ms 57 Hz.
    settings = {servo: {"return_delay_time": 0} for servo in ARM_IDS}
    with rig(timed=True, latency_s=latency_s, settings=settings) as (bus, _, clock):
        began, loops = clock.now(), 50
        for _ in range(loops):
            bus.read_block(ARM_IDS)
            bus.write_all("goal_position", dict.fromkeys(ARM_IDS, 2048))
            # Nothing answers the command: count the time its bytes take.
            clock.sleep(39 * 1e-5)
        assert low < loops / (clock.now() - began) < high


def test_answers_keep_their_order_even_if_the_first_is_late():
    arm = quick()
    wire = Wire(arm)
    arm.faults.inject("late", count=1, value=0.02)
    wire.send(SYNC, 0.0)
    assert wire.receive(1000, 0.019) == b""
    assert [p.id for p in pk.Reader().feed(wire.receive(1000, 0.021))] == list(ARM_IDS)


def test_a_packet_may_come_in_pieces_but_not_with_a_pause():
    wire = Wire(quick())
    wire.send(PING[:5], 0.0)
    wire.send(PING[5:], 0.001)
    assert wire.receive(100, 0.001)
    wire.send(PING[:5], 1.0)
    wire.send(PING[5:], 1.0 + 2 * GAP_S)
    assert not wire.receive(100, 2.0)


def test_dropping_leaves_what_is_still_on_its_way():
    arm = quick()
    wire = Wire(arm)
    wire.send(PING, 0.0)
    arm.faults.inject("late", count=1, value=0.1)
    wire.send(PING, 0.0)
    wire.drop(0.0)
    assert wire.receive(100, 0.0) == b""
    assert len(wire.receive(100, 0.2)) == 14


def test_a_timed_wire_needs_a_rate():
    with pytest.raises(BadInput, match="baud"):
        Wire(VirtualArm(), timed=True)
