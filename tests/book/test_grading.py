"""A round of grading: right answers get their marks, odd ones a sentence, attacks nothing; no round is ever lost."""

import ast
import copy
import csv
import importlib
import json
import os

import mpmath
import pytest

from book.chapters import normalise
from book.chapters.cells import source, tags
from book.chapters.student import grade_id, student_copy
from book.grading import __main__ as command
from book.grading import gradebook, sandbox, student_run
from book.grading.assign import assign
from book.grading.grade import grade
from book.setup import names
from book.setup.paths import ROOT, Stop
from tests.helpers.chapter import chapter, code, markdown

NAME = "07-lines"
MORE = [
    code("import numpy as np\nimport omx\nfrom omx import check"),
    markdown("### Exercise 7.2 \N{MIDDLE DOT} half of it\n\n**Hint:** divide.", "subslide", ["exercise"]),
    code("def half(length):\n    return length / 2", "skip", ["solution"]),
    code(
        "samples = [1.0, -3.0, 8.0]\ncheck.function(half, lambda x: 0.5 * x, samples)\n"
        "check.that(abs(check.call(half, 0.0, gives=())) < 1e-9, 'Half of nothing is nothing.', 'nothing')",
        "skip",
        ["check"],
    ),
    markdown("### Exercise 7.3 \N{MIDDLE DOT} the hidden ones\n\n**Hint:** none.", "subslide", ["exercise"]),
    code("lost = {'L2', 'L3'}\nhow_many = 2", "skip", ["solution"]),
    code(
        "check.that({'L2', 'L3'} <= lost, 'Look at the links.', 'links')\ncheck.value(how_many, 2, 'how_many')",
        "skip",
        ["check"],
    ),
]
RIGHT = {
    "exercise-7-1-answer": "def diagonal(width, height):\n    return math.hypot(width, height)\n\nlength = 13.0",
    "exercise-7-2-answer": "def half(length):\n    return 0.5 * length",
    "exercise-7-3-answer": "lost = {'L2', 'L3', 'o2'}\nhow_many = 2",
}
NONSENSE = {
    "exercise-7-1-answer": "def diagonal(width, height):\n    return 0.0\n\nlength = 0.0",
    "exercise-7-2-answer": "def half(length):\n    return 0.0",
    "exercise-7-3-answer": "lost = set()\nhow_many = 7",
}
ENDLESS = "import time\n\ndef half(length):\n    while True:\n        time.sleep(0.01)"
FIND = (
    "\nimport json\ntexts = [''.join(c['source']) for p in found for c in json.load(open(p))['cells']]\nexec(texts[9])"
)
STEAL = "def half(length):\n    import sys\n{}\n    return max(v for v in seen if isinstance(v, float))"
#: What a student writes into the first answer cell, all other answers being nonsense. Nobody may get a mark for it,
#: except the two tenths that a half of 0.0 earns honestly.
ATTACKS = {
    "checks replaced by nothing": "import omx.check as c\nfor n in dir(c):\n    setattr(c, n, lambda *a, **k: None)",
    "the name check shadowed": "class Dummy:\n    def __getattr__(self, n):\n        return lambda *a, **k: None\n"
    "check = Dummy()",
    "the module of checks replaced": "import sys, types\nfake = types.ModuleType('omx.check')\n"
    "fake.value = fake.that = fake.function = lambda *a, **k: None\nsys.modules['omx.check'] = fake\nomx.check = fake",
    "what checks call replaced": "import omx.check.answers as a, omx.check.functions as f\n"
    "a.compare = f.compare = a.as_truth = lambda *x, **k: True",
    "the comparison's method replaced": "from omx.check.mistakes import Comparison\nComparison.same = lambda *a: True",
    "the error made harmless": "import omx.check.answers as a\na.Wrong = print",
    "NumPy replaced": "import numpy as np\nnp.asarray = lambda *a, **k: np.zeros(1)\nnp.all = lambda *a: True",
    "builtins replaced": "import builtins\nbuiltins.isinstance = lambda *a: True\nbuiltins.abs = lambda x: 0.0",
    "the code of a check replaced": "import omx.check.answers as a\na.value.__code__ = (lambda *a, **k: None).__code__",
    "checks replaced while they run": "def diagonal(width, height):\n    import omx.check.answers as a\n"
    "    a.compare = a.as_truth = lambda *x, **k: True\n    return 5.0",
    "a thread that goes on replacing them": "import threading, time, omx.check.functions as f\n"
    "def go():\n    while True:\n        f.compare = lambda *a, **k: None\n        time.sleep(0)\n"
    "threading.Thread(target=go, daemon=True).start()",
    "an answer that is equal to everything": "class Yes(set):\n    def __ge__(self, o):\n        return True\n"
    "    __le__ = __eq__ = __ge__\n    __hash__ = None\nYES = Yes()",
    "NumPy's inner modules replaced": "import numpy._core.numeric as n, numpy.linalg._linalg as g\n"
    "n.isclose = n.allclose = n.array_equal = lambda *a, **k: True\ng.norm = lambda *a, **k: 0.0",
    "the comparison's tolerances": "import types\nimport omx.check.answers as a, omx.check.functions as f\n"
    "for m in (a, f):\n    for v in list(vars(m).values()):\n        if isinstance(v, types.FunctionType):\n"
    "            v.__defaults__ = tuple(1e9 for _ in v.__defaults__ or ())\n"
    "            v.__kwdefaults__ = {k: 1e9 for k in v.__kwdefaults__ or {}}",
    "the arm itself changed": "object.__setattr__(omx.COURSE, 'L2', 0.0)",
    "the encoder of results": "import json\nold = json._default_encoder.encode\ndef encode(o):\n"
    "    if isinstance(o, dict) and 'passed' in o:\n        o['passed'] = True\n    return old(o)\n"
    "json._default_encoder.encode = encode\njson.JSONEncoder.encode = lambda s, o: encode(o)",
    "a number that is near everything": "class F(float):\n    __module__ = 'builtins'\n"
    "    __sub__ = __rsub__ = __abs__ = lambda s, *o: F(0)\n"
    "    __lt__ = __le__ = __gt__ = __ge__ = __eq__ = lambda s, o: True\n"
    "    __hash__ = float.__hash__\ndef diagonal(width, height):\n    return F(0)\nlength = F(0)",
    "an object inside a list": "class Yes(list):\n    __module__ = 'builtins'\n"
    "    def __sub__(s, o):\n        return 0.0\n"
    "    __rsub__ = __sub__\n    def __float__(s):\n        return 5.0\n    __eq__ = lambda s, o: True\n"
    "def diagonal(width, height):\n    return [Yes()]\nlength = [Yes()]",
    "the solutions beside the module": "from pathlib import Path\n"
    "found = sorted((Path(omx.__file__).parents[1] / 'notebooks').glob('*.ipynb'))" + FIND,
    "the solutions beside the interpreter": "import sys\nfrom pathlib import Path\n"
    "found = sorted((Path(sys.executable).parents[2] / 'notebooks').glob('0*.ipynb'))" + FIND,
    "the grader's key": "import os\nfound = [p for p in [COURSE + '/key/07-lines.json'] if open(p)]",
    "a neighbour's answers": "text = open(COURSE + '/submitted/right/07-lines.ipynb').read()\nexec(text)",
    "the copy of omx that all share": "import omx.check.answers as a\n"
    "open(a.__file__, 'a').write('\\nvalue = print\\n')",
    "the copy of omx, by a link": "import os, omx.check.answers as a\nos.link(a.__file__, 'mine')\n"
    "open('mine', 'a').write('\\nvalue = print\\n')",
    "a package for everybody": "import os, sympy\nfd = os.open(sympy.__file__, os.O_WRONLY)",
    "a file beside the packages": "import sqlite3, sympy\nsqlite3.connect(sympy.__path__[0] + '/../mine.pth')",
    "a file by readline's hand": "import readline, sympy\nreadline.append_history_file(0, sympy.__file__)",
    "a file by Tcl's hand": "import tkinter, sympy\ntkinter.Tcl().eval('open {' + sympy.__path__[0] + '/x.pth} w')",
    "another program": "import subprocess, sys\nsubprocess.run([sys.executable, '-c', 'print(1)'])",
    "a shell": "import os\nos.system('cat ' + COURSE + '/key/*')",
    "lines on every file descriptor": "import os\nline = b'{\"exercise\": \"exercise-7-2\", \"number\": 1, \"passed\": "
    "true, \"said\": \"\", \"nonce\": \"\"}\\n'\nfor n in range(1, 64):\n    try:\n        os.write(n, line)\n"
    "    except OSError:\n        pass",
    "the results file, found": "import glob, os, tempfile\nup = os.path.dirname\n"
    "for p in glob.glob(up(up(tempfile.gettempdir())) + '/*/*/*'):\n"
    "    try:\n        line = open(p).readline()\n    except OSError:\n        continue\n    NONCE = line[:60]",
    "all file descriptors closed": "import os\nos.closerange(3, 64)",
    "the parent killed": "import os\nos.kill(os.getppid(), 9)",
    "the caller's frame": STEAL.format("    seen = sys._getframe(1).f_back.f_locals.values()"),
    "the caller's frame by an error": STEAL.format(
        "    try:\n        1 / 0\n    except ZeroDivisionError as e:\n"
        "        seen = e.__traceback__.tb_frame.f_back.f_locals.values()"
    ),
    "the caller's frame by inspect": STEAL.format(
        "    import inspect\n    seen = inspect.stack()[1].frame.f_locals.values()"
    ),
    "all objects": "import gc\nfound = [o for o in gc.get_objects() if isinstance(o, dict) and 'statements' in o]",
    "a tracer": "import sys\nsys.settrace(lambda *a: None)",
    "code in a file's name": "exec(compile('import sys; found = sys._getframe(0)', omx.__file__, 'exec'))",
    "the end of the program": "import os\nos._exit(0)",
    "an exit": "raise SystemExit(0)",
    "an interrupt": "raise KeyboardInterrupt",
    "all memory": "hoard = [bytearray(10**9) for _ in range(10**6)]",
    "a wall of text": "print('x' * 10**7)",
    "a loop": "while True:\n    pass",
}  # fmt: skip


