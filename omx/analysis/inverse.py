"""Every answer of an inverse that the book's generator wrote, each with its verdict: reach, limits, singularity."""

from dataclasses import dataclass, field
from functools import cached_property
from math import degrees, pi
from types import ModuleType
from typing import NamedTuple

import numpy as np

from ..arrays import as_rows, shown
from ..dh import Chain, as_chain, limit_violations
from ..errors import BadInput, Violation
from ..kinematics import LIMIT_SLACK

#: A branch that leaves the hand this far (mm) from its place is within reach: rounding.
REACH_SLACK = 1e-9

#: Lines that are this near to one another, in rad and as a share of the arm's length, count as one: at such places an
#: inverse finds what it looks for under a square root, so half of all digits are lost.
NEAR = 1e-7

HAND = "the transform T_base_tool of the hand, its rotation orthonormal"


class Family(NamedTuple):
    """Infinitely many answers in one branch: `free` is the joint that may have any value, `text` says what is fixed.

    `along`, if there is one: joint values may be moved along this direction, and the hand stays where it is. None where
    the other joints follow on a curve.
    """

    free: str
    text: str
    along: tuple[float, ...] | None = None


@dataclass(frozen=True, repr=False)
class Solution:
    """One branch of an inverse.

    `q`: joint values (rad, wrapped into one turn; mm where prismatic), None where out of reach by `missing` (mm).
    """

    branch: str
    q: tuple[float, ...] | None
    missing: float
    chain: Chain = field(compare=False)

    @cached_property
    def violations(self) -> tuple[Violation, ...]:
        """Each joint that is outside its limits."""
        if self.q is None:
            return ()
        slides = [row.prismatic for row in self.chain.rows]
        return limit_violations(self.q, self.chain.limits or (), self.chain.names, LIMIT_SLACK, slides)

    @cached_property
    def families(self) -> tuple[Family, ...]:
        """What is free there, if anything; `q` is then one answer of infinitely many."""
        return () if self.q is None else families(self.chain, self.q)

    @property
    def reachable(self) -> bool:
        """Does this branch bring the hand to its place?"""
        return self.q is not None

    @property
    def legal(self) -> bool:
        """Within reach, and every joint within its limits."""
        return self.reachable and not self.violations

    def __repr__(self) -> str:
        if self.q is None:
            return f"Solution({self.branch}: out of reach by {self.missing:.3f} mm)"
        values = zip(self.q, self.chain.rows, strict=True)
        told = ", ".join(f"{q:.2f} mm" if row.prismatic else f"{degrees(q) + 0.0:.2f}" for q, row in values)
        verdict = "; ".join(map(str, self.violations)) or "legal"
        free = "".join(f"; {family.text}" for family in self.families)
        return f"Solution({self.branch}: q = ({told}) deg, {verdict}{free})"


class Solutions(NamedTuple):
    """The branches of many targets: `q` (..., branches, joints), NaN where out of reach; the rest (..., branches)."""

    q: np.ndarray
    missing: np.ndarray
    legal: np.ndarray


