"""Raw register values to physical units and back. Conversions to raw *round*; raw to unit to raw is exact.

The only place where ticks are explained. Source: the units column of the XM430-W350 control table.
"""

import math
from typing import NamedTuple

import numpy as np

from ...arm import TICKS_PER_TURN, ZERO_TICK
from ...errors import BadInput


class Unit(NamedTuple):
    """value = (raw - zero) x scale, in `symbol`."""

    symbol: str
    scale: float
    zero: int = 0

    def value(self, raw):
        """Raw integer (or array of them) to a float (or array) in this unit."""
        return (raw - self.zero) * self.scale

    def raw(self, value):
        """A number (or array) in this unit to the nearest raw integer; `BadInput` if it is not finite."""
        if isinstance(value, (int, float)):
            if not math.isfinite(value):
                raise BadInput(f"Expected a finite number of {self.symbol or 'ticks'}; got {value!r}.")
            return round(value / self.scale) + self.zero
        array = np.asarray(value, dtype=float)
        if not np.isfinite(array).all():
            raise BadInput(f"Expected finite numbers of {self.symbol or 'ticks'}; got {array.tolist()}.")
        raw = np.rint(array / self.scale).astype(int) + self.zero
        return int(raw) if raw.ndim == 0 else raw


_RPM = math.tau / 60.0  # rad/s

POSITION = Unit("rad", math.tau / TICKS_PER_TURN, ZERO_TICK)
ANGLE = Unit("rad", math.tau / TICKS_PER_TURN)
VELOCITY = Unit("rad/s", 0.229 * _RPM)
ACCELERATION = Unit("rad/s2", 214.577 * _RPM / 60.0)
CURRENT = Unit("mA", 2.69)
PWM = Unit("%", 0.113)
VOLTAGE = Unit("V", 0.1)
TEMPERATURE = Unit("degC", 1.0)
MILLISECONDS = Unit("s", 1e-3)
WATCHDOG = Unit("s", 20e-3)
DELAY = Unit("s", 2e-6)
PLAIN = Unit("", 1.0)
