"""Protocol 1.0, which a servo speaks whose `protocol_type` is 1: enough of it to find such a servo and to set it back.

    FF FF | id | length | instruction | parameters | checksum

Addresses are one byte. Ping, read, write, reg write, action, reboot and sync write; the maker's e-manual, Protocol 1.0.
"""

from ..dynamixel import packet as pk
from ..dynamixel import registers as reg
from ..dynamixel.packet import Instruction as Do
from .servo_chain import Frame, obey

_HEADER = b"\xff\xff"
_CHECKSUM, _RANGE, _INSTRUCTION = 0x10, 0x08, 0x40
_ERRORS = {0: 0, pk.CRC_ERROR: _CHECKSUM, pk.INSTRUCTION_ERROR: _INSTRUCTION}
#: Hardware errors that have the same bit in a status packet.
_ALARMS = reg.VOLTAGE | reg.OVERHEATED | reg.OVERLOAD


def packets(data: bytes):
    """(id, instruction, parameters, intact) of each whole packet in `data`; those of Protocol 2.0 are passed over."""
    start = data.find(_HEADER)
    while 0 <= start <= len(data) - 6:
        servo, length = data[start + 2], data[start + 3]
        end = start + 4 + length
        if servo in (0xFF, 0xFD) or length < 2 or end > len(data):
            start = data.find(_HEADER, start + 1)
            continue
        body = data[start + 2 : end - 1]
        yield servo, body[2], body[3:], _checksum(body) == data[end - 1]
        start = data.find(_HEADER, end)


def answers(servos, data: bytes, now: float) -> list[Frame]:
    """What those of `servos` that speak this protocol do and say."""
    frames = []
    for to, instruction, params, intact in packets(data):
        for servo, request in _requests(servos, to, instruction, params, intact):
            servo.heard = now
            code, found = obey(servo, request, now)
            if servo.id == to and servo.table["status_return_level"] >= {Do.PING: 0, Do.READ: 1}.get(instruction, 2):
                frames.append(_status(servo, code, b"" if instruction == Do.PING else found))
    return frames


def _requests(servos, to: int, instruction: int, params: bytes, intact: bool):
    """Each servo that is meant, with the same request in Protocol 2.0."""
    if instruction == Do.SYNC_WRITE and to == pk.BROADCAST and len(params) > 2:
        address, length = params[:2]
        for i in range(2, len(params) - length, length + 1):
            yield from _requests(
                servos, params[i], Do.WRITE, bytes((address,)) + params[i + 1 : i + 1 + length], intact
            )
        return
    if instruction == Do.READ and len(params) == 2:
        params = pk.words(*params)
    elif instruction in (Do.WRITE, Do.REG_WRITE) and params:
        params = pk.words(params[0]) + params[1:]
    request = pk.Packet(to, instruction, params, None, intact)
    yield from ((servo, request) for servo in servos if to in (pk.BROADCAST, servo.id))


def _status(servo, code: int, data: bytes) -> Frame:
    error = _ERRORS.get(code, _RANGE) | servo.table["hardware_error"] & _ALARMS
    body = bytes((servo.id, len(data) + 2, error)) + data
    return Frame(servo.id, _HEADER + body + bytes((_checksum(body),)), servo.table["return_delay_time"] * 2e-6)


def _checksum(body: bytes) -> int:
    return ~sum(body) & 0xFF
