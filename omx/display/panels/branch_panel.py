"""`BranchPanel`: what panels that ask an inverse share: sliders for a pose, a choice of branch, ghosts, verdicts."""

from itertools import cycle

import ipywidgets

from ...errors import OmxError
from ..palette import PALETTE
from ..viewer.view import View
from . import tables
from .panel import Panel, side_by_side

#: The branch that is nearest to where the arm is.
NEAREST = "nearest"


class BranchPanel(Panel):
    """Sliders for a pose under the arm, which takes the branch that is chosen; the others are ghosts.

    A panel of its own says which pose belongs to joint values (`_pose_of`), which answers to a pose (`_answers`), which
    of them the arm takes (`_choose`, or `OmxError`: then the arm stays), and how a pose is asked for (`_take`).
    `rows`: sliders with their lines, in `units`.
    """

    def __init__(self, view: View, rows, units, branches, q):
        self._units = units
        self.sliders = [slider for slider, _ in rows]
        for slider in self.sliders:
            slider.observe(self._heard, "value")
        self._choice = ipywidgets.Dropdown(options=[NEAREST, *branches], description="branch")
        self._choice.style.description_width = "48px"
        self._choice.observe(lambda _: self._keep(), "value")
        self._text, self._notice = ipywidgets.HTML(), ipywidgets.HTML()
        self._solutions, self._chosen, self._message = (), None, ""
        controls = ipywidgets.VBox([*(line for _, line in rows), self._choice])
        super().__init__(view, [side_by_side(controls, self._text), self._notice], q)

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

    def _static_data(self) -> dict:
        sliders = [(s.description, unit, s.min, s.max) for s, unit in zip(self.sliders, self._units, strict=True)]
        return {"kind": "pose", "sliders": sliders}

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

    def _ask(self, pose) -> None:
        """Ask for `pose` from outside the sliders, which follow."""
        self._pose = pose
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
        self._tell(None)

    def _write(self) -> None:
        self._text.value = tables.branch_table(self._solutions, cycle(PALETTE), self._chosen)
        self._notice.value = tables.notice(self._message or self._remark(), good=not self._message)

    def _remark(self) -> str:
        """What is worth saying of an answer that the arm has taken."""
        return ""
