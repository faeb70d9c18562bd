"""The set-point generator inside a servo: how registers 108, 112 and a goal become a trajectory.

Positions are in ticks, speeds in ticks/s, times in s. A trajectory is a list of pieces of constant acceleration,
so it can be asked for any time, however often. A new goal takes over the speed of the old trajectory.
"""

from math import copysign, inf, sqrt
from typing import NamedTuple

STEP, RECTANGLE, TRIANGLE, TRAPEZOID = range(4)


class Piece(NamedTuple):
    """From `start` on: position p + v t + a t^2 / 2."""

    start: float
    position: float
    speed: float
    acceleration: float


class Trajectory(NamedTuple):
    """What the servo's set-point does from now to `end`; it stays at `goal` afterwards."""

    pieces: tuple[Piece, ...]
    end: float
    goal: float
    shape: int

    @property
    def steady_from(self) -> float:
        """From when on the set-point stands still, or turns at a constant speed for ever."""
        return self.pieces[-1].start if self.end == inf else self.end

    def at(self, time: float) -> tuple[float, float]:
        """Set-point and its speed at `time`."""
        if time >= self.end or not self.pieces:
            return self.goal, 0.0
        for piece in reversed(self.pieces):
            if time >= piece.start:
                break
        start, position, speed, acceleration = piece
        t = time - start
        return position + (speed + 0.5 * acceleration * t) * t, speed + acceleration * t


def step(now: float, goal: float) -> Trajectory:
    """Register 112 = 0: the set-point jumps to the goal and the motor follows as fast as it can."""
    return Trajectory((), now, goal, STEP)


def by_speed(now: float, position: float, speed: float, goal: float, cruise: float, acceleration: float):
    """Velocity-based profile: at most `cruise`, speeding up and slowing down at `acceleration` (0 = at once)."""
    distance = goal - position
    if not acceleration:
        return _pieces(now, position, [(abs(distance) / cruise, copysign(cruise, distance), 0.0)], goal, RECTANGLE)
    phases = []
    braking = speed * abs(speed) / (2 * acceleration)
    if (distance - braking) * speed < 0:  # moving away, or too fast to stop in time: stop first, then come back
        phases.append((abs(speed) / acceleration, speed, -copysign(acceleration, speed)))
        distance, speed = distance - braking, 0.0
    start, top = abs(speed), min(cruise, sqrt(acceleration * abs(distance) + speed * speed / 2))
    between = abs(distance) - (abs(top**2 - start**2) + top**2) / (2 * acceleration)
    along = copysign(1.0, distance)
    ramp = copysign(acceleration, top - start)
    phases.append(((top - start) / ramp, along * start, along * ramp))
    phases.append((between / top if between > 0 else 0.0, along * top, 0.0))
    phases.append((top / acceleration, along * top, -along * acceleration))
    return _pieces(now, position, phases, goal, TRAPEZOID if between > 0 else TRIANGLE)


def by_time(now: float, position: float, speed: float, goal: float, total: float, ramp: float) -> Trajectory:
    """Time-based profile: arrive after `total` seconds, of which `ramp` to speed up and `ramp` to slow down."""
    ramp = min(ramp, total / 2)
    cruise = (goal - position - speed * ramp / 2) / (total - ramp)
    phases = [(total - 2 * ramp, cruise, 0.0)]
    if ramp:
        phases = [(ramp, speed, (cruise - speed) / ramp), *phases, (ramp, cruise, -cruise / ramp)]
    shape = RECTANGLE if not ramp else TRIANGLE if ramp == total / 2 else TRAPEZOID
    return _pieces(now, position, phases, goal, shape)


def to_speed(now: float, speed: float, wanted: float, acceleration: float) -> Trajectory:
    """Velocity mode: from `speed` to `wanted` at `acceleration` (0 = at once), then on for ever."""
    pieces = [Piece(now, 0.0, wanted, 0.0)]
    duration = abs(wanted - speed) / acceleration if acceleration else 0.0
    if duration > 0:
        pieces = [Piece(now, 0.0, speed, (wanted - speed) / duration), Piece(now + duration, 0.0, wanted, 0.0)]
    return Trajectory(tuple(pieces), inf, 0.0, TRAPEZOID if len(pieces) > 1 else STEP)


def _pieces(now, position, phases, goal, shape) -> Trajectory:
    pieces = []
    for duration, speed, acceleration in phases:
        if duration > 0:
            pieces.append(Piece(now, position, speed, acceleration))
            position += (speed + 0.5 * acceleration * duration) * duration
            now += duration
    return Trajectory(tuple(pieces), now, goal, shape)
