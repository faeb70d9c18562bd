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
import tomllib
from typing import NamedTuple

from book.setup.paths import Stop

TABLES = {"points", "weights", "due", "late", "days_late"}
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
                f"roster.csv must have the columns {', '.join(ROSTER)}; only the first must be filled."
            ) from None
        except ValueError as error:
            raise Stop(f"course.toml or roster.csv cannot be read: {error}") from error
        if unknown := set(self.tables) - TABLES:
            raise Stop(f"course.toml has [{min(unknown)}]; the tables are {', '.join(sorted(TABLES))}.")

    def points(self, exercise):
        number = exercise["name"].removeprefix("exercise-").replace("-", ".")
        return self.tables.get("points", {}).get(number, exercise["points"])

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
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, [*columns, "notes"], restval="")
        writer.writeheader()
        writer.writerows([{name: shown(value) for name, value in row.items()} for row in rows])


def shown(value):
    if isinstance(value, (int, float)):
        return number(value)
    return f"'{value}" if str(value)[:1] in "=+-@\t\r" and value else value


def totals(course):
    """Write marks.csv, moodle.csv and canvas.csv over all graded chapters; their paths. Raises `Stop`."""
    rules, paths = Rules(course), sorted(course.glob("marks-*.csv"))
    if not paths:
        raise Stop(f"{course} holds no marks yet: `grading grade` comes first.")
    chapters = {path.stem.removeprefix("marks-"): table(path) for path in paths}
    students = list(dict.fromkeys([*rules.roster, *(name for rows in chapters.values() for name in rows)]))
    rows = [total(name, chapters, rules) for name in students]
    names = list(chapters)
    plain = [{"student": row["student"], **{c: row[c] for c in names}, "total (%)": row["total"]} for row in rows]
    moodle = [{"Email address": who(row, rules, "email"), "ID number": who(row, rules, "id"),
               **{c: row[c] for c in names}} for row in rows]  # fmt: skip
    best = {"Student": "    Points Possible", "ID": "", "SIS Login ID": "", "Section": ""}
    best |= {c: max((row["of"] for row in chapters[c].values()), key=float) for c in names}
    canvas = [best] + [{"Student": who(row, rules, "name") or row["student"], "ID": who(row, rules, "id"),
                        "SIS Login ID": row["student"], "Section": "", **{c: row[c] for c in names}}
                       for row in rows]  # fmt: skip
    made = {"marks.csv": plain, "moodle.csv": moodle, "canvas.csv": canvas}
    for name, content in made.items():
        with open(course / name, "w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, list(content[-1]))
            writer.writeheader()
            writer.writerows([{key: shown(value) for key, value in row.items()} for row in content])
    return [course / name for name in made]


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
