"""The rules between registers: which writes a servo refuses, and what a write sets off."""

from ..dynamixel import packet as pk
from ..dynamixel import registers as reg
from .control_table import Refusal

_GOALS = ("goal_pwm", "goal_current", "goal_velocity", "goal_position")
_GAINS = (
    "velocity_i_gain", "velocity_p_gain", "position_d_gain", "position_i_gain", "position_p_gain",
    "feedforward_2nd_gain", "feedforward_1st_gain",
)  # fmt: skip


def check(servo, row: reg.Register, value: int):
    """Refuse a write that the row, the mode or the state of the servo forbids."""
    table = servo.table
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
    if row.name == "startup_configuration" and value:
        raise Refusal(pk.DATA_RANGE)  # starting with the torque on is not built into this servo
    if row.name == "bus_watchdog" and table["firmware_version"] < 38:
        raise Refusal(pk.ACCESS)
    low, high = _limits(table, row.name)
    if low is not None and not low <= value <= high:
        raise Refusal(pk.DATA_LIMIT)


def _limits(table, name: str) -> tuple[int | None, int | None]:
    """The limits that other registers set for this one."""
    if name in ("goal_pwm", "goal_current", "goal_velocity"):
        limit = table[name.removeprefix("goal_") + "_limit"]
        return -limit, limit
    if name == "goal_position" and table["operating_mode"] == reg.MODES["position"]:
        return table["min_position_limit"], table["max_position_limit"]
    return None, None


def apply(servo, name: str, before: int, now: float):
    """What writing the register `name`, which held `before`, sets off."""
    table = servo.table
    if name == "torque_enable":
        _torque(servo, now)
    elif name == "operating_mode" and table[name] != before:
        _new_mode(servo)
    elif name in _GOALS:
        _new_goal(servo, now)


def _torque(servo, now: float):
    servo.been_on = servo.been_on or servo.torque_on
    if not servo.torque_on:
        servo.release()
    elif servo.trajectory is None:
        if servo.table["operating_mode"] == reg.MODES["position"]:
            servo.wrap()
        # Whether real firmware sets the goal to the present position here is not known. This one does not.
        servo.plan(now)


def _new_mode(servo):
    table = servo.table
    for name in (*_GAINS, "profile_velocity", "profile_acceleration"):
        table.put(name, reg.REGISTERS[name].default)
    table.put("goal_pwm", table["pwm_limit"])
    table.put("goal_current", table["current_limit"])
    table.put("goal_velocity", 0)
    if table["operating_mode"] == reg.MODES["position"]:
        servo.wrap()


def _new_goal(servo, now: float):
    table = servo.table
    if not servo.torque_on and table["drive_mode"] & reg.DRIVE_TORQUE_BY_GOAL:
        if table["hardware_error"] & table["shutdown"]:
            return
        table.put("torque_enable", 1)
        _torque(servo, now)
    elif servo.torque_on:
        servo.plan(now)
