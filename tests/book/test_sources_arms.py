"""Every example, table and simulation of the textbook chapter and of the Stanford arm's document; and their errata."""

from math import hypot, radians, sqrt

import numpy as np
import pytest

import omx
from omx import COURSE, Chain, DHRow
from omx.analysis import accuracy, workspace
from omx.rotation import from_rpy, to_rpy
from tests.helpers import oracles

QUARTER = radians(90)


def rad(*angles):
    return [radians(angle) for angle in angles]


# ---- the textbook: three joints, in mm -----------------------------------------------------------------

#: a, alpha (deg), d, as the textbook lists them, in metres.
THREE = ((0, 90, 0.3), (0.5, 0, 0), (0.4, 0, 0))
SIX = (*THREE, (0, 90, 0.2), (0, -90, 0), (0, 0, 0.1))
SIX_LIMITS = np.outer(rad(180, 90, 180, 180, 90, 180), (-1, 1))


def textbook(rows, **more):
    return Chain([DHRow(0, 1000 * d, 1000 * a, radians(alpha)) for a, alpha, d in rows], **more)


def test_three_joints_at_45_30_and_60_degrees():
    T = textbook(THREE).fk(rad(45, 30, 60))
    reach = 500 * sqrt(3) / 2 / sqrt(2)  # the second link points straight up
    half = sqrt(0.5)
    expected = [[0, -half, half, reach], [0, -half, -half, reach], [1, 0, 0, 950], [0, 0, 0, 1]]
    np.testing.assert_allclose(T, expected, atol=1e-12)
    assert round(reach, 3) == 306.186


@pytest.mark.parametrize("rows", [THREE, SIX], ids=["three joints", "six joints"])
def test_the_textbooks_arms_are_the_products_of_their_moves(rows):
    chain = textbook(rows)
    table = [(0, 1000 * d, 1000 * a, radians(alpha)) for a, alpha, d in rows]
    for q in np.random.default_rng(3).uniform(-3, 3, (50, len(rows))):
        np.testing.assert_allclose(chain.frames(q)[1:], oracles.product(table, q), atol=1e-11)


def test_its_workspace_by_ten_thousand_samples_fills_a_shell_about_the_shoulder():
    arm = textbook(THREE, limits=SIX_LIMITS[:3])
    tips = workspace.tips(workspace.sample_joints(10_000, geometry=arm), arm)
    away = np.linalg.norm(tips - [0, 0, 300], axis=1)
    assert 100 - 1e-9 <= away.min() < 102
    assert 898 < away.max() <= 900 + 1e-9


def test_the_six_joint_pose_is_position_rotation_angles_and_transform():
    arm = textbook(SIX, limits=SIX_LIMITS)
    q = rad(30, 45, -60, 20, 40, 10)
    arm.check(q)
    T = arm.fk(q)
    built = np.eye(4)
    built[:3, :3], built[:3, 3] = from_rpy(*to_rpy(T)), T[:3, 3]
    np.testing.assert_allclose(built, T, atol=1e-12)


@pytest.mark.parametrize("joint", range(6))
def test_each_limit_of_the_six_joint_arm_is_held(joint):
    arm = textbook(SIX, limits=SIX_LIMITS)
    q = np.zeros(6)
    q[joint] = SIX_LIMITS[joint, 1] + 0.01
    with pytest.raises(omx.JointLimit, match=rf"q{joint + 1} = .*above its limit"):
        arm.check(q)


def test_erratum_reachable_is_not_dexterous():
    """With "any orientation" in place of "at least one", the arm would have no workspace at all."""
    share = workspace.pitch_map(step=20.0, pitches=60).share
    assert np.count_nonzero(share > 0) > 500
    assert np.count_nonzero(share == 1) == 0


def test_erratum_three_angles_without_a_convention_are_another_orientation():
    roll, pitch, yaw = to_rpy(textbook(SIX).fk(rad(30, 45, -60, 20, 40, 10)))
    ours = oracles.turn_z(yaw)[:3, :3] @ from_rpy(0, pitch, 0) @ oracles.turn_x(roll)[:3, :3]
    other = oracles.turn_x(roll)[:3, :3] @ from_rpy(0, pitch, 0) @ oracles.turn_z(yaw)[:3, :3]
    np.testing.assert_allclose(from_rpy(roll, pitch, yaw), ours, atol=1e-12)
    turn = np.degrees(np.arccos((np.trace(ours.T @ other) - 1) / 2))
    assert round(turn, 1) == 25.4


def test_erratum_the_fast_program_forgets_the_offset():
    """It agrees where no offset is, as in the textbook's own examples, and errs by 166 mm on this arm."""

    def forgetful(chain):
        return Chain([DHRow(0, row.d, row.a, row.alpha) for row in chain.rows])

    q = np.random.default_rng(4).uniform(-3, 3, (20, 6))
    np.testing.assert_array_equal(forgetful(textbook(SIX)).fk(q), textbook(SIX).fk(q))
    gap = np.linalg.norm(forgetful(COURSE.chain).fk(omx.ZERO)[:3, 3] - omx.fk(omx.ZERO)[:3, 3])
    assert round(gap) == 166


