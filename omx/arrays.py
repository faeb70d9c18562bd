"""Whole-array arithmetic for the generated batch functions, and the one gate that numbers pass on their way in.

The formulas take their functions from the arrays that they are given, so one source serves NumPy, JAX, PyTorch, CuPy
and Dask."""

import math
from collections.abc import Callable, Iterator
from itertools import islice
from numbers import Real
from typing import Any

import numpy as np

from .errors import BadInput

#: Rows worked on at a time: enough that Python's share of the time is small, few enough that a column (96 KB)
#: stays in the cache and below the 128 KB from which the C library maps fresh memory for every array.
BLOCK = 12_288

#: Floats (16 MB) that are asked for and let go, untouched, before many blocks are worked on. The C library hands a
#: block's columns back to the system, page by page, unless it has seen larger pieces freed; that takes longer than
#: computing them.
HOARD = 1 << 21

#: No number may be larger: sums of four, and products with lengths, stay finite.
HUGE = 1e306


#: An array of NumPy, or of another library that keeps to the array API standard: JAX, PyTorch, CuPy, Dask ...
Array = Any

_OTHER_LIBRARIES = ("torch", "dask", "cupy", "jax", "jaxlib", "array_api_strict")


def is_foreign(value) -> bool:
    """Is it an array of another library than NumPy? Then it keeps its kind, its device and its laziness."""
    kind = type(value)
    if issubclass(kind, (np.ndarray, np.generic, float, int, list, tuple)):
        return False
    return hasattr(kind, "__array_namespace__") or kind.__module__.partition(".")[0] in _OTHER_LIBRARIES


def namespace(*arrays):
    """The functions for these arrays by the names of the array API standard, from NumPy or from their own library."""
    first = next(filter(is_foreign, arrays), None)
    if first is None:
        return np
    if hasattr(first, "__array_namespace__"):
        return first.__array_namespace__()
    from array_api_compat import array_namespace  # PyTorch and Dask have some of the names otherwise

    return array_namespace(first)


def sincos(x):
    """Sine and cosine of an array (rad), for NumPy both from one tangent of the half angle.

    NumPy evaluates `sin` and `cos` of float64 one element at a time, but `tan` in vector registers, so
    this is several times faster than calling both. The error is below 1e-15 (2e-13 mm at the arm's tip).
    """
    if is_foreign(x):
        xp = namespace(x)
        return xp.sin(x), xp.cos(x)
    t = np.tan(0.5 * x)
    u = t * t
    u += 1.0
    u = 2.0 / u
    t *= u  # not t*(1 + cos), which is 0 times infinity near half a turn
    u -= 1.0
    return t, u


def wrap(x):
    """Angles (rad) brought into (-pi, pi], to within the spacing of floats at `x`.

    In turns, because there the subtraction is exact: what is left is in (-1/2, 1/2], and half a turn is pi.
    """
    turns = x * (1.0 / math.tau)
    if is_foreign(x):
        ceil = namespace(x).ceil
        turns = turns - ceil(turns - 0.5)
        return (turns - ceil(turns - 0.5)) * math.tau  # once more: compilers may round the first otherwise
    turns -= np.ceil(turns - 0.5)
    turns *= math.tau
    return turns


def where(condition, a, b):
    """`a` where the condition holds, else `b`: arrays or numbers."""
    xp = namespace(condition)
    if is_foreign(condition) and not (is_foreign(a) or is_foreign(b)):
        a = xp.full_like(condition, a, dtype=xp.float64)  # two numbers may become float32 there
    return xp.where(condition, a, b)


class Four:
    """A base for what stands for four numbers in their order, so that the gates below unpack it."""

    __slots__ = ()

    def __iter__(self) -> Iterator[float]:
        raise NotImplementedError


_ORDERED, _PLAIN = (tuple, list, Four), {float, int}


def as_four(value, name: str, wanted: str) -> tuple[float, float, float, float]:
    """Four finite floats, from any one row that `as_rows` takes; `BadInput` otherwise."""
    four = as_four_or_rows(value, name, wanted, many=False)
    return four if four.__class__ is tuple else tuple(as_rows(four, name, 4, wanted, many=False).tolist())


