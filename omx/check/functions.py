"""Checks of a function that a student wrote: called on samples, compared with what must hold for them."""

import contextlib
import inspect
import re

import numpy as np

from ..arm import HOME, LIMITS, ZERO
from ..errors import BadInput, Wrong
from .answers import compare, correct
from .mistakes import Comparison
from .validation import answer, as_numbers, counted, present

#: More numbers than this, or a longer text, are not written out in a sentence.
MANY, LONG = 8, 60


def function(function, reference, samples, name: str = "", unit: str = "", parts: str = "", within=None) -> None:
    """`function(*sample)` must equal `reference(*sample)` for every sample (a tuple of arguments, or one argument).

    `unit` and `parts` describe the result, as in `value`. Raises `Wrong`, naming the first sample that fails.
    """
    name = _named(function, name)
    rows = [sample if isinstance(sample, tuple) else (sample,) for sample in _some(samples)]
    expected = [np.asarray(reference(*row), float) for row in rows]
    answers = [_shaped(called(function, row, name), want, name) for row, want in zip(rows, expected, strict=True)]
    _degrees_taken(answers, reference, rows, expected, name)

    def example(index):
        if expected[index].size > MANY:
            furthest = Comparison(answers[index], expected[index], unit, "", within).furthest()
            return f"For {_written(rows[index])}: {furthest[0].lower()}{furthest[1:]}"
        return f"For {_written(rows[index])} it returns {_short(answers[index])}; {_short(expected[index])} is right."

    for group in _of_one_shape(expected):  # all samples of one shape together, so that one slip explains them all
        ours, theirs = (np.array([values[i] for i in group]) for values in (answers, expected))
        compare(ours, theirs, name, unit, parts, within, lambda index, group=group: example(group[index]))
    correct(f"{name}, at {len(rows)} samples")


def round_trip(there, back, samples, name: str = "", unit: str = "", parts: str = "", within=None) -> None:
    """`back(there(sample))` must give the sample again: an inverse undoes what it inverts. Raises `Wrong`.

    One of the two is the student's. `there` may return a tuple or an array; `back` takes it as one argument.
    """
    name = _named(there, name)
    rows = [np.asarray(sample, float) for sample in _some(samples)]
    middles = [_plain(called(there, (row,), name), name) for row in rows]
    answers = [_shaped(_back(back, m, name), row, name) for m, row in zip(middles, rows, strict=True)]

    def where(index):
        slip = _slip_between(middles, back, rows, name, unit, within)
        if rows[index].size > MANY:
            return slip + Comparison(answers[index], rows[index], unit, parts, within).furthest()
        return f"{slip}{_short(rows[index])} comes back as {_short(answers[index])}."

    compare(np.array(answers), np.array(rows), name, unit, parts, within, where)
    correct(f"{name}, there and back at {len(rows)} samples")


def configurations(count: int = 50, limits=LIMITS, seed: int = 0) -> np.ndarray:
    """Joint angles (count, 4), rad, within `limits`: zero, home, a straight arm, a folded one, then random ones."""
    low, high = np.array(limits, float).T
    straight, folded = (0.4, 0.3, -1.385, 0.2), (-0.7, -1.2, 1.2, 1.0)
    special = [np.clip(q, low, high) for q in (ZERO, HOME, straight, folded)]
    return np.vstack([*special, np.random.default_rng(seed).uniform(low, high, (count, len(low)))])[:count]


def call(function, /, *arguments, gives=None, name: str = ""):
    """What `function(*arguments)` returns, for checks that look at its properties.

    `gives` says what that must be, as in `answer`. The arguments are copies, so the function cannot change them.
    Raises `Wrong` with one sentence for the untouched TODO, None, an error inside, another type or shape.
    """
    name = _named(function, name)
    return answer(called(function, arguments, name), gives, f"what {name} returns")


def called(function, arguments, name: str):
    """The function's result; what goes wrong inside becomes a `Wrong` that says what to look at."""
    if not callable(function):
        present(function, name)
        raise Wrong(f"{name} must be a function; it is {_short(function)} ({type(function).__name__}).")
    try:
        result = function(*map(_copied, arguments))
    except NotImplementedError:
        raise Wrong(f"{name} is still the TODO: write its body.") from None
    except Wrong:
        raise
    except Exception as error:
        hint = _hint(error, function, arguments)
        raise Wrong(f"{name} stops with {told(error)}. {hint}".rstrip()) from error
    present(result, f"what {name} returns")
    return result


