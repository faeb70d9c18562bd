"""`JointPanel`: one slider a joint, and the tool's pose as it follows."""

import math

import ipywidgets

from ...arm import HOME
from ...dh import Chain, clipped
from ...errors import BadInput
from ...kinematics import pose as tool_pose
from ..viewer.arm_data import joint_sliders, slider_ends
from ..viewer.arm_model import is_our_arm
from ..viewer.view import View
from . import tables
from .panel import Panel, as_view


class JointPanel(Panel):
    """Joint sliders in degrees (mm where prismatic) under the arm, with T, x, y, z and pitch as they change.

    `view`: a `View` to drive, the arm's or any chain's; a new one if left out. `limits`: one (low, high) a joint,
    rad. Arrow keys move a slider by one degree, page keys by more; a number can be typed into its box. `terms` shows r
    and z term by term, each in the colour of its link, and the DH table: who points at a row sees its frame.
    """

    def __init__(self, view: View | None = None, *, q=None, limits=None, terms=False):
        view = as_view(view or View(HOME if q is None else q))
        chain = view.chain
        limits = chain.limits if limits is None else Chain(chain.rows, limits).limits
        ends = slider_ends(chain, limits)
        self.chain = Chain(chain.rows, ends, chain.names, chain.name, chain.base, chain.tool)
        view.let_drag(self.chain.limits, handle=False)
        self._terms = self._with_terms(view) if terms else None
        q = clipped(view.q, self.chain.limits) if q is None else q
        beside = [self._terms] if terms else []
        super().__init__(view, joint_sliders(self.chain, ends), q, below=[self._buttons(view)], beside=beside)

    def _with_terms(self, view: View) -> tables.DHTable:
        """The DH table of the arm, whose bones get their colours. Raises `BadInput` for another chain."""
        if not is_our_arm(view.geometry):
            raise BadInput("`terms` are those of the OpenMANIPULATOR-X; this view shows another chain.")
        view.bones()
        self._shown = view.shown_frames
        view.frames(*range(len(view.chain) + 1))
        view.shown_frames = self._shown
        table = tables.DHTable(html=tables.dh_table(view.chain))
        table.observe(lambda change: self._light(view, change["new"]), "lit")
        self._light(view, 0)
        return table

    def _light(self, view: View, row: int) -> None:
        """All frames are in the scene; seen are those that were asked for, and that of `row`, 1 for the first."""
        seen = {*self._shown, row} if row else self._shown
        with view.channel.batch():
            for i in range(len(view.chain) + 1):
                view.channel.set(f"/meshcat/frames/{i}", "visible", i in seen)

    def _buttons(self, view: View):
        poses = {"zero": clipped((0.0,) * len(self.chain), self.chain.limits)}  # or the limit nearest to it
        if view.geometry is not None:
            poses["home"] = HOME
        buttons = []
        for name, q in poses.items():
            button = ipywidgets.Button(description=name, tooltip=f"Go to the {name} pose")
            button.layout.width = "80px"
            button.on_click(lambda _, q=q: setattr(self, "q", q))
            buttons.append(button)
        return ipywidgets.HBox(buttons)

    def page_data(self) -> dict:
        data = {"q": self.q, "kind": "joints", **({"section": True} if self.view.has_section else {})}
        if self._terms is not None:
            told = {"words": tables.TERMS, "colours": tables.TERM_COLOURS, "table": self._terms.html}
            data["terms"] = {**told, "shown": self._shown}
        return {**super().page_data(), "panel": data}

    def _on_sliders(self, values) -> None:
        rows = zip(values, self.chain.rows, strict=True)
        self._command(tuple(v if row.prismatic else math.radians(v) for v, row in rows))

    def _slider_values(self, q) -> list[float]:
        return [v if row.prismatic else math.degrees(v) for v, row in zip(q, self.chain.rows, strict=True)]

    def _write(self) -> None:
        T = self.view.chain.fk(self._q)
        values = [(n, float(T[i, 3]), "mm") for i, n in enumerate("xyz")]
        if self.view.geometry is not None:
            values.append(("pitch", math.degrees(tool_pose(self._q, self.view.geometry).pitch), "deg"))
        formula = tables.sums(self.view.chain.frames(self._q)) if self._terms is not None else ""
        self._text.value = formula + tables.matrix_table(T) + tables.value_table(values)
