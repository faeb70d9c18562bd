"""What one servo does for each instruction. A function returns the parameters of the answer, or refuses."""

from ..dynamixel import packet as pk
from ..dynamixel.packet import Instruction as Do
from .control_table import Refusal

_CLEAR_TURNS = b"\x01\x44\x58\x4c\x22"
#: Option of a factory reset -> registers that keep their value.
_KEEP = {0xFF: (), 0x01: ("id",), 0x02: ("id", "baud_rate")}


def obey(servo, packet: pk.Packet, now: float, elapsed: float) -> tuple[int, bytes]:
    """Do what the packet says, and return error code and parameters of the answer.

    `now` is the time, `elapsed` how much of it has passed since the joints' last step (s).
    """
    if not packet.intact:
        return pk.CRC_ERROR, b""
    action = _ACTIONS.get(packet.instruction)
    if action is None:
        return pk.INSTRUCTION_ERROR, b""
    try:
        return 0, action(servo, packet, now, elapsed) or b""
    except Refusal as refusal:
        return refusal.code, b""


def word(data: bytes, start: int = 0) -> int:
    """The two bytes from `start`, low byte first."""
    return int.from_bytes(data[start : start + 2], "little")


def words(*values: int) -> bytes:
    """Each value as two bytes, low byte first."""
    return b"".join(value.to_bytes(2, "little") for value in values)


def _ping(servo, packet, now, elapsed):
    return words(servo.table["model_number"]) + bytes((servo.table["firmware_version"],))


def _read(servo, packet, now, elapsed):
    if len(packet.params) != 4:
        raise Refusal(pk.DATA_LENGTH)
    return servo.read(word(packet.params), word(packet.params, 2), now, elapsed)


def _write(servo, packet, now, elapsed):
    servo.write(word(packet.params), packet.params[2:], now)


def _reg_write(servo, packet, now, elapsed):
    address, data = word(packet.params), packet.params[2:]
    servo.check(address, data)
    servo.registered = (address, data)
    servo.table.put("registered_instruction", 1)


def _action(servo, packet, now, elapsed):
    if servo.registered is None:
        raise Refusal(pk.INSTRUCTION_ERROR)
    registered, servo.registered = servo.registered, None
    servo.table.put("registered_instruction", 0)
    servo.write(*registered, now)


def _factory_reset(servo, packet, now, elapsed):
    option = packet.params[0] if len(packet.params) == 1 else None
    if option not in _KEEP:
        raise Refusal(pk.DATA_RANGE)
    if packet.id == pk.BROADCAST and option == 0xFF:
        raise Refusal(pk.ACCESS)  # or all servos would end up with id 1
    servo.factory_reset(now, _KEEP[option])


def _reboot(servo, packet, now, elapsed):
    servo.reboot(now)


def _clear(servo, packet, now, elapsed):
    if packet.params != _CLEAR_TURNS:
        raise Refusal(pk.DATA_RANGE)
    if servo.moving(now):
        raise Refusal(pk.RESULT_FAIL)
    servo.clear_turns(now)


_ACTIONS = {
    Do.PING: _ping,
    Do.READ: _read,
    Do.WRITE: _write,
    Do.REG_WRITE: _reg_write,
    Do.ACTION: _action,
    Do.FACTORY_RESET: _factory_reset,
    Do.REBOOT: _reboot,
    Do.CLEAR: _clear,
}
