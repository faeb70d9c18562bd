"""Can the tip get to a point of the arm's plane, with any pitch at all? Decided exactly, without trying pitches.

The joint angles that put the tip on a point form curves in the box of limits. Each curve either ends on a face of
the box, where a joint is at a limit, or is closed; and where q2 is largest on a closed one, hand and forearm are in
line. So it is enough to hold one joint at a time, at a limit or with the hand in line, and solve for the other two.
"""

from math import atan2, cos, hypot, pi, sin

import numpy as np

from ...arm import LIMITS
from ...arrays import as_rows, in_blocks, wrap
from ...geometry import COURSE, Geometry, as_geometry
from .arcs import finite_limits, in_line

#: Joint angles may exceed a limit by this much (rad), and the cosine of a bend may exceed 1: rounding.
SLACK, REACH_SLACK = 1e-11, 1e-13


def reaches(points, geometry: Geometry = COURSE, limits=LIMITS) -> np.ndarray:
    """Which of the points (..., 2), r and z in mm, the tip reaches with q1 = 0: booleans (...,).

    r < 0 is over the arm's back. All joint limits but those of q1 count. Raises `BadInput`.
    """
    points = as_rows(points, "points", 2, "r and z in mm")
    geometry, limits = as_geometry(geometry), finite_limits(limits)
    flat = points.reshape(-1, 2)
    found = np.zeros(len(flat), dtype=bool)
    for rows, (r, z) in in_blocks(flat):
        for q in _candidates(r, z - geometry.L1, geometry, limits):
            found[rows] |= _within(q, limits)
    return found.reshape(points.shape[:-1])


def _candidates(r, z, geometry: Geometry, limits):
    """(q2, q3, q4) for each held joint and each bend of the other two; NaN out of reach. z is above the shoulder."""
    L2, L3, L4, upright = geometry.L2, geometry.L3, geometry.L4, 0.5 * pi - geometry.delta
    for q2 in limits[1]:
        upper = upright - q2
        for forearm, bend in _two_links(r - L2 * cos(upper), z - L2 * sin(upper), L3, L4):
            yield q2, -forearm - q2, -bend
    for q3 in limits[2]:
        span, turn = _rigid(L2, L3, -q3 - upright)
        for line, bend in _two_links(r, z, span, L4):
            q2 = upright - (line - turn)
            yield q2, q3, -(line + bend) - q2 - q3
    for q4 in (*limits[3], *in_line(geometry, limits)[1]):
        span, turn = _rigid(L3, L4, -q4)
        for upper, bend in _two_links(r, z, L2, span):
            q2 = upright - upper
            yield q2, -(upper + bend - turn) - q2, q4


def _rigid(first: float, second: float, bend: float) -> tuple[float, float]:
    """Two links that do not move against each other as one: its length (mm) and how far it leans from the first."""
    along, across = first + second * cos(bend), second * sin(bend)
    return hypot(along, across), atan2(across, along)


def _two_links(r, z, first: float, second: float):
    """Direction of the first link and bend to the second, for tip (r, z) from their base: both bends."""
    D = (r * r + z * z - first * first - second * second) / (2.0 * first * second)
    s = np.sqrt(np.maximum(0.0, (1.0 - D) * (1.0 + D)))
    s[np.abs(D) > 1.0 + REACH_SLACK] = np.nan
    towards, lean, bend = np.arctan2(z, r), np.arctan2(second * s, first + second * D), np.arctan2(s, D)
    return (towards - lean, bend), (towards + lean, -bend)


def _within(q, limits):
    """Where all three joints are inside their limits, whole turns not counted."""
    inside = True
    for angle, (low, high) in zip(q, limits[1:], strict=True):
        if np.ndim(angle):
            inside = inside & (np.abs(wrap(angle - 0.5 * (low + high))) <= 0.5 * (high - low) + SLACK)
    return inside
