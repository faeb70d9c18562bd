"""What the panels say: small HTML tables and sums of numbers, and sentences about branches and limits."""

import html
import math
from pathlib import Path

import anywidget
import numpy as np
import traitlets

from ..palette import PALETTE

#: What the names of the branches mean, for whoever stays on one with the mouse.
BEND = "elbow up: the forearm bends down from the upper arm (bend > 0); elbow down: it bends up"

_CELL = "padding:1px 7px;text-align:right;font-family:var(--jp-code-font-family,monospace);white-space:pre"
_WORDS = "padding:1px 7px;white-space:nowrap"
_TABLE = "border-collapse:collapse;font-size:13px;line-height:1.45"


def number(value: float, digits: int) -> str:
    """Fixed digits, a true minus sign, and no minus before a zero."""
    return f"{round(value, digits) + 0.0:.{digits}f}".replace("-", "\u2212")


def matrix_table(T, name: str = "T") -> str:
    """A 4x4 pose: rotation with three decimals, position (mm) with one."""
    rows = []
    for row in T:
        cells = [number(float(v), 3) for v in row[:3]] + [number(float(row[3]), 1)]
        rows.append("".join(f'<td style="{_CELL}">{cell}</td>' for cell in cells))
    body = "".join(f"<tr>{row}</tr>" for row in rows)
    edges = "border-left:1.5px solid currentColor;border-right:1.5px solid currentColor;border-radius:6px"
    table = f'<table style="{_TABLE};{edges}">{body}</table>'
    return f'<div style="display:flex;align-items:center;gap:8px"><i>{html.escape(name)}</i> = {table} mm</div>'


def value_table(values) -> str:
    """Rows of (name, value, unit)."""
    rows = "".join(
        f'<tr><td style="padding:1px 4px"><i>{html.escape(name)}</i></td><td style="{_CELL}">{number(value, 1)}</td>'
        f"<td>{html.escape(unit)}</td></tr>"
        for name, value, unit in values
    )
    return f'<table style="{_TABLE}">{rows}</table>'


def branch_table(solutions, colours, chosen, joints) -> str:
    """One row a branch: its colour, its name, its angles and its verdict; the chosen one in bold. `joints`: DH rows."""
    rows = []
    for solution, colour in zip(solutions, colours, strict=False):
        dot = f'<span style="color:{colour}">&#9679;</span>'
        weight = "bold" if chosen is not None and solution.branch == chosen.branch else "normal"
        values = zip(solution.q or (), joints, strict=False)
        angles = ", ".join(number(v if row.prismatic else math.degrees(v), 1) for v, row in values)
        rows.append(
            f'<tr style="font-weight:{weight}"><td>{dot}</td><td style="{_WORDS}" title="{BEND}">{solution.branch}</td>'
            f'<td style="{_CELL}">{angles}</td><td style="padding:1px 7px">{html.escape(verdict(solution))}</td></tr>'
        )
    return f'<table style="{_TABLE}">{"".join(rows)}</table>'


def verdict(solution) -> str:
    """One branch in words: legal, out of reach by how much, or which joint is beyond its limit by how much."""
    if solution.legal:
        return "legal"
    if not solution.reachable:
        return f"out of reach, {solution.missing:.{1 if solution.missing >= 0.1 else 3}f} mm missing"
    return "; ".join(str(violation) for violation in solution.violations)


def notice(text: str, good: bool = True) -> str:
    """A line that screen readers announce when it changes."""
    if not text:
        return '<div role="status" style="min-height:1.5em"></div>'
    colour = "inherit" if good else "var(--jp-error-color1,#b3261e)"
    return f'<div role="status" style="min-height:1.5em;color:{colour}">{html.escape(text)}</div>'


# ---- the formula beside the picture: r and z term by term in the links' colours, and the DH table ---------------

#: What each link adds to r and to z (chapter 3), in order; "" adds nothing.
TERMS = {
    "r": ("", "L2 sin(q2 + δ)", "L3 cos(q2 + q3)", "L4 cos(q2 + q3 + q4)"),
    "z": ("L1", "L2 cos(q2 + δ)", "−L3 sin(q2 + q3)", "−L4 sin(q2 + q3 + q4)"),
}
TERM_COLOURS = PALETTE[:4]


class DHTable(anywidget.AnyWidget):
    """A DH table; `lit` is the row at which the reader points, 1 for the first, 0 for none."""

    _esm = Path(__file__).with_name("dh_table.js").read_text(encoding="utf-8")

    html = traitlets.Unicode("").tag(sync=True)
    lit = traitlets.Int(0).tag(sync=True)


def term_values(frames) -> dict[str, list[float]]:
    """How much each link adds to r and z, mm, for an arm whose `frames` are (5, 4, 4)."""
    steps = np.diff(np.asarray(frames, float)[:, :3, 3], axis=0)
    x_1 = np.asarray(frames, float)[1, :2, 0]  # the way that the arm faces
    return {"r": (steps[:, :2] @ x_1).tolist(), "z": steps[:, 2].tolist()}


def sums(frames) -> str:
    """Both sums as HTML: each term underlined in its link's colour, its formula above its number."""
    return "".join(_sum(name, terms) for name, terms in term_values(frames).items())


def _sum(name: str, terms: list[float]) -> str:
    parts = []
    for words, value, colour in zip(TERMS[name], terms, TERM_COLOURS, strict=True):
        if words:
            sign = "−" if value < -0.05 else "+" if parts else ""
            about = f"border-bottom:3px solid {colour};display:inline-block;text-align:center;margin:0 2px"
            told = f"{sign} {number(abs(value), 1)}"
            parts.append(f'<span style="{about}"><small>{html.escape(words)}</small><br>{told}</span>')
    total = number(sum(terms), 1)
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
