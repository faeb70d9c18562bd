"""Build the copies for students: solutions become a TODO that names its exercise, outputs are cleared.

    python -m book.chapters.student                    # every chapter, into build/student
    python -m book.chapters.student --to FOLDER 03     # one of them
    python -m book.chapters.student --edition stick.zip [--graded 03,05]

A sheet that is handed out is the sheet that is graded: its cells carry the grader's marks from the beginning.
Fails closed: a chapter with an unknown tag, a solution without exercise or check, or a line of a solution or of a
speaker's note that can still be read anywhere in the copy is refused. A sheet that somebody has filled in stays.
"""

import argparse
import ast
import hashlib
import json
import re
import sys
from pathlib import Path

from book.chapters import normalise
from book.chapters.cells import TAGS, is_code, slide_type, source, tags
from book.chapters.lint import exercises
from book.setup.paths import BUILD, Stop, in_a_sentence

STUDENT = BUILD / "student"
SHORT = 10  # shorter lines, such as `return q`, give nothing away
WRITTEN = ".written.json"  # beside the sheets: what was written, to know a sheet that somebody has changed
POINTS = 1


class Refused(Stop):
    """A chapter from which no copy can be made safely; the message says which cell and why."""


def student_copy(notebook, thin=False):
    """The notebook (parsed JSON) without solutions, outputs and speaker's notes. Raises `Refused`.

    `thin`: the checks say only whether an answer is there; the full ones stay with the grader.
    """
    cells = normalise.normalise(notebook)["cells"]
    for number, cell in enumerate(cells, 1):
        if unknown := set(tags(cell)) - TAGS:
            raise Refused(f"cell {number} has the unknown tags {sorted(unknown)}; is one of them 'solution'?")
    for number, problem in exercises(cells):
        raise Refused(f"cell {number} {problem}")
    copies = [dict(cell) for cell in sheet_cells(cells, thin)]
    copy = normalise.normalise({"cells": copies, "nbformat": 4})
    for line in leaks(cells, copy["cells"], thin):
        raise Refused(f"this line of a solution or note can still be read in the copy: {line}")
    return copy


def sheet_cells(cells, thin):
    """The cells of the sheet: a TODO for each solution, a folded check, nothing for the speaker."""
    exercise, answers, checks, asked = "", 0, 0, []
    for place, cell in enumerate(cells):
        if slide_type(cell) == "notes" and not is_code(cell):
            continue
        plain = {**cell, "outputs": [], "execution_count": None} if is_code(cell) else cell
        if "exercise" in tags(cell):
            exercise, answers, checks, asked = title(source(cell)), 0, 0, []
        if "solution" in tags(cell):
            answers += 1
            asked += wanted(source(cell), cells[place + 1 :]) if is_code(cell) else []
            name = f"{slug(exercise)}-answer{nth(answers)}"
            yield marked(blank(plain, exercise, cells[place + 1 :]), name, solution=True)
        elif "check" in tags(cell):
            checks += 1
            check = {**plain, "source": thin_check(asked)} if thin else plain
            name = f"{slug(exercise)}-check{nth(checks)}"
            yield marked(check, name, grade=True, points=POINTS, locked=True)
        else:
            yield plain


def nth(number):
    """What tells the second cell of a kind from the first."""
    return f"-{number}" if number > 1 else ""


def marked(cell, grade_id, **roles):
    """The cell with the grader's marks (nbgrader's schema); an error in it does not stop *Run All*."""
    plain = {"grade": False, "locked": False, "solution": False, "task": False, "schema_version": 3}
    about = {**plain, "grade_id": grade_id, "cell_type": cell["cell_type"], **roles}
    metadata = {**cell["metadata"], "nbgrader": about}
    if is_code(cell):
        metadata["tags"] = [*tags(cell), *({"raises-exception"} - set(tags(cell)))]
    if about["grade"]:
        metadata["jupyter"] = {"source_hidden": True}
    return {**cell, "metadata": metadata}


def grade_id(cell):
    """The name under which a cell of a sheet is graded, or None."""
    return cell.get("metadata", {}).get("nbgrader", {}).get("grade_id")


