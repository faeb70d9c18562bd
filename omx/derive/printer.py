"""How one expression looks in each dialect: `math` for one configuration, arrays for batches, JavaScript for pages."""

import re
from dataclasses import dataclass

import sympy as sp
from sympy.functions.elementary.piecewise import ExprCondPair
from sympy.logic.boolalg import BooleanTrue
from sympy.printing.precedence import PRECEDENCE
from sympy.printing.pycode import PythonCodePrinter

from ..arrays import HUGE
from ..errors import BadInput
from .symbolic import as_expression, wrap

#: What an expression may be made of, besides the functions of a dialect.
PARTS = (sp.Symbol, sp.Rational, sp.Float, sp.Add, sp.Mul, sp.Pow, type(sp.pi))

#: What cases are made of: `Piecewise` of (value, condition), where a condition is an inequality, the last one True.
CONDITIONS = (sp.LessThan, sp.StrictLessThan, sp.GreaterThan, sp.StrictGreaterThan, BooleanTrue)
CASES = (sp.Piecewise, ExprCondPair, *CONDITIONS)

FUNCTIONS = ("sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sqrt", "floor")


@dataclass(frozen=True)
class Dialect:
    """The words of one target: `functions` maps SymPy names to it, `pair` computes a sine and a cosine.

    `imports` says which module each word comes from. A statement is `let name = code end`; several results
    stand in `brackets`. `cases`: a value, its condition, and what holds otherwise. `numbers_in`: the dialect
    for what takes numbers alone, if it is another one.
    """

    suffix: str
    number: str
    functions: dict[str, str]
    imports: dict[str, str]
    numbers_in: "Dialect | None" = None
    cases: str = "({0} if {1} else {2})"
    pi: str = "pi"
    pair: str = ""
    let: str = ""
    end: str = ""
    brackets: str = "()"


SCALAR = Dialect(
    suffix="",
    number="float",
    functions={name: name for name in FUNCTIONS}
    | {"Abs": "abs", "Max": "max", "Min": "min", wrap.__name__: "remainder({0}, tau)"},
    imports=dict.fromkeys((*FUNCTIONS, "remainder", "tau", "pi"), "math"),
    pair="sin({0}), cos({0})",
)

BATCH = Dialect(
    suffix="_batch",
    number="Array",
    functions={name: f"xp.{name}" for name in FUNCTIONS}
    | {"Abs": "xp.abs", "Max": "xp.maximum", "Min": "xp.minimum", wrap.__name__: "wrap({0})"},
    imports=SCALAR.imports | dict.fromkeys(("Array", "namespace", "sincos", "where", "wrap"), "omx.arrays"),
    numbers_in=SCALAR,
    cases="where({1}, {0}, {2})",
    pair="sincos({0})",
)

JAVASCRIPT = Dialect(
    suffix="",
    number="number",
    functions={name: f"Math.{name}" for name in FUNCTIONS}
    | {"Abs": "Math.abs", "Max": "Math.max", "Min": "Math.min", wrap.__name__: "wrap({0})"},
    imports={"wrap": "this module"},
    cases="({1} ? {0} : {2})",
    pi="Math.PI",
    let="const ",
    end=";",
    brackets="[]",
)


