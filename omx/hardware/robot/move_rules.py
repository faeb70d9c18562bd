"""The rules of the last gate: how long a move takes, how far a step may go, and the way to the rest pose.

A move begins and ends at rest, so that the servos' set-points run along the very line that the guard checked: a servo
that gets a goal in mid-motion carries its old speed into the new one, past both. A step of a stream has no ramps: its
set-point runs straight to the step's end and stands there.
"""

import math
from itertools import pairwise

from ...arm import HOME, PARK_SPEED, REST, SLOW
from ...dh import limit_violations
from ...errors import BadInput, OmxError, TooFast
from ..safety import Guard

#: The times (s) of a move: the profile register of a servo ends at 32.7 s.
SHORTEST_S, LONGEST_S = 0.2, 32.0
#: The longest step (rad) of a stream, from where the arm is: it may lag a little behind.
STREAM_STEP = math.radians(8.0)
#: How far (rad) the first point of a stream may be ahead of its time, and the shortest time of a step (s).
FIRST_STEP, STEP_S = math.radians(3.0), 0.02
#: Which joints may go first where the straight way to the rest pose is not free.
_FIRST = ((), (1,), (2, 3), (3,), (2,), (1, 3))


def outside(guard: Guard, q) -> tuple:
    """The joints of `q` outside the guard's hard limits."""
    return limit_violations(q, guard.limits)


def seconds(guard: Guard, start, goal, asked: float | None, cap: float) -> float:
    """The time of a move: what was `asked`, or the fewest within `cap` (rad/s); `SLOW` from outside the limits.

    Raises `TooFast` where what was asked is too few, but from outside, where no caller can know how slow it must be.
    """
    slow = outside(guard, start)
    fewest = guard.seconds(start, goal) * guard.speed_cap / min(cap, SLOW if slow else cap)
    if asked is not None and not slow:
        fewest = guard.seconds(start, goal, asked)
    took = max(asked or 0.0, fewest, SHORTEST_S)
    if not took <= LONGEST_S:
        raise BadInput(f"`seconds` may be {LONGEST_S:.0f} at most, a servo's longest profile; this way takes {took:g}.")
    return took


def step_seconds(guard: Guard, reading, before, goal, asked: float) -> float:
    """The time of one step of a stream to `goal`: what was `asked`, or longer where the arm has to catch up.

    `before` is the step before, None at the start. Whatever moment the step arrives at, the set-point is then between
    where it was seen and `before`; from neither may it have to run faster than the cap. A step that is itself longer
    than the cap allows is refused.
    """
    if not 0 < asked <= LONGEST_S:
        raise BadInput(f"`seconds` must be a positive number, at most {LONGEST_S:.0f}; got {asked!r}.")
    far = _farthest(reading.q, goal)
    if far > STREAM_STEP:
        raise BadInput(f"the next point of the stream is {math.degrees(far):.1f} deg away; `move_to` it first.")
    first = before is None
    before = reading.aim if first else before
    step = _farthest(before, goal)
    if step > guard.speed_cap * asked * (1 + 1e-9) + (FIRST_STEP if first else 0.0):
        joint = max(range(4), key=lambda i: abs(goal[i] - before[i])) + 1
        raise TooFast(f"q{joint}", step / asked, guard.speed_cap, step / guard.speed_cap)
    cap = min(guard.speed_cap, SLOW) if outside(guard, reading.q) else guard.speed_cap
    return max(asked, max(step, _farthest(reading.aim, goal)) / cap, STEP_S)


def _farthest(start, goal) -> float:
    return max(abs(b - a) for a, b in zip(start, goal, strict=True))


def way_to_rest(guard: Guard, here) -> list[tuple[float, ...]]:
    """The goals (rad) on the way from `here` to the rest pose, none longer than a servo's profile.

    Joint 1 stays as it is: the arm folds where it stands. It passes `HOME`, from which the hand comes down; where the
    straight way there is not free, some joints go first. Raises what is in the way if none of these is free.
    """
    low, high = guard.soft_limits[0]
    turn, reason = min(max(here[0], low), high), None
    home, rest = (turn, *HOME[1:]), (turn, *REST[1:])
    for joints in _FIRST:
        first = tuple(home[i] if i in joints else here[i] for i in range(4))
        way = [here, *([first] if joints else []), home, rest]
        try:
            for start, goal in pairwise(way):
                guard.check(goal, start)
        except OmxError as error:
            reason = reason or error
        else:
            return [part for start, goal in pairwise(way) for part in _parts(guard, start, goal)]
    raise reason


def _parts(guard: Guard, start, goal) -> list[tuple[float, ...]]:
    """The way from `start` to `goal` in as many parts as it needs for each to fit into a profile."""
    cap = min(PARK_SPEED, guard.speed_cap, SLOW if outside(guard, start) else math.inf)
    count = max(1, math.ceil(guard.seconds(start, goal) * guard.speed_cap / cap / (LONGEST_S - 2.0)))
    return [tuple(a + (b - a) * i / count for a, b in zip(start, goal, strict=True)) for i in range(1, count + 1)]
