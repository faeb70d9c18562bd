"""Packets as bytes, against the examples printed in the maker's e-manual, and taken apart again."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from omx.hardware.dynamixel import packet as pk
from omx.hardware.dynamixel.packet import Instruction as Do
from tests.helpers.rigs import parse

HEX = bytes.fromhex

INSTRUCTIONS = {
    "ping 1": ((1, Do.PING), "FF FF FD 00 01 03 00 01 19 4E"),
    "ping all": ((pk.BROADCAST, Do.PING), "FF FF FD 00 FE 03 00 01 31 42"),
    "read": ((1, Do.READ, HEX("84 00 04 00")), "FF FF FD 00 01 07 00 02 84 00 04 00 1D 15"),
    "write": ((1, Do.WRITE, HEX("74 00 00 02 00 00")), "FF FF FD 00 01 09 00 03 74 00 00 02 00 00 CA 89"),
    "reg write": (
        (1, Do.REG_WRITE, HEX("68 00 C8 00 00 00")),
        "FF FF FD 00 01 09 00 04 68 00 C8 00 00 00 AE 8E",
    ),
    "action": ((1, Do.ACTION), "FF FF FD 00 01 03 00 05 02 CE"),
    "factory reset": ((1, Do.FACTORY_RESET, b"\x01"), "FF FF FD 00 01 04 00 06 01 A1 E6"),
    "reboot": ((1, Do.REBOOT), "FF FF FD 00 01 03 00 08 2F 4E"),
    "clear": ((1, Do.CLEAR, HEX("01 44 58 4C 22")), "FF FF FD 00 01 08 00 10 01 44 58 4C 22 B1 DC"),
    "sync read": (
        (254, Do.SYNC_READ, HEX("84 00 04 00 01 02")),
        "FF FF FD 00 FE 09 00 82 84 00 04 00 01 02 CE FA",
    ),
    "sync write": (
        (254, Do.SYNC_WRITE, HEX("74 00 04 00 01 96 00 00 00 02 AA 00 00 00")),
        "FF FF FD 00 FE 11 00 83 74 00 04 00 01 96 00 00 00 02 AA 00 00 00 82 87",
    ),
    "fast sync read": (
        (254, Do.FAST_SYNC_READ, HEX("84 00 04 00 03 07 04")),
        "FF FF FD 00 FE 0A 00 8A 84 00 04 00 03 07 04 20 F2",
    ),
    "bulk read": (
        (254, Do.BULK_READ, HEX("01 90 00 02 00 02 92 00 01 00")),
        "FF FF FD 00 FE 0D 00 92 01 90 00 02 00 02 92 00 01 00 1A 05",
    ),
    "bulk write": (
        (254, Do.BULK_WRITE, HEX("01 20 00 02 00 A0 00 02 1F 00 01 00 50")),
        "FF FF FD 00 FE 10 00 93 01 20 00 02 00 A0 00 02 1F 00 01 00 50 B7 68",
    ),
}
STATUS = {
    "done": ((1, 0), "FF FF FD 00 01 04 00 55 00 A1 0C"),
    "ping 1": ((1, 0, HEX("06 04 26")), "FF FF FD 00 01 07 00 55 00 06 04 26 65 5D"),
    "ping 2": ((2, 0, HEX("06 04 26")), "FF FF FD 00 02 07 00 55 00 06 04 26 6F 6D"),
    "position 1": ((1, 0, HEX("A6 00 00 00")), "FF FF FD 00 01 08 00 55 00 A6 00 00 00 8C C0"),
    "position 2": ((2, 0, HEX("1F 08 00 00")), "FF FF FD 00 02 08 00 55 00 1F 08 00 00 BA BE"),
    "voltage": ((1, 0, HEX("77 00")), "FF FF FD 00 01 06 00 55 00 77 00 C3 69"),
    "temperature": ((2, 0, HEX("24")), "FF FF FD 00 02 05 00 55 00 24 8B A9"),
}
FAST_SYNC = (
    [(3, 0, HEX("A6 00 00 00")), (7, 0, HEX("1F 08 00 00")), (4, 0, HEX("FF 03 00 00"))],
    "FF FF FD 00 FE 19 00 55 00 03 A6 00 00 00 84 08 00 07 1F 08 00 00 16 CA 00 04 FF 03 00 00 D1 9E",
)
FAST_BULK = (
    [(3, 0, HEX("A6 00 00 00")), (7, 0, HEX("A5 01")), (4, 0, HEX("1F"))],
    "FF FF FD 00 FE 14 00 55 00 03 A6 00 00 00 67 A4 00 07 A5 01 24 74 00 04 1F D9 C1",
)

# Bytes that make stuffing, headers and their fragments likely.
awkward = st.lists(st.sampled_from([0xFF, 0xFD, 0x00, 0x55, 0xFE, 1, 7]), max_size=40).map(bytes) | st.binary(
    max_size=40
)


@pytest.mark.parametrize("name", INSTRUCTIONS)
def test_instructions_match_the_manual(name):
    parts, printed = INSTRUCTIONS[name]
    assert pk.build(*parts) == HEX(printed)
    assert parse(HEX(printed)) == pk.Packet(*parts, *([b""] if len(parts) < 3 else []))


@pytest.mark.parametrize("name", STATUS)
def test_status_packets_match_the_manual(name):
    (servo, error, *params), printed = STATUS[name]
    assert pk.build_status(servo, error, *params) == HEX(printed)
    assert parse(HEX(printed)) == pk.Packet(servo, Do.STATUS, b"".join(params), error)


@pytest.mark.parametrize(("answers", "printed"), [FAST_SYNC, FAST_BULK], ids=["sync", "bulk"])
def test_fast_answers_match_the_manual(answers, printed):
    length = 1 + sum(4 + len(data) for _, _, data in answers)
    assert pk.build_fast_status(answers, length) == HEX(printed)
    assert parse(HEX(printed)).intact


def test_checksum_of_two_halves_is_the_checksum_of_the_whole():
    data = bytes(range(256))
    assert pk.crc16(data[100:], pk.crc16(data[:100])) == pk.crc16(data)
    header = [0xFF, 0xFF, 0xFD, 0x00]
    assert {pk.crc16(kind(header)) for kind in (bytes, bytearray, list, np.array)} == {3624}
    with pytest.raises(TypeError):
        pk.crc16(5)


@settings(deadline=None)
@given(awkward)
def test_stuffing_hides_every_header_and_comes_off_again(body):
    assert pk.HEADER not in pk.stuff(body) + b"\xfd"
    assert pk.unstuff(pk.stuff(body)) == body


@settings(deadline=None)
@given(st.integers(0, 252), awkward, awkward, awkward)
def test_packets_are_found_among_rubbish(servo, params, before, after):
    packets = pk.Reader().feed(before + pk.build(servo, Do.WRITE, params) + after + pk.HEADER)
    assert pk.Packet(servo, Do.WRITE, params) in packets


@settings(deadline=None)
@given(st.lists(awkward, min_size=1, max_size=4), st.lists(st.integers(1, 12), min_size=1, max_size=20))
def test_how_a_stream_is_cut_does_not_matter(bodies, cuts):
    stream = b"".join(pk.build_status(11, 0, body) for body in bodies)
    reader, packets, cuts = pk.Reader(), [], cuts * 200
    while stream:
        cut, cuts = cuts[0], cuts[1:]
        packets += reader.feed(stream[:cut])
        stream = stream[cut:]
    assert [p.params for p in packets] == bodies
    assert reader.feed(pk.build_status(11)) == [pk.Packet(11, Do.STATUS, b"", 0)]


@settings(deadline=None)
@given(awkward, st.data())
def test_one_flipped_bit_never_gives_a_wrong_packet(params, data):
    frame = bytearray(pk.build_status(12, 0, params))
    bit = data.draw(st.integers(0, 8 * len(frame) - 1))
    frame[bit // 8] ^= 1 << bit % 8
    assert not any(p.intact for p in pk.Reader().feed(bytes(frame)))


@settings(deadline=None)
@given(st.binary(max_size=300))
def test_rubbish_is_survived(rubbish):
    reader = pk.Reader()
    reader.feed(rubbish)
    assert pk.Packet(1, Do.PING, b"") in reader.feed(bytes(1024) + pk.build(1, Do.PING))


def test_a_packet_cut_short_does_not_swallow_the_next():
    first, second = pk.build(11, Do.WRITE, bytes(20)), pk.build(12, Do.PING)
    assert [p.id for p in pk.Reader().feed(first[:9] + second)] == [12]
