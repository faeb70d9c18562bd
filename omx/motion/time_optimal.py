"""The fastest timing of a given path, within limits on speed, acceleration and torque.

The path says where, q(s). When is one function more, s(t), and its speed is all that can be chosen. With x = (ds/dt)^2
and u = d2s/dt2, and primes for derivatives by s,

    qd^2 = q'^2 x,     qdd = q' u + q'' x,     torque = gravity + along u + bend x,

so each limit is a straight line in the plane of x and u, and from one place to the next x grows by 2 u ds. Backwards
from the end one finds the speeds from which the end can be reached at all; forwards one takes the fastest of them. This
is reachability analysis, by H. Pham and Q.-C. Pham (2018).
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ..arm import NO_LOAD_SPEED, STALL_TORQUE
from ..arrays import as_number, as_rows, shown
from ..errors import BadInput, OmxError
from .dynamics import motor_torques
from .paths import Path
from .trajectory import TINY, Trajectory

#: Below this a coefficient, in shares of its limit, counts as 0, and a gap between two limits as none.
FLAT = 1e-12


@dataclass(frozen=True)
class Allowed:
    """What the joints may do, each way: one number for all joints, or four. Raises `BadInput`.

    `speed` in rad/s, `acceleration` in rad/s^2, `torque` in Nm, gravity and a payload (g) at the tool included.
    """

    speed: tuple[float, ...] | float = NO_LOAD_SPEED
    acceleration: tuple[float, ...] | float = 20.0
    torque: tuple[float, ...] | float = STALL_TORQUE
    payload_g: float = 0.0

    def __post_init__(self):
        for name in ("speed", "acceleration", "torque"):
            value = getattr(self, name)
            four = as_rows(
                value if np.ndim(value) else [value] * 4, name, 4, f"above {TINY:g}, one number or four", many=False
            )
            if not four.min() > TINY:
                raise BadInput(f"`{name}` must be above {TINY:g}, one number for all joints or four; got {value}.")
            object.__setattr__(self, name, tuple(four.tolist()))
        as_number(self.payload_g, "payload_g", "a mass of 0 g or more", 0.0)

    def lines(self, path: Path) -> np.ndarray:
        """(3, N, 8): a, b, c of the limits |a u + b x + c| <= 1 at each place, in shares of what is allowed."""
        still, along, bend = torque_lines(path, self.payload_g)
        parts = [np.array([path.dq, path.ddq, 0 * path.q]) / self.acceleration]
        parts += [np.array([along, bend, still]) / self.torque]
        return np.concatenate(parts, axis=-1)

    def most(self, path: Path) -> np.ndarray:
        """The largest x (N,) that the speeds allow; beyond 1/`TINY` where no joint moves."""
        return (np.array(self.speed) / np.maximum(np.abs(path.dq), TINY)).min(axis=1) ** 2


def torque_lines(path: Path, payload_g: float = 0.0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """`still`, `along` and `bend`, each (N, 4), of the motors' torque still + along u + bend x (Nm) on the path."""
    _check(path, Allowed(payload_g=payload_g))
    still = motor_torques(path.q, payload_g=payload_g)
    along = motor_torques(path.q, qdd=path.dq, payload_g=payload_g) - still
    return still, along, motor_torques(path.q, path.dq, path.ddq, payload_g) - still


def controllable(path: Path, allowed: Allowed) -> tuple[np.ndarray, np.ndarray]:
    """The least and the largest x = (ds/dt)^2, each (N,), from which the end of the path can be reached, at rest there.

    Raises `OmxError` at a place where there is none, `BadInput`.
    """
    _check(path, allowed)
    lines, most = _both_ends(path, allowed), allowed.most(path)
    low, high = np.zeros_like(path.s), np.zeros_like(path.s)
    for i in reversed(range(len(path.s) - 1)):
        reach = _reach(path.s[i + 1] - path.s[i], low[i + 1], high[i + 1])
        low[i], high[i] = _span(np.hstack([lines[:, i], reach]), most[i])
        if low[i] > high[i] * (1 + 1e-9) + FLAT:
            raise OmxError(_why_none(path, allowed, i))
    return low, high


