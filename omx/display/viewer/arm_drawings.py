"""From a geometry or a chain to the drawings of its links: the arm itself, and its ghosts."""

import functools

from . import arm_model as arm
from . import skeleton
from .mesh import Solid
from .threejs import GHOST, METAL, Drawing

_LENGTHS = ("L1", "L2", "L3", "L4", "delta")


def arm_drawings(geometry, plate: bool) -> dict[int, Drawing]:
    """The OpenMANIPULATOR-X with the lengths of `geometry`; a plain chain where it names other lengths."""
    if not is_our_arm(geometry):
        return skeleton.drawings(geometry.chain, skeleton.SCALE * skeleton.reach(geometry.chain))
    out = {i: Drawing().solid(solid, METAL) for i, solid in enumerate(_links(geometry))}
    if plate:
        out[0].solid(arm.plate(), METAL, casts=False, receives=True)
    return out


def finger_drawings(geometry) -> dict[str, Drawing]:
    """The two fingers, which slide in the last link; none where the arm is drawn as a plain chain."""
    if not is_our_arm(geometry):
        return {}
    return {name: Drawing().solid(s, METAL) for name, s in zip(("left", "right"), arm.fingers(geometry), strict=True)}


def ghost_drawings(geometry, chain, colour) -> dict[int, Drawing]:
    """The same arm in one translucent colour (three integers), without details; what turns about a vertical
    axis alone is left out, because another ghost or the arm itself often stands there."""
    if geometry is None or not is_our_arm(geometry):
        return skeleton.drawings(chain, skeleton.SCALE * skeleton.reach(chain), colour, opacity=0.35)
    links = list(_links(geometry))
    links[4] = functools.reduce(Solid.add, arm.fingers(geometry), Solid().add(links[4]))
    return {i: Drawing().solid(links[i].silhouette(colour), GHOST, opacity=0.3, casts=False) for i in (2, 3, 4)}


@functools.lru_cache(maxsize=8)
def _links(geometry) -> tuple[Solid, ...]:
    return tuple(arm.links(geometry))


def is_our_arm(geometry) -> bool:
    """Does the geometry name the lengths of the OpenMANIPULATOR-X, so that it can be drawn as one?"""
    return all(hasattr(geometry, name) for name in _LENGTHS) and len(geometry.chain) == 4
