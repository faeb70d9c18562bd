"""`HandPanel`: sliders for the whole pose of a six-joint arm's hand, all its branches as ghosts, and their verdicts."""

import math
from itertools import cycle

import ipywidgets
import numpy as np

from ...analysis.inverse import Inverse, Solution
from ...arrays import shown, wrap
from ...errors import BadInput, OmxError
from ...rotation import from_rpy, to_rpy
from ..palette import PALETTE
from ..viewer.view import View
from . import tables
from .panel import Panel, side_by_side, slider_row
from .pose_panel import NEAREST

_UNITS = ("mm", "mm", "mm", "deg", "deg", "deg")


class HandPanel(Panel):
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
        view = view or View.of_chain(inverse.chain, q)
        reach = math.ceil(sum(abs(float(v)) for row in inverse.chain.rows for v in (row.a, row.d)))
        slid = max(
            (abs(v) for row, ends in self._ends() for v in ends if row.prismatic and math.isfinite(v)), default=0
        )
        spans = dict.fromkeys("xyz", reach + math.ceil(slid)) | {"roll": 180, "pitch": 90, "yaw": 180}
        named = zip(spans.items(), _UNITS, strict=True)
        made = [slider_row(name, -span, span, 0.0, unit) for (name, span), unit in named]
        self.sliders = [slider for slider, _ in made]
        for slider in self.sliders:
            slider.observe(self._heard, "value")
        self._choice = ipywidgets.Dropdown(options=[NEAREST, *inverse.branches], description="branch")
        self._choice.style.description_width = "48px"
        self._choice.observe(lambda _: self._solve(), "value")
        self._text, self._notice = ipywidgets.HTML(), ipywidgets.HTML()
        self._solutions: tuple[Solution, ...] = ()
        self._chosen, self._message, self._target = None, "", np.eye(4)
        controls = ipywidgets.VBox([*(row for _, row in made), self._choice])
        super().__init__(view, [side_by_side(controls, self._text), self._notice], q)

    def __repr__(self) -> str:
        return f"HandPanel: {self.view!r}"

    @property
    def target(self) -> np.ndarray:
        """The pose asked for, T_base_tool (4, 4), mm; the arm may be elsewhere if it is not to be had."""
        return self._target

    @target.setter
    def target(self, T) -> None:
        self.inverse(T)  # refuses what is no pose before anything moves
        self._target = np.array(T, dtype=float)
        self._set_sliders(None)
        self._solve()

    @property
    def branch(self) -> str:
        """`nearest`, or the name of the branch that the arm keeps to."""
        return self._choice.value

    @branch.setter
    def branch(self, name: str) -> None:
        self._choice.value = name

    @property
    def solutions(self) -> tuple[Solution, ...]:
        """Every branch of the pose asked for."""
        return self._solutions

    @property
    def message(self) -> str:
        """Why the arm did not follow, or nothing."""
        return self._message

    def static_html(self, *, shared: bool = False) -> str:
        """The scene with its ghosts: the sliders need Python."""
        return self.view.static_html(shared=shared)

    # -- the slots of Panel -----------------------------------------------------------------------------------

    def _ends(self):
        return zip(self.inverse.chain.rows, self.inverse.chain.limits or (), strict=False)

    def _check(self, q) -> None:
        self.inverse.chain.check(q)

    def _place(self, q) -> None:
        """Joint values set from outside: ask for the hand that they give, in the branch that they are in."""
        self._target = self.inverse.chain.fk(q)
        self._set_sliders(None)
        self._command(q)
        if self.branch == NEAREST:
            self._solve(command=False)
        else:
            self.branch = NEAREST

    def _slider_values(self, _q) -> list[float]:
        return [*self._target[:3, 3].tolist(), *np.degrees(to_rpy(self._target)).tolist()]

    def _on_sliders(self, values) -> None:
        self._target = np.eye(4)
        self._target[:3, 3] = values[:3]
        self._target[:3, :3] = from_rpy(*np.radians(values[3:]))
        self._solve()

    # -- solving ----------------------------------------------------------------------------------------------

    def _solve(self, command: bool = True) -> None:
        self._solutions, self._message, self._chosen = self.inverse(self._target), "", None
        try:
            self._chosen = self._choose()
        except OmxError as error:
            self._message = f"The arm stays. {error}"
        with self.view.channel.batch():
            self.view.target(self._target)
            chosen = self._chosen and self._chosen.branch
            self.view.ghosts([None if s.branch == chosen else s.q for s in self._solutions])
            if command and self._chosen is not None:
                self._command(self._chosen.q)
        self._tell(None)

    def _choose(self) -> Solution:
        if self.branch != NEAREST:
            (named,) = (s for s in self._solutions if s.branch == self.branch)
            if not named.legal:
                raise OmxError(f"With {named.branch}: {tables.verdict(named)}.")
            return named
        legal = [s for s in self._solutions if s.legal]
        if not legal:
            best = min(self._solutions, key=lambda s: (s.missing, len(s.violations)))
            raise OmxError(f"No branch is legal. Nearest is {best.branch}: {tables.verdict(best)}.")
        return min(legal, key=lambda s: self._way(s.q))

    def _way(self, q) -> float:
        """How far the joints have to go; a slide's mm count as parts of the arm's length."""
        apart = np.subtract(q, self._q)
        slides = np.array([row.prismatic for row in self.inverse.chain.rows])
        return float((np.where(slides, apart / 100.0, wrap(apart)) ** 2).sum())

    def _write(self) -> None:
        self._text.value = tables.branch_table(self._solutions, cycle(PALETTE), self._chosen)
        free = "; ".join(family.text for family in getattr(self._chosen, "families", ()))
        self._notice.value = tables.notice(self._message or free, good=not self._message)