def blank(cell, exercise, later):
    """The cell with a TODO in place of the solution; `later` are the cells that use it."""
    if not is_code(cell):
        return {**cell, "source": f"*Your answer to {exercise}: write it here.*"}
    return {**cell, "source": todo(source(cell), exercise, wanted(source(cell), later))}


def title(exercise):
    """The exercise's name: its heading or its first bold words, such as `Exercise 3.2`."""
    found = re.search(r"^#+\s+(.+)$|\*\*(.+?)\*\*", exercise, re.M)
    return (found[1] or found[2]).strip(" .:*") if found else exercise.split(".")[0].strip()


def slug(name):
    """`Exercise 3.1 · Two models` -> `exercise-3-1`: the name up to its number."""
    found = re.match(r"(\w+)\W+([\d.]*\d)", name)
    words = f"{found[1]} {found[2]}" if found else name
    return re.sub(r"\W+", "-", words).strip("-").lower()


def short(exercise):
    """`Exercise 3.1` of `Exercise 3.1 · Two models`, to name it in one line of code."""
    found = re.match(r"\w+\W+[\d.]*\d", exercise)
    return found[0] if found else exercise


def wanted(code, later):
    """The names that a solution binds and that cells after it use, in order; all of them if none is used."""
    names = bound(code)
    used = {node.id for cell in later if is_code(cell) for node in ast.walk(parsed(cell)) if isinstance(node, ast.Name)}
    return [name for name in names if name in used] or names


def parsed(cell):
    try:
        return ast.parse(source(cell))
    except SyntaxError:  # a magic
        return ast.Module([], [])


def bound(code):
    """The names that a cell defines for cells after it, without those that start with an underscore."""
    found, waiting = [], list(ast.parse(code).body)
    while waiting:
        node = waiting.pop(0)
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            found.append(node.name)
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            found.append(node.id)
        elif not isinstance(node, (ast.Lambda, ast.ListComp, ast.GeneratorExp, ast.SetComp, ast.DictComp)):
            waiting[:0] = ast.iter_child_nodes(node)
    return [name for name in dict.fromkeys(found) if not name.startswith("_")]


def todo(code, exercise, names=None):
    """What stays of a solution: imports, function heads with docstrings, and `...` for each variable in `names`.

    The body of a function raises an error that says what to do; `...` is what the checks call a TODO.
    """
    names, values, functions = bound(code) if names is None else names, [], []
    kept = [ast.unparse(node) for node in ast.parse(code).body if isinstance(node, ast.Import | ast.ImportFrom)]
    stop = f"{short(exercise)} is still to do: replace this line by your own."
    defined = [node for node in ast.parse(code).body if isinstance(node, ast.FunctionDef) and node.name in names]
    for node in defined:
        functions += ["", head(node), f'    raise NotImplementedError("{stop}")', ""]
    values = [f"{name} = ..." for name in names if name not in {node.name for node in defined}]
    first = "# TODO: write the body of the function." if functions else "# TODO: put your answer in place of the dots."
    if functions and values:
        first = "# TODO: write the body of the function, and put your answer in place of the dots."
    if not (functions or values):
        first, values = "# TODO", [f'raise NotImplementedError("{stop}")']
    return re.sub(r"\n{3,}", "\n\n\n", "\n".join([first, *kept, *functions, *values])).strip("\n")


def thin_check(names):
    """A check that only asks whether the answers are there."""
    listed = ", ".join(f"{name}={name}" for name in dict.fromkeys(names))
    return f"check.handed_in({listed})"


def head(function):
    """The source of a function's signature and docstring, decorators left out."""
    has_doc = ast.get_docstring(function) is not None
    body = function.body[:1] if has_doc else [ast.Pass()]
    shell = ast.FunctionDef(function.name, function.args, body, [], function.returns)
    text = ast.unparse(ast.fix_missing_locations(shell))
    return text if has_doc else text.rsplit("\n", 1)[0]


