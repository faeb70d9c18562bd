"""Every exercise of every chapter refuses a family of wrong answers with one sentence, and accepts the right one."""

import contextlib
import io
import re
import tomllib
import warnings
from pathlib import Path

import pytest

from book.chapters import normalise, student
from book.chapters.cells import is_code, source, tags
from omx.check import Wrong
from omx.check.notebook import explained
from tests.helpers.mutants import Overheard, names_read, wrong_answers

CHAPTERS = sorted(normalise.NOTEBOOKS.glob("*.ipynb"))

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

#: name: slips that leave this answer right, because many answers are.
RIGHT_ALL_THE_SAME = {
    "waypoints": {"sign", "off by a little", "twice", "reversed", "in another order"},  # any legal triangle
    "mine": {"off by one", "off by a little", "reversed", "in another order"},  # any three level tips
    "nearest": {"sign", "the transposed expression"},  # the elbow folds either way; a row or a column
    "textbook_volume": {"off by one"},  # a litre of three thousand
    "q_chosen": {"twice"},  # any pose in the box
    "place": {"off by one", "off by a little", "twice"},  # any place from which the cups are reached
    "measuring_plan": {"reversed"},  # the order does not matter
    "missing": {"root of its square"},  # a distance
    "bulge": {"root of its square"},  # a length
    "chord": {"root of its square"},  # a length
    "r_max": {"root of its square"},  # a length
    "d3_squared": {"root of its square"},  # a square
    **{name: {"arc sine of its sine"} for name in ("sine_of", "cosine_of", "brought", "sign")},  # at most pi/2
    **{name: {"arc sine of its sine"} for name in ("sin_q5", "cos_q5", "sin_q6", "cos_q6")},  # at most 1
    "apart": {"root of its square"},  # a distance
    "radius_squared": {"root of its square"},  # a square
    "old_error": {"root of its square"},  # a distance
    "old_bend": {"root of its square"},  # a size
    "cos_shoulder": {"arc sine of its sine"},  # a cosine is at most 1
    "sigma_uniform": {"arc sine of its sine"},  # far below 1
    "sigma_sine": {"arc sine of its sine"},
    "variance": {"arc sine of its sine"},  # compared with samples, all of them small
    **{name: {"arc sine of its sine"} for name in ("turned_by", "jams")},  # angles below pi/2
    "release_heights": {"returns: off by one", "returns: off by a little"},  # anywhere within 5 mm
    "looks": {"off by a little", "reversed"},  # any six good pictures, in any order
    "sorting": {"in another order", "reversed"},  # the order does not matter
    "is_rigid": {"returns: one for True"},
    "reaches": {"returns: one for True"},
}


class Trial:
    """One exercise: the names as they were before its solution, the names that its check reads, and what it said.

    Its check has accepted the right answers; `heard` is what their functions gave it, `names` are those after it.
    """

    def __init__(self, exercise, before, after, solution, check, broken=()):
        self.title, self.before, self.after, self.check, self.broken = exercise, before, after, check, broken
        used = names_read(check)
        self.answers = [name for name in student.bound(solution) if name in used]
        self.todo = student.todo(solution, exercise, self.answers)
        self.heard = {name: Overheard(after[name]) for name in self.answers if callable(after[name])}
        names = {**after, **self.heard}
        run(check, names)
        self.names = {name: value for name, value in names.items() if name not in self.heard}

    def returned(self, name):
        return self.heard[name].returned if name in self.heard else None

    def refusal(self, **answers):
        """What the check says to these answers (the others right): its sentence, or '' if it accepts them."""
        return self.said({**self.after, **answers})

    def said(self, names):
        try:
            run(self.check, names)
        except Wrong as wrong:
            return str(wrong)
        except Exception as error:  # the notebook makes a sentence of it; here it is made by hand
            return "(*) " + explained(error)
        return ""

    def refusal_of_code(self, code):
        names = dict(self.before)
        with contextlib.suppress(Exception):
            run(code, names)
        return self.said(names)


def run(code, names):
    with contextlib.redirect_stdout(io.StringIO()), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        exec(compile(code, "<cell>", "exec"), names)


def trials(path):
    """The exercises of a chapter, its other cells run in this process: nothing is drawn."""
    names, title, solutions, broken = {"__name__": "__main__", "display": lambda *_, **__: None}, "", [], []
    for cell in normalise.read(path)["cells"]:
        code = source(cell)
        if "exercise" in tags(cell):
            title, before, solutions, broken = student.title(code), None, [], []
        elif "broken" in tags(cell):
            broken.append(code)
            with contextlib.suppress(Exception):
                run(code, names)
        elif is_code(cell) and "solution" in tags(cell):
            before = dict(names) if before is None else before
            solutions.append(code)
            run(code, names)
        elif is_code(cell) and "check" in tags(cell):
            if solutions:
                trial = Trial(title, before, dict(names), "\n".join(solutions), code, broken)
                yield trial
                names.update(trial.names)
            else:
                run(code, names)
        elif is_code(cell):
            with contextlib.suppress(Exception) if "raises-exception" in tags(cell) else contextlib.nullcontext():
                run(code, names)


@pytest.mark.parametrize("path", CHAPTERS, ids=lambda path: path.stem)
def test_every_wrong_answer_is_refused_by_a_sentence(path, tmp_path, monkeypatch):
    for name, value in {"MPLBACKEND": "Agg", "OMX_VIEW": "data", "OMX_GENERATED": str(tmp_path)}.items():
        monkeypatch.setenv(name, value)
    monkeypatch.chdir(tmp_path)
    table, accepted = [], []
    for trial in trials(path):
        table.append(f"\n{trial.title}")
        refusals = [("the sheet as handed out", trial.refusal_of_code(trial.todo))]
        refusals += [(f"the broken program {n}", trial.refusal_of_code(text)) for n, text in enumerate(trial.broken)]
        for name in trial.answers:
            right = trial.after[name]
            for done, wrong in wrong_answers(right, trial.returned(name)):
                said = trial.refusal(**{name: wrong})
                if said or getattr(wrong, "differed", True):
                    refusals.append((f"{name}: {done}", said))
            refusals += [
                (f"{name}: known {n}", trial.refusal_of_code(code)) for n, code in enumerate(KNOWN.get(name, []))
            ]
        number = re.search(r"\d+\.\d+", trial.title)
        for slip in STUDENTS.get(number[0] if number else "", ()):
            said = trial.refusal_of_code(slip["code"])
            fits = slip["says"] in said if slip["says"] else not said
            assert fits, f"{slip['code']}\n{said}"
        for done, said in refusals:
            table.append(f"  {done:34} {said or 'ACCEPTED'}")
            name, _, slip = done.partition(": ")
            fine = RIGHT_ALL_THE_SAME.get(name, {"off by one", "off by a little"} if name.startswith("guess") else ())
            if not said and slip not in fine:
                accepted.append(f"{trial.title}: {done}")
            elif said:
                assert len(said.splitlines()) == 1, said
                assert len(said) < 420, said
    by_hand = sum("(*)" in line for line in table)
    print("\n".join(table), f"\n\n{len(table)} lines; {by_hand} sentences are made of an error, marked (*)")
    assert not accepted, "these wrong answers are accepted:\n" + "\n".join(accepted)
