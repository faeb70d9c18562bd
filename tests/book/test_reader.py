"""The reader's folder: copies that nothing of ours overwrites, answers that survive a new edition, clean saving."""

import copy
import datetime
import json
import os
import re
import shutil
import subprocess
import threading

import pytest

from book.chapters import normalise
from book.chapters.cells import is_code, is_note, source, tags
from book.reader import folder, handin, merge, overview, saving, solutions
from book.setup import names
from book.setup.file_lock import one_at_a_time
from book.setup.paths import ENVIRONMENT, NOTEBOOKS, ROOT, WORK, Stop
from omx.check import passed
from tests.book.test_run import UV, Clone
from tests.helpers.chapter import chapter, code, markdown

ANSWER = "def diagonal(width, height):\n    return 5  # my own answer\n\nlength = 13"


@pytest.fixture
def book(tmp_path, monkeypatch):
    """A book of two small chapters and an empty folder for a reader: (notebooks, work)."""
    notebooks, work = tmp_path / "notebooks", tmp_path / "work"
    notebooks.mkdir()
    for module in (names, normalise):
        monkeypatch.setattr(module, "NOTEBOOKS", notebooks)
    store(notebooks / "07-lines.ipynb", [*chapter(), markdown("The answer is 13.", "notes")])
    store(notebooks / "08-more.ipynb", chapter())
    folder.prepare(work)
    return notebooks, work


def store(path, cells):
    normalise.write(path, normalise.normalise({"cells": cells, "nbformat": 4}))


def edit(path, change):
    """Change the cells of a stored notebook as JupyterLab does: in place, ids kept."""
    notebook = normalise.read(path)
    change(notebook["cells"])
    path.write_text(json.dumps(notebook, indent=1), encoding="utf-8")


def solution_of(path):
    return next(cell for cell in normalise.read(path)["cells"] if "solution" in tags(cell))


def answer(cells):
    next(cell for cell in cells if "solution" in tags(cell))["source"] = ANSWER


def texts(path):
    return [source(cell) for cell in normalise.read(path)["cells"]]


def test_a_chapter_with_another_number_keeps_its_answers(book):
    notebooks, work = book
    edit(work / "08-more.ipynb", answer)
    (notebooks / "07-lines.ipynb").rename(notebooks / "08-lines.ipynb")
    (notebooks / "08-more.ipynb").rename(notebooks / "07-more.ipynb")
    folder.prepare(work)
    assert source(solution_of(work / "07-more.ipynb")) == ANSWER
    assert sorted(path.name for path in work.glob("*-*.ipynb")) == ["07-more.ipynb", "08-lines.ipynb"]


# ---- copies --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("path", names.chapters(), ids=lambda path: path.stem)
def test_a_readers_copy_holds_no_solution_output_or_note_and_leads_on(path):
    cells, chapters = folder.edition(path)["cells"], names.chapters()
    assert not any(is_note(cell) for cell in cells)
    assert not any(cell.get("outputs") for cell in cells)
    assert all("TODO" in source(cell) or "Your answer" in source(cell) for cell in cells if "solution" in tags(cell))
    near = [other.name for other in chapters if abs(chapters.index(other) - chapters.index(path)) == 1]
    for cell in (cells[0], cells[-1]):
        assert all(f"]({name})" in source(cell) for name in [overview.NAME, *near])
    assert len({cell["id"] for cell in cells}) == len(cells)


def test_an_untouched_copy_follows_the_chapter_and_keeps_its_outputs(book):
    notebooks, work = book
    printed = {"output_type": "stream", "name": "stdout", "text": ["5.0 mm\n"]}
    edit(work / "07-lines.ipynb", lambda cells: cells[6].update(outputs=[printed], execution_count=3))
    edit(notebooks / "07-lines.ipynb", lambda cells: cells[2].update(source="A better word."))
    assert folder.prepare(work) == []
    assert "A better word." in texts(work / "07-lines.ipynb")
    assert normalise.read(work / "07-lines.ipynb")["cells"][6]["outputs"] == [printed]
    assert not (work / "earlier").exists()


