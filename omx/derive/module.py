"""The text of a whole generated module: header, imports, parameters, DH table, functions."""

import re
import textwrap
from collections.abc import Iterable, Mapping, Sequence

import sympy as sp

from ..arrays import HUGE, shown
from ..dh import DHRow, as_table
from ..errors import BadInput
from .emit import WIDTH, Emitter, JavaScriptEmitter, folded, one_line, signature
from .function import Function, check_name
from .printer import BATCH, JAVASCRIPT, SCALAR, Printer
from .symbolic import as_expression

#: The first line of the note that every generated module carries; the tests find its notebook by it.
MARK = "Written by notebooks/"

#: The same line in a module that no chapter of the book writes.
SCRATCH = "Written by omx.derive. Do not edit: change the derivation and write it again."

#: An angle brought into (-pi, pi] in JavaScript, as `omx.arrays.wrap` does.
WRAP = "const wrap = (angle) => angle - 2*Math.PI*Math.ceil(angle/(2*Math.PI) - 0.5);\n"

Parameters = Mapping[sp.Symbol, object] | Sequence[sp.Symbol]


def source(
    name: str,
    functions: Iterable[Function],
    *,
    notebook: str | None = None,
    doc: str,
    parameters: Parameters = (),
    rows: Sequence[DHRow] = (),
    branches: Sequence[str] = (),
    batch: bool = True,
) -> str:
    """The Python text that `write` writes, from the same arguments."""
    functions, values = listed(functions), parameter_values(parameters)
    if batch is not True and batch is not False:
        raise BadInput(f"`batch` must be True or False; got {shown(batch)}.")
    symbols, rows = list(parameters), table_of(rows)
    _check_names(name, functions)
    _check_symbols(rows, symbols)
    dialects = (SCALAR, BATCH) if batch else (SCALAR,)
    emitters = [Emitter(function, symbols, dialect) for function in functions for dialect in dialects]
    bodies = [emitter.source() for emitter in emitters]
    printer = Printer(SCALAR, symbols)
    constants = [_parameters(values, printer)] if values else []
    constants += [_branches(branch_names(branches))] if branches else []
    table = [_rows(rows, symbols, printer)] if rows else []
    words = {word: SCALAR.imports[word] for word in printer.used} | ({"DHRow": "omx.dh"} if rows else {})
    for emitter in emitters:
        words |= {word: emitter.dialect.imports[word] for word in emitter.printer.used}
    header = '"""' + "\n".join(_header(notebook, doc, batch)) + '\n"""\n'
    return "\n".join([header, *_imports(words), *constants]) + "\n\n" + "\n\n".join([*table, *bodies])


def script(
    functions: Iterable[Function],
    *,
    notebook: str | None = None,
    doc: str,
    parameters: Parameters = (),
    branches: Sequence[str] = (),
) -> str:
    """The same functions as the text of a JavaScript module, so that a page without Python moves the arm by them."""
    header = "\n".join(f"// {line}".rstrip() for line in _header(notebook, doc, batch=False)) + "\n"
    emitters = [JavaScriptEmitter(function, list(parameters)) for function in functions]
    bodies = [emitter.source() for emitter in emitters]
    helper = [WRAP] if any("wrap" in emitter.printer.used for emitter in emitters) else []
    code = Printer(JAVASCRIPT).code
    values = [f"    {symbol.name}: {code(value)}," for symbol, value in parameter_values(parameters).items()]
    names = [f'    "{name}",' for name in branch_names(branches)]
    constants = ["\n".join(["export const PARAMETERS = {", *values, "};\n"])] if values else []
    constants += ["\n".join(["export const BRANCHES = [", *names, "];\n"])] if names else []
    return "\n".join([header, *constants, *helper, *bodies])


def parameter_values(parameters: Parameters) -> dict[sp.Symbol, sp.Expr]:
    """The value of each parameter, if values are given; `BadInput` unless every one is a real number."""
    if not isinstance(parameters, (Mapping, Sequence)) or isinstance(parameters, str):
        raise BadInput(f"`parameters` must be symbols, or map each symbol to its value; got {shown(parameters)}.")
    values = {}
    for symbol, value in parameters.items() if isinstance(parameters, Mapping) else ():
        if not isinstance(symbol, sp.Symbol):
            raise BadInput(f"`parameters` are SymPy symbols, each with its value; got {shown(symbol)}.")
        number = values[symbol] = sp.S.NaN if value is None or isinstance(value, str) else as_expression(value)
        if not isinstance(number, sp.Expr) or number.free_symbols or not number.is_real or not abs(number) < HUGE:
            raise BadInput(f"parameter `{symbol}` must have a real number as its value; got {shown(value)}.")
    return values


