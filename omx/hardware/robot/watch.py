"""Somebody always looks: between two commands, while a cell only sleeps, and when the kernel idles for hours."""

import logging
import math
import weakref

from ...errors import OmxError

#: Seconds between two looks at an arm that moves, that is pushed, and that holds.
MOVING_S, PUSHED_S, HOLDING_S = 0.1, 0.05, 1.0

_log = logging.getLogger("omx.robot")


class Watch:
    """Looks at `driver`'s arm on its own clock while the motors are on; keeps neither the driver nor the program alive.

    What it finds makes the arm hold, is said once, and is raised by the next call of somebody who asks.
    """

    def __init__(self, driver):
        self._driver = weakref.ref(driver)
        self._clock = driver.bus.clock
        self._turn, self._due = 0, math.inf

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
        if not (driver.busy or driver.bus.asking):
            self._glance(driver)
        self._again(PUSHED_S if driver.pushing else MOVING_S if driver.moving else HOLDING_S)

    def _glance(self, driver) -> None:
        try:
            driver.glance()
        except OmxError as error:
            if driver.trouble is None:
                driver.trouble = error
                _log.warning("%s", error)
        if driver.forgotten:
            _log.warning("%s: the arm was left to itself, so it parks.", driver.bus.name)
            try:
                driver.park()
            except OmxError as error:
                driver.asked_at = self._clock.now()  # not again at once
                _log.warning("it could not park: %s", error)
