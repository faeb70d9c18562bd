"""The time a port lives in: a wall clock for the real arm; real, scaled or stepped time for the virtual one."""

import threading
import time

from ..errors import BadInput


class Clock:
    """Seconds since the clock was made, `scale` times as fast as the wall clock."""

    def __init__(self, scale: float = 1.0):
        if not scale > 0:
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


class SteppedClock:
    """A clock that moves only when someone sleeps on it: the same run gives the same times, at any speed."""

    def __init__(self):
        self._now = 0.0
        self._lock = threading.Lock()

    def now(self) -> float:
        """Seconds slept so far."""
        return self._now

    def sleep(self, seconds: float):
        """Move the clock on by `seconds` at once."""
        if seconds > 0:
            with self._lock:
                self._now += seconds
