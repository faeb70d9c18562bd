"""Symbolic helpers: proofs that succeed where things are equal, and fail where they are not."""

from math import pi

import numpy as np
import pytest
import sympy as sp

from omx import BadInput, DHRow, OmxError
from omx.derive.symbolic import dh_matrix, exact, gather, numbers, prove_equal, residual, short, show, wrap
from omx.errors import NotDecided, NotEqual
from tests.helpers import oracles

q1, q2, q3, q4, delta = q = sp.symbols("q1:5 delta", real=True)
L1, L2, L3, L4 = L = sp.symbols("L1:5", positive=True)
lean = sp.pi / 2 - delta
A1, A2 = dh_matrix(q1, L1, 0, -sp.pi / 2), dh_matrix(q2 - lean, 0, L2, 0)
A3, A4 = dh_matrix(q3 + lean, 0, L3, 0), dh_matrix(q4, 0, L4, 0)
R = L2 * sp.sin(q2 + delta) + L3 * sp.cos(q2 + q3) + L4 * sp.cos(q2 + q3 + q4)
Z = L1 + L2 * sp.cos(q2 + delta) - L3 * sp.sin(q2 + q3) - L4 * sp.sin(q2 + q3 + q4)


def test_dh_matrix_is_the_product_of_four_moves():
    symbols = theta, d, a, alpha = sp.symbols("theta d a alpha")
    values = (0.3, 11.0, -7.0, 1.1)
    matrix = dh_matrix(theta, d, a, alpha).subs(dict(zip(symbols, values, strict=True)))
    np.testing.assert_allclose(np.array(matrix, dtype=float), oracles.link(*values), atol=1e-14)


def test_gather_finds_the_closed_form():
    plane = gather(A2 * A3 * A4)
    assert sp.simplify(plane[0, 3] - R) == 0
    assert sp.count_ops(plane[0, 3]) <= sp.count_ops(R)
    T = A1 * plane
    prove_equal(T, A1 * A2 * A3 * A4)
    prove_equal(T[:3, 3], sp.Matrix([R * sp.cos(q1), R * sp.sin(q1), Z]))


# ---- proofs --------------------------------------------------------------------------------------------

s, D = sp.symbols("s D", real=True)

TRUE = {
    "Pythagoras": (sp.sin(q1) ** 2 + sp.cos(q1) ** 2, 1),
    "an angle sum": (sp.sin(q1 + q2), sp.sin(q1) * sp.cos(q2) + sp.cos(q1) * sp.sin(q2)),
    "a triple angle": (sp.sin(3 * q1), 3 * sp.sin(q1) - 4 * sp.sin(q1) ** 3),
    "a fraction": (1 / (1 - sp.sin(q1)) - 1 / (1 + sp.sin(q1)), 2 * sp.sin(q1) / sp.cos(q1) ** 2),
    "a constant angle": (sp.cos(q1 + sp.pi / 3), sp.cos(q1) / 2 - sp.sqrt(3) * sp.sin(q1) / 2),
    "numbers": (1, 1),
    "a tangent": (sp.tan(q1) * sp.cos(q1), sp.sin(q1)),
    "a double angle and a tangent": (2 * sp.sin(q1) ** 2, sp.sin(2 * q1) * sp.tan(q1)),
    "secants": (1 / sp.cos(q1) ** 2, 1 + sp.tan(q1) ** 2),
    "the other reciprocals": (sp.cot(q1 + q2) * sp.sec(q1 + q2), sp.csc(q1 + q2)),
    "floats": (sp.Float(0.1) + sp.Float(0.2), 0.3),
    "a float's quarter turn": (dh_matrix(q1, 0, 0, -1.5707963267948966)[0, 1], 0),
}
FALSE = {
    "a sign": (sp.sin(q1 - q2), sp.sin(q1 + q2)),
    "another joint": (sp.sin(q1) ** 2 + sp.cos(q2) ** 2, 1),
    "a tiny constant": (sp.sin(q1) ** 2 + sp.cos(q1) ** 2, 1 + sp.Rational(1, 10**12)),
    "an odd power": (sp.sin(q1) ** 3, sp.sin(q1)),
    "equal at zero only": (sp.sin(q1) * sp.cos(q1), sp.sin(q1)),
    "numbers": (1, 2),
    "a root and its sign": (sp.sqrt(1 - sp.sin(q1) ** 2), sp.cos(q1)),
    "an arc and its range": (sp.asin(sp.sin(q1)), q1),
    "a wrapped angle": (wrap(q1), q1),
}


