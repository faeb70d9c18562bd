"""Wrong answers made from right ones: the slips that students make, for any answer of any exercise."""

import inspect
import math

import numpy as np
import sympy as sp

from omx.dh import Chain
from omx.errors import OmxError


def wrong_answers(right, returned=None):
    """(what was done, a wrong answer) for one right answer: a number, an array, a function, a chain, an expression.

    Of a function, `returned` is all that it gave its check: a slip that fits nothing of it would change nothing.
    """
    yield "untouched TODO", ...
    yield "None", None
    yield "a text", "seven"
    if callable(right):
        yield from wrong_functions(right, returned)
        return
    for name, slip in SLIPS.items():
        wrong = slipped(slip, right)
        if wrong is not ... and not same(wrong, right):
            yield name, wrong


def wrong_functions(right, returned=None):
    """The same slips in what a function returns, in what it takes, and functions that do not work at all."""

    def todo(*_):
        raise NotImplementedError("Exercise 0.0 is still to do. Hint: none.")

    yield "untouched TODO in it", todo
    yield "no return line", lambda *_: None
    yield "stops", lambda *_: 1 / 0
    yield "no arguments", lambda: None
    for name, slip in SLIPS.items():
        if returned is None or any(slipped(slip, result) is not ... for result in returned):
            yield f"returns: {name}", Slipped(right, slip)
    yield "takes degrees", Slipped(right, None, lambda first: np.radians(first))
    yield "first argument negated", Slipped(right, None, lambda first: -np.asarray(first))
    yield "always the first result", Remembering(right)


class Slipped:
    """A function with a slip in its result, or in its first argument; `differed` says whether that ever mattered."""

    def __init__(self, right, slip, before=None, outer=None):
        self.right, self.slip, self.before, self.differed, self.outer = right, slip, before, False, outer
        self.__name__, self.__signature__ = getattr(right, "__name__", "it"), inspect.signature(right)

    def __call__(self, *arguments):
        result = self.right(*arguments)
        if is_function(result):
            return Slipped(result, self.slip, self.before, self)
        if self.before:
            wrong = self.right(*self.changed(arguments))
        else:
            wrong = slipped(self.slip, result)
            wrong = result if wrong is ... else wrong
        if not same(wrong, result):
            self.differed = True
            if self.outer:
                self.outer.differed = True
        return wrong

    def changed(self, arguments):
        try:
            return (self.before(arguments[0]), *arguments[1:])
        except (TypeError, IndexError):
            return arguments


class Overheard:
    """The right function; `returned` is all that it returned, also by the functions that it returned."""

    def __init__(self, right, returned=None):
        self.right, self.returned = right, [] if returned is None else returned
        self.__name__, self.__signature__ = getattr(right, "__name__", "it"), inspect.signature(right)

    def __call__(self, *arguments):
        result = self.right(*arguments)
        if is_function(result):
            return Overheard(result, self.returned)
        self.returned.append(result)
        return result


class Remembering:
    """A function that gives its first result for ever."""

    def __init__(self, right):
        self.right, self.first, self.differed = right, None, False
        self.__name__, self.__signature__ = getattr(right, "__name__", "it"), inspect.signature(right)

    def __call__(self, *arguments):
        result = self.right(*arguments)
        self.first = result if self.first is None else self.first
        self.differed = self.differed or not same(self.first, result)
        return self.first


def is_function(value):
    return callable(value) and not isinstance(value, (Chain, np.ndarray))


def slipped(slip, value):
    """The value with a slip, or `...` where the slip does not apply."""
    try:
        return slip(value)
    except (TypeError, ValueError, IndexError, AttributeError, KeyError, ZeroDivisionError, OmxError, sp.SympifyError):
        return ...


def numbers(change):
    """A slip for numbers and arrays, applied to plain and nested ones, of NumPy's kind afterwards."""

    def slip(value):
        if isinstance(value, (bool, str, bytes, set, sp.Basic, sp.MatrixBase, np.bool_)) or value is None:
            return ...
        array = np.asarray(value)
        return change(array.astype(float) if array.dtype.kind in "iufO" else unfit())

    return slip


def unfit():
    raise TypeError


def swapped(a):
    b = np.array(a)
    b[..., [0, 1]] = a[..., [1, 0]]
    return b


def symbolic(change):
    return lambda value: change(value) if isinstance(value, (sp.Expr, sp.MatrixBase)) else ...


