"""Same robot or not: the two Stanford tables of the source, and chains whose coordinates were changed on purpose."""

from dataclasses import replace

import numpy as np
import pytest
import sympy as sp

import omx
from omx import Chain, DHRow
from omx.analysis.equivalence import same_robot
from omx.errors import BadInput

P = np.pi / 2
STANDARD = Chain(
    [DHRow(0, 1, 0, -P), DHRow(0, 1, 0, P), DHRow(0, 0, 0, 0, True), DHRow(0, 0, 0, -P), DHRow(0, 0, 0, P),
     DHRow(0, 1, 0, 0)],
    name="standard",
)  # fmt: skip
PRINTED = Chain(
    [DHRow(0, 1, 0, -P), DHRow(0, 1, 0, -P), DHRow(-P, 0, 0, 0, True), DHRow(0, 0, 0, -P), DHRow(0, 0, 0, P),
     DHRow(0, 1, 0, 0)],
    name="printed table",
)  # fmt: skip
PROGRAM = Chain(
    [DHRow(0, 1, 0, -P), DHRow(0, 1, 0, P), DHRow(0, 0, 0, -P, True), DHRow(0, 0, 0, -P), DHRow(0, 0, 0, P),
     DHRow(0, 1, 0, 0)],
    name="printed program",
)  # fmt: skip


def test_the_printed_table_is_the_stanford_arm_in_other_coordinates():
    change = same_robot(STANDARD, PRINTED)
    assert str(change) == "q2 -> q2 + 180 deg, q4 -> q4 - 90 deg"
    q = np.random.default_rng(1).uniform(-3, 3, (50, 6))
    np.testing.assert_allclose(PRINTED.fk(change(q)), STANDARD.fk(q), atol=1e-9)


def test_the_change_named_in_the_errata_is_the_same_with_the_wrist_flipped():
    """From the table to the standard: q2 + 180, q4 - 90, -q5, q6 + 180 deg; (q4 + 180, -q5, q6 + 180) is no change."""
    q = np.random.default_rng(1).uniform(-3, 3, (50, 6))
    named = q * [1, 1, 1, 1, -1, 1] + [0, np.pi, 0, -P, 0, np.pi]
    np.testing.assert_allclose(STANDARD.fk(named), PRINTED.fk(q), atol=1e-9)


def test_the_printed_program_is_not():
    assert same_robot(STANDARD, PROGRAM) is None


def test_the_tips_of_the_source():
    q = [np.pi, 0, 6, np.radians(45), np.radians(25), 0]
    np.testing.assert_allclose(STANDARD.fk(q)[:3, 3], (-0.299, -1.299, 7.906), atol=5e-4)
    np.testing.assert_allclose(PROGRAM.fk(q)[:3, 3], (-0.299, -1.906, 6.701), atol=5e-4)


def test_a_chain_is_itself():
    assert str(same_robot(STANDARD, STANDARD)) == "the same coordinates"


def test_a_longer_link_is_another_robot():
    rows = list(STANDARD.rows)
    rows[1] = DHRow(0, 1.001, 0, P)
    assert same_robot(STANDARD, Chain(rows)) is None


def test_zeros_along_the_links_are_other_zeros_of_the_same_arm():
    along = Chain([(0, 77, 0, -P), (0, 0, 130, 0), (0, 0, 124, 0), (0, 0, 126, 0)])
    change = same_robot(omx.COURSE.chain, along)
    assert str(change) == "q2 -> q2 - 79.36 deg, q3 -> q3 + 79.36 deg"
    assert change.offsets[1] == pytest.approx(omx.COURSE.delta - P, abs=1e-9)


def test_a_rounded_table_is_the_same_arm_within_what_rounding_does():
    lean = np.radians(90 - 10.64)
    rounded = Chain([(0, 77, 0, -1.5708), (-lean, 0, 130, 0), (lean, 0, 124, 0), (0, 0, 126, 0)])
    change = same_robot(omx.COURSE.chain, rounded)
    assert str(change).startswith("the same coordinates; the same arm within 0.0")
    assert 1e-4 < change.gap < 0.04
    assert same_robot(omx.COURSE.chain, rounded, tolerance=1e-9) is None


@pytest.mark.parametrize("joints", [3, 6, 7])
def test_any_offset_and_any_sense_is_found(joints):
    """A sense is turned by turning the axis over, before and behind the joint."""
    random = np.random.default_rng(joints)
    for _ in range(3):
        sizes = random.uniform(30, 300, (joints, 2))
        twists, shifts = random.choice([0.3, P, -P, 0.0], joints), random.uniform(-3, 3, joints)
        rows = [DHRow(0, d, a, twist) for (d, a), twist in zip(sizes, twists, strict=True)]
        other = [DHRow(-shift, row.d, row.a, row.alpha) for shift, row in zip(shifts, rows, strict=True)]
        j = int(random.integers(1, joints))
        other[j - 1] = replace(other[j - 1], alpha=other[j - 1].alpha + np.pi)
        other[j] = DHRow(shifts[j], -rows[j].d, rows[j].a, rows[j].alpha + np.pi)
        change = same_robot(Chain(rows), Chain(other))
        assert change.gap < 1e-6
        q = random.uniform(-3, 3, (20, joints))
        np.testing.assert_allclose(Chain(other).fk(change(q)), Chain(rows).fk(q), atol=1e-6)
        other[1] = replace(other[1], a=other[1].a + 2)
        assert same_robot(Chain(rows), Chain(other)) is None


def test_a_slide_and_parallel_axes_leave_a_zero_open_for_a_while():
    scara = Chain([(0, 200, 180, 0), (0, 0, 140, np.pi), (0, 0, 0, 0, True), (0, 0, 0, 0)])
    moved = Chain([(0.3, 200, 180, 0), (-0.7, 0, 140, np.pi), (0, 20, 0, 0, True), (0.2, 0, 0, 0)])
    change = same_robot(scara, moved)
    q = np.random.default_rng(2).uniform(-1, 1, (20, 4))
    np.testing.assert_allclose(moved.fk(change(q)), scara.fk(q), atol=1e-9)
    assert "d3 -> d3 - 20 mm" in str(change)


@pytest.mark.parametrize("other", [None, [(0, 77, 0, 0)], Chain([(sp.Symbol("b"), 1, 0, 0)])])
def test_only_chains_with_numbers_are_compared(other):
    with pytest.raises(BadInput, match="`second` must"):
        same_robot(Chain([(0, 1, 0, 0)]), other)


def test_chains_with_other_joints_are_not_compared():
    with pytest.raises(BadInput, match="same joints"):
        same_robot(STANDARD, Chain(STANDARD.rows[:3]))
