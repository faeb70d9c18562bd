"""One `Function` as source text: sines and cosines first, then the named steps, then the results."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import sympy as sp

from ..errors import BadInput
from .printer import BATCH, Dialect, Printer

WIDTH = 110


@dataclass(frozen=True)
class Function:
    """What a notebook derived, ready to be written.

    `outputs` maps each result's name to an expression, a sequence of expressions, or a matrix. `steps` are
    (symbol, expression) pairs, computed in their order before the results; an expression may use the `inputs`,
    the module's parameters and the steps before it.
    """

    name: str
    doc: str
    inputs: Sequence[sp.Symbol]
    outputs: Mapping[str, Any]
    steps: Sequence[tuple[sp.Symbol, sp.Expr]] = field(default=())

    def flat_outputs(self) -> list[sp.Expr]:
        return [sp.sympify(e) for value in self.outputs.values() for e in entries(value)]

    def check(self, parameters: Sequence[sp.Symbol]) -> None:
        """Every symbol must be an input, a parameter or an earlier step; `BadInput` names the first that is not."""
        known = set(self.inputs) | set(parameters)
        for symbol, expression in self.steps:
            self._check_known(expression, known, f"step `{symbol}`")
            known.add(symbol)
        for name, value in self.outputs.items():
            for expression in entries(value):
                self._check_known(expression, known, f"output `{name}`")

    def _check_known(self, expression, known, where) -> None:
        unknown = sorted(s.name for s in sp.sympify(expression).free_symbols - known)
        if unknown:
            names = ", ".join(sorted(s.name for s in known))
            raise BadInput(
                f"`{self.name}`, {where}: unknown symbol `{unknown[0]}`. Known here: {names}. Make it an input, "
                f"a parameter with a value, or a step. (SymPy symbols with other assumptions are other symbols.)"
            )


def entries(value) -> list:
    """The expressions in an output: of a matrix row by row, of a sequence in order, or the one itself."""
    if isinstance(value, sp.MatrixBase):
        return list(value)
    if isinstance(value, (list, tuple)):
        return [e for item in value for e in entries(item)]
    return [value]


def operations(function: Function) -> str:
    """How much arithmetic one call costs, for the docstring."""
    body = [e for _, e in function.steps] + function.flat_outputs()
    trig = set().union(*(sp.sympify(e).atoms(sp.sin, sp.cos) for e in body))
    names = {t: sp.Dummy() for t in trig}
    rest = sum(sp.count_ops(sp.sympify(e).xreplace(names)) for e in body)
    return f"{rest} operations and {len(trig)} sines and cosines"


class Emitter:
    """Writes one function in one dialect."""

    def __init__(self, function: Function, parameters: Sequence[sp.Symbol], dialect: Dialect):
        self.function, self.parameters, self.dialect = function, tuple(parameters), dialect
        self.printer = Printer(dialect, parameters)
        self.lines: list[str] = []
        self.replaced: dict = {}

    def source(self) -> str:
        function = self.function
        function.check(self.parameters)
        self._angles()
        for symbol, expression in function.steps:
            self._assign(symbol.name, expression)
            if not isinstance(expression, sp.Symbol):
                self.replaced.setdefault(sp.sympify(expression), symbol)
        self._results()
        return "\n".join([*self._head(), *self.lines]) + "\n"

    def _head(self) -> list[str]:
        number = self.printer.use(self.dialect.number)
        inputs = ", ".join(f"{s.name}: {number}" for s in self.function.inputs)
        lengths = ", ".join(f"{s.name}: float" for s in self.parameters)
        arguments = f"    {inputs},\n    {lengths},\n" if lengths else f"    {inputs},\n"
        head = f"def {self.function.name}{self.dialect.suffix}(\n{arguments}) -> {self._returns()}:"
        kind = "Columns in, columns out." if self.dialect is BATCH else operations(self.function) + "."
        doc = f"{self.function.doc.strip()} {kind[0].upper()}{kind[1:]}"
        return [head, *_docstring(doc)]

    def _returns(self) -> str:
        outputs = list(self.function.outputs.values())
        if all(len(entries(v)) == 1 and not isinstance(v, (sp.MatrixBase, tuple, list)) for v in outputs):
            number = self.dialect.number
            return number if len(outputs) == 1 else f"tuple[{', '.join([number] * len(outputs))}]"
        return "tuple"

    def _angles(self) -> None:
        """Name every sine and cosine: c1 s1 c23 s23 ... in order of the number of joints in the angle."""
        body = [e for _, e in self.function.steps] + self.function.flat_outputs()
        trig = set().union(*(sp.sympify(e).atoms(sp.sin, sp.cos) for e in body))
        given = set(self.function.inputs) | set(self.parameters)
        for argument in sorted({t.args[0] for t in trig}, key=lambda a: (len(a.free_symbols), label(a))):
            if not argument.free_symbols <= given:
                raise BadInput(
                    f"`{self.function.name}`: sin or cos of `{argument}`, which is computed in a step; "
                    f"make it an input, or write the sine and cosine as steps."
                )
            self._angle(argument, trig)

    def _angle(self, argument, trig) -> None:
        name = label(argument)
        sine, cosine = sp.sin(argument), sp.cos(argument)
        angle = argument
        if isinstance(argument, sp.Add):
            angle = sp.Symbol(f"q{name}" if name[0].isdigit() else f"angle{name}")
            self.lines.append(f"    {angle} = {self.printer.code(argument)}")
            self.replaced |= {argument: angle, -argument: -angle}
        code = self.printer.code(angle)
        names = [f"s{name}" if sine in trig else "_", f"c{name}" if cosine in trig else "_"]
        if self.dialect is BATCH or "_" not in names:
            pair = self.printer.use(self.dialect.pair.format(code))
            self.lines.append(f"    {', '.join(names)} = {pair}")
        else:
            function = self.printer.use("sin" if sine in trig else "cos")
            self.lines.append(f"    {names[function == 'cos']} = {function}({code})")
        self.replaced |= {sine: sp.Symbol(f"s{name}"), cosine: sp.Symbol(f"c{name}")}

    def _code(self, expression) -> str:
        return self.printer.code(sp.sympify(expression).xreplace(self.replaced))

    def _assign(self, name: str, expression) -> None:
        self.lines += folded(f"    {name} = ", self._code(expression))

    def _results(self) -> None:
        outputs = self.function.outputs
        if len(outputs) == 1:
            ((_, value),) = outputs.items()
            self._return_one(value)
            return
        for name, value in outputs.items():
            if isinstance(value, (sp.MatrixBase, tuple, list)):
                self.lines += self._group(f"{name} = ", value)
            elif not (isinstance(value, sp.Symbol) and value.name == name):
                self._assign(name, value)
        self.lines.append(f"    return {', '.join(outputs)}")

    def _return_one(self, value) -> None:
        if isinstance(value, (sp.MatrixBase, tuple, list)):
            self.lines += self._group("return ", value)
        else:
            self.lines += folded("    return ", self._code(value))

    def _group(self, prefix: str, value) -> list[str]:
        """A sequence on one line if it is flat and fits; otherwise a line for each row."""
        if not any(isinstance(item, (list, tuple)) for item in _as_rows(value)):
            line = f"    {prefix}({', '.join(self._code(item) for item in value)})"
            if len(line) <= WIDTH:
                return [line]
        return [f"    {prefix}(", *self._rows(value, 8), "    )"]

    def _rows(self, value, indent: int) -> list[str]:
        lines = []
        for row in _as_rows(value):
            if isinstance(row, (list, tuple)):
                cells = [self._code(cell) for cell in row]
                text = f"({', '.join(cells)}{',' if len(cells) == 1 else ''}),"
                lines += _row_lines(text, cells, indent)
            else:
                lines.append(" " * indent + self._code(row) + ",")
        return lines


def _as_rows(value) -> list:
    return value.tolist() if isinstance(value, sp.MatrixBase) else list(value)


def _row_lines(text: str, cells: list[str], indent: int) -> list[str]:
    pad = " " * indent
    if len(pad + text) <= WIDTH:
        return [pad + text]
    return [f"{pad}(", *(f"{pad}    {cell}," for cell in cells), f"{pad}),"]


def label(argument) -> str:
    """The short name of an angle: q2 + q3 -> "23", q2 + delta -> "2_delta", pitch -> "_pitch"."""
    joints, others = [], []
    for term in sp.Add.make_args(argument):
        sign, symbol = ("m", -term) if term.could_extract_minus_sign() else ("", term)
        if not symbol.is_Symbol:
            others.append(sign + re.sub(r"\W+", "", str(symbol).replace("/", "_")))
        elif re.fullmatch(r"q\d+", symbol.name):
            joints.append((int(symbol.name[1:]), sign))
        else:
            others.append(sign + symbol.name)
    separator = "_" if any(number > 9 for number, _ in joints) else ""
    digits = separator.join(f"{sign}{number}" for number, sign in sorted(joints))
    return digits + "".join(f"_{name}" for name in sorted(others))


def folded(prefix: str, code: str) -> list[str]:
    """`prefix + code`, broken before top-level `+` and `-` inside parentheses where it is too long."""
    if len(prefix + code) <= WIDTH:
        return [prefix + code]
    indent = " " * (len(prefix) - len(prefix.lstrip()))
    lines, current = [], ""
    for part in re.split(r"(?= [+-] )", code):
        if len(current + part) > WIDTH - len(indent) - 4 and _balanced(current):
            lines.append(current.strip())
            current = ""
        current += part
    lines.append(current.strip())
    return [f"{prefix}(", *(f"{indent}    {line}" for line in lines), f"{indent})"]


def _balanced(text: str) -> bool:
    return text.count("(") == text.count(")")


def _docstring(text: str) -> list[str]:
    words, lines, current = text.split(), [], '    """'
    for word in words:
        if len(current) + len(word) + 1 > WIDTH - 4:
            lines.append(current.rstrip())
            current = "    "
        current += word + " "
    return [*lines, current.rstrip() + '"""']
