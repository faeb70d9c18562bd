"""Which exercises a reader has done: kept in one small file beside the notebooks, and shown as a table."""

import html
import json
import os
import re
from pathlib import Path
from typing import NamedTuple

FILE = ".progress.json"
NAME = "the reader's name"
DONE, OPEN = "\N{CHECK MARK}", "\N{MIDDLE DOT}"
HARD = re.compile(r"Difficulty ([1-5]) of 5")


class Exercise(NamedTuple):
    """An exercise of a notebook: its heading, its difficulty from 1 to 5 (0 if not given), the ids of its checks."""

    title: str
    difficulty: int
    checks: tuple[str, ...]

    def is_done(self, stored: dict) -> bool:
        """Have all its checks passed, and passed last?"""
        return all(stored.get(check) is True for check in self.checks)


class Progress(dict):
    """{chapter's title: [(exercise, is it done?), ...]}; notebooks show it as a table, `print` as text."""

    def __str__(self) -> str:
        lines = []
        for chapter, exercises in self.items():
            lines += [f"{chapter}: {_count(exercises)}"]
            lines += [f"  {DONE if done else OPEN} {exercise.title}" for exercise, done in exercises]
        return "\n".join(lines) or "No exercises here: open this notebook in the folder of the chapters."

    __repr__ = __str__

    def _repr_html_(self) -> str:
        parts = []
        for chapter, exercises in self.items():
            rows = "".join(
                f"<li style='list-style:none'>{DONE if done else OPEN} {html.escape(exercise.title)} "
                f"<span style='opacity:.6'>{_circles(exercise.difficulty)}</span></li>"
                for exercise, done in exercises
            )
            head = f"{html.escape(chapter)}: <b>{_count(exercises)}</b>"
            parts.append(f"<details><summary>{head}</summary><ul>{rows}</ul></details>")
        return "".join(parts) or html.escape(str(self))


def progress(folder: str | os.PathLike = ".") -> Progress:
    """The exercises of all notebooks in `folder`, chapter by chapter, and which of them have passed their check."""
    return Progress((read(path)[0], exercises) for path, exercises in by_notebook(folder))


def by_notebook(folder: str | os.PathLike = "."):
    """(path, [(exercise, is it done?), ...]) of each notebook in `folder` that has exercises."""
    stored = _stored(folder)
    for path in sorted(Path(folder).glob("*.ipynb")):
        _, exercises = read(path)
        if exercises:
            yield path, [(exercise, exercise.is_done(stored)) for exercise in exercises]


def record(cell: str, passed: bool, folder: str | os.PathLike = ".") -> str:
    """Keep whether the check in `cell` passed; "2 of 4 exercises of this chapter done", '' if it is of no chapter."""
    stored = _stored(folder)
    if stored.get(cell) != passed:
        stored[cell] = passed
        _store(folder, stored)
    for path in sorted(Path(folder).glob("*.ipynb")):
        _, exercises = read(path)
        if any(cell in exercise.checks for exercise in exercises):
            done = sum(exercise.is_done(stored) for exercise in exercises)
            return f"{done} of {len(exercises)} exercises of this chapter done."
    return ""


def forget(path: Path) -> None:
    """Forget which checks of a notebook have passed: it is given out anew."""
    stored, (_, exercises) = _stored(path.parent), read(path)
    checks = {check for exercise in exercises for check in exercise.checks}
    if checks & stored.keys():
        _store(path.parent, {cell: passed for cell, passed in stored.items() if cell not in checks})


def keep_name(name: str, folder: str | os.PathLike = ".") -> None:
    """Keep the reader's name beside the progress."""
    _store(folder, {**_stored(folder), NAME: name})


def name(folder: str | os.PathLike = ".") -> str:
    """The name that the reader gave, or ''."""
    found = _stored(folder).get(NAME, "")
    return found if isinstance(found, str) else ""


def read(path: Path) -> tuple[str, list[Exercise]]:
    """The title of a notebook and its exercises; nothing of a file that is no notebook."""
    try:
        cells = json.loads(path.read_text(encoding="utf-8-sig"))["cells"]
        tagged = [(cell.get("id", ""), "".join(cell["source"]), cell["metadata"].get("tags", [])) for cell in cells]
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return path.stem, []
    heading = next((found[1] for _, text, _ in tagged if (found := re.search(r"^# (.+)", text, re.M))), path.stem)
    exercises = []
    for name, text, tags in tagged:
        if "exercise" in tags:
            exercises.append(Exercise(*entitled(text), ()))
        elif "check" in tags:
            last = exercises.pop() if exercises else Exercise("", 0, ())
            exercises.append(last._replace(checks=(*last.checks, name)))
    return heading, [exercise for exercise in exercises if exercise.checks]  # an answer in words has none


def entitled(text: str) -> tuple[str, int]:
    """The heading of an exercise and its difficulty, from the line `*Difficulty 2 of 5, about 10 minutes.*`."""
    found, hard = re.search(r"^#+\s+(.+)$|\*\*(.+?)\*\*", text, re.M), HARD.search(text)
    heading = (found[1] or found[2]) if found else text.split(".")[0]
    return heading.strip(" .:*"), int(hard[1]) if hard else 0


def _stored(folder) -> dict:
    try:
        stored = json.loads(Path(folder, FILE).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return stored if isinstance(stored, dict) else {}


def _store(folder, stored: dict) -> None:
    """Write the file whole, or leave it: a full or read-only disk must not stop a reader."""
    partial = Path(folder, f"{FILE}.{os.getpid()}")
    try:
        partial.write_text(json.dumps(stored, indent=1, sort_keys=True) + "\n", encoding="utf-8")
        os.replace(partial, Path(folder, FILE))
    except OSError:
        pass


def _count(exercises) -> str:
    return f"{sum(done for _, done in exercises)} of {len(exercises)} done"


def _circles(difficulty: int) -> str:
    return "\N{BLACK CIRCLE}" * difficulty + "\N{WHITE CIRCLE}" * (5 - difficulty) if difficulty else ""
