"""A whole generated module: header, parameters, DH table, functions; written only when it changed and works."""

import importlib
import importlib.util
import os
import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from types import ModuleType

import sympy as sp

from ..dh import DHRow
from ..errors import BadInput
from .emit import Emitter, Function, folded
from .printer import BATCH, SCALAR, Printer

GENERATED = Path(__file__).resolve().parent.parent / "generated"

#: The first line of the note that every generated module carries; the tests find its notebook by it.
MARK = "Written by notebooks/"


def folder() -> Path:
    """Where modules are written: `omx/generated`, or the folder that OMX_GENERATED names."""
    return Path(os.environ.get("OMX_GENERATED") or GENERATED)


def write(
    name: str,
    functions: Iterable[Function],
    *,
    notebook: str,
    doc: str,
    parameters: Mapping[sp.Symbol, object] | Sequence[sp.Symbol] = (),
    rows: Sequence[DHRow] = (),
    batch: bool = True,
) -> ModuleType:
    """Write `<name>.py` and return it as a freshly loaded module.

    `parameters`: the symbols that every function takes after its inputs. A mapping gives their values too,
    and the module then carries them as `PARAMETERS`. `rows`: a DH table to carry along as `dh_rows(...)`.
    `notebook`: the name of the chapter that writes it, without folder and ending. `batch=False` leaves the
    NumPy forms out. The text depends on nothing but these arguments.
    """
    text = source(name, functions, notebook=notebook, doc=doc, parameters=parameters, rows=rows, batch=batch)
    path = folder() / f"{name}.py"
    path.parent.mkdir(parents=True, exist_ok=True)
    if not path.exists() or path.read_text(encoding="utf-8") != text:
        compile(text, str(path), "exec")
        fresh = path.with_suffix(".py.new")
        fresh.write_text(text, encoding="utf-8", newline="\n")
        os.replace(fresh, path)
    return _load(name, path)


def source(name, functions, *, notebook, doc, parameters=(), rows=(), batch=True) -> str:
    """The text of the module that `write` would write."""
    functions, symbols = list(functions), list(parameters)
    if not name.isidentifier():
        raise BadInput(f"`name` must be a Python module name; got {name!r}.")
    _no_clashes(functions, symbols)
    emitters = [
        Emitter(f, symbols, dialect) for f in functions for dialect in ((SCALAR, BATCH) if batch else (SCALAR,))
    ]
    bodies = [emitter.source() for emitter in emitters]
    constants = _parameters(parameters) if isinstance(parameters, Mapping) else ("", Printer(SCALAR))
    table = _rows(rows, symbols) if rows else ("", Printer(SCALAR))
    words = {word: module for e in emitters for word, module in e.dialect.imports.items() if word in e.printer.used}
    for _, printer in (constants, table):
        words |= {word: SCALAR.imports[word] for word in printer.used}
    if rows:
        words["DHRow"] = "omx.dh"
    parts = [_header(notebook, doc, batch), _imports(words)]
    if constants[0]:
        parts.append(constants[0])
    sections = [p for p in (table[0], *bodies) if p]
    return "\n".join(part for part in parts if part) + "\n\n" + "\n\n".join(sections)


def _no_clashes(functions: list[Function], symbols: list) -> None:
    names = [f.name for f in functions]
    for name in names:
        if names.count(name) > 1:
            raise BadInput(f"two functions are called `{name}`; give each its own name.")
    for function in functions:
        taken = {s.name for s in (*function.inputs, *symbols)}
        for symbol, _ in function.steps:
            if symbol.name in taken:
                raise BadInput(f"`{function.name}`: the step `{symbol}` has the name of an input, parameter or step.")
            taken.add(symbol.name)


def _header(notebook: str, doc: str, batch: bool) -> str:
    lines = [f'"""{doc.strip()}', "", f"{MARK}{notebook}.ipynb. Do not edit: change the chapter and run it."]
    lines.append("Lengths are in mm, angles in rad.")
    if batch:
        lines[-1] += " `..._batch` is the same formula for columns (NumPy arrays of one shape)."
    return "\n".join([*lines, '"""', ""])


def _imports(words: Mapping[str, str]) -> str:
    by_module: dict[str, list[str]] = {}
    for word, module in words.items():
        by_module.setdefault(module, []).append(word)
    groups = []
    for group in (("math",), ("numpy",), ("omx.arrays", "omx.dh")):
        lines = [_import(module, by_module[module]) for module in group if module in by_module]
        if lines:
            groups.append("\n".join(lines))
    return "\n\n".join(groups) + "\n" if groups else ""


def _import(module: str, words: list[str]) -> str:
    return "import numpy as np" if words == ["np"] else f"from {module} import {', '.join(sorted(words))}"


def _parameters(values: Mapping) -> tuple[str, Printer]:
    printer = Printer(SCALAR)
    lines = ["#: The arm's lengths (mm) and angles (rad), in the order in which every function takes them.", "PARAMETERS = {"]
    for symbol, value in values.items():
        value = sp.sympify(value)
        if value.free_symbols or not value.is_real:
            raise BadInput(f"parameter `{symbol}` must have a real number as its value; got {value}.")
        code = repr(float(value)) if value.is_Rational else printer.code(value)
        note = "" if value.is_Rational else f"  # {float(value):.6f}"
        lines.append(f'    "{symbol.name}": {code},{note}')
    return "\n".join([*lines, "}"]) + "\n", printer


def _rows(rows: Sequence[DHRow], symbols: list) -> tuple[str, Printer]:
    printer = Printer(SCALAR, symbols)
    arguments = ", ".join(f"{s.name}: float" for s in symbols)
    lines = [
        f"def dh_rows({arguments}) -> tuple[DHRow, ...]:",
        '    """The DH table, a row a joint: theta or d holds the offset that the joint variable is added to."""',
        "    return (",
    ]
    for row in rows:
        cells = [_number(printer, e) for e in (row.theta, row.d, row.a, row.alpha)]
        kind = ", prismatic=True" if row.prismatic else ""
        lines += [f"        {line}" for line in folded("", f"DHRow({', '.join(cells)}{kind}),")]
    return "\n".join([*lines, "    )"]) + "\n", printer


def _number(printer: Printer, entry) -> str:
    entry = sp.sympify(entry)
    return repr(float(entry)) if entry.is_Rational else printer.code(entry)


def _load(name: str, path: Path) -> ModuleType:
    """The module as it is on disk now; inside the package it also replaces the copy loaded earlier."""
    if path.parent == GENERATED:
        importlib.invalidate_caches()
        qualified = f"omx.generated.{name}"
        if qualified in sys.modules:
            return importlib.reload(sys.modules[qualified])
        return importlib.import_module(qualified)
    spec = importlib.util.spec_from_file_location(name, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
