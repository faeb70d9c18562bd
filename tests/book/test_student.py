"""Student copies hold no solutions: in the source every check passes, in the copy every check fails."""

import copy

import pytest

from book.chapters import edition, execute, normalise, student
from book.chapters.cells import is_code, source, tags
from omx import check
from tests.helpers.chapter import SOLUTION, chapter, code, markdown

CHAPTERS = [
    path
    for path in sorted(normalise.NOTEBOOKS.glob("*.ipynb"))
    if any("solution" in tags(cell) for cell in normalise.read(path)["cells"])
]


def ran(notebook, path, cwd=None, allow_errors=True):
    """The cells of the notebook after running all of them, errors allowed."""
    normalise.write(path, notebook)
    return execute.run(path, cwd=cwd or path.parent, allow_errors=allow_errors, timeout_s=60).cells


def failing(cells, tag):
    """For each cell with the tag: the error that it ended with, as `Name: message`, or ''."""
    tagged = [cell for cell in cells if tag in cell.metadata.get("tags", [])]
    return [error_of(cell) for cell in tagged]


def error_of(cell):
    return "".join(f"{out.ename}: {out.evalue}" for out in cell.outputs if out.output_type == "error")


@pytest.mark.parametrize("path", CHAPTERS, ids=lambda path: path.stem)
def test_the_chapter_itself_passes_every_check(path):
    stored = [cell for cell in normalise.read(path)["cells"] if "check" in tags(cell)]
    assert stored
    for cell in stored:  # nbval runs these cells and compares: what is stored is what happens
        assert not any(output["output_type"] == "error" for output in cell["outputs"]), source(cell)


@pytest.mark.parametrize("path", CHAPTERS, ids=lambda path: path.stem)
def test_the_sheet_of_a_chapter_holds_all_that_a_grader_needs_and_nothing_for_the_speaker(path):
    cells = normalise.read(path)["cells"]
    sheet = student.student_copy(normalise.read(path))  # refuses to let a line of a solution or note through
    graded = [student.grade_id(cell) for cell in sheet["cells"] if student.grade_id(cell)]
    assert len(set(graded)) == len(graded) == sum(bool({"solution", "check"} & set(tags(cell))) for cell in cells)
    assert not [cell for cell in sheet["cells"] if cell["metadata"].get("slideshow", {}).get("slide_type") == "notes"]
    for cell in sheet["cells"]:
        if "check" in tags(cell):
            assert cell["metadata"]["jupyter"] == {"source_hidden": True}
        if "solution" in tags(cell) and is_code(cell):
            assert max(map(len, source(cell).splitlines())) <= 100, "a TODO must be read without scrolling"
    thin = student.student_copy(normalise.read(path), thin=True)
    assert all("handed_in(" in source(cell) for cell in thin["cells"] if "check" in tags(cell))
    assert [cell["id"] for cell in thin["cells"]] == [cell["id"] for cell in sheet["cells"]]
    assert normalise.normalise(sheet) == sheet, "a sheet stays what it is when it is stored again"


def test_run_all_of_a_fresh_sheet_reaches_the_self_test_and_shows_each_todo(tmp_path):
    path = CHAPTERS[0]
    cells = ran(student.student_copy(normalise.read(path)), tmp_path / path.name, allow_errors=False)
    assert failing(cells, "check")[0].startswith("Wrong: q_right is still the TODO")
    (self_test,) = [cell for cell in cells if "self-test" in cell.metadata.get("tags", []) and cell.cell_type == "code"]
    assert "ok  kinematics" in self_test.outputs[0].text


def scratch(cells=None):
    return normalise.normalise({"cells": cells or chapter(), "nbformat": 4})


def test_source_passes_and_copy_fails_on_a_small_chapter(tmp_path):
    assert failing(ran(scratch(), tmp_path / "source.ipynb"), "check") == [""]
    (error,) = failing(ran(student.student_copy(scratch()), tmp_path / "copy.ipynb"), "check")
    assert error.startswith("NotImplementedError: Exercise 7.1 is still to do: replace this line by your own.")


