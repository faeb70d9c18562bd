"""From here to there in time: scalings, joint-space moves, straight lines of the tool, the legs of a pick or a place.

A scaling turns normalised time u in [0, 1] into progress s in [0, 1] with its first two derivatives by u. A
`Trajectory` is sampled: times (s), joint angles, velocities and accelerations (rad, rad/s, rad/s^2).
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import ceil, inf, pi, tau

import numpy as np

from .. import kinematics
from ..arm import LIMITS, SPEED_CAP
from ..arrays import as_floats, as_four, as_number, as_rows, shown, wrap
from ..dh import as_limits, clipped, limit_violations
from ..errors import BadInput, JointLimit, OmxError, PathBlocked
from ..geometry import COURSE, Geometry
from ..kinematics import JOINT_ANGLES, TASK_POSE
from .differential_ik import joint_velocity, manipulability

#: Normalised time u (N,) in [0, 1] -> progress s, ds/du and d2s/du2, each (N,).
Scaling = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray, np.ndarray]]

#: A smaller |det| of the task Jacobian than this, relative to its size a long way from singularities, is singular.
NEAR_SINGULAR = 1e-3

#: The smallest number that counts as positive here, and the most samples of one motion.
TINY, MOST_SAMPLES = 1e-9, 1e7

#: How high (mm) the tool is carried between picks, and how long (s) it takes straight down or up.
ABOVE, STRAIGHT_S = 95.0, 1.2
#: The quintic's top speed, by its mean; and the share of the speed cap that is used.
TOP, CAUTION = 1.875, 0.9

UNIT = "shares of the time, from 0 to 1"


@dataclass(frozen=True)
class Trajectory:
    """Samples of a motion: `t` (N,) s; `q`, `qd`, `qdd` (N, 4) in rad, rad/s, rad/s^2."""

    t: np.ndarray
    q: np.ndarray
    qd: np.ndarray
    qdd: np.ndarray

    @property
    def seconds(self) -> float:
        """How long the motion takes."""
        return float(self.t[-1])

    def poses(self, geometry: Geometry = COURSE) -> np.ndarray:
        """The tool's x, y, z, pitch at each sample, (N, 4), mm and rad."""
        return np.asarray(kinematics.pose(self.q, geometry))

    def at(self, seconds: float) -> np.ndarray:
        """Joint angles (4,) at a time between the samples; the ends hold before and after."""
        seconds = as_number(seconds, "seconds", "a time in seconds", -inf, inf)
        return np.array([np.interp(seconds, self.t, column) for column in self.q.T])

    def then(self, other: "Trajectory") -> "Trajectory":
        """This motion and then the other, which must begin where this one ends."""
        if not isinstance(other, Trajectory):
            raise BadInput(f"`other` must be a Trajectory; got {shown(other)}.")
        gap = np.abs(self.q[-1] - other.q[0]).max()
        if gap > 1e-6:
            raise BadInput(f"`other` must begin where this trajectory ends; a joint would jump by {gap:.6f} rad.")
        t = np.concatenate([self.t, other.t[1:] + self.t[-1]])
        parts = ((self.q, other.q), (self.qd, other.qd), (self.qdd, other.qdd))
        return Trajectory(t, *(np.concatenate([a, b[1:]]) for a, b in parts))


def cubic(u):
    """3u^2 - 2u^3: starts and ends at rest, with a jump of the acceleration at both ends."""
    u = as_floats(u, "u", UNIT)
    return u * u * (3 - 2 * u), 6 * u * (1 - u), 6 - 12 * u


def quintic(u):
    """10u^3 - 15u^4 + 6u^5: starts and ends at rest and without acceleration."""
    u = as_floats(u, "u", UNIT)
    return u**3 * (10 - 15 * u + 6 * u * u), 30 * (u * (1 - u)) ** 2, 60 * u * (1 - u) * (1 - 2 * u)


def trapezoid(ramp: float = 0.25) -> Scaling:
    """Constant acceleration for `ramp` of the time, constant speed, and the same ramp down: a servo's profile.

    Unlike `cubic` and `quintic` it is called to be passed on: `scaling=trapezoid(0.3)`.
    """
    ramp = as_number(ramp, "ramp", f"a share of the time, {TINY:g} to 0.5", TINY, 0.5)
    speed = 1 / (1 - ramp)

    def scaling(u):
        u = as_floats(u, "u", UNIT)
        rising, falling = u < ramp, u > 1 - ramp
        s = np.where(rising, speed * u * u / (2 * ramp), speed * (u - ramp / 2))
        s = np.where(falling, 1 - speed * (1 - u) ** 2 / (2 * ramp), s)
        ds = speed * np.minimum(1.0, np.minimum(u, 1 - u) / ramp)
        return s, ds, speed / ramp * (rising.astype(float) - falling)

    return scaling


