"""The one error of the checks, and the tests that any answer must pass before it is compared."""

import numpy as np

from ..errors import Wrong


def present(answer, name: str) -> None:
    """Raise `Wrong` for what a TODO leaves behind: `...`, None or NotImplemented."""
    if answer is Ellipsis or answer is NotImplemented:
        raise Wrong(f"{name} is still the TODO: put your own answer in its place.")
    if answer is None:
        raise Wrong(f"{name} is None. Is there a value, or does the function lack its `return` line?")


def as_numbers(answer, name: str) -> np.ndarray:
    """`answer` as a float64 array, finite throughout; `Wrong` says what else it is."""
    present(answer, name)
    if isinstance(answer, (list, tuple)):
        for entry in answer:
            present(entry, f"an entry of {name}")
    if getattr(answer, "free_symbols", None):
        symbols = ", ".join(sorted(str(s) for s in answer.free_symbols))
        raise Wrong(f"{name} still holds the symbols {symbols}; a number is wanted: put values in for them.")
    try:
        array = np.array(answer.tolist() if hasattr(answer, "tolist") else answer)
        numbers = array.astype(float) if array.dtype.kind in "iufO" else None
    except (TypeError, ValueError):
        numbers = None
    if numbers is None:
        raise Wrong(f"{name} must be made of numbers; it is {_described(answer)}.")
    if not np.isfinite(numbers).all():
        raise Wrong(f"{name} holds NaN or infinity: look for a division by zero or a root of a negative number.")
    return numbers


def as_truth(answer, name: str) -> bool:
    """`answer` as a bool; `Wrong` if it is anything else."""
    present(answer, name)
    if not isinstance(answer, (bool, np.bool_)):
        raise Wrong(f"{name} must be True or False; it is {_described(answer)}.")
    return bool(answer)


def _described(answer) -> str:
    if callable(answer):
        return "a function: call it, with its arguments in brackets"
    text = repr(answer)
    return f"{text if len(text) < 60 else text[:57] + '...'} ({type(answer).__name__})"