@pytest.fixture(scope="module")
def book(tmp_path_factory):
    """The scratch chapter's file."""
    path = tmp_path_factory.mktemp("book") / f"{NAME}.ipynb"
    cells = [*chapter()[:4], MORE[0], *chapter()[4:], *MORE[1:]]
    normalise.write(path, normalise.normalise({"cells": cells, "nbformat": 4}))
    return path


@pytest.fixture(scope="module")
def sheet(book):
    return student_copy(normalise.read(book))


def cell_of(submission, name):
    return next(cell for cell in submission["cells"] if grade_id(cell) == name)


def answered(sheet, answers=RIGHT, **changes):
    """The sheet with these answers, but for `changes`: `_2="..."`."""
    submission = copy.deepcopy(sheet)
    for name, text in {**answers, **{f"exercise-7-{k[1:]}-answer": v for k, v in changes.items()}}.items():
        cell_of(submission, name)["source"] = text
    return submission


def without(submission, *names):
    submission["cells"] = [cell for cell in submission["cells"] if grade_id(cell) not in names]
    return submission


def duplicated(sheet):
    submission = answered(sheet)
    place = submission["cells"].index(cell_of(submission, "exercise-7-2-answer"))
    twin = copy.deepcopy(submission["cells"][place])
    submission["cells"][place]["source"] = "def half(length):\n    return abs(length) / 2"
    submission["cells"].insert(place + 1, {**twin, "id": "twin"})
    return submission


