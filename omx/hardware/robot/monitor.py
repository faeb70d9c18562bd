"""Keeping an arm safe: every look at it, what is wrong with it, bringing it to a stand. Commands are in `driver`."""

import contextlib
import math
import threading
from typing import NamedTuple

from ...arm import ARM_IDS, STALL_MA
from ...errors import (
    BusCorrupt,
    BusError,
    BusTimeout,
    NotReady,
    OmxError,
    PortLost,
    ServoLost,
    ServoRestarted,
    Stalled,
    Stopped,
)
from ..dynamixel import registers as reg
from ..dynamixel import units
from ..dynamixel.bus import Bus
from ..safety import Guard, stalled
from .discovery import Condition, judge, look_over
from .servo_group import HOLD_S, JOINTS, Servos, again

LOOK_S = 0.02
STALL_S = 0.15
HEALTH_S = 1.0
STREAM_WATCHDOG_S = 0.4
#: How old a reading may be to hold blindly where it was.
FRESH_S = 1.5
#: How long a servo that restarts is silent, and a little more.
RESTART_S = 0.6

_HEALTH = reg.block("present_voltage", "present_temperature")


class Reading(NamedTuple):
    """One look at the joints: angles (rad), speeds (rad/s), currents (mA)."""

    q: tuple[float, ...]
    speed: tuple[float, ...]
    current: tuple[float, ...]


