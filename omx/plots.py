"""The book's flat figures, one call each: planar arms, side views of the arm, curves, heat maps.

Every function returns a `Picture`: a PNG in a notebook, with an alt text that tells in words and numbers what the
drawing shows. Lengths in mm (or the unit given), angles in rad. Colours are those of Okabe and Ito.
"""

import io
import math
from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Arc, PathPatch
from matplotlib.path import Path

from . import kinematics
from .geometry import COURSE, Geometry

#: Colours that stay apart for every kind of colour vision; the first four are those of the four IK branches.
COLOURS = ("#0072b2", "#e69f00", "#009e73", "#cc79a7", "#d55e00", "#56b4e9")
INK, PALE = "#1b1f24", "#8a929c"

#: Words on a heat map: white on a dark patch, readable on every colour.
ON_COLOUR = {
    "fontsize": 11,
    "color": "white",
    "weight": "bold",
    "bbox": {"boxstyle": "round", "fc": INK, "alpha": 0.75},
}

#: Pixels for an inch: the picture is stored at twice the size at which it is shown.
DPI, SHARPNESS = 96, 2


class Picture:
    """A Matplotlib figure with its alt text. Notebooks and pages show the figure; `repr` is the alt text."""

    def __init__(self, figure: Figure, alt: str):
        self.figure, self.alt = figure, " ".join(alt.split())

    def __repr__(self) -> str:
        return f"Figure: {self.alt}"

    def png(self) -> bytes:
        """The picture as PNG."""
        buffer = io.BytesIO()
        self.figure.savefig(buffer, format="png", dpi=DPI * SHARPNESS, facecolor="white", metadata={"Software": None})
        return buffer.getvalue()

    def _repr_mimebundle_(self, include=None, exclude=None):
        width, height = (round(DPI * inches) for inches in self.figure.get_size_inches())
        metadata = {"image/png": {"alt": self.alt, "width": width, "height": height}}
        return {"image/png": self.png(), "text/plain": repr(self)}, metadata


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
    arms = [np.asarray(arm, float) for arm in arms]
    figure, axes = _axes(f"{across} ({unit})", f"{up} ({unit})", square=True)
    labels = [*labels, *([""] * (len(arms) - len(labels)))]
    if path is not None:
        axes.plot(*np.asarray(path, float).T, color=PALE, lw=1.2, zorder=1)
    for arm, colour, label in zip(arms, _cycle(), labels, strict=False):
        _links(axes, arm, colour, label)
    if angles:
        _angle_marks(axes, arms[0])
    if target is not None:
        axes.plot(*target, marker="x", ms=11, mew=2.5, color=COLOURS[4], ls="", label="target", zorder=6)
    _finish(axes)
    tips = "; ".join(
        f"{label or 'arm'} with its tip at {_point(arm[-1], unit)}" for arm, label in zip(arms, labels, strict=True)
    )
    return Picture(figure, f"{alt or f'Planar arm of {len(arms[0]) - 1} links'}: {tips}.")


def side_view(
    *configurations, labels: Sequence[str] = (), geometry: Geometry = COURSE, target=None, alt: str = ""
) -> Picture:
    """The arm from the side, one colour for each of `configurations` (q, or an IKSolution), in the plane r, z.

    r is counted along the direction in which the first one faces, so an arm that reaches over its back has
    the tool at the same r. An IKSolution is labelled with its branch, dashed where a joint limit forbids it and
    left out where it is out of reach. `target`: a point (r, z) to mark.
    """
    figure, axes = _axes("r (mm)", "z (mm)", square=True)
    axes.axhline(0, color=PALE, lw=1)
    shown, facing = [], None
    for i, (q, colour) in enumerate(zip(configurations, _cycle(), strict=False)):
        if not getattr(q, "reachable", True):
            continue
        facing = q[0] if facing is None else facing
        points = _outline(q, geometry, facing)
        legal = getattr(q, "legal", True)
        label = labels[i] if i < len(labels) else getattr(q, "branch", "")
        label += "" if legal else " (beyond a joint limit)"
        _links(axes, points, colour, label, dashed=not legal, joints=(0, 1, 3, 4, 5), width=5 - 0.9 * len(shown))
        shown.append(f"{label or 'arm'} with its tip at r, z = {_point(points[-1], 'mm')}")
    if target is not None:
        axes.plot(*target, marker="x", ms=11, mew=2.5, color=COLOURS[4], ls="", label="target", zorder=6)
    _finish(axes)
    return Picture(figure, f"{alt or 'Side view of the arm'}: {'; '.join(shown) or 'no branch is within reach'}.")


