"""Big batches in machine code, where numba is installed: the generated formulas themselves, compiled.

`pose` and `ik_batch` take and return what their namesakes in `omx` do. Without numba, or for numbers beyond `RANGE`,
they call these. The compiled formulas use the polynomials that chapter 11 wrote for sine, cosine and arc tangent,
which the processor evaluates for several rows at once; results differ from NumPy's by rounding only (1e-12 mm).
The first call compiles, which takes some seconds.
"""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from importlib.util import find_spec
from math import nan, pi, tan, tau
from os import cpu_count
from types import FunctionType
from typing import NamedTuple

import numpy as np

from .. import kinematics
from ..arm import LIMITS
from ..arrays import as_rows
from ..errors import BadInput
from ..generated import fk as _fk
from ..generated import ik as _ik
from ..generated import polynomials as _polynomials
from ..geometry import COURSE, Geometry

#: The largest angle (rad) and length (mm) that the compiled formulas take: beyond, digits or squares are lost.
RANGE = (64.0, 1e9)

#: Fewer rows than this are not worth a second thread.
THREADED = 100_000

#: Rows in one round of a compiled loop: few enough that the columns in work stay in the processor's nearest cache.
ROUND = 256

#: Rows whose results are copied out together: 16 columns are written in turn, and memory likes long runs.
RUN = 8 * ROUND

#: From one column of the work space to the next. A constant: so the compiler sees that columns do not overlap.
#: An odd number of rounds: columns that lie a power of two apart would share few lines of the cache.
PITCH = RUN + ROUND


class Loops(NamedTuple):
    """The compiled loops over rows `start` .. `stop`; each returns whether every row was in `RANGE`."""

    pose: Callable[..., bool]
    ik: Callable[..., bool]


def available() -> bool:
    """Is numba installed?"""
    return find_spec("numba") is not None


def pose(q, geometry: Geometry = COURSE, *, threads: int | None = None, dtype=np.float64) -> np.ndarray:
    """x, y, z (mm) and pitch (rad), (..., 4), for joint angles `q` (..., 4), rad: as `omx.pose`.

    `threads`: how many; as many as the machine has, for big batches, if left out. `dtype`: of the result. With
    float32 in `q` and here, half as much memory is moved, and the position errs by up to 1e-4 mm, 2000 times less
    than the arm repeats; the arithmetic is in float64 all the same. Raises `BadInput`.
    """
    q = _rows(q, "q", kinematics.JOINT_ANGLES)
    rows = q.reshape(-1, 4)
    out = np.empty(rows.shape, _float(dtype))
    if not available() or not _run(_loops().pose, threads, rows, out, geometry.values):
        out = np.asarray(kinematics.pose(rows, geometry), dtype)
    return out.reshape(q.shape)


def ik_batch(poses, geometry: Geometry = COURSE, limits=LIMITS, *, threads: int | None = None, dtype=np.float64):
    """All four branches of many poses (N, 4): q (N, 4, 4), reachable (N, 4), legal (N, 4), as `omx.ik_batch`.

    `threads`, `dtype` and errors as in `pose`; in float32 each angle is off by up to 2e-7 rad.
    """
    poses = _rows(poses, "poses", kinematics.TASK_POSE)
    if poses.ndim != 2:
        raise BadInput(f"`poses` must have shape (N, 4); got {poses.shape}. For one pose use `omx.ik`.")
    q = np.empty((4, 4, len(poses)), _float(dtype))
    reachable, legal = (np.empty((4, len(poses)), dtype=bool) for _ in range(2))
    ends = tuple(end for low, high in limits for end in (low - kinematics.LIMIT_SLACK, high + kinematics.LIMIT_SLACK))
    if available() and _run(_loops().ik, threads, poses, q, reachable, legal, geometry.values, ends):
        return q.transpose(2, 0, 1), reachable.T, legal.T
    angles, *verdicts = kinematics.ik_batch(poses, geometry, limits)
    return angles.astype(dtype, copy=False), *verdicts


