"""Screws: exponentials are exponentials, their product is the DH product, their Jacobians are pinocchio's."""

from math import prod

import mpmath
import numpy as np
import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st

import omx
from omx.derive import prove_equal
from omx.derive.screws import (
    adjoint,
    body_jacobian,
    exp_twist,
    screw_axis,
    skew,
    space_jacobian,
)
from omx.errors import BadInput
from tests.helpers import oracles

RNG = np.random.default_rng(16)
ROW = st.tuples(*[st.floats(-3, 3), st.floats(-300, 300), st.floats(-300, 300), st.floats(-3, 3)], st.booleans())


def numbers(matrix):
    return np.array(matrix, dtype=float)


def twists_of(chain):
    """The screws of a chain at zero, and where its tool is then."""
    frames = chain.frames(np.zeros(len(chain)))
    axes = zip(frames, chain.rows, strict=False)
    return [screw_axis(T[:3, 2], T[:3, 3], row.prismatic) for T, row in axes], frames[-1]


def hat(twist):
    return sp.Matrix.vstack(sp.Matrix.hstack(skew(twist[3:, :]), twist[:3, :]), sp.zeros(1, 4))


def test_exp_is_the_sum_of_the_series():
    for _ in range(20):
        v, w, angle = RNG.uniform(-2, 2, 3), RNG.uniform(-1, 1, 3), RNG.uniform(-4, 4)
        for twist in ([*v, *(w / np.linalg.norm(w))], [*v, 0, 0, 0]):
            series = mpmath.expm(mpmath.matrix((hat(sp.Matrix(twist)) * angle).tolist()))
            np.testing.assert_allclose(numbers(exp_twist(twist, angle)), numbers(series.tolist()), atol=1e-12)


def test_a_joint_at_zero_moves_nothing_and_back_is_back():
    q = sp.Symbol("q", real=True)
    for twist in (screw_axis((0, 1, 0), (5, 0, 77)), screw_axis((0, 0, 1), prismatic=True)):
        assert exp_twist(twist, 0) == sp.eye(4)
        prove_equal(exp_twist(twist, q) * exp_twist(twist, -q), sp.eye(4))


@settings(max_examples=25, deadline=None)
@given(st.lists(st.tuples(ROW, st.floats(-3, 3)), min_size=1, max_size=5))
def test_the_product_of_exponentials_is_the_dh_product(joints):
    rows, q = zip(*joints, strict=True)
    chain = omx.Chain(rows, tool=oracles.turn_x(0.3) @ oracles.shift(9, 2))
    twists, zero = twists_of(chain)
    product = prod(map(exp_twist, twists, q), start=sp.eye(4))
    np.testing.assert_allclose(numbers(product * sp.Matrix(zero)), chain.fk(q), atol=1e-9)


def test_both_jacobians_are_pinocchios():
    rows = [(0.1, 400, 30, -1.1), (0.5, 150, 80, 0.7), (0, 20, 60, 1.3), (0.2, 0, 90, -0.4)]
    pin, model, data, tool = oracles.pinocchio_arm(rows, prismatic=(2,))
    chain = omx.Chain([(*row, i == 2) for i, row in enumerate(rows)])
    twists, zero = twists_of(chain)
    for q in RNG.uniform(-2, 2, (10, 4)):
        pin.computeJointJacobians(model, data, q)
        pin.updateFramePlacements(model, data)
        space = pin.getFrameJacobian(model, data, tool, pin.ReferenceFrame.WORLD)
        body = pin.getFrameJacobian(model, data, tool, pin.ReferenceFrame.LOCAL)
        np.testing.assert_allclose(numbers(space_jacobian(twists, q)), space, atol=1e-9)
        np.testing.assert_allclose(numbers(body_jacobian(twists, zero, q)), body, atol=1e-9)
        T = chain.fk(q)
        to_tip = np.block([[np.eye(3), -numbers(skew(T[:3, 3]))], [np.zeros((3, 3)), np.eye(3)]])
        np.testing.assert_allclose(to_tip @ space, chain.jacobian(q), atol=1e-9)


def test_the_adjoint_tells_a_twist_in_another_frame():
    q1, q2, x, y = sp.symbols("q1 q2 x y", real=True)
    T = exp_twist(screw_axis((0, 0, 1), (x, y, 0)), q1) * exp_twist(screw_axis((1, 0, 0), (0, y, x)), q2)
    twist = sp.Matrix(sp.symbols("v_x v_y v_z w_x w_y w_z", real=True))
    prove_equal(hat(adjoint(T) * twist) * T, T * hat(twist))


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: skew((1, 2)), "`w` must be 3 numbers"),
        (lambda: screw_axis("up"), "an expression or a number is wanted"),
        (lambda: screw_axis(None), "`direction` must be 3"),
        (lambda: exp_twist((0, 0, 1), 0.5), "`twist` must be 6"),
        (lambda: adjoint(np.eye(3)), "`T` must be a transform"),
        (lambda: space_jacobian([(0, 0, 0, 0, 0, 1)], [1, 2]), "as many, one or more; got 1 and 2"),
        (lambda: space_jacobian([], []), "as many, one or more; got 0 and 0"),
        (lambda: body_jacobian([(0, 0, 0, 0, 0, 1)], [[1, 0, 0]] * 4, [1]), "`zero` must be a transform"),
        (lambda: space_jacobian(5, [1]), "must be lists"),
    ],
)
def test_what_is_no_screw_is_refused_by_name(call, message):
    with pytest.raises(BadInput, match=message):
        call()
