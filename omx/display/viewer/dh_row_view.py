"""`RowView`: one DH row as four moves from frame {0} to frame {1}.

Every mark is drawn once, in a place of its own, and then only moved, and shown or hidden. So a page without Python
can do the same: omx/display/panels/dh_row_panel.js has `places` once more.
"""

import math

import numpy as np

from ...arrays import as_four
from ...dh import Chain, DHRow
from ..palette import PALE, PALETTE
from . import annotations
from .environment import Camera
from .linkage import column_major
from .moving_parts import put_object, put_property, put_transform
from .scene import Scene
from .threejs import Drawing

#: Length of the frames' axes, radius of the arcs, half the length of the joints' axes, mm.
_MARK, _ARC, _AXIS = 42.0, 75.0, 130.0
#: Length of an arrow's head, and of the rod behind it as it is drawn, before it is stretched, mm.
_HEAD, _ROD = 10.4, 100.0
#: Arcs of so many degrees, one after the other, make an arc of any whole number.
_PIECES = (128, 64, 32, 16, 8, 4, 2, 1)
_NOTES = "/meshcat/notes"
_ROW = "theta (rad), d (mm), a (mm), alpha (rad)"


class RowView(Scene):
    """The four DH parameters in 3-D: turn by `theta` about z0, go `d` along it, go `a` along x1, twist by `alpha`.

    Lengths in mm, angles in rad in (-pi, pi]. Set `row` to show another one. The grey lines are the axes of the two
    joints. Raises `BadInput`.
    """

    def __init__(self, row=(0, 0, 0, 0), *, height: int = 380, dark: bool = False, camera: Camera = Camera.ISO):
        super().__init__(height=height, dark=dark, camera=camera, aim=(0.02, 0.045, 0.06), distance=0.6, floor=-80.0)
        with self.channel.batch():
            self.triad("first", np.eye(4), index=0, size=_MARK)
            for name, drawing in _drawings().items():
                put_object(self.channel, f"{_NOTES}/{name}", drawing)
            self.row = row

    @property
    def row(self) -> DHRow:
        """The row shown: a `DHRow`, or theta, d, a, alpha."""
        return self._row

    @row.setter
    def row(self, value) -> None:
        self._row = value if isinstance(value, DHRow) else DHRow(*as_four(value, "row", _ROW))
        nodes, shown = places(as_four(self._row.at(0.0), "row", _ROW))
        with self.channel.batch():
            for name, matrix in nodes.items():
                put_transform(self.channel, f"{_NOTES}/{name}", column_major(matrix))
            for name, visible in shown.items():
                put_property(self.channel, f"{_NOTES}/{name}", "visible", visible)

    @property
    def matrix(self) -> np.ndarray:
        """The link matrix A of the row, (4, 4), mm: the last frame as the first one sees it."""
        return _matrix(*as_four(self._row.at(0.0), "row", _ROW))

    def __repr__(self) -> str:
        theta, d, a, alpha = self._row.at(0.0)
        turn, twist = math.degrees(theta), math.degrees(alpha)
        return f"DH row: theta = {turn:.1f} deg, d = {d:.1f} mm, a = {a:.1f} mm, alpha = {twist:.1f} deg"


# ---- what is drawn once ----------------------------------------------------------------------------------


def _drawings() -> dict[str, Drawing]:
    """Every mark by its name, where it is drawn: arrows along z, arcs about z from x on."""
    axis = annotations.polyline([(0, 0, -_AXIS), (0, 0, _AXIS)], PALE, 0.6)
    out = {"joint_axis": axis, "next_axis": axis, "last": annotations.triad(1, _MARK)}
    for name in ("d", "a"):
        out |= {f"{name}/rod": annotations.rod(_ROD, PALETTE[4]), f"{name}/head": annotations.head(_HEAD, PALETTE[4])}
        out[f"{name}_name"] = Drawing().label(name, (0, 0, 0), PALETTE[4])
    line = annotations.polyline([(0, 0, 0), (1.1 * _ARC, 0, 0)], PALE, 0.6)
    for name, letter in (("theta", "θ"), ("alpha", "α")):
        out |= {f"{name}/from": line, f"{name}/to": line, f"{name}/head": annotations.arc_head(_ARC, PALETTE[3])}
        out |= {f"{name}/{size}": annotations.arc_piece(_ARC, size, PALETTE[3]) for size in _PIECES}
        out[f"{name}/name"] = Drawing().label(letter, (0, 0, 0), PALETTE[3])
    return out


