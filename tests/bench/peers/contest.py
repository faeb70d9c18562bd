"""One piece of work that several contenders do, and the proof that it is the same work."""

from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np

import omx
from omx.analysis import compiled
from tests.bench.timing import Contender
from tests.helpers import oracles

#: mm or rad: results that differ by more are not the same work.
SAME = 1e-6

#: Iterative solvers start this far (rad) from the answer, in every joint: near enough to find that branch.
START = 0.1


class Contest(NamedTuple):
    """`ours` and `theirs`, all compared with the first of `limits`, or else of ours.

    `gap` (mm or rad): how far apart the results are. `limits`: work that is not ours but bounds it, such as a copy.
    `in_c`: our formulas in C, without Python; None where there is no compiler.
    """

    ours: list[Contender]
    theirs: list[Contender]
    gap: float
    limits: tuple[Contender, ...] = ()
    in_c: Contender | None = None


def agreed(gap) -> float:
    """The largest of `gap`; raises `AssertionError` if results are not the same."""
    largest = float(np.max(gap))
    assert largest <= SAME, f"the results differ by {largest:.1e} mm or rad"
    return largest


def configurations(count: int) -> np.ndarray:
    """(count, 4), rad, legal, the same each time; none so near to a straight elbow that iterations are slow."""
    low, high = np.array(omx.LIMITS).T
    q = oracles.random_q(count, seed=1)
    q[:, 2] = low[2] + 0.6 * (q[:, 2] - low[2])
    return np.clip(q, low, high)


def starts(q) -> np.ndarray:
    """Where iterative solvers begin."""
    return q + START


def returned(q_found, q) -> float:
    """How far the tool is from where it should be, at the solutions (n, 4) of an iterative solver."""
    return agreed(oracles.pose_gap(omx.pose(np.asarray(q_found)), omx.pose(q)))


def shared_out(function, rows, threads: int):
    """`function` of equal parts of `rows`, one thread each: for code that lets other threads run meanwhile."""
    if threads == 1:
        return [function(rows)]
    parts = np.array_split(rows, threads)
    with ThreadPoolExecutor(threads) as pool:
        return list(pool.map(function, parts))


def our_pose(q, threads=(1, 2)) -> list[Contender]:
    """Forward kinematics of a batch: NumPy, and numba where it is installed."""
    return [
        Contender("omx.pose (NumPy)", lambda: omx.pose(q), count=len(q)),
        *(_fast("omx.analysis.compiled.pose (numba)", compiled.pose, q, n) for n in threads if compiled.available()),
    ]


def our_ik(poses, threads=(1, 2)) -> list[Contender]:
    """Inverse kinematics of a batch, four branches with verdicts."""
    return [
        Contender("omx.ik_batch (NumPy)", lambda: omx.ik_batch(poses), count=len(poses)),
        *(_fast("compiled.ik_batch (numba)", compiled.ik_batch, poses, n) for n in threads if compiled.available()),
    ]


def threaded(name: str, threads: int) -> str:
    return name if threads == 1 else f"{name}, {threads} threads"


def _fast(name, function, rows, threads):
    return Contender(threaded(name, threads), lambda: function(rows, threads=threads), count=len(rows), threads=threads)
