"""Serving the virtual arm to other programs, in a process of its own.

In a thread it would starve beside a busy notebook, and its answers would come too late. The arm is computed while it
moves, not when somebody asks: a program may wait 34 ms for an answer, and a second of motion takes 20 ms to compute.
"""

import os
import queue
import socket
import threading

from ...errors import BadInput, OmxError
from ..clock import Clock
from .virtual_arm import VirtualArm
from .wire_timing import Wire

#: How often (s) the arm is computed while it moves, and while it rests.
BUSY_S, RESTING_S = 0.02, 0.5
#: A server that was held up longer than this (s) does not make up for it: the arm's time stood still meanwhile.
CATCH_UP_S = 1.0


class Orders:
    """What comes in on standard input, read in a thread; `waker` becomes readable when there is something."""

    def __init__(self):
        try:
            os.fstat(0)
        except OSError:
            raise BadInput("--stdin: standard input is closed.") from None
        self.lines: queue.Queue[str | None] = queue.Queue()
        self.waker, self._bell = socket.socketpair()
        threading.Thread(target=self._listen, daemon=True).start()

    def _listen(self):
        rest = b""
        while data := _received():
            *lines, rest = (rest + data).split(b"\n")
            for line in lines:
                self._put(line.decode(errors="replace"))
        self._put(None)

    def _put(self, line: str | None):
        self.lines.put(line)
        self._bell.send(b"!")

    def take(self) -> list[str | None]:
        """The lines that have come in; None stands for the end."""
        lines = []
        while not self.lines.empty():
            self.waker.recv(1)
            lines.append(self.lines.get())
        return lines


def _received() -> bytes:
    try:
        return os.read(0, 4096)
    except OSError:  # a terminal that has gone is an end, too
        return b""


class Pace:
    """The arm's time: the clock's, less whatever the server was held up for beyond `CATCH_UP_S`."""

    def __init__(self, clock: Clock, arm: VirtualArm):
        self._clock, self._arm, self._most = clock, arm, CATCH_UP_S * clock.scale
        self._lost = clock.now() - arm.now

    def now(self) -> float:
        """The arm's present (s)."""
        now = self._clock.now() - self._lost
        late = max(now - self._arm.now - self._most, 0.0)
        self._lost += late
        return now - late

    def seconds(self, until: float) -> float:
        """How long (s, by the wall) until the arm's time is `until`."""
        return max(until - self.now(), 0.0) / self._clock.scale


def serve(end, arm: VirtualArm, clock: Clock, orders: Orders | None = None):
    """Carry bytes between `end` and `arm`, and keep the arm's time going, until the orders end, or for ever."""
    pace, wire = Pace(clock, arm), Wire(arm)
    arm.connect(pace.now)
    wakers = [orders.waker] if orders else []
    while True:
        wait_s = BUSY_S if arm.busy else RESTING_S
        if wire.next_due is not None:
            wait_s = min(wait_s, pace.seconds(wire.next_due))
        end.wait(wait_s, wakers)
        for order in orders.take() if orders else ():
            if order is None:
                return
            print(obey(arm, order), flush=True)
        arm.advance(pace.now())
        _carry(end, arm, wire, pace.now())


def _carry(end, arm: VirtualArm, wire: Wire, now: float):
    data = end.read()
    if not arm.plugged:
        end.hang_up()
        return
    if data:
        wire.baud = end.baud
        wire.send(data, now)
    if answer := wire.receive(4096, now):
        end.write(answer)


def obey(arm: VirtualArm, order: str) -> str:
    """Carry out one order; `ok`, or what is wrong with it."""
    try:
        if order.strip() == "clear":
            arm.faults.clear()
        else:
            kind, options = parse_fault(order)
            arm.faults.inject(kind, **options)
    except OmxError as error:
        return f"refused: {error}"
    return "ok"


def parse_fault(text: str) -> tuple[str, dict]:
    """`lost servo=13 count=2` as the arguments of `Faults.inject`."""
    kind, *options = text.split() or [""]
    types = {"servo": int, "count": float, "after": float, "value": float}
    given = {}
    for option in options:
        name, _, number = option.partition("=")
        try:
            given[name] = types[name](number)
        except (KeyError, ValueError):
            form = "KIND servo=13 count=2 after=0.5 value=1"
            raise BadInput(
                f"A fault is written `{form}`, and all but the kind may be left out; got {text!r}."
            ) from None
    return kind, given
