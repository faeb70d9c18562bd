"""At most so many calls a second, and the last value is never lost."""

import asyncio
import time


class Latest:
    """Calls `action(value)` at once, or when `interval` seconds since the last call have passed, with the newest value.

    With `eager` False even the first value waits, so that more urgent messages go first. Without a running
    event loop nothing could call later, so then every value is passed on at once.
    """

    def __init__(self, action, interval: float, *, eager: bool = True):
        self._action, self._interval, self._eager = action, interval, eager
        self._due = 0.0
        self._waiting: list = []

    def __call__(self, value) -> None:
        wait = self._due - time.monotonic() if self._eager else self._interval
        loop = _running_loop()
        if wait <= 0 or loop is None:
            self._waiting.clear()
            self._call(value)
        elif self._waiting:
            self._waiting[0] = value
        else:
            self._waiting.append(value)
            loop.call_later(wait, self.flush)

    def flush(self) -> None:
        """Pass on the value that is waiting, if any."""
        if self._waiting:
            self._call(self._waiting.pop())

    def _call(self, value) -> None:
        self._due = time.monotonic() + self._interval
        self._action(value)


def _running_loop():
    try:
        return asyncio.get_running_loop()
    except RuntimeError:
        return None
