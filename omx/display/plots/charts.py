"""Curves over one variable, clouds of points in space, figures and maps in the plane r, z."""

from collections.abc import Mapping, Sequence
from itertools import cycle

import numpy as np
from matplotlib import colormaps
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch
from matplotlib.path import Path

from ...arrays import shown
from ...errors import BadInput
from ..palette import INK, PALE, PALETTE
from .picture import Picture, as_points, axes_of, finish, span_text


def curves(
    across,
    lines: Mapping[str, Sequence[float]],
    x: str,
    y: str,
    marks=(),
    alt: str = "",
    wanted: Mapping[str, Sequence[float]] | None = None,
) -> Picture:
    """Curves against one axis. `lines` maps each label to its values; `x` and `y` are axis titles with units.

    `marks`: pairs (value on the x axis, label) drawn as vertical dotted lines. `wanted`: what some of the lines should
    have been, by the same labels, drawn as thin dark lines over them; they are wide then. The line y = 0 is drawn if
    it is in sight.
    """
    across = as_points(np.reshape(across, (-1, 1)), "across", 1).ravel()
    if not (isinstance(lines, Mapping) and lines):
        raise BadInput(f"`lines` must map a label to the values of each curve; got {shown(lines)}.")
    figure, axes = axes_of(x, y)
    width = 4.8 if wanted else 2.2
    looks = zip(cycle(PALETTE), cycle(("-", "--", "-.", ":")), strict=False)
    for (label, values), (colour, dash) in zip(lines.items(), looks, strict=False):
        axes.plot(across, np.asarray(values, float), color=colour, ls=dash, lw=width, label=label)
    for i, values in enumerate((wanted or {}).values()):
        axes.plot(across, np.asarray(values, float), color=INK, lw=0.9, label="" if i else "wanted")
    low, high = axes.get_ylim()
    if low < 0 < high:
        axes.axhline(0, color=PALE, lw=1)
    for place, label in marks:
        axes.axvline(place, color=INK, lw=1.2, ls=":")
        axes.annotate(f" {label}", (place, 0.97), xycoords=("data", "axes fraction"), va="top", fontsize=11)
    finish(axes, margin=0.02)
    told = "; ".join(f"{label or y} lies between {span_text(values)}" for label, values in lines.items())
    if wanted:
        told += "; " + "; ".join(f"{label} should lie between {span_text(values)}" for label, values in wanted.items())
    marked = "".join(f"; {label} is marked at {place:.4g}" for place, label in marks)
    return Picture(
        figure, f"{alt or f'{y} against {x}'}: {x} from {across[0]:.4g} to {across[-1]:.4g}; {told}{marked}."
    )


def cloud(points, alt: str = "") -> Picture:
    """Points (N, 3) in space, mm, coloured by their height z."""
    points = as_points(points, "points", 3)
    figure = Figure(figsize=(7.0, 5.4), layout="constrained")
    axes = figure.add_subplot(projection="3d")
    dots = axes.scatter(*points.T, c=points[:, 2], cmap="cividis", s=5, lw=0, depthshade=False, antialiased=False)
    figure.colorbar(dots, ax=axes, label="height z (mm)", shrink=0.7, pad=0.12)
    for axis, name in zip("xyz", "xyz", strict=True):
        getattr(axes, f"set_{axis}label")(f"{name} (mm)", fontsize=11, labelpad=8)
    axes.tick_params(labelsize=11)
    axes.locator_params(nbins=5)
    extents = [np.ptp(axis.get_view_interval()) for axis in (axes.xaxis, axes.yaxis, axes.zaxis)]
    axes.set_box_aspect(extents, zoom=0.9)  # one scale for all; smaller, or the titles would be cut off
    for axis in (axes.xaxis, axes.yaxis):
        _without_corners(axis)
    spans = ", ".join(f"{name} between {span_text(values)} mm" for name, values in zip("xyz", points.T, strict=True))
    return Picture(figure, f"{alt or 'Points in space'}: {len(points)} points, {spans}.")


