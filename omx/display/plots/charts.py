"""Numbers against numbers: curves over one variable."""

from collections.abc import Mapping, Sequence
from itertools import cycle

import numpy as np

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
