"""The exercises of a chapter, and which answers `trials.py` tries on each."""

import ast
import re
import tomllib
from pathlib import Path

from book.chapters import student
from book.chapters.cells import is_code, source, tags

#: Wrong answers that somebody would write, and that a check once accepted or explained badly.
KNOWN = {
    "ring": ["def ring(l):\n    return 0.0, sum(l)", "def ring(l):\n    return abs(l[0] - sum(l[1:])), sum(l)"],
    "best": [
        "def best(target, near_deg):\n    pose = [*target[:3], np.radians(target[3])]\n"
        "    return np.degrees(omx.solve_ik(pose, start=np.radians(near_deg)).q)",
        "def best(target, near_deg):\n    return omx.solve_ik([*target[:3], np.radians(target[3])]).q",
    ],
    "from_behind": ["def from_behind(pose):\n    return [*pose[:3], 180 - pose[3]]"],
    "to_tick": [
        "def to_tick(q_deg):\n    return int(2048 + q_deg * 4096 / 360)",
        "def to_tick(q_deg):\n    return round(2048 + q_deg * 4095 / 360)",
        "def to_tick(q_deg):\n    return round(2048 + q_deg * 4096 / (2 * np.pi))",
    ],
}

#: {exercise: [{"code": what students write, "says": a part of the check's sentence}, ...]}
STUDENTS = tomllib.loads(Path(__file__).with_name("slips.toml").read_text(encoding="utf-8"))


def jobs(cells):
    """{number of a code cell: None where the answers of an exercise begin, or what `trials.Trial` wants to know}."""
    found, title, solutions, broken, number = {}, "", [], [], -1
    for cell in cells:
        number += is_code(cell)
        if "exercise" in tags(cell):
            title, solutions, broken = student.title(source(cell)), [], []
        elif "broken" in tags(cell):
            broken.append(source(cell))
        elif is_code(cell) and "solution" in tags(cell):
            if not solutions:
                found[number] = None
            solutions.append(source(cell))
        elif is_code(cell) and "check" in tags(cell) and solutions:
            found[number] = job(title, "\n".join(solutions), source(cell), broken)
    return found


def job(title, solution, check, broken):
    read, number = names_read(check), re.search(r"\d+\.\d+", title)
    answers = [name for name in student.bound(solution) if name in read]
    codes = [("the sheet as handed out", student.todo(solution, title, answers))]
    codes += [(f"the broken program {n}", code) for n, code in enumerate(broken)]
    codes += [(f"{name}: known {n}", code) for name in answers for n, code in enumerate(KNOWN.get(name, ()))]
    slips = STUDENTS.get(number[0], []) if number else []
    return {"title": title, "answers": answers, "check": check, "codes": codes, "slips": slips}


def names_read(code: str) -> set[str]:
    """The names that a cell uses."""
    return {node.id for node in ast.walk(ast.parse(code)) if isinstance(node, ast.Name)}
