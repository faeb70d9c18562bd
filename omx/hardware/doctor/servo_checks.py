"""The servos one by one: what they are, how they are, and how they are set. Reads only."""

import math

from ...arm import JOINT_IDS, STOPS
from ..dynamixel import units
from ..dynamixel.bus import Bus, Ping
from ..fault_table import judge, settings
from ..safety import Guard
from .report import Report, explain

#: What a joint may read beyond its stops, and parts overlap, before a pose is called impossible (rad, mm).
SLACK, OVERLAP = math.radians(6.0), 30.0


def what_they_are(report: Report, pings: dict[int, Ping]) -> list[int]:
    """Model and firmware; the servos of the right model go back."""
    right = []
    for servo, ping in pings.items():
        found = judge(servo, {"model_number": ping.model, "firmware_version": ping.firmware})
        report.findings += found
        right += [] if any(one.key == "wrong_model" for one in found) else [servo]
    return right


def how_they_are(bus: Bus, report: Report, servos, pose_deg=None) -> None:
    """Errors, voltage, temperature, settings, and whether the angles can be true (`pose_deg`: what you say it is)."""
    seen, errors = settings(bus, servos)
    for error in errors:
        report.findings += explain(error)
    for servo, at in seen.items():
        report.findings += judge(servo, at)
    on = [servo for servo in seen if seen[servo]["torque_enable"]]
    if on:
        report.add("torque_on", ids=", ".join(map(str, on)))
    slow = [servo for servo in seen if seen[servo]["return_delay_time"] > 10]
    if slow:
        us = 2 * max(seen[servo]["return_delay_time"] for servo in slow)
        report.add("slow_return", ids=", ".join(map(str, slow)), us=us)
    if all(servo in seen for servo in JOINT_IDS):
        _pose(report, [units.POSITION.value(seen[servo]["present_position"]) for servo in JOINT_IDS], pose_deg)


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
