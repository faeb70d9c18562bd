"""Which of Pieper's patterns a DH table has, or why none, and its closed inverse written as a module."""

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from itertools import product
from types import ModuleType

import sympy as sp

from ..arrays import shown
from ..dh import Chain, DHRow, as_chain, exact_transform
from ..errors import BadInput, listed
from . import pieper
from .function import Function
from .store import write
from .symbolic import exact

#: A length below this share of the table's longest is 0: 0.1 - 0.3 + 0.2 is meant to be.
TINY = sp.Float(1e-12)

SLANTING = (
    "axes 4, 5 and 6 meet in one point, as Pieper asks, but not at right angles: such a hand cannot be turned "
    "everywhere, and its wrist is not written here"
)


@dataclass(frozen=True)
class Pattern:
    """What `pattern` found: falsy if none. `str` of it is the reason, in a sentence.

    `name`: `spherical wrist`, `three parallel axes`, `shoulder and plane`, `all axes parallel`, or `none`. `axes`: the
    numbers of the axes that make it so. `branches`: their names, in the order of the module's answers.
    """

    name: str
    reason: str
    axes: tuple[int, ...] = ()
    branches: tuple[str, ...] = ()
    functions: Callable[[], list[Function]] | None = field(default=None, repr=False, compare=False)

    def __bool__(self) -> bool:
        return self.functions is not None

    def __str__(self) -> str:
        return self.reason


def pattern(chain: Chain) -> Pattern:
    """Which of Pieper's patterns, or of their smaller relatives for fewer joints, a table has; or why none.

    Twists must be numbers; lengths may be symbols, which then stand for any value but 0. Raises `BadInput`.
    """
    return patterns(chain)[0]


def patterns(chain: Chain) -> tuple[Pattern, ...]:
    """Every pattern of the table, for there are arms that have two; at least one, the last of which may be none."""
    rows = _rows(chain)
    if len(rows) == 6:
        return _six(rows)
    if rows.fixed:
        return (_none("with fewer than six joints, x, y, z and an angle are told in frame 0: leave base and tool off"),)
    if len(rows) <= 4 and all(_flat(row) for row in rows[:-1]):
        return (_all_parallel(rows),)
    if len(rows) in (3, 4):
        return (_shoulder_and_plane(rows),)
    return (_none(_too_few_or_many(len(rows))),)


def write_inverse(
    name: str,
    chain: Chain,
    *,
    by: Pattern | None = None,
    doc: str = "",
    notebook: str | None = None,
    folder: str | os.PathLike | None = None,
    parameters: Mapping[sp.Symbol, object] | None = None,
) -> ModuleType:
    """Write `<name>.py` and `.js` with `branches` and `missing` of a table that has a pattern; return the former.

    Entries of the rows may be numbers or SymPy expressions; `parameters` gives each symbol in them its value. `by` is
    the pattern to use, where the table has two. What the chain has as `base` and `tool` is in the formulas, not in
    `dh_rows`. The other arguments are those of `write`. Raises `BadInput`, with the reason, for a table that has none.
    """
    known = patterns(chain)
    found = known[0] if by is None else by
    if found not in known:
        raise BadInput(f"`by` must be one of the patterns of {chain.name}; got {shown(by)}.")
    if found.functions is None:
        raise BadInput(f"{chain.name} has no inverse of this kind: {found.reason}.")
    return write(
        name,
        found.functions(),
        notebook=notebook,
        folder=folder,
        doc=doc or f"Inverse kinematics of {chain.name}: {found.reason}.",
        parameters=() if parameters is None else parameters,
        rows=[exact(row) for row in chain.rows],
        branches=found.branches,
    )


def _rows(chain) -> "_Rows":
    """The rows, exact, with lengths that rounding left as nearly 0 made 0, and sines and cosines of twists known."""
    rows = [exact(row) for row in as_chain(chain).rows]
    for number, row in enumerate(rows, start=1):
        if row.alpha.free_symbols:
            raise BadInput(f"alpha of row {number} of {chain.name} is {row.alpha}; a pattern needs twists in numbers.")
    lengths = [abs(x) for row in rows for x in (row.d, row.a) if x.is_number]
    least = TINY * max(lengths, default=1)
    clean = [(x if not x.is_number or abs(x) > least else sp.Integer(0)) for row in rows for x in (row.d, row.a)]
    return _Rows(chain, [
        DHRow(row.theta, d, a, row.alpha, row.prismatic)
        for row, d, a in zip(rows, clean[::2], clean[1::2], strict=True)
    ])  # fmt: skip


