"""Hand out a chapter's exercises, and mark what comes back.

    python -m book.chapters.grading assign 03 --course FOLDER [--open] [--hidden FOLDER]
    python -m book.chapters.grading grade 03 --course FOLDER
    python -m book.chapters.grading marks --course FOLDER

`assign` writes FOLDER/release/03-....ipynb, to be handed out: its checks say only whether an answer is there; with
`--open` they say everything. It tries the full checks first: the book's solution must pass, an empty sheet and
nonsense must not. Collect answers in FOLDER/submitted/STUDENT/, under any name. `grade` writes marks-03-....csv and a
page of feedback for each student, and `marks` the totals over all chapters, for Moodle and Canvas, too.
"""

import argparse
import ast
import concurrent.futures
import contextlib
import json
import os
import secrets
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import time
from pathlib import Path

from book.chapters import marks, normalise
from book.chapters.cells import headings, is_code, source, tags
from book.chapters.student import POINTS, bound, grade_id, nth, sheet_cells, slug, student_copy, title
from book.setup import names
from book.setup.paths import ROOT, VENV, Stop

CELL_TIMEOUT_S, STUDENT_TIMEOUT_S = 30, 600
POLL_S, AT_ONCE = 0.02, 2
GRADER = Path(__file__).with_name("grader.py")
SUPPORT = ("configurations", "variant", "call", "answer", "student")


# ---- handing out -------------------------------------------------------------------------------------------


def assign(chapter, course, hidden=None, thin=True):
    """Write the course's sheet of a chapter, and the grader's key; the sheet's path. Raises `Stop`."""
    notebook = normalise.read(chapter)
    key = key_of(notebook, hidden_tests(chapter.stem, notebook, hidden))
    validate(key, notebook)
    sheet = course / "release" / chapter.name
    for folder in (sheet.parent, course / "key", course / "submitted"):
        folder.mkdir(parents=True, exist_ok=True)
    normalise.write(sheet, student_copy(notebook, thin))
    (course / "key" / f"{chapter.stem}.json").write_text(json.dumps(key, indent=1), encoding="utf-8")
    return sheet


def hidden_tests(name, notebook, folder):
    """{exercise: code} of a folder of hidden tests. Raises `Stop` for a folder or file that belongs to nothing."""
    if folder is None:
        return {}
    place = Path(folder, name)
    if not place.is_dir():
        raise Stop(f"There is no folder {place} with hidden tests.")
    known = [slug(title(source(cell))) for cell in notebook["cells"] if "exercise" in tags(cell)]
    files = sorted(path for path in place.iterdir() if not path.name.startswith((".", "__")))
    if unknown := [path.name for path in files if path.suffix != ".py" or path.stem not in known]:
        raise Stop(f"{place} holds {', '.join(unknown)}, but the exercises are {', '.join(known)} (each with .py).")
    if not files:
        raise Stop(f"{place} holds no hidden tests.")
    return {path.stem: path.read_text(encoding="utf-8") for path in files}


def key_of(notebook, hidden):
    """What the grader needs: the chapter's cells with TODOs, and of each exercise its answers and its criteria."""
    cells = normalise.normalise(notebook)["cells"]
    todos = {cell["id"]: cell for cell in sheet_cells(cells, thin=False)}
    exercises, answers = [], []
    for cell in cells:
        if "exercise" in tags(cell):
            name, answers, checks = title(source(cell)), [], 0
        elif "solution" in tags(cell) and is_code(cell):
            answers += bound(source(cell))
        elif "check" in tags(cell):
            checks += 1
            extra = hidden.get(slug(name), "") if checks == 1 else ""
            used = {node.id for node in ast.walk(ast.parse(source(cell) + "\n" + extra)) if isinstance(node, ast.Name)}
            exercises.append({"name": slug(name) + nth(checks), "title": name, "points": POINTS, "check": cell["id"],
                              "answers": [n for n in dict.fromkeys(answers) if n in used] or answers,
                              "statements": [*statements(source(cell)), *statements(extra)]})  # fmt: skip
    return {
        "title": next(text for cell in cells for _, text in headings(cell)),
        "chapter": [{"id": c["id"], "role": role(c), "source": source(todos[c["id"]])} for c in cells
                    if is_code(c) and c["id"] in todos],
        "graded": {grade_id(cell): name for name, cell in todos.items() if grade_id(cell)},
        "exercises": exercises,
    }  # fmt: skip


