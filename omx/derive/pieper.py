"""Closed inverses by Pieper's patterns: which of them a DH table has, and the inverse of that table as a module.

Three small problems are enough, and the patterns differ in their order only. The *turn*: which angle of joint 1 brings
the wrist centre into the plane of the arm? The *triangle*: two links and a distance (or a slide). The *wrist*: three
angles that make a rotation. Each has two answers. Chapter "Six joints, all the answers" derives and proves all three.
"""

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from itertools import pairwise
from types import ModuleType

import sympy as sp

from ..arrays import shown
from ..dh import Chain, DHRow, exact_transform
from ..errors import BadInput
from .function import Function
from .store import write
from .symbolic import exact, wrap

#: The pose of a hand as six-joint inverses take it: the columns n, o, a of its rotation, and its position p (mm).
HAND = sp.symbols("nx ny nz ox oy oz ax ay az px py pz", real=True)
PLACE = sp.symbols("x y z", real=True)
PITCH, YAW = sp.symbols("pitch yaw", real=True)

#: A length below this share of the table's longest is 0: 0.1 - 0.3 + 0.2 is meant to be.
TINY = sp.Float(1e-12)

ANSWERS = "One tuple of joint values (rad; mm where prismatic) for each branch, also where `missing` is not 0."
GAP = "How far (mm) the answer of each branch leaves the hand from its place, turned as wanted; 0 within reach."


SLANTING = (
    "axes 4, 5 and 6 meet in one point, as Pieper asks, but not at right angles: such a hand cannot be turned "
    "everywhere, and its wrist is not written here"
)


@dataclass(frozen=True)
class Pattern:
    """What `pattern` found: falsy if none. `str` of it is the reason, in a sentence.

    `name`: `spherical wrist`, `three parallel axes`, `shoulder and plane`, `all axes parallel`, or `none`. `axes`: the
    numbers of the axes that make it so. `branches`: their names, in the order of the module's answers.
    """

    name: str
    reason: str
    axes: tuple[int, ...] = ()
    branches: tuple[str, ...] = ()
    functions: Callable[[], list[Function]] | None = field(default=None, repr=False, compare=False)

    def __bool__(self) -> bool:
        return self.functions is not None

    def __str__(self) -> str:
        return self.reason


def pattern(chain: Chain) -> Pattern:
    """Which of Pieper's patterns, or of their smaller relatives for fewer joints, a table has; or why none.

    Twists must be numbers; lengths may be symbols, which then stand for any value but 0. Raises `BadInput`.
    """
    return patterns(chain)[0]


def patterns(chain: Chain) -> tuple[Pattern, ...]:
    """Every pattern of the table, for there are arms that have two; at least one, the last of which may be none."""
    rows = _rows(chain)
    if len(rows) == 6:
        return _six(rows)
    if rows.fixed:
        return (_none("with fewer than six joints, x, y, z and an angle are told in frame 0: leave base and tool off"),)
    if len(rows) <= 4 and all(_flat(row) for row in rows[:-1]):
        return (_all_parallel(rows),)
    if len(rows) in (3, 4):
        return (_shoulder_and_plane(rows),)
    return (_none(_too_few_or_many(len(rows))),)


def write_inverse(
    name: str,
    chain: Chain,
    *,
    by: Pattern | None = None,
    doc: str = "",
    notebook: str | None = None,
    folder: str | os.PathLike | None = None,
    parameters: Mapping[sp.Symbol, object] | None = None,
) -> ModuleType:
    """Write `<name>.py` and `.js` with `branches` and `missing` of a table that has a pattern; return the former.

    Entries of the rows may be numbers or SymPy expressions; `parameters` gives each symbol in them its value. `by` is
    the pattern to use, where the table has two. What the chain has as `base` and `tool` is in the formulas, not in
    `dh_rows`. The other arguments are those of `write`. Raises `BadInput`, with the reason, for a table that has none.
    """
    known = patterns(chain)
    found = known[0] if by is None else by
    if found not in known:
        raise BadInput(f"`by` must be one of the patterns of {chain.name}; got {shown(by)}.")
    if found.functions is None:
        raise BadInput(f"{chain.name} has no inverse of this kind: {found.reason}.")
    return write(
        name,
        found.functions(),
        notebook=notebook,
        folder=folder,
        doc=doc or f"Inverse kinematics of {chain.name}: {found.reason}.",
        parameters=dict(parameters or {}),
        rows=[exact(row) for row in chain.rows],
        branches=found.branches,
    )


