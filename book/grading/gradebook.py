"""What a course makes of results: points, a late rule, a roster, feedback to read, and tables for Moodle and Canvas.

A course's folder may hold two small files. `roster.csv` has the columns student (the name of the folder in
`submitted`), name, email, id. `course.toml` has these tables, each optional:

    [points]      "3.1" = 2                      # 1 if not given
    [weights]     "03" = 1.5                     # of a chapter in the total; 1 if not given
    [due]         "03" = 2026-03-01T23:59:00     # by the file's time
    [late]        per_day = 0.1                  # of the marks; at_most = 0.5
    [days_late]   "03" = { ada = 0 }             # what you know better than the file's time
"""

import csv
import datetime
import math
import re
import tomllib
from typing import NamedTuple

from book.setup.paths import Stop


def is_amount(value):
    return isinstance(value, (int, float)) and not isinstance(value, bool) and 0 <= value < math.inf


EXERCISE, CHAPTER = r"\d+\.\d+", r"\d\d"
#: The tables of course.toml: what may stand at the left, does a value fit, and how is one written?
TABLES = {
    "points": (EXERCISE, is_amount, '"3.1" = 2'),
    "weights": (CHAPTER, is_amount, '"03" = 1.5'),
    "due": (CHAPTER, lambda value: isinstance(value, datetime.datetime), '"03" = 2026-03-01T23:59:00'),
    "late": ("per_day|at_most", lambda value: is_amount(value) and value <= 1, "per_day = 0.1, or at_most = 0.5"),
    "days_late": (CHAPTER, lambda value: isinstance(value, dict) and all(map(is_amount, value.values())),
                  '"03" = { ada = 0 }'),
}  # fmt: skip
ROSTER = ("student", "name", "email", "id")


class Late(NamedTuple):
    """What is left of the marks, and the note on it."""

    factor: float
    notes: list


class Rules:
    """The course's own rules, from its folder. Raises `Stop` for what it cannot read."""

    def __init__(self, course):
        self.roster, self.tables = {}, {}
        try:
            if (course / "roster.csv").exists():
                with open(course / "roster.csv", newline="", encoding="utf-8-sig") as file:
                    self.roster = {row["student"].strip(): row for row in csv.DictReader(file) if row["student"]}
            if (course / "course.toml").exists():
                self.tables = tomllib.loads((course / "course.toml").read_text(encoding="utf-8-sig"))
        except KeyError:
            raise Stop(
                f"roster.csv must have the columns {', '.join(ROSTER)}, with commas; only the first must be filled."
            ) from None
        except UnicodeDecodeError:
            raise Stop("course.toml or roster.csv is not stored as UTF-8: in Excel, save it as `CSV UTF-8`.") from None
        except ValueError as error:
            raise Stop(f"course.toml or roster.csv cannot be read: {error}") from error
        if unknown := set(self.tables) - TABLES.keys():
            raise Stop(f"course.toml has [{min(unknown)}]; the tables are {', '.join(sorted(TABLES))}.")
        for table, (left, fits, form) in TABLES.items():
            entries = self.tables.get(table, {})
            for name, value in entries.items() if isinstance(entries, dict) else [(table, entries)]:
                if not (isinstance(entries, dict) and re.fullmatch(left, name) and fits(value)):
                    raise Stop(f"course.toml, [{table}]: {name} = {value} cannot be; it is written {form}.")

    def points(self, exercise):
        return self.tables.get("points", {}).get(self.number(exercise), exercise["points"])

    @staticmethod
    def number(exercise):
        return exercise["name"].removeprefix("exercise-").replace("-", ".")

    def refuse_unknown(self, key, chapter):
        """Raises `Stop` for points of an exercise that the chapter lacks, and for days of nobody on the roster."""
        there = {self.number(exercise) for exercise in key["exercises"]}
        points = {name for name in self.tables.get("points", {}) if int(name.partition(".")[0]) == int(chapter[:2])}
        if wrong := points - there:
            raise Stop(f"course.toml, [points]: {chapter[:2]} has no exercise {min(wrong)} with a check.")
        days = self.tables.get("days_late", {}).get(chapter[:2], {})
        if self.roster and (strangers := days.keys() - self.roster.keys()):
            raise Stop(f"course.toml, [days_late]: {min(strangers)} is not on the roster.")

    def weight(self, chapter):
        return self.tables.get("weights", {}).get(chapter[:2], 1)

    def late(self, chapter, student, path):
        """What the late rule leaves of the marks of this file."""
        known = self.tables.get("days_late", {}).get(chapter[:2], {})
        days, due = known.get(student), self.tables.get("due", {}).get(chapter[:2])
        if days is None and due is not None:
            at = datetime.datetime.fromtimestamp(path.stat().st_mtime, due.tzinfo)
            days = max(0, math.ceil((at - due).total_seconds() / 86400))
        if not days:
            return Late(1.0, [])
        rule = self.tables.get("late", {})
        lost = min(days * rule.get("per_day", 0.0), rule.get("at_most", 1.0))
        return Late(1.0 - lost, [f"{days} day{'s' * (days != 1)} late: {lost:.0%} off"])