def plane(polygons=(), arcs=(), r: str = "r (mm)", z: str = "z (mm)", alt: str = "") -> Picture:
    """Figures in the plane r, z: `polygons` (n, 2) filled together; `arcs` (n, 2) as thin lines.

    A polygon inside another one that runs the other way round is a hole.
    """
    polygons, arcs = ([as_points(one, name) for one in many] for name, many in (("polygons", polygons), ("arcs", arcs)))
    everything = np.vstack([*polygons, *arcs] or as_points((), "polygons"))
    figure, axes = axes_of(r, z, square=True)
    told = []
    if len(polygons):
        _filled(axes, polygons)
        told.append(f"{len(polygons)} closed outline{'s' * (len(polygons) != 1)}")
    for arc, colour in zip(arcs, cycle(PALETTE), strict=False):
        axes.plot(*arc.T, color=colour, lw=1.4)
    if len(arcs):
        told.append(f"{len(arcs)} arcs")
    finish(axes, margin=0.05)
    spans = f"{r} between {span_text(everything[:, 0])}, {z} between {span_text(everything[:, 1])}"
    return Picture(figure, f"{alt or 'Figures in the plane'}: {', '.join(told)}; {spans}.")


def plane_map(
    across, up, values, label: str, outlines=(), r: str = "r (mm)", z: str = "z (mm)", alt: str = ""
) -> Picture:
    """A value in each cell of the plane r, z: `values` (len(up), len(across)), NaN left blank; equal scales.

    What is shown ends where the values end. `label`: what the colours mean, with its unit. `outlines`: polygons
    (n, 2) drawn on top. Where all values are small whole numbers, each has a colour of its own.
    """
    across, up, values = _cropped(*(np.asarray(a, float) for a in (across, up, values)))
    figure, axes = axes_of(r, z, square=True)
    axes.set_aspect("equal", adjustable="box")
    figure.set_layout_engine("compressed")  # the colour bar stays beside a narrow map
    colours, scale, ticks = _scale(values)
    cells = np.ma.masked_invalid(values)
    mesh = axes.pcolormesh(across, up, cells, cmap=colours, shading="nearest", rasterized=True, **scale)
    figure.colorbar(mesh, ax=axes, label=label, shrink=0.85, ticks=ticks)
    for outline in outlines:
        axes.plot(*np.vstack((outline, outline[:1])).T, color=PALETTE[4], lw=1.6)
    axes.use_sticky_edges = False
    axes.margins(0.02)
    axes.grid(False)
    row, column = np.unravel_index(np.nanargmax(values), values.shape)
    best = f"largest {values[row, column]:.4g}, first at ({across[column]:.4g}, {up[row]:.4g}) mm"
    return Picture(figure, f"{alt or 'Map of the plane'}, {label}: smallest {np.nanmin(values):.4g}, {best}.")


def _without_corners(axis) -> None:
    """Leave out the ticks next to a corner, where the numbers of two axes would meet."""
    low, high = axis.get_view_interval()
    edge = 0.06 * (high - low)
    axis.set_ticks([tick for tick in axis.get_majorticklocs() if low + edge < tick < high - edge])


def _cropped(across, up, values) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The smallest rectangle of cells that holds all values."""
    rows, columns = np.nonzero(np.isfinite(values))
    some_rows = slice(rows.min(), rows.max() + 1)
    some_columns = slice(columns.min(), columns.max() + 1)
    return across[some_columns], up[some_rows], values[some_rows, some_columns]


def _scale(values) -> tuple:
    """Colour map, its range and its ticks: one step for each number where they are whole and few."""
    colours, found = colormaps["cividis"], values[np.isfinite(values)]
    low, high = found.min(), found.max()
    if high - low > 8 or (found != np.round(found)).any():
        return colours, {}, None
    steps = np.arange(low, high + 1)
    return colours.resampled(len(steps)), {"vmin": low - 0.5, "vmax": high + 0.5}, steps


def _filled(axes, polygons) -> None:
    """All polygons as one shape, so that one inside another is a hole."""
    closed = [np.vstack((p, p[:1])) for p in polygons]
    codes = [[Path.MOVETO, *[Path.LINETO] * (len(p) - 2), Path.CLOSEPOLY] for p in closed]
    shape = Path(np.vstack(closed), np.concatenate(codes))
    axes.add_patch(PathPatch(shape, fc=PALETTE[5], ec=PALETTE[0], lw=1.6, alpha=0.55))
    axes.autoscale_view()
