"""Screws in symbols: the twist of a joint's axis, its exponential, and what carries it from frame to frame.

A twist is a column of six, `(v, w)`: the velocity v of the point that is just passing the frame's origin, then the
angular velocity w, as in the rows of a Jacobian here. (Lynch and Park write w first.) Lengths in mm, angles in rad.
Chapter 4 derives what is written down here.
"""

from collections.abc import Sequence

import sympy as sp

from ..arrays import shown
from ..errors import BadInput
from .symbolic import as_expression

__all__ = ["adjoint", "body_jacobian", "exp_twist", "screw_axis", "skew", "space_jacobian", "undone"]


def skew(w) -> sp.Matrix:
    """The 3x3 matrix of the cross product: `skew(w) * u` is `w` x `u`."""
    x, y, z = _column(w, 3, "w")
    return sp.Matrix([[0, -z, y], [z, 0, -x], [-y, x, 0]])


def screw_axis(direction, point=(0, 0, 0), prismatic: bool = False) -> sp.Matrix:
    """The twist of a joint that turns about the line through `point` along `direction`, or slides along it.

    `direction` has length 1. Which point of the line is given makes no difference; a sliding joint needs none.
    """
    direction, point = _column(direction, 3, "direction"), _column(point, 3, "point")
    if prismatic:
        return sp.Matrix([*direction, 0, 0, 0])
    return sp.Matrix([*point.cross(direction), *direction])


def exp_twist(twist, q) -> sp.Matrix:
    """The motion by `q` (rad; mm where `twist` has w = 0) along a twist whose w has length 1 or 0, 4x4."""
    twist, q = _column(twist, 6, "twist"), as_expression(q)
    v, W = twist[:3, :], skew(twist[3:, :])
    if W.is_zero_matrix:
        R, p = sp.eye(3), v * q
    else:
        sine, rest = sp.sin(q), 1 - sp.cos(q)
        R = sp.eye(3) + sine * W + rest * W**2
        p = (sp.eye(3) * q + rest * W + (q - sine) * W**2) * v
    return sp.Matrix.vstack(sp.Matrix.hstack(R, p), sp.Matrix([[0, 0, 0, 1]]))


def adjoint(T) -> sp.Matrix:
    """The 6x6 matrix that tells a twist in another frame: `adjoint(T_a_b)` takes it from frame b to frame a."""
    T = _transform(T, "T")
    R, p = T[:3, :3], T[:3, 3]
    return sp.Matrix.vstack(sp.Matrix.hstack(R, skew(p) * R), sp.Matrix.hstack(sp.zeros(3), R))


def space_jacobian(twists, q: Sequence) -> sp.Matrix:
    """The twists where the joints in front of them have carried them, side by side: 6xn, told in the base."""
    T, columns = sp.eye(4), []
    for twist, joint in zip(*_pairs(twists, q), strict=True):
        columns.append(adjoint(T) * twist)
        T = T * exp_twist(twist, joint)
    return sp.Matrix.hstack(*columns)


def body_jacobian(twists, zero, q: Sequence) -> sp.Matrix:
    """The same twists told in the tool's own frame: 6xn, its linear rows are the velocity of the tool's origin."""
    to_tool, columns = adjoint(undone(_transform(zero, "zero"))), []
    T = sp.eye(4)
    for twist, joint in reversed(list(zip(*_pairs(twists, q), strict=True))):  # from the tool back to the base
        columns.append(adjoint(T) * to_tool * twist)
        T = T * exp_twist(to_tool * twist, -joint)
    return sp.Matrix.hstack(*reversed(columns))


def undone(T) -> sp.Matrix:
    """The inverse of a rigid transform, 4x4: R^T and -R^T p."""
    T = _transform(T, "T")
    R = T[:3, :3].T
    return sp.Matrix.vstack(sp.Matrix.hstack(R, -R * T[:3, 3]), sp.Matrix([[0, 0, 0, 1]]))


def _column(value, size: int, name: str) -> sp.Matrix:
    """`value` as a column of `size` expressions; `BadInput` otherwise."""
    try:
        entries = [as_expression(entry) for entry in value]
    except TypeError:
        entries = []
    if len(entries) != size:
        raise BadInput(f"`{name}` must be {size} numbers or expressions; got {shown(value)}.")
    return sp.Matrix(entries)


def _pairs(twists, q) -> tuple[list, list]:
    """As many twists as joint variables, one or more."""
    try:
        twists, q = [_column(twist, 6, "twists") for twist in twists], [as_expression(joint) for joint in q]
    except TypeError:
        raise BadInput(f"`twists` and `q` must be lists, one twist of six a joint; got {shown(q)} for `q`.") from None
    if not twists or len(twists) != len(q):
        raise BadInput(f"`twists` and `q` must be as many, one or more; got {len(twists)} and {len(q)}.")
    return twists, q


def _transform(value, name: str) -> sp.Matrix:
    try:
        rows = [[as_expression(entry) for entry in row] for row in getattr(value, "tolist", lambda: value)()]
    except TypeError:
        rows = []
    if [len(row) for row in rows] != [4] * 4 or any(rows[3][j] - int(j == 3) for j in range(4)):
        raise BadInput(f"`{name}` must be a transform, 4x4 with the last row 0, 0, 0, 1; got {shown(value)}.")
    return sp.Matrix(rows)
