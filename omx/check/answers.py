"""Checks of one answer: numbers, an expression, a truth."""

import numpy as np

from ..errors import Wrong
from .mistakes import Comparison
from .validation import as_numbers, as_truth, present

#: Points at which two expressions are compared; an identity that holds at all of them holds.
POINTS = 12


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
        raise Wrong(complaint)
    correct(name)


def expression(answer, expected, name: str = "the expression") -> None:
    """The SymPy expression or matrix `answer` must equal `expected` for all values of its symbols.

    Compared at random points, so it does not matter how either is written. Raises `Wrong`.
    """
    present(answer, name)
    if not hasattr(answer, "free_symbols") and not isinstance(answer, (int, float)):
        raise Wrong(f"{name} must be a SymPy expression or matrix; it is {answer!r} ({type(answer).__name__}).")
    shape, wanted = getattr(answer, "shape", ()), getattr(expected, "shape", ())
    if shape != wanted:
        raise Wrong(f"{name} must be {_counted(wanted)}; yours is {_counted(shape)}.")
    symbols = sorted(getattr(expected, "free_symbols", set()), key=str)
    _foreign_symbols(answer, set(symbols), name)
    random = np.random.default_rng(0)
    points = [{s: _value(s, random) for s in symbols} for _ in range(POINTS)]
    ours, theirs = _evaluated(answer, points, name), _evaluated(expected, points, name)
    compare(ours, theirs, name, within=1e-9)
    correct(name)


def compare(answer: np.ndarray, expected, name: str, unit: str = "", parts: str = "", within=None, where=None) -> None:
    """Raise `Wrong` with the best sentence if two arrays differ; `where(row)` adds a sentence on that sample."""
    expected = np.asarray(expected, float)
    if answer.shape != expected.shape:
        raise Wrong(f"{name} must be {_counted(expected.shape)}; yours is {_counted(answer.shape)}.")
    comparison = Comparison(answer, expected, unit, parts, within)
    if comparison.same(answer):
        return
    sentence = comparison.slip() or comparison.close() or comparison.wrong_parts()
    example = where(int(np.argwhere(~comparison.agrees(answer))[0][0])) if where else ""
    raise Wrong(" ".join(s for s in (f"{name} is not right.", sentence, example) if s))


def correct(name: str) -> None:
    """The one line that a check prints when all is well."""
    print(f"Correct: {name}." if name else "Correct.")


def _counted(shape: tuple[int, ...]) -> str:
    if shape == ():
        return "one value"
    if len(shape) == 1:
        return f"{shape[0]} values"
    return f"of shape {' x '.join(map(str, shape))}"


def _foreign_symbols(answer, known: set, name: str) -> None:
    names = {str(s) for s in known}
    for symbol in sorted(getattr(answer, "free_symbols", set()) - known, key=str):
        if str(symbol) in names:
            raise Wrong(
                f"{name} uses another {symbol} than the chapter's: to SymPy, symbols with other assumptions are "
                f"other symbols. Use the {symbol} that is already defined."
            )
        raise Wrong(f"{name} must not contain {symbol}; it depends on {', '.join(sorted(names)) or 'nothing'} only.")


def _value(symbol, random) -> float:
    """A value for one symbol, of either sign unless the symbol is known to be positive."""
    size = float(random.uniform(0.3, 1.3))
    sign = 1.0 if symbol.is_nonnegative else float(random.choice((-1.0, 1.0)))
    return sign * size


def _evaluated(expression, points, name: str) -> np.ndarray:
    """Values (points, entries) of an expression or matrix; real and imaginary parts where it is complex."""
    if not hasattr(expression, "evalf"):
        return np.full((len(points), 1), float(expression))
    entries = list(expression) if hasattr(expression, "shape") else [expression]
    try:
        rows = [[complex(e.evalf(subs=point)) for e in entries] for point in points]
    except (TypeError, ValueError):
        raise Wrong(f"{name} cannot be evaluated: something in it is not a number when its symbols are.") from None
    values = np.array(rows)
    if not np.isfinite(values).all():
        raise Wrong(f"{name} is infinite or undefined for ordinary values: look for a division by zero.")
    return values.real if not values.imag.any() else values.view(float)
