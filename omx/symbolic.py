"""SymPy helpers for the derivations: DH matrices, tidy angle sums, proofs of equality, display.

Only notebooks, tests and `omx.codegen` import this module; the arm itself never needs SymPy.
"""

import sympy as sp
from sympy.simplify.fu import TR10i

from .errors import OmxError


class NotEqual(OmxError, AssertionError):
    """Two expressions that should be the same are not; `residual` is what is left of their difference."""

    def __init__(self, name: str, residual):
        self.residual = residual
        super().__init__(f"{name} is not 0; what remains is {residual}")


def dh_matrix(theta, d, a, alpha) -> sp.Matrix:
    """`Rz(theta) Tz(d) Tx(a) Rx(alpha)`, standard convention, 4x4."""
    ct, st, ca, sa = sp.cos(theta), sp.sin(theta), sp.cos(alpha), sp.sin(alpha)
    return sp.Matrix(
        [
            [ct, -st * ca, st * sa, a * ct],
            [st, ct * ca, -ct * sa, a * st],
            [0, sa, ca, d],
            [0, 0, 0, 1],
        ]
    )


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
    `(s, 1 - D**2)`. The answer is exactly 0 if, and only if, the polynomial in sines, cosines and symbols is 0.
    Works on an expression or a matrix.
    """
    if isinstance(difference, sp.MatrixBase):
        return difference.applyfunc(lambda entry: residual(entry, relations))
    numerator = sp.numer(sp.together(sp.expand(sp.expand_trig(difference))))
    expanded = sp.expand(numerator)
    for sine in sorted(expanded.atoms(sp.sin), key=sp.default_sort_key):
        expanded = _reduce_square(expanded, sine, 1 - sp.cos(sine.args[0]) ** 2)
    for symbol, square in relations:
        expanded = _reduce_square(expanded, symbol, square)
    return sp.expand(expanded)


def _reduce_square(expression, base, square):
    """`expression` with base**2 replaced by `square` until only base**0 and base**1 are left."""
    marker = sp.Dummy("base")
    polynomial = sp.Poly(expression.subs(base, marker), marker)
    total = sp.Integer(0)
    for (power,), coefficient in polynomial.terms():
        total += coefficient * square ** (power // 2) * base ** (power % 2)
    return sp.expand(total)


def prove_equal(left, right, relations=(), name: str = "the difference") -> None:
    """Prove `left == right` symbolically; raise `NotEqual` with the residual otherwise. Prints nothing."""
    rest = residual(left - right, relations)
    if isinstance(rest, sp.MatrixBase):
        for entry in rest:
            if entry != 0:
                raise NotEqual(name, entry)
    elif rest != 0:
        raise NotEqual(name, rest)


def show(name: str, expression) -> sp.Eq:
    """`name = expression` as an equation that the notebook typesets; `name` may be LaTeX, such as `A_1`."""
    return sp.Eq(sp.Symbol(name), expression, evaluate=False)


def numbers(expression, values: dict, digits: int = 3):
    """`expression` with `values` put in, as floats rounded to `digits` decimals: the formula beside its value."""
    def rounded(entry):
        return sp.Float(round(float(sp.sympify(entry).evalf(subs=values)), digits) + 0.0, 15)

    if isinstance(expression, sp.MatrixBase):
        return expression.applyfunc(rounded)
    return rounded(expression)
