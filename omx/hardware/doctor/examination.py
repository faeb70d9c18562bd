"""The examination: software, port, wire, servos, in this order, as far as one can get."""

from ...errors import OmxError, PortError
from ..dynamixel.bus import Bus
from ..robot.discovery import find_ports
from .bus_checks import how_well, who_answers
from .report import Report, explain
from .servo_checks import how_they_are, what_they_are
from .software_checks import examine_port_name, examine_software, holder


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
        right = what_they_are(report, {servo: ping for servo, ping in pings.items() if ping.model})
        readable = how_well(bus, report, list(pings))
        how_they_are(bus, report, [servo for servo in readable if servo in right], pose_deg)
    except OmxError as error:
        report.findings += explain(error)
    return bool(pings)
