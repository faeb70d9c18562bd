"""The closed inverse of each of Pieper's patterns, and of their relatives with fewer joints, from the rows of a table.

The patterns differ in the order of three small problems only. The *turn*: which angle of joint 1 brings a place into
the plane of the arm? The *triangle*: two links and a distance. The *wrist*: three angles that make a rotation. Each has
two answers, and none divides by what may be 0. Where axes 4, 5 and 6 meet: turn, triangle (or slide), wrist. Where axes
2, 3 and 4 are parallel: turn, wrist, triangle. Chapter "Six joints, all the answers" derives and proves them;
`inverse.py` says which one a table has.
"""

from itertools import pairwise

import sympy as sp

from ..dh import DHRow
from .function import Function
from .screws import undone
from .symbolic import wrap

#: The pose of a hand as six-joint inverses take it: the columns n, o, a of its rotation, and its position p (mm).
HAND = sp.symbols("nx ny nz ox oy oz ax ay az px py pz", real=True)

#: The turns about x and about z, 3x3, as functions of their angle.
turned_x, turned_z = sp.rot_ccw_axis1, sp.rot_ccw_axis3

PLACE = sp.symbols("x y z", real=True)
PITCH, YAW = sp.symbols("pitch yaw", real=True)

ANSWERS = "One tuple of joint values (rad; mm where prismatic) for each branch, also where `missing` is not 0."
GAP = "How far (mm) the answer of each branch leaves the hand from its place, turned as wanted; 0 within reach."


# ---- the three small problems, as steps of a generated function ----------------------------------------


class Steps(list):
    """(symbol, expression) pairs for a `Function`."""

    def let(self, name: str, expression):
        """`expression` under a name from here on; itself where it is a number or a symbol."""
        expression = sp.sympify(expression)
        if expression.is_Atom or (-expression).is_Atom:
            return expression
        for symbol, known in self:
            if known == expression:
                return symbol
        symbol = sp.Symbol(name, real=True)
        self.append((symbol, expression))
        return symbol

    def joint(self, name: str, angle, row: DHRow):
        """The joint's value for an angle theta of its row: the offset comes off, and whole turns."""
        turned = isinstance(angle, sp.atan2) and row.theta == 0
        return self.let(name, angle if turned else wrap(angle - row.theta))


def turn(steps: Steps, across, place):
    """The turn: {side: (theta 1, how far ahead the place is then)}, and how far (mm) it is too near to the axis.

    `place` is (x, y) in the base; the arm's plane passes `across` (mm) beside axis 1.
    """
    x, y = place
    rho = steps.let("rho", sp.sqrt(x**2 + y**2))
    azimuth = steps.let("azimuth", sp.atan2(y, x))
    if across == 0:
        return {"front": (azimuth, rho), "back": (azimuth + sp.pi, -rho)}, sp.Integer(0)
    ahead = steps.let("ahead", sp.sqrt(sp.Max(0, (rho - across) * (rho + across))))
    sides = {side: (azimuth + sp.atan2(across, e * ahead), e * ahead) for side, e in (("front", 1), ("back", -1))}
    return sides, steps.let("beside", sp.Max(0, sp.Abs(across) - rho))


def triangle(steps: Steps, name: str, place, upper, fore, up=1):
    """The triangle: {elbow: (direction of the upper arm, bend)}, for links of these lengths that end at `place`.

    `up`: the sign of the bend that is called up.
    """
    x, y = place
    D = steps.let(f"D{name}", (x**2 + y**2 - upper**2 - fore**2) / (2 * upper * fore))
    s = steps.let(f"s{name}", sp.sqrt(sp.Max(0, (1 - D) * (1 + D))))
    mu = steps.let(f"mu{name}", sp.atan2(y, x))
    gamma = steps.let(f"gamma{name}", sp.atan2(fore * s, upper + fore * D))
    bend = steps.let(f"bend{name}", sp.atan2(s, D))
    return {"up": (mu - up * gamma, up * bend), "down": (mu + up * gamma, -up * bend)}


def ring_gap(steps: Steps, name: str, place, upper, fore):
    """How far (mm) `place` lies outside the ring that two links can reach."""
    distance = steps.let(f"d{name}", sp.sqrt(place[0] ** 2 + place[1] ** 2))
    upper, fore = sp.Abs(upper), sp.Abs(fore)
    return sp.Max(0, distance - upper - fore, sp.Abs(upper - fore) - distance)


def both(sideways, inside):
    """Two gaps at a right angle to each other as one."""
    return inside if sideways == 0 else sideways if inside == 0 else sp.sqrt(sideways**2 + inside**2)


def wrist(steps: Steps, name: str, R, twists, first, rows, leaning=(0, 0)):
    """The wrist: {flip: (q of its first joint, q5, q6)} for the rotation `R` that the three joints must make.

    `twists`: the sines of alpha 4 and alpha 5, +1 or -1. `first` names the first angle and its row. The last two angles
    come from the first, and none of them from a division: where axes 4 and 6 are one line, any first angle is right,
    and `leaning` chooses it.
    """
    (symbol, row), (k4, k5) = first, twists
    q4 = steps.joint(f"{symbol}{name}", sp.atan2(k5 * R[1, 2] + leaning[1], k5 * R[0, 2] + leaning[0]), row)
    c, s = sp.cos(q4 + row.theta), sp.sin(q4 + row.theta)
    theta5 = sp.atan2(k5 * (c * R[0, 2] + s * R[1, 2]), -k4 * k5 * R[2, 2])
    k = -k4 * k5
    theta6 = sp.atan2(k * (c * R[1, 0] - s * R[0, 0]), k * (c * R[1, 1] - s * R[0, 1]))
    q5, q6 = steps.joint(f"q5{name}", theta5, rows[4]), steps.joint(f"q6{name}", theta6, rows[5])
    straight = rows[4].theta == 0
    flipped5 = -q5 if straight else wrap(-q5 - 2 * rows[4].theta)
    return {"plain": (q4, q5, q6), "flip": (wrap(q4 + sp.pi), flipped5, wrap(q6 + sp.pi))}


def hand_and_centre(steps: Steps, rows):
    """The rotation before the last row's twist, and the wrist centre in frame 0: fixed in the hand, so known."""
    last, hand = rows[5], sp.eye(4)
    hand[:3, :] = sp.Matrix(4, 3, HAND).T
    if rows.fixed:
        hand = undone(rows.base) * hand * undone(rows.tool)
        names = [f"{column}{axis}0" for axis in "xyz" for column in "noap"]
        hand[:3, :] = sp.Matrix(3, 4, [steps.let(*pair) for pair in zip(names, hand[:3, :], strict=True)])
    R = hand[:3, :3] * turned_x(-last.alpha)
    R = sp.Matrix(3, 3, lambda i, j: steps.let(f"{'noa'[j]}{'xyz'[i]}6", R[i, j]))
    centre = hand[:3, 3] - last.d * R[:, 2] - last.a * R[:, 0]
    # x6 lies a along the hand's own x, which the last twist leaves alone
    return R, [steps.let(f"w{axis}", entry) for axis, entry in zip("xyz", centre, strict=True)]


def in_plane(steps: Steps, name: str, x, y):
    return steps.let(f"x{name}", x), steps.let(f"y{name}", y)


def seen(steps: Steps, name: str, turn, R):
    """`turn` R, entry by entry, with a name for each."""
    found = turn * R
    return sp.Matrix(3, 3, lambda i, j: steps.let(f"r{i + 1}{j + 1}{name}", found[i, j]))


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
