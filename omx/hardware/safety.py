"""What a command must pass before it reaches a servo: limits, table, the arm's own links, speed. Pure geometry.

Every check either returns or raises: the reason, by how much, and the nearest command that would pass. Nothing is
ever clamped in silence.
"""

from dataclasses import dataclass
from math import ceil, pi, radians

import numpy as np

from ..arm import GRAVITY, HOLDING_TORQUE, LIMITS, NO_LOAD_SPEED, SOFT_MARGIN, SPEED_CAP, STALL_TORQUE
from ..arrays import as_four, as_number, as_rows
from ..collision import gaps
from ..dh import clipped, limit_violations
from ..errors import BadInput, Collision, JointLimit, TooFast
from ..geometry import COURSE, Geometry
from ..kinematics import JOINT_ANGLES
from . import gravity

#: A path is looked at every so far (rad) of the joint that turns most.
STEP = radians(2.0)
#: The share of its time in which a move speeds up, and that in which it slows down: a trapezoid.
RAMP = 0.25
#: The overload threshold: more current (mA) than this beyond the weight, without motion, pushes on something.
STALL_MA = 500.0
#: Dry friction (Nm) in a joint, and how far (mm) a payload in the fingers is from the axis of joint 2.
FRICTION, PAYLOAD_AT = 0.1, 380.0
#: The farthest (mm) that something carried may reach from the tool.
MOST_MM = 150.0


