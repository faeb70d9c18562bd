"""The exact section of the workspace: closed loops of circular arcs, with its area, volume, reach and holes.

From arcs that cross each other to the boundary of a region: cut them, keep the pieces between in and out, join. A piece
is on the boundary if the region is on one side of it and not on the other, which two tests decide.
"""

from collections.abc import Callable, Sequence
from functools import cached_property
from itertools import pairwise
from math import acos, atan2, ceil, hypot, pi, tau
from typing import NamedTuple

import numpy as np

from ...arm import LIMITS
from ...arrays import as_number, as_rows
from ...dh import as_limits
from ...errors import BadInput, OmxError
from ...geometry import COURSE, Geometry, as_geometry
from .arcs import Arc, critical_arcs
from .reach import reaches

#: Gauss's nodes and weights on [-1, 1]: exact to the last bits for a quarter of a circle.
NODES, WEIGHTS = np.polynomial.legendre.leggauss(16)

#: The most cells side by side.
MOST_CELLS = 20_000

#: Corners closer than this (mm) are one corner: where arcs only touch, rounding moves a crossing by about 1e-6 mm.
SAME = 1e-4

#: How far beside a piece its two sides are tested: this share of its length, but at most so many mm.
BESIDE, FURTHEST = 1e-3, 1e-5

#: Pieces shorter than this (mm) may be missing where two arcs all but coincide; their neighbours are joined over them.
GAP = 1.0


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
        (r_low, z_low), (r_high, z_high) = points.min(axis=0).tolist(), points.max(axis=0).tolist()
        return r_low, r_high, z_low, z_high

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
    low, high = as_number(low, "low", "a number in mm"), as_number(high, "high", "a number in mm")
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
    evenly = np.linspace(arc.start, arc.stop, 1 + ceil(abs(arc.stop - arc.start) / 1.5))
    cuts = np.sort([*evenly, *_axis_crossings(arc)])
    cuts = cuts if arc.stop > arc.start else cuts[::-1]
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


# ---- the boundary among the arcs ----------------------------------------------------------------------------


def boundary_loops(arcs: Sequence[Arc], inside: Callable[[np.ndarray], np.ndarray]) -> list[list[Arc]]:
    """The boundary of the region where `inside` is true, if it lies on `arcs`: closed loops, the region on the left.

    `inside` takes points (n, 2) and returns booleans (n,). Raises `OmxError` where the pieces leave a gap.
    """
    pieces = [piece for arc in arcs for piece in _cut(arc, arcs)]
    angles = np.array([0.5 * (piece.start + piece.stop) for piece in pieces])
    middles = np.array([piece.at(angle) for piece, angle in zip(pieces, angles, strict=True)])
    beside = np.minimum(BESIDE * np.array([piece.length for piece in pieces]), FURTHEST)
    outward = beside[:, None] * np.column_stack((np.cos(angles), np.sin(angles)))
    within, beyond = inside(middles - outward), inside(middles + outward)
    boundary = [
        piece if near else piece.part(piece.stop, piece.start)
        for piece, near, far in zip(pieces, within, beyond, strict=True)
        if near != far
    ]
    return [_merged(loop) for loop in _joined(_without_doubles(boundary))]


def _cut(arc: Arc, arcs: Sequence[Arc]) -> list[Arc]:
    """`arc` in pieces, cut wherever another one ends on it, touches it or crosses it."""
    cuts = [arc.start, arc.stop]
    same = SAME / arc.radius
    meetings = [angle for other in arcs for angle in _ends_on(arc, other)]  # these first: they are the more exact
    meetings += [angle for other in arcs for angle in _crossings(arc, other)]
    for angle in meetings:
        angle = arc.start + (angle - arc.start) % tau
        if angle < arc.stop and all(abs(angle - cut) > same for cut in cuts):
            cuts.append(angle)
    cuts.sort()
    return [arc.part(a, b) for a, b in pairwise(cuts)]


def _ends_on(arc: Arc, other: Arc) -> list[float]:
    """The angles on the circle of `arc` at which `other` ends on it."""
    offsets = (other.ends - arc.centre).tolist()
    return [atan2(z, r) for r, z in offsets if abs(hypot(r, z) - arc.radius) < 1e-7]


def _crossings(arc: Arc, other: Arc) -> list[float]:
    """The angles on the circle of `arc` at which the circle of `other` crosses it."""
    r, z = other.centre[0] - arc.centre[0], other.centre[1] - arc.centre[1]
    apart = hypot(r, z)
    if apart < 1e-9:
        return []
    cosine = (arc.radius**2 + apart**2 - other.radius**2) / (2.0 * arc.radius * apart)
    if abs(cosine) > 1.0:
        return []
    towards, half = atan2(z, r), acos(cosine)
    return [towards - half, towards + half]


def _without_doubles(pieces: list[Arc]) -> list[Arc]:
    """Each piece once, where arcs of the same circle lie on each other."""
    kept: list[Arc] = []
    middles: list[np.ndarray] = []
    for piece in pieces:
        middle = piece.at(0.5 * (piece.start + piece.stop))
        if not any(np.abs(middle - other).max() < SAME for other in middles):
            kept.append(piece)
            middles.append(middle)
    return kept


def _joined(pieces: list[Arc]) -> list[list[Arc]]:
    """The pieces end to end, as closed loops: each is followed by the one that starts nearest to its end."""
    rest, found = list(pieces), []
    while rest:
        loop = [rest.pop()]
        while True:
            end = loop[-1].ends[1]
            gaps = [float(np.abs(piece.ends[0] - end).max()) for piece in (loop[0], *rest)]
            if min(gaps) > GAP:
                raise OmxError(f"the boundary has a gap at r, z = ({end[0]:.3f}, {end[1]:.3f}) mm: arcs are missing.")
            nearest = gaps.index(min(gaps))
            if nearest == 0:
                break
            loop.append(rest.pop(nearest - 1))
        found.append(loop)
    return found


def _merged(loop: list[Arc]) -> list[Arc]:
    """The loop with neighbouring pieces of one circle made one."""
    merged: list[Arc] = []
    for piece in loop:
        last = merged[-1] if merged else None
        if last and _same_circle(last, piece) and abs((last.stop - piece.start + 1.0) % tau - 1.0) * last.radius < SAME:
            merged[-1] = last.part(last.start, last.stop + piece.stop - piece.start)
        else:
            merged.append(piece)
    return merged


def _same_circle(one: Arc, other: Arc) -> bool:
    apart = hypot(one.centre[0] - other.centre[0], one.centre[1] - other.centre[1])
    turned = (one.stop - one.start) * (other.stop - other.start)
    return apart < SAME and abs(one.radius - other.radius) < SAME and turned > 0
