"""Hand out a chapter's exercises and grade what comes back, with nbgrader in an environment of its own.

    python -m book.chapters.grading assign 03-forward-kinematics --course FOLDER [--hidden FOLDER]
    python -m book.chapters.grading grade 03-forward-kinematics --course FOLDER

`assign` writes FOLDER/release/03-.../03-....ipynb, to be handed out. Collect answers as
FOLDER/submitted/STUDENT/03-.../03-....ipynb. `grade` writes FOLDER/marks-03-....csv and never stops at a bad one:
each is mended into FOLDER/mended, run and graded by itself. Hidden tests are files HIDDEN/03-.../exercise-3-1.py.
"""

import argparse
import csv
import json
import os
import shutil
import subprocess
import sys
import threading
from pathlib import Path

from book.chapters import normalise
from book.chapters.nbgrader_form import mended, release
from book.chapters.student import Refused
from book.setup import extra_envs
from book.setup.paths import NOTEBOOKS, Stop

CELL_TIMEOUT_S, STUDENT_TIMEOUT_S = 30, 600
CONFIG = f"""c = get_config()  # noqa: F821 - nbgrader gives it
c.CourseDirectory.course_id = "omx"
c.CourseDirectory.submitted_directory = "mended"
c.ExecutePreprocessor.timeout = {CELL_TIMEOUT_S}
c.ExecutePreprocessor.interrupt_on_timeout = True
c.GenerateAssignment.preprocessors = [
    "nbgrader.preprocessors." + name
    for name in ("LockCells", "ComputeChecksums", "SaveCells", "ClearOutput", "ClearHiddenTests", "ComputeChecksums",
                 "CheckCellMetadata")
]
"""
#: Runs in nbgrader's environment: grades students one by one, and says a line of JSON about each.
GRADER = """
import json, sys
from nbgrader.api import Gradebook
from nbgrader.apps.api import NbGraderAPI
from traitlets.config import PyFileConfigLoader

chapter, *students = sys.argv[1:]
api = NbGraderAPI(config=PyFileConfigLoader("nbgrader_config.py", path=".").load_config())
for student in students:
    done = api.autograde(chapter, student, force=True, create=True)
    marks = {}
    if done["success"]:
        with Gradebook("sqlite:///gradebook.db") as book:
            notebooks = book.find_submission(chapter, student).notebooks
            marks = {g.name: g.auto_score or 0 for n in notebooks for g in n.grades}
    said = [line for line in (done.get("error") or "").splitlines() if line.strip()]
    error = "" if done["success"] else "".join(said[-1:]) or "nbgrader failed without a word"
    print(json.dumps({"student": student, "marks": marks, "error": error}), flush=True)
"""


def assign(chapter, course, hidden=None):
    """Write the course's release version of a chapter; its path."""
    source = normalise.read(NOTEBOOKS / f"{chapter}.ipynb")
    course.mkdir(parents=True, exist_ok=True)
    (course / "nbgrader_config.py").write_text(CONFIG, encoding="utf-8")
    files = sorted(Path(hidden, chapter).glob("*.py")) if hidden else []
    tests = {path.stem: path.read_text(encoding="utf-8") for path in files}
    target = course / "source" / chapter / f"{chapter}.ipynb"
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_text(normalise.dumps(release(source, tests)), encoding="utf-8")
    nbgrader(course, "generate_assignment", chapter, "--create", "--force")
    return course / "release" / chapter / target.name


def grade(chapter, course):
    """Grade every submission of a chapter: a list of rows (dicts), also written as CSV."""
    released = normalise.read(course / "release" / chapter / f"{chapter}.ipynb")
    best = sum(cell["metadata"].get("nbgrader", {}).get("points", 0) for cell in released["cells"])
    rows = {}
    for folder in sorted((course / "submitted").iterdir()):
        rows[folder.name] = {"student": folder.name, "marks": 0, "of": best, "notes": ""}
        rows[folder.name]["notes"] = mend(chapter, course, folder.name, released)
    waiting = [student for student in rows if (course / "mended" / student / chapter).exists()]
    for student, marks, error in graded(chapter, course, waiting):
        rows[student].update(marks=sum(marks.values()), **marks)
        rows[student]["notes"] += f" not graded: {error}" if error else ""
    write_marks(course / f"marks-{chapter}.csv", list(rows.values()))
    return list(rows.values())


def mend(chapter, course, student, released):
    """Write a student's mended notebook; what was done to it, or why it cannot be graded."""
    name, target = f"{chapter}.ipynb", course / "mended" / student / chapter
    shutil.rmtree(target, ignore_errors=True)
    try:
        notebook, notes = mended(normalise.read(course / "submitted" / student / chapter / name), released)
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        return f"not graded: {' '.join(str(error).split())[:200]}"
    target.mkdir(parents=True)
    (target / name).write_text(normalise.dumps(notebook), encoding="utf-8")
    return "; ".join(notes)


def graded(chapter, course, students):
    """(student, marks, error) for each; a grader that dies or hangs at one student goes on with the next."""
    waiting = list(students)
    while waiting:
        process = subprocess.Popen(
            [extra_envs.python("grading"), "-c", GRADER, chapter, *waiting], cwd=course, env=variables(course),
            stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
        )  # fmt: skip
        watch = threading.Timer(STUDENT_TIMEOUT_S * len(waiting), process.kill)
        watch.start()
        for line in process.stdout:
            if line.startswith('{"student"'):
                said = json.loads(line)
                waiting.remove(said["student"])
                print(f"{said['student']}: {sum(said['marks'].values())} {said['error']}", flush=True)
                yield said["student"], said["marks"], said["error"]
        process.wait()
        watch.cancel()
        if waiting:
            yield waiting.pop(0), {}, "nbgrader stopped at this notebook"


def write_marks(path, rows):
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(dict.fromkeys(name for row in rows for name in row)), restval="")
        writer.writeheader()
        writer.writerows(rows)


def nbgrader(course, *arguments):
    """Run nbgrader in the course's folder. Raises `Stop` with its last words."""
    command = [extra_envs.python("grading"), "-m", "nbgrader", *arguments]
    done = subprocess.run(command, cwd=course, env=variables(course), capture_output=True, text=True, check=False)
    if done.returncode:
        lines = [line for line in done.stderr.splitlines() if line.strip()] or ["it said nothing"]
        raise Stop(f"nbgrader stopped: {lines[-1]}")


def variables(course):
    return {**extra_envs.variables("grading"), "OMX_VIEW": "static", "OMX_GENERATED": str(course / "generated")}


def main(argv=None):
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("what", choices=("assign", "grade"))
    parser.add_argument("chapter", help="such as 03-forward-kinematics")
    parser.add_argument("--course", type=Path, required=True, metavar="FOLDER", help="outside the book's own folder")
    parser.add_argument("--hidden", type=Path, metavar="FOLDER", help="hidden tests for `assign`")
    options = parser.parse_args(argv)
    course = Path(os.path.abspath(options.course))
    try:
        if options.what == "assign":
            print(assign(options.chapter, course, options.hidden))
        else:
            grade(options.chapter, course)
    except (Stop, Refused, OSError) as error:
        print(f"grading: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