def _rows(value, name: str, wanted: str) -> np.ndarray:
    """`value` as float32 or float64 rows of four; the compiled loop finds what is not finite."""
    plain = isinstance(value, np.ndarray) and value.dtype in (np.float32, np.float64)
    if plain and value.ndim > 1 and value.shape[-1] == 4 and value.size:
        return np.ascontiguousarray(value)
    return as_rows(value, name, 4, wanted)


def _float(dtype):
    if np.dtype(dtype) not in (np.float32, np.float64):
        raise BadInput(f"`dtype` must be float64 or float32; got {dtype!r}.")
    return dtype


def _run(loop: Callable[..., bool], threads: int | None, rows: np.ndarray, *arguments) -> bool:
    """`loop` over all rows, shared out among threads; False if some row is out of its range."""
    if threads is None:
        threads = (cpu_count() or 1) if len(rows) >= THREADED else 1
    if threads < 1:
        raise BadInput(f"`threads` must be at least 1; got {threads}.")
    borders = np.linspace(0, len(rows), threads + 1).astype(int).tolist()
    if threads == 1:
        return loop(0, len(rows), rows, *arguments)
    with ThreadPoolExecutor(threads) as pool:
        return all(pool.map(lambda start, stop: loop(start, stop, rows, *arguments), borders[:-1], borders[1:]))


def _compile(function: Callable, **options) -> Callable:
    import numba

    return numba.njit(nogil=True, error_model="numpy", fastmath={"contract", "nsz"}, **options)(function)


def _inline(function: Callable, **names) -> Callable:
    """The function compiled into whatever calls it, with `names` in place of its own globals."""
    names = function.__globals__ | names
    return _compile(FunctionType(function.__code__, names, function.__name__), forceinline=True)


@cache
def _functions() -> dict[str, Callable]:
    """What the generated code calls, from the polynomials: no branches, so that it runs for several rows at once."""
    sine, cosine, arc_tangent = map(_inline, (_polynomials.sine, _polynomials.cosine, _polynomials.arc_tangent))
    rest_of_pi, eighth = 1.2246467991473532e-16, tan(pi / 8)  # pi less its float

    def sin(x):
        turns = np.rint(x * (1.0 / pi))
        return sine((x - turns * pi) - turns * rest_of_pi) * (1.0 - 2.0 * abs(turns - 2.0 * np.rint(0.5 * turns)))

    def cos(x):
        turns = np.rint(x * (1.0 / pi))
        return cosine((x - turns * pi) - turns * rest_of_pi) * (1.0 - 2.0 * abs(turns - 2.0 * np.rint(0.5 * turns)))

    def atan2(y, x):
        steep = abs(y) > abs(x)
        short, long = (abs(x), abs(y)) if steep else (abs(y), abs(x))
        wide = short > eighth * long
        above, below = (short - long, short + long) if wide else (short, long if long > 0.0 else 1.0)
        angle = arc_tangent(above / below) + (0.25 * pi if wide else 0.0)
        angle = 0.5 * pi - angle if steep else angle
        angle = pi - angle if x < 0.0 else angle
        return -angle if y < 0.0 else angle

    def remainder(x, turn):  # as `wrap` in arrays.py, but products fused with sums can round to more than half a turn
        turns = x * (1.0 / turn)
        angle = (turns - np.ceil(turns - 0.5)) * turn
        return pi if angle > pi else angle

    def max(a, b):
        return a if a > b else b

    return {f.__name__: _compile(f, forceinline=True) for f in (sin, cos, atan2, remainder, max)}