def role(cell):
    return next((tag for tag in ("solution", "check") if tag in tags(cell)), "given")


def statements(code):
    """[source, does it check something?] for each statement of a check; if none does, all of it together does."""
    found = [[ast.unparse(node), is_criterion(node)] for node in ast.parse(code).body]
    return found if any(counts for _, counts in found) or not found else [[code, True]]


def is_criterion(node):
    if isinstance(node, (ast.Assign, ast.FunctionDef, ast.Import, ast.ImportFrom)):
        return False
    calls = [n.func.attr for n in ast.walk(node) if isinstance(n, ast.Call) and isinstance(n.func, ast.Attribute)
             and isinstance(n.func.value, ast.Name) and n.func.value.id == "check"]  # fmt: skip
    return any(name not in SUPPORT for name in calls) or any(isinstance(n, ast.Assert) for n in ast.walk(node))


def validate(key, notebook):
    """The solution must meet every criterion; an empty sheet and nonsense must not, in any exercise. Raises `Stop`."""
    solutions = {cell["id"]: source(cell) for cell in notebook["cells"] if "solution" in tags(cell)}
    sheets = {"solution": [], "empty": [], "nonsense": []}
    for cell in key["chapter"]:
        texts = {"empty": cell["source"], "solution": solutions.get(cell["id"], cell["source"])}
        junk = nonsense(texts["solution"]) if cell["role"] == "solution" else cell["source"]
        for kind in sheets:
            sheets[kind].append({"id": cell["id"], "source": texts.get(kind, junk)})
    with tempfile.TemporaryDirectory() as folder:
        library = copied_library(Path(folder))
        reports = {kind: run_one(key, cells, "", library, []) for kind, cells in sheets.items()}
    for exercise in key["exercises"]:
        results = {kind: report.of(exercise["name"]) for kind, report in reports.items()}
        counted = [number for number, (_, counts) in enumerate(exercise["statements"]) if counts]
        for number in counted:
            if not results["solution"].get(number, (False, ""))[0]:
                said = results["solution"].get(number, (False, "it was not reached"))[1]
                raise Stop(f"{exercise['title']}: the book's own solution does not pass: {said}")
        free = {n for n in counted for kind in ("empty", "nonsense") if results[kind].get(n, (False,))[0]}
        if not set(counted) - free:
            raise Stop(f"{exercise['title']}: its check accepts an empty sheet, or 0.0 for every answer.")
        exercise["counted"] = sorted(set(counted) - free)


def nonsense(code):
    """0.0 for every answer of a solution, and functions that always return it."""
    functions = {node.name for node in ast.parse(code).body if isinstance(node, ast.FunctionDef)}
    return "\n".join(f"{n} = lambda *_, **__: 0.0" if n in functions else f"{n} = 0.0" for n in bound(code))


# ---- one student -------------------------------------------------------------------------------------------


class Report:
    """What the grader's process said: criteria, cells that stopped, tampering."""

    def __init__(self):
        self.criteria, self.stopped, self.tampered, self.skipped = {}, {}, [], []

    def of(self, exercise):
        """{number of the statement: (met, what was said)}."""
        return {number: result for (name, number), result in self.criteria.items() if name == exercise}

    def take(self, line):
        if "exercise" in line:
            self.criteria[line["exercise"], line["number"]] = (line["passed"], line["said"])
        elif "stopped" in line:
            self.stopped[line["stopped"]] = line["said"]
        elif "tampered" in line and line["said"] not in self.tampered:
            self.tampered.append(line["said"])


