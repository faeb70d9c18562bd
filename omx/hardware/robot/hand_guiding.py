"""Teaching by hand: the motors carry the arm's weight while a hand leads it; what was recorded becomes a trajectory."""

import math

import numpy as np

from ...arrays import as_number
from ...errors import BadInput
from ...motion.trajectory import Trajectory
from ..log import Log
from .driver import Driver

JOINTS = tuple(f"q{i}" for i in range(1, 5))
#: A hand trembles and an encoder counts in ticks: what is shorter than this (s) is smoothed away.
SMOOTH_S = 0.3
RATE = 100.0
#: The longest recording (s) that is replayed: a damaged time is not taken for a day.
LONGEST_S = 3600.0


def joints_named(joints) -> tuple[int, ...]:
    """`joints` as numbers 1 .. 4, each once; raises `BadInput`."""
    try:
        numbers = tuple(joints)
    except TypeError:
        numbers = (joints,)
    if not numbers or len(set(numbers)) != len(numbers) or not set(numbers) <= {1, 2, 3, 4}:
        raise BadInput(f"`joints` are some of 1, 2, 3, 4, each once; got {joints!r}.")
    return numbers


def trajectory(log: Log, speed: float = 1.0) -> Trajectory:
    """The motion that `log` holds, at `speed` times its own speed, beginning and ending at rest.

    Smoothed over `SMOOTH_S` of the recording: at either end the arm takes half of that to speed up, and to slow down.
    """
    speed = as_number(speed, "speed", "at least 0.001, 1 for as fast as it was taught", 1e-3)
    t, q = log["t"], np.radians(log.array(*JOINTS))
    if {log.units[joint] for joint in JOINTS} != {"deg"}:
        raise BadInput("the log's angles must be in deg: a heading is `q1 (deg)`.")
    if len(t) < 2 or not np.isfinite(q).all() or not (np.diff(t) > 0).all() or not t[-1] - t[0] <= LONGEST_S:
        raise BadInput(
            "the log must have at least two samples, every angle measured, its times growing, within "
            f"{LONGEST_S:.0f} s."
        )
    half = round(SMOOTH_S * RATE / 2)
    even = np.arange(0.0, t[-1] - t[0] + 1.0 / RATE, 1.0 / RATE) + t[0]
    padded = np.array([np.pad(np.interp(even, t, column), 2 * half, mode="edge") for column in q.T])
    window = np.hanning(2 * half + 3)[1:-1]
    smooth = np.array([np.convolve(column, window / window.sum(), mode="valid") for column in padded]).T
    step = 1.0 / RATE / speed
    velocity = np.gradient(smooth, step, axis=0)
    velocity[[0, -1]] = 0.0
    return Trajectory(np.arange(len(smooth)) * step, smooth, velocity, np.gradient(velocity, step, axis=0))


def check_speed(driver: Driver, motion: Trajectory, speed: float) -> None:
    """Raise `BadInput` if a joint would be faster than the cap, with the greatest `speed` that would do."""
    fastest = float(np.abs(motion.qd).max())
    if fastest > driver.guard.speed_cap:
        most = math.floor(100 * speed * driver.guard.speed_cap / fastest) / 100
        raise BadInput(
            f"at {speed:g} times the speed that it was taught with a joint would turn at {math.degrees(fastest):.0f} "
            f"deg/s; the cap is {math.degrees(driver.guard.speed_cap):.0f} deg/s. speed={most:g} is the most."
        )
