"""What a command must pass before it reaches a servo: limits, table, the arm's own links, speed. Pure geometry.

Every check either returns or raises: the reason, by how much, and the nearest command that would pass. Nothing is
ever clamped in silence.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, isfinite, radians

import numpy as np

from ..arm import LIMITS, SOFT_MARGIN, SPEED_CAP
from ..arrays import as_four
from ..collision import gaps
from ..dh import clipped, limit_violations
from ..errors import BadInput, Collision, JointLimit, TooFast
from ..geometry import COURSE, Geometry
from ..kinematics import JOINT_ANGLES

#: A path is looked at every so far (rad) of the joint that turns most.
STEP = radians(2.0)


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
        goal = as_four(goal, "goal", JOINT_ANGLES)
        if start is None:
            start, floor, limits = goal, 0.0, self.soft_limits
        else:
            start = as_four(start, "start", JOINT_ANGLES)
            floor = min(0.0, self.clearance(start)[0])
            limits = [(min(low, q), max(high, q)) for (low, high), q in zip(self.soft_limits, start, strict=True)]
        violations = limit_violations(goal, limits)
        if violations:
            raise JointLimit(violations, clipped(goal, self.soft_limits), "refused")
        way = _way(start, goal)
        pairs, found = gaps(way, self.geometry, self.table)
        met = found.min(axis=0) < floor - 1e-6
        if met.any():
            first = int(met.argmax())
            pair = int(found[:, first].argmin())
            raise Collision(*pairs[pair], -found[pair, first], way[first - 1].tolist() if first else start)
        return goal

    def seconds(self, start, goal, seconds: float | None = None) -> float:
        """`seconds` for a move, or the fewest that the speed cap allows; raises `TooFast` where they are too few."""
        start, goal = as_four(start, "start", JOINT_ANGLES), as_four(goal, "goal", JOINT_ANGLES)
        ways = [abs(b - a) for a, b in zip(start, goal, strict=True)]
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
        pairs, found = gaps([q], self.geometry, self.table)
        nearest = int(found[:, 0].argmin())
        return float(found[nearest, 0]), *pairs[nearest]


def stalled(current_mA: Sequence[float], speed: Sequence[float], threshold_mA: float = 500.0) -> list[int]:
    """The joints (1..4) that push without moving: much current (mA) and hardly any speed (rad/s)."""
    pairs = zip(current_mA, speed, strict=True)
    return [i for i, (mA, v) in enumerate(pairs, start=1) if abs(mA) > threshold_mA and abs(v) < radians(2.0)]


def _way(start, goal) -> np.ndarray:
    """Configurations from `start` to `goal` (N, 4), the last one included, no joint turning more than STEP between."""
    start, goal = np.array(start), np.array(goal)
    count = max(1, ceil(np.abs(goal - start).max() / STEP))
    return start + (goal - start) * np.arange(1, count + 1)[:, None] / count
