"""Velocity and current mode: what is commanded goes on for a moment only, and has to be said again and again."""

import math

from ...arm import SLOW
from ...arrays import as_four
from ...errors import BadInput, TooFast
from .. import gravity
from ..dynamixel import units
from ..safety import STALL_MA
from . import move_rules
from .driver import Driver, Reading
from .push_by_current import UNREPEATED_S
from .servo_group import JOINTS


def choose(driver: Driver, mode: str) -> None:
    """What is commanded from now on: "position", "velocity" or "current". The arm comes to rest, and holds.

    Only from the first push with `currents` to the next "position" or "velocity" are the servos not in their position
    mode. For each change they lose their torque for some ms, one after the other.
    """
    if mode not in ("position", "velocity", "current"):
        raise BadInput(f"`mode` must be 'position', 'velocity' or 'current'; got {mode!r}.")
    with driver.commanding:
        driver.brake.refuse_if_latched()
        if driver.push:
            driver.stand()
        driver.come_to_rest()
        if mode != "current":
            driver.stiffen()
        driver.mode, driver.streamed = mode, None


def velocities(driver: Driver, speeds) -> tuple[float, ...]:
    """Turn the joints at `speeds` (rad/s), for at most `UNREPEATED_S` unless repeated; returns them as rounded.

    That is a goal so far ahead, reached at this speed and checked like every other: nothing can make it run on.
    """
    guard, asked = driver.guard, as_four(speeds, "velocities", "four numbers, one a joint")
    fastest = max(map(abs, asked))
    if fastest > guard.speed_cap * (1 + 1e-9):
        most = math.degrees(guard.speed_cap)
        raise BadInput(f"`velocities` may be at most {most:.0f} deg/s; got {math.degrees(fastest):.0f}.")
    speeds = tuple(units.VELOCITY.value(units.VELOCITY.raw(v)) for v in asked)
    with driver.commanding:
        driver.ready("velocity")
        reading = driver.watch()
        if driver.brake.holding or not driver.brake.moving:
            driver.check_settings()
        if fastest > SLOW and move_rules.outside(guard, reading.q):
            raise TooFast("an arm outside its limits", fastest, SLOW, UNREPEATED_S * fastest / SLOW)
        goal = tuple(a + v * UNREPEATED_S for a, v in zip(reading.aim, speeds, strict=True))
        driver.send(guard.check(goal, reading.q, reading.aim), UNREPEATED_S, ramp=0.0, confirmed=False)
    return speeds


def currents(driver: Driver, milliamps) -> tuple[float, ...]:
    """Push with `milliamps`, for at most `UNREPEATED_S` unless repeated; then, and near a limit or table, it holds."""
    milliamps = as_four(milliamps, "currents", "four numbers, one a joint")
    if max(map(abs, milliamps)) > STALL_MA:
        raise BadInput(f"`currents` may be at most {STALL_MA:.0f} mA; got {max(map(abs, milliamps)):.0f}.")
    with driver.commanding:
        driver.ready("current")
        return _push(driver, driver.watch(), dict(zip(JOINTS, milliamps, strict=True)))


def balance(driver: Driver, joints=(1, 2, 3, 4)) -> Reading:
    """Carry the weight of `joints` in current mode, so that a hand can move them; the others hold. Repeat it.

    Like `currents` in all else. Returns the reading that the currents are for.
    """
    with driver.commanding:
        driver.ready("current")
        reading = driver.watch()
        weight = dict(zip(JOINTS, gravity.holding_currents(reading.q, driver.guard.payload_g), strict=True))
        _push(driver, reading, {JOINTS[joint - 1]: weight[JOINTS[joint - 1]] for joint in joints})
        return reading


def _push(driver: Driver, reading: Reading, milliamps: dict[int, float]) -> tuple[float, ...]:
    if wrong := driver.push.forecast(reading, milliamps, driver.guard):
        ends = wrong if driver.push else wrong.reason
        driver.halt()  # what it was told before ends, too
        raise ends
    if driver.push and driver.push.joints != set(milliamps):
        driver.stand()
    with driver.unbroken():
        if not driver.servos.soft.issuperset(milliamps):
            driver.soften(milliamps)
        pushed = driver.push.push(milliamps)
    driver.watcher.begin()
    return pushed
