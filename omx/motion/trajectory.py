"""From here to there in time: scalings, joint-space moves, and straight lines of the tool.

A scaling turns normalised time u in [0, 1] into progress s in [0, 1] with its first two derivatives by u. A
`Trajectory` is sampled: times (s), joint angles, velocities and accelerations (rad, rad/s, rad/s^2).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import ceil

import numpy as np

from ..arm import LIMITS
from ..arrays import as_rows
from ..errors import BadInput, OmxError, PathBlocked
from ..geometry import COURSE, Geometry
from ..kinematics import pose, solve_ik
from .differential_ik import joint_velocity, manipulability

Scaling = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray, np.ndarray]]

#: A smaller |det| of the task Jacobian than this, relative to its size a long way from singularities, is singular.
NEAR_SINGULAR = 1e-3


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
        return pose(self.q, geometry)

    def at(self, seconds: float) -> np.ndarray:
        """Joint angles (4,) at a time between the samples; the ends hold before and after."""
        return np.array([np.interp(seconds, self.t, column) for column in self.q.T])

    def then(self, other: "Trajectory") -> "Trajectory":
        """This motion and then the other, which must begin where this one ends."""
        gap = np.abs(self.q[-1] - other.q[0]).max()
        if gap > 1e-6:
            raise BadInput(f"`other` must begin where this trajectory ends; a joint would jump by {gap:.6f} rad.")
        t = np.concatenate([self.t, other.t[1:] + self.t[-1]])
        parts = ((self.q, other.q), (self.qd, other.qd), (self.qdd, other.qdd))
        return Trajectory(t, *(np.concatenate([a, b[1:]]) for a, b in parts))


def cubic(u):
    """3u^2 - 2u^3: starts and ends at rest, with a jump of the acceleration at both ends."""
    u = np.asarray(u, dtype=float)
    return u * u * (3 - 2 * u), 6 * u * (1 - u), 6 - 12 * u


def quintic(u):
    """10u^3 - 15u^4 + 6u^5: starts and ends at rest and without acceleration."""
    u = np.asarray(u, dtype=float)
    return u**3 * (10 - 15 * u + 6 * u * u), 30 * (u * (1 - u)) ** 2, 60 * u * (1 - u) * (1 - 2 * u)


def trapezoid(ramp: float = 0.25) -> Scaling:
    """Constant acceleration for `ramp` of the time, constant speed, and the same ramp down: a servo's profile."""
    if not 0 < ramp <= 0.5:
        raise BadInput(f"`ramp` must be a share of the time in (0, 0.5]; got {ramp}.")
    speed = 1 / (1 - ramp)

    def scaling(u):
        u = np.asarray(u, dtype=float)
        rising, falling = u < ramp, u > 1 - ramp
        s = np.where(rising, speed * u * u / (2 * ramp), speed * (u - ramp / 2))
        s = np.where(falling, 1 - speed * (1 - u) ** 2 / (2 * ramp), s)
        ds = speed * np.minimum(1.0, np.minimum(u, 1 - u) / ramp)
        return s, ds, speed / ramp * (rising.astype(float) - falling)

    return scaling


def joint_move(q0, q1, seconds: float, scaling: Scaling = quintic, rate: float = 100.0) -> Trajectory:
    """All joints from `q0` to `q1` (rad) together, along a straight line in joint space; `rate` samples a second."""
    q0, q1 = _angles(q0, "q0"), _angles(q1, "q1")
    t, (s, ds, dds) = _timeline(seconds, scaling, rate)
    way = q1 - q0
    return Trajectory(t, q0 + np.outer(s, way), np.outer(ds, way) / seconds, np.outer(dds, way) / (seconds * seconds))


def joint_path(waypoints, seconds: float | Sequence[float], scaling: Scaling = quintic, rate: float = 100.0):
    """Through `waypoints` (N, 4) rad in turn, resting at each; `seconds` for each leg, or one number for all."""
    q = as_rows(waypoints, "waypoints", 4, "joint angles in rad")
    if q.ndim != 2 or len(q) < 2:
        raise BadInput(f"`waypoints` must be at least two configurations, shape (N, 4); got {q.shape}.")
    legs = np.broadcast_to(np.asarray(seconds, dtype=float), (len(q) - 1,))
    path = joint_move(q[0], q[1], legs[0], scaling, rate)
    for start, end, duration in zip(q[1:-1], q[2:], legs[1:], strict=True):
        path = path.then(joint_move(start, end, duration, scaling, rate))
    return path


