"""One row or many: every public array function gives for a batch what it gives for each row, or refuses it by name."""

import numpy as np
import pytest

import omx
from omx import BadInput, motion
from omx.analysis import accuracy, workspace

RNG = np.random.default_rng(12)
SHAPES = [(4,), (1, 4), (3, 4), (4, 4), (2, 3, 4)]
SIGMAS = {"L2": 0.1, "o1": 0.001}
CHAIN = omx.Chain([(0, 77, 0, -1.5), (0.2, 0, 130, 0), (0, 5, 124, 0.4), (0, 0, 0, 0, True)])


def angles(shape):
    return RNG.uniform(-1.2, 1.2, shape)


def poses(shape):
    return np.asarray(omx.pose(angles(shape)))


#: name -> (function of one array (..., 4), what makes the array).
MANY = {
    "fk": (omx.fk, angles),
    "pose": (omx.pose, angles),
    "frames": (omx.frames, angles),
    "jacobian": (omx.jacobian, angles),
    "ik": (lambda p: omx.ik(p).q if np.ndim(p) > 1 else omx.ik(p[None]).q[0], poses),
    "ik, verdicts": (lambda p: omx.ik(p).legal if np.ndim(p) > 1 else [s.legal for s in omx.ik(p)], poses),
    "clearance": (omx.collision.clearance, angles),
    "clear": (omx.collision.clear, angles),
    "Chain.matrices": (CHAIN.matrices, angles),
    "Chain.frames": (CHAIN.frames, angles),
    "Chain.fk": (CHAIN.fk, angles),
    "Chain.jacobian": (CHAIN.jacobian, angles),
    "task_jacobian": (motion.task_jacobian, angles),
    "manipulability": (motion.manipulability, angles),
    "motor_torques": (lambda q: motion.motor_torques(q, 1 + q, 2 - q, 100.0), angles),
    "joint_velocity": (lambda q: motion.joint_velocity(q, 10 * np.cos(q)), angles),
    "joint_velocity, damped": (lambda q: motion.joint_velocity(q, 10 * np.cos(q), 3.0), angles),
    "joint_velocity, one q": (lambda v: motion.joint_velocity(omx.HOME, v, 3.0), angles),
    "joint_velocity, one velocity": (lambda q: motion.joint_velocity(q, (30, 20, 10, 0.1)), angles),
    "task_error": (lambda p: motion.task_error(p, 0.01 * p), poses),
    "task_error, one pose": (lambda q: motion.task_error((200, 0, 100, 3.0), q), angles),
    "sensitivity": (lambda q: accuracy.sensitivity(q)["delta"], angles),
    "tip_error": (lambda q: accuracy.tip_error(q, SIGMAS), angles),
    "worst_tip_error": (lambda q: accuracy.worst_tip_error(q, SIGMAS), angles),
    "tips": (workspace.tips, angles),
    "tips of a chain": (lambda q: workspace.tips(q, CHAIN), angles),
    "reaches": (lambda p: workspace.reaches(p[..., [0, 2]]), poses),
    "Section.contains": (lambda p: workspace.section().contains(p[..., [0, 2]]), poses),
    "Section.distance": (lambda p: workspace.section().distance(p[..., [0, 2]]), poses),
    "Coordinates": (lambda q: omx.same_robot(CHAIN, CHAIN)(q), angles),
}

#: name -> a function that takes one row only.
ONE = {
    "solve_ik": lambda q: omx.solve_ik(q),
    "solve_ik, start": lambda q: omx.solve_ik((200, 0, 150, 0), q),
    "joint_move": lambda q: motion.joint_move(q, omx.HOME, 1.0),
    "joint_move, goal": lambda q: motion.joint_move(omx.HOME, q, 1.0),
    "line": lambda q: motion.line(q, (200, 0, 150, 0), 1.0),
    "line, pose": lambda q: motion.line(omx.HOME, q, 1.0),
    "iterate": lambda q: motion.iterate(q, omx.HOME),
    "iterate, start": lambda q: motion.iterate((200, 0, 150, 0), q),
    "iterate for a chain": lambda q: motion.iterate((200, 0, 150), q, geometry=CHAIN),
    "violations": CHAIN.violations,
    "check": CHAIN.check,
    "spread": lambda q: accuracy.spread(q, SIGMAS, 10),
}


@pytest.mark.parametrize("name", MANY)
def test_a_batch_is_its_rows_one_by_one(name):
    function, make = MANY[name]
    for shape in SHAPES:
        batch = make(shape)
        found = np.asarray(function(batch))
        alone = np.array([function(row) for row in batch.reshape(-1, 4)])
        np.testing.assert_allclose(found, alone.reshape((*shape[:-1], *alone.shape[1:])), rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("name", ONE)
def test_what_takes_one_row_refuses_many(name):
    for shape in SHAPES[1:]:
        with pytest.raises(BadInput, match=r"must be|one at a time"):
            ONE[name](angles(shape))


@pytest.mark.parametrize("shape", [(5, 4), (2, 4)])
def test_rows_that_do_not_pair_are_refused(shape):
    with pytest.raises(BadInput, match="a row for each other"):
        motion.joint_velocity(angles((3, 4)), angles(shape))
    with pytest.raises(BadInput, match="a row for each other"):
        motion.task_error(poses((3, 4)), angles(shape))
