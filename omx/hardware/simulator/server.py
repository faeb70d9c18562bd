"""Serving the virtual arm to other programs, in a process of its own.

In a thread it would starve beside a busy notebook, and its answers would come too late. The arm is computed while it
moves, not when somebody asks: a program may wait 34 ms for an answer, and a second of motion takes 20 ms to compute.
"""

import _thread
import contextlib
import errno
import os
import select
import signal
import socket
import struct
import sys
from collections.abc import Iterable

from ...errors import BadInput, OmxError
from ..clock import Clock
from .virtual_arm import VirtualArm
from .wire_timing import Wire

#: How often (s) the arm is computed while it moves, and while it rests.
BUSY_S, RESTING_S = 0.02, 0.5
#: A server that was held up longer than this (s) does not make up for it: the arm's time stood still meanwhile.
CATCH_UP_S = 1.0
_TCGETS2 = 0x802C542A  # Linux: struct termios2, whose last two fields are the speeds in bits per second
_TERMIOS2 = struct.Struct("4I20B2I")


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


def serve(end: "TcpEnd | PtyEnd", arm: VirtualArm, clock: Clock):
    """Carry bytes between `end` and `arm`, and keep the arm's time going, until it is interrupted."""
    pace, wire = Pace(clock, arm), Wire(arm)
    arm.connect(pace.now)
    while True:
        wait_s = BUSY_S if arm.busy else RESTING_S
        if wire.next_due is not None:
            wait_s = min(wait_s, pace.seconds(wire.next_due))
        end.wait(wait_s)
        arm.advance(pace.now())
        _carry(end, arm, wire, pace.now())


def follow(orders: Iterable[str], arm: VirtualArm):
    """Carry out `orders`, each a fault or `clear`, and print what came of it.

    When they end, or those who gave them have gone, the program is ended.
    """
    try:
        for order in orders:
            try:
                with arm.lock:
                    arm.faults.clear() if order.strip() == "clear" else arm.faults.inject_text(order)
                print("ok", flush=True)
            except OmxError as error:
                print(f"refused: {error}", flush=True)
    except OSError:  # a pipe or a terminal that has gone
        sys.stdout = None  # there is nobody to flush it for
    finally:
        _thread.interrupt_main(signal.SIGTERM)


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


# ---- the ends of a line to another program ----


class TcpEnd:
    """A TCP port on the loopback interface; one client at a time, as on a serial line.

    Every page in a browser may send a request to this computer. No packet begins with a letter as every request does,
    so whoever begins with one is a web page, and is hung up on.
    """

    baud = None  # a socket has no rate

    def __init__(self, port: int = 0):
        try:
            self._listener = socket.create_server(("127.0.0.1", port), backlog=1)
        except OSError as error:
            why = "somebody has it, perhaps another virtual arm" if error.errno == errno.EADDRINUSE else error.strerror
            raise BadInput(f"TCP port {port} cannot be had: {why}. Take another; 0 takes a free one.") from error
        self._client: socket.socket | None = None
        self._new = True  # until the client has said something
        self.name = f"socket://127.0.0.1:{self._listener.getsockname()[1]}"

    def wait(self, seconds: float):
        """Return after `seconds`, or earlier when a client has something to say."""
        select.select([self._listener, *([self._client] if self._client else [])], [], [], seconds)

    def read(self) -> bytes:
        """What the client has sent. A newcomer is let in if there is no client, and shown the door otherwise."""
        if self._client and _readable(self._client):
            data = b""
            with contextlib.suppress(OSError):
                data = self._client.recv(4096)
            if not data or (self._new and data[:1].isalpha()):
                self.hang_up()
                return b""
            self._new = False
            return data
        if _readable(self._listener):  # whoever has just left has been heard out, and is gone
            newcomer, _ = self._listener.accept()
            if self._client:
                newcomer.close()
            else:
                newcomer.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                newcomer.setblocking(False)
                self._client, self._new = newcomer, True
        return b""

    def write(self, data: bytes):
        """Send to the client, if one is there; what one that does not read has no room for is lost, as on a wire."""
        try:
            if self._client:
                self._client.send(data)
        except BlockingIOError:
            pass
        except OSError:
            self.hang_up()

    def hang_up(self):
        """Let the client go."""
        if self._client:
            self._client.close()
            self._client = None

    def close(self):
        """Give the port back."""
        self.hang_up()
        self._listener.close()


def _readable(sock) -> bool:
    return bool(select.select([sock], [], [], 0)[0])


class PtyEnd:
    """A pseudo-terminal (Linux, macOS): for other programs it is a serial port."""

    def __init__(self):
        import tty

        # The slave stays open on our side too, or the pair would break with the first client that closes it.
        self._master, self._slave = os.openpty()
        tty.setraw(self._slave)
        os.set_blocking(self._master, False)
        self.name = os.ttyname(self._slave)

    @property
    def baud(self) -> int | None:
        """The rate that the client has set; None on macOS, whose terminals do not reach the servos' rate."""
        if not sys.platform.startswith("linux"):
            return None
        # Clients set rates as constants or as numbers; only the second form of the settings tells both.
        import fcntl

        settings = fcntl.ioctl(self._slave, _TCGETS2, bytes(_TERMIOS2.size))
        return _TERMIOS2.unpack(settings)[-1]

    def wait(self, seconds: float):
        """Return after `seconds`, or earlier when the client has something to say."""
        select.select([self._master], [], [], seconds)

    def read(self) -> bytes:
        """What the client has sent."""
        with contextlib.suppress(BlockingIOError):
            return os.read(self._master, 4096)
        return b""

    def write(self, data: bytes):
        """Send to the client; what does not fit into the terminal's buffer is lost, as on a real line."""
        with contextlib.suppress(BlockingIOError):
            os.write(self._master, data)

    def hang_up(self):
        """A terminal does not know who listens: there is nobody to let go."""

    def close(self):
        """Give the terminal back."""
        os.close(self._slave)
        os.close(self._master)