def test_an_answer_waits_for_update_and_survives_it(book, capsys):
    notebooks, work = book
    edit(work / "07-lines.ipynb", answer)
    before = (work / "07-lines.ipynb").read_text()
    edit(notebooks / "07-lines.ipynb", lambda cells: cells[2].update(source="A better word."))
    assert folder.prepare(work) == ["07-lines.ipynb"]
    assert (work / "07-lines.ipynb").read_text() == before, "starting JupyterLab changes nothing"
    folder.carry_over(work)
    assert "A better word." in texts(work / "07-lines.ipynb")
    assert source(solution_of(work / "07-lines.ipynb")) == ANSWER
    assert (work / "earlier" / "07-lines-1.ipynb").read_text() == before
    assert "earlier/07-lines-1.ipynb" in capsys.readouterr().out
    assert folder.prepare(work) == []


def test_reset_gives_the_chapter_and_keeps_what_it_replaces(book, capsys):
    _, work = book
    fresh = (work / "07-lines.ipynb").read_text()
    for number in (1, 2):
        edit(work / "07-lines.ipynb", answer)
        folder.reset("lines", work)
        assert (work / "07-lines.ipynb").read_text() == fresh
        assert source(solution_of(work / "earlier" / f"07-lines-{number}.ipynb")) == ANSWER
    folder.reset("7", work)
    assert len(list((work / "earlier").iterdir())) == 2, "an untouched copy needs no keeping"
    (work / "08-more.ipynb").write_text("{ half")
    folder.prepare(work)
    assert (work / "08-more.ipynb").read_text() == "{ half", "damaged, and still the reader's"
    folder.reset("8", work)
    assert (work / "earlier" / "08-more-1.ipynb").read_text() == "{ half"


def test_two_terminals_take_turns(monkeypatch):
    begun = threading.Event()
    monkeypatch.setattr(folder, "reset", lambda chapter: begun.set())
    other = threading.Thread(target=folder.main, args=(["reset", "07"],))
    with one_at_a_time(ENVIRONMENT):
        other.start()
        assert not begun.wait(0.5)
    assert begun.wait(10)
    other.join()


def test_a_copy_of_the_book_elsewhere_hands_over_its_answers(book, tmp_path):
    _, work = book
    edit(work / "07-lines.ipynb", answer)
    (work / "mine.py").write_text("x = 1")
    new = tmp_path / "new"
    folder.prepare(new)
    edit(new / "08-more.ipynb", answer)
    edit(work / "08-more.ipynb", lambda cells: cells[3].update(source="another remark"))
    folder.take_along(tmp_path, new)
    assert source(solution_of(new / "07-lines.ipynb")) == ANSWER
    assert source(solution_of(new / "08-more.ipynb")) == ANSWER, "what was done here stays"
    assert "another remark" in texts(new / "earlier" / "08-more-1.ipynb")
    assert (new / "mine.py").read_text() == "x = 1"
    with pytest.raises(Stop, match="is this copy of the book itself"):
        folder.take_along(work, work)
    with pytest.raises(Stop, match="holds no folder `work`"):
        folder.take_along(tmp_path / "nowhere", new)


def test_a_notebook_that_lost_its_ids_is_left_alone(book, capsys):
    notebooks, work = book
    edit(work / "07-lines.ipynb", lambda cells: [cell.pop("id") for cell in cells])
    before = (work / "07-lines.ipynb").read_text()
    edit(notebooks / "07-lines.ipynb", lambda cells: cells[2].update(source="A better word."))
    folder.carry_over(work)
    assert (work / "07-lines.ipynb").read_text() == before
    assert "`reset 07` gives the new edition" in capsys.readouterr().out


