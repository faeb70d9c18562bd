"""`RowView`: one DH row as four moves from frame {0} to frame {1}."""

import math

import numpy as np

from ..dh import Chain, DHRow
from ..errors import BadInput
from .annotate import PALETTE
from .scene import Scene
from .stage import Camera

#: Length of the frames' axes, radius of the arcs, half the length of the joints' axes, mm.
_MARK, _ARC, _AXIS = 42.0, 75.0, 130.0
_GREY = "#8a929c"


class RowView(Scene):
    """The four DH parameters in 3-D: turn by `theta` about z0, go `d` along it, go `a` along x1, twist by `alpha`.

    Lengths in mm, angles in rad in (-pi, pi]. Set `row` to show another one. The grey lines are the axes of the two
    joints. Raises `BadInput`.
    """

    def __init__(self, row=(0, 0, 0, 0), *, height: int = 380, dark: bool = False, camera: Camera = Camera.ISO):
        super().__init__(height=height, dark=dark, camera=camera, aim=(0.02, 0.045, 0.06), distance=0.6, floor=-80.0)
        self.row = row

    @property
    def row(self) -> DHRow:
        """The row shown: a `DHRow`, or theta, d, a, alpha."""
        return self._row

    @row.setter
    def row(self, value) -> None:
        self._row = value if isinstance(value, DHRow) else DHRow(*_four(value))
        theta, d, a, alpha = _four(self._row.at(0.0))
        lifted, shifted, end = (_matrix(*r) for r in ((theta, d, 0, 0), (theta, d, a, 0), (theta, d, a, alpha)))
        with self.channel.batch():
            self._line("joint_axis", np.zeros(3), (0, 0, 1), back=_AXIS)
            self._line("next_axis", end[:3, 3], end[:3, 2], back=_AXIS)
            self.triad("first", np.eye(4), index=0, size=_MARK)
            self.triad("last", end, index=1, size=_MARK)
            self._length("d", np.zeros(3), lifted[:3, 3], (-14, -14, 0))
            self._length("a", lifted[:3, 3], shifted[:3, 3], (0, 0, 13))
            self._angle("theta", "θ", np.zeros(3), (1, 0, 0), lifted[:3, 0])
            self._angle("alpha", "α", shifted[:3, 3], shifted[:3, 2], end[:3, 2])

    def __repr__(self) -> str:
        theta, d, a, alpha = self._row.at(0.0)
        turn, twist = math.degrees(theta), math.degrees(alpha)
        return f"DH row: theta = {turn:.1f} deg, d = {d:.1f} mm, a = {a:.1f} mm, alpha = {twist:.1f} deg"

    def _line(self, name: str, point, direction, back: float = 0.0) -> None:
        """A thin line through a point, `back` mm to the one side and an axis' length, or an arc's radius, ahead."""
        direction = np.asarray(direction, float)
        ahead = back or 1.1 * _ARC
        self.path([point - back * direction, point + ahead * direction], name=name, colour=_GREY, radius=0.6)

    def _length(self, name: str, start, end, aside) -> None:
        """An arrow with its name beside it, unless it has no length."""
        if np.linalg.norm(end - start) < 1.0:
            for mark in (name, f"{name}_name"):
                self.remove(mark)
            return
        self.arrow(name, start, end - start, colour=PALETTE[4])
        self.label(f"{name}_name", name, 0.5 * (start + end) + aside, colour=PALETTE[4])

    def _angle(self, name: str, label: str, centre, start, end) -> None:
        """An arc from one direction to another, each drawn as a thin line, unless they agree."""
        if np.dot(start, end) > math.cos(0.02):
            for mark in (name, f"{name}_from", f"{name}_to"):
                self.remove(mark)
            return
        self._line(f"{name}_from", centre, start)
        self._line(f"{name}_to", centre, end)
        self.arc(name, centre, _ARC * np.asarray(start, float), end, label=label, colour=PALETTE[3])


def _matrix(theta, d, a, alpha) -> np.ndarray:
    return Chain([DHRow(theta, d, a, alpha)]).fk([0.0])


def _four(values) -> tuple[float, ...]:
    try:
        numbers = tuple(float(v) for v in values)
    except (TypeError, ValueError):
        numbers = ()
    if len(numbers) != 4 or not all(map(math.isfinite, numbers)):
        raise BadInput(f"`row` must be theta (rad), d (mm), a (mm), alpha (rad): four finite numbers; got {values!r}.")
    return numbers