@cache
def _loops() -> Loops:
    """Compiled when first called. Rows are copied to columns, worked on, and copied to where they belong."""
    forward, branches = (_inline(f, **_functions()) for f in (_fk.pose, _ik.branches))
    load, copy, inside = _compile(_load), _compile(_copy), _inline(_inside)
    wrap, angle, length = _functions()["remainder"], *RANGE
    within = 1.0 + kinematics.REACH_SLACK

    @_compile
    def columns_pose(w, lengths):
        for i in range(ROUND):
            x, y, z, pitch = forward(w[i], w[PITCH + i], w[2 * PITCH + i], w[3 * PITCH + i], *lengths)
            w[4 * PITCH + i], w[5 * PITCH + i], w[6 * PITCH + i], w[7 * PITCH + i] = x, y, z, pitch

    @_compile
    def columns_ik(w, marks, lengths, ends):
        for i in range(ROUND):
            x, y, z, pitch = w[i] + 0.0, w[PITCH + i] + 0.0, w[2 * PITCH + i], wrap(w[3 * PITCH + i], tau)
            up, down, back_up, back_down, D, D_back = branches(x, y, z, pitch, *lengths)
            front, back = abs(D) <= within, abs(D_back) <= within
            marks[i], marks[PITCH + i] = front, back
            for b, (q, reached) in enumerate(((up, front), (down, front), (back_up, back), (back_down, back))):
                q1 = pi if q[0] == -pi else q[0]  # the arc tangent's range is closed at both ends
                blank = 0.0 if reached else nan
                w[(4 + 4 * b) * PITCH + i] = q1 + blank
                for j in range(1, 4):
                    w[(4 + 4 * b + j) * PITCH + i] = q[j] + blank
                marks[(2 + b) * PITCH + i] = reached & inside(q1, q[1], q[2], q[3], ends)

    @_compile
    def pose_loop(start, stop, rows, out, lengths):
        w, fine = np.zeros(8 * PITCH), True
        for first in range(start, stop, ROUND):
            part = slice(first, min(first + ROUND, stop))
            fine &= load(rows[part], w, angle, angle)
            columns_pose(w, lengths)
            results = out[part]
            for i in range(len(results)):
                for j in range(4):
                    results[i, j] = w[(4 + j) * PITCH + i]
        return fine

    @_compile
    def ik_loop(start, stop, rows, q, reachable, legal, lengths, ends):
        w, marks, fine = np.zeros(20 * PITCH), np.zeros(6 * PITCH, dtype=np.bool_), True
        for first in range(start, stop, RUN):
            part = slice(first, min(first + RUN, stop))
            fine &= load(rows[part], w, length, angle)
            for k in range(0, part.stop - first, ROUND):
                columns_ik(w[k:], marks[k:], lengths, ends)
            for b in range(4):
                for j in range(4):
                    copy(w[(4 + 4 * b + j) * PITCH :], q[b, j, part])
                copy(marks[b // 2 * PITCH :], reachable[b, part])
                copy(marks[(2 + b) * PITCH :], legal[b, part])
        return fine

    return Loops(pose_loop, ik_loop)


def _load(rows, w, largest, largest_last):
    """Copy rows to the first four columns of `w`; False if one is not a number or too large."""
    wrong = 0
    for i in range(len(rows)):
        for j in range(4):
            w[j * PITCH + i] = rows[i, j]
    for i in range(len(rows)):
        fine = (abs(w[i]) <= largest) & (abs(w[PITCH + i]) <= largest) & (abs(w[2 * PITCH + i]) <= largest)
        wrong += not fine & (abs(w[3 * PITCH + i]) <= largest_last)
    return wrong == 0


def _copy(column, target):
    """Fill `target` from the beginning of `column`. A loop, since numba makes it four times as fast as a slice."""
    for i in range(len(target)):
        target[i] = column[i]


def _inside(q1, q2, q3, q4, ends):
    """Are the four angles within their limits?"""
    low1, high1, low2, high2, low3, high3, low4, high4 = ends
    return (
        (q1 >= low1) & (q1 <= high1) & (q2 >= low2) & (q2 <= high2)
        & (q3 >= low3) & (q3 <= high3) & (q4 >= low4) & (q4 <= high4)
    )  # fmt: skip
