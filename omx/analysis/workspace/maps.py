"""How freely the arm can work at a point: the share of pitches that are legal there, and how many solutions.

*Reachable* means with at least one pitch, *dexterous* with every pitch. Between the two, the share of legal pitches
tells how much choice is left; it is measured on evenly spaced pitches, so a very narrow choice can show as 0.
"""

import warnings
from typing import NamedTuple

import numpy as np

from ...arm import LIMITS
from ...arrays import as_count, as_number, shown
from ...dh import as_limits
from ...errors import BadInput
from ...geometry import COURSE, Geometry
from ...kinematics import ik_batch
from .section import centres, section

#: Poses solved in one go, to bound the memory; from how many on a map takes so long that it says so.
POSES, MANY = 1 << 18, 30_000_000


class PitchMap(NamedTuple):
    """Over cells with centres `r` (n,), `z` (m,) in mm, for the arm's plane (q1 = 0, r < 0 over its back):

    `share` (m, n): the share of all pitches, 0 to 1, that are legal; NaN where the tip cannot go at all.
    `branches` (m, n): the largest number of legal solutions (elbow up, elbow down) for one pitch.
    """

    r: np.ndarray
    z: np.ndarray
    share: np.ndarray
    branches: np.ndarray


class BranchMap(NamedTuple):
    """Over cells with centres `r` (n,) >= 0, `z` (m,): `count` (m, n), how many of the four branches are legal."""

    r: np.ndarray
    z: np.ndarray
    count: np.ndarray  # type: ignore[assignment]  # tuples have a method of this name, which nobody needs here


def pitch_map(step: float = 10.0, pitches: int = 120, geometry: Geometry = COURSE, limits=LIMITS, *,
              allowed=None) -> PitchMap:  # fmt: skip
    """The share of legal pitches and the number of branches, at the centre of every cell of side `step` (mm).

    `pitches`: how many, evenly spaced over the full turn, are tried. `allowed(q)`, (n, 4) -> booleans (n,), rules out
    more configurations, for example `omx.analysis.workspace.clear`.
    """
    pitches, limits = as_count(pitches, "pitches", most=100_000), as_limits(limits, 4)
    r, z, inside = section(geometry, limits).fill(step)
    cells = np.argwhere(inside)
    if (tried := len(cells) * pitches) > MANY:
        warnings.warn(f"{tried / 1e6:.0f} million poses are tried, a few million a second; a larger step, or fewer "
                      "pitches, is sooner done.", stacklevel=2)  # fmt: skip
    share, branches = np.full(inside.shape, np.nan), np.zeros(inside.shape, dtype=int)
    some = max(1, POSES // pitches)
    for start in range(0, len(cells), some):
        rows, columns = cells[start : start + some].T
        legal = _legal_branches(r[columns], z[rows], pitches, geometry, limits, allowed)
        share[rows, columns] = (legal > 0).mean(axis=1)
        branches[rows, columns] = legal.max(axis=1)
    return PitchMap(r, z, share, branches)


def branch_map(pitch: float, step: float = 5.0, geometry: Geometry = COURSE, limits=LIMITS, *,
               allowed=None) -> BranchMap:  # fmt: skip
    """How many of the four branches are legal for one pitch (rad), in space: at a distance r from the axis.

    `allowed(q)`, (n, 4) -> booleans (n,), rules out more configurations.
    """
    pitch = as_number(pitch, "pitch", "an angle in rad")
    r_low, r_high, z_low, z_high = section(geometry, limits).bounds
    r, z = centres(0.0, max(-r_low, r_high), step), centres(z_low, z_high, step)
    poses = np.zeros((len(z), len(r), 4))
    poses[..., 0], poses[..., 2], poses[..., 3] = r, z[:, None], pitch
    q, _, legal = ik_batch(poses.reshape(-1, 4), geometry, limits)
    return BranchMap(r, z, _ruled(q, legal, allowed).sum(axis=1).reshape(len(z), len(r)))


def _legal_branches(r, z, pitches: int, geometry: Geometry, limits, allowed) -> np.ndarray:
    """How many branches with q1 = 0 are legal, (points, pitches)."""
    poses = np.zeros((len(r), pitches, 4))
    poses[..., 0], poses[..., 2] = r[:, None], z[:, None]
    poses[..., 3] = (np.arange(pitches) + 0.5) * (2.0 * np.pi / pitches) - np.pi
    q, _, legal = ik_batch(poses.reshape(-1, 4), geometry, ((-np.pi, np.pi), *limits[1:]))
    legal = legal & (np.abs(q[:, :, 0]) < 1.0)  # the front branches for r > 0, those over the back for r < 0
    return _ruled(q, legal, allowed).sum(axis=1).reshape(len(r), pitches)


def _ruled(q, legal, allowed) -> np.ndarray:
    """`legal`, less what `allowed` forbids."""
    if allowed is not None:
        if not callable(allowed):
            raise BadInput(f"`allowed` must be a function, or None; got {shown(allowed)}.")
        legal = legal.copy()
        wanted = np.asarray(allowed(q[legal]))
        if wanted.shape != (int(legal.sum()),) or wanted.dtype.kind != "b":
            raise BadInput(f"`allowed` must return one True or False a row; got {wanted.dtype} {wanted.shape}.")
        legal[legal] = wanted
    return legal
