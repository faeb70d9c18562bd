"""`PosePanel`: sliders for the tool's pose, the four IK branches as ghosts, and why a pose cannot be had."""

import math

from ...arm import HOME, LIMITS
from ...dh import Chain
from ...errors import BadInput, JointLimit, OmxError
from ...geometry import COURSE
from ...kinematics import IKSolution, ik, solve_ik
from ...kinematics import pose as tool_pose
from ..viewer.arm_data import branch_names
from ..viewer.view import View
from .branch_panel import NEAREST, BranchPanel
from .panel import as_view, slider_row

_UNITS = ("mm", "mm", "mm", "deg")


class PosePanel(BranchPanel):
    """Sliders for x, y, z (mm) and pitch (deg) under the arm; the arm takes the IK branch that is chosen.

    The other branches are ghosts, in the colours of the table. Where a pose is out of reach or breaks a joint
    limit, the panel says by how much, and the arm stays at its last legal pose. `panel.branch` is `nearest`, or
    a branch by name (`front, elbow up`).
    """

    def __init__(self, view: View | None = None, *, q=HOME, geometry=COURSE, limits=LIMITS):
        view = as_view(view or View(q, geometry=geometry))
        if view.geometry is None:
            raise BadInput(f"a PosePanel shows this book's arm; {view!r} is of another chain.")
        self.geometry, self.limits = view.geometry, limits
        reach = math.ceil(sum((self.geometry.L2, self.geometry.L3, self.geometry.L4)))
        spans = {"x": reach, "y": reach, "z": (-200, math.floor(self.geometry.L1) + reach), "pitch": 120}
        rows = []
        for (name, span), unit in zip(spans.items(), _UNITS, strict=True):
            low, high = span if isinstance(span, tuple) else (-span, span)
            rows.append(slider_row(name, low, high, 0.0, unit))
        view.let_drag(limits, handle=True)
        super().__init__(view, rows, _UNITS, branch_names(), q)

    @property
    def pose(self) -> tuple[float, float, float, float]:
        """The pose asked for: x, y, z (mm) and pitch (rad); the arm may be elsewhere if it is not to be had."""
        return self._pose

    @pose.setter
    def pose(self, value) -> None:
        self._take(value)

    # -- the slots of Panel and BranchPanel ------------------------------------------------------------------

    def _take(self, value) -> None:
        ik(value, self.geometry, self.limits)  # refuses what is no pose before anything moves
        self._ask(tuple(float(v) for v in value))

    def _check(self, q) -> None:
        Chain(self.view.chain.rows, self.limits).check(q)

    def _pose_of(self, q):
        return tuple(tool_pose(q, self.geometry))

    def _answers(self, pose) -> tuple[IKSolution, ...]:
        return ik(pose, self.geometry, self.limits)

    def _slider_values(self, _q) -> list[float]:
        x, y, z, pitch = self._pose
        return [x, y, z, math.degrees(pitch)]

    def _on_sliders(self, values) -> None:
        *position, pitch = values
        self._pose = (*position, math.radians(pitch))
        self._solve()

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
