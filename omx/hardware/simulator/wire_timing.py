"""The cable between a program and the virtual arm: bytes in, bytes out, each at its time."""

from collections import deque

from ...errors import BadInput
from ..dynamixel.packet import Reader
from . import protocol1, servo_chain
from .virtual_arm import VirtualArm

#: A packet whose next byte is this late is given up (s).
GAP_S = 0.05
_BITS_PER_BYTE = 10  # start bit, eight bits, stop bit


class Wire:
    """One opened line to `arm`.

    `baud` is the sender's rate: servos set to another one do not hear it; None if the line has no rate. With
    `timed`, bytes take the time that they take at this rate, and `latency_s` passes before the USB adapter hands
    them over (its latency timer); otherwise answers are there at once.
    """

    def __init__(self, arm: VirtualArm, baud: int | None = None, timed: bool = False, latency_s: float = 0.0):
        if timed and not baud:
            raise BadInput("A timed wire needs a baud rate, or there is nothing to time.")
        self.arm, self.baud, self.timed, self.latency_s = arm, baud, timed, latency_s
        self._reader = Reader()
        self._last_byte = 0.0
        self._coming: deque[tuple[float, bytes]] = deque()

    def send(self, data: bytes, now: float):
        """The program writes `data` at time `now` (s, the arm's)."""
        if now - self._last_byte > GAP_S:
            self._reader.clear()
        self._last_byte = now
        heard = now + self._duration(data)
        with self.arm.lock:
            self.arm.advance(heard)
            for packet in self._reader.feed(data):
                frames = servo_chain.answers(self.arm.servos, packet, heard, self.baud)
                self._schedule(self.arm.faults.distort(frames), heard)
            if old := [servo for servo in self.arm.servos if servo.hears(heard, self.baud, protocol=1)]:
                self._schedule(self.arm.faults.distort(protocol1.answers(old, data, heard)), heard)

    def _schedule(self, frames, time: float):
        for frame in frames:
            time += frame.delay if self.timed or frame.late else 0.0
            time += self._duration(frame.data)
            due = max(time + self.latency_s, self._coming[-1][0] if self._coming else 0.0)
            self._coming.append((due, frame.data))

    def _duration(self, data: bytes) -> float:
        return len(data) * _BITS_PER_BYTE / self.baud if self.timed else 0.0

    def receive(self, size: int, now: float) -> bytes:
        """Up to `size` bytes that have arrived by `now`."""
        out = b""
        while self._coming and self._coming[0][0] <= now and len(out) < size:
            due, data = self._coming.popleft()
            need = size - len(out)
            if len(data) > need:
                self._coming.appendleft((due, data[need:]))
            out += data[:need]
        return out

    def waiting(self, now: float) -> int:
        """How many bytes have arrived by `now` and not been received."""
        return sum(len(data) for due, data in self._coming if due <= now)

    @property
    def next_due(self) -> float | None:
        """When the next bytes arrive, or None if none are on their way."""
        return self._coming[0][0] if self._coming else None

    def drop(self, now: float):
        """Throw away what has arrived by `now`; what is on its way still comes."""
        while self._coming and self._coming[0][0] <= now:
            self._coming.popleft()
