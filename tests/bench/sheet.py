"""What a family of measurements hands to the report: tables, expectations met or not, and curves for the figure."""

from dataclasses import dataclass, field
from typing import NamedTuple

AS_EXPECTED, NOT_AS_EXPECTED = "as expected", "NOT as expected"


@dataclass(frozen=True)
class Size:
    """How much to measure. `seconds`: about as long lasts one race; `longest_s`: no pass of a peer takes longer.

    `rows` of our batches and `peer_rows` of the others'; `joints` of planar arms; `steps`: cells of maps (mm);
    `presses` of a slider's key. `whole`: make environments, run every chapter, build the site.
    """

    rows: tuple[int, ...]
    peer_rows: tuple[int, ...]
    joints: tuple[int, ...]
    steps: tuple[float, ...]
    seconds: float
    longest_s: float
    presses: int
    whole: bool


FULL = Size((10_000, 100_000, 1_000_000, 10_000_000), (1000, 10_000, 1_000_000, 10_000_000), (2, 4, 8, 16, 32, 64),
            (8.0, 4.0, 2.0, 1.0), 4.0, 2.5, 45, True)  # fmt: skip
QUICK = Size((10_000, 100_000), (1000,), (2, 8, 32), (4.0, 1.0), 0.2, 0.25, 3, False)


class Table(NamedTuple):
    """`title`, the `head` and the `rows` of text."""

    title: str
    head: tuple[str, ...]
    rows: list[tuple[str, ...]]


class Expectation(NamedTuple):
    """`what` was expected to keep to `limit`, and what was `measured`."""

    what: str
    limit: str
    measured: str
    holds: bool

    @property
    def verdict(self) -> str:
        return AS_EXPECTED if self.holds else NOT_AS_EXPECTED


class Panel(NamedTuple):
    """One drawing: `lines`, name -> points (x, y), on logarithmic axes; or bars, if `bars`, name -> length.

    `x` and `y` are the titles of the axes, with units; `limit`, if not None, is drawn as a line and named.
    """

    title: str
    x: str
    y: str
    lines: dict
    bars: dict
    limit: float | None = None
    limit_name: str = "expected at most"


@dataclass
class Section:
    """A family's part of the report. `left_out`: what was not measured, each with the reason."""

    title: str
    prose: str
    tables: list[Table] = field(default_factory=list)
    expectations: list[Expectation] = field(default_factory=list)
    left_out: list[str] = field(default_factory=list)
    panels: list[Panel] = field(default_factory=list)


def times(value: float) -> str:
    """A ratio, to three digits."""
    return f"{value:,.0f}x" if value >= 100 else f"{value:.3g}x"


def duration(seconds: float) -> str:
    """A time, to three digits, in the unit that fits."""
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("us", 1e-6)):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}" if seconds / size < 100 else f"{seconds / size:.0f} {unit}"
    return f"{seconds * 1e9:.3g} ns"


def at_most(what: str, measured: float, limit: float, unit: str = "x") -> Expectation:
    """The expectation that a number stays within its limit."""
    return Expectation(what, f"<= {limit:g}{unit}", f"{measured:.3g}{unit}", measured <= limit)
