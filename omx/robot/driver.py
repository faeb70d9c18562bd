"""The arm on a bus in rad and seconds: set up, command, watch, hold, park. Every rule of safety is applied here.

All methods may be called from any thread: each transaction holds the bus's lock, and `stop` works while another
thread waits for a motion to end.
"""

import contextlib
import math
import threading
from typing import NamedTuple

from ..arrays import as_rows
from ..dh import limit_violations
from ..dynamixel import registers as reg
from ..dynamixel import units
from ..dynamixel.bus import Bus
from ..errors import BadInput, BusCorrupt, BusError, BusTimeout, OmxError, ServoRefused
from ..safety import Guard, stalled
from .connect import Condition, NotReady, judge, look_over

#: Where the arm lies when it is parked, folded together: least to fall when the torque goes off. Check it on yours.
REST = (0.0, -1.45, 1.32, 0.2)
#: The poses on the way to REST, so that the hand comes down from above.
APPROACH = (0.0, -1.05, 0.35, 0.7)

LONGEST_S = 32.0  # the profile register ends at 32737 ms
SHORTEST_S = 0.2
HOLD_S = 0.2
#: A joint that is farther (ticks) from its own set-point than this is being held up by something.
HOLD_SLACK = units.ANGLE.raw(math.radians(3.0))
PARK_SPEED = math.radians(30.0)
SLOW = math.radians(10.0)
LOOK_S = 0.02
STALL_S = 0.15
STALL_MA = 500.0
HEALTH_S = 1.0
RESTING = math.radians(2.0)  # rad/s
STREAM_WATCHDOG_S = 0.4
#: The longest step (rad) of a stream, from where the arm is: it may lag a little behind.
STREAM_STEP = math.radians(8.0)

_PROFILE = reg.block("profile_acceleration", "profile_velocity")
_HEALTH = reg.block("present_voltage", "present_temperature")
_JOINTS = reg.JOINT_IDS


class Stopped(OmxError):
    """The stop button was pressed; the arm holds. `resume()` allows commands again."""


class TorqueOff(OmxError):
    """The motors are off, so there is nothing to command."""


class Stalled(OmxError):
    """A joint pushes and does not move. `joint` is 1 .. 4, `current` in mA; the arm holds."""

    def __init__(self, joint: int, current: float):
        self.joint, self.current = joint, current
        super().__init__(
            f"joint {joint} is pushing on something ({abs(current):.0f} mA) and does not move. The arm holds. "
            "Take away what is in its way, then move on."
        )


class Reading(NamedTuple):
    """One look at the joints: angles (rad), speeds (rad/s), currents (mA)."""

    q: tuple[float, ...]
    speed: tuple[float, ...]
    current: tuple[float, ...]


