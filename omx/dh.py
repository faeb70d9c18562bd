"""Denavit-Hartenberg rows, and the frames of any chain made of them (standard, or distal, convention)."""

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate, repeat
from math import inf, isfinite, sin
from numbers import Real
from operator import mul
from typing import Any

import numpy as np

from .arrays import HUGE, as_rows, fill, shown
from .errors import BadInput, JointLimit, Violation

#: A constant angle or a limit beyond this (rad), a little over one turn, was meant in degrees. Limits to a little over
#: two turns are real, though, for the wrists of factory arms: only whole numbers are suspected there.
MOST_ANGLE, MOST_LIMIT = 6.3, 12.6


@dataclass(frozen=True, slots=True)
class DHRow:
    """One joint: `A = Rz(theta) Tz(d) Tx(a) Rx(alpha)`, lengths in mm, angles in rad.

    The joint's variable is *added* to `theta` (revolute) or to `d` (prismatic), so `theta` or `d` holds the
    constant offset. Entries may be numbers or SymPy expressions. A frame that is fixed in front of the first joint or
    behind the last is no row: `Chain` has `base` and `tool` for it. In a table after Craig (proximal, or modified,
    convention) a row holds a and alpha of the link before: `Chain.from_craig` reads it.
    """

    theta: Any
    d: Any
    a: Any
    alpha: Any
    prismatic: bool = False

    def at(self, q) -> tuple[Any, Any, Any, Any]:
        """`(theta, d, a, alpha)` with the joint variable `q` (rad or mm) put in."""
        if self.prismatic:
            return self.theta, self.d + q, self.a, self.alpha
        return self.theta + q, self.d, self.a, self.alpha


