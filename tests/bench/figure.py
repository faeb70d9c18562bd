"""The report's figure: one drawing for each panel, in Okabe and Ito's colours, lines told apart by markers as well."""

from itertools import cycle
from math import ceil
from pathlib import Path

from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator

from omx.display.palette import PALETTE
from tests.bench.sheet import Panel

MARKERS = "osD^vP"
COLUMNS, WIDTH_IN, HEIGHT_IN, DPI = 2, 15.0, 5.6, 110
LIMIT_COLOUR, BAR_COLOUR, OVER_COLOUR = "#1b1f24", PALETTE[0], PALETTE[4]


def drawn(panels: list[Panel], path: Path) -> None:
    """Write the figure as PNG."""
    figure = Figure(figsize=(WIDTH_IN, HEIGHT_IN * ceil(len(panels) / COLUMNS)), layout="constrained")
    grid = figure.subplots(ceil(len(panels) / COLUMNS), COLUMNS, squeeze=False).ravel()
    for axes, panel in zip(grid, panels, strict=False):
        axes.set_title(panel.title, fontsize=13)
        (_bars if panel.bars else _lines)(axes, panel)
        axes.grid(color="#e3e6ea", lw=0.8)
        axes.set_axisbelow(True)
    for axes in grid[len(panels) :]:
        axes.set_axis_off()
    figure.savefig(path, dpi=DPI, facecolor="white")


def _lines(axes, panel: Panel) -> None:
    """A colour and a marker for each name; dashed with two threads, in the colour of one."""
    styles = cycle(zip(PALETTE, MARKERS, strict=True))
    style_of = {base: next(styles) for base in dict.fromkeys(map(_base, panel.lines))}
    for name, points in panel.lines.items():
        colour, marker = style_of[_base(name)]
        dash = "-" if name == _base(name) else "--"
        axes.plot(*zip(*points, strict=True), color=colour, marker=marker, ls=dash, ms=6, label=name)
    if panel.limit is not None:
        axes.axhline(panel.limit, color=LIMIT_COLOUR, lw=1.2, ls="-.", label=panel.limit_name)
    axes.set_xscale("log")
    axes.set_yscale("log")
    steps = sorted({x for points in panel.lines.values() for x, _ in points})
    axes.set_xticks(steps, [f"{step:,.0f}" for step in steps])
    axes.xaxis.set_minor_locator(NullLocator())
    axes.set_xlabel(panel.x, fontsize=11)
    axes.set_ylabel(panel.y, fontsize=11)
    axes.legend(fontsize=8.5, ncols=2, loc="upper center", bbox_to_anchor=(0.5, -0.14), frameon=False)


def _base(name: str) -> str:
    return name.removesuffix(", 2 threads")


def _bars(axes, panel: Panel) -> None:
    """Bars from 0; or from the limit on a logarithmic scale, if they are hundreds of times as long as each other."""
    names, lengths = list(panel.bars), list(panel.bars.values())
    wide = panel.limit is not None and max(lengths) > 100 * min(lengths)
    start = panel.limit if wide else 0.0
    colours = [OVER_COLOUR if _is_bad(value, panel.limit, wide) else BAR_COLOUR for value in lengths]
    axes.barh(names, [value - start for value in lengths], left=start, color=colours, height=0.7)
    for i, value in enumerate(lengths):
        place = {"xytext": (4, 0), "textcoords": "offset points", "va": "center", "fontsize": 9}
        axes.annotate(f"{value:,.0f}" if value >= 100 else f"{value:.3g}", (max(value, start), i), **place)
    axes.margins(x=0.1)
    if wide:
        axes.set_xscale("log")
        axes.set_xlim(min(*lengths, start) / 2, max(lengths) * 5)
    if panel.limit is not None:
        axes.axvline(panel.limit, color=LIMIT_COLOUR, lw=1.2, ls="-.", label=panel.limit_name)
        axes.legend(fontsize=8.5, loc="upper center", bbox_to_anchor=(0.5, -0.1), frameon=False)
    axes.set_ylim(max(len(lengths), 6) - 0.5, -0.5)
    axes.set_xlabel(panel.x, fontsize=11)


def _is_bad(value: float, limit: float | None, wide: bool) -> bool:
    """Below the limit where it is a start, beyond it where it is an end."""
    return limit is not None and (value < limit if wide else value > limit)