def curves(across, lines: Mapping[str, Sequence[float]], x: str, y: str, marks=(), alt: str = "") -> Picture:
    """Curves against one axis. `lines` maps each label to its values; `x` and `y` are axis titles with units.

    `marks`: pairs (value on the x axis, label) drawn as vertical dotted lines. The line y = 0 is drawn if it is
    in sight.
    """
    across = np.asarray(across, float)
    figure, axes = _axes(x, y)
    for (label, values), colour, dash in zip(lines.items(), _cycle(), _cycle(("-", "--", "-.", ":")), strict=False):
        axes.plot(across, np.asarray(values, float), color=colour, ls=dash, lw=2.2, label=label)
    low, high = axes.get_ylim()
    if low < 0 < high:
        axes.axhline(0, color=PALE, lw=1)
    for place, label in marks:
        axes.axvline(place, color=INK, lw=1.2, ls=":")
        axes.annotate(f" {label}", (place, 0.97), xycoords=("data", "axes fraction"), va="top", fontsize=11)
    _finish(axes, margin=0.02)
    told = "; ".join(f"{label or y} lies between {_span(values)}" for label, values in lines.items())
    marked = "".join(f"; {label} is marked at {place:.4g}" for place, label in marks)
    return Picture(
        figure, f"{alt or f'{y} against {x}'}: {x} from {across[0]:.4g} to {across[-1]:.4g}; {told}{marked}."
    )


def heat_map(across, up, values, x: str, y: str, z: str, marks=(), alt: str = "") -> Picture:
    """A scalar over two variables: `values` has shape (len(up), len(across)); NaN is left blank.

    `x`, `y`, `z` are titles with units. `marks`: triples (x, y, label) drawn as points.
    """
    across, up, values = (np.asarray(a, float) for a in (across, up, values))
    figure, axes = _axes(x, y, size=(7.2, 5.0))
    mesh = axes.pcolormesh(across, up, np.ma.masked_invalid(values), cmap="cividis", shading="nearest", rasterized=True)
    figure.colorbar(mesh, ax=axes, label=z)
    axes.grid(False)
    for a, b, label in marks:
        axes.plot(a, b, marker="o", ms=9, mfc="white", mec=INK, mew=2)
        axes.annotate(label, (a, b), xytext=(9, 7), textcoords="offset points", **ON_COLOUR)
    row, column = np.unravel_index(np.nanargmax(values), values.shape)
    best = f"largest {values[row, column]:.4g}, at {across[column]:.4g} and {up[row]:.4g}"
    return Picture(figure, f"{alt or f'Heat map of {z}'} over {x} and {y}: smallest {np.nanmin(values):.4g}, {best}.")


def _axes(x: str, y: str, square: bool = False, size=(6.4, 4.6)):
    figure = Figure(figsize=(6.2, 4.8) if square else size, layout="constrained")
    axes = figure.add_subplot()
    axes.set_xlabel(x, fontsize=12)
    axes.set_ylabel(y, fontsize=12)
    axes.tick_params(labelsize=11)
    axes.grid(color="#e3e6ea", lw=0.8)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    if square:
        axes.set_aspect("equal", adjustable="datalim")
    return figure, axes


def _finish(axes, margin: float = 0.12) -> None:
    """Room around the data, and above the axes a legend of what has a label."""
    axes.margins(x=margin, y=0.12)
    handles, labels = axes.get_legend_handles_labels()
    if labels:
        columns = len(labels) if sum(map(len, labels)) < 40 else 2 if max(map(len, labels)) < 28 else 1
        axes.figure.legend(handles, labels, loc="outside upper center", ncols=columns, fontsize=11, frameon=False)


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
    frames = kinematics.frames(np.asarray(tuple(q), float), geometry)
    x, y, z = frames[:, :3, 3].T
    r = x * math.cos(facing) + y * math.sin(facing)
    points = np.column_stack((r, z))
    lean, side = q[1], math.cos(q[0] - facing)
    corner = points[1] + geometry.L2 * math.cos(geometry.delta) * np.array((side * math.sin(lean), math.cos(lean)))
    return np.insert(points, 2, corner, axis=0)


def _cycle(values: Sequence = COLOURS):
    """The values again and again."""
    while True:
        yield from values


