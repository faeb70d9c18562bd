"""EAIK (C++): analytic inverse kinematics by subproblems.

It knows no family of four-axis arms with three parallel axes, but one of five-axis arms. So the hand gets a fifth
joint, a roll, that all our poses leave at 0. Of its four solutions two are ours, elbow up and down; the other two
roll the hand half over, where our other two reach over the back.

Arms of six joints it knows well; there both find all eight answers.
"""

from functools import partial

import numpy as np
from eaik.IK_HP import HPRobot

import omx
from omx.generated import fk, ik
from tests.bench.c_code import compiled
from tests.bench.contenders import Q
from tests.bench.peers import six_joints
from tests.bench.peers.contest import SAME, Contest, agreed, configurations, our_ik, threaded
from tests.bench.timing import Contender
from tests.helpers.oracles import angle_gap

L1, L2, L3, L4, DELTA = omx.COURSE.values
AXES = np.array([[0.0, 0, 1], [0, 1, 0], [0, 1, 0], [0, 1, 0], [1, 0, 0]])
OFFSETS = np.array(
    [[0, 0, L1], [0, 0, 0], [L2 * np.sin(DELTA), 0, L2 * np.cos(DELTA)], [L3, 0, 0], [L4, 0, 0], [0] * 3]
)
ARM = HPRobot(AXES, OFFSETS)

#: Our tool frame as seen from theirs, which keeps the base's axes at q = 0.
TURN = omx.fk(omx.ZERO)
TURN[:3, 3] = 0.0


def frames(q) -> np.ndarray:
    """The tool frames (n, 4, 4) of configurations (n, 4), in EAIK's axes."""
    return omx.fk(q) @ TURN.T


def same_gap(solutions, q) -> float:
    """How far (rad) those of our branches that give the whole frame, not just the pose, are from its nearest."""
    branches, reachable, _ = omx.ik_batch(omx.pose(q))
    gaps = []
    for found, ours, there, T in zip(solutions, branches, reachable, omx.fk(q), strict=True):
        ours = ours[there]
        ours = ours[abs(omx.fk(ours) - T).max(axis=(1, 2)) < SAME]
        assert len(ours), "no branch of ours gives the frame"
        gaps.append(angle_gap(np.array(found.Q)[:, None, :4], ours).max(axis=2).min(axis=0).max())
    return agreed(gaps)


def forward_one(_) -> Contest:
    q, five = np.array([Q]), np.array([*Q, 0.0])
    gap = agreed(abs(ARM.fwdKin(five) - frames(q)[0]))
    theirs, made = Contender("fwdKin", lambda: ARM.fwdKin(five)), compiled([fk.transform])
    in_c = made and Contender("the same in C through cffi", partial(matrix_in_c, *made))
    return Contest([Contender("omx.fk", lambda: omx.fk(Q))], [theirs], gap, in_c=in_c)


def matrix_in_c(ffi, lib) -> np.ndarray:
    """The matrix by the generated lines in C, in a new array like theirs."""
    T = np.empty((4, 4))
    lib.transform(*Q, *omx.COURSE.values, ffi.from_buffer("double[]", T))
    return T


def forward(count: int) -> Contest:
    q = configurations(count)
    five = np.column_stack([q, np.zeros(count)])
    gap = agreed(abs(np.array([*map(ARM.fwdKin, five[:1000])]) - frames(q[:1000])))
    loop = Contender("a loop of fwdKin", lambda: np.array([*map(ARM.fwdKin, five)]), count=count)
    return Contest([Contender("omx.fk (NumPy), 4x4 matrices", lambda: omx.fk(q), count=count)], [loop], gap)


def inverse_one(_) -> Contest:
    q, target = np.array([Q]), tuple(omx.pose(Q))
    T = frames(q)[0]
    ours = [
        Contender("generated IK, four branches", lambda: ik.branches(*target, *omx.COURSE.values)),
        Contender("omx.ik, four branches with verdicts", lambda: omx.ik(target)),
    ]
    return Contest(ours, [Contender("IK, four solutions", lambda: ARM.IK(T).Q)], same_gap([ARM.IK(T)], q))


def inverse(count: int) -> Contest:
    q = configurations(count)
    T = frames(q)
    gap = same_gap(ARM.IK_batched(T[:1000], 1), q[:1000])
    theirs = [
        Contender(threaded("IK_batched", n), lambda n=n: ARM.IK_batched(T, n), count=count, threads=n, wall=True)
        for n in (1, 2)
    ]
    return Contest(our_ik(omx.pose(q)), theirs, gap)


WORK = {
    "FK, one": forward_one,
    "FK, batch": forward,
    "IK, one": inverse_one,
    "IK, batch": inverse,
    **six_joints.work("eaik"),
}