def as_four_or_rows(value, name: str, wanted: str, many: bool = True):
    """A tuple of four plain floats, by the quick way; else what `as_rows` returns, with two axes or more.

    An array of another library comes back as it is, with its shape checked.
    """
    try:
        four: tuple = ()
        if value.__class__ is tuple:
            four = value
        elif value.__class__ is list:
            four = tuple(value)
        elif value.__class__ is np.ndarray and value.ndim == 1:
            four = tuple(value.tolist())
        elif isinstance(value, _ORDERED):
            four = tuple(value)
        elif is_foreign(value) and value.ndim and value.shape[-1] == 4:
            return value
        a, b, c, d = four
        if a.__class__ is float and b.__class__ is float and c.__class__ is float and d.__class__ is float:
            if abs(a + b + c + d) < HUGE:
                return four
        elif {type(a), type(b), type(c), type(d)} <= _PLAIN and abs(a + b + c + d) < HUGE:
            return float(a), float(b), float(c), float(d)
    except (TypeError, ValueError, OverflowError):  # not four numbers: a batch, or a mistake that `as_rows` explains
        pass
    rows = as_rows(value, name, 4, wanted, many)
    return tuple(rows.tolist()) if rows.ndim == 1 else rows


def as_rows(value, name: str, columns: int, wanted: str, many: bool = True):
    """`value` as a float64 array of shape (..., `columns`), finite throughout; `BadInput` otherwise.

    One row alone, (`columns`,), unless `many`.

    What passes, here and through `as_four`: arrays of whole numbers or floats, whatever NumPy makes such an array of
    (pandas, PyTorch), lists and tuples of numbers, nested or not, and an iterator over one row. Numbers may be
    Python's, NumPy's, SymPy's, fractions, decimals. Refused: True and False, strings, None, complex numbers, what is
    masked, NaN, infinity, numbers beyond 1e306, and sets and mappings, whose order means nothing.
    """
    expected = f"`{name}` must be {wanted}, shape ({columns},)" + (f" or (..., {columns})" if many else "")
    if isinstance(value, Iterator):
        value = _row(value, columns)
    array = _as_floats(value, expected)
    if array.ndim == 0 or array.shape[-1] != columns or (array.ndim > 1 and not many):
        raise BadInput(f"{expected}; got shape {array.shape}.")
    if array.size == 0:
        raise BadInput(f"{expected}; got an empty batch of shape {array.shape}.")
    entries = array.ravel("K")
    if not np.vdot(entries, entries) < HUGE and not -HUGE < array.min() <= array.max() < HUGE:  # NaN passes neither
        place = tuple(int(i) for i in np.argwhere(~(np.abs(array) < HUGE))[0])
        index = ", ".join(map(str, place))
        raise BadInput(f"{expected}, all finite; got shape {array.shape} with `{name}`[{index}] = {array[place]}.")
    return array


def as_number(value, name: str, wanted: str = "a number", low: float = -HUGE, high: float = HUGE) -> float:
    """One finite float in [low, high]; `BadInput` otherwise. `wanted` says what the number is, with its unit."""
    if _is_number(value) or (isinstance(value, np.ndarray) and value.shape == () and value.dtype.kind in "iuf"):
        try:
            number = float(value)
        except (TypeError, ValueError, OverflowError):  # SymPy's symbols and complex numbers
            number = math.nan
        if low <= number <= high:
            return number
    raise BadInput(f"`{name}` must be {wanted}; got {shown(value)}.")


def as_count(value, name: str, least: int = 1, most: int = 1 << 40) -> int:
    """A whole number, `least` to `most`; `BadInput` otherwise."""
    if isinstance(value, (int, np.integer)) and not isinstance(value, bool) and least <= value <= most:
        return int(value)
    raise BadInput(f"`{name}` must be a whole number, at least {least} and at most {most:,}; got {shown(value)}.")


def as_word(value, name: str = "name") -> str:
    """A name that can stand in a path; `BadInput` otherwise."""
    if isinstance(value, str) and value and "/" not in value:
        return value
    raise BadInput(f"`{name}` must be a word without '/'; got {shown(value)}.")


def as_floats(value, name: str, wanted: str) -> np.ndarray:
    """`value` as a float64 array of any shape; `BadInput` otherwise."""
    return _as_floats(value, f"`{name}` must be {wanted}")


