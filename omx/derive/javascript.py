"""The same functions as JavaScript, so that a page without Python moves the arm by the same formulas."""

from collections.abc import Mapping, Sequence

from .emit import Emitter, one_line, operations
from .printer import ROOTS_AND_ARCS, Dialect, Printer

JAVASCRIPT = Dialect(
    suffix="",
    number="number",
    functions={name: f"Math.{name}" for name in ROOTS_AND_ARCS}
    | {"Abs": "Math.abs", "Max": "Math.max", "Min": "Math.min", "wrap": "wrap({0})"},
    imports={"wrap": "this module"},
    pi="Math.PI",
    let="const ",
    end=";",
    brackets="[]",
)

#: An angle brought into (-pi, pi], as `omx.arrays.wrap` does.
WRAP = "const wrap = (angle) => angle - 2*Math.PI*Math.ceil(angle/(2*Math.PI) - 0.5);\n"


class JavaScriptPrinter(Printer):
    """One expression as JavaScript, ordered and bracketed as in the Python that stands beside it."""

    def _power(self, base, exponent) -> str:
        return f"Math.pow({self._print(base)}, {self._print(exponent)})"  # -x**2 is an error in JavaScript


class JavaScriptEmitter(Emitter):
    """Writes one function as an exported JavaScript function; several results come as one array."""

    def __init__(self, function, parameters):
        super().__init__(function, parameters, JAVASCRIPT, JavaScriptPrinter)

    def head(self) -> list[str]:
        arguments = ", ".join(symbol.name for symbol in (*self.function.inputs, *self.parameters))
        doc = f"{one_line(self.function.doc)} {operations(self.function, self.parameters)}.".replace("*/", "* /")
        return [f"/** {doc} */", f"export function {self.function.name}({arguments}) {{"]

    def body(self) -> list[str]:
        return [*super().body(), "}"]


def javascript(functions, header: str, parameters, values: Mapping, branches: Sequence[str] = ()) -> str:
    """The text of a module: `header` as comments, `PARAMETERS` if there are `values`, `BRANCHES`, the functions."""
    emitters = [JavaScriptEmitter(function, parameters) for function in functions]
    bodies = [emitter.source() for emitter in emitters]
    comment = "\n".join(f"// {line}".rstrip() for line in header.splitlines()) + "\n"
    helper = [WRAP] if any("wrap" in emitter.printer.used for emitter in emitters) else []
    constants = [_parameters(values)] if values else []
    constants += [_branches(branches)] if branches else []
    return "\n".join([comment, *constants, *helper, *bodies])


def _branches(names: Sequence[str]) -> str:
    return "\n".join(["export const BRANCHES = [", *(f'    "{name}",' for name in names), "];"]) + "\n"


def _parameters(values: Mapping) -> str:
    printer = JavaScriptPrinter(JAVASCRIPT)
    lines = [f"    {symbol.name}: {printer.code(value)}," for symbol, value in values.items()]
    return "\n".join(["export const PARAMETERS = {", *lines, "};"]) + "\n"
