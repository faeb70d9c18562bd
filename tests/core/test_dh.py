"""Chains of DH rows: equal to the product of elementary moves and to pinocchio, in numbers and in symbols."""

import warnings
from math import pi

import numpy as np
import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st

import omx
from omx import BadInput, Chain, DHRow, JointLimit
from omx.dh import as_limits, clipped, limit_violations
from tests.helpers import oracles

TWISTS = (-pi / 2, pi / 2, 0, -pi / 2, pi / 2, 0)
TWO = [(0, 0, 1, 0), (0, 0, 1, 0)]
STANFORD = [(0, d, 0, alpha) for d, alpha in zip((400, 150, 0, 0, 0, 60), TWISTS, strict=True)]

ANGLES = st.floats(-4, 4)
LENGTHS = st.floats(-300, 300)
ROWS = st.tuples(ANGLES, LENGTHS, LENGTHS, ANGLES, st.booleans())


@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(ROWS, ANGLES), min_size=1, max_size=7))
def test_any_chain_is_the_product_of_its_elementary_moves(joints):
    rows, q = zip(*joints, strict=True)
    sliding = [i for i, row in enumerate(rows) if row[4]]
    frames = Chain(rows).frames(q)
    assert frames.shape == (len(rows) + 1, 4, 4)
    np.testing.assert_array_equal(frames[0], np.eye(4))
    np.testing.assert_allclose(frames[1:], oracles.product([r[:4] for r in rows], q, sliding), atol=1e-10)
    np.testing.assert_array_equal(Chain(rows).fk(q), frames[-1])


@pytest.mark.parametrize(("rows", "sliding"), [(oracles.table(*oracles.COURSE), ()), (STANFORD, (2,))])
def test_pinocchio_agrees(rows, sliding):
    pin, model, data, tool = oracles.pinocchio_arm(rows, sliding)
    chain = Chain([DHRow(*row, prismatic=i in sliding) for i, row in enumerate(rows)])
    for q in np.random.default_rng(1).uniform(-3, 3, (200, len(rows))):
        pin.framesForwardKinematics(model, data, q)
        np.testing.assert_allclose(chain.fk(q), data.oMf[tool].homogeneous, atol=1e-11)


def test_frames_are_products_of_link_matrices():
    q = oracles.random_q(50)
    links, frames = omx.COURSE.chain.matrices(q), omx.COURSE.chain.frames(q)
    assert links.shape == (50, 4, 4, 4)
    for i in range(4):
        np.testing.assert_allclose(frames[:, i] @ links[:, i], frames[:, i + 1], atol=1e-12)


def test_a_batch_is_its_rows_one_by_one():
    chain, q = omx.COURSE.chain, oracles.random_q(6).reshape(2, 3, 4)
    one_by_one = [[chain.fk(row) for row in rows] for rows in q]
    np.testing.assert_allclose(chain.fk(q), one_by_one, atol=1e-13)


def test_every_frame_is_a_rigid_motion():
    frames = Chain(STANFORD).frames(np.random.default_rng(2).uniform(-3, 3, (100, 6)))
    R = frames[..., :3, :3]
    np.testing.assert_allclose(R @ np.swapaxes(R, -1, -2), np.broadcast_to(np.eye(3), R.shape), atol=1e-14)
    np.testing.assert_allclose(np.linalg.det(R), 1, atol=1e-14)
    np.testing.assert_array_equal(frames[..., 3, :], np.broadcast_to([0, 0, 0, 1], (*frames.shape[:-2], 4)))


def test_a_chain_does_not_change():
    """What is worked out of it when it is read, such as a solution's verdict, would change behind one's back."""
    base = BASE.copy()
    symbolic = sp.eye(4)
    symbolic[0, 3] = L1
    chain = Chain(STANFORD, [(-1, 1)] * 6, base=base, tool=symbolic)
    for name, value in vars(chain).copy().items():
        with pytest.raises(AttributeError, match=f"does not change; make another with the {name}"):
            setattr(chain, name, value)
        with pytest.raises(AttributeError, match=f"does not change; {name} stays"):
            delattr(chain, name)
    with pytest.raises(ValueError, match="read-only"):
        chain.base[0, 3] = 5.0
    with pytest.raises(TypeError):
        chain.tool[0, 3] = 5
    base[0, 3] = symbolic[0, 3] = 5
    assert (chain.base[0, 3], chain.tool[0, 3]) == (BASE[0, 3], L1)