def turned_to_markdown(sheet):
    submission = answered(sheet)
    cell = cell_of(submission, "exercise-7-1-answer")
    cell["cell_type"] = "markdown"
    del cell["outputs"], cell["execution_count"]
    return submission


def without_metadata(sheet):
    submission = answered(sheet)
    for cell in submission["cells"]:
        cell["metadata"] = {}
    return submission


def without_all_names(sheet):
    """As some programs store a notebook: neither ids nor metadata."""
    submission = without_metadata(sheet)
    for cell in submission["cells"]:
        del cell["id"]
    return submission


def with_damage(sheet):
    submission = answered(sheet)
    cell_of(submission, "exercise-7-2-answer")["source"] = 7
    submission["cells"][2:2] = [7, {"cell_type": "code"}, {**submission["cells"][2], "metadata": []}]
    return submission


def backwards(sheet):
    submission = answered(sheet)
    return {**submission, "cells": submission["cells"][::-1]}


def answer_moved_to_the_end(sheet):
    submission = answered(sheet)
    submission["cells"].append(
        submission["cells"].pop(submission["cells"].index(cell_of(submission, "exercise-7-2-answer")))
    )
    return submission


def answered_below_the_check(sheet):
    """A copy of the answer cell, pasted behind its check and filled in there."""
    submission = answered(sheet, _2="def half(length):\n    raise NotImplementedError")
    place = submission["cells"].index(cell_of(submission, "exercise-7-2-check"))
    twin = {**cell_of(submission, "exercise-7-2-answer"), "id": "twin", "source": RIGHT["exercise-7-2-answer"]}
    submission["cells"].insert(place + 1, twin)
    return submission


