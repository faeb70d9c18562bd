"""What a command must pass before it reaches a servo: limits, table, the arm's own links, speed. Pure geometry.

Every check either returns or raises: the reason, by how much, and the nearest command that would pass. Nothing is
ever clamped in silence. The links are capsules (segments with a radius, mm) around the frames of the arm.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, cos, isfinite, radians, sin, sqrt

from .arrays import as_rows
from .dh import clipped, limit_violations
from .errors import BadInput, Collision, JointLimit, TooFast
from .generated import fk as _fk
from .geometry import COURSE, LIMITS, Geometry

#: Commands stay this far (rad) inside the joint limits.
SOFT_MARGIN = radians(2.0)

#: The fastest a joint is sent anywhere, unless the caller raises it on purpose (rad/s).
SPEED_CAP = radians(60.0)

#: A path is looked at every so far (rad) of the joint that turns most.
STEP = radians(2.0)

Point = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Capsule:
    """One part of the arm: all points within `radius` (mm) of the segment from `a` to `b` (mm, base frame)."""

    name: str
    a: Point
    b: Point
    radius: float


@dataclass(frozen=True)
class Guard:
    """The limits that one arm is driven within.

    `table`: the height (mm) of the table in the base frame, None for no table. `speed_cap` in rad/s. `margin`:
    how far (rad) commands stay inside `limits`.
    """

    geometry: Geometry = COURSE
    limits: tuple[tuple[float, float], ...] = LIMITS
    margin: float = SOFT_MARGIN
    table: float | None = 0.0
    speed_cap: float = SPEED_CAP

    @property
    def soft_limits(self) -> tuple[tuple[float, float], ...]:
        """The joint limits less the margin at either end, (low, high) a joint."""
        return tuple((low + self.margin, high - self.margin) for low, high in self.limits)

    def check(self, goal, start=None) -> tuple[float, float, float, float]:
        """`goal` (rad), checked by itself and, if `start` is given, all along the way that the joints take.

        Raises `BadInput`, `JointLimit` or `Collision`. An arm that *starts* outside (moved by hand, say) may come
        back in: then a joint, or the clearance, must only not get worse.
        """
        goal = _four(goal, "goal")
        if start is None:
            start, floor, limits = goal, 0.0, self.soft_limits
        else:
            start = _four(start, "start")
            floor = min(0.0, self.clearance(start)[0])
            limits = [(min(low, q), max(high, q)) for (low, high), q in zip(self.soft_limits, start, strict=True)]
        violations = limit_violations(goal, limits)
        if violations:
            raise JointLimit(violations, clipped(goal, self.soft_limits), "refused")
        last = start
        for q in _way(start, goal):
            gap, first, second = self.clearance(q)
            if gap < floor - 1e-6:
                raise Collision(first, second, -gap, last)
            last = q
        return goal

    def seconds(self, start, goal, seconds: float | None = None) -> float:
        """`seconds` for a move, or the fewest that the speed cap allows; raises `TooFast` where they are too few."""
        ways = [abs(b - a) for a, b in zip(_four(start, "start"), _four(goal, "goal"), strict=True)]
        fewest = max(ways) / self.speed_cap
        if seconds is None:
            return fewest
        if not (isfinite(seconds) and seconds > 0):
            raise BadInput(f"`seconds` must be a positive number; got {seconds}.")
        if seconds < fewest * (1 - 1e-9):
            joint = ways.index(max(ways)) + 1
            raise TooFast(f"q{joint}", max(ways) / seconds, self.speed_cap, fewest)
        return seconds

    def clearance(self, q) -> tuple[float, str, str]:
        """The smallest gap (mm; negative where parts overlap) and the names of the two parts it is between."""
        parts = capsules(q, self.geometry)
        gaps = [
            (distance(parts[i], parts[j]) - parts[i].radius - parts[j].radius, parts[i].name, parts[j].name)
            for i, j in PAIRS
        ]
        if self.table is not None:
            gaps += [(min(c.a[2], c.b[2]) - c.radius - self.table, c.name, "table") for c in parts[3:]]
        return min(gaps)


#: Which capsules can meet: the base and the parts beyond the elbow, the upper arm and the hand.
PAIRS = ((0, 3), (0, 4), (0, 5), (1, 4), (1, 5), (2, 5))


def capsules(q, geometry: Geometry = COURSE) -> tuple[Capsule, ...]:
    """The arm at `q` (rad): base, upper arm, elbow, forearm, hand, fingers. Sizes from the maker's drawings."""
    return parts(_fk.frames(*q, *geometry.values), geometry)