def _copied(argument):
    """A copy of numbers, in whatever lists or tuples they come; everything else as it is."""
    if isinstance(argument, (list, tuple)) and type(argument) in (list, tuple):
        return type(argument)(map(_copied, argument))
    return np.copy(argument) if isinstance(argument, np.ndarray) else argument


def told(error: Exception) -> str:
    """The kind of an error and what it says, in words for a reader."""
    sizes = re.search(r"size (\d+) is different from (\d+)", str(error))
    said = f"{sizes[2]} and {sizes[1]} numbers do not fit together in a product" if sizes else str(error)
    return f"{type(error).__name__}: {' '.join(said.split())}".rstrip(".: ")


def _hint(error: Exception, function, arguments) -> str:
    if isinstance(error, TypeError) and not _takes(function, len(arguments)):
        return f"It is called with {len(arguments)} argument{'s' * (len(arguments) != 1)}."
    return hint(error) or f"It was called with {_written(arguments)}."


#: What usually lies behind an error in an answer: its kind, what it says (a pattern), and a sentence. The first counts.
HINTS = (
    (Exception, "ellipsis", "Something that it uses is still the TODO."),
    (Exception, "size 3 is different from 4", "A 4x4 matrix takes a point as (x, y, z, 1)."),
    (IndexError, "out of bounds", "Python counts from 0: the last of four is [3]."),
    (Exception, "NoneType.*'append'", "`append` changes the list and returns nothing: do not assign what it returns."),
    (Exception, "unsupported operand.*'(Pose|tuple|list)'",
     "Tuples and lists do not compute: np.array(...) makes an array of them."),
    (Exception, "NoneType", "Something is None there: does a function lack its `return` line?"),
    (Exception, "ndarray' object is not callable", "An array takes its index in square brackets, [3]."),
    (Exception, "is not callable",
     "What stands there is no function: define it with def, and do not use its name for something else."),
    (NameError, "", "Is the name spelt as it was defined, and has the cell that defines it run without an error?"),
    (Exception, "^SympifyError", "SymPy takes no arrays: sp.lambdify makes a function of numbers from an expression."),
    (Exception, "not reversible", "list(...) around it makes a list of it, and a list can be reversed."),
    (Exception, "no attribute 'subs'",
     "An expression of SymPy is wanted there, with its symbols, or a number such as sp.Rational(1, 2)."),
    (Exception, "expression to float", "It still holds a symbol: .subs puts a number in for it."),
    (Exception, "not 'list'", "A list is no number: [0] takes its first entry."),
    (TypeError, "scalar|0-dim|real number", "math.cos and its kin take one number; did you mean np.cos?"),
    (TypeError, "no callable",
     "NumPy's functions cannot take SymPy's numbers and symbols: sp.cos can, and float(...) makes numbers."),
)  # fmt: skip


def hint(error: Exception) -> str:
    """A sentence on what usually lies behind an error in an answer; '' if nothing does."""
    text = f"{type(error).__name__}: {error}"
    unknown = re.search(r"'(\w+)'" if isinstance(error, NameError) else r"'numpy.ndarray' object has .* '(\w+)'", text)
    if unknown and hasattr(np, unknown[1]):
        name = f"np.{unknown[1]}"
        return f"Did you mean {name}?" if isinstance(error, NameError) else f"NumPy has it as a function: {name}(...)."
    return next((told for kind, said, told in HINTS if isinstance(error, kind) and re.search(said, text, re.S)), "")


def _takes(function, count: int) -> bool:
    try:
        inspect.signature(function).bind(*range(count))
    except TypeError:
        return False
    except ValueError:  # a built-in without a signature
        pass
    return True


def _shaped(result, wanted: np.ndarray, name: str) -> np.ndarray:
    """The result as numbers of the wanted shape."""
    array = as_numbers(result, f"what {name} returns")
    if array.shape != wanted.shape:
        if array.ndim <= 1 and wanted.ndim <= 1:
            raise Wrong(
                f"{name} must return {counted(wanted.shape)}; it returned {array.size if array.ndim else 'one'}."
            )
        raise Wrong(f"{name} must return an array of shape {wanted.shape}; it returned shape {array.shape}.")
    return array