# ---- looking at a table ---------------------------------------------------------------------------------


def _rows(chain) -> "_Rows":
    """The rows, exact, with lengths that rounding left as nearly 0 made 0, and sines and cosines of twists known."""
    if not isinstance(chain, Chain):
        raise BadInput(f"`chain` must be an omx.Chain; got {shown(chain)}.")
    rows = [exact(row) for row in chain.rows]
    for number, row in enumerate(rows, start=1):
        if row.alpha.free_symbols:
            raise BadInput(f"alpha of row {number} of {chain.name} is {row.alpha}; a pattern needs twists in numbers.")
    lengths = [abs(x) for row in rows for x in (row.d, row.a) if x.is_number]
    least = TINY * max(lengths, default=1)
    clean = [(x if not x.is_number or abs(x) > least else sp.Integer(0)) for row in rows for x in (row.d, row.a)]
    return _Rows(chain, [
        DHRow(row.theta, d, a, row.alpha, row.prismatic)
        for row, d, a in zip(rows, clean[::2], clean[1::2], strict=True)
    ])  # fmt: skip


class _Rows(list):
    """The rows of a table, and what is fixed around them."""

    def __init__(self, chain: Chain, rows):
        super().__init__(rows)
        self.fixed = chain.base is not None or chain.tool is not None
        self.base, self.tool = exact_transform(chain.base), exact_transform(chain.tool)


def _flat(row) -> bool:
    """Are this joint's axis and the next one parallel?"""
    return sp.sin(row.alpha) == 0


def _square(row) -> bool:
    """Are they at a right angle?"""
    return sp.cos(row.alpha) == 0


def _none(reason: str) -> Pattern:
    return Pattern("none", reason)


def _too_few_or_many(joints: int) -> str:
    if joints > 6:
        return (
            f"it has {joints} joints, and a hand needs six: where it can go, it can go in infinitely many ways; fix "
            "one joint and ask again"
        )
    return (
        f"with {joints} joints it needs axes that are all parallel, or a turn and then parallel axes (three or four "
        "joints); it has neither"
    )


def _six(rows) -> tuple[Pattern, ...]:
    wrist, parallel = _why_no_wrist(rows), _why_not_parallel(rows)
    found = [look(rows) for look, why in ((_spherical, wrist), (_parallel, parallel)) if not why]
    if found:
        return tuple(sorted(found, key=lambda one: not one))
    if wrist == SLANTING:
        return (_none(SLANTING),)
    others = _other_three(rows)
    if others:
        return (_none(f"{others}, which is Pieper's condition, but not at the wrist, where {wrist}"),)
    return (
        _none(
            f"{wrist}, and {parallel}: no three neighbouring axes meet in one point or are parallel. Such an arm may "
            "have up to 16 answers, and they need a numerical method"
        ),
    )


def _why_no_wrist(rows) -> str:
    """What keeps axes 4, 5 and 6 from meeting at right angles; empty if nothing does."""
    if any(row.prismatic for row in rows[3:]):
        return "a joint of the wrist slides"
    if rows[3].a != 0:
        return f"axes 4 and 5 are {rows[3].a} mm apart (a of row 4)"
    if rows[4].a != 0:
        return f"axes 5 and 6 are {rows[4].a} mm apart (a of row 5)"
    if _flat(rows[3]) or _flat(rows[4]):
        return f"axes {'4 and 5' if _flat(rows[3]) else '5 and 6'} are parallel"
    if rows[4].d != 0:
        return f"axis 6 misses the crossing of axes 4 and 5 by {rows[4].d} mm (d of row 5)"
    if not (_square(rows[3]) and _square(rows[4])):
        return SLANTING
    return ""


