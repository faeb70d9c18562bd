"""One arm leads another, or a slider does: step by step, every step through the guard."""

import math
from collections.abc import Callable
from dataclasses import dataclass

from ...errors import BadInput, Collision, JointLimit, OmxError, TooHeavy
from ..clock import ticks
from .driver import Driver

#: A step takes this share of what the speed cap allows, so that a step that comes late is not refused.
SHARE = 0.9
#: Steps are sent this many periods ahead.
AHEAD = 2


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
    led, sent, period = Led(), None, 1.0 / rate
    try:
        for _ in ticks(seconds, rate, driver.clock):
            wanted = _four(where())
            sent = driver.watch().aim if sent is None else sent
            most = driver.guard.speed_cap * period * SHARE
            goal = tuple(a + min(max(b - a, -most), most) for a, b in zip(sent, wanted, strict=True))
            try:
                reading = driver.stream_to(goal, AHEAD * period)
            except (Collision, JointLimit, TooHeavy) as reason:
                led.refused, led.reason = led.refused + 1, reason
                continue
            sent, led.sent = goal, led.sent + 1
            led.lag = max(led.lag, *(abs(a - b) for a, b in zip(reading.q, wanted, strict=True)))
    except BaseException as error:
        driver.broken_off(error)
        raise
    driver.wait()
    return led


def _four(q) -> tuple[float, ...]:
    numbers = tuple(float(angle) for angle in q)
    if len(numbers) != 4 or not all(map(math.isfinite, numbers)):
        raise BadInput(f"the leader must give four finite joint angles; got {numbers}.")
    return numbers