@dataclass(frozen=True)
class Guard:
    """The limits that one arm is driven within.

    `table`: the height (mm) of the table in the base frame, None for no table. `speed_cap` in rad/s. `margin`:
    how far (rad) commands stay inside `limits`. `payload_g`: what the gripper carries (g); `payload_mm`: how far it
    reaches (mm) from the tool, all round. Raises `BadInput` for settings that cannot be kept.
    """

    geometry: Geometry = COURSE
    limits: tuple[tuple[float, float], ...] = LIMITS
    margin: float = SOFT_MARGIN
    table: float | None = 0.0
    speed_cap: float = SPEED_CAP
    payload_g: float = 0.0
    payload_mm: float = 0.0

    def __post_init__(self):
        limits = as_rows(self.limits, "limits", 2, "(low, high) a joint in rad").tolist()
        if len(limits) != 4 or not all(-pi <= low < high <= pi for low, high in limits):
            raise BadInput(f"`limits` must be four pairs (low, high) within -pi .. pi rad; got {limits}.")
        object.__setattr__(self, "limits", tuple(map(tuple, limits)))
        narrowest = min(high - low for low, high in limits)
        most = f"0 or more, in rad, and leave something of the narrowest limits ({narrowest:.2f} rad)"
        as_number(self.margin, "margin", most, 0, 0.499 * narrowest)
        if self.table is not None:
            as_number(self.table, "table", "a height in mm, or None for no table")
        fastest = f"above 0 and at most {NO_LOAD_SPEED:.2f} rad/s, the motors' own speed"
        as_number(self.speed_cap, "speed_cap", fastest, 1e-6, NO_LOAD_SPEED)
        if not isinstance(self.geometry, Geometry):
            raise BadInput(f"`geometry` must be a Geometry, such as omx.COURSE; got {self.geometry!r}.")
        gravity.payload(self.payload_g)
        as_number(self.payload_mm, "payload_mm", f"0 .. {MOST_MM:.0f} mm from the tool", 0, MOST_MM)

    @property
    def soft_limits(self) -> tuple[tuple[float, float], ...]:
        """The joint limits less the margin at either end, (low, high) a joint."""
        return tuple((low + self.margin, high - self.margin) for low, high in self.limits)

    def check(self, goal, start=None, aim=None) -> tuple[float, float, float, float]:
        """`goal` (rad), checked by itself and, if `start` is given, all along the way that the joints take from there.

        From `aim`, too, where the set-points are of an arm that moves. The way must be clear as it is commanded, and as
        the arm sags on it, payload and all. An arm that *starts* outside (moved by hand, say) may come back in: then a
        joint, the clearance or the load must only not get worse. Raises `BadInput`, `JointLimit`, `Collision` or
        `TooHeavy`.
        """
        goal = as_four(goal, "goal", JOINT_ANGLES)
        starts = [as_four(q, "start", JOINT_ANGLES) for q in (start, aim) if q is not None]
        for here in starts or [None]:
            self._check_limits(goal, here)
        ways = [_way(here, goal) for here in starts] or [np.array([goal])]
        pairs, found = self._gaps(np.concatenate(ways))  # of all ways at once: a look at a few arms costs as one
        for way in ways:
            self._check_way(way, pairs, found[:, :, : len(way)], begun=bool(starts))
            found = found[:, :, len(way) :]
        return goal

    def check_points(self, points) -> None:
        """Each of `points` (N, 4), rad, along a way, checked by itself: limits first, then gaps, then loads."""
        for q in points.tolist():
            self._check_limits(q)
        self._check_way(points, *self._gaps(points), begun=False)

    def _check_limits(self, goal, start=None) -> None:
        limits = soft = self.soft_limits
        if start is not None:
            limits = [(min(low, q), max(high, q)) for (low, high), q in zip(soft, start, strict=True)]
        if violations := limit_violations(goal, limits):
            raise JointLimit(violations, clipped(goal, soft), "refused")

    def _check_way(self, way, pairs, found, begun: bool) -> None:
        """Raise what is against `way` (N, 4), whose gaps were `found`. If it has `begun`, the arm is at its start."""
        floor = min(0.0, found[:, :, 0].min()) if begun else 0.0
        met = found.min(axis=(0, 1)) < floor - 1e-6
        met[:begun] = False
        if met.any():
            first = int(met.argmax())
            sags, pair = divmod(int(found[:, :, first].argmin()), len(pairs))
            raise Collision(*pairs[pair], -found[sags, pair, first], way[max(first - 1, 0)].tolist(), sags=bool(sags))
        if self.payload_g:
            gravity.check_payload(way[begun:].tolist(), self.payload_g, way[0].tolist() if begun else None)

    def seconds(self, start, goal, seconds: float | None = None, ramp: float = RAMP) -> float:
        """`seconds` for a move, or the fewest that the speed cap allows; raises `TooFast` where they are too few.

        The cap is on the top of the trapezoid, not on its mean: 4/3 of that with ramps of a quarter.
        """
        start, goal = as_four(start, "start", JOINT_ANGLES), as_four(goal, "goal", JOINT_ANGLES)
        ways = [abs(b - a) / (1 - ramp) for a, b in zip(start, goal, strict=True)]
        fewest = max(ways) / self.speed_cap
        if seconds is None:
            return fewest
        as_number(seconds, "seconds", "at least 1e-9 s", 1e-9)
        if seconds < fewest * (1 - 1e-9):
            joint = ways.index(max(ways)) + 1
            raise TooFast(f"q{joint}", max(ways) / seconds, self.speed_cap, fewest)
        return seconds

    def push(self) -> float:
        """The torque (Nm) that a joint is allowed: enough to carry the arm and its payload at the cap, and a tenth.

        With the default cap and no payload 2.1 Nm: a hand that stands in the way of the fingertips of the stretched
        arm, 0.38 m from the axis, feels at most (2.1 + 0.9) Nm / 0.38 m = 8 N, the weight of the arm included; one
        that is 0.1 m from an axis at most 30 N.
        """
        carried = HOLDING_TORQUE + self.payload_g * GRAVITY * PAYLOAD_AT * 1e-6
        return min(1.1 * (carried + FRICTION + STALL_TORQUE / NO_LOAD_SPEED * self.speed_cap), STALL_TORQUE)

    def _gaps(self, way) -> tuple[list[tuple[str, str]], np.ndarray]:
        """The pairs of parts that can meet, and their gaps (mm) as commanded and as the arm sags: (2, pairs, N)."""
        sagged = [gravity.sagged(q, self.payload_g) for q in way.tolist()]
        pairs, found = gaps(np.concatenate([way, sagged]), self.geometry, self.table, self.payload_mm)
        return pairs, found.reshape(len(pairs), 2, len(way)).swapaxes(0, 1)

    def clearance(self, q) -> tuple[float, str, str]:
        """The smallest gap (mm; negative where parts overlap) and the names of the two parts it is between."""
        pairs, found = gaps([q], self.geometry, self.table, self.payload_mm)
        nearest = int(found[:, 0].argmin())
        return float(found[nearest, 0]), *pairs[nearest]


def stalled(current_mA, speed, *weights_mA) -> list[int]:
    """The joints (1..4) that push without moving: hardly any speed (rad/s), and a current more than `STALL_MA` beyond
    what each of the `weights_mA` asks for, such as those of the empty arm and of the loaded one.
    """
    joints = enumerate(zip(current_mA, speed, *(weights_mA or [(0.0,) * 4]), strict=True), start=1)
    return [
        i
        for i, (mA, v, *weights) in joints
        if abs(v) < radians(2.0) and not min(weights) - STALL_MA <= mA <= max(weights) + STALL_MA
    ]


def _way(start, goal) -> np.ndarray:
    """Configurations from `start` to `goal` (N, 4), both included, no joint turning more than STEP between."""
    start, goal = np.array(start), np.array(goal)
    count = max(1, ceil(np.abs(goal - start).max() / STEP))
    return start + (goal - start) * np.arange(count + 1)[:, None] / count
