"""One motor with its gearbox and what it carries: a torque comes in, the joint turns or holds.

The motor is the straight line of its data sheet: full torque at standstill, no torque at no-load speed. There is
dry friction and no inertia: what the motor has left after load and friction decides the speed at once. Angles are
in rad, torques in Nm, times in s.
"""

import random
from dataclasses import dataclass
from math import copysign, exp, inf, sin
from typing import NamedTuple

from ...arm import NO_LOAD_SPEED, STALL_TORQUE, TORQUE_PER_MA

#: Slope of the motor's line: torque lost per speed.
DAMPING = STALL_TORQUE / NO_LOAD_SPEED
#: Torque lost per speed when the motor is not powered and the load turns the gearbox: the arm falls slowly.
COASTING = 0.3
FRICTION = 0.1
#: A joint at rest holds a little more than a moving one.
STICTION = 1.02


@dataclass(slots=True)
class Drive:
    """What the controller asks of the motor: torque + stiffness (target - angle), at most `limit`; or a `speed`.

    `full`, where it is not `limit`: the torque that the voltage allows. A current that is limited pushes weakly, but
    what is `light` it moves as fast as the voltage turns the motor.
    """

    limit: float = 0.0
    torque: float = 0.0
    stiffness: float = 0.0
    target: float = 0.0
    speed: float | None = None
    damping: float = DAMPING
    full: float = 0.0


COAST = Drive(damping=COASTING)


class Joint:
    """The state of one joint: `angle`, `speed`, `effort`, the torque of the motor on what it carries, and `current`.

    The motor draws that current (mA), with the sign of its torque.

    `play` (rad, from end to end) is between what the encoder sees and the link. The link leans to the side that its
    load pushes it to, and without a load it lags behind the motion. `light`: it has nothing to carry, like fingers.
    """

    def __init__(
        self, angle: float, low=-inf, high=inf, friction: float = FRICTION, play: float = 0.0, light: bool = False
    ):
        self.angle, self.low, self.high, self.friction, self.play, self.light = angle, low, high, friction, play, light
        self.speed = self.effort = self.current = self._lean = 0.0
        self.contact = inf  # where what it presses on balances its motor: it goes no further, though the stop is beyond

    @property
    def link(self) -> float:
        """Where the link really is (rad): `angle`, and half of the play."""
        return self.angle + self._lean

    def stops(self, low: float, high: float):
        """Let the joint move between these angles only."""
        self.low, self.high = low, high

    def settle(self, drive: Drive, load: float, dt: float):
        """Set speed and effort for the next `dt` seconds, with the torque `load` acting on the joint."""
        limit = drive.limit
        wanted = drive.torque + drive.stiffness * (drive.target - self.angle)
        if drive.speed is not None:
            wanted = copysign(limit, drive.speed) if drive.speed else -load
        torque = wanted if -limit <= wanted <= limit else copysign(limit, wanted)
        self.speed, self.effort = 0.0, torque
        if abs(torque + load) > STICTION * self.friction:
            self._move(drive, wanted, torque, load, dt)
        if not limit:
            self.effort = 0.0  # a motor without power draws no current, whatever turns it
        self.current = self.effort / TORQUE_PER_MA
        if self.play and (load or self.speed):
            self._lean = copysign(self.play / 2, load or -self.speed)

    def _move(self, drive: Drive, wanted: float, torque: float, load: float, dt: float):
        friction = copysign(self.friction, torque + load)
        wins = self.light and drive.full and torque * (torque + load) > 0
        free = ((copysign(drive.full, torque) if wins else torque) + load - friction) / drive.damping
        aimed = drive.speed
        if drive.stiffness:  # the torque falls as the joint nears its target: the exact solution over dt
            excess = wanted + load - friction
            aimed = excess / drive.stiffness * (1 - exp(-drive.stiffness * dt / drive.damping)) / dt
        speed = _within(free, aimed)
        self.speed = self._up_to_stop(speed, dt)
        if self.speed == speed:
            self.effort = friction - load

    def _up_to_stop(self, speed: float, dt: float) -> float:
        """`speed`, or less if a stop is in the way within `dt`."""
        if speed > 0:
            room = (min(self.high, self.contact) - self.angle) / dt
            return speed if speed <= room else max(room, 0.0)
        room = (self.low - self.angle) / dt
        return speed if speed >= room else min(room, 0.0)


def _within(free: float, aimed: float | None) -> float:
    """`aimed`, but not faster than `free`; a load that overpowers the motor (opposite signs) has its way."""
    return free if aimed is None or aimed * free <= 0 or abs(aimed) > abs(free) else aimed


class Encoder(NamedTuple):
    """What the sensor on the output shaft makes of an angle, before the register rounds; ideal unless asked otherwise.

    `ripple` (rad) is the most that a reading is wrong by, `phase` (rad) where on the turn; `noise` (rad) is rms. The
    XM430 has an AS5045 (the maker's e-manual). Its data sheet allows a non-linearity of 0.5 deg with a well centred
    magnet, mostly once a turn, and gives a noise of 0.03 deg rms in its slow mode, 0.06 in its fast one.
    """

    ripple: float = 0.0
    phase: float = 0.0
    noise: float = 0.0

    def reads(self, angle: float) -> float:
        """What is read (rad) where the joint is at `angle`, but for noise."""
        return angle + self.ripple * sin(angle + self.phase)

    def angle(self, reading: float) -> float:
        """Where the joint is (rad) when `reading` is read."""
        if not self.ripple:
            return reading
        angle = reading
        for _ in range(3):
            angle = reading - self.ripple * sin(angle + self.phase)
        return angle

    def jitter(self, servo: int, moment: int) -> float:
        """The noise (rad) in a reading of `servo` at the `moment` (a count of steps): the same whoever looks."""
        return random.Random(moment << 8 | servo).gauss(0.0, self.noise) if self.noise else 0.0
