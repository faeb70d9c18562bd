"""`python run.py doctor [PORT]`, or `python -m omx.hardware.doctor`: exits with 1 if there is something to mend."""

import argparse
import sys

from ...errors import OmxError
from ..robot.calibration import load_calibration
from ..simulator import SteppedClock, VirtualArm, VirtualPort
from .examination import doctor
from .report import Report


def arguments() -> argparse.ArgumentParser:
    """The command line."""
    parser = argparse.ArgumentParser(
        prog="python run.py doctor",
        description="Finds out why the arm does not answer, or not do what it should. Reads only; nothing moves.",
    )
    parser.add_argument("port", nargs="?", help="/dev/ttyUSB0, COM5 ...; every USB serial port if left out")
    parser.add_argument("--virtual", action="store_true", help="examine a virtual arm")
    parser.add_argument("--fault", action="append", default=[], help='with --virtual: "KIND servo=13 value=1"')
    parser.add_argument("--pose", type=float, nargs=4, metavar="DEG", help="where you say the joints are")
    parser.add_argument("--calibration", metavar="FILE", help="the arm's own calibration, shown with the rest")
    return parser


def main(argv=None) -> int:
    """Examine, print, and say by the exit status whether all is well."""
    given = arguments().parse_args(argv)
    try:
        port = _virtual(given.fault) if given.virtual else given.port
        known = load_calibration(given.calibration) if given.calibration else None
    except OmxError as error:
        print(error, file=sys.stderr)
        return 2
    report: Report = doctor(port, given.pose, known)
    print(report)
    return 0 if report.healthy else 1


def _virtual(faults: list[str]) -> VirtualPort:
    arm = VirtualArm()
    for text in faults:
        arm.faults.inject_text(text)
    return VirtualPort(arm, clock=SteppedClock())


if __name__ == "__main__":
    sys.exit(main())
