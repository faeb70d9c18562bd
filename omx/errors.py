"""What can go wrong, by name. Every error holds its data; every message says what to do next."""

import copyreg
import math
import os
import sys
import traceback
from typing import NamedTuple

__all__ = [
    "BadInput", "BusCorrupt", "BusError", "BusTimeout", "Collision", "JointLimit", "LogError", "NotArrived",
    "NotDecided", "NotEqual", "NotIdentifiable", "NotReady", "ObjectLost", "OmxError", "OutOfBounds", "PathBlocked",
    "PortBusy", "PortError", "PortLost", "ReadOnly", "ServoFault", "ServoLost", "ServoRefused", "ServoRestarted",
    "Stalled", "Stopped", "TooFast", "TooHeavy", "TorqueOff", "Unreachable", "ViewerMissing", "Violation", "Wrong",
]  # fmt: skip

#: The folder of this package, whose lines teach a reader nothing.
_HOME = os.path.dirname(os.path.realpath(__file__)) + os.sep


class OmxError(Exception):
    """The parent of every error that `omx` raises on purpose. Copies and pickles with its message and all its data.

    `note` is what a notebook shows after every message.
    """

    note = ""

    def __reduce__(self):
        # in another process it is made without its `__init__`, which takes other arguments
        return copyreg.__newobj__, (type(self), *self.args), self.__dict__

    def _render_traceback_(self) -> list[str]:
        """What a notebook shows: the reader's own lines and the sentence, nothing of ours between them."""
        ours, lines = (_HOME, sys.prefix, sys.base_prefix), []
        for frame in traceback.extract_tb(self.__traceback__):
            if not os.path.realpath(frame.filename).startswith(ours):
                within = "" if frame.name == "<module>" else f" of {frame.name}"
                lines.append(f"line {frame.lineno}{within}:   {frame.line}")
        return lines + _noted(f"{type(self).__name__}: {self}")


def _noted(message: str) -> list[str]:
    return [message, OmxError.note] if OmxError.note else [message]


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
            f"({x:.2f}, {y:.2f}, {z:.2f}) mm.{slip_of_unit(pose)}"
        )


