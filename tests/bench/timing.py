"""Ratios that a shared, noisy machine cannot spoil: contenders take turns, and each round is compared with itself."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from math import inf
from statistics import median
from typing import NamedTuple

import numpy as np

#: Seconds that one contender runs in one round: short, so that few rounds are interrupted.
SLICE = 0.002

#: The time that this thread has had a processor, where that is known well enough: others' work does not count.
FINE = time.get_clock_info("thread_time").resolution < 1e-6
clock = time.thread_time if FINE else time.perf_counter

#: Rounds that are raced however long they take: the median of fewer says little.
LEAST = 3


class Spent(NamedTuple):
    """Seconds that one call took: of this thread's processor time, and of the clock on the wall."""

    own: float
    wall: float


@dataclass(frozen=True)
class Contender:
    """Something to time: `call` does the work `count` times over (rows of a batch, or 1).

    `against` names the contender that the ratio is to; `at_most` is the ratio expected, or with `absolute`
    the nanoseconds. `threads`: how many work. `wall`: others than the calling one work for it, so the clock on the
    wall is read, for its reference as well.
    """

    name: str
    call: Callable[[], object]
    against: str = ""
    at_most: float | None = None
    absolute: bool = False
    count: int = 1
    threads: int = 1
    wall: bool = False

    @property
    def by_the_wall(self) -> bool:
        return self.wall or self.threads > 1


@dataclass(frozen=True)
class Result:
    contender: Contender
    ns: float
    ratio: float | None

    @property
    def expected(self) -> str:
        limit = self.contender.at_most
        if limit is None:
            return ""
        return f"< {limit / 1000:g} us" if self.contender.absolute else f"<= {limit:g}x"

    @property
    def verdict(self) -> str:
        if self.contender.at_most is None:
            return ""
        measured = self.ns if self.contender.absolute else self.ratio
        return "as expected" if measured <= self.contender.at_most else "NOT as expected"


def race(contenders: list[Contender], rounds: int) -> list[Result]:
    """Time every contender once a round; medians of the times, and of the ratios within each round."""
    times = laps(contenders, rounds)
    known = {contender.name: contender for contender in contenders}
    ratios = [ratio(times, c, known[c.against]) if c.against in known else None for c in contenders]
    return [Result(c, nanoseconds(times, c), r) for c, r in zip(contenders, ratios, strict=True)]


def laps(contenders: list[Contender], rounds: int, seconds: float = inf) -> dict[str, list[Spent]]:
    """What each contender spent for a unit of `count` in each round; all take turns.

    After `seconds` no further round begins, unless there were fewer than `LEAST`.
    """
    start = time.perf_counter()
    loops = {contender.name: _loops(contender) for contender in contenders}
    times = {contender.name: [] for contender in contenders}
    for number in range(rounds):
        if number >= LEAST and time.perf_counter() - start > seconds:
            break
        for contender in contenders:
            spent = _timed(contender.call, loops[contender.name])
            times[contender.name].append(Spent(spent.own / contender.count, spent.wall / contender.count))
    return times


def nanoseconds(times: dict[str, list[Spent]], contender: Contender) -> float:
    """The median of what a contender spent."""
    return median(_read(spent, contender.by_the_wall) for spent in times[contender.name]) * 1e9


def ratio(times: dict[str, list[Spent]], contender: Contender, reference: Contender) -> float:
    """How many times as long a contender took as the reference, the median over the rounds; by one clock for both."""
    wall = contender.by_the_wall or reference.by_the_wall
    pairs = zip(times[contender.name], times[reference.name], strict=True)
    return median(_read(mine, wall) / _read(theirs, wall) for mine, theirs in pairs)


def touch(rows: int) -> None:
    """Use about as much memory as a pass over `rows` needs, once: a machine is slow to hand it out the first time."""
    np.ones(rows * 40)


def _read(spent: Spent, wall: bool) -> float:
    return spent.wall if wall else spent.own


def _loops(contender: Contender) -> int:
    first = _timed(contender.call, 1)  # pays for imports, caches and memory that was never touched
    if first.wall > 50 * SLICE:
        return 1
    once = _read(_timed(contender.call, 1), contender.by_the_wall)
    return max(1, min(20_000, round(SLICE / once)))


def _timed(call: Callable[[], object], loops: int) -> Spent:
    own, wall = clock(), time.perf_counter()
    for _ in range(loops):
        call()
    return Spent((clock() - own) / loops, (time.perf_counter() - wall) / loops)
