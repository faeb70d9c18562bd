"""The whole benchmark in one run: `python -m tests.bench --report [--quick]` writes build/bench/report.md and .png."""

import os
import tempfile
import time
from datetime import UTC, datetime
from pathlib import Path

from book.setup.paths import ROOT
from tests.bench import batches, browsing, chapters, figure, joints, machine, maps, markdown, rivalry
from tests.bench.sheet import FULL, QUICK, Section, Size, duration

FOLDER = ROOT / "build" / "bench"
PACKAGES = ("numpy", "cffi", "matplotlib", "jupyterlab", "sphinx")

DISTURBED = "what is timed by the clock on the wall (two threads, jax, sampling, chapters, sliders) is longer for it"


def report(quick: bool = False, folder: Path = FOLDER) -> Path:
    """Measure everything, write the report and its figure to `folder`; the path of the report."""
    start, before, watch = time.perf_counter(), machine.load(), machine.Watch()
    sections = list(measured(QUICK if quick else FULL))
    took = duration(time.perf_counter() - start)
    what = "a small version (--quick); the limits at 10,000,000 rows are not judged" if quick else "everything"
    facts = [("When", f"{datetime.now(UTC):%Y-%m-%d %H:%M} UTC, in {took}"), ("What", what), *about(before, watch)]
    folder.mkdir(parents=True, exist_ok=True)
    figure.drawn([panel for section in sections for panel in section.panels], folder / "report.png")
    path = folder / "report.md"
    path.write_text(markdown.written(facts, sections, "report.png"), encoding="utf-8")
    return path


def about(before: float | None, watch: machine.Watch) -> list[tuple[str, str]]:
    """The machine: what it is, and how much of it we had."""
    others = watch.others()
    disturbed = "unknown" if others is None else f"took {others:.0%} of the processors' time meanwhile; {DISTURBED}"
    threads = (
        f"one for each contender unless its name says otherwise; {machine.allowed()} of the cores may be used; "
        "a peer that is told its number is pinned to as many"
    )
    return [
        ("Processor", f"{machine.processor()}, {os.cpu_count()} cores, {machine.memory()} of memory"),
        ("Threads", threads),
        ("Memory", "inputs touched before; results in new memory each time, as in use"),
        ("Load", f"{_number(before)} before, {_number(machine.load())} after; means of a minute, this run included"),
        ("Other work", disturbed),
        ("System", machine.system()),
        ("Versions", ", ".join(machine.versions(PACKAGES))),
        ("Times", "medians over rounds in which all take turns; every ratio is taken within a round"),
    ]


def measured(size: Size):
    """One family after the other."""
    for family in (batches, rivalry, joints, maps):
        yield _told(family.__name__, lambda family=family: family.measure(size))
    with tempfile.TemporaryDirectory(prefix="omx-bench-") as scratch:
        copy = chapters.copied(Path(scratch) / "book")
        yield _told("chapters", lambda: chapters.measure(size, copy))
        built = copy / "build" / "site" if size.whole else browsing.THERE
        yield _told("pages", lambda: browsing.measure(size, built))


def _told(name: str, measure) -> Section:
    """A section, and a line on the screen when it is done."""
    print(f"{name.split('.')[-1]} ...", end=" ", flush=True)
    start = time.perf_counter()
    section = measure()
    print(f"{time.perf_counter() - start:.0f} s", flush=True)
    return section


def _number(load: float | None) -> str:
    return "unknown" if load is None else f"{load:.1f}"
