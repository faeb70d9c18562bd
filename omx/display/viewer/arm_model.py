"""The OpenMANIPULATOR-X from primitives: one solid a link, each in its own DH frame, mm.

Sizes are those of the maker's parts (an XM430 servo is 28.5 x 46.5 x 34), but every beam is placed between the
frames that the geometry gives, so an arm with other lengths is drawn with other beams. Each link is first
built in a frame of its own, x forward, y left, z up, origin on the joint that moves it, and then moved
into its DH frame. Any other chain is drawn from its DH table alone: cylinders about revolute axes, boxes on prismatic
ones, links between.
"""

import functools
import math

import numpy as np

from ...rotation import rigid
from .mesh import Solid, ball, circle, cone, slot
from .threejs import GHOST, METAL, Drawing

SERVO, SERVO_EDGE, LABEL = (52, 54, 58), (70, 73, 78), (126, 130, 136)
BRACKET, BEAM, BEAM_EDGE = (92, 96, 103), (74, 78, 84), (104, 108, 115)
HORN, SCREW, RAIL = (196, 200, 206), (150, 154, 160), (206, 210, 215)
PLATE, PLATE_HOLE = (170, 174, 180), (104, 108, 114)
PALM, FINGER, RUBBER = (60, 62, 67), (46, 48, 52), (24, 24, 26)

#: XM430: half width, half depth (mm), and how far the body reaches from the horn's axis to either end.
_HALF_WIDTH, _HALF_DEPTH, _NEAR, _FAR = 14.25, 17.0, 11.25, 35.25
_HINGE = 36.0  # from a joint's axis to the outside of the hinge bracket's bridge
_FINGER_TIP = 21.7  # the fingers end this far beyond the tool frame

#: A link's radius as a share of the chain's reach.
SCALE = 0.026

JOINT, SLIDER, LINK, TOOL = (58, 61, 66), (72, 92, 120), (150, 155, 162), (205, 92, 30)

# ---- drawings ------------------------------------------------------------------------------------------------


def is_our_arm(geometry) -> bool:
    """Does the geometry name the lengths of the OpenMANIPULATOR-X, so that it can be drawn as one? None does not."""
    return all(hasattr(geometry, name) for name in ("L1", "L2", "L3", "L4", "delta")) and len(geometry.chain) == 4


def arm_drawings(chain, geometry, with_plate: bool = True) -> dict[int, Drawing]:
    """The OpenMANIPULATOR-X with the lengths of `geometry`; a plain chain where that has none or names others."""
    if not is_our_arm(geometry):
        return chain_drawings(chain)
    out = {i: Drawing().solid(solid, METAL) for i, solid in enumerate(links(geometry))}
    if with_plate:
        out[0].solid(plate(), METAL, casts=False, receives=True)
    return out


def finger_drawings(geometry) -> dict[str, Drawing]:
    """The two fingers, which slide in the last link; none where the arm is drawn as a plain chain."""
    if not is_our_arm(geometry):
        return {}
    return {name: Drawing().solid(s, METAL) for name, s in zip(("left", "right"), fingers(geometry), strict=True)}


def ghost_drawings(chain, geometry, colour) -> dict[int, Drawing]:
    """The same arm in one translucent colour (three integers), without details; what turns about a vertical
    axis alone is left out, because another ghost or the arm itself often stands there."""
    if not is_our_arm(geometry):
        return chain_drawings(chain, colour, opacity=0.35)
    hand = functools.reduce(Solid.add, fingers(geometry), Solid().add(links(geometry)[4]))
    solids = {2: links(geometry)[2], 3: links(geometry)[3], 4: hand}
    return {i: Drawing().solid(s.silhouette(colour), GHOST, opacity=0.3, casts=False) for i, s in solids.items()}


# ---- solids --------------------------------------------------------------------------------------------------