class Chain:
    """A serial chain of DH rows; frame 0 is the base, frame n moves with joint n and is the tool.

    Numbers go in and arrays come out; SymPy comes out where a row holds a symbol or `q` anything of SymPy's. Immutable:
    what a solution says by its chain stays true. Raises `BadInput`. Warns where two joints turn about one line, as they
    do when Craig's rows are taken for standard ones.

    Args:
        rows: one `DHRow` a joint, or (theta, d, a, alpha[, prismatic]).
        limits: one (low, high) a joint in rad (mm where prismatic), infinite where there is none; or None.
        names: one name a joint; q1, q2, ... (d3 where joint 3 is prismatic) if left out.
        name: of the arm, for messages.
        base: where frame 0 stands, seen from the frame in which all results are told, (4, 4), mm.
        tool: the tool seen from the frame at which the last row ends, (4, 4), mm; frame n then is the tool's.
    """

    rows: tuple[DHRow, ...]
    limits: tuple[tuple[float, float], ...] | None
    names: tuple[str, ...]
    name: str
    base: Any
    tool: Any

    def __init__(self, rows: Sequence[DHRow], limits=None, names=None, name: str = "chain", base=None, tool=None):
        table = as_table(rows)
        default = (f"{'d' if row.prismatic else 'q'}{i}" for i, row in enumerate(table, start=1))
        self.__dict__.update(
            rows=table,
            names=tuple(default) if names is None else _as_names(names, len(table)),
            limits=None if limits is None else as_limits(limits, len(table), [row.prismatic for row in table]),
            name=name if isinstance(name, str) else shown(name),
            base=as_transform(base, "base"),
            tool=as_transform(tool, "tool"),
        )
        for i, row in enumerate(self.rows, start=1):
            _refuse_variables(row, i, self.names)
        _suspect_craig(self)

    @classmethod
    def from_craig(cls, rows, limits=None, names=None, name: str = "chain", base=None, tool=None) -> "Chain":
        """The chain of a table after Craig (modified, or proximal, convention): `Rx(alpha) Tx(a) Rz(theta) Tz(d)`.

        Each row still is (theta, d, a, alpha[, prismatic]), whatever the order of its columns in print; its a and
        alpha are of the link *before* the joint. Here they move up by one row; those of the first row go into `base`.
        """
        rows = as_table(rows)
        following = [(row.a, row.alpha) for row in rows[1:]] + [(0, 0)]
        shifted = [DHRow(r.theta, r.d, a, alpha, r.prismatic) for r, (a, alpha) in zip(rows, following, strict=True)]
        first = cls([DHRow(0, 0, rows[0].a, rows[0].alpha)], base=base).fk([0])
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of the suspicion that this is a table after Craig
            return cls(shifted, limits, names, name, None if np.array_equal(first, np.eye(4)) else first, tool)

    def __setattr__(self, key, value):
        raise AttributeError(f"a Chain does not change; make another with the {key} that you want.")

    def __delattr__(self, key):
        raise AttributeError(f"a Chain does not change; {key} stays.")

    def __len__(self) -> int:
        return len(self.rows)

    def __repr__(self) -> str:
        return f"Chain({self.name!r}, joints {', '.join(self.names)})"

    @property
    def size(self) -> float:
        """The lengths of all rows together (mm): what is small for this arm is a share of it."""
        return float(sum(abs(float(row.d)) + abs(float(row.a)) for row in self.rows))

    def matrices(self, q):
        """The link matrices A_1 .. A_n: (..., n, 4, 4), mm; a list of SymPy matrices for symbolic input.

        The last one carries the `tool`; `base` is in none of them.
        """
        if self._is_symbolic(q):
            return self._symbolic_matrices(q)
        q = self._as_values(q)
        out = np.empty((*q.shape, 4, 4))
        for i, row in enumerate(self.numeric_rows):
            fill(out[..., i, :, :], link_rows(*row.at(q[..., i]), np.cos, np.sin))
        if self.tool is not None:
            out[..., -1, :, :] = out[..., -1, :, :] @ self.tool
        return out

    def frames(self, q):
        """T_0_0 .. T_0_n: (..., n + 1, 4, 4), mm; a list of SymPy matrices for symbolic input.

        With a `base` they are seen from where that is told: the first one is `base`, not the identity.
        """
        links = self.matrices(q)
        if isinstance(links, list):
            return list(accumulate(links, mul, initial=exact_transform(self.base)))
        out = np.empty((*links.shape[:-3], len(self.rows) + 1, 4, 4))
        out[..., 0, :, :] = np.eye(4) if self.base is None else self.base
        for i in range(len(self.rows)):
            np.matmul(out[..., i, :, :], links[..., i, :, :], out=out[..., i + 1, :, :])
        return out

    def fk(self, q):
        """T_base_tool: (..., 4, 4), mm; a SymPy matrix for symbolic input."""
        frames = self.frames(q)
        return frames[-1] if isinstance(frames, list) else frames[..., -1, :, :]

    def jacobian(self, q) -> np.ndarray:
        """The geometric Jacobian, (..., 6, n), base frame: linear rows (mm/rad; 1 where prismatic), then angular."""
        frames = self.frames(self._as_values(q))
        z, origins = frames[..., :-1, :3, 2], frames[..., :-1, :3, 3]
        slides = np.array([row.prismatic for row in self.rows])[:, None]
        swept = np.cross(z, frames[..., -1:, :3, 3] - origins)
        columns = np.concatenate([np.where(slides, z, swept), np.where(slides, 0.0, z)], axis=-1)
        return np.swapaxes(columns, -1, -2)

    def violations(self, q) -> tuple[Violation, ...]:
        """Every joint of `q` (n,) that is outside its limits; empty if all are inside, or there are none."""
        q = self._as_values(q, many=False)
        prismatic = [row.prismatic for row in self.rows]
        return limit_violations(q.tolist(), self.limits or (), self.names, prismatic=prismatic)

    def check(self, q) -> None:
        """Raise `JointLimit` if any joint of `q` (n,) is outside its limits, naming joint, value and limit."""
        violations = self.violations(q)
        if violations:
            raise JointLimit(violations, clipped(q, self.limits), self.name)

    @cached_property
    def numeric_rows(self) -> tuple[DHRow, ...]:
        """The rows as plain floats."""
        return tuple(
            DHRow(float(row.theta), float(row.d), float(row.a), float(row.alpha), row.prismatic) for row in self.rows
        )

    def _as_values(self, q, many: bool = True):
        return as_rows(q, "q", len(self.rows), f"the joint values of {self.name} in rad (mm where prismatic)", many)

    def _is_symbolic(self, q) -> bool:
        entries = [entry for row in self.rows for entry in row.at(0)]
        if any(getattr(entry, "free_symbols", None) for entry in (*entries, self.base, self.tool)):
            return True
        if isinstance(q, np.ndarray) and q.dtype.kind != "O":
            return False
        try:
            return any(hasattr(entry, "free_symbols") for entry in np.ravel(q))
        except ValueError:  # ragged, which `as_rows` explains
            return False

    def _symbolic_matrices(self, q) -> list:
        import sympy as sp  # a symbol is here already, so SymPy is

        if np.shape(q) not in ((len(self),), (len(self), 1), (1, len(self))):
            raise BadInput(f"`q` must be {len(self)} symbols or numbers, one a joint; got shape {np.shape(q)}.")
        links = [
            sp.Matrix(link_rows(*exact(row).at(as_expression(variable)), sp.cos, sp.sin))
            for row, variable in zip(self.rows, np.ravel(q).tolist(), strict=True)
        ]
        return [*links[:-1], links[-1] * exact_transform(self.tool)]


