"""The closed inverse of each of Pieper's patterns, and of their relatives with fewer joints, from the rows of a table.

The patterns differ in the order of the three small problems only. Where axes 4, 5 and 6 meet: turn, triangle (or
slide), wrist. Where axes 2, 3 and 4 are parallel: turn, wrist, triangle. Chapter "Six joints, all the answers" derives
and proves them; `inverse.py` says which one a table has.
"""

from itertools import pairwise

import sympy as sp

from ..dh import DHRow
from .function import Function
from .subproblems import (
    HAND,
    Steps,
    both,
    hand_and_centre,
    in_plane,
    ring_gap,
    seen,
    triangle,
    turn,
    turned_x,
    turned_z,
    wrist,
)

PLACE = sp.symbols("x y z", real=True)
PITCH, YAW = sp.symbols("pitch yaw", real=True)

ANSWERS = "One tuple of joint values (rad; mm where prismatic) for each branch, also where `missing` is not 0."
GAP = "How far (mm) the answer of each branch leaves the hand from its place, turned as wanted; 0 within reach."


# ---- six joints: axes 4, 5 and 6 meet ------------------------------------------------------------------


def spherical(rows) -> list[Function]:
    """`branches` and `missing` where axes 4, 5 and 6 meet: turn, then triangle or slide, then the wrist."""
    first, second, third, fourth = rows[:4]
    k1, k4, k5 = (sp.sin(rows[i].alpha) for i in (0, 3, 4))
    lift = sp.cos(second.alpha) * (third.d + sp.cos(third.alpha) * fourth.d)
    across = k1 * (second.d if third.prismatic else second.d + lift)
    steps, answers, gaps = Steps(), {}, {}
    R, (wx, wy, wz) = hand_and_centre(steps, rows)
    sides, beside = turn(steps, across, (wx, wy))
    for side, (theta1, ahead) in sides.items():
        q1 = steps.joint(f"q1_{side}", theta1, first)
        place = in_plane(steps, f"_{side}", ahead - first.a, k1 * (wz - first.d))
        N = seen(steps, f"_{side}", (turned_z(q1 + first.theta) * turned_x(first.alpha)).T, R)
        arms, gap = (_slid if third.prismatic else _bent)(steps, f"_{side}", place, rows)
        gap = steps.let(f"gap_{side}", both(beside, gap))
        for elbow, (q2, q3, turned) in arms.items():
            name = f"_{side}_{elbow}"
            M = seen(steps, name, turned, N)
            for flip, rest in wrist(steps, name, M, (k4, k5), ("q4", fourth), rows).items():
                answers[f"{name[1:]}_{flip}"], gaps[f"{name[1:]}_{flip}"] = (q1, q2, q3, *rest), gap
    return _functions(HAND, answers, gaps, steps)


def _bent(steps: Steps, name: str, place, rows):
    """{elbow: (q2, q3, the turn from frame 1 to the wrist's)} of an arm with two links, and how far it falls short."""
    second, third = rows[1:3]
    e2 = sp.cos(second.alpha)
    fore, lean = _forearm(rows)
    found = {}
    for elbow, (theta2, bend) in triangle(steps, name, place, second.a, fore, _up(rows, fore)).items():
        q2 = steps.joint(f"q2{name}_{elbow}", theta2, second)
        q3 = steps.joint(f"q3{name}_{elbow}", e2 * (bend - lean), third)
        direction = steps.let(f"fore{name}_{elbow}", theta2 + bend - lean)
        turned = turned_x(-second.alpha - third.alpha) * turned_z(direction).T
        found[elbow] = q2, q3, turned
    return found, ring_gap(steps, name, place, second.a, fore)


def _slid(steps: Steps, name: str, place, rows):
    """{out or in: (q2, d3, the turn from frame 1 to the wrist's)} of an arm with a boom, which never falls short."""
    (x, y), (second, third, fourth) = place, rows[1:4]
    k2 = sp.sin(second.alpha)
    length = steps.let(f"boom{name}", sp.sqrt(x**2 + y**2))
    fixed = turned_x(second.alpha) * turned_z(third.theta) * turned_x(third.alpha)
    found = {}
    for way, e in (("out", 1), ("in", -1)):
        q2 = steps.joint(f"q2{name}_{way}", sp.atan2(e * k2 * x, -e * k2 * y), second)
        d3 = e * length - third.d - sp.cos(third.alpha) * fourth.d
        found[way] = q2, steps.let(f"d3{name}_{way}", d3), fixed.T * turned_z(q2 + second.theta).T
    return found, sp.Integer(0)


