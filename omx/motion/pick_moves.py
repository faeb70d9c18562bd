"""The legs of a pick or a place from above: over it as the joints turn, straight down, straight up again."""

from math import pi

import numpy as np

from .. import kinematics
from ..arm import SPEED_CAP
from ..arrays import as_four, as_number, as_rows
from ..geometry import COURSE, Geometry
from ..kinematics import JOINT_ANGLES
from .trajectory import Trajectory, joint_move, line

#: How high (mm) the tool is carried, and how long (s) it takes straight down or up.
ABOVE, STRAIGHT_S = 95.0, 1.2
#: The quintic's top speed, by its mean; and the share of the speed cap that is used.
TOP, CAUTION = 1.875, 0.9


def legs(
    start, place, z: float, above: float = ABOVE, geometry: Geometry = COURSE, speed: float = 1.0
) -> tuple[Trajectory, Trajectory, Trajectory]:
    """From `start` (rad) with the hand pointing down over `place` (x, y), down to the height `z`, and up: three legs.

    The first takes as long as 9/10 of the speed cap ask for; with a `speed` of 0.5 all three take twice as long. The
    tool is `above` mm high between places, and at least 16 mm above `z`. Raises `Unreachable`, `JointLimit`,
    `PathBlocked` or `BadInput`; the table is the guard's business.
    """
    start = as_four(start, "start", JOINT_ANGLES)
    x, y = as_rows(place, "place", 2, "x and y on the table in mm", many=False)
    z = as_number(z, "z", "a height in mm")
    slow = 1 / as_number(speed, "speed", "a share of the full speed, above 0 and at most 1", 1e-3, 1.0)
    high = max(as_number(above, "above", "a height in mm"), z + 16)
    over = np.array(kinematics.solve_ik([x, y, high, -pi / 2], start, geometry).q)
    way = float(np.abs(np.subtract(over, start)).max())
    first = joint_move(start, over, slow * max(0.6, TOP * way / (CAUTION * SPEED_CAP)), rate=40)
    down = line(over, [x, y, z, -pi / 2], slow * STRAIGHT_S, rate=40, geometry=geometry)
    return first, down, line(down.q[-1], [x, y, high, -pi / 2], slow * STRAIGHT_S, rate=40, geometry=geometry)
