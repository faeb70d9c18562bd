"""Units: raw to unit to raw is exact, unit to raw is never more than half a tick off."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from omx.errors import BadInput
from omx.hardware.dynamixel import registers as reg
from omx.hardware.dynamixel import units

ROWS = list(reg.REGISTERS.values())


@settings(deadline=None)
@given(st.sampled_from(ROWS), st.data())
def test_raw_to_unit_to_raw_is_exact(row, data):
    raw = data.draw(st.integers(row.low, row.high))
    assert row.unit.raw(row.unit.value(raw)) == raw


@settings(deadline=None)
@given(st.sampled_from(sorted({row.unit for row in ROWS})), st.floats(-1e6, 1e6))
def test_unit_to_raw_rounds_to_the_nearest(unit, raw):
    value = unit.value(raw)
    assert abs(unit.raw(value) - raw) <= 0.5 + 1e-6


@settings(deadline=None)
@given(st.lists(st.floats(-40, 40), min_size=1, max_size=5))
def test_arrays_convert_like_their_elements(angles):
    together = units.POSITION.raw(np.array(angles))
    assert together.tolist() == [units.POSITION.raw(angle) for angle in angles]


def test_every_position_tick_of_a_turn_survives():
    ticks = np.arange(4096)
    assert np.array_equal(units.POSITION.raw(units.POSITION.value(ticks)), ticks)


@pytest.mark.parametrize(("unit", "raw", "value"), [
    (units.POSITION, 2048, 0.0),
    (units.POSITION, 1024, -math.pi / 2),
    (units.POSITION, 0, -math.pi),
    (units.VELOCITY, 200, math.radians(274.8)),     # the factory's velocity limit
    (units.VELOCITY, 1, math.radians(1.374)),
    (units.CURRENT, 1193, 3209.17),
    (units.PWM, 885, 100.005),
    (units.VOLTAGE, 120, 12.0),
    (units.DELAY, 250, 500e-6),
    (units.WATCHDOG, 50, 1.0),
])  # fmt: skip
def test_known_values(unit, raw, value):
    assert unit.value(raw) == pytest.approx(value, abs=1e-9)
    assert unit.raw(value) == raw


@pytest.mark.parametrize("bad", [math.nan, math.inf, [0.0, math.nan]])
def test_only_finite_numbers_become_ticks(bad):
    with pytest.raises(BadInput, match="finite"):
        units.POSITION.raw(bad)
