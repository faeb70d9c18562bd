"""What an arm must be and how it must be set, one row a condition. `Robot` refuses by these rows, sets back what other
programs left behind, and warns; the doctor tells the same rows. Reads only.
"""

import math
import sys
from collections.abc import Callable, Iterable
from typing import NamedTuple

from ..arm import (
    ARM_IDS,
    FEWEST_VOLTS,
    GRIPPER_ID,
    HOLDING_TORQUE,
    JOINT_IDS,
    LIMITS,
    MODEL,
    MOST_DEGREES,
    OLDEST_FIRMWARE,
    SOFT_MARGIN,
    STALL_TORQUE,
    WARN_DEGREES,
    WARN_VOLTS,
)
from ..errors import BusError
from .dynamixel import registers as reg
from .dynamixel import units
from .dynamixel.bus import Bus, again

#: The gains that hold a position, in blocks of neighbours.
GAINS = (
    reg.block("position_d_gain", "position_i_gain", "position_p_gain"),
    reg.block("feedforward_2nd_gain", "feedforward_1st_gain"),
)
#: The registers that the rows judge, in blocks of neighbours: one transaction each, whatever the number of servos.
BLOCKS = (
    reg.block("return_delay_time", "drive_mode", "operating_mode", "secondary_id"),
    reg.block("homing_offset"),
    reg.block("temperature_limit", "max_voltage_limit", "min_voltage_limit", "pwm_limit", "current_limit"),
    reg.block("velocity_limit", "max_position_limit", "min_position_limit"),
    reg.block("startup_configuration"),
    reg.block("shutdown", "torque_enable"),
    reg.block("hardware_error"),
    *GAINS,
    reg.block("bus_watchdog"),
    reg.block("goal_pwm", "goal_current", "goal_velocity", "profile_acceleration", "profile_velocity", "goal_position"),
    reg.block("present_position", "velocity_trajectory", "position_trajectory", "present_voltage",
              "present_temperature"),
)  # fmt: skip
HEALTH = reg.block("present_voltage", "present_temperature")

_FULL_PWM = reg.REGISTERS["goal_pwm"].high
#: With less PWM than this the stretched arm cannot be held up.
WEAK_PWM = math.ceil(1.1 * HOLDING_TORQUE / STALL_TORQUE * _FULL_PWM)
#: The errors that must switch a servo off: overheated, shock, overload.
PROTECTION = reg.REGISTERS["shutdown"].default
#: The temperature limit from the factory: the servo gives up there.
_HOTTEST = reg.REGISTERS["temperature_limit"].default
_GAINS = tuple(row for block in GAINS for row in block.registers)


class Finding(NamedTuple):
    """One thing found: the `key` of its row, the texts, and the id if it is one servo's.

    `level` is "fault", "warning" or "note"; what is `mended` is set back when the motors are switched on.
    """

    key: str
    level: str
    symptom: str
    cause: str
    remedy: str
    servo: int | None = None
    mended: bool = False

    @property
    def forbids(self) -> bool:
        """True if the arm must not be driven like this, and switching on does not mend it."""
        return self.level == "fault" and not self.mended

    @property
    def warns(self) -> bool:
        """True if it should be said when the arm is opened."""
        return self.level == "warning" and not self.mended


class Condition(NamedTuple):
    """One row. `found(servo, at)` is true where the condition holds, or gives further facts for the texts.

    `at` maps names to raw values and must have those that `needs` names; they are facts for the texts, as are `value`,
    that of the first one in its unit, and `degrees`, the same in degrees. A "fault" forbids driving, a "warning" is
    said, a "note" is for the doctor; what `mend` maps to values is written back when the motors are switched on, and
    forbids nothing. `remedy` maps systems to texts where they differ.
    """

    key: str
    level: str
    needs: tuple[str, ...]
    found: Callable[[int, dict[str, int]], dict | bool] | None
    symptom: str
    cause: str
    remedy: str | dict[str, str]
    mend: dict[str, int] | None = None

    def finding(self, servo: int | None, facts: dict, system: str = sys.platform) -> Finding:
        """This row with its blanks filled in; on `system` ("linux", "darwin", "win32") if remedies differ."""
        remedy = self.remedy if isinstance(self.remedy, str) else self.remedy.get(system, self.remedy["linux"])
        symptom, cause, remedy = (text.format(servo=servo, **facts) for text in (self.symptom, self.cause, remedy))
        return Finding(self.key, self.level, symptom, cause, remedy, servo, self.mend is not None)