class Inverse:
    """All answers of an arm: its `chain`, with the limits, and the `module` that `write_inverse` wrote for it.

    A target is T_base_tool, (4, 4), for six joints; for fewer, the numbers that the module takes, such as x, y, z and
    pitch. Raises `BadInput` where the module belongs to another arm.
    """

    def __init__(self, chain: Chain, module: ModuleType):
        chain = as_chain(chain)
        needed = ("branches", "branches_batch", "missing", "missing_batch", "dh_rows", "BRANCHES")
        if not all(hasattr(module, name) for name in needed):
            raise BadInput(f"`module` must be one that omx.derive.write_inverse wrote; got {shown(module)}.")
        self.chain, self.module = chain, module
        self.lengths = tuple(map(float, getattr(module, "PARAMETERS", {}).values()))
        self._refuse_another_arm()

    def __repr__(self) -> str:
        return f"Inverse({self.chain.name!r}, {len(self.branches)} branches)"

    @property
    def branches(self) -> tuple[str, ...]:
        """The names of the branches, in their order."""
        return self.module.BRANCHES

    @property
    def takes_hand(self) -> bool:
        """Is a target a whole transform?"""
        return len(self.chain) == 6

    def __call__(self, target) -> tuple[Solution, ...]:
        """Every branch for one target, each with its verdict, in the order of `branches`. Raises `BadInput`."""
        numbers = self._numbers(target).tolist()
        if isinstance(numbers[0], list):
            raise BadInput("one target is wanted here; for many use `batch`.")
        answers = self.module.branches(*numbers, *self.lengths)
        missing = self.module.missing(*numbers, *self.lengths)
        return tuple(
            Solution(branch, None, gap, self.chain)
            if gap > REACH_SLACK
            else Solution(branch, self._upright(q), 0.0, self.chain)
            for branch, q, gap in zip(self.branches, answers, missing, strict=True)
        )

    def batch(self, targets) -> Solutions:
        """The same for many targets, (..., 4, 4) or (..., k): arrays."""
        rows = self._numbers(targets)
        shape, columns = rows.shape[:-1], np.ascontiguousarray(rows.reshape(-1, rows.shape[-1]).T)
        answers = self.module.branches_batch(*columns, *self.lengths)
        gaps = self.module.missing_batch(*columns, *self.lengths)
        count = columns.shape[1]
        q = np.stack([[np.broadcast_to(value, count) for value in one] for one in answers]).transpose(2, 0, 1)
        missing = np.stack([np.broadcast_to(gap, count) for gap in gaps], axis=-1)
        q = np.where((q == -pi) & ~self._slides, pi, q)
        reachable = missing <= REACH_SLACK
        low, high = self._bounds
        legal = reachable & ((q >= low - LIMIT_SLACK) & (q <= high + LIMIT_SLACK)).all(axis=-1)
        q = np.where(reachable[..., None], q, np.nan)
        return Solutions(*(part.reshape(*shape, *part.shape[1:]) for part in (q, missing, legal)))

    def _upright(self, q) -> tuple[float, ...]:
        """Half a turn is +pi; an arc tangent may say -pi."""
        return tuple(pi if v == -pi and not row.prismatic else v for v, row in zip(q, self.chain.rows, strict=True))

    # -- input ----------------------------------------------------------------------------------------------

    def _numbers(self, target) -> np.ndarray:
        """The module's arguments, (..., k)."""
        if not self.takes_hand:
            count = self.module.branches.__code__.co_argcount - len(self.lengths)
            wanted = ", ".join(self.module.branches.__code__.co_varnames[:count])
            return as_rows(target, "target", count, f"{wanted} (mm, rad)") + 0.0
        T = as_rows(target, "target", 4, HAND)
        if T.shape[-2:] != (4, 4):
            raise BadInput(f"`target` must be {HAND}, shape (4, 4) or (..., 4, 4); got shape {T.shape}.")
        R = T[..., :3, :3]
        off = np.abs(np.swapaxes(R, -1, -2) @ R - np.eye(3)).max(), np.abs(T[..., 3, :] - [0, 0, 0, 1]).max()
        if not (max(off) < 1e-5 and (np.linalg.det(R) > 0).all()):
            raise BadInput(f"`target` must be {HAND}, and a last row of 0, 0, 0, 1; this matrix is no pose.")
        return np.swapaxes(T[..., :3, :], -1, -2).reshape(*T.shape[:-2], 12) + 0.0  # no minus zeros

    @cached_property
    def _slides(self) -> np.ndarray:
        return np.array([row.prismatic for row in self.chain.rows])

    @cached_property
    def _bounds(self) -> tuple[np.ndarray, np.ndarray]:
        limits = self.chain.limits or [(-np.inf, np.inf)] * len(self.chain)
        low, high = np.array(limits).T
        return low, high

    def _refuse_another_arm(self) -> None:
        rows = self.module.dh_rows(*self.lengths)
        same = len(rows) == len(self.chain) and np.allclose(_table(rows), _table(self.chain.rows), atol=1e-9)
        if same and self.takes_hand:  # a base or a tool is in the formulas only
            q = np.where(self._slides, 0.3 * self.chain.size, np.linspace(0.3, 1.1, 6))
            answers = self.module.branches(*self._numbers(self.chain.fk(q)).tolist(), *self.lengths)
            same = bool(np.abs(np.array(answers) - q).max(axis=1).min() < 1e-6 * max(self.chain.size, 1.0))
        if not same:
            raise BadInput(f"`module` {self.module.__name__} was written for another arm than {self.chain.name}.")


def families(chain: Chain, q) -> tuple[Family, ...]:
    """What is free at `q`. Only lines count: two axes on one line, or one through the wrist centre."""
    frames = chain.frames(q)
    z, origins, names = frames[:, :3, 2], frames[:, :3, 3], chain.names
    near = NEAR * max(chain.size, 1e-9)

    def aligned(i, j):
        return _apart(z[i - 1], z[j - 1]) < NEAR

    def passes(i, point):
        return _apart(point - origins[i - 1], z[i - 1]) < near

    def one_line(i, j):
        """One joint takes back what the other turns."""
        same = z[i - 1] @ z[j - 1] > 0
        along = [0.0] * len(q)
        along[i - 1], along[j - 1] = 1.0, -1.0 if same else 1.0
        total = degrees(q[i - 1] + q[j - 1] if same else q[i - 1] - q[j - 1])
        text = f"only {names[i - 1]} {'+' if same else '-'} {names[j - 1]} = {total + 0.0:.2f} deg is fixed"
        return Family(names[i - 1], text, tuple(along))

    def curve(i):
        return Family(names[i - 1], f"{names[i - 1]} is free, and others follow")

    found = []
    if len(chain) == 6:
        found += [curve(i) for i in (1, 2) if _may_pass(chain, i) and passes(i, origins[5])]
        if aligned(4, 6) and passes(4, origins[5]) and passes(6, origins[4]):
            found.append(one_line(4, 6))
        elif aligned(2, 6) and aligned(2, 3) and aligned(3, 4):
            found.append(curve(6))
    elif len(q) in (3, 4) and abs(z[0] @ z[1]) < 0.5 and passes(1, origins[-1]):
        found.append(Family(names[0], f"{names[0]} is free"))
    return tuple(found)


def _may_pass(chain: Chain, i: int) -> bool:
    """Does the wrist follow whatever axis `i` turns? Axis 2 counts for a wrist whose axes meet only."""
    return i == 1 or float(chain.rows[4].d) == float(chain.rows[3].a) == 0.0


def _apart(a, b) -> float:
    """The length of the cross product: of unit vectors, the sine of the angle between them."""
    return float(np.linalg.norm(np.cross(a, b)))


def _table(rows) -> np.ndarray:
    return np.array([[row.theta, row.d, row.a, row.alpha, row.prismatic] for row in rows], dtype=float)
