"""The checks of the exercises: right answers pass, every slip gets its own sentence, everything else is Wrong."""

import math
import re
import shutil
import subprocess
import sys

import numpy as np
import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st

import omx
from book.setup.paths import ROOT
from omx import check
from omx.check import mistakes, selftest

pytestmark = pytest.mark.filterwarnings("ignore:the matrix subclass:PendingDeprecationWarning")
Q = check.configurations(12)
T = omx.fk((0.3, -0.4, 0.5, 0.6))
x, y = sp.symbols("x y", real=True)


def wrong(function, *arguments, **options):
    """The message of the `Wrong` that the check raises."""
    with pytest.raises(check.Wrong) as caught:
        function(*arguments, **options)
    return str(caught.value)


def todo(*_):
    raise NotImplementedError("still to do")


# ---- right answers ---------------------------------------------------------------------------------------


RIGHT = {
    "value": lambda: check.value([1, 2.0], (1, 2), "two numbers"),
    "truth": lambda: check.value(np.bool_(False), False, "a truth"),
    "matrix": lambda: check.value(sp.Matrix([[1, 2]]), [[1, 2]], "a matrix"),
    "that": lambda: check.that(1 < 2, "Never said.", "an order"),
    "expression": lambda: check.expression(1 - sp.sin(x) ** 2, sp.cos(x) ** 2, "a cosine"),
    "function": lambda: check.function(omx.fk, omx.COURSE.chain.fk, list(Q)),
    "round trip": lambda: check.round_trip(np.exp, np.log, np.eye(3), name="exp"),
}  # fmt: skip


@pytest.mark.parametrize("name", RIGHT)
def test_a_right_answer_passes_with_one_line(name, capsys):
    RIGHT[name]()
    said = capsys.readouterr().out
    assert said.startswith("Correct: ")
    assert said.count("\n") == 1


def test_what_is_printed_is_the_same_every_time(capsys):
    for _ in range(2):
        check.function(omx.fk, omx.COURSE.chain.fk, list(Q), "T")
    first, second = capsys.readouterr().out.splitlines()
    assert first == second == "Correct: T, at 12 samples."


@given(st.floats(-500, 500), st.floats(-1, 1))
def test_what_is_off_by_more_than_the_tolerance_is_wrong_and_by_less_is_right(expected, off):
    within = 1e-3
    if abs(off) <= within:
        check.value(expected + 0.9 * off, expected, unit="mm", within=within)
    elif abs(off) > 1.01 * within:
        wrong(check.value, expected + off, expected, unit="mm", within=within)


# ---- slips -----------------------------------------------------------------------------------------------

POSE = np.array([120.0, -40.0, 205.0, 0.4])
POSES = [POSE, np.array([80.0, 33.0, 150.0, -0.7]), np.array([10.0, 260.0, 40.0, 1.1])]
UNITS = {"unit": "mm mm mm rad", "parts": "x y z pitch"}
SLIPS = {  # what the sentence says -> the slip, made in a pose
    "look like degrees": lambda x, y, z, pitch: (x, y, z, math.degrees(pitch)),
    "looks like metres": lambda x, y, z, pitch: (x / 1000, y / 1000, z / 1000, pitch),
    "1000 times too large": lambda x, y, z, pitch: (1000 * x, 1000 * y, 1000 * z, pitch),
    "a full turn off": lambda x, y, z, pitch: (x, y, z, pitch + math.tau),
    "x and y are swapped": lambda x, y, z, pitch: (y, x, z, pitch),
    "y has the wrong sign": lambda x, y, z, pitch: (x, -y, z, pitch),
    "pitch has the wrong sign": lambda x, y, z, pitch: (x, y, z, -pitch),
    "The sign is wrong": lambda x, y, z, pitch: (-x, -y, -z, -pitch),
    "All of it is 9.81 times too small": lambda *pose: tuple(part / 9.81 for part in pose),
    "All of it is 2 times too large": lambda *pose: tuple(2 * part for part in pose),
    "90 deg minus the angle": lambda x, y, z, pitch: (x, y, z, math.pi / 2 - pitch),
    "off by 1.0e-02: keep all digits": lambda x, y, z, pitch: (x + 0.01, y, z, pitch),
    "z is wrong; x, y and pitch are right": lambda x, y, z, pitch: (x, y, z + 50, pitch),
}


