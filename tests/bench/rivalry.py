"""Everybody else on the same work, and who was beaten."""

from tests.bench.ask import Absent, ask, verdict
from tests.bench.peer import Task
from tests.bench.peers import PEERS
from tests.bench.sheet import Expectation, Panel, Section, Size, Table, times

PROSE = """Each peer ran in a process of its own, in turns with ours. "ours" is the fastest of ours with no more threads
than the peer. Iterative solvers find one solution and start 0.1 rad from it, in each joint; ours has nothing to
start from, and in a batch finds all four branches. EAIK has no family for this arm; it is given a fifth joint,
a roll of the hand that stays at 0. For one pose ours is Python, which takes about 10 ns for each sum or product,
EAIK is C++. "Of ours in C" is how many times as long they took as the same generated lines, compiled from C and
called through cffi: what is left then is not the language. Results were compared before anything was timed; where
they differ by more than 1e-6 mm or rad, nothing was timed."""


def measure(size: Size) -> Section:
    section = Section("Peers: the same work by others", PROSE)
    bars = {}
    for name in [name for name in PEERS if name != "omx"]:
        runs = PEERS[name].runs if size.whole else PEERS[name].runs[:1]
        try:
            found = [ask(name, Task(size.peer_rows, size.seconds / 4, size.longest_s, run), size) for run in runs]
        except Absent as absent:
            section.left_out.append(f"{name}: {absent}")
            continue
        lines = [(race, line) for one in found for race in one["races"] for line in race["results"] if line["theirs"]]
        section.left_out += [f"{name}{_with(run)}: {told}" for run, one in zip(runs, found, strict=True)
                             for told in one["left_out"]]  # fmt: skip
        section.tables.append(_table(", ".join(found[0]["versions"]), lines))
        section.expectations.append(_beaten(name, lines))
        bars |= {f"{name}, {work}": ratio for work, ratio in _closest(lines).items()}
    if bars:
        section.panels.append(Panel("Peers: at the most rows, the fastest of each", "time / time of ours", "", {},
                                    bars, 1.0, "ours"))  # fmt: skip
    return section


def _closest(lines) -> dict[str, float]:
    """For each kind of work, with the most rows that were measured, how close the peer came to ours."""
    most = {race["work"]: race["rows"] for race, _ in lines}  # they grow
    return {work: min(line["to_ours"] for race, line in lines if (race["work"], race["rows"]) == (work, rows))
            for work, rows in most.items()}  # fmt: skip


def _with(processors: int) -> str:
    return f" with {processors} thread{'s' * (processors > 1)}" if processors else ""


def _table(title, lines) -> Table:
    rows = [
        (race["work"] + ("" if race["rows"] == 1 else f" of {race['rows']:,}"), line["name"],
         line["best"], verdict(line), times(line["to_c"]) if "to_c" in line else "", f"{race['gap']:.0e}")
        for race, line in lines
    ]  # fmt: skip
    return Table(title, ("work", "how", "ours", "verdict", "of ours in C", "results differ by (mm, rad)"), rows)


def _beaten(name, lines) -> Expectation:
    """Whether we were faster at all the work; if not, where."""
    lost = [f"{race['work']} ({line['name']}) by {times(1 / line['to_ours'])}"
            for race, line in lines if line["to_ours"] <= 1.0]  # fmt: skip
    measured = f"not beaten: {'; '.join(lost)}" if lost else "beaten" if lines else "nothing was measured"
    return Expectation(name, "beaten", measured, bool(lines) and not lost)
