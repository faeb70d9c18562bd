"""ikpy: a chain of DH links, one configuration at a time, and its least-squares search for the inverse."""

import numpy as np
from ikpy.chain import Chain
from ikpy.link import DHLink

import omx
from tests.bench.contenders import Q
from tests.bench.peers.contest import Contest, agreed, configurations, our_ik, returned, starts
from tests.bench.timing import Contender

ROWS = omx.COURSE.chain.rows
LINKS = [DHLink(f"joint {i}", d=r.d, a=r.a, alpha=r.alpha, theta=r.theta) for i, r in enumerate(ROWS, start=1)]
CHAIN = Chain(LINKS, active_links_mask=[True] * 4)

#: Of the search; it stops where steps and gains are this small, relatively.
TOLERANCE = 1e-14


def solved(T, start):
    """One solution near `start`: position and the direction of the hand."""
    return CHAIN.inverse_kinematics_frame(T, initial_position=start, orientation_mode="X", tol=TOLERANCE)


def forward_one(_) -> Contest:
    q = np.array(Q)
    theirs = [Contender("Chain.forward_kinematics", lambda: CHAIN.forward_kinematics(q))]
    gap = agreed(abs(CHAIN.forward_kinematics(q) - omx.fk(Q)))
    return Contest([Contender("omx.fk", lambda: omx.fk(Q))], theirs, gap)


def forward(count: int) -> Contest:
    q = configurations(count)
    gap = agreed(abs(np.array([*map(CHAIN.forward_kinematics, q[:1000])]) - omx.fk(q[:1000])))
    loop = Contender("a loop", lambda: np.array([*map(CHAIN.forward_kinematics, q)]), count=count)
    return Contest([Contender("omx.fk (NumPy), 4x4 matrices", lambda: omx.fk(q), count=count)], [loop], gap)


def inverse_one(_) -> Contest:
    target, T, start = tuple(omx.pose(Q)), omx.fk(Q), starts(np.array(Q))
    ours = Contender("omx.solve_ik", lambda: omx.solve_ik(target, start))
    gap = returned([solved(T, start)], np.array([Q]))
    return Contest([ours], [Contender("Chain.inverse_kinematics_frame", lambda: solved(T, start))], gap)


def inverse(count: int) -> Contest:
    q = configurations(count)
    T, begin = omx.fk(q), starts(q)
    gap = returned([*map(solved, T[:100], begin[:100])], q[:100])
    loop = Contender("a loop of the search", lambda: [*map(solved, T, begin)], count=count)
    return Contest(our_ik(omx.pose(q)), [loop], gap)


WORK = {"FK, one": forward_one, "FK, batch": forward, "IK, one": inverse_one, "IK, batch": inverse}
