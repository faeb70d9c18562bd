"""What one servo does for each instruction. A function returns the parameters of the answer, or refuses."""

from ..dynamixel import packet as pk
from ..dynamixel.packet import Instruction as Do
from .control_table import Refusal

#: Option of a factory reset -> registers that keep their value.
_KEEP = {pk.RESET_ALL: (), pk.RESET_BUT_ID: ("id",), pk.RESET_BUT_ID_AND_BAUD: ("id", "baud_rate")}
_BACKUP_FIRMWARE = 45


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


def word(data: bytes, start: int = 0) -> int:
    """The two bytes from `start`, low byte first."""
    return int.from_bytes(data[start : start + 2], "little")


def words(*values: int) -> bytes:
    """Each value as two bytes, low byte first."""
    return b"".join(value.to_bytes(2, "little") for value in values)


def _ping(servo, packet, now):
    return words(servo.table["model_number"]) + bytes((servo.table["firmware_version"],))


def _read(servo, packet, now):
    if len(packet.params) != 4:
        raise Refusal(pk.DATA_LENGTH)
    return servo.read(word(packet.params), word(packet.params, 2), now)


def _write(servo, packet, now):
    servo.write(word(packet.params), packet.params[2:], now)


def _reg_write(servo, packet, now):
    address, data = word(packet.params), packet.params[2:]
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


def _reboot(servo, packet, now):
    servo.reboot(now)


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
    Do.WRITE: _write,
    Do.REG_WRITE: _reg_write,
    Do.ACTION: _action,
    Do.FACTORY_RESET: _factory_reset,
    Do.REBOOT: _reboot,
    Do.CLEAR: _clear,
    Do.BACKUP: _backup,
}
