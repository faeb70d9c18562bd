"""A round with nbgrader: eight submissions, each ends with the mark that it deserves, none stops the batch."""

import copy
import csv
import json

import pytest

from book.chapters import grading, normalise
from book.chapters.nbgrader_form import BEGIN, grade_id, mended, release, slug
from book.setup import extra_envs
from book.setup.paths import Stop
from tests.helpers.chapter import chapter, code, markdown

NAME = "07-lines"
SECOND = [
    markdown("### Exercise 7.2: half of it\n\n**Hint:** divide.", "subslide", ["exercise"]),
    code("def half(length):\n    return length / 2  # in the middle", "skip", ["solution"]),
    code("assert half(10.0) == 5.0", "skip", ["check"]),
]
HIDDEN = "assert half(-3.0) == -1.5, 'a length may carry a sign'"
ANSWERS = {
    "exercise-7-1-answer": "def diagonal(width, height):\n    return math.hypot(width, height)\n\nlength = 13.0",
    "exercise-7-2-answer": "def half(length):\n    return 0.5 * length",
}
WRONG = "def half(length):\n    return abs(length) / 2"
ENDLESS = "def half(length):\n    while True:\n        pass"


def notebook():
    return normalise.normalise({"cells": [*chapter(), *SECOND], "nbformat": 4})


def released():
    return release(notebook())


def cell_of(submission, name):
    return next(cell for cell in submission["cells"] if grade_id(cell) == name)


def answered(**changes):
    """The released notebook with right answers, but for `changes`."""
    submission = released()
    for name, text in {**ANSWERS, **{f"exercise-7-{k[1:]}-answer": v for k, v in changes.items()}}.items():
        cell_of(submission, name)["source"] = text
    return submission


def duplicated():
    """The answer was copied before it was finished: the last copy counts."""
    submission = answered()
    place = submission["cells"].index(cell_of(submission, "exercise-7-2-answer"))
    twin = copy.deepcopy(submission["cells"][place])
    submission["cells"][place]["source"] = WRONG
    submission["cells"].insert(place + 1, {**twin, "id": "twin"})
    return submission


def without_check():
    submission = answered()
    submission["cells"].remove(cell_of(submission, "exercise-7-2-check"))
    return submission


def turned_to_markdown():
    submission = answered()
    cell = cell_of(submission, "exercise-7-1-answer")
    cell["cell_type"] = "markdown"
    del cell["outputs"], cell["execution_count"]
    return submission


SUBMISSIONS = {
    "right": (answered, 2),
    "wrong": (lambda: answered(_2=WRONG), 1),  # only the hidden test notices
    "raises": (lambda: answered(_1="raise RuntimeError('lost')"), 1),
    "untouched": (released, 0),
    "endless": (lambda: answered(_2=ENDLESS), 1),
    "duplicated": (duplicated, 2),
    "check-deleted": (without_check, 2),
    "to-markdown": (turned_to_markdown, 2),
}


def test_slugs_are_the_exercise_without_its_title():
    assert slug("Exercise 3.1 · Two models of one arm") == "exercise-3-1"
    assert slug("Exercise 7.1: another line") == "exercise-7-1"
    assert slug("Draw it") == "draw-it"


def test_a_release_marks_each_answer_and_each_check():
    names = [grade_id(cell) for cell in released()["cells"] if grade_id(cell)]
    assert names == [f"exercise-7-{n}-{role}" for n in (1, 2) for role in ("answer", "check")]
    answer = cell_of(released(), "exercise-7-1-answer")["metadata"]["nbgrader"]
    check = cell_of(released(), "exercise-7-1-check")["metadata"]["nbgrader"]
    assert (answer["solution"], answer["locked"], answer["grade"]) == (True, False, False)
    assert (check["solution"], check["locked"], check["grade"], check["points"]) == (False, True, True, 1)


def test_hidden_tests_go_into_the_check_and_nowhere_else():
    text = json.dumps(release(notebook(), {"exercise-7-2": HIDDEN}))
    assert text.count(BEGIN) == 1
    assert BEGIN in cell_of(release(notebook(), {"exercise-7-2": HIDDEN}), "exercise-7-2-check")["source"]


@pytest.mark.parametrize("name", SUBMISSIONS)
def test_a_mended_submission_has_every_graded_cell_once(name):
    fixed, _ = mended(SUBMISSIONS[name][0](), released())
    kinds = [(grade_id(cell), cell["cell_type"]) for cell in fixed["cells"] if grade_id(cell)]
    assert kinds == [(grade_id(cell), "code") for cell in released()["cells"] if grade_id(cell)]


def test_a_sound_submission_is_not_touched():
    assert mended(answered(), released()) == (answered(), [])


@pytest.fixture(scope="module")
def course(tmp_path_factory):
    """A course of eight students and one file that is no notebook, graded."""
    try:
        extra_envs.python("grading")
    except Stop as stop:
        pytest.skip(str(stop))
    folder = tmp_path_factory.mktemp("course")
    notebooks, hidden = folder / "notebooks", folder / "hidden" / NAME
    for made in (notebooks, hidden):
        made.mkdir(parents=True)
    normalise.write(notebooks / f"{NAME}.ipynb", notebook())
    (hidden / "exercise-7-2.py").write_text(HIDDEN)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(grading, "NOTEBOOKS", notebooks)
        patch.setattr(grading, "CONFIG", grading.CONFIG.replace("timeout = 30", "timeout = 5"))
        grading.assign(NAME, folder, folder / "hidden")
    for student, (make, _) in SUBMISSIONS.items():
        hand_in(folder, student, normalise.dumps(make()))
    hand_in(folder, "broken", "this is no notebook")
    grading.grade(NAME, folder)
    return folder


def hand_in(folder, student, text):
    place = folder / "submitted" / student / NAME
    place.mkdir(parents=True)
    (place / f"{NAME}.ipynb").write_text(text)


def test_what_students_get_shows_neither_answer_nor_hidden_test(course):
    text = (course / "release" / NAME / f"{NAME}.ipynb").read_text()
    assert "a length may carry a sign" not in text
    assert "sqrt" not in text
    assert "length / 2" not in text
    assert "Exercise 7.2: half of it is still to do" in text


@pytest.mark.parametrize("student", SUBMISSIONS)
def test_each_submission_ends_with_the_right_mark(course, student):
    row = rows(course)[student]
    assert (float(row["marks"]), float(row["of"])) == (SUBMISSIONS[student][1], 2), row


def test_a_file_that_is_no_notebook_gets_a_note_and_stops_nobody(course):
    row = rows(course)["broken"]
    assert row["marks"] == "0"
    assert "not a notebook" in row["notes"]


def rows(course):
    with open(course / f"marks-{NAME}.csv", newline="") as file:
        return {row["student"]: row for row in csv.DictReader(file)}
