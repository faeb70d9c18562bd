"""What a function asks of NumPy, written down: a program for any compiler, one call a line.

The function is given rows and columns that are not there. It must be for arrays of any library, and decide nothing by a
value: generated functions of columns, and those of `omx` that call them, are such.
"""

from collections.abc import Callable

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin

from ..errors import BadInput


def recorded(function: Callable, inputs: int) -> tuple[tuple[str, ...], tuple[float, ...], tuple[tuple[str, ...], ...]]:
    """What `function` of rows (..., inputs) does with each row: its statements, its constants, its results' names.

    A statement is one call, `v7 = add(v3, p[1])`. `x0`, `x1` .. are the inputs, `p[0]`, `p[1]` .. the constants. The
    names stand in the order of the results, a tuple for each array. Raises `BadInput` for what cannot be written so.
    """
    lines, constants = list[str](), dict[str, str]()
    found = function(Rows([Column(f"x{j}", lines, constants) for j in range(inputs)]))
    parts = found if isinstance(found, tuple) else (found,)
    names = tuple(tuple(column.name for column in np.array(part, object).flat) for part in parts)
    return tuple(lines), tuple(map(float, constants)), names


class Rows:
    """Rows that are not there. Only their columns can be computed with."""

    __array_ufunc__ = None

    def __init__(self, columns: "list[Column]"):
        self.columns, self.shape, self.ndim = columns, (len(columns),), 1

    def __array_namespace__(self):
        return np

    def __getitem__(self, index):
        return self.columns[index[-1]]


class Column(NDArrayOperatorsMixin):
    """An array that is not there: a step of a function, by the name of what it gives for one row."""

    ndim = 0

    def __init__(self, name: str, lines: list[str], constants: dict[str, str]):
        self.name, self.lines, self.constants = name, lines, constants

    def __array_namespace__(self):
        return np

    def __bool__(self):
        raise BadInput("a function that asks whether a number is so or so cannot be compiled; let it use `where`.")

    def __array_ufunc__(self, ufunc, method, *given, **named):
        return self._write(ufunc, given, method == "__call__" and not named)

    def __array_function__(self, function, types, given, named):
        if function is np.full_like:
            return Column(self._word(given[1]), self.lines, self.constants)
        if function is np.stack:
            return np.stack([np.array(column, object) for column in given[0]], **named)
        return self._write(function, given, function is np.where)

    def _write(self, function, given, known: bool) -> "Column":
        if not known:
            raise BadInput(f"a function that uses `numpy.{function.__name__}` like this cannot be compiled.")
        self.lines.append(f"v{len(self.lines)} = {function.__name__}({', '.join(map(self._word, given))})")
        return Column(f"v{len(self.lines) - 1}", self.lines, self.constants)

    def _word(self, value) -> str:
        if isinstance(value, (Column, int)):
            return getattr(value, "name", repr(value))
        return self.constants.setdefault(repr(float(value)), f"p[{len(self.constants)}]")
