"""The time a port lives in: a wall clock for the real arm; real, scaled or stepped time for the virtual one."""

import heapq
import itertools
import math
import threading
import time
from collections.abc import Callable, Iterator
from numbers import Real

from ..errors import BadInput


class Clock:
    """Seconds since the clock was made, `scale` times as fast as the wall clock."""

    def __init__(self, scale: float = 1.0):
        if not (math.isfinite(scale) and scale > 0):
            raise BadInput(f"A clock's scale must be positive (1 = real time, 10 = ten times as fast); got {scale!r}.")
        self.scale = scale
        self._start = time.perf_counter()

    def now(self) -> float:
        """Seconds since this clock was made; never goes back."""
        return (time.perf_counter() - self._start) * self.scale

    def sleep(self, seconds: float):
        """Wait until `seconds` of this clock have passed."""
        if seconds > 0:
            time.sleep(seconds / self.scale)

    def later(self, seconds: float, action: Callable[[], None]) -> None:
        """Call `action()` in `seconds`, in a thread of its own; the end of the program does not wait for it."""
        timer = threading.Timer(max(seconds, 0.0) / self.scale, action)
        timer.name, timer.daemon = "omx alarm", True
        timer.start()


class SteppedClock:
    """A clock that moves only when someone sleeps on it: the same run gives the same times, at any speed."""

    def __init__(self):
        self._slept = 0.0
        self._running: Clock | None = None
        self._lock = threading.Lock()
        self._alarms: list[tuple[float, int, Callable[[], None]]] = []
        self._count = itertools.count()

    def run(self) -> None:
        """From now on go with the wall clock: somebody is watching."""
        with self._lock:
            if self._running is None:
                now, self._running = self._slept, Clock()
                for due, _, action in self._alarms:
                    self._running.later(due - now, action)

    def now(self) -> float:
        """Seconds slept so far, and those since `run`."""
        return self._slept + (self._running.now() if self._running else 0.0)

    def sleep(self, seconds: float):
        """Move the clock on by `seconds` at once; after `run`, wait for them. What is due on the way is done."""
        if self._running:
            self._running.sleep(seconds)
        elif seconds > 0:
            end = self._slept + seconds
            while action := self._next(end):
                action()
            with self._lock:
                self._slept = max(self._slept, end)

    def _next(self, end: float) -> Callable[[], None] | None:
        """The next action that is due by `end`, the clock being at its moment."""
        with self._lock:
            if not self._alarms or self._alarms[0][0] > end:
                return None
            due, _, action = heapq.heappop(self._alarms)
            self._slept = max(self._slept, due)
            return action

    def later(self, seconds: float, action: Callable[[], None]) -> None:
        """Call `action()` in `seconds`: inside the `sleep` that passes that moment."""
        if self._running:
            self._running.later(seconds, action)
        else:
            with self._lock:
                heapq.heappush(self._alarms, (self._slept + seconds, next(self._count), action))


def period(rate: float) -> float:
    """Seconds from one turn to the next of a loop at `rate` turns a second; raises `BadInput`."""
    if not (isinstance(rate, Real) and math.isfinite(rate) and rate > 0):
        raise BadInput(f"`rate` must be a positive number of turns a second; got {rate!r}.")
    return 1.0 / rate


def ticks(seconds: float, rate: float, clock: Clock | None = None) -> Iterator[float]:
    """The moments (s since the start) of a fixed-rate loop: `for t in ticks(10, rate=50): ...`.

    Waits for each moment without drift: a slow turn of the loop does not shift those after it. Moments that have
    already passed come at once, so that no sample is left out. `clock` (wall time if left out) has `now` and `sleep`.
    """
    clock = clock or Clock()
    if not (isinstance(seconds, Real) and math.isfinite(seconds) and seconds >= 0):
        raise BadInput(f"`seconds` must be 0 or more; got {seconds!r}.")
    start, step = clock.now(), period(rate)
    for i in range(math.floor(seconds / step + 1e-9) + 1):
        wait = start + i * step - clock.now()
        if wait > 0:
            clock.sleep(wait)
        yield clock.now() - start