def _why_not_parallel(rows) -> str:
    """What keeps axes 2, 3 and 4 from being parallel, with a shoulder and a wrist around them; empty if nothing."""
    if any(row.prismatic for row in rows):
        return "a joint slides"
    if not (_flat(rows[1]) and _flat(rows[2])):
        return "axes 2, 3 and 4 are not parallel"
    if rows[1].a == 0 or rows[2].a == 0:
        return "two of the axes 2, 3 and 4 are one and the same"
    for number in (1, 4, 5):
        if not _square(rows[number - 1]):
            return f"axes {number} and {number + 1} are not at a right angle"
    if rows[4].a != 0:
        return f"axes 5 and 6 are {rows[4].a} mm apart (a of row 5)"
    return ""


def _other_three(rows) -> str:
    for i in (1, 2, 3):
        first, second = rows[i - 1], rows[i]
        turning = not any(row.prismatic for row in rows[i - 1 : i + 2])
        if turning and first.a == second.a == second.d == 0 and not _flat(first) and not _flat(second):
            return f"axes {i}, {i + 1} and {i + 2} meet in one point"
    for i in (1, 3, 4):
        if not any(row.prismatic for row in rows[i - 1 : i + 2]) and _flat(rows[i - 1]) and _flat(rows[i]):
            return f"axes {i}, {i + 1} and {i + 2} are parallel"
    return ""


# ---- the three small problems ---------------------------------------------------------------------------


class _Steps(list):
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


def _turn(steps: _Steps, across, place, row: DHRow):
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
    return sides, sp.Max(0, sp.Abs(across) - rho)


def _triangle(steps: _Steps, name: str, place, upper, fore, up=1):
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


def _ring_gap(steps: _Steps, name: str, place, upper, fore):
    """How far (mm) `place` lies outside the ring that two links can reach."""
    distance = steps.let(f"d{name}", sp.sqrt(place[0] ** 2 + place[1] ** 2))
    upper, fore = sp.Abs(upper), sp.Abs(fore)
    return sp.Max(0, distance - upper - fore, sp.Abs(upper - fore) - distance)


def _both(sideways, inside):
    """Two gaps at a right angle to each other as one."""
    return inside if sideways == 0 else sideways if inside == 0 else sp.sqrt(sideways**2 + inside**2)


def _wrist(steps: _Steps, name: str, R, k4, k5, first, rows, leaning=(0, 0)):
    """The wrist: {flip: (q of its first joint, q5, q6)} for the rotation `R` that the three joints must make.

    `k4`, `k5`: the sines of the twists, +1 or -1. `first` names the first angle and its row. The last two angles come
    from the first, and none of them from a division: where axes 4 and 6 are one line, any first angle is right, and
    `leaning` chooses it.
    """
    symbol, row = first
    q4 = steps.joint(f"{symbol}{name}", sp.atan2(k5 * R[1, 2] + leaning[1], k5 * R[0, 2] + leaning[0]), row)
    c, s = sp.cos(q4 + row.theta), sp.sin(q4 + row.theta)
    theta5 = sp.atan2(k5 * (c * R[0, 2] + s * R[1, 2]), -k4 * k5 * R[2, 2])
    k = -k4 * k5
    theta6 = sp.atan2(k * (c * R[1, 0] - s * R[0, 0]), k * (c * R[1, 1] - s * R[0, 1]))
    q5, q6 = steps.joint(f"q5{name}", theta5, rows[4]), steps.joint(f"q6{name}", theta6, rows[5])
    straight = rows[4].theta == 0
    flipped5 = -q5 if straight else wrap(-q5 - 2 * rows[4].theta)
    return {"no flip": (q4, q5, q6), "flip": (wrap(q4 + sp.pi), flipped5, wrap(q6 + sp.pi))}


# ---- six joints -----------------------------------------------------------------------------------------


def _hand(steps: _Steps, rows):
    """The rotation before the last row's twist, and the wrist centre in frame 0: fixed in the hand, so known."""
    last, hand = rows[5], sp.eye(4)
    hand[:3, :] = sp.Matrix(4, 3, HAND).T
    if rows.fixed:
        hand = _undone(rows.base) * hand * _undone(rows.tool)
        names = [f"{column}{axis}0" for axis in "xyz" for column in "noap"]
        hand[:3, :] = sp.Matrix(3, 4, [steps.let(*pair) for pair in zip(names, hand[:3, :], strict=True)])
    R = hand[:3, :3] * _turned_x(-last.alpha)
    R = sp.Matrix(3, 3, lambda i, j: steps.let(f"{'noa'[j]}{'xyz'[i]}6", R[i, j]))
    centre = hand[:3, 3] - last.d * R[:, 2] - last.a * R[:, 0]
    # x6 lies a along the hand's own x, which the last twist leaves alone
    return R, [steps.let(f"w{axis}", entry) for axis, entry in zip("xyz", centre, strict=True)]


