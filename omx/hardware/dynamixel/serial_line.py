"""Opening a serial line: exclusively, with a short read timeout, and with reasons when it cannot be had."""

import contextlib
import errno
import sys
from urllib.parse import urlsplit

import serial
from serial import SerialException as SerialException  # the virtual line raises it, too

from ...errors import PortBusy, PortError
from . import web_serial

#: USB adapters that the arm is sold with: U2D2 (FTDI) and OpenCR, by vendor and product id.
ADAPTERS = {(0x0403, 0x6014): "U2D2", (0x0403, 0x6001): "USB serial (FTDI)", (0xFFF1, 0xFF48): "OpenCR",
            (0x0483, 0x5740): "OpenCR"}  # fmt: skip


#: How long a read waits for the next bytes. Zero would spin: 44 % of a core instead of 5 %.
READ_TIMEOUT_S = 0.002

_REASONS = {
    errno.ENOENT: "there is no such port. Is the USB plug in? On Linux it is mostly /dev/ttyUSB0 or /dev/ttyACM0, on "
    "macOS /dev/tty.usbserial-..., on Windows COM3 or higher",
    errno.EACCES: "the system does not let you use it. On Linux add yourself to the group dialout, then log out and "
    "in again; on Windows another program has it open",
    errno.ECONNREFUSED: "nobody listens there. Is the virtual arm running?",
}
_BUSY = "another program or another notebook has it open. Close that one first: two at once corrupt each other"


def open_line(name: str, baud: int):
    """An open pyserial line to `name`: a serial port, or a `socket://127.0.0.1:PORT` URL; or a browser's "webserial".

    Raises PortBusy if someone else has it, PortError with the reason otherwise.
    """
    if name == web_serial.NAME:
        return web_serial.WebSerial(baud, READ_TIMEOUT_S)
    try:
        if "://" in name:
            _check_url(name)
            return serial.serial_for_url(name, baudrate=baud, timeout=READ_TIMEOUT_S)
        line = serial.Serial(name, baudrate=baud, timeout=READ_TIMEOUT_S, exclusive=True)
    except (OSError, ValueError) as error:
        raise _explained(name, error) from error
    _keep_others_out(line)
    with contextlib.suppress(Exception):  # Linux and a USB adapter: 1 ms instead of 16 ms latency
        line.set_low_latency_mode(True)
    return line


def _check_url(name: str):
    try:
        parts = urlsplit(name)
        if parts.hostname and parts.port:
            return
    except ValueError:  # a port that is no number, or too large
        pass
    raise PortError(name, "a served arm is named socket://127.0.0.1:PORT, as it prints at its start")


def _explained(name: str, error: Exception) -> PortError:
    number = getattr(error, "errno", None)
    if number is None and isinstance(error.__context__, OSError):
        number = error.__context__.errno
    text = str(error)
    if number in (errno.EBUSY, errno.EAGAIN, errno.EWOULDBLOCK) or "exclusively lock" in text:
        return PortBusy(name, _BUSY, number)
    if number is None and "FileNotFoundError" in text:  # Windows: pyserial keeps only the text
        number = errno.ENOENT
    if number is None and "PermissionError" in text:
        return PortBusy(name, _BUSY, errno.EACCES)
    return PortError(name, _REASONS.get(number, f"cannot be opened: {text}"), number)


def _keep_others_out(line):
    """Ask the system to refuse every later open, also by programs that do not know of pyserial's lock."""
    try:
        import fcntl
        import os
        import termios
    except ImportError:  # Windows: ports are exclusive there
        return
    # A pseudo-terminal lives on after it is closed, and so would the lock.
    if not os.path.realpath(line.port).startswith(("/dev/pts/", "/dev/ttys")):
        with contextlib.suppress(OSError):
            fcntl.ioctl(line.fileno(), termios.TIOCEXCL)


def find_ports(adapters_only: bool = False) -> list[str]:
    """Serial ports that may have the arm, likely adapters first; or those of adapters that arms are sold with alone."""
    if sys.platform == "emscripten":
        return web_serial.find_ports()  # pyserial would not even import its list there
    from serial.tools import list_ports

    ports = [port for port in list_ports.comports() if port.vid is not None]
    if adapters_only:
        ports = [port for port in ports if (port.vid, port.pid) in ADAPTERS]
    ports.sort(key=lambda port: ((port.vid, port.pid) not in ADAPTERS, port.device))
    return [port.device for port in ports]