def parts(frames, geometry: Geometry = COURSE) -> tuple[Capsule, ...]:
    """The arm's capsules from its frames T_0_1 .. T_0_4, rows of numbers or, for many arms at once, of columns."""
    T1, T2, T3, T4 = frames
    shoulder, elbow, wrist, tool = (_position(T) for T in (T1, T2, T3, T4))
    beam = geometry.L2 * cos(geometry.delta)
    c, s = beam * cos(geometry.delta), beam * sin(geometry.delta)
    corner = tuple(p + c * row[0] - s * row[1] for p, row in zip(shoulder, T2, strict=False))
    ahead = tuple(row[0] for row in T4[:3])
    palm = _along(wrist, ahead, 69.0)
    return (
        Capsule("base", (0.0, 0.0, 15.0), (0.0, 0.0, geometry.L1 - 25.0), 24.0),
        Capsule("upper arm", shoulder, corner, 20.0),
        Capsule("elbow", corner, elbow, 24.0),
        Capsule("forearm", elbow, wrist, 22.0),
        Capsule("hand", wrist, palm, 23.0),
        Capsule("fingers", palm, _along(tool, ahead, 22.0), 13.0),
    )


def distance(one: Capsule, other: Capsule) -> float:
    """The shortest distance (mm) between the axes of two capsules."""
    u, v, w = _minus(one.b, one.a), _minus(other.b, other.a), _minus(one.a, other.a)
    a, b, c, d, e = _dot(u, u), _dot(u, v), _dot(v, v), _dot(u, w), _dot(v, w)
    denominator = a * c - b * b
    s = _unit((b * e - c * d) / denominator) if denominator > 1e-9 * a * c else 0.0
    t = _unit((b * s + e) / c) if c else 0.0
    s = _unit((b * t - d) / a) if a else 0.0
    gap = [w[i] + s * u[i] - t * v[i] for i in range(3)]
    return sqrt(_dot(gap, gap))


def stalled(current_mA: Sequence[float], speed: Sequence[float], threshold_mA: float = 500.0) -> list[int]:
    """The joints (1..4) that push without moving: much current (mA) and hardly any speed (rad/s)."""
    pairs = zip(current_mA, speed, strict=True)
    return [i for i, (mA, v) in enumerate(pairs, start=1) if abs(mA) > threshold_mA and abs(v) < radians(2.0)]


def _way(start, goal):
    """Configurations from `start` to `goal`, the last one included, no joint turning more than STEP between them."""
    longest = max(abs(b - a) for a, b in zip(start, goal, strict=True))
    count = max(1, ceil(longest / STEP))
    for i in range(1, count + 1):
        yield tuple(a + (b - a) * i / count for a, b in zip(start, goal, strict=True))


def _four(value, name: str) -> tuple[float, float, float, float]:
    row = as_rows(value, name, 4, "the four joint angles in rad")
    if row.ndim != 1:
        raise BadInput(f"`{name}` must be four joint angles; got shape {row.shape}.")
    return tuple(row.tolist())


def _position(T) -> Point:
    return T[0][3], T[1][3], T[2][3]


def _along(point, direction, length: float) -> Point:
    return tuple(p + length * d for p, d in zip(point, direction, strict=True))


def _minus(p, q) -> Point:
    return p[0] - q[0], p[1] - q[1], p[2] - q[2]


def _dot(p, q) -> float:
    return p[0] * q[0] + p[1] * q[1] + p[2] * q[2]


def _unit(t: float) -> float:
    return min(1.0, max(0.0, t))