@pytest.mark.skipif(UV is None, reason="uv is not installed")
def test_update_fetches_an_edition_and_loses_nothing(tmp_path):
    """The whole command, in a checkout of a book whose sources the reader has dirtied, too."""
    clone = Clone(tmp_path)
    for part in ("chapters", "reader"):
        shutil.copytree(ROOT / "book" / part, clone.root / "book" / part)
    (clone.root / "notebooks").mkdir()
    store(clone.root / "notebooks" / "07-lines.ipynb", chapter())
    (clone.root / ".gitignore").write_text("/.venv/\n/work/\n__pycache__/\n")
    upstream = clone.root
    git(upstream, "init", "-q", "-b", "main")
    commit(upstream)
    clone.root = tmp_path / "the reader's"
    git(tmp_path, "clone", "-q", str(upstream), str(clone.root))
    assert "up to date" in updated(clone)
    edit(clone.root / "work" / "07-lines.ipynb", answer)
    edit(clone.root / "notebooks" / "07-lines.ipynb", answer)
    assert "This is the newest edition." in updated(clone)
    edit(upstream / "notebooks" / "07-lines.ipynb", lambda cells: cells[2].update(source="A better word."))
    commit(upstream)
    said = updated(clone)
    assert "A new edition is here" in said
    kept = re.search(r"notebooks/07-lines.ipynb was changed here: yours is kept as (work/earlier/.*\.ipynb)", said)[1]
    assert source(solution_of(clone.root / kept)) == ANSWER
    assert source(solution_of(clone.root / "work" / "07-lines.ipynb")) == ANSWER
    assert "A better word." in texts(clone.root / "work" / "07-lines.ipynb")
    assert git(clone.root, "status", "--porcelain") == ""
    (clone.root / "run.py").write_text("# mine\n" + (clone.root / "run.py").read_text())
    (upstream / "run.py").write_text("# theirs\n" + (upstream / "run.py").read_text())
    commit(upstream)
    done = clone.run("update")
    assert done.returncode == 1
    assert "You changed run.py: commit that or put it elsewhere" in done.stderr


def updated(clone):
    done = clone.run("update")
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def git(cwd, *arguments):
    who = ("-c", "user.name=a", "-c", "user.email=a@b", "-c", "commit.gpgsign=false")
    return subprocess.run(["git", *who, *arguments], cwd=cwd, capture_output=True, text=True, check=True).stdout


def commit(root):
    git(root, "add", "-A")
    git(root, "commit", "-qm", "an edition")


# ---- merging, case by case -----------------------------------------------------------------------------


def cell(name, text, **more):
    return {"id": name, "cell_type": "code", "metadata": {}, "source": text, "outputs": [], **more}


def merged(mine, given="abc", fresh="abc"):
    """Notebooks as words: each letter a cell of this id; `x=` in front of a text says what it holds."""

    def notebook(words):
        parts = words.split() if " " in words or "=" in words else words
        return {"cells": [cell(word[0], word.partition("=")[2] or word[0]) for word in parts]}

    done = merge.merged(notebook(mine), notebook(given), notebook(fresh))["cells"]
    assert len({c["id"] for c in done}) == len(done)
    return " ".join(c["id"][0] if c["source"] == c["id"][0] else f"{c['id']}={c['source']}" for c in done)


@pytest.mark.parametrize(
    ("mine", "given", "fresh", "expected"),
    [
        ("abc", "abc", "abc", "a b c"),
        ("abc", "abc", "a b=new c", "a b=new c"),
        ("a b=mine c", "abc", "abc", "a b=mine c"),
        ("a b=mine c", "abc", "a=new b c", "a=new b=mine c"),
        ("a b=mine c", "abc", "a b=new c", "a b=new b-mine=mine c"),
        ("a b=same c", "abc", "a b=same c", "a b=same c"),
        ("a x b c", "abc", "abc", "a x b c"),
        ("a x y b c", "abc", "ac", "a x y c"),
        ("x a b c", "abc", "abc", "x a b c"),
        ("a b=mine c", "abc", "ac", "a b=mine c"),
        ("abc", "abc", "a n c", "a n c"),
        ("ac", "abc", "abc", "a c"),
        ("ac", "abc", "a b=new c", "a b=new c"),
        ("abc", "abc", "cab", "c a b"),
        ("a b c x", "abc", "abcd", "a b c x d"),
        ("a b=mine x c", "abc", "a b=new c", "a b=new b-mine=mine x c"),
    ],
)
def test_merging(mine, given, fresh, expected):
    assert merged(mine, given, fresh) == expected


def test_an_answer_stays_alone_where_its_todo_changed():
    given, fresh = (cell("s", text, metadata={"tags": ["solution"]}) for text in ("TODO old", "TODO new"))
    own = {**copy.deepcopy(given), "source": "x = 1"}
    assert merge.merged(*({"cells": [c]} for c in (own, given, fresh)))["cells"] == [own]


