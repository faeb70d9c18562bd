"""pinocchio (C++): forward kinematics in a loop, and the Newton iteration that its manual shows for the inverse."""

from math import atan2

import numpy as np
import pinocchio as pin

import omx
from tests.bench.contenders import Q
from tests.bench.peers.contest import Contest, agreed, configurations, our_ik, our_pose, returned, starts
from tests.bench.timing import Contender
from tests.helpers import oracles

_, MODEL, DATA, TOOL = oracles.pinocchio_arm(oracles.table(*omx.COURSE.values))
STEPS, CLOSE = 50, 1e-9


def pose(q) -> tuple[float, float, float, float]:
    """x, y, z and pitch, read out of pinocchio's frame."""
    pin.framesForwardKinematics(MODEL, DATA, q)
    placement = DATA.oMf[TOOL]
    x, y, z = placement.translation.tolist()
    rotation = placement.rotation
    return x, y, z, atan2(rotation[2, 0], -rotation[2, 1])


def solved(target, q):
    """One solution near `q`: Gauss and Newton's steps on the error of the whole frame."""
    for _ in range(STEPS):
        pin.framesForwardKinematics(MODEL, DATA, q)
        error = pin.log6(DATA.oMf[TOOL].actInv(target)).vector
        if error @ error < CLOSE * CLOSE:
            return q
        J = pin.computeFrameJacobian(MODEL, DATA, q, TOOL, pin.LOCAL)
        q = q + np.linalg.solve(J.T @ J, J.T @ error)
    return q


def forward_one(_) -> Contest:
    q = np.array(Q)
    theirs = [
        Contender(
            "forwardKinematics alone, less work: nothing is read out", lambda: pin.forwardKinematics(MODEL, DATA, q)
        ),
        Contender("x, y, z and pitch read out", lambda: pose(q)),
    ]
    return Contest([Contender("omx.pose", lambda: omx.pose(Q))], theirs, agreed(oracles.pose_gap(pose(q), omx.pose(Q))))


def forward(count: int) -> Contest:
    q = configurations(count)
    gap = agreed(oracles.pose_gap([pose(row) for row in q[:1000]], omx.pose(q[:1000])))
    loop = Contender("a loop, read out", lambda: np.array([pose(row) for row in q]), count=count)
    return Contest(our_pose(q), [loop], gap)


def inverse_one(_) -> Contest:
    target, start = tuple(omx.pose(Q)), starts(np.array(Q))
    frame = pin.SE3(omx.fk(Q))
    gap = returned([solved(frame, start)], np.array([Q]))
    ours = Contender("omx.solve_ik", lambda: omx.solve_ik(target, start))
    return Contest([ours], [Contender("Newton's iteration", lambda: solved(frame, start))], gap)


def inverse(count: int) -> Contest:
    q = configurations(count)
    frames, begin = [pin.SE3(T) for T in omx.fk(q)], starts(q)
    gap = returned([solved(*both) for both in zip(frames[:1000], begin[:1000], strict=True)], q[:1000])
    loop = Contender("a loop of Newton's iteration", lambda: [*map(solved, frames, begin)], count=count)
    return Contest(our_ik(omx.pose(q)), [loop], gap)


WORK = {"FK, one": forward_one, "FK, batch": forward, "IK, one": inverse_one, "IK, batch": inverse}
