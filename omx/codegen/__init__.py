"""From derived expressions to readable source: `write` a module, `python -m omx.codegen --check` them all.

A notebook derives formulas with SymPy and hands them over as `Function`s. `write` turns each into two functions
of one module: `name` takes floats and uses `math`; `name_batch` takes columns (arrays) and uses NumPy. Beside it
goes the same module in JavaScript, for pages without Python.
"""

from ..symbolic import wrap
from .chain import chain_functions, write_chain
from .function import Function
from .module import source
from .store import write

__all__ = ["Function", "chain_functions", "source", "wrap", "write", "write_chain"]