def run_one(key, cells, student, library, forbidden):
    """Run one submission, in a process of its own, as often as it takes to get past cells that end or hang it."""
    skip, began = [], time.monotonic()
    while True:
        report, done, at = run_once(key, cells, student, library, forbidden, skip)
        report.skipped = skip
        if done:
            return report
        if not at or at in skip or time.monotonic() - began > STUDENT_TIMEOUT_S:
            report.tampered.append("the run ended before its results were complete")
            return report
        skip.append(at)


def run_once(key, cells, student, library, forbidden, skip):
    """(report, did it reach its end?, the cell or criterion at which it did not)."""
    report, nonce, at, seen = Report(), secrets.token_hex(16), "", time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        scratch = Path(folder, "work")
        scratch.mkdir()
        results = Path(tempfile.mkdtemp(dir=folder), secrets.token_hex(8))
        results.touch()
        secret = [str(ROOT), str(results.parent), "/proc", *map(str, forbidden)]
        job = {"chapter": key["chapter"], "exercises": key["exercises"], "student": cells, "skip": skip,
               "nonce": nonce, "results": str(results), "library": str(library), "packages": packages(),
               "forbidden": {"roots": secret, "except": [str(VENV), str(library), str(GRADER)],
                             "libraries": [str(library), *packages()]}}  # fmt: skip
        process = subprocess.Popen([sys.executable, "-I", "-S", "-B", str(GRADER)], cwd=scratch, stdin=subprocess.PIPE,
                                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, close_fds=True,
                                   env=variables(scratch, student), start_new_session=True)  # fmt: skip
        process.stdin.write(json.dumps(job).encode())
        process.stdin.close()
        try:
            read, done, ended, lines = 0, False, False, []
            while not done and not ended and time.monotonic() - seen < CELL_TIMEOUT_S:
                ended = process.poll() is not None
                with contextlib.suppress(OSError):  # a student may have taken the file away
                    lines = results.read_bytes().split(b"\n")[:-1]
                for line in parsed(lines[read:], nonce, report):
                    at, seen = line.get("at", at), time.monotonic()
                    done = done or "done" in line
                    report.take(line)
                read = len(lines)
                time.sleep(0 if done or ended else POLL_S)
        finally:
            stop(process)
    return report, done, at


def parsed(lines, nonce, report):
    """The lines that the grader wrote; others are somebody else's, and that is said."""
    for line in lines:
        try:
            found = json.loads(line)
            if secrets.compare_digest(found["nonce"], nonce):
                yield found
                continue
        except (ValueError, KeyError, TypeError):
            pass
        report.take({"tampered": True, "said": "somebody wrote into the grader's results"})


def stop(process):
    """End the process and all that it started."""
    if os.name == "posix":
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, 9)
    else:
        process.kill()
    process.wait()


