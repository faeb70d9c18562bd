"""What a teacher needs to know of each chapter, and plans of a course, from the chapters themselves: `book/teach`.

Minutes, objectives and exercises are read from the notebooks; what only a teacher knows (common mistakes, what to
skip, which meeting takes which chapter) stands in `book/teach/course.toml`, by the chapters' names without numbers.
"""

import json
import math
import re
import tomllib
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache, cached_property
from pathlib import Path

from sphinx.util.docutils import SphinxDirective

from book.chapters import cells, normalise
from book.chapters.student import POINTS
from book.publish import deck
from book.setup.paths import NOTEBOOKS, ROOT

COURSE = ROOT / "book/teach/course.toml"
WORDS_A_MINUTE, LINES_A_MINUTE = 50, 6
MEETING_MIN, ROOM_MIN = 90, 85  # some minutes go by before the first slide and after the last
OBJECTIVE = re.compile(r"^- (.+?)(?=^- |^\S|\Z)", re.MULTILINE | re.DOTALL)


@dataclass(frozen=True)
class Exercise:
    """An exercise as its cell tells it; `points` is 0 where no check tests it."""

    number: str
    title: str
    difficulty: int
    minutes: int
    points: int
    kind: str


@dataclass
class Chapter:
    """A chapter as a teacher sees it; `told` are this chapter's lines of course.toml."""

    path: Path
    told: dict

    @cached_property
    def cells(self):
        return normalise.read(self.path)["cells"]

    @property
    def name(self) -> str:
        """Its file's name without number and ending."""
        return self.path.stem.partition("-")[2]

    @property
    def title(self) -> str:
        return cells.headings(self.cells[0])[0][1]

    def link(self) -> str:
        return f"[{self.title}](../../notebooks/{self.path.name})"

    @cached_property
    def slides_min(self) -> float:
        return _minutes(json.dumps(self.cells))

    @cached_property
    def reading_min(self) -> float:
        """For one student who runs every cell and answers each *Predict* before looking; labs say their own time."""
        if "reading" in self.told:
            return self.told["reading"]
        until = next((i for i, c in enumerate(self.cells) if (0, "Exercises") in _titles(c)), len(self.cells))
        text = self.cells[:until]
        words, lines = sum(map(cells.word_count, text)), sum(len(cells.code_lines(cell)) for cell in text)
        return words / WORDS_A_MINUTE + lines / LINES_A_MINUTE

    @cached_property
    def objectives(self) -> list[str]:
        """The list below "You will be able to"."""
        _, _, listed = cells.source(self.cells[0]).partition("You will be able to")
        return [" ".join(found.split()).rstrip(";.") for found in OBJECTIVE.findall(listed)]

    @cached_property
    def exercises(self) -> list[Exercise]:
        found = []
        for cell in self.cells:
            tags = cells.tags(cell)
            if "exercise" in tags:
                head, effort = deck.EXERCISE.match(cells.source(cell)), deck.EFFORT.search(cells.source(cell))
                number, title = head.groups() if head else ("", cells.source(cell).split("\n")[0].strip("# "))
                hard, minutes = map(int, effort.groups()) if effort else (0, 0)
                derive = "derive it" if re.search(r"\bDerive\b", cells.source(cell)) else ""
                kind = "find the fault" if "broken" in tags else derive
                found.append(Exercise(number, title, hard, minutes, 0, kind))
            elif "check" in tags and found:
                found[-1] = replace(found[-1], points=found[-1].points + POINTS)
        return [e if e.points else replace(e, kind="in words") for e in found]


@cache
def _minutes(chapter: str) -> float:
    """Of these cells, as JSON: every table of a build asks again."""
    return deck.minutes({"cells": json.loads(chapter)})


def _titles(cell):
    return [(0, title) for _, title in cells.headings(cell)]


def told() -> dict:
    """What stands in course.toml."""
    return tomllib.loads(COURSE.read_text(encoding="utf-8"))


def chapters() -> list[Chapter]:
    """All chapters, in order."""
    about = told()["chapters"]
    return [Chapter(path, about.get(path.stem.partition("-")[2], {})) for path in sorted(NOTEBOOKS.glob("*.ipynb"))]


