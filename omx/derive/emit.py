"""One `Function` as source text: sines and cosines first, then the named steps, then the results."""

import ast
import re
import textwrap
from collections.abc import Sequence

import sympy as sp

from .function import Function, label
from .printer import BATCH, JAVASCRIPT, SCALAR, Dialect, Printer

WIDTH = 110


class Emitter:
    """Writes one function in one dialect."""

    def __init__(self, function: Function, parameters: Sequence[sp.Symbol], dialect: Dialect):
        self.function, self.parameters, self.dialect = function, tuple(parameters), dialect
        self.printer = Printer(dialect, parameters)
        self.replaced: dict = {}

    def source(self) -> str:
        """The whole function, checked first."""
        self.function.check(self.parameters)
        head, body = self.head(), self.body()
        if any("xp." in line for line in body):
            inputs = ", ".join(symbol.name for symbol in self.function.inputs)
            head += [f"    xp = {self.printer.use(f'namespace({inputs})')}"]
        return "\n".join([*head, *body]) + "\n"

    def head(self) -> list[str]:
        function, number = self.function, self.printer.use(self.dialect.number)
        inputs = [f"{symbol.name}: {number}" for symbol in function.inputs]
        lengths = [f"{symbol.name}: float" for symbol in self.parameters]
        lines = signature(function.name + self.dialect.suffix, (inputs, lengths), self._returns())
        note = self._columns() if self.dialect is BATCH else operations(function, self.parameters)
        return [*lines, *docstring(f"{function.doc.strip()} {note}.")]

    def _columns(self) -> str:
        plain = any(not result.free_symbols - set(self.parameters) for result in self.function.results)
        return "Columns in, columns out" + ("; constants are plain numbers" if plain else "")

    def _returns(self) -> str:
        outputs, number = self.function.named[1].values(), self.dialect.number
        if any(isinstance(value, tuple) for value in outputs):
            return "tuple"
        if len(outputs) > 6:
            return f"tuple[{number}, ...]"
        return number if len(outputs) == 1 else f"tuple[{', '.join([number] * len(outputs))}]"

    def body(self) -> list[str]:
        """The statements, indented."""
        lines, known, waiting = [], {*self.function.inputs, *self.parameters}, list(self.function.angles)
        for symbol, expression in [(None, None), *self.function.named[0]]:
            if symbol is not None:
                lines += self._statement(f"{self.dialect.let}{symbol.name} = ", expression)
                known.add(symbol)
                if expression.free_symbols <= self.printer.constants:
                    self.printer.constants.add(symbol)
            for angle in [angle for angle in waiting if angle.free_symbols <= known]:
                lines += self._angle(angle)
                waiting.remove(angle)
        return lines + self._results()

    def _angle(self, angle) -> list[str]:
        """The sine and cosine of one angle, and first the angle itself if it is a sum."""
        lines, name, variable = [], label(angle), angle
        if angle.is_Add:
            variable = sp.Symbol(self.function.sum_name(angle))
            lines += self._statement(f"{self.dialect.let}{variable.name} = ", angle)
            self.replaced |= {angle: variable, -angle: -variable}
        code = self.printer.code(variable)
        used = self.function.sines_and_cosines
        names = {word: f"{word[0]}{name}" for word, f in (("sin", sp.sin), ("cos", sp.cos)) if f(angle) in used}
        self.replaced |= {sp.sin(angle): sp.Symbol(f"s{name}"), sp.cos(angle): sp.Symbol(f"c{name}")}
        if self.dialect is BATCH or (self.dialect.pair and len(names) == 2):
            pair = self.printer.use(self.dialect.pair.format(code))
            return [*lines, f"    {names.get('sin', '_')}, {names.get('cos', '_')} = {pair}"]
        functions = {word: self.printer.use(self.dialect.functions[word]) for word in names}
        let, end = self.dialect.let, self.dialect.end
        return [*lines, *(f"    {let}{variable} = {functions[word]}({code}){end}" for word, variable in names.items())]

    def _results(self) -> list[str]:
        outputs = self.function.named[1]
        if len(outputs) == 1:
            return self._statement("return ", *outputs.values())
        lines = []
        for name, value in outputs.items():
            if not (isinstance(value, sp.Symbol) and value.name == name):
                lines += self._statement(f"{self.dialect.let}{name} = ", value)
        opening, closing = tuple(self.dialect.brackets) if self.dialect.let else ("", "")
        line = f"    return {opening}{', '.join(outputs)}{closing}{self.dialect.end}"
        if len(line) <= WIDTH:
            return [*lines, line]
        opening, closing = tuple(self.dialect.brackets)
        return [*lines, f"    return {opening}", *packed(list(outputs), " " * 8), f"    {closing}{self.dialect.end}"]

    def _statement(self, prefix: str, value, indent: str = "    ", end: str | None = None) -> list[str]:
        """`prefix value`: a number or a row of numbers on one line if it fits, a table with a line for each row."""
        end = self.dialect.end if end is None else end
        if not isinstance(value, tuple):
            return folded(indent + prefix, self._code(value), end)
        opening, closing = tuple(self.dialect.brackets)
        if not any(isinstance(item, tuple) for item in value):
            comma = "," if len(value) == 1 and opening == "(" else ""
            line = f"{indent}{prefix}{opening}{', '.join(map(self._code, value))}{comma}{closing}{end}"
            if len(line) <= WIDTH:
                return [line]
        inner = [line for item in value for line in self._statement("", item, indent + "    ", ",")]
        return [f"{indent}{prefix}{opening}", *inner, f"{indent}{closing}{end}"]

    def _code(self, expression) -> str:
        return self.printer.code(expression.xreplace(self.replaced))