def _undone(T):
    """The inverse of a rigid transform."""
    out = sp.eye(4)
    out[:3, :3], out[:3, 3] = T[:3, :3].T, -T[:3, :3].T * T[:3, 3]
    return out


def _turned_x(angle):
    c, s = sp.cos(angle), sp.sin(angle)
    return sp.Matrix([[1, 0, 0], [0, c, -s], [0, s, c]])


def _turned_z(angle):
    c, s = sp.cos(angle), sp.sin(angle)
    return sp.Matrix([[c, -s, 0], [s, c, 0], [0, 0, 1]])


def _seen(steps: _Steps, name: str, turn, R):
    """`turn` R, entry by entry, with a name for each."""
    found = turn * R
    return sp.Matrix(3, 3, lambda i, j: steps.let(f"r{i + 1}{j + 1}{name}", found[i, j]))


def _spherical(rows) -> Pattern:
    """Axes 4, 5, 6 meet: turn and triangle (or slide) place the crossing, then the wrist turns the hand."""
    why = _why_no_arm(rows)
    if why:
        return _none(
            f"axes 4, 5 and 6 meet in one point, as Pieper asks, but {why}; only arms that begin with a turn, and then "
            "two links or a slide in one plane, are written here"
        )
    slide = rows[2].prismatic
    elbows = ("out", "in") if slide else ("elbow up", "elbow down")
    kind = "a turn and a slide" if slide else "a turn and a triangle"
    reason = f"axes 4, 5 and 6 meet in one point; {kind} place it, then the wrist turns the hand"
    names = _named(("front", "back"), elbows, ("no flip", "flip"))
    return Pattern("spherical wrist", reason, (4, 5, 6), names, lambda: _spherical_functions(rows))


def _why_no_arm(rows) -> str:
    first, second, third, fourth = rows[:4]
    if first.prismatic or second.prismatic:
        return f"joint {1 if first.prismatic else 2} slides"
    if not _square(first):
        return "axes 1 and 2 are not at a right angle"
    if third.prismatic:
        if not _square(second) or second.a != 0:
            return "the slide does not pass axis 2 at a right angle"
        if third.a != 0 or not (_flat(third) or fourth.d == 0):
            return "their crossing is not on the line of the slide"
        return ""
    if not _flat(second):
        return "axes 2 and 3 are not parallel"
    if second.a == 0 or (third.a == 0 and (_flat(third) or fourth.d == 0)):
        return "one of the links between shoulder, elbow and wrist has no length"
    return ""


def _named(*choices) -> tuple[str, ...]:
    names = [""]
    for choice in choices:
        names = [f"{name}, {word}" if name else word for name in names for word in choice]
    return tuple(names)


def _identifier(branch: str) -> str:
    return "_".join(branch.replace(",", "").replace("elbow ", "").replace("no flip", "plain").split())


def _spherical_functions(rows) -> list[Function]:
    first, second, third, fourth = rows[:4]
    steps, measure = _Steps(), _Steps()
    k1, e2 = sp.sin(first.alpha), sp.cos(second.alpha)
    lift = e2 * (third.d + sp.cos(third.alpha) * fourth.d)
    across = k1 * (second.d if third.prismatic else second.d + lift)
    answers, gaps = {}, {}
    R, (wx, wy, wz) = _hand(steps, rows)
    _, centre = _hand(measure, rows)
    sides, _ = _turn(steps, across, (wx, wy), first)
    other_sides, beside = _turn(measure, across, centre[:2], first)
    beside = measure.let("beside", beside)
    for side, (theta1, ahead) in sides.items():
        q1 = steps.joint(f"q1_{side}", theta1, first)
        place = _in_plane(steps, f"_{side}", ahead - first.a, k1 * (wz - first.d))
        N = _seen(steps, f"_{side}", (_turned_z(q1 + first.theta) * _turned_x(first.alpha)).T, R)
        if third.prismatic:
            arms, gap = _slid(steps, f"_{side}", place, rows), sp.Integer(0)
        else:
            arms = _bent(steps, f"_{side}", place, rows)
            there = _in_plane(measure, f"_{side}", other_sides[side][1] - first.a, k1 * (centre[2] - first.d))
            gap = _ring_gap(measure, f"_{side}", there, second.a, _forearm(rows)[0])
        gap = measure.let(f"gap_{side}", _both(beside, gap))
        for elbow, (q2, q3, turn) in arms.items():
            name = f"_{side}_{elbow}"
            M = _seen(steps, name, turn, N)
            k4, k5 = sp.sin(fourth.alpha), sp.sin(rows[4].alpha)
            word = elbow if third.prismatic else f"elbow {elbow}"
            for flip, rest in _wrist(steps, name, M, k4, k5, ("q4", fourth), rows).items():
                branch = _identifier(f"{side}, {word}, {flip}")
                answers[branch], gaps[branch] = (q1, q2, q3, *rest), gap
    return _functions(HAND, answers, gaps, steps, measure)


