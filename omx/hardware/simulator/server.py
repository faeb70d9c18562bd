"""Serving the virtual arm to other programs, in a process of its own.

In a thread it would starve beside a busy notebook, and its answers would come too late. Standard input takes
orders, one a line: a fault such as `lost servo=13 count=2`, or `clear`. When it ends, the process ends.
"""

import os
import queue
import socket
import threading

from ...errors import BadInput, OmxError
from ..clock import Clock
from .virtual_arm import VirtualArm
from .wire_timing import Wire

_IDLE_S = 60.0


class Orders:
    """What comes in on standard input, read in a thread; `waker` becomes readable when there is something."""

    def __init__(self):
        self.lines: queue.Queue[str | None] = queue.Queue()
        self.waker, self._bell = socket.socketpair()
        threading.Thread(target=self._listen, daemon=True).start()

    def _listen(self):
        rest = b""
        while data := os.read(0, 4096):
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


def serve(end, arm: VirtualArm, orders: Orders, scale: float = 1.0):
    """Carry bytes between `end` and `arm` until the orders end."""
    clock, wire = Clock(scale), Wire(arm)
    arm.connect(clock.now)
    while True:
        due = wire.next_due
        wait_s = _IDLE_S if due is None else max(due - clock.now(), 0.0) / scale
        end.wait(wait_s, orders.waker)
        for order in orders.take():
            if order is None:
                return
            print(obey(arm, order), flush=True)
        _carry(end, arm, wire, clock.now())


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