def as_chain(value, name: str = "chain", numbers: bool = False) -> Chain:
    """`value`, if it is a `Chain`, and without symbols where `numbers` are wanted; `BadInput` otherwise."""
    if not isinstance(value, Chain):
        raise BadInput(f"`{name}` must be an omx.Chain; got {shown(value)}.")
    if numbers and value._is_symbolic(np.zeros(len(value))):
        raise BadInput(f"`{name}` must hold numbers; {value!r} has symbols in it: give them values first.")
    return value


def as_table(rows) -> tuple[DHRow, ...]:
    """`rows` as `DHRow`s, one or more; `BadInput` otherwise."""
    try:
        found = tuple(_as_row(row, i) for i, row in enumerate(rows, start=1))
    except TypeError:
        raise BadInput(f"`rows` must be a list of DHRow; got {shown(rows)}.") from None
    if not found:
        raise BadInput("`rows` must hold at least one DHRow; got none.")
    return found


def as_transform(value, name: str):
    """A rigid transform (4, 4), mm, that nobody changes any more: a copy, of SymPy where it holds symbols; or None."""
    if value is None:
        return None
    wanted = f"`{name}` must be a transform (4, 4), mm, with a rotation and the last row 0, 0, 0, 1"
    if getattr(value, "free_symbols", None) and getattr(value, "shape", None) == (4, 4):
        if any(value[3, j] - int(j == 3) for j in range(4)):
            raise BadInput(f"{wanted}; its last row is {list(value[3, :])}.")
        return value.as_immutable()
    T = np.array(as_rows(value, name, 4, "a transform (4, 4), mm"))
    rigid = T.shape == (4, 4) and np.allclose(T[3], [0, 0, 0, 1]) and np.allclose(T[:3, :3].T @ T[:3, :3], np.eye(3))
    if not rigid or np.linalg.det(T[:3, :3]) < 0:
        raise BadInput(f"{wanted}; got {shown(value)} of shape {T.shape}.")
    T.flags.writeable = False
    return T


def _suspect_craig(chain: Chain) -> None:
    """Warn where neighbouring joints turn about one line as the rows stand, and none would after Craig."""
    held = [low == high for low, high in chain.limits] if chain.limits else [False] * len(chain)
    pairs = [
        (i, row, after)
        for i, (row, after) in enumerate(zip(chain.rows, chain.rows[1:], strict=False))
        if not (row.prismatic or after.prismatic or held[i] or held[i + 1])
    ]
    alike = [i for i, row, _ in pairs if _on_one_line(row)]
    if alike and not any(_on_one_line(after) for _, _, after in pairs):
        one, other = chain.names[alike[0]], chain.names[alike[0] + 1]
        warnings.warn(
            f"{chain.name}: {one} and {other} turn about one line, as these rows stand (standard convention, a and "
            "alpha of the link behind the joint). After Craig (modified convention) no two joints do: if the table is "
            "of that kind, read it with Chain.from_craig(rows).",
            stacklevel=3,
        )


