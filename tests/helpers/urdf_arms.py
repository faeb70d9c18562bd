"""Arms whose URDF other programs read in tests: this arm, slides, six and seven joints, any base and tool."""

import os
from math import pi

import numpy as np

import omx
from omx.rotation import from_rpy

#: Configurations tried of each arm; OMX_POSES=1000 asks for more.
POSES = int(os.environ.get("OMX_POSES", 100))
#: How far (mm) two programs' transforms may be apart.
NEAR = 1e-9


def transform(xyz, rpy):
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = from_rpy(*rpy), xyz
    return T


SCARA = omx.Chain(
    [(0, 300, 200, 0), (0, 0, 150, pi), (0.3, 0, 0, 0, True), (0, 40, 0, 0)],
    [(-2, 2), (-2.5, 2.5), (0, 180), (-np.inf, np.inf)], name="SCARA",
)  # fmt: skip
WRIST = [(0, 200, 0, pi / 2), (0, 0, 0, -pi / 2), (0.2, 100, 0, 0)]
SIX = omx.Chain(
    [(0, 300, 0, pi / 2), (0.4, 0, 500, 0), (0, 20, 40, -pi / 2), *WRIST], [(-3, 3)] * 6, name="six & <more>",
    base=transform((100, -50, 30), (0.3, -1.0, 2.0)), tool=transform((5, 6, 70), (1.0, pi / 2, 0.3)),
)  # fmt: skip
RNG = np.random.default_rng(13)
SEVEN = omx.Chain(
    [(*RNG.uniform((-3, -200, -200, -3), (3, 200, 200, 3)), i == 4) for i in range(7)],
    [(-2, 2)] * 4 + [(-50, 150), (-1, 3), (-3, -1)], name="seven",
)  # fmt: skip

#: Name -> (what is written, the chain, is the base the maker's?).
ARMS = {
    "course": (omx.COURSE, omx.COURSE.chain, False),
    "maker": (omx.MAKER, omx.MAKER.chain, True),
    **{chain.name.split()[0]: (chain, chain, False) for chain in (SCARA, SIX, SEVEN)},
}


def poses(chain, count=POSES):
    """Configurations (count, n) within the chain's limits, a joint that turns freely anywhere."""
    low, high = np.array([(-pi, pi) if np.isinf(low) else (low, high) for low, high in chain.limits]).T
    return np.random.default_rng(7).uniform(low, high, (count, len(chain)))


def wanted(chain, q, maker_base):
    """The tool (count, 4, 4), mm, as the file's base link sees it."""
    return transform((12.0 if maker_base else 0.0, 0, 0), (0, 0, 0)) @ chain.fk(q)