def test_an_answer_to_another_question_stands_below_the_new_todo():
    given, fresh = (cell("s", f"{name} = ...", metadata={"tags": ["solution"]}) for name in ("old", "new"))
    own = {**copy.deepcopy(given), "source": "old = 1"}
    first, second = merge.merged(*({"cells": [c]} for c in (own, given, fresh)))["cells"]
    assert (first["source"], second["source"]) == ("new = ...", "old = 1")


# ---- saving --------------------------------------------------------------------------------------------


class Manager:
    root_dir = str(ROOT)


def saved(content, path):
    model = {"type": "notebook", "content": copy.deepcopy(content)}
    saving.before_saving(model=model, path=path, contents_manager=Manager())
    return model["content"]


WIDGET = {
    "output_type": "display_data",
    "metadata": {},
    "data": {saving.WIDGET: {"model_id": "1"}, "text/plain": "View"},
}
FIGURE = {"output_type": "execute_result", "execution_count": 7, "metadata": {}, "data": {"image/png": "aGk="}}


def run_by_lab(content):
    """What JupyterLab has in its hands after *Run All*: counts, widgets, timings, the kernel's own language_info."""
    content = copy.deepcopy(content)
    content["metadata"]["language_info"] = {"name": "python", "version": "3.11.9", "nbconvert_exporter": "python"}
    content["metadata"]["widgets"] = {"state": {}}
    for number, there in enumerate((c for c in content["cells"] if is_code(c)), 1):
        there["execution_count"] = number + 40
        there["metadata"]["execution"] = {"iopub.execute_input": "now"}
        there["outputs"] += [copy.deepcopy(WIDGET)]
    return content


def test_a_chapter_is_saved_in_its_stored_form():
    path = names.chapters()[3]
    stored = normalise.read(path)
    assert normalise.dumps(saved(run_by_lab(stored), f"notebooks/{path.name}")) == normalise.dumps(stored)


def test_a_readers_copy_is_saved_without_what_dies_with_the_kernel():
    content = run_by_lab({"cells": [code("1"), code("2"), markdown("3")], "metadata": {}, "nbformat": 4})
    content["cells"][0]["outputs"] = [copy.deepcopy(o) for o in (WIDGET, FIGURE, WIDGET)]
    first, second, _ = saved(content, f"{WORK.name}/03-forward-kinematics.ipynb")["cells"]
    told = {"output_type": "display_data", "metadata": {}, "data": {"text/plain": saving.AGAIN}}
    assert first["outputs"] == [told, {**FIGURE, "execution_count": None}]
    assert second["outputs"] == [told]
    assert first["execution_count"] is second["execution_count"] is None
    assert "execution" not in first["metadata"]


def test_a_notebook_elsewhere_and_a_file_are_saved_as_they_are():
    content = run_by_lab({"cells": [code("1")], "metadata": {}, "nbformat": 4})
    assert saved(content, "work/deeper/mine.ipynb") == content
    model = {"type": "file", "content": "text"}
    saving.before_saving(model=model, path="work/a.txt", contents_manager=Manager())
    assert model["content"] == "text"


# ---- contents and solutions ----------------------------------------------------------------------------


def test_progress_counts_the_exercises_whose_checks_passed_last(book):
    """The contents count what the kernel keeps, not what a file's outputs show."""
    _, work = book
    check = passed.exercises(work / "07-lines.ipynb")[0][0]
    none, one = "0 of 1 \u00b7", "1 of 1 \u2713"
    for last, counted in ((None, none), (True, one), (False, none), (True, one)):
        if last is not None:
            assert passed.record(check, last, work).startswith(counted[:6])
        assert f"| {counted} |" in overview.table(work)
    folder.reset("07", work)
    assert f"| {none} |" in overview.table(work), "given out anew"
    in_words = [markdown("### Exercise 7.2: in words", tags=["exercise"]), markdown("", tags=["solution"])]
    edit(work / "07-lines.ipynb", lambda cells: cells.extend(in_words))
    assert f"| {none} |" in overview.table(work), "what is told in words is not counted"
    overview.write(work)
    assert "0 of 1" in (work / overview.NAME).read_text()
    edit(work / overview.NAME, lambda cells: cells[0].update(source="# My own contents"))
    before = (work / overview.NAME).read_text()
    overview.write(work)
    assert (work / overview.NAME).read_text() == before