def _on_one_line(row: DHRow) -> bool:
    """Does the link of this row leave the next axis where the last one is?"""
    symbols = any(getattr(entry, "free_symbols", None) for entry in (row.a, row.alpha))
    return not symbols and abs(float(row.a)) < 1e-9 and abs(sin(float(row.alpha))) < 1e-9


def _as_row(row, number: int) -> DHRow:
    try:
        row = row if isinstance(row, DHRow) else DHRow(*row)
    except TypeError:
        raise BadInput(f"row {number} must be a DHRow of numbers or SymPy expressions; got {shown(row)}.") from None
    if row.prismatic not in (True, False) or isinstance(row.prismatic, float):
        raise BadInput(
            f"the fifth entry of row {number} says whether the joint is prismatic, True or False; got "
            f"{shown(row.prismatic)}. An offset is added to theta (or d), the joint's variable is in no column."
        )
    for column in ("theta", "d", "a", "alpha"):
        entry = getattr(row, column)
        if not _is_real(entry):
            raise BadInput(
                f"row {number} must be a DHRow of numbers or SymPy expressions, finite and real; {column} is "
                f"{shown(entry)}."
            )
        if column in ("theta", "alpha") and isinstance(entry, Real) and abs(float(entry)) > MOST_ANGLE:
            raise BadInput(f"{column} of row {number} is {entry} rad, more than a turn: degrees? Use math.radians.")
    return DHRow(row.theta, row.d, row.a, row.alpha, bool(row.prismatic))


def _is_real(entry) -> bool:
    """A finite real number, or a SymPy expression that may be one."""
    if isinstance(entry, (bool, np.bool_)):
        return False
    if isinstance(entry, Real):
        return bool(abs(entry) < HUGE)  # type: ignore[operator]  # every Real has an order with floats
    if isinstance(entry, type) or not (hasattr(entry, "free_symbols") and hasattr(entry, "as_coeff_Add")):
        return False
    if entry.free_symbols:
        return entry.is_real is not False and not entry.has(1j)
    return bool(entry.is_real and entry.is_finite)


def _as_names(names, joints: int) -> tuple[str, ...]:
    try:
        found = () if isinstance(names, str) else tuple(names)
    except TypeError:
        found = ()
    good = len(found) == joints == len(set(map(str, found))) and all(isinstance(name, str) and name for name in found)
    if not good:
        raise BadInput(f"`names` must be {joints} different names, one a joint; got {shown(names)}.")
    return tuple(map(str, found))


def _refuse_variables(row: DHRow, number: int, names: Sequence[str]) -> None:
    """`BadInput` where an entry holds a joint's variable, as printed tables do: it would count twice."""
    own = "d" if row.prismatic else "theta"
    for column in ("theta", "d", "a", "alpha"):
        used = {str(symbol) for symbol in getattr(getattr(row, column), "free_symbols", ())} & set(names)
        if used and column == own and names[number - 1] in used:
            raise BadInput(
                f"{column} of row {number} holds the joint's own variable {names[number - 1]}, which is added to it "
                f"anyway: leave only the constant offset there, 0 if there is none. (A joint that turns the other way "
                f"is written with alpha of the row before, and of its own row, turned by pi.)"
            )
        if used:
            raise BadInput(
                f"{column} of row {number} holds {sorted(used)[0]}, the name of a joint's variable; give the length "
                "or angle another name, or the joints other `names`."
            )


def as_limits(limits, joints: int, prismatic: Sequence[bool] = ()) -> tuple[tuple[float, float], ...]:
    """`limits` as one `(low, high)` of floats a joint (infinite where there is none); `BadInput` otherwise."""
    wanted = f"`limits` must be {joints} pairs (low, high), low <= high, one a joint"
    try:
        pairs = tuple((_limit(low), _limit(high)) for low, high in limits)
    except (TypeError, ValueError, OverflowError):
        raise BadInput(f"{wanted}; got {shown(limits)}.") from None
    if len(pairs) != joints:
        raise BadInput(f"{wanted}; got {len(pairs)}.")
    for i, ((low, high), slides) in enumerate(zip(pairs, prismatic or repeat(False), strict=False)):
        if not low <= high or low == inf or high == -inf:
            raise BadInput(f"{wanted}; `limits`[{i}] is ({low}, {high}).")
        ends = [abs(limit) for limit in (low, high) if isfinite(limit)]
        suspected = MOST_ANGLE if all(end.is_integer() for end in ends) else MOST_LIMIT
        if not slides and max(ends, default=0.0) > suspected:
            raise BadInput(
                f"`limits`[{i}] is ({low:g}, {high:g}) rad, more than a turn: degrees? Use numpy.radians; a joint "
                "without a limit has (-inf, inf)."
            )
    return pairs


