"""The examination: software, port, wire, servos, in this order, as far as one can get."""

import math

from ...arm import JOINT_IDS, STOPS
from ...errors import OmxError, PortError
from ..dynamixel import units
from ..dynamixel.bus import Bus, Ping
from ..fault_table import judge, settings
from ..robot.discovery import find_ports
from ..safety import Guard
from .bus_checks import how_well, who_answers
from .report import Report, explain
from .software_checks import examine_port_name, examine_software, holder

#: What a joint may read beyond its stops, and parts overlap, before a pose is called impossible (rad, mm).
SLACK, OVERLAP = math.radians(6.0), 30.0


def doctor(bus_or_port=None, pose_deg=None, calibration=None) -> Report:
    """Examine the arm on `bus_or_port`, or on the first port that has one; prints well and is data.

    `bus_or_port` is a port's name, a `Port`, a `Bus`, or a `Robot`. `pose_deg`: four angles (deg) that you say the
    arm is at, to find a horn that was screwed on wrong. `calibration`: what to show
    of the arm's own; a `Robot` brings its. Reads only: no servo is written to, nothing moves.
    """
    report = Report()
    examine_software(report)
    if known := calibration or getattr(bus_or_port, "calibration", None):
        report.facts.append(f"calibrated by {known}")
    given = getattr(bus_or_port, "bus", bus_or_port)
    if given is None:
        _search(report, pose_deg)
    elif isinstance(given, Bus):
        _examine(given, report, pose_deg)
    else:
        _open(given, report, pose_deg)
    return report


def _search(report: Report, pose_deg) -> None:
    """Every port of this computer in turn, until one has servos."""
    ports = find_ports()
    if not ports:
        report.add("no_ports")
    for port in ports:
        alone = Report()
        answered = _open(port, alone, pose_deg)
        if answered:
            report.findings = [f for f in report.findings if f.key.startswith("sdk")]
        report.findings += alone.findings
        report.facts += alone.facts
        if answered:
            return


def _open(port, report: Report, pose_deg) -> bool:
    """Open `port`, examine, close; True if any servo answered."""
    name = port if isinstance(port, str) else port.port_name
    examine_port_name(report, name)
    try:
        bus = Bus(port)
    except PortError as error:
        findings = explain(error)
        if findings[0].key == "port_busy":
            report.add("port_busy", port=name, who=holder(name))
        else:
            report.findings += findings
        return False
    with bus:
        return _examine(bus, report, pose_deg)


def _examine(bus: Bus, report: Report, pose_deg) -> bool:
    report.facts.append(f"{bus.name} opens")
    pings = {}
    try:
        pings = who_answers(bus, report)
        right = _what_they_are(report, {servo: ping for servo, ping in pings.items() if ping.model})
        readable = how_well(bus, report, list(pings))
        _how_they_are(bus, report, [servo for servo in readable if servo in right], pose_deg)
    except OmxError as error:
        report.findings += explain(error)
    return bool(pings)


# ---- the servos one by one ----


def _what_they_are(report: Report, pings: dict[int, Ping]) -> list[int]:
    """Model and firmware; the servos of the right model go back."""
    right = []
    for servo, ping in pings.items():
        found = judge(servo, {"model_number": ping.model, "firmware_version": ping.firmware})
        report.findings += found
        right += [] if any(one.key == "wrong_model" for one in found) else [servo]
    return right


def _how_they_are(bus: Bus, report: Report, servos, pose_deg=None) -> None:
    """Errors, voltage, temperature, settings, and whether the angles can be true (`pose_deg`: what you say it is)."""
    seen, errors = settings(bus, servos)
    for error in errors:
        report.findings += explain(error)
    for servo, at in seen.items():
        report.findings += judge(servo, at)
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