def variables(scratch, student):
    kept = {name: os.environ[name] for name in ("PATH", "LANG", "SYSTEMROOT", "TEMP") if name in os.environ}
    return {**kept, "HOME": str(scratch), "OMX_STUDENT": student, "OMX_VIEW": "static", "MPLBACKEND": "Agg",
            "MPLCONFIGDIR": str(scratch), "OMX_GENERATED": str(scratch / "generated"), "PYTHONHASHSEED": "0",
            "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}  # fmt: skip


def packages():
    """The folders of the installed packages, without links to this book."""
    return list(dict.fromkeys(sysconfig.get_path(name) for name in ("purelib", "platlib")))


def copied_library(folder):
    """A copy of `omx` away from the chapters and their solutions; the folder that holds it."""
    shutil.copytree(ROOT / "omx", folder / "omx", ignore=shutil.ignore_patterns("__pycache__"))
    return folder


# ---- a round -----------------------------------------------------------------------------------------------


def grade(name, course):
    """Mark every submission of a chapter: rows (dicts) in the order of the roster, also written as CSV."""
    path = course / "key" / f"{name}.json"
    if not path.exists():
        raise Stop(f"{name} was not assigned in {course}: `grading assign {name[:2]} --course ...` comes first.")
    key, rules = json.loads(path.read_text(encoding="utf-8")), marks.Rules(course)
    best, rows = sum(rules.points(exercise) for exercise in key["exercises"]), []
    with tempfile.TemporaryDirectory() as folder, concurrent.futures.ThreadPoolExecutor(AT_ONCE) as pool:
        library = copied_library(Path(folder))
        waiting = students(course, rules)
        results = pool.map(lambda one: marked(key, name, *one, course, library, rules), waiting)
        for (student, _), result in zip(waiting, results, strict=True):
            rows.append({"student": student, "of": best, "notes": "", **result})
            print(f"{student}: {result.get('marks', '')} {result['notes']}".rstrip(), flush=True)
    marks.write(course / f"marks-{name}.csv", rows)
    return rows


def students(course, rules):
    """(name, folder or file, None where there is nothing) of all on the roster, then of others who handed in."""
    there = {}
    for path in sorted((course / "submitted").iterdir()):
        if path.is_dir() or path.suffix.lower() == ".ipynb":
            there[path.stem if path.is_file() else path.name] = path
        elif not path.name.startswith("."):
            print(f"{path.name} in submitted/ is neither a folder nor a notebook: left out.")
    known = [*rules.roster, *(name for name in there if name not in rules.roster)]
    return [(name, there.get(name)) for name in known]


def marked(key, name, student, place, course, library, rules):
    """The marks of one student, one exercise a column, and notes; blank marks where nothing could be graded."""
    notes = [] if not rules.roster or student in rules.roster else ["not on the roster"]
    path, said = found(place, key, name)
    notes += [said] if said else []
    if path is None:
        return {"notes": "; ".join(notes)}
    try:
        cells, mended = submission(path, key)
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        return {"notes": "; ".join([*notes, f"not graded: {reason(error)}"])}
    report = run_one(key, cells, student, library, [course])
    points = {e["name"]: score(e, report, rules) for e in key["exercises"]}
    late = rules.late(name, student, path)
    total = round(sum(points.values()) * late.factor, 2)
    notes += [*mended, *(f"flagged: {what}" for what in report.tampered), *late.notes, *skipped(report, key)]
    feedback = course / "feedback" / name
    feedback.mkdir(parents=True, exist_ok=True)
    page = marks.feedback(key, student, report, points, rules, late, total, mended)
    (feedback / f"{student}.md").write_text(page, encoding="utf-8")
    return {"marks": total, **points, "notes": "; ".join(notes)}


def reason(error):
    """Why a submission could not be graded, in words."""
    if isinstance(error, OSError):
        return "it cannot be read"
    return "it is not a notebook" if isinstance(error, ValueError) else "it is a notebook of another format, or damaged"


def score(exercise, report, rules):
    """Points: the share of the criteria that are met; 0 where only those are met that an empty sheet meets, too."""
    met = [n for n, (passed, _) in report.of(exercise["name"]).items() if passed]
    criteria = [n for n, (_, counts) in enumerate(exercise["statements"]) if counts]
    share = len(met) / len(criteria) if set(met) & set(exercise["counted"]) else 0.0
    return round(rules.points(exercise) * share, 2)


def skipped(report, key):
    names = {cell: name for name, cell in key["graded"].items()}
    places = dict.fromkeys(place.split("/")[0] for place in report.skipped)
    return [f"{names.get(place, 'a cell')}: did not come to an end, or ended the program" for place in places]


def found(place, key, name):
    """(the notebook of this chapter among what a student handed in, or None; what is to be said about it)."""
    if place is None:
        return None, "nothing handed in"
    paths = [place] if place.is_file() else [p for p in sorted(place.rglob("*")) if p.suffix.lower() == ".ipynb"]
    paths = [path for path in paths if ".ipynb_checkpoints" not in path.parts]
    fits = sorted((held, path.stat().st_mtime, path) for path in paths if (held := ids_in(path, key)))
    best = [path for _, _, path in fits]
    if not best:
        broken = [path for path in paths if path.stem.startswith(name[:2])]
        others = [] if place.is_file() else [p.name for p in sorted(place.rglob("*")) if passed_over(p, name)]
        but = f" but {', '.join(others)}: the notebook itself is wanted" if others else ""
        return (broken[0], "") if broken else (None, f"nothing handed in{but}")
    said = [] if best[-1].name == f"{name}.ipynb" else [f"graded: {best[-1].name}"]
    said += [f"{len(best)} notebooks of this chapter; the fullest and newest counts"] if len(best) > 1 else []
    return best[-1], "; ".join(said)


def passed_over(path, name):
    """Is this a file that may hold the chapter, though not as a notebook: an archive, a page, a text?"""
    return path.is_file() and (path.suffix.lower() == ".zip" or path.name.startswith(name[:2]))


def ids_in(path, key):
    """(answers that are no TODO any more, graded cells of the chapter) in a notebook; None if it holds none."""
    todos = {cell["id"]: cell["source"] for cell in key["chapter"] if cell["role"] == "solution"}
    try:
        held = {known(cell, key): "".join(cell["source"]) for cell in read(path)["cells"]}
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return None
    answered = sum(held.get(place, todo).strip() != todo.strip() for place, todo in todos.items())
    return (answered, len(held.keys() - {None})) if held.keys() - {None} else None


def read(path):
    """The notebook's JSON, with or without a byte order mark."""
    return json.loads(path.read_text(encoding="utf-8-sig"))


def known(cell, key):
    """The id, in the chapter, of a graded cell: by the grader's mark, or else by the cell's own id."""
    name = key["graded"].get(grade_id(cell))
    return name or (cell.get("id") if cell.get("id") in key["graded"].values() else None)


def submission(path, key):
    """([{"id", "source"}, ...] of what is run, what was mended) of a student's notebook."""
    notebook, notes, cells = read(path), [], []
    own = {cell["id"]: cell for cell in key["chapter"]}
    twice = {}
    for number, cell in enumerate(notebook["cells"]):
        place = known(cell, key)
        if place is None and cell["cell_type"] != "code":
            continue
        name = place or (cell.get("id") if own.get(cell.get("id"), {}).get("role") == "given" else f"extra-{number}")
        twice[name] = twice.get(name, 0) + bool(place)
        if place in own and cell["cell_type"] != "code":
            notes.append(f"{label(place, key)}: was turned to {cell['cell_type']}")
        text = cell["source"] if isinstance(cell["source"], str) else "".join(cell["source"])
        cells.append({"id": name, "source": text})
    notes += [f"{label(name, key)}: is there {n} times; the last one counts" for name, n in twice.items() if n > 1]
    missing = [name for name in key["graded"].values() if name not in twice and name in own]
    notes += [f"{label(name, key)}: was deleted" for name in missing]
    return last_checks(cells, key), notes


def label(place, key):
    return next(name for name, cell in key["graded"].items() if cell == place)


def last_checks(cells, key):
    """The cells without all but the last copy of each check, since answers are taken where it stands."""
    checks, seen, kept = {e["check"] for e in key["exercises"]}, set(), []
    for cell in reversed(cells):
        if not (cell["id"] in checks and cell["id"] in seen):
            kept.append(cell)
        seen.add(cell["id"])
    return kept[::-1]


def main(argv=None):
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("what", choices=("assign", "grade", "marks"))
    parser.add_argument("chapter", nargs="?", help="such as 03")
    parser.add_argument("--course", type=Path, required=True, metavar="FOLDER", help="outside the book's own folder")
    parser.add_argument("--hidden", type=Path, metavar="FOLDER", help="more tests, for `assign`")
    parser.add_argument("--open", action="store_true", help="`assign`: a sheet whose checks say everything")
    options = parser.parse_args(argv)
    course = Path(os.path.abspath(options.course))
    try:
        if course.is_relative_to(ROOT):
            raise Stop("Put the course's folder outside the book's own.")
        if options.what == "marks":
            print(*marks.totals(course), sep="\n")
            return 0
        if not options.chapter:
            raise Stop(f"`grading {options.what}` wants a chapter, such as 03.")
        chapter = names.chapter(options.chapter)
        if options.what == "assign":
            print(assign(chapter, course, options.hidden, thin=not options.open))
        else:
            grade(chapter.stem, course)
    except (Stop, OSError) as error:
        print(f"grading: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
