"""Protocol 2.0 packets as pure bytes: checksum, byte stuffing, building and taking apart.

    FF FF FD 00 | id | length (2) | instruction | parameters | checksum (2)

`length` counts everything after itself. The answer of a servo, a status packet, has instruction 0x55 and one
error byte before its parameters. Source: the maker's e-manual, Protocol 2.0.
"""

import struct
from collections.abc import Iterable
from enum import IntEnum
from functools import lru_cache
from typing import NamedTuple

HEADER = b"\xff\xff\xfd\x00"
BROADCAST = 0xFE
MAX_ID = 0xFC
#: Longest packet that is believed: the limit of the servo's buffer.
MAX_LENGTH = 1024
_WORD = struct.Struct("<H")
_PATTERN, _STUFFED = b"\xff\xff\xfd", b"\xff\xff\xfd\xfd"


class Instruction(IntEnum):
    """What a packet asks for."""

    PING = 0x01
    READ = 0x02
    WRITE = 0x03
    REG_WRITE = 0x04
    ACTION = 0x05
    FACTORY_RESET = 0x06
    REBOOT = 0x08
    CLEAR = 0x10
    BACKUP = 0x20
    STATUS = 0x55
    SYNC_READ = 0x82
    SYNC_WRITE = 0x83
    FAST_SYNC_READ = 0x8A
    BULK_READ = 0x92
    BULK_WRITE = 0x93
    FAST_BULK_READ = 0x9A


#: What asks, and changes nothing in a servo.
QUESTIONS = frozenset((Instruction.PING, Instruction.READ, Instruction.SYNC_READ))

#: Parameters of CLEAR (forget whole turns), BACKUP (the table into the servo's store, and back), FACTORY_RESET.
CLEAR_TURNS = b"\x01DXL\x22"
STORE, RESTORE = b"\x01CTRL", b"\x02CTRL"
RESET_ALL, RESET_BUT_ID, RESET_BUT_ID_AND_BAUD = b"\xff", b"\x01", b"\x02"

#: What the low seven bits of a status packet's error byte mean. Bit 7 is the alert: look at register 70.
STATUS_ERRORS = {
    1: "result fail",
    2: "instruction error",
    3: "checksum error",
    4: "data range error",
    5: "data length error",
    6: "data limit error",
    7: "access error",
}
RESULT_FAIL, INSTRUCTION_ERROR, CRC_ERROR, DATA_RANGE, DATA_LENGTH, DATA_LIMIT, ACCESS = range(1, 8)
ALERT = 0x80


class Packet(NamedTuple):
    """One packet without its byte stuffing.

    `error` is None in an instruction; `intact` is False if the checksum does not match.
    """

    id: int
    instruction: int
    params: bytes
    error: int | None = None
    intact: bool = True


def _crc_table() -> tuple[int, ...]:
    table = []
    for byte in range(256):
        crc = byte << 8
        for _ in range(8):
            crc = (crc << 1) ^ (0x8005 if crc & 0x8000 else 0)
        table.append(crc & 0xFFFF)
    return tuple(table)


_CRC = _crc_table()


def crc16(data: Iterable[int], crc: int = 0) -> int:
    """The checksum: CRC-16, polynomial 0x8005, not reflected; start from `crc` to continue an earlier one."""
    return _crc16(bytes(data if isinstance(data, (bytes, bytearray)) else iter(data)), crc)


@lru_cache
def _crc16(data: bytes, crc: int) -> int:
    """Kept for a while: at a virtual arm both ends of the line are in one process, and ask for the same one."""
    table = _CRC
    for byte in data:
        crc = (crc << 8 & 0xFF00) ^ table[crc >> 8 ^ byte]
    return crc


def word(data: bytes, start: int = 0) -> int:
    """The two bytes from `start`, low byte first."""
    return int.from_bytes(data[start : start + 2], "little")


