"""`python run.py generate`: a scratch chapter writes its module, and the check notices every way to disagree."""

import subprocess
import sys

import nbformat
import pytest

from book.chapters import generate
from omx import OmxError

CHAPTER = """
import sympy as sp
from omx.derive import Function, write

q1 = sp.Symbol("q1")
module = write("scratch", [Function("f", "Twice.", [q1], {"y": FACTOR * q1})], notebook="42-scratch", doc="A test.")
assert module.f(1.0) == FACTOR
"""


@pytest.fixture
def book(tmp_path, monkeypatch):
    """A book of one chapter, and an empty folder for what it writes."""
    monkeypatch.setattr(generate, "NOTEBOOKS", tmp_path / "notebooks")
    monkeypatch.setattr(generate, "GENERATED", tmp_path / "generated")
    for folder in (generate.NOTEBOOKS, generate.GENERATED):
        folder.mkdir()
    store_chapter(factor=2)
    return tmp_path


def store_chapter(factor, code=CHAPTER):
    cells = [nbformat.v4.new_code_cell(code.replace("FACTOR", str(factor)))]
    nbformat.write(nbformat.v4.new_notebook(cells=cells), generate.NOTEBOOKS / "42-scratch.ipynb")


def test_a_chapter_is_run_compared_and_its_change_found(book, capsys, monkeypatch):
    monkeypatch.setenv("OMX_GENERATED", str(generate.GENERATED))
    exec(CHAPTER.replace("FACTOR", "2"), {})
    assert {path.name for path in generate.GENERATED.glob("*.*")} == {"scratch.py", "scratch.js"}
    assert generate.sources() == {generate.GENERATED / "scratch.py": "42-scratch"}
    assert generate.main(["--check"]) == 0
    assert "1 generated modules are what 42-scratch write" in capsys.readouterr().out

    store_chapter(factor=3)
    before = (generate.GENERATED / "scratch.py").read_bytes()
    assert generate.main(["--check"]) == 1
    report = capsys.readouterr().out
    assert "-    return 2*q1" in report
    assert "+    return 3*q1" in report
    assert report.endswith("To write them: python run.py generate\n")
    assert (generate.GENERATED / "scratch.py").read_bytes() == before

    assert generate.main([]) == 0
    assert "return 3*q1" in (generate.GENERATED / "scratch.py").read_text()


def test_a_chapter_that_fails_is_named_and_changes_nothing(book, capsys):
    (generate.GENERATED / "scratch.py").write_text('"""A test.\n\nWritten by notebooks/42-scratch.ipynb.\n"""\n')
    store_chapter(0, "1 / FACTOR")
    assert generate.main([]) == 1
    assert "notebooks/42-scratch.ipynb stops with ZeroDivisionError: division by zero" in capsys.readouterr().err
    assert "def f" not in (generate.GENERATED / "scratch.py").read_text()


def test_a_missing_chapter_is_named_before_any_other_runs(book):
    for name in ("scratch", "other"):
        (generate.GENERATED / f"{name}.py").write_text(f'"""A test.\n\nWritten by notebooks/42-{name}.ipynb.\n"""\n')
    with pytest.raises(OmxError, match=r"42-other\.ipynb is missing"):
        generate.chapters()
    (generate.GENERATED / "other.py").unlink()
    assert generate.chapters() == ["42-scratch"]


@pytest.mark.parametrize(
    ("ours", "theirs", "found"),
    [
        ({"a.py": "1\n"}, {"a.py": "1\n"}, False),
        ({"a.py": "1\n"}, {"a.py": "2\n"}, True),
        ({"a.py": "1\n"}, {"a.py": "1\r\n"}, True),
        ({"a.py": "1\n"}, {"a.py": "1"}, True),
        ({"a.py": "1\n"}, {}, True),
        ({}, {"a.py": "1\n"}, True),
        ({"a.js": "1\n"}, {"a.js": "2\n"}, True),
        ({"a.py": "1\n", "a.js": "2\n"}, {"a.py": "1\n"}, True),
        ({"__init__.py": "1\n"}, {}, False),
    ],
)
def test_names_and_bytes_are_compared(book, tmp_path, ours, theirs, found):
    other = tmp_path / "written"
    other.mkdir()
    for folder, files in ((generate.GENERATED, ours), (other, theirs)):
        for name, text in files.items():
            (folder / name).write_bytes(text.encode())
    assert bool(generate.difference(other)) == found


def test_the_command_explains_itself():
    done = subprocess.run(
        [sys.executable, "-m", "book.chapters.generate", "--chek"], capture_output=True, text=True, timeout=60
    )
    assert done.returncode == 2
    assert done.stderr == "usage: python run.py generate [--check, --ship, --restore]\n"
