"""A port to a virtual arm inside this process: the SDK's own code runs over it, unchanged, on any system.

There is no thread. What the arm does between two packets is worked out when the next one arrives.
"""

import errno

from ...errors import PortBusy, PortError
from ..clock import Clock
from ..dynamixel.sdk import Port
from ..dynamixel.serial_line import READ_TIMEOUT_S, SerialException
from .virtual_arm import VirtualArm
from .wire_timing import Wire

#: What a port inside this process is called.
NAME = "virtual"


class VirtualPort(Port):
    """An in-process port to `arm` (a new one if none is given).

    `clock`: `Clock()` real time, `Clock(10)` ten times as fast, `SteppedClock()` moves only when slept on. With
    `timed`, the wire takes its time at the baud rate, and `latency_s` more as a USB adapter does.
    """

    def __init__(self, arm: VirtualArm | None = None, clock=None, timed: bool = False, latency_s: float = 0.0):
        super().__init__(NAME, clock or Clock())
        self.arm = arm or VirtualArm()
        self._timed, self._latency_s = timed, latency_s

    def open_line(self):
        """The look-alike of a serial line that the SDK reads and writes."""
        return VirtualSerial(self.arm, self.clock, Wire(self.arm, self.baudrate, self._timed, self._latency_s))


class VirtualSerial:
    """What the SDK uses of a `serial.Serial`, at the virtual arm's end of a `Wire`."""

    timeout = READ_TIMEOUT_S

    def __init__(self, arm: VirtualArm, clock, wire: Wire):
        late = clock.now() - arm.now  # the arm goes on from where it was, whatever the clock shows
        self._arm, self._clock, self._wire = arm, clock, wire
        self._time = lambda: clock.now() - late
        if not arm.plugged:
            raise PortError(NAME, "the virtual plug is pulled. arm.faults.clear() puts it back", errno.ENOENT)
        if not arm.connect(self._time):
            raise PortBusy(NAME, "another connection to this virtual arm is open. Close that one first")
        self.is_open = True

    def _now(self) -> float:
        if not self._arm.plugged:
            raise SerialException(errno.EIO, "the virtual plug is pulled")
        return self._time()

    @property
    def in_waiting(self) -> int:
        """How many bytes can be read at once."""
        return self._wire.waiting(self._now())

    def write(self, data: bytes) -> int:
        """Send `data`."""
        self._wire.send(bytes(data), self._now())
        return len(data)

    def read(self, size: int = 1) -> bytes:
        """Up to `size` bytes; waits for them until the timeout."""
        now = self._now()
        until = now + self.timeout
        data = self._wire.receive(size, now)
        while len(data) < size and now < until:
            due = self._wire.next_due
            self._clock.sleep(max(min(until if due is None else due, until) - now, 1e-6))
            now = self._now()
            data += self._wire.receive(size - len(data), now)
        return data

    def reset_input_buffer(self):
        """Forget what has arrived."""
        self._wire.drop(self._now())

    def close(self):
        """Let the arm go; someone else may open it."""
        if self.is_open:
            self.is_open = False
            self._arm.disconnect()