def with_a_helper(sheet):
    submission = answered(sheet, _2="def half(length):\n    return divided(length)")
    submission["cells"].insert(5, {**code("%matplotlib inline\ndef divided(x):\n    return x / 2"), "id": "mine"})
    return submission


#: student: (what is handed in, marks, a word in the notes)
ODD = {
    "right": (answered, 3, ""),
    "untouched": (lambda s: s, 0, ""),
    "one-criterion": (lambda s: answered(s, _3="lost = {'L2', 'L3'}\nhow_many = 3"), 2.5, ""),
    "raises": (lambda s: answered(s, _1="raise RuntimeError('lost')"), 2, ""),
    "endless": (lambda s: answered(s, _2=ENDLESS), 2, "did not come to an end"),
    "ends-it-all": (lambda s: answered(s, _2="import os\nos._exit(0)"), 2, "or ended the program"),
    "duplicated": (duplicated, 3, "the last one counts"),
    "check-deleted": (lambda s: without(answered(s), "exercise-7-2-check"), 3, "check: was deleted"),
    "answer-deleted": (lambda s: without(answered(s), "exercise-7-2-answer"), 2, "was deleted"),
    "check-edited": (lambda s: answered(s, _2="half = 3"), 2, ""),
    "to-markdown": (turned_to_markdown, 3, "was turned to markdown"),
    "no-metadata": (without_metadata, 3, ""),
    "helper-and-magic": (with_a_helper, 3, ""),
    "awaits": (
        lambda s: answered(s, _2=f"import asyncio\nawait asyncio.sleep(0)\n{RIGHT['exercise-7-2-answer']}"),
        3,
        "",
    ),
    "half-a-letter": (lambda s: answered(s, _1="raise ValueError('\\ud800')"), 2, ""),
    "no-names": (without_all_names, 3, ""),
    "damaged": (with_damage, 2, "cell 3 is damaged and was left out; cell 4 is damaged and was left out; cell 5 is"),
    "backwards": (backwards, 3, "another order than in the sheet"),
    "moved": (answer_moved_to_the_end, 3, "another order than in the sheet"),
    "below-the-check": (answered_below_the_check, 3, "exercise-7-2-answer: is there 2 times; the last one counts"),
    "timed-cell": (lambda s: answered(s, _2=f"%%time\n{RIGHT['exercise-7-2-answer']}"), 3, ""),
}


