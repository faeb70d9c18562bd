"""Marks in the scene: labelled frames, arrows, polylines, a target. All sizes in mm."""

import math
import re
from itertools import cycle

import numpy as np

from ...arrays import shown
from ...errors import BadInput
from ..palette import AXES, INK, NAMES, PALE, PALETTE, VERMILION
from .mesh import Solid, ball, cone, tube
from .threejs import FLAT, ON_TOP, Drawing

_LABELLED = {**FLAT, **ON_TOP, "side": 0}


def rgb(colour) -> tuple[int, int, int]:
    """`#rrggbb`, `#rgb`, or one of `NAMES`, as three integers; `BadInput` otherwise."""
    red, green, blue = bytes.fromhex(as_hex(colour)[1:])
    return red, green, blue


def as_hex(colour) -> str:
    """The same as `#rrggbb`."""
    digits = NAMES.get(colour.lower(), colour) if isinstance(colour, str) else ""
    digits = re.sub("[^#]", r"\g<0>\g<0>", digits) if len(digits) == 4 else digits
    if re.fullmatch("#[0-9a-fA-F]{6}", digits):
        return digits
    raise BadInput(f"`colour` must be '#rrggbb', or one of {', '.join(NAMES)}; got {shown(colour)}.")


def triad(index: int | None = None, size: float = 55.0) -> Drawing:
    """Three arrows x, y, z from the origin, drawn over everything; with `index`, each labelled (x_2, frame {2})."""
    out = Drawing()
    arrows = Solid()
    for k, axis in enumerate(np.eye(3)):
        arrows.add(arrow_solid((0, 0, 0), size * axis, rgb(AXES[k]), 0.022 * size + 0.4))
    arrows.add(ball((0, 0, 0), 0.05 * size, (40, 44, 50)))
    out.solid(arrows, _LABELLED, casts=False, order=10)
    if index is not None:
        for letter, axis, colour in zip("xyz", np.eye(3), AXES, strict=True):
            out.label(f"{letter}_{index}", 1.17 * size * axis, colour)
        out.label(f"{{{index}}}", (-0.2 * size,) * 3, INK, 13)
    return out


def arrow_solid(start, end, colour, radius: float) -> Solid:
    """A round arrow from `start` to `end` (3,)."""
    start, end = np.asarray(start, float), np.asarray(end, float)
    length = float(np.linalg.norm(end - start))
    neck = end - (end - start) / length * min(0.4 * length, 6.5 * radius)
    return cone(start, neck, radius, colour, 12, radius).add(cone(neck, end, 2.6 * radius, colour))


def arrow(start, end, colour=INK, label: str | None = None, radius: float = 1.6) -> Drawing:
    """An arrow, drawn over everything, with its label beyond the middle."""
    start, end = np.asarray(start, float), np.asarray(end, float)
    return _mark(arrow_solid(start, end, rgb(colour), radius), label, 0.5 * (start + end) + (0, 0, 7), colour)


def arc(centre, start, end, colour=INK, label: str | None = None, radius: float = 1.1) -> Drawing:
    """The angle from direction `start` to direction `end` about `centre`; the length of `start` is its radius."""
    centre, start, end = (np.asarray(v, float) for v in (centre, start, end))
    size = np.linalg.norm(start)
    u = start / size
    across = end - u * (u @ end)
    angle = math.atan2(np.linalg.norm(across), u @ end)
    v = across / max(np.linalg.norm(across), 1e-12)
    solid = _bow(centre, u, v, angle, size, rgb(colour), radius)
    middle = centre + 1.18 * size * (math.cos(angle / 2) * u + math.sin(angle / 2) * v)
    return _mark(solid, label, middle, colour)


def axis(point, direction, length: float, colour, label: str | None = None) -> Drawing:
    """A joint's axis: a thin line of `length` with `point` in its middle, its head where `direction` points.

    An arc about it shows the positive turn by the right-hand rule.
    """
    point, z = np.asarray(point, float), _unit(np.asarray(direction, float))
    start, end, size = point - 0.5 * length * z, point + 0.5 * length * z, 0.09 * length
    solid = arrow_solid(start, end, rgb(colour), 0.9)
    x = _unit(np.cross(z, np.eye(3)[np.argmin(np.abs(z))]))
    solid.add(_bow(end - 1.6 * size * z, x, np.cross(z, x), 1.6 * math.pi, size, rgb(colour), 1.0))
    return _mark(solid, label, end + 0.6 * size * z, colour)


