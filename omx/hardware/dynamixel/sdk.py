"""The maker's `dynamixel_sdk` with a remedy for each of its pitfalls. No other module of omx imports it.

Used of it: `PortHandler`, and sending and receiving of single packets (its low-level API, version 4.0.5 or newer).
"""

import contextlib
import os
import weakref

import dynamixel_sdk

from ...errors import PortBusy, PortLost
from ..clock import Clock
from . import packet as pk
from . import web_serial
from .serial_line import open_line

#: More bytes than any answer has: a line that goes on after them is noise, not an answer.
MOST_BYTES = 4 * pk.MAX_LENGTH
#: How long to wait for an answer beyond what the SDK allows (34 ms), where another process or a network is between.
SOCKET_PATIENCE_S = 0.25


#: The ports that this process has open.
_open_here = weakref.WeakSet()


def is_open_here(name: str) -> bool:
    """True if this very process has the port `name` open."""
    return any(port.is_open and _same(port.port_name, name) for port in list(_open_here))


def _same(one: str, other: str) -> bool:
    return one == other or ("://" not in one + other and os.path.realpath(one) == os.path.realpath(other))


def _in_a_forked_child() -> None:
    """The arm belongs to the process that opened it: a copy of that process must neither drive it nor hang up."""
    for port in list(_open_here):
        port.is_open = False
        with contextlib.suppress(Exception):
            port.ser.is_open = False  # closing it, as the end of the child would, shuts a socket for the parent, too


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_in_a_forked_child)


class Silence(Exception):
    """No byte came in time."""


class Damage(Exception):
    """What came is no whole packet."""


class Port(dynamixel_sdk.PortHandler):
    """The SDK's port, opened with care: exclusive, with a short read timeout, and with its bytes recorded.

    `clock` is the time it lives in; `patience_s` is how much longer than the SDK it waits for an answer. Over a
    `read_only` one, such as a browser's, nothing but questions goes out.
    """

    def __init__(self, name: str, clock: Clock | None = None, patience_s: float | None = None):
        super().__init__(name)
        self.clock = clock or Clock()
        self.read_only = name == web_serial.NAME
        far = self.read_only or "://" in name
        self.patience_s = (SOCKET_PATIENCE_S if far else 0.0) if patience_s is None else patience_s
        self.sent, self.received = b"", bytearray()
        self._heard = False

    def open_line(self):
        """A serial line at `self.baudrate`; a virtual port gives something that looks like one."""
        return open_line(self.port_name, self.baudrate)

    def setupPort(self, cflag_baud):
        """Open the line, as the SDK does; raises PortError with the reason instead of returning False."""
        if self.is_open:
            self.closePort()
        self.ser = self.open_line()
        self.is_open, self._heard = True, False
        _open_here.add(self)
        self.tx_time_per_byte = 10_000.0 / self.baudrate  # ms
        self.clearPort()
        return True

    def closePort(self):
        """Close the line; twice does no harm."""
        if self.is_open:
            self.is_open = False
            with contextlib.suppress(Exception):  # a line that is gone cannot be closed
                self.ser.close()

    def clearPort(self):
        """Forget what has arrived."""
        self._guarded(self.ser.reset_input_buffer)

    def getBytesAvailable(self):
        """How many bytes have arrived and not been read."""
        return self._guarded(lambda: self.ser.in_waiting)

    def writePort(self, packet):
        """Send a packet and record it."""
        self.sent, self.received = bytes(packet), bytearray()
        return self._guarded(self.ser.write, self.sent)

    def readPort(self, length):
        """Up to `length` bytes, after at most the read timeout."""
        data = self._guarded(self.ser.read, length)
        self.received += data
        self._heard = self._heard or bool(data)
        if len(self.received) > MOST_BYTES:  # the SDK would read on for ever
            raise Damage
        return data

    def _guarded(self, call, *args):
        try:
            return call(*args)
        except Exception as error:  # pyserial lets OSError, termios.error and TypeError through
            self.closePort()
            if "://" in self.port_name and not self._heard:
                raise PortBusy(self.port_name, "it hung up at once: another program is connected to it") from error
            raise PortLost(self.port_name, f"the port has gone ({error}). Is the USB plug in?") from error

    def getCurrentTime(self):
        """Milliseconds of this port's clock; the wall clock that the SDK takes can jump."""
        return self.clock.now() * 1000.0

    def setPacketTimeout(self, packet_length):
        """The SDK's timeout, and this port's patience on top."""
        super().setPacketTimeout(packet_length)
        self.packet_timeout += self.patience_s * 1000.0


class Protocol(dynamixel_sdk.Protocol2PacketHandler):
    """The SDK's packets, with byte stuffing done right both ways, a fast checksum, and errors that are raised."""

    def send(self, port: Port, to: int, instruction: int, params: bytes, answer_bytes: int):
        """Send one packet, and give an answer of `answer_bytes` its time from now."""
        length = len(params) + 3
        result = self.txPacket(port, [0, 0, 0, 0, to, length & 0xFF, length >> 8, instruction, *params, 0, 0])
        if result != dynamixel_sdk.COMM_SUCCESS:
            port.closePort()
            raise PortLost(port.port_name, "the packet did not go out. Is the USB plug in?")
        port.setPacketTimeout(answer_bytes)

    def receive(self, port: Port) -> list[int]:
        """The next packet, byte stuffing removed, from its header to its checksum."""
        frame, result = self.rxPacket(port, False)
        if result == dynamixel_sdk.COMM_RX_TIMEOUT:
            raise Silence
        if result != dynamixel_sdk.COMM_SUCCESS:
            raise Damage
        return frame

    def addStuffing(self, packet):
        """In place: the SDK stuffs a copy, and sends the original."""
        body = pk.stuff(bytes(packet[7:-2]))
        packet[5:] = [*(len(body) + 2).to_bytes(2, "little"), *body, 0, 0]
        return packet

    def removeStuffing(self, packet):
        """From the original: the SDK looks at bytes it has moved, and loses an FD after the first stuffed one."""
        body = pk.unstuff(bytes(packet[7:-2]))
        packet[5:] = [*(len(body) + 2).to_bytes(2, "little"), *body, *packet[-2:]]
        return packet

    def updateCRC(self, crc_accum, data_blk_ptr, data_blk_size):
        """The checksum of the first `data_blk_size` bytes."""
        return pk.crc16(bytes(data_blk_ptr[:data_blk_size]), crc_accum)