def judge(servo: int, at: dict[str, int]) -> list[Finding]:
    """Every row that holds for `servo`, of those that the registers in `at` can tell."""
    findings = []
    for row in CONDITIONS:
        if all(name in at for name in row.needs) and (found := row.found(servo, at)):
            value = reg.REGISTERS[row.needs[0]].unit.value(at[row.needs[0]])
            facts = {**at, "value": value, "degrees": math.degrees(value), **(found if isinstance(found, dict) else {})}
            findings.append(row.finding(servo, facts))
    return findings


def sentences(found: Iterable[Finding]) -> list[str]:
    """What is the case and what to do about it: servos with the same remedy in one."""
    symptoms: dict[str, list[str]] = {}
    for one in found:
        symptoms.setdefault(one.remedy, []).append(one.symptom)
    return [f"{'; '.join(each)}. {remedy}" for remedy, each in symptoms.items()]


def registers(bus: Bus, servos, blocks=BLOCKS) -> dict[int, dict[str, int]]:
    """All that the rows judge, of `servos`: id -> name -> raw value. A lost answer is asked for again."""
    at: dict[int, dict[str, int]] = {servo: {} for servo in servos}
    for what in blocks:
        for servo, values in again(bus.read_block, servos, what).items():
            at[servo] |= {row.name: value for row, value in zip(what.registers, values, strict=True)}
    return at


def settings(bus: Bus, servos) -> tuple[dict[int, dict[str, int]], list[BusError]]:
    """The `registers` of as many of `servos` as can be read, and why the others cannot."""
    try:
        return registers(bus, servos) if servos else {}, []
    except BusError:  # one of them does not answer: which?
        at, errors = {}, []
        for servo in servos:
            try:
                at |= registers(bus, [servo])
            except BusError as error:
                errors.append(error)
        return at, errors


# ---- what the rows ask where that is more than one line: each gives facts for its text, or none ----


def hardware_words(bits: int) -> dict[str, str]:
    """The bits of register 70 in words, and what brings them about."""
    reasons = "; ".join(why for bit, (_, why) in reg.HARDWARE_ERRORS.items() if bits & bit)
    words = ", ".join(reg.hardware_errors(bits)) or f"unknown error {bits:#04x}"
    return {"words": words, "reason": reasons or "the servo's manual does not say"}


def _without_profile(torque: int) -> Callable:
    def found(servo, at):
        reasons = [] if at["drive_mode"] & reg.DRIVE_TIME_BASED else ["its drive mode is not time-based"]
        reasons += [] if at["profile_velocity"] else ["its profile velocity is 0"]
        return {"why": " and ".join(reasons)} if reasons and at["torque_enable"] == torque else {}

    return found


def _narrow(servo, at):
    if servo not in JOINT_IDS:
        return {}
    low, high = (units.POSITION.value(at[f"{end}_position_limit"]) for end in ("min", "max"))
    least, most = LIMITS[JOINT_IDS.index(servo)]
    narrow = low > least + SOFT_MARGIN or high < most - SOFT_MARGIN
    return {"low": math.degrees(low), "high": math.degrees(high)} if narrow else {}


def _gains(servo, at):
    wrong = [f"{row.name} {at[row.name]} (right: {row.default})" for row in _GAINS if at[row.name] != row.default]
    return {"what": ", ".join(wrong)} if wrong else {}


_SUPPLY = "Use the arm's own 12 V, 5 A supply, and look for a half-open switch or plug."
_EEPROM = (
    "It is in the EEPROM. Support the arm; `from omx.hardware.dynamixel.bus import Bus`, `bus = Bus(PORT)`, "
    "`bus.write({servo}, 'torque_enable', 0)`, "
)
_SET_BACK = "`robot.write_motor_state(True)` sets it back where the arm stands."