def _limit(value) -> float:
    """One limit as a float, infinity included."""
    if isinstance(value, (str, bool, np.bool_)):
        raise TypeError(value)
    return float(value)


def exact(row: DHRow) -> DHRow:
    """The row for SymPy: angles that are multiples of 15 deg exact, so that their cosines are 0, 1/2, ...

    Entries may be numbers or expressions: `delta - 1.5707963` becomes `delta - pi/2`, a length 77.0 becomes 77.
    """
    row = _as_row(row, 1)
    return DHRow(exact_angle(row.theta), _length(row.d), _length(row.a), exact_angle(row.alpha), row.prismatic)


def exact_angle(value):
    """An angle as a SymPy expression, a constant in it that is a multiple of 15 deg exact."""
    import sympy as sp

    constant, rest = sp.sympify(value, strict=True).as_coeff_Add()
    if constant.is_Float:
        steps = round(float(constant / (sp.pi / 12)))
        near = abs(float(constant - steps * sp.pi / 12)) < 1e-12
        constant = steps * sp.pi / 12 if near else constant
    return constant + rest


def as_expression(value):
    """`value` as SymPy's. `BadInput` for what is no number and no expression: text is never evaluated."""
    import sympy as sp

    try:
        expression = sp.sympify(value, strict=True)
    except (sp.SympifyError, TypeError, ValueError, AttributeError, OverflowError):
        expression = None
    if not isinstance(expression, sp.Expr):
        raise BadInput(f"an expression or a number is wanted; got {shown(value)}.")
    return expression


def _length(value):
    import sympy as sp

    value = sp.sympify(value, strict=True)
    return sp.Integer(int(value)) if value.is_Float and float(value).is_integer() else value


def limit_violations(
    q, limits, names=("q1", "q2", "q3", "q4"), slack: float = 1e-9, prismatic=None
) -> tuple[Violation, ...]:
    """One `Violation` for each value of `q` more than `slack` (rad, or mm where `prismatic`) outside its limits."""
    found = []
    for value, (low, high), name, slides in zip(q, limits, names, prismatic or repeat(False), strict=False):
        if not low - slack <= value <= high + slack:
            found.append(Violation(name, value, low if value < low else high, slides))
    return tuple(found)


def clipped(q, limits) -> tuple[float, ...]:
    """`q` with each value moved to its nearest limit where it is outside."""
    return tuple(min(max(float(value), low), high) for value, (low, high) in zip(q, limits, strict=True))


def link_rows(theta, d, a, alpha, cos, sin) -> tuple[tuple, ...]:
    """The rows of `Rz(theta) Tz(d) Tx(a) Rx(alpha)`, in the arithmetic of the given `cos` and `sin`."""
    ct, st, ca, sa = cos(theta), sin(theta), cos(alpha), sin(alpha)
    return (
        (ct, -st * ca, st * sa, a * ct),
        (st, ct * ca, -ct * sa, a * st),
        (0, sa, ca, d),
        (0, 0, 0, 1),
    )


def link_matrix(theta, d, a, alpha) -> np.ndarray:
    """The link matrix of one DH row, (4, 4), mm."""
    return np.array(link_rows(theta, d, a, alpha, np.cos, np.sin), float)


def exact_transform(T):
    """A rigid transform (4, 4) for SymPy, whole numbers in it exact; the identity for None."""
    import sympy as sp

    T = as_transform(T, "T")
    return sp.eye(4) if T is None else sp.Matrix(4, 4, lambda i, j: _length(T[i, j]))
