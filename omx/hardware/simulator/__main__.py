"""`python -m omx.hardware.simulator --tcp PORT | --pty`: the virtual arm for other programs, on this computer only."""

import argparse
import contextlib
import sys

from ...arm import HOME
from ...errors import OmxError
from .endpoints import PtyEnd, TcpEnd
from .faults import KINDS
from .server import Orders, parse_fault, serve
from .virtual_arm import VirtualArm


def arguments() -> argparse.ArgumentParser:
    """The command line."""
    parser = argparse.ArgumentParser(
        prog="python -m omx.hardware.simulator",
        description="A virtual OpenMANIPULATOR-X behind a serial port. Prints the port's name, and ends when its "
        "standard input ends (Ctrl-D, or the end of the program that started it).",
        epilog="Faults, at the start with --fault or later as lines of standard input: "
        + "; ".join(f"{name}: {kind.text}" for name, kind in KINDS.items()),
    )
    where = parser.add_mutually_exclusive_group(required=True)
    where.add_argument("--tcp", type=int, metavar="PORT", help="a TCP port on 127.0.0.1; 0 takes a free one")
    where.add_argument("--pty", action="store_true", help="a pseudo-terminal (Linux and macOS)")
    parser.add_argument("--scale", type=float, default=1.0, help="how many times as fast as real time (default 1)")
    parser.add_argument("--fault", action="append", default=[], help='"KIND servo=13 count=2 after=0.5 value=1"')
    parser.add_argument("--q", type=float, nargs=4, default=HOME, metavar="RAD", help="joint angles at the start")
    return parser


def main(argv=None) -> int:
    """Serve until standard input ends."""
    given = arguments().parse_args(argv)
    try:
        arm = VirtualArm(given.q)
        for text in given.fault:
            kind, options = parse_fault(text)
            arm.faults.inject(kind, **options)
        end = _end(given)
    except (OmxError, OSError) as error:
        print(error, file=sys.stderr)
        return 1
    print(end.name, flush=True)
    with contextlib.suppress(KeyboardInterrupt):
        serve(end, arm, Orders(), given.scale)
    end.close()
    return 0


def _end(given):
    if not given.pty:
        return TcpEnd(given.tcp)
    try:
        return PtyEnd()
    except (ImportError, AttributeError) as error:
        raise OSError("this system has no pseudo-terminals; use --tcp 0.") from error


if __name__ == "__main__":
    sys.exit(main())
