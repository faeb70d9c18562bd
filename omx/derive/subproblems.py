"""The three small problems of closed inverses, as steps of a generated function, and the hand that they start from.

The *turn*: which angle of joint 1 brings a place into the plane of the arm? The *triangle*: two links and a distance.
The *wrist*: three angles that make a rotation. Each has two answers, and none divides by what may be 0.
"""

import sympy as sp

from ..dh import DHRow
from .screws import undone
from .symbolic import wrap

#: The pose of a hand as six-joint inverses take it: the columns n, o, a of its rotation, and its position p (mm).
HAND = sp.symbols("nx ny nz ox oy oz ax ay az px py pz", real=True)

#: The turns about x and about z, 3x3, as functions of their angle.
turned_x, turned_z = sp.rot_ccw_axis1, sp.rot_ccw_axis3


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
