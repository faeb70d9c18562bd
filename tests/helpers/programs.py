"""Programs that nobody would write: commands, faults, stops, exits and restarts in any order, and what must hold.

`python -m tests.helpers.programs --programs 2000 --seed 1` runs many and says what it saw.
"""

import argparse
import logging
import math
import random
import sys
import time

import numpy as np

import omx
from omx.arm import JOINT_IDS, SPEED_CAP
from omx.collision import clearance
from omx.errors import OmxError
from omx.hardware.robot import Robot
from omx.hardware.safety import Guard
from omx.hardware.simulator import SteppedClock, VirtualArm, VirtualPort
from omx.hardware.simulator.virtual_arm import STEP_S
from omx.motion.trajectory import joint_move

FAULTS = (
    ("lost", {"count": 1}), ("lost", {"count": 3}), ("corrupt", {"count": 2}), ("late", {"count": 2}),
    ("noise", {"count": 3}), ("duplicated", {"count": 2}), ("blocked", {"value": 0.02}), ("overload", {}),
    ("reboots", {}), ("dead", {}), ("low_voltage", {"value": 10.5}), ("low_voltage", {"value": 9.7}),
    ("hot", {"value": 65.0}), ("hot", {"value": 72.0}), ("unplugged", {}),
)  # fmt: skip
OPERATIONS = (
    *["move"] * 5, *["write"] * 5, *["sleep"] * 5, *["stream"] * 2, *["follow"] * 2, *["velocity"] * 3, *["push"] * 2,
    "mode", "mode", "hold", "stop", "resume", "resume", "park", "on", "on", "grip", "fault", "fault", "clear", "clear",
    "recover", "read", "relax", "interrupt", "exit", "error", "killed", "settings",
)  # fmt: skip


class Broken(AssertionError):
    """A promise that was not kept, with the program that broke it."""


class Heard(logging.Handler):
    """What the logger said."""

    def __init__(self):
        super().__init__()
        self.lines: list[str] = []

    def emit(self, record):
        self.lines.append(record.getMessage())