def test_erratum_zip_drops_a_joint_silently():
    """Five angles for six joints: paired by `zip` the last row, 100 mm long, is left out; ours refuses."""
    arm, q = textbook(SIX), rad(30, 45, -60, 20, 40)
    dropped = np.linalg.norm((Chain(arm.rows[:5]).fk(q) - arm.fk([*q, 0.2]))[:3, 3])
    assert round(dropped) == 100
    with pytest.raises(omx.OmxError, match=r"got shape \(5,\)"):
        arm.fk(q)


def test_the_wrist_axes_of_the_six_joint_arm_meet_in_one_point():
    """Pieper's first case: so it has an inverse in closed form."""
    frames = textbook(SIX).frames(rad(30, 45, -60, 20, 40, 10))
    for axis, origin in ((frame[:3, 2], frame[:3, 3]) for frame in frames[3:6]):
        np.testing.assert_allclose(np.cross(frames[4][:3, 3] - origin, axis), 0, atol=1e-9)


def test_the_best_share_of_pitches_is_above_38_percent_and_lies_in_the_arms_own_column():
    poses = np.tile([-7.0, 0.0, 39.25, 0.0], (36_000, 1))
    poses[:, 3] = np.linspace(-np.pi, np.pi, 36_000, endpoint=False)
    share = omx.ik_batch(poses, limits=((-0.1, 0.1), *omx.LIMITS[1:]))[2].any(axis=1).mean()
    assert 0.385 < share < 0.39
    clear = workspace.pitch_map(allowed=workspace.clear).share
    assert 0.32 < np.nanmax(clear) < 0.33


def test_erratum_one_tick_is_more_than_the_accuracy_table_promises():
    """Printed: 0.05 mm, 0.005 deg, repeatability 0.02 mm. One tick is 0.088 deg, and up to 0.46 mm at zero."""
    assert round(np.degrees(accuracy.TICK), 3) == 0.088
    tick = max(np.linalg.norm(move) * accuracy.TICK for name, move in _moves(omx.ZERO).items())
    assert round(tick, 2) == 0.46
    assert np.degrees(accuracy.TICK) / 2 > 0.005
    ticks = dict.fromkeys(accuracy.OFFSETS, accuracy.TICK_SIGMA)
    assert (accuracy.tip_error(oracles.random_q(500), ticks) > 0.05).all()


def _moves(q):
    return {name: move for name, move in accuracy.sensitivity(q).items() if name in accuracy.OFFSETS}


# ---- the Stanford arm, in units of 1 -------------------------------------------------------------------

WRIST = (DHRow(0, 0, 0, -QUARTER), DHRow(0, 0, 0, QUARTER), DHRow(0, 1, 0, 0))
LIMITS = [rad(-180, 180), rad(-90, 90), (1, 3), rad(-180, 180), rad(-25, 25), rad(-180, 180)]
POSES = [(-90, 90, 6, 45, 25, 90), (180, 0, 6, 45, 25, 0), (90, -45, 6, 45, -25, 45)]
TIPS = [(1.299, -6.906, 0.701), (-0.299, -1.299, 7.906), (-0.701, -5.095, 5.672)]


def stanford(alpha_2=QUARTER, theta_3=0.0, alpha_3=0.0, d4=0.0, limits=None):
    """The standard model; the arguments are what the printed table and the printed program have instead."""
    first = [DHRow(0, 1, 0, -QUARTER), DHRow(0, 1, 0, alpha_2), DHRow(theta_3, 0, 0, alpha_3, prismatic=True)]
    return Chain([*first, DHRow(0, d4, 0, -QUARTER), *WRIST[1:]], limits)


STANDARD, PROGRAM = stanford(), stanford(alpha_3=-QUARTER)
TABLE = stanford(alpha_2=-QUARTER, theta_3=-QUARTER)


def values(pose):
    """A pose as printed (deg, the slide in units) as joint values."""
    q = np.radians(pose)
    q[2] = pose[2]
    return q


def moved(q, signs=(1, 1, 1, 1, 1, 1), degrees=(0, 0, 0, 0, 0, 0)):
    return q * signs + np.radians(degrees)


@pytest.fixture
def some_q():
    return np.random.default_rng(5).uniform(-3, 3, (50, 6))


def test_the_standard_model_is_the_product_of_its_moves(some_q):
    q90 = QUARTER
    table = ((0, 1, 0, -q90), (0, 1, 0, q90), (0, 0, 0, 0), (0, 0, 0, -q90), (0, 0, 0, q90), (0, 1, 0, 0))
    for q in some_q:
        np.testing.assert_allclose(STANDARD.frames(q)[1:], oracles.product(table, q, prismatic=(2,)), atol=1e-12)


@pytest.mark.parametrize(("pose", "tip"), list(zip(POSES, TIPS, strict=True)))
def test_the_three_simulated_poses(pose, tip):
    """The tips as chapter 10 prints them, and by hand: from the wrist the hand is one unit long."""
    frames = STANDARD.frames(values(pose))
    np.testing.assert_allclose(frames[-1][:3, 3], tip, atol=5e-4)
    wrist, shoulder = frames[4][:3, 3], np.array([0, 0, 1])
    assert np.linalg.norm(wrist - shoulder) == pytest.approx(hypot(6, 1))
    assert np.linalg.norm(frames[-1][:3, 3] - wrist) == pytest.approx(1)


