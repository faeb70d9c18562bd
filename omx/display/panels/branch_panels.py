"""Panels that ask an inverse: sliders for a pose, a choice of branch, ghosts of the others, verdicts.

`PosePanel` asks for the tool's x, y, z and pitch and shows the four IK branches; `HandPanel` asks for the whole pose of
a six-joint arm's hand, in all its branches.
"""

import math
from itertools import cycle

import ipywidgets
import numpy as np

from ...analysis.inverse import Inverse, Solution
from ...arm import HOME, LIMITS
from ...arrays import shown, wrap
from ...errors import BadInput, OmxError
from ...kinematics import IKSolution, ik, solve_ik
from ...kinematics import pose as tool_pose
from ...rotation import from_rpy, rigid, to_rpy
from ..palette import PALETTE
from ..viewer.arm_data import branch_names
from ..viewer.arm_model import reach
from ..viewer.view import View
from . import tables
from .panel import Panel, as_view

#: The branch that is nearest to where the arm is.
NEAREST = "nearest"

#: So many mm of a slide count as one rad of a turn.
_SLIDE = 100.0


class BranchPanel(Panel):
    """Sliders for a pose under the arm, which takes the branch that is chosen; the others are ghosts.

    A panel of its own says which pose belongs to joint values (`_pose_of`), which answers to a pose (`_answers`), and
    which of them is nearest (`_nearest`, or `OmxError`: then the arm stays).
    """

    def __init__(self, view: View, rows, branches, q):
        self._rows = rows
        self._choice = ipywidgets.Dropdown(options=[NEAREST, *branches], description="branch")
        self._choice.style.description_width = "48px"
        self._choice.observe(lambda _: self._keep(), "value")
        self._notice = ipywidgets.HTML()
        self._solutions, self._chosen, self._message = (), None, ""
        super().__init__(view, rows, q, below=[self._choice], after=[self._notice])

    @property
    def branch(self) -> str:
        """`nearest`, or the name of the branch that the arm keeps to."""
        return self._choice.value

    @branch.setter
    def branch(self, name: str) -> None:
        self._choice.value = name

    @property
    def solutions(self) -> tuple:
        """Every branch of the pose asked for."""
        return self._solutions

    @property
    def message(self) -> str:
        """Why the arm did not follow, or nothing."""
        return self._message

    def page_data(self) -> dict:
        return {**super().page_data(), "panel": {"q": self.q, "kind": "pose", "sliders": self._rows}}

    def _dragged(self, pose, q) -> None:
        """By its handle the tool is asked to a pose; a link that is pulled says where the joints are, and no pose."""
        if pose is None:
            super()._dragged(pose, q)
        else:
            self._take(pose)

    def _keep(self) -> None:
        """A branch was chosen: in the scene, too, a dragged tool keeps to it."""
        self.view.channel.set("/meshcat/arm", "branch", "" if self.branch == NEAREST else self.branch)
        self._solve()

    def _take(self, pose) -> None:
        """Ask for `pose` from outside the sliders, which follow."""
        self._answers(pose)  # refuses what is no pose before anything moves
        self._pose = np.array(pose, dtype=float)
        self._set_sliders(None)
        self._solve()

    def _place(self, q) -> None:
        """Joint values set from outside: ask for the pose that they give, in the branch that they are in."""
        self._pose = self._pose_of(q)
        self._set_sliders(None)
        self._command(q)
        if self.branch == NEAREST:
            self._solve(command=False)
        else:
            self.branch = NEAREST

    def _solve(self, command: bool = True) -> None:
        self._solutions, self._message, self._chosen = self._answers(self._pose), "", None
        try:
            self._chosen = self._choose()
        except OmxError as error:
            self._message = f"The arm stays. {error}"
        with self.view.channel.batch():
            self.view.target(self._pose)
            chosen = self._chosen and self._chosen.branch
            self.view.ghosts([None if s.branch == chosen else s.q for s in self._solutions])
            if command and self._chosen is not None:
                self._command(self._chosen.q)
        self._tell()

    def _choose(self):
        """The branch that the arm takes: the nearest, or the one that it is to keep to. `OmxError` without one."""
        if self.branch == NEAREST or not any(s.reachable for s in self._solutions):
            return self._nearest()
        (named,) = (s for s in self._solutions if s.branch == self.branch)
        if not named.legal:
            raise OmxError(f"With {named.branch}: {tables.verdict(named)}.")
        return named

    def _write(self) -> None:
        self._text.value = tables.branch_table(self._solutions, cycle(PALETTE), self._chosen, self.chain.rows)
        free = "; ".join(family.text for family in getattr(self._chosen, "families", ()))
        self._notice.value = tables.notice(self._message or free, good=not self._message)