def plate(height: float = -8.0) -> Solid:
    """The aluminium base plate 350 x 300 x 8, its top at z = 0, with its rows of holes."""
    out = Solid().box((-110, -150, height), (240, 150, 0), PLATE, bevel=1.4)
    for x in np.arange(-85, 240, 50):
        for y in np.arange(-125, 150, 50):
            if abs(y) > 30 or x > 40:
                out.stud((x, y), 3.2, -0.2, 0.12, PLATE_HOLE, sides=12)
    return out


@functools.lru_cache(maxsize=8)
def links(geometry) -> tuple[Solid, ...]:
    """The five moving and fixed parts of the arm, link 0 (base) to link 4 (gripper), each in its DH frame."""
    L1, L2, L3, L4 = (float(v) for v in (geometry.L1, geometry.L2, geometry.L3, geometry.L4))
    delta = float(geometry.delta)
    return (
        base(L1),
        turret(L1).moved(_into_frame((0.0, 0.0, L1), 0.0)),
        upper_arm(L2, delta).moved(_into_frame((L2 * math.sin(delta), 0.0, L2 * math.cos(delta)), math.pi / 2 - delta)),
        forearm(L3).moved(_into_frame((L3, 0.0, 0.0), 0.0)),
        wrist(L4).moved(_into_frame((L4, 0.0, 0.0), 0.0)),
    )


def fingers(geometry) -> tuple[Solid, Solid]:
    """The left and the right finger with their palms, in the tool's DH frame, closed to the pads' middle travel."""
    move = _into_frame((float(geometry.L4), 0.0, 0.0), 0.0)
    return tuple(finger(float(geometry.L4), side).moved(move) for side in (1, -1))


def base(shoulder: float) -> Solid:
    """Servo 1 upright in its bracket, on the plate; joint 1's axis is z."""
    top = min(38.0, max(20.0, shoulder - 39.0))
    out = Solid().box((-40, -25, 0), (17, 25, 3.2), BRACKET)
    for y in (-1, 1):
        out.box((-33, y * 14.6, 3), (9, y * 17.2, 0.72 * top), BRACKET)
        for x in (-27, 3):
            out.stud((0.5 * top, x), 1.9, *_span(y, 17.0, 17.9), SCREW, "y", y)
    for x, y in ((-36, 21), (-36, -21), (13, 21), (13, -21)):
        out.stud((x, y), 2.6, 3.2, 4.6, SCREW, "z")
    return out.add(servo(), _pose((0, 0, top - _HALF_DEPTH), x=(1, 0, 0), z=(0, 0, 1)))


def turret(shoulder: float) -> Solid:
    """The bracket that joint 1 turns and servo 2 in it, its horn across (y) at the shoulder."""
    foot = shoulder - _FAR - 1.4
    out = Solid().disc((0, 0), 16.5, foot - 2.2, foot, HORN, bevel=0.5)
    out.prism(slot((-6, 0), (6, 0), 17.5), foot, foot + 3.4, BRACKET, bevel=0.8)
    for x in (-1, 1):
        out.box((x * 14.5, -15, foot), (x * 17.3, 15, foot + 27), BRACKET)
        for y in (-9, 9):
            out.stud((y, foot + 20), 1.9, *_span(x, 17.1, 18.0), SCREW, "x", x)
    return out.add(servo(), _pose((0, 0, shoulder), x=(0, 0, 1), z=(0, 1, 0)))


def upper_arm(length: float, delta: float) -> Solid:
    """Shoulder hinge, beam and servo 3: a dog-leg, the elbow `length` away and leaning forward by `delta`."""
    ex, ez = length * math.sin(delta), length * math.cos(delta)
    if ez < 75 or abs(ex) > 45:  # no room for the maker's dog-leg: a straight link that points at the elbow
        return forearm(length).moved(_turn_y(delta - math.pi / 2))
    out = hinge().moved(_turn_y(-math.pi / 2))
    seat = ez - _HALF_WIDTH - 2.6
    out.add(beam(_HINGE + 2, seat).moved(_turn_y(-math.pi / 2)))
    back = ex - _FAR
    out.box((back - 3, -_HALF_DEPTH, seat - 1), (ex + 7, _HALF_DEPTH, seat + 2), BRACKET)
    out.box((back - 3, -_HALF_DEPTH, seat - 1), (back - 0.4, _HALF_DEPTH, ez + 9), BRACKET)
    for y in (-10, 10):
        out.stud((y, ez + 2), 1.9, back - 3.9, back - 2.8, SCREW, "x", -1)
    return out.add(servo(), _pose((ex, 0, ez), x=(1, 0, 0), z=(0, 1, 0)))