@pytest.mark.parametrize("sentence", SLIPS)
def test_each_slip_has_its_sentence(sentence):
    message = wrong(check.value, SLIPS[sentence](*POSE), POSE, "the pose", **UNITS)
    assert sentence in message
    assert message.startswith("the pose is not right.")


@pytest.mark.parametrize("sentence", SLIPS)
def test_each_slip_of_a_function_is_found_from_all_samples(sentence):
    slip = SLIPS[sentence]
    message = wrong(check.function, lambda pose: slip(*pose), lambda pose: pose, POSES, "slipped", **UNITS)
    assert sentence in message
    assert "For ([120. , -40. , 205. ,   0.4]) it returns" in message


def test_slips_of_matrices():
    assert "the transpose" in wrong(check.value, T.T, T, "T")
    assert "the inverse" in wrong(check.value, np.linalg.inv(T), T, "T")
    assert "the sign is wrong" in wrong(check.value, -T, T, "T").lower()


def test_a_factor_is_claimed_only_where_it_explains_several_different_numbers():
    assert "times too" not in wrong(check.value, 10.0, 5.0, "one number")
    assert "times too" not in wrong(check.value, [2.0, 2.0], [1.0, 1.0], "two equal numbers")
    assert "times too" not in wrong(check.value, [2.0, 4.0, 6.5], [1.0, 2.0, 3.0], "three numbers")
    assert "3 times too small" in wrong(check.expression, x * y, 3 * x * y, "a product")
    assert "times too" not in wrong(check.expression, sp.sin(x), sp.cos(x), "a sine")


def test_a_count_is_one_number_and_a_transposed_matrix_of_expressions_is_told():
    assert "count once more" in wrong(check.value, 6, 8, "how many")
    assert "count once more" not in wrong(check.value, [1, 2, 0], [1, 0, 0], "three numbers")
    turned = wrong(check.expression, sp.Matrix([[1, y], [x, x * y]]), sp.Matrix([[1, x], [y, x * y]]), "a matrix")
    assert "Rows and columns are exchanged" in turned


def test_degrees_and_squares():
    assert "look like radians" in wrong(check.value, 0.5, math.degrees(0.5), "the angle", unit="deg")
    assert "the root is missing" in wrong(check.value, 25.0, 5.0, "the distance", unit="mm")


def test_a_function_that_takes_radians_for_degrees():
    message = wrong(check.function, lambda q: omx.fk(np.radians(q)), omx.fk, list(Q), "fk")
    assert "radians already" in message


@given(st.lists(st.floats(-300, 300), min_size=3, max_size=3), st.lists(st.floats(-300, 300), min_size=3, max_size=3))
def test_no_slip_is_claimed_that_does_not_explain_the_answer(answer, expected):
    """Whatever the sentence says, putting it right gives what is expected: no advice that leads astray."""
    comparison = mistakes.Comparison(answer, expected, "mm mm mm", "x y z")
    with np.errstate(all="ignore"):
        explained = [sentence for fixed, sentence in comparison._slips() if comparison.same(fixed)]
    assert comparison.slip() == (explained[0] if explained else "")


# ---- whatever is no answer ---------------------------------------------------------------------------------

JUNK = (
    None,
    ...,
    NotImplemented,
    "12",
    b"12",
    [],
    {},
    [1, None],
    [1, ...],
    math.nan,
    [1, math.inf],
    object(),
    print,
    x,
)


def name_of(junk):
    """The same in every process."""
    return re.sub(" at 0x.*", "", repr(junk))


@pytest.mark.parametrize("junk", JUNK, ids=name_of)
def test_junk_is_wrong(junk):
    wrong(check.value, junk, 12.0)
    wrong(check.value, junk, [1.0, 2.0])
    wrong(check.value, junk, True)
    wrong(check.that, junk, "No.")
    wrong(check.function, lambda _: junk, lambda _: 12.0, [1.0])
    wrong(check.function, lambda _: junk, lambda _: [1.0, 2.0], [1.0])
    wrong(check.round_trip, lambda _: junk, lambda _: junk, [[1.0, 2.0]])


@pytest.mark.parametrize("junk", [j for j in JUNK if j is not x], ids=name_of)
def test_junk_is_no_expression(junk):
    wrong(check.expression, junk, sp.cos(x))
    wrong(check.expression, junk, sp.Matrix([x, y]))


@pytest.mark.parametrize("value", [1, 0, 1.0, "True", np.array([True])], ids=repr)
def test_true_ish_is_not_true(value):
    wrong(check.that, value, "No.")
    wrong(check.value, value, True)


