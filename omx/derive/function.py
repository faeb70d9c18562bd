"""`Function`: what a notebook hands over, and the names it will have in code, checked before anything is written."""

import keyword
import re
import unicodedata
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import sympy as sp

from ..arrays import shown
from ..errors import BadInput
from .printer import BATCH, SCALAR
from .symbolic import as_expression

#: JavaScript's own words, those of its strict mode included, and what it lets nobody define.
JAVASCRIPT_WORDS = {
    "arguments", "await", "break", "case", "catch", "class", "const", "continue", "debugger", "default", "delete", "do",
    "else", "enum", "eval", "export", "extends", "false", "finally", "for", "function", "if", "implements", "import",
    "in", "instanceof", "interface", "let", "new", "null", "package", "private", "protected", "public", "return",
    "static", "super", "switch", "this", "throw", "true", "try", "typeof", "undefined", "var", "void", "while", "with",
    "yield", "NaN", "Infinity",
}  # fmt: skip

#: Names that the written modules use themselves, in Python or in JavaScript.
RESERVED = {
    *keyword.kwlist, *JAVASCRIPT_WORDS, *SCALAR.imports, *BATCH.imports, "xp", "abs", "max", "min", "float", "tuple",
    "DHRow", "PARAMETERS", "dh_rows", "Math", "_",
}  # fmt: skip


@dataclass(frozen=True)
class Function:
    """What a notebook derived, ready to be written.

    `outputs` maps each result's name to an expression, a matrix, or a (nested) sequence of expressions. `steps`
    are (symbol, expression) pairs, computed in their order before the results; an expression may use the
    `inputs`, the module's parameters and the steps before it. Where a step's expression appears again, its symbol
    is written; steps that no result needs are left out.
    """

    name: str
    doc: str
    inputs: Sequence[sp.Symbol]
    outputs: Mapping[str, Any]
    steps: Sequence[tuple[sp.Symbol, sp.Expr]] = field(default=())

    @cached_property
    def named(self) -> tuple[list[tuple[sp.Symbol, sp.Expr]], dict[str, Any]]:
        """The steps and the outputs as they are written: shortened by the steps before them, useless ones gone."""
        short: dict[sp.Expr, sp.Symbol] = {}
        steps: list[tuple[sp.Symbol, sp.Expr]] = []
        for symbol, expression in self.steps:
            expression = as_expression(expression)
            steps.append((symbol, expression.xreplace(short)))
            if expression.args and expression.free_symbols:
                short.setdefault(expression, symbol)
        outputs = {name: tree(value, short) for name, value in self.outputs.items()}
        wanted = set().union(*(leaf.free_symbols for leaf in sp.flatten(outputs.values())))
        kept = []
        for symbol, expression in reversed(steps):
            if symbol in wanted:
                kept.append((symbol, expression))
                wanted |= expression.free_symbols
        return kept[::-1], outputs

    @cached_property
    def results(self) -> list[sp.Expr]:
        """Every expression of the outputs, in their order."""
        return sp.flatten(self.named[1].values())

    @cached_property
    def sines_and_cosines(self) -> set[sp.Expr]:
        """Every sine and cosine in what is written."""
        body = [expression for _, expression in self.named[0]] + self.results
        return set().union(*(expression.atoms(sp.sin, sp.cos) for expression in body))

    @cached_property
    def angles(self) -> list[sp.Expr]:
        """What the sines and cosines are taken of: c1 s1 before c23 s23 before c234 s234."""
        found = {trig.args[0] for trig in self.sines_and_cosines}
        return sorted(found, key=lambda angle: (len(angle.free_symbols), label(angle)))

    def sum_name(self, angle) -> str:
        """The name of the variable that holds a sum of angles: q23, q2_delta; sum_12 where joint 12 is called q12."""
        short = label(angle)
        name = f"q{short}" if short[0].isdigit() else f"angle{short}"
        return f"sum_{short}" if name in {symbol.name for symbol in self.inputs} else name

    def check(self, parameters: Sequence[sp.Symbol]) -> None:
        """`BadInput` for the first name that is unknown, taken, or no name in code."""
        check_name(self.name, "the function")
        self._check_kinds()
        given = [*self.inputs, *parameters]
        taken = self._taken_names(given, [symbol for symbol, _ in self.steps])
        self._check_outputs(taken)
        self._check_angles(taken | set(self.outputs))
        known = set(given)
        for symbol, expression in self.steps:
            self._check_known(as_expression(expression), known, f"step `{symbol}`")
            known.add(symbol)
        for name, value in self.outputs.items():
            for expression in sp.flatten([tree(value)]):
                self._check_known(expression, known, f"output `{name}`")

    def _check_kinds(self) -> None:
        """That each field is of its kind, before any of them is looked into."""
        if not isinstance(self.doc, str):
            raise BadInput(f"`{self.name}`: `doc` must be a sentence; got {shown(self.doc)}.")
        if not isinstance(self.outputs, Mapping):
            raise BadInput(f"`{self.name}`: `outputs` must map each result's name to it; got {shown(self.outputs)}.")
        if not self.outputs:
            raise BadInput(f"`{self.name}` has no outputs.")
        if not isinstance(self.inputs, Sequence) or isinstance(self.inputs, str):
            raise BadInput(f"`{self.name}`: `inputs` must be a list of symbols; got {shown(self.inputs)}.")
        pairs = isinstance(self.steps, Sequence) and all(isinstance(s, Sequence) and len(s) == 2 for s in self.steps)
        if not pairs or isinstance(self.steps, str):
            raise BadInput(f"`{self.name}`: `steps` must be (symbol, expression) pairs; got {shown(self.steps)}.")

    def _taken_names(self, given, steps) -> set[str]:
        taken = set()
        for symbol in (*given, *steps):
            if not isinstance(symbol, sp.Symbol):
                raise BadInput(
                    f"`{self.name}`: inputs, parameters and steps must be SymPy symbols; got {shown(symbol)}."
                )
            check_name(symbol.name, f"`{self.name}`: the symbol `{symbol}`")
            if symbol.name in taken:
                raise BadInput(f"`{self.name}`: two inputs, parameters or steps are called `{symbol}`.")
            taken.add(symbol.name)
        return taken

    def _check_outputs(self, taken: set[str]) -> None:
        for name, value in self.outputs.items():
            check_name(name, f"`{self.name}`: the output `{name}`")
            itself = isinstance(value, sp.Symbol) and value.name == name
            if name in taken and not itself and len(self.outputs) > 1:
                raise BadInput(f"`{self.name}`: the output `{name}` has the name of an input, parameter or step.")

    def _check_angles(self, taken: set[str]) -> None:
        for angle in self.angles:
            for name, part in self._own_names(angle).items():
                if name in taken:
                    raise BadInput(f"`{self.name}`: {part} is written as `{name}`, but that name is taken; change it.")
                taken.add(name)

    def _own_names(self, angle) -> dict[str, sp.Expr]:
        """The names that the generator gives to an angle, its sine and its cosine, and what they stand for."""
        trig = {f"s{label(angle)}": sp.sin(angle), f"c{label(angle)}": sp.cos(angle)}
        used = {name: part for name, part in trig.items() if part in self.sines_and_cosines}
        return used | ({self.sum_name(angle): angle} if angle.is_Add else {})

    def _check_known(self, expression, known: set, where: str) -> None:
        unknown = sorted(symbol.name for symbol in expression.free_symbols - known)
        if unknown:
            names = ", ".join(sorted(symbol.name for symbol in known))
            raise BadInput(
                f"`{self.name}`, {where}: unknown symbol `{unknown[0]}`. Known here: {names}. Make it an input, "
                f"a parameter with a value, or a step. (SymPy symbols with other assumptions are other symbols.)"
            )


