"""One fault at one packet of a programme that does a little of everything; all faults at all packets run by hand.

`python -m tests.helpers.sweep` is the whole of it; OMX_SWEEP sets another number of packets a fault here.
"""

import os

import pytest

from tests.helpers.sweep import SPOILS, Sweep, packets

EACH = int(os.environ.get("OMX_SWEEP", "1"))


@pytest.fixture(scope="module")
def some():
    return packets()


def test_the_programme_without_a_fault_ends_parked_and_has_enough_to_spoil(some):
    assert Sweep().run() == "done, motors off"
    assert len(some) > 150


def test_a_joint_that_fell_while_the_program_was_held_up_does_not_leap_back():
    """Its motor was off for its mode, and goes on with the set-point of five seconds ago."""
    whole = Sweep()
    whole.run()
    calls = [{code.co_name for code, _ in place} for place in whole.line.places]
    _, *last = [k for k, names in enumerate(calls, start=1) if {"_switch_on_here", "stiffen", "put"} <= names][-3:]
    assert len(last) == 2
    for k in last:
        Sweep("held up 5 s", k).run()


@pytest.mark.parametrize("name", SPOILS)
def test_whatever_happens_to_any_packet_the_end_is_a_known_one(name, some):
    first = 17 * list(SPOILS).index(name)
    for i in range(EACH):
        Sweep(name, some[(first + i * len(some) // EACH) % len(some)]).run()