class Trial:
    """One program on one virtual arm, written by `choose`, a `random.Random`; `told` is what it did, in words."""

    def __init__(self, choose: random.Random, arm: VirtualArm | None = None):
        self.choose, self.told = choose, []
        self.arm, self.robot = arm or VirtualArm(), None
        self.rows: list[tuple] = []  # time, angles, all joints powered and on?, pushed?, stopped since, restarts
        self.stopped_at, self.episode = math.inf, 0
        live, servos = self.arm._live, self.arm.servos[:4]

        def seen(steps):
            on = all(servo.torque_on and servo.powered for servo in servos)
            if any(servo.table["goal_current"] < servo.table["current_limit"] for servo in servos):
                on = on and self.robot.bus.is_open  # killed in a push: it holds with no more current than it pushed
            angles = [joint.angle for joint in self.arm.joints[:4]]
            self.rows.append((self.arm.time, *angles, on, self.stopped_at, self.episode))
            live(steps)

        self.arm._live = seen
        self.heard, self.guard = Heard(), Guard()

    def run(self, length: int) -> None:
        """`length` operations, and a regular end."""
        log = logging.getLogger("omx.robot")
        log.addHandler(self.heard)
        log.propagate = False
        try:
            self.open()
            for _ in range(length):
                self.do(self.choose.choice(OPERATIONS))
            self.arm.faults.clear()
            self.do("exit")
            self.judge()
        finally:
            log.removeHandler(self.heard)
            log.propagate = True

    def open(self) -> None:
        try:
            self.robot = Robot(VirtualPort(self.arm, clock=SteppedClock()), idle_s=self.choose.choice((None, 30.0)))
        except OmxError as error:
            self.told.append(f"not opened: {type(error).__name__}")
            self.arm.faults.clear()
            self.arm.advance(self.arm.now + 1.0)
            for servo in self.arm.servos:
                if servo.table["hardware_error"]:
                    servo.reboot(self.arm.time)
            self.arm.advance(self.arm.now + 1.0)
            self.robot = Robot(VirtualPort(self.arm, clock=SteppedClock()))
        self.stopped_at = math.inf
        self.episode += 1
        if self.choose.random() < 0.8:
            self.do("on")

    def do(self, operation: str) -> None:
        before = self.robot.driver.stopped
        try:
            getattr(self, f"_{operation}")()
            self.told.append(operation)
        except OmxError as error:
            self.told.append(f"{operation}: {type(error).__name__}")
            self.heard.lines.append(str(error))
        except Broken:
            raise
        except Exception as error:
            raise Broken(f"{operation} raised {error!r} after {self.told}") from error
        stopped = self.robot.driver.stopped
        if stopped and not before:
            self.stopped_at = self.arm.now
        elif not stopped:
            self.stopped_at = math.inf
        self.episode += before is None and stopped is not None

    # ---- operations ----

    def pose(self) -> list[float]:
        """Four angles (deg), mostly some that are free."""
        low, high = np.degrees(np.array(omx.LIMITS)).T
        for _ in range(20 if self.choose.random() < 0.9 else 1):
            q = [self.choose.uniform(a - 3, b + 3) for a, b in zip(low, high, strict=True)]
            if self.guard.clearance(np.radians(q))[0] > 0:
                break
        return q

    def seconds(self, q) -> float:
        """A time (s) that will mostly do."""
        fewest = self.guard.seconds(self.robot.q, np.radians(q))
        return min(max(fewest * self.choose.choice((0.7, 1.0, 1.05, 1.3, 2.0, 5.0)), 0.01), 32.0)

    def position(self) -> None:
        if self.robot.driver.mode != "position" and self.choose.random() < 0.8:
            self.robot.write_mode("position")

    def _move(self):
        self.position()
        q = self.pose()
        self.robot.move_to(q, self.choose.choice((None, self.seconds(q))))

    def _write(self):
        self.position()
        for _ in range(self.choose.randrange(1, 4)):
            q = self.pose()
            self.robot.write_time(self.seconds(q))
            self.robot.write_joints(q)
            self.robot.clock.sleep(self.choose.uniform(0.0, 1.5))

    def _sleep(self):
        self.robot.clock.sleep(self.choose.uniform(0.0, 2.0))

    def _read(self):
        self.robot.get_joints_readings()

    def _stream(self):
        self.position()
        step = np.radians([self.choose.uniform(-3, 3) for _ in range(4)])
        period = self.choose.choice((0.02, 0.05, 0.1))
        for _ in range(self.choose.randrange(1, 20)):
            self.robot.driver.stream_to(self.robot.q + step, 2 * period)
            self.robot.clock.sleep(period * self.choose.choice((0.5, 1.0, 1.0, 3.0)))

    def _follow(self):
        self.position()
        q = self.pose()
        path = joint_move(self.robot.q, np.radians(q), 1.5 * self.seconds(q))
        self.robot.follow(path, self.choose.choice((20, 50)))

    def _mode(self):
        self.robot.write_mode(self.choose.choice(("position", "position", "velocity", "current")))

    def _velocity(self):
        self.robot.write_mode("velocity")
        for _ in range(self.choose.randrange(1, 8)):
            self.robot.write_velocities([self.choose.uniform(-70, 70) for _ in range(4)])
            self.robot.clock.sleep(self.choose.choice((0.05, 0.1, 0.6)))

    def _push(self):
        self.robot.write_mode("current")
        for _ in range(self.choose.randrange(1, 6)):
            self.robot.write_currents([self.choose.uniform(-520, 520) for _ in range(4)])
            self.robot.clock.sleep(self.choose.choice((0.05, 0.1, 0.6)))

    def _grip(self):
        self.robot.write_gripper(self.choose.random() < 0.5)

    def _hold(self):
        self.robot.hold()

    def _stop(self):
        self.robot.stop()

    def _resume(self):
        self.robot.resume()

    def _park(self):
        self.robot.park()

    def _relax(self):
        if self.choose.random() < 0.3:
            self.robot.relax()

    def _on(self):
        self.robot.write_motor_state(True)

    def _recover(self):
        self.robot.recover()

    def _fault(self):
        kind, options = self.choose.choice(FAULTS)
        servo = {"servo": self.choose.choice(JOINT_IDS)} if kind not in ("low_voltage", "unplugged") else {}
        self.told.append(f"{kind} {servo.get('servo', '')}")
        self.arm.faults.inject(kind, **options, **servo)

    def _clear(self):
        self.arm.faults.clear()
        if not self.robot.bus.is_open:
            self.robot.bus.reopen()

    def _settings(self):
        """Another program was at the servos' registers."""
        servo = self.arm.servo(self.choose.choice(JOINT_IDS))
        servo.table.put(*self.choose.choice((("goal_pwm", 300), ("position_p_gain", 500), ("profile_velocity", 0))))

    def _interrupt(self):
        self._end(KeyboardInterrupt)

    def _error(self):
        self._end(ZeroDivisionError)

    def _end(self, kind):
        """A `with` block that ends in this error in mid-move."""
        try:
            with self.robot:
                self.position()
                self.robot.write_joints(self.pose())
                self.robot.clock.sleep(self.choose.uniform(0.0, 2.0))
                raise kind
        except kind:
            pass
        finally:
            self._ended()

    def _exit(self):
        try:
            self.robot.close()
        finally:
            self._ended()

    def _ended(self):
        on = [servo for servo in JOINT_IDS if self.arm.servo(servo).torque_on]
        said = any("MOTORS ARE ON" in line or "motors on" in line for line in self.heard.lines)
        if on and not said:
            raise Broken(f"the motors {on} stay on without a word after {self.told}")
        self.robot.bus.close()
        self.heard.lines.clear()
        self._reopen()

    def _killed(self):
        """The kernel dies: nothing is said on the line any more."""
        self.robot.bus.close()
        self._reopen()

    def _reopen(self):
        for _ in range(20):
            self.arm.advance(self.arm.now + 0.1)
        self.arm.faults.clear()
        self.open()

    # ---- what must hold ----

    def judge(self) -> None:
        rows = np.array(self.rows)
        t, q, on, stopped_at, episode = rows[:, 0], rows[:, 1:5], rows[:, 5] > 0, rows[:, 6], rows[:, 7]
        starts = np.flatnonzero(np.diff(np.concatenate([[False], on]).astype(int)) == 1)
        ends = [*np.flatnonzero(np.diff(on.astype(int)) == -1), len(on) - 1]
        low, high = np.array(omx.LIMITS).T
        for first in starts:
            last = next(end for end in ends if end >= first)
            part = q[first : last + 1]
            if len(part) > 1:
                span = slice(first, last + 1)
                self._spans(t[span], part, low, high)
                self._stands_when_stopped(t[span], part, stopped_at[span], episode[span])

    def _spans(self, t, q, low, high) -> None:
        beyond = np.maximum(low - q, q - high)
        allowed = np.maximum(beyond[0], 0.0) + math.radians(1.0)
        if (beyond > allowed).any():
            raise Broken(f"a joint is {np.degrees((beyond - allowed).max()):.1f} deg outside after {self.told}")
        gap = clearance(q)
        if gap.min() < min(gap[0], 0.0) - 3.0:
            raise Broken(f"{-gap.min():.1f} mm into the table or itself after {self.told}")
        later = np.searchsorted(t, t + 0.1 - STEP_S / 2)
        ok = later < len(t)
        turned = np.abs(q[later[ok]] - q[ok]).max(axis=1, initial=0.0) - math.radians(1.0)
        speed = turned / (t[later[ok]] - t[ok])
        if len(speed) and speed.max() > SPEED_CAP * 1.05:
            raise Broken(f"{math.degrees(speed.max()):.0f} deg/s after {self.told}")

    def _stands_when_stopped(self, t, q, stopped_at, episode) -> None:
        for number in np.unique(episode[np.isfinite(stopped_at)]):
            still = (episode == number) & np.isfinite(stopped_at) & (t > stopped_at + 0.5)
            if still.sum() > 1 and np.ptp(q[still], axis=0).max() > math.radians(1.0):
                raise Broken(f"it moved after a stop, after {self.told}")


def run(seed: int, number: int, length: int = 12) -> list[str]:
    """Program `number` of the series `seed`; what it did, in words."""
    trial = Trial(random.Random(f"{seed}/{number}"))
    trial.run(length)
    return trial.told


def main(argv=None) -> int:
    """The command line."""
    parser = argparse.ArgumentParser(prog="python -m tests.helpers.programs", description=__doc__.splitlines()[0])
    parser.add_argument("--programs", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--length", type=int, default=12)
    given = parser.parse_args(argv)
    began, broken, operations = time.monotonic(), [], 0
    for number in range(given.first, given.first + given.programs):
        try:
            operations += len(run(given.seed, number, given.length))
        except Broken as error:
            broken.append(number)
            print(f"program {number}: {error}", flush=True)
        if (number + 1) % 100 == 0:
            print(f"{number + 1 - given.first} programs, {operations} operations, {len(broken)} broken", flush=True)
    counts = f"{given.programs} programs of series {given.seed}, {operations} operations"
    print(f"{counts}, {time.monotonic() - began:.0f} s: {len(broken)} broken")
    return int(bool(broken))


if __name__ == "__main__":
    sys.exit(main())