def five(minutes: float) -> int:
    """Minutes as a plan has them: in fives."""
    return 5 * math.ceil(minutes / 5 - 0.2)


# ---- one section a chapter -----------------------------------------------------------------------------------


def overview(found: list[Chapter]) -> str:
    """One row a chapter: minutes, exercises, points."""
    rows = [
        f"| {c.link()} | {five(c.slides_min)} | {five(c.reading_min)} | {len(c.exercises)} "
        f"| {sum(e.minutes for e in c.exercises)} | {sum(e.points for e in c.exercises)} |"
        for c in found
    ]
    head = "| chapter | on slides (min) | reading (min) | exercises | all of them (min) | points |"
    return "\n".join([head, "|---|---|---|---|---|---|", *rows])


def section(chapter: Chapter) -> str:
    """A chapter's table, as Markdown: objectives, times, exercises, mistakes, what to skip."""
    about = [
        ("able to", "; ".join(chapter.objectives)),
        ("minutes", f"{five(chapter.slides_min)} on slides, {five(chapter.reading_min)} to read and run, "
                    f"{sum(e.minutes for e in chapter.exercises)} for all exercises"),
        ("common mistakes", " ".join(chapter.told.get("mistakes", []))),
        ("what to skip", chapter.told.get("skip", "")),
    ]  # fmt: skip
    lines = [f"## {chapter.title}", "", "| | |", "|---|---|"]
    lines += [f"| **{name}** | {text} |" for name, text in about if text]
    lines += ["", "| exercise | | difficulty | minutes | points | |", "|---|---|---|---|---|---|"]
    lines += [
        f"| {e.number} | {e.title} | {e.difficulty or ''} | {e.minutes or ''} | {e.points or ''} | {e.kind} |"
        for e in chapter.exercises
    ]
    return "\n".join([*lines, "", f"To the chapter: {chapter.link()}", ""])


# ---- plans ---------------------------------------------------------------------------------------------------


def taken(word: str) -> tuple[Fraction, str]:
    """`1/2 planar-arms` as (1/2, "planar-arms"); a name alone is the whole chapter."""
    share, _, name = word.rpartition(" ")
    return Fraction(share or 1), name


def minutes(meeting: dict, found: dict[str, Chapter]) -> float:
    """How long the slides of a meeting take; a chapter that is not there takes none."""
    parts = map(taken, meeting["chapters"])
    return sum(float(share) * found[name].slides_min for share, name in parts if name in found)


def plan(meetings: list[dict], found: dict[str, Chapter]) -> str:
    """A table of meetings, as Markdown."""
    rows, seen = [], {}
    for number, meeting in enumerate(meetings, 1):
        words = []
        for share, name in map(taken, meeting["chapters"]):
            if name in found:
                part = "" if share == 1 else " (second part)" if name in seen else " (first part)"
                words.append(found[name].link() + part)
            else:
                words.append(name.replace("-", " ").capitalize())
            seen[name] = True
        rows.append(f"| {number} | {'; '.join(words)} | {five(minutes(meeting, found))} | {meeting.get('before', '')} "
                    f"| {meeting['point']} |")  # fmt: skip
    return "\n".join(["| | together | slides (min) | before | the point of it |", "|---|---|---|---|---|", *rows])


# ---- directives ----------------------------------------------------------------------------------------------


class Teaching(SphinxDirective):
    """Markdown made from the chapters; the page is written anew when one of them, or course.toml, changes."""

    def run(self):
        for path in (COURSE, *NOTEBOOKS.glob("*.ipynb")):
            self.env.note_dependency(str(path))
        return self.parse_text_to_nodes(self.text(), allow_section_headings=True)


class Overview(Teaching):
    def text(self):
        return overview(chapters())


class Sections(Teaching):
    def text(self):
        return "\n".join(map(section, chapters()))


class Plan(Teaching):
    """`plan` with the number of meetings."""

    required_arguments = 1

    def text(self):
        return plan(told()["plans"][self.arguments[0]], {chapter.name: chapter for chapter in chapters()})


def setup(app):
    app.add_directive("chapter-overview", Overview)
    app.add_directive("chapter-sections", Sections)
    app.add_directive("plan", Plan)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
