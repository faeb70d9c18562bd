"""Chapters as nbgrader wants them: metadata on answers and checks, hidden tests from a folder, submissions mended.

nbgrader itself is not imported here. An exercise's cells are known by its name: `exercise-3-1-answer`,
`exercise-3-1-check`.
"""

import copy
import re

from book.chapters.cells import is_code, source, tags
from book.chapters.student import student_copy, title

BEGIN, END = "### BEGIN HIDDEN TESTS", "### END HIDDEN TESTS"
POINTS = 1


def release(notebook, hidden=None):
    """The student copy (parsed JSON) with nbgrader's metadata; `hidden` maps an exercise to the code of its tests.

    With hidden tests it is what `nbgrader generate_assignment` takes, not yet what students get.
    """
    copied, exercise, answers = student_copy(notebook), "", 0
    for cell in copied["cells"]:
        if "exercise" in tags(cell):
            exercise, answers = slug(title(source(cell))), 0
        elif "solution" in tags(cell):
            answers += 1
            mark(cell, f"{exercise}-answer" + (f"-{answers}" if answers > 1 else ""), solution=True, locked=False)
        elif "check" in tags(cell):
            mark(cell, f"{exercise}-check", grade=True, points=POINTS, locked=True)
            if tests := (hidden or {}).get(exercise):
                cell["source"] = f"{source(cell)}\n{BEGIN}\n{tests.strip()}\n{END}"
    return copied


def mark(cell, grade_id, **roles):
    """Give a cell nbgrader's metadata."""
    cell["id"] = grade_id
    plain = {"grade": False, "locked": False, "solution": False, "task": False, "schema_version": 3}
    cell["metadata"]["nbgrader"] = {**plain, "grade_id": grade_id, "cell_type": cell["cell_type"], **roles}


def slug(name):
    """`Exercise 3.1 · Two models` -> `exercise-3-1`: the name up to its number."""
    found = re.match(r"(\w+)\W+([\d.]*\d)", name)
    words = f"{found[1]} {found[2]}" if found else name
    return re.sub(r"\W+", "-", words).strip("-").lower()


def mended(submission, released):
    """(notebook, notes): the submission so that nbgrader grades what it means; `notes` say what was done.

    A duplicated cell keeps its role in the last copy, a cell of the wrong kind gets its kind back, a check that
    was deleted returns, and so does the empty answer before it.
    """
    notebook, notes = copy.deepcopy(submission), []
    wanted = {grade_id(cell): cell for cell in released["cells"] if grade_id(cell)}
    seen = set()
    for cell in reversed(notebook["cells"]):
        name = grade_id(cell)
        if name is None:
            continue
        if name not in wanted or name in seen:
            del cell["metadata"]["nbgrader"]
            cell["id"] = f"{name}-copy-{len(notes)}"[-60:]
            notes.append(f"{name}: a copy of it does not count")
            continue
        seen.add(name)
        if cell["cell_type"] != wanted[name]["cell_type"]:
            notes.append(f"{name}: was turned to {cell['cell_type']}")
            change_kind(cell, wanted[name])
    for name in [name for name in wanted if name not in seen]:
        notes.append(f"{name}: was deleted")
        insert(notebook["cells"], wanted, name)
    return notebook, notes


def grade_id(cell):
    return cell.get("metadata", {}).get("nbgrader", {}).get("grade_id")


def change_kind(cell, wanted):
    """Turn a cell back to the kind that it had, its text untouched."""
    cell["cell_type"] = wanted["cell_type"]
    cell.pop("attachments", None)
    if is_code(cell):
        cell.update(outputs=[], execution_count=None)
    else:
        cell.pop("outputs", None)
        cell.pop("execution_count", None)


def insert(cells, wanted, name):
    """Put a deleted cell back: behind the graded cell that stood before it, or at the end."""
    names = list(wanted)
    before = set(names[: names.index(name)])
    places = [place for place, cell in enumerate(cells) if grade_id(cell) in before]
    cells.insert(places[-1] + 1 if places else len(cells), copy.deepcopy(wanted[name]))
