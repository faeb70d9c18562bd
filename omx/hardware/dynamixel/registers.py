"""The control table of the XM430-W350 as rows of data, from the maker's e-manual.

A servo is a table of numbers: reading and writing its addresses is all there is. The bus and the virtual
servo use the same rows. Values here are raw integers; `units.py` turns them into rad, mA, V and s.
"""

import struct
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cached_property
from itertools import pairwise
from operator import index
from typing import NamedTuple

from ...errors import BadInput
from . import units

#: First address of the RAM area. Below it is EEPROM: it survives power-off and is locked while torque is on.
RAM = 64


class Register(NamedTuple):
    """One row: where a value lives and what it may be.

    `default`, `low` and `high` are raw integers in `unit`. (In a time-based profile the two profile registers hold
    `MILLISECONDS`.)
    """

    address: int
    size: int
    name: str
    access: str
    default: int
    low: int
    high: int
    unit: units.Unit = units.PLAIN
    note: str = ""

    @property
    def writable(self) -> bool:
        return self.access == "RW"

    @property
    def signed(self) -> bool:
        return self.low < 0

    @property
    def eeprom(self) -> bool:
        return self.address < RAM

    @property
    def end(self) -> int:
        """The first address after this register."""
        return self.address + self.size

    def decode(self, data: bytes) -> int:
        """The integer in `data` (little-endian, two's complement where negative values exist)."""
        return int.from_bytes(data, "little", signed=self.signed)

    def encode(self, value: int) -> bytes:
        """`value` as bytes for the wire; `BadInput` if it is no integer or outside `low` .. `high`."""
        try:
            number = index(value)
        except TypeError:
            raise BadInput(f"{self.name} takes a whole raw number; got {value!r}. See units.py.") from None
        if not self.low <= number <= self.high:
            nearest = min(max(number, self.low), self.high)
            span = f"{self.low} .. {self.high}"
            raise BadInput(f"{self.name} takes {span}; got {number}. The nearest legal value is {nearest}.")
        return number.to_bytes(self.size, "little", signed=self.signed)


_TURNS = 1_048_575  # 256 turns less one tick, either way
_INT16, _INT32 = 2**15 - 1, 2**31 - 1

