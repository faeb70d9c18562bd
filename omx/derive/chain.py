"""Any chain of DH rows as a generated module: frames and tool transform, no simplification needed."""

import os
from collections.abc import Mapping
from types import ModuleType

import sympy as sp

from ..dh import Chain, as_chain, exact_transform
from .function import Function
from .store import write
from .symbolic import dh_matrix, exact


def chain_functions(chain: Chain) -> list[Function]:
    """`frames` (T_0_1 .. T_0_n) and `transform` (T_0_n) of `chain`, each entry a named step from the one before."""
    chain = as_chain(chain)
    joints = [sp.Symbol(name, real=True) for name in chain.names]
    steps: list[tuple[sp.Symbol, sp.Expr]] = []
    frames: list[sp.Matrix] = []
    current = exact_transform(chain.base)
    for i, (row, joint) in enumerate(zip(chain.rows, joints, strict=True), start=1):
        link = dh_matrix(*exact(row).at(joint))
        current = _named(current * (link if i < len(chain) else link * exact_transform(chain.tool)), i, steps)
        frames.append(current)
    outputs = {f"T_0_{i}": frame for i, frame in enumerate(frames, start=1)}
    last, tool = list(outputs.items())[-1]
    if len(frames) == 1:
        outputs = {"frames": (tool,)}  # a single output would be returned without a tuple around it
    return [
        Function("transform", f"{last}, rows of the 4x4 matrix.", joints, {last: tool}, steps),
        Function("frames", f"T_0_1 .. {last}, each as rows of a 4x4 matrix.", joints, outputs, steps),
    ]


def write_chain(
    name: str,
    chain: Chain,
    *,
    doc: str = "",
    notebook: str | None = None,
    folder: str | os.PathLike | None = None,
    parameters: Mapping[sp.Symbol, object] | None = None,
) -> ModuleType:
    """Write `<name>.py` with `transform`, `frames` and `dh_rows` of any chain, and return it loaded.

    Entries of the rows may be numbers or SymPy expressions; `parameters` gives each symbol in them its value. The other
    arguments are those of `write`. What the chain has as `base` and `tool` is in the formulas, not in `dh_rows`.
    """
    chain = as_chain(chain)
    return write(
        name,
        chain_functions(chain),
        notebook=notebook,
        folder=folder,
        doc=doc or f"Forward kinematics of {chain.name}.",
        parameters=() if parameters is None else parameters,
        rows=[exact(row) for row in chain.rows],
    )


def _named(matrix: sp.Matrix, frame: int, steps: list) -> sp.Matrix:
    """`matrix` with each entry that needs arithmetic replaced by a symbol, whose step is appended to `steps`."""
    named = matrix.copy()
    for i, axis in enumerate("xyz"):
        for j, column in enumerate("noap"):
            entry = matrix[i, j]
            if sp.count_ops(entry.xreplace({t: sp.Dummy() for t in entry.atoms(sp.sin, sp.cos)})) > 1:
                named[i, j] = sp.Symbol(f"{column}{axis}{frame}", real=True)
                steps.append((named[i, j], entry))
    return named