def feedback(key, student, report, points, rules, late, total, mended):
    """A page for the student: each exercise, its points, and of each criterion what the check said."""
    of = sum(rules.points(exercise) for exercise in key["exercises"])
    lines = [f"# {key['title']}", "", f"{student}: **{number(total)} of {number(of)}**", ""]
    lines += [f"- {note}" for note in [*late.notes, *mended]]
    for exercise in key["exercises"]:
        got, worth = number(points[exercise["name"]]), number(rules.points(exercise))
        lines += ["", f"## {exercise['title']}: {got} of {worth}", ""]
        met = report.of(exercise["name"])
        for place in [n for n, (_, counts) in enumerate(exercise["statements"]) if counts]:
            passed, said = met.get(place, (False, "not reached"))
            lines.append(f"- {'✓' if passed else '✗'} {said.replace('Correct: ', '') or 'right'}")
    if stopped := list(report.stopped.values()):
        lines += ["", "Cells that stopped:", "", *(f"- {said}" for said in dict.fromkeys(stopped))]
    return "\n".join(lines) + "\n"


def number(value):
    return f"{value:.2f}".rstrip("0").rstrip(".")


def write(path, rows):
    """A table as CSV; a cell that a spreadsheet would take for a formula gets an apostrophe."""
    columns = list(dict.fromkeys(name for row in rows for name in row if name != "notes"))
    with open(path, "w", newline="", encoding="utf-8", errors="backslashreplace") as file:
        writer = csv.DictWriter(file, [*columns, "notes"], restval="")
        writer.writeheader()
        writer.writerows([{name: shown(value) for name, value in row.items()} for row in rows])


def shown(value):
    if isinstance(value, (int, float)):
        return number(value)
    text = value or ""
    return f"'{text}" if len(text) > 1 and text[0] in "=+-@\t\r" else text  # a lone `-` is Moodle's blank


def totals(course):
    """Write marks.csv, moodle.csv and canvas.csv over all graded chapters; their paths. Raises `Stop`."""
    rules, paths = Rules(course), sorted(course.glob("marks-*.csv"))
    if not paths:
        raise Stop(f"{course} holds no marks yet: `grading grade` comes first.")
    chapters = {path.stem.removeprefix("marks-"): table(path) for path in paths}
    students = list(dict.fromkeys([*rules.roster, *(name for rows in chapters.values() for name in rows)]))
    rows = [total(name, chapters, rules) for name in students]
    best = {chapter: max((row["of"] for row in found.values()), key=float) for chapter, found in chapters.items()}
    plain = [{"student": row["student"], **{c: row[c] for c in best}, "total (%)": row["total"]} for row in rows]
    made = {"marks.csv": plain, "moodle.csv": moodle(rows, best, rules), "canvas.csv": canvas(rows, best, rules)}
    for name, content in made.items():
        with open(course / name, "w", newline="", encoding="utf-8", errors="backslashreplace") as file:
            writer = csv.DictWriter(file, list(content[0]) if content else [])
            writer.writeheader()
            writer.writerows([{key: shown(value) for key, value in row.items()} for row in content])
    return [course / name for name in made]


def moodle(rows, best, rules):
    """Rows for Moodle, which knows no mark as `-`, and gives a row without its user to the user before it."""
    columns = (("Email address", "email"), ("ID number", "id"))
    title, column = max(columns, key=lambda one: sum(bool(who(row, rules, one[1])) for row in rows))
    if without := [row["student"] for row in rows if not who(row, rules, column)]:
        print(f"moodle.csv is without {', '.join(without)}: roster.csv says no {column} for them.")
    return [{title: user, **{c: row[c] or "-" for c in best}} for row in rows if (user := who(row, rules, column))]


def canvas(rows, best, rules):
    """Rows for Canvas, whose own column `ID` is a number that only Canvas knows."""
    first = {"Student": "    Points Possible", **dict.fromkeys(("ID", "SIS User ID", "SIS Login ID", "Section"), "")}
    return [{**first, **best}] + [
        {**first, "Student": who(row, rules, "name") or row["student"], "SIS User ID": who(row, rules, "id"),
         "SIS Login ID": row["student"], **{c: row[c] for c in best}} for row in rows]  # fmt: skip


def table(path):
    with open(path, newline="", encoding="utf-8") as file:
        return {row["student"]: row for row in csv.DictReader(file)}


def total(student, chapters, rules):
    """A student's marks by chapter, blank where there are none, and the weighted share of all that was set, in %."""
    row, got, best = {"student": student}, 0.0, 0.0
    for chapter, rows in chapters.items():
        found = rows.get(student, {})
        row[chapter] = found.get("marks", "")
        weight = rules.weight(chapter)
        best += weight
        of = float(found.get("of") or 0)
        got += weight * float(row[chapter] or 0) / of if of else 0
    row["total"] = round(100 * got / best, 1) if best else ""
    return row


def who(row, rules, column):
    return (rules.roster.get(row["student"], {}).get(column) or "").strip()