class JavaScriptEmitter(Emitter):
    """Writes one function as an exported JavaScript function; several results come as one array."""

    def __init__(self, function: Function, parameters: Sequence[sp.Symbol]):
        super().__init__(function, parameters, JAVASCRIPT)

    def head(self) -> list[str]:
        arguments = ", ".join(symbol.name for symbol in (*self.function.inputs, *self.parameters))
        doc = f"{one_line(self.function.doc)} {operations(self.function, self.parameters)}.".replace("*/", "* /")
        return [f"/** {doc} */", f"export function {self.function.name}({arguments}) {{"]

    def body(self) -> list[str]:
        return [*super().body(), "}"]


def operations(function: Function, parameters: Sequence[sp.Symbol]) -> str:
    """How much arithmetic one call costs, counted in the code that is written."""
    nodes = list(ast.walk(ast.parse(textwrap.dedent("\n".join(Emitter(function, parameters, SCALAR).body())))))
    calls = [node.func.id for node in nodes if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)]
    trig = sum(name in ("sin", "cos") for name in calls)
    rest = sum(isinstance(node, (ast.BinOp, ast.UnaryOp, ast.Compare)) for node in nodes) + len(calls) - trig
    return f"{rest} operations and {trig} sines and cosines" if trig else f"{rest} operations"


def signature(name: str, groups: Sequence[Sequence[str]], returns: str) -> list[str]:
    """The `def` line; if it is too long, each group of arguments on lines of its own."""
    line = f"def {name}({', '.join(argument for group in groups for argument in group)}) -> {returns}:"
    if len(line) <= WIDTH:
        return [line]
    return [f"def {name}(", *(line for group in groups for line in packed(group, "    ")), f") -> {returns}:"]


def folded(prefix: str, code: str, end: str = "") -> list[str]:
    """`prefix + code`, put in parentheses and broken before `+` and `-` where it is too long."""
    if len(prefix + code + end) <= WIDTH:
        return [prefix + code + end]
    indent = " " * (len(prefix) - len(prefix.lstrip()))
    glued = re.sub(r"([+-]) ", "\\1\0", code)
    pieces = textwrap.wrap(glued, WIDTH - len(indent) - 4, break_long_words=False, break_on_hyphens=False)
    return [f"{prefix}(", *(f"{indent}    {piece}".replace("\0", " ") for piece in pieces), f"{indent}){end}"]


def packed(words: Sequence[str], indent: str) -> list[str]:
    """`words` with a comma after each, as many on a line as fit."""
    glued = " ".join(f"{word},".replace(" ", "\0") for word in words)
    lines = textwrap.wrap(glued, WIDTH - len(indent), break_long_words=False, break_on_hyphens=False)
    return [indent + line.replace("\0", " ") for line in lines]


def one_line(text: str) -> str:
    """`text` without line breaks, and without what no source file can hold."""
    return "".join(letter if letter.isprintable() else " " for letter in " ".join(text.split()))


def docstring(text: str, indent: str = "    ") -> list[str]:
    """A docstring, whatever characters the text holds."""
    safe = one_line(text).replace("\\", "\\\\").replace('"""', "'''")
    return textwrap.wrap(f'"""{safe}"""', WIDTH - 4, initial_indent=indent, subsequent_indent=indent)