class _Rows(list):
    """The rows of a table, and what is fixed around them."""

    def __init__(self, chain: Chain, rows):
        super().__init__(rows)
        self.fixed = chain.base is not None or chain.tool is not None
        self.base, self.tool = exact_transform(chain.base), exact_transform(chain.tool)


def _flat(row) -> bool:
    """Are this joint's axis and the next one parallel?"""
    return sp.sin(row.alpha) == 0


def _square(row) -> bool:
    """Are they at a right angle?"""
    return sp.cos(row.alpha) == 0


def _none(reason: str) -> Pattern:
    return Pattern("none", reason)


def _first(*rules: tuple[bool, str]) -> str:
    """What is wrong, by the first of the rules (is it broken, in words) that is broken; empty if none is."""
    return next((words for broken, words in rules if broken), "")


def _too_few_or_many(joints: int) -> str:
    if joints > 6:
        return (
            f"it has {joints} joints, and a hand needs six: where it can go, it can go in infinitely many ways; fix "
            "one joint and ask again"
        )
    return (
        f"with {joints} joints it needs axes that are all parallel, or a turn and then parallel axes (three or four "
        "joints); it has neither"
    )


# ---- six joints ----------------------------------------------------------------------------------------


def _six(rows) -> tuple[Pattern, ...]:
    wrist, parallel = _why_no_wrist(rows), _why_not_parallel(rows)
    found = [look(rows) for look, why in ((_spherical, wrist), (_parallel, parallel)) if not why]
    if found:
        return tuple(sorted(found, key=lambda one: not one))
    if wrist == SLANTING:
        return (_none(SLANTING),)
    others = _other_three(rows)
    if others:
        return (_none(f"{others}, which is Pieper's condition, but not at the wrist, where {wrist}"),)
    return (
        _none(
            f"{wrist}, and {parallel}: no three neighbouring axes meet in one point or are parallel. Such an arm may "
            "have up to 16 answers, and they need a numerical method"
        ),
    )


def _why_no_wrist(rows) -> str:
    """What keeps axes 4, 5 and 6 from meeting at right angles; empty if nothing does."""
    fourth, fifth = rows[3:5]
    return _first(
        (any(row.prismatic for row in rows[3:]), "a joint of the wrist slides"),
        (fourth.a != 0, f"axes 4 and 5 are {fourth.a} mm apart (a of row 4)"),
        (fifth.a != 0, f"axes 5 and 6 are {fifth.a} mm apart (a of row 5)"),
        (_flat(fourth), "axes 4 and 5 are parallel"),
        (_flat(fifth), "axes 5 and 6 are parallel"),
        (fifth.d != 0, f"axis 6 misses the crossing of axes 4 and 5 by {fifth.d} mm (d of row 5)"),
        (not (_square(fourth) and _square(fifth)), SLANTING),
    )


def _why_not_parallel(rows) -> str:
    """What keeps axes 2, 3 and 4 from being parallel, with a shoulder and a wrist around them; empty if nothing."""
    first, second, third, fourth, fifth = rows[:5]
    return _first(
        (any(row.prismatic for row in rows), "a joint slides"),
        (not (_flat(second) and _flat(third)), "axes 2, 3 and 4 are not parallel"),
        (second.a == 0 or third.a == 0, "two of the axes 2, 3 and 4 are one and the same"),
        (not _square(first), "axes 1 and 2 are not at a right angle"),
        (not _square(fourth), "axes 4 and 5 are not at a right angle"),
        (not _square(fifth), "axes 5 and 6 are not at a right angle"),
        (fifth.a != 0, f"axes 5 and 6 are {fifth.a} mm apart (a of row 5)"),
    )


def _other_three(rows) -> str:
    for i in (1, 2, 3):
        first, second = rows[i - 1], rows[i]
        turning = not any(row.prismatic for row in rows[i - 1 : i + 2])
        if turning and first.a == second.a == second.d == 0 and not _flat(first) and not _flat(second):
            return f"axes {i}, {i + 1} and {i + 2} meet in one point"
    for i in (1, 3, 4):
        if not any(row.prismatic for row in rows[i - 1 : i + 2]) and _flat(rows[i - 1]) and _flat(rows[i]):
            return f"axes {i}, {i + 1} and {i + 2} are parallel"
    return ""


