"""Whole-array arithmetic: as exact as the standard library's, and arguments that are checked by name."""

import math
import subprocess
import sys
from fractions import Fraction

import numpy as np
import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st

import omx
from book.setup.paths import ROOT
from omx.arrays import BLOCK, as_rows, fill, in_blocks, sincos, wrap
from tests.helpers.oracles import NEAR

EPS = np.finfo(float).eps
TURNS = np.arange(-8, 9) * math.pi / 2
CORNERS = (TURNS[:, None] + NEAR).ravel()  # where the half-angle form has its zeros and its poles


def assert_sine_and_cosine(x):
    s, c = sincos(x)
    np.testing.assert_allclose(s, [math.sin(a) for a in x], atol=4 * EPS, rtol=0)
    np.testing.assert_allclose(c, [math.cos(a) for a in x], atol=4 * EPS, rtol=0)


def test_sincos_is_sine_and_cosine_everywhere():
    assert_sine_and_cosine(np.random.default_rng(0).uniform(-20, 20, 100_000))


def test_sincos_holds_at_its_poles_and_zeros():
    assert_sine_and_cosine(CORNERS)
    assert_sine_and_cosine(np.array([math.nextafter(math.pi, side) for side in (0, 9)]))


@given(st.floats(-1e15, 1e15))
def test_sincos_reduces_large_angles_correctly(angle):
    assert_sine_and_cosine(np.array([angle]))


def test_sincos_keeps_small_angles_to_the_last_digits():
    x = np.array([1e-300, -1e-20, 1e-9, 0.0])
    np.testing.assert_allclose(sincos(x)[0], x, rtol=2 * EPS)


def test_neither_function_changes_its_argument():
    x = np.linspace(-4, 4, 9)
    before = x.copy()
    sincos(x), wrap(x)
    np.testing.assert_array_equal(x, before)


@given(st.floats(-1e15, 1e15))
def test_wrap_is_the_remainder_of_the_standard_library(angle):
    wrapped = wrap(np.array([angle]))[0]
    assert -math.pi < wrapped <= math.pi
    gap = abs(wrapped - math.remainder(angle, math.tau))
    assert min(gap, math.tau - gap) <= 2 * EPS * max(abs(angle), math.pi)


def test_wrap_stays_in_its_interval_at_every_half_turn():
    wrapped = wrap(CORNERS)
    assert (wrapped > -math.pi).all()
    assert (wrapped <= math.pi).all()
    np.testing.assert_array_equal(wrap(np.array([math.pi, -math.pi, 3 * math.pi, 0.0])), [math.pi] * 3 + [0.0])


def test_wrap_stays_in_its_interval_one_float_after_the_other():
    """Every float near an odd number of half turns, where rounding could lead out of (-pi, pi]."""
    for half_turns in range(-41, 42, 2):
        x = half_turns * math.pi + np.arange(-500, 501) * np.spacing(half_turns * math.pi)
        wrapped = wrap(x)
        assert (wrapped > -math.pi).all()
        assert (wrapped <= math.pi).all()
        assert {-1.0, 1.0} == set(np.sign(wrapped).tolist())


# ---- arguments -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "value",
    [
        (1, 2, 3, 4),
        [1.0, 2.0, 3.0, 4.0],
        np.arange(1, 5, dtype=np.int32),
        np.arange(1, 5, dtype=np.float32),
        [Fraction(1), sp.Integer(2), 3, sp.Float(4)],
        range(1, 5),
    ],
    ids=["tuple", "list", "int32", "float32", "numbers of other kinds", "range"],
)
def test_every_kind_of_number_is_read(value):
    row = as_rows(value, "q", 4, "angles")
    assert row.dtype == np.float64
    np.testing.assert_array_equal(row, [1, 2, 3, 4])


def test_a_float64_array_is_not_copied():
    q = np.zeros((5, 4))
    assert as_rows(q, "q", 4, "angles") is q