def _point(point, unit: str) -> str:
    numbers = ", ".join(f"{value + 0.0:.2f}" for value in np.round(point, 2))
    return f"({numbers}) {unit}".rstrip()


def _span(values) -> str:
    values = np.asarray(values, float)
    return f"{np.nanmin(values):.4g} and {np.nanmax(values):.4g}"


def cloud(points, unit: str = "mm", alt: str = "") -> Picture:
    """Points (N, 3) in space, coloured by their height z. `unit` is that of the axes."""
    points = np.asarray(points, float)
    figure = Figure(figsize=(7.0, 5.4), layout="constrained")
    axes = figure.add_subplot(projection="3d")
    dots = axes.scatter(*points.T, c=points[:, 2], cmap="cividis", s=5, lw=0, alpha=0.8)
    figure.colorbar(dots, ax=axes, label=f"z ({unit})", shrink=0.7).solids.set_alpha(1.0)
    for axis, name in zip("xyz", "xyz", strict=True):
        getattr(axes, f"set_{axis}label")(f"{name} ({unit})", fontsize=11, labelpad=8)
    axes.locator_params(nbins=5)
    axes.set_aspect("equal")
    spans = ", ".join(f"{name} between {_span(values)} {unit}" for name, values in zip("xyz", points.T, strict=True))
    return Picture(figure, f"{alt or 'Points in space'}: {len(points)} points, {spans}.")


def plane(polygons=(), arcs=(), points=None, r: str = "r (mm)", z: str = "z (mm)", alt: str = "") -> Picture:
    """Figures in the plane r, z: `polygons` (n, 2) filled together, holes left out; `arcs` (n, 2) as thin lines.

    `points`: (N, 2), as dots.
    """
    figure, axes = _axes(r, z, square=True)
    told = []
    if len(polygons):
        _filled(axes, polygons)
        told.append(f"{len(polygons)} closed outline{'s' * (len(polygons) != 1)}")
    for arc, colour in zip(arcs, _cycle(), strict=False):
        axes.plot(*np.asarray(arc, float).T, color=colour, lw=1.4)
    if len(arcs):
        told.append(f"{len(arcs)} arcs")
    if points is not None:
        axes.plot(*np.asarray(points, float).T, ls="", marker=".", ms=2, color=INK, alpha=0.35, rasterized=True)
        told.append(f"{len(points)} points")
    _finish(axes, margin=0.05)
    everything = np.vstack([*polygons, *arcs, *([] if points is None else [points])])
    spans = f"{r} between {_span(everything[:, 0])}, {z} between {_span(everything[:, 1])}"
    return Picture(figure, f"{alt or 'Figures in the plane'}: {', '.join(told)}; {spans}.")


def plane_map(
    across, up, values, label: str, outlines=(), r: str = "r (mm)", z: str = "z (mm)", alt: str = ""
) -> Picture:
    """A value in each cell of the plane r, z: `values` (len(up), len(across)), NaN left blank; equal scales.

    `label`: what the colours mean, with its unit. `outlines`: polygons (n, 2) drawn on top.
    """
    across, up, values = (np.asarray(a, float) for a in (across, up, values))
    figure, axes = _axes("r (mm)", "z (mm)", square=True)
    mesh = axes.pcolormesh(across, up, np.ma.masked_invalid(values), cmap="cividis", shading="nearest", rasterized=True)
    figure.colorbar(mesh, ax=axes, label=label, shrink=0.85)
    for outline in outlines:
        axes.plot(*np.vstack((outline, outline[:1])).T, color=COLOURS[4], lw=1.6)
    axes.grid(False)
    row, column = np.unravel_index(np.nanargmax(values), values.shape)
    best = f"largest {values[row, column]:.4g}, first at ({across[column]:.4g}, {up[row]:.4g}) mm"
    return Picture(figure, f"{alt or 'Map of the plane'}, {label}: smallest {np.nanmin(values):.4g}, {best}.")


def _filled(axes, polygons) -> None:
    """All polygons as one shape, so that one inside another is a hole."""
    closed = [np.vstack((p, p[:1])) for p in polygons]
    codes = [[Path.MOVETO, *[Path.LINETO] * (len(p) - 2), Path.CLOSEPOLY] for p in closed]
    shape = Path(np.vstack(closed), np.concatenate(codes))
    axes.add_patch(PathPatch(shape, fc=COLOURS[5], ec=COLOURS[0], lw=1.6, alpha=0.55))
    axes.autoscale_view()