def _in_plane(steps: _Steps, name: str, x, y):
    return steps.let(f"x{name}", x), steps.let(f"y{name}", y)


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
    """The sign of the bend with which the forearm bends down, as chapter 4 calls it `up`, seen from the front."""
    turned = sp.sin(rows[0].alpha) * rows[1].a * fore
    return 1 if turned.is_negative else -1


def _bent(steps: _Steps, name: str, place, rows):
    """{elbow: (q2, q3, the turn from frame 1 to the wrist's)} of an arm with two links."""
    second, third = rows[1:3]
    e2 = sp.cos(second.alpha)
    fore, lean = _forearm(rows)
    found = {}
    for elbow, (theta2, bend) in _triangle(steps, name, place, second.a, fore, _up(rows, fore)).items():
        q2 = steps.joint(f"q2{name}_{elbow}", theta2, second)
        q3 = steps.joint(f"q3{name}_{elbow}", e2 * (bend - lean), third)
        direction = steps.let(f"fore{name}_{elbow}", theta2 + bend - lean)
        turn = _turned_x(-second.alpha - third.alpha) * _turned_z(direction).T
        found[elbow] = q2, q3, turn
    return found


def _slid(steps: _Steps, name: str, place, rows):
    """{out or in: (q2, d3, the turn from frame 1 to the wrist's)} of an arm with a boom."""
    (x, y), (second, third, fourth) = place, rows[1:4]
    k2 = sp.sin(second.alpha)
    length = steps.let(f"boom{name}", sp.sqrt(x**2 + y**2))
    fixed = _turned_x(second.alpha) * _turned_z(third.theta) * _turned_x(third.alpha)
    found = {}
    for way, e in (("out", 1), ("in", -1)):
        q2 = steps.joint(f"q2{name}_{way}", sp.atan2(e * k2 * x, -e * k2 * y), second)
        d3 = e * length - third.d - sp.cos(third.alpha) * fourth.d
        found[way] = q2, steps.let(f"d3{name}_{way}", d3), fixed.T * _turned_z(q2 + second.theta).T
    return found


def _parallel(rows) -> Pattern:
    """Axes 2, 3, 4 are parallel: the turn, then the wrist, which only needs the turn, and the triangle at last."""
    reason = "axes 2, 3 and 4 are parallel; a turn, then the wrist, and a triangle that ends where the wrist begins"
    names = _named(("front", "back"), ("elbow up", "elbow down"), ("no flip", "flip"))
    return Pattern("three parallel axes", reason, (2, 3, 4), names, lambda: _parallel_functions(rows))


