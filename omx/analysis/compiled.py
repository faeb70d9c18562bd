"""Big batches in machine code, where numba is installed: any generated function, compiled, a row at a time.

`compile_batch(module)` serves every module that `omx.derive` writes; `pose` and `ik_batch` take and return what their
namesakes in `omx` do. Without numba, or for numbers beyond `RANGE`, NumPy does the work. Sine, cosine and arc tangent
are the polynomials that a chapter wrote, which the processor evaluates for several rows at once; results differ from
NumPy's by rounding only (1e-12 mm). The first call compiles, which takes some seconds.
"""

import inspect
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from importlib.util import find_spec
from math import nan, pi, remainder, tan, tau
from os import cpu_count
from types import FunctionType, ModuleType, SimpleNamespace

import numpy as np

from .. import kinematics
from ..arm import LIMITS
from ..arrays import as_rows
from ..dh import as_limits
from ..errors import BadInput
from ..generated import fk as _fk
from ..generated import ik as _ik
from ..generated import polynomials as _polynomials
from ..geometry import COURSE, Geometry, as_geometry

#: The largest angle (rad) and length (mm) that the compiled formulas take: beyond, digits or squares are lost.
RANGE = (64.0, 1e9)

#: Inputs of generated functions that are lengths; all others are angles.
LENGTHS = ("x", "y", "z", "d")

#: Fewer rows than this are not worth a second thread.
THREADED = 100_000

#: Rows in one round of a compiled loop: few enough that the columns in work stay in the processor's nearest cache.
ROUND = 256

#: Rows whose results are copied out together: columns are written in turn, and memory likes long runs.
RUN = 8 * ROUND

#: From one column of the work space to the next. A constant: so the compiler sees that columns do not overlap.
#: An odd number of rounds: columns that lie a power of two apart would share few lines of the cache.
PITCH = RUN + ROUND

#: Results of more numbers than this are kept as columns: rows would be written in too many strides.
WIDEST_ROW = 8

#: Results of more bytes than this are written past the processor's caches, which do not hold them anyway.
CACHED = 32 * 2**20


def available() -> bool:
    """Is numba installed?"""
    return find_spec("numba") is not None


def compile_batch(module: ModuleType) -> SimpleNamespace:
    """Every function of a generated module for many rows: `compile_batch(fk).pose(q, *geometry.values)`.

    Each takes rows (..., k) of its k inputs, then its parameters, `threads` and `dtype` as in `pose`. It returns an
    array (..., n), or (..., n, m) for a matrix; a tuple of arrays where results have several shapes. Raises `BadInput`.
    """
    functions = {name: value for name, value in vars(module).items() if f"{name}_batch" in vars(module)}
    return SimpleNamespace(**{name: _many(f, vars(module)[f"{name}_batch"]) for name, f in functions.items()})


def pose(q, geometry: Geometry = COURSE, *, threads: int | None = None, dtype=np.float64) -> np.ndarray:
    """x, y, z (mm) and pitch (rad), (..., 4), for joint angles `q` (..., 4), rad: as `omx.pose`.

    `threads`: how many; as many as the machine has, for big batches, if left out. `dtype`: of the result. With
    float32 in `q` and here, half as much memory is moved, and the position errs by up to 1e-4 mm, 2000 times less
    than the arm repeats; the arithmetic is in float64 all the same. Raises `BadInput`.
    """
    q = _rows(q, "q", 4, kinematics.JOINT_ANGLES)
    as_geometry(geometry)
    rows = q.reshape(-1, 4)
    done = _run(_fk.pose, rows, geometry.values, threads, dtype)
    out = done[0] if done else np.asarray(kinematics.pose(rows, geometry), dtype)
    return out.reshape(q.shape)


