"""The sheet of a chapter, and the grader's key to it: what is run, and which statements of a check are criteria."""

import ast
import json
import tempfile
from pathlib import Path

from book.chapters import normalise
from book.chapters.cells import headings, is_code, source, tags
from book.chapters.student import POINTS, bound, grade_id, nth, sheet_cells, slug, student_copy, title
from book.grading.student_run import copied_library, run_one
from book.setup.paths import Stop

#: What `omx.check` offers that judges nothing by itself.
SUPPORT = ("configurations", "variant", "call", "answer", "student")

#: What a check is tried with before anything is handed out.
TRIALS = {
    "solution": "the book's own solutions, which must pass",
    "empty": "an empty sheet, which must not",
    "nonsense": "0.0 for every answer, which must not",
}


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
    todos, thin = ({cell["id"]: cell for cell in sheet_cells(cells, thin)} for thin in (False, True))
    exercises, answers, places = [], [], []
    for cell in cells:
        if "exercise" in tags(cell):
            name, answers, places, checks = title(source(cell)), [], [], 0
        elif "solution" in tags(cell) and is_code(cell):
            answers += bound(source(cell))
            places.append(cell["id"])
        elif "check" in tags(cell):
            checks += 1
            extra = hidden.get(slug(name), "") if checks == 1 else ""
            used = {node.id for node in ast.walk(ast.parse(source(cell) + "\n" + extra)) if isinstance(node, ast.Name)}
            exercises.append({"name": slug(name) + nth(checks), "title": name, "points": POINTS, "check": cell["id"],
                              "cells": list(places),
                              "answers": [n for n in dict.fromkeys(answers) if n in used] or answers,
                              "statements": [*statements(source(cell)), *statements(extra)]})  # fmt: skip
    return {
        "title": next(text for cell in cells for _, text in headings(cell)),
        "chapter": [{"id": c["id"], "role": role(c), "source": source(todos[c["id"]]), "thin": source(thin[c["id"]])}
                    for c in cells if is_code(c) and c["id"] in todos],
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
    sheets = {kind: [] for kind in TRIALS}
    for cell in key["chapter"]:
        texts = {"empty": cell["source"], "solution": solutions.get(cell["id"], cell["source"])}
        junk = nonsense(texts["solution"]) if cell["role"] == "solution" else cell["source"]
        for kind in sheets:
            sheets[kind].append({"id": cell["id"], "source": texts.get(kind, junk)})
    reports = {}
    with tempfile.TemporaryDirectory() as folder:
        library = copied_library(Path(folder))
        for number, (kind, cells) in enumerate(sheets.items(), 1):
            print(f"{key['title']}, trial {number} of {len(sheets)}: {TRIALS[kind]} ...", flush=True)
            reports[kind] = run_one(key, cells, "", library, [])
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
