"""A way without times: where a motion goes, and how it bends there. `time_optimal` says when.

The parameter s grows along the way; what it measures is the path's own affair: rad for a spline of joints, mm for a way
of the tool.
"""

from dataclasses import dataclass

import numpy as np

from ..arm import LIMITS
from ..arrays import as_count, as_four, as_number, as_rows
from ..dh import as_limits
from ..errors import BadInput
from ..geometry import COURSE, Geometry, as_geometry
from ..kinematics import JOINT_ANGLES, TASK_POSE, solve_ik
from .differential_ik import damped, task_jacobian
from .trajectory import TINY, cubic, solve_along


@dataclass(frozen=True)
class Path:
    """Places on a way: `s` (N,) grows; `q` (N, 4) with its first and second derivative by s, `dq` and `ddq`.

    The columns are the joints (rad) or, for a way of the tool, x, y, z (mm) and pitch (rad).
    """

    s: np.ndarray
    q: np.ndarray
    dq: np.ndarray
    ddq: np.ndarray


def spline_path(waypoints, samples: int = 500) -> Path:
    """The joints through `waypoints` (N, 4) rad without a stop and without a kink: a cubic spline, free at its ends.

    s is the way in joint space from waypoint to waypoint (rad). Raises `BadInput`.
    """
    q = as_rows(waypoints, "waypoints", 4, JOINT_ANGLES)
    ways = _legs(q, "waypoints")
    knots = np.concatenate([[0.0], np.cumsum(np.linalg.norm(ways, axis=1))])
    s = np.linspace(0.0, knots[-1], as_count(samples, "samples", 3, 100_000))
    return Path(s, *_spline(knots, q, s))


def _spline(knots, points, at) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The cubic spline through `points` (N, n) at the growing `knots` (N,): value, slope and curvature where `at` says.

    At both ends its curvature is zero. The slopes at the knots are what makes the curvatures of two legs agree.
    """
    h, q = np.diff(knots), np.asarray(points, float)
    slopes = np.diff(q, axis=0) / h[:, None]
    A, b = np.zeros((len(q), len(q))), np.zeros_like(q)
    A[0, :2], A[-1, -2:] = (2, 1), (1, 2)
    b[0], b[-1] = 3 * slopes[0], 3 * slopes[-1]
    for i in range(1, len(q) - 1):
        A[i, i - 1 : i + 2] = h[i], 2 * (h[i - 1] + h[i]), h[i - 1]
        b[i] = 3 * (h[i] * slopes[i - 1] + h[i - 1] * slopes[i])
    v = np.linalg.solve(A, b)
    leg = np.clip(np.searchsorted(knots, at, side="right") - 1, 0, len(h) - 1)
    u, width = (at - knots[leg])[:, None], h[leg][:, None]
    c2 = (3 * slopes[leg] - 2 * v[leg] - v[leg + 1]) / width
    c3 = (v[leg] + v[leg + 1] - 2 * slopes[leg]) / width**2
    return q[leg] + u * (v[leg] + u * (c2 + u * c3)), v[leg] + u * (2 * c2 + 3 * c3 * u), 2 * c2 + 6 * c3 * u


def rounded(corners, error: float, samples: int = 500) -> Path:
    """Straight lines of the tool through `corners` (N, 4), each corner but the ends cut by `error` (mm) at most.

    Before a corner, and after it, the tool leaves the lines; between, its direction turns from the one to the other as
    `cubic` goes from 0 to 1, so the way has no kink and its bend no jump. Where legs are short, the corners are cut
    less. s is the way along the lines (mm); the pitch turns evenly on each. Raises `BadInput`.
    """
    corners = as_rows(corners, "corners", 4, TASK_POSE)
    ways = _legs(corners, "corners")
    error = as_number(error, "error", f"a distance of {TINY:g} mm or more", TINY)
    lengths = np.linalg.norm(ways[:, :3], axis=1)
    if not lengths.min() > TINY:
        raise BadInput("`corners`: two that follow each other are one place; the tool must move from each to the next.")
    directions = ways / lengths[:, None]
    turns = np.diff(directions, axis=0)
    bends = np.maximum(np.linalg.norm(turns[:, :3], axis=1), TINY)
    halves = np.minimum(16 / 3 * error / bends, np.minimum(lengths[:-1], lengths[1:]) / 2)
    places = np.cumsum(lengths)
    s = np.linspace(0.0, places[-1], as_count(samples, "samples", 3, 100_000))
    share = np.maximum((s[:, None] - places[:-1] + halves) / (2 * halves), 0.0)  # how much of each corner is done
    within = np.minimum(share, 1.0)
    turned, bending, _ = cubic(within)
    gone = within**3 - within**4 / 2 + share - within  # the integral of the cubic, and of 1 after it
    pose = corners[0] + np.outer(s, directions[0]) + (2 * halves * gone) @ turns
    return Path(s, pose, directions[0] + turned @ turns, (bending / (2 * halves)) @ turns)


def in_joints(way: Path, start, geometry: Geometry = COURSE, limits=LIMITS) -> Path:
    """A way of the tool as one of the joints (rad): from the legal solution nearest to `start` (rad), on its branch.

    With p' = J q' the chain rule gives p'' = J q'' + J' q'. Raises `Unreachable` or `JointLimit` where there is no
    solution to begin with, `PathBlocked` where its branch ends, `BadInput`.
    """
    if not isinstance(way, Path):
        raise BadInput("`way` must be a Path of the tool, such as `rounded(...)` gives.")
    geometry, limits = as_geometry(geometry), limits if limits is LIMITS else as_limits(limits, 4)
    first = solve_ik(way.q[0], as_four(start, "start", JOINT_ANGLES), geometry, limits)
    q = solve_along(way.q, np.array(first), geometry, limits, way.s / way.s[-1])
    J = task_jacobian(q, geometry)
    dq = damped(J, way.dq)
    h = 1e-5 / np.abs(dq).max()
    dJ = (task_jacobian(q + h * dq, geometry) - task_jacobian(q - h * dq, geometry)) / (2 * h)
    return Path(way.s, q, dq, damped(J, way.ddq - (dJ @ dq[..., None])[..., 0]))


def _legs(points, name: str) -> np.ndarray:
    """What leads from each point to the next, (N - 1, 4); `BadInput` for fewer than two, or two that are the same."""
    if points.ndim != 2 or len(points) < 2:
        raise BadInput(f"`{name}` must be at least two, shape (N, 4); got {points.shape}.")
    ways = np.diff(points, axis=0)
    if not np.abs(ways).max(axis=1).min() > TINY:
        raise BadInput(f"`{name}`: two that follow each other are the same.")
    return ways