class Printer(PythonCodePrinter):
    """Prints one expression; remembers in `used` the names that the module has to import.

    `parameters` come first in products and sums, in their order: `L3*s23`, `L2 + L3*D`. `constants`: the symbols that
    stand for numbers also where others stand for arrays.
    """

    def __init__(self, dialect: Dialect, parameters=()):
        super().__init__({"fully_qualified_modules": False})
        self.dialect = dialect
        self.rank = {symbol: i for i, symbol in enumerate(parameters)}
        self.constants = set(parameters)
        self.used: set[str] = set()

    def code(self, expression) -> str:
        """The expression as source text; `BadInput` names what cannot be written."""
        expression = as_expression(expression)
        for part in sp.preorder_traversal(expression):
            if isinstance(part, sp.Piecewise) and part.args[-1].cond != sp.true:
                raise BadInput(f"cannot write `{part}` as code: its last case must be for all the rest, `(..., True)`.")
            if isinstance(part, ExprCondPair) and not isinstance(part.cond, CONDITIONS):
                raise BadInput(f"cannot write `{part.cond}` as the condition of a case; let it be an inequality.")
            if not isinstance(part, (*PARTS, *CASES)) and type(part).__name__ not in self.dialect.functions:
                known = ", ".join(sorted(self.dialect.functions))
                raise BadInput(f"cannot write `{part}` as code; the functions that can be written are {known}.")
            if part.is_number and part.is_Atom and not max(abs(sp.numer(part)), abs(sp.denom(part))) < HUGE:
                raise BadInput(f"cannot write `{expression}` as code: a number in it is beyond 1e306.")
            if part.is_Pow and part.base.is_number and part.base.is_negative and not part.exp.is_integer:
                raise BadInput(f"cannot write `{part}` as code: powers of a negative number are seldom real.")
        code = self.doprint(expression)
        return code[1:-1] if isinstance(expression, sp.Piecewise) and code.startswith("(") else code

    def use(self, code: str) -> str:
        """`code`, with every importable word in it noted."""
        self.used |= set(re.findall(r"(?<!\.)\b[A-Za-z]\w*", code)) & self.dialect.imports.keys()
        return code

    def _dialect(self, expression) -> Dialect:
        """That of numbers, if `expression` is made of nothing else."""
        numbers = expression.free_symbols <= self.constants
        return (self.dialect.numbers_in or self.dialect) if numbers else self.dialect

    def _print_Function(self, expression):
        target = self._dialect(expression).functions[type(expression).__name__]
        printed = [self._print(a) for a in expression.args]
        return self.use(target.format(*printed) if "{0}" in target else f"{target}({', '.join(printed)})")

    _print_sin = _print_cos = _print_tan = _print_asin = _print_acos = _print_atan = _print_Function
    _print_atan2 = _print_Abs = _print_floor = _print_Function

    def _print_Max(self, expression):
        """Two at a time, since NumPy's take two; numbers first, as floats, and what is computed of numbers alone."""

        def order(argument):
            return not argument.free_symbols <= self.constants, not argument.is_number, sp.default_sort_key(argument)

        first, *rest = sorted(expression.args, key=order)
        code = self._number(first)
        for argument in rest:
            target = self._dialect(argument).functions[type(expression).__name__]
            code = self.use(f"{target}({code}, {self._number(argument)})")
        return code

    _print_Min = _print_Max

    def _print_Piecewise(self, expression):
        *cases, (rest, _) = expression.args
        code = self._number(rest)
        for value, condition in reversed(cases):
            form = self._dialect(condition).cases
            code = self.use(form.format(self._number(value), self._print(condition)[1:-1], code))
        return code

    def _number(self, expression) -> str:
        """Whole numbers as floats: of two that NumPy chooses from, it makes whole numbers of 64 bits."""
        return repr(float(expression)) if expression.is_Integer else self._print(expression)

    def _print_Pi(self, expression):
        return self.use(self.dialect.pi)

    def _print_Float(self, expression):
        return repr(float(expression))  # SymPy would round it to 15 digits

    def _print_Pow(self, expression, rational=False):
        base, exponent = expression.as_base_exp()
        if exponent == sp.Rational(1, 2):
            return self.use(f"{self._dialect(base).functions['sqrt']}({self._print(base)})")
        if exponent == 2 and base.is_Symbol:
            return f"{base.name}*{base.name}"
        if exponent.is_Rational and exponent < 0:
            return f"1/{self.parenthesize(base**-exponent, PRECEDENCE['Pow'])}"
        return self._power(base, exponent)

    def _power(self, base, exponent) -> str:
        if self.dialect is JAVASCRIPT:
            return f"Math.pow({self._print(base)}, {self._print(exponent)})"  # -x**2 is an error there
        return "**".join(self.parenthesize(part, PRECEDENCE["Pow"]) for part in (base, exponent))

    def _print_Mul(self, expression):
        numerator, denominator = sp.fraction(expression)
        coefficient, factors = numerator.as_coeff_mul()
        words = self._factors(factors)
        if abs(coefficient) != 1 or not words:
            words.insert(0, self._print(abs(coefficient)))
        code = ("-" if coefficient < 0 else "") + "*".join(words)
        if denominator == 1:
            return code
        below = self._factors(denominator.as_ordered_factors())
        return f"{code}/({'*'.join(below)})" if len(below) > 1 or "*" in below[0] else f"{code}/{below[0]}"

    def _factors(self, factors) -> list[str]:
        ordered = sorted(factors, key=self._factor_order)
        return [self.parenthesize(f, PRECEDENCE["Mul"]) for f in ordered]

    def _print_Add(self, expression, order=None):
        pieces: list[str] = []
        for term in sorted(self._as_ordered_terms(expression, order=order), key=self._term_order):
            text = self.parenthesize(term, PRECEDENCE["Add"], strict=True)
            sign, text = ("-", text[1:]) if text.startswith("-") else ("+", text)
            pieces.append(f" {sign} {text}" if pieces else text if sign == "+" else f"-{text}")
        return "".join(pieces)

    def _factor_order(self, factor):
        """Numbers, lengths, steps, then sines and cosines by their angle: `2*L2*L3`, `L4*s1*c234`."""
        trig = factor.is_Symbol and re.fullmatch(r"[sc](\d.*|_\w+)", factor.name)
        name = factor.name[1:] if trig else str(factor)
        return (not factor.is_number, self.rank.get(factor, len(self.rank)), bool(trig), name, str(factor))

    def _term_order(self, term):
        """What is added before what is subtracted; joint variables, numbers, then terms by their first length."""
        joint = term.is_Symbol and re.fullmatch(r"q\d+", term.name)
        ranks = [self.rank[s] for s in term.free_symbols if s in self.rank]
        first = -2 if joint else -1 if term.is_number else min(ranks, default=len(self.rank))
        return term.could_extract_minus_sign(), first
