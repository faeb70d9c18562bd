"""What JavaScript needs to know about an arm, as plain data: `arm.js` and `tool.js` read it."""

import math
from pathlib import Path

from ...arm import HOME, LIMITS, ZERO
from ...collision import OVER_THE_TABLE, PAIRS, capsules
from ...geometry import Geometry
from ...kinematics import BRANCHES, branch_name, frames
from ..palette import AXES, INK, PALETTE, REFUSED, VERMILION
from .assets import as_expression
from .skeleton import reach

#: In which frame each of `collision.capsules` stands still.
_FRAMES = (0, 2, 2, 3, 4, 4)

_COLOURS = {"axes": AXES, "ink": INK, "refused": REFUSED, "ellipse": VERMILION}


def branch_names() -> list[str]:
    """The four branches in words, in the order of `omx.ik`."""
    return [branch_name(front, elbow_up) for front, elbow_up in BRANCHES]


def chain_data(chain, limits, inverse=None) -> dict:
    """Any chain: its table, joints' names and limits (rad, mm; None where there is no end), reach (mm), and colours.

    `inverse`: its `omx.analysis.Inverse`, of which a page gets what was generated beside the Python.
    """
    fixed = {name: T.tolist() for name in ("base", "tool") if (T := getattr(chain, name)) is not None}
    about = {
        **fixed, "rows": [_numbers(row) for row in chain.rows], "names": list(chain.names), "reach": reach(chain),
        "limits": None if limits is None else [[v if math.isfinite(v) else None for v in pair] for pair in limits],
    }  # fmt: skip
    source = inverse and Path(inverse.module.__file__).with_suffix(".js")
    if source and source.is_file():
        about |= {"branches": list(inverse.branches), "lengths": list(inverse.lengths),
                  "inverse": as_expression(source.read_text(encoding="utf-8"))}  # fmt: skip
    colours = [PALETTE[k % len(PALETTE)] for k in range(len(about.get("branches", ())))]
    return {**about, "colours": {**_COLOURS, "branches": colours}}


def arm_data(geometry: Geometry, limits=LIMITS) -> dict:
    """The OpenMANIPULATOR-X: lengths, home, branches and the capsules in their frames (mm), beside its `chain_data`."""
    parts = []
    for part, frame in zip(capsules(ZERO, geometry), _FRAMES, strict=True):
        T = frames(ZERO, geometry)[frame]
        a, b = ([round(float(v), 9) for v in T[:3, :3].T @ (end - T[:3, 3])] for end in (part.a, part.b))
        parts.append({"name": part.name, "frame": frame, "a": a, "b": b, "radius": part.radius})
    return {
        **chain_data(geometry.chain, limits), "geometry": list(geometry.values), "home": list(HOME),
        "branches": branch_names(), "parts": parts, "pairs": [list(p) for p in PAIRS], "over": list(OVER_THE_TABLE),
        "colours": {**_COLOURS, "branches": PALETTE[:4]},
    }  # fmt: skip


def _numbers(row) -> dict:
    """A DH row as plain numbers."""
    numbers = {name: float(getattr(row, name)) for name in ("theta", "d", "a", "alpha")}
    return {**numbers, "prismatic": bool(row.prismatic)}