def words(*values: int) -> bytes:
    """Each value as two bytes, low byte first."""
    return b"".join(map(_WORD.pack, values))


def stuff(body: bytes) -> bytes:
    """Insert FD after every FF FF FD, so that no header appears inside a packet."""
    return body.replace(_PATTERN, _STUFFED) if _PATTERN in body else body


def unstuff(body: bytes) -> bytes:
    """The inverse of `stuff`."""
    return body.replace(_STUFFED, _PATTERN) if _STUFFED in body else body


def build(servo: int, instruction: int, params: bytes = b"") -> bytes:
    """The instruction packet for one servo, or for `BROADCAST`."""
    return _frame(servo, stuff(bytes((instruction,)) + params))


def build_status(servo: int, error: int = 0, params: bytes = b"") -> bytes:
    """The answer of one servo."""
    return _frame(servo, stuff(bytes((Instruction.STATUS, error)) + params))


def build_fast_status(answers, length: int) -> bytes:
    """The common answer to a fast read, from (id, error, data) of each servo in turn.

    Each servo appends its part and the checksum of everything so far. These packets are never stuffed.
    `length` is what the header promises: that of all parts, also if some servos do not send theirs.
    """
    out = HEADER + bytes((BROADCAST, *words(length), Instruction.STATUS))
    for servo, error, data in answers:
        out += bytes((error, servo)) + data
        out += words(crc16(out))
    return out


def _frame(servo: int, body: bytes) -> bytes:
    head = HEADER + bytes((servo,)) + words(len(body) + 2) + body
    return head + words(crc16(head))


class Reader:
    """Finds packets in a stream of bytes: drops rubbish between them, keeps an unfinished one."""

    def __init__(self):
        self._buffer = b""

    def clear(self):
        """Forget an unfinished packet."""
        self._buffer = b""

    def feed(self, data: bytes) -> list[Packet]:
        """The packets that end within `data`."""
        self._buffer += data
        packets = []
        while (packet := self._next()) is not None:
            packets.append(packet)
        return packets

    def _next(self) -> Packet | None:
        while True:
            buffer = self._buffer = _from_header(self._buffer)
            if len(buffer) < 7:
                return None
            end = 7 + word(buffer, 5)
            if not 10 <= end <= MAX_LENGTH:
                self._buffer = buffer[1:]
                continue
            # Stuffing forbids a header inside a packet: if there is one, the first packet was cut short.
            restart = -1 if _is_fast(buffer) else buffer.find(HEADER, 4, end - 2)
            if restart > 0:
                self._buffer = buffer[restart:]
                continue
            if len(buffer) < end:
                return None
            return self._take(end)

    def _take(self, end: int) -> Packet:
        packet = _take_apart(self._buffer[:end])
        if not packet.intact:  # its length may be wrong too: go on from the next header, wherever that is
            restart = self._buffer.find(HEADER, 4, end + 3)
            end = restart if restart > 0 else end
        self._buffer = self._buffer[end:]
        return packet


def _from_header(buffer: bytes) -> bytes:
    """`buffer` from its first header on, or the last few bytes if they may begin one."""
    start = buffer.find(HEADER)
    if start >= 0:
        return buffer[start:]
    for keep in (3, 2, 1):
        if buffer.endswith(HEADER[:keep]):
            return buffer[-keep:]
    return b""


def _is_fast(buffer: bytes) -> bool:
    return buffer[4] == BROADCAST and buffer[7:8] == bytes((Instruction.STATUS,))


def _take_apart(frame: bytes) -> Packet:
    intact = crc16(frame[:-2]) == word(frame[-2:])
    servo, body = frame[4], frame[7:-2]
    if not _is_fast(frame):
        body = unstuff(body)
    if body[0] != Instruction.STATUS:
        return Packet(servo, body[0], body[1:], None, intact)
    if len(body) < 2:
        return Packet(servo, body[0], b"", None, False)
    return Packet(servo, body[0], body[2:], body[1], intact)
