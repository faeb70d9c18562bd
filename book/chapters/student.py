"""Build the copies for students: solutions become a TODO that names its exercise, outputs are cleared.

    python -m book.chapters.student                    # every chapter, into build/student
    python -m book.chapters.student --to FOLDER notebooks/03-*.ipynb

Fails closed: a chapter with an unknown tag, a solution without exercise or check, or a line of a solution that
is still to be read anywhere in the copy is refused, and nothing is written for it.
"""

import argparse
import ast
import re
import sys
from pathlib import Path

from book.chapters import normalise
from book.chapters.cells import TAGS, is_code, source, tags
from book.chapters.lint import exercises
from book.setup.paths import BUILD

STUDENT = BUILD / "student"
SHORT = 10  # shorter lines, such as `return q`, give nothing away


class Refused(Exception):
    """A chapter from which no copy can be made safely; the message says which cell and why."""


def student_copy(notebook):
    """The notebook (parsed JSON) without solutions and outputs. Raises `Refused`."""
    cells = normalise.normalise(notebook)["cells"]
    for number, cell in enumerate(cells, 1):
        if unknown := set(tags(cell)) - TAGS:
            raise Refused(f"cell {number} has the unknown tags {sorted(unknown)}; is one of them 'solution'?")
    for number, problem in exercises(cells):
        raise Refused(f"cell {number} {problem}")
    copies, exercise = [], ""
    for cell in cells:
        exercise = source(cell) if "exercise" in tags(cell) else exercise
        copies.append(blank(cell, exercise) if "solution" in tags(cell) else dict(cell))
        if is_code(cell):
            copies[-1].update(outputs=[], execution_count=None)
    copy = normalise.normalise({"cells": copies, "nbformat": 4})
    for line in leaks(cells, copy["cells"]):
        raise Refused(f"this line of a solution can still be read in the copy: {line}")
    return copy


def blank(cell, exercise):
    """The cell with a TODO in place of the solution."""
    message = f"{title(exercise)} is still to do. {hint(exercise)}"
    if not is_code(cell):
        return {**cell, "source": f"*Your answer. {message}*"}
    return {**cell, "source": todo(source(cell), message)}


def title(exercise):
    """The exercise's name: its heading or its first bold words, such as `Exercise 3.2`."""
    found = re.search(r"^#+\s+(.+)$|\*\*(.+?)\*\*", exercise, re.M)
    return (found[1] or found[2]).strip(" .:*") if found else exercise.split(".")[0].strip()


def hint(exercise):
    """The exercise's hint in one line, without Markdown's emphasis."""
    found = re.search(r"\bhint\b[\s:.*_]*(.+?)(?:\n\s*\n|\Z)", exercise, re.I | re.S)
    return "Hint: " + " ".join(found[1].replace("**", "").split()) if found else "Its text is in the cell above."


def todo(code, message):
    """What stays of a solution: imports, function heads with docstrings, and `...` for each variable.

    A function raises the message when it is called, a cell without functions when it is run.
    """
    lines, stop = ["# TODO: your answer goes into this cell."], f"raise NotImplementedError({message!r})"
    functions = False
    for node in ast.parse(code).body:
        if isinstance(node, ast.Import | ast.ImportFrom):
            lines.append(ast.unparse(node))
        elif isinstance(node, ast.FunctionDef):
            functions = True
            lines += ["", head(node), "    " + stop, ""]
        else:
            lines += [f"{name} = ...  # TODO" for name in assigned(node)]
    return "\n".join(lines if functions else [*lines, stop]).strip("\n")


def head(function):
    """The source of a function's signature and docstring, decorators left out."""
    has_doc = ast.get_docstring(function) is not None
    body = function.body[:1] if has_doc else [ast.Pass()]
    shell = ast.FunctionDef(function.name, function.args, body, [], function.returns)
    text = ast.unparse(ast.fix_missing_locations(shell))
    return text if has_doc else text.rsplit("\n", 1)[0]


def assigned(node):
    """The names that a statement binds, in order, without those that start with an underscore."""
    names = [n.id for n in ast.walk(node) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)]
    return list(dict.fromkeys(name for name in names if not name.startswith("_")))


def leaks(cells, copies):
    """The lines of solutions that can be read in the copy although no other cell of the source shows them."""
    solutions = [cell for cell in cells if "solution" in tags(cell)]
    shown = squeeze("\n".join(source(cell) for cell in cells if cell not in solutions))
    copy = squeeze("\n".join(str(cell.get("outputs", "")) + source(cell) for cell in copies))
    secrets = {line: None for cell in solutions for line in secret_lines(cell)}
    kept = {squeeze(line) for cell in solutions if is_code(cell) for line in kept_lines(source(cell))}
    return [line for line in secrets if line in copy and line not in shown and line not in kept]


def kept_lines(code):
    """The lines of a solution that its copy keeps on purpose: imports, function heads, docstrings."""
    nodes = ast.parse(code).body
    texts = [ast.unparse(node) for node in nodes if isinstance(node, ast.Import | ast.ImportFrom)]
    texts += [head(node) for node in nodes if isinstance(node, ast.FunctionDef)]
    return "\n".join(texts).splitlines()


def secret_lines(cell):
    """The lines of a solution worth hiding, without blanks and comments."""
    lines = [re.sub(r"\s#\s.*$", "", line) if is_code(cell) else line for line in source(cell).splitlines()]
    return [squeezed for line in lines if len(squeezed := squeeze(line)) >= SHORT]


def squeeze(text):
    return re.sub(r"\s+", "", text)


def main(argv=None):
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("notebooks", nargs="*", help="default: every chapter")
    parser.add_argument("--to", type=Path, default=STUDENT, metavar="FOLDER", help="default: build/student")
    options = parser.parse_args(argv)
    options.to.mkdir(parents=True, exist_ok=True)
    refused = 0
    for path in normalise.chapters(options.notebooks):
        try:
            normalise.write(options.to / path.name, student_copy(normalise.read(path)))
            print(options.to / path.name)
        except Refused as reason:
            refused += 1
            (options.to / path.name).unlink(missing_ok=True)  # an older copy must not pass for this one
            print(f"{path}: no copy made: {reason}", file=sys.stderr)
    return 1 if refused else 0


if __name__ == "__main__":
    sys.exit(main())
