"""The arm on a bus in rad and seconds: set up, command, park. Every rule of safety is applied here and in `keeper`.

All methods may be called from any thread: each transaction holds the bus's lock, and `stop` works while another
thread waits for a motion to end.
"""

import math

from ...arm import GRIPPER_ID, HOME, PARK_SPEED, REST, SLOW, STALL_MA
from ...arrays import as_four
from ...dh import limit_violations
from ...errors import BadInput, BusError, NotReady, TorqueOff
from ..dynamixel import registers as reg
from ..dynamixel import units
from ..safety import Guard
from .monitor import LOOK_S, STREAM_WATCHDOG_S, Keeper, Reading
from .servo_group import JOINTS, MODES, again

LONGEST_S = 32.0  # the profile register ends at 32737 ms
SHORTEST_S = 0.2
RESTING = math.radians(2.0)  # rad/s
#: The longest step (rad) of a stream, from where the arm is: it may lag a little behind.
STREAM_STEP = math.radians(8.0)


class Driver(Keeper):
    """Four joints and a gripper on `bus`, driven within `guard`. Making one reads only; nothing moves."""

    # ---- setting up ----

    def torque_on(self) -> None:
        """Set every servo up and switch it on where it stands: the goal becomes the present position first."""
        self._refuse_if_stopped()
        self._profile_s, self._holding = None, True
        if self.mode == "mixed":
            self.mode = "position"
        for servo in self._servos():
            self.torque = True  # from the first one on
            self.servos.set_up(servo, self._mode_of(servo), on=True)
        self._streaming = False

    def relax(self) -> None:
        """Torque off: **the arm falls**. Support it first, or `park` instead."""
        errors = []
        for call, *args in [(self.leave_stream,), *((self.servos.put, s, "torque_enable", 0) for s in self._servos())]:
            try:
                call(*args)
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
        self._profile_s = None
        before, self.mode = self.mode, "mixed"  # until all are done
        for servo in JOINTS:
            self.servos.set_up(servo, mode, on=self.torque)
        self.mode, self._holding = mode, before == mode and self._holding

    def recover(self) -> list[int]:
        """Reboot each servo that reports a hardware error, and switch on again, where it stands, what has no torque.

        A servo that reboots is limp for half a second: support the arm. Returns the ids of the servos rebooted.
        """
        bits = again(self.bus.read_all, self._servos(), "hardware_error")
        faulty = [servo for servo in bits if bits[servo]]
        for servo in faulty:
            self.bus.reboot(servo)
            self.clock.sleep(0.5)
            self.servos.set_up(servo, self._mode_of(servo), on=True)
        self._profile_s = None
        off = [servo for servo, on in self.servos.of_joints("torque_enable").items() if not on]
        for servo in off if self.torque else ():
            self.servos.set_up(servo, self._mode_of(servo), on=True)
        self.torque = all(self.servos.of_joints("torque_enable").values())
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
        ticks = {servo: units.POSITION.raw(angle) for servo, angle in zip(JOINTS, goal, strict=True)}
        self._check_settings()
        try:
            with self._sending:
                self._refuse_if_stopped()
                self._holding = False
                self.leave_stream()
                self._set_profile(seconds)
                self._arrival = self.clock.now() + seconds
                self.servos.send(ticks)
        except BaseException:  # an interrupt too: it may have set off
            self.halt()
            raise
        return tuple(units.POSITION.value(tick) for tick in ticks.values()), seconds

    def _check_settings(self) -> None:
        """Is every joint still as we set it up? After a restart, or another program, a goal would mean full speed."""
        self._check_torque()
        wanted = (reg.DRIVE_TIME_BASED, reg.MODES["position"])
        found = again(self.bus.read_block, JOINTS, MODES)
        wrong = [
            f"servo {servo} has drive mode {got[0]} and operating mode {got[1]} instead of {wanted[0]} and "
            f"{wanted[1]}, so goals would not take the time given: `robot.write_motor_state(True)` sets it up"
            for servo, got in found.items()
            if got != wanted
        ]
        if wrong:
            raise NotReady(self.bus.name, wrong)
        self._profile_s = None

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
        if not self._streaming:
            self._check_settings()
        ticks = {servo: units.POSITION.raw(angle) for servo, angle in zip(JOINTS, goal, strict=True)}
        with self._sending:
            self._refuse_if_stopped()
            self._holding = False
            self._stream()
            self._set_profile(seconds)
            self.bus.write_all("goal_position", ticks)
            self._arrival = self.clock.now() + seconds
        return reading

    def wait(self, patience_s: float = 1.0) -> Reading:
        """Wait until the motion has ended, watching the arm; returns the last reading.

        An interrupt, or any error, makes the arm hold. Raises what `watch` raises.
        """
        try:
            while True:
                reading = self.watch()
                late = self.clock.now() - self._arrival
                if late >= 0 and (max(map(abs, reading.speed)) < RESTING or late > patience_s):
                    self.leave_stream()
                    return reading
                self.clock.sleep(LOOK_S)
        except BaseException:
            self.halt()
            raise

    def velocities(self, speeds) -> tuple[float, ...]:
        """Turn the joints at `speeds` (rad/s) in velocity mode, for at most `STREAM_WATCHDOG_S` unless repeated."""
        self._ready("velocity")
        speeds = as_four(speeds, "velocities", "four numbers, one a joint")
        fastest = max(map(abs, speeds))
        if fastest > self.guard.speed_cap * (1 + 1e-9):
            raise BadInput(
                f"`velocities` may be at most {math.degrees(self.guard.speed_cap):.0f} deg/s; "
                f"got {math.degrees(fastest):.0f}."
            )
        q = self.watch().q
        self.guard.check([a + v * STREAM_WATCHDOG_S for a, v in zip(q, speeds, strict=True)], q)
        raw = {servo: units.VELOCITY.raw(v) for servo, v in zip(JOINTS, speeds, strict=True)}
        self._send_stream("goal_velocity", raw)
        return tuple(units.VELOCITY.value(value) for value in raw.values())

    def currents(self, milliamps) -> tuple[float, ...]:
        """Push with `milliamps` in current mode, for at most `STREAM_WATCHDOG_S` unless repeated."""
        self._ready("current")
        milliamps = as_four(milliamps, "currents", "four numbers, one a joint")
        if max(map(abs, milliamps)) > STALL_MA:
            raise BadInput(f"`currents` may be at most {STALL_MA:.0f} mA; got {max(map(abs, milliamps)):.0f}.")
        self.guard.check(self.watch().q)
        raw = {servo: units.CURRENT.raw(mA) for servo, mA in zip(JOINTS, milliamps, strict=True)}
        self._send_stream("goal_current", raw)
        return tuple(units.CURRENT.value(value) for value in raw.values())

    def _send_stream(self, name: str, raw: dict[int, int]) -> None:
        with self._sending:
            self._refuse_if_stopped()
            self._holding = False
            self._stream()
            self.bus.write_all(name, raw)

    def park(self) -> None:
        """Slowly to the rest pose, then torque off. If the way is blocked the arm stays, torque on, and says why."""
        if not self.torque:
            return
        self.resume()
        if self.mode != "position":
            self.hold()
        for goal in (HOME, REST):
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
        servo = GRIPPER_ID
        if self.torque and not self.servos.get(servo, "torque_enable"):
            self._gripper_off()
        self.servos.slow(servo, seconds)
        self.servos.put(servo, "goal_position", units.POSITION.raw(self._gripper_sense() * servo_angle))

    def _gripper_off(self) -> None:
        again(self.bus.check_hardware, [GRIPPER_ID])
        self._restarted([GRIPPER_ID])

    def gripper(self) -> float:
        """The angle of the gripper's servo (rad; negative is open)."""
        raw = self.servos.get(GRIPPER_ID, "present_position")
        return self._gripper_sense() * units.POSITION.value(raw)

    def _gripper_sense(self) -> int:
        return -1 if self.servos.get(GRIPPER_ID, "drive_mode") & reg.DRIVE_REVERSE else 1

    # ---- small parts ----

    def _ready(self, mode: str) -> None:
        self._refuse_if_stopped()
        if not self.torque:
            raise TorqueOff
        if self.mode != mode:
            raise BadInput(f"the joints are in {self.mode} mode; `robot.write_mode({mode!r})` changes that.")

    def _set_profile(self, seconds: float) -> None:
        if seconds != self._profile_s:
            self.servos.slow_all(seconds)
            self._profile_s = seconds
