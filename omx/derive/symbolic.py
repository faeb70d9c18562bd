"""SymPy helpers for the derivations: DH matrices, tidy angle sums, proofs of equality, display.

Only notebooks, tests and `omx.derive` import this module; the arm itself never needs SymPy.
"""

import re

import sympy as sp
from sympy.simplify.fu import TR10i

from .. import arrays
from ..dh import DHRow, link_rows
from ..errors import BadInput, NotEqual


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
    """`Rz(theta) Tz(d) Tx(a) Rx(alpha)`, standard convention, 4x4."""
    return sp.Matrix(link_rows(theta, d, a, alpha, sp.cos, sp.sin))


def exact(row: DHRow) -> DHRow:
    """The row for SymPy: angles that are multiples of 15 deg exact, so that their cosines are 0, 1/2, ...

    Entries may be numbers or expressions: `delta - 1.5707963` becomes `delta - pi/2`, a length 77.0 becomes 77.
    """
    return DHRow(_angle(row.theta), _length(row.d), _length(row.a), _angle(row.alpha), row.prismatic)


def _angle(value):
    constant, rest = sp.sympify(value).as_coeff_Add()
    if constant.is_Float:
        steps = round(float(constant / (sp.pi / 12)))
        near = abs(float(constant - steps * sp.pi / 12)) < 1e-12
        constant = steps * sp.pi / 12 if near else constant
    return constant + rest


def _length(value):
    value = sp.sympify(value)
    return sp.Integer(int(value)) if value.is_Float and float(value).is_integer() else value


def gather(expression):
    """Products of sines and cosines gathered into angle sums: `c2 c3 - s2 s3` becomes `cos(q2 + q3)`.

    Works on an expression or, entry by entry, on a matrix. Multiply out the part of a chain whose axes are
    parallel, `gather` it, and only then bring in the rest: the result stays short.
    """
    if isinstance(expression, sp.MatrixBase):
        return expression.applyfunc(gather)
    return TR10i(sp.expand(expression))


def residual(difference, relations=()):
    """What is left of `difference` when every angle sum is expanded and sin^2 + cos^2 = 1 is used.

    `relations`: pairs (symbol, expression for its square), for symbols bound by an identity, such as
    `(s, 1 - D**2)`; they are used in their order. What is left is exactly 0 if, and only if, the difference is 0
    for all angles and all symbols that keep the relations; half an angle counts as an angle of its own. Works on
    an expression or a matrix.
    """
    if isinstance(difference, sp.MatrixBase):
        return difference.applyfunc(lambda entry: residual(entry, relations))
    numerator = sp.numer(sp.together(sp.expand(sp.expand_trig(difference))))
    expanded = sp.expand(numerator)
    for symbol, square in relations:
        expanded = _reduce_square(expanded, symbol, sp.expand_trig(square))
    for sine in sorted(expanded.atoms(sp.sin), key=sp.default_sort_key):
        expanded = _reduce_square(expanded, sine, 1 - sp.cos(sine.args[0]) ** 2)
    return expanded


def _reduce_square(expression, base, square):
    """`expression` with base**2 replaced by `square` until only base**0 and base**1 are left."""
    marker = sp.Dummy("base")
    polynomial = sp.Poly(expression.xreplace({base: marker}), marker)
    total = sp.Integer(0)
    for (power,), coefficient in polynomial.terms():
        total += coefficient * square ** (power // 2) * base ** (power % 2)
    return sp.expand(total)


def prove_equal(left, right, relations=(), name: str = "the difference") -> None:
    """Prove `left == right` symbolically; raise `NotEqual` with the residual otherwise. Prints nothing."""
    rest = residual(left - right, relations)
    if not isinstance(rest, sp.MatrixBase):
        rest = sp.Matrix([rest])
    for index, entry in enumerate(rest):
        if entry != 0:
            where = f"{name}, entry {divmod(index, rest.cols)}," if len(rest) > 1 else name
            raise NotEqual(where, entry)


def show(name: str, *forms) -> sp.Eq:
    """`name = form` as an equation that the notebook typesets; `name` may be LaTeX, such as `A_1`.

    More forms stand side by side: `show("A_1", A1, numbers(A1, lengths))` is the formula, then its value.
    """
    equation = _typeset(sp.Symbol(name))
    for form in forms:
        equation = sp.Eq(equation, _typeset(sp.sympify(form)), evaluate=False)
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


def numbers(expression, values: dict, digits: int = 3, unit: str = ""):
    """`expression` with `values` put in, rounded to `digits` decimals: to be shown beside the formula.

    Whole numbers come out as integers, so that a matrix of zeros and ones is easy to read. `unit` is written behind
    one number; it converts nothing.
    """
    if isinstance(expression, sp.MatrixBase):
        return expression.applyfunc(lambda entry: numbers(entry, values, digits))
    number = sp.sympify(expression).subs(values).evalf()
    if number.free_symbols:
        missing = ", ".join(sorted(symbol.name for symbol in number.free_symbols))
        raise BadInput(f"`values` must hold a number for every symbol; it lacks {missing}.")
    value = round(float(number), digits)
    value = sp.Integer(int(value)) if value.is_integer() else sp.Float(value, 15)
    return sp.Mul(value, Unit(unit), evaluate=False) if unit else value