def test_a_solution_becomes_a_todo_that_names_its_exercise():
    todo = next(source(c) for c in student.student_copy(scratch())["cells"] if "solution" in tags(c))
    assert "def diagonal(width, height):" in todo
    assert "The diagonal of a box, mm." in todo
    assert "length = ..." in todo
    assert 'raise NotImplementedError("Exercise 7.1 is still to do: replace this line by your own.")' in todo
    assert todo.startswith("# TODO: write the body of the function, and put your answer in place of the dots.")
    assert "sqrt" not in todo
    assert "5, 12" not in todo
    compile(todo, "todo", "exec")


def test_a_solution_without_functions_becomes_dots_for_the_names_that_are_asked_for():
    code = "import math\na, b = 3, 4\nfor _i in range(2):\n    total = a + b\nprint(total)"
    assert student.todo(code, "Exercise 1", ["total"]).splitlines()[1:] == ["import math", "total = ..."]
    assert student.todo(code, "Exercise 1").splitlines()[2:] == ["a = ...", "b = ...", "total = ..."]
    assert "raise NotImplementedError" in student.todo("print(3)", "Exercise 1.2: look")


def test_slugs_are_the_exercise_without_its_title():
    assert student.slug("Exercise 3.1 · Two models of one arm") == "exercise-3-1"
    assert student.slug("Exercise 7.1: another line") == "exercise-7-1"
    assert student.slug("Draw it") == "draw-it"


def test_a_thin_check_knows_a_function_whose_body_nobody_has_written():
    names = {}
    exec(student.todo("def half(length):\n    return length / 2", "Exercise 7.2", ["half"]), names)
    with pytest.raises(check.Wrong, match="half is still the TODO"):
        check.handed_in(half=names["half"])
    check.handed_in(half=lambda length: length / 2)


@pytest.mark.parametrize("early", [True, False])
def test_a_function_that_keeps_the_sheets_line_behind_its_own_is_written(early):
    names, stop = {}, student.todo("def half(length):\n    return 1", "Exercise 7.2", ["half"]).splitlines()[-1]
    own = "    if length:\n        return length / 2\n" if early else "    length /= 2\n"
    exec(f"def half(length):\n{own}{stop}", names)
    if early:
        return check.handed_in(half=names["half"])
    with pytest.raises(check.Wrong, match="half is still the TODO"):
        check.handed_in(half=names["half"])


def test_speakers_notes_stay_with_the_speaker():
    cells = chapter()
    cells.insert(3, markdown("For the speaker: they will say 12, because they add.", "notes"))
    assert "they will say" not in str(student.student_copy(scratch(cells)))
    cells[0] = markdown("# Lines\n\nA hook: they will say 12, because they add.", "slide")
    cells[3] = markdown("they will say 12, because they add.", "notes")
    student.student_copy(scratch(cells))  # a line that is shown elsewhere is no secret


def test_a_written_answer_becomes_a_place_for_one():
    cells = chapter()
    cells.insert(-1, markdown("Because the hypotenuse is longest.", tags=["solution"]))
    copied = student.student_copy(scratch(cells))
    assert "hypotenuse" not in str(copied)
    assert "*Your answer to Exercise 7.1" in str(copied)


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
    path, target = tmp_path / "07-scratch.ipynb", tmp_path / "out"
    normalise.write(path, scratch())
    assert edition.main(["--to", str(target), str(path)]) == 0
    assert "sqrt" not in (target / path.name).read_text()
    cells = copy.deepcopy(chapter())
    REFUSED[reason](cells)
    normalise.write(path, scratch(cells))
    assert edition.main(["--to", str(target), str(path)]) == 1
    assert reason in capsys.readouterr().err
    assert not (target / path.name).exists()


def test_a_sheet_that_somebody_has_filled_in_is_never_replaced(tmp_path, capsys):
    path, target = tmp_path / "07-scratch.ipynb", tmp_path / "out"
    normalise.write(path, scratch())
    edition.main(["--to", str(target), str(path)])
    mine = (target / path.name).read_text().replace("length = ...", "length = 13.0")
    (target / path.name).write_text(mine)
    assert edition.main(["--to", str(target), str(path)]) == 1
    assert "was filled in or changed, so it stays" in capsys.readouterr().err
    assert (target / path.name).read_text() == mine