@pytest.fixture(scope="module")
def course(book, sheet, tmp_path_factory):
    """A course of honest, odd and dishonest students, graded twice over with the same end."""
    folder = tmp_path_factory.mktemp("course")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(student_run, "CELL_TIMEOUT_S", 6)
        assign(book, folder)
        for student, (make, _, _) in ODD.items():
            hand_in(folder, student, normalise.dumps(make(sheet)))
        for name, attack in ATTACKS.items():
            text = (
                attack
                if "def diagonal" in attack or "def half" in attack
                else f"{attack}\n\n{NONSENSE['exercise-7-1-answer']}"
            )
            text = f"COURSE = {str(folder)!r}\n" + text
            third = NONSENSE["exercise-7-3-answer"] + ("\nlost = YES" if "YES" in attack else "")
            changes = {"_2": text, "_3": third} if "def half" in attack else {"_1": text, "_3": third}
            hand_in(folder, f"attack {name}", normalise.dumps(answered(sheet, NONSENSE, **changes)))
        hand_in(folder, "browser", normalise.dumps(answered(sheet)), f"{NAME} (1).ipynb")
        hand_in(folder, "renamed", normalise.dumps(answered(sheet)), "Ä chapter.ipynb")
        hand_in(folder, "windows", "\ufeff" + normalise.dumps(answered(sheet)).replace("\n", "\r\n"))
        for kind in ("utf-16", "utf-16-le", "utf-32", "latin-1"):
            hand_in(folder, kind, json.dumps(answered(sheet), ensure_ascii=False), encoding=kind)
        hand_in(folder, "broken", "this is no notebook")
        hand_in(folder, "deep", "[" * 10**5)
        hand_in(folder, "old", json.dumps({"nbformat": 3, "worksheets": []}))
        hand_in(folder, "twice", normalise.dumps(sheet))
        hand_in(folder, "twice", normalise.dumps(answered(sheet)), "newer.ipynb")
        os.utime(folder / "submitted" / "twice" / f"{NAME}.ipynb", (0, 0))
        hand_in(folder, "fuller", normalise.dumps(answered(sheet)))
        hand_in(folder, "fuller", normalise.dumps(sheet), "a copy, never filled in.ipynb")
        os.utime(folder / "submitted" / "fuller" / f"{NAME}.ipynb", (0, 0))
        hand_in(folder, "archived", "PK", "all of it.zip")
        hand_in(folder, "as-a-page", "<html>", f"{NAME}.html")
        (folder / "submitted" / "empty").mkdir()
        (folder / "submitted" / ".DS_Store").write_text("")
        (folder / "submitted" / "readme.txt").write_text("")
        students = ["right", "one-criterion", "absent", "broken"]
        (folder / "roster.csv").write_text(
            "student,name,email,id\n"
            + "".join(f"{s},=Name of {s},{s}@uni.example,{n}\n" for n, s in enumerate(students))
        )
        grade(NAME, folder)
    return folder


def hand_in(folder, student, text, name=f"{NAME}.ipynb", encoding="utf-8"):
    place = folder / "submitted" / student
    place.mkdir(parents=True, exist_ok=True)
    (place / name).write_text(text, encoding=encoding, newline="")


def rows(course, name=f"marks-{NAME}.csv", key="student"):
    with open(course / name, newline="", encoding="utf-8") as file:
        return {row[key]: row for row in csv.DictReader(file)}


@pytest.mark.parametrize("student", ODD)
def test_each_submission_ends_with_the_right_mark(course, student):
    row, (_, wanted, note) = rows(course)[student], ODD[student]
    assert (float(row["marks"]), row["of"]) == (wanted, "3"), row
    assert note in row["notes"]
    assert "flagged" not in row["notes"]
    assert note or not row["notes"].removeprefix("not on the roster").removeprefix("; "), "no sentence without a cause"


