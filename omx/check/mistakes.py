"""From two arrays that differ to a sentence that says which slip explains the difference."""

import math
from collections.abc import Iterator
from itertools import combinations

import numpy as np

from ..errors import listed

#: How far an answer may be off, by unit; rounding errors are far below.
WITHIN = {"mm": 1e-6, "rad": 1e-9, "deg": 1e-7}


class Comparison:
    """An answer (..., n) beside what is expected, with the units and names of its n components.

    `unit` and `parts` hold one word for all components or one word for each: `"mm mm rad"`, `"x y pitch"`.
    """

    def __init__(self, answer, expected, unit: str = "", parts: str = "", within: float | None = None):
        self.answer, self.expected = np.asarray(answer, float), np.asarray(expected, float)
        width = self.expected.shape[-1] if self.expected.ndim else 1
        self.units = _one_each(unit, width)
        self.parts = parts.split() if len(parts.split()) == width else []
        self.within = np.array([WITHIN.get(u, 1e-9) if within is None else within for u in self.units])

    def same(self, answer) -> bool:
        """Does `answer` agree with what is expected?"""
        return bool(np.all(self.agrees(answer)))

    def agrees(self, answer) -> np.ndarray:
        """Where `answer` agrees, entry by entry."""
        near = np.abs(answer - self.expected) <= self.within + 1e-9 * np.abs(self.expected)
        return near & np.isfinite(answer)

    def of(self, *units: str) -> np.ndarray:
        """A mask (n,) of the components in these units."""
        return np.array([unit in units for unit in self.units])

    def slip(self) -> str:
        """The first slip that explains the whole difference, as a sentence; empty if none does."""
        with np.errstate(all="ignore"):
            for corrected, sentence in self._slips():
                if self.same(corrected):
                    return sentence
        return ""

    def _slips(self) -> Iterator[tuple[np.ndarray, str]]:
        yield from _units(self)
        yield from _matrices(self)
        yield from _components(self)
        a, angle = self.answer, self.of("rad", "deg")
        quarter = np.where(self.of("deg"), 90.0, math.pi / 2)
        if angle.any():
            yield np.where(angle, quarter - a, a), "That is 90 deg minus the angle wanted: taken from the other axis."
        yield np.sqrt(a), "That is the square of what is wanted: the root is missing."
        yield -a, "The sign is wrong."
        yield from _factor(self)

    def close(self) -> str:
        """A sentence for an answer that is only a rounding away; empty otherwise."""
        off = float(np.max(np.abs(self.answer - self.expected)))
        if (
            self.answer.ndim == 0
            and 1 <= off < 3
            and np.array_equal(np.round(self.answer), self.answer)
            and not any(self.units)
        ):
            return f"That is off by {off:.0f}: count once more, and round to the nearest."
        scale = float(np.max(np.abs(self.expected))) or 1.0
        if off < 1e-3 * scale:
            return f"That is close, but off by {off:.1e}: keep all digits, and round only when you print."
        return ""

    def wrong_parts(self) -> str:
        """Which components are right and which are not, if they have names: `y is wrong; x is right`."""
        if not self.parts:
            return ""
        right = self.agrees(self.answer).reshape(-1, len(self.parts)).all(axis=0)
        good = [p for p, ok in zip(self.parts, right, strict=True) if ok]
        bad = [p for p, ok in zip(self.parts, right, strict=True) if not ok]
        if not good:
            return ""
        return f"{_listed(bad)} wrong; {_listed(good)} right."

    def furthest(self) -> str:
        """Which of many numbers is furthest away, and by how much; of one number only to which side."""
        if not self.answer.ndim:
            return f"It is too {'large' if self.answer > self.expected else 'small'}."
        off = np.abs(self.answer - self.expected)
        place = np.unravel_index(np.argmax(off), off.shape)
        by = f"{off[place]:.3g} {self.units[place[-1] % len(self.units)]}".rstrip()
        rows = f" of row {place[0]}" if len(place) > 1 else ""
        entry = f"{self.name(place[-1])}{rows}" if self.parts else f"Entry [{', '.join(map(str, place))}]"
        return f"{entry} is furthest away, by {by}."

    def name(self, index: int) -> str:
        """The name of one component, to begin a sentence with."""
        return self.parts[index] if self.parts else f"Number {index + 1}"


