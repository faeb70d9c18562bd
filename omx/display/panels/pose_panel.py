"""`PosePanel`: sliders for the tool's pose, the four IK branches as ghosts, and why a pose cannot be had."""

import math

import ipywidgets

from ...arm import HOME, LIMITS
from ...dh import Chain
from ...errors import JointLimit, OmxError
from ...geometry import COURSE
from ...kinematics import IKSolution, ik, solve_ik
from ...kinematics import pose as tool_pose
from ..palette import PALETTE
from ..viewer.arm_data import branch_names
from ..viewer.view import View
from . import tables
from .panel import Panel, side_by_side, slider_row

#: The branch that is nearest to where the arm is.
NEAREST = "nearest"
_UNITS = ("mm", "mm", "mm", "deg")


class PosePanel(Panel):
    """Sliders for x, y, z (mm) and pitch (deg) under the arm; the arm takes the IK branch that is chosen.

    The other branches are ghosts, in the colours of the table. Where a pose is out of reach or breaks a joint
    limit, the panel says by how much, and the arm stays at its last legal pose. `panel.branch` is `nearest`, or
    a branch by name (`front, elbow up`).
    """

    def __init__(self, view: View | None = None, *, q=HOME, geometry=COURSE, limits=LIMITS):
        view = view or View(q, geometry=geometry)
        self.geometry, self.limits = view.geometry or geometry, limits
        reach = math.ceil(sum((self.geometry.L2, self.geometry.L3, self.geometry.L4)))
        spans = {"x": reach, "y": reach, "z": (-200, math.floor(self.geometry.L1) + reach), "pitch": 120}
        made = {}
        for (name, span), unit in zip(spans.items(), _UNITS, strict=True):
            low, high = span if isinstance(span, tuple) else (-span, span)
            made[name] = slider_row(name, low, high, 0.0, unit)
        self.sliders = [slider for slider, _ in made.values()]
        for slider in self.sliders:
            slider.observe(self._heard, "value")
        self._choice = ipywidgets.Dropdown(options=[NEAREST, *branch_names()], description="branch")
        self._choice.style.description_width = "48px"
        self._choice.observe(lambda _: self._solve(), "value")
        view.let_drag(limits, handle=True)
        self._text, self._notice = ipywidgets.HTML(), ipywidgets.HTML()
        self._solutions, self._chosen, self._message = (), None, ""
        controls = ipywidgets.VBox([row for _, row in made.values()] + [self._choice])
        super().__init__(view, [side_by_side(controls, self._text), self._notice], q)

    def __repr__(self) -> str:
        return f"PosePanel: {self.view!r}"

    @property
    def pose(self) -> tuple[float, float, float, float]:
        """The pose asked for: x, y, z (mm) and pitch (rad); the arm may be elsewhere if it is not to be had."""
        return self._pose

    @pose.setter
    def pose(self, value) -> None:
        ik(value, self.geometry, self.limits)  # refuses what is no pose before anything moves
        self._pose = tuple(float(v) for v in value)
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
    def solutions(self) -> tuple[IKSolution, ...]:
        """The four branches of the pose asked for."""
        return self._solutions

    @property
    def message(self) -> str:
        """Why the arm did not follow, or nothing."""
        return self._message

    # -- the slots of Panel ---------------------------------------------------------------------------------

    def _static_data(self) -> dict:
        sliders = [(s.description, unit, s.min, s.max) for s, unit in zip(self.sliders, _UNITS, strict=True)]
        return {"kind": "pose", "geometry": list(self.geometry.values), "limits": list(self.limits), "sliders": sliders,
                "branches": branch_names(), "colours": PALETTE[:4]}  # fmt: skip

    def _check(self, q) -> None:
        Chain(self.view.chain.rows, self.limits).check(q)

    def _place(self, q) -> None:
        """Joint values set from outside: ask for the pose that they give, in the branch that they are in."""
        self._pose = tuple(tool_pose(q, self.geometry))
        self._set_sliders(None)
        self._command(q)
        if self.branch == NEAREST:
            self._solve(command=False)
        else:
            self.branch = NEAREST

    def _dragged(self, pose, _q) -> None:
        self.pose = pose

    def _slider_values(self, _q) -> list[float]:
        x, y, z, pitch = self._pose
        return [x, y, z, math.degrees(pitch)]

    def _on_sliders(self, values) -> None:
        *position, pitch = values
        self._pose = (*position, math.radians(pitch))
        self._solve()

    # -- solving ---------------------------------------------------------------------------------------------

    def _solve(self, command: bool = True) -> None:
        self._solutions = ik(self._pose, self.geometry, self.limits)
        self._message, self._chosen = "", None
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

    def _choose(self) -> IKSolution:
        if self.branch == NEAREST:
            return solve_ik(self._pose, self._q, self.geometry, self.limits)
        solution = self._solutions[branch_names().index(self.branch)]
        if not any(s.reachable for s in self._solutions):
            return solve_ik(self._pose, self._q, self.geometry, self.limits)  # raises, and names the nearest pose
        if not solution.reachable:
            raise OmxError(f"With {solution.branch}, {solution.missing:.3f} mm are missing.")
        if not solution.legal:
            raise JointLimit(solution.violations, [v.limit for v in solution.violations], solution.branch)
        return solution

    def _write(self) -> None:
        self._text.value = tables.branch_table(self._solutions, PALETTE, self._chosen)
        self._notice.value = tables.notice(self._message, good=not self._message)
