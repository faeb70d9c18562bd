"""One peer, measured in this process against ours: `python -m tests.bench.peer NAME` prints what it found as JSON.

Started by `rivalry.py` with the Python of the peer's own environment; the options are those of `Task`.
"""

import contextlib
import importlib
import json
import os
import sys
import time
import traceback
from dataclasses import asdict, dataclass

from tests.bench import machine
from tests.bench.peers import PEERS
from tests.bench.peers.contest import Contest
from tests.bench.timing import laps, nanoseconds, ratio, touch

#: How work on a single configuration or pose is called; all other work is on batches.
ONE = ", one"


@dataclass(frozen=True)
class Task:
    """What to measure: batches of `rows`, about `seconds` for each race, no pass longer than `longest_s`.

    `processors`: how many this process may use; 0 is all.
    """

    rows: tuple[int, ...]
    seconds: float
    longest_s: float
    processors: int = 0


def measure(name: str, task: Task) -> dict:
    """Everything that was found out about one peer: versions, races, and what was left out and why."""
    if task.processors:
        os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[: task.processors])
    module = importlib.import_module(f"tests.bench.peers.{PEERS[name].module}")
    found = {"versions": machine.versions(PEERS[name].packages), "races": [], "left_out": []}
    for work, contest in module.WORK.items():
        sizes = (1,) if work.endswith(ONE) else task.rows
        grow(work, contest, sizes, task, found)
    return found


def grow(work, contest, sizes, task: Task, found: dict) -> None:
    """Add to `found` a race for each number of rows, until one would take too long or results are not the same."""
    slowest_ns = max((line["ns"] for one in found["races"] if one["work"] == f"{work[:2]}, one"
                      for line in one["results"]), default=0.0)  # fmt: skip
    for rows in sizes:
        if slowest_ns * rows > task.longest_s * 1e9:
            told = f"{work}, {rows:,} rows and more: one pass would take about {slowest_ns * rows / 1e9:.1f} s"
            found["left_out"].append(told)
            return
        try:
            entered = contest(rows)
        except Exception as error:  # whatever a peer does must not end the report
            place = traceback.extract_tb(error.__traceback__)[-1].name
            found["left_out"].append(f"{work}, {rows:,} rows: {type(error).__name__}: {error} (in {place})")
            return
        touch(rows)
        record = _raced(entered, task.seconds)
        found["races"].append({"work": work, "rows": rows, **record})
        slowest_ns = max(line["ns"] for line in record["results"])


def _raced(contest: Contest, seconds: float) -> dict:
    """A race as plain data.

    `ratio` is to the first of all, `to_ours` to the fastest of ours with no more threads, `to_c` to ours in C.
    """
    everyone = [*contest.limits, *contest.ours, *filter(None, [contest.in_c]), *contest.theirs]
    times = laps(everyone, 75, seconds)
    lines = []
    for contender in everyone:
        line = {"name": contender.name, "threads": contender.threads, "ns": nanoseconds(times, contender)}
        line |= {"ratio": ratio(times, contender, everyone[0]), "theirs": contender in contest.theirs}
        if contender in contest.theirs:
            equals = {c.name: ratio(times, contender, c) for c in contest.ours if c.threads <= contender.threads}
            best = max(equals, key=equals.get)
            line |= {"best": best, "to_ours": equals[best]}
            if contest.in_c is not None:
                line["to_c"] = ratio(times, contender, contest.in_c)
        lines.append(line)
    return {"gap": contest.gap, "results": lines}


def main(arguments: list[str]) -> int:
    name, options = arguments[0], json.loads(arguments[1])
    start = time.perf_counter()
    with contextlib.redirect_stdout(sys.stderr):  # the answer alone goes to the standard output
        found = measure(name, Task(**{**options, "rows": tuple(options["rows"])}))
    print(json.dumps({**found, "seconds": time.perf_counter() - start}))
    return 0


def command(python, name: str, task: Task) -> list[str]:
    """The command line that measures `name` with this Python."""
    return [str(python), "-m", "tests.bench.peer", name, json.dumps(asdict(task))]


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
