"""What the panels say: small HTML tables of numbers, and sentences about branches and limits."""

import html
import math

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
