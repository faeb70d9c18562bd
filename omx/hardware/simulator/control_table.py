"""A servo's memory: the control table with its rules about who may read and write what."""

from ..dynamixel import packet as pk
from ..dynamixel.registers import REGISTERS, TABLE_SIZE, Register, at

#: Bytes that stand for other bytes: indirect data address -> name of the register that holds its target.
_INDIRECT = {
    row.address: row.name.replace("data", "address")
    for row in REGISTERS.values()
    if row.name.startswith("indirect_data")
}
_FIRST_INDIRECT = min(_INDIRECT)


class Refusal(Exception):
    """The servo will not do it; `code` is the error number of the status packet."""

    def __init__(self, code: int):
        self.code = code
        super().__init__(pk.STATUS_ERRORS[code])


class Table:
    """The registers of one servo: `table[name]` for what was written, `read` for everything, as bytes."""

    def __init__(self):
        self._values: dict[str, int] = {}
        self._memory = bytearray(TABLE_SIZE)
        for row in REGISTERS.values():
            self.put(row.name, row.default)

    def __getitem__(self, name: str) -> int:
        return self._values[name]

    def put(self, name: str, value: int):
        """Set a register, without asking whether that is allowed."""
        self._values[name] = value
        self.show(name, value)

    def show(self, name: str, value: int):
        """What the register `name`, which reports the present, reads from now on; `table[name]` does not know it."""
        row = REGISTERS[name]
        self._memory[row.address : row.end] = (value % (1 << 8 * row.size)).to_bytes(row.size, "little")

    def shown(self, names, address: int, length: int) -> list[str]:
        """Which of the registers `names` show in `length` bytes from `address`: all, if those stand for others."""
        end = address + length
        if end > _FIRST_INDIRECT:
            return list(names)
        return [name for name in names if REGISTERS[name].address < end and REGISTERS[name].end > address]

    def restore(self, keep=lambda row: False):
        """Put the factory's value into every writable register that `keep` does not name."""
        for row in REGISTERS.values():
            if row.writable and not keep(row):
                self.put(row.name, row.default)

    def read(self, address: int, length: int) -> bytes:
        """The bytes from `address` on; gaps of the table read as zero."""
        end = address + length
        if not length:
            raise Refusal(pk.DATA_LENGTH)
        if end > TABLE_SIZE or not any(at(a) for a in range(address, end)):
            raise Refusal(pk.ACCESS)
        if end <= _FIRST_INDIRECT:
            return bytes(self._memory[address:end])
        return bytes(self._memory[self._target(a)] for a in range(address, end))

    def _target(self, address: int) -> int:
        name = _INDIRECT.get(address)
        return self._values[name] if name else address

    def changes(self, address: int, data: bytes) -> list[tuple[Register, int]]:
        """The registers that writing `data` at `address` sets, with their new values; whole registers only."""
        if not data:
            raise Refusal(pk.DATA_LENGTH)
        new = {self._target(address + i): byte for i, byte in enumerate(data)}
        rows = dict.fromkeys(at(target) for target in sorted(new))
        if None in rows:
            raise Refusal(pk.ACCESS)
        changes = []
        for row in rows:
            whole = [new.get(a) for a in range(row.address, row.end)]
            if None in whole:
                raise Refusal(pk.DATA_LENGTH)
            changes.append((row, row.decode(bytes(whole))))
        return changes

    def check(self, row: Register, value: int):
        """Refuse what the row itself forbids: writing a constant, the locked EEPROM, a value out of its range."""
        if not row.writable or (row.eeprom and self._values["torque_enable"]):
            raise Refusal(pk.ACCESS)
        if not row.low <= value <= row.high:
            raise Refusal(pk.DATA_RANGE)
