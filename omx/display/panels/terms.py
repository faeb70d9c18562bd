"""The formula beside the picture: r and z of the arm, term by term in its links' colours, and its DH table."""

import html
import math
from pathlib import Path

import anywidget
import numpy as np
import traitlets

from ..palette import PALETTE
from . import tables

#: What each link adds to r and to z (chapter 3), in order; "" adds nothing.
WORDS = {
    "r": ("", "L2 sin(q2 + δ)", "L3 cos(q2 + q3)", "L4 cos(q2 + q3 + q4)"),
    "z": ("L1", "L2 cos(q2 + δ)", "−L3 sin(q2 + q3)", "−L4 sin(q2 + q3 + q4)"),
}
COLOURS = PALETTE[:4]


class DHTable(anywidget.AnyWidget):
    """A DH table; `lit` is the row at which the reader points, 1 for the first, 0 for none."""

    _esm = Path(__file__).with_name("dh_table.js").read_text(encoding="utf-8")

    html = traitlets.Unicode("").tag(sync=True)
    lit = traitlets.Int(0).tag(sync=True)


def values(frames) -> dict[str, list[float]]:
    """How much each link adds to r and z, mm, for an arm whose `frames` are (5, 4, 4)."""
    steps = np.diff(np.asarray(frames, float)[:, :3, 3], axis=0)
    x_1 = np.asarray(frames, float)[1, :2, 0]  # the way that the arm faces
    return {"r": (steps[:, :2] @ x_1).tolist(), "z": steps[:, 2].tolist()}


def lines(frames) -> str:
    """Both sums as HTML: each term underlined in its link's colour, its formula above its number."""
    return "".join(_line(name, terms) for name, terms in values(frames).items())


def _line(name: str, terms: list[float]) -> str:
    parts = []
    for words, value, colour in zip(WORDS[name], terms, COLOURS, strict=True):
        if words:
            sign = "−" if value < -0.05 else "+" if parts else ""
            about = f"border-bottom:3px solid {colour};display:inline-block;text-align:center;margin:0 2px"
            number = f"{sign} {tables.number(abs(value), 1)}"
            parts.append(f'<span style="{about}"><small>{html.escape(words)}</small><br>{number}</span>')
    total = tables.number(sum(terms), 1)
    return f'<div style="white-space:nowrap;margin:4px 0"><i>{name}</i> = {" ".join(parts)} = {total} mm</div>'


def dh_table(chain) -> str:
    """The chain's table as HTML: angles in degrees, lengths in mm."""
    rows = ""
    for i, (name, row) in enumerate(zip(chain.names, chain.rows, strict=True), 1):
        theta = f"{name} + {math.degrees(row.theta):.3g}°" if row.theta else name
        cells = (str(i), theta, f"{row.d:.4g}", f"{row.a:.4g}", f"{math.degrees(row.alpha):.3g}°")
        tidy = [cell.replace("-", "−").replace("+ −", "− ") for cell in cells]
        rows += f"<tr>{''.join(f'<td>{cell}</td>' for cell in tidy)}</tr>"
    head = "".join(f"<th>{word}</th>" for word in ("row", "θ", "d (mm)", "a (mm)", "α"))
    return f'<table class="omx-dh"><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>'
