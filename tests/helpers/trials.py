"""Tries wrong answers on an exercise, in the kernel that has just run it: each is refused with one sentence.

The pytest plugin `chapter_runs` asks for it: `remember` before the first answer and before the check, then `tried`. The
answers are those of `mutants.py`, and what `exercises.py` adds.
"""

import contextlib
import io
import json
import sys
import traceback
import warnings

from omx.check import Wrong
from omx.check.notebook import explained
from tests.helpers.mutants import Overheard, wrong_answers

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
    **{name: {"arc sine of its sine"} for name in ("sine_of", "cosine_of", "brought")},  # at most pi/2
    **{name: {"arc sine of its sine"} for name in ("of_sine", "of_cosine")},  # at most 1
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


#: The names of the kernel before the first answer of an exercise, and before its check.
remembered = {}


def remember(when):
    remembered[when] = dict(sys.modules["IPython"].get_ipython().user_ns)


def tried(job):
    """Print, as JSON, what is wrong with the check of this job (JSON), and a line for each answer that was tried."""
    try:
        faults, table = results(Trial(**json.loads(job), **remembered))
    except Exception:
        faults, table = [traceback.format_exc()], []
    print(json.dumps([faults, table]))


class Trial:
    """One exercise: its answers, its check, and the names as they were before both."""

    def __init__(self, title, answers, check, codes, slips, before, after):
        self.title, self.answers, self.check, self.codes, self.slips = title, answers, check, codes, slips
        self.before, self.after = ({**names, "display": lambda *_, **__: None} for names in (before, after))

    def returned(self):
        """{name: what it returned to the check} of the answers that are functions, in a run that accepts them."""
        heard = {name: Overheard(self.after[name]) for name in self.answers if callable(self.after[name])}
        if heard:
            run(self.check, {**self.after, **heard})
        return {name: function.returned for name, function in heard.items()}

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


def results(trial):
    """(what is wrong, a line for each answer and what the check said to it)."""
    faults, returned = [], trial.returned()
    refusals = [(what, trial.refusal_of_code(code)) for what, code in trial.codes]
    for name in trial.answers:
        for done, wrong in wrong_answers(trial.after[name], returned.get(name)):
            said = trial.refusal(**{name: wrong})
            if said or getattr(wrong, "differed", True):
                refusals.append((f"{name}: {done}", said))
    for slip in trial.slips:
        said = trial.refusal_of_code(slip["code"])
        if not (slip["says"] in said if slip["says"] else not said):
            faults.append(f"the check should say {slip['says']!r} to\n{slip['code']}\nand says {said!r}")
    for done, said in refusals:
        name, _, slip = done.partition(": ")
        fine = RIGHT_ALL_THE_SAME.get(name, {"off by one", "off by a little"} if name.startswith("guess") else ())
        if not said and slip not in fine:
            faults.append(f"this wrong answer is accepted: {done}")
        elif len(said.splitlines()) > 1 or len(said) >= 420:
            faults.append(f"more than one sentence, or a long one, to {done}: {said}")
    return faults, [f"  {done:34} {said or 'ACCEPTED'}" for done, said in refusals]
