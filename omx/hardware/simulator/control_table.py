"""A servo's memory: the control table, and the rules about who may read and write what."""

from functools import lru_cache

from ..dynamixel import packet as pk
from ..dynamixel import registers as reg
from ..dynamixel.registers import REGISTERS, TABLE_SIZE, Register, at

#: Bytes that stand for other bytes: indirect data address -> name of the register that holds its target.
_INDIRECT = {
    row.address: row.name.replace("data", "address")
    for row in REGISTERS.values()
    if row.name.startswith("indirect_data")
}
FIRST_INDIRECT = min(_INDIRECT)
GOALS = ("goal_pwm", "goal_current", "goal_velocity", "goal_position")
_WATCHDOG_FIRMWARE, _STARTUP_FIRMWARE = 38, 45


class Refusal(Exception):
    """The servo will not do it; `code` is the error number of the status packet."""

    def __init__(self, code: int):
        self.code = code
        super().__init__(pk.STATUS_ERRORS[code])


class Table(dict[str, int]):
    """The registers of one servo: `table[name]` for what was written, `read` for everything, as bytes."""

    __slots__ = ("_memory", "written")

    def __init__(self):
        super().__init__()
        self._memory = bytearray(TABLE_SIZE)
        self.written = True  # until whoever works by the registers has seen it
        for row in REGISTERS.values():
            self.put(row.name, row.default)

    def put(self, name: str, value: int):
        """Set a register, without asking whether that is allowed."""
        self[name], self.written = value, True
        self.show(REGISTERS[name], value)

    def show(self, row: Register, value: int):
        """What `row`, which reports the present, reads from now on; `table[name]` does not know it."""
        self._memory[row.address : row.end] = (value % (1 << 8 * row.size)).to_bytes(row.size, "little")

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
        if end <= FIRST_INDIRECT:
            return bytes(self._memory[address:end])
        return bytes(self._memory[self._target(a)] for a in range(address, end))

    def _target(self, address: int) -> int:
        name = _INDIRECT.get(address)
        return self[name] if name else address

    def changes(self, address: int, data: bytes) -> list[tuple[Register, int]]:
        """The registers that writing `data` at `address` sets, with their new values; whole registers only."""
        if not data:
            raise Refusal(pk.DATA_LENGTH)
        targets = range(address, address + len(data))
        if targets.stop > FIRST_INDIRECT:
            targets = tuple(map(self._target, targets))
        return [(row, row.decode(bytes([data[i] for i in places]))) for row, places in _whole(targets)]

    # ---- the rules ----

    def check(self, row: Register, value: int):
        """Refuse a write that the row, the mode or the state of the servo forbids."""
        if row.name in GOALS and self["bus_watchdog"] == reg.WATCHDOG_TRIPPED:
            raise Refusal(pk.DATA_RANGE)
        if not row.writable or (row.eeprom and self["torque_enable"]):
            raise Refusal(pk.ACCESS)
        if not row.low <= value <= row.high:
            raise Refusal(pk.DATA_RANGE)
        if row.name == "torque_enable" and value and self["hardware_error"] & self["shutdown"]:
            raise Refusal(pk.RESULT_FAIL)
        if row.name == "drive_mode" and value & ~(reg.DRIVE_REVERSE | reg.DRIVE_TIME_BASED | reg.DRIVE_TORQUE_BY_GOAL):
            raise Refusal(pk.DATA_RANGE)
        if row.name == "operating_mode" and value not in reg.MODES.values():
            raise Refusal(pk.DATA_RANGE)
        if row.name.startswith("profile") and self["drive_mode"] & reg.DRIVE_TIME_BASED and value > 32737:
            raise Refusal(pk.DATA_RANGE)
        if row.name == "startup_configuration" and self["firmware_version"] < _STARTUP_FIRMWARE:
            raise Refusal(pk.ACCESS)
        if row.name == "bus_watchdog" and self["firmware_version"] < _WATCHDOG_FIRMWARE:
            raise Refusal(pk.ACCESS)
        low, high = self._limits(row)
        if not low <= value <= high:
            raise Refusal(pk.DATA_LIMIT)

    def _limits(self, row: Register) -> tuple[int, int]:
        """The limits that other registers set for this one, or its own."""
        if row.name in ("goal_pwm", "goal_current", "goal_velocity"):
            limit = self[row.name.removeprefix("goal_") + "_limit"]
            return -limit, limit
        if row.name == "goal_position" and self["operating_mode"] == reg.MODES["position"]:
            return self["min_position_limit"], self["max_position_limit"]
        return row.low, row.high

    def new_mode(self):
        """What a change of `operating_mode` does to other registers."""
        for name in (*reg.GAINS, "profile_velocity", "profile_acceleration"):
            self.put(name, REGISTERS[name].default)
        self.put("goal_pwm", self["pwm_limit"])
        self.put("goal_current", self["current_limit"])
        self.put("goal_velocity", 0)


@lru_cache
def _whole(targets) -> list[tuple[Register, list[int]]]:
    """The registers whose bytes the addresses `targets` are, and where among them each has its own."""
    places = {target: i for i, target in enumerate(targets)}
    rows = dict.fromkeys(at(target) for target in sorted(places))
    if None in rows:
        raise Refusal(pk.ACCESS)
    if not all(a in places for row in rows for a in range(row.address, row.end)):
        raise Refusal(pk.DATA_LENGTH)
    return [(row, [places[a] for a in range(row.address, row.end)]) for row in rows]
