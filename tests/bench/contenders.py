"""What is compared: our functions, pinocchio, the textbook product of 4x4 matrices, and C."""

from math import atan2

import numpy as np

import omx
from omx.generated import fk, ik, jacobian
from tests.bench.c_code import compiled, only
from tests.bench.timing import Contender, touch
from tests.helpers import oracles

Q = (0.3, -0.4, 0.35, 0.2)
TARGET = tuple(omx.pose(Q))
LENGTHS = omx.COURSE.values

PIN = "pinocchio: forwardKinematics"
PIN_READ = "pinocchio: the same, x, y, z and pitch read out"
PIN_J = "pinocchio: computeJointJacobians"
POSE = "generated pose"
IK = "generated IK, four branches"
COPY = "copy of the poses' bytes, q.copy()"


def textbook(q):
    """T_base_tool as every course writes it first: four 4x4 matrices, multiplied."""
    T = np.eye(4)
    for row, angle in zip(omx.COURSE.chain.rows, q, strict=True):
        theta, d, a, alpha = row.at(angle)
        ct, st, ca, sa = np.cos(theta), np.sin(theta), np.cos(alpha), np.sin(alpha)
        rotation = ([ct, -st * ca, st * sa, a * ct], [st, ct * ca, -ct * sa, a * st])
        T = T @ np.array([*rotation, [0, sa, ca, d], [0, 0, 0, 1]])
    return T


def with_pinocchio() -> tuple[list[Contender], list[Contender]]:
    """Forward kinematics, and Jacobians; nothing where pinocchio is not installed."""
    try:
        import pinocchio as pin
    except ImportError:
        return [], []
    _, model, data, tool = oracles.pinocchio_arm(oracles.table(*oracles.COURSE))
    q = np.array(Q)

    def read_out():
        pin.framesForwardKinematics(model, data, q)
        placement = data.oMf[tool]
        x, y, z = placement.translation.tolist()
        rotation = placement.rotation
        return x, y, z, atan2(rotation[2, 0], -rotation[2, 1])

    assert np.allclose(read_out(), omx.pose(Q))
    return [
        Contender(PIN, lambda: pin.forwardKinematics(model, data, q)),
        Contender(PIN_READ, read_out, PIN),
    ], [Contender(PIN_J, lambda: pin.computeJointJacobians(model, data, q))]


def one_at_a_time(in_c=()) -> list[Contender]:
    """A single configuration or pose; `in_c` are the same in C, for the group of what they are compared with."""
    poses, jacobians = with_pinocchio()
    numbers = np.array(Q)
    pose, bare = omx.pose, fk.pose  # to look a name up in `omx`, which imports its rooms when asked, takes 0.04 us
    one_branch = only(ik.branches, "front_up")
    assert one_branch(*TARGET, *LENGTHS) == ik.branches(*TARGET, *LENGTHS)[0]
    return [
        *poses,
        Contender(POSE, lambda: bare(*Q, *LENGTHS), PIN),
        Contender("omx.pose, against the generated pose", lambda: pose(Q), POSE, 1.5),
        Contender("omx.pose", lambda: omx.pose(Q), PIN, 0.6),
        Contender("omx.pose, against the pose read out", lambda: omx.pose(Q), PIN_READ, 0.6),
        Contender("omx.fk, the 4x4 matrix", lambda: omx.fk(Q), PIN),
        Contender("NumPy: product of four 4x4 matrices", lambda: textbook(numbers), PIN),
        *(contender for contender in in_c if contender.against == PIN),
        Contender(IK, lambda: ik.branches(*TARGET, *LENGTHS), "", 2000, absolute=True),
        Contender("generated IK, one branch", lambda: one_branch(*TARGET, *LENGTHS), IK),
        Contender("omx.ik, four branches", lambda: omx.ik(TARGET), IK, 2.5),
        Contender("omx.ik, and whether each is legal", lambda: [s.legal for s in omx.ik(TARGET)], IK, 2.5),
        Contender("omx.solve_ik", lambda: omx.solve_ik(TARGET, Q), IK),
        *(contender for contender in in_c if contender.against == IK),
        *jacobians,
        Contender("generated Jacobian", lambda: jacobian.jacobian(*Q, *LENGTHS), PIN_J),
        Contender("omx.jacobian, the 6x4 matrix", lambda: omx.jacobian(Q), PIN_J),
    ]


def many(count: int) -> list[Contender]:
    """Batches, against a copy of as many configurations."""
    q = oracles.random_q(count)
    poses = omx.pose(q)
    touch(count)
    return [
        Contender(COPY, q.copy, count=count),
        Contender("omx.pose", lambda: omx.pose(q), COPY, 15, count=count),
        Contender("omx.ik_batch, four branches with verdicts", lambda: omx.ik_batch(poses), COPY, 100, count=count),
        Contender("omx.fk, 4x4 matrices", lambda: omx.fk(q), COPY, count=count),
        Contender("omx.jacobian, 6x4 matrices", lambda: omx.jacobian(q), COPY, count=count),
    ]


def in_c(count: int) -> tuple[list[Contender], list[Contender]]:
    """The same formulas in C, for one and for many; nothing where there is no compiler."""
    made = compiled([fk.pose, ik.branches])
    if made is None:
        return [], []
    ffi, lib = made
    q = oracles.random_q(count)
    poses, out = omx.pose(q), np.empty((count, 18))
    lengths, one = ffi.new("double[]", LENGTHS), ffi.new("double[18]")
    rows, targets, results = (ffi.cast("double *", array.ctypes.data) for array in (q, poses, out))

    def fk_loop(keep=(q, out)):
        lib.pose_loop(rows, count, lengths, results)

    def ik_loop(keep=(poses, out)):
        lib.branches_loop(targets, count, lengths, results)

    lib.pose(*Q, *LENGTHS, one)
    assert np.allclose(list(one)[:4], TARGET)
    return [
        Contender("C through cffi: pose", lambda: lib.pose(*Q, *LENGTHS, one), PIN),
        Contender("C through cffi: IK, four branches", lambda: lib.branches(*TARGET, *LENGTHS, one), IK),
    ], [
        Contender("C: a loop of the same pose", fk_loop, COPY, count=count),
        Contender("C: a loop of the same four branches", ik_loop, COPY, count=count),
    ]