def slip_of_unit(pose) -> str:
    """A question, where the numbers of a pose can hardly be in mm and rad; else ''."""
    if abs(pose[3]) > 4 * math.pi:
        return " Is the pitch in degrees? It is wanted in rad."
    return " Are x, y, z in metres? They are wanted in mm." if 0 < max(map(abs, pose[:3])) < 1 else ""


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
    (rad) on the way. `sags`: not as it is told to stand, but as it sags there under its weight.
    """

    def __init__(self, first: str, second: str, depth: float, nearest, sags: bool = False):
        self.first, self.second, self.depth, self.nearest, self.sags = first, second, depth, tuple(nearest), sags
        angles = ", ".join(f"{math.degrees(a):.1f}" for a in self.nearest)
        super().__init__(
            f"refused: the {first} would {'sag' if sags else 'run'} {depth:.1f} mm into the {second}. "
            f"The arm could go as far as ({angles}) deg."
        )


class TooFast(OmxError):
    """A joint would have to be faster than the cap: `joint`, its `speed` and the `cap` (rad/s), `seconds` it takes."""

    def __init__(self, joint: str, speed: float, cap: float, seconds: float):
        self.joint, self.speed, self.cap, self.seconds = joint, speed, cap, seconds
        super().__init__(
            f"refused: {joint} would turn at {math.degrees(speed):.0f} deg/s; the cap is {math.degrees(cap):.0f} "
            f"deg/s. Take at least {seconds:.2f} s."
        )


class TooHeavy(OmxError):
    """A joint could not hold the payload there for long.

    `joint` is 1 .. 4; `current` is what it would need, `limit` what it may (mA); `payload_g` the load, `most_g` what
    the arm may carry at `q` (rad).
    """

    def __init__(self, joint: int, current: float, limit: float, payload_g: float, most_g: float, q):
        self.joint, self.current, self.limit = joint, current, limit
        self.payload_g, self.most_g, self.q = payload_g, most_g, tuple(q)
        angles = ", ".join(f"{math.degrees(a):.0f}" for a in self.q)
        super().__init__(
            f"refused: with {payload_g:.0f} g joint {joint} would need {current:.0f} mA at ({angles}) deg; {limit:.0f} "
            f"mA is the most for longer than a moment. Carry it closer to the base, or at most {most_g:.0f} g there."
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


class ReadOnly(OmxError):
    """An arm that is only read was to be written to. `port` is its port, `doing` what was refused; nothing was sent."""

    def __init__(self, port: str, doing: str):
        self.port, self.doing = port, doing
        super().__init__(
            f"{port}: a real arm is only read in a browser: refused to {doing}. Here STOP would wait for the end of a "
            "cell, nothing would watch the arm meanwhile, and a restarted kernel could not make it hold. The virtual "
            "arm, `Robot()`, moves; so does a real one with the book installed: `python run.py lab`."
        )


class BusTimeout(BusError):
    """No answer. `missing` are the ids that owe one, `answered` those that gave one before."""

    def __init__(self, port: str, doing: str, missing, answered=()):
        self.doing, self.missing, self.answered = doing, tuple(missing), tuple(answered)
        first, *rest = self.missing
        after = f"; {listed(rest)} come after it in turn and stay silent" if rest else ""
        before = f" ({listed(self.answered)} did{after})" if self.answered else after
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


class PathBlocked(OmxError):
    """A straight line that the arm cannot follow: `fraction` of the way done, `reached` the last good `Pose`.

    `reason` is the `Unreachable`, `JointLimit` or a sentence; `q` are the last good joint angles (rad).
    """

    def __init__(self, fraction: float, reached, q, reason):
        self.fraction, self.reached, self.q, self.reason = fraction, reached, tuple(q), reason
        super().__init__(
            f"the straight line stops after {fraction:.1%} of its length, at ({reached.x:.1f}, {reached.y:.1f}, "
            f"{reached.z:.1f}) mm: {reason} Choose other end points, another pitch, or a joint-space move."
        )


class NotIdentifiable(OmxError):
    """The measured configurations say too little about some parameters; `names` are those."""

    def __init__(self, names):
        self.names = tuple(names)
        super().__init__(
            f"these configurations cannot tell {', '.join(self.names)} apart from other errors. Measure more of them, "
            "spread over the whole range of every joint."
        )


class NotEqual(OmxError, AssertionError):
    """Two expressions that should be the same are not; `residual` is what is left of their difference.

    `values` are numbers, by the symbols' names, at which the two sides have the values `sides`.
    """

    def __init__(self, name: str, residual, values=None, sides=()):
        self.residual, self.values, self.sides = residual, dict(values or {}), tuple(sides)
        at = ", ".join(f"{symbol} = {value:.6g}" for symbol, value in self.values.items())
        told = f"; {f'with {at} ' if at else ''}the sides are {' and '.join(map(_plain, self.sides))}" if sides else ""
        super().__init__(f"{name} is not 0; what remains is {_remaining(residual)}{told}")


class NotDecided(OmxError, AssertionError):
    """Two expressions may be the same: no proof was found, and no numbers at which they differ; see `residual`."""

    def __init__(self, name: str, residual):
        self.residual = residual
        super().__init__(
            f"{name}: not decided. The sides agree wherever they were compared, but {_remaining(residual)} remains. Is "
            "a float such as 1.5707963 meant to be exact (write sympy.pi / 2), or a `relation` between symbols missing?"
        )


def _remaining(residual):
    """An expression as it is, a number as a float."""
    return _plain(complex(residual)) if getattr(residual, "is_number", False) else residual


def _plain(number: complex) -> str:
    return f"{number.real:.6g}" if abs(number.imag) <= 1e-12 * abs(number) else f"{number:.6g}"


#: A sentence of a check begins with such a word or with a name, and names stay as they are written.
WORDS = ("the", "what", "an", "one", "these", "all")


class Wrong(OmxError, AssertionError):
    """An answer that is not right yet; the message says what to look at."""

    def _render_traceback_(self) -> list[str]:
        """What a notebook shows: the message alone, since the traceback is ours and teaches nothing."""
        first, _, rest = str(self).partition(" ")
        return _noted(f"Not yet. {first.capitalize() if first in WORDS else first} {rest}".rstrip())


class ViewerMissing(OmxError):
    """The MeshCat viewer is not where its package should have it; `path` is where it was looked for."""

    def __init__(self, path):
        self.path = path
        super().__init__(f"The MeshCat viewer is missing ({path}). Install the package `meshcat`.")


class LogError(OmxError):
    """The file could not be written or read. `samples` holds every sample taken, so nothing is lost."""

    def __init__(self, message: str, samples: list[tuple[float, ...]] | None = None):
        self.samples = samples or []
        super().__init__(message)


class NotReady(OmxError):
    """The arm cannot be used as it is: `problems` lists everything that was found, not only the first."""

    def __init__(self, where: str, problems: list[str]):
        self.problems = list(problems)
        listed = "\n".join(f"  - {problem}" for problem in self.problems)
        super().__init__(f"{where} is not ready:\n{listed}\n`python run.py doctor` looks further.")


class Stopped(OmxError):
    """The arm was stopped and holds; `why` in a few words. `resume()` allows commands again."""

    def __init__(self, why: str = "stopped"):
        self.why = why
        super().__init__(f"{why}: the arm holds. `robot.resume()` allows commands again.")


class TorqueOff(OmxError):
    """The motors are off, so there is nothing to command."""

    def __init__(self):
        super().__init__("the motors are off. `robot.write_motor_state(True)` switches them on where the arm stands.")


class Stalled(OmxError):
    """A joint pushes and does not move. `joint` is 1 .. 4, `current` in mA; the arm holds."""

    def __init__(self, joint: int, current: float):
        self.joint, self.current = joint, current
        super().__init__(
            f"joint {joint} is pushing on something ({abs(current):.0f} mA) and does not move. The arm holds. "
            "Take away what is in its way; `robot.resume()` allows commands again."
        )


class NotArrived(OmxError):
    """The time of a move is over, and joint `joint` (1 .. 4) is `gap` (rad) from where it was sent: the arm holds."""

    def __init__(self, joint: int, gap: float, cause: str):
        self.joint, self.gap, self.cause = joint, gap, cause
        super().__init__(
            f"joint {joint} is {math.degrees(abs(gap)):.1f} deg from where it was sent, and its time is over. The arm "
            f"holds. Likely: {cause}."
        )


class OutOfBounds(OmxError):
    """An arm that is pushed, in current mode, came too near a limit or the table; it holds, in position mode."""

    def __init__(self, reason: OmxError):
        self.reason, why = reason, str(reason)
        if isinstance(reason, TooFast):  # nobody asked for a speed: a hand leads the arm, or its weight does
            speed, cap = math.degrees(reason.speed), math.degrees(reason.cap)
            why = f"{reason.joint} turned at {speed:.0f} deg/s, and the cap is {cap:.0f} deg/s."
        super().__init__(f"the push ended, and the arm holds in position mode: {why}")


class ObjectLost(OmxError):
    """The gripper held something and holds it no more. `before` and `now` are the openings of its pads (mm).

    `limp`: its motor is off, though nobody switched it off.
    """

    def __init__(self, before: float, now: float, limp: bool = False):
        self.before, self.now, self.limp = before, now, limp
        why = " Its motor is off: servo 15 restarted, or gave up." if limp else ""
        super().__init__(
            f"the gripper has lost what it held: its pads were {before:.1f} mm apart and are {now:.1f} mm.{why} The "
            "arm holds. Grip it again, with more force if it slipped."
        )


class ServoLost(BusTimeout):
    """Servos that answered before have gone for good: `missing`; `answered` are still there, and hold."""

    def __init__(self, port: str, doing: str, missing, answered):
        self.doing, self.missing, self.answered = doing, tuple(missing), tuple(answered)
        BusError.__init__(self, port, f"{_gone(self.missing, self.answered)} `python run.py doctor` looks further.")


class ServoRestarted(BusError):
    """Servos restarted by themselves and lost their torque: `servos`; `held` says whether they hold again."""

    def __init__(self, port: str, servos, held: bool):
        self.servos, self.held = tuple(servos), held
        now = "It was switched on again where it was. The arm holds." if held else "Its motor is OFF: support the arm."
        super().__init__(
            port,
            f"servo {listed(self.servos)} restarted by itself, and its motor went off for a moment: too little "
            f"power, or a loose plug. {now} Look at the supply and the cables, then move on.",
        )


def _gone(missing, answered) -> str:
    if not answered:
        return "no servo answers any more: the 12 V supply is off (then the arm falls), or the first cable is out."
    if len(missing) > 1 and min(missing) > max(answered):
        where = f"the chain is broken between servo {max(answered)} and servo {missing[0]}: look at that cable"
        return f"servo {listed(missing)} no longer answer; {where}. The others hold; these may have no power."
    return f"servo {listed(missing)} no longer answers: look at its cable. The others hold; it may have no power."


def listed(ids) -> str:
    """Numbers or names in a row: `11, 12 and 13`."""
    *most, last = map(str, ids)
    return f"{', '.join(most)} and {last}" if most else last
