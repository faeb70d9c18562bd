"""`python -m omx.hardware.simulator --tcp PORT | --pty`: the virtual arm for other programs, on this computer only."""

import argparse
import contextlib
import signal
import sys
import threading

from ...arm import ARM_IDS, HOME
from ...errors import BadInput, OmxError
from ..clock import Clock
from ..dynamixel.registers import register
from .faults import KINDS
from .server import PtyEnd, TcpEnd, follow, serve
from .virtual_arm import VirtualArm

#: What makes the arm less than ideal, by its name at `VirtualArm`.
_FLAWS = {
    "payload_g": "mass at the tool; the maker allows 500",
    "backlash_deg": "play of each joint; the servo's data sheet: 0.25",
    "encoder_ripple_deg": "non-linearity; the AS5045's data sheet: 0.5",
    "encoder_noise_deg": "rms; the AS5045's data sheet: 0.03 to 0.06",
}


class _Parser(argparse.ArgumentParser):
    """Says in one sentence what is wrong, without the list of all options."""

    def error(self, message):
        self.exit(2, f"{self.prog}: {message}. --help lists the options.\n")


def _port(text: str) -> int:
    if not (text.isdecimal() and int(text) <= 65535):
        raise argparse.ArgumentTypeError(f"a TCP port is 0 .. 65535, got {text!r}")
    return int(text)


def arguments() -> argparse.ArgumentParser:
    """The command line."""
    parser = _Parser(
        prog="python -m omx.hardware.simulator",
        description="A virtual OpenMANIPULATOR-X behind a serial port. Prints the port's name, and serves it until it "
        "is interrupted or terminated.",
        epilog="Faults, at the start with --fault or later with --stdin: "
        + "; ".join(f"{name}: {kind.text}" for name, kind in KINDS.items()),
    )
    where = parser.add_mutually_exclusive_group(required=True)
    where.add_argument("--tcp", type=_port, metavar="PORT", help="a TCP port on 127.0.0.1; 0 takes a free one")
    where.add_argument("--pty", action="store_true", help="a pseudo-terminal (Linux and macOS)")
    parser.add_argument("--scale", type=float, default=1.0, help="how many times as fast as real time (default 1)")
    parser.add_argument(
        "--stdin",
        action="store_true",
        help="take orders on standard input, one a line: a fault, or `clear`; end when it ends",
    )
    start = parser.add_argument_group("the arm at the start; it is ideal unless asked otherwise")
    start.add_argument("--q", type=float, nargs=4, default=HOME, metavar="RAD", help="joint angles (default: home)")
    start.add_argument(
        "--set",
        action="append",
        nargs="+",
        default=[],
        metavar=("SERVO", "NAME=VALUE"),
        help="registers of a servo, 11 .. 15 or `all`: --set all drive_mode=4 --set 12 homing_offset=-400",
    )
    start.add_argument("--fault", action="append", default=[], help='"KIND servo=13 count=2 after=0.5 value=1"')
    for name, text in _FLAWS.items():
        option, _, unit = name.rpartition("_")
        flag = "--" + option.replace("_", "-")
        start.add_argument(flag, dest=name, type=float, default=0.0, metavar=unit.upper(), help=text)
    return parser


def main(argv=None) -> int:
    """Serve until a signal, or the end of standard input if that was asked for."""
    given = arguments().parse_args(argv)
    try:
        arm, clock, orders = _arm(given), Clock(given.scale), _standard_input() if given.stdin else None
        end = _end(given)
    except (OmxError, OSError) as error:
        print(error, file=sys.stderr)
        return 1
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    print(end.name, flush=True)
    with contextlib.suppress(KeyboardInterrupt):
        if orders:
            threading.Thread(target=follow, args=(orders, arm), daemon=True).start()
        serve(end, arm, clock)
    end.close()
    return 0


def _arm(given) -> VirtualArm:
    settings: dict[int, dict[str, int]] = {}
    for who, *registers in given.set:
        if not registers:
            raise BadInput(f"--set {who} names no register: --set {who} homing_offset=-400.")
        for servo in _servos(who):
            settings.setdefault(servo, {}).update(map(_setting, registers))
    arm = VirtualArm(given.q, settings=settings, **{name: getattr(given, name) for name in _FLAWS})
    for text in given.fault:
        arm.faults.inject_text(text)
    return arm


def _servos(text: str) -> tuple[int, ...]:
    if text == "all":
        return ARM_IDS
    if text.isdecimal() and int(text) in ARM_IDS:
        return (int(text),)
    raise BadInput(f"--set takes a servo, {', '.join(map(str, ARM_IDS))} or `all`, then NAME=VALUE; got {text!r}.")


def _setting(text: str) -> tuple[str, int]:
    name, _, value = text.partition("=")
    row = register(name)
    try:
        number = int(value, 0)
    except ValueError:
        raise BadInput(f"--set takes NAME=VALUE with a whole number, homing_offset=-400; got {text!r}.") from None
    row.encode(number)  # refuses what the register cannot hold
    return row.name, number


def _standard_input():
    """A reader of its own: Python would wait for one that is in use when it ends."""
    try:
        return open(0, errors="replace", closefd=False)
    except OSError as error:
        raise OSError("--stdin: standard input is closed.") from error


def _end(given):
    if not given.pty:
        return TcpEnd(given.tcp)
    try:
        return PtyEnd()
    except (ImportError, AttributeError) as error:
        raise OSError("this system has no pseudo-terminals; use --tcp 0.") from error


if __name__ == "__main__":
    sys.exit(main())
