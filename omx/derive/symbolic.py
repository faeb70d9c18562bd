"""SymPy helpers for the derivations: DH matrices, tidy angle sums, proofs of equality, display.

Only notebooks, tests and `omx.derive` import this module; the arm itself never needs SymPy.
"""

import re
from collections.abc import Mapping

import numpy as np
import sympy as sp
from sympy.simplify.fu import TR1, TR2, TR10i

from .. import arrays
from ..arrays import as_count, shown
from ..dh import as_expression, exact, exact_angle, link_rows
from ..errors import BadInput, NotDecided, NotEqual

__all__ = [
    "Unit", "as_expression", "dh_matrix", "exact", "gather", "numbers", "prove_equal", "residual", "short", "show",
    "wrap",
]  # fmt: skip

#: Points at which two sides are compared when their difference does not come out as 0, and how near they must be,
#: with and without floats in them. They are worked out to 30 digits.
POINTS, NEAR, EXACTLY_NEAR = 12, 1e-9, 1e-20


class wrap(sp.Function):
    """An angle brought into (-pi, pi]: kept as it is in derivations, worked out for numbers and in code."""

    nargs = 1
    _imp_ = staticmethod(arrays.wrap)  # what `lambdify` calls

    @classmethod
    def eval(cls, angle):
        if angle.is_number and angle.is_real:
            return angle - 2 * sp.pi * sp.ceiling(angle / (2 * sp.pi) - sp.Rational(1, 2))

    def fdiff(self, argindex=1):
        return sp.Integer(1)


class _Atan2(sp.Function):
    """`atan2` as the prose writes it; SymPy would set its 2 as an index."""

    def _latex(self, printer) -> str:
        return rf"\mathrm{{atan2}}\left({', '.join(printer._print(arg) for arg in self.args)}\right)"


class Unit(sp.Symbol):
    """A unit behind a number, set upright: `274 mm`."""

    def _latex(self, printer) -> str:
        return rf"\,\mathrm{{{self.name}}}"


def dh_matrix(theta, d, a, alpha) -> sp.Matrix:
    """`Rz(theta) Tz(d) Tx(a) Rx(alpha)`, standard convention, 4x4; quarter turns are exact."""
    theta, d, a, alpha = map(as_expression, (theta, d, a, alpha))
    return sp.Matrix(link_rows(exact_angle(theta), d, a, exact_angle(alpha), sp.cos, sp.sin))


def gather(expression):
    """Products of sines and cosines gathered into angle sums: `c2 c3 - s2 s3` becomes `cos(q2 + q3)`.

    Works on an expression or, entry by entry, on a matrix. Multiply out the part of a chain whose axes are
    parallel, `gather` it, and only then bring in the rest: the result stays short.
    """
    if isinstance(expression, sp.MatrixBase):
        return expression.applyfunc(gather)
    return TR10i(sp.expand(as_expression(expression)))


def residual(difference, relations=()):
    """What is left of `difference` when every angle sum is expanded and sin^2 + cos^2 = 1 is used.

    `relations`: pairs (symbol, expression for its square), for symbols bound by an identity, such as
    `(s, 1 - D**2)`; they are used in their order. What is left is exactly 0 if, and only if, the difference is 0
    for all angles and all symbols that keep the relations, as long as it is made of sines, cosines, tangents and
    their reciprocals; half an angle counts as an angle of its own. Works on an expression or a matrix.
    """
    relations = _pairs(relations)
    if isinstance(difference, sp.MatrixBase):
        return difference.applyfunc(lambda entry: residual(entry, relations))
    difference = _in_sines(as_expression(difference))
    numerator, denominator = sp.fraction(sp.together(sp.expand(sp.expand_trig(difference))))
    expanded = sp.expand(numerator / denominator if denominator.is_number else numerator)
    for symbol, square in relations:
        expanded = _reduce_square(expanded, symbol, sp.expand_trig(square))
    for sine in sorted(expanded.atoms(sp.sin), key=sp.default_sort_key):
        expanded = _reduce_square(expanded, sine, 1 - sp.cos(sine.args[0]) ** 2)
    return expanded


