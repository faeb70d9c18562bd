"""Where the tip of any chain goes, by trying many configurations: counts of tips in cells of a plane or of space.

The samples come in blocks, each with its own seed, so the counts are the same whatever works on them: threads of
this machine (the default), processes, or a dask cluster, through any object with the `map` of an executor.
"""

import sys
from concurrent.futures import ThreadPoolExecutor
from functools import cached_property, partial
from math import isfinite, pi, prod, tau
from os import cpu_count
from typing import NamedTuple, Protocol

import numpy as np

from ... import kinematics
from ...arm import LIMITS
from ...arrays import as_count, shown
from ...dh import Chain, as_limits
from ...errors import BadInput
from ...geometry import COURSE, Geometry, as_arm
from .section import centres

#: Samples that share one seed. Changing it changes the samples; the size of a task does not.
BLOCK = 65_536

#: Samples that one call of the executor works on.
TASK = 16 * BLOCK

#: The most samples and cells of one count.
MOST_SAMPLES, MOST_CELLS = 10**12, 10**8


class Executor(Protocol):
    """What may do the work: a `concurrent.futures` executor, or `dask.distributed.Client().get_executor()`."""

    def map(self, function, *iterables): ...


class Counts:
    """How many tips fell into each cell of side `step` (mm): `counts`, an axis for each of `axes`, the centres."""

    def __init__(self, axes: tuple[np.ndarray, ...], counts: np.ndarray, step: float):
        self.axes, self.counts, self.step = axes, counts, step

    def __repr__(self) -> str:
        hit = int(np.count_nonzero(self.counts))
        return f"Counts({int(self.counts.sum())} tips in {hit} cells of {self.step:g} mm)"

    @cached_property
    def hit(self) -> np.ndarray:
        """The centres (n, 2) or (n, 3), mm, of the cells that hold at least one tip."""
        return np.column_stack([axis[i] for axis, i in zip(self.axes, np.nonzero(self.counts), strict=True)])

    @property
    def size(self) -> float:
        """The area (mm2) or volume (mm3) of these cells together: border cells count whole, so it is a bit large."""
        return len(self.hit) * self.step ** len(self.axes)


class _Job(NamedTuple):
    """Everything that a worker has to know; plain data, so that it can be sent to another machine."""

    samples: int
    seed: int
    geometry: Geometry | Chain
    limits: tuple
    axes: tuple
    step: float


