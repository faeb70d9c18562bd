"""No check of a chapter is left out when wrong answers are tried; `chapter_runs` does that where a chapter is run."""

import pytest

from book.chapters import normalise
from book.chapters.cells import is_code, source, tags
from book.setup import names
from tests.helpers.exercises import STUDENTS, jobs


@pytest.mark.parametrize("path", names.chapters(), ids=lambda path: path.stem)
def test_every_check_has_answers_that_are_tried(path):
    cells = normalise.read(path)["cells"]
    checks = {n for n, cell in enumerate(filter(is_code, cells)) if "check" in tags(cell)}
    found = {number: job for number, job in jobs(cells).items() if job}
    assert checks == found.keys()
    assert all(job["answers"] for job in found.values())


def test_every_slip_of_a_student_belongs_to_an_exercise():
    titles = [source(c) for path in names.chapters() for c in normalise.read(path)["cells"] if "exercise" in tags(c)]
    assert [number for number in STUDENTS if not any(f"### Exercise {number} " in title for title in titles)] == []
