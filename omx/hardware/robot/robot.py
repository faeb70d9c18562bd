"""`Robot`: the arm in the course's words, degrees and millimetres, virtual or real."""

import contextlib
import logging
import math
import os
from collections.abc import Callable

import numpy as np

from ...arm import CLOSED_DEG, GRIP_FORCE, HOME, IDLE_S, OPEN_DEG
from ...arrays import as_four, as_number
from ...dh import Chain, DHRow
from ...errors import BadInput, OmxError
from ...geometry import COURSE, Geometry
from ...kinematics import fk, ik, jacobian, pose, solve_ik
from ..clock import SteppedClock, period, ticks
from ..dynamixel.bus import Bus
from ..log import Log, Recorder, read_log
from ..safety import Guard
from ..simulator import VirtualArm, VirtualPort
from . import hand_guiding, modes, shutdown, streaming
from .calibration import as_calibration
from .discovery import open_bus
from .driver import Driver, Reading
from .gripper import Grip

_log = logging.getLogger("omx.robot")

#: Columns of `log`, with units.
COLUMNS = {
    "t": "s",
    **{f"q{i}": "deg" for i in range(1, 5)},
    **{f"v{i}": "deg/s" for i in range(1, 5)},
    **{f"i{i}": "mA" for i in range(1, 5)},
    "x": "mm", "y": "mm", "z": "mm", "pitch": "deg",
}  # fmt: skip


