"""The circular arcs on which the boundary of the workspace lies, in the arm's plane (r, z).

Turning joint 1 revolves a flat figure, so the plane of the other three joints is enough. A tip can be on the
boundary only where it cannot be moved across it, whichever joint that is not at a limit turns. That leaves three
kinds of curves, and each is the circle that the tip draws while one joint turns and the other two are held:

- both held joints are at limits;
- one is at a limit, and the parts that the free joints move are in line with each other;
- none is at a limit, and all three links are in line.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product
from math import atan2, ceil, cos, hypot, pi, sin, tau

import numpy as np

from ...arm import LIMITS
from ...arrays import as_number
from ...dh import as_limits
from ...geometry import COURSE, Geometry, as_geometry


@dataclass(frozen=True)
class Arc:
    """Part of a circle in the plane (r, z): from the angle `start` to `stop` (rad), anticlockwise if stop > start.

    `centre` and `radius` in mm. `held` says what the arm does there: which joints are held, and where.
    """

    centre: tuple[float, float]
    radius: float
    start: float
    stop: float
    held: str = ""

    @property
    def length(self) -> float:
        """In mm, positive."""
        return self.radius * abs(self.stop - self.start)

    @property
    def ends(self) -> np.ndarray:
        """The first and the last point, (2, 2), mm."""
        return self.at(np.array((self.start, self.stop)))

    def at(self, angle) -> np.ndarray:
        """The points (..., 2), mm, at these angles (rad) around the centre."""
        angle = np.asarray(angle, float)
        r = self.centre[0] + self.radius * np.cos(angle)
        return np.stack((r, self.centre[1] + self.radius * np.sin(angle)), axis=-1)

    def points(self, step: float = 2.0) -> np.ndarray:
        """Points (n, 2), mm, evenly spaced from one end to the other, at most `step` mm apart."""
        step = as_number(step, "step", "a length in mm, more than 0", 1e-6)
        return self.at(np.linspace(self.start, self.stop, 1 + max(1, ceil(self.length / step))))

    def angles_of(self, points) -> np.ndarray:
        """The angle (rad) at which each of the points (..., 2) is seen from the centre, counted on from the start.

        In [low, low + tau), where low is the smaller end: the point is beside the arc if it is not above the larger.
        """
        offset = np.asarray(points, float) - self.centre
        low = min(self.start, self.stop)
        return low + np.mod(np.arctan2(offset[..., 1], offset[..., 0]) - low, tau)

    def distance(self, points) -> np.ndarray:
        """The distance (mm) of each of the points (..., 2) from the arc."""
        points = np.asarray(points, float)
        offset = points - self.centre
        beside = self.angles_of(points) <= max(self.start, self.stop)
        to_ends = np.hypot(*np.moveaxis(points[..., None, :] - self.ends, -1, 0)).min(axis=-1)
        return np.where(beside, np.abs(np.hypot(offset[..., 0], offset[..., 1]) - self.radius), to_ends)

    def part(self, start: float, stop: float) -> "Arc":
        """The same circle between two other angles."""
        return replace(self, start=start, stop=stop)

    def mirrored(self) -> "Arc":
        """The arc on the other side of the axis r = 0, run through the same way (anticlockwise stays so)."""
        r, z = self.centre
        return replace(self, centre=(-r, z), start=pi - self.stop, stop=pi - self.start)


def critical_arcs(geometry: Geometry = COURSE, limits=LIMITS) -> tuple[Arc, ...]:
    """Every arc on which the boundary of the workspace can lie, for q1 = 0: r < 0 is over the arm's back.

    Some of them, or parts of them, run through the inside, where the arm only folds over.
    """
    geometry, limits = as_geometry(geometry), as_limits(limits, 4)
    found = []
    for free, q in _held_configurations(geometry, limits):
        arc = _swept(free, q, limits[free - 1], geometry)
        if arc.radius > 1e-9:
            found.append(arc)
    return tuple(found)


def directions(q2, q3, q4, geometry: Geometry):
    """The angles (rad) above the r axis at which upper arm, forearm and hand point."""
    return 0.5 * pi - geometry.delta - q2, -q2 - q3, -q2 - q3 - q4


def joints(q2, q3, q4, geometry: Geometry) -> list[tuple[float, float]]:
    """Shoulder, elbow, wrist and tip in the plane (r, z), mm."""
    points = [(0.0, geometry.L1)]
    lengths = (geometry.L2, geometry.L3, geometry.L4)
    for length, angle in zip(lengths, directions(q2, q3, q4, geometry), strict=True):
        r, z = points[-1]
        points.append((r + length * cos(angle), z + length * sin(angle)))
    return points


def in_line(geometry: Geometry, limits) -> tuple[list[float], list[float]]:
    """The legal q3 at which forearm and upper arm are in line, and the legal q4 that line up hand and forearm."""
    elbow = [geometry.delta - 0.5 * pi, geometry.delta + 0.5 * pi]
    return _legal(elbow, limits[2]), _legal([0.0, pi], limits[3])


def _held_configurations(geometry: Geometry, limits) -> Iterator[tuple[int, dict[int, float]]]:
    """(free joint, values of the other two) for every critical arc."""
    _, q2_ends, q3_ends, q4_ends = limits
    straight_elbow, straight_wrist = in_line(geometry, limits)
    for q3, q4 in product(q3_ends, q4_ends):
        yield 2, {3: q3, 4: q4}
    for q3 in q3_ends:
        yield from ((2, {3: q3, 4: q4}) for q4 in _legal(_hand_in_line(q3, geometry), limits[3]))
    for q4 in q4_ends:
        yield from ((2, {3: q3, 4: q4}) for q3 in _legal(_elbow_in_line(q4, geometry), limits[2]))
    for q3, q4 in product(straight_elbow, straight_wrist):
        yield 2, {3: q3, 4: q4}
    for q2, q4 in product(q2_ends, (*q4_ends, *straight_wrist)):
        yield 3, {2: q2, 4: q4}
    for q2, q3 in product(q2_ends, q3_ends):
        yield 4, {2: q2, 3: q3}


def _hand_in_line(q3: float, geometry: Geometry) -> list[float]:
    """The two q4 at which the tip is in line with shoulder and wrist."""
    shoulder, _, wrist, _ = joints(0.0, q3, 0.0, geometry)
    q4 = -q3 - _direction(shoulder, wrist)
    return [q4, q4 + pi]


def _elbow_in_line(q4: float, geometry: Geometry) -> list[float]:
    """The two q3 at which the tip is in line with shoulder and elbow."""
    _, elbow, _, tip = joints(0.0, 0.0, q4, geometry)
    q3 = _direction(elbow, tip) - (0.5 * pi - geometry.delta)
    return [q3, q3 + pi]


def _swept(free: int, held: dict[int, float], ends, geometry: Geometry) -> Arc:
    """What the tip draws while joint `free` turns from one of its limits to the other. Joints turn clockwise."""
    low, high = ends
    q = {**held, free: low}
    points = joints(q[2], q[3], q[4], geometry)
    centre, tip = points[free - 2], points[-1]
    angle = _direction(centre, tip)
    text = ", ".join(f"q{joint} = {value:.4g}" for joint, value in sorted(held.items()))
    return Arc(centre, hypot(tip[0] - centre[0], tip[1] - centre[1]), angle - (high - low), angle, text)


def _direction(a, b) -> float:
    return atan2(b[1] - a[1], b[0] - a[0])


def _legal(values, ends) -> list[float]:
    """Those of the angles that are within the limits, whole turns added or taken as needed."""
    low, high = ends
    turned = (low + (value - low) % tau for value in values)
    return [value for value in turned if value <= high]