def _forearm(rows):
    """Length of the line from elbow to wrist centre, and its direction in the frame that turns with joint 3."""
    third, fourth = rows[2:4]
    along, sideways = third.a, -sp.cos(rows[1].alpha) * sp.sin(third.alpha) * fourth.d
    if sideways == 0:
        return along, sp.Integer(0)
    if along == 0:
        return fourth.d, sp.atan2(sideways / fourth.d, 0)
    return sp.sqrt(along**2 + sideways**2), sp.atan2(sideways, along)


def _up(rows, fore) -> int:
    """The sign of the bend with which the forearm bends down, as chapter 5 calls it `up`, seen from the front."""
    turned = sp.sin(rows[0].alpha) * rows[1].a * fore
    return 1 if turned.is_negative else -1


# ---- six joints: axes 2, 3 and 4 are parallel ----------------------------------------------------------


def parallel(rows) -> list[Function]:
    """`branches` and `missing` where axes 2, 3 and 4 are parallel: turn, then the wrist, then the triangle."""
    first, second, third, fourth = rows[:4]
    k1, k5, e2 = sp.sin(first.alpha), sp.sin(rows[4].alpha), sp.cos(second.alpha)
    sense = e2 * sp.cos(third.alpha)  # of axis 4, seen from axis 2
    k4 = sense * sp.sin(fourth.alpha)
    across = k1 * (second.d + e2 * third.d + sense * fourth.d)
    steps, found = Steps(), {}
    R, (wx, wy, wz) = hand_and_centre(steps, rows)
    sides, beside = turn(steps, across, (wx, wy))
    for side, (theta1, ahead) in sides.items():
        q1 = steps.joint(f"q1_{side}", theta1, first)
        centre = in_plane(steps, f"_{side}", ahead - first.a, k1 * (wz - first.d))
        N = seen(steps, f"_{side}", (turned_z(q1 + first.theta) * turned_x(first.alpha)).T, R)
        leaning = _leaning(steps, f"_{side}", N, centre, rows, k4)
        wrists = wrist(steps, f"_{side}", N, (k4, k5), ("hand", DHRow(0, 0, 0, 0)), rows, leaning)
        hand = wrists["plain"][0]
        for flip, (_, q5, q6) in wrists.items():
            sign, name = (1 if flip == "plain" else -1), f"_{side}_{flip}"
            place = in_plane(steps, name, *_before_hand(centre, hand, sign, rows, k4))
            gap = steps.let(f"gap{name}", both(beside, ring_gap(steps, name, place, second.a, third.a)))
            for elbow, (theta2, bend) in triangle(steps, name, place, second.a, third.a, _up(rows, third.a)).items():
                ending = f"{side}_{elbow}_{flip}"
                theta4 = hand + (sp.pi if sign < 0 else 0) - theta2 - bend
                q2 = steps.joint(f"q2_{ending}", theta2, second)
                q3 = steps.joint(f"q3_{ending}", e2 * bend, third)
                q4 = steps.joint(f"q4_{ending}", sense * theta4, fourth)
                found[ending] = (q1, q2, q3, q4, q5, q6), gap
    order = [f"{side}_{elbow}_{flip}" for side in sides for elbow in ("up", "down") for flip in ("plain", "flip")]
    answers, gaps = ({name: found[name][i] for name in order} for i in (0, 1))
    return _functions(HAND, answers, gaps, steps)


def _leaning(steps: Steps, name: str, R, place, rows, k4):
    """What decides the hand's direction where axis 6 is parallel to axes 2, 3 and 4, and any would be right.

    Not any is within reach. This one has axis 4 as near to axis 2 as it can be, and the other flip as far. It weighs
    1e-12, and nothing as soon as the axes are more than 1e-12 rad from parallel.
    """
    (x, y), (fourth, fifth) = place, rows[3:5]
    if fourth.a == 0 and fifth.d == 0:
        return 0, 0
    size = (sp.Abs(rows[1].a) + sp.Abs(rows[2].a)) * (sp.Abs(fourth.a) + sp.Abs(fifth.d))
    near = sp.Max(0, sp.Float(1e-12) - sp.Abs(R[0, 2]) - sp.Abs(R[1, 2]))
    near = steps.let(f"near{name}", near / size)
    across = k4 * fifth.d
    return near * (fourth.a * x - across * y), near * (fourth.a * y + across * x)


