"""The exact section of the workspace: closed loops of circular arcs, with its area, volume, reach and holes."""

from collections.abc import Sequence
from functools import cached_property
from math import acos, ceil, pi, tau
from typing import NamedTuple

import numpy as np

from ...arm import LIMITS
from ...arrays import as_number, as_rows
from ...dh import as_limits
from ...errors import BadInput
from ...geometry import COURSE, Geometry, as_geometry
from .arcs import Arc, critical_arcs
from .arrangement import boundary_loops
from .reach import reaches

#: Gauss's nodes and weights on [-1, 1]: exact to the last bits for a quarter of a circle.
NODES, WEIGHTS = np.polynomial.legendre.leggauss(16)

#: The most cells side by side.
MOST_CELLS = 20_000


class Grid(NamedTuple):
    """Square cells: `r` (n,) and `z` (m,) are their centres (mm), `inside` (m, n) says which are reached."""

    r: np.ndarray
    z: np.ndarray
    inside: np.ndarray


class Section:
    """A plane figure bounded by arcs. `loops`: tuples of `Arc`s, end to end, with the figure on their left.

    So a loop around the figure runs anticlockwise and a loop around a hole clockwise. Made by `section`.
    """

    def __init__(self, loops: Sequence[Sequence[Arc]]):
        self.loops = tuple(tuple(loop) for loop in loops)

    def __repr__(self) -> str:
        counted = f"{len(self.arcs)} arcs, {len(self.holes)} hole{'s' * (len(self.holes) != 1)}"
        return f"{type(self).__name__}({counted}, {self.area / 100:.1f} cm2)"

    @property
    def arcs(self) -> tuple[Arc, ...]:
        """The arcs of all loops."""
        return tuple(arc for loop in self.loops for arc in loop)

    @cached_property
    def area(self) -> float:
        """In mm2, holes taken out; exact to rounding, by Green's theorem."""
        return sum(map(_enclosed, self.loops))

    @cached_property
    def holes(self) -> tuple[float, ...]:
        """The area (mm2) of each hole, the largest first."""
        return tuple(sorted((-area for area in map(_enclosed, self.loops) if area < 0), reverse=True))

    @cached_property
    def moment(self) -> float:
        """The integral of |r| over the figure (mm3): what one radian of turning sweeps, by Pappus's theorem."""
        return sum(_integral(arc, lambda r: 0.5 * r * np.abs(r)) for arc in self.arcs)

    @cached_property
    def bounds(self) -> tuple[float, float, float, float]:
        """The smallest and the largest r, the smallest and the largest z (mm)."""
        points = np.vstack([_extremes(arc) for arc in self.arcs])
        return tuple(float(v) for pair in zip(points.min(axis=0), points.max(axis=0), strict=True) for v in pair)

    def contains(self, points) -> np.ndarray:
        """Which of the points (..., 2), r and z in mm, are inside: an odd number of arcs lies to the left of them."""
        points = as_rows(points, "points", 2, "r and z in mm")
        return np.sum(self._crossings(points[..., 1]) < points[..., :1], axis=-1) % 2 == 1

    def fill(self, step: float = 1.0) -> Grid:
        """Square cells of side `step` (mm) over the section, each decided exactly, at its centre."""
        r_low, r_high, z_low, z_high = self.bounds
        r, z = centres(r_low, r_high, step), centres(z_low, z_high, step)
        columns = np.ceil((self._crossings(z) - r[0]) / step)  # the first cell to the right of each crossing
        columns = np.clip(np.nan_to_num(columns, nan=len(r)), 0, len(r)).astype(int)
        flips = np.zeros((len(z), len(r) + 1), dtype=int)
        np.add.at(flips, (np.arange(len(z))[:, None], columns), 1)
        return Grid(r, z, np.cumsum(flips, axis=1)[:, :-1] % 2 == 1)

    def distance(self, points) -> np.ndarray:
        """The distance (mm) of each of the points (..., 2) from the boundary."""
        points = as_rows(points, "points", 2, "r and z in mm")
        return np.min([arc.distance(points) for arc in self.arcs], axis=0)

    def polygons(self, step: float = 2.0) -> list[np.ndarray]:
        """The loops as polygons (n, 2), mm, corners at most `step` apart: the largest outline first, holes last."""
        ordered = sorted(self.loops, key=_enclosed, reverse=True)
        return [np.vstack([arc.points(step)[:-1] for arc in loop]) for loop in ordered]

    def _crossings(self, z) -> np.ndarray:
        """Where the horizontal lines at heights z (...) cross the arcs: r (..., twice the arcs), NaN where not."""
        found = []
        for arc in self.arcs:
            low, high = sorted((arc.start, arc.stop))
            with np.errstate(invalid="ignore"):
                up = np.arcsin((z - arc.centre[1]) / arc.radius)
            for angle in (up, pi - up):
                crossed = np.mod(angle - low, tau) < high - low
                found.append(np.where(crossed, arc.centre[0] + arc.radius * np.cos(angle), np.nan))
        return np.stack(found, axis=-1)