# ---- symbols through the same rows ---------------------------------------------------------------------

q1, q2, L1 = sp.symbols("q1 q2 L1")
PLANAR = Chain([DHRow(0, 0, L1, 0), DHRow(0, 0, 50, 0)], name="two links")


@pytest.mark.parametrize("q", [(q1, q2), [q1, q2], sp.Matrix([q1, q2]), sp.Matrix([[q1, q2]]), np.array([q1, q2])])
def test_symbols_in_symbols_out(q):
    T = PLANAR.fk(q)
    assert isinstance(T, sp.MatrixBase)
    assert sp.simplify(T[0, 3] - (L1 * sp.cos(q1) + 50 * sp.cos(q1 + q2))) == 0


def test_symbolic_rows_with_numbers_put_in_are_the_numeric_chain():
    symbolic = PLANAR.fk([0.3, -0.8]).subs(L1, 70)
    numeric = Chain([DHRow(0, 0, 70, 0), DHRow(0, 0, 50, 0)]).fk([0.3, -0.8])
    np.testing.assert_allclose(np.array(symbolic, dtype=float), numeric, atol=1e-13)


def test_sympy_numbers_in_the_rows_still_make_a_numeric_chain():
    chain = Chain([DHRow(0, 77, 0, -sp.pi / 2), DHRow(sp.Rational(1, 2), 0, sp.Integer(130), 0)])
    assert chain.fk([0.1, 0.2]).dtype == np.float64
    assert chain.fk(np.zeros((5, 2))).shape == (5, 4, 4)


def test_a_sympy_number_in_q_asks_for_an_exact_answer():
    T = Chain([DHRow(0, 0, 2, 0)]).fk([sp.pi / 3])
    assert T[:2, 3] == sp.Matrix([1, sp.sqrt(3)])


def test_numeric_chains_do_without_sympy():
    numeric = Chain(oracles.table(*oracles.COURSE))
    assert not numeric._is_symbolic((0.0, 0.0, 0.0, 0.0))
    assert numeric.fk([0, 0, 0, 0]).dtype == np.float64


# ---- what stands before the first joint and behind the last --------------------------------------------

BASE = oracles.turn_z(0.4) @ oracles.shift(-12, 30) @ oracles.turn_x(0.9)
TOOL = oracles.turn_x(-1.1) @ oracles.shift(45, 20) @ oracles.turn_z(2.0)


def test_base_and_tool_cost_no_joint():
    rows, q = oracles.table(*oracles.COURSE), oracles.random_q(50)
    plain, fixed = Chain(rows), Chain(rows, base=BASE, tool=TOOL)
    assert len(fixed) == 4
    np.testing.assert_allclose(fixed.fk(q), BASE @ plain.fk(q) @ TOOL, atol=1e-11)
    frames = fixed.frames(q)
    np.testing.assert_allclose(frames[:, :-1], BASE @ plain.frames(q)[:, :-1], atol=1e-11)
    for i, links in enumerate(np.moveaxis(fixed.matrices(q), 1, 0)):
        np.testing.assert_allclose(frames[:, i] @ links, frames[:, i + 1], atol=1e-11)


def test_the_jacobian_is_that_of_the_tool():
    chain, step = Chain(STANFORD, base=BASE, tool=TOOL), 1e-6
    q = np.random.default_rng(3).uniform(-2, 2, 6)
    ahead, behind = chain.fk(q + step * np.eye(6)), chain.fk(q - step * np.eye(6))
    slopes = (ahead - behind)[:, :3, 3].T / (2 * step)
    np.testing.assert_allclose(chain.jacobian(q)[:3], slopes, atol=1e-5)