def _spherical(rows) -> Pattern:
    """Axes 4, 5, 6 meet: turn and triangle (or slide) place the crossing, then the wrist turns the hand."""
    if why := _why_no_arm(rows):
        return _none(
            f"axes 4, 5 and 6 meet in one point, as Pieper asks, but {why}; only arms that begin with a turn, and then "
            "two links or a slide in one plane, are written here"
        )
    slide = rows[2].prismatic
    elbows = ("out", "in") if slide else ("elbow up", "elbow down")
    kind = "a turn and a slide" if slide else "a turn and a triangle"
    reason = f"axes 4, 5 and 6 meet in one point; {kind} place it, then the wrist turns the hand"
    names = _named(("front", "back"), elbows, ("no flip", "flip"))
    return Pattern("spherical wrist", reason, (4, 5, 6), names, lambda: pieper.spherical(rows))


def _why_no_arm(rows) -> str:
    first, second, third, fourth = rows[:4]
    slide, along = third.prismatic, _flat(third) or fourth.d == 0  # does row 4 go on where joint 3 leads?
    return _first(
        (first.prismatic, "joint 1 slides"),
        (second.prismatic, "joint 2 slides"),
        (not _square(first), "axes 1 and 2 are not at a right angle"),
        (slide and not (_square(second) and second.a == 0), "the slide does not pass axis 2 at a right angle"),
        (slide and not (third.a == 0 and along), "their crossing is not on the line of the slide"),
        (not slide and not _flat(second), "axes 2 and 3 are not parallel"),
        (not slide and (second.a == 0 or (third.a == 0 and along)),
         "one of the links between shoulder, elbow and wrist has no length"),
    )  # fmt: skip


def _parallel(rows) -> Pattern:
    """Axes 2, 3, 4 are parallel: the turn, then the wrist, which only needs the turn, and the triangle at last."""
    reason = "axes 2, 3 and 4 are parallel; a turn, then the wrist, and a triangle that ends where the wrist begins"
    names = _named(("front", "back"), ("elbow up", "elbow down"), ("no flip", "flip"))
    return Pattern("three parallel axes", reason, (2, 3, 4), names, lambda: pieper.parallel(rows))


def _named(*choices) -> tuple[str, ...]:
    return tuple(", ".join(words) for words in product(*choices))


# ---- fewer joints --------------------------------------------------------------------------------------


def _shoulder_and_plane(rows) -> Pattern:
    """A turn, and then two or three parallel axes: this book's arm, and its relatives."""
    number = len(rows)
    if why := _first(
        (any(row.prismatic for row in rows), "a joint slides, and not all axes are parallel"),
        (not _square(rows[0]), "axes 1 and 2 are neither parallel nor at a right angle"),
        (not all(_flat(row) for row in rows[1 : number - 1]), f"the axes from 2 to {number} are not all parallel"),
        (rows[1].a == 0 or rows[2].a == 0, "one of the links between shoulder, elbow and wrist has no length"),
    ):
        return _none(why)
    task = "x, y, z and pitch" if number == 4 else "x, y and z"
    axes = tuple(range(2, number + 1))
    reason = f"axes {listed(axes)} are parallel, at a right angle to axis 1; {task} fix all joints"
    names = _named(("front", "back"), ("elbow up", "elbow down"))
    return Pattern("shoulder and plane", reason, axes, names, lambda: pieper.shoulder_and_plane(rows))


def _all_parallel(rows) -> Pattern:
    """Every axis has one direction: planar arms, and with a slide a SCARA."""
    slides = [row for row in rows if row.prismatic]
    turning = [row for row in rows if not row.prismatic]
    if why := _first(
        (len(slides) > 1 or len(turning) not in (2, 3),
         f"all axes are parallel, {len(turning)} of them turns and {len(slides)} slides; two or three turns and one "
         "slide at most have an inverse"),
        (any(row.a != 0 for row in slides),
         "the slide shifts sideways, too (its a is not 0): add that a to the row before"),
        (any(row.a == 0 for row in turning[:2]), "two of the axes are one and the same"),
    ):  # fmt: skip
        return _none(why)
    number = len(rows)
    task = ["x, y", "z" if slides else "", "yaw" if len(turning) == 3 else ""]
    reason = f"all axes are parallel; {', '.join(filter(None, task))} fix all joints: one triangle" + (
        ", and the slide for the height" if slides else ""
    )
    names = ("elbow up", "elbow down")
    return Pattern("all axes parallel", reason, tuple(range(1, number + 1)), names, lambda: pieper.all_parallel(rows))
