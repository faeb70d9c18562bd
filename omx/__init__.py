"""Kinematics of the OpenMANIPULATOR-X, as the book's notebooks derive it. Lengths in mm, angles in rad.

The small module: `errors`, `arm`, `geometry`, `dh`, `rotation`, `kinematics`, `arrays`, and `generated`, which the
notebooks write. Around it stand the rooms `derive`, `motion`, `analysis`, `exchange`, `hardware`, `display`, `check`.
"""

from importlib import import_module as _import_module

from .arm import HOME, LIMITS, ZERO
from .dh import Chain, DHRow
from .errors import (
    BadInput,
    BusCorrupt,
    BusError,
    BusTimeout,
    Collision,
    JointLimit,
    LogError,
    NotArrived,
    NotDecided,
    NotEqual,
    NotIdentifiable,
    NotReady,
    ObjectLost,
    OmxError,
    OutOfBounds,
    PathBlocked,
    PortBusy,
    PortError,
    PortLost,
    ReadOnly,
    ServoFault,
    ServoLost,
    ServoRefused,
    ServoRestarted,
    Stalled,
    Stopped,
    TooFast,
    TooHeavy,
    TorqueOff,
    Unreachable,
    ViewerMissing,
    Violation,
    Wrong,
)  # fmt: skip
from .geometry import COURSE, MAKER, Geometry, other_arm
from .kinematics import IKSolution, Pose, fk, frames, ik, ik_batch, jacobian, pose, solve_ik, warn_if_stale

#: What needs more than NumPy, or is needed less often: name -> where it lives. Imported when first asked for.
_LATER = {
    **{
        room: f"omx.{room}"
        for room in ("analysis", "check", "derive", "display", "exchange", "hardware", "motion", "rotation")
    },
    **dict.fromkeys(("clock", "doctor", "dynamixel", "log", "robot", "safety", "simulator"), "omx.hardware"),
    **dict.fromkeys(("Robot", "find_ports"), "omx.hardware.robot"),
    **dict.fromkeys(("Camera", "RowView", "View"), "omx.display.viewer"),
    **dict.fromkeys(
        ("HandPanel", "JointPanel", "LiveFigure", "PosePanel", "RobotPanel", "RowPanel", "TeachPanel"),
        "omx.display.panels",
    ),
    **dict.fromkeys(("panels", "plots", "viewer"), "omx.display"),
    **dict.fromkeys(("accuracy", "compiled", "same_robot", "workspace"), "omx.analysis"),
    **dict.fromkeys(("differential_ik", "trajectory"), "omx.motion"),
    "urdf": "omx.exchange",
}

__all__ = [
    "COURSE", "HOME", "LIMITS", "MAKER", "ZERO",
    "BadInput", "BusCorrupt", "BusError", "BusTimeout", "Camera", "Chain", "Collision", "DHRow", "Geometry",
    "HandPanel",
    "IKSolution", "JointLimit", "JointPanel", "LiveFigure", "LogError", "NotArrived", "NotDecided", "NotEqual",
    "NotIdentifiable", "NotReady", "ObjectLost", "OmxError", "OutOfBounds", "PathBlocked", "PortBusy", "PortError",
    "PortLost", "Pose", "PosePanel", "ReadOnly", "Robot", "RobotPanel", "RowPanel", "RowView", "ServoFault",
    "ServoLost", "ServoRefused", "ServoRestarted", "Stalled", "Stopped", "TeachPanel", "TooFast", "TooHeavy",
    "TorqueOff", "Unreachable", "View", "ViewerMissing", "Violation", "Wrong",
    "fk", "frames", "ik", "ik_batch", "jacobian", "other_arm", "pose", "solve_ik",
]  # fmt: skip

warn_if_stale()


def __getattr__(name: str):
    """`omx.Robot`, and rooms such as `omx.motion`, when first asked for: `import omx` itself needs NumPy alone."""
    where = _LATER.get(name)
    if where is None:
        raise AttributeError(f"module 'omx' has no attribute {name!r}", name=name, obj=_import_module(__name__))
    if where == f"omx.{name}":
        return _import_module(where)
    module = _import_module(where)
    return getattr(module, name) if hasattr(module, name) else _import_module(f"{where}.{name}")


def __dir__() -> list[str]:
    return sorted({*__all__, *_LATER})