CONDITIONS = (
    # ---- what they are ----
    Condition("wrong_model", "fault", ("model_number",),
              lambda servo, at: at["model_number"] != MODEL,
              f"servo {{servo}} is model {{model_number}}, not {MODEL} (XM430-W350)",
              "another arm, or another servo was built in",
              "This book drives the OpenMANIPULATOR-X only; XL430 and XL330 servos belong to its newer relatives."),
    Condition("old_firmware", "fault", ("firmware_version",),
              lambda servo, at: at["firmware_version"] < OLDEST_FIRMWARE,
              f"servo {{servo}} has firmware {{firmware_version}}; {OLDEST_FIRMWARE} is the oldest that will do",
              f"moves of a given time came with firmware {OLDEST_FIRMWARE}",
              "Update it with DYNAMIXEL Wizard (Windows, macOS, Linux), one servo at a time."),
    # ---- how they are ----
    Condition("hardware_error", "fault", ("hardware_error",),
              lambda servo, at: at["hardware_error"] and hardware_words(at["hardware_error"]),
              "servo {servo} reports: {words}", "{reason}",
              "Support the arm, remove the cause, then `robot.recover()`: only a reboot clears it."),
    Condition("low_voltage", "fault", ("present_voltage",),
              lambda servo, at: at["present_voltage"] < 10 * FEWEST_VOLTS,
              f"servo {{servo}} has {{value:.1f}} V; {FEWEST_VOLTS:.0f} V are the least", "no or the wrong supply",
              _SUPPLY),
    Condition("weak_voltage", "warning", ("present_voltage",),
              lambda servo, at: 10 * FEWEST_VOLTS <= at["present_voltage"] < 10 * WARN_VOLTS,
              "servo {servo} has only {value:.1f} V", "a weak supply or a long cable", _SUPPLY),
    Condition("hot", "fault", ("present_temperature",),
              lambda servo, at: at["present_temperature"] >= MOST_DEGREES,
              "servo {servo} is at {value:.0f} degrees C", "it holds a load for long, or something blocks it",
              "Park the arm, motors off, and let it cool below 50."),
    Condition("warm", "warning", ("present_temperature",),
              lambda servo, at: WARN_DEGREES <= at["present_temperature"] < MOST_DEGREES,
              "servo {servo} is at {value:.0f} degrees C", "it holds a load for long",
              "Park the arm between two runs."),
    # ---- how they are set, for good ----
    Condition("homing_offset", "fault", ("homing_offset",),
              lambda servo, at: servo in JOINT_IDS and at["homing_offset"] and {"joint": JOINT_IDS.index(servo) + 1},
              "joint {joint} reads {degrees:.1f} deg more than it should: servo {servo} has a homing offset of "
              "{homing_offset} ticks",
              "another program's calibration wrote it into the EEPROM of servo {servo}",
              _EEPROM + "`bus.write({servo}, 'homing_offset', 0)`."),
    Condition("gripper_offset", "warning", ("homing_offset",),
              lambda servo, at: servo == GRIPPER_ID and at["homing_offset"],
              "the gripper, servo {servo}, has a homing offset of {homing_offset} ticks: it opens and closes elsewhere",
              "another program's calibration wrote it", _EEPROM + "`bus.write({servo}, 'homing_offset', 0)`."),
    Condition("narrow_limits", "fault", ("min_position_limit", "max_position_limit"), _narrow,
              "servo {servo} refuses goals outside {low:.0f} .. {high:.0f} deg (data limit error)",
              "its position limits, registers 48 and 52, were changed",
              _EEPROM + "`bus.write({servo}, 'max_position_limit', 4095)`, "
              "`bus.write({servo}, 'min_position_limit', 0)`."),
    Condition("low_pwm_limit", "fault", ("pwm_limit",),
              lambda servo, at: servo in JOINT_IDS and at["pwm_limit"] < WEAK_PWM,
              "servo {servo} has a PWM limit of {value:.0f} %: it cannot hold the arm up",
              "another program changed register 36", _EEPROM + "`bus.write({servo}, 'pwm_limit', 885)`."),
    Condition("no_shutdown", "fault", ("shutdown",),
              lambda servo, at: at["shutdown"] & PROTECTION != PROTECTION,
              "servo {servo} does not switch itself off when it is overloaded or too hot (shutdown mask {shutdown})",
              "another program changed register 63", _EEPROM + f"`bus.write({{servo}}, 'shutdown', {PROTECTION})`."),
    Condition("high_heat_limit", "fault", ("temperature_limit",),
              lambda servo, at: at["temperature_limit"] > _HOTTEST,
              f"servo {{servo}} does not switch itself off before {{value:.0f}} degrees C; {_HOTTEST} is right",
              "another program changed register 31",
              _EEPROM + f"`bus.write({{servo}}, 'temperature_limit', {_HOTTEST})`."),
    Condition("low_heat_limit", "warning", ("temperature_limit",),
              lambda servo, at: at["temperature_limit"] <= MOST_DEGREES,
              "servo {servo} switches itself off at {value:.0f} degrees C already: then the arm falls",
              "another program changed register 31",
              _EEPROM + f"`bus.write({{servo}}, 'temperature_limit', {_HOTTEST})`."),
    Condition("secondary_id", "fault", ("secondary_id",),
              lambda servo, at: at["secondary_id"] in set(ARM_IDS) - {servo},
              "servo {servo} obeys what is meant for servo {secondary_id}, too",
              "its secondary id, register 12, is {secondary_id}",
              _EEPROM + "`bus.write({servo}, 'secondary_id', 255)`."),
    Condition("starts_by_itself", "warning", ("startup_configuration",),
              lambda servo, at: at["startup_configuration"] & 1,
              "servo {servo} switches its motor on by itself when the power comes on",
              "its startup configuration, register 60, says so",
              _EEPROM + "`bus.write({servo}, 'startup_configuration', 0)`."),
    Condition("velocity_limit", "note", ("velocity_limit",),
              lambda servo, at: servo in JOINT_IDS and at["velocity_limit"] < 44,
              "servo {servo} has a velocity limit of {degrees:.0f} deg/s", "another program changed register 44",
              "Nothing with this book, whose moves take a time; programs with velocity profiles crawl."),
    Condition("slow_return", "note", ("return_delay_time",),
              lambda servo, at: at["return_delay_time"] > 10 and {"us": 2 * at["return_delay_time"]},
              "servo {servo} waits {us} us before it answers",
              "so it comes from the factory (return delay, register 9)",
              "Nothing need be done; 0 saves half a millisecond a servo: write it with the torque off."),
    # ---- how they are set, until they are switched on ----
    Condition("torque_on", "note", ("torque_enable",), lambda servo, at: at["torque_enable"],
              "servo {servo} has its motor on",
              "a program left it on, and the arm holds. The EEPROM is locked meanwhile (access error)",
              "`Robot(...).park()` folds the arm and switches the motors off."),
    Condition("full_speed", "fault", ("drive_mode", "profile_velocity", "torque_enable"), _without_profile(1),
              "servo {servo} moves at full speed on its next goal: {why}, and its motor is on",
              "a program left the motor on without a motion profile, or the servo restarted",
              "Do not send goals. `robot.write_motor_state(True)` sets it up where it stands.", {}),
    Condition("no_profile", "note", ("drive_mode", "profile_velocity", "torque_enable"), _without_profile(0),
              "servo {servo} would move at full speed: {why}", "so it comes from the factory and from every restart",
              "Nothing with this book: `write_motor_state(True)` sets it. Other programs must do so themselves.", {}),
    Condition("gripper_inverted", "note", ("drive_mode",),
              lambda servo, at: servo == GRIPPER_ID and at["drive_mode"] & reg.DRIVE_REVERSE,
              "servo 15 counts backwards (drive mode {drive_mode})", "ROS 2 leaves it so",
              "Nothing with this book, which reads it; a course program would open the gripper where it should close."),
    Condition("joint_reversed", "warning", ("drive_mode",),
              lambda servo, at: servo in JOINT_IDS and at["drive_mode"] & reg.DRIVE_REVERSE,
              "servo {servo} counts backwards (drive mode {drive_mode})",
              "another program set the reverse bit in its EEPROM",
              "`write_motor_state(True)` puts it right; support the arm, for its idea of where it is changes."),
    Condition("weak_pwm", "fault", ("goal_pwm",),
              lambda servo, at: servo in JOINT_IDS and at["goal_pwm"] < WEAK_PWM,
              "servo {servo} pushes with at most {value:.0f} % (goal PWM): it cannot hold the arm up",
              "another program changed register 100", _SET_BACK, {}),
    Condition("gains", "warning", tuple(row.name for row in _GAINS), _gains,
              "servo {servo} has other gains than from the factory: {what}", "another program changed them", _SET_BACK,
              {row.name: row.default for row in _GAINS}),
    Condition("watchdog", "warning", ("bus_watchdog",),
              lambda servo, at: at["bus_watchdog"] == reg.WATCHDOG_TRIPPED,
              "the bus watchdog of servo {servo} has tripped: it refuses goals",
              "the program that streamed to it broke off",
              "`robot.write_motor_state(True)` clears it; or `bus.write({servo}, 'bus_watchdog', 0)`.",
              {"bus_watchdog": 0}),
)  # fmt: skip

#: What switching the motors on writes into every servo, besides modes, profile and goal.
MENDS = {name: value for row in CONDITIONS for name, value in (row.mend or {}).items()}
