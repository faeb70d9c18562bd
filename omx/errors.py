"""What can go wrong, by name. Every error holds its data; every message says what to do next."""

import math
from typing import NamedTuple


class OmxError(Exception):
    """The parent of every error that `omx` raises on purpose."""


class BadInput(OmxError, ValueError):
    """An argument of the wrong shape, type or value: a mistake of the caller, found before any work is done."""


class Violation(NamedTuple):
    """One joint outside its limits: `joint` is its name, `value` and `limit` in rad (mm for a prismatic joint)."""

    joint: str
    value: float
    limit: float

    @property
    def excess(self) -> float:
        """How far beyond the limit, always positive."""
        return abs(self.value - self.limit)

    def __str__(self) -> str:
        side = "above" if self.value > self.limit else "below"
        if self.joint.startswith("d"):
            return f"{self.joint} = {self.value:.2f} is {self.excess:.2f} {side} its limit {self.limit:.2f}"
        value, limit, excess = (math.degrees(a) for a in (self.value, self.limit, self.excess))
        return f"{self.joint} = {value:.2f} deg is {excess:.2f} deg {side} its limit {limit:.2f} deg"


class Unreachable(OmxError):
    """No joint angles bring the tool to `pose`.

    `missing` (mm) is the distance the arm falls short, at the wrist; `nearest` is the pose in that direction
    that it can reach, with the same pitch.
    """

    def __init__(self, pose, missing: float, nearest):
        self.pose, self.missing, self.nearest = pose, missing, nearest
        x, y, z, pitch = nearest
        super().__init__(
            f"({pose[0]:.2f}, {pose[1]:.2f}, {pose[2]:.2f}) mm at pitch {math.degrees(pose[3]):.2f} deg is out of "
            f"reach: {missing:.3f} mm are missing. The nearest reachable pose with this pitch is "
            f"({x:.2f}, {y:.2f}, {z:.2f}) mm."
        )


class JointLimit(OmxError):
    """The joints would have to leave their limits.

    `violations` lists each `Violation`; `nearest` holds the joint values with each one moved to its limit.
    """

    def __init__(self, violations, nearest, where: str = ""):
        self.violations, self.nearest = tuple(violations), tuple(nearest)
        listed = "; ".join(str(v) for v in self.violations)
        names = ", ".join(f"{v.joint} = {_in_unit(v)}" for v in self.violations)
        prefix = f"{where}: " if where else ""
        super().__init__(f"{prefix}{listed}. The nearest legal value: {names}.")


def _in_unit(violation: Violation) -> str:
    if violation.joint.startswith("d"):
        return f"{violation.limit:.2f}"
    return f"{math.degrees(violation.limit):.2f} deg"


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