def turned(size: float, angle: float, colour, radius: float = 1.1) -> Drawing:
    """A turn by `angle` (rad) about z, from x on: an arc of radius `size` between two thin lines."""
    solid = _bow(np.zeros(3), np.eye(3)[0], np.sign(angle) * np.eye(3)[1], abs(angle), size, rgb(colour), radius)
    for end in (0.0, angle):
        solid.add(tube([(0, 0, 0), (1.1 * size * math.cos(end), 1.1 * size * math.sin(end), 0)], 0.6, rgb(PALE)))
    return _mark(solid)


def _mark(solid: Solid, label: str | None = None, at=(0, 0, 0), colour=INK) -> Drawing:
    """A solid drawn over everything, with its label at `at` (3,)."""
    out = Drawing().solid(solid, _LABELLED, casts=False, order=11)
    return out.label(label, at, as_hex(colour)) if label else out


def _bow(centre, u, v, angle: float, size: float, colour, radius: float) -> Solid:
    """An arc about `centre` from the direction `u` towards `v` (3,), with its head."""
    turn = np.linspace(0, angle, max(3, int(angle / 0.08)))[:, None]
    points = centre + size * (np.cos(turn) * u + np.sin(turn) * v)
    solid = tube(points[:-1] if len(points) > 3 else points, radius, colour)
    if angle > 0.1:
        solid.add(cone(points[-1] - 4 * radius * _unit(points[-1] - points[-2]), points[-1], 2.4 * radius, colour))
    return solid


def regions(figures) -> Drawing:
    """Translucent figures with their rims; each is an outline (n, 2) or a pair (outline, list of holes)."""
    out = Drawing()
    for figure, colour in zip(figures, cycle(PALETTE), strict=False):
        outline, holes = figure if isinstance(figure, tuple) and len(figure) == 2 else (figure, ())
        out.region(outline, holes, int(colour[1:], 16), opacity=0.22)
        for loop in (np.asarray(one, float) for one in (outline, *holes)):
            loop = loop[:-1] if np.array_equal(loop[0], loop[-1]) else loop
            points = np.column_stack((np.repeat(loop, 2, 0), np.zeros(2 * len(loop))))
            out.lines(np.roll(points, -1, 0), np.tile(rgb(colour), (len(points), 1)))
    return out


def polyline(points, colour=VERMILION, radius: float = 1.2, on_top: bool = False) -> Drawing:
    """A round line through `points` (n, 3)."""
    solid = tube(points, radius, rgb(colour))
    return Drawing().solid(solid, _LABELLED if on_top else {**FLAT, "side": 0}, casts=False, order=5)


def thing(width: float, height: float, is_round: bool, colour) -> Drawing:
    """A box or a round thing about the origin, upright, its square tag on top. `colour` grey if nobody knows it."""
    try:
        colour = rgb(colour)
    except BadInput:
        colour = rgb(PALE)
    half, top = width / 2, height / 2
    solid = Solid()
    if is_round:
        solid.disc((0, 0), half, -top, top, colour)
    else:
        solid.box((-half, -half, -top), (half, half, top), colour)
    tag = 0.9 * half / (math.sqrt(2) if is_round else 1)
    solid.box((-tag, -tag, top - 0.5), (tag, tag, top + 0.2), rgb("white"), 0.1)
    solid.box((-0.7 * tag, -0.7 * tag, top), (0.7 * tag, 0.7 * tag, top + 0.3), rgb(INK), 0.1)
    solid.box((-0.7 * tag, 0, top), (0, 0.7 * tag, top + 0.4), rgb("white"), 0.1)
    return Drawing().solid(solid)


def target(size: float = 42.0) -> Drawing:
    """A target marker: a triad in a ring and a translucent ball, at the origin of its node."""
    out = triad(None, size)
    angle = np.linspace(0, 2 * math.pi, 49)[:-1]
    ring = 22 * np.column_stack((np.zeros(48), np.cos(angle), np.sin(angle)))
    out.solid(tube(ring, 1.3, rgb(VERMILION), closed=True), _LABELLED, casts=False, order=9)
    return out.solid(ball((0, 0, 0), 9, rgb(VERMILION)), FLAT, opacity=0.35, order=8)


def _unit(v):
    return v / max(float(np.linalg.norm(v)), 1e-12)