def joint_spline(waypoints, seconds: float | Sequence[float], rate: float = 100.0) -> Trajectory:
    """Through `waypoints` (N, 4) rad without stopping, at rest at both ends; `seconds` as for `joint_path`.

    A clamped cubic spline: on each leg a cubic, and where two meet position, velocity and acceleration agree. The
    velocities at the waypoints solve that. Between two waypoints it may swing a little beyond them.
    """
    q = as_rows(waypoints, "waypoints", 4, "joint angles in rad")
    if q.ndim != 2 or len(q) < 2:
        raise BadInput(f"`waypoints` must be at least two configurations, shape (N, 4); got {q.shape}.")
    h = np.broadcast_to(np.asarray(seconds, dtype=float), (len(q) - 1,))
    if not (np.isfinite(h).all() and (h > 0).all() and np.isfinite(rate) and rate > 0):
        raise BadInput(f"`seconds` and `rate` must be positive numbers; got {seconds} and {rate}.")
    slopes = np.diff(q, axis=0) / h[:, None]
    A, b = np.eye(len(q)), np.zeros_like(q)
    for i in range(1, len(q) - 1):
        A[i, i - 1 : i + 2] = h[i], 2 * (h[i - 1] + h[i]), h[i - 1]
        b[i] = 3 * (h[i] * slopes[i - 1] + h[i - 1] * slopes[i])
    v = np.linalg.solve(A, b)
    knots = np.concatenate([[0.0], np.cumsum(h)])
    t = np.linspace(0.0, knots[-1], max(2, ceil(knots[-1] * rate) + 1))
    leg = np.clip(np.searchsorted(knots, t, side="right") - 1, 0, len(h) - 1)
    u, width = (t - knots[leg])[:, None], h[leg][:, None]
    c2 = (3 * slopes[leg] - 2 * v[leg] - v[leg + 1]) / width
    c3 = (v[leg] + v[leg + 1] - 2 * slopes[leg]) / width**2
    return Trajectory(
        t, q[leg] + u * (v[leg] + u * (c2 + u * c3)), v[leg] + u * (2 * c2 + 3 * c3 * u), 2 * c2 + 6 * c3 * u
    )


def line(
    q0,
    target,
    seconds: float,
    scaling: Scaling = quintic,
    rate: float = 100.0,
    geometry: Geometry = COURSE,
    limits=LIMITS,
    max_speed: float = np.inf,
) -> Trajectory:
    """The tool on a straight line from where it is at `q0` (rad) to the pose `target` [x, y, z, pitch] (mm, rad).

    Each sample is solved by the inverse, staying on the branch of the sample before; joint velocities come from
    the Jacobian. Raises `PathBlocked` where the line leaves the reach or a joint its limits, where the arm is
    singular, or where a joint would be faster than `max_speed` (rad/s).
    """
    q0 = _angles(q0, "q0")
    start = np.array(pose(q0, geometry))
    way = np.asarray(_angles(target, "target")) - start
    t, (s, ds, _) = _timeline(seconds, scaling, rate)
    poses = start + np.outer(s, way)
    q, qd = np.empty_like(poses), np.empty_like(poses)
    for i, wanted in enumerate(poses):
        last = q[i - 1] if i else q0
        try:
            q[i] = _next(wanted, last, geometry, limits)
            qd[i] = _joint_velocity(q[i], way * ds[i] / seconds, geometry, max_speed)
        except OmxError as reason:
            raise PathBlocked(float(s[max(i - 1, 0)]), pose(last, geometry), last, reason) from reason
    qdd = np.gradient(qd, t, axis=0, edge_order=2) if len(t) > 2 else np.zeros_like(qd)
    return Trajectory(t, q, qd, qdd)


def _next(wanted, last, geometry, limits):
    solution = np.array(solve_ik(wanted, last, geometry, limits))
    jump = np.abs(solution - last).max()
    if jump > 0.5:
        raise OmxError(f"the arm would have to change its branch: a joint would jump by {np.degrees(jump):.0f} deg.")
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
    if not (np.isfinite(seconds) and seconds > 0 and rate > 0):
        raise BadInput(f"`seconds` and `rate` must be positive numbers; got {seconds} and {rate}.")
    t = np.linspace(0.0, seconds, max(2, ceil(seconds * rate) + 1))
    return t, scaling(t / seconds)


def _angles(value, name: str) -> np.ndarray:
    row = as_rows(value, name, 4, "four numbers (rad; mm for x, y, z)")
    if row.ndim != 1:
        raise BadInput(f"`{name}` must be four numbers; got shape {row.shape}.")
    return row