MISTAKES = {
    "too short": ([1, 2, 3], r"got shape \(3,\)"),
    "too long": (np.zeros((2, 5)), r"got shape \(2, 5\)"),
    "columns as rows": (np.zeros((4, 7)), r"got shape \(4, 7\)"),
    "one number": (5.0, r"got shape \(\)"),
    "empty list": ([], r"got shape \(0,\)"),
    "empty batch": (np.empty((0, 4)), r"empty batch of shape \(0, 4\)"),
    "NaN": ([0, math.nan, 0, 0], r"got shape \(4,\) with `q`\[1\] = nan"),
    "infinity in a batch": ([[0, 0, 0, 0], [0, 0, math.inf, 0]], r"shape \(2, 4\) with `q`\[1, 2\] = inf"),
    "minus infinity": ([0, 0, 0, -math.inf], r"`q`\[3\] = -inf"),
    "a string": ("1234", "got '1234'"),
    "strings": (["1", "2", "3", "4"], r"got \['1', '2', '3', '4'\] of shape \(4,\)"),
    "bytes": (b"1234", "got b'1234'"),
    "None": (None, "got None"),
    "Nones": ([None] * 4, "None"),
    "one None": ([0.0, None, 0.0, 0.0], "None"),
    "complex": ([1j, 0, 0, 0], "1j"),
    "truth values": ([True] * 4, "True"),
    "an array of truth values": (np.ones((3, 4), dtype=bool), r"of shape \(3, 4\)"),
    "ragged": ([[1, 2, 3, 4], [1, 2]], "not a table of real numbers"),
    "a symbol": ([sp.Symbol("q1"), 0, 0, 0], "q1"),
    "a set": ({1.0, 2.0, 3.0, 4.0}, "not a table"),
    "a dict": ({"q1": 0, "q2": 0, "q3": 0, "q4": 0}, "not a table"),
    "a number too large for a float": ([10**400, 0, 0, 0], "not a table"),
    "an IK branch out of reach": (omx.ik([600, 0, 204, 0])[0], "out of reach by 236.7"),
    "a function": (math.sin, "not a table"),
}


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_answered_with_what_was_wanted_and_what_came(mistake):
    value, message = MISTAKES[mistake]
    with pytest.raises(omx.BadInput, match=message) as caught:
        as_rows(value, "q", 4, "the four joint angles in rad")
    assert "`q` must be the four joint angles in rad, shape (4,) or (..., 4)" in str(caught.value)


# ---- blocks --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("rows", [1, BLOCK - 1, BLOCK, BLOCK + 1, 2 * BLOCK + 5])
def test_blocks_cover_every_row_once(rows):
    table = np.arange(rows * 4.0).reshape(rows, 4)
    pieces = list(in_blocks(table))
    np.testing.assert_array_equal(np.concatenate([columns.T for _, columns in pieces]), table)
    np.testing.assert_array_equal(np.concatenate([table[piece] for piece, _ in pieces]), table)
    assert all(columns.flags.c_contiguous and columns.shape[1] <= BLOCK for _, columns in pieces)


@pytest.mark.skipif(sys.platform != "linux", reason="page faults are counted as Linux counts them")
def test_blocks_keep_their_memory():
    """In a fresh process: a block's columns (5 MB) come from memory that is there already, not from the system."""
    code = (
        "import resource, numpy as np, omx\n"
        "faults = lambda: resource.getrusage(resource.RUSAGE_SELF).ru_minflt\n"
        f"poses, before = np.tile([200.0, 0.0, 100.0, 0.1], ({16 * BLOCK}, 1)), faults()\n"
        "omx.ik_batch(poses)\n"
        "print((faults() - before) / 16)"
    )
    command = [sys.executable, "-c", code]
    told = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True, timeout=60)
    assert float(told.stdout) < 400  # about 90; 800 where every block's memory comes and goes


def test_fill_spreads_plain_numbers_over_the_batch():
    out = fill(np.empty((3, 2, 2)), ((np.arange(3.0), 0), (1, np.ones(3))))
    np.testing.assert_array_equal(out, [[[0, 0], [1, 1]], [[1, 0], [1, 1]], [[2, 0], [1, 1]]])
