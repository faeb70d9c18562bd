"""How far the tool is from where the formulas put it, and how to bring it nearer: error propagation and calibration.

Errors are small, so the tip moves by Jacobian times error; `spread` checks that claim by sampling. The parameters
are the arm's lengths (mm), delta (rad), and an offset (rad) of each joint's zero: o1 .. o4.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import count
from math import degrees, pi, sqrt

import numpy as np

from ..arm import TICKS_PER_TURN
from ..arrays import as_count, as_four, as_number, as_rows, shown
from ..errors import BadInput, NotIdentifiable
from ..generated import fk as _fk
from ..geometry import COURSE, Geometry, as_geometry
from ..kinematics import jacobian, pose

PARAMETERS = _fk.PARAMETERS

#: One tick of the servo's encoder (rad): 0.088 deg.
TICK = 2 * pi / TICKS_PER_TURN

#: The standard deviation (rad) of rounding to the nearest tick: uniform over one tick.
TICK_SIGMA = TICK / sqrt(12)

OFFSETS = ("o1", "o2", "o3", "o4")

#: Every parameter that can be in error, and the most samples of one `spread`.
KNOWN, MOST_SAMPLES = (*PARAMETERS, *OFFSETS), 10_000_000

#: Smaller probabilities count as 0.
TINY = 1e-12

#: What `calibrate` fits. Not delta: it enters only as o2 + delta, o3 - delta, so offsets already say it all.
FITTED = (*(name for name in PARAMETERS if name != "delta"), *OFFSETS)


@dataclass(frozen=True)
class Calibration:
    """The outcome of `calibrate`.

    `geometry`: fitted lengths. `offsets` (4,) rad: add them to the joint readings. `sigma`: the standard deviation of
    each fitted parameter (mm, rad). `noise` (mm): that of one measured coordinate. `before`, `after` (mm): the RMS
    distance of the tip from its measured place. `steps`: iterations used.
    """

    geometry: Geometry
    offsets: tuple[float, float, float, float]
    sigma: Mapping[str, float]
    noise: float
    before: float
    after: float
    steps: int

    def value(self, name: str) -> float:
        """The fitted value of one parameter: L1 .. L4 in mm, o1 .. o4 in rad."""
        if name not in KNOWN:
            raise BadInput(f"unknown parameter `{name}`; known are {', '.join(KNOWN)}.")
        return self.offsets[OFFSETS.index(name)] if name in OFFSETS else getattr(self.geometry, name)

    def pose(self, q) -> np.ndarray:
        """The tool's pose at joint readings `q` (..., 4) rad, corrected: x, y, z (mm), pitch (rad)."""
        q = as_rows(q, "q", 4, "joint readings in rad")
        return np.asarray(pose(q + self.offsets, self.geometry))

    def __str__(self) -> str:
        lines = [f"RMS error of the tip: {self.before:.3f} mm before, {self.after:.3f} mm after ({self.steps} steps)"]
        for name in self.sigma:
            value, sigma = self.value(name), self.sigma[name]
            if name in OFFSETS:
                lines.append(f"{name} = {degrees(value):+8.3f} +- {degrees(sigma):.3f} deg")
            else:
                lines.append(f"{name} = {value:8.3f} +- {sigma:.3f} mm")
        return "\n".join(lines)


def sensitivity(q, geometry: Geometry = COURSE) -> dict[str, np.ndarray]:
    """How the tip (x, y, z) moves with each parameter: name -> (..., 3), mm per mm or mm per rad, at `q` (..., 4)."""
    q = as_rows(q, "q", 4, "the four joint angles in rad")
    J = jacobian(q, geometry)[..., :3, :]
    moves = {name: J[..., i] for i, name in enumerate(OFFSETS)}
    for name in PARAMETERS:
        step = 1e-4 if name == "delta" else 1.0  # the tip is linear in the lengths: a whole mm is exact
        value = getattr(geometry, name)
        more, less = (np.asarray(pose(q, geometry.replace(**{name: value + d})))[..., :3] for d in (step, -step))
        moves[name] = (more - less) / (2 * step)
    return moves


def tip_error(q, sigmas: Mapping[str, float], geometry: Geometry = COURSE) -> np.ndarray:
    """The RMS distance (mm), (...), of the tip from its computed place at `q` (..., 4), to first order.

    `sigmas`: the standard deviation of each uncertain parameter (mm; rad for delta and o1 .. o4), independent.
    """
    sigmas = _known(sigmas)
    moves = sensitivity(q, geometry)
    squares = [(np.asarray(moves[name]) ** 2).sum(-1) * sigma**2 for name, sigma in sigmas.items()]
    return np.sqrt(sum(squares, np.zeros(np.shape(moves["o1"])[:-1])))


def worst_tip_error(q, bounds: Mapping[str, float], geometry: Geometry = COURSE) -> np.ndarray:
    """An upper bound (mm), (...), of the tip's error with each parameter off by at most its bound, to first order."""
    bounds = _known(bounds)
    moves = sensitivity(q, geometry)
    parts = [np.linalg.norm(moves[name], axis=-1) * bound for name, bound in bounds.items()]
    return sum(parts, np.zeros(np.shape(moves["o1"])[:-1]))


