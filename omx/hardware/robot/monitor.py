"""Looking at an arm, judging what is seen, and doing so again and again while the motors are on.

It only reads: what to do about it is the driver's business.
"""

import contextlib
import logging
import math
import threading
import weakref
from collections.abc import Iterable
from typing import NamedTuple

from ...errors import NotReady, OmxError, Stalled
from .. import gravity
from ..dynamixel import registers as reg
from ..dynamixel.bus import Bus, again
from ..fault_table import HEALTH, Finding, judge, registers, sentences
from ..safety import stalled
from .servo_group import JOINTS

STALL_S = 0.15
HEALTH_S = 1.0
#: Seconds between two looks at an arm that moves, that is pushed, and that holds.
MOVING_S, PUSHED_S, HOLDING_S = 0.1, 0.05, 1.0
#: A servo that is too hot after so long (s) without a command is parked: it will give up by itself soon.
HOT_IDLE_S = 30.0
#: A warning is said again only when its cause has been away for so long (s): a supply that is just too weak comes and
#: goes with every motion.
AWAY_S = 60.0

_log = logging.getLogger("omx.robot")

#: What one look at a servo is: the present, and the set-point that the servo follows.
LOOK = reg.block(
    "present_current", "present_velocity", "present_position", "velocity_trajectory", "position_trajectory"
)


class Reading(NamedTuple):
    """One look at the joints: angles (rad), speeds (rad/s), currents (mA); and their set-points, angles and speeds."""

    q: tuple[float, ...]
    speed: tuple[float, ...]
    current: tuple[float, ...]
    aim: tuple[float, ...]
    aim_speed: tuple[float, ...]


def _whose(one: Finding) -> tuple[str, int | None]:
    """The condition and its servo: each has a temperature of its own, but all have one supply."""
    return one.key, None if one.key == "weak_voltage" else one.servo


class Monitor:
    """The joints on `bus`, looked at and judged. `seen`: when they were read last, and where each was (ticks).

    `offsets` (rad) are added to what is read; `known` is what was found, and told, when the arm was opened.
    """

    def __init__(self, bus: Bus, offsets=(0.0,) * 4, known: Iterable[Finding] = ()):
        self.bus, self.offsets = bus, offsets
        self.seen: tuple[float, dict[int, int]] = (-math.inf, {})
        self._warned = {_whose(one): bus.clock.now() for one in known}  # when it was last so
        self._stall_since: dict[int, float] = {}
        self._health_at = bus.clock.now() + HEALTH_S  # opening has just looked

    def look(self) -> Reading:
        """Angles, speeds and currents of the four joints, in one transaction; a lost answer is asked for again."""
        block = again(self.bus.read_block, JOINTS, LOOK)
        self.seen = self.bus.clock.now(), {servo: block[servo][2] for servo in JOINTS}
        columns = zip(*(block[servo] for servo in JOINTS), strict=True)
        current, speed, q, aim_speed, aim = (
            tuple(map(row.unit.value, column)) for row, column in zip(LOOK.registers, columns, strict=True)
        )
        return Reading(self._corrected(q), speed, current, self._corrected(aim), aim_speed)

    def _corrected(self, q) -> tuple[float, ...]:
        return tuple(angle + offset for angle, offset in zip(q, self.offsets, strict=True))

    def stall(self, reading: Reading, payload_g: float = 0.0) -> Stalled | None:
        """The joint that has been pushing on something for `STALL_S`, if one has; the weight it carries is nothing."""
        weights = (gravity.holding_currents(reading.q, grams) for grams in {0.0, payload_g})
        now, stuck = self.bus.clock.now(), set(stalled(reading.current, reading.speed, *weights))
        self._stall_since = {joint: self._stall_since.get(joint, now) for joint in stuck}
        for joint, since in self._stall_since.items():
            if now - since >= STALL_S:
                self._stall_since = {}
                return Stalled(joint, reading.current[joint - 1])
        return None

    def health_is_due(self) -> bool:
        """Once in `HEALTH_S`: is it time to look at supply and temperature?"""
        if self.bus.clock.now() < self._health_at:
            return False
        self._health_at = self.bus.clock.now() + HEALTH_S
        return True

    def health(self) -> NotReady | None:
        """Voltage and temperature of the joints: what forbids going on; a warning is said, once."""
        at = registers(self.bus, JOINTS, (HEALTH,))
        found = [one for servo in JOINTS for one in judge(servo, at[servo])]
        now, warnings = self.bus.clock.now(), [one for one in found if one.warns]
        new = [one for one in warnings if now - self._warned.get(_whose(one), -math.inf) > AWAY_S]
        for sentence in sentences(new):
            _log.warning("%s", sentence)
        self._warned |= {_whose(one): now for one in warnings}
        problems = sentences(one for one in found if one.forbids)
        return NotReady(f"{self.bus.name} holds: the arm", problems) if problems else None


class Watch:
    """Looks at `driver`'s arm on its own clock while the motors are on; keeps neither the driver nor the program alive.

    What it finds makes the arm hold, is said once, and is raised by the next call of somebody who asks. An arm that
    holds, and that nobody has asked for anything for `idle_s`, or `HOT_IDLE_S` if it is `hot`, is parked.
    """

    def __init__(self, driver, idle_s: float | None):
        self._driver, self._clock, self._idle_s = weakref.ref(driver), driver.bus.clock, idle_s
        self._turn, self._due = 0, math.inf
        self._asked_at, self._alone, self._busy = self._clock.now(), threading.RLock(), False
        self.troubles: list[OmxError] = []  # what it met, one of a kind, until somebody asks
        self.folding = False  # while the arm parks heat is no reason to stop: the motors are about to go off
        self.hot = False

    def asked(self) -> None:
        """Somebody asks something of the arm."""
        self._asked_at = self._clock.now()

    def ask(self) -> None:
        """Raise what it met first, once."""
        with contextlib.suppress(IndexError):  # nothing, or another thread asks at the same moment
            raise self.troubles.pop(0)

    @contextlib.contextmanager
    def alone(self):
        """For deciding what motors are on: one thread after the other, and no look in between."""
        with self._alone:
            before = self._busy
            try:
                self._busy = True
                yield
            finally:
                self._busy = before

    def begin(self) -> None:
        """Look soon, and then again and again. Called when the motors go on, and whenever something sets off."""
        if self._clock.now() + MOVING_S < self._due:
            self._turn += 1  # the look that was to come later is none of ours any more
            self._again(PUSHED_S)

    def _again(self, seconds: float) -> None:
        turn, self._due = self._turn, self._clock.now() + seconds
        self._clock.later(seconds, lambda: self._look(turn))

    def _look(self, turn: int) -> None:
        driver = self._driver()
        if driver is None or turn != self._turn:
            return
        if not (driver.torque and driver.bus.is_open):
            self._due = math.inf
            return
        try:
            if not (self._busy or driver.bus.asking):
                self._glance(driver)
        finally:
            self._again(PUSHED_S if driver.push else MOVING_S if driver.moving else HOLDING_S)

    def _glance(self, driver) -> None:
        try:
            driver.glance()
        except OmxError as error:
            if type(error) not in map(type, self.troubles):
                self.troubles.append(error)
                _log.warning("%s", error)
        patience = HOT_IDLE_S if self.hot else math.inf if self._idle_s is None else self._idle_s
        if self._clock.now() - self._asked_at > patience and not (driver.stopped or driver.moving):
            _log.warning("%s: the arm was left to itself, so it parks.", driver.bus.name)
            try:
                driver.park()
            except OmxError as error:
                self.asked()  # not again at once
                _log.warning("it could not park: %s", error)
