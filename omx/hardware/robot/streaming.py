"""Running a trajectory: looked through first, then sent point by point, at the pace that the program keeps."""

import math
from collections.abc import Callable, Iterator

import numpy as np

from ...arrays import as_rows, shown
from ...errors import BadInput
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
    for q in points[[*picked, -1]]:
        driver.guard.check(q)


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