def ik_batch(poses, geometry: Geometry = COURSE, limits=LIMITS, *, threads: int | None = None, dtype=np.float64):
    """All four branches of many poses (N, 4): q (N, 4, 4), reachable (N, 4), legal (N, 4), as `omx.ik_batch`.

    `threads`, `dtype` and errors as in `pose`; in float32 each angle is off by up to 2e-7 rad.
    """
    poses = _rows(poses, "poses", 4, kinematics.TASK_POSE)
    if poses.ndim != 2:
        raise BadInput(f"`poses` must have shape (N, 4); got {poses.shape}. For one pose use `omx.ik`.")
    limits = as_limits(limits, 4)
    kinematics.ik((0.0, 0.0, 0.0, 0.0), geometry)  # of any pose it says if these lengths have no inverse
    ends = tuple(end for low, high in limits for end in (low - kinematics.LIMIT_SLACK, high + kinematics.LIMIT_SLACK))
    done = _run(_judged, poses, (*ends, *geometry.values), threads, dtype)
    if done:
        q, marks = done
        return q.reshape(-1, 4, 4), marks[:, :4], marks[:, 4:]
    angles, *verdicts = kinematics.ik_batch(poses, geometry, limits)
    return angles.astype(dtype, copy=False), *verdicts


def _judged(x, y, z, pitch, low1, high1, low2, high2, low3, high3, low4, high4, *lengths):
    """The branches as `omx.ik_batch` gives them; then of each whether it is in reach, and whether it is legal."""
    up, down, back_up, back_down, D, D_back = _branches(x + 0.0, y + 0.0, z, remainder(pitch, tau), *lengths)
    front, back = abs(D) <= _WITHIN, abs(D_back) <= _WITHIN
    ends = (low1, high1, low2, high2, low3, high3, low4, high4)
    up, down, back_up, back_down = _closed(up), _closed(down), _closed(back_up), _closed(back_down)
    return (
        _shown(up, front), _shown(down, front), _shown(back_up, back), _shown(back_down, back),
        front, front, back, back, front & _inside(up, ends), front & _inside(down, ends), back & _inside(back_up, ends),
        back & _inside(back_down, ends),
    )  # fmt: skip


_branches, _WITHIN = _ik.branches, kinematics.WITHIN


def _closed(q):
    """The arc tangent's range is closed at both ends, ours at pi alone."""
    return pi if q[0] == -pi else q[0], q[1], q[2], q[3]


def _shown(q, reached):
    blank = 0.0 if reached else nan
    return q[0] + blank, q[1] + blank, q[2] + blank, q[3] + blank


def _inside(q, ends):
    """Are the four angles within their limits?"""
    low1, high1, low2, high2, low3, high3, low4, high4 = ends
    return (
        (q[0] >= low1) & (q[0] <= high1) & (q[1] >= low2) & (q[1] <= high2)
        & (q[2] >= low3) & (q[2] <= high3) & (q[3] >= low4) & (q[3] <= high4)
    )  # fmt: skip


# ---- rows in, arrays out -------------------------------------------------------------------------------------


def _many(function: Callable, batch: Callable) -> Callable:
    """`function` for rows, compiled when first called; `batch` is its NumPy form, for where it cannot be."""
    names = list(inspect.signature(function).parameters)

    def call(rows, *parameters, threads: int | None = None, dtype=np.float64):
        inputs = len(names) - len(parameters)
        if inputs < 1:
            raise BadInput(
                f"`{function.__name__}` has {len(names)} arguments; got rows and {len(parameters)} parameters."
            )
        rows = _rows(rows, "rows", inputs, f"{', '.join(names[:inputs])}")
        flat = rows.reshape(-1, inputs)
        done = _run(function, flat, parameters, threads, dtype)
        if done is None:
            columns = np.broadcast_arrays(
                flat[:, 0], *(number for _, number in _places(batch(*flat.astype(np.float64).T, *parameters)))
            )[1:]
            done = np.array(columns, dtype).T, None
        return _assembled(done[0], function(*[0.5] * inputs, *parameters), rows.shape[:-1])

    call.__name__, call.__doc__ = function.__name__, f"{function.__doc__} For many rows: see `compile_batch`."
    return call


def _places(results, at: str = "r"):
    """Each number of nested tuples with the code that reads it: `r[0][1]`."""
    if not isinstance(results, tuple):
        yield at, results
        return
    for i, part in enumerate(results):
        yield from _places(part, f"{at}[{i}]")


def _assembled(values: np.ndarray, like, batch: tuple[int, ...]):
    """Columns of `values` (N, n) in the shape of one row's results, `like`, behind the shape of the batch."""
    try:
        return values.reshape(*batch, *np.shape(like))
    except ValueError:  # results of several shapes
        borders = np.cumsum([len(dict(_places(part))) for part in like])[:-1]
        pieces = np.split(values, borders, axis=1)
        return tuple(_assembled(piece, part, batch) for piece, part in zip(pieces, like, strict=True))


