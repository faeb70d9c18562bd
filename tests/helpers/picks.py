"""One pick each by many imperfect arms, over the wire, beside what the error budget says of them.

python -m tests.helpers.picks 200
"""

import math
import os
import sys
from typing import NamedTuple

import numpy as np

import omx
from omx.analysis.accuracy import TICK_SIGMA, binomial_interval
from omx.hardware.robot import Robot
from omx.hardware.simulator import SteppedClock, VirtualArm, VirtualPort, World, cup
from omx.hardware.simulator.joint import Encoder

PICKS = int(os.environ.get("OMX_PICKS", "10"))
#: What the arms and whoever puts the cup on its mark are good for (deg, mm), and the cup (mm).
RIPPLE, HORN, PLAY, BY_HAND, CUP = 0.5, 0.3, 0.25, 1.5, 54.0
OPENING = 42 + 2 * 11.5 * math.pi / 4  # the course's open gripper, -45 deg
DOWN = -math.pi / 2


class Rate(NamedTuple):
    """How many of `picks` were `held`; what was predicted, and its interval of 99 %; how often geometry agreed."""

    picks: int
    held: int
    predicted: float
    low: int
    high: int
    as_geometry_says: int


def chance(radius: float) -> float:
    """The probability that both fingers pass the cup, `radius` mm from the axis of joint 1."""
    play = math.radians(PLAY) / math.sqrt(12)
    joint = math.hypot(math.radians(RIPPLE) / math.sqrt(2), math.radians(HORN), play, TICK_SIGMA)
    sigma = math.hypot(radius * joint, BY_HAND)
    return math.erf((OPENING - CUP) / 2 / sigma / math.sqrt(2))


def rate(picks: int, seed: int = 20) -> Rate:
    """Each pick by an arm of its own, of a cup at a place of its own."""
    draw = np.random.default_rng(seed)
    chances, held, agreed = [], 0, 0
    for _ in range(picks):
        radius, turn = draw.uniform(120, 175), draw.uniform(-1.2, 1.2)
        lies, foreseen = pick(draw, radius, turn)
        chances.append(chance(radius))
        held += lies
        agreed += lies == foreseen
    low, high = binomial_interval(picks, float(np.mean(chances)), 0.99)
    return Rate(picks, held, float(np.sum(chances)), low, high, agreed)


def pick(draw, radius: float, turn: float) -> tuple[bool, bool]:
    """Does the hand hold the cup in the end, and do the true angles at the bottom say so?"""
    at = np.array([radius * math.cos(turn), radius * math.sin(turn)])
    above, below = (omx.solve_ik([*at, z, DOWN]).q for z in (90, 45))
    elsewhere = (turn + draw.choice((-0.4, 0.4)), *above[1:])
    arm = VirtualArm(q=elsewhere, backlash_deg=PLAY)
    for servo in arm.servos[:4]:
        servo.encoder = Encoder(math.radians(RIPPLE), draw.uniform(-math.pi, math.pi))
        servo.mount = math.radians(draw.normal(0, HORN))
    world = World(arm, [cup("cup", at + draw.normal(0, BY_HAND, 2), CUP)])
    robot = Robot(VirtualPort(arm, SteppedClock()))
    robot.write_motor_state(True)
    robot.release()
    robot.move_to(np.degrees(above), 1.5)
    robot.move_to(np.degrees(below), 1.5)
    foreseen = world.between(arm.q, arm.opening) == "cup" and world["cup"].standing
    robot.grip(payload_g=30)
    robot.move_to(np.degrees(above), 1.5)
    held = world.held == "cup"
    robot.relax()
    robot.close()
    return held, foreseen


if __name__ == "__main__":
    print(rate(int(sys.argv[1])))
