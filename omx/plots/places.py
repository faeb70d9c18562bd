"""Places: clouds of points in space, figures and maps in the plane r, z."""

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch
from matplotlib.path import Path

from .picture import COLOURS, INK, Picture, axes_of, cycle, finish, span_text


def cloud(points, unit: str = "mm", alt: str = "") -> Picture:
    """Points (N, 3) in space, coloured by their height z. `unit` is that of the axes."""
    points = np.asarray(points, float)
    figure = Figure(figsize=(7.0, 5.4), layout="constrained")
    axes = figure.add_subplot(projection="3d")
    dots = axes.scatter(*points.T, c=points[:, 2], cmap="cividis", s=5, lw=0, depthshade=False, antialiased=False)
    figure.colorbar(dots, ax=axes, label=f"z ({unit})", shrink=0.7)
    for axis, name in zip("xyz", "xyz", strict=True):
        getattr(axes, f"set_{axis}label")(f"{name} ({unit})", fontsize=11, labelpad=8)
    axes.tick_params(labelsize=11)
    axes.locator_params(nbins=5)
    axes.set_aspect("equal")
    spans = ", ".join(
        f"{name} between {span_text(values)} {unit}" for name, values in zip("xyz", points.T, strict=True)
    )
    return Picture(figure, f"{alt or 'Points in space'}: {len(points)} points, {spans}.")


def plane(polygons=(), arcs=(), points=None, r: str = "r (mm)", z: str = "z (mm)", alt: str = "") -> Picture:
    """Figures in the plane r, z: `polygons` (n, 2) filled together; `arcs` (n, 2) as thin lines.

    A polygon inside another one that runs the other way round is a hole.

    `points`: (N, 2), as dots.
    """
    figure, axes = axes_of(r, z, square=True)
    told = []
    if len(polygons):
        _filled(axes, polygons)
        told.append(f"{len(polygons)} closed outline{'s' * (len(polygons) != 1)}")
    for arc, colour in zip(arcs, cycle(), strict=False):
        axes.plot(*np.asarray(arc, float).T, color=colour, lw=1.4)
    if len(arcs):
        told.append(f"{len(arcs)} arcs")
    if points is not None:
        axes.plot(*np.asarray(points, float).T, ls="", marker=".", ms=2, color=INK, alpha=0.35, rasterized=True)
        told.append(f"{len(points)} points")
    finish(axes, margin=0.05)
    everything = np.vstack([*polygons, *arcs, *([] if points is None else [points])])
    spans = f"{r} between {span_text(everything[:, 0])}, {z} between {span_text(everything[:, 1])}"
    return Picture(figure, f"{alt or 'Figures in the plane'}: {', '.join(told)}; {spans}.")


def plane_map(
    across, up, values, label: str, outlines=(), r: str = "r (mm)", z: str = "z (mm)", alt: str = ""
) -> Picture:
    """A value in each cell of the plane r, z: `values` (len(up), len(across)), NaN left blank; equal scales.

    `label`: what the colours mean, with its unit. `outlines`: polygons (n, 2) drawn on top.
    """
    across, up, values = (np.asarray(a, float) for a in (across, up, values))
    figure, axes = axes_of(r, z, square=True)
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
