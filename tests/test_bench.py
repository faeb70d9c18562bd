"""The benchmark runs, times what it says, and judges by ratios."""

import numpy as np
import pytest

from omx.generated import fk, ik
from tests import oracles
from tests.bench.c_code import compiled, only
from tests.bench.contenders import in_c, many, one_at_a_time
from tests.bench.timing import Contender, Result, clock, race


def test_every_contender_runs_and_every_ratio_has_its_reference():
    few_in_c, many_in_c = in_c(1000)
    for contenders in (one_at_a_time(few_in_c), [*many(1000), *many_in_c]):
        names = [contender.name for contender in contenders]
        assert len(set(names)) == len(names)
        for result in race(contenders, rounds=1):
            assert result.ns > 0
            assert (result.ratio is None) == (result.contender.against not in names)


def busy(milliseconds):
    def call():
        end = clock() + milliseconds / 1000
        while clock() < end:
            pass

    return call


def test_twice_the_work_is_a_ratio_of_two():
    _, double = race([Contender("one", busy(1)), Contender("two", busy(2), "one", at_most=1.5)], rounds=9)
    assert double.ratio == pytest.approx(2, rel=0.2)
    assert double.verdict == "NOT as expected"


@pytest.mark.parametrize(
    ("at_most", "absolute", "verdict"),
    [(None, False, ""), (0.6, False, "as expected"), (0.4, False, "NOT as expected"), (90.0, True, "NOT as expected")],
)
def test_verdicts(at_most, absolute, verdict):
    contender = Contender("omx", lambda: None, "reference", at_most, absolute)
    assert Result(contender, ns=100.0, ratio=0.5).verdict == verdict


def test_one_branch_is_that_branch():
    target = (200.0, 50.0, 150.0, -0.3, *oracles.COURSE)
    assert only(ik.branches, "back_up")(*target) == ik.branches(*target)[2]


def test_c_is_the_same_formula():
    made = compiled([fk.pose, ik.branches, fk.transform])
    if made is None:
        pytest.skip("no C compiler")
    ffi, lib = made
    for q in oracles.any_q(20).tolist():
        for name, function in (("pose", fk.pose), ("transform", fk.transform)):
            out = ffi.new("double[]", 16)
            getattr(lib, name)(*q, *oracles.COURSE, out)
            expected = np.ravel(function(*q, *oracles.COURSE))
            np.testing.assert_allclose(list(out)[: len(expected)], expected, atol=1e-12)