def forearm(length: float) -> Solid:
    """Elbow hinge, beam and servo 4, straight along x."""
    out = hinge()
    back = length - _FAR
    if back > _HINGE + 8:
        out.add(beam(_HINGE + 2, back - 3))
    out.box((back - 3.2, -_HALF_DEPTH, -_HALF_WIDTH), (back - 0.4, _HALF_DEPTH, _HALF_WIDTH), BRACKET)
    for z in (-1, 1):
        out.box((back - 3.2, -13, z * 14.5), (back + 20, 13, z * 17), BRACKET)
        for y in (-8, 8):
            out.stud((back + 13, y), 1.9, *_span(z, 16.8, 17.7), SCREW, "z", z)
    return out.add(servo(), _pose((length, 0, 0), x=(1, 0, 0), z=(0, 1, 0)))


def wrist(length: float) -> Solid:
    """Wrist hinge, the gripper's servo (horn forward), and the front plate with its rail."""
    front = length - 64.0  # the front plate's back
    bridge = min(_HINGE, front - 32)
    out = hinge(bridge)
    if front - 36 > bridge + 8:
        out.add(beam(bridge + 2, front - 36))
    out.add(servo(), _pose((front - _HALF_DEPTH - 2.5, 0, 0), x=(0, 1, 0), z=(1, 0, 0)))
    outline = slot((-52, 0), (52, 0), 12.5)
    out.prism(outline, front, front + 4, BRACKET, "x", bevel=0.8)
    out.box((front + 4, -60, -4.5), (front + 8.5, 60, 4.5), RAIL)
    for y in (-50, -38, 38, 50):
        for z in (-8.3, 8.3):
            out.stud((y, z), 1.8, front + 3.8, front + 4.8, SCREW, "x")
    for y in (-1, 1):
        out.box((front - 16, y * 17, -11), (front + 1, y * 20, 11), BRACKET)
    return out.stud((0, 0), 10, front + 4, front + 7, HORN, "x", 1, 16)


def finger(length: float, side: int) -> Solid:
    """One palm and finger, pads 21 mm from the middle plane, on the left (`side` 1) or the right (-1)."""
    near, tip = length - 56, length + _FINGER_TIP
    out = Solid().box((near, side * 19, -14), (near + 12, side * 47, 14), PALM, bevel=1.5)
    out.box((near + 10, side * 25, -13), (near + 24, side * 45, 13), PALM, bevel=1.5)
    blade = [(near + 10, -12.5), (tip - 12, -12.5), (tip - 3, -8), (tip, -3), (tip, 3), (tip - 3, 8), (tip - 12, 12.5),
             (near + 10, 12.5)]  # fmt: skip
    low, high = _span(side, 26, 33)
    out.prism([(z, x) for x, z in reversed(blade)], low, high, FINGER, "y", bevel=1.0)
    pad = [(tip - 42, -10), (tip - 12, -10), (tip - 5, -6), (tip - 2.5, -2), (tip - 2.5, 2), (tip - 5, 6),
           (tip - 12, 10), (tip - 42, 10)]  # fmt: skip
    low, high = _span(side, 21, 27)
    out.prism([(z, x) for x, z in reversed(pad)], low, high, RUBBER, "y", bevel=1.0)
    for x in (near + 4, near + 9):
        for z in (-9, 9):
            out.stud((z, x), 1.7, *_span(side, 46.6, 47.8), SCREW, "y", side)
    return out


