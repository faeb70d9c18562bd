"""`RowPanel`: four sliders for the four DH parameters of one row."""

import math

import ipywidgets

from ...dh import DHRow
from ..viewer.dh_row_view import RowView
from . import tables
from .panel import ViewPanel, side_by_side, slider_row

#: Names, units and ranges of the sliders.
_SLIDERS = (("theta", "deg", 180.0), ("d", "mm", 150.0), ("a", "mm", 150.0), ("alpha", "deg", 180.0))


class RowPanel(ViewPanel):
    """Sliders for theta, d, a and alpha (deg, mm) under the two frames that they lead from and to, and the matrix A.

    `row` is the `DHRow` shown (mm, rad); set it to move the sliders.
    """

    def __init__(self, row=(0, 0, 0, 0)):
        rows = [slider_row(name, -size, size, 0.0, unit) for name, unit, size in _SLIDERS]
        self.sliders = [slider for slider, _ in rows]
        self._text = ipywidgets.HTML()
        lines = ipywidgets.VBox([line for _, line in rows])
        view = RowView(row)
        super().__init__(view, [view.widget, side_by_side(lines, self._text)])
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
        self._write()

    def _static_data(self) -> dict:
        sliders = [(name, unit, -size, size) for name, unit, size in _SLIDERS]
        return {"kind": "row", "q": [float(v) for v in self.view.row.at(0.0)], "sliders": sliders}

    def _heard(self, _change) -> None:
        self.view.row = self.row
        self._write()

    def _write(self) -> None:
        self._text.value = tables.matrix_table(self.view.matrix, "A")
