"""Student copies hold no solutions: in the source every check passes, in the copy every check fails."""

import copy

import pytest

from book.chapters import execute, normalise, student
from book.chapters.cells import is_code, source, tags
from tests.helpers.chapter import SOLUTION, chapter, code, markdown

CHAPTERS = [
    path
    for path in sorted(normalise.NOTEBOOKS.glob("*.ipynb"))
    if any("solution" in tags(cell) for cell in normalise.read(path)["cells"])
]


def ran(notebook, path, cwd=None):
    """The cells of the notebook after running all of them, errors allowed."""
    normalise.write(path, normalise.normalise({**notebook, "nbformat": 4}))
    return execute.run(path, cwd=cwd or path.parent, allow_errors=True, timeout_s=60).cells


def with_broken_programs_handed_in(cells):
    """The cells, and after each program that is broken on purpose the check of its exercise, tagged `broken`."""
    out = []
    for number, cell in enumerate(cells):
        out.append(cell)
        if "broken" in tags(cell):
            out[-1] = {**cell, "metadata": {}}
            check = next(later for later in cells[number:] if "check" in tags(later))
            out.append({**check, "id": f"broken-{number}", "metadata": {"tags": ["broken"]}})
    return out


def failing(cells, tag):
    """For each cell with the tag: the error that it ended with, as `Name: message`, or ''."""
    tagged = [cell for cell in cells if tag in cell.metadata.get("tags", [])]
    return [error_of(cell) for cell in tagged]


def error_of(cell):
    return "".join(f"{out.ename}: {out.evalue}" for out in cell.outputs if out.output_type == "error")


@pytest.mark.parametrize("path", CHAPTERS, ids=lambda path: path.stem)
def test_the_copy_of_a_chapter_fails_every_check(path, tmp_path):
    copied = student.student_copy(normalise.read(path))
    cells = ran({"cells": with_broken_programs_handed_in(copied["cells"])}, tmp_path / path.name, path.parent)
    told = failing(cells, "broken")
    assert all(error.startswith("Wrong: ") for error in told), f"a broken program that no check finds out: {told}"
    checks = failing(cells, "check")
    assert checks
    passed = [number for number, error in enumerate(checks, 1) if not error]
    assert not passed, f"these checks pass without an answer: {passed}"
    lost = [f"check {n} ends with {e}" for n, e in enumerate(checks, 1) if not names_the_todo(e)]
    assert not lost, "a check of an empty answer must lead to the TODO:\n" + "\n".join(lost)


def names_the_todo(error):
    """Does an error lead to the TODO: by omx.check, by its own message, or as what `...` does in arithmetic?"""
    return error.startswith(("Wrong", "NotImplementedError", "TypeError", "AttributeError"))


@pytest.mark.parametrize("path", CHAPTERS, ids=lambda path: path.stem)
def test_the_chapter_itself_passes_every_check(path):
    stored = [cell for cell in normalise.read(path)["cells"] if "check" in tags(cell)]
    assert stored
    for cell in stored:  # nbval runs these cells and compares: what is stored is what happens
        assert not any(output["output_type"] == "error" for output in cell["outputs"]), source(cell)


def scratch(cells=None):
    return normalise.normalise({"cells": cells or chapter(), "nbformat": 4})


def test_source_passes_and_copy_fails_on_a_small_chapter(tmp_path):
    assert failing(ran(scratch(), tmp_path / "source.ipynb"), "check") == [""]
    (error,) = failing(ran(student.student_copy(scratch()), tmp_path / "copy.ipynb"), "check")
    assert error.startswith("NotImplementedError: Exercise 7.1: another line is still to do.")


def test_a_solution_becomes_a_todo_that_names_its_exercise():
    todo = next(source(c) for c in student.student_copy(scratch())["cells"] if "solution" in tags(c))
    assert "def diagonal(width, height):" in todo
    assert "The diagonal of a box, mm." in todo
    assert "length = ...  # TODO" in todo
    assert "Exercise 7.1: another line is still to do. Hint: `hypot` does it." in todo
    assert "sqrt" not in todo
    assert "5, 12" not in todo
    compile(todo, "todo", "exec")


def test_a_solution_without_functions_raises_when_it_is_run():
    todo = student.todo(
        "a, b = 3, 4\nfor _i in range(2):\n    total = a + b\nprint(total)", "Exercise 1 is still to do."
    )
    names = {}
    with pytest.raises(NotImplementedError, match="Exercise 1 is still to do"):
        exec(todo, names)
    assert names["a"] is names["b"] is names["total"] is ...
    assert "_i" not in names


def test_a_written_answer_becomes_a_place_for_one():
    cells = chapter()
    cells.insert(-1, markdown("Because the hypotenuse is longest.", tags=["solution"]))
    copied = student.student_copy(scratch(cells))
    assert "hypotenuse" not in str(copied)
    assert "*Your answer." in str(copied)


def test_outputs_are_cleared():
    copied = student.student_copy(scratch())
    assert all(not cell["outputs"] and cell["execution_count"] is None for cell in copied["cells"] if is_code(cell))


def test_the_leak_check_reads_cells_and_outputs():
    solution = code(SOLUTION, tags=["solution"])
    stub = code("raise NotImplementedError('x')", tags=["solution"])
    leaky = {**code("1"), "outputs": [{"text": "return math.sqrt( width**2 + height**2 )"}]}
    assert student.leaks([solution], [stub]) == []
    assert student.leaks([solution], [stub, leaky]) == ["returnmath.sqrt(width**2+height**2)"]
    assert student.leaks([solution], [stub, markdown("so `length = math.hypot(5, 12)` it is")])
    assert student.leaks([solution], [solution]) != [], "a solution that was not blanked at all"


REFUSED = {
    "unknown tags": lambda cells: cells[-2]["metadata"].update(tags=["solutions"]),
    "is tagged 'solution' after 'check'": lambda cells: cells.append(code("y = 2", tags=["solution"])),
    "is tagged 'check' after 'exercise'": lambda cells: cells.pop(-2),
    "ends with 'solution'": lambda cells: cells.pop(-1),
}


@pytest.mark.parametrize("reason", REFUSED)
def test_a_chapter_that_is_not_safe_is_refused_and_an_old_copy_removed(reason, tmp_path, capsys):
    cells = copy.deepcopy(chapter())
    REFUSED[reason](cells)
    path, target = tmp_path / "07-scratch.ipynb", tmp_path / "out"
    target.mkdir()
    (target / path.name).write_text("an older copy")
    normalise.write(path, scratch(cells))
    assert student.main(["--to", str(target), str(path)]) == 1
    assert reason in capsys.readouterr().err
    assert list(target.iterdir()) == []
    normalise.write(path, scratch())
    assert student.main(["--to", str(target), str(path)]) == 0
    assert "sqrt" not in (target / path.name).read_text()