def test_what_can_be_neither_proved_nor_refuted_is_said_to_be_undecided():
    rounded = (sp.cos(q1 - 1.57079632679), sp.sin(q1))
    for left, right in (rounded, (sp.sqrt(sp.sin(q1) ** 2), sp.Abs(sp.sin(q1)) + 1e-14)):
        with pytest.raises(NotDecided, match="not decided"):
            prove_equal(left, right)


@pytest.mark.parametrize("other", [sp.eye(3), None, "q1", sp.Eq(q1, 1)])
def test_only_expressions_and_matrices_of_one_shape_are_compared(other):
    with pytest.raises(BadInput):
        prove_equal(A2, other)


@pytest.mark.parametrize(("expression", "values"), [(q1 / q2, {q1: 0, q2: 0}), (1 / q1, {q1: 0}), (q1, {q1: sp.I})])
def test_a_number_that_is_none_is_not_shown(expression, values):
    with pytest.raises(BadInput, match="is no real number"):
        numbers(expression, values)


@pytest.mark.parametrize("name", TRUE)
def test_what_is_equal_is_proved(name):
    left, right = TRUE[name]
    assert residual(sp.sympify(left) - right) == 0 or name == "floats"
    prove_equal(left, right)


@pytest.mark.parametrize("name", FALSE)
def test_what_differs_is_refused(name):
    with pytest.raises(NotEqual, match=f"{name} is not 0; what remains is") as caught:
        prove_equal(*FALSE[name], name=name)
    assert caught.value.residual != 0
    assert abs(caught.value.sides[0] - caught.value.sides[1]) > 0
    difference = sp.sympify(FALSE[name][0]) - FALSE[name][1]
    at = {symbol: caught.value.values[str(symbol)] for symbol in difference.free_symbols}
    assert abs(difference.evalf(30, subs=at)) > 1e-13
    assert isinstance(caught.value, (OmxError, AssertionError))


def test_what_remains_is_the_whole_difference_and_a_number_is_read_as_one():
    with pytest.raises(NotEqual, match=r"what remains is 0\.001;"):
        prove_equal(sp.sin(q1) + sp.Rational(1, 1000), sp.sin(q1))
    with pytest.raises(NotDecided, match=r"but 5\.55112e-17 remains"):
        prove_equal(sp.Float(0.1) + 0.2 - 0.3, 0)
    assert residual(sp.sin(q1) / 2 + D / 3) == sp.sin(q1) / 2 + D / 3


def test_relations_are_used_and_only_as_far_as_they_go():
    circle = [(s, 1 - D**2)]
    prove_equal(s**2 + D**2, 1, circle)
    prove_equal(s**5, s * (1 - D**2) ** 2, circle)
    with pytest.raises(NotEqual):
        prove_equal(s**2 + D**2, 1)
    with pytest.raises(NotEqual):
        prove_equal(s, sp.sqrt(1 - D**2), circle)  # or minus the root: the relation does not say which


def test_a_relation_may_bring_in_sines():
    prove_equal(s**2, sp.cos(q1) ** 2, [(s, 1 - sp.sin(q1) ** 2)])
    prove_equal(s**2 * D**2, sp.cos(q1) ** 2 * sp.cos(q2) ** 2, [(s, 1 - sp.sin(q1) ** 2), (D, 1 - sp.sin(q2) ** 2)])


def test_one_wrong_entry_of_a_matrix_is_found_and_named():
    wrong = A2.copy()
    wrong[1, 3] = L2 * sp.cos(q2 + delta)
    with pytest.raises(NotEqual, match=r"A2, entry \(1, 3\), is not 0"):
        prove_equal(A2, wrong, name="A2")


# ---- FK(IK) = identity ---------------------------------------------------------------------------------


@pytest.mark.parametrize("elbow", [1, -1])
def test_fk_of_ik_is_the_identity_exactly(elbow):
    """With the angles' sines and cosines as the inverse defines them; s^2 = 1 - D^2, and the wrist's own circle."""
    r_w, z_w, rho2 = sp.symbols("r_w z_w rho2")  # rho2 = r_w^2 + z_w^2
    d = (rho2 - L2**2 - L3**2) / (2 * L2 * L3)
    bend_cos, bend_sin = D, elbow * s
    # gamma = atan2(L3 sin bend, L2 + L3 cos bend) and mu = atan2(z_w, r_w) both belong to a side of length sqrt(rho2)
    g_cos, g_sin = L2 + L3 * bend_cos, L3 * bend_sin
    up_cos, up_sin = (r_w * g_cos - z_w * g_sin) / rho2, (z_w * g_cos + r_w * g_sin) / rho2  # of gamma + mu
    # q2 + delta = pi/2 - (gamma + mu);  q2 + q3 = bend - (gamma + mu)
    reach = L2 * up_cos + L3 * (bend_cos * up_cos + bend_sin * up_sin)
    height = L2 * up_sin - L3 * (bend_sin * up_cos - bend_cos * up_sin)
    relations = [(s, 1 - D**2)]
    for found, wanted in ((reach, r_w), (height, z_w)):
        difference = sp.together((found - wanted) * rho2)
        assert residual(residual(difference, relations).subs(D, d), [(r_w, rho2 - z_w**2)]) == 0


