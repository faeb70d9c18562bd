"""One arm leads another, or a slider does: step by step, every step through the guard."""

import math
from collections.abc import Callable
from dataclasses import dataclass

from ...arrays import as_four
from ...errors import Collision, JointLimit, OmxError, TooHeavy
from ..clock import period, ticks
from .driver import Driver

#: A step takes this share of what the speed cap allows, so that a step that comes late is not refused.
SHARE = 0.9
#: Steps are sent this many periods ahead.
AHEAD = 2
#: How far (rad) ahead of the arm a step may be: a program that was held up catches up, the arm does not leap.
REACH = math.radians(5.0)


@dataclass
class Led:
    """How it went: steps `sent` and `refused`, the last `reason` for a refusal, the greatest `lag` (rad) behind."""

    sent: int = 0
    refused: int = 0
    reason: OmxError | None = None
    lag: float = 0.0

    def __str__(self) -> str:
        told = f"{self.sent} steps, {self.refused} refused, at most {math.degrees(self.lag):.1f} deg behind the leader"
        return f"{told}; the last refusal: {self.reason}" if self.reason else told


def lead(driver: Driver, where: Callable[[], tuple[float, ...]], seconds: float, rate: float) -> Led:
    """The arm of `driver` goes where `where()` says (rad), `rate` times a second, no faster than its cap allows.

    Where the guard refuses a step the arm waits at the last that passed, until the leader comes back. What else goes
    wrong, on either side, makes it hold and is raised. At the end it holds.
    """
    led, step_s = Led(), period(rate)
    most = driver.guard.speed_cap * step_s * SHARE
    with driver.unbroken():
        stops, reading = driver.brake.stops, driver.watch()
        sent = reading.aim
        for _ in ticks(seconds, rate, driver.clock):
            driver.brake.refuse_if_stopped_since(stops)
            wanted = as_four(where(), "leader", "four joint angles in rad")
            goal = _within(sent, wanted, most)
            goal = _within(reading.q, goal, REACH)
            try:
                reading = driver.stream_to(goal, AHEAD * step_s)
            except (Collision, JointLimit, TooHeavy) as reason:
                led.refused, led.reason = led.refused + 1, reason
                reading = driver.watch()
                continue
            sent, led.sent = goal, led.sent + 1
            led.lag = max(led.lag, *(abs(a - b) for a, b in zip(reading.q, wanted, strict=True)))
    driver.wait()
    return led


def _within(start, goal, most: float) -> tuple[float, ...]:
    """`goal`, but no joint farther than `most` from `start`."""
    return tuple(a + min(max(b - a, -most), most) for a, b in zip(start, goal, strict=True))