def kind(types, change):
    return lambda value: change(value) if isinstance(value, types) else ...


def every(change):
    """A change of an expression, or of each entry of a matrix."""
    return lambda value: value.applyfunc(change) if isinstance(value, sp.MatrixBase) else change(value)


def other_waves(e):
    return e.replace(lambda x: isinstance(x, sp.sin), lambda x: sp.Function("C")(x.args[0])).replace(
        sp.cos, sp.sin).replace(sp.Function("C"), sp.cos)  # fmt: skip


SLIPS = {
    "degrees": numbers(np.degrees),
    "radians": numbers(np.radians),
    "metres": numbers(lambda a: a / 1000),
    "sign": numbers(lambda a: -a),
    "off by one": numbers(lambda a: a + 1),
    "off by a little": numbers(lambda a: a + 0.01 * (1 + np.abs(a))),
    "twice": numbers(lambda a: 2 * a),
    "zero": numbers(lambda a: 0 * a),
    "NaN": numbers(lambda a: a * math.nan),
    "swapped": numbers(lambda a: swapped(a) if a.ndim else ...),
    "reversed": numbers(lambda a: a[::-1] if a.ndim else ...),
    "transposed": numbers(lambda a: a.T if a.ndim > 1 else ...),
    "one short": numbers(lambda a: a[:-1] if a.ndim else ...),
    "one too many": numbers(lambda a: np.append(a, a[-1:], axis=0) if a.ndim else np.array([a, a])),
    "np.matrix": numbers(lambda a: np.matrix(a) if a.ndim < 2 else np.matrix(a + 1)),
    "ragged": numbers(lambda a: [[1.0, 2.0], [3.0]]),
    "opposite": kind((bool, np.bool_), lambda b: not b),
    "one for True": kind((bool, np.bool_), int),
    "always True": kind((bool, np.bool_), lambda b: True),
    "always False": kind((bool, np.bool_), lambda b: False),
    "another text": kind(str, lambda s: s[::-1] + "1"),
    "bytes reversed": kind(bytes, lambda b: b[::-1]),
    "one bit wrong": kind(bytes, lambda b: bytes([*b[:-1], b[-1] ^ 1])),
    "one byte short": kind(bytes, lambda b: b[:-1]),
    "a list for bytes": kind(bytes, list),
    "empty": kind((set, dict, str, bytes), lambda s: type(s)()),
    "one left out": kind((set, dict), lambda s: type(s)(sorted(s, key=str)[1:]) if isinstance(s, set) else {}),
    "a list of Nones": kind(list, lambda v: [None] * len(v)),
    "in another order": kind(list, lambda v: v[::-1]),
    "without the last": kind(list, lambda v: v[:-1]),
    "rows for a chain": kind(Chain, lambda c: list(c.rows)),
    "a chain without its last row": kind(Chain, lambda c: Chain(c.rows[:-1])),
    "a chain of opposite twists": kind(Chain, lambda c: Chain([r._replace(alpha=r.alpha + 0.5) for r in c.rows])),
    "a chain of lengths off by one": kind(Chain, lambda c: Chain([r._replace(a=r.a + 1) for r in c.rows])),
    "minus the expression": symbolic(lambda e: -e),
    "the expression plus one": symbolic(every(lambda e: e + 1)),
    "sine for cosine": symbolic(every(other_waves)),
    "root of its square": symbolic(every(lambda e: sp.sqrt(e**2))),
    "arc sine of its sine": symbolic(every(lambda e: sp.asin(sp.sin(e)))),
    "the transposed expression": symbolic(lambda e: e.T),
    "an equation": symbolic(lambda e: sp.Eq(sp.Symbol("y"), e)),
}


def same(a, b) -> bool:
    """Are two answers the same, as far as anybody can see?"""
    if isinstance(a, (sp.Basic, sp.MatrixBase)) or isinstance(b, (sp.Basic, sp.MatrixBase)):
        return a == b
    if type(a) in (set, str, bytes, dict) or type(b) in (set, str, bytes, dict):
        return a == b
    if isinstance(a, (bool, np.bool_)) or isinstance(b, (bool, np.bool_)):
        return type(a) in (bool, np.bool_) and type(b) in (bool, np.bool_) and bool(a) == bool(b)
    try:
        a, b = np.asarray(a, float), np.asarray(b, float)
        return a.shape == b.shape and bool(np.allclose(a, b, rtol=1e-7, atol=1e-9))
    except (TypeError, ValueError):
        return a is b
