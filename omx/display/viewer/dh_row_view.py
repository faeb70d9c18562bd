"""`RowView`: one DH row as four moves from frame {0} to frame {1}. A page without Python draws them by `dh_row.js`."""

import math
from collections.abc import Callable

import numpy as np

from ...arrays import as_four
from ...dh import DHRow, link_matrix
from ..palette import PALE, PALETTE
from . import annotations
from .camera_and_light import Camera
from .scene import Scene
from .threejs import Drawing

#: Length of the frames' axes, radius of the arcs, half the length of the joints' axes, mm.
_MARK, _ARC, _AXIS = 42.0, 75.0, 130.0
#: Colours of what moves along an axis, and of what turns about one.
_ALONG, _ABOUT = PALETTE[4], PALETTE[3]
#: An arrow along z turned along x, and an arc about z from x on turned about x from z on.
_ALONG_X = np.array([[0, 0, 1, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1.0]])
_ABOUT_X = np.array([[0, 0, 1, 0], [0, -1, 0, 0], [1, 0, 0, 0], [0, 0, 0, 1.0]])
_NOTES = "/meshcat/notes"
_ROW = "theta (rad), d (mm), a (mm), alpha (rad)"


class RowView(Scene):
    """The four DH parameters in 3-D: turn by `theta` about z0, go `d` along it, go `a` along x1, twist by `alpha`.

    Lengths in mm, angles in rad in (-pi, pi]. Set `row` to show another one. The grey lines are the axes of the two
    joints. Raises `BadInput`.
    """

    def __init__(self, row=(0, 0, 0, 0), *, height: int = 380, camera: Camera = Camera.ISO):
        super().__init__(height=height, camera=camera, aim=(0.02, 0.045, 0.06), distance=0.6, floor=-80.0)
        self._sizes: dict[str, float] = {}
        with self.channel.batch():
            self.triad("first", np.eye(4), index=0, size=_MARK)
            self.triad("last", np.eye(4), index=1, size=_MARK)
            for name in ("joint_axis", "next_axis"):
                self.path([(0, 0, -_AXIS), (0, 0, _AXIS)], name=name, colour=PALE, radius=0.6)
            for name, letter in (("d", "d"), ("a", "a"), ("theta", "θ"), ("alpha", "α")):
                self.label(f"{name}_name", letter, (0, 0, 0), colour=_ALONG if name == letter else _ABOUT)
            self.row = row

    @property
    def row(self) -> DHRow:
        """The row shown: a `DHRow`, or theta, d, a, alpha."""
        return self._row

    @row.setter
    def row(self, value) -> None:
        self._row = value if isinstance(value, DHRow) else DHRow(*as_four(value, "row", _ROW))
        theta, d, a, alpha = as_four(self._row.at(0.0), "row", _ROW)
        lifted, shifted, end = (link_matrix(*r) for r in ((theta, d, 0, 0), (theta, d, a, 0), (theta, d, a, alpha)))
        with self.channel.batch():
            for name in ("last", "next_axis"):
                self.channel.place(f"{_NOTES}/{name}", end)
            self._move("d", d, np.eye(4), 0.5 * lifted[:3, 3] + (-14, -14, 0))
            self._move("a", a, lifted @ _ALONG_X, 0.5 * (lifted + shifted)[:3, 3] + (0, 0, 13))
            self._turn("theta", theta, np.eye(4))
            self._turn("alpha", alpha, shifted @ _ABOUT_X)

    def _move(self, name: str, length: float, frame, middle) -> None:
        """An arrow along z of `frame`, its name at `middle`."""
        length = length if abs(length) >= 1.0 else 0.0
        self._mark_of(name, length, lambda: annotations.arrow((0, 0, 0), (0, 0, length), _ALONG), frame, middle)

    def _turn(self, name: str, angle: float, frame) -> None:
        """An arc about z of `frame`, from its x on, its name beside its middle."""
        angle = math.atan2(math.sin(angle), math.cos(angle))
        angle = angle if abs(angle) > 0.02 else 0.0
        middle = frame @ (1.18 * _ARC * math.cos(angle / 2), 1.18 * _ARC * math.sin(angle / 2), 0, 1)
        self._mark_of(name, angle, lambda: annotations.turned(_ARC, angle, _ABOUT), frame, middle[:3])

    def _mark_of(self, name: str, size: float, drawing: Callable[[], Drawing], frame, middle) -> None:
        """A mark in `frame`, drawn anew only where its size has changed; there is none of size 0."""
        if size != self._sizes.get(name):
            self._sizes[name] = size
            self._note(name, drawing()) if size else self.remove(name)
        if size:
            self.channel.place(f"{_NOTES}/{name}", frame)
        self.channel.place(f"{_NOTES}/{name}_name", np.block([[np.eye(3), middle[:, None]], [0, 0, 0, 1]]))
        self.channel.set(f"{_NOTES}/{name}_name", "visible", bool(size))

    def _config(self) -> dict:
        return {**super()._config(), "row": {"arc": _ARC, "along": _ALONG, "about": _ABOUT, "pale": PALE}}

    @property
    def matrix(self) -> np.ndarray:
        """The link matrix A of the row, (4, 4), mm: the last frame as the first one sees it."""
        return link_matrix(*as_four(self._row.at(0.0), "row", _ROW))

    def __repr__(self) -> str:
        theta, d, a, alpha = self._row.at(0.0)
        turn, twist = math.degrees(theta), math.degrees(alpha)
        return f"DH row: theta = {turn:.1f} deg, d = {d:.1f} mm, a = {a:.1f} mm, alpha = {twist:.1f} deg"
