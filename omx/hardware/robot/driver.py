"""The arm on a bus in rad and seconds: set up, command, park.

All methods may be called from any thread: each transaction holds the bus's lock, and `stop` works while another
thread waits for a motion to end. Whatever sends a goal passes `send`, the last gate.
"""

import contextlib
import logging
import math
import threading
from dataclasses import replace

from ...arm import ARRIVED, GRIP_FORCE, GRIPPER_ID, IDLE_S, JOINT_IDS, PARK_SPEED, STALL_TORQUE
from ...arrays import as_number
from ...errors import (
    BadInput,
    BusCorrupt,
    BusError,
    BusTimeout,
    NotArrived,
    NotReady,
    ObjectLost,
    OmxError,
    PortLost,
    Stalled,
    Stopped,
    TorqueOff,
)
from ..dynamixel import registers as reg
from ..dynamixel import units
from ..dynamixel.bus import Bus, again, for_each
from ..fault_table import judge, registers
from ..safety import RAMP, Guard
from . import move_rules, rescue
from .brake import Brake
from .discovery import look_over
from .gripper import Grip, Gripper
from .monitor import Monitor, Reading, Watch
from .push_by_current import Pushing
from .servo_group import HOLD_SLACK, JOINTS, RESTING, Servos

_log = logging.getLogger("omx.robot")
#: Somebody wants the arm to stand, and its fingers.
_STOPS = (KeyboardInterrupt, Stopped)


