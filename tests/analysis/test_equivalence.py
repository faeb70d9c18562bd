"""Same robot or not: the two Stanford tables of the source, and chains whose coordinates were changed on purpose."""

import numpy as np
import pytest

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


def test_chains_with_other_joints_are_not_compared():
    with pytest.raises(BadInput, match="same joints"):
        same_robot(STANDARD, Chain(STANDARD.rows[:3]))