def branch_names(branches) -> list[str]:
    """The names of an inverse's branches; `BadInput` unless they are short texts."""
    good = isinstance(branches, (list, tuple)) and all(isinstance(name, str) for name in branches)
    if not good or not all(re.fullmatch(r"[\w ,-]+", name) for name in branches):
        raise BadInput(f"`branches` must be a list of plain names, one a branch; got {shown(branches)}.")
    return list(branches)


def listed(functions) -> list[Function]:
    """The functions as a list; `BadInput` for anything else."""
    if isinstance(functions, Function) or not isinstance(functions, Iterable):
        raise BadInput(f"`functions` must be a list of omx.derive.Function; got {shown(functions)}.")
    return list(functions)


def table_of(rows) -> tuple[DHRow, ...]:
    """The rows of a DH table, checked; none is a table, too."""
    return () if isinstance(rows, (tuple, list)) and not rows else as_table(rows)


def _check_names(name: str, functions: list[Function]) -> None:
    check_name(name, "the module")
    for function in functions:
        if not isinstance(function, Function):
            raise BadInput(f"`functions` must be a list of omx.derive.Function; it holds {shown(function)}.")
        check_name(function.name, "the function")
    names = [function.name + suffix for function in functions for suffix in (SCALAR.suffix, BATCH.suffix)]
    for twice in sorted({name for name in names if names.count(name) > 1}):
        raise BadInput(f"two functions would be called `{twice}`; give each its own name.")


def _check_symbols(rows: Sequence[DHRow], symbols: list[sp.Symbol]) -> None:
    used = set().union(*(as_expression(entry).free_symbols for row in rows for entry in row.at(0)))
    if unknown := sorted(map(str, used - set(symbols))):
        raise BadInput(
            f"the DH table uses {', '.join(unknown)}: give each a value in `parameters`. (SymPy symbols with other "
            "assumptions are other symbols.)"
        )


def _header(notebook: str | None, doc: str, batch: bool) -> list[str]:
    if not isinstance(doc, str):
        raise BadInput(f"`doc` must be a sentence that says what the module is; got {shown(doc)}.")
    if notebook is not None and not (isinstance(notebook, str) and re.fullmatch(r"[\w-]+", notebook)):
        raise BadInput(f"`notebook` must be a chapter's name, such as '03-forward-kinematics'; got {shown(notebook)}.")
    safe = one_line(doc).replace("\\", "\\\\").replace('"""', "'''")
    units = ["Lengths are in mm, angles in rad."]
    if batch:
        units[0] += " `..._batch` is the same formula for columns: arrays of one"
        units += ["shape, NumPy's or those of another library that keeps to the array API standard."]
    note = f"{MARK}{notebook}.ipynb. Do not edit: change the chapter and run it." if notebook else SCRATCH
    return [*textwrap.wrap(safe, WIDTH - 3), "", note, *units]


def _imports(words: Mapping[str, str]) -> list[str]:
    """One paragraph for each group of modules."""
    paragraphs = []
    for group in (("math",), ("omx.arrays", "omx.dh")):
        found = [(module, [word for word in sorted(words) if words[word] == module]) for module in group]
        lines = [f"from {module} import {', '.join(names)}" for module, names in found if names]
        if lines:
            paragraphs.append("\n".join(lines) + "\n")
    return paragraphs


def _parameters(values: Mapping[sp.Symbol, sp.Expr], printer: Printer) -> str:
    lines = ["#: The arm's lengths (mm) and angles (rad), in the order in which every function takes them."]
    lines.append("PARAMETERS = {")
    for symbol, value in values.items():
        comment = "" if value.is_Rational or value.is_Float else f"  # {float(value):.6f}"
        lines.append(f'    "{symbol.name}": {_number(printer, value)},{comment}')
    return "\n".join([*lines, "}"]) + "\n"


def _branches(names: list[str]) -> str:
    lines = ["#: The branches, in the order in which the functions return them.", "BRANCHES = ("]
    return "\n".join([*lines, *(f'    "{name}",' for name in names), ")"]) + "\n"


def _rows(rows: Sequence[DHRow], symbols: list[sp.Symbol], printer: Printer) -> str:
    lines = [
        *signature("dh_rows", [[f"{symbol.name}: float" for symbol in symbols]], "tuple[DHRow, ...]"),
        '    """The DH table, a row a joint: theta or d holds the offset that the joint variable is added to."""',
        "    return (",
    ]
    for row in rows:
        cells = [_number(printer, entry) for entry in (row.theta, row.d, row.a, row.alpha)]
        code = f"DHRow({', '.join(cells)}{', prismatic=True' if row.prismatic else ''})"
        lines += folded(" " * 8, code, ",")
    return "\n".join([*lines, "    )"]) + "\n"


def _number(printer: Printer, entry) -> str:
    entry = as_expression(entry)
    return repr(float(entry)) if entry.is_Rational or entry.is_Float else printer.code(entry)