def servo() -> Solid:
    """An XM430: the horn's axis is z through the origin, the body runs along x, from -35.25 to 11.25."""
    w, depth = _HALF_WIDTH, _HALF_DEPTH
    out = Solid().box((-_FAR, -w, -9.5), (_NEAR, w, 9.5), SERVO, bevel=1.2)
    out.box((-_FAR + 0.5, -w + 0.5, 9.9), (_NEAR - 0.5, w - 0.5, depth), SERVO, bevel=1.8)
    out.box((-_FAR + 0.5, -w + 0.5, -depth), (_NEAR - 0.5, w - 0.5, -9.9), SERVO_EDGE, bevel=1.8)
    out.box((-_FAR + 1.2, -w + 1.2, -10.2), (_NEAR - 1.2, w - 1.2, 10.2), SERVO_EDGE, bevel=0.3)
    for end, colour in ((1, HORN), (-1, SERVO_EDGE)):
        out.stud((0, 0), 11.2, *_span(end, depth - 0.4, depth + 2.2), colour, "z", end, 20, detail=False)
        hub = SERVO_EDGE if end > 0 else HORN
        out.stud((0, 0), 4.0, *_span(end, depth + 2.0, depth + 2.8), hub, "z", end, 12)
        for k in range(8):
            out.stud(circle(8.0, 8)[k], 1.15, *_span(end, depth + 2.0, depth + 2.7), SERVO, "z", end, 6)
        for y in (-10.6, 10.6):
            out.stud((-_FAR + 4, y), 1.5, *_span(end, depth - 0.3, depth + 0.35), SCREW, "z", end)
    return out.box((-_FAR + 8, -w + 4.5, -depth - 0.25), (-_FAR + 21, w - 4.5, -depth + 1), LABEL, bevel=0.1)


def hinge(bridge: float = _HINGE) -> Solid:
    """The U-shaped bracket that a horn across y turns: two rounded cheeks and the bridge at x = `bridge`."""
    out = Solid()
    for y in (-1, 1):
        low, high = _span(y, 19.4, 22.0)
        out.prism(slot((0, 0), (0, bridge - 7), 13.5, 8, end_radius=14.5), low, high, BRACKET, "y", bevel=0.7)
        out.stud((0, 0), 7.2, *_span(y, 21.8, 23.0), HORN, "y", y, 18)
        out.stud((0, 0), 2.2, *_span(y, 22.8, 23.8), SERVO_EDGE, "y", y)
        for k in range(4):
            z, x = circle(10.2, 4)[k]
            out.stud((z, x), 1.5, *_span(y, 21.9, 22.7), SCREW, "y", y)
    return out.box((bridge - 2.2, -22.0, -14.5), (bridge + 2.4, 22.0, 14.5), BRACKET)


def beam(start: float, end: float) -> Solid:
    """The slim beam 17 x 32 along x, hollowed like an H, from `start` to `end`."""
    out = Solid().box((start, -12.5, -5.5), (end, 12.5, 5.5), BEAM)
    for y in (-1, 1):
        out.box((start, y * 12, -8.5), (end, y * 16, 8.5), BEAM_EDGE)
    middle = 0.5 * (start + end)
    for x in (middle - 0.28 * (end - start), middle + 0.28 * (end - start)):
        for z in (-1, 1):
            out.stud((x, 0), 3.4, *_span(z, 5.0, 5.7), SERVO, "z", z, 12)
    return out


def _span(side: int, near: float, far: float) -> tuple[float, float]:
    """The interval from `near` to `far` on the positive (1) or negative (-1) side, low end first."""
    return (near, far) if side > 0 else (-far, -near)


def _pose(origin, x, z):
    """A rigid 4x4 from an origin (mm) and two of its axes."""
    return rigid(np.column_stack((x, np.cross(z, x), z)), origin)


