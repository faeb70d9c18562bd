"""Hand out a chapter's exercises, and mark what comes back.

    python -m book.grading assign 03 --course FOLDER [--open] [--hidden FOLDER]
    python -m book.grading grade 03 --course FOLDER
    python -m book.grading marks --course FOLDER

`assign` writes FOLDER/release/03-....ipynb, to be handed out: its checks say only whether an answer is there; with
`--open` they say everything. It tries the full checks first: the book's solution must pass, an empty sheet and
nonsense must not. Collect answers in FOLDER/submitted/STUDENT/, under any name. `grade` writes marks-03-....csv and a
page of feedback for each student, and `marks` the totals over all chapters, for Moodle and Canvas, too.
"""

import argparse
import os
import sys
from pathlib import Path

from book.grading import gradebook
from book.grading.assign import assign
from book.grading.grade import grade
from book.setup import names
from book.setup.paths import ROOT, Stop, in_a_sentence


@in_a_sentence
def main(argv=None):
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("what", choices=("assign", "grade", "marks"))
    parser.add_argument("chapter", nargs="?", help="such as 03")
    parser.add_argument("--course", type=Path, required=True, metavar="FOLDER", help="outside the book's own folder")
    parser.add_argument("--hidden", type=Path, metavar="FOLDER", help="more tests, for `assign`")
    parser.add_argument("--open", action="store_true", help="`assign`: a sheet whose checks say everything")
    options = parser.parse_args(argv)
    if hasattr(sys.stdout, "reconfigure"):
        sys.stdout.reconfigure(errors="backslashreplace")  # a student may have any letters in a name
    course = Path(os.path.abspath(options.course))
    if course.is_relative_to(ROOT):
        raise Stop("Put the course's folder outside the book's own.")
    if options.what == "marks":
        print(*gradebook.totals(course), sep="\n")
    elif not options.chapter:
        raise Stop(f"`grading {options.what}` wants a chapter, such as 03.")
    elif options.what == "assign":
        print(assign(names.chapter(options.chapter), course, options.hidden, thin=not options.open))
    else:
        grade(names.chapter(options.chapter).stem, course)


if __name__ == "__main__":
    sys.exit(main())