@pytest.mark.parametrize("name", ATTACKS)
def test_no_attack_is_worth_a_mark(course, name):
    row = rows(course)[f"attack {name}"]
    assert row["of"] == "3"
    assert float(row["marks"] or 0) <= 0.5, row
    assert row["exercise-7-1"] == row["exercise-7-3"] == "0", row


def test_attacks_are_flagged(course):
    flagged = [name for name in ATTACKS if "flagged" in rows(course)[f"attack {name}"]["notes"]]
    harmless = {
        *("the name check shadowed", "the solutions beside the module", "all file descriptors closed"),
        *("the end of the program", "an exit", "an interrupt", "all memory", "a wall of text", "a loop"),
    }
    print({name: rows(course)[f"attack {name}"]["notes"] for name in ATTACKS})
    assert set(ATTACKS) - set(flagged) <= harmless


def test_what_lies_in_a_module_from_the_beginning_is_nobodys_doing():
    assert importlib.import_module("sympy.physics.units.definitions.unit_definitions").bytes, "a unit"
    keeper = sandbox.Keeper()
    assert keeper.put_back() == ""
    mpmath.MPContext()  # makes the methods of its class again
    assert keeper.put_back(made_anew=True) == ""
    assert keeper.put_back() == "", "they are those that were there before"


def test_what_a_check_says_in_a_loop_is_told_once():
    said = "for i in range(9):\n    print('Correct: limits.')\n    print('Correct: height.')"
    assert sandbox.attempt(said, {}, sandbox.Keeper(), False) == ("", "Correct: limits. Correct: height.")


def test_odd_files_get_their_mark_or_a_sentence(course):
    found = rows(course)
    assert found["browser"]["marks"] == found["renamed"]["marks"] == found["windows"]["marks"] == "3"
    assert f"graded: {NAME} (1).ipynb" in found["browser"]["notes"]
    assert found["twice"]["marks"] == found["fuller"]["marks"] == "3"
    for kind in ("utf-16", "utf-16-le", "utf-32", "latin-1"):
        assert found[kind]["marks"] == "3", kind
    assert "its letters are not stored as UTF-8" in found["latin-1"]["notes"]
    assert "2 notebooks of this chapter" in found["twice"]["notes"]
    for student in ("broken", "old", "deep", "empty", "absent"):
        assert found[student]["marks"] == found[student]["exercise-7-1"] == "", "what was not graded is blank, not 0"
    assert "not graded: it is not a notebook" in found["broken"]["notes"]
    assert "not graded: it is a notebook of another format" in found["old"]["notes"]
    assert "nothing handed in" in found["empty"]["notes"]
    assert "nothing handed in" in found["absent"]["notes"]
    assert "nothing handed in but all of it.zip: this chapter's notebook is wanted" in found["archived"]["notes"]
    assert f"nothing handed in but {NAME}.html" in found["as-a-page"]["notes"]
    assert not {".DS_Store", "readme.txt", "readme"} & set(found)
    assert "not on the roster" in found["raises"]["notes"]
    assert not any(str(ROOT) in row["notes"] for row in found.values())


def test_feedback_is_a_page_with_the_checks_own_words(course):
    page = (course / "feedback" / NAME / "one-criterion.md").read_text()
    assert "one-criterion: **2.5 of 3**" in page
    assert "## Exercise 7.3 \N{MIDDLE DOT} the hidden ones: 0.5 of 1" in page
    assert "- ✗ how_many is not right." in page
    assert "- ✓ links." in page
    assert "(course" not in page
    assert "RuntimeError: lost" in (course / "feedback" / NAME / "raises.md").read_text()


