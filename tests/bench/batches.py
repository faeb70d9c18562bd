"""Our own batches, and how their cost grows with the rows: NumPy, numba and C against a copy."""

from tests.bench.ask import Absent, ask, verdict
from tests.bench.peer import Task
from tests.bench.peers.own import COPY, COPY_RESULTS, COPY_USED
from tests.bench.sheet import Expectation, Panel, Section, Size, Table, at_most, times

#: What is expected of our batches at the most rows: times as long as the copy.
LIMITS = {
    ("FK, batch", "omx.pose (NumPy)"): 12.0,
    ("FK, batch", "omx.analysis.compiled.pose (numba)"): 3.0,
    ("FK, batch", "omx.analysis.compiled.pose (numba), 2 threads"): 3.0,
    ("IK, batch", "omx.ik_batch (NumPy)"): 25.0,
    ("IK, batch", "omx.analysis.compiled.ik_batch (numba)"): 8.0,
    ("IK, batch", "omx.analysis.compiled.ik_batch (numba), 2 threads"): 8.0,
}
JUDGED_AT = 10_000_000
#: No pass of ours is left out for being long.
ANY_S = 60.0

PROSE = """Every contender returns new memory, the copy too, as in use; the memory was touched once before. The copy
moves 32 bytes in and 32 out for each row, in one thread, and is the limit for both; the inverse has to write 136,
and a copy of these is given for comparison. With two threads the clock on
the wall is read, with one the processor's time of that thread. NumPy's and C's two threads work on a half of the rows
each and do not join the results. C writes the angles of all branches, but does not say which are legal."""


def measure(size: Size) -> Section:
    """Our own batches against the copy, and against C."""
    section = Section("Batches: NumPy, numba and C against a copy", PROSE)
    try:
        found = ask("omx", Task(size.rows, size.seconds, ANY_S), size)
    except Absent as absent:
        section.left_out.append(f"numba: {absent}")
        found = ask("omx", Task(size.rows, size.seconds, ANY_S), size, here=True)
    section.left_out += found["left_out"]
    for work, title in (("FK, batch", "Forward kinematics"), ("IK, batch", "Inverse kinematics, all branches")):
        races = [race for race in found["races"] if race["work"] == work]
        section.tables.append(_batch_table(title, races))
        section.panels.append(_batch_panel(title, races))
        section.expectations += _limits(work, races)
    section.prose += f" Versions: {', '.join(found['versions'])}."
    return section


def _batch_table(title, races) -> Table:
    """A line for each contender; for each number of rows the ratio to the copy."""
    head = ("", *(f"{race['rows']:,} rows" for race in races))
    names = [line["name"] for line in races[0]["results"]]
    rows = []
    for i, name in enumerate(names):
        cells = [race["results"][i] for race in races]
        rows.append((name, *(times(c["ratio"]) for c in cells)))
    return Table(f"{title}: how many times the time of the copy", head, rows)


def _batch_panel(title, races) -> Panel:
    lines = {}
    for race in races:
        for line in race["results"]:
            if line["name"] not in (COPY, COPY_USED, COPY_RESULTS):
                lines.setdefault(line["name"], []).append((race["rows"], line["ratio"]))
    return Panel(title, "rows", "time / time of q.copy()", lines, {}, 1.0, "the copy")


def _limits(work, races):
    """Our limits hold at the most rows; a smaller report does not judge them."""
    for race in races:
        ratios = {line["name"]: line["ratio"] for line in race["results"]}
        for (limited, name), limit in LIMITS.items():
            if race["rows"] == JUDGED_AT and limited == work and name in ratios:
                yield at_most(f"{name} at {JUDGED_AT:,} rows, of the copy", ratios[name], limit)
        if race is races[-1]:
            yield from (_against_c(work, race["rows"], line) for line in race["results"] if line["theirs"])


def _against_c(work, rows, line) -> Expectation:
    what = f"{line['name']}, {work} of {rows:,} rows, against {line['best']}"
    return Expectation(what, "beaten", verdict(line), line["to_ours"] > 1.0)
