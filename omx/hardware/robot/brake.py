"""Bringing an arm to a stand, and keeping it there until somebody says in so many words that it may go on."""

import contextlib
import threading

from ...errors import BusCorrupt, BusError, BusTimeout, Stopped
from ..dynamixel.bus import for_each
from .monitor import Monitor
from .servo_group import HOLD_S, JOINTS, MOTION_PUSHED, Servos

#: How old a reading may be to hold blindly where it was.
FRESH_S = 1.5


class Brake:
    """Stops the joints of `servos`. `lock` is held while a goal goes out: a stop must not come between check and goal.

    `arrival` is when the motion under way should be over.
    """

    def __init__(self, servos: Servos, monitor: Monitor):
        self.servos, self.monitor, self.clock = servos, monitor, servos.bus.clock
        self.lock = threading.RLock()
        self.arrival = self.clock.now()
        self.holding = False
        self.why: str | None = None
        self.stops = 0  # how often it was latched
        self.began = 0  # how often that was when the last motion was asked for

    # ---- the latch ----

    def latch(self, why: str = "stopped") -> None:
        """From now on refuse every command. What came first stays the reason."""
        self.stops += self.why is None
        self.why = self.why or why

    def resume(self) -> None:
        """Commands are allowed again."""
        self.why = None

    def refuse_if_latched(self) -> None:
        """Raise `Stopped` while it is latched."""
        if self.why is not None:
            raise Stopped(self.why)

    def begin(self) -> None:
        """A motion is asked for: raise `Stopped` while it is latched. What stops from now on ends this motion."""
        self.began = self.stops  # counted first: a stop may come between two lines
        self.refuse_if_latched()

    def refuse_if_stopped_since(self, stops: int) -> None:
        """Raise `Stopped` if it is or was latched after `stops` times: what ran then has ended, resumed or not."""
        if self.stops > stops or self.why is not None:
            raise Stopped(self.why or "stopped meanwhile")

    # ---- standing ----

    @property
    def moving(self) -> bool:
        """Is a commanded motion still under way, by its time?"""
        return self.clock.now() < self.arrival

    def sets_off(self, seconds: float) -> None:
        """A goal goes out now, and takes `seconds`."""
        self.holding, self.arrival = False, self.clock.now() + seconds

    def hold(self) -> None:
        """Stop where the arm is, torque on. Does what it can even if servos are missing, then raises what failed."""
        with self.lock:
            self.arrival, self.holding = self.clock.now() + HOLD_S, True
            try:
                self.servos.stand()
                return
            except BusError:
                pass
            except BaseException:  # an interrupt, in the very middle of it: first the arm stands
                with contextlib.suppress(BusError):
                    self.servos.stand()
                raise
            for_each(JOINTS, self._stand)  # one of them is in trouble: each by itself, so that the others stand

    def _stand(self, servo: int) -> None:
        """Hold one joint. If it does not answer it may still hear: it is told to stay where it was seen last."""
        try:
            self.servos.stand([servo])
        except (BusTimeout, BusCorrupt):
            when, where = self.monitor.seen
            if self.clock.now() - when < FRESH_S:
                current, *_, goal = self.servos.standing(servo, where[servo])
                self.servos.bus.write_block(MOTION_PUSHED, {servo: (current, 0, 0, 1000, goal)})
            raise