def _rows(value, name: str, columns: int, wanted: str) -> np.ndarray:
    """`value` as float32 or float64 rows; the compiled loop finds what is not finite."""
    plain = isinstance(value, np.ndarray) and value.dtype in (np.float32, np.float64)
    if plain and value.ndim > 1 and value.shape[-1] == columns and value.size:
        return np.ascontiguousarray(value)
    return as_rows(value, name, columns, wanted)


def _run(function: Callable, rows: np.ndarray, parameters: tuple, threads: int | None, dtype):
    """Numbers (N, n) and truths (N, m) that `function` gives for each row; None without numba or out of `RANGE`."""
    if np.dtype(dtype) not in (np.float32, np.float64):
        raise BadInput(f"`dtype` must be float64 or float32; got {dtype!r}.")
    if threads is None:
        threads = (cpu_count() or 1) if len(rows) >= THREADED else 1
    if threads < 1:
        raise BadInput(f"`threads` must be at least 1; got {threads}.")
    if not available():
        return None
    results, count = dict(_places(function(*[0.5] * rows.shape[1], *parameters))), len(rows)
    truths = tuple(place for place, result in results.items() if isinstance(result, bool))
    numbers = tuple(place for place in results if place not in truths)
    in_rows = len(numbers) <= WIDEST_ROW
    out = np.empty((count, len(numbers)) if in_rows else (len(numbers), count), dtype)
    marks = np.empty((len(truths), count), bool)
    loop, parameters = _loop(function, rows.shape[1], numbers, truths, in_rows), tuple(map(float, parameters))
    borders = np.linspace(0, count, threads + 1).astype(int).tolist()
    if threads == 1:
        fine = loop(0, count, rows, out, marks, parameters)
    else:
        with ThreadPoolExecutor(threads) as pool:
            ways = pool.map(lambda *piece: loop(*piece, rows, out, marks, parameters), borders[:-1], borders[1:])
            fine = all(list(ways))
    return (out if in_rows else out.T, marks.T) if fine else None


# ---- compiling -----------------------------------------------------------------------------------------------


def _compile(function: Callable, **options) -> Callable:
    import numba

    return numba.njit(nogil=True, error_model="numpy", fastmath={"contract", "nsz", "arcp"}, **options)(function)


def _inline(function: Callable) -> Callable:
    """The function compiled into whatever calls it, with what it calls: our sines for Python's, others alike."""
    known = function.__globals__
    inner = {name: known[name] for name in function.__code__.co_names if isinstance(known.get(name), FunctionType)}
    names = known | {name: _inline(called) for name, called in inner.items()} | _functions()
    return _compile(FunctionType(function.__code__, names, function.__name__), forceinline=True)


@cache
def _functions() -> dict[str, Callable]:
    """What the generated code calls, from the polynomials: no branches, so that it runs for several rows at once."""
    sine, cosine, arc_tangent = (
        _compile(f, forceinline=True) for f in (_polynomials.sine, _polynomials.cosine, _polynomials.arc_tangent)
    )
    rest_of_pi, eighth = 1.2246467991473532e-16, tan(pi / 8)  # pi less its float

    def sin(x):
        turns = np.rint(x * (1.0 / pi))
        return sine((x - turns * pi) - turns * rest_of_pi) * (1.0 - 2.0 * abs(turns - 2.0 * np.rint(0.5 * turns)))

    def cos(x):
        turns = np.rint(x * (1.0 / pi))
        return cosine((x - turns * pi) - turns * rest_of_pi) * (1.0 - 2.0 * abs(turns - 2.0 * np.rint(0.5 * turns)))

    def atan2(y, x):
        steep = abs(y) > abs(x)
        short, long = (abs(x), abs(y)) if steep else (abs(y), abs(x))
        wide = short > eighth * long
        above, below = (short - long, short + long) if wide else (short, long if long > 0.0 else 1.0)
        angle = arc_tangent(above / below) + (0.25 * pi if wide else 0.0)
        angle = 0.5 * pi - angle if steep else angle
        angle = pi - angle if x < 0.0 else angle
        return -angle if y < 0.0 else angle

    def remainder(x, turn):  # as `wrap` in arrays.py, but products fused with sums can round to more than half a turn
        turns = x * (1.0 / turn)
        angle = (turns - np.ceil(turns - 0.5)) * turn
        return pi if angle > pi else angle

    def max(a, b):
        return a if a > b else b

    return {f.__name__: _compile(f, forceinline=True) for f in (sin, cos, atan2, remainder, max)}


