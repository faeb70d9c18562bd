"""What can go wrong, by name. Every error holds its data; every message says what to do next."""

import math
from typing import NamedTuple


class OmxError(Exception):
    """The parent of every error that `omx` raises on purpose."""


class BadInput(OmxError, ValueError):
    """An argument of the wrong shape, type or value: a mistake of the caller, found before any work is done."""


class Violation(NamedTuple):
    """One joint outside its limits: `joint` is its name; `value` and `limit` are in rad, mm if `prismatic`."""

    joint: str
    value: float
    limit: float
    prismatic: bool = False

    @property
    def excess(self) -> float:
        """How far beyond the limit, always positive."""
        return abs(self.value - self.limit)

    def __str__(self) -> str:
        side = "above" if self.value > self.limit else "below"
        value, excess, limit = (self.in_unit(a) for a in (self.value, self.excess, self.limit))
        return f"{self.joint} = {value} is {excess} {side} its limit {limit}"

    def in_unit(self, number: float) -> str:
        """`number` of this joint (rad or mm) in the unit for readers: `12.34 deg` or `12.34 mm`."""
        return _rounded(number) + " mm" if self.prismatic else _rounded(math.degrees(number)) + " deg"


class Unreachable(OmxError):
    """No joint angles bring the tool to `pose`.

    `missing` (mm) is the distance the arm falls short, at the wrist; `nearest` is the pose in that direction
    that it can reach, with the same pitch.
    """

    def __init__(self, pose, missing: float, nearest):
        self.pose, self.missing, self.nearest = pose, missing, nearest
        x, y, z, _ = nearest
        super().__init__(
            f"({pose[0]:.2f}, {pose[1]:.2f}, {pose[2]:.2f}) mm at pitch {math.degrees(pose[3]):.2f} deg is out "
            f"of reach: {_rounded(missing, 3)} mm are missing. The nearest reachable pose with this pitch is "
            f"({x:.2f}, {y:.2f}, {z:.2f}) mm."
        )


class JointLimit(OmxError):
    """The joints would have to leave their limits.

    `violations` lists each `Violation`; `nearest` holds the joint values with each one moved to its limit.
    """

    def __init__(self, violations, nearest, where: str = ""):
        self.violations, self.nearest = tuple(violations), tuple(nearest)
        listed = "; ".join(str(v) for v in self.violations)
        names = ", ".join(f"{v.joint} = {v.in_unit(v.limit)}" for v in self.violations)
        prefix = f"{where}: " if where else ""
        super().__init__(f"{prefix}{listed}. The nearest legal value: {names}.")


def _rounded(number: float, digits: int = 2) -> str:
    """Rounded for reading, but never to a zero that hides something small."""
    hides = number and abs(number) < 0.5 * 10**-digits
    return f"{number:.1e}" if hides else f"{number:.{digits}f}"


class Collision(OmxError):
    """Two parts of the arm, or the arm and the table, would meet.

    `first` and `second` name them, `depth` (mm) is how far they would overlap, `nearest` the last safe joint angles
    (rad) on the way.
    """

    def __init__(self, first: str, second: str, depth: float, nearest):
        self.first, self.second, self.depth, self.nearest = first, second, depth, tuple(nearest)
        angles = ", ".join(f"{math.degrees(a):.1f}" for a in self.nearest)
        super().__init__(
            f"refused: the {first} would run {depth:.1f} mm into the {second}. The arm could go as far as "
            f"({angles}) deg."
        )


class TooFast(OmxError):
    """A joint would have to be faster than the cap: `joint`, its `speed` and the `cap` (rad/s), `seconds` it takes."""

    def __init__(self, joint: str, speed: float, cap: float, seconds: float):
        self.joint, self.speed, self.cap, self.seconds = joint, speed, cap, seconds
        super().__init__(
            f"refused: {joint} would turn at {math.degrees(speed):.0f} deg/s; the cap is {math.degrees(cap):.0f} "
            f"deg/s. Take at least {seconds:.2f} s."
        )


class BusError(OmxError):
    """Something went wrong between the program and the servos. `port` is the port's name."""

    def __init__(self, port: str, message: str):
        self.port = port
        super().__init__(f"{port}: {message}")


class PortError(BusError):
    """The port cannot be opened; `errno` is the system's number for the reason, or None."""

    def __init__(self, port: str, message: str, errno: int | None = None):
        self.errno = errno
        super().__init__(port, message)


class PortBusy(PortError):
    """Another program, or another notebook, has the port open."""


class PortLost(PortError):
    """The port was open and has gone: the plug was pulled, or the adapter lost its power."""


class BusTimeout(BusError):
    """No answer. `missing` are the ids that owe one, `answered` those that gave one before."""

    def __init__(self, port: str, doing: str, missing, answered=()):
        self.doing, self.missing, self.answered = doing, tuple(missing), tuple(answered)
        first, *rest = self.missing
        after = f"; {_listed(rest)} come after it in turn and stay silent" if rest else ""
        before = f" ({_listed(self.answered)} did{after})" if self.answered else after
        super().__init__(
            port,
            f"servo {first} did not answer{before}. It was asked to {doing}. Is the 12 V supply on, and the cable "
            f"to servo {first} in? `python run.py doctor` looks further.",
        )


class BusCorrupt(BusError):
    """An answer came and was not whole. `servo` owed it; `received` is what arrived, as bytes."""

    def __init__(self, port: str, doing: str, servo: int, received: bytes):
        self.doing, self.servo, self.received = doing, servo, received
        super().__init__(
            port,
            f"the answer of servo {servo} is damaged ({received[-32:].hex(' ') or 'no bytes'}). It was asked to "
            f"{doing}. A loose cable, two servos with one id, or a second program on this port do this; ask again.",
        )


class ServoRefused(BusError):
    """The servo understood and will not do it. `servo` is its id, `code` the status packet's error number."""

    def __init__(self, port: str, doing: str, servo: int, code: int, reason: str):
        self.doing, self.servo, self.code = doing, servo, code
        super().__init__(port, f"servo {servo} refused to {doing}: {reason}.")


class ServoFault(BusError):
    """Servos report hardware errors: `faults` maps id to the bits of its register 70, `causes` id to words."""

    def __init__(self, port: str, faults: dict[int, int], causes: dict[int, list[str]]):
        self.faults, self.causes = dict(faults), dict(causes)
        told = "; ".join(f"servo {servo}: {', '.join(words)}" for servo, words in causes.items())
        super().__init__(
            port,
            f"{told}. The servo's torque may be off: support the arm. Remove the cause, then reboot that servo "
            f"(only a reboot clears the error).",
        )


class WrongServo(BusError):
    """Servos that are not the arm's model: `found` maps id to its model number."""

    def __init__(self, port: str, found: dict[int, int], wanted: int):
        self.found, self.wanted = dict(found), wanted
        told = ", ".join(f"servo {servo} is model {model}" for servo, model in found.items())
        super().__init__(
            port,
            f"{told}; the OpenMANIPULATOR-X has model {wanted} (XM430-W350). Is this another arm, or was another "
            f"servo built in?",
        )


def _listed(ids) -> str:
    *most, last = map(str, ids)
    return f"{', '.join(most)} and {last}" if most else last
