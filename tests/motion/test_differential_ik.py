"""Differential inverse kinematics: velocities are followed, damping bounds them, iteration meets the closed form."""

import numpy as np
import pytest

import omx
from omx.errors import BadInput
from omx.motion.differential_ik import RADIAN_MM, iterate, joint_velocity, manipulability, task_error, task_jacobian

RNG = np.random.default_rng(8)
LOW, HIGH = np.array(omx.LIMITS).T
STRAIGHT = (0.2, 0.5, omx.COURSE.delta - np.pi / 2, 0.3)


def test_the_task_jacobian_is_the_derivative_of_the_pose():
    q, h = RNG.uniform(LOW, HIGH, 4), 1e-6
    columns = [(np.array(omx.pose(q + h * e)) - omx.pose(q - h * e)) / (2 * h) for e in np.eye(4)]
    np.testing.assert_allclose(task_jacobian(q), np.column_stack(columns), atol=1e-6)


def test_manipulability_is_the_formula_of_chapter_05():
    q = RNG.uniform(LOW, HIGH, (500, 4))
    r = np.hypot(*omx.pose(q)[:, :2].T)
    expected = 130 * 124 * r * np.abs(np.cos(q[:, 2] - omx.COURSE.delta))
    np.testing.assert_allclose(manipulability(q), expected, rtol=1e-9, atol=1e-6)


def test_without_damping_the_tool_moves_as_asked():
    q, v = np.array(omx.HOME), np.array([30.0, -20.0, 10.0, 0.1])
    qd = joint_velocity(q, v)
    np.testing.assert_allclose(task_jacobian(q) @ qd, v, atol=1e-9)
    h = 1e-6
    np.testing.assert_allclose((np.array(omx.pose(q + h * qd)) - omx.pose(q - h * qd)) / (2 * h), v, atol=1e-5)


def test_there_is_no_null_motion_away_from_singularities():
    """Four joints, four task variables: no joint motion leaves the tool at rest."""
    for q in RNG.uniform(LOW, HIGH, (100, 4)):
        if manipulability(q) > 1e5:
            assert np.linalg.matrix_rank(task_jacobian(q)) == 4


def test_at_the_straight_arm_one_motion_leaves_the_tool_at_rest():
    J = task_jacobian(STRAIGHT) * np.array([1, 1, 1, RADIAN_MM])[:, None]
    _, singular, rows = np.linalg.svd(J)
    assert singular[-1] < 1e-9 * singular[0]
    assert np.abs(J @ rows[-1]).max() < 1e-9 * singular[0]


@pytest.mark.parametrize("damping", [1.0, 5.0, 20.0])
def test_damping_bounds_the_joint_speed_even_where_the_arm_is_singular(damping):
    for velocity in RNG.normal(size=(50, 4)) * [50, 50, 50, 0.5]:
        size = np.linalg.norm(velocity * [1, 1, 1, RADIAN_MM])
        for offset in (0.0, 1e-9, 1e-3):
            q = np.add(STRAIGHT, (0, 0, offset, 0))
            assert np.linalg.norm(joint_velocity(q, velocity, damping)) <= size / (2 * damping) * (1 + 1e-9)


def test_the_iteration_meets_a_branch_of_the_closed_form():
    met = 0
    for q in RNG.uniform(LOW, HIGH, (60, 4)):
        if manipulability(q) < 5e5:
            continue
        found = iterate(omx.pose(q), q + RNG.normal(0, 0.1, 4))
        if found.converged:
            met += 1
            branches, reachable, _ = omx.ik_batch([omx.pose(q)])
            gaps = [np.abs(np.angle(np.exp(1j * (found.q - b)))).max() for b in branches[0][reachable[0]]]
            assert min(gaps) < 1e-6
    assert met > 30


def test_out_of_reach_the_iteration_does_not_claim_to_have_arrived():
    found = iterate([600, 0, 204, 0], omx.HOME)
    assert not found.converged
    assert found.steps == 100
    assert found.errors[-1] > 200


def test_errors_and_path_belong_together():
    found = iterate(omx.pose((0.3, 0.2, 0.1, 0.0)), omx.HOME)
    assert len(found.errors) == len(found.path) == found.steps + 1
    np.testing.assert_allclose(found.path[0], omx.HOME)


def test_the_pitch_error_takes_the_short_way_round():
    assert task_error([0, 0, 0, np.pi - 0.05], (0, 0, np.pi - 0.05, 0))[3] == pytest.approx(-0.1)


@pytest.mark.parametrize("way", ["position", "transform"])
def test_the_iteration_goes_for_any_chain(way):
    """Six joints, one of them a slide, to a point and to a whole transform."""
    quarter = np.pi / 2
    chain = omx.Chain([(0, 100, 0, -quarter), (0, 100, 0, quarter), (0, 0, 0, 0, True), (0, 0, 0, -quarter),
                       (0, 0, 0, quarter), (0, 100, 0, 0)])  # fmt: skip
    for seed in range(5):
        goal = np.add(np.random.default_rng(seed).uniform(-1, 1, 6), (0, 0, 200, 0, 0, 0))
        T = chain.fk(goal)
        found = iterate(T[:3, 3] if way == "position" else T, goal + 0.2, geometry=chain)
        assert found.converged
        reached = chain.fk(found.q)
        np.testing.assert_allclose(reached[:3, 3], T[:3, 3], atol=1e-5)
        if way == "transform":
            np.testing.assert_allclose(reached, T, atol=1e-5)


def test_half_a_turn_of_a_hand_is_an_error_of_half_a_turn():
    wrist = omx.Chain([(0, 0, 0, np.pi / 2), (0, 0, 0, -np.pi / 2), (0, 0, 0, 0)])
    turned = wrist.fk([0, 0, np.pi])
    assert iterate(turned, [0.0, 0.0, 0.0], geometry=wrist, steps=0).errors[0] == pytest.approx(RADIAN_MM * np.pi)


def test_mistakes_are_named():
    for start in ([omx.HOME] * 4, [omx.HOME], (0, 0)):
        with pytest.raises(BadInput, match="`start`"):
            iterate((200, 0, 150, 0), start)
    with pytest.raises(BadInput, match="`steps` must be a whole number"):
        iterate((200, 0, 150, 0), omx.HOME, steps=-1)
    for damping in (-1.0, 1e200):  # the square of the second is beyond all numbers
        with pytest.raises(BadInput, match="`damping` must be 0 to 1e100 mm"):
            joint_velocity(omx.HOME, [1, 0, 0, 0], damping)
        with pytest.raises(BadInput, match="`damping` must be 0 to 1e100 mm"):
            iterate((200, 0, 150, 0), omx.HOME, damping)
    with pytest.raises(BadInput, match="velocity"):
        joint_velocity(omx.HOME, [1, 0, 0])
