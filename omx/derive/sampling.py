"""Values of expressions at many points, so that a check can compare two of them on every branch."""

from itertools import count

import mpmath
import numpy as np
import sympy as sp

#: Points that are kept, and points that are tried to find so many at which the expression is real.
POINTS, TRIED = 36, 400
DIGITS = 30


def points(symbols, ranges: dict | None = None, seed: int = 0):
    """Endless dicts {symbol: float}: every third point has values of all sizes, the others stay within some turns.

    Values have either sign unless the symbol is known to be positive or `ranges` holds `{symbol: (low, high)}`.
    """
    random, ranges = np.random.default_rng(seed), ranges or {}
    for number in count(1):
        sizes = 10 ** random.uniform(-2, 3, len(symbols)) if number % 3 == 0 else random.uniform(0.1, 8, len(symbols))
        signs = random.choice((-1.0, 1.0), len(symbols))
        shares = random.uniform(0, 1, len(symbols))
        yield {
            symbol: float(np.interp(share, (0, 1), ranges[symbol])) if symbol in ranges else _signed(symbol, size, sign)
            for symbol, size, sign, share in zip(symbols, sizes, signs, shares, strict=True)
        }


def _signed(symbol, size: float, sign: float) -> float:
    if symbol.is_integer:
        size = float(max(1, round(size)))
    return size if symbol.is_nonnegative else -size if symbol.is_nonpositive else sign * size


def evaluated(expression, at: list[dict]) -> np.ndarray:
    """Values (points, entries), complex, of an expression, a number or a matrix; NaN where there is none.

    Computed with 30 digits, so that terms of very different size do not hide a difference. TypeError if something
    in it has no value at all when all symbols have one.
    """
    entries = [sp.sympify(e) for e in (expression if hasattr(expression, "shape") else [expression])]
    symbols = list(at[0])
    functions = [_function(symbols, entry) for entry in entries]
    with mpmath.workdps(DIGITS):
        rows = [[_value(f, point.values()) for f in functions] for point in at]
    return np.array(rows, complex).reshape(len(at), len(entries))


def _function(symbols: list, entry):
    if not isinstance(entry, sp.Expr) or entry.has(sp.core.function.AppliedUndef, sp.Derivative, sp.Integral):
        raise TypeError(f"{entry} has no value")
    if entry.has(sp.zoo, sp.nan, sp.oo, -sp.oo):
        return lambda *_: complex(np.nan)
    return sp.lambdify(symbols, entry, modules="mpmath")


def _value(function, arguments) -> complex:
    try:
        value = complex(function(*map(mpmath.mpf, arguments)))
    except (ArithmeticError, ValueError):
        return complex(np.nan)
    except TypeError as error:
        if "mpc" in str(error) or "complex" in str(error):  # an order or an atan2 of what is not real
            return complex(np.nan)
        raise
    return value if np.isfinite(value) else complex(np.nan)


def real_points(expression, symbols, ranges: dict | None = None) -> tuple[list[dict], np.ndarray]:
    """Points at which `expression` is real, and its values there; any points with a value if it is never real."""
    found: list[tuple[dict, np.ndarray]] = []
    others: list[tuple[dict, np.ndarray]] = []
    source = points(symbols, ranges)
    for _ in range(0, TRIED if symbols else 1, POINTS):
        batch = [next(source) for _ in range(POINTS if symbols else 1)]
        for point, row in zip(batch, evaluated(expression, batch), strict=True):
            if np.abs(row.imag).max(initial=0.0) <= 1e-12 * (1 + np.abs(row).max(initial=0.0)):
                found.append((point, row.real))
            elif np.isfinite(row).all():
                others.append((point, row))
        if len(found) >= POINTS:
            break
    kept = (found or others)[:POINTS]
    return [point for point, _ in kept], np.array([row for _, row in kept])