def test_what_a_todo_leaves_is_called_so():
    assert "still the TODO" in wrong(check.value, ..., 1.0)
    assert "still the TODO" in wrong(check.function, todo, omx.fk, list(Q))
    assert "still the TODO" in wrong(check.function, ..., omx.fk, list(Q))
    assert "still the TODO" in wrong(check.round_trip, todo, omx.fk, Q)
    assert "`return`" in wrong(check.function, lambda q: None, omx.fk, list(Q))


def test_a_wrong_count_is_counted():
    assert "must be 2 values; yours is 3 values" in wrong(check.value, [1, 2, 3], [1, 2])
    assert "must return 4 numbers; it returned 2" in wrong(check.function, lambda q: q[:2], lambda q: q, list(Q))
    assert "of shape 4 x 4" in wrong(check.value, 1.0, T)


def test_no_samples_prove_nothing():
    for function in (check.function, check.round_trip):
        with pytest.raises(omx.BadInput, match="at least one sample"):
            function(np.exp, np.log, [])


def test_errors_inside_an_answer_are_explained():
    missing = eval("lambda q: cos(q[0])")
    assert "Did you mean np.cos?" in wrong(check.function, missing, omx.fk, list(Q))
    assert "did you mean np.cos?" in wrong(check.function, lambda q: math.cos(q), np.cos, list(Q))
    assert "sp.cos can, and float(...) makes" in wrong(check.function, lambda q: np.cos(x), np.cos, list(Q))
    assert "called with 1 argument" in wrong(check.function, lambda a, b: a, np.cos, list(Q))
    unwritten = ...
    assert "still the TODO" in wrong(check.function, lambda q: unwritten.fk(q), np.cos, list(Q))
    message = wrong(check.function, lambda q: 1 / 0, np.cos, list(Q), "inverse")
    assert "inverse stops with ZeroDivisionError" in message
    assert "called with ([0., 0., 0., 0.])" in message


def test_an_answer_may_not_change_the_samples():
    def spoils(q):
        q[:] = 0
        return omx.fk(q)

    samples = [row.copy() for row in Q]
    wrong(check.function, spoils, omx.fk, samples)
    np.testing.assert_array_equal(samples, Q)


def test_samples_of_different_shapes():
    samples = [np.ones(2), np.ones(3), 2 * np.ones(3)]
    check.function(lambda v: 2 * v, lambda v: v + v, samples, "double")
    assert "[2., 2., 2.]" in wrong(check.function, lambda v: v + 1, lambda v: 2 * v, samples, "double")


# ---- expressions -------------------------------------------------------------------------------------------


def test_expressions():
    assert "has the wrong sign" in wrong(check.expression, sp.Matrix([x, -y]), sp.Matrix([x, y]))
    assert "The sign is wrong" in wrong(check.expression, -sp.cos(x), sp.cos(x))
    assert "must not contain y" in wrong(check.expression, x + y, x)
    assert "another x than the chapter's" in wrong(check.expression, sp.Symbol("x"), x)
    assert "division by zero" in wrong(check.expression, x / (x - x), x)
    assert "must be of shape 2 x 1" in wrong(check.expression, x, sp.Matrix([x, y]))
    check.expression(x + y - y, x)
    check.expression(2, sp.Integer(2))
    wrong(check.expression, sp.sqrt(x**2), x)  # equal for positive x only


t, u = sp.symbols("t u", real=True)
a, b = sp.symbols("a b", positive=True)
NOT_FOR_ALL_VALUES = [  # answer, expected: equal for many values, not for all
    (sp.sqrt(1 - sp.sin(t) ** 2), sp.cos(t)),
    (sp.asin(sp.sin(t)), t),
    (sp.acos(sp.cos(t)), t),
    (sp.Abs(sp.cos(t)), sp.cos(t)),
    (sp.Abs(t), t),
    (sp.atan2(sp.sin(t), sp.cos(t)), t),
    (sp.Mod(t + sp.pi, 2 * sp.pi) - sp.pi, t),
    (sp.atan(u / t), sp.atan2(u, t)),
    (sp.sqrt(t**2), t),
    (sp.Piecewise((t, t < 100), (100, True)), t),
    (sp.Max(t, -50), t),
    (sp.sign(t), sp.Integer(1)),
    (sp.acos(t / a) + sp.asin(t / a), sp.Integer(2)),
    (2 * sp.log(t), sp.log(t**2)),
    (sp.Matrix([sp.cos(t), sp.Abs(sp.sin(t))]), sp.Matrix([sp.cos(t), sp.sin(t)])),
    (t + sp.Rational(1, 10**6), t),
]
FOR_ALL_VALUES = [
    (sp.sin(t) ** 2 + sp.cos(t) ** 2, 1),
    (sp.cos(t - u), sp.cos(t) * sp.cos(u) + sp.sin(t) * sp.sin(u)),
    (sp.atan2(sp.sqrt(1 - (t / a) ** 2), t / a), sp.acos(t / a)),
    (sp.sqrt(a**2 * b), a * sp.sqrt(b)),
    (sp.Abs(a), a),
    (sp.Matrix([[sp.sin(2 * t)]]), sp.Matrix([[2 * sp.sin(t) * sp.cos(t)]])),
    (sp.sqrt(-a), sp.I * sp.sqrt(a)),
    ((t**2 - u**2) / (t - u), t + u),
    (0.5 * t, t / 2),
]


