"""The servos one by one: what they are, how they are, and how they are set. Reads only."""

import math

from ...arm import (
    FEWEST_VOLTS,
    GRIPPER_ID,
    JOINT_IDS,
    MODEL,
    MOST_DEGREES,
    OLDEST_FIRMWARE,
    STOPS,
    WARN_DEGREES,
    WARN_VOLTS,
)
from ...errors import BusError
from ..dynamixel import registers as reg
from ..dynamixel import units
from ..dynamixel.bus import Bus, Ping
from ..safety import Guard
from .explanations import explain, hardware
from .report import Report

_REGISTERS = (
    "return_delay_time", "drive_mode", "homing_offset", "max_position_limit", "min_position_limit", "torque_enable",
    "hardware_error", "bus_watchdog", "profile_velocity", "present_position", "present_voltage", "present_temperature",
)  # fmt: skip
#: What a joint may read beyond its stops, and parts overlap, before a pose is called impossible (rad, mm).
SLACK, OVERLAP = math.radians(6.0), 30.0


def what_they_are(report: Report, pings: dict[int, Ping]) -> list[int]:
    """Model and firmware; the servos of the right model go back."""
    right = []
    for servo, ping in pings.items():
        if ping.model != MODEL:
            report.add("wrong_model", servo, model=ping.model)
            continue
        right.append(servo)
        if ping.firmware < OLDEST_FIRMWARE:
            report.add("old_firmware", servo, firmware=ping.firmware)
    return right


def how_they_are(bus: Bus, report: Report, servos, pose_deg=None) -> None:
    """Errors, voltage, temperature, settings, and whether the angles can be true (`pose_deg`: what you say it is)."""
    seen = {}
    for servo in servos:
        try:
            seen[servo] = {name: _read(bus, servo, name) for name in _REGISTERS}
        except BusError as error:
            report.findings += explain(error)
            continue
        _health(report, servo, seen[servo])
        _settings(report, servo, seen[servo])
    on = [servo for servo in seen if seen[servo]["torque_enable"]]
    if on:
        report.add("torque_on", ids=", ".join(map(str, on)))
    slow = [servo for servo in seen if seen[servo]["return_delay_time"] > 10]
    if slow:
        us = 2 * max(seen[servo]["return_delay_time"] for servo in slow)
        report.add("slow_return", ids=", ".join(map(str, slow)), us=us)
    if all(servo in seen for servo in JOINT_IDS):
        _pose(report, [units.POSITION.value(seen[servo]["present_position"]) for servo in JOINT_IDS], pose_deg)


def _read(bus: Bus, servo: int, name: str) -> int:
    try:
        return bus.read(servo, name)
    except BusError:  # a lost answer is a finding of its own
        return bus.read(servo, name)


def _health(report: Report, servo: int, at: dict[str, int]) -> None:
    if at["hardware_error"]:
        report.findings.append(hardware(servo, at["hardware_error"]))
    volts, degrees = units.VOLTAGE.value(at["present_voltage"]), at["present_temperature"]
    if volts < WARN_VOLTS:
        report.add("low_voltage" if volts < FEWEST_VOLTS else "weak_voltage", servo, volts=volts)
    if degrees >= WARN_DEGREES:
        report.add("hot" if degrees >= MOST_DEGREES else "warm", servo, degrees=degrees)


def _settings(report: Report, servo: int, at: dict[str, int]) -> None:
    mode, joint = at["drive_mode"], servo != GRIPPER_ID
    reasons = [] if mode & reg.DRIVE_TIME_BASED else ["its drive mode is not time-based"]
    reasons += [] if at["profile_velocity"] else ["its profile velocity is 0"]
    if reasons:
        report.add("full_speed" if at["torque_enable"] else "no_profile", servo, why=" and ".join(reasons))
    if mode & reg.DRIVE_REVERSE:
        report.add("joint_reversed" if joint else "gripper_inverted", servo, mode=mode)
    if offset := at["homing_offset"]:
        degrees = math.degrees(units.ANGLE.value(offset))
        report.add("homing_offset", servo, joint=servo - 10, degrees=degrees, ticks=offset)
    if at["bus_watchdog"] == reg.WATCHDOG_TRIPPED:
        report.add("watchdog", servo)
    if joint:
        _limits(report, servo, at)


def _limits(report: Report, servo: int, at: dict[str, int]) -> None:
    low, high = (units.POSITION.value(at[f"{end}_position_limit"]) for end in ("min", "max"))
    needed_low, needed_high = Guard().soft_limits[servo - JOINT_IDS[0]]
    if low > needed_low or high < needed_high:
        report.add("narrow_limits", servo, low=math.degrees(low), high=math.degrees(high))


def _pose(report: Report, q, pose_deg) -> None:
    if pose_deg is not None:
        for joint, (angle, wanted) in enumerate(zip(q, pose_deg, strict=True), start=1):
            _compare(report, joint, math.degrees(angle), float(wanted))
        return
    why = [f"joint {i} is beyond its stops" for i, (a, (low, high)) in enumerate(zip(q, STOPS, strict=True), start=1)
           if not low - SLACK <= a <= high + SLACK]  # fmt: skip
    gap, first, second = Guard().clearance(q)
    if gap < -OVERLAP:
        why.append(f"the {first} would be {-gap:.0f} mm inside the {second}")
    if why:
        report.add("impossible_pose", angles=", ".join(f"{math.degrees(a):.0f}" for a in q), why="; ".join(why))


def _compare(report: Report, joint: int, found: float, wanted: float) -> None:
    off = found - wanted
    if abs(off) < 8.0:  # nobody places an arm better by hand
        return
    quarter = round(off / 90)
    tight = quarter and abs(off - 90 * quarter) < 15
    why = "its horn was screwed on a quarter turn off" if tight else "its horn, a homing offset, or another pose"
    back = -(90 * quarter if tight else off)
    report.add("joint_off", joint + 10, joint=joint, found=found, wanted=wanted, off=off, back=back, why=why)
