"""Big batches in machine code, where numba is installed: `pose`, `ik_batch` and any generated function.

What a function asks of NumPy is recorded and becomes a loop over rows. Small batches, numbers beyond `RANGE` and other
kinds than float64 go to NumPy, as all do without numba. Results differ by rounding (1e-12 mm); the first call compiles.
"""

import inspect
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache, partial, wraps
from importlib.util import find_spec
from os import cpu_count
from types import FunctionType, ModuleType, SimpleNamespace

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin

from .. import kinematics
from ..arrays import as_count, of_rows
from ..errors import BadInput
from ..generated import polynomials

#: The largest angle (rad) or length (mm) that is compiled for: beyond, digits are lost.
RANGE = 1e4

#: So few rows NumPy has done before the function is recorded.
FEW = 10_000


def available() -> bool:
    """Is numba installed?"""
    return find_spec("numba") is not None


def compile_batch(module: ModuleType) -> SimpleNamespace:
    """Every function of a generated module for many rows: `compile_batch(fk).pose(q, *geometry.values)`.

    Each takes rows (..., k) of its k inputs, its parameters, and `threads` as in `compile_rows`. It returns an array
    (..., n), or (..., n, m) for a matrix; a tuple of arrays where results have several shapes. Raises `BadInput`.
    """
    batches = {name.removesuffix("_batch"): f for name, f in vars(module).items() if name.endswith("_batch")}
    return SimpleNamespace(**{name: compile_rows(of_rows(batch)) for name, batch in batches.items()})


def compile_rows(function: Callable) -> Callable:
    """`function` of rows (..., k), as any library's, in machine code: the same arguments and errors, and `threads`.

    `threads`: how many share the work; as many as the machine has, if left out.
    """

    name, *_ = inspect.signature(function, follow_wrapped=False).parameters

    @wraps(function)
    def call(*arguments, threads: int | None = None, **named):
        rows, *others = arguments or (named.pop(name, None),)

        def given(rows):
            return function(rows, *others, **named)

        workers = (cpu_count() or 1) if threads is None else as_count(threads, "threads")
        plain = type(rows) is np.ndarray and rows.dtype == float and rows.ndim > 1
        if not (available() and plain and rows.size > FEW * rows.shape[-1]):
            return given(rows)
        flat = np.ascontiguousarray(rows).reshape(-1, rows.shape[-1])
        sample = given(flat[:1])  # says what is wrong, and what comes out
        parts = sample if isinstance(sample, tuple) else (sample,)
        lines, constants, results = recorded(given, flat.shape[1])
        outs = tuple(np.empty((part[0].size, len(flat)), part.dtype) for part in parts)
        loop = partial(_loop(flat.shape[1], lines, results), flat.reshape(-1), outs, constants)
        borders = np.linspace(0, len(flat), workers + 1).astype(int).tolist()
        with ThreadPoolExecutor(workers) as pool:
            each = map if workers == 1 else pool.map
            if not all(list(each(loop, borders, borders[1:]))):
                return given(rows)
        found = [out.T.reshape(*rows.shape[:-1], *part.shape[1:]) for out, part in zip(outs, parts, strict=True)]
        return found[0] if parts[0] is sample else type(sample)(*found) if hasattr(sample, "_fields") else tuple(found)

    return call


pose, ik_batch = compile_rows(kinematics.pose), compile_rows(kinematics.ik_batch)


@cache
def _loop(inputs: int, lines: tuple[str, ...], results: tuple[tuple[str, ...], ...]) -> Callable:
    """A compiled loop over rows `start` .. `stop`; it returns whether all numbers were in `RANGE`."""
    import llvmlite.binding
    from numba import njit

    llvmlite.binding.set_option("", "-vectorize-memory-check-threshold=5000")  # for so many columns of results
    fast = partial(njit, nogil=True, error_model="numpy", fastmath={"contract", "nsz", "arcp"})
    known = vars(polynomials) | {"floor": np.floor}
    words = {"sin": known["sine"], "cos": known["cosine"], "arctan2": known["arc_tangent"]}
    words |= {"maximum": lambda a, b: a if a > b else b, "where": lambda condition, a, b: a if condition else b}
    names = vars(np) | {word: fast(forceinline=True)(FunctionType(f.__code__, known)) for word, f in words.items()}
    places = [(k, j, name) for k, part in enumerate(results) for j, name in enumerate(part)]
    text = ["def loop(x, outs, p, start, stop):", *(f"o{k}_{j} = outs[{k}][{j}, start:stop]" for k, j, _ in places)]
    text += [f"x, wrong = x[{inputs} * start :], 0", "for i in range(stop - start):"]
    text += [f"    x{j} = x[{inputs} * i + {j}]; wrong += not abs(x{j}) <= {RANGE}" for j in range(inputs)]
    text += [f"    {line}" for line in (*lines, *(f"o{k}_{j}[i] = {name}" for k, j, name in places))]
    exec("\n    ".join([*text, "return wrong == 0"]), names)
    return fast()(names["loop"])


def recorded(function: Callable, inputs: int) -> tuple[tuple[str, ...], tuple[float, ...], tuple[tuple[str, ...], ...]]:
    """What `function` of rows (..., inputs) does with each row: statements, constants, and its results' names.

    A statement is one call, `v7 = add(v3, p[1])`, by NumPy's names. `x0` .. are the inputs, `p[0]` .. the constants.
    """
    lines, constants = list[str](), dict[float, str]()
    found = function(Column("x", lines, constants, (inputs,)))
    parts = found if isinstance(found, tuple) else (found,)
    return tuple(lines), tuple(constants), tuple(tuple(c.name for c in np.array(part, object).flat) for part in parts)


class Column(NDArrayOperatorsMixin):
    """An array that is not there: a step of a function, by the name of what it gives for one row."""

    def __init__(self, name: str, lines: list[str], constants: dict[float, str], shape: tuple[int, ...] = ()):
        self.name, self.lines, self.constants, self.shape, self.ndim = name, lines, constants, shape, len(shape)

    def write(self, step: str, *given) -> "Column":
        """One more statement, and the column that it makes."""
        for number in given:
            if not isinstance(number, (Column, int)):
                self.constants.setdefault(float(number), f"p[{len(self.constants)}]")
        words = (g.name if isinstance(g, Column) else self.constants.get(g, g) for g in given)
        self.lines.append(f"v{len(self.lines)} = {step.format(*words)}")
        return Column(f"v{len(self.lines) - 1}", self.lines, self.constants)

    def __array_namespace__(self):
        return np

    def __bool__(self):
        raise BadInput("a function that asks whether a number is so or so cannot be compiled; let it use `where`.")

    def __getitem__(self, index):
        return Column(f"{self.name}{index[-1]}", self.lines, self.constants)

    def __array_ufunc__(self, ufunc, method, *given):
        return self.write(f"{ufunc.__name__}({', '.join(['{}'] * len(given))})", *given)

    def __array_function__(self, function, types, given, named):
        if function is np.stack:
            return np.stack([np.array(column, object) for column in given[0]])
        return self.write("where({}, {}, {})", *given) if function is np.where else self.write("{1}", *given)
