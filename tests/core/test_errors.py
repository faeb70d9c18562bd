"""Errors: one family, each with its data, each message with what to do next."""

import copy
import inspect
import re
import runpy
from math import pi, radians

import pytest

import omx
from omx import errors
from tests.helpers import processes

FAMILY = [c for _, c in inspect.getmembers(errors, inspect.isclass) if issubclass(c, Exception)]


@pytest.mark.parametrize("error", FAMILY)
def test_one_except_catches_them_all(error):
    assert issubclass(error, omx.OmxError)
    assert error.__doc__


#: One of each that takes arguments of its own; the others take a sentence.
MADE = [
    errors.Unreachable((600, 0, 204, 0), 229.1, (371, 0, 143, 0)),
    errors.JointLimit([errors.Violation("q2", 2.0, 1.5)], (0, 1.5, 0, 0), "here"),
    errors.Collision("hand", "base", 3.0, (0, 1, 2, 3)),
    errors.TooFast("q1", 2.0, 1.0, 3.5),
    errors.PortError("/dev/x", "no", 13),
    errors.ReadOnly("webserial", "set goal_position to 5"),
    errors.BusTimeout("/dev/x", "read", (12, 13), (11,)),
    errors.ServoLost("/dev/x", "read", (12, 13), (11,)),
    errors.BusCorrupt("/dev/x", "read", 12, b"abc"),
    errors.ServoRefused("/dev/x", "move", 12, 7, "busy"),
    errors.ServoFault("/dev/x", {12: 4}, {12: ["hot"]}),
    errors.ServoRestarted("/dev/x", (12,), True),
    errors.PathBlocked(0.5, omx.Pose(1, 2, 3, 4), (0, 1, 2, 3), errors.BadInput("why")),
    errors.NotIdentifiable(["L1", "o1"]),
    errors.NotEqual("it", 3, {"q1": 0.1}, (1 + 0j, 2 + 0j)),
    errors.NotDecided("it", 3),
    errors.LogError("no", [(1.0, 2.0)]),
    errors.NotReady("the arm", ["a", "b"]),
    errors.Stalled(3, 700.0),
    errors.NotArrived(2, 0.1, "something in its way"),
    errors.OutOfBounds(errors.BadInput("why")),
    errors.ObjectLost(20.0, 3.0),
    errors.TooHeavy(2, 1500.0, 1000.0, 500.0, 300.0, (0, 1, 2, 3)),
]


def remade(kind):
    """An error of this kind: from the list, or of a sentence, or of nothing."""
    found = [error for error in MADE if type(error) is kind]
    for attempt in (lambda: found[0], kind, lambda: kind("why"), lambda: kind("/dev/x", "why")):
        try:
            error = attempt()
        except (TypeError, IndexError, ValueError):
            continue
        if str(error):
            return error
    raise AssertionError(f"{kind.__name__}: how is it made?")


def same(one, other):
    assert type(one) is type(other)
    assert str(one) == str(other)
    assert one.args == other.args
    assert repr(vars(one)) == repr(vars(other))


@pytest.mark.parametrize("kind", FAMILY)
def test_every_error_is_copied_with_its_message_and_data(kind):
    error = remade(kind)
    for again in (copy.copy(error), copy.deepcopy(error)):
        same(error, again)
        with pytest.raises(kind, match=re.escape(str(error))):
            raise again


def fail(kind):
    raise remade(kind)


def test_an_error_crosses_a_process_whole():
    """Without this a pool waits for ever, and an executor breaks."""
    with processes.pool() as pool:
        for kind in FAMILY:
            with pytest.raises(kind) as caught:
                pool.submit(fail, kind).result(timeout=60)
            same(remade(kind), caught.value)


def test_a_callers_mistake_is_also_a_value_error():
    assert issubclass(omx.BadInput, ValueError)
    assert not issubclass(omx.Unreachable, ValueError)


def test_a_violation_reads_as_a_sentence():
    above = omx.Violation("q2", radians(95), radians(90))
    assert str(above) == "q2 = 95.00 deg is 5.00 deg above its limit 90.00 deg"
    assert above.excess == pytest.approx(radians(5))
    below = omx.Violation("d3", -4.0, 0.0, prismatic=True)
    assert str(below) == "d3 = -4.00 mm is 4.00 mm below its limit 0.00 mm"


def test_no_excess_is_too_small_to_be_read():
    assert "is 1.1e-07 deg above" in str(omx.Violation("q2", 1.5 + 2e-9, 1.5))
    assert "1.0e-09 mm are missing" in str(omx.Unreachable((0, 0, 0, 0), 1e-9, (0, 0, 0, 0)))


def test_unreachable_tells_how_far_and_where_to_go_instead():
    error = omx.Unreachable((600.0, 0.0, 204.0, pi / 2), 236.7191, omx.Pose(371.0, 0.0, 143.0, pi / 2))
    assert (error.pose[0], error.missing, error.nearest.x) == (600.0, 236.7191, 371.0)
    text = "(600.00, 0.00, 204.00) mm at pitch 90.00 deg is out of reach: 236.719 mm are missing. "
    assert str(error) == text + "The nearest reachable pose with this pitch is (371.00, 0.00, 143.00) mm."


def test_joint_limit_names_each_joint_and_the_nearest_legal_value():
    violations = [omx.Violation("q2", 2.0, 1.5), omx.Violation("d3", -1.0, 0.0, prismatic=True)]
    error = omx.JointLimit(violations, [0.0, 1.5, 0.0], "at the back")
    assert error.violations == tuple(violations)
    assert error.nearest == (0.0, 1.5, 0.0)
    assert str(error).startswith("at the back: q2 = 114.59 deg is 28.65 deg above its limit 85.94 deg; d3 = -1.00 mm")
    assert str(error).endswith("The nearest legal value: q2 = 85.94 deg, d3 = 0.00 mm.")


def test_a_notebook_shows_the_readers_lines_and_the_sentence_alone(tmp_path):
    mine = tmp_path / "mine.py"
    mine.write_text("import omx\n\ndef go():\n    return omx.solve_ik([900, 0, 0, 0])\n\ngo()\n")
    with pytest.raises(omx.Unreachable) as caught:
        runpy.run_path(str(mine))
    first, second, *rest = caught.value._render_traceback_()[-3:]
    assert (first, second) == ("line 6:   go()", "line 4 of go:   return omx.solve_ik([900, 0, 0, 0])")
    assert rest == [f"Unreachable: {caught.value}"]
