"""Clocks: real, scaled, stepped."""

import time

import pytest

from omx.errors import BadInput
from omx.hardware.clock import Clock, SteppedClock


def test_a_scaled_clock_runs_and_sleeps_faster():
    before, clock, after = time.perf_counter(), Clock(1000), time.perf_counter()
    clock.sleep(60.0)
    early, now, late = time.perf_counter(), clock.now(), time.perf_counter()
    assert 1000 * (early - after) <= now <= 1000 * (late - before)
    assert now >= 60.0
    assert late - before < 60.0, "a minute that takes one, however busy the machine is"


def test_a_stepped_clock_moves_only_when_slept_on():
    clock = SteppedClock()
    time.sleep(0.01)
    assert clock.now() == 0.0
    clock.sleep(3600.0)
    clock.sleep(-1.0)
    assert clock.now() == 3600.0


@pytest.mark.parametrize("scale", [0, -1])
def test_time_does_not_stand_still_or_go_back(scale):
    with pytest.raises(BadInput, match="positive"):
        Clock(scale)
