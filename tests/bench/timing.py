"""Ratios that a shared, noisy machine cannot spoil: contenders take turns, and each round is compared with itself."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from statistics import median

#: Seconds that one contender runs in one round: short, so that few rounds are interrupted.
SLICE = 0.002

#: The time that this thread has had a processor, where that is known well enough: others' work does not count.
FINE = time.get_clock_info("thread_time").resolution < 1e-6
clock = time.thread_time if FINE else time.perf_counter


@dataclass(frozen=True)
class Contender:
    """Something to time: `call` does the work `count` times over (rows of a batch, or 1).

    `against` names the contender that the ratio is to; `at_most` is the ratio expected, or with `absolute`
    the nanoseconds.
    """

    name: str
    call: Callable[[], object]
    against: str = ""
    at_most: float | None = None
    absolute: bool = False
    count: int = 1


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
    loops = {contender.name: _loops(contender) for contender in contenders}
    times = {contender.name: [] for contender in contenders}
    for _ in range(rounds):
        for contender in contenders:
            elapsed = _timed(contender.call, loops[contender.name])
            times[contender.name].append(elapsed / contender.count * 1e9)
    return [Result(c, median(times[c.name]), _ratio(times, c)) for c in contenders]


def _ratio(times: dict[str, list[float]], contender: Contender) -> float | None:
    if contender.against not in times:
        return None
    pairs = zip(times[contender.name], times[contender.against], strict=True)
    return median(mine / theirs for mine, theirs in pairs)


def _loops(contender: Contender) -> int:
    contender.call()  # the first call pays for imports and caches
    once = _timed(contender.call, 1)
    return max(1, min(20_000, round(SLICE / once)))


def _timed(call: Callable[[], object], loops: int) -> float:
    start = clock()
    for _ in range(loops):
        call()
    return (clock() - start) / loops
