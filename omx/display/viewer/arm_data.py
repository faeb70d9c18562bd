"""What JavaScript needs to know about an arm, as plain data: `arm.js` and `tool.js` read it."""

import math
from dataclasses import asdict
from pathlib import Path

from ...arm import HOME, LIMITS, ZERO
from ...collision import OVER_THE_TABLE, PAIRS, capsules
from ...geometry import Geometry
from ...kinematics import BRANCHES, branch_name, frames
from ..palette import AXES, INK, PALETTE, REFUSED, VERMILION
from .arm_model import reach
from .assets import as_expression

#: In which frame each of `collision.capsules` stands still.
_FRAMES = (0, 2, 2, 3, 4, 4)

_COLOURS = {"axes": AXES, "ink": INK, "refused": REFUSED, "ellipse": VERMILION}


def branch_names() -> list[str]:
    """The four branches in words, in the order of `omx.ik`."""
    return [branch_name(front, elbow_up) for front, elbow_up in BRANCHES]


def slider_ends(chain, limits) -> list[tuple[float, float]]:
    """Where each joint's slider ends (rad, mm): at its limits; where it has none, half a turn or 100 mm from zero."""
    free = [(0.0, 100.0) if row.prismatic else (-math.pi, math.pi) for row in chain.rows]
    return [_finite(*pair) for pair in zip(limits or free, free, strict=True)]


def _finite(limit, free) -> tuple[float, float]:
    low, high = limit
    low = low if math.isfinite(low) else min(free[0], high - 1.0)
    return low, high if math.isfinite(high) else max(free[1], low + 1.0)


def joint_sliders(chain, limits) -> list[list]:
    """Name, unit, ends and step of each joint's slider, in degrees and mm."""
    rows = []
    for name, row, ends in zip(chain.names, chain.rows, slider_ends(chain, limits), strict=True):
        unit, scale = ("mm", 1.0) if row.prismatic else ("deg", 180 / math.pi)
        rows.append([name, unit, *_whole(*(scale * end for end in ends))])
    return rows


def _whole(low: float, high: float) -> tuple[float, float, float]:
    """A slider's ends and step: whole numbers within the limits, but for rounding; a short range as it is."""
    first, last = math.ceil(low - 1e-6), math.floor(high + 1e-6)
    if last - first < 2:
        return low, high, (high - low) / 100 or 1.0
    return first, last, 1.0


def chain_data(chain, limits, inverse=None) -> dict:
    """Any chain: its table, joints' names and limits (rad, mm; None where there is no end), reach (mm), and colours.

    `inverse`: its `omx.analysis.Inverse`, of which a page gets what was generated beside the Python.
    """
    fixed = {name: T.tolist() for name in ("base", "tool") if (T := getattr(chain, name)) is not None}
    about = {
        **fixed, "rows": [asdict(row) for row in chain.numeric_rows], "names": list(chain.names), "reach": reach(chain),
        "sliders": joint_sliders(chain, limits),
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
