"""From a derivation to code: SymPy helpers for the chapters' own steps, and the generator that writes their result.

A chapter hands its expressions over as `Function`s; `write` puts them, readable, into `omx/generated` as Python and
JavaScript. Only notebooks, tests and this package need SymPy.
"""

from .chain import chain_functions, write_chain
from .function import Function
from .inverse import Pattern, pattern, patterns, write_inverse
from .module import source
from .sampling import evaluated, real_points
from .store import write
from .symbolic import dh_matrix, exact, gather, numbers, prove_equal, residual, short, show, wrap

__all__ = [
    "Function", "Pattern", "chain_functions", "dh_matrix", "evaluated", "exact", "gather", "numbers", "pattern",
    "patterns", "prove_equal", "real_points", "residual", "short", "show", "source", "wrap", "write", "write_chain",
    "write_inverse",
]  # fmt: skip
