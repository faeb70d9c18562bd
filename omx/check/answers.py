"""Checks of one answer: numbers, an expression, a truth."""

import dis
import math
import re

import numpy as np

from ..errors import Wrong
from .mistakes import Comparison
from .validation import as_numbers, as_truth, counted, described, present


def value(answer, expected, name: str = "the answer", unit: str = "", parts: str = "", within=None) -> None:
    """The number, truth or array `answer` must be `expected`, to rounding or to `within` (in `unit`).

    `unit` ("mm", "rad", "deg", or "") and `parts` (names of the components) hold one word, or one for each
    component: `unit="mm mm rad", parts="x y pitch"`. Raises `Wrong`.
    """
    if isinstance(expected, (bool, np.bool_)):
        if as_truth(answer, name) != bool(expected):
            raise Wrong(f"{name} is not {bool(answer)}. Try one case by hand and look.")
    else:
        compare(as_numbers(answer, name), expected, name, unit, parts, within)
    correct(name)


def that(condition, complaint: str, name: str = "") -> None:
    """The property `condition` must hold (be True, not only true-ish); otherwise `Wrong(complaint)`."""
    if not as_truth(condition, name or "this property"):
        raise Wrong(" ".join(complaint.split()))
    correct(name)


def expression(answer, expected, name="the expression", ranges: dict | None = None, parts: str = "") -> None:
    """The SymPy expression or matrix `answer` must equal `expected` for all values of its symbols.

    It does not matter how either is written: both are evaluated at values of all sizes and signs where `expected` is
    real, so that `sqrt(1 - sin(t)**2)` is no cosine, and `asin(sin(t))` no `t`. `ranges`, {symbol: (low, high)},
    narrows what "all" means; `parts` names the entries, as in `value`. Raises `Wrong`.
    """
    from ..derive import evaluated, real_points  # SymPy only for those who bring an expression

    present(answer, name)
    _an_expression(answer, name)
    shape, wanted = getattr(answer, "shape", ()), getattr(expected, "shape", ())
    if shape != wanted:
        raise Wrong(f"{name} must be {counted(wanted, 'value')}; yours is {counted(shape, 'value')}.")
    known = set(getattr(expected, "free_symbols", set()))
    foreign = _foreign_symbols(answer, known, name)
    at, theirs = real_points(expected, sorted(known | set(foreign), key=str), ranges)
    try:
        ours = evaluated(answer, at)
    except (TypeError, NameError):
        raise Wrong(f"{name} cannot be evaluated: something in it is not a number when its symbols are.") from None
    comparison = Comparison(*_reals(ours, theirs), parts=parts, within=1e-9)
    if comparison.same(comparison.answer):
        return correct(name)
    if foreign:
        names = ", ".join(sorted(map(str, known)))
        only = f"it depends on {names} only" if names else "it is the same for all values"
        raise Wrong(f"{_named(name)} must not contain {foreign[0]}; {only}.")
    absent = ", ".join(sorted(map(str, known - getattr(answer, "free_symbols", set()))))
    told = [f"It does not contain {absent}: is that meant?"] if absent else []
    raise Wrong(" ".join((_not_right(name), *told, *_differs(comparison, at, ours, theirs, shape))))


#: What a sheet's functions raise as long as nobody has written their body.
STILL_TO_DO = "is still to do: replace this line by your own."


def handed_in(**answers) -> None:
    """Are the answers there? Whether they are right is looked at after they are handed in. Raises `Wrong`."""
    for name, answer in answers.items():
        present(... if _only_raises_todo(getattr(answer, "__code__", None)) else answer, name)
    print(f"There: {', '.join(answers)}. Whether it is right, you hear when it is marked.")


def _only_raises_todo(code) -> bool:
    """Is this the code of a function that still has the sheet's `raise`, and nothing that it returns?"""
    if not any(isinstance(part, str) and STILL_TO_DO in part for part in getattr(code, "co_consts", ())):
        return False
    return not any(step.opname in ("RETURN_VALUE", "RETURN_CONST") for step in dis.get_instructions(code))


def compare(answer: np.ndarray, expected, name: str, unit: str = "", parts: str = "", within=None, where=None) -> None:
    """Raise `Wrong` with the best sentence if two arrays differ; `where(row)` adds a sentence on that sample."""
    expected = np.asarray(expected, float)
    if answer.shape != expected.shape:
        raise Wrong(f"{name} must be {counted(expected.shape, 'value')}; yours is {counted(answer.shape, 'value')}.")
    comparison = Comparison(answer, expected, unit, parts, within)
    if comparison.same(answer):
        return
    sentence = comparison.slip() or comparison.close() or comparison.wrong_parts()
    example = where(int(np.argwhere(~comparison.agrees(answer))[0][0])) if where else ""
    sentence = sentence or ("" if where else comparison.furthest())
    raise Wrong(" ".join(s for s in (_not_right(name), sentence, example) if s))


