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
        self[name] = value

    def __setitem__(self, name: str, value: int):
        super().__setitem__(name, value)
        self.written = True
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

    def check(self, row: Register, value: int):
        """Refuse a write that the row, the mode or the state of the servo forbids."""
        for names, forbids, code in _RULES:
            if row.name in names and forbids(self, row, value):
                raise Refusal(code)

    def new_mode(self):
        """What a change of `operating_mode` does to other registers."""
        for name in (*reg.GAINS, "profile_velocity", "profile_acceleration"):
            self.put(name, REGISTERS[name].default)
        self.put("goal_pwm", self["pwm_limit"])
        self.put("goal_current", self["current_limit"])
        self.put("goal_velocity", 0)


_DRIVE_MODES = reg.DRIVE_REVERSE | reg.DRIVE_TIME_BASED | reg.DRIVE_TORQUE_BY_GOAL
#: What forbids to write a value, in the order in which a servo looks: to which registers, when, and its error.
_RULES = (
    (GOALS, lambda at, row, value: at["bus_watchdog"] == reg.WATCHDOG_TRIPPED, pk.DATA_RANGE),
    (REGISTERS, lambda at, row, value: not row.writable or (row.eeprom and at["torque_enable"]), pk.ACCESS),
    (REGISTERS, lambda at, row, value: not row.low <= value <= row.high, pk.DATA_RANGE),
    (("torque_enable",), lambda at, row, value: value and at["hardware_error"] & at["shutdown"], pk.RESULT_FAIL),
    (("drive_mode",), lambda at, row, value: value & ~_DRIVE_MODES, pk.DATA_RANGE),
    (("operating_mode",), lambda at, row, value: value not in reg.MODES.values(), pk.DATA_RANGE),
    (("profile_velocity", "profile_acceleration"),
     lambda at, row, value: at["drive_mode"] & reg.DRIVE_TIME_BASED and value > 32737, pk.DATA_RANGE),
    (("startup_configuration",), lambda at, row, value: at["firmware_version"] < _STARTUP_FIRMWARE, pk.ACCESS),
    (("bus_watchdog",), lambda at, row, value: at["firmware_version"] < _WATCHDOG_FIRMWARE, pk.ACCESS),
    (("goal_pwm", "goal_current", "goal_velocity"),
     lambda at, row, value: abs(value) > at[row.name.removeprefix("goal_") + "_limit"], pk.DATA_LIMIT),
    (("goal_position",), lambda at, row, value: at["operating_mode"] == reg.MODES["position"]
     and not at["min_position_limit"] <= value <= at["max_position_limit"], pk.DATA_LIMIT),
)  # fmt: skip


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