def _before_hand(place, hand, sign: int, rows, k4):
    """Where axis 4 passes the plane: the wrist centre less a4 along the hand's direction and d5 across it."""
    fourth, fifth = rows[3:5]
    c, s = sign * sp.cos(hand), sign * sp.sin(hand)
    return place[0] - fourth.a * c - k4 * fifth.d * s, place[1] - fourth.a * s + k4 * fifth.d * c


# ---- fewer joints --------------------------------------------------------------------------------------


def shoulder_and_plane(rows) -> list[Function]:
    """`branches` and `missing` of a turn and then two or three parallel axes: this book's arm, and its relatives."""
    first, second, third = rows[:3]
    fourth = rows[3] if len(rows) == 4 else DHRow(*[sp.Integer(0)] * 4)
    k1, e2 = sp.sin(first.alpha), sp.cos(second.alpha)
    e3 = sp.cos(third.alpha) if len(rows) == 4 else 0
    x, y, z = PLACE
    across = k1 * (second.d + e2 * third.d + e2 * e3 * fourth.d)
    hand_x, hand_y = fourth.a * sp.cos(PITCH), fourth.a * k1 * sp.sin(PITCH)
    steps, answers, gaps = Steps(), {}, {}
    sides, beside = turn(steps, across, (x, y))
    for side, (theta1, ahead) in sides.items():
        q1 = steps.joint(f"q1_{side}", theta1, first)
        place = in_plane(steps, f"_{side}", ahead - first.a - hand_x, k1 * (z - first.d) - hand_y)
        gap = steps.let(f"gap_{side}", both(beside, ring_gap(steps, f"_{side}", place, second.a, third.a)))
        for elbow, (theta2, bend) in triangle(steps, f"_{side}", place, second.a, third.a, _up(rows, third.a)).items():
            name = f"{side}_{elbow}"
            q2 = steps.joint(f"q2_{name}", theta2, second)
            q3 = steps.joint(f"q3_{name}", e2 * bend, third)
            q4 = steps.joint(f"q4_{name}", e2 * e3 * (k1 * PITCH - theta2 - bend), fourth)
            answers[name], gaps[name] = (q1, q2, q3, q4)[: len(rows)], gap
    return _functions((*PLACE, PITCH)[: len(rows)], answers, gaps, steps)


def all_parallel(rows) -> list[Function]:
    """`branches` and `missing` of axes that are all parallel: one triangle in the plane of the turns.

    `up` is a bend to the right, as seen against the axis of joint 1.
    """
    turning = [i for i, row in enumerate(rows) if not row.prismatic]
    slides = [i for i, row in enumerate(rows) if row.prismatic]
    x, y, z = PLACE
    inputs = [x, y, *([z] if slides else []), *([YAW] if len(turning) == 3 else [])]
    sense = [sp.Integer(1)]  # of each axis, and of z at the hand
    for row in rows:
        sense.append(sense[-1] * sp.cos(row.alpha))
    ends = [-1, *turning, len(rows)]
    fixed = [  # what a slide's own angle turns before each turn, and behind the last
        sum((sense[i] * rows[i].theta for i in slides if start < i < end), sp.Integer(0))
        for start, end in pairwise(ends)
    ]
    upper, fore = rows[turning[0]], rows[turning[1]]
    hand = YAW - fixed[-1]
    last = rows[turning[2]].a if len(turning) == 3 else 0
    begin = x - last * sp.cos(hand), y - last * sp.sin(hand)
    height = sum((sense[i] * row.d for i, row in enumerate(rows)), sp.Integer(0))
    steps, answers = Steps(), {}
    place = in_plane(steps, "_wrist", *begin)
    gap = ring_gap(steps, "_wrist", place, upper.a, fore.a)
    for elbow, (direction, bend) in triangle(steps, "_wrist", place, upper.a, fore.a, -1).items():
        turns = [direction, bend, hand - direction - bend]
        q = {
            i: steps.joint(f"q{i + 1}_{elbow}", sense[i] * (turned - before), rows[i])
            for i, turned, before in zip(turning, turns, fixed, strict=False)
        }
        q |= {i: sense[i] * (z - height) for i in slides}
        answers[elbow] = tuple(q[i] for i in range(len(rows)))
    return _functions(inputs, answers, dict.fromkeys(answers, gap), steps)


def _functions(inputs, answers, gaps, steps) -> list[Function]:
    """Both functions, of one list of steps: each keeps those that it needs."""
    return [
        Function("branches", ANSWERS, inputs, answers, steps),
        Function("missing", GAP, inputs, gaps, steps),
    ]
