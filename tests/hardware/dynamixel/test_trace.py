"""Transactions in words: every kind of packet that the bus sends, and the ones that go wrong."""

import pytest

from omx.hardware.dynamixel import packet as pk
from omx.hardware.dynamixel.packet import Instruction as Do
from omx.hardware.dynamixel.trace import Transaction
from tests.hardware.dynamixel.test_packets import HEX, INSTRUCTIONS, STATUS


def told(sent, received=b"", fault=""):
    return Transaction(1.5, 0.0021, sent, received, fault).explain()


@pytest.mark.parametrize(
    ("request_of", "answer_of", "words"),
    [
        ("ping 1", "ping 1", ["ping, servo 1", "1 ok: 06 04 26"]),
        ("read", "position 1", ["read, servo 1: 4 bytes from 132 (present_position)", "1 ok: present_position 166 = "]),
        ("write", "done", ["write, servo 1: goal_position 512 = -2.356 rad", "1 ok"]),
        ("sync write", None, ["sync write, all: 1: goal_position 150", "2: goal_position 170"]),
        ("reboot", "done", ["reboot, servo 1"]),
        ("clear", "done", ["clear, servo 1: 01 44 58 4c 22"]),
    ],
)
def test_the_manuals_packets_in_words(request_of, answer_of, words):
    text = told(HEX(INSTRUCTIONS[request_of][1]), HEX(STATUS[answer_of][1]) if answer_of else b"")
    assert all(word in text for word in words)
    assert "1.5000 s  2.10 ms" in text


def test_refusals_alerts_damage_and_faults_are_told():
    request = pk.build(12, Do.WRITE, HEX("0A 00 04"))
    assert "12 access error" in told(request, pk.build_status(12, pk.ACCESS))
    assert "12 result fail, ALERT" in told(request, pk.build_status(12, pk.RESULT_FAIL | pk.ALERT))
    damaged = pk.build_status(12)[:-1] + b"\x00"
    assert "damaged packet, id 12" in told(request, damaged)
    assert "! BusTimeout: no answer" in told(request, fault="BusTimeout: no answer")


@pytest.mark.parametrize(
    "data", [b"", b"\xff", bytes(40), pk.HEADER * 9, pk.build(1, 0x77), pk.build(1, Do.READ, b"\1")]
)
def test_nothing_that_was_sent_or_received_breaks_it(data):
    assert told(data, data)
    assert Transaction(0, 0, data, data).hex().startswith("> ")
