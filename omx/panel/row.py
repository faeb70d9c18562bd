"""`RowPanel`: four sliders for the four DH parameters of one row."""

import math

import ipywidgets

from ..dh import DHRow
from ..view.row import RowView
from ..view.scene import mimebundle
from .base import slider_row

#: Names, units and ranges of the sliders.
_SLIDERS = (("theta", "deg", 180.0), ("d", "mm", 150.0), ("a", "mm", 150.0), ("alpha", "deg", 180.0))


class RowPanel(ipywidgets.VBox):
    """Sliders for theta, d, a and alpha (deg, mm) under the two frames that they lead from and to.

    `row` is the `DHRow` shown (mm, rad); set it to move the sliders.
    """

    def __init__(self, row=(0, 0, 0, 0)):
        self.view = RowView(row)
        rows = [slider_row(name, -size, size, 0.0, unit) for name, unit, size in _SLIDERS]
        self.sliders = [slider for slider, _ in rows]
        super().__init__([self.view.widget, *(line for _, line in rows)])
        self.row = row
        for slider in self.sliders:
            slider.observe(self._heard, "value")

    @property
    def row(self) -> DHRow:
        """The row that the sliders stand for, mm and rad."""
        theta, d, a, alpha = (slider.value for slider in self.sliders)
        return DHRow(math.radians(theta), d, a, math.radians(alpha))

    @row.setter
    def row(self, value) -> None:
        self.view.row = value
        theta, d, a, alpha = self.view.row.at(0.0)
        for slider, number in zip(self.sliders, (math.degrees(theta), d, a, math.degrees(alpha)), strict=True):
            slider.value = number

    def __repr__(self) -> str:
        return f"RowPanel: {self.view!r}"

    def static_html(self, *, shared: bool = False) -> str:
        """The scene without a kernel; the sliders need one."""
        return self.view.static_html(shared=shared)

    def _heard(self, _change) -> None:
        self.view.row = self.row

    def _repr_mimebundle_(self, **_) -> dict:
        return mimebundle(self.view, self)