def test_the_proof_would_notice_the_wrong_elbow():
    difference = L2 * s + L3 * s * D - (L2 * s - L3 * s * D)
    assert residual(difference, [(s, 1 - D**2)]) != 0


# ---- angles brought into one turn ----------------------------------------------------------------------


def test_wrap_stays_in_derivations_and_is_worked_out_for_numbers():
    assert wrap(q1 + q2).func is wrap
    assert wrap(3 * sp.pi) == sp.pi
    assert wrap(-sp.pi) == sp.pi
    assert wrap(0) == 0
    assert float(wrap(sp.Float(4.0))) == pytest.approx(4 - 2 * pi)
    assert wrap(-q2 - q3).diff(q3) == -1
    assert "wrap" in sp.latex(wrap(q1))


@pytest.mark.parametrize("modules", ["math", "numpy"])
def test_wrap_can_be_lambdified(modules):
    function = sp.lambdify([q1, q2], wrap(q1 + q2), modules)
    assert function(3.0, 3.0) == pytest.approx(6 - 2 * pi)
    assert function(3.0, -3.5) == pytest.approx(-0.5)


# ---- rows, display -------------------------------------------------------------------------------------


def test_exact_makes_twists_exact_and_leaves_the_rest():
    row = exact(DHRow(delta - pi / 2, 77.0, 130.5, pi / 6))
    assert row == DHRow(delta - sp.pi / 2, 77, 130.5, sp.pi / 6)
    assert exact(DHRow(0.3, L1, 0, -pi / 2)) == DHRow(0.3, L1, 0, -sp.pi / 2)
    assert exact(DHRow(0, 0, 0, 0, prismatic=True)).prismatic


def test_numbers_puts_values_in_and_rounds():
    shown = numbers(sp.Matrix([[sp.sin(q1), L1, sp.pi / 2, -sp.cos(sp.pi / 2)]]), {q1: 0.5, L1: 77})
    assert shown == sp.Matrix([[sp.Float(0.479, 15), 77, sp.Float(1.571, 15), 0]])
    assert numbers(wrap(q1), {q1: 7.0}, digits=2) == sp.Float(0.72, 15)


def test_numbers_names_the_symbol_without_a_value():
    with pytest.raises(BadInput, match="it lacks L1, q1"):
        numbers(L1 * sp.sin(q1) + L2, {L2: 3})


def test_a_unit_stands_behind_the_number_and_converts_nothing():
    assert sp.latex(numbers(L1, {L1: 77}, unit="mm")) == r"77 \,\mathrm{mm}"
    assert str(numbers(L1, {L1: 0}, unit="mm")) == "0*mm"
    assert numbers(sp.deg(q1), {q1: sp.pi / 6}, unit="deg").args[0] == 30


def test_short_abbreviates_sums_of_symbols_and_leaves_other_angles():
    total = sp.Symbol("q3") + sp.Symbol("q12") + sp.Symbol("delta")
    assert sp.latex(short(sp.cos(q1) * sp.sin(q1))) == "c_{1} s_{1}"
    assert sp.latex(short(sp.sin(sp.Symbol("q2") + sp.Symbol("q3")))) == "s_{23}"
    assert sp.latex(short(sp.cos(sp.Symbol("q2") + sp.Symbol("delta")))) == r"c_{2\delta}"
    assert short(sp.sin(total - 2 * q1)) == sp.sin(total - 2 * q1)
    assert short(sp.Matrix([[L1, sp.cos(q1)]])).shape == (1, 2)


def test_show_is_an_equation_with_one_or_more_sides():
    assert sp.latex(show("r", R)).startswith("r = ")
    assert sp.latex(show("A_1", A1, numbers(A1, {q1: 0, L1: 77}))).count("=") == 2


def test_show_sets_words_upright_and_atan2_with_its_2_on_the_line():
    bend, D, s = sp.symbols("bend D s")
    assert sp.latex(show("bend", sp.atan2(s, D))) == r"\mathrm{bend} = \mathrm{atan2}\left(s, D\right)"
    assert sp.latex(show("gamma", sp.Matrix([bend + D]))) == (
        r"\gamma = \left[\begin{matrix}D + \mathrm{bend}\end{matrix}\right]"
    )


def test_the_name_of_what_is_proved_is_text():
    with pytest.raises(BadInput, match="`name` must be text"):
        prove_equal(sp.Symbol("x"), 0, name=5)