@pytest.mark.parametrize(("answer", "expected"), NOT_FOR_ALL_VALUES, ids=str)
def test_what_is_equal_for_some_values_only_is_wrong(answer, expected):
    assert wrong(check.expression, answer, expected).startswith("the expression ")


@pytest.mark.parametrize(("answer", "expected"), FOR_ALL_VALUES, ids=str)
def test_what_is_equal_for_all_values_is_right_however_it_is_written(answer, expected):
    check.expression(answer, expected)


def test_an_expression_that_forgets_a_branch_is_told_where():
    message = wrong(check.expression, sp.sqrt(1 - sp.sin(t) ** 2), sp.cos(t))
    assert "right for some values only" in message
    assert re.search(r"At t = -?\d\S* it is 0\.\d+; -0\.\d+ is wanted", message)
    assert "not a real number" in wrong(check.expression, sp.log(t), sp.log(sp.Abs(t)))
    assert "give its right-hand side" in wrong(check.expression, sp.Eq(x, y), y)


def test_ranges_narrow_what_all_values_means():
    check.expression(sp.asin(sp.sin(t)), t, ranges={t: (-1.5, 1.5)})
    wrong(check.expression, sp.asin(sp.sin(t)), t, ranges={t: (-1.5, 1.8)})


# ---- answers that are judged by their properties -------------------------------------------------------------


@pytest.mark.parametrize(
    ("result", "gives", "sentence"),
    [
        (None, (), "lack its `return`"),
        (..., (3,), "still the TODO"),
        ([1, 2], (), "must be one number; yours is 2 numbers"),
        (3.0, (3,), "must be 3 numbers; yours is one number"),
        ([1, 2], (3,), "must be 3 numbers; yours is 2 numbers"),
        (np.matrix([1, 2, 3]), (3,), "must be 3 numbers; yours is of shape 1 x 3"),
        ([[1, 2], [3]], (None, 2), "must be made of numbers"),
        ([[1, 2]], (None, 3), "must be of shape any x 3; yours is of shape 1 x 2"),
        ("L3", (), "must be made of numbers"),
        (1, bool, "must be True or False"),
        ([], dict, "must be a dict"),
        ("13", int, "must be an int"),
        (10**400, (), "must be made of numbers"),
        (x, (), "still holds the symbols x"),
    ],
)
def test_a_call_whose_result_cannot_be_used_ends_with_one_sentence(result, gives, sentence):
    assert sentence in wrong(check.call, lambda: result, gives=gives, name="f")
    assert sentence in wrong(check.answer, result, gives, "f")


def test_a_call_gives_plain_numbers_and_cannot_change_its_arguments():
    def spoils(points):
        points[0] += 1
        return np.matrix(points)

    points = np.ones((2, 2))
    result = check.call(spoils, points, gives=(None, 2))
    assert type(result) is np.ndarray
    assert points.tolist() == [[1, 1], [1, 1]]
    assert type(check.call(lambda: sp.Rational(1, 2), gives=())) is float
    assert type(check.call(lambda: np.matrix([1]))) is not np.matrix
    assert check.call(lambda q: q[0] is None, [None], gives=bool)


def test_a_call_of_what_is_no_function_or_stops_ends_with_one_sentence():
    assert "still the TODO" in wrong(check.call, todo, 1.0)
    assert "must be a function" in wrong(check.call, 3.0, 1.0)
    assert "spoilt stops with ZeroDivisionError" in wrong(check.call, lambda: 1 / 0, name="spoilt")
    assert "called with 2 arguments" in wrong(check.call, lambda one: one, 1, 2)