def test_totals_go_into_tables_for_moodle_and_canvas(course):
    for path in gradebook.totals(course):
        assert path.exists()
    assert rows(course, "marks.csv")["one-criterion"] == {"student": "one-criterion", NAME: "2.5", "total (%)": "83.3"}
    assert rows(course, "marks.csv")["absent"][NAME] == ""
    moodle = rows(course, "moodle.csv", "Email address")
    assert (moodle["right@uni.example"][NAME], moodle["absent@uni.example"][NAME]) == ("3", "-")
    canvas = rows(course, "canvas.csv", "SIS Login ID")
    assert canvas["right"]["Student"] == "'=Name of right", "a spreadsheet must not take a name for a formula"
    assert canvas[""][NAME] == "3"


def test_points_weights_and_lateness_are_the_courses_own(course, tmp_path):
    (tmp_path / "course.toml").write_text(
        '[points]\n"7.2" = 4\n[due]\n"07" = 2026-03-01T12:00:00\n[late]\nper_day = 0.1\nat_most = 0.25\n'
        '[days_late]\n"07" = { ada = 0 }\n[weights]\n"07" = 2\n')  # fmt: skip
    rules, path = gradebook.Rules(tmp_path), tmp_path / "sheet.ipynb"
    path.touch()
    assert rules.points({"name": "exercise-7-2", "points": 1}) == 4
    assert rules.points({"name": "exercise-7-1", "points": 1}) == 1
    assert rules.weight(NAME) == 2
    due = rules.tables["due"]["07"].timestamp()
    for hours, factor, note in (
        (-1, 1.0, []),
        (1, 0.9, ["1 day late: 10% off"]),
        (100, 0.75, ["5 days late: 25% off"]),
    ):
        os.utime(path, (due + 3600 * hours, due + 3600 * hours))
        assert rules.late(NAME, "bob", path) == (factor, note)
    assert rules.late(NAME, "ada", path) == (1.0, [])
    key = {"exercises": [{"name": "exercise-7-2"}]}
    rules.refuse_unknown(key, NAME)
    rules.refuse_unknown({"exercises": []}, "08-others")
    for text, sentence in (
        ("[wieghts]\n", r"has \[wieghts\]"),
        ('[due]\n"7" = 2026-03-01T12:00:00\n', r'\[due\]: 7 = .* is written "03"'),
        ("[late]\nper_days = 0.1\n", r"\[late\]: per_days = 0.1 cannot be; it is written per_day = 0.1"),
        ('[points]\n"7.9" = 2\n', "07 has no exercise 7.9"),
        ('[days_late]\n"07" = { adda = 0 }\n', "adda is not on the roster"),
    ):
        (tmp_path / "course.toml").write_text(text)
        (tmp_path / "roster.csv").write_text("student\nada\n")
        with pytest.raises(Stop, match=sentence):
            gradebook.Rules(tmp_path).refuse_unknown(key, NAME)


# ---- handing out -------------------------------------------------------------------------------------------


def test_a_thin_sheet_shows_neither_answer_nor_reference(course, book):
    text = (course / "release" / f"{NAME}.ipynb").read_text()
    for secret in ("sqrt", "length / 2", "0.5 * x", "'L2'", "check.value"):
        assert secret not in text
    assert "check.handed_in(half=half)" in text
    assert "check.handed_in(lost=lost, how_many=how_many)" in text


def test_hidden_tests_must_belong_to_an_exercise(book, tmp_path):
    place = tmp_path / "hidden" / NAME
    with pytest.raises(Stop, match="There is no folder"):
        assign(book, tmp_path / "course", tmp_path / "hidden")
    place.mkdir(parents=True)
    with pytest.raises(Stop, match="holds no hidden tests"):
        assign(book, tmp_path / "course", tmp_path / "hidden")
    (place / "exercise-7.2.py").write_text("assert True")
    with pytest.raises(Stop, match=r"holds exercise-7.2.py, but the exercises are exercise-7-1, exercise-7-2"):
        assign(book, tmp_path / "course", tmp_path / "hidden")