def fastest(path: Path, allowed: Allowed) -> Trajectory:
    """The path (of joints, rad) in the least time that is `allowed`, from rest to rest, at the places of `path`.

    Between two places u is constant, and the limits hold at both; the more places, the better. Raises `OmxError` where
    no speed at all keeps the limits, `BadInput`.
    """
    low, high = controllable(path, allowed)
    lines, steps = _both_ends(path, allowed), np.diff(path.s)
    if low[0] > FLAT:
        raise OmxError(_why_none(path, allowed, 0))
    x, u = np.zeros_like(path.s), np.zeros_like(path.s)
    for i, step in enumerate(steps):
        _, most_u = _slopes(np.hstack([lines[:, i], _reach(step, low[i + 1], high[i + 1])]), x[i])
        x[i + 1] = min(max(x[i] + 2 * step * most_u, low[i + 1]), high[i + 1])
        u[i] = (x[i + 1] - x[i]) / (2 * step)
    speed, u[-1] = np.sqrt(x), u[-2]
    pairs = np.array([a + b for a, b in pairwise(speed)])
    if not pairs.min() > TINY:
        raise OmxError(_why_none(path, allowed, int(pairs.argmin())))
    t = np.concatenate([[0.0], np.cumsum(2 * steps / pairs)])
    return Trajectory(t, path.q, path.dq * speed[:, None], path.dq * u[:, None] + path.ddq * x[:, None])


def _check(path, allowed) -> None:
    if not isinstance(path, Path):
        raise BadInput(f"`path` must be a Path of joints, such as `spline_path(...)` gives; got {shown(path)}.")
    if not isinstance(allowed, Allowed):
        raise BadInput(f"`allowed` must be an Allowed(...); got {shown(allowed)}.")


def _both_ends(path: Path, allowed: Allowed) -> np.ndarray:
    """a, b, c of a u + b x + c <= 0, (3, N - 1, 32): each limit, both ways, where a step begins and where it ends.

    At its end x is x + 2 u ds.
    """
    a, b, c = allowed.lines(path)
    ends = np.array([a[1:] + 2 * np.diff(path.s)[:, None] * b[1:], b[1:], c[1:]])
    two = np.concatenate([np.array([a, b, c])[:, :-1], ends], axis=-1)
    one = np.array([0.0, 0.0, 1.0])[:, None, None]
    return np.concatenate([two - one, -two - one], axis=-1)


def _reach(step: float, low: float, high: float) -> np.ndarray:
    """x + 2 u ds <= high and >= low, as a, b, c (3, 2)."""
    return np.array([[2 * step, -2 * step], [1.0, -1.0], [-high, low]])


def _slopes(lines, x: float) -> tuple[float, float]:
    """The least and the largest u that the lines allow at `x`."""
    a, b, c = lines
    with np.errstate(divide="ignore", invalid="ignore"):
        u = -(b * x + c) / a
    return u[a < -FLAT].max(), u[a > FLAT].min()


def _span(lines, most: float) -> tuple[float, float]:
    """The least and the largest x in 0 .. `most` for which some u satisfies all lines.

    Solved for u, a line bounds it from above (a > 0) or from below: u <= p + r x. Every bound from below must be under
    every bound from above: no u is left in that, only x.
    """
    a, b, c = lines
    above, below, flat = a > FLAT, a < -FLAT, np.abs(a) <= FLAT
    p, r = (np.divide(-part, a, out=np.zeros_like(a), where=~flat) for part in (c, b))
    slope = np.concatenate([(r[below][:, None] - r[above]).ravel(), b[flat]])
    room = np.concatenate([(p[above] - p[below][:, None]).ravel(), -c[flat]])
    up, down = slope > FLAT, slope < -FLAT
    high = min(most, (room[up] / slope[up]).min(initial=np.inf))
    low = max(0.0, (room[down] / slope[down]).max(initial=0.0))
    return (low, high) if room[~up & ~down].min(initial=0.0) >= -1e-9 else (np.inf, 0.0)


def _why_none(path: Path, allowed: Allowed, i: int) -> str:
    """A sentence on the place `i`, where no speed keeps the limits."""
    where = f"at s = {path.s[i]:.4g} of {path.s[-1]:.4g}, q = {np.degrees(path.q[i]).round(1)} deg,"
    still = np.abs(motor_torques(path.q[i], payload_g=allowed.payload_g))
    torque = np.array(allowed.torque)
    worst = int(np.argmax(still / torque))
    if still[worst] > torque[worst]:
        needs, may = f"{still[worst]:.2f} Nm", f"{torque[worst]:.2f} Nm"
        return (
            f"{where} joint {worst + 1} would need {needs} to stand still, and {may} are allowed; carry less, or lead "
            "the path nearer to the base."
        )
    return f"{where} no speed keeps the limits; allow more acceleration or torque, or make the path bend less there."