# ---- numbers of one's own ------------------------------------------------------------------------------------


def test_variants_are_the_books_own_without_a_name_and_a_students_own_with_one(monkeypatch, tmp_path):
    monkeypatch.delenv("OMX_STUDENT", raising=False)
    monkeypatch.chdir(tmp_path)
    drawn = [check.variant("4.3", name).integers(10**9) for name in (None, "", "Ada", "ada ", "Bob")]
    assert drawn[0] == drawn[1] == 171447093, "stored outputs depend on this number"
    assert drawn[2] == drawn[3] != drawn[4] != drawn[0]
    assert check.variant("4.4").integers(10**9) != drawn[0]
    monkeypatch.setenv("OMX_STUDENT", "Ada")
    assert check.variant("4.3").integers(10**9) == drawn[2]


def test_a_name_is_kept_beside_the_notebooks_until_a_grader_sets_another(monkeypatch, tmp_path, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("OMX_STUDENT", raising=False)
    check.student(" Ada  LOVELACE")
    assert capsys.readouterr().out == "The numbers are those of 'ada lovelace' now.\n"
    hers = check.variant("4.3", "ada lovelace").integers(10**9)
    assert check.variant("4.3").integers(10**9) == hers
    monkeypatch.setenv("OMX_STUDENT", "")
    assert check.variant("4.3").integers(10**9) == 171447093


# ---- around it -----------------------------------------------------------------------------------------------


def test_configurations_are_legal_the_same_every_time_and_begin_where_formulas_break():
    q = check.configurations(200)
    assert q.shape == (200, 4)
    np.testing.assert_array_equal(q, check.configurations(200))
    assert not any(omx.COURSE.chain.violations(row) for row in q)
    np.testing.assert_array_equal(q[0], omx.ZERO)
    straight = omx.COURSE.delta - math.pi / 2
    assert np.abs(q[:4, 2] - straight).min() < 1e-3


def test_a_notebook_shows_the_message_alone():
    error = check.Wrong("Look at the sign.")
    assert error._render_traceback_() == ["Not yet. Look at the sign."]
    assert isinstance(error, (omx.OmxError, AssertionError))


def test_setup_passes_here(capsys):
    check.setup()
    lines = capsys.readouterr().out.splitlines()
    assert [line[:2] for line in lines] == ["ok"] * 4
    assert "(274.000, 0.000, 204.765) mm" in lines[-1]


def test_setup_says_what_is_missing_and_what_to_do(capsys, monkeypatch):
    monkeypatch.setattr(selftest, "NEEDED", ("numpy", "no-such-package"))
    message = wrong(check.setup)
    assert "!!  packages: no-such-package missing" in capsys.readouterr().out
    assert "python run.py repair" in message


STALE = """
import pathlib, warnings, omx, omx.check
from omx.display.viewer import View
path = pathlib.Path(omx.generated.fk.__file__)
with warnings.catch_warnings(record=True) as told:
    warnings.simplefilter("always")
    View()
    path.write_text(path.read_text() + "# another arm")
    View(geometry=omx.MAKER)
    assert not told
    View(), View()
    print(*(warning.message for warning in told))
omx.check.setup()
"""


def test_a_notebook_that_still_has_the_old_arm_says_so_once(tmp_path):
    """In a copy of the package: a chapter writes another arm while a kernel is running."""
    shutil.copytree(ROOT / "omx", tmp_path / "omx", ignore=shutil.ignore_patterns("__pycache__"))
    command = [sys.executable, "-c", STALE]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    first, *lines = done.stdout.splitlines()
    assert first.startswith("omx.generated.fk was written anew after this notebook had imported it")
    assert first.count("Choose Kernel > Restart Kernel") == 1, "once"
    assert "!!  generated modules: fk was written anew after this notebook had imported it" in lines
    assert done.stderr.strip().endswith("choose Kernel > Restart Kernel, then run the cells again.")


def test_setup_survives_what_is_broken(capsys, monkeypatch):
    def broken(_name):
        raise ImportError("no module of that name")

    monkeypatch.setattr(selftest.importlib, "import_module", broken)
    wrong(check.setup)
    assert "!!  generated modules: ImportError: no module of that name" in capsys.readouterr().out


def test_a_tolerance_that_is_no_number_lets_nothing_pass():
    with pytest.raises(check.Wrong):
        check.value(1.5, 1.0, within=math.nan)
