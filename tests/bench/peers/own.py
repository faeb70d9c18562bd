"""Our own batches: NumPy, numba and C against the limit that copying as many rows sets.

Every contender returns new memory, the copy as well: that is how they are used. One more copy goes to memory that
was used before, to show what new memory costs.
"""

from functools import cache, partial

import numpy as np

import omx
from omx.analysis import compiled as numba_loops
from omx.generated import fk, ik
from tests.bench.c_code import compiled
from tests.bench.peers.contest import Contest, agreed, configurations, our_ik, our_pose, shared_out, threaded
from tests.bench.timing import Contender
from tests.helpers import oracles

COPY, COPY_USED = "copy of the rows, q.copy()", "the same copy into memory used before"
COPY_RESULTS = "copy of the results, angles and verdicts"
FLAGS = {"C -O3": ("-O3",), "C -O3 -march=native -ffast-math": ("-O3", "-march=native", "-ffast-math")}
COLUMNS = {"pose": 4, "branches": 18}


def forward(count: int) -> Contest:
    q = configurations(count)
    few = q[:10_000]
    gaps = [oracles.pose_gap(numba_loops.pose(few), omx.pose(few))]
    gaps += [oracles.pose_gap(in_c(flags, "pose", few), omx.pose(few)) for flags in builds()]
    numpy, *numba = our_pose(q)
    two = Contender("omx.pose (NumPy), 2 threads", lambda: shared_out(omx.pose, q, 2), count=count, threads=2)
    return Contest([numpy, two, *numba], c_loops("pose", q), agreed(np.concatenate(gaps)), copies(q))


def inverse(count: int) -> Contest:
    q = configurations(count)
    poses = omx.pose(q)
    few = poses[:10_000]
    expected, reachable, legal = omx.ik_batch(few)
    found = numba_loops.ik_batch(few)
    assert (found[1] == reachable).all()
    assert (found[2] == legal).all()
    angles = [found[0], *(in_c(flags, "branches", few)[:, :16].reshape(-1, 4, 4) for flags in builds())]
    gap = agreed([oracles.angle_gap(each[reachable], expected[reachable]).max() for each in angles])
    numpy, *numba = our_ik(poses)
    two = Contender(
        "omx.ik_batch (NumPy), 2 threads", lambda: shared_out(omx.ik_batch, poses, 2), count=count, threads=2
    )
    limits = (*copies(poses), Contender(COPY_RESULTS, copier(omx.ik_batch(poses)), count=count))
    return Contest([numpy, two, *numba], c_loops("branches", poses), gap, limits)


WORK = {"FK, batch": forward, "IK, batch": inverse}


def copies(rows) -> tuple[Contender, ...]:
    """What bounds all of them: reading and writing as many numbers as come in."""
    used = rows.copy()
    return (
        Contender(COPY, rows.copy, count=len(rows)),
        Contender(COPY_USED, lambda: np.copyto(used, rows), count=len(rows)),
    )


def copier(arrays):
    """A call that copies them all, as they lie in memory."""
    return lambda: [array.copy(order="K") for array in arrays]


@cache
def builds() -> tuple[str, ...]:
    """The ways in which a compiler was found to work, by the flags."""
    return tuple(flags for flags in FLAGS if library(flags))


@cache
def library(flags: str):
    return compiled([fk.pose, ik.branches], FLAGS[flags])


def in_c(flags: str, name: str, rows) -> np.ndarray:
    """The loop over rows in C; its results, (n, 4) of `pose` or (n, 18) of `branches`, in new memory."""
    ffi, lib = library(flags)
    out = np.empty((len(rows), COLUMNS[name]))
    source, target = (ffi.cast("double *", array.ctypes.data) for array in (rows, out))
    getattr(lib, f"{name}_loop")(source, len(rows), ffi.new("double[]", omx.COURSE.values), target)
    return out


def c_loops(name: str, rows) -> list[Contender]:
    """C by one thread and by two; cffi lets other threads run."""
    return [
        Contender(threaded(flags, threads), partial(shared_out, partial(in_c, flags, name), rows, threads),
                  count=len(rows), threads=threads)
        for flags in builds()
        for threads in (1, 2)
    ]  # fmt: skip
