"""Pushing with currents instead of going to positions: for a moment only, and then the arm holds.

The joints hold their position with a limited current (mode 5): sent far away, one pushes with all the current that it
may have. Should the program die, the servos' own watchdog makes each stand where it is, with that much current; in
current mode it would leave them limp.
"""

import math
from collections.abc import Mapping

from ...arm import NO_LOAD_SPEED, STALL_CURRENT
from ...errors import OmxError, OutOfBounds, TooFast
from ..dynamixel import units
from ..safety import Guard
from .brake import Brake
from .monitor import Monitor, Reading
from .servo_group import JOINTS, MOTION_PUSHED, Servos

#: How long a velocity or a push lasts unless it is repeated (s).
UNREPEATED_S = 0.4
#: How far ahead (s) an arm that is pushed must stay clear: a look of the watch, and the time that a hold takes.
AHEAD_S = 0.3
#: How much faster (rad/s) a motor turns for each mA.
SPEED_PER_MA = NO_LOAD_SPEED / STALL_CURRENT
#: How far (ticks) from where it is a joint is sent to push: more than any current gives way.
FAR = units.ANGLE.raw(math.radians(30.0))


class Pushing:
    """Those joints of `servos` that push. `joints`: their ids; `until`: when that ends unless it is repeated."""

    def __init__(self, servos: Servos, monitor: Monitor, brake: Brake):
        self.servos, self.monitor, self.brake, self.clock = servos, monitor, brake, servos.bus.clock
        self.joints: set[int] = set()
        self.until = math.inf

    def __bool__(self) -> bool:
        return bool(self.joints)

    def forecast(self, reading: Reading, milliamps: Mapping[int, float], guard: Guard) -> OutOfBounds | None:
        """What the guard has against pushing with `milliamps` (id -> mA) from here: too fast, or soon too near."""
        # A motor has no inertia to speak of: what it pushes more than now decides at once how much faster it turns.
        now = zip(JOINTS, reading.speed, reading.current, strict=True)
        speed = [v + (milliamps.get(servo, mA) - mA) * SPEED_PER_MA for servo, v, mA in now]
        worst = max(range(4), key=lambda i: abs(speed[i]))
        try:
            if abs(speed[worst]) > guard.speed_cap:
                raise TooFast(f"q{worst + 1}", abs(speed[worst]), guard.speed_cap, AHEAD_S)
            guard.check([a + v * AHEAD_S for a, v in zip(reading.q, speed, strict=True)], reading.q)
        except OmxError as reason:
            return OutOfBounds(reason)
        return None

    def push(self, milliamps: Mapping[int, float]) -> tuple[float, ...]:
        """Each of these joints (id -> mA) pushes from now on; returns the currents as the servos round them."""
        raw = {servo: units.CURRENT.raw(mA) for servo, mA in milliamps.items()}
        ticks = self.monitor.seen[1]
        motions = {
            servo: (abs(push), 0, 0, 0, self.servos.within_limits(servo, ticks[servo] + int(math.copysign(FAR, push))))
            for servo, push in raw.items()
        }
        with self.brake.lock:
            self.brake.refuse_if_stopped_since(self.brake.began)
            self.joints = set(raw)
            self.servos.bus.write_all("bus_watchdog", dict.fromkeys(raw, units.WATCHDOG.raw(UNREPEATED_S)))
            self.servos.bus.write_block(MOTION_PUSHED, motions)
            self.until = self.clock.now() + UNREPEATED_S
            self.brake.refuse_if_stopped_since(self.brake.began)  # a signal's handler comes in spite of the lock
        return tuple(units.CURRENT.value(push) for push in raw.values())
