"""The line that the servos share: a packet comes in, each servo does its part, and their answers go out in turn."""

from typing import NamedTuple

from ..dynamixel import packet as pk
from ..dynamixel.packet import Instruction as Do
from .control_table import Refusal

_FAST = (Do.FAST_SYNC_READ, Do.FAST_BULK_READ)
_FAST_FIRMWARE = _BACKUP_FIRMWARE = 45
#: Option of a factory reset -> registers that keep their value.
_KEEP = {pk.RESET_ALL: (), pk.RESET_BUT_ID: ("id",), pk.RESET_BUT_ID_AND_BAUD: ("id", "baud_rate")}


class Frame(NamedTuple):
    """Bytes that the servo with id `servo` puts on the wire, `delay` s after the request or the frame before.

    `late` frames are late even on a wire that takes no time.
    """

    servo: int
    data: bytes
    delay: float = 0.0
    late: bool = False


def answers(servos, packet: pk.Packet, now: float, baud: int | None = None) -> list[Frame]:
    """What `servos` send back for one packet. `baud` is the sender's rate; None on a line that has none."""
    servos = [s for s in servos if s.hears(now, baud)]
    everyone = packet.id == pk.BROADCAST
    addressed = servos if everyone else [s for s in servos if s.listens_to(packet.id)]
    for servo in addressed:
        servo.heard = now
    if everyone and not packet.intact:
        return []
    if everyone and packet.instruction in _GROUPS:
        return _GROUPS[packet.instruction](packet, servos, now)
    return _single(packet, addressed, now)


def _single(packet, servos, now) -> list[Frame]:
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


def _sync_read(packet, servos, now) -> list[Frame]:
    address, length = pk.word(packet.params, 0), pk.word(packet.params, 2)
    return _read_group(packet, servos, now, [(i, address, length) for i in packet.params[4:]])


def _bulk_read(packet, servos, now) -> list[Frame]:
    p = packet.params
    wanted = [(p[i], pk.word(p, i + 1), pk.word(p, i + 3)) for i in range(0, len(p) - 4, 5)]
    return _read_group(packet, servos, now, wanted)


def _read_group(packet, servos, now, wanted) -> list[Frame]:
    """Each servo answers after the one before it in the list; after a missing one the rest stay silent."""
    fast = packet.instruction in _FAST
    frames, parts, able = [], [], {}
    for servo in servos:
        new_enough = not fast or servo.table["firmware_version"] >= _FAST_FIRMWARE
        if new_enough and servo.table["status_return_level"] >= 1:
            able.setdefault(servo.id, []).append(servo)
    for servo_id, address, length in wanted:
        if servo_id not in able:
            break
        request = pk.Packet(servo_id, Do.READ, pk.words(address, length))
        answers = [obey(servo, request, now) for servo in able[servo_id]]
        frames += _collide([_status(s, servo_id, *a) for s, a in zip(able[servo_id], answers, strict=True)])
        error, data = answers[0]
        parts.append((servo_id, error | _alert(able[servo_id][0]), data.ljust(length, b"\0")))
    if not fast or not parts:
        return frames
    whole = 1 + sum(4 + length for _, _, length in wanted)
    if whole > pk.MAX_LENGTH - 7:
        return []  # more than a packet can hold
    return [Frame(parts[0][0], pk.build_fast_status(parts, whole), frames[0].delay)]


def _sync_write(packet, servos, now) -> list[Frame]:
    address, length = packet.params[:2], pk.word(packet.params, 2)
    rest = packet.params[4:]
    for i in range(0, len(rest) - length, length + 1):
        _write_one(servos, rest[i], address + rest[i + 1 : i + 1 + length], now)
    return []


def _bulk_write(packet, servos, now) -> list[Frame]:
    rest = packet.params
    while len(rest) >= 5 and len(rest) >= 5 + pk.word(rest, 3):
        end = 5 + pk.word(rest, 3)
        _write_one(servos, rest[0], rest[1:3] + rest[5:end], now)
        rest = rest[end:]
    return []


def _write_one(servos, servo_id, params, now):
    for servo in servos:
        if servo.id == servo_id:
            obey(servo, pk.Packet(servo_id, Do.WRITE, params), now)


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


# ---- what one servo does: each gives the parameters of its answer, or refuses ----


def obey(servo, packet: pk.Packet, now: float) -> tuple[int, bytes]:
    """Do at the time `now` (s) what the packet says, and return error code and parameters of the answer."""
    if not packet.intact:
        return pk.CRC_ERROR, b""
    action = _ACTIONS.get(packet.instruction)
    if action is None:
        return pk.INSTRUCTION_ERROR, b""
    try:
        return 0, action(servo, packet, now) or b""
    except Refusal as refusal:
        return refusal.code, b""


def _ping(servo, packet, now):
    return pk.words(servo.table["model_number"]) + bytes((servo.table["firmware_version"],))


def _read(servo, packet, now):
    if len(packet.params) != 4:
        raise Refusal(pk.DATA_LENGTH)
    return servo.read(pk.word(packet.params), pk.word(packet.params, 2), now)


def _reg_write(servo, packet, now):
    address, data = pk.word(packet.params), packet.params[2:]
    servo.check(address, data)
    servo.registered = (address, data)
    servo.table.put("registered_instruction", 1)


def _action(servo, packet, now):
    if servo.registered is None:
        raise Refusal(pk.INSTRUCTION_ERROR)
    registered, servo.registered = servo.registered, None
    servo.table.put("registered_instruction", 0)
    servo.write(*registered, now)


def _factory_reset(servo, packet, now):
    if packet.params not in _KEEP:
        raise Refusal(pk.DATA_RANGE)
    if packet.id == pk.BROADCAST and packet.params == pk.RESET_ALL:
        raise Refusal(pk.ACCESS)  # or all servos would end up with id 1
    servo.factory_reset(now, _KEEP[packet.params])


def _clear(servo, packet, now):
    if packet.params != pk.CLEAR_TURNS:
        raise Refusal(pk.DATA_RANGE)
    if servo.moving(now):
        raise Refusal(pk.RESULT_FAIL)
    servo.clear_turns(now)


def _backup(servo, packet, now):
    if servo.table["firmware_version"] < _BACKUP_FIRMWARE:
        raise Refusal(pk.INSTRUCTION_ERROR)
    if packet.params not in (pk.STORE, pk.RESTORE):
        raise Refusal(pk.DATA_RANGE)
    if servo.torque_on or (packet.params == pk.RESTORE and not servo.table["backup_ready"]):
        raise Refusal(pk.RESULT_FAIL)
    if packet.params == pk.STORE:
        servo.store()
    else:
        servo.restore(now)


_ACTIONS = {
    Do.PING: _ping,
    Do.READ: _read,
    Do.WRITE: lambda servo, packet, now: servo.write(pk.word(packet.params), packet.params[2:], now),
    Do.REG_WRITE: _reg_write,
    Do.ACTION: _action,
    Do.FACTORY_RESET: _factory_reset,
    Do.REBOOT: lambda servo, packet, now: servo.reboot(now),
    Do.CLEAR: _clear,
    Do.BACKUP: _backup,
}
_GROUPS = {
    Do.SYNC_READ: _sync_read,
    Do.FAST_SYNC_READ: _sync_read,
    Do.BULK_READ: _bulk_read,
    Do.FAST_BULK_READ: _bulk_read,
    Do.SYNC_WRITE: _sync_write,
    Do.BULK_WRITE: _bulk_write,
}