def _degrees_taken(answers, reference, rows, expected, name: str) -> None:
    """`Wrong` if the function is right for an argument in degrees: it converts what is in radians already."""
    for i, in_radians in ((i, turn) for i in range(len(rows[0])) for turn in (np.deg2rad, _last_in_radians)):
        seen = []  # (the answer, what would be right for degrees, what is right), where there is such a thing
        for row, ours, right in zip(rows, answers, expected, strict=True):
            with contextlib.suppress(Exception):  # this argument is no angle, or in radians out of reach
                turned = np.asarray(reference(*row[:i], in_radians(row[i]), *row[i + 1 :]), float)
                seen.append((ours, turned, right))
        if 2 * len(seen) < len(rows):
            continue
        ours, turned, right = zip(*seen, strict=True)
        if _alike(ours, turned) and not _alike(turned, right):
            raise Wrong(f"{name} takes an angle as degrees. Angles are in radians already: do not convert them.")


def _last_in_radians(pose):
    """A pose whose pitch was taken for degrees."""
    return np.array([*pose[:-1], np.deg2rad(pose[-1])])


def _plain(middle, name: str):
    """What lies between there and back, free of SymPy's numbers, which NumPy's functions cannot take."""
    parts = middle if isinstance(middle, (list, tuple, np.ndarray)) else [middle]
    for part in np.asarray(parts, object).ravel() if isinstance(parts, np.ndarray) else parts:
        if hasattr(part, "free_symbols"):
            raise Wrong(f"what {name} returns holds SymPy's numbers, such as {part}; float(...) makes plain ones.")
    return middle


def _back(back, middle, name: str):
    """The way back, which may be the book's own: then an error there is about what it was given."""
    if getattr(back, "__name__", "") == name:
        return called(back, (middle,), name)
    try:
        return back(_copied(middle))
    except NotImplementedError as error:
        raise Wrong(f"{name} is still the TODO: write its body.") from error
    except Wrong:
        raise
    except Exception as error:
        told = hint(error) or "Has it the form that the exercise asks for?"
        raise Wrong(f"{name}: the way back stops at {_short(middle)}, {type(error).__name__}. {told}") from error


def _slip_between(middles, back, rows, name: str, unit: str, within) -> str:
    """A sentence, with a blank, if one slip in what lies between there and back explains every sample."""
    width = len(middles[0]) if isinstance(middles[0], (list, tuple)) or np.ndim(middles[0]) == 1 else 0
    places = [tuple(range(width)), *((i,) for i in range(width))] if 1 < width <= 6 else []
    which = [f"What {name} returns", *(f"Number {i + 1} that {name} returns" for i in range(width))]
    for place, what in zip(places, which, strict=False):
        for change, sentence in (
            (np.deg2rad, "looks like degrees; angles are in radians."),
            (np.negative, "has the wrong sign."),
        ):
            changed = [_changed(middle, place, change) for middle in middles]
            try:
                answers = np.array([np.asarray(back(middle), float) for middle in changed])
            except Exception:  # with this change the way back fails: it explains nothing
                continue
            if Comparison(answers, np.array(rows), unit, "", within).same(answers):
                return f"{what} {sentence} "
    return ""


def _changed(middle, places, change):
    """A row of numbers or arrays with some of them changed, in the form in which it came."""
    parts = [change(part) if i in places else part for i, part in enumerate(middle)]
    return np.array(parts) if isinstance(middle, np.ndarray) else type(middle)(parts)


def _alike(some, others) -> bool:
    return all(np.allclose(a, b, rtol=1e-7, atol=1e-5) for a, b in zip(some, others, strict=True))


def _of_one_shape(arrays: list[np.ndarray]) -> list[list[int]]:
    """The indices of the arrays, grouped by shape."""
    groups: dict[tuple, list[int]] = {}
    for index, array in enumerate(arrays):
        groups.setdefault(array.shape, []).append(index)
    return list(groups.values())


def _some(samples) -> list:
    samples = list(samples)
    if not samples:
        raise BadInput("`samples` must hold at least one sample: a check without any would always pass.")
    return samples


def _named(function, name: str) -> str:
    return name or getattr(function, "__name__", "your function")


def _written(arguments) -> str:
    return f"({', '.join(_short(a) for a in arguments)})"


def _short(value) -> str:
    if isinstance(value, (list, tuple, np.ndarray)):
        try:
            array = np.asarray(value)
        except ValueError:  # rows of different lengths
            return f"a {type(value).__name__} of {len(value)}"
        if array.size > MANY:
            return f"an array of shape {array.shape}"
        if array.dtype.kind in "if":
            return np.array2string(array, precision=4, suppress_small=True, separator=", ").replace("\n", "")
    text = f"{value:.4g}" if isinstance(value, float) else " ".join(repr(value).split())
    return text if len(text) <= LONG else f"a {type(value).__name__}"
