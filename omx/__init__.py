"""Kinematics of the OpenMANIPULATOR-X, as the book's notebooks derive it. Lengths in mm, angles in rad."""

from .agreement import warn_if_stale as _warn_if_stale
from .dh import Chain, DHRow
from .errors import BadInput, JointLimit, OmxError, Unreachable, Violation
from .geometry import COURSE, HOME, LIMITS, MAKER, ZERO, Geometry
from .kinematics import IKSolution, Pose, fk, frames, ik, ik_batch, jacobian, pose, solve_ik

__all__ = [
    "COURSE", "HOME", "LIMITS", "MAKER", "ZERO",
    "BadInput", "Chain", "DHRow", "Geometry", "IKSolution", "JointLimit", "OmxError", "Pose", "Unreachable",
    "Violation", "fk", "frames", "ik", "ik_batch", "jacobian", "pose", "solve_ik",
]  # fmt: skip

_warn_if_stale()
