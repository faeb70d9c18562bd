"""The gripper: it presses with a force that it can keep up, knows whether it holds something, and when it has lost it.

Its servo holds a position with limited current (mode 5): the fingers close until something, or the end, stops them, and
go on pressing. A position alone would take all the servo has, overload, and drop what it held after a second.
"""

import math
from typing import NamedTuple

from ...arm import FINGER_PER_RAD, GRIP_FORCES, GRIP_TORQUE_PER_N, GRIPPER_ID, OPENING_AT_ZERO, TORQUE_PER_MA
from ...arrays import as_number
from ...errors import ObjectLost
from ..dynamixel import registers as reg
from ..dynamixel import units
from ..dynamixel.bus import again
from ..safety import FRICTION
from .servo_group import HOLD_S, RESTING, STATE, Servos

#: Fingers that stand this far (rad) short of where they were sent have something between them: pads 1 mm apart.
SHORT = 0.045
#: Fingers that have closed by this much (rad) since they held something have lost it: pads 2 mm closer.
SLIPPED = 0.09
#: How long (s) fingers take at the most: weak ones are slow.
PATIENCE_S = 8.0
#: Fingers that turned less (rad) than this in 0.1 s stand.
STILL = math.radians(0.1)


class Grip(NamedTuple):
    """One look at the gripper: its pads are `opening` mm apart and press with about `force` N; `holding` something.

    `angle` is its servo's (rad; negative is open). The force comes from the motor's current: dry friction in the
    gearbox hides up to 4 N of it.
    """

    opening: float
    force: float
    holding: bool
    angle: float


class Gripper:
    """Servo 15 of `servos`. `goal` is the angle (rad) that it was sent to last, None before."""

    def __init__(self, servos: Servos):
        self.servos, self.clock = servos, servos.bus.clock
        self.goal: float | None = None
        self._held: float | None = None  # where the fingers stood when they held something
        self.began = 0  # how often the arm had been stopped when they were last told to go
        self._standing = 0.0  # the time from which on they should stand

    def prepare(self, force: float, seconds: float) -> None:
        """From its next goal on it presses with at most `force` N, and takes `seconds` to get there."""
        low, high = GRIP_FORCES
        force = as_number(force, "force", f"{low:.0f} .. {high:.0f} N", low, high)
        milliamps = (force * GRIP_TORQUE_PER_N + FRICTION) / TORQUE_PER_MA
        self.servos.slow(GRIPPER_ID, seconds)
        self.servos.put(GRIPPER_ID, "goal_current", units.CURRENT.raw(milliamps))

    def close_to(self, angle: float, seconds: float) -> None:
        """Turn to `angle` (rad; negative opens) in the `seconds` prepared, whichever way its drive mode counts."""
        sense = self._sense()
        self.goal, self._held, self._standing = angle, None, self.clock.now() + seconds  # first: a stop may come now
        self.servos.put(GRIPPER_ID, "goal_position", units.POSITION.raw(sense * angle))

    def look(self) -> Grip:
        """Where its fingers are, and what they do; two transactions."""
        sense = self._sense()
        current, speed, position = again(self.servos.bus.read_block, [GRIPPER_ID], reg.PRESENT)[GRIPPER_ID]
        angle = sense * units.POSITION.value(position)
        stands = abs(units.VELOCITY.value(speed)) < RESTING and self.clock.now() >= self._standing
        torque = sense * units.CURRENT.value(current) * TORQUE_PER_MA
        closing = self.goal is not None and self.goal - angle > SHORT and torque > 0
        holding = stands and closing
        self._held = angle if holding and self._held is None else self._held
        force = max(torque - FRICTION, 0.0) / GRIP_TORQUE_PER_N
        return Grip(OPENING_AT_ZERO + 2 * FINGER_PER_RAD * angle, force, holding and not self._slipped(angle), angle)

    @property
    def moving(self) -> bool:
        """Are the fingers still under way, by their time?"""
        return self.clock.now() < self._standing

    def settle(self) -> Grip:
        """Wait until the fingers stand, and look."""
        until, before = self.clock.now() + PATIENCE_S, math.inf
        while True:
            self.clock.sleep(0.1)
            grip = self.look()
            still = abs(grip.angle - before) < STILL
            if (still and self.clock.now() >= self._standing) or self.clock.now() > until:
                return grip
            before = grip.angle

    def lost(self) -> ObjectLost | None:
        """What it held and holds no more, told once."""
        if self.goal is None:
            return None
        before, grip = self._held, self.look()
        if before is None or grip.holding:
            return None
        limp = not self.servos.get(GRIPPER_ID, "torque_enable")
        if not (limp or self._slipped(grip.angle)):
            return None
        self._held, self.goal = None, None
        return ObjectLost(OPENING_AT_ZERO + 2 * FINGER_PER_RAD * before, grip.opening, limp)

    def stand(self) -> None:
        """Stop the fingers where they are, if they move, or are about to; what they press on they go on pressing.

        Fingers that were just told to go do not move yet; their own set-point may run ahead of what they press on.
        """
        if self.goal is None:
            return
        sense = self._sense()
        speed, position, _, aim = again(self.servos.bus.read_block, [GRIPPER_ID], STATE)[GRIPPER_ID]
        if self._held is not None and not self._slipped(sense * units.POSITION.value(position)):
            return
        moves = abs(units.VELOCITY.value(speed)) >= RESTING
        if moves or self.moving:
            presses = not moves and abs(units.ANGLE.value(aim - position)) > SHORT
            goal = aim if presses else position
            self.goal = sense * units.POSITION.value(goal)
            self.servos.send({GRIPPER_ID: goal}, HOLD_S, ramp=0.0)

    def _slipped(self, angle: float) -> bool:
        return self._held is not None and angle - self._held > SLIPPED

    def _sense(self) -> int:
        return -1 if self.servos.get(GRIPPER_ID, "drive_mode") & reg.DRIVE_REVERSE else 1