#   address, size, name, access, default, low, high, unit, note
_ROWS = [
    (0, 2, "model_number", "R", 1020, 0, 65535, units.PLAIN, "1020 = XM430-W350"),
    (2, 4, "model_information", "R", 0, 0, 2**32 - 1),
    (6, 1, "firmware_version", "R", 45, 0, 255, units.PLAIN, "38 watchdog, 42 time-based profile, 45 fast reads"),
    (7, 1, "id", "RW", 1, 0, 252),
    (8, 1, "baud_rate", "RW", 1, 0, 7, units.PLAIN, "0 9600, 1 57600, 2 115200, 3 1M, 4 2M, 5 3M, 6 4M, 7 4.5M"),
    (9, 1, "return_delay_time", "RW", 250, 0, 254, units.DELAY),
    (10, 1, "drive_mode", "RW", 0, 0, 13, units.PLAIN, "1 reverse, 4 time-based profile, 8 torque on by goal"),
    (11, 1, "operating_mode", "RW", 3, 0, 16, units.PLAIN, "changing it zeroes the profile and resets the gains"),
    (12, 1, "secondary_id", "RW", 255, 0, 255, units.PLAIN, "a second id to listen to; above 252 = none"),
    (13, 1, "protocol_type", "RW", 2, 1, 2),
    (20, 4, "homing_offset", "RW", 0, -1_044_479, 1_044_479, units.ANGLE, "added to the position"),
    (24, 4, "moving_threshold", "RW", 10, 0, 1023, units.VELOCITY),
    (31, 1, "temperature_limit", "RW", 80, 0, 100, units.TEMPERATURE),
    (32, 2, "max_voltage_limit", "RW", 160, 95, 160, units.VOLTAGE),
    (34, 2, "min_voltage_limit", "RW", 95, 95, 160, units.VOLTAGE),
    (36, 2, "pwm_limit", "RW", 885, 0, 885, units.PWM),
    (38, 2, "current_limit", "RW", 1193, 0, 1193, units.CURRENT),
    (44, 4, "velocity_limit", "RW", 200, 0, 1023, units.VELOCITY),
    (48, 4, "max_position_limit", "RW", 4095, 0, 4095, units.POSITION, "in position mode only"),
    (52, 4, "min_position_limit", "RW", 0, 0, 4095, units.POSITION, "in position mode only"),
    (60, 1, "startup_configuration", "RW", 0, 0, 3, units.PLAIN, "1 torque on, 2 restore the RAM at power-on"),
    (63, 1, "shutdown", "RW", 52, 0, 63, units.PLAIN, "which hardware errors switch the torque off"),
    (64, 1, "torque_enable", "RW", 0, 0, 1, units.PLAIN, "refused after a shutdown, until a reboot"),
    (65, 1, "led", "RW", 0, 0, 1),
    (68, 1, "status_return_level", "RW", 2, 0, 2, units.PLAIN, "0 ping, 1 and reads, 2 everything is answered"),
    (69, 1, "registered_instruction", "R", 0, 0, 1),
    (70, 1, "hardware_error", "R", 0, 0, 255, units.PLAIN, "cleared by a reboot only"),
    (76, 2, "velocity_i_gain", "RW", 1920, 0, 16383),
    (78, 2, "velocity_p_gain", "RW", 100, 0, 16383),
    (80, 2, "position_d_gain", "RW", 0, 0, 16383),
    (82, 2, "position_i_gain", "RW", 0, 0, 16383),
    (84, 2, "position_p_gain", "RW", 800, 0, 16383),
    (88, 2, "feedforward_2nd_gain", "RW", 0, 0, 16383),
    (90, 2, "feedforward_1st_gain", "RW", 0, 0, 16383),
    (98, 1, "bus_watchdog", "RW", 0, 0, 127, units.WATCHDOG, "reads 255 after it has tripped; write 0 to clear"),
    (100, 2, "goal_pwm", "RW", 885, -885, 885, units.PWM),
    (102, 2, "goal_current", "RW", 1193, -1193, 1193, units.CURRENT),
    (104, 4, "goal_velocity", "RW", 0, -1023, 1023, units.VELOCITY),
    (108, 4, "profile_acceleration", "RW", 0, 0, 32767, units.ACCELERATION, "ms in time mode; 0 = infinite"),
    (112, 4, "profile_velocity", "RW", 0, 0, 32767, units.VELOCITY, "total ms in time mode; 0 = maximum speed"),
    (116, 4, "goal_position", "RW", 2048, -_TURNS, _TURNS, units.POSITION),
    (120, 2, "realtime_tick", "R", 0, 0, 32767, units.MILLISECONDS),
    (122, 1, "moving", "R", 0, 0, 1),
    (123, 1, "moving_status", "R", 0, 0, 255, units.PLAIN, "1 arrived, 2 profile running, 8 following error"),
    (124, 2, "present_pwm", "R", 0, -_INT16, _INT16, units.PWM),
    (126, 2, "present_current", "R", 0, -_INT16, _INT16, units.CURRENT),
    (128, 4, "present_velocity", "R", 0, -_INT32, _INT32, units.VELOCITY),
    (132, 4, "present_position", "R", 2048, -_INT32, _INT32, units.POSITION),
    (136, 4, "velocity_trajectory", "R", 0, -_INT32, _INT32, units.VELOCITY, "the servo's own set-point"),
    (140, 4, "position_trajectory", "R", 2048, -_INT32, _INT32, units.POSITION, "the servo's own set-point"),
    (144, 2, "present_voltage", "R", 120, 0, 65535, units.VOLTAGE),
    (146, 1, "present_temperature", "R", 25, 0, 255, units.TEMPERATURE),
    (147, 1, "backup_ready", "R", 0, 0, 1),
]
# Each indirect address points at one byte; indirect data n *is* the byte that indirect address n points at.
_INDIRECT = [
    (first_address + 2 * i, 2, f"indirect_address_{n + i}", "RW", first_data + i, RAM, 661)
    for first_address, first_data, n in ((168, 224, 1), (578, 634, 29))
    for i in range(28)
] + [
    (first_data + i, 1, f"indirect_data_{n + i}", "RW", 0, 0, 255)
    for first_data, n in ((224, 1), (634, 29))
    for i in range(28)
]

#: Every register by name, in the order of its address.
REGISTERS = {row.name: row for row in sorted(Register(*row) for row in _ROWS + _INDIRECT)}
#: One past the last address.
TABLE_SIZE = max(row.end for row in REGISTERS.values())
_AT = {address: row for row in REGISTERS.values() for address in range(row.address, row.end)}

