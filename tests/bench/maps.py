"""The workspace: the exact section against sampling, and how the maps grow as their cells shrink."""

import numpy as np

from omx.analysis import workspace
from tests.bench.sheet import Panel, Section, Size, Table, at_most, duration
from tests.bench.timing import Contender, laps, nanoseconds

SAMPLES, FINEST, LIMIT_S, SAMPLED_STEP = 1_000_000, 1.0, 0.6, 5.0
EXACT = "exact section, filled"

PROSE = f"""The exact section is worked out anew each time: its arcs, the loops that they form, and every cell. Before
timing, the cells of {FINEST:g} mm were compared with the exact area, and {SAMPLES:,} sampled tips were all found
in it. Sampling uses all processors, so the clock on the wall is read for it; the share of the section that it
hits is given beside. The pitch map tries 120 pitches a cell, the branch map one."""


def measure(size: Size) -> Section:
    section = Section("Workspace maps", PROSE)
    samples = SAMPLES if size.whole else SAMPLES // 10
    section.prose = PROSE.replace(f"{SAMPLES:,}", f"{samples:,}")
    hit = compared(samples)
    curves, rows = {}, []
    for step in size.steps:
        contenders = entered(step, size.whole)
        times = laps(contenders, 25, size.seconds / 4)
        for contender in contenders:
            seconds = nanoseconds(times, contender) * 1e-9
            curves.setdefault(contender.name, []).append((step, seconds))
            rows.append((contender.name, f"{step:g} mm", duration(seconds), ""))
    seconds = _sampled(samples)
    rows.append((f"{samples:,} sampled tips", f"{SAMPLED_STEP:g} mm", duration(seconds), f"{hit:.1%} of the area"))
    section.tables.append(Table("Time of one map", ("map", "cells", "time", "note"), rows))
    section.panels.append(Panel("Workspace maps", "side of a cell (mm)", "time of one map (s)", curves, {}, LIMIT_S))
    finest = dict(curves[EXACT])[FINEST]
    section.expectations.append(at_most(f"exact section at {FINEST:g} mm", finest, LIMIT_S, " s"))
    return section


def compared(samples: int) -> float:
    """The share of the exact section that the sampled cells hit; both ways to the area and to each tip must agree."""
    section = workspace.section()
    cells = section.fill(FINEST).inside.sum() * FINEST**2
    assert abs(cells / section.area - 1.0) < 1e-3, "the cells do not have the section's area"
    q = workspace.sample_joints(samples)
    q[:, 0] = 0.0
    tips = workspace.tips(q)[:, [0, 2]]
    out = tips[~section.contains(tips)]
    assert len(out) == 0 or section.distance(out).max() < 1e-6, "a sampled tip is outside the section"
    counts = workspace.count_plane(samples, step=SAMPLED_STEP)
    return float(np.sum(section.contains(counts.hit)) * SAMPLED_STEP**2 / section.area)


def entered(step: float, whole: bool) -> list[Contender]:
    """The maps with cells of one size; the pitch map, 120 times the work, only with cells of 4 mm or more."""
    made = [
        Contender(EXACT, lambda: workspace.section().fill(step)),
        Contender("branch map", lambda: workspace.branch_map(0.0, step)),
    ]
    if whole and step >= 4.0:
        made.append(Contender("pitch map", lambda: workspace.pitch_map(step)))
    return made


def _sampled(samples: int) -> float:
    call = Contender("sampled", lambda: workspace.count_plane(samples, step=SAMPLED_STEP), wall=True)
    return nanoseconds(laps([call], 3), call) * 1e-9
