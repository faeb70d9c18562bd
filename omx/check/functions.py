"""Checks of a function that a student wrote: called on samples, compared with what must hold for them."""

import inspect
import re

import numpy as np

from ..arm import HOME, LIMITS, ZERO
from ..errors import BadInput, Wrong
from .answers import compare, correct
from .validation import answer, as_numbers, present

#: Half the step of the central differences; it balances rounding against curvature, error about 1e-8.
STEP = 1e-5


def function(function, reference, samples, name: str = "", unit: str = "", parts: str = "", within=None) -> None:
    """`function(*sample)` must equal `reference(*sample)` for every sample (a tuple of arguments, or one argument).

    `unit` and `parts` describe the result, as in `value`. Raises `Wrong`, naming the first sample that fails.
    """
    name = _named(function, name)
    rows = [_arguments(sample) for sample in _some(samples)]
    expected = [np.asarray(reference(*row), float) for row in rows]
    answers = [_shaped(called(function, row, name), want, name) for row, want in zip(rows, expected, strict=True)]
    _degrees_taken(answers, reference, rows, expected, name)

    def example(index):
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
    answers = []
    for row in rows:
        middle = called(there, (row,), name)
        answers.append(_shaped(called(back, (middle,), name), row, name))

    def where(index):
        return f"{_short(rows[index])} comes back as {_short(answers[index])}."

    compare(np.array(answers), np.array(rows), name, unit, parts, within, where)
    correct(f"{name}, there and back at {len(rows)} samples")


def derivative(derivative, function, samples, name: str = "", within: float = 1e-6) -> None:
    """`derivative(q)`, (m, n), must be the slope of `function(q)`, (m,), by central differences. Raises `Wrong`."""
    name = _named(derivative, name)
    rows = [np.asarray(sample, float) for sample in _some(samples)]
    expected = [_differences(function, row) for row in rows]
    answers = [_shaped(called(derivative, (row,), name), want, name) for row, want in zip(rows, expected, strict=True)]
    scale = max(1.0, max(float(np.abs(e).max()) for e in expected))

    def where(index):
        wrong = np.abs(answers[index] - expected[index]) > within * scale
        entries = ", ".join(f"[{', '.join(map(str, place))}]" for place in np.argwhere(wrong).tolist()[:3])
        return f"At q = {_short(rows[index])} look at the entries {entries}, counted from 0."

    compare(np.array(answers), np.array(expected), name, within=within * scale, where=where)
    correct(f"{name}, against differences at {len(rows)} samples")


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
        raise Wrong(f"{name} stops with {type(error).__name__}: {error}. {hint}".rstrip()) from error
    present(result, f"what {name} returns")
    return result


def _copied(argument):
    """A copy of numbers, in whatever lists or tuples they come; everything else as it is."""
    if isinstance(argument, (list, tuple)) and type(argument) in (list, tuple):
        return type(argument)(map(_copied, argument))
    return np.copy(argument) if isinstance(argument, np.ndarray) else argument


def _hint(error: Exception, function, arguments) -> str:
    text = str(error)
    if "ellipsis" in text:
        return "Something that it uses is still the TODO."
    if isinstance(error, NameError):
        found = re.search(r"'(\w+)'", text)
        if found and hasattr(np, found[1]):
            return f"Did you mean np.{found[1]}?"
        return "Is the name spelt as it was defined, and has that cell been run?"
    if isinstance(error, TypeError) and not _takes(function, len(arguments)):
        return f"It is called with {len(arguments)} argument{'s' * (len(arguments) != 1)}."
    if isinstance(error, TypeError) and ("scalar" in text or "0-dim" in text or "real number" in text):
        return "math.cos and its kin take one number; did you mean np.cos?"
    if isinstance(error, TypeError) and "no callable" in text:
        return "NumPy's functions cannot take symbols; did you mean sp.cos?"
    return f"It was called with {_written(arguments)}."


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
            raise Wrong(f"{name} must return {_count(wanted)}; it returned {array.size if array.ndim else 'one'}.")
        raise Wrong(f"{name} must return an array of shape {wanted.shape}; it returned shape {array.shape}.")
    return array


def _degrees_taken(answers, reference, rows, expected, name: str) -> None:
    """`Wrong` if the function is right for an argument in degrees: it converts what is in radians already."""
    for i in range(len(rows[0])):
        try:
            turned = [np.asarray(reference(*row[:i], np.deg2rad(row[i]), *row[i + 1 :]), float) for row in rows]
        except Exception:  # this argument is no angle; whatever the reference says about it, the next may be
            continue
        if _alike(answers, turned) and not _alike(turned, expected):
            raise Wrong(f"{name} takes an angle as degrees. Angles are in radians already: do not convert them.")


def _alike(some: list, others: list) -> bool:
    return all(np.allclose(a, b, rtol=1e-9, atol=1e-9) for a, b in zip(some, others, strict=True))


def _of_one_shape(arrays: list[np.ndarray]) -> list[list[int]]:
    """The indices of the arrays, grouped by shape."""
    groups: dict[tuple, list[int]] = {}
    for index, array in enumerate(arrays):
        groups.setdefault(array.shape, []).append(index)
    return list(groups.values())


def _differences(function, q: np.ndarray) -> np.ndarray:
    columns = []
    for j in range(len(q)):
        step = np.zeros(len(q))
        step[j] = STEP
        columns.append((np.asarray(function(q + step), float) - np.asarray(function(q - step), float)) / (2 * STEP))
    return np.stack(columns, axis=-1)


def _some(samples) -> list:
    samples = list(samples)
    if not samples:
        raise BadInput("`samples` must hold at least one sample: a check without any would always pass.")
    return samples


def _arguments(sample) -> tuple:
    return sample if isinstance(sample, tuple) else (sample,)


def _named(function, name: str) -> str:
    return name or getattr(function, "__name__", "your function")


def _count(array: np.ndarray) -> str:
    return f"{array.size} numbers" if array.ndim else "one number"


def _written(arguments) -> str:
    return f"({', '.join(_short(a) for a in arguments)})"


def _short(value) -> str:
    if isinstance(value, (list, tuple, np.ndarray)):
        array = np.asarray(value)
        if array.dtype.kind in "if":
            return np.array2string(array, precision=4, suppress_small=True, separator=", ").replace("\n", "")
    return f"{value:.4g}" if isinstance(value, float) else repr(value)