class Driver:
    """Four joints and a gripper on `bus`, driven within `guard`. Making one reads only; nothing moves.

    `idle_s`: after so long without a command an arm that holds parks itself; None: never. `offsets` (rad): added to
    what the joints read, and taken off what they are sent, so that all angles are the arm's own.
    """

    def __init__(
        self, bus: Bus, guard: Guard | None = None, *, idle_s: float | None = IDLE_S, offsets=(0.0, 0.0, 0.0, 0.0)
    ):
        if idle_s is not None:
            as_number(idle_s, "idle_s", "at least 0.001 s, or None for never", 1e-3, math.inf)
        self.bus, self.guard, self.clock = bus, guard or Guard(), bus.clock
        self.condition = look_over(bus)
        self.servos = Servos(bus, self.condition.registers, self._pwm(), self.guard.payload_g)
        self.monitor = Monitor(bus, offsets, self.condition.found)
        self.brake = Brake(self.servos, self.monitor)
        self.gripper = Gripper(self.servos)
        self.push = Pushing(self.servos, self.monitor, self.brake)
        self.streamed: tuple[float, ...] | None = None  # the last point of a stream
        self.commanding = threading.RLock()  # from the look at the arm to the goal: two threads must not mix theirs
        self.mode = "position"
        self.torque = any(self.condition.registers[servo]["torque_enable"] for servo in JOINT_IDS)
        self.watcher = Watch(self, idle_s)
        if self.torque:
            bus.refuse_if_read_only("look after its motors, which another program has left on; support the arm and "
                                    "switch its power off")  # fmt: skip
            self.servos.stiffen()  # it may be turning, and our own questions would feed its watchdog
            self.watcher.begin()

    # ---- setting up ----

    def _pwm(self) -> dict[int, int]:
        """How much of its power (raw) each joint may use."""
        push = round(self.guard.push() / STALL_TORQUE * reg.REGISTERS["goal_pwm"].high)
        return {servo: min(push, self.condition.registers[servo]["pwm_limit"]) for servo in JOINT_IDS}

    def carry(self, payload_g: float, payload_mm: float = 0.0) -> None:
        """From now on the gripper carries `payload_g` (g): joints may push so much harder, and not stretch as far.

        What reaches `payload_mm` from the tool must stay clear of table and arm, too.
        """
        self.guard = replace(self.guard, payload_g=payload_g, payload_mm=payload_mm)
        self.servos.pwm, self.servos.payload_g = self._pwm(), payload_g
        if self.torque:
            self.servos.put_all(reg.block("goal_pwm"), {servo: (most,) for servo, most in self.servos.pwm.items()})

    def torque_on(self) -> None:
        """Set every servo up and switch it on where it stands: a limp joint's goal is first what holds it there."""
        self.bus.refuse_if_read_only("switch its motors on")
        self.brake.refuse_if_latched()
        with self.watcher.alone():
            self.halt()  # a joint that lags behind, on less power than it is about to get, would leap
            self.torque = True  # from the first one on
            self.watcher.troubles.clear()
            self.brake.holding, self.mode, self.streamed = True, "position", None
            self.servos.switch_on(self.servos.ids)
        for one in self.condition.found:
            if one.mended and one.level != "note":
                _log.warning("set back: %s.", one.symptom)
        self.condition.found.clear()
        self.watcher.begin()

    def relax(self) -> None:
        """Torque off: **the arm falls**. Support it first, or `park` instead."""
        with self.watcher.alone():
            for_each(self.servos.ids, lambda servo: self.servos.put(servo, "torque_enable", 0))
            self.torque, self.streamed = False, None
            self.push.joints.clear()

    def recover(self) -> list[int]:
        """Reboot each servo that reports a hardware error, and switch on again, where it stands, what has no torque.

        A servo that reboots is limp for half a second: support the arm. Returns the ids of the servos rebooted.
        """
        self.bus.refuse_if_read_only("restart a servo")
        with self.watcher.alone():
            faulty = rescue.recover(self.servos, self.torque)
            self.torque = any(self.servos.of_joints("torque_enable").values())
            self.watcher.troubles.clear()
        self.watcher.begin()
        return faulty

    # ---- looking ----

    def read(self) -> Reading:
        """Angles, speeds and currents of the joints. Every read watches: it holds the arm, and raises what is wrong."""
        self.watcher.ask()
        reading = self.glance()
        self.watcher.ask()  # it may have looked meanwhile
        return reading

    def watch(self) -> Reading:
        """`read`, for somebody who waits for the arm: raises `Stopped`, too."""
        self.watcher.asked()
        reading = self.read()
        self.brake.refuse_if_latched()
        return reading

    def glance(self) -> Reading:
        """What `read` does, also for the watch."""
        with self._rescuing():
            try:
                reading = self.monitor.look()
            except PortLost as error:
                if not self.torque:
                    raise
                raise rescue.port_lost(error) from error
            if self.bus.alerts.intersection(JOINTS):
                self._fault()
            if self.torque:
                self._judge(reading)
        return reading

    def _judge(self, reading: Reading) -> None:
        wrong = self.monitor.stall(reading, self.guard.payload_g)
        if self.push and not wrong:
            if self.clock.now() >= self.push.until:  # nobody has repeated it
                self.halt()
            else:
                wrong = self.push.forecast(reading, {}, self.guard)
        if not wrong and self.monitor.health_is_due():
            wrong = self._health()
        if wrong:
            self.halt()
            if isinstance(wrong, Stalled):
                self.brake.latch(f"joint {wrong.joint} pushed on something")
            raise wrong

    def _health(self) -> NotReady | ObjectLost | None:
        wrong = self.monitor.health() or self.gripper.lost()
        if self.watcher.folding and isinstance(wrong, NotReady):  # the motors are about to go off, which helps best
            wrong = None
        self.watcher.hot = isinstance(wrong, NotReady)
        if not wrong:
            self._check_torque()
        return wrong

    def _check_torque(self) -> None:
        """A motor that is off although we switched it on: an error, or a restart that nobody noticed."""
        with self.watcher.alone():
            if self.torque and (off := rescue.off(self.servos)):
                self._fault()
                rescue.catch(self.servos, off)

    def _check_fingers(self) -> None:
        """The same for the gripper's motor."""
        with self.watcher.alone():
            if not self.torque:
                raise TorqueOff
            if not self.servos.get(GRIPPER_ID, "torque_enable"):
                again(self.bus.check_hardware, [GRIPPER_ID])
                rescue.catch(self.servos, [GRIPPER_ID])

    # ---- when something is wrong ----

    @contextlib.contextmanager
    def _rescuing(self):
        """Who does not answer in here, whatever the question, is waited for, and caught if it comes back limp."""
        try:
            yield
        except (BusTimeout, BusCorrupt) as error:
            self._silence(error)
            raise

    def _fault(self) -> None:
        """A servo has its alert bit set, or no torque: the others hold, and the hardware error is raised."""
        self.halt()
        again(self.bus.check_hardware, JOINTS)

    def _silence(self, error: BusError) -> None:
        """Someone did not answer twice: the others hold, and whoever is back after a restart is caught."""
        self.halt()
        if self.torque:
            with self.watcher.alone():
                rescue.find(self.servos, error)
            self._check_torque()

    # ---- stopping ----

    def stop(self) -> None:
        """Hold at once, fingers too, and refuse every command until `resume`. May be called from another thread."""
        self.brake.latch()
        with self._rescuing():
            try:
                self.stand()
            finally:  # before anybody who does not answer is waited for
                self._still_fingers()
            self.stiffen()
        self.mode = "position"

    def _still_fingers(self) -> None:
        if self.torque:
            with contextlib.suppress(OmxError):
                self.gripper.stand()

    def resume(self) -> None:
        """Allow commands again after a stop, a stall or an interrupt."""
        self.watcher.troubles.clear()
        self.brake.resume()

    def hold(self) -> None:
        """Stop where the arm is, torque on, in position mode. Does what it can, then raises what failed."""
        with self._rescuing():
            self.stand()
            self.stiffen()
        self.mode = "position"

    def stand(self) -> None:
        """Stop where the arm is, in whatever mode it is; it may push again from there."""
        if self.torque:
            self.push.until = self.clock.now()  # if this fails, the watch tries again
            self.brake.hold()
            self.push.joints.clear()

    def stiffen(self) -> None:
        """Back into position mode, joint by joint."""
        if self.servos.soft:
            with self.watcher.alone():
                if self.torque:  # another thread may have switched them off meanwhile
                    self.servos.stiffen()

    def soften(self, servos) -> None:
        """One of the `servos` after the other into the mode with limited current, each holding as it did."""
        self.come_to_rest()
        with self.watcher.alone():
            if not self.torque:
                raise TorqueOff
            self.servos.soften(servos)

    def halt(self) -> None:
        """Hold on our own account, once; what fails then does not hide the reason for it."""
        if self.torque and (self.push or not self.brake.holding):
            with contextlib.suppress(OmxError):
                self.stand()

    def broken_off(self, error: BaseException | None) -> None:
        """Something ended early: hold. An interrupt is a stop: somebody wanted the arm to stand."""
        if isinstance(error, KeyboardInterrupt):
            self.brake.latch("interrupted")
        self.halt()
        if isinstance(error, _STOPS):
            self._still_fingers()
        if isinstance(error, (BusTimeout, BusCorrupt)):
            with contextlib.suppress(OmxError):
                self._silence(error)

    @contextlib.contextmanager
    def unbroken(self, by=BaseException):
        """Whatever ends early in here, `by` an error or an interrupt, makes the arm hold."""
        try:
            yield
        except by as error:
            self.broken_off(error)
            raise

    @property
    def stopped(self) -> str | None:
        """Why commands are refused, in a few words; None if they are not."""
        return self.brake.why

    @property
    def moving(self) -> bool:
        """Is a commanded motion still under way, by its time?"""
        return self.brake.moving or bool(self.push)

    # ---- moving ----

    def command(self, q, seconds: float | None = None) -> tuple[float, ...]:
        """Send the joints to `q` (rad) in `seconds`; returns what was sent, rounded to ticks.

        Without `seconds`, as fast as the speed cap allows; from outside the limits slowly, whatever `seconds` say. An
        arm that moves is brought to rest first. Raises `JointLimit`, `Collision`, `TooFast`, `TorqueOff`, `Stopped`;
        then nothing was sent. Does not wait.
        """
        with self.commanding:
            self.ready("position")
            return self._move(q, seconds, self.guard.speed_cap)

    def _move(self, q, seconds: float | None, cap: float) -> tuple[float, ...]:
        present = self.watch().q
        goal = self.guard.check(q, present)
        asked = move_rules.seconds(self.guard, present, goal, seconds, cap)
        self.check_settings()
        start = self.come_to_rest()
        goal = self.guard.check(goal, start)
        took = max(asked, move_rules.seconds(self.guard, start, goal, None, cap))
        if seconds is not None and took > seconds and (outside := move_rules.outside(self.guard, start)):
            joints = ", ".join(map(str, outside))
            _log.warning("%s: the way back in takes %.1f s instead of %.1f s.", joints, took, seconds)
        return self.send(goal, took, RAMP)

    def come_to_rest(self) -> tuple[float, ...]:
        """Where the joints' set-points stand (rad), once they do: a servo takes its old speed into a new motion."""
        slack = units.ANGLE.value(HOLD_SLACK)
        for _ in range(round(1.0 / rescue.LOOK_S)):  # not a second: it may pass between two looks
            reading = self.watch()
            gaps = (abs(a - b) for a, b in zip(reading.aim, reading.q, strict=True))
            runs = any(reading.aim_speed) or max(gaps) > slack or self.moving
            if not (self.torque and runs):
                break
            if not (self.brake.holding and self.brake.moving):
                self.stand()
            self.clock.sleep(rescue.LOOK_S)
        return reading.aim if self.torque else reading.q

    def send(self, goal, seconds: float, ramp: float, confirmed: bool = True) -> tuple[float, ...]:
        """The last gate: nothing comes after a stop. Returns the goal in whole ticks."""
        offsets = self.monitor.offsets
        readings = [angle - offset for angle, offset in zip(goal, offsets, strict=True)]
        ticks = {servo: units.POSITION.raw(angle) for servo, angle in zip(JOINTS, readings, strict=True)}
        with self.unbroken(), self.brake.lock:
            self.brake.refuse_if_stopped_since(self.brake.began)
            self.watcher.ask()
            self.brake.sets_off(seconds)
            self.servos.send(ticks, seconds, ramp, confirmed)
            self.brake.sets_off(seconds)  # the program may have been held up in between
            self.brake.refuse_if_stopped_since(self.brake.began)  # a signal's handler comes in spite of the lock
        self.watcher.begin()
        return tuple(units.POSITION.value(ticks[servo]) + a for servo, a in zip(JOINTS, offsets, strict=True))

    def check_settings(self) -> None:
        """Raise what became of the servos since they were set up: no torque, other modes."""
        self._check_torque()
        rescue.check_settings(self.servos)

    def stream_to(self, q, seconds: float) -> Reading:
        """One small step of a stream: the joints are to be at `q` (rad) in `seconds`. Returns where they were.

        The set-points run straight to `q` and stand there: if the stream breaks off, nothing goes further. A step
        that is longer than the speed cap allows is refused; one that has to catch up takes its time.
        """
        with self.commanding:
            self.ready("position")
            reading = self.watch()
            goal = self.guard.check(q, reading.q, reading.aim)
            if self.streamed is None or not self.brake.moving:
                self.check_settings()
                self.streamed = None
            took = move_rules.step_seconds(self.guard, reading, self.streamed, goal, seconds)
            self.send(goal, took, ramp=0.0, confirmed=False)
            self.streamed = goal
            return reading

    def wait(self, patience_s: float = 1.0) -> Reading:
        """Wait until the motion has ended, watching the arm; returns the last reading.

        An interrupt, or any error, makes the arm hold. Raises what `watch` raises.
        """
        began = self.brake.began
        with self.unbroken():
            while True:
                late = self.clock.now() - self.brake.arrival  # before the look, which may be held up
                reading = self.watch()
                self.brake.refuse_if_stopped_since(began)
                if late >= 0 and (max(map(abs, reading.speed)) < RESTING or late > patience_s):
                    return reading
                self.clock.sleep(rescue.LOOK_S)

    def arrive(self, goal) -> Reading:
        """Wait for a move to `goal` (rad) to end; raises `NotArrived` if a joint is not there then, with the cause."""
        reading = self.wait()
        gaps = [a - b for a, b in zip(reading.q, goal, strict=True)]
        worst = max(range(4), key=lambda i: abs(gaps[i]))
        if abs(gaps[worst]) > ARRIVED:
            self.halt()
            servo = JOINTS[worst]
            found = judge(servo, registers(self.bus, [servo])[servo])
            symptoms = [one.symptom for one in found if one.level != "note"]
            cause = "; ".join(symptoms) or "something is in its way, or it carries more than it can"
            raise NotArrived(worst + 1, gaps[worst], cause)
        return reading

    # ---- parking ----

    def park(self) -> None:
        """Fold the arm slowly where it stands, then torque off. If the way is blocked it stays, torque on."""
        with self.commanding:  # up to the end: nothing may set off between the rest pose and the torque
            if self.torque:
                self._park()

    def _park(self) -> None:
        self.brake.begin()
        if self.mode != "position":
            self.hold()
        known, self.watcher.troubles = self.watcher.troubles, []  # said already, and parking is what helps
        self.watcher.folding = True
        try:
            with self.unbroken(), self._rescuing():
                self.check_settings()
                for goal in move_rules.way_to_rest(self.guard, self.come_to_rest()):
                    sent = self._move(goal, None, min(PARK_SPEED, self.guard.speed_cap))
                    self.arrive(sent)  # from anywhere else it would fall
                self.relax()
        finally:
            self.watcher.folding = False
            self.watcher.troubles = known + self.watcher.troubles

    # ---- gripper ----

    def grip(self, servo_angle: float, force: float = GRIP_FORCE, seconds: float = 0.7) -> None:
        """Turn the gripper's servo to `servo_angle` (rad; negative opens), pressing with at most `force` (N).

        It goes on pressing. Does not wait. Raises `TorqueOff`, `Stopped`, `NotReady` without a gripper.
        """
        self.gripper.began = stops = self.brake.stops  # counted first: a stop may come between two lines
        self.brake.refuse_if_latched()
        self.watcher.asked()
        if GRIPPER_ID not in self.servos.ids:
            raise NotReady(self.bus.name, ["no gripper: servo 15 does not answer"])
        self._check_fingers()
        with self.unbroken(_STOPS):
            self.gripper.prepare(force, seconds)
            with self.brake.lock:
                self.brake.refuse_if_stopped_since(stops)
                self.gripper.close_to(servo_angle, seconds)
                self.brake.refuse_if_stopped_since(stops)

    def settle(self) -> Grip:
        """Wait until the fingers stand, and look; raises `Stopped` if somebody stopped them, resumed or not."""
        with self.unbroken(_STOPS):
            found = self.gripper.settle()
            self.brake.refuse_if_stopped_since(self.gripper.began)
        return found

    # ---- small parts ----

    def ready(self, mode: str) -> None:
        """Raise what forbids a command of this `mode`."""
        self.watcher.ask()
        self.brake.begin()
        self.watcher.asked()
        if not self.torque:
            raise TorqueOff
        if self.mode != mode:
            raise BadInput(f"the joints are in {self.mode} mode; `robot.write_mode({mode!r})` changes that.")