def _reduce_square(expression, base, square):
    """`expression` with base**2 replaced by `square` until only base**0 and base**1 are left."""
    marker = sp.Dummy("base")
    try:
        polynomial = sp.Poly(expression.xreplace({base: marker}), marker)
    except sp.PolynomialError:  # the base is under a root, or in an arc: nothing to reduce
        return expression
    total = sp.Integer(0)
    for (power,), coefficient in polynomial.terms():
        total += coefficient * square ** (power // 2) * base ** (power % 2)
    return sp.expand(total)


def _in_sines(expression):
    """Tangents and reciprocals as sines and cosines, floats as the fractions that they print as."""
    expression = TR2(TR1(expression))
    return sp.nsimplify(expression, rational=True) if expression.has(sp.Float) else expression


def prove_equal(left, right, relations=(), name: str = "the difference") -> None:
    """Prove `left == right` symbolically, expressions or matrices. Prints nothing.

    Raises `NotEqual` with numbers at which the sides differ, `NotDecided` where neither a proof nor such numbers are
    found, `BadInput`. `relations`: see `residual`.
    """
    left, right, relations = _as_matrix(left), _as_matrix(right), _pairs(relations)
    if not isinstance(name, str):
        raise BadInput(f"`name` must be text; got {shown(name)}.")
    if left.shape != right.shape:
        raise BadInput(f"`left` and `right` must have one shape; they have {left.shape} and {right.shape}.")
    for index, (one, other) in enumerate(zip(left, right, strict=True)):
        rest = residual(_in_sines(one) - _in_sines(other), relations)
        if rest == 0:
            continue
        where = f"{name}, entry {divmod(index, left.cols)}," if len(left) > 1 else name
        _find_a_difference(one, other, relations, where, rest)
        if sp.count_ops(rest) > 100 or relations or sp.simplify(one - other) != 0:
            raise NotDecided(where, rest)


def _pairs(relations) -> list[tuple]:
    """The relations as (symbol, expression) pairs."""
    try:
        pairs = [tuple(pair) for pair in relations]
    except TypeError:
        pairs = [()]
    if not all(len(pair) == 2 and isinstance(pair[0], sp.Symbol) for pair in pairs):
        raise BadInput(f"`relations` must be (symbol, expression for its square) pairs; got {shown(relations)}.")
    return [(symbol, as_expression(square)) for symbol, square in pairs]


def _as_matrix(value):
    if isinstance(value, sp.MatrixBase):
        return value
    return sp.Matrix([as_expression(value)])


def _find_a_difference(left, right, relations, where: str, rest) -> None:
    """Raise `NotEqual` with the first numbers, all of them real, at which the sides differ."""
    near = NEAR if any(side.has(sp.Float) for side in (left, right)) else EXACTLY_NEAR
    for point in _points((left, right), relations):
        try:
            sides = [side.evalf(30, subs=point) for side in (left, right)]
            apart = complex(sides[0] - sides[1])
            sides = [complex(side) for side in sides]
        except (TypeError, ValueError, ZeroDivisionError, OverflowError):  # no value there
            continue
        if abs(apart) > near * (1 + max(map(abs, sides))):
            raise NotEqual(where, rest, {str(symbol): float(value) for symbol, value in point.items()}, tuple(sides))


def _points(sides, relations):
    """Where to compare: real values for every symbol, the same each time; they keep the relations."""
    bound = [symbol for symbol, _ in relations]
    squares = dict(relations)
    symbols = set().union(*(side.free_symbols for side in (*sides, *squares.values()))) - set(bound)
    random = np.random.default_rng(0)
    for _ in range(POINTS):
        point = {}
        for symbol in sorted(symbols, key=sp.default_sort_key):
            value = random.uniform(0.2, 7.0) * (1 if symbol.is_positive else random.choice([-1, 1]))
            point[symbol] = sp.Integer(round(value) or 1) if symbol.is_integer else sp.Float(value, 30)
        for _ in bound:
            for symbol, square in squares.items():
                number = square.evalf(30, subs=point) if square.free_symbols <= point.keys() else None
                if symbol not in point and number is not None and number.is_nonnegative:
                    point[symbol] = sp.sqrt(number) * random.choice([-1, 1])
        if all(symbol in point for symbol in bound):
            yield point


def show(name: str, *forms) -> sp.Eq:
    """`name = form` as an equation that the notebook typesets; `name` may be LaTeX, such as `A_1`.

    More forms stand side by side: `show("A_1", A1, numbers(A1, lengths))` is the formula, then its value.
    """
    if not isinstance(name, str):
        raise BadInput(f"`name` must be a text, such as 'A_1'; got {shown(name)}.")
    equation = _typeset(sp.Symbol(name))
    for form in forms:
        form = form if isinstance(form, (sp.Basic, sp.MatrixBase)) else as_expression(form)
        equation = sp.Eq(equation, _typeset(form), evaluate=False)
    return equation


def _typeset(expression):
    """For display: names that are words upright, as the prose sets them, and `atan2` with its 2 on the line."""
    words = {s: sp.Symbol(rf"\mathrm{{{s.name}}}") for s in expression.free_symbols if _is_word(s)}
    expression = expression.xreplace(words) if words else expression
    return expression.replace(sp.atan2, _Atan2) if expression.has(sp.atan2) else expression


def _is_word(symbol) -> bool:
    return len(symbol.name) > 2 and symbol.name.isalpha() and sp.latex(symbol) == symbol.name


def short(expression):
    """Sines and cosines as textbooks abbreviate them: `cos(q2 + q3)` as c_23. For display only."""
    expression = expression if isinstance(expression, sp.MatrixBase) else as_expression(expression)
    waves = sorted(expression.atoms(sp.sin, sp.cos), key=sp.default_sort_key)
    return expression.xreplace({wave: _abbreviated(wave) for wave in waves})


def _abbreviated(wave):
    """`sin(q2 + delta)` as the symbol s_2delta; unchanged where the angle is more than a sum of symbols."""
    terms = sp.Add.make_args(wave.args[0])
    if not all(term.is_Symbol for term in terms):
        return wave
    words = [term.name[1:] if re.fullmatch(r"q\d+", term.name) else sp.latex(term) for term in terms]
    subscript = "".join(sorted(words, key=lambda word: (not word.isdigit(), word)))
    return sp.Symbol(f"{type(wave).__name__[0]}_{{{subscript}}}", real=True)


def _values(values) -> dict:
    if not isinstance(values, Mapping):
        raise BadInput(f"`values` must map each symbol to its number; got {shown(values)}.")
    return {symbol: as_expression(value) for symbol, value in values.items()}


def numbers(expression, values: Mapping, digits: int = 3, unit: str = ""):
    """`expression` with `values` put in, rounded to `digits` decimals: to be shown beside the formula.

    Whole numbers come out as integers, so that a matrix of zeros and ones is easy to read. `unit` is written behind
    one number; it converts nothing.
    """
    if isinstance(expression, sp.MatrixBase):
        return expression.applyfunc(lambda entry: numbers(entry, values, digits))
    digits = as_count(digits, "digits", 0, 15)
    if not isinstance(unit, str):
        raise BadInput(f"`unit` must be a text, such as 'mm'; got {shown(unit)}.")
    number = as_expression(expression).subs(_values(values), simultaneous=True).evalf()
    if number.free_symbols:
        missing = ", ".join(sorted(symbol.name for symbol in number.free_symbols))
        raise BadInput(f"`values` must hold a number for every symbol; it lacks {missing}.")
    if not (isinstance(number, sp.Expr) and number.is_real and number.is_finite):
        raise BadInput(f"with these `values`, {shown(expression)} is no real number; it comes out as {number}.")
    value = round(float(number), digits)
    value = sp.Integer(int(value)) if value.is_integer() else sp.Float(value, 15)
    return sp.Mul(value, Unit(unit), evaluate=False) if unit else value