def _turn_y(angle: float):
    """A rotation about y; positive pitches x down."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, 0, s, 0], [0, 1, 0, 0], [-s, 0, c, 0], [0, 0, 0, 1.0]])


def _into_frame(origin, rise: float):
    """From a link's building frame to its DH frame at `origin`, whose x axis rises by `rise` (rad) and z is y."""
    c, s = math.cos(rise), math.sin(rise)
    return np.linalg.inv(rigid([[c, s, 0], [0, 0, 1], [s, -c, 0]], origin))


# ---- any other chain -----------------------------------------------------------------------------------------


def chain_drawings(chain, colour=None, opacity: float = 1.0) -> dict[int, Drawing]:
    """One drawing a frame for the joints and links of `chain`, as thick as suits its reach.

    Joint i lies on the z axis of frame i - 1 and is drawn there; the link that it moves (d along that axis, then
    a along x) is drawn in frame i, its far end. A prismatic joint is a box that its link's rod slides through.
    `colour` (three integers) paints it all.
    """
    scale = SCALE * reach(chain)
    solids = {i: Solid() for i in range(len(chain.rows) + 1)}
    for i, row in enumerate(chain.rows):
        _joint(solids[i], row.prismatic, scale)
        _link(solids[i + 1], row, _stroke(chain, i), scale)
    if chain.tool is not None:
        back = np.linalg.inv(chain.tool)
        solids[len(chain.rows)] = solids[len(chain.rows)].moved(back)
        _rod(solids[len(chain.rows)], back[:3, 3], np.zeros(3), scale)
    solids[len(chain.rows)].add(ball((0, 0, 0), 1.7 * scale, TOOL))
    painted = {i: solid if colour is None else solid.silhouette(colour) for i, solid in solids.items()}
    return {i: Drawing().solid(solid, METAL, opacity=opacity) for i, solid in painted.items()}


def reach(chain) -> float:
    """An upper bound of the distance (mm) from the base to the tool; a prismatic joint counts with its stroke."""
    fixed = sum(float(np.linalg.norm(T[:3, 3])) for T in (chain.base, chain.tool) if T is not None)
    return chain.size + fixed + sum(_stroke(chain, i) for i in range(len(chain.rows))) or 100.0


def _stroke(chain, joint: int) -> float:
    """How far (mm) a prismatic joint slides from its zero: its limits, or 100 if it has none; 0 if it turns."""
    if not chain.rows[joint].prismatic:
        return 0.0
    return max((abs(v) for v in (chain.limits or {joint: ()})[joint] if math.isfinite(v)), default=100.0)


def _joint(solid: Solid, prismatic: bool, scale: float) -> None:
    if prismatic:
        half = 2.2 * scale
        solid.box((-half, -half, -1.2 * half), (half, half, 1.2 * half), SLIDER, 0.3 * scale)
    else:
        solid.disc((0, 0), 2.2 * scale, -2.6 * scale, 2.6 * scale, JOINT, bevel=0.3 * scale)
        solid.disc((0, 0), 1.2 * scale, -2.9 * scale, 2.9 * scale, LINK, bevel=0.2 * scale)


def _link(solid: Solid, row, stroke: float, scale: float) -> None:
    """The link of one row, seen from its far frame: back along x by a, then back along the joint's axis by d."""
    a, d, alpha = float(row.a), float(row.d), float(row.alpha)
    corner = np.array((-a, 0.0, 0.0))
    axis = np.array((0.0, math.sin(alpha), math.cos(alpha)))  # the joint's axis, as the far frame sees it
    for start, end in ((corner, np.zeros(3)), (corner - (d + stroke) * axis, corner)):
        _rod(solid, start, end, scale)
    solid.add(ball(corner, 0.95 * scale, LINK))


def _rod(solid: Solid, start, end, scale: float) -> None:
    if np.linalg.norm(end - start) > 1e-6:
        solid.add(cone(start, end, 0.85 * scale, LINK, 20, 0.85 * scale))
