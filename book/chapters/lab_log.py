"""Look at a log that students hand in with chapters 10 and 11: `python -m book.chapters.lab_log side-1.csv ...`.

Says what is odd about it, a sentence each; the exit status is 1 if anything is. A good one: book/teach/sample-log.csv.
"""

import sys

import numpy as np

import omx
from omx.hardware.log import read_log

TICK_DEG = 360 / 4096
ANGLES, SPEEDS, GOALS = ("q1", "q2", "q3", "q4"), ("v1", "v2", "v3", "v4"), ("c1", "c2", "c3", "c4")


def oddities(log):
    """Sentences on what is odd about a log; none for one that was measured on an arm that moved."""
    if missing := [name for name in ("t", *ANGLES) if name not in log.columns]:
        yield f"it has no column {', '.join(missing)}"
        return
    if len(log) < 10:
        yield f"it holds only {len(log)} samples"
        return
    t, q = log["t"], log.array(*ANGLES)
    yield from uneven(t)
    yield from not_measured(q)
    yield from not_followed(log, t, q)
    yield from elsewhere(log, q)


def uneven(t):
    steps = np.diff(t)
    usual = float(np.median(steps))
    if steps.min() <= 0:
        yield f"time does not go on after sample {int(np.argmin(steps)) + 1}"
    elif np.abs(steps - usual).max() > 0.5 * usual:
        at = int(np.argmax(np.abs(steps - usual)))
        odd = f"{steps[at] * 1000:.0f} ms after sample {at + 1}"
        yield f"the time step is not even: {usual * 1000:.0f} ms mostly, {odd}"


def not_measured(q):
    """An encoder gives whole ticks; a command, or a number copied from a page, does not."""
    ticks = q / TICK_DEG
    off = np.abs(ticks - ticks.round()).max(axis=0)
    for name, far in zip(ANGLES, off, strict=True):
        if far > 0.05:
            yield f"{name} is not in whole ticks of the encoder: was the command logged, or the number rounded?"
    if np.ptp(q, axis=0).max() < 2:
        yield "no joint moves by 2 deg: the log began too late, or the motors were off"


def not_followed(log, t, q):
    """The speeds must be those of the angles; where the command was logged, too, the arm lags behind it."""
    if set(SPEEDS) <= set(log.columns):
        with np.errstate(all="ignore"):  # a clock that stands still is said already
            slopes, speeds = np.gradient(q, t, axis=0), log.array(*SPEEDS)
        for j, name in enumerate(SPEEDS):
            if np.abs(slopes[:, j]).max() > 5 and alike(slopes[:, j], speeds[:, j]) < 0.7:
                yield f"{name} is not the speed of {ANGLES[j]}"
    if set(GOALS) <= set(log.columns):
        goals = log.array(*GOALS)
        if np.abs(q - goals).max() < TICK_DEG:
            yield "the measured angles are the commanded ones: an arm lags behind"
        else:
            for j in np.flatnonzero(np.ptp(goals, axis=0) > 5):
                if (ahead := lag(t, goals[:, j], q[:, j])) < 0:
                    yield f"{ANGLES[j]} is {-ahead * 1000:.0f} ms ahead of its command"


def alike(a, b):
    """The correlation of two curves; 0 where one of them is flat."""
    return 0.0 if np.ptp(a) == 0 or np.ptp(b) == 0 else float(np.corrcoef(a, b)[0, 1])


def lag(t, goal, measured):
    """The delay (s) at which the measured curve fits the commanded one best."""
    step = float(np.median(np.diff(t)))
    shifts = range(-20, 21)
    late = t[25:-25] if len(t) > 60 else t
    misses = [np.abs(np.interp(late, t + k * step, goal) - np.interp(late, t, measured)).mean() for k in shifts]
    return shifts[int(np.argmin(misses))] * step


def elsewhere(log, q):
    """Angles within the limits, and x, y, z those of the angles."""
    low, high = np.degrees(omx.LIMITS).T
    for j, name in enumerate(ANGLES):
        if q[:, j].min() < low[j] - 1 or q[:, j].max() > high[j] + 1:
            yield f"{name} leaves its limits: are the angles in degrees, and in the order of the joints?"
            return
    if {"x", "y", "z"} <= set(log.columns):
        off = np.abs(log.array("x", "y", "z") - omx.pose(np.radians(q), log.geometry)[:, :3]).max()
        if off > 0.01:
            yield f"x, y, z are up to {off:.1f} mm away from those of the angles, for the lengths in its first lines"


def main(argv):
    if not argv:
        sys.exit("lab_log: name the logs, such as side-1.csv.")
    odd = False
    for path in argv:
        try:
            log = read_log(path)
        except (omx.OmxError, OSError) as error:
            odd = True
            print(f"{path}: {error}")
            continue
        found = list(oddities(log))
        odd = odd or bool(found)
        span = f"{len(log)} samples, {log['t'][-1] - log['t'][0]:.1f} s" if len(log) and "t" in log.columns else "empty"
        print(f"{path}: {span}; {'; '.join(found) or 'nothing is odd'}")
    return int(odd)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
