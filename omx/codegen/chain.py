"""Any chain of DH rows as a generated module: frames and tool transform, no simplification needed."""

from collections.abc import Mapping, Sequence
from types import ModuleType

import sympy as sp

from ..dh import Chain, DHRow
from ..errors import BadInput
from ..symbolic import dh_matrix
from .emit import Function
from .module import write


def chain_functions(chain: Chain) -> list[Function]:
    """`frames` (T_0_1 .. T_0_n) and `transform` (T_0_n) of `chain`, each entry a named step from the one before."""
    joints = [sp.Symbol(name, real=True) for name in chain.names]
    steps, frames = [], []
    current = sp.eye(4)
    for i, (row, joint) in enumerate(zip(chain.rows, joints, strict=True), start=1):
        current = _named(current * dh_matrix(*exact(row).at(joint)), i, steps)
        frames.append(current)
    outputs = {f"T_0_{i}": frame for i, frame in enumerate(frames, start=1)}
    last = f"T_0_{len(joints)}"
    return [
        Function("transform", f"T_0_{len(joints)}, rows of the 4x4 matrix.", joints, {last: frames[-1]}, tuple(steps)),
        Function("frames", f"T_0_1 .. {last}, each as rows of a 4x4 matrix.", joints, outputs, tuple(steps)),
    ]


def write_chain(
    name: str,
    chain: Chain,
    *,
    notebook: str,
    doc: str = "",
    parameters: Mapping[sp.Symbol, object] | None = None,
) -> ModuleType:
    """Write `<name>.py` with `transform`, `frames` and `dh_rows` of any chain, and return it loaded.

    Entries of the rows may be numbers or SymPy expressions; `parameters` gives each symbol in them its value.
    """
    parameters = dict(parameters or {})
    rows = [exact(row) for row in chain.rows]
    missing = set().union(*(_symbols(row) for row in rows)) - set(parameters)
    if missing:
        names = ", ".join(sorted(s.name for s in missing))
        raise BadInput(f"the rows of {chain.name} use {names}: give each a value in `parameters`.")
    return write(
        name,
        chain_functions(chain),
        notebook=notebook,
        doc=doc or f"Forward kinematics of {chain.name}.",
        parameters=parameters,
        rows=rows,
    )


def exact(row: DHRow) -> DHRow:
    """The row for SymPy: angles that are multiples of 15 deg exact, so that their cosines are 0, 1/2, ..."""
    return DHRow(_angle(row.theta), _length(row.d), _length(row.a), _angle(row.alpha), row.prismatic)


def _angle(value):
    value = sp.sympify(value)
    if value.free_symbols or not value.is_Float:
        return value
    steps = round(float(value / (sp.pi / 12)))
    return steps * sp.pi / 12 if abs(float(value - steps * sp.pi / 12)) < 1e-12 else value


def _length(value):
    value = sp.sympify(value)
    return sp.Integer(int(value)) if value.is_Float and value == int(value) else value


def _symbols(row: DHRow) -> set:
    return set().union(*(sp.sympify(e).free_symbols for e in (row.theta, row.d, row.a, row.alpha)))


def _named(matrix: sp.Matrix, frame: int, steps: list) -> sp.Matrix:
    """`matrix` with each entry that needs arithmetic replaced by a symbol, whose step is appended to `steps`."""
    letters: Sequence[Sequence[str]] = (("nx", "ox", "ax", "px"), ("ny", "oy", "ay", "py"), ("nz", "oz", "az", "pz"))
    named = matrix.copy()
    for i, row in enumerate(letters):
        for j, letter in enumerate(row):
            entry = matrix[i, j]
            if sp.count_ops(entry.xreplace({t: sp.Dummy() for t in entry.atoms(sp.sin, sp.cos)})) > 1:
                symbol = sp.Symbol(f"{letter}{frame}", real=True)
                steps.append((symbol, entry))
                named[i, j] = symbol
    return named
