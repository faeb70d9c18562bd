"""What JavaScript needs to know about the arm, as plain data: `arm.js` and `tool.js` read it."""

from ...arm import HOME, LIMITS, ZERO
from ...collision import OVER_THE_TABLE, PAIRS, capsules
from ...geometry import Geometry
from ...kinematics import BRANCHES, IKSolution, frames
from ..palette import AXES, INK, PALETTE, REFUSED, VERMILION

#: In which frame each of `collision.capsules` stands still.
_FRAMES = (0, 2, 2, 3, 4, 4)


def branch_names() -> list[str]:
    """The four branches in words, in the order of `omx.ik`."""
    return [IKSolution(None, front, elbow_up).branch for front, elbow_up in BRANCHES]


def arm_data(geometry: Geometry, limits=LIMITS) -> dict:
    """Lengths, limits (rad), home, branches, the capsules in their frames (mm), and all colours."""
    parts = []
    for part, frame in zip(capsules(ZERO, geometry), _FRAMES, strict=True):
        T = frames(ZERO, geometry)[frame]
        a, b = ([round(float(v), 9) for v in T[:3, :3].T @ (end - T[:3, 3])] for end in (part.a, part.b))
        parts.append({"name": part.name, "frame": frame, "a": a, "b": b, "radius": part.radius})
    return {
        "geometry": list(geometry.values), "limits": [list(pair) for pair in limits], "home": list(HOME),
        "branches": branch_names(), "parts": parts, "pairs": [list(p) for p in PAIRS], "over": list(OVER_THE_TABLE),
        "colours": {"branches": PALETTE[:4], "axes": AXES, "ink": INK, "refused": REFUSED, "ellipse": VERMILION},
    }  # fmt: skip