def test_a_solution_is_shown_on_demand():
    chapters = [path for path in names.chapters() if "solution" in path.read_text(encoding="utf-8")]
    for path in chapters:
        first = next(source(c) for c in normalise.read(path)["cells"] if "solution" in tags(c))
        assert solutions.found(f"{int(path.stem[:2])}.1")[1].startswith(first[:20])
    with pytest.raises(Stop, match=r"Chapter 3 has no exercise 3\.99; it has 3\.1,"):
        solutions.found("3.99")
    with pytest.raises(Stop, match="numbered by chapter"):
        solutions.found("three")
    assert NOTEBOOKS == names.NOTEBOOKS


# ---- a file to hand in ---------------------------------------------------------------------------------


def handed_in(tmp_path, cells, **more):
    store(tmp_path / "07-lines.ipynb", cells)
    results = handin.write(tmp_path / "07-lines.ipynb", tmp_path / "out" / "07.html", **more)
    return results, (tmp_path / "out" / "07.html").read_text(encoding="utf-8")


def test_a_handed_in_page_is_run_shows_results_and_needs_nothing_else(tmp_path):
    cells = [*chapter(), markdown(r"An angle $\alpha_1$ and" + "\n\n$$\n\\frac{a}{b}\n$$"), code("1 / 0")]
    wrong = copy.deepcopy(chapter()[-3:])
    wrong[1]["source"] = ANSWER.replace("return 5", "return 6")
    results, page = handed_in(tmp_path, [*cells, *wrong])
    name = "Exercise 7.1: another line"
    assert results == [(name, True), (name, False)]
    assert "1 of 2 exercises pass their checks" in page
    assert "run from top to bottom" in page
    assert "my own answer" in page
    assert "AssertionError" in page
    assert "ZeroDivisionError: division by zero" in page
    assert page.count("<math ") == 2
    assert "<mfrac>" in page
    assert not re.findall(r'(?:src|href)="(?!data:)[^"]*"', page.split("<script>")[0])
    for call in ("<link", "<script src", "@import", "url(http"):
        assert call not in page


def test_who_hands_in_hears_what_passed_and_of_when_it_is(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(handin, "WORK", tmp_path)
    path = names.chapter("03", tmp_path)
    store(path, chapter())
    os.utime(path, (0, datetime.datetime(2026, 3, 4, 15, 16).timestamp()))
    assert handin.main(["03", "--as-saved", "--to", str(tmp_path / "out")]) == 0
    *_, last = capsys.readouterr().out.splitlines()
    assert last.startswith(f"Hand in this file: {tmp_path / 'out' / path.stem}.html")
    assert "as saved 04 March, 15:16;" in last


def test_an_answer_in_words_waits_for_a_teacher():
    cells = [markdown("### Exercise 7.2 · In your own words", tags=["exercise"])]
    assert handin.results_of(cells) == [("Exercise 7.2 · In your own words", handin.IN_WORDS)]


def test_an_answer_whose_check_stays_with_the_teacher_has_not_passed(tmp_path):
    exercise = markdown("### Exercise 7.1 · Half", tags=["exercise"])
    thin = code("check.handed_in(half=half)", tags=["check"])
    cells = [code("from omx import check\nhalf = 7"), exercise, thin]
    results, page = handed_in(tmp_path, cells)
    assert results == [("Exercise 7.1 · Half", handin.THERE)]
    assert "0 of 0 exercises pass their checks; 1 more is there, to be marked" in page


def test_a_notebook_that_drives_a_real_arm_is_not_run_again(tmp_path):
    told = {"output_type": "stream", "name": "stdout", "text": "moved\n"}
    port = code("port = '/dev/ttyUSB0'\nprint('moved again')", outputs=[told])
    results, page = handed_in(tmp_path, [*chapter(), port])
    assert "as it was saved, not run again" in page
    assert ">moved\n</pre>" in page
    assert results == [("Exercise 7.1: another line", True)]
    untouched = [{**cell, "outputs": []} if is_code(cell) else cell for cell in chapter()]
    assert handed_in(tmp_path, untouched, run=False)[0] == [("Exercise 7.1: another line", None)]


def test_a_formula_that_cannot_be_turned_stays_as_it_was_written():
    assert handin.mathml(r"\(\left( a\)") == r"\(\left( a\)"
    assert handin.mathml(r"\(a \lt b\)").count("<math ") == 1
