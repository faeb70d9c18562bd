"""Prints the table."""

import os
import platform
import sys
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from tests.bench.contenders import in_c, many, one_at_a_time
from tests.bench.timing import FINE, Result, race


def machine() -> str:
    """Processor, cores, load, and the versions that matter."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text().splitlines() if info.exists() else []
    model = next((line.split(":")[1].strip() for line in lines if line.startswith("model name")), platform.processor())
    load = f", load {os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else ""
    parts = [f"{model or platform.machine()}, {os.cpu_count()} cores{load}; Python {platform.python_version()}"]
    for package in ("numpy", "pin"):
        try:
            parts.append(f"{package} {version(package)}")
        except PackageNotFoundError:
            parts.append(f"no {package}")
    return ", ".join(parts)


def show(title: str, results: list[Result]) -> None:
    print(f"\n{title:51} {'ns':>9} {'ratio':>7}  {'expected':10} verdict")
    for number, result in enumerate(results):
        if number and result.ratio is None:
            print()
        ratio = "" if result.ratio is None else f"{result.ratio:.2f}x"
        line = f"  {result.contender.name:49} {result.ns:9.1f} {ratio:>7}  {result.expected:10} {result.verdict}"
        print(line.rstrip())


def main(arguments: list[str]) -> int:
    if arguments not in ([], ["--quick"]):
        print("usage: python -m tests.bench [--quick]", file=sys.stderr)
        return 2
    rounds, count = (15, 1_000_000) if arguments else (75, 1_000_000)
    kind = "processor" if FINE else "wall clock"
    print(f"{machine()}\nMedians of {kind} times over {rounds} rounds in which all take turns.")
    print("Each ratio is to the first row of its group, taken within a round.", flush=True)
    few_in_c, many_in_c = in_c(count)
    if not few_in_c:
        print("No C compiler was found: the rows in C are left out.")
    show("one at a time", race(one_at_a_time(few_in_c), rounds))
    results = race([*many(count), *many_in_c], rounds // 5)
    show(f"batches of {count:,}, ns a row", results)
    print(NOTES)
    return 0


NOTES = """
Ratios travel between machines; nanoseconds do not, so the two rows that are judged by them may fail on a slow one.
pinocchio's forwardKinematics leaves its result in C++ memory. Reading four numbers out of it into Python takes
longer than computing them; omx.pose returns them, so it is compared with both (the second time with that row)."""


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
