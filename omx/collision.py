"""How near the arm comes to the table and to itself, for one arm or many: capsules around its frames, in mm.

A capsule is every point within a radius of a segment. Sizes are from the maker's drawings.
"""

from math import cos, sin
from typing import NamedTuple

import numpy as np

from .arrays import as_number, as_rows, in_blocks
from .generated import fk as _fk
from .geometry import COURSE, Geometry, as_geometry

#: Which capsules can meet: the base and the parts beyond the elbow, the upper arm and the hand.
PAIRS = ((0, 3), (0, 4), (0, 5), (1, 4), (1, 5), (2, 5))
#: Which of them can meet the table.
OVER_THE_TABLE = (3, 4, 5)
#: What the hand carries, a ball about the tool, comes after them: it can meet the base, the upper arm and the table.
LOAD = 6


class Capsule(NamedTuple):
    """One part of the arm: all points within `radius` (mm) of the segment from `a` to `b` (mm, base frame)."""

    name: str
    a: tuple
    b: tuple
    radius: float


def capsules(q, geometry: Geometry = COURSE, load: float = 0.0) -> tuple[Capsule, ...]:
    """The arm at `q` (four numbers or columns, rad): base, upper arm, elbow, forearm, hand, fingers.

    Then, if it carries something that reaches `load` mm from the tool, that.
    """
    T1, T2, T3, T4 = (_fk.frames_batch if isinstance(q, np.ndarray) else _fk.frames)(*q, *geometry.values)
    shoulder, elbow, wrist, tool = ((T[0][3], T[1][3], T[2][3]) for T in (T1, T2, T3, T4))
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
        *([Capsule("load", tool, tool, load)] if load else []),
    )


def gaps(
    q, geometry: Geometry = COURSE, table: float | None = 0.0, load: float = 0.0
) -> tuple[list[tuple[str, str]], np.ndarray]:
    """The pairs of parts that can meet, by name, and the gap (mm, negative where they overlap) of each: (pairs, N).

    `q` (N, 4) in rad. `table`: its height (mm) in the base frame; None leaves the table out. `load`: how far (mm) what
    the hand carries reaches from the tool.
    """
    parts = capsules(np.ascontiguousarray(np.transpose(q)), geometry, load)
    meeting = (*PAIRS, (0, LOAD), (1, LOAD)) if load else PAIRS
    pairs = [(parts[i].name, parts[j].name) for i, j in meeting]
    found = [distance(parts[i], parts[j]) - parts[i].radius - parts[j].radius for i, j in meeting]
    if table is not None:
        over = [parts[i] for i in (OVER_THE_TABLE if not load else (*OVER_THE_TABLE, LOAD))]
        pairs += [(part.name, "table") for part in over]
        found += [np.minimum(part.a[2], part.b[2]) - part.radius - table for part in over]
    return pairs, np.array(np.broadcast_arrays(*found))


def clearance(q, geometry: Geometry = COURSE, table: float | None = 0.0) -> np.ndarray:
    """The smallest gap (mm, negative where parts overlap) of each arm in `q` (..., 4), rad: an array (...,).

    `table`: its height (mm) in the base frame; None leaves the table out. Raises `BadInput`.
    """
    q, geometry = as_rows(q, "q", 4, "the four joint angles in rad"), as_geometry(geometry)
    table = None if table is None else as_number(table, "table", "its height in mm, or None")
    rows = q.reshape(-1, 4)
    smallest = np.empty(len(rows))
    for block, columns in in_blocks(rows):
        smallest[block] = gaps(columns.T, geometry, table)[1].min(axis=0)
    return smallest.reshape(q.shape[:-1])


def clear(q, geometry: Geometry = COURSE, table: float | None = 0.0) -> np.ndarray:
    """Which arms in `q` (..., 4), rad, touch neither the table nor themselves: booleans (...,)."""
    return clearance(q, geometry, table) >= 0.0


def distance(one: Capsule, other: Capsule) -> np.ndarray:
    """The shortest distance (mm) between the axes of two capsules, column by column."""
    u, v, w = _between(one.a, one.b), _between(other.a, other.b), _between(other.a, one.a)
    a, b, c, d, e = _dot(u, u), _dot(u, v), _dot(v, v), _dot(u, w), _dot(v, w)
    denominator = a * c - b * b
    slanted = denominator > 1e-9 * a * c
    s = np.where(slanted, np.clip((b * e - c * d) / np.where(slanted, denominator, 1.0), 0.0, 1.0), 0.0)
    t = np.clip(np.divide(b * s + e, c, out=np.zeros(np.broadcast(s, c).shape), where=np.asarray(c) > 0), 0.0, 1.0)
    s = np.clip(np.divide(b * t - d, a, out=np.zeros(np.broadcast(t, a).shape), where=np.asarray(a) > 0), 0.0, 1.0)
    gap = [w[i] + s * u[i] - t * v[i] for i in range(3)]
    return np.sqrt(_dot(gap, gap))


def _along(point, direction, length: float) -> tuple:
    return tuple(p + length * d for p, d in zip(point, direction, strict=True))


def _between(p, q) -> list:
    return [b - a for a, b in zip(p, q, strict=True)]


def _dot(p, q):
    return p[0] * q[0] + p[1] * q[1] + p[2] * q[2]
