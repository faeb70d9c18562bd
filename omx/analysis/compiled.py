"""Big batches in machine code, where numba is installed: `pose`, `ik_batch` and any generated function.

What a function asks of NumPy is recorded and becomes a loop over rows. Small batches, numbers beyond `RANGE` and other
kinds than float64 go to NumPy, as all do without numba. Results differ by rounding (1e-12 mm); the first call compiles.
"""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache, partial
from importlib.util import find_spec
from os import cpu_count
from types import FunctionType, ModuleType, SimpleNamespace

import numpy as np

from .. import kinematics
from ..arm import LIMITS
from ..arrays import as_count, of_rows
from ..generated import polynomials
from ..geometry import COURSE, Geometry
from .recorded import recorded

#: The largest angle (rad) or length (mm) that is compiled for: beyond, digits are lost.
RANGE = 1e4

#: So few rows NumPy has done before the function is recorded.
FEW = 10_000


def available() -> bool:
    """Is numba installed?"""
    return find_spec("numba") is not None


def compile_batch(module: ModuleType) -> SimpleNamespace:
    """Every function of a generated module for many rows: `compile_batch(fk).pose(q, *geometry.values)`.

    Each takes rows (..., k) of its k inputs, its parameters, and `threads`: how many share the work, as many as the
    machine has if left out. It returns an array (..., n), or (..., n, m) for a matrix; a tuple of arrays where results
    have several shapes. Raises `BadInput`.
    """
    found = vars(module)
    batches = {name: found[f"{name}_batch"] for name in found if f"{name}_batch" in found}
    return SimpleNamespace(**{name: _compiled(of_rows(batch)) for name, batch in batches.items()})


def pose(q, geometry: Geometry = COURSE, *, threads: int | None = None) -> np.ndarray:
    """x, y, z (mm) and pitch (rad), (..., 4), for joint angles `q` (..., 4), rad: as `omx.pose`. Raises `BadInput`.

    `threads`: how many share the work; as many as the machine has, if left out.
    """
    return _run(lambda q: kinematics.pose(q, geometry), q, threads)


def ik_batch(poses, geometry: Geometry = COURSE, limits=LIMITS, *, threads: int | None = None) -> kinematics.Branches:
    """All four branches of many poses (N, 4), with verdicts: as `omx.ik_batch`. `threads` and errors as in `pose`."""
    return kinematics.Branches(*_run(lambda poses: kinematics.ik_batch(poses, geometry, limits), poses, threads))


def _compiled(function: Callable) -> Callable:
    def call(rows, *parameters, threads: int | None = None):
        return _run(lambda rows: function(rows, *parameters), rows, threads)

    call.__name__, call.__doc__ = function.__name__, function.__doc__
    return call


def _run(function: Callable, rows, threads: int | None):
    """What `function` of rows (..., k), as any library's, gives: an array, or a tuple of them."""
    workers = (cpu_count() or 1) if threads is None else as_count(threads, "threads", most=1024)
    plain = type(rows) is np.ndarray and rows.dtype == float and rows.ndim > 1
    if not (available() and plain and rows.size > FEW * rows.shape[-1]):
        return function(rows)
    sample = function(rows[(slice(1),) * (rows.ndim - 1)])  # says what is wrong, and what comes out
    parts = sample if isinstance(sample, tuple) else (sample,)
    flat = np.ascontiguousarray(rows).reshape(-1, rows.shape[-1])
    lines, constants, results = recorded(function, flat.shape[1])
    outs = tuple(np.empty((len(r), len(flat)), part.dtype) for r, part in zip(results, parts, strict=True))
    loop = partial(_loop(flat.shape[1], lines, results), flat.reshape(-1), outs, constants)
    borders = np.linspace(0, len(flat), workers + 1).astype(int).tolist()
    with ThreadPoolExecutor(workers) as pool:
        each = map if workers == 1 else pool.map
        if not all(list(each(loop, borders, borders[1:]))):
            return function(rows)
    pairs = zip(outs, parts, strict=True)
    found = tuple(out.T.reshape(*rows.shape[:-1], *part.shape[rows.ndim - 1 :]) for out, part in pairs)
    return found if isinstance(sample, tuple) else found[0]


@cache
def _loop(inputs: int, lines: tuple[str, ...], results: tuple[tuple[str, ...], ...]) -> Callable:
    """A compiled loop over rows `start` .. `stop`; it returns whether all numbers were in `RANGE`."""
    import llvmlite.binding
    from numba import njit

    llvmlite.binding.set_option("", "-vectorize-memory-check-threshold=5000")  # for so many columns of results
    fast = partial(njit, nogil=True, error_model="numpy", fastmath={"contract", "arcp"})
    known = vars(polynomials) | {"floor": np.floor}
    words = {"sin": known["sine"], "cos": known["cosine"], "arctan2": known["arc_tangent"]}
    words |= {
        "maximum": lambda a, b: a if a > b or a != a else b,
        "where": lambda condition, a, b: a if condition else b,
    }
    names = vars(np) | {word: fast(forceinline=True)(FunctionType(f.__code__, known)) for word, f in words.items()}
    places = [(k, j, name) for k, part in enumerate(results) for j, name in enumerate(part)]
    text = ["def loop(x, outs, p, start, stop):", *(f"o{k}_{j} = outs[{k}][{j}, start:stop]" for k, j, _ in places)]
    text += [f"x, wrong = x[{inputs} * start :], 0", "for i in range(stop - start):"]
    text += [f"    x{j} = x[{inputs} * i + {j}]; wrong += not abs(x{j}) <= {RANGE}" for j in range(inputs)]
    text += [f"    {line}" for line in (*lines, *(f"o{k}_{j}[i] = {name}" for k, j, name in places))]
    exec("\n    ".join([*text, "return wrong == 0"]), names)
    return fast()(names["loop"])