def test_erratum_the_printed_table_is_the_same_arm_in_other_coordinates(some_q):
    ours = moved(some_q, degrees=(0, 180, 0, -90, 0, 0))
    np.testing.assert_allclose(TABLE.fk(ours), STANDARD.fk(some_q), atol=1e-12)
    flipped = moved(some_q, (1, 1, 1, 1, -1, 1), (0, 180, 0, 90, 0, 180))
    np.testing.assert_allclose(TABLE.fk(flipped), STANDARD.fk(some_q), atol=1e-12)
    back = moved(some_q, (1, 1, 1, 1, -1, 1), (0, 180, 0, -90, 0, 180))
    np.testing.assert_allclose(STANDARD.fk(back), TABLE.fk(some_q), atol=1e-12)
    assert np.abs(TABLE.fk(some_q) - STANDARD.fk(some_q)).max() > 1, "the coordinates do differ"


def test_other_toolboxes_differ_by_the_zero_of_joint_4(some_q):
    toolbox = stanford(theta_3=-QUARTER)
    shifted = moved(some_q, degrees=(0, 0, 0, 90, 0, 0))
    np.testing.assert_allclose(toolbox.fk(shifted), STANDARD.fk(some_q), atol=1e-12)


def test_the_wrist_flips_without_moving_the_hand(some_q):
    flipped = moved(some_q, (1, 1, 1, 1, -1, 1), (0, 0, 0, 180, 0, 180))
    np.testing.assert_allclose(STANDARD.fk(flipped), STANDARD.fk(some_q), atol=1e-12)


def test_erratum_the_printed_program_is_another_robot():
    """The tips that the errata page names; the wrist is right, the axis of joint 4 is 90 deg off the boom."""
    q = values(POSES[1])
    np.testing.assert_allclose(STANDARD.fk(q)[:3, 3], (-0.299, -1.299, 7.906), atol=5e-4)
    np.testing.assert_allclose(PROGRAM.fk(q)[:3, 3], (-0.299, -1.906, 6.701), atol=5e-4)
    standard, program = STANDARD.frames(q), PROGRAM.frames(q)
    np.testing.assert_allclose(program[4][:3, 3], standard[4][:3, 3], atol=1e-12)
    boom = standard[2][:3, 2]  # along which the slide moves
    assert standard[3][:3, 2] @ boom == pytest.approx(1)
    assert program[3][:3, 2] @ boom == pytest.approx(0, abs=1e-12)


def test_erratum_d4_adds_to_the_slide(some_q):
    for rows in ({}, {"alpha_2": -QUARTER, "theta_3": -QUARTER}):
        longer = np.add(some_q, (0, 0, 0.5, 0, 0, 0))
        np.testing.assert_allclose(stanford(d4=0.5, **rows).fk(some_q), stanford(**rows).fk(longer), atol=1e-12)


def test_erratum_in_the_program_d4_does_not_add_to_the_slide(some_q):
    """Its row 4 has d4, along an axis at a right angle to the slide: no slide makes up for it."""
    with_d4 = stanford(alpha_3=-QUARTER, d4=0.5)
    for sign in (1, -1):
        longer = np.add(some_q, (0, 0, sign * 0.5, 0, 0, 0))
        apart = np.linalg.norm((with_d4.fk(some_q) - PROGRAM.fk(longer))[:, :3, 3], axis=1)
        np.testing.assert_allclose(apart, sqrt(0.5), atol=1e-12)


def test_erratum_the_vector_of_joint_variables_has_q4():
    assert STANDARD.names == ("q1", "q2", "d3", "q4", "q5", "q6")
    q = values(POSES[0])
    without = STANDARD.fk(moved(q, (1, 1, 1, 0, 1, 1)))
    assert np.abs(without - STANDARD.fk(q)).max() > 0.1


@pytest.mark.parametrize("pose", POSES)
def test_erratum_all_simulations_break_the_limit_of_the_slide(pose):
    with pytest.raises(omx.JointLimit, match=r"d3 = 6.* above its limit 3") as caught:
        stanford(limits=LIMITS).check(values(pose))
    assert [violation.joint for violation in caught.value.violations] == ["d3"], "and no other"
    raised = [*LIMITS[:2], (1, 6), *LIMITS[3:]]
    stanford(limits=raised).check(values(pose))


def test_its_workspace_ends_where_shoulder_wrist_and_hand_are_in_line():
    arm = stanford(limits=LIMITS)
    tips = workspace.tips(workspace.sample_joints(20_000, geometry=arm), arm)
    furthest = np.linalg.norm(tips - [0, 0, 1], axis=1).max()
    assert 4.1 < furthest < hypot(3, 1) + 1
    assert np.arctan2(1, 3) < LIMITS[4][1], "joint 5 can bring the hand into line"
