"""Which configurations keep clear of the table and of the arm itself: `omx.safety`'s capsules, many at a time."""

import numpy as np

from ..arrays import as_rows, in_blocks
from ..generated import fk as _fk
from ..geometry import COURSE, Geometry
from ..kinematics import JOINT_ANGLES
from ..safety import PAIRS, parts


def clearance(q, geometry: Geometry = COURSE, table: float | None = 0.0) -> np.ndarray:
    """The smallest gap (mm, negative where parts overlap) of each arm in `q` (..., 4), rad: an array (...,).

    `table`: its height (mm) in the base frame; None leaves the table out. As `omx.safety.Guard.clearance` finds it
    for one arm. Raises `BadInput`.
    """
    q = as_rows(q, "q", 4, JOINT_ANGLES)
    rows = q.reshape(-1, 4)
    gaps = np.empty(len(rows))
    for block, columns in in_blocks(rows):
        gaps[block] = _smallest_gap(columns, geometry, table)
    return gaps.reshape(q.shape[:-1])


def clear(q, geometry: Geometry = COURSE, table: float | None = 0.0) -> np.ndarray:
    """Which arms in `q` (..., 4), rad, touch neither the table nor themselves: booleans (...,)."""
    return clearance(q, geometry, table) >= 0.0


def _smallest_gap(columns, geometry: Geometry, table: float | None) -> np.ndarray:
    capsules = parts(_fk.frames_batch(*columns, *geometry.values), geometry)
    gap = np.full(columns.shape[1], np.inf)
    for i, j in PAIRS:
        one, other = capsules[i], capsules[j]
        np.minimum(gap, _distance(one, other) - one.radius - other.radius, out=gap)
    if table is not None:
        for part in capsules[3:]:
            np.minimum(gap, np.minimum(part.a[2], part.b[2]) - part.radius - table, out=gap)
    return gap


def _distance(one, other) -> np.ndarray:
    """The shortest distance (mm) between the axes of two capsules, column by column, as `safety.distance` does."""
    u, v, w = _between(one.a, one.b), _between(other.a, other.b), _between(other.a, one.a)
    a, b, c, d, e = _dot(u, u), _dot(u, v), _dot(v, v), _dot(u, w), _dot(v, w)
    denominator = a * c - b * b
    slanted = denominator > 1e-9 * a * c
    s = np.where(slanted, np.clip((b * e - c * d) / np.where(slanted, denominator, 1.0), 0.0, 1.0), 0.0)
    t = np.clip((b * s + e) / c, 0.0, 1.0)
    s = np.clip((b * t - d) / a, 0.0, 1.0)
    gap = [w[i] + s * u[i] - t * v[i] for i in range(3)]
    return np.sqrt(_dot(gap, gap))


def _between(p, q) -> list:
    return [b - a for a, b in zip(p, q, strict=True)]


def _dot(p, q):
    return p[0] * q[0] + p[1] * q[1] + p[2] * q[2]
