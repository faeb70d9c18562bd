"""`Picture`: a figure with its alt text; and what all figures share: colours, axes, legend, numbers in words."""

import io

import numpy as np
from matplotlib.figure import Figure

from ...arrays import shown
from ...errors import BadInput

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


def axes_of(x: str, y: str, square: bool = False):
    """A figure and its one pair of axes, titles with units; `square`: one scale for both."""
    figure = Figure(figsize=(6.2, 4.8) if square else (6.4, 4.6), layout="constrained")
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


def finish(axes, margin: float = 0.12) -> None:
    """Room around the data, and above the axes a legend of what has a label."""
    axes.margins(x=margin, y=0.12)
    handles, labels = axes.get_legend_handles_labels()
    if labels:
        columns = len(labels) if sum(map(len, labels)) < 40 else 2 if max(map(len, labels)) < 28 else 1
        axes.figure.legend(handles, labels, loc="outside upper center", ncols=columns, fontsize=11, frameon=False)


def as_points(value, name: str, columns: int = 2, least: int = 1) -> np.ndarray:
    """`value` as a float array (N, columns), N at least `least`; NaN may stand in it. Raises `BadInput`."""
    try:
        array = np.asarray(value, float)
    except (TypeError, ValueError):
        array = np.empty(0)
    if array.ndim == 2 and array.shape[1] == columns and len(array) >= least:
        return array
    raise BadInput(f"`{name}` must be numbers of shape (N, {columns}), N at least {least}; got {shown(value)}.")


def point_text(point, unit: str) -> str:
    """A point in words, for an alt text."""
    numbers = ", ".join(f"{value + 0.0:.2f}" for value in np.round(point, 2))
    return f"({numbers}) {unit}".rstrip()


def span_text(values) -> str:
    """The smallest and the largest of some values in words, NaN left out."""
    values = np.asarray(values, float)
    return f"{np.nanmin(values):.4g} and {np.nanmax(values):.4g}"
