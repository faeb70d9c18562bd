"""Whole-array arithmetic for the generated batch functions, and the check that array arguments pass.

The formulas take their functions from the arrays that they are given, so one source serves NumPy, JAX, PyTorch, CuPy
and Dask."""

import math
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
        return (turns - namespace(x).ceil(turns - 0.5)) * math.tau
    turns -= np.ceil(turns - 0.5)
    turns *= math.tau
    return turns


def as_rows(value, name: str, columns: int, wanted: str):
    """`value` as a float64 array of shape (..., `columns`), finite throughout; `BadInput` otherwise."""
    expected = f"`{name}` must be {wanted}, shape ({columns},) or (..., {columns})"
    array = _as_floats(value, expected)
    if array.ndim == 0 or array.shape[-1] != columns:
        raise BadInput(f"{expected}; got shape {array.shape}.")
    if array.size == 0:
        raise BadInput(f"{expected}; got an empty batch of shape {array.shape}.")
    finite = np.isfinite(array)
    if not finite.all():
        where = tuple(int(i) for i in np.argwhere(~finite)[0])
        index = ", ".join(map(str, where))
        raise BadInput(f"{expected}, all finite; got shape {array.shape} with `{name}`[{index}] = {array[where]}.")
    return array


def _as_floats(value, expected: str):
    """Whole numbers, floats, and objects that have a float value (SymPy's, fractions) as float64; nothing else."""
    try:
        array = np.asarray(value)
        if array.dtype.kind in "iuf" or (array.dtype.kind == "O" and None not in array.ravel().tolist()):
            return array.astype(np.float64, copy=False)
    except (ValueError, TypeError, OverflowError):
        array = None
    raise BadInput(f"{expected}; got {_described(value, array)}.")


def _described(value, array) -> str:
    text = repr(value)
    shown = text if len(text) < 60 else f"a {type(value).__name__}"
    shape = f" of shape {array.shape}" if array is not None and array.ndim else ""
    return f"{shown}{shape}, which is not a table of real numbers"


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


def fill(out, entries):
    """Write nested tuples of columns (or plain numbers) into the trailing axes of `out`, row by row."""
    for i, row in enumerate(entries):
        for j, entry in enumerate(row):
            out[..., i, j] = entry
    return out
