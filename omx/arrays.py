"""Whole-array arithmetic for the generated batch functions, and the check that array arguments pass."""

import math

import numpy as np

from .errors import BadInput

#: Rows worked on at a time: enough that Python's share of the time is small, few enough that a column (96 KB)
#: stays in the cache and below the 128 KB from which the C library maps fresh memory for every array.
BLOCK = 12_288

#: Floats (16 MB) that are asked for and let go, untouched, before many blocks are worked on. The C library hands a
#: block's columns back to the system, page by page, unless it has seen larger pieces freed; that takes longer than
#: computing them.
HOARD = 1 << 21


def sincos(x):
    """Sine and cosine of an array (rad), both from one tangent of the half angle.

    NumPy evaluates `sin` and `cos` of float64 one element at a time, but `tan` in vector registers, so
    this is several times faster than calling both. The error is below 1e-15 (2e-13 mm at the arm's tip).
    """
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


def fill(out, entries):
    """Write nested tuples of columns (or plain numbers) into the trailing axes of `out`, row by row."""
    for i, row in enumerate(entries):
        for j, entry in enumerate(row):
            out[..., i, j] = entry
    return out
