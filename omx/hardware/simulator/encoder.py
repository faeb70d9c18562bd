"""What an angle sensor makes of an angle. Ideal unless asked otherwise; the register rounds to ticks afterwards.

The XM430 has an AS5045 on its output shaft (the maker's e-manual). Its data sheet allows a non-linearity of 0.5 deg
with a well centred magnet, mostly once a turn, and gives a noise of 0.03 deg rms in its slow mode, 0.06 in its
fast one.
"""

import random
from math import sin
from typing import NamedTuple


class Encoder(NamedTuple):
    """`ripple` (rad) is the most that a reading is wrong by, `phase` (rad) where on the turn; `noise` (rad) is rms."""

    ripple: float = 0.0
    phase: float = 0.0
    noise: float = 0.0

    def reads(self, angle: float) -> float:
        """What is read (rad) where the joint is at `angle`, but for noise."""
        return angle + self.ripple * sin(angle + self.phase)

    def angle(self, reading: float) -> float:
        """Where the joint is (rad) when `reading` is read."""
        angle = reading
        for _ in range(3 if self.ripple else 0):
            angle = reading - self.ripple * sin(angle + self.phase)
        return angle

    def jitter(self, servo: int, moment: int) -> float:
        """The noise (rad) in a reading of `servo` at the `moment` (a count of steps): the same whoever looks."""
        return random.Random(moment << 8 | servo).gauss(0.0, self.noise) if self.noise else 0.0