def _parallel_functions(rows) -> list[Function]:
    first, second, third, fourth, fifth = rows[:5]
    k1, k4, k5 = (sp.sin(row.alpha) for row in (first, fourth, fifth))
    e2, e3 = sp.cos(second.alpha), sp.cos(third.alpha)
    across = k1 * (second.d + e2 * third.d + e2 * e3 * fourth.d)
    steps, measure, answers, gaps = _Steps(), _Steps(), {}, {}
    R, (wx, wy, wz) = _hand(steps, rows)
    R_measured, centre = _hand(measure, rows)
    sides, _ = _turn(steps, across, (wx, wy), first)
    other_sides, beside = _turn(measure, across, centre[:2], first)
    beside = measure.let("beside", beside)
    free = DHRow(0, 0, 0, 0)
    for side, (theta1, ahead) in sides.items():
        places = {}
        for into, theta, there, z, rotation in (
            (steps, theta1, ahead, wz, R),
            (measure, other_sides[side][0], other_sides[side][1], centre[2], R_measured),
        ):
            q1 = into.joint(f"q1_{side}", theta, first)
            place = _in_plane(into, f"_{side}", there - first.a, k1 * (z - first.d))
            N = _seen(into, f"_{side}", (_turned_z(q1 + first.theta) * _turned_x(first.alpha)).T, rotation)
            places[id(into)] = q1, place, N
        q1, (x, y), N = places[id(steps)]
        leaning = _leaning(steps, f"_{side}", N, (x, y), rows, e2 * e3 * k4)
        wrists = _wrist(steps, f"_{side}", N, e2 * e3 * k4, k5, ("hand", free), rows, leaning)
        hand = wrists["no flip"][0]
        _, (x_m, y_m), N_m = places[id(measure)]
        lean_x, lean_y = _leaning(measure, f"_{side}", N_m, (x_m, y_m), rows, e2 * e3 * k4)
        hand_m = measure.let(f"hand_{side}", sp.atan2(k5 * N_m[1, 2] + lean_y, k5 * N_m[0, 2] + lean_x))
        for flip, (_, q5, q6) in wrists.items():
            sign, name = (1 if flip == "no flip" else -1), f"_{side}_{_identifier(flip)}"
            begin = _before_hand((x, y), hand, sign, rows, e2 * e3 * k4)
            place = _in_plane(steps, name, *begin)
            there = _in_plane(measure, name, *_before_hand((x_m, y_m), hand_m, sign, rows, e2 * e3 * k4))
            gap = measure.let(f"gap{name}", _both(beside, _ring_gap(measure, name, there, second.a, third.a)))
            triangle = _triangle(steps, name, place, second.a, third.a, _up(rows, third.a))
            for elbow, (theta2, bend) in triangle.items():
                ending = f"_{_identifier(f'{side}, {elbow}, {flip}')}"
                q2 = steps.joint(f"q2{ending}", theta2, second)
                q3 = steps.joint(f"q3{ending}", e2 * bend, third)
                turned = hand + (sp.pi if sign < 0 else 0)
                q4 = steps.joint(f"q4{ending}", e2 * e3 * (turned - theta2 - bend), fourth)
                answers[ending[1:]], gaps[ending[1:]] = (q1, q2, q3, q4, q5, q6), gap
    order = [_identifier(name) for name in _named(("front", "back"), ("up", "down"), ("no flip", "flip"))]
    answers, gaps = ({name: found[name] for name in order} for found in (answers, gaps))
    return _functions(HAND, answers, gaps, steps, measure)


def _leaning(steps: _Steps, name: str, R, place, rows, k4):
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


# ---- fewer joints ---------------------------------------------------------------------------------------


def _shoulder_and_plane(rows) -> Pattern:
    """A turn, and then two or three parallel axes: this book's arm, and its relatives."""
    number = len(rows)
    if any(row.prismatic for row in rows):
        return _none("a joint slides, and not all axes are parallel")
    if not _square(rows[0]):
        return _none("axes 1 and 2 are neither parallel nor at a right angle")
    if not all(_flat(row) for row in rows[1 : number - 1]):
        return _none(f"the axes from 2 to {number} are not all parallel")
    if rows[1].a == 0 or rows[2].a == 0:
        return _none("one of the links between shoulder, elbow and wrist has no length")
    task = "x, y, z and pitch" if number == 4 else "x, y and z"
    axes = tuple(range(2, number + 1))
    reason = f"axes {_listed(axes)} are parallel, at a right angle to axis 1; {task} fix all joints"
    names = _named(("front", "back"), ("elbow up", "elbow down"))
    return Pattern("shoulder and plane", reason, axes, names, lambda: _plane_functions(rows))


def _listed(numbers) -> str:
    *first, last = map(str, numbers)
    return f"{', '.join(first)} and {last}"


