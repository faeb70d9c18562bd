"""Kinematics of the OpenMANIPULATOR-X, as the book's notebooks derive it. Lengths in mm, angles in rad."""

from importlib import import_module as _import_module

from .agreement import warn_if_stale as _warn_if_stale
from .dh import Chain, DHRow
from .errors import BadInput, JointLimit, OmxError, Unreachable, Violation
from .geometry import COURSE, HOME, LIMITS, MAKER, ZERO, Geometry
from .kinematics import IKSolution, Pose, fk, frames, ik, ik_batch, jacobian, pose, solve_ik

__all__ = [
    "COURSE", "HOME", "LIMITS", "MAKER", "ZERO",
    "BadInput", "Chain", "DHRow", "Geometry", "IKSolution", "JointLimit", "OmxError", "Pose", "Robot", "Unreachable",
    "Violation", "fk", "frames", "ik", "ik_batch", "jacobian", "pose", "solve_ik",
]  # fmt: skip

_warn_if_stale()

_LATER = {
    "accuracy", "check", "codegen", "compare", "differential", "doctor", "dynamixel", "fast", "log", "panel", "plots",
    "robot", "rotation", "safety", "symbolic", "trajectory", "view", "virtual", "workspace",
}  # fmt: skip


def __getattr__(name: str):
    """`omx.Robot`, and modules such as `omx.view`, when first asked for: `import omx` itself needs NumPy alone."""
    if name == "Robot":
        return _import_module("omx.robot").Robot
    if name in _LATER:
        return _import_module(f"omx.{name}")
    raise AttributeError(f"module 'omx' has no attribute {name!r}", name=name, obj=_import_module(__name__))


def __dir__() -> list[str]:
    return sorted({*__all__, *_LATER})
