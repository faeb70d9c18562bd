"""From derived expressions to readable Python source: `write` a module, `python -m omx.codegen --check` them all.

A notebook derives formulas with SymPy and hands them over as `Function`s. `write` turns each into two functions
of one module: `name` takes floats and uses `math`; `name_batch` takes columns (arrays) and uses NumPy.
"""

from .chain import chain_functions, write_chain
from .emit import Function
from .module import source, write

__all__ = ["Function", "chain_functions", "source", "write", "write_chain"]