class ArmSection(Section):
    """The section of an arm's workspace: what the tip reaches with q1 = 0, r < 0 over the arm's back."""

    def __init__(self, geometry: Geometry = COURSE, limits=LIMITS):
        self.geometry, self.limits = geometry, limits
        self.critical = critical_arcs(geometry, limits)
        super().__init__(boundary_loops(self.critical, self._reached))

    @cached_property
    def both_sides(self) -> Section:
        """The section together with its mirror image in the axis r = 0: what half a turn of q1 brings into it."""
        arcs = [*self.critical, *(arc.mirrored() for arc in self.critical)]
        return Section(boundary_loops(arcs, lambda p: self._reached(p) | self._reached(p * (-1.0, 1.0))))

    @property
    def volume(self) -> float:
        """The space that the tip reaches (mm3): the section turned from one limit of q1 to the other.

        Where the arm can reach both to the front and over its back, points are counted once.
        """
        low, high = self.limits[0]
        turn = min(high - low, tau)
        if turn <= pi:
            return turn * self.moment  # front and back do not meet yet
        both = self.moment - 0.5 * self.both_sides.moment  # reached to the front and over the back
        return turn * self.moment - 2.0 * (turn - pi) * both

    def _reached(self, points):
        return reaches(points, self.geometry, self.limits)


def section(geometry: Geometry = COURSE, limits=LIMITS) -> ArmSection:
    """The exact section of the workspace of an arm with these lengths and joint limits.

    Raises `BadInput` unless the limits of q2, q3 and q4 are (low, high), low < high, less than a turn apart.
    """
    geometry, limits = as_geometry(geometry), as_limits(limits, 4)
    for name, (low, high) in zip(("q2", "q3", "q4"), limits[1:], strict=True):
        if not 0.0 < high - low < tau:
            raise BadInput(f"the limits of {name} must be (low, high) in rad, less than a turn; got ({low}, {high}).")
    return ArmSection(geometry, limits)


def centres(low: float, high: float, step: float) -> np.ndarray:
    """The centres of cells of size `step` that cover low .. high, the borders at whole multiples of `step`."""
    step = as_number(step, "step", "the side of a cell in mm, more than 0", 1e-6)
    if (high - low) / step > MOST_CELLS:
        raise BadInput(
            f"`step` = {step:g} mm makes {(high - low) / step:.1e} cells in a row; the most are {MOST_CELLS}."
        )
    first = np.floor(low / step)
    return (np.arange(first, max(np.ceil(high / step), first + 1)) + 0.5) * step


def _enclosed(loop) -> float:
    """The area (mm2) that a loop encloses, negative if it runs clockwise."""
    return sum(_integral(arc, lambda r: r) for arc in loop)


def _integral(arc: Arc, function) -> float:
    """The integral of function(r) dz along an arc."""
    cuts = [*np.linspace(arc.start, arc.stop, 1 + ceil(abs(arc.stop - arc.start) / 1.5)), *_axis_crossings(arc)]
    cuts = np.sort(cuts) if arc.stop > arc.start else np.sort(cuts)[::-1]
    middle, half = 0.5 * (cuts[1:] + cuts[:-1]), 0.5 * np.diff(cuts)
    angle = middle[:, None] + half[:, None] * NODES
    r = arc.centre[0] + arc.radius * np.cos(angle)
    return float(np.sum(half[:, None] * WEIGHTS * function(r) * arc.radius * np.cos(angle)))


def _axis_crossings(arc: Arc) -> list[float]:
    """The angles at which an arc crosses r = 0."""
    if abs(arc.centre[0]) >= arc.radius:
        return []
    low, high = sorted((arc.start, arc.stop))
    angle = acos(-arc.centre[0] / arc.radius)
    turned = (low + (a - low) % tau for a in (angle, -angle))
    return [a for a in turned if a < high]


def _extremes(arc: Arc) -> np.ndarray:
    """The ends of an arc, and those of its four outermost points that it goes through."""
    low, high = sorted((arc.start, arc.stop))
    turned = low + np.mod(np.arange(4) * 0.5 * pi - low, tau)
    return np.vstack((arc.ends, arc.at(turned[turned <= high])))
