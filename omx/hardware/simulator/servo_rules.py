"""The rules between registers: which writes a servo refuses, and what a write sets off.

They see the control table only. What a write does to the servo itself comes back as `Effect`s, in order.
"""

from enum import Enum, auto

from ..dynamixel import packet as pk
from ..dynamixel import registers as reg
from .control_table import Refusal, Table

_GOALS = ("goal_pwm", "goal_current", "goal_velocity", "goal_position")
_WATCHDOG_FIRMWARE, STARTUP_FIRMWARE = 38, 45


class Effect(Enum):
    """What a servo does because of a write."""

    RELEASE = auto()  # the torque is off: forget where the set-point was going
    WRAP = auto()  # forget whole turns
    PLAN = auto()  # lay the trajectory to the goal


def check(table: Table, row: reg.Register, value: int):
    """Refuse a write that the row, the mode or the state of the servo forbids."""
    if row.name in _GOALS and table["bus_watchdog"] == reg.WATCHDOG_TRIPPED:
        raise Refusal(pk.DATA_RANGE)
    table.check(row, value)
    if row.name == "torque_enable" and value and table["hardware_error"] & table["shutdown"]:
        raise Refusal(pk.RESULT_FAIL)
    if row.name == "drive_mode" and value & ~(reg.DRIVE_REVERSE | reg.DRIVE_TIME_BASED | reg.DRIVE_TORQUE_BY_GOAL):
        raise Refusal(pk.DATA_RANGE)
    if row.name == "operating_mode" and value not in reg.MODES.values():
        raise Refusal(pk.DATA_RANGE)
    if row.name.startswith("profile") and table["drive_mode"] & reg.DRIVE_TIME_BASED and value > 32737:
        raise Refusal(pk.DATA_RANGE)
    if row.name == "startup_configuration" and table["firmware_version"] < STARTUP_FIRMWARE:
        raise Refusal(pk.ACCESS)
    if row.name == "bus_watchdog" and table["firmware_version"] < _WATCHDOG_FIRMWARE:
        raise Refusal(pk.ACCESS)
    low, high = _limits(table, row.name)
    if low is not None and not low <= value <= high:
        raise Refusal(pk.DATA_LIMIT)


def _limits(table: Table, name: str) -> tuple[int | None, int | None]:
    """The limits that other registers set for this one."""
    if name in ("goal_pwm", "goal_current", "goal_velocity"):
        limit = table[name.removeprefix("goal_") + "_limit"]
        return -limit, limit
    if name == "goal_position" and table["operating_mode"] == reg.MODES["position"]:
        return table["min_position_limit"], table["max_position_limit"]
    return None, None


def apply(table: Table, name: str, before: int, planned: bool) -> list[Effect]:
    """What writing the register `name`, which held `before`, sets off: in the table at once, the rest comes back.

    `planned` says whether the servo has a trajectory.
    """
    if name == "torque_enable":
        return _torque(table, planned)
    if name == "operating_mode" and table[name] != before:
        return _new_mode(table)
    if name in _GOALS:
        return _new_goal(table, name, planned)
    return []


def _torque(table: Table, planned: bool) -> list[Effect]:
    if not table["torque_enable"]:
        return [Effect.RELEASE]
    if planned:
        return []
    # Whether real firmware sets the goal to the present position here is not known. This one does not.
    return [Effect.WRAP, Effect.PLAN] if table["operating_mode"] == reg.MODES["position"] else [Effect.PLAN]


def _new_mode(table: Table) -> list[Effect]:
    for name in (*reg.GAINS, "profile_velocity", "profile_acceleration"):
        table.put(name, reg.REGISTERS[name].default)
    table.put("goal_pwm", table["pwm_limit"])
    table.put("goal_current", table["current_limit"])
    table.put("goal_velocity", 0)
    return [Effect.WRAP] if table["operating_mode"] == reg.MODES["position"] else []


def _new_goal(table: Table, name: str, planned: bool) -> list[Effect]:
    if table["torque_enable"]:  # the goals of other modes lay nothing anew
        goal = "goal_velocity" if table["operating_mode"] == reg.MODES["velocity"] else "goal_position"
        return [Effect.PLAN] if name == goal else []
    if table["drive_mode"] & reg.DRIVE_TORQUE_BY_GOAL and not table["hardware_error"] & table["shutdown"]:
        table.put("torque_enable", 1)
        return _torque(table, planned)
    return []