def _plane_functions(rows) -> list[Function]:
    first, second, third = rows[:3]
    fourth = rows[3] if len(rows) == 4 else DHRow(*[sp.Integer(0)] * 4)
    k1, e2 = sp.sin(first.alpha), sp.cos(second.alpha)
    e3 = sp.cos(third.alpha) if len(rows) == 4 else 0
    x, y, z = PLACE
    inputs = (*PLACE, PITCH)[: len(rows)]
    across = k1 * (second.d + e2 * third.d + e2 * e3 * fourth.d)
    hand_x, hand_y = fourth.a * sp.cos(PITCH), fourth.a * k1 * sp.sin(PITCH)
    steps, measure, answers, gaps = _Steps(), _Steps(), {}, {}
    sides, _ = _turn(steps, across, (x, y), first)
    measured, beside = _turn(measure, across, (x, y), first)
    beside = measure.let("beside", beside)
    for side, (theta1, ahead) in sides.items():
        q1 = steps.joint(f"q1_{side}", theta1, first)
        place = _in_plane(steps, f"_{side}", ahead - first.a - hand_x, k1 * (z - first.d) - hand_y)
        there = _in_plane(measure, f"_{side}", measured[side][1] - first.a - hand_x, k1 * (z - first.d) - hand_y)
        gap = _both(beside, _ring_gap(measure, f"_{side}", there, second.a, third.a))
        gap = measure.let(f"gap_{side}", gap)
        for elbow, (theta2, bend) in _triangle(steps, f"_{side}", place, second.a, third.a, _up(rows, third.a)).items():
            name = f"{side}_{elbow}"
            q2 = steps.joint(f"q2_{name}", theta2, second)
            q3 = steps.joint(f"q3_{name}", e2 * bend, third)
            q4 = steps.joint(f"q4_{name}", e2 * e3 * (k1 * PITCH - theta2 - bend), fourth)
            answers[name], gaps[name] = (q1, q2, q3, q4)[: len(rows)], gap
    return _functions(inputs, answers, gaps, steps, measure)


def _all_parallel(rows) -> Pattern:
    """Every axis has one direction: planar arms, and with a slide a SCARA."""
    slides = [i for i, row in enumerate(rows) if row.prismatic]
    turning = [row for row in rows if not row.prismatic]
    if len(slides) > 1 or len(turning) not in (2, 3):
        found = f"all axes are parallel, {len(turning)} of them turns and {len(slides)} slides"
        return _none(f"{found}; two or three turns and one slide at most have an inverse")
    if any(row.a != 0 for row in rows if row.prismatic):
        return _none("the slide shifts sideways, too (its a is not 0): add that a to the row before")
    if any(row.a == 0 for row in turning[:2]):
        return _none("two of the axes are one and the same")
    number = len(rows)
    task = ["x, y", "z" if slides else "", "yaw" if len(turning) == 3 else ""]
    reason = f"all axes are parallel; {', '.join(filter(None, task))} fix all joints: one triangle" + (
        ", and the slide for the height" if slides else ""
    )
    names = ("elbow up", "elbow down")
    return Pattern("all axes parallel", reason, tuple(range(1, number + 1)), names, lambda: _scara_functions(rows))


def _scara_functions(rows) -> list[Function]:
    """One triangle in the plane of the turns; `up` is a bend to the right, as seen against the axis of joint 1."""
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
    steps, measure, answers = _Steps(), _Steps(), {}
    gap = _ring_gap(measure, "_wrist", _in_plane(measure, "_wrist", *begin), upper.a, fore.a)
    triangle = _triangle(steps, "_wrist", _in_plane(steps, "_wrist", *begin), upper.a, fore.a, -1)
    for elbow, (direction, bend) in triangle.items():
        turns = [direction, bend, hand - direction - bend]
        q = {
            i: steps.joint(f"q{i + 1}_{elbow}", sense[i] * (turned - before), rows[i])
            for i, turned, before in zip(turning, turns, fixed, strict=False)
        }
        q |= {i: sense[i] * (z - height) for i in slides}
        answers[elbow] = tuple(q[i] for i in range(len(rows)))
    return _functions(inputs, answers, dict.fromkeys(answers, gap), steps, measure)


def _functions(inputs, answers, gaps, steps, measure) -> list[Function]:
    return [
        Function("branches", ANSWERS, inputs, answers, steps),
        Function("missing", GAP, inputs, gaps, measure),
    ]
