"""The line that the servos share: a packet comes in, each servo does its part, and their answers go out in turn."""

from typing import NamedTuple

from ..dynamixel import packet as pk
from ..dynamixel.packet import Instruction as Do
from .instructions import obey, word, words

_FAST = (Do.FAST_SYNC_READ, Do.FAST_BULK_READ)
_FAST_FIRMWARE = 45


class Frame(NamedTuple):
    """Bytes that the servo with id `servo` puts on the wire, `delay` s after the request or the frame before.

    `late` frames are late even on a wire that takes no time.
    """

    servo: int
    data: bytes
    delay: float = 0.0
    late: bool = False


class Line:
    """The servos of one arm, as they answer on the wire."""

    def __init__(self, servos):
        self._servos = servos
        self._groups = {
            Do.SYNC_READ: self._sync_read,
            Do.FAST_SYNC_READ: self._sync_read,
            Do.BULK_READ: self._bulk_read,
            Do.FAST_BULK_READ: self._bulk_read,
            Do.SYNC_WRITE: self._sync_write,
            Do.BULK_WRITE: self._bulk_write,
        }

    def answer(self, packet: pk.Packet, now: float, baud: int | None = None) -> list[Frame]:
        """What comes back for one packet. `baud` is the sender's rate; None on a line that has none."""
        servos = [s for s in self._servos if s.hears(now, baud)]
        everyone = packet.id == pk.BROADCAST
        addressed = servos if everyone else [s for s in servos if s.listens_to(packet.id)]
        for servo in addressed:
            servo.heard(now)
        if everyone and not packet.intact:
            return []
        if everyone and packet.instruction in self._groups:
            return self._groups[packet.instruction](packet, servos, now)
        return self._single(packet, addressed, now)

    def _single(self, packet, servos, now) -> list[Frame]:
        everyone = packet.id == pk.BROADCAST
        needed = {Do.PING: 0, Do.READ: 1}.get(packet.instruction, 2)  # status return level that makes it answer
        frames = []
        for servo in sorted(servos, key=lambda s: s.id):
            own_id, level = servo.id, servo.table["status_return_level"]
            answer = obey(servo, packet, now)
            silent = packet.instruction != Do.PING if everyone else packet.id != own_id
            if level >= needed and not silent:
                frames.append(_status(servo, own_id, *answer))
        return frames if everyone else _collide(frames)

    # ---- several servos with one packet ----

    def _sync_read(self, packet, servos, now) -> list[Frame]:
        address, length = word(packet.params, 0), word(packet.params, 2)
        return self._read_group(packet, servos, now, [(i, address, length) for i in packet.params[4:]])

    def _bulk_read(self, packet, servos, now) -> list[Frame]:
        p = packet.params
        wanted = [(p[i], word(p, i + 1), word(p, i + 3)) for i in range(0, len(p) - 4, 5)]
        return self._read_group(packet, servos, now, wanted)

    def _read_group(self, packet, servos, now, wanted) -> list[Frame]:
        """Each servo answers after the one before it in the list; after a missing one the rest stay silent."""
        fast = packet.instruction in _FAST
        frames, parts = [], []
        for servo_id, address, length in wanted:
            able = [s for s in servos if s.id == servo_id and _able(s, fast)]
            if not able:
                break
            request = pk.Packet(servo_id, Do.READ, words(address, length))
            answers = [obey(servo, request, now) for servo in able]
            frames += _collide([_status(s, servo_id, *a) for s, a in zip(able, answers, strict=True)])
            error, data = answers[0]
            parts.append((servo_id, error | _alert(able[0]), data.ljust(length, b"\0")))
        if not fast or not parts:
            return frames
        whole = 1 + sum(4 + length for _, _, length in wanted)
        if whole > pk.MAX_LENGTH - 7:
            return []  # more than a packet can hold
        return [Frame(parts[0][0], pk.build_fast_status(parts, whole), frames[0].delay)]

    def _sync_write(self, packet, servos, now) -> list[Frame]:
        address, length = packet.params[:2], word(packet.params, 2)
        rest = packet.params[4:]
        for i in range(0, len(rest) - length, length + 1):
            self._write_one(servos, rest[i], address + rest[i + 1 : i + 1 + length], now)
        return []

    def _bulk_write(self, packet, servos, now) -> list[Frame]:
        rest = packet.params
        while len(rest) >= 5 and len(rest) >= 5 + word(rest, 3):
            end = 5 + word(rest, 3)
            self._write_one(servos, rest[0], rest[1:3] + rest[5:end], now)
            rest = rest[end:]
        return []

    def _write_one(self, servos, servo_id, params, now):
        for servo in servos:
            if servo.id == servo_id:
                obey(servo, pk.Packet(servo_id, Do.WRITE, params), now)


def _able(servo, fast: bool) -> bool:
    new_enough = not fast or servo.table["firmware_version"] >= _FAST_FIRMWARE
    return new_enough and servo.table["status_return_level"] >= 1


def _alert(servo) -> int:
    return pk.ALERT if servo.table["hardware_error"] else 0


def _status(servo, own_id: int, error: int, data: bytes) -> Frame:
    delay = servo.table["return_delay_time"] * 2e-6
    return Frame(own_id, pk.build_status(own_id, error | _alert(servo), data), delay)


def _collide(frames: list[Frame]) -> list[Frame]:
    """Servos with one id answer at once; on this line a 0 from any of them wins."""
    if len(frames) < 2:
        return frames
    size = max(len(frame.data) for frame in frames)
    mixed = bytes([0xFF]) * size
    for frame in frames:
        mixed = bytes(a & b for a, b in zip(mixed, frame.data.ljust(size, b"\xff"), strict=True))
    return [Frame(frames[0].servo, mixed, frames[0].delay)]