def joint_move(start, goal, seconds: float, scaling: Scaling = quintic, rate: float = 100.0) -> Trajectory:
    """All joints from `start` to `goal` (rad) together, along a straight line in joint space; `rate` samples a second.

    Joints have ends, so each turns from its one value to the other: 350 deg is not 10 deg the other way.
    """
    start, goal = np.array(as_four(start, "start", JOINT_ANGLES)), np.array(as_four(goal, "goal", JOINT_ANGLES))
    seconds, t, (s, ds, dds) = _timeline(seconds, scaling, rate)
    way = goal - start
    return Trajectory(
        t, start + np.outer(s, way), np.outer(ds, way) / seconds, np.outer(dds, way) / (seconds * seconds)
    )


def line(
    start,
    pose,
    seconds: float,
    scaling: Scaling = quintic,
    rate: float = 100.0,
    geometry: Geometry = COURSE,
    limits=LIMITS,
    max_speed: float = inf,
) -> Trajectory:
    """The tool on a straight line from where it is at `start` to `pose`; the pitch turns evenly, the short way round.

    Each sample is solved by the inverse, staying on the branch of the sample before; joint velocities come from
    the Jacobian. Half a turn of the pitch goes up. Raises `PathBlocked` where the line leaves the reach or a joint its
    limits, where the arm is singular, or where a joint would be too fast; `JointLimit` if `start` is outside its limits
    already; `BadInput`.

    Args:
        start: joint angles (4,), rad.
        pose: x, y, z in mm and pitch in rad, (4,).
        seconds: how long it takes.
        scaling: how it speeds up and slows down: `cubic`, `quintic` or `trapezoid(...)`.
        rate: samples a second.
        geometry: the arm's lengths.
        limits: one (low, high) in rad a joint.
        max_speed: the fastest that a joint may turn (rad/s).
    """
    limits = limits if limits is LIMITS else as_limits(limits, 4)
    max_speed = as_number(max_speed, "max_speed", f"a speed in rad/s, {TINY:g} or more", TINY, inf)
    q0, first, way = _straight_way(start, pose, geometry, limits)
    seconds, t, (s, ds, _) = _timeline(seconds, scaling, rate)
    poses = first + np.outer(s, way)
    qd = np.empty_like(poses)

    def look(i, here):
        qd[i] = _joint_velocity(here, way * ds[i] / seconds, geometry, max_speed)

    q = solve_along(poses, q0, geometry, limits, s, look)
    qdd = np.gradient(qd, t, axis=0, edge_order=2) if len(t) > 2 else np.zeros_like(qd)
    return Trajectory(t, q, qd, qdd)


def legs(
    start, place, z: float, above: float = ABOVE, geometry: Geometry = COURSE, speed: float = 1.0
) -> tuple[Trajectory, Trajectory, Trajectory]:
    """From `start` (rad) with the hand pointing down over `place` (x, y), down to the height `z`, and up: three legs.

    The first takes as long as 9/10 of the speed cap ask for; with a `speed` of 0.5 all three take twice as long. The
    tool is `above` mm high between places, and at least 16 mm above `z`. Raises `Unreachable`, `JointLimit`,
    `PathBlocked` or `BadInput`; the table is the guard's business.
    """
    start = as_four(start, "start", JOINT_ANGLES)
    x, y = as_rows(place, "place", 2, "x and y on the table in mm", many=False)
    z = as_number(z, "z", "a height in mm")
    slow = 1 / as_number(speed, "speed", "a share of the full speed, above 0 and at most 1", 1e-3, 1.0)
    high = max(as_number(above, "above", "a height in mm"), z + 16)
    over = np.array(kinematics.solve_ik([x, y, high, -pi / 2], start, geometry).q)
    way = float(np.abs(np.subtract(over, start)).max())
    first = joint_move(start, over, slow * max(0.6, TOP * way / (CAUTION * SPEED_CAP)), rate=40)
    down = line(over, [x, y, z, -pi / 2], slow * STRAIGHT_S, rate=40, geometry=geometry)
    return first, down, line(down.q[-1], [x, y, high, -pi / 2], slow * STRAIGHT_S, rate=40, geometry=geometry)