class Robot:
    """The OpenMANIPULATOR-X. Angles in degrees, lengths in mm.

    `Robot()` is a virtual arm with the same servos, the same bytes and the same SDK as the real one. `Robot("auto")`
    looks for yours; `Robot("/dev/ttyUSB0")`, `Robot("COM5")` name its port. Nothing moves, and no torque is switched
    on, until you call something that says so. Use it in a `with` block: at its end, and after an error, the arm holds,
    parks, and only then lets go; after a stop, a stall or an interrupt it holds, and a sentence says how to go on.

    `guard`: limits, table, speed cap and payload. `payload_g`: what the gripper carries from the start, without a guard
    of your own. `idle_s`: an arm that nobody has asked for anything for so long parks; None: never. `clock`: time of
    the virtual arm. Left out, it moves only when somebody waits for it, and in real time once a `RobotPanel` looks on;
    `Clock(10)` is ten times as fast. What is worth knowing is said by the logger "omx.robot", in a notebook below the
    cell. `calibration`: what chapter 17 found for this very arm, or the file that `save_calibration` wrote; its lengths
    count unless `geometry` is given. Nothing of it is written to the servos.
    Raises `NotReady` with everything that is wrong, or a `PortError`.
    """

    def __init__(self, port=None, *, geometry: Geometry | None = None, guard: Guard | None = None, clock=None,
                 idle_s: float | None = IDLE_S, payload_g: float = 0.0, calibration=None):  # fmt: skip
        self.calibration = found = None if calibration is None else as_calibration(calibration)
        self.geometry = geometry = geometry or (found.geometry if found else COURSE)
        self.arm: VirtualArm | None = None
        if port is None:
            self.arm = VirtualArm(q=HOME)
            port = VirtualPort(self.arm, clock=clock or SteppedClock())
        elif isinstance(port, VirtualPort):
            self.arm = port.arm
        port = os.fspath(port) if isinstance(port, os.PathLike) else port
        self.bus: Bus = open_bus(port) if isinstance(port, str) else Bus(port)
        self._seconds: float | None = None
        self._closed = False
        try:
            self.driver = Driver(self.bus, guard or Guard(geometry=geometry, payload_g=payload_g), idle_s=idle_s,
                                 offsets=found.offsets if found else (0.0,) * 4)  # fmt: skip
        except BaseException:
            self.bus.close()
            raise
        self.clock = self.bus.clock
        shutdown.look_after(self)
        for warning in self.driver.condition.warnings:
            _log.warning("%s: %s", self.bus.name, warning)
        if self.driver.torque:
            _log.warning("%s: the motors are on; another program left them so. The arm holds.", self.bus.name)

    def __repr__(self) -> str:
        kind = "virtual" if self.arm else self.bus.name
        state = "closed" if not self.bus.is_open else f"motors {'on' if self.driver.torque else 'off'}"
        return f"Robot({kind}, {state})"

    def __enter__(self) -> "Robot":
        return self

    def __exit__(self, kind, error, _) -> None:
        if kind is None:
            self.close()
            return
        self.driver.broken_off(error)
        with contextlib.suppress(OmxError):  # the reason that brought us here is worth more than what follows
            self.close()

    # ---- the course's names: the motors ----

    def write_motor_state(self, on: bool) -> None:
        """Motors on where the arm stands, or off: **off, the arm falls** (see `park`)."""
        if on:
            self.driver.torque_on()
        else:
            self.driver.relax()

    def write_time(self, seconds: float) -> None:
        """How long each following `write_joints` takes, in s."""
        self._seconds = as_number(seconds, "seconds", "0.001 .. 32 s", 1e-3, 32)

    def write_joints(self, q_deg) -> np.ndarray:
        """Send the joints on their way to four angles (deg), and return at once with those really sent (ticks).

        Takes the seconds of `write_time`, or as few as the speed cap allows. Refuses what is outside the limits, hits
        the table or the arm itself, or is too fast: then nothing was sent, and the error names what would pass.
        """
        sent = self.driver.command(np.radians(as_four(q_deg, "q_deg", "four numbers")), self._seconds)
        return np.degrees(sent)

    def get_joints_readings(self) -> np.ndarray:
        """Angles (deg), velocities (deg/s) and currents (mA) now: (3, 4), one transaction on the bus."""
        return _in_degrees(self.driver.read())

    def write_gripper(self, opened: bool, force: float = GRIP_FORCE) -> None:
        """Open (True) or close (False) the gripper, and return at once. It presses with at most `force` (N)."""
        self.driver.grip(math.radians(OPEN_DEG if opened else CLOSED_DEG), force)

    def read_gripper(self) -> float:
        """The gripper's servo in degrees: -45 is open, +45 closed."""
        return math.degrees(self.driver.gripper.look().angle)

    def write_mode(self, mode: str) -> None:
        """What is commanded: "position" (the default), "velocity" or "current". The arm comes to rest and holds."""
        modes.choose(self.driver, mode)

    def write_velocities(self, deg_per_s) -> np.ndarray:
        """In velocity mode: turn the joints at these speeds (deg/s). Repeat it: unrepeated it ends after 0.4 s."""
        return np.degrees(modes.velocities(self.driver, np.radians(as_four(deg_per_s, "deg_per_s", "four numbers"))))

    def write_currents(self, milliamps) -> np.ndarray:
        """In current mode: push with these currents (mA). Repeat it: unrepeated for 0.4 s, the arm holds."""
        return np.array(modes.currents(self.driver, as_four(milliamps, "milliamps", "four numbers")))

    # ---- the course's names: kinematics ----

    def get_dh_row_mat(self, row) -> np.ndarray:
        """A_i, (4, 4), for one row [theta, d, a, alpha] of a DH table (deg, mm)."""
        theta, d, a, alpha = as_four(row, "row", "four numbers")
        return Chain([DHRow(math.radians(theta), d, a, math.radians(alpha))]).fk([0.0])

    def get_int_mat(self, q_deg) -> np.ndarray:
        """The link matrices A_1 .. A_4 at four angles (deg): (4, 4, 4), mm."""
        return self.geometry.chain.matrices(np.radians(as_four(q_deg, "q_deg", "four numbers")))

    def get_fk(self, q_deg) -> np.ndarray:
        """T_base_tool, (4, 4), mm, at four angles (deg)."""
        return fk(np.radians(as_four(q_deg, "q_deg", "four numbers")), self.geometry)

    def get_current_fk(self) -> np.ndarray:
        """T_base_tool, (4, 4), mm, at the angles read now."""
        return fk(self.driver.read().q, self.geometry)

    def get_ee_pos(self, q_deg) -> np.ndarray:
        """[x, y, z, pitch, yaw] (mm, deg) of the tool at four angles (deg)."""
        q = np.radians(as_four(q_deg, "q_deg", "four numbers"))
        x, y, z, pitch = pose(q, self.geometry)
        return np.array([x, y, z, math.degrees(pitch), math.degrees(q[0])])

    def get_ik(self, pose_deg) -> np.ndarray:
        """The two solutions in front, elbow up and elbow down, (2, 4) deg, for [x, y, z, alpha] (mm, deg).

        Joint limits are not considered; `omx.ik` has all four branches with verdicts. Raises `Unreachable`.
        """
        target = _task(pose_deg)
        up, down, *_ = ik(target, self.geometry)
        if not up.reachable:
            solve_ik(target, geometry=self.geometry, limits=((-math.inf, math.inf),) * 4)  # raises, or the back reaches
            raise BadInput(f"`pose_deg` {list(pose_deg)} is only reachable over the arm's back; see `omx.ik`.")
        return np.degrees([up.q, down.q])

    def get_jacobian(self, q_deg) -> np.ndarray:
        """The Jacobian (6, 4) at four angles (deg): mm/rad, then rad/rad."""
        return jacobian(np.radians(as_four(q_deg, "q_deg", "four numbers")), self.geometry)

    # ---- beyond the course ----

    @property
    def q(self) -> tuple[float, ...]:
        """The joint angles now, in rad, as the rest of `omx` takes them."""
        return self.driver.read().q

    def move_to(self, q_deg, seconds: float | None = None) -> np.ndarray:
        """Go to four angles (deg) and wait; returns the reading (3, 4) at the end. `seconds`: as for `write_time`.

        Raises `NotArrived` if a joint is not there when the time is over, with the likely cause.
        """
        sent = self.driver.command(np.radians(as_four(q_deg, "q_deg", "four numbers")), seconds)
        return _in_degrees(self.driver.arrive(sent))

    def move_to_pose(self, pose_deg, seconds: float | None = None) -> np.ndarray:
        """Go to [x, y, z, pitch] (mm, deg) by the nearest legal branch and wait; returns the reading (3, 4)."""
        target = _task(pose_deg)
        q = solve_ik(target, self.driver.read().q, self.geometry, self.driver.guard.soft_limits)
        sent = self.driver.command(q.q, seconds)
        return _in_degrees(self.driver.arrive(sent))

    def grip(self, force: float = GRIP_FORCE, payload_g: float | None = None, payload_mm: float = 0.0) -> Grip:
        """Close the gripper on something, wait until its fingers stand, and tell what they hold.

        `force` (N) is what either pad presses with, for as long as you like; rubber carries about its weight. With
        `payload_g` the arm counts on that weight from now on, if there is something; with `payload_mm` it keeps what
        reaches so far from the tool clear of the table. What slips out later makes the arm hold, and raises
        `ObjectLost`.
        """
        self.write_gripper(False, force)
        found = self.driver.settle()
        if found.holding and (payload_g is not None or payload_mm):
            self.driver.carry(self.driver.guard.payload_g if payload_g is None else payload_g, payload_mm)
        return found

    def release(self) -> Grip:
        """Open the gripper and wait; whatever it carried is gone."""
        self.write_gripper(True)
        found = self.driver.settle()
        self.driver.carry(0.0)
        return found

    @property
    def holding(self) -> bool:
        """True while the gripper holds something between its fingers."""
        return self.driver.gripper.look().holding

    def follow(self, trajectory, rate: float = 50.0, each: Callable[[Reading, float], None] | None = None) -> None:
        """Run an `omx.motion.Trajectory`: the next waypoint is sent `rate` times a second, two periods ahead.

        `each(reading, t)` is called at every step, `t` (s) being how far along the trajectory we are. Checked whole
        before the first step: limits, table, speed. Starts from where the trajectory starts: move there first. If the
        program is held up, the arm waits on the path and goes on from there. An interrupt or an error makes it hold.
        """
        streaming.follow(self.driver, trajectory, rate, each)

    def ticks(self, seconds: float, rate: float = 50.0):
        """The moments (s) of a loop at `rate` turns a second of the arm's time: `for t in robot.ticks(10): ...`."""
        return ticks(seconds, rate, self.clock)

    def log(self, seconds: float, path="log.csv", rate: float = 50.0, progress=None, **notes) -> Log:
        """Sample for `seconds`, `rate` times a second, into a CSV file, while the arm does what it was told.

        Columns: t (s), q1 .. q4 (deg), v1 .. v4 (deg/s), i1 .. i4 (mA), x, y, z (mm), pitch (deg). `progress(share)` is
        called now and then, with 0 .. 1. Whatever ends it early, the arm holds, and every sample taken is on the disk,
        and in `LogError.samples`.
        """
        return self._record(self.driver.watch, seconds, path, rate, progress, notes)

    def _record(self, look: Callable[[], Reading], seconds, path, rate, progress, notes) -> Log:
        with Recorder(path, COLUMNS, self.geometry, **notes) as recorder, self.driver.unbroken():
            for i, t in enumerate(self.ticks(seconds, rate)):
                self._sample(recorder, look(), t)
                if progress and i % 10 == 0:
                    progress(min(t / seconds, 1.0) if seconds else 1.0)
            if progress:
                progress(1.0)
        return recorder.log

    def _sample(self, recorder: Recorder, reading: Reading, t: float) -> None:
        x, y, z, pitch = pose(reading.q, self.geometry)
        recorder.write(t, *_in_degrees(reading).ravel().tolist(), x, y, z, math.degrees(pitch))

    def teach(
        self, seconds: float, path="taught.csv", joints=(1, 2, 3, 4), rate: float = 50.0, progress=None, **notes
    ) -> Log:
        """Lead the arm by hand for `seconds`, recorded as by `log`; then it holds. `replay` runs what was taught.

        The motors carry the weight of `joints`, payload and all: the arm stays where it is left. The others hold.
        **Keep a hand at the arm**: it carries what the model says it weighs, not what it does. It holds, and the log
        ends with the reason raised, where a joint comes near a limit, the table or the arm itself.
        """
        joints = hand_guiding.joints_named(joints)
        modes.choose(self.driver, "current")
        try:
            return self._record(lambda: modes.balance(self.driver, joints), seconds, path, rate, progress, notes)
        finally:
            self.driver.hold()

    def replay(self, log, speed: float = 1.0, rate: float = 50.0, each=None) -> None:
        """Run what was taught or logged, a `Log` or its path, at `speed` times its speed; first go to where it starts.

        Checked whole before the first step, like every trajectory (`follow`).
        """
        period(rate)  # a mistake is told before anything moves
        log = log if isinstance(log, Log) else read_log(log)
        motion = hand_guiding.trajectory(log, speed)
        hand_guiding.check_speed(self.driver, motion, speed)
        streaming.check_path(self.driver, motion)
        self.driver.arrive(self.driver.command(motion.q[0]))
        self.follow(motion, rate, each)

    def follow_leader(self, leader, seconds: float, rate: float = 100.0) -> streaming.Led:
        """For `seconds` go where `leader` goes: another `Robot`, or a function that returns four angles (deg).

        A leader with relaxed or balanced joints is led by hand. Each step passes the guard; where one is refused the
        arm waits until the leader comes back. It begins from wherever it is, no faster than the speed cap.
        """

        if leader is self:
            raise BadInput("`leader` is this very arm: it would follow its own sag, down and down.")

        def where():
            return leader.q if isinstance(leader, Robot) else np.radians(as_four(leader(), "leader()", "four numbers"))

        return streaming.lead(self.driver, where, seconds, rate)

    def hold(self) -> None:
        """Stop where the arm is, motors on."""
        self.driver.hold()

    def stop(self) -> None:
        """Stop, and refuse every command, parking too, until `resume`: what the stop button does, from any thread."""
        self.driver.stop()

    def resume(self) -> None:
        """Allow commands again after a stop, a stall or an interrupt."""
        self.driver.resume()

    def park(self) -> None:
        """Fold the arm slowly where it stands, then switch the motors off."""
        self.driver.park()

    def relax(self) -> None:
        """Motors off at once: **the arm falls**. Support it."""
        self.driver.relax()

    def recover(self) -> list[int]:
        """Reboot servos that report a hardware error and switch them on again where they stand. Returns their ids."""
        return self.driver.recover()

    def close(self) -> None:
        """Park, motors off, port closed; a stopped arm holds instead. Closing twice is fine."""
        if not self.bus.is_open:
            if self.driver.torque and not self._closed:  # pulled out: nobody has said so yet
                shutdown.say_motors_on(self.driver, "the port has gone")
            self._closed = True
            return
        self._closed, why = True, self.driver.stopped
        try:
            if why is None:
                why = "it could not park"
                self.driver.park()
            else:
                self.driver.hold()
        finally:
            if self.driver.torque:
                shutdown.say_motors_on(self.driver, why)
            self.bus.close()


def _task(pose_deg) -> list[float]:
    x, y, z, alpha = as_four(pose_deg, "pose_deg", "four numbers")
    return [x, y, z, math.radians(alpha)]


def _in_degrees(reading: Reading) -> np.ndarray:
    return np.array([np.degrees(reading.q), np.degrees(reading.speed), reading.current])
