"""From arcs that cross each other to the boundary of a region: cut them, keep the pieces between in and out, join.

A piece is on the boundary if the region is on one side of it and not on the other, which two tests decide.
"""

from collections.abc import Callable, Sequence
from itertools import pairwise
from math import acos, atan2, hypot, tau

import numpy as np

from ...errors import OmxError
from .arcs import Arc

#: Corners closer than this (mm) are one corner: where arcs only touch, rounding moves a crossing by about 1e-6 mm.
SAME = 1e-4

#: How far beside a piece its two sides are tested: this share of its length, but at most so many mm.
BESIDE, FURTHEST = 1e-3, 1e-5

#: Pieces shorter than this (mm) may be missing where two arcs all but coincide; their neighbours are joined over them.
GAP = 1.0


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
