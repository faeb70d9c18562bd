"""Prints the table, or writes the report."""

import argparse
import sys

from tests.bench.contenders import in_c, many, one_at_a_time
from tests.bench.machine import describe
from tests.bench.timing import FINE, Result, race

COUNT = 1_000_000


def show(title: str, results: list[Result]) -> None:
    print(f"\n{title:51} {'ns':>9} {'ratio':>7}  {'expected':10} verdict")
    for number, result in enumerate(results):
        if number and result.ratio is None:
            print()
        ratio = "" if result.ratio is None else f"{result.ratio:.2f}x"
        line = f"  {result.contender.name:49} {result.ns:9.1f} {ratio:>7}  {result.expected:10} {result.verdict}"
        print(line.rstrip())


def table(rounds: int) -> None:
    """The short table: one configuration at a time, and batches of a million."""
    kind = "processor" if FINE else "wall clock"
    print(f"{describe()}\nMedians of {kind} times over {rounds} rounds in which all take turns.")
    print("Each ratio is to the first row of its group, taken within a round.", flush=True)
    few_in_c, many_in_c = in_c(COUNT)
    if not few_in_c:
        print("No C compiler was found: the rows in C are left out.")
    show("one at a time", race(one_at_a_time(few_in_c), rounds))
    results = race([*many(COUNT), *many_in_c], rounds // 5)
    show(f"batches of {COUNT:,}, ns a row", results)
    print(NOTES)


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="python run.py bench", description="How fast is it? Prints a short table.")
    parser.add_argument("--report", action="store_true", help="measure everything, also against other libraries and the"
                        " book itself, and write build/bench/report.md with a figure (about 8 minutes)")  # fmt: skip
    parser.add_argument("--quick", action="store_true", help="fewer rounds; with --report a small version (a minute)")
    parser.add_argument("--gpu", action="store_true", help="JAX, PyTorch and CuPy on this machine's graphics processor")
    options = parser.parse_args(arguments)
    if options.gpu:
        from tests.bench import gpu

        return gpu.main()
    if options.report:
        from tests.bench.report import report

        print(f"The report is {report(options.quick)}")
    else:
        table(15 if options.quick else 75)
    return 0


NOTES = """
Ratios travel between machines; nanoseconds do not, so the row that is judged by them may fail on a slow one.
pinocchio's forwardKinematics leaves its result in C++ memory. Reading four numbers out of it into Python takes
longer than computing them; omx.pose returns them, so it is compared with both (the second time with that row)."""


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