def test_symbols_go_through_base_and_tool():
    x, angle = sp.symbols("x angle", real=True)
    base = sp.Matrix([[1, 0, 0, -x], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
    T = Chain([(0, 0, L1, 0)], base=base, tool=np.diag([1.0, -1.0, -1.0, 1.0])).fk([angle])
    assert T[0, 3] == L1 * sp.cos(angle) - x
    assert T[2, 2] == -1


@pytest.mark.parametrize("value", [np.eye(3), np.diag([1, 1, -1, 1]), np.diag([2, 1, 1, 1]), np.ones((4, 4)), "maker"])
def test_what_is_no_transform_is_refused(value):
    for name in ("base", "tool"):
        with pytest.raises(BadInput, match=f"`{name}` must be a transform"):
            Chain(TWO, **{name: value})


# ---- Craig's convention --------------------------------------------------------------------------------


def craig(rows, q, sliding=()):
    """The product of Craig's elementary moves, `Rx(alpha) Tx(a) Rz(theta) Tz(d)` a row."""
    T = np.eye(4)
    for i, ((theta, d, a, alpha), value) in enumerate(zip(rows, q, strict=True)):
        turn, way = (theta, d + value) if i in sliding else (theta + value, d)
        T = T @ oracles.turn_x(alpha) @ oracles.shift(a) @ oracles.turn_z(turn) @ oracles.shift(z=way)
    return T


@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(ROWS, ANGLES), min_size=1, max_size=7))
def test_a_craig_table_is_shifted_to_the_standard_one(joints):
    rows, q = zip(*joints, strict=True)
    sliding = [i for i, row in enumerate(rows) if row[4]]
    chain = Chain.from_craig(rows, base=BASE, tool=TOOL)
    wanted = BASE @ craig([row[:4] for row in rows], q, sliding) @ TOOL
    np.testing.assert_allclose(chain.fk(q), wanted, atol=1e-10)
    assert [row.prismatic for row in chain.rows] == [row[4] for row in rows]


#: A Craig table of this arm, as it goes around under the name "standard", with the hand as a fifth, fixed row.
CRAIG = [(0, 77, 0, 0), (-pi / 2, 0, 0, -pi / 2), (pi / 2, 0, 128, 0), (0, 0, 124, 0), (0, 0, 126, 0)]
HELD = [*omx.LIMITS, (0, 0)]


def test_craigs_rows_under_the_name_standard_are_recognised():
    with pytest.warns(UserWarning, match="theirs: q1 and q2 turn about one line.*read it with Chain.from_craig"):
        Chain(CRAIG, HELD, name="theirs")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        chain = Chain.from_craig(CRAIG, HELD, name="ours")
        assert chain.base is None
        np.testing.assert_allclose(chain.fk([0] * 5)[:3, 3], (250, 0, 205), atol=1e-12)


@pytest.mark.parametrize(
    ("rows", "limits"),
    [
        (oracles.table(*oracles.COURSE), None),
        (STANFORD, None),
        ([(0, 300, 0, 0), (0, 0, 9, 0, True)], None),  # a crane: it turns and slides along one line
        ([(0, 77, 0, 0), (0, 0, 9, 1.0), (0, 0, 9, 0)], [(0, 0), (-1, 1), (-1, 1)]),  # the first row is held
        ([(0, 77, 0, 0), (0, 0, 0, 0), (0, 0, 9, 0)], None),  # and after Craig two turn about one line just as well
    ],
)
def test_a_table_that_may_be_standard_is_taken_as_it_is(rows, limits):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        Chain(rows, limits)


def test_a_craig_table_with_symbols_stays_symbolic():
    alpha = sp.Symbol("alpha", real=True)
    chain = Chain.from_craig([(0, 0, L1, alpha), (0, 0, 5, 0)])
    T = chain.fk([q1, q2])
    assert sp.simplify(T[2, 3] - 5 * sp.sin(q1) * sp.sin(alpha)) == 0


# ---- limits --------------------------------------------------------------------------------------------

SLIDER = Chain([(0, 0, 10, 0), (0, 0, 0, 0, True)], limits=[(-1, 1), (0, 200)], name="slider")


def test_joints_are_named_by_kind_and_number():
    assert SLIDER.names == ("q1", "d2")
    assert Chain([(0, 0, 1, 0)], names=["elbow"]).names == ("elbow",)
    assert len(SLIDER) == 2
    assert repr(SLIDER) == "Chain('slider', joints q1, d2)"


def test_violations_name_joint_value_limit_and_unit():
    low, high = SLIDER.violations([-1.5, 250.0])
    assert (low.joint, low.value, low.limit, low.excess) == ("q1", -1.5, -1.0, 0.5)
    assert (high.joint, high.value, high.limit, high.excess) == ("d2", 250.0, 200.0, 50.0)
    assert str(low) == "q1 = -85.94 deg is 28.65 deg below its limit -57.30 deg"
    assert str(high) == "d2 = 250.00 mm is 50.00 mm above its limit 200.00 mm"