def _units(c: Comparison) -> Iterator[tuple[np.ndarray, str]]:
    a, off = c.answer, ~c.agrees(c.answer)
    if c.of("rad").any():
        yield (
            np.where(c.of("rad") & off, np.deg2rad(a), a),
            ("These look like degrees; angles are in radians (math.radians or np.deg2rad converts)."),
        )
    if c.of("deg").any():
        yield np.where(c.of("deg") & off, np.rad2deg(a), a), "These look like radians; degrees are wanted (np.rad2deg)."
    if c.of("mm").any():
        yield np.where(c.of("mm") & off, 1000 * a, a), "This looks like metres; lengths are in mm."
        yield np.where(c.of("mm") & off, a / 1000, a), "This is 1000 times too large: the lengths were in mm already."
    if c.of("rad", "deg").any():
        turn = np.where(c.of("deg"), 360.0, math.tau)
        whole = np.where(c.of("rad", "deg"), np.round((a - c.expected) / turn), 0.0)
        yield (
            a - whole * turn,
            (
                "The direction is right, but an angle is a full turn off; bring it into (-pi, pi], "
                "for instance with math.remainder(angle, math.tau)."
            ),
        )


def _factor(c: Comparison) -> Iterator[tuple[np.ndarray, str]]:
    """One factor that is missing everywhere, or too many; of one number alone that would be no slip."""
    told = np.abs(c.expected) > 1e-9 * np.max(np.abs(c.expected), initial=0)
    if told.sum() < 2 or np.ptp(np.abs(c.expected[told])) == 0:
        return
    ratio = float(np.median(c.answer[told] / c.expected[told]))
    if math.isfinite(ratio) and ratio > 0 and abs(math.log(ratio)) > 1e-3:
        times, way = (ratio, "large") if ratio > 1 else (1 / ratio, "small")
        yield (
            c.answer / ratio,
            f"All of it is {times:.4g} times too {way}: a factor is missing, or there is one too many.",
        )


def _matrices(c: Comparison) -> Iterator[tuple[np.ndarray, str]]:
    a, shape = c.answer, c.answer.shape
    if len(shape) < 2 or shape[-1] != shape[-2] or c.parts:
        return
    yield np.swapaxes(a, -1, -2), "Rows and columns are exchanged: this is the transpose of what is wanted."
    try:
        yield np.linalg.inv(a), "This is the inverse of what is wanted: check from which frame to which it goes."
    except np.linalg.LinAlgError:
        return


def _components(c: Comparison) -> Iterator[tuple[np.ndarray, str]]:
    a = c.answer
    width = a.shape[-1] if a.ndim else 1
    if a.ndim == 0 or not 2 <= width <= 6:
        return
    for i, j in combinations(range(width), 2):
        swapped = a.copy()
        swapped[..., [i, j]] = a[..., [j, i]]
        yield swapped, f"{c.name(i)} and {c.name(j)} are swapped."
    for i in range(width):
        flipped = a.copy()
        flipped[..., i] *= -1
        yield flipped, f"{c.name(i)} has the wrong sign."
    for unit in dict.fromkeys(c.units):
        group = c.of(unit)
        if 1 < group.sum() < width:
            names = _listed([c.name(i) for i in np.flatnonzero(group)]).removesuffix(" are")
            yield np.where(group, -a, a), f"{names} have the wrong sign."


def _one_each(words: str, width: int) -> list[str]:
    found = words.split() or [""]
    if len(found) not in (1, width):
        raise ValueError(f"a check with {width} components needs 1 or {width} units; got {words!r}.")
    return found * width if len(found) == 1 else found


def _listed(names: list[str]) -> str:
    return f"{listed(names)} {'is' if len(names) == 1 else 'are'}"