def sample_joints(samples: int, seed: int = 0, geometry: Geometry | Chain = COURSE, limits=None) -> np.ndarray:
    """`samples` configurations within the joint limits, (samples, joints), the same for the same seed.

    `limits`: the chain's own, or `omx.LIMITS`, if left out. Raises `BadInput`.
    """
    job = _job(samples, seed, as_arm(geometry, numbers=True), limits)
    return np.vstack([_block(job, i) for i in range(-(-job.samples // BLOCK))])


def tips(q, geometry: Geometry | Chain = COURSE) -> np.ndarray:
    """The tip's position (..., 3), mm, for joint values q (..., joints)."""
    geometry = as_arm(geometry, numbers=True)
    if isinstance(geometry, Chain):
        return geometry.fk(q)[..., :3, 3]
    return np.asarray(kinematics.pose(q, geometry))[..., :3]


def count_plane(samples: int, seed: int = 0, *, geometry: Geometry | Chain = COURSE, limits=None, step: float = 5.0,
                executor: Executor | None = None, progress=None) -> Counts:  # fmt: skip
    """Tips in cells of the plane: `counts` with the axes r, z.

    For a `Geometry` r has a sign, as if q1 were 0: negative over the arm's back. For a `Chain` it is the distance
    from the z axis. `step`: the side of a cell (mm). `executor`: anything with the `map` of `concurrent.futures`;
    threads if left out. `progress(share)`, 0 .. 1, is called as the work proceeds. The counts do not depend on either.
    Raises `BadInput`.
    """
    geometry = as_arm(geometry, numbers=True)
    (z_low, z_high), reach = _span(geometry, limits)
    axes = (centres(-reach if isinstance(geometry, Geometry) else 0.0, reach, step), centres(z_low, z_high, step))
    return _count(_job(samples, seed, geometry, limits, axes, step), _plane, executor, progress)


def count_space(samples: int, seed: int = 0, *, geometry: Geometry | Chain = COURSE, limits=None, step: float = 10.0,
                executor: Executor | None = None, progress=None) -> Counts:  # fmt: skip
    """Tips in cubes of space: `counts` with the axes x, y, z; the other arguments are those of `count_plane`."""
    geometry = as_arm(geometry, numbers=True)
    (z_low, z_high), reach = _span(geometry, limits)
    axes = (*[centres(-reach, reach, step)] * 2, centres(z_low, z_high, step))
    return _count(_job(samples, seed, geometry, limits, axes, step), _space, executor, progress)


def _count(job: _Job, project, executor: Executor | None, progress) -> Counts:
    blocks = -(-job.samples // BLOCK)
    firsts = range(0, blocks, TASK // BLOCK)
    if progress is not None and not callable(progress):
        raise BadInput(f"`progress` must be a function, or None; got {shown(progress)}.")
    if executor is not None and not callable(getattr(executor, "map", None)):
        raise BadInput(f"`executor` must have a `map`, as those of concurrent.futures do; got {shown(executor)}.")
    if executor is None and sys.platform != "emscripten":  # a browser's Python has no threads
        with ThreadPoolExecutor(cpu_count()) as threads:
            return _count(job, project, threads, progress)
    shared_out = map if executor is None else executor.map
    total = np.zeros(prod(map(len, job.axes)), dtype=np.int64)
    for first, counts in zip(firsts, shared_out(partial(_task, job, project), firsts), strict=True):
        total += counts
        if progress is not None:
            progress(min((first * BLOCK + TASK) / job.samples, 1.0))
    return Counts(job.axes, total.reshape([len(axis) for axis in job.axes]), job.step)


def _task(job: _Job, project, first: int) -> np.ndarray:
    """The counts of one task's blocks, all cells in one row."""
    total = np.zeros(prod(map(len, job.axes)), dtype=np.int64)
    for i in range(first, min(first + TASK // BLOCK, -(-job.samples // BLOCK))):
        total += np.bincount(_cells(job, project(_block(job, i), job.geometry)), minlength=len(total))
    return total


def _block(job: _Job, i: int) -> np.ndarray:
    """The configurations of block i; the last block may be cut short."""
    random = np.random.default_rng(np.random.SeedSequence(job.seed, spawn_key=(i,)))
    low, high = np.array(job.limits, float).T
    q = random.random((min(BLOCK, job.samples - i * BLOCK), len(low)))
    q *= high - low
    q += low
    return q


def _cells(job: _Job, points: list[np.ndarray]) -> np.ndarray:
    """The number of the cell of each point, counted through all axes, the last one fastest, for `bincount`."""
    number = np.zeros(len(points[0]), dtype=np.intp)
    for axis, values in zip(job.axes, points, strict=True):
        place = np.floor((values - (axis[0] - 0.5 * job.step)) / job.step).astype(np.intp)
        number = number * len(axis) + np.clip(place, 0, len(axis) - 1)  # rounding at the rim
    return number


def _plane(q: np.ndarray, geometry: Geometry | Chain) -> list[np.ndarray]:
    if isinstance(geometry, Geometry):
        q[:, 0] = 0.0
        x, _, z = tips(q, geometry).T
        return [x, z]
    x, y, z = tips(q, geometry).T
    return [np.hypot(x, y), z]


def _space(q: np.ndarray, geometry: Geometry | Chain) -> list[np.ndarray]:
    return list(tips(q, geometry).T)


def _span(geometry: Geometry | Chain, limits) -> tuple[tuple[float, float], float]:
    """The height, (low, high), and the distance from the z axis (mm) that the tip cannot exceed: all links in line."""
    if isinstance(geometry, Geometry):
        reach = abs(geometry.L2) + abs(geometry.L3) + abs(geometry.L4)
        return (geometry.L1 - reach, geometry.L1 + reach), reach
    reach = sum(float(np.linalg.norm(T[:3, 3])) for T in (geometry.base, geometry.tool) if T is not None)
    for row, (low, high) in zip(geometry.rows, _limits(geometry, limits), strict=True):
        slide = max(abs(row.d + low), abs(row.d + high)) if row.prismatic else abs(row.d)
        reach += float(np.hypot(row.a, slide))
    return (-reach, reach), reach


def _limits(geometry: Geometry | Chain, limits) -> tuple[tuple[float, float], ...]:
    """The intervals to draw from: the limits, and one turn where a joint turns without end."""
    if isinstance(geometry, Chain):
        prismatic, names = [row.prismatic for row in geometry.rows], geometry.names
        limits = geometry.limits if limits is None else limits
    else:
        prismatic, names = [False] * 4, ("q1", "q2", "q3", "q4")
        limits = LIMITS if limits is None else limits
    if limits is None:
        raise BadInput(f"{geometry!r} has no limits: give `limits`, one (low, high) for each of its joints.")
    pairs = as_limits(limits, len(names), prismatic)
    return tuple(_drawn(*pair, name, slides) for pair, name, slides in zip(pairs, names, prismatic, strict=True))


def _drawn(low: float, high: float, name: str, slides: bool) -> tuple[float, float]:
    if isfinite(low) and isfinite(high):
        return low, high
    if slides:
        raise BadInput(f"{name} slides without end, ({low}, {high}) mm: give `limits` to draw from.")
    if isfinite(low) or isfinite(high):
        return (low, low + tau) if isfinite(low) else (high - tau, high)
    return -pi, pi


def _job(samples, seed, geometry, limits, axes=(), step=0.0) -> _Job:
    """The order for the workers, every argument checked."""
    if prod(map(len, axes)) > MOST_CELLS:
        raise BadInput(f"`step` = {step:g} mm makes {prod(map(len, axes)):.1e} cells; the most are {MOST_CELLS:.0e}.")
    samples = as_count(samples, "samples", most=MOST_SAMPLES)
    return _Job(samples, as_count(seed, "seed", 0), geometry, _limits(geometry, limits), axes, float(step))
