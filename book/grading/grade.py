"""A round of grading: every submission of a chapter gets its marks and a sentence, and none costs another one its."""

import concurrent.futures
import json
import tempfile
from pathlib import Path

from book.grading import gradebook
from book.grading.student_run import copied_library, run_one
from book.grading.submissions import DAMAGED, found, submission
from book.setup.paths import Stop

AT_ONCE = 2


def grade(name, course):
    """Mark every submission of a chapter: rows (dicts) in the order of the roster, also written as CSV."""
    path = course / "key" / f"{name}.json"
    if not path.exists():
        raise Stop(f"{name} was not assigned in {course}: `grading assign {name[:2]} --course ...` comes first.")
    key, rules = json.loads(path.read_text(encoding="utf-8")), gradebook.Rules(course)
    if not all("cells" in exercise for exercise in key["exercises"]):
        raise Stop(f"{name} was assigned by an older edition of the book: `assign` it again, then grade it.")
    rules.refuse_unknown(key, name)
    best, rows = sum(rules.points(exercise) for exercise in key["exercises"]), []
    with tempfile.TemporaryDirectory() as folder, concurrent.futures.ThreadPoolExecutor(AT_ONCE) as pool:
        library = copied_library(Path(folder))
        waiting = students(course, rules)
        results = pool.map(lambda one: one_row(key, name, *one, course, library, rules), waiting)
        for (student, _), result in zip(waiting, results, strict=True):
            rows.append({"student": student, "of": best, "notes": "", **result})
            print(f"{student}: {result.get('marks', '')} {result['notes']}".rstrip(), flush=True)
    gradebook.write(course / f"marks-{name}.csv", rows)
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


def one_row(key, name, student, *more):
    """What `marked` says; where the grader itself fails at a submission, that is its note, and the round goes on."""
    try:
        return marked(key, name, student, *more)
    except Exception as error:
        return {"notes": f"not graded: the grader itself failed ({type(error).__name__}: {error}); look at it by eye"}


def marked(key, name, student, place, course, library, rules):
    """The marks of one student, one exercise a column, and notes; blank marks where nothing could be graded."""
    notes = [] if not rules.roster or student in rules.roster else ["not on the roster"]
    path, said = found(place, key, name)
    notes += [said] if said else []
    if path is None:
        return {"notes": "; ".join(notes)}
    try:
        cells, mended = submission(path, key)
    except DAMAGED as error:
        return {"notes": "; ".join([*notes, f"not graded: {reason(error)}"])}
    report = run_one(key, cells, student, library, [course])
    points = {e["name"]: score(e, report, rules) for e in key["exercises"]}
    late = rules.late(name, student, path)
    total = round(sum(points.values()) * late.factor, 2)
    notes += [*mended, *(f"flagged: {what}" for what in report.tampered), *late.notes, *skipped(report, key)]
    feedback = course / "feedback" / name
    feedback.mkdir(parents=True, exist_ok=True)
    page = gradebook.feedback(key, student, report, points, rules, late, total, mended)
    (feedback / f"{student}.md").write_text(page, encoding="utf-8", errors="backslashreplace")
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