# ---- what changes with the row -----------------------------------------------------------------------------

_FLIP = np.diag((1.0, -1.0, -1.0, 1.0))
#: An arrow along z turned along x, and an arc about z from x on turned about x from z on.
_ALONG_X = np.array([[0, 0, 1, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1.0]])
_ABOUT_X = np.array([[0, 0, 1, 0], [0, -1, 0, 0], [1, 0, 0, 0], [0, 0, 0, 1.0]])


def places(row) -> tuple[dict, dict]:
    """Where each mark of the row (theta, d, a, alpha; mm, rad) stands, (4, 4) mm by its name, and which are shown."""
    theta, d, a, alpha = row
    lifted, shifted, end = (_matrix(*r) for r in ((theta, d, 0, 0), (theta, d, a, 0), (theta, d, a, alpha)))
    nodes, shown = {"next_axis": end, "last": end}, {}
    for name, frame, length in (("d", np.eye(4), d), ("a", lifted @ _ALONG_X, a)):
        nodes |= _arrow(name, frame, length)
        shown[name] = shown[f"{name}_name"] = abs(length) >= 1.0
    nodes["d_name"] = _shift(0.5 * lifted[:3, 3] + (-14, -14, 0))
    nodes["a_name"] = _shift(0.5 * (lifted + shifted)[:3, 3] + (0, 0, 13))
    for name, frame, angle in (("theta", np.eye(4), theta), ("alpha", shifted @ _ABOUT_X, alpha)):
        angle = math.atan2(math.sin(angle), math.cos(angle))
        nodes |= _arc(name, frame if angle > 0 else frame @ _FLIP, abs(angle))
        left = _length_of_arc(angle)
        shown |= {name: abs(angle) > 0.02, f"{name}/head": abs(angle) > 0.1}
        shown |= {f"{name}/{size}": bool(left & size) for size in _PIECES}
    return nodes, shown


def _arrow(name: str, frame, length: float) -> dict:
    """An arrow along z of `frame`: its rod is stretched, its head is pushed to the end."""
    head = min(0.4 * abs(length), _HEAD)
    rod = max(abs(length) - head, 1e-3)
    return {name: frame if length > 0 else frame @ _FLIP, f"{name}/rod": np.diag((1, 1, rod / _ROD, 1)),
            f"{name}/head": _shift((0, 0, rod)) @ np.diag((1, 1, max(head, 1e-3) / _HEAD, 1))}  # fmt: skip


def _arc(name: str, frame, angle: float) -> dict:
    """An arc about z of `frame`, from its x to `angle` (rad): whole pieces one after the other, and a head."""
    left, start = _length_of_arc(angle), 0
    out = {name: frame, f"{name}/to": _turn(angle), f"{name}/head": _turn(angle)}
    out[f"{name}/name"] = _shift(1.18 * _ARC * np.array((math.cos(angle / 2), math.sin(angle / 2), 0)))
    for size in _PIECES:
        out[f"{name}/{size}"] = _turn(math.radians(start))
        start += left & size
    return out


def _length_of_arc(angle: float) -> int:
    """Of how many whole degrees an arc is, when its head takes the last two."""
    return max(0, int(math.degrees(abs(angle)) + 1e-9) - 2)


def _matrix(theta, d, a, alpha) -> np.ndarray:
    return Chain([DHRow(theta, d, a, alpha)]).fk([0.0])


def _turn(angle: float) -> np.ndarray:
    return _matrix(angle, 0, 0, 0)


def _shift(to) -> np.ndarray:
    out = np.eye(4)
    out[:3, 3] = to
    return out
