"""The one error of the checks, and the tests that any answer must pass before it is compared."""

import numpy as np

from ..errors import Wrong

#: SymPy's classes in a reader's words.
KINDS = {
    "Expr": "SymPy expression",
    "Basic": "SymPy expression or number",
    "MatrixBase": "SymPy matrix, sp.Matrix(...)",
}


def present(answer, name: str) -> None:
    """Raise `Wrong` for what a TODO leaves behind: `...`, None or NotImplemented."""
    if answer is Ellipsis or answer is NotImplemented:
        raise Wrong(f"{name} is still the TODO: put your own answer in its place.")
    if answer is None:
        raise Wrong(f"{name} is None. Is there a value, or does the function lack its `return` line?")


def answer(value, gives=None, name: str = "the answer"):
    """The answer `value` itself if it is what `gives` says, for checks that look at its properties; else `Wrong`.

    `gives` is a shape: () for one number, (4,) for four, (None, 3) for any number of rows of three; or a type such as
    `bool` or `Chain`; or None for anything that is not a TODO. Numbers come back as float or as a plain array.
    """
    present(value, name)
    if gives is bool:
        return as_truth(value, name)
    if isinstance(gives, type):
        if not isinstance(value, gives) or getattr(value, "is_Relational", False):
            kind = KINDS.get(gives.__name__, gives.__name__)
            raise Wrong(f"{name} must be {_article(kind)}; it is {described(value)}.")
        return value
    if gives is None:
        return np.asarray(value) if isinstance(value, np.matrix) else value
    numbers = as_numbers(value, name)
    fits = len(numbers.shape) == len(gives) and all(g in (None, n) for g, n in zip(gives, numbers.shape, strict=True))
    if not fits:
        raise Wrong(f"{name} must be {counted(gives)}; yours is {counted(numbers.shape)}.")
    return float(numbers) if gives == () else numbers


def _article(word: str) -> str:
    return f"{'an' if word[0].lower() in 'aeiou' else 'a'} {word}"


def counted(shape: tuple, what: str = "number") -> str:
    """A shape in words: `one number`, `3 numbers`, `of shape any x 3`."""
    if shape == ():
        return f"one {what}"
    if len(shape) == 1:
        return f"{'a row of' if shape[0] is None else shape[0]} {what}s"
    return f"of shape {' x '.join('any' if n is None else str(n) for n in shape)}"


def as_numbers(answer, name: str) -> np.ndarray:
    """`answer` as a float64 array, finite throughout; `Wrong` says what else it is."""
    present(answer, name)
    if isinstance(answer, (list, tuple)):
        for entry in answer:
            present(entry, f"an entry of {name}")
    held = answer if isinstance(answer, (list, tuple)) else [answer]
    if symbols := sorted({str(symbol) for entry in held for symbol in getattr(entry, "free_symbols", ())}):
        wanted = "numbers are wanted" if held is answer else "a number is wanted"
        raise Wrong(f"{name} still holds the symbols {', '.join(symbols)}; {wanted}: put values in for them.")
    try:
        array = np.array(answer.tolist() if hasattr(answer, "tolist") else answer)
        numbers = array.astype(float) if array.dtype.kind in "iufO" else None
    except (TypeError, ValueError, OverflowError):
        numbers = None
    if numbers is None:
        raise Wrong(f"{name} must be made of numbers; it is {described(answer)}.")
    if not np.isfinite(numbers).all():
        raise Wrong(f"{name} holds NaN or infinity: look for a division by zero or a root of a negative number.")
    return numbers


def as_truth(answer, name: str) -> bool:
    """`answer` as a bool; `Wrong` if it is anything else."""
    present(answer, name)
    if not isinstance(answer, (bool, np.bool_)):
        raise Wrong(f"{name} must be True or False; it is {described(answer)}.")
    return bool(answer)


def described(answer) -> str:
    """What an answer of the wrong kind is, and how to get what it holds."""
    if callable(answer):
        return "a function: call it, with its arguments in brackets"
    if getattr(answer, "is_Relational", False):
        return f"the equation {shortened(str(answer))}: give its right-hand side, `.rhs`"
    text = f"{shortened(repr(answer))} ({type(answer).__name__})"
    if isinstance(answer, (list, tuple)) and any(hasattr(entry, "free_symbols") for entry in answer):
        return f"{text}: [0] takes its first entry, sp.Matrix makes a matrix of it"
    return text


def shortened(text: str, most: int = 60) -> str:
    """The text on one line, of at most so many letters."""
    text = " ".join(text.split())
    return text if len(text) <= most else text[: most - 3] + "..."
