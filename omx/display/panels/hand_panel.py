"""`HandPanel`: sliders for the whole pose of a six-joint arm's hand, all its branches as ghosts, and their verdicts."""

import math

import numpy as np

from ...analysis.inverse import Inverse, Solution
from ...arrays import shown, wrap
from ...errors import BadInput, OmxError
from ...rotation import from_rpy, to_rpy
from ..viewer.view import View
from . import tables
from .branch_panel import NEAREST, BranchPanel
from .panel import as_view, slider_row

_UNITS = ("mm", "mm", "mm", "deg", "deg", "deg")

#: So many mm of a slide count as one rad of a turn.
_SLIDE = 100.0


class HandPanel(BranchPanel):
    """Sliders for x, y, z (mm) and roll, pitch, yaw (deg) of the hand; the arm takes the branch that is chosen.

    The other branches are ghosts, in the colours of the table. Where the hand cannot be had, the panel says why, and
    the arm stays at its last legal answer. `panel.branch` is `nearest`, or the name of a branch.

    Args:
        inverse: of an arm with six joints; its chain's limits count.
        q: joint values to begin with (rad; mm where prismatic), within the limits.
        view: of that chain; a new one if left out.
    """

    def __init__(self, inverse: Inverse, q, *, view: View | None = None):
        if not isinstance(inverse, Inverse) or not inverse.takes_hand:
            raise BadInput(f"`inverse` must be an omx.analysis.Inverse of six joints; got {shown(inverse)}.")
        self.inverse = inverse
        view = as_view(view or View.of_chain(inverse.chain, q))
        reach = math.ceil(sum(abs(float(v)) for row in inverse.chain.rows for v in (row.a, row.d)))
        slid = max(
            (abs(v) for row, ends in self._ends() for v in ends if row.prismatic and math.isfinite(v)), default=0
        )
        spans = dict.fromkeys("xyz", reach + math.ceil(slid)) | {"roll": 180, "pitch": 90, "yaw": 180}
        named = zip(spans.items(), _UNITS, strict=True)
        rows = [slider_row(name, -span, span, 0.0, unit) for (name, span), unit in named]
        view.let_drag(inverse.chain.limits, handle=True, inverse=inverse)
        super().__init__(view, rows, _UNITS, inverse.branches, q)

    @property
    def target(self) -> np.ndarray:
        """The pose asked for, T_base_tool (4, 4), mm; the arm may be elsewhere if it is not to be had."""
        return self._pose

    @target.setter
    def target(self, T) -> None:
        self._take(T)

    # -- the slots of Panel and BranchPanel ------------------------------------------------------------------

    def _take(self, T) -> None:
        self.inverse(T)  # refuses what is no pose before anything moves
        self._ask(np.array(T, dtype=float))

    def _ends(self):
        return zip(self.inverse.chain.rows, self.inverse.chain.limits or (), strict=False)

    def _check(self, q) -> None:
        self.inverse.chain.check(q)

    def _pose_of(self, q):
        return self.inverse.chain.fk(q)

    def _answers(self, pose) -> tuple[Solution, ...]:
        return self.inverse(pose)

    def _slider_values(self, _q) -> list[float]:
        return [*self._pose[:3, 3].tolist(), *np.degrees(to_rpy(self._pose)).tolist()]

    def _on_sliders(self, values) -> None:
        self._pose = np.eye(4)
        self._pose[:3, 3] = values[:3]
        self._pose[:3, :3] = from_rpy(*np.radians(values[3:]))
        self._solve()

    def _choose(self) -> Solution:
        if self.branch != NEAREST:
            (named,) = (s for s in self._solutions if s.branch == self.branch)
            if not named.legal:
                raise OmxError(f"With {named.branch}: {tables.verdict(named)}.")
            return named
        legal = [s for s in self._solutions if s.legal]
        if not legal:
            best = min(self._solutions, key=lambda s: (s.missing, max(map(_excess, s.violations), default=0.0)))
            raise OmxError(f"No branch is legal. Nearest is {best.branch}: {tables.verdict(best)}.")
        return min(legal, key=lambda s: self._way(s.q))

    def _way(self, q) -> float:
        """How far the joints have to go."""
        apart = np.subtract(q, self._q)
        slides = np.array([row.prismatic for row in self.inverse.chain.rows])
        return float((np.where(slides, apart / _SLIDE, wrap(apart)) ** 2).sum())

    def _remark(self) -> str:
        return "; ".join(family.text for family in getattr(self._chosen, "families", ()))


def _excess(violation) -> float:
    return violation.excess / (_SLIDE if violation.prismatic else 1.0)