@cache
def _loop(
    function: Callable, inputs: int, numbers: tuple[str, ...], truths: tuple[str, ...], in_rows: bool
) -> Callable:
    """`function` over rows `start` .. `stop`, compiled when first called; it returns whether all were in `RANGE`.

    `numbers` and `truths`: where the results stand in what `function` returns, such as `r[0][1]`. Rows are copied to
    columns, worked on a round at a time, and copied to where they belong.
    """
    names = list(inspect.signature(function).parameters)[:inputs]
    load, copy = _load(np.array([RANGE[name[0] in LENGTHS] for name in names])), _copy()
    columns = _compile(_columns(function, inputs, numbers, truths))
    width, marked, step = len(numbers), len(truths), ROUND if in_rows else RUN

    @_compile
    def loop(start, stop, rows, out, marks, parameters):
        w, t, fine = np.zeros((inputs + width) * PITCH), np.zeros((marked + 1) * PITCH, dtype=np.bool_), True
        past = out.nbytes > CACHED
        for first in range(start, stop, step):
            part = slice(first, min(first + step, stop))
            fine &= load(rows[part], w)
            for k in range(0, part.stop - first, ROUND):
                columns(w[k:], t[k:], parameters)
            if in_rows:
                results = out[part]
                for i in range(len(results)):
                    for j in range(width):
                        results[i, j] = w[(inputs + j) * PITCH + i]
            else:
                for j in range(width):
                    copy(w[(inputs + j) * PITCH :], out[j, part], past)
            for j in range(marked):
                copy(t[j * PITCH :], marks[j, part], False)
        return fine

    return loop


def _load(bounds: np.ndarray) -> Callable:
    """Rows to the first columns of `w`; True if none of their numbers is beyond its bound."""
    inputs = len(bounds)

    @_compile
    def load(rows, w):
        wrong = 0
        for i in range(len(rows)):
            for j in range(inputs):
                w[j * PITCH + i] = rows[i, j]
        for j in range(inputs):
            for i in range(len(rows)):
                wrong += not abs(w[j * PITCH + i]) <= bounds[j]
        return wrong == 0

    return load


def _columns(function: Callable, inputs: int, numbers: tuple[str, ...], truths: tuple[str, ...]) -> Callable:
    """One round of `function`: from the first columns of `w` to those after them, truths to the columns of `t`."""
    given = ", ".join(f"w[{j * PITCH} + i]" for j in range(inputs))
    lines = ["def columns(w, t, p):", f"    for i in range({ROUND}):", f"        r = f({given}, *p)"]
    lines += [f"        w[{(inputs + j) * PITCH} + i] = {result}" for j, result in enumerate(numbers)]
    lines += [f"        t[{j * PITCH} + i] = {result}" for j, result in enumerate(truths)]
    names = {"f": _inline(function)}
    exec("\n".join(lines), names)
    return names["columns"]


@cache
def _copy() -> Callable:
    """Fill `target` from the beginning of `column`, by loops: numba makes them four times as fast as a slice.

    `past` the caches, each line of memory is written without being read first.
    """
    from numba import types
    from numba.extending import intrinsic

    @intrinsic
    def store(_, target, i, value):
        def emit(context, builder, signature, given):
            array = context.make_array(target)(context, builder, given[0])
            number = context.cast(builder, given[2], value, target.dtype)
            number = context.get_value_as_data(builder, target.dtype, number)
            size = context.get_abi_sizeof(number.type)
            written = builder.store(number, builder.gep(array.data, [given[1]]), align=size)
            one = context.get_constant(types.int32, 1)
            written.set_metadata("nontemporal", builder.module.add_metadata([one]))
            return context.get_dummy_value()

        return types.void(target, i, value), emit

    @_compile
    def copy(column, target, past):
        if past:
            for i in range(len(target)):
                store(target, i, column[i])
        else:
            for i in range(len(target)):
                target[i] = column[i]

    return copy