#: Baud rate by the code in register 8.
BAUDS = (9600, 57600, 115200, 1_000_000, 2_000_000, 3_000_000, 4_000_000, 4_500_000)
#: What operating mode (register 11) each number is.
MODES = {"current": 0, "velocity": 1, "position": 3, "extended": 4, "current_position": 5, "pwm": 16}
DRIVE_REVERSE, DRIVE_TIME_BASED, DRIVE_TORQUE_BY_GOAL = 1, 4, 8
WATCHDOG_TRIPPED = 255
#: Bits of startup_configuration (register 60).
STARTUP_TORQUE_ON, STARTUP_RESTORE_RAM = 1, 2
#: Bits of hardware_error (register 70) and of the shutdown mask (register 63).
VOLTAGE, OVERHEATED, ENCODER, SHOCK, OVERLOAD = 0x01, 0x04, 0x08, 0x10, 0x20
#: What each of them is called, and what brings it about.
HARDWARE_ERRORS = {
    VOLTAGE: ("input voltage out of range",
              "its voltage was outside 9.5 .. 16 V: a weak supply, or all joints pushing at once"),
    OVERHEATED: ("overheated", "it got hotter than its limit, 80 degrees C"),
    ENCODER: ("encoder fault", "its encoder cannot be read: a knock, or a broken servo"),
    SHOCK: ("electrical shock or too little power", "an electrical shock, or too little power for its motor"),
    OVERLOAD: ("overload",
               "it pushed hard for longer than it can: something blocks the joint, or the load is above 500 g"),
}  # fmt: skip
#: The control loops' gains: a backup keeps them, a new mode resets them.
GAINS = (
    "velocity_i_gain", "velocity_p_gain", "position_d_gain", "position_i_gain", "position_p_gain",
    "feedforward_2nd_gain", "feedforward_1st_gain",
)  # fmt: skip


def register(name: str) -> Register:
    """The row called `name`; `BadInput` with the closest names if there is none."""
    if isinstance(name, Register):
        return name
    try:
        return REGISTERS[name]
    except (KeyError, TypeError):
        close = get_close_matches(str(name), REGISTERS, n=3) or ["present_position", "goal_position"]
        raise BadInput(f"The servo has no register {name!r}. Did you mean {', '.join(close)}?") from None


def at(address: int) -> Register | None:
    """The register that holds the byte at `address`, or None in a gap of the table."""
    return _AT.get(address)


def within(address: int, length: int) -> list[Register]:
    """The registers that lie whole inside `length` bytes from `address`."""
    rows = dict.fromkeys(row for a in range(address, address + length) if (row := _AT.get(a)))
    return [row for row in rows if row.address >= address and row.end <= address + length]


@dataclass(frozen=True)
class Block:
    """Neighbouring registers read in one piece."""

    registers: tuple[Register, ...]

    @property
    def address(self) -> int:
        return self.registers[0].address

    @property
    def size(self) -> int:
        return self.registers[-1].end - self.address

    @property
    def names(self) -> str:
        """The register's name, or the first and the last."""
        first, last = self.registers[0].name, self.registers[-1].name
        return first if first == last else f"{first} .. {last}"

    def decode(self, data: bytes) -> tuple[int, ...]:
        """One integer a register, from the `size` bytes of the block."""
        return struct.unpack(self._layout, data)

    @cached_property
    def _layout(self) -> str:
        letters = ["_bh_i"[row.size] if row.signed else "_BH_I"[row.size] for row in self.registers]
        return "<" + "".join(letters)


def block(*names: str) -> Block:
    """The block of these registers, in the order of their addresses; `BadInput` if there is a gap."""
    rows = tuple(sorted(register(name) for name in names))
    if not rows or any(a.end != b.address for a, b in pairwise(rows)):
        raise BadInput(f"A block is neighbouring registers without a gap; got {', '.join(names) or 'none'}.")
    return Block(rows)


#: What one look at a servo is: bytes 126 .. 135, present current, velocity and position.
PRESENT = block("present_current", "present_velocity", "present_position")


def hardware_errors(bits: int) -> list[str]:
    """In words what the bits of register 70 say."""
    return [name for bit, (name, _) in HARDWARE_ERRORS.items() if bits & bit]
