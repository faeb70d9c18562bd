"""Chapters get other numbers: names, titles, links and references follow, and nothing else does."""

import subprocess

import pytest

from book.chapters import normalise
from book.chapters.renumber import Renumbering, moved

CHAPTERS = ("00-start", "01-lines", "02-circles-and-arcs", "03-screws")
#: 03 goes behind 00: 1 -> 2, 2 -> 3, 3 -> 1.
NEW = Renumbering(moved(CHAPTERS, {"03-screws": 1}))


def test_chapters_move_and_the_others_close_up():
    assert list(NEW.stems.values()) == ["00-start", "01-screws", "02-lines", "03-circles-and-arcs"]
    assert moved(CHAPTERS, {"00-start": 2, "03-screws": 0}) == [
        "03-screws",
        "01-lines",
        "00-start",
        "02-circles-and-arcs",
    ]


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("Chapter 1 and chapters 2, 3 and 0 or chapter\n3.", "Chapter 2 and chapters 3, 1 and 0 or chapter\n1."),
        ("derived in chapters 01 to 02", "derived in chapters 02 to 03"),
        ("exercises 1.4 and 2.1; exercise 3.10", "exercises 2.4 and 3.1; exercise 1.10"),
        (
            'mine = check.variant("3.2"); solution("1.2"); run.py lab 03',
            'mine = check.variant("1.2"); solution("2.2"); run.py lab 01',
        ),
        ("# 3 · Screws\n\nText\n\n### Exercise 3.1 · Turn", "# 1 · Screws\n\nText\n\n### Exercise 1.1 · Turn"),
        ("[02 Arcs](notebooks/02-circles-and-arcs.ipynb)", "[03 Arcs](notebooks/03-circles-and-arcs.ipynb)"),
        ("[a later one](02-circles-and-arcs.ipynb#arcs)", "[a later one](03-circles-and-arcs.ipynb#arcs)"),
        ("chapter 9, 2 links, 1.5 mm, joint 3, [1, 2]", "chapter 9, 2 links, 1.5 mm, joint 3, [1, 2]"),
        ("chapter 2-3 and chapter 1.4.2", "chapter 2-3 and chapter 1.4.2"),
    ],
)
def test_references_follow(old, new):
    assert NEW.text(old) == new


def test_files_are_renamed_and_read_again(tmp_path, monkeypatch):
    notebooks = tmp_path / "notebooks"
    (tmp_path / "tests").mkdir()
    notebooks.mkdir()
    for stem in CHAPTERS:
        cell = {
            "cell_type": "markdown",
            "id": "title",
            "metadata": {},
            "source": f"# {int(stem[:2])} · Title\n\nSee chapter 1.",
        }
        normalise.write(notebooks / f"{stem}.ipynb", normalise.normalise({"cells": [cell], "nbformat": 4}))
    (tmp_path / "README.md").write_text("[01 Lines](notebooks/01-lines.ipynb)\n", encoding="utf-8")
    (tmp_path / "tests" / "test_it.py").write_text('"Exercise 1.1", "01-lines"\n', encoding="utf-8")
    subprocess.run(["git", "init", "-q"], cwd=tmp_path, check=True)
    subprocess.run(["git", "add", "."], cwd=tmp_path, check=True)
    NEW.apply(tmp_path)
    assert sorted(path.stem for path in notebooks.iterdir()) == sorted(NEW.stems.values())
    (cell,) = normalise.read(notebooks / "01-screws.ipynb")["cells"]
    assert "".join(cell["source"]) == "# 1 · Title\n\nSee chapter 2."
    assert (tmp_path / "README.md").read_text(encoding="utf-8") == "[02 Lines](notebooks/02-lines.ipynb)\n"
    assert (tmp_path / "tests" / "test_it.py").read_text(encoding="utf-8") == '"Exercise 1.1", "02-lines"\n'
