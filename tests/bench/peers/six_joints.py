"""Six joints: all the answers of one pose, from our generated module and from others, compared both ways first."""

import importlib.util
import tempfile
from pathlib import Path

import numpy as np

from omx.derive import pattern, source
from tests.bench.peers.contest import Contest, agreed
from tests.bench.timing import Contender
from tests.helpers.six_joint_arms import ARMS, columns, configurations, gaps
from tests.helpers.six_joint_peers import PEERS, UNIT

#: Poses whose answers are compared before one of them is timed.
COMPARED = 200


def written(arm):
    """The generated module of an arm."""
    found = pattern(arm)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "six.py"
        path.write_text(source("six", found.functions(), rows=arm.rows, branches=found.branches, doc="An inverse."))
        spec = importlib.util.spec_from_file_location("six", path)
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
    return module


def answers(arm, module, T) -> np.ndarray:
    """The branches (N, 8, 6) of hands T (N, 4, 4), NaN where out of reach."""
    many, beyond = module.branches_batch(*columns(T)), module.missing_batch(*columns(T))
    q = np.array([[np.broadcast_to(value, len(T)) for value in one] for one in many]).transpose(2, 0, 1)
    missing = np.array([np.broadcast_to(gap, len(T)) for gap in beyond]).T
    return np.where(missing[..., None] <= 1e-9, q, np.nan)


def contest(peer: str, name: str) -> Contest:
    """All answers of one pose of the arm `name`, in the unit that the peer likes."""
    arm = ARMS[name]
    module, T = written(arm), arm.fk(configurations(arm, COMPARED, seed=12))
    rows = np.array([[row.theta, row.d, row.a, row.alpha, row.prismatic] for row in arm.rows], dtype=float)
    rows[:, 1:3] /= UNIT
    theirs_T = T.copy()
    theirs_T[:, :3, 3] /= UNIT
    solve = PEERS[peer](rows)
    found = [np.array([np.asarray(q, float) for q in solve(one)]) for one in theirs_T]
    theirs = np.full((COMPARED, max(map(len, found)), 6), np.nan)
    for into, one in zip(theirs, found, strict=True):
        into[: len(one)] = one
    ours = answers(arm, module, T)
    gap = agreed([gaps(arm, ours, theirs).max(), gaps(arm, theirs, ours).max()])
    numbers, one = [float(column[0]) for column in columns(T)], theirs_T[0]
    bare = getattr(solve, "bare", solve)

    def all_eight():
        return module.branches(*numbers), module.missing(*numbers)

    ours = [Contender("generated IK, eight branches, and which are within reach", all_eight)]
    return Contest(ours, [Contender(f"{peer}, all answers", lambda: bare(one))], gap)


def work(peer: str, names=("textbook", "UR5")) -> dict:
    """What `peer.py` measures of a peer: one pose of each arm."""
    return {f"IK of six joints, {name}, one": lambda _, name=name: contest(peer, name) for name in names}
