"""Sending the arm along, step by step, every step through the guard: on a trajectory, or after a leader.

A trajectory is looked through first, then sent point by point, at the pace that the program keeps.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from ...arrays import as_four, as_rows, shown
from ...errors import BadInput, Collision, JointLimit, OmxError, TooHeavy
from ...motion.trajectory import Trajectory
from ..clock import period, ticks
from ..safety import STEP
from .driver import Driver, Reading

#: A step that comes so many periods after the one before is not caught up with: the arm would have to leap.
HELD_UP = 1.5
#: How many periods ahead the next point is. With 2 the set-points would run on the plan, with 1 a period behind it.
LEAD = 1.25
#: How far (rad) the arm may be from where the trajectory starts.
NEAR = math.radians(3.0)


def follow(driver: Driver, trajectory, rate: float, each: Callable[[Reading, float], None] | None) -> None:
    """What `Robot.follow` does, in rad."""
    step_s = period(rate)
    last, stops = 0.0, driver.brake.stops
    _look_through(driver, trajectory)
    with driver.unbroken():
        for t in _along(trajectory.seconds, rate, driver.clock):
            driver.brake.refuse_if_stopped_since(stops)
            reading = driver.stream_to(trajectory.at(t + LEAD * step_s), max(t - last, step_s) + step_s)
            last = t
            if each:
                each(reading, t)
    driver.wait()


def _along(seconds: float, rate: float, clock) -> Iterator[float]:
    """The moments of `ticks`, but that time in which the program was held up does not count."""
    start, last, held_up = 0.0, 0.0, True
    while held_up:
        held_up = False
        for t in ticks(max(seconds - start, 0.0), rate, clock):
            held_up = start + t - last > HELD_UP / rate
            if held_up:
                break
            last = start + t
            yield last
        start = min(last + 1 / rate, seconds)


def check_path(driver: Driver, trajectory) -> None:
    """Raise what the guard has against the trajectory, looked at every `STEP` of the joint that turns most."""
    points = as_rows(trajectory.q, "trajectory", 4, "four joint angles in rad a sample")
    turned = np.abs(np.diff(points, axis=0, prepend=points[:1])).max(axis=1).cumsum()
    _, picked = np.unique(turned // STEP, return_index=True)
    driver.guard.check_points(points[[*picked, -1]])


def _look_through(driver: Driver, trajectory) -> None:
    """Raise what would stop the arm on its way, before it sets off."""
    if not isinstance(trajectory, Trajectory):
        raise BadInput(f"`trajectory` is one of `omx.motion`; got {shown(trajectory)}.")
    check_path(driver, trajectory)
    start, guard = driver.read().q, driver.guard
    gap = max(abs(a - b) for a, b in zip(start, trajectory.q[0], strict=True))
    if gap > NEAR:
        raise BadInput(
            f"the arm is {math.degrees(gap):.1f} deg away from where the trajectory starts; `move_to` its start."
        )
    fastest = float(np.abs(trajectory.qd).max())
    if not fastest <= guard.speed_cap:  # NaN is not
        raise BadInput(
            f"the trajectory turns a joint at {math.degrees(fastest):.0f} deg/s; the cap is "
            f"{math.degrees(guard.speed_cap):.0f} deg/s. Give it more seconds."
        )


# ---- one arm leads another, or a slider does ----

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
