"""`RowPanel`: four sliders for the four DH parameters of one row."""

import math

from ...dh import DHRow
from ..viewer.dh_row_view import RowView
from . import tables
from .panel import SliderPanel

#: Names, units and ends of the sliders.
_ROWS = (("theta", "deg", -180, 180), ("d", "mm", -150, 150), ("a", "mm", -150, 150), ("alpha", "deg", -180, 180))


class RowPanel(SliderPanel):
    """Sliders for theta, d, a and alpha (deg, mm) under the two frames that they lead from and to, and the matrix A.

    `row` is the `DHRow` shown (mm, rad); set it to move the sliders.
    """

    def __init__(self, row=(0, 0, 0, 0)):
        super().__init__(RowView(), _ROWS)
        self.row = row

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

    def page_data(self) -> dict:
        row = {"kind": "row", "q": [float(v) for v in self.view.row.at(0.0)], "sliders": _ROWS}
        return {**super().page_data(), "panel": row}

    def _heard(self, _change) -> None:
        self.view.row = self.row
        self._write()

    def _write(self) -> None:
        self._text.value = tables.matrix_table(self.view.matrix, "A")