def _not_right(name: str) -> str:
    """`x and y of the tip are not right.`, with the verb that the name asks for."""
    head = re.split(r",| of | in | at | which | where ", name)[0]
    many = " and " in head or re.search(r"\b(two|three|four|five|angles|tips|stops|numbers|signs|points)\b", head)
    return f"{_named(name)} {'are' if many else 'is'} not right."


def _named(name: str) -> str:
    """The name, to go on a sentence with: an addition to it ends with a comma, too."""
    name = name.rstrip(" ,")
    return f"{name}," if "," in name else name


#: What the check cell that runs has said already; `notebook` empties it before each cell.
said: set[str] | None = None
#: What is wrong with the answers that it reads, before any look at them: `notebook` knows which cells have stopped.
older = ""


def correct(name: str) -> None:
    """The one line that a check prints when all is well; a cell that checks the same ten times says it once."""
    if older:
        raise Wrong(older)
    line = f"Correct: {name.rstrip(' ,')}." if name else "Correct."
    if said is None or line not in said:
        print(line)
    if said is not None:
        said.add(line)


def _an_expression(answer, name: str) -> None:
    """`Wrong` unless `answer` is a number, an expression or a matrix of expressions."""
    numbers = isinstance(answer, (int, float)) and not isinstance(answer, bool)
    if getattr(answer, "is_Relational", False) or (not numbers and not hasattr(answer, "free_symbols")):
        raise Wrong(f"{name} must be a SymPy expression or matrix; it is {described(answer)}.")


def _foreign_symbols(answer, known: set, name: str) -> list:
    """The symbols of `answer` that are not `known`; `Wrong` if one only looks like a known one."""
    names, foreign = {str(s) for s in known}, sorted(getattr(answer, "free_symbols", set()) - known, key=str)
    for symbol in foreign:
        if str(symbol) in names:
            raise Wrong(
                f"{name} uses another {symbol} than the chapter's: to SymPy, symbols with other assumptions are "
                f"other symbols. Use the {symbol} that is already defined."
            )
    return foreign


def _reals(*values: np.ndarray) -> list[np.ndarray]:
    """Complex values (points, entries) as reals, or all as (points, 2 entries) where some are not real."""
    real = all(np.all(np.isnan(v) | (np.abs(v.imag) <= 1e-12 * (1 + np.abs(v)))) for v in values)
    return [v.real if real else v.astype(complex).view(float) for v in values]


def _differs(comparison: Comparison, at: list[dict], ours, theirs, shape=()) -> list[str]:
    """Sentences on how an expression of this shape differs from the one wanted, at the points `at`."""
    if not np.isfinite(ours).any(axis=0).all():
        return ["It is infinite or undefined for ordinary values: look for a division by zero."]
    agree = np.isfinite(ours) & (np.abs(ours - theirs) <= 1e-9 * (1 + np.abs(theirs)))
    point, entry = np.argwhere(~agree)[0]
    where = ", ".join(f"{symbol} = {value:.4g}" for symbol, value in at[point].items())
    what = _entry(int(entry), shape, comparison.parts)
    what = f"at {where} {what}" if where else what
    gives = _written(ours[point, entry])
    if where or not comparison.parts:
        what = what[0].upper() + what[1:]
    example = f"{what} is {gives}; {_written(theirs[point, entry])} is wanted."
    slip = comparison.slip()
    if len(shape) == 2 and shape[0] == shape[1] > 1:
        turned = (
            ours.reshape(-1, *shape).swapaxes(1, 2).reshape(ours.shape) if ours.shape[1] == math.prod(shape) else ours
        )
        slip = "Rows and columns are exchanged: this is the transpose." if np.allclose(turned, theirs) else slip
    if not slip and 0.2 < agree.all(axis=1).mean() < 1:  # fewer are special points, where many things agree
        slip = "It is right for some values only: a root or an inverse function forgets a sign or a turn."
    return [slip, example] if slip else [example]


def _entry(entry: int, shape: tuple, parts: list[str]) -> str:
    """An entry of a matrix by its name, or by its place; `it` for the only one."""
    if parts:
        return parts[entry]
    if len(shape) == 2 and 1 not in shape:
        return f"row {entry // shape[1] + 1}, column {entry % shape[1] + 1}"
    return f"entry {entry + 1}" if math.prod(shape) > 1 else "it"


def _written(value: complex) -> str:
    if not np.isfinite(value):
        return "not defined"
    return f"{value.real:.6g}" if abs(value.imag) <= 1e-12 * (1 + abs(value)) else f"{value:.6g}, not a real number"