def spread(
    q, sigmas: Mapping[str, float], samples: int = 2000, seed: int = 0, geometry: Geometry = COURSE
) -> np.ndarray:
    """Tips (samples, 3), mm, at one `q` (4,) with every parameter of `sigmas` drawn from its normal distribution."""
    sigmas, samples = _known(sigmas), as_count(samples, "samples", most=MOST_SAMPLES)
    q, geometry = np.array(as_four(q, "q", "the four joint angles in rad")), as_geometry(geometry)
    draw = np.random.default_rng(as_count(seed, "seed", 0))
    offsets = np.column_stack([draw.normal(0, sigmas.get(name, 0.0), samples) for name in OFFSETS])
    lengths = {name: draw.normal(getattr(geometry, name), sigmas.get(name, 0.0), samples) for name in PARAMETERS}
    if not set(sigmas) - set(OFFSETS):
        return pose(q + offsets, geometry)[:, :3]
    arms = (geometry.replace(**{name: lengths[name][i] for name in lengths}) for i in range(samples))
    return np.array([pose(row, arm)[:3] for row, arm in zip((q + offsets).tolist(), arms, strict=True)])


def calibrate(q, points, geometry: Geometry = COURSE, names=FITTED, steps: int = 20) -> Calibration:
    """Fit lengths and joint offsets to measured tips: Gauss-Newton least squares, starting from `geometry`.

    `q` (N, 4): joint readings in rad. `points` (N, 3): where the tip was measured, mm, base frame. `names`: what to
    fit. Raises `BadInput`, or `NotIdentifiable` where the configurations are too few or too much alike.
    """
    q = as_rows(q, "q", 4, "joint readings in rad, shape (N, 4)")
    points = as_rows(points, "points", 3, "measured tips in mm, shape (N, 3)")
    if q.ndim != 2 or points.shape != (len(q), 3):
        raise BadInput(f"`points` must have one row of x, y, z for each row of `q`; got {points.shape} and {q.shape}.")
    geometry, steps, names = as_geometry(geometry), as_count(steps, "steps"), _fitted(names)
    offsets, before = np.zeros(4), _rms(points - pose(q, geometry)[:, :3])
    for done in count(1):
        residual = points - pose(q + offsets, geometry)[:, :3]
        A = _design(q + offsets, geometry, names)
        change = np.linalg.lstsq(A, residual.ravel(), rcond=None)[0]
        geometry, offsets = _changed(geometry, offsets, dict(zip(names, change, strict=True)))
        if np.abs(change).max() < 1e-10 or done == steps:
            break
    residual = points - pose(q + offsets, geometry)[:, :3]
    freedom = residual.size - len(names)
    noise = sqrt((residual**2).sum() / freedom)
    covariance = noise**2 * np.linalg.inv(A.T @ A)
    sigma = dict(zip(names, np.sqrt(np.diag(covariance)).tolist(), strict=True))
    o1, o2, o3, o4 = offsets.tolist()
    return Calibration(geometry, (o1, o2, o3, o4), sigma, noise, before, _rms(residual), done)


def _design(q, geometry, names) -> np.ndarray:
    """The matrix (3N, parameters) of the linearised problem; raises where its columns hang together."""
    moves = sensitivity(q, geometry)
    A = np.column_stack([moves[name].reshape(-1) for name in names])
    if A.shape[0] <= A.shape[1]:
        raise NotIdentifiable(names)
    scale = np.linalg.norm(A, axis=0)
    if (scale == 0).any():
        raise NotIdentifiable(name for name, size in zip(names, scale, strict=True) if size == 0)
    _, singular, directions = np.linalg.svd(A / scale, full_matrices=False)
    if singular[-1] < 1e-6 * singular[0]:
        raise NotIdentifiable(name for name, part in zip(names, directions[-1], strict=True) if abs(part) > 0.1)
    return A


def _changed(geometry, offsets, change):
    lengths = {name: getattr(geometry, name) + step for name, step in change.items() if name in PARAMETERS}
    moved = offsets + [change.get(name, 0.0) for name in OFFSETS]
    return geometry.replace("calibrated", **lengths), moved


def _rms(residual) -> float:
    return float(np.sqrt((residual**2).sum(axis=1).mean()))


def _known(parameters: Mapping[str, float]) -> dict[str, float]:
    """The parameters with the size of each one's error; `BadInput` for what is unknown, or no size."""
    if not isinstance(parameters, Mapping):
        raise BadInput(
            f"the sizes of the errors must be given by name, such as {{'L2': 0.1}}; got {shown(parameters)}."
        )
    for name in parameters:
        if name not in KNOWN:
            raise BadInput(f"unknown parameter `{name}`; known are {', '.join(KNOWN)}.")
    return {
        name: as_number(size, name, "the size of an error, 0 or more", low=0.0) for name, size in parameters.items()
    }


def _fitted(names) -> tuple[str, ...]:
    found = (names,) if isinstance(names, str) else tuple(names) if isinstance(names, Iterable) else ()
    if not found or len(set(map(str, found))) < len(found) or not set(map(str, found)) <= set(KNOWN):
        raise BadInput(f"`names` must be some of {', '.join(KNOWN)}, each once; got {shown(names)}.")
    return tuple(map(str, found))


def binomial_interval(trials: int, chance: float, sure: float = 0.95) -> tuple[int, int]:
    """(fewest, most) successes of `trials` independent tries that succeed with probability `chance`.

    At least `sure` of all such series lie between them; less than half of the rest on either side. Raises `BadInput`.
    """
    trials = as_count(trials, "trials", 1, 10**7)
    chance = as_number(chance, "chance", "a probability from 0 to 1", 0, 1)
    tail = (1 - as_number(sure, "sure", "a share of all series, above 0 and below 1", TINY, 1 - TINY)) / 2
    counts = np.arange(trials + 1)
    ways = np.concatenate([[0.0], np.cumsum(np.log((trials - counts[:-1]) / counts[1:]))])
    with np.errstate(divide="ignore", invalid="ignore"):
        logs = (
            ways
            + np.where(counts, counts * np.log(chance), 0)
            + np.where(trials - counts, (trials - counts) * np.log1p(-chance), 0)
        )
    below = np.cumsum(np.exp(logs))
    return int(np.searchsorted(below, tail)), int(np.searchsorted(below, 1 - tail))
