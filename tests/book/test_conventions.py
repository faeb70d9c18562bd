"""Every chapter keeps the conventions, and every convention can be broken: one broken chapter for each rule."""

import copy
import json

import pytest

from book.chapters import lint, new, normalise
from book.setup.paths import Stop
from tests.helpers.chapter import PROSE, chapter, code, markdown

CHAPTERS = sorted(normalise.NOTEBOOKS.glob("*.ipynb"))


@pytest.mark.parametrize("path", CHAPTERS, ids=lambda path: path.stem)
def test_chapter_keeps_the_conventions(path):
    found = lint.problems(path)
    assert not found, "\n".join(found)


def problems(tmp_path, cells, name="98-scratch.ipynb"):
    path = tmp_path / name
    normalise.write(path, normalise.normalise({"cells": cells, "nbformat": 4}))
    return lint.problems(path)


def whole():
    """The small chapter with all that students do in one: recall, six exercises, two of them symbolic, one broken."""
    *before, _, solution, check = chapter()
    answered = "<details><summary>Answer</summary>\n\nYes.\n\n</details>"
    recall = markdown(
        "## Before you begin\n\n" + "\n\n".join(f"**{i}.** Is it?\n\n{answered}" for i in (1, 2, 3)),
        "slide",
        ["recall"],
    )
    before.insert(3, recall)
    for i in range(1, 7):
        text = f"### Exercise 7.{i} · A line\n\n*Difficulty 2 of 5, about 10 minutes.*\n\n{PROSE}\n\n**Hint:** `hypot`."
        before.append(markdown(text, "subslide", ["exercise"]))
        before += [code("length = 5", "skip", ["broken"])] if i == 1 else []
        before.append(solution)
        symbolic = {**check, "source": "check.expression(length, 13)\n" + check["source"]}
        before.append(symbolic if i < 3 else check)
    words = markdown("**Model answer.** It is.\n\n**Rubric.** One point.", "skip", ["solution"])
    return [*before, markdown(text.replace("7.6", "7.7"), "subslide", ["exercise"]), words]


def test_a_good_chapter_has_no_problems(tmp_path):
    assert problems(tmp_path, whole()) == []


def replaced(old, new):
    def change(cells):
        hit = [cell for cell in cells if old in cell["source"]]
        assert hit, f"the good chapter does not contain {old!r}"
        hit[0]["source"] = hit[0]["source"].replace(old, new)

    return change


def added(*cells):
    return lambda chapter: chapter.extend(cells)


def metadata(old, **values):
    def change(cells):
        next(cell for cell in cells if old in cell["source"])["metadata"].update(values)

    return change


def outputs(*outputs):
    return added(code("1", outputs=list(outputs)))


def stream(text, name="stdout"):
    return {"output_type": "stream", "name": name, "text": text}


ERROR = {"output_type": "error", "ename": "ValueError", "evalue": "no", "traceback": []}

BROKEN = {
    "wants one H1": added(markdown("# A second title")),
    "wants a hook of one sentence": replaced("A straight line has a length.", "It is short. It is two."),
    "wants three items": replaced("- compute a length,", ""),
    "no 'You will be able to'": replaced("You will be able to", "Aims"),
    "no section '## Summary'": replaced("## Summary", "## End"),
    "no section '## Exercises'": replaced("## Exercises", "## Tasks"),
    "all imports belong in cell": added(code("from math import pi")),
    "unknown tag 'solutions'": added(code("1", tags=["solutions"])),
    "unknown tag 'nbval-skip'": added(code("1", tags=["nbval-skip"])),
    "has slide type 'slides'": metadata("A straight line", slideshow={"slide_type": "slides"}),
    "its slide type follows from that": metadata("## Summary", slideshow={"slide_type": "skip"}),
    "8 are wanted": added(code("\n".join(f"x{i} = {i}" for i in range(15))), code("y = 2\n" * 15)),
    "15 at most": added(markdown("word " * 300), code("y = 2\n" * 16)),
    "is not plain Python": added(code("%matplotlib inline")),
    "line 1": added(code("!ls")),
    "imports *": replaced("import math", "from math import *"),
    "imports urllib": replaced("import math", "import urllib.request, math"),
    "imports matplotlib": replaced("import math", "import matplotlib.pyplot as plt, math"),
    "uses sleep": added(code("time.sleep(1)")),
    "uses interact": added(code("widgets.interact(f)")),
    "uses Output": added(code("widgets.Output()")),
    "uses system": added(code("os.system('ls')")),
    "without a seed": added(code("np.random.default_rng()")),
    "uses numpy.random.normal": added(code("np.random.normal(0, 1)")),
    "holds an absolute path": added(code("open('/etc/hosts')")),
    "says TODO": added(code("x = 1  # TODO")),
    "is tagged 'check' after 'exercise'": metadata("length = math.hypot(5, 12)", tags=[]),
    "exercise without a hint": replaced("Hint:", ""),
    "does not begin with its heading": replaced("### Exercise 7.1", "**Exercise 1.**"),
    "ends with 'solution'": added(markdown("**Exercise 9** Hint: no", tags=["exercise"]), code("1", tags=["solution"])),
    "no cell tagged 'predict'": metadata("**Predict**", tags=[]),
    "no cell tagged 'play'": metadata("**Play**", tags=[]),
    "is a Predict without a note": metadata("**Expect**", slideshow={"slide_type": "-"}),
    "without alt text": added(markdown("![](98-scratch.ipynb)")),
    "has an <img> without alt text": added(markdown("<img src='a.png'>")),
    "points to 08-nowhere.ipynb": added(markdown("See [the next](08-nowhere.ipynb).")),
    "stores a warning": outputs(stream("careful\n", "stderr")),
    "stores an error without the tag": outputs(ERROR),
    "with an address": outputs(stream("<object at 0x7f3a5c0b1d30>\n")),
    "or an absolute path": outputs(stream("File /" + "home/someone/book\n")),
}


