"""A servo's memory: the control table, the rules about who may read and write what, and what a write sets off.

The rules see the table only. What a write does to the servo itself comes back as `Effect`s, in order.
"""

from enum import Enum, auto

from ..dynamixel import packet as pk
from ..dynamixel import registers as reg
from ..dynamixel.registers import REGISTERS, TABLE_SIZE, Register, at

#: Bytes that stand for other bytes: indirect data address -> name of the register that holds its target.
_INDIRECT = {
    row.address: row.name.replace("data", "address")
    for row in REGISTERS.values()
    if row.name.startswith("indirect_data")
}
_FIRST_INDIRECT = min(_INDIRECT)
_GOALS = ("goal_pwm", "goal_current", "goal_velocity", "goal_position")
_WATCHDOG_FIRMWARE, _STARTUP_FIRMWARE = 38, 45


class Effect(Enum):
    """What a servo does because of a write."""

    RELEASE = auto()  # the torque is off: forget where the set-point was going
    WRAP = auto()  # forget whole turns
    PLAN = auto()  # lay the trajectory to the goal


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
        self.written = True  # until whoever works by the registers has seen it
        for row in REGISTERS.values():
            self.put(row.name, row.default)

    def __getitem__(self, name: str) -> int:
        return self._values[name]

    def put(self, name: str, value: int):
        """Set a register, without asking whether that is allowed."""
        self._values[name], self.written = value, True
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

    # ---- the rules ----

    def check(self, row: Register, value: int):
        """Refuse a write that the row, the mode or the state of the servo forbids."""
        if row.name in _GOALS and self["bus_watchdog"] == reg.WATCHDOG_TRIPPED:
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

    def set(self, name: str, value: int, planned: bool) -> list[Effect]:
        """Set a register, with what that sets off in the table; what it sets off in the servo comes back.

        `planned` says whether the servo has a trajectory.
        """
        before = self[name]
        self.put(name, value)
        if name == "torque_enable":
            return self._torque(planned)
        if name == "operating_mode" and value != before:
            return self._new_mode()
        if name in _GOALS:
            return self._new_goal(name, planned)
        return []

    def _torque(self, planned: bool) -> list[Effect]:
        if not self["torque_enable"]:
            return [Effect.RELEASE]
        if planned:
            return []
        # Whether real firmware sets the goal to the present position here is not known. This one does not.
        return [Effect.WRAP, Effect.PLAN] if self["operating_mode"] == reg.MODES["position"] else [Effect.PLAN]

    def _new_mode(self) -> list[Effect]:
        for name in (*reg.GAINS, "profile_velocity", "profile_acceleration"):
            self.put(name, REGISTERS[name].default)
        self.put("goal_pwm", self["pwm_limit"])
        self.put("goal_current", self["current_limit"])
        self.put("goal_velocity", 0)
        return [Effect.WRAP] if self["operating_mode"] == reg.MODES["position"] else []

    def _new_goal(self, name: str, planned: bool) -> list[Effect]:
        if self["torque_enable"]:  # the goals of other modes lay nothing anew
            goal = "goal_velocity" if self["operating_mode"] == reg.MODES["velocity"] else "goal_position"
            return [Effect.PLAN] if name == goal else []
        if self["drive_mode"] & reg.DRIVE_TORQUE_BY_GOAL and not self["hardware_error"] & self["shutdown"]:
            self.put("torque_enable", 1)
            return self._torque(planned)
        return []