class Driver:
    """Four joints and a gripper on `bus`, driven within `guard`. Making one reads only; nothing moves."""

    def __init__(self, bus: Bus, guard: Guard | None = None):
        self.bus, self.guard, self.clock = bus, guard or Guard(), bus.clock
        self.condition: Condition = look_over(bus)
        if self.condition.problems:
            raise NotReady(bus.name, self.condition.problems)
        self.mode = "position"
        self._profile_s: float | None = None
        self._arrival = self.clock.now()
        self._stopping = threading.Event()
        self._stall_since: dict[int, float] = {}
        self._health_at = self.clock.now()
        self._streaming = False
        self.torque = all(bus.read_all(_JOINTS, "torque_enable").values())
        if self.torque:
            self.mode = _mode_name(bus.read(_JOINTS[0], "operating_mode"))

    # ---- looking ----

    def read(self) -> Reading:
        """Angles, speeds and currents of the four joints, in one transaction. Raises what is wrong with them."""
        try:
            block = self.bus.read_block(_JOINTS)
        except (BusTimeout, BusCorrupt):  # once in a while an answer is lost: reading again does no harm
            block = self.bus.read_block(_JOINTS)
        current, speed, q = zip(*(block[servo] for servo in _JOINTS), strict=True)
        reading = Reading(
            tuple(units.POSITION.value(raw) for raw in q),
            tuple(units.VELOCITY.value(raw) for raw in speed),
            tuple(units.CURRENT.value(raw) for raw in current),
        )
        if self.bus.alerts & set(_JOINTS):
            self._fault()
        return reading

    def watch(self) -> Reading:
        """`read`, and hold with a reason if a joint stalls, is too hot or has too little voltage, or stop was hit."""
        reading = self.read()
        if self._stopping.is_set():
            raise Stopped("stopped: the arm holds. `robot.resume()` allows commands again.")
        self._check_stall(reading)
        self._check_health()
        return reading

    def _check_stall(self, reading: Reading) -> None:
        now, stuck = self.clock.now(), set(stalled(reading.current, reading.speed, STALL_MA))
        self._stall_since = {joint: self._stall_since.get(joint, now) for joint in stuck}
        for joint, since in self._stall_since.items():
            if now - since >= STALL_S:
                self._stall_since = {}
                self.hold()
                raise Stalled(joint, reading.current[joint - 1])

    def _check_health(self) -> None:
        if self.clock.now() < self._health_at:
            return
        self._health_at = self.clock.now() + HEALTH_S
        condition = Condition()
        for servo, (volts, degrees) in self.bus.read_block(_JOINTS, _HEALTH).items():
            judge(servo, units.VOLTAGE.value(volts), degrees, condition)
            self.condition.volts[servo], self.condition.degrees[servo] = units.VOLTAGE.value(volts), degrees
        if condition.problems:
            self.hold()
            raise NotReady(f"{self.bus.name} holds: the arm", condition.problems)

    def _fault(self) -> None:
        """A servo has its alert bit set: the others hold, and the reason is raised."""
        with contextlib.suppress(BusError):
            self.hold()
        self.torque = False
        self.bus.check_hardware(_JOINTS)

    # ---- setting up ----

    def torque_on(self) -> None:
        """Set every servo up and switch it on where it stands: the goal becomes the present position first."""
        self._refuse_if_stopped()
        for servo in self._servos():
            self._set_up(servo, self.mode if servo in _JOINTS else "position", on=True)
        self._profile_s = None
        self.torque = True

    def relax(self) -> None:
        """Torque off: **the arm falls**. Support it first, or `park` instead."""
        self.leave_stream()
        errors = []
        for servo in self._servos():
            try:
                self.bus.write(servo, "torque_enable", 0)
            except BusError as error:
                errors.append(error)
        self.torque = False
        if errors:
            raise errors[0]

    def set_mode(self, mode: str) -> None:
        """Put the joints into "position", "velocity" or "current" mode, one servo after the other, torque kept."""
        if mode not in ("position", "velocity", "current"):
            raise BadInput(f"`mode` must be 'position', 'velocity' or 'current'; got {mode!r}.")
        self._refuse_if_stopped()
        self.leave_stream()
        for servo in _JOINTS:
            self._set_up(servo, mode, on=self.torque)
        self.mode, self._profile_s = mode, None

    def _set_up(self, servo: int, mode: str, on: bool) -> None:
        """Drive mode, operating mode, both read back; profile; goal := present; torque. In this order.

        Drive and operating mode live in the EEPROM, which is locked while the torque is on. Only if one of them is
        wrong does the torque go off, for some milliseconds and one servo at a time.
        """
        bus, number = self.bus, reg.MODES[mode]
        drive = bus.read(servo, "drive_mode")
        reverse = drive & reg.DRIVE_REVERSE if servo == reg.GRIPPER_ID else 0
        wanted = {"drive_mode": reg.DRIVE_TIME_BASED | reverse, "operating_mode": number}
        if drive != wanted["drive_mode"] or bus.read(servo, "operating_mode") != number:
            bus.write(servo, "torque_enable", 0)
            for name, value in wanted.items():
                bus.write(servo, name, value)
                if bus.read(servo, name) != value:
                    raise ServoRefused(bus.name, f"take {name} = {value}", servo, 0, "it reads back another value")
        if bus.read(servo, "bus_watchdog"):
            bus.write(servo, "bus_watchdog", 0)
        bus.write(servo, "profile_velocity", _milliseconds(HOLD_S))
        bus.write(servo, "profile_acceleration", _milliseconds(HOLD_S) // 4)
        if mode == "position" and not bus.read(servo, "torque_enable"):
            present = bus.read(servo, "present_position")
            low, high = bus.read(servo, "min_position_limit"), bus.read(servo, "max_position_limit")
            bus.write(servo, "goal_position", min(max(present, low), high))
        if on:
            bus.write(servo, "torque_enable", 1)

    def recover(self) -> list[int]:
        """Reboot each servo that reports a hardware error, and switch it on again where it stands. Their ids."""
        faulty = [servo for servo, bits in self.bus.read_all(self._servos(), "hardware_error").items() if bits]
        for servo in faulty:
            self.bus.reboot(servo)
            self.clock.sleep(0.5)
            self._set_up(servo, self.mode if servo in _JOINTS else "position", on=True)
        self._profile_s = None
        self.torque = all(self.bus.read_all(_JOINTS, "torque_enable").values())
        return faulty

    # ---- moving ----

    def command(self, q, seconds: float | None = None) -> tuple[tuple[float, ...], float]:
        """Send the joints to `q` (rad) in `seconds`; returns what was sent (rounded to ticks) and the seconds.

        Without `seconds`, as fast as the speed cap allows. Raises `JointLimit`, `Collision`, `TooFast`, `TorqueOff`,
        `Stopped`; then nothing was sent. Does not wait.
        """
        self._ready("position")
        present = self.watch().q
        inside = not self.guard_violations(present)
        goal = self.guard.check(q, present)
        slowest = self.guard if inside else Guard(**{**vars(self.guard), "speed_cap": SLOW})
        seconds = max(slowest.seconds(present, goal, seconds), SHORTEST_S)
        if seconds > LONGEST_S:
            raise BadInput(f"`seconds` must be at most {LONGEST_S:.0f}, the longest profile of a servo; got {seconds}.")
        self._set_profile(seconds)
        ticks = {servo: units.POSITION.raw(angle) for servo, angle in zip(_JOINTS, goal, strict=True)}
        self.bus.write_all("goal_position", ticks)
        self._arrival = self.clock.now() + seconds
        return tuple(units.POSITION.value(tick) for tick in ticks.values()), seconds

    def guard_violations(self, q) -> tuple:
        """The joints of `q` outside the guard's hard limits."""
        return limit_violations(q, self.guard.limits)

    def stream_to(self, q, seconds: float) -> Reading:
        """One small step of a stream: the joints are to be at `q` (rad) in `seconds`. Returns where they are now.

        The servos' watchdog is armed: if the stream breaks off, they stop by themselves. A step longer than the speed
        cap allows is refused.
        """
        self._ready("position")
        reading = self.watch()
        goal = self.guard.check(q, reading.q)
        far = max(abs(a - b) for a, b in zip(goal, reading.q, strict=True))
        if far > STREAM_STEP:
            raise BadInput(f"the next point of the stream is {math.degrees(far):.1f} deg away; `move_to` it first.")
        self._set_profile(seconds)
        self._stream()
        ticks = {servo: units.POSITION.raw(angle) for servo, angle in zip(_JOINTS, goal, strict=True)}
        self.bus.write_all("goal_position", ticks)
        self._arrival = self.clock.now() + seconds
        return reading

    def wait(self, patience_s: float = 1.0) -> Reading:
        """Wait until the motion has ended, watching the arm; returns the last reading.

        An interrupt makes the arm hold. Raises what `watch` raises.
        """
        try:
            while True:
                reading = self.watch()
                late = self.clock.now() - self._arrival
                if late >= 0 and (max(map(abs, reading.speed)) < RESTING or late > patience_s):
                    self.leave_stream()
                    return reading
                self.clock.sleep(LOOK_S)
        except KeyboardInterrupt:
            self.hold()
            raise

    @property
    def moving(self) -> bool:
        """Is a commanded motion still under way, by its time?"""
        return self.clock.now() < self._arrival

    def velocities(self, speeds) -> tuple[float, ...]:
        """Turn the joints at `speeds` (rad/s) in velocity mode, for at most `STREAM_WATCHDOG_S` unless repeated."""
        self._ready("velocity")
        speeds = _four(speeds, "velocities")
        fastest = max(map(abs, speeds))
        if fastest > self.guard.speed_cap * (1 + 1e-9):
            raise BadInput(
                f"`velocities` may be at most {math.degrees(self.guard.speed_cap):.0f} deg/s; "
                f"got {math.degrees(fastest):.0f}."
            )
        q = self.watch().q
        self.guard.check([a + v * STREAM_WATCHDOG_S for a, v in zip(q, speeds, strict=True)], q)
        self._stream()
        raw = {servo: units.VELOCITY.raw(v) for servo, v in zip(_JOINTS, speeds, strict=True)}
        self.bus.write_all("goal_velocity", raw)
        return tuple(units.VELOCITY.value(value) for value in raw.values())

    def currents(self, milliamps) -> tuple[float, ...]:
        """Push with `milliamps` in current mode, for at most `STREAM_WATCHDOG_S` unless repeated."""
        self._ready("current")
        milliamps = _four(milliamps, "currents")
        if max(map(abs, milliamps)) > STALL_MA:
            raise BadInput(f"`currents` may be at most {STALL_MA:.0f} mA; got {max(map(abs, milliamps)):.0f}.")
        self.guard.check(self.watch().q)
        self._stream()
        raw = {servo: units.CURRENT.raw(mA) for servo, mA in zip(_JOINTS, milliamps, strict=True)}
        self.bus.write_all("goal_current", raw)
        return tuple(units.CURRENT.value(value) for value in raw.values())

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
        self.leave_stream()
        self._arrival = self.clock.now() + HOLD_S
        self._profile_s = None
        failed = None
        for servo in _JOINTS:
            try:
                self._hold_one(servo)
            except BusError as error:
                failed = failed or error
        if self.mode != "position" and failed is None:
            self.mode = "position"
        if failed:
            raise failed

    def _hold_one(self, servo: int) -> None:
        if self.mode != "position":
            self._set_up(servo, "position", on=True)
            return
        present, aim = self.bus.read(servo, "present_position"), self.bus.read(servo, "position_trajectory")
        if abs(aim - present) <= HOLD_SLACK:  # holding what it aims at, the arm does not sag a little more each time
            present = aim
        self.bus.write(servo, "profile_acceleration", 0)
        self.bus.write(servo, "profile_velocity", _milliseconds(HOLD_S))
        low, high = self.bus.read(servo, "min_position_limit"), self.bus.read(servo, "max_position_limit")
        self.bus.write(servo, "goal_position", min(max(present, low), high))

    def park(self) -> None:
        """Slowly to the rest pose, then torque off. If the way is blocked the arm stays, torque on, and says why."""
        if not self.torque:
            return
        self.resume()
        if self.mode != "position":
            self.set_mode("position")
        for goal in (APPROACH, REST):
            q = self.read().q
            far = max(abs(a - b) for a, b in zip(q, goal, strict=True))
            self.command(goal, max(far / PARK_SPEED, 0.5))
            self.wait()
        self.relax()

    # ---- gripper ----

    def grip(self, servo_angle: float, seconds: float = 0.7) -> None:
        """Turn the gripper's servo to `servo_angle` (rad; negative opens), whichever way its drive mode counts."""
        self._refuse_if_stopped()
        if not self.condition.has_gripper:
            raise NotReady(self.bus.name, ["no gripper: servo 15 does not answer"])
        servo = reg.GRIPPER_ID
        self.bus.write(servo, "profile_acceleration", 0)
        self.bus.write(servo, "profile_velocity", _milliseconds(seconds))
        self.bus.write(servo, "profile_acceleration", _milliseconds(seconds) // 4)
        self.bus.write(servo, "goal_position", units.POSITION.raw(self._gripper_sense() * servo_angle))

    def gripper(self) -> float:
        """The angle of the gripper's servo (rad; negative is open)."""
        raw = self.bus.read(reg.GRIPPER_ID, "present_position")
        return self._gripper_sense() * units.POSITION.value(raw)

    def _gripper_sense(self) -> int:
        return -1 if self.bus.read(reg.GRIPPER_ID, "drive_mode") & reg.DRIVE_REVERSE else 1

    # ---- small parts ----

    def _servos(self) -> list[int]:
        return [servo for servo in reg.ARM_IDS if servo in self.condition.servos]

    def _ready(self, mode: str) -> None:
        self._refuse_if_stopped()
        if not self.torque:
            raise TorqueOff(
                "the motors are off. `robot.write_motor_state(True)` switches them on where the arm stands."
            )
        if self.mode != mode:
            raise BadInput(f"the joints are in {self.mode} mode; `robot.write_mode({mode!r})` changes that.")

    def _refuse_if_stopped(self) -> None:
        if self._stopping.is_set():
            raise Stopped("stopped: the arm holds. `robot.resume()` allows commands again.")

    def _set_profile(self, seconds: float) -> None:
        """The servos' own motion profile, a trapezoid with a quarter of the time at either end; read back."""
        if seconds == self._profile_s:
            return
        total = _milliseconds(seconds)
        for name, value in (
            ("profile_acceleration", 0),
            ("profile_velocity", total),
            ("profile_acceleration", total // 4),
        ):
            self.bus.write_all(name, dict.fromkeys(_JOINTS, value))
        for servo, found in self.bus.read_block(_JOINTS, _PROFILE).items():
            if found != (total // 4, total):
                raise ServoRefused(self.bus.name, "take its motion profile", servo, 0, f"it reads back {found}")
        self._profile_s = seconds

    def _stream(self) -> None:
        """Arm the servos' own watchdog: without another command they stop by themselves."""
        if not self._streaming:
            self.bus.write_all("bus_watchdog", dict.fromkeys(_JOINTS, units.WATCHDOG.raw(STREAM_WATCHDOG_S)))
            self._streaming = True

    def leave_stream(self) -> None:
        """Disarm the watchdog again; a watchdog that has tripped is cleared."""
        if self._streaming:
            self._streaming = False
            self.bus.write_all("bus_watchdog", dict.fromkeys(_JOINTS, 0))


def _milliseconds(seconds: float) -> int:
    return units.MILLISECONDS.raw(seconds)


def _mode_name(number: int) -> str:
    return next((name for name, value in reg.MODES.items() if value == number), "position")


def _four(values, name: str) -> tuple[float, ...]:
    row = as_rows(values, name, 4, "four numbers, one a joint")
    if row.ndim != 1:
        raise BadInput(f"`{name}` must be four numbers; got shape {row.shape}.")
    return tuple(row.tolist())