def test_the_unit_follows_the_joint_not_its_name():
    drum = Chain([(0, 0, 1, 0)], limits=[(-1, 1)], names=["drum"])
    assert "deg" in str(drum.violations([2.0])[0])


def test_check_raises_with_the_nearest_legal_configuration():
    SLIDER.check([1.0, 0.0])
    with pytest.raises(JointLimit, match=r"slider: q1 .* above") as caught:
        SLIDER.check([2.0, 100.0])
    assert caught.value.nearest == (1.0, 100.0)
    assert [v.joint for v in caught.value.violations] == ["q1"]


def test_a_chain_without_limits_refuses_nothing():
    assert Chain([(0, 0, 1, 0)]).violations([1e6]) == ()


def test_a_wrist_may_turn_more_than_once():
    turns = np.radians([-400, 400])
    assert Chain([(0, 0, 1, 0)], [turns]).limits == (tuple(turns),)
    for degrees in ([-10, 10], [-22.5, 22.5], [-400.5, 0]):
        with pytest.raises(BadInput, match="more than a turn: degrees"):
            Chain([(0, 0, 1, 0)], [degrees])


def test_limits_hold_to_the_slack_and_no_further():
    inside, outside = 1 + 0.5e-9, 1 + 2e-9
    assert limit_violations([inside], [(-1, 1)]) == ()
    assert limit_violations([outside], [(-1, 1)])[0].limit == 1
    assert clipped([outside, -5], [(-1, 1), (-2, 2)]) == (1.0, -2.0)


FLAT = Chain(TWO)


def test_limits_may_be_infinite_and_come_from_arrays():
    assert as_limits([(-np.inf, np.inf)], 1) == ((-np.inf, np.inf),)
    assert Chain(TWO, limits=np.radians([[-90, 90], [0, 360]]), names=np.array(["a", "b"])).names == ("a", "b")
    slides = [(0, 0, 1, 0), (0, 0, 0, 0, np.bool_(True))]
    assert Chain(slides, limits=[(-1, 1), (0, 300)]).limits[1] == (0, 300)  # mm


def test_symbolic_chains_have_exact_quarter_turns():
    symbols = sp.symbols("q1:5", real=True)
    T = omx.COURSE.chain.fk(symbols)
    constants = {float(number) for entry in T for number in entry.atoms(sp.Float)}
    assert all(abs(constant) > 1e-3 for constant in constants)
    assert T[2, 2] == 0
    numeric = np.array(T.subs(dict(zip(symbols, omx.HOME, strict=True))), float)
    np.testing.assert_allclose(numeric, omx.fk(omx.HOME), atol=1e-9)


@pytest.mark.parametrize("chain", [SLIDER, FLAT, omx.COURSE.chain])
def test_the_jacobian_is_the_derivative_of_the_frames(chain):
    q, h = np.linspace(-0.4, 0.9, len(chain)), 1e-6
    J = chain.jacobian(q)
    for j, step in enumerate(h * np.eye(len(chain))):
        slope = (chain.fk(q + step) - chain.fk(q - step)) / (2 * h)
        np.testing.assert_allclose(J[:3, j], slope[:3, 3], atol=1e-6)
        spin = slope[:3, :3] @ chain.fk(q)[:3, :3].T
        np.testing.assert_allclose(J[3:, j], [spin[2, 1], spin[0, 2], spin[1, 0]], atol=1e-7)
    np.testing.assert_allclose(chain.jacobian([[q, q]] * 3), np.broadcast_to(J, (3, 2, 6, len(chain))))
    if chain is omx.COURSE.chain:
        np.testing.assert_allclose(J, omx.jacobian(q), atol=1e-9)