def leaks(cells, copies, thin=False):
    """The lines of solutions and notes that can be read in the copy although no other cell of the source shows them."""
    hidden = [cell for cell in cells if "solution" in tags(cell) or slide_type(cell) == "notes"]
    hidden += [cell for cell in cells if thin and "check" in tags(cell)]
    shown = squeeze("\n".join(source(cell) for cell in cells if cell not in hidden))
    copy = squeeze("\n".join(str(cell.get("outputs", "")) + source(cell) for cell in copies))
    secrets = {line: None for cell in hidden for line in secret_lines(cell)}
    kept = {squeeze(line) for cell in hidden if is_code(cell) for line in kept_lines(source(cell))}
    return [line for line in secrets if line in copy and line not in shown and line not in kept]


def kept_lines(code):
    """The lines of a solution that its copy keeps on purpose: imports, function heads, docstrings."""
    nodes = ast.parse(code).body
    texts = [ast.unparse(node) for node in nodes if isinstance(node, ast.Import | ast.ImportFrom)]
    texts += [head(node) for node in nodes if isinstance(node, ast.FunctionDef)]
    return "\n".join(texts).splitlines()


def secret_lines(cell):
    """The lines of a cell worth hiding, without blanks and comments."""
    lines = [re.sub(r"\s#\s.*$", "", line) if is_code(cell) else line for line in source(cell).splitlines()]
    return [squeezed for line in lines if len(squeezed := squeeze(line)) >= SHORT]


def squeeze(text):
    return re.sub(r"\s+", "", text)


# ---- writing sheets, and never over somebody's work ----------------------------------------------------------


def give_out(target, notebook):
    """Write a sheet (or None: only take an old one away) unless somebody has changed the one that is there.

    True if it was written or taken away.
    """
    known = written(target.parent)
    if target.exists() and known.get(target.name) != digest(target):
        return False
    target.unlink(missing_ok=True)
    known.pop(target.name, None)
    if notebook is not None:
        normalise.write(target, notebook)
        known[target.name] = digest(target)
    (target.parent / WRITTEN).write_text(json.dumps(known, indent=1, sort_keys=True) + "\n", encoding="utf-8")
    return True


def digest(path):
    return hashlib.sha256(path.read_bytes()).hexdigest()


def written(folder):
    try:
        return dict(json.loads((folder / WRITTEN).read_text(encoding="utf-8")))
    except (OSError, ValueError, TypeError):
        return {}


@in_a_sentence
def main(argv=None):
    parser = argparse.ArgumentParser("python run.py student", description=__doc__.split("\n")[0])
    parser.add_argument("notebooks", nargs="*", help="default: every chapter")
    parser.add_argument("--to", type=Path, default=STUDENT, metavar="FOLDER", help="default: build/student")
    parser.add_argument("--edition", type=Path, metavar="FILE.zip", help="all that a student needs, in one file")
    parser.add_argument("--graded", default="", metavar="03,05", help="chapters whose checks stay with the grader")
    parser.add_argument("--wheels", action="store_true", help="with the packages for this system, to install offline")
    options = parser.parse_args(argv)
    graded = tuple(options.graded.split(",")) if options.graded else ()
    if options.edition:
        from book.chapters import edition

        print(edition.write(options.edition, options.wheels, graded=graded))
        return 0
    options.to.mkdir(parents=True, exist_ok=True)
    paths = normalise.chapters(options.notebooks)
    return 1 if [path for path in paths if not wrote(path, options.to / path.name, graded)] else 0


def wrote(path, target, graded=()):
    """Write the sheet of one chapter and say so; False, with a sentence, if there is none now."""
    try:
        sheet, reason = student_copy(normalise.read(path), path.name[:2] in graded), ""
    except Refused as refused:
        sheet, reason = None, f"{path}: no copy made: {refused}"  # an older copy must not pass for this one
    if not give_out(target, sheet):
        reason = f"{target} was filled in or changed, so it stays; move it away to get a new one. {reason}".strip()
    print(reason or target, file=sys.stderr if reason else sys.stdout)
    return not reason


if __name__ == "__main__":
    sys.exit(main())