class PosePanel(BranchPanel):
    """Sliders for x, y, z (mm) and pitch (deg) under the arm; the arm takes the IK branch that is chosen.

    The other branches are ghosts, in the colours of the table. Where a pose is out of reach or breaks a joint
    limit, the panel says by how much, and the arm stays at its last legal pose. `panel.branch` is `nearest`, or
    a branch by name (`front, elbow up`).
    """

    def __init__(self, view: View | None = None, *, q=HOME):
        view = as_view(view or View(q))
        if view.geometry is None:
            raise BadInput(f"a PosePanel shows this book's arm; {view!r} is of another chain.")
        self.geometry, self.chain = view.geometry, view.chain
        far = math.ceil(sum((self.geometry.L2, self.geometry.L3, self.geometry.L4)))
        rows = [("x", "mm", -far, far), ("y", "mm", -far, far)]
        rows += [("z", "mm", -200, math.floor(self.geometry.L1) + far), ("pitch", "deg", -120, 120)]
        view.let_drag(LIMITS, handle=True)
        super().__init__(view, rows, branch_names(), q)

    @property
    def pose(self) -> tuple[float, float, float, float]:
        """The pose asked for: x, y, z (mm) and pitch (rad); the arm may be elsewhere if it is not to be had."""
        return tuple(self._pose.tolist())

    @pose.setter
    def pose(self, value) -> None:
        self._take(value)

    # -- the slots of Panel and BranchPanel ------------------------------------------------------------------

    def _pose_of(self, q) -> np.ndarray:
        return np.array(tool_pose(q, self.geometry))

    def _answers(self, pose) -> tuple[IKSolution, ...]:
        return ik(pose, self.geometry)

    def _nearest(self) -> IKSolution:
        return solve_ik(self._pose, self._q, self.geometry)

    def _slider_values(self, _q) -> list[float]:
        x, y, z, pitch = self.pose
        return [x, y, z, math.degrees(pitch)]

    def _on_sliders(self, values) -> None:
        *position, pitch = values
        self._pose = np.array([*position, math.radians(pitch)])
        self._solve()


class HandPanel(BranchPanel):
    """Sliders for x, y, z (mm) and roll, pitch, yaw (deg) of the hand; the arm takes the branch that is chosen.

    The other branches are ghosts, in the colours of the table. Where the hand cannot be had, the panel says why, and
    the arm stays at its last legal answer. `panel.branch` is `nearest`, or the name of a branch.

    Args:
        inverse: of an arm with six joints; its chain's limits count.
        q: joint values to begin with (rad; mm where prismatic), within the limits.
    """

    def __init__(self, inverse: Inverse, q):
        if not isinstance(inverse, Inverse) or not inverse.takes_hand:
            raise BadInput(f"`inverse` must be an omx.analysis.Inverse of six joints; got {shown(inverse)}.")
        self.inverse, self.chain = inverse, inverse.chain
        view = View.of_chain(self.chain, q)
        far = math.ceil(reach(self.chain))
        rows = [(name, "mm", -far, far) for name in "xyz"]
        rows += [(name, "deg", -turn, turn) for name, turn in (("roll", 180), ("pitch", 90), ("yaw", 180))]
        view.let_drag(self.chain.limits, handle=True, inverse=inverse)
        super().__init__(view, rows, inverse.branches, q)

    @property
    def target(self) -> np.ndarray:
        """The pose asked for, T_base_tool (4, 4), mm; the arm may be elsewhere if it is not to be had."""
        return self._pose

    @target.setter
    def target(self, T) -> None:
        self._take(T)

    # -- the slots of Panel and BranchPanel ------------------------------------------------------------------

    def _pose_of(self, q) -> np.ndarray:
        return self.chain.fk(q)

    def _answers(self, pose) -> tuple[Solution, ...]:
        return self.inverse(pose)

    def _nearest(self) -> Solution:
        legal = [s for s in self._solutions if s.legal]
        if not legal:
            best = min(self._solutions, key=lambda s: (s.missing, max(map(_excess, s.violations), default=0.0)))
            raise OmxError(f"No branch is legal. Nearest is {best.branch}: {tables.verdict(best)}.")
        return min(legal, key=lambda s: self._way(s.q))

    def _way(self, q) -> float:
        """How far the joints have to go."""
        apart = np.subtract(q, self._q)
        slides = np.array([row.prismatic for row in self.chain.rows])
        return float((np.where(slides, apart / _SLIDE, wrap(apart)) ** 2).sum())

    def _slider_values(self, _q) -> list[float]:
        return [*self._pose[:3, 3].tolist(), *np.degrees(to_rpy(self._pose)).tolist()]

    def _on_sliders(self, values) -> None:
        self._pose = rigid(from_rpy(*np.radians(values[3:])), values[:3])
        self._solve()


def _excess(violation) -> float:
    return violation.excess / (_SLIDE if violation.prismatic else 1.0)