# ---- mistakes ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"rows": []}, "at least one"),
        ({"rows": [(0, 1, 2)]}, "row 1 must be a DHRow"),
        ({"rows": [(0, 0, 1, 0), (0, "long", 0, 0)]}, "row 2 must be a DHRow"),
        ({"rows": [(0, None, 0, 0)]}, "row 1 must be a DHRow"),
        ({"rows": [7]}, "row 1 must be a DHRow"),
        ({"rows": TWO, "names": ["a"]}, "2 different names"),
        ({"rows": TWO, "names": ["a", "a"]}, "2 different names"),
        ({"rows": TWO, "limits": [(0, 1)]}, "2 pairs"),
        ({"rows": TWO, "limits": [(0, 1), (1, 0)]}, r"`limits`\[1\] is \(1.0, 0.0\)"),
        ({"rows": TWO, "limits": [(0, 1), (0, float("nan"))]}, r"`limits`\[1\]"),
        ({"rows": TWO, "limits": [0, 1]}, "2 pairs"),
        ({"rows": TWO, "limits": "no"}, "2 pairs"),
        ({"rows": TWO, "limits": [("0", "1")] * 2}, "2 pairs"),
        ({"rows": TWO, "limits": [(0, 1), (np.inf, np.inf)]}, r"`limits`\[1\]"),
        ({"rows": None}, "`rows` must be a list of DHRow"),
        ({"rows": [(0, np.nan, 0, 0)]}, "row 1 must be .* finite and real; d is nan"),
        ({"rows": [(0, 0, np.inf, 0)]}, "a is inf"),
        ({"rows": [(0, sp.I, 0, 0)]}, "d is I"),
        ({"rows": [(0, sp.zoo, 0, 0)]}, "d is zoo"),
        ({"rows": [(0, sp.nan, 0, 0)]}, "d is nan"),
        ({"rows": [(True, 0, 0, 0)]}, "theta is True"),
        ({"rows": [(0, 2j, 0, 0)]}, "d is 2j"),
        ({"rows": [DHRow(0, 77, 0, -90)]}, "alpha of row 1 is -90 rad, more than a turn: degrees[?]"),
        ({"rows": [DHRow(90.0, 77, 0, 0)]}, "theta of row 1 is 90.0 rad"),
        ({"rows": [(0, 0, 1, 0, True), (45, 0, 1, 0)]}, "theta of row 2 is 45 rad"),
        ({"rows": TWO, "limits": [(-90, 90), (-1, 1)]}, r"`limits`\[0\] is \(-90, 90\) rad, more than a turn: degrees"),
        (
            {"rows": [(0, 77, 0, 0, "R")]},
            "fifth entry of row 1 says whether the joint is prismatic, True or False; got 'R'",
        ),
        ({"rows": [(0, 77, 0, 0, 1.57)]}, "fifth entry .* An offset is added to theta"),
        ({"rows": [DHRow(q1, 77, 0, 0)]}, "theta of row 1 holds the joint's own variable q1, which is added to it"),
        ({"rows": [DHRow(-q1 - sp.pi / 2, 77, 0, 0)]}, "A joint that turns the other way"),
        ({"rows": [DHRow(0, sp.Symbol("d1"), 0, 0, True)]}, "d of row 1 holds the joint's own variable d1"),
        ({"rows": [DHRow(0, sp.Symbol("q2"), 0, 0), (0, 0, 1, 0)]}, "d of row 1 holds q2, the name of a joint's"),
        ({"rows": TWO, "names": sp.symbols("a b")}, "2 different names"),
        ({"rows": TWO, "names": "ab"}, "2 different names"),
    ],
)
def test_a_bad_table_is_refused_by_name(arguments, message):
    with pytest.raises(BadInput, match=message):
        Chain(**arguments)


@pytest.mark.parametrize("q", [[1], [1, 2, 3], [[1, 2, 3]], "ab", None, [1, "a"], [1, np.nan], [], np.empty((0, 2))])
@pytest.mark.parametrize("method", ["fk", "frames", "matrices", "violations", "check"])
def test_bad_joint_values_are_refused(method, q):
    with pytest.raises(BadInput, match="`q` must be"):
        getattr(SLIDER, method)(q)


@pytest.mark.parametrize("q", [(q1,), (q1, q2, q1), sp.Matrix([q1]), 0.5, [[q1, q2]] * 3])
def test_the_wrong_number_of_symbols_is_refused(q):
    with pytest.raises(BadInput, match="`q` must be 2 symbols"):
        PLANAR.fk(q)


def test_limits_are_checked_one_configuration_at_a_time():
    with pytest.raises(BadInput, match=r"shape \(2,\); got shape \(3, 2\)"):
        SLIDER.violations(np.zeros((3, 2)))


def test_rows_do_not_change():
    with pytest.raises(AttributeError):
        SLIDER.rows[0].a = 5
