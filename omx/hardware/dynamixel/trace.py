"""What went over the wire: one transaction as data, and in words."""

from typing import NamedTuple

from .packet import ALERT, BROADCAST, STATUS_ERRORS, Instruction, Packet, Reader, word
from .registers import Block, within

_READS = (Instruction.READ, Instruction.SYNC_READ)


class Transaction(NamedTuple):
    """One request and its answers. `time_s` is when it began, `seconds` how long it took, `fault` what went wrong."""

    time_s: float
    seconds: float
    sent: bytes
    received: bytes
    fault: str = ""

    def hex(self) -> str:
        """The bytes both ways."""
        return f"> {self.sent.hex(' ')}\n< {self.received.hex(' ')}"

    def explain(self) -> str:
        """The packets in words: one line for the request and one for each answer."""
        requests, answers = Reader().feed(self.sent), Reader().feed(self.received)
        address, length = _asked(requests[0]) if requests else (0, 0)
        lines = [f"{self.time_s:10.4f} s  {1000 * self.seconds:.2f} ms"]
        lines += [f"  > {_request(packet)}" for packet in requests]
        lines += [f"  < {_answer(packet, address, length)}" for packet in answers]
        if self.fault:
            lines.append(f"  ! {self.fault}")
        return "\n".join(lines)


def _asked(packet: Packet) -> tuple[int, int]:
    """Address and length that the answers to `packet` hold, (0, 0) if they hold none."""
    if packet.instruction not in _READS or len(packet.params) < 4:
        return 0, 0
    return word(packet.params), word(packet.params, 2)


def _request(packet: Packet) -> str:
    name = _name(packet.instruction)
    to = "all" if packet.id == BROADCAST else f"servo {packet.id}"
    address, length = _asked(packet)
    if length:
        ids = " of " + ", ".join(map(str, packet.params[4:])) if len(packet.params) > 4 else ""
        return f"{name}, {to}: {length} bytes from {address} ({_names(address, length)}){ids}"
    if packet.instruction in (Instruction.WRITE, Instruction.REG_WRITE):
        return f"{name}, {to}: {_values(word(packet.params), packet.params[2:])}"
    if packet.instruction == Instruction.SYNC_WRITE:
        address, size, rest = word(packet.params), word(packet.params, 2), packet.params[4:]
        each = [rest[i : i + size + 1] for i in range(0, len(rest), size + 1)]
        return f"{name}, {to}: " + "; ".join(f"{part[0]}: {_values(address, part[1:])}" for part in each)
    return f"{name}, {to}" + (f": {packet.params.hex(' ')}" if packet.params else "")


def _name(instruction: int) -> str:
    try:
        return Instruction(instruction).name.lower().replace("_", " ")
    except ValueError:
        return f"instruction {instruction:#04x}"


def _names(address: int, length: int) -> str:
    rows = within(address, length)
    return Block(tuple(rows)).names if rows else "no register"


def _values(address: int, data: bytes) -> str:
    parts = []
    for row in within(address, len(data)):
        raw, unit = row.decode(data[row.address - address : row.end - address]), row.unit
        parts.append(f"{row.name} {raw}" + (f" = {unit.value(raw):.4g} {unit.symbol}" if unit.symbol else ""))
    return ", ".join(parts) or data.hex(" ")


def _answer(packet: Packet, address: int, length: int) -> str:
    if not packet.intact or packet.error is None:
        return f"damaged packet, id {packet.id}"
    code, data = packet.error & ~ALERT, packet.params
    said = STATUS_ERRORS.get(code, f"error {code}") if code else "ok"
    alert = ", ALERT" if packet.error & ALERT else ""
    shown = f": {_values(address, data)}" if length and len(data) == length else f": {data.hex(' ')}" if data else ""
    return f"{packet.id} {said}{alert}{shown}"