class Keeper:
    """Four joints and a gripper on `bus`, watched and held. Making one reads only; nothing moves."""

    def __init__(self, bus: Bus, guard: Guard | None = None):
        self.bus, self.guard, self.clock = bus, guard or Guard(), bus.clock
        self.condition: Condition = look_over(bus)
        if self.condition.problems:
            raise NotReady(bus.name, self.condition.problems)
        self.servos = Servos(bus)
        self._sending = threading.RLock()  # a stop must not come between the check for it and the goal
        self._profile_s: float | None = None
        self._arrival = self._fed = self._health_at = self.clock.now()
        self._stopping = threading.Event()
        self._stall_since: dict[int, float] = {}
        self._holding = False
        self._seen: tuple[float, dict[int, int]] = (-math.inf, {})  # when, and where each joint was (ticks)
        self.torque = any(self.servos.of_joints("torque_enable").values())
        self.mode = self._mode_found() if self.torque else "position"
        self._streaming = any(self.servos.of_joints("bus_watchdog").values())  # a stream that broke off

    def _mode_found(self) -> str:
        numbers = set(self.servos.of_joints("operating_mode").values())
        return next((name for name, value in reg.MODES.items() if numbers == {value}), "mixed")

    # ---- looking ----

    def read(self) -> Reading:
        """Angles, speeds and currents of the four joints, in one transaction. Raises what is wrong with them."""
        try:
            block = again(self.bus.read_block, JOINTS)  # once in a while an answer is lost
        except (BusTimeout, BusCorrupt) as error:
            self._silence(error)
            raise
        except PortLost as error:
            raise port_lost(error) from error
        self._seen = self.clock.now(), {servo: block[servo][2] for servo in JOINTS}
        current, speed, q = zip(*(block[servo] for servo in JOINTS), strict=True)
        reading = Reading(
            tuple(units.POSITION.value(raw) for raw in q),
            tuple(units.VELOCITY.value(raw) for raw in speed),
            tuple(units.CURRENT.value(raw) for raw in current),
        )
        if self.bus.alerts & set(JOINTS):
            self._fault()
        return reading

    def watch(self) -> Reading:
        """`read`, and hold with a reason if a joint stalls, is too hot or has too little voltage, or stop was hit."""
        reading = self.read()
        self._refuse_if_stopped()
        self._check_stall(reading)
        self._check_health()
        return reading

    def _check_stall(self, reading: Reading) -> None:
        now, stuck = self.clock.now(), set(stalled(reading.current, reading.speed, STALL_MA))
        self._stall_since = {joint: self._stall_since.get(joint, now) for joint in stuck}
        for joint, since in self._stall_since.items():
            if now - since >= STALL_S:
                self._stall_since = {}
                self.halt()
                raise Stalled(joint, reading.current[joint - 1])

    def _check_health(self) -> None:
        if self.clock.now() < self._health_at:
            return
        self._health_at = self.clock.now() + HEALTH_S
        condition = Condition()
        for servo, (volts, degrees) in again(self.bus.read_block, JOINTS, _HEALTH).items():
            judge(servo, units.VOLTAGE.value(volts), degrees, condition)
            self.condition.volts[servo], self.condition.degrees[servo] = units.VOLTAGE.value(volts), degrees
        if condition.problems:
            self.halt()
            raise NotReady(f"{self.bus.name} holds: the arm", condition.problems)
        self._check_torque()

    def _check_torque(self) -> None:
        """A motor that is off although we switched it on: an error, or a restart that nobody noticed."""
        if self.torque:
            off = [servo for servo, on in self.servos.of_joints("torque_enable").items() if not on]
            if off:
                self._fault()
                self._restarted(off)

    # ---- when something is wrong ----

    def _fault(self) -> None:
        """A servo has its alert bit set, or no torque: the others hold, and the hardware error is raised."""
        self.halt()
        again(self.bus.check_hardware, JOINTS)

    def _silence(self, error: BusError) -> None:
        """Someone did not answer twice: the others hold, and whoever is back after a restart is caught."""
        self.halt()
        if not self.torque:
            return
        gone, until = self._servos(), self.clock.now() + RESTART_S
        while True:
            there = self.bus.scan(gone)
            gone = [servo for servo in gone if servo not in there]
            if not gone or self.clock.now() >= until:
                break
            self.clock.sleep(LOOK_S)
        if gone:
            raise ServoLost(self.bus.name, "answer", gone, [s for s in self._servos() if s not in gone]) from error
        self._check_torque()

    def _restarted(self, servos) -> None:
        caught = [servo for servo in servos if self._caught(servo)]
        self._profile_s = None
        raise ServoRestarted(self.bus.name, servos, held=len(caught) == len(servos))

    def _caught(self, servo: int) -> bool:
        with contextlib.suppress(BusError):
            self.servos.set_up(servo, self._mode_of(servo), on=True)
            return True
        return False

    def halt(self) -> None:
        """Hold on our own account, once; what fails then does not hide the reason for it."""
        if self.torque and not self._holding:
            with contextlib.suppress(OmxError):
                self.hold()

    # ---- stopping ----

    def stop(self) -> None:
        """Hold at once, and refuse every command until `resume`. May be called from another thread."""
        self._stopping.set()
        self.hold()

    def resume(self) -> None:
        """Allow commands again after `stop`."""
        self._stopping.clear()

    def hold(self) -> None:
        """Stop where the arm is, torque on. Does what it can even if servos are missing, then raises what failed."""
        if not self.torque:
            return
        with self._sending:
            self._arrival = self.clock.now() + HOLD_S
            self._profile_s, self._holding = None, True
            position, failed = self.mode == "position", []
            stand = self._stand if position else self._into_position
            for step, *args in [(self.leave_stream,), *((stand, servo) for servo in JOINTS)]:
                try:
                    step(*args)
                except BusError as error:
                    failed.append(error)
            if not failed:
                self.mode = "position"
            elif not position:
                self.mode = "mixed"
        if failed:
            raise failed[0]

    def _stand(self, servo: int) -> None:
        """Hold one joint. If it does not answer it may still hear: it is told to stay where it was seen last."""
        try:
            self.servos.hold(servo)
        except (BusTimeout, BusCorrupt):
            when, where = self._seen
            if self.clock.now() - when < FRESH_S:
                for name, value in (("profile_acceleration", 0), ("profile_velocity", 1000), ("goal_position", None)):
                    self.bus.write_all(name, {servo: where[servo] if value is None else value})
            raise

    def _into_position(self, servo: int) -> None:
        self.servos.set_up(servo, "position", on=True)

    @property
    def moving(self) -> bool:
        """Is a commanded motion still under way, by its time?"""
        return self.clock.now() < self._arrival

    def _stream(self) -> None:
        """Arm the servos' own watchdog: without another command they stop by themselves.

        After a pause it may have tripped: then it refuses goals, and the profile is gone.
        """
        now = self.clock.now()
        if self._streaming and now - self._fed > 0.8 * STREAM_WATCHDOG_S:
            self.leave_stream()
        if not self._streaming:
            self._streaming = True
            self.bus.write_all("bus_watchdog", dict.fromkeys(JOINTS, units.WATCHDOG.raw(STREAM_WATCHDOG_S)))
        self._fed = now

    def leave_stream(self) -> None:
        """Disarm the watchdog again, and see that it is; a watchdog that has tripped is cleared."""
        if self._streaming:
            self._profile_s = None
            self.bus.write_all("bus_watchdog", dict.fromkeys(JOINTS, 0))
            for servo, value in self.servos.of_joints("bus_watchdog").items():
                if value:
                    self.servos.put(servo, "bus_watchdog", 0)
            self._streaming = False

    # ---- small parts ----

    def _servos(self) -> list[int]:
        return [servo for servo in ARM_IDS if servo in self.condition.servos]

    def _mode_of(self, servo: int) -> str:
        return self.mode if servo in JOINTS and self.mode != "mixed" else "position"

    def _refuse_if_stopped(self) -> None:
        if self._stopping.is_set():
            raise Stopped


def port_lost(error: PortLost) -> PortLost:
    """The same, with what it means for the arm."""
    said = str(error).removeprefix(f"{error.port}: ")
    return PortLost(
        error.port,
        f"{said} The arm cannot hear us: it ends its last move by itself and holds there, motors on (the power switch "
        "is the emergency stop). With the plug back in, `robot.bus.reopen()` goes on.",
        error.errno,
    )