@pytest.mark.parametrize("message", BROKEN)
def test_each_violation_is_caught(tmp_path, message):
    cells = copy.deepcopy(chapter())
    BROKEN[message](cells)
    assert message in "\n".join(problems(tmp_path, cells))


def test_a_chapter_without_outputs_is_caught(tmp_path):
    cells = [{**cell, "outputs": []} if cell["cell_type"] == "code" else cell for cell in chapter()]
    assert "has no stored output at all" in "\n".join(problems(tmp_path, cells))


def test_a_name_without_number_is_caught(tmp_path):
    assert "is not called NN-topic.ipynb" in "\n".join(problems(tmp_path, chapter(), "Scratch.ipynb"))


def test_a_notebook_out_of_stored_form_is_caught(tmp_path):
    path = tmp_path / "98-scratch.ipynb"
    path.write_text(json.dumps(normalise.normalise({"cells": chapter(), "nbformat": 4})))
    assert "is not in stored form" in "\n".join(lint.problems(path))


def test_attachments_are_caught(tmp_path):
    cells = [*chapter(), {**markdown("![three good words](attachment:a.png)"), "attachments": {"a.png": {}}}]
    assert "carries an attachment" in "\n".join(problems(tmp_path, cells))


def test_the_start_chapter_needs_no_exercises(tmp_path):
    cells = [cell for cell in chapter() if "Exercises" not in cell["source"]]
    cells = [cell for cell in cells if not {"exercise", "solution", "check"} & set(cell["metadata"]["tags"])]
    assert problems(tmp_path, cells, "00-scratch.ipynb") == []
    assert "has no section '## Exercises'" in "\n".join(problems(tmp_path, cells))


# ---- a new chapter ----------------------------------------------------------------------------------------


def test_a_new_chapter_runs_and_lacks_only_its_words(monkeypatch, tmp_path):
    first = sorted(normalise.NOTEBOOKS.glob("*.ipynb"))[-1]
    (tmp_path / first.name).write_bytes(first.read_bytes())
    monkeypatch.setattr(new, "NOTEBOOKS", tmp_path)
    path = new.new("light-and-shadow")
    assert path.name == f"{int(first.name[:2]) + 1:02}-light-and-shadow.ipynb"
    complaints = lint.problems(path)
    left = (
        "still says «",
        "hook of one sentence",
        "are wanted",
        "has no program that is broken",
        "has no exercise in words",
    )
    assert all(any(words in line for words in left) for line in complaints), complaints
    with pytest.raises(Stop, match="hyphens"):
        new.new("Light and shadow")


def test_a_chapter_is_named_by_its_beginning():
    (path,) = normalise.chapters(["03"])
    assert path.name.startswith("03-")
    assert normalise.chapters([str(path)]) == [path]
    with pytest.raises(SystemExit, match="There is no chapter '77'"):
        normalise.chapters(["77"])


# ---- the student works ------------------------------------------------------------------------------------

EXERCISE = "### Exercise 7.{} · A name\n\n*Difficulty 2 of 5, about 10 minutes.*\n\nDo it. *Hint:* think."
RECALL = "\n\n".join("**Why?**\n\n<details><summary>Answer</summary>\n\nSo.\n\n</details>" for _ in range(3))
IN_WORDS = "**Model answer.** Because.\n\n**Rubric.** One point for the cause."


def a_working_chapter():
    cells = [markdown(RECALL, tags=["recall"])]
    for number in range(1, 7):
        cells.append(markdown(EXERCISE.format(number), tags=["exercise"]))
        if number == 6:
            cells.append(markdown(IN_WORDS, tags=["solution"]))
        else:
            cells += [code("x = 1", tags=["solution"]), code("check.expression(x, y)", tags=["check"])]
    cells.insert(2, code("def f(): return 2", tags=["broken"]))
    return cells


def test_a_chapter_in_which_the_student_works():
    assert list(lint.the_student_works(a_working_chapter())) == []
    assert list(lint.exercises(a_working_chapter())) == []


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("<summary>Answer</summary>", "", "wants one cell tagged 'recall'"),
        ("*Difficulty 2 of 5", "*Difficulty 6 of 5", "without a line"),
        ("check.expression(x, y)", "assert x", "0 exercises judged by"),
        ("def f(): return 2", None, "broken on purpose"),
        ("**Rubric.**", "Rubric:", "no exercise in words"),
        ("### Exercise 7.6", None, "5 exercises"),
    ],
)
def test_work_that_is_missing_is_named(old, new, message):
    changed = old if new is None else new
    cells = [{**cell, "source": cell["source"].replace(old, changed)} for cell in a_working_chapter()]
    cells = [cell for cell in cells if new is not None or old not in cell["source"]]
    assert message in "\n".join(what for _, what in lint.the_student_works(cells))


def test_what_the_exercises_take_together_is_their_sum():
    """Six of ten minutes: an hour; three quarters or an hour and a half are not."""
    for said, wrong in (
        ("an hour", 0), ("an hour and a quarter", 1), ("two hours", 1), ("an hour and leave room", 0),
        ("an hour and tenderly", 0), ("an hour and five minutes", 0), ("an hour and forty minutes", 1),
    ):  # fmt: skip
        cells = [*a_working_chapter(), markdown(f"Together they take about {said}.")]
        assert len(list(lint.the_minutes_add_up(cells))) == wrong


def test_an_answer_in_words_needs_no_check_but_code_does():
    cells = a_working_chapter()
    assert "ends with 'solution'" in str(list(lint.exercises([*cells[:-1], code("x = 1", tags=["solution"])])))
