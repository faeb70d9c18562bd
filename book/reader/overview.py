"""The contents of the book as a notebook in the reader's folder, with progress; each chapter's way to the next."""

import json
import re

from book.chapters import normalise
from book.chapters.cells import headings, prose, source, tags
from book.setup import names

NAME = "contents.ipynb"
TEXT = """# Contents

Run the cell below (click it, press Shift+Enter) to see how far you are. These chapters are your own copies: change
whatever you like, and save with Ctrl+S. An exercise counts as done when its check cell has passed, and passed last.

| in a terminal, in the book's folder | |
|---|---|
| `python run.py lab 03` | opens a chapter |
| `python run.py update` | brings in a new edition; what you wrote stays |
| `python run.py reset 03` | a chapter as it was given out; yours is kept in `work/earlier` |
| `python run.py solution 3.1` | shows a solution; in a cell: `from book.reader import solution; solution("3.1")` |
| `python run.py handin 03` | writes one HTML file of a chapter, with its results |
"""
CODE = "from book.reader import contents\n\ncontents()"


def links(path):
    """The cells at the beginning and at the end of a chapter: previous, contents, next."""
    paths = names.chapters()
    place = paths.index(path)
    before = f"[\u2190 {title(paths[place - 1])}]({paths[place - 1].name}) \u00b7 " if place else ""
    after = f" \u00b7 [{title(paths[place + 1])} \u2192]({paths[place + 1].name})" if place + 1 < len(paths) else ""
    line = f"{before}[Contents]({NAME}){after}"
    number = int(path.stem[:2])
    stuck = f'Stuck for good? `from book.reader import solution; solution("{number}.1")` shows a solution.\n\n'
    has = any("solution" in tags(cell) for cell in normalise.read(path)["cells"])
    return cell("markdown", "omx-links-top", line), cell("markdown", "omx-links-end", (stuck if has else "") + line)


def title(path):
    """A chapter's number and name, from its file: `03 Forward kinematics`, as its heading has it."""
    first = next(text for _, text in headings(normalise.read(path)["cells"][0]))
    name = re.sub(r"^\d+\s*\W+\s*", "", first)
    return f"{path.stem[:2]} {name}"


def cell(kind, name, text):
    made = {"cell_type": kind, "id": name, "metadata": {}, "source": normalise.lines_of(text)}
    return made if kind == "markdown" else {**made, "outputs": [], "execution_count": None}


def table(folder):
    """| chapter | what it is about | exercises done |, as Markdown."""
    rows = ["| chapter | | exercises done |", "|---|---|---|"]
    solved_in = progress(folder)
    for path in names.chapters():
        solved = solved_in.get(path.name, [])
        marks = "".join("\u2713" if done else "\u00b7" for done in solved)  # which ones, in their order
        count = f"{sum(solved)} of {len(solved)} {marks}" if solved else ""
        rows.append(f"| [{title(path)}]({path.name}) | {hook(path)} | {count} |")
    return "\n".join(rows)


def progress(folder):
    """{notebook: for each exercise, is it done?}, as `omx.check` counts; nothing before its packages are there."""
    try:
        from omx.check import passed
    except ImportError:
        return {}
    return {path.name: done for path, done in passed.progress(folder).items()}


def hook(path):
    """The sentence below a chapter's title."""
    paragraphs = [text for text in prose(normalise.read(path)["cells"][0]).split("\n\n") if not text.startswith("#")]
    return " ".join(paragraphs[0].split()) if paragraphs else ""


def write(folder):
    """Write the notebook, with progress as of now, unless the reader has changed it."""
    path, output = folder / NAME, {"data": {"text/markdown": normalise.lines_of(table(folder))}, "metadata": {}}
    output["output_type"] = "display_data"
    code = {**cell("code", "omx-progress", CODE), "outputs": [output]}
    notebook = {"cells": [cell("markdown", "omx-contents", TEXT), code], "nbformat": 4, "nbformat_minor": 5,
                "metadata": {"kernelspec": normalise.KERNELSPEC, "language_info": normalise.LANGUAGE}}  # fmt: skip
    try:
        there = json.loads(path.read_text(encoding="utf-8"))["cells"]
        is_ours = {c["id"]: source(c) for c in there}.items() <= {c["id"]: source(c) for c in notebook["cells"]}.items()
    except FileNotFoundError:
        is_ours = True
    except (OSError, ValueError, KeyError, TypeError):
        is_ours = False
    if is_ours:
        folder.mkdir(parents=True, exist_ok=True)
        normalise.write(path, notebook)