def _straight_way(start, pose, geometry, limits):
    """`start`, the pose there, and what leads from it to `pose`, arrays (4,); the pitch goes the short way round."""
    q0 = np.array(as_four(start, "start", JOINT_ANGLES))
    outside = limit_violations(q0, limits)
    if outside:
        raise JointLimit(outside, clipped(q0, limits), "the line starts outside the limits")
    first = np.array(kinematics.pose(q0, geometry))
    way = np.array(as_four(pose, "pose", TASK_POSE)) - first
    way[3] = wrap(way[3])
    return q0, first, way


def solve_along(poses, start, geometry: Geometry, limits, shares, look=lambda i, here: None) -> np.ndarray:
    """Joint angles (N, 4) for `poses` in their order, each on the branch of the one before, the first on `start`'s.

    Raises `PathBlocked` where that ends, or where `look(i, q)` raises what it has against the joint angles of pose i.
    `shares` (N,) says how much of the way is done at each pose.
    """
    q = np.empty((len(poses), 4))
    for i, wanted in enumerate(poses):
        last = q[i - 1] if i else start
        try:
            q[i] = _next(wanted, last, geometry, limits)
            look(i, q[i])
        except OmxError as reason:
            reached = kinematics.pose(last, geometry)
            raise PathBlocked(float(shares[max(i - 1, 0)]), reached, last, reason) from reason
    return q


def _next(wanted, last, geometry, limits):
    """The joint angles for the next sample, whole turns added where the limits allow what is nearer to the last."""
    solution = np.array(kinematics.solve_ik(wanted, last, geometry, limits))
    turned = solution + tau * np.round((last - solution) / tau)
    low, high = np.transpose(limits)
    solution = np.where((low <= turned) & (turned <= high), turned, solution)
    jumps = np.abs(solution - last)
    worst = int(jumps.argmax())
    if jumps[worst] > 0.5:
        name, jump = f"q{worst + 1}", np.degrees(jumps[worst])
        if abs(wrap(solution[worst] - last[worst])) < 0.5:
            raise OmxError(f"{name} is at its limit, and would have to turn {jump:.0f} deg back to go on.")
        raise OmxError(f"the arm would have to change its branch: a joint would jump by {jump:.0f} deg.")
    return solution


def _joint_velocity(q, task_velocity, geometry, max_speed):
    size = geometry.L2 * geometry.L3 * (geometry.L2 + geometry.L3 + geometry.L4)
    if manipulability(q, geometry) < NEAR_SINGULAR * size:
        raise OmxError("the arm is singular there: some direction cannot be followed at any joint speed.")
    qd = joint_velocity(q, task_velocity, geometry=geometry)
    fastest = int(np.abs(qd).argmax())
    if abs(qd[fastest]) > max_speed:
        raise OmxError(
            f"joint q{fastest + 1} would have to turn at {np.degrees(abs(qd[fastest])):.1f} deg/s, above "
            f"{np.degrees(max_speed):.1f} deg/s; take more seconds."
        )
    return qd


def _timeline(seconds: float, scaling: Scaling, rate: float):
    """`seconds` as a float, the times of the samples, both ends among them, and what the scaling makes of them."""
    seconds = as_number(seconds, "seconds", f"a number of seconds, {TINY:g} or more", TINY)
    rate = as_number(rate, "rate", f"a number of samples a second, {TINY:g} or more", TINY)
    if seconds * rate > MOST_SAMPLES:
        raise BadInput(f"`seconds` times `rate` must be at most {MOST_SAMPLES:.0e} samples; got {seconds * rate:.1e}.")
    t = np.linspace(0.0, seconds, max(2, ceil(seconds * rate) + 1))
    wanted = "`scaling` must turn times u in [0, 1] into (s, ds/du, d2s/du2), as `quintic` and `trapezoid(0.25)` do"
    if scaling is trapezoid:
        raise BadInput(f"{wanted}; `trapezoid` itself must be called first: write `trapezoid()`.")
    try:
        s, ds, dds = (np.asarray(part, dtype=float) for part in scaling(t / seconds))
    except (TypeError, ValueError) as error:
        raise BadInput(f"{wanted}; {shown(scaling)} does not.") from error
    if not s.shape == ds.shape == dds.shape == t.shape:
        raise BadInput(f"{wanted}; {shown(scaling)} gives other shapes.")
    return seconds, t, (s, ds, dds)