def _row(values, columns: int) -> list:
    """The first numbers of an iterator, one more than there should be; nothing else can be taken from it twice."""
    row = list(islice(values, columns + 1))
    return row if all(_is_number(entry) for entry in row) else [None]


def _is_number(value) -> bool:
    """Anything with a float value that is no truth value, no text and no complex number."""
    if type(value) in (float, int):
        return True
    real = isinstance(value, Real) or (hasattr(value, "__float__") and not hasattr(value, "__len__"))
    return real and not isinstance(value, (bool, np.bool_, np.complexfloating, np.ma.core.MaskedConstant))


def _as_floats(value, expected: str):
    """Whole numbers, floats, and objects that have a float value (SymPy's, fractions) as float64; nothing else."""
    array = None
    try:
        array = np.asarray(value)
        plain = array.dtype.kind in "iuf" or (array.dtype.kind == "O" and all(map(_is_number, array.flat)))
        if plain and not _hides_something(value):
            return array.astype(np.float64, copy=False)
    except (ValueError, TypeError, OverflowError, RecursionError):
        array = None
    shape = f" of shape {array.shape}" if array is not None and array.ndim else ""
    raise BadInput(f"{expected}; got {shown(value)}{shape}, which is not a table of real numbers.")


def _hides_something(value) -> bool:
    """Truth values and masked entries, which `numpy.asarray` would turn into numbers without a word."""
    if isinstance(value, np.ma.MaskedArray):
        return bool(np.ma.is_masked(value))
    if isinstance(value, (list, tuple)):
        return any(type(entry) is not float and _hides_something(entry) for entry in value)
    return isinstance(value, (bool, np.bool_))


def shown(value) -> str:
    """The value as text, if that is short; else what it is."""
    try:
        text = repr(value)
    except Exception:  # a value's own repr may do anything
        text = ""
    return text if 0 < len(text) < 60 and "\n" not in text else f"a {type(value).__name__}"


def in_blocks(rows, block: int = BLOCK):
    """Slices that cut `rows` (N, k) into blocks, each with its columns contiguous: (slice, (k, n) array)."""
    if len(rows) > block:
        np.empty(HOARD)
    for start in range(0, len(rows), block):
        piece = slice(start, start + block)
        yield piece, np.ascontiguousarray(rows[piece].T)


def stacked(entries, like):
    """Nested tuples of foreign columns (or plain numbers) as one array: `like`'s shape, then an axis a level."""
    xp = namespace(like)
    if not isinstance(entries, tuple):
        return entries if is_foreign(entries) else xp.full_like(like, entries)
    return xp.stack([stacked(entry, like) for entry in entries], axis=like.ndim)


def of_rows(batch: Callable) -> Callable:
    """A generated function of columns as one of rows (..., k), of any library: `of_rows(fk.pose_batch)(q, *lengths)`.

    It returns an array (..., n), or (..., n, m) for a matrix; a tuple of arrays where results have several shapes.
    """
    names = batch.__code__.co_varnames[: batch.__code__.co_argcount]

    def function(rows, *parameters):
        inputs = names[: len(names) - len(parameters)]
        wanted = f"{', '.join(inputs) or 'nothing'} before {len(parameters)} parameters of `{batch.__name__}`"
        if not (is_foreign(rows) and inputs and rows.ndim and rows.shape[-1] == len(inputs)):
            rows = as_rows(rows, "rows", len(inputs), wanted)
        columns = [rows[..., j] for j in range(len(inputs))]
        results = batch(*columns, *map(as_number, parameters, names[len(inputs) :]))
        several = isinstance(results, tuple) and len(set(map(_shape, results))) > 1
        return tuple(stacked(part, columns[0]) for part in results) if several else stacked(results, columns[0])

    function.__name__, function.__doc__ = batch.__name__, batch.__doc__
    return function


def _shape(entries) -> tuple[int, ...]:
    """That of nested tuples."""
    return (len(entries), *_shape(entries[0])) if isinstance(entries, tuple) else ()


def fill(out, entries):
    """Write columns (or plain numbers), or a tuple of tuples of them, into the last axis of `out`, or the last two."""
    for i, entry in enumerate(entries):
        if isinstance(entry, tuple):
            fill(out[..., i, :], entry)
        else:
            out[..., i] = entry
    return out
