"""The Robotics Toolbox for Python: its elementary transforms, evaluated in C++, and its Newton-Raphson in C++."""

import numpy as np
import roboticstoolbox as rtb

import omx
from tests.bench.contenders import Q
from tests.bench.peers.contest import Contest, agreed, configurations, our_ik, returned, starts
from tests.bench.timing import Contender

ROWS = [rtb.RevoluteDH(d=row.d, a=row.a, alpha=row.alpha, offset=row.theta) for row in omx.COURSE.chain.rows]
ARM = rtb.DHRobot(ROWS, name="arm")
ETS = ARM.ets()

#: Half the square of the error (mm, rad): positions to 1e-6 mm.
TOLERANCE = 1e-13


def solved(T, start):
    """One solution near `start`; joint limits are left alone, a search would only begin again."""
    return ETS.ik_NR(T, q0=start, tol=TOLERANCE, joint_limits=False)[0]


def forward_one(_) -> Contest:
    q = np.array(Q)
    theirs = [
        Contender("DHRobot.fkine", lambda: ARM.fkine(q)),
        Contender("ETS.eval", lambda: ETS.eval(q)),
    ]
    gap = agreed([abs(ARM.fkine(q).A - omx.fk(Q)), abs(ETS.eval(q) - omx.fk(Q))])
    return Contest([Contender("omx.fk", lambda: omx.fk(Q))], theirs, gap)


def forward(count: int) -> Contest:
    q = configurations(count)
    gap = agreed(abs(ETS.eval(q[:1000]) - omx.fk(q[:1000])))
    ours = Contender("omx.fk (NumPy), 4x4 matrices", lambda: omx.fk(q), count=count)
    return Contest([ours], [Contender("ETS.eval", lambda: ETS.eval(q), count=count)], gap)


def inverse_one(_) -> Contest:
    target, T, start = tuple(omx.pose(Q)), omx.fk(Q), starts(np.array(Q))
    ours = Contender("omx.solve_ik", lambda: omx.solve_ik(target, start))
    gap = returned([solved(T, start)], np.array([Q]))
    return Contest([ours], [Contender("ETS.ik_NR", lambda: solved(T, start))], gap)


def inverse(count: int) -> Contest:
    q = configurations(count)
    T, begin = omx.fk(q), starts(q)
    gap = returned([*map(solved, T[:1000], begin[:1000])], q[:1000])
    loop = Contender("a loop of ETS.ik_NR", lambda: [*map(solved, T, begin)], count=count)
    return Contest(our_ik(omx.pose(q)), [loop], gap)


WORK = {"FK, one": forward_one, "FK, batch": forward, "IK, one": inverse_one, "IK, batch": inverse}
