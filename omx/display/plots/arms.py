"""Arms in a plane: any planar arm by its articulations, and the arm from the side, branch by branch."""

import math
from collections.abc import Sequence
from itertools import cycle

import numpy as np
from matplotlib.patches import Arc

from ... import kinematics
from ...arrays import as_four
from ...collision import capsules
from ...geometry import COURSE, Geometry
from ..palette import INK, PALE, PALETTE
from .picture import Picture, as_points, axes_of, finish, point_text


def planar(
    arms,
    labels: Sequence[str] = (),
    *,
    angles: bool = False,
    target=None,
    path=None,
    unit: str = "mm",
    alt: str = "",
    across: str = "x",
    up: str = "y",
) -> Picture:
    """Arms in their plane. Each of `arms` is an array (n + 1, 2): the base and every articulation, tip last.

    `angles`: write x1, x2, ... at the joints of the first arm. `target`: a point to mark. `path`: points (m, 2) to
    join by a thin line, broken where they are NaN. `across` and `up` name the axes. `alt` is put before the numbers
    in the alt text.
    """
    arms = [as_points(arm, "arms") for arm in (arms if np.iterable(arms) else ())] or [as_points(arms, "arms")]
    figure, axes = axes_of(f"{across} ({unit})", f"{up} ({unit})", square=True)
    labels = [*labels, *([""] * (len(arms) - len(labels)))]
    if path is not None:
        axes.plot(*np.asarray(path, float).T, color=PALE, lw=1.2, zorder=1)
    for arm, colour, label in zip(arms, cycle(PALETTE), labels, strict=False):
        _links(axes, arm, colour, label)
    if angles:
        _angle_marks(axes, arms[0])
    if target is not None:
        axes.plot(*target, marker="x", ms=11, mew=2.5, color=PALETTE[4], ls="", label="target", zorder=6)
    finish(axes)
    tips = "; ".join(
        f"{label or 'arm'} with its tip at {point_text(arm[-1], unit)}" for arm, label in zip(arms, labels, strict=True)
    )
    return Picture(figure, f"{alt or f'Planar arm of {len(arms[0]) - 1} links'}: {tips}.")


def side_view(*configurations, geometry: Geometry = COURSE, target=None, alt: str = "") -> Picture:
    """The arm from the side, one colour for each of `configurations` (q, or an IKSolution), in the plane r, z.

    r is counted along the direction in which the first one faces, so an arm that reaches over its back has
    the tool at the same r. An IKSolution is labelled with its branch, dashed where a joint limit forbids it and
    left out where it is out of reach. `target`: a point (r, z) to mark.
    """
    figure, axes = axes_of("r (mm)", "z (mm)", square=True)
    axes.axhline(0, color=PALE, lw=1)
    shown, facing = [], None
    for q, colour in zip(configurations, cycle(PALETTE), strict=False):
        if not getattr(q, "reachable", True):
            continue
        four = as_four(q, "configurations", "four joint angles in rad each, or an IKSolution")
        facing = four[0] if facing is None else facing
        points = _outline(four, geometry, facing)
        legal = getattr(q, "legal", True)
        label = getattr(q, "branch", "")
        label += "" if legal else " (beyond a joint limit)"
        _links(axes, points, colour, label, dashed=not legal, joints=(0, 1, 3, 4, 5), width=5 - 0.9 * len(shown))
        shown.append(f"{label or 'arm'} with its tip at r, z = {point_text(points[-1], 'mm')}")
    if target is not None:
        axes.plot(*target, marker="x", ms=11, mew=2.5, color=PALETTE[4], ls="", label="target", zorder=6)
    finish(axes)
    return Picture(figure, f"{alt or 'Side view of the arm'}: {'; '.join(shown) or 'no branch is within reach'}.")


def _links(axes, points, colour, label="", dashed=False, joints=None, width=4.0) -> None:
    """Links as thick lines, articulations as rings, the tip as a filled square; all in one colour."""
    style = (0, (2.2, 1.4)) if dashed else "-"
    axes.plot(*points.T, color=colour, lw=width, ls=style, label=label or None, solid_joinstyle="round", zorder=3)
    rings = points[list(joints)] if joints else points
    axes.plot(*rings[:-1].T, ls="", marker="o", ms=9, mfc="white", mec=colour, mew=2.2, zorder=4)
    axes.plot(*rings[-1], ls="", marker="s", ms=8, color=colour, zorder=4)


def _angle_marks(axes, arm) -> None:
    """At each joint an arc from the link before (or the x axis), drawn on, to the link after, and its name."""
    steps = np.diff(arm, axis=0)
    directions = np.unwrap(np.arctan2(steps[:, 1], steps[:, 0]))
    before = 0.0
    for i, (joint, step, after) in enumerate(zip(arm, steps, directions, strict=False), start=1):
        size = 0.32 * float(np.hypot(*step))
        ahead = joint + 1.5 * size * np.array((math.cos(before), math.sin(before)))
        axes.plot(*np.array((joint, ahead)).T, color=PALE, lw=1.2, ls="--", zorder=2)
        low, high = sorted((before, after))
        axes.add_patch(
            Arc(joint, 2 * size, 2 * size, theta1=math.degrees(low), theta2=math.degrees(high), color=INK, lw=1.5)
        )
        middle = 0.5 * (before + after)
        spot = joint + 1.45 * size * np.array((math.cos(middle), math.sin(middle)))
        axes.annotate(f"$x_{i}$", spot, ha="center", va="center", fontsize=13)
        before = after


def _outline(q, geometry: Geometry, facing: float) -> np.ndarray:
    """Points (6, 2) in the plane r, z: base, shoulder, the dog-leg's corner, elbow, wrist, tool."""
    _, upper_arm, _, forearm, *_ = capsules(q, geometry)
    tool = kinematics.pose(q, geometry)[:3]
    x, y, z = np.transpose([(0, 0, 0), upper_arm.a, upper_arm.b, forearm.a, forearm.b, tool])
    return np.column_stack((x * math.cos(facing) + y * math.sin(facing), z))
