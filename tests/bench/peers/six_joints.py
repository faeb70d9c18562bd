"""Six joints: all the answers of one pose, from our generated module and from others, compared both ways first."""

import tempfile

import numpy as np

from omx.analysis import Inverse
from omx.derive import write_inverse
from tests.bench.c_code import compiled
from tests.bench.peers.contest import Contest, agreed
from tests.bench.timing import Contender
from tests.helpers.six_joint_arms import ARMS, columns, configurations, gaps
from tests.helpers.six_joint_peers import PEERS, UNIT

#: Poses whose answers are compared before one of them is timed.
COMPARED = 200


def contest(peer: str, name: str) -> Contest:
    """All answers of one pose of the arm `name`, in the unit that the peer likes."""
    arm = ARMS[name]
    T = arm.fk(configurations(arm, COMPARED, seed=12))
    numbers = [float(column[0]) for column in columns(T)]
    with tempfile.TemporaryDirectory() as folder:
        module = write_inverse("six", arm, folder=folder)
        compiled_c = in_c(module, numbers)
    rows = np.array([[row.theta, row.d, row.a, row.alpha, row.prismatic] for row in arm.rows], dtype=float)
    rows[:, 1:3] /= UNIT
    theirs_T = T.copy()
    theirs_T[:, :3, 3] /= UNIT
    solve = PEERS[peer](rows)
    found = [np.array([np.asarray(q, float) for q in solve(one)]) for one in theirs_T]
    theirs = np.full((COMPARED, max(map(len, found)), 6), np.nan)
    for into, one in zip(theirs, found, strict=True):
        into[: len(one)] = one
    ours = Inverse(arm, module).batch(T).q
    gap = agreed([gaps(arm, ours, theirs).max(), gaps(arm, theirs, ours).max()])
    one = theirs_T[0]
    bare = getattr(solve, "bare", solve)

    def all_eight():
        return module.branches(*numbers), module.missing(*numbers)

    ours = [Contender("generated IK, eight branches, and which are within reach", all_eight)]
    return Contest(ours, [Contender(f"{peer}, all answers", lambda: bare(one))], gap, in_c=compiled_c)


def in_c(module, numbers) -> Contender | None:
    """The same two functions in C, their results compared first."""
    made = compiled([module.branches, module.missing], inputs=len(numbers))
    if made is None:
        return None
    ffi, lib = made
    q, gaps = ffi.new("double[48]"), ffi.new("double[8]")

    def all_eight():
        lib.branches(*numbers, q)
        lib.missing(*numbers, gaps)

    all_eight()
    agreed(abs(np.ravel(module.branches(*numbers)) - list(q)))
    return Contender("the same in C through cffi", all_eight)


def work(peer: str, names=("textbook", "UR5")) -> dict:
    """What `peer.py` measures of a peer: one pose of each arm."""
    return {f"IK of six joints, {name}, one": lambda _, name=name: contest(peer, name) for name in names}