def tree(value, short: Mapping | None = None):
    """An output as nested tuples of expressions, a matrix as a tuple of rows; `short` is put in."""
    if isinstance(value, sp.MatrixBase):
        value = value.tolist()
    if isinstance(value, (list, tuple)):
        return tuple(tree(item, short) for item in value)
    return as_expression(value).xreplace(short or {})


def label(angle) -> str:
    """The short name of an angle: q2 + q3 -> "23", q2 + delta -> "2_delta", pitch -> "_pitch"."""
    joints, others = [], []
    for term in sp.Add.make_args(angle):
        sign, term = ("m", -term) if term.could_extract_minus_sign() else ("", term)
        joint = re.fullmatch(r"q(\d+)", term.name) if term.is_Symbol else None
        if joint:
            joints.append((int(joint[1]), sign))
        else:
            others.append(sign + _word(term))
    separator = "_" if any(number > 9 for number, _ in joints) else ""
    numbers = [f"{sign}{number}" for number, sign in sorted(joints)]
    return separator + separator.join(numbers) + "".join(f"_{name}" for name in sorted(others))


def _word(term) -> str:
    """A term as part of a name: pi/6 -> "pi_6", 0.3 -> "0p3", 2*q1 -> "2q1"."""
    text = f"{float(term):g}" if term.is_Float else str(term)
    return re.sub(r"\W+", "", text.replace("/", "_").replace(".", "p"))


def check_name(name, what: str) -> None:
    """`BadInput` unless `name` is a name in Python and in JavaScript, the same in both, and free."""
    reason = ""
    if not isinstance(name, str) or not name.isidentifier() or name.startswith("__"):
        reason = "is no name in code"
    elif unicodedata.normalize("NFKC", name) != name:
        reason = f"is the same name as `{unicodedata.normalize('NFKC', name)}` to Python, and another one to JavaScript"
    elif name in RESERVED:
        reason = "is used by the generated code, or a word of Python or JavaScript"
    if reason:
        raise BadInput(f"{what}: `{name if isinstance(name, str) else shown(name)}` {reason}; choose another.")