def test_hidden_tests_are_tried_on_the_solution_and_count(book, sheet, tmp_path, capsys):
    place, course = tmp_path / "hidden" / NAME, tmp_path / "course"
    place.mkdir(parents=True)
    (place / "exercise-7-2.py").write_text("assert half(2) == 2, 'this is wrong'")
    with pytest.raises(Stop, match=r"Exercise 7.2 .* the book's own solution does not pass: .*this is wrong"):
        assign(book, course, tmp_path / "hidden")
    (place / "exercise-7-2.py").write_text("assert half(np.array([2.0, 4.0])).tolist() == [1, 2]")
    capsys.readouterr()
    assign(book, course, tmp_path / "hidden")
    told = capsys.readouterr().out.splitlines()
    assert len(told) == 3
    assert all(f"trial {n} of 3" in line for n, line in enumerate(told, 1))
    assert "tolist" not in (course / "release" / f"{NAME}.ipynb").read_text()
    hand_in(course, "plain", normalise.dumps(answered(sheet, _2="def half(x):\n    return float(x) / 2")))
    (row,) = grade(NAME, course)
    assert row["exercise-7-2"] == 0.67


def test_a_check_that_accepts_an_empty_sheet_is_refused(tmp_path):
    cells = [*chapter()[:-1], code("assert True", "skip", ["check"])]
    path = tmp_path / f"{NAME}.ipynb"
    normalise.write(path, normalise.normalise({"cells": cells, "nbformat": 4}))
    with pytest.raises(Stop, match="its check accepts an empty sheet"):
        assign(path, tmp_path / "course")


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["assign", "99", "--course", "COURSE"], "There is no chapter '99'"),
        (["grade", "03", "--course", "COURSE"], "was not assigned in"),
        (["grade", "--course", "COURSE"], "wants a chapter, such as 03"),
        (["marks", "--course", "COURSE"], "holds no marks yet"),
        (["assign", "03", "--course", str(ROOT / "build" / "course")], "outside the book's own"),
    ],
)
def test_the_command_says_in_a_sentence_what_is_wrong(arguments, sentence, tmp_path, capsys):
    assert command.main([str(tmp_path) if word == "COURSE" else word for word in arguments]) == 1
    assert sentence in capsys.readouterr().err


# ---- the book's own checks ----------------------------------------------------------------------------------------


def names_in(text, context):
    return {
        node.id for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Name) and isinstance(node.ctx, context)
    }


@pytest.mark.parametrize("path", names.chapters(), ids=lambda path: path.stem)
def test_no_check_needs_what_another_check_has_made(path):
    """Who skips an exercise, and the grader, who runs each check alone, must not miss its names."""
    made, elsewhere = set(), set()
    for cell in normalise.read(path)["cells"]:
        if cell["cell_type"] == "code" and "check" in tags(cell):
            own, missing = set(), set()
            for statement in ast.parse(source(cell)).body:
                text = ast.unparse(statement)
                read = names_in(text, ast.Load)
                if isinstance(statement, ast.AugAssign):
                    read |= names_in(text, ast.Store)
                else:
                    own |= names_in(text, ast.Store) | {n.arg for n in ast.walk(statement) if isinstance(n, ast.arg)}
                missing |= (read - own) & (elsewhere - made)
            assert not missing, cell["id"]
            elsewhere |= own
        elif cell["cell_type"] == "code":
            made |= names_in(source(cell), ast.Store) | {
                node.name for node in ast.walk(ast.parse(source(cell))) if isinstance(node, ast.FunctionDef)
            }


ALL_CHECKS = names.chapters() if os.environ.get("OMX_ALL_CHECKS") else []


@pytest.mark.parametrize("path", ALL_CHECKS, ids=lambda path: path.stem)
def test_each_check_of_the_book_knows_its_solution_and_refuses_nothing_and_nonsense(path, tmp_path):
    """Minutes for all chapters: `OMX_ALL_CHECKS=1` asks for it. `assign` does the same for the one it hands out."""
    assign(path, tmp_path)
