"""A serial line in a browser: `navigator.serial` where Python runs, as something like a pyserial line.

There is a port only after the reader has pressed *Connect the arm* in the page that is open. What goes over it is
the business of the same SDK as everywhere, but that only questions pass: see `ReadOnly`.
"""

import sys
from functools import cache
from pathlib import Path
from time import perf_counter

from serial import SerialException

from ...errors import PortBusy, PortError

#: The name of the one port that a browser has.
NAME = "webserial"
HOW = "press *Connect the arm*, at the top of the page, and choose the arm's adapter (Chrome and Edge can)"


@cache
def _script():
    from pyodide.code import run_js

    return run_js(Path(__file__).with_name("web_serial.js").read_text(encoding="utf-8"))


def _wait(promise):
    from pyodide.ffi import run_sync

    return run_sync(promise)


def find_ports() -> list[str]:
    """The port that the reader has connected, if so."""
    if sys.platform != "emscripten":
        return []
    from pyodide.ffi import can_run_sync

    return [NAME] if can_run_sync() and _wait(_script().connected()) else []


class WebSerial:
    """What the SDK uses of a `serial.Serial`. Raises PortError if the reader has connected no arm."""

    def __init__(self, baud: int, timeout: float):
        self.timeout = timeout
        if not find_ports():
            raise PortError(NAME, f"no arm is connected to this page: {HOW}")
        self._line = _script().line()
        wrong = _wait(self._line.open(baud))
        if wrong.startswith("InvalidStateError"):
            raise PortBusy(NAME, "this notebook has it open already. Close that robot or bus first")
        if wrong:
            raise PortError(
                NAME, f"the browser cannot open it ({wrong}). Has another program or notebook the port open?"
            )

    @property
    def in_waiting(self) -> int:
        """How many bytes can be read at once."""
        return len(self._line.bytes)

    def write(self, data: bytes) -> int:
        """Send `data`."""
        from pyodide.ffi import to_js

        if wrong := _wait(self._line.write(to_js(data))):
            raise SerialException(wrong)
        return len(data)

    def read(self, size: int = 1) -> bytes:
        """Up to `size` bytes; waits for them until the timeout."""
        until = perf_counter() + self.timeout
        while self.in_waiting < size and (left := until - perf_counter()) > 0 and not self._line.lost:
            _wait(self._line.wait(1000 * left))
        if self._line.lost and not self.in_waiting:
            raise SerialException(self._line.lost)
        return self._line.take(size).to_bytes()

    def reset_input_buffer(self) -> None:
        """Forget what has arrived."""
        self._line.drop()

    def close(self) -> None:
        """Let the port go."""
        _wait(self._line.close())
