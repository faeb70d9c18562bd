"""What is done to the servos on a bus: set up, sent on their way, brought to a stand, each read back.

All at once, in few transactions; one by one where that fails, or where a motor must go off for it. Nothing here leaves
a servo limp that was not: what fails, or is interrupted, half-way switches it on again first.
"""

import contextlib
import math
from typing import NoReturn

from ...arm import GRIPPER_ID, JOINT_IDS
from ...errors import BusError, ServoRefused
from ..dynamixel import registers as reg
from ..dynamixel import units
from ..dynamixel.bus import Bus, again, for_each
from ..fault_table import GAINS, MENDS
from ..gravity import sagged

HOLD_S = 0.2
#: How long (s) a motor takes to its set-point when it goes on: it may have fallen from there while we were held up.
CAREFUL_S = 4.0
#: What was read longer ago (s), because the program was held up, is read again, so often at the most.
STALE_S, STALE_TRIES = 0.1, 5
#: A joint that is farther (ticks) from its own set-point than this is being held up by something.
HOLD_SLACK = units.ANGLE.raw(math.radians(3.0))
#: Slower (rad/s) is at rest: a servo counts in steps of 1.4 deg/s, and one of them is noise.
RESTING = math.radians(2.0)
#: One that rests (raw speed), and is farther (ticks) from it than by its weight, is held up, too.
STILL, UNEXPLAINED = units.VELOCITY.raw(RESTING), units.ANGLE.raw(math.radians(1.0))
PROFILE = reg.block("profile_acceleration", "profile_velocity")
MODES = reg.block("drive_mode", "operating_mode")
#: A whole motion in one packet: a servo takes all three, or none.
MOTION = reg.block("profile_acceleration", "profile_velocity", "goal_position")
#: The same with the current that a servo in mode 5 may use for it.
MOTION_PUSHED = reg.block("goal_current", "goal_velocity", *(row.name for row in MOTION.registers))
WATCHDOG = reg.block("bus_watchdog")
#: How fast a servo turns, where it is, and its own set-point with its speed.
STATE = reg.block("present_velocity", "present_position", "velocity_trajectory", "position_trajectory")
#: What is written at every set-up, in blocks of neighbours.
SETTINGS = (*GAINS, WATCHDOG)
JOINTS = JOINT_IDS


class Servos:
    """What is done to one servo, or to several, of `bus`. Raw values, but for seconds.

    `at`: the registers of each as they were found, its limits among them; `ids`: who is there. `pwm`: the most of its
    power that each joint may use. `soft`: the joints that are on, and not in position mode. `payload_g`: what hangs on
    the gripper.
    """

    def __init__(self, bus: Bus, at: dict[int, dict[str, int]], pwm: dict[int, int], payload_g: float = 0.0):
        self.bus, self.at, self.pwm, self.payload_g = bus, at, pwm, payload_g
        self.ids = sorted(at)
        on = [servo for servo in JOINTS if at[servo]["torque_enable"]]
        self.soft = {servo for servo in on if at[servo]["operating_mode"] != reg.MODES["position"]}

    def get(self, servo: int, name: str) -> int:
        """A register, asked for three times if need be."""
        return again(self.bus.read, servo, name, times=3)

    def put(self, servo: int, name: str, value: int) -> None:
        """A register, confirmed."""
        again(self.bus.write, servo, name, value, times=3)

    def of_joints(self, name: str) -> dict[int, int]:
        """One register of the four joints."""
        return again(self.bus.read_all, JOINTS, name)

    def put_all(self, what: reg.Block, values: dict[int, tuple[int, ...]]) -> None:
        """A block of registers of each servo, in one packet, read back: nobody confirms a packet to all."""
        left = values
        for _ in range(3):
            self.bus.write_block(what, left)
            found = again(self.bus.read_block, list(values), what)
            left = {servo: wanted for servo, wanted in values.items() if found[servo] != wanted}
            if not left:
                return
        servo, wanted = next(iter(left.items()))
        pairs = zip(what.registers, wanted, found[servo], strict=True)
        row, value, got = next(pair for pair in pairs if pair[1] != pair[2])
        self._not_taken(servo, row.name, value, got)

    def _not_taken(self, servo: int, name: str, value: int, got: int) -> NoReturn:
        """Raise why it reads back `got`: its hardware error, if it has one."""
        if servo in self.bus.alerts:
            again(self.bus.check_hardware, [servo])
        raise ServoRefused(self.bus.name, f"take {name} = {value}", servo, 0, f"it reads back {got}")

    # ---- switching on ----

    def switch_on(self, servos: list[int]) -> None:
        """Set up for position mode and switch on, each where it stands, those that are on without letting go.

        The set-point of a joint that was limp is the one that holds its weight just there, so that it does not sag.
        """
        modes = again(self.bus.read_block, servos, MODES)
        on = again(self.bus.read_all, servos, "torque_enable")
        wrong = {servo: self._wanted(servo, modes[servo][0], "position") for servo in servos}
        wrong = {servo: wanted for servo, wanted in wrong.items() if modes[servo] != wanted}
        limp = {servo: wanted for servo, wanted in wrong.items() if not on[servo]}
        if limp:
            self.put_all(MODES, limp)
        for servo in wrong:
            if on[servo]:  # its motor must go off for it: one after the other, so that the others hold
                self.set_up(servo)
        self._mend(servos)
        state = again(self.bus.read_block, servos, STATE)
        lifts = self._lifts(state)
        off = {servo: self.within_limits(servo, state[servo][1] + lifts.get(servo, 0))
               for servo in servos if not on[servo]}  # fmt: skip
        total = units.MILLISECONDS.raw(HOLD_S)
        if off:  # at once: while its set-point was on its way a joint would sag
            self.put_all(MOTION, {servo: (0, 0, goal) for servo, goal in off.items()})
            self.put_all(reg.block("torque_enable"), dict.fromkeys(off, (1,)))
        self.put_all(PROFILE, dict.fromkeys(servos, (total // 4, total)))
        self.soft.clear()

    def _mend(self, servos) -> None:
        """What other programs may have left behind, and how hard the joints may push."""
        for what in SETTINGS:
            wanted = tuple(MENDS[row.name] for row in what.registers)
            found = again(self.bus.read_block, servos, what)
            if wrong := [servo for servo in servos if found[servo] != wanted]:
                self.put_all(what, dict.fromkeys(wrong, wanted))
        if pushes := {servo: (self.pwm[servo],) for servo in servos if servo in self.pwm}:
            self.put_all(reg.block("goal_pwm"), pushes)

    def _wanted(self, servo: int, drive: int, mode: str) -> tuple[int, int]:
        """Drive mode and operating mode: time-based profiles; only the gripper may count backwards.

        It holds its position with no more current than it is given, so that it can press on something for good.
        """
        mode = "current_position" if servo == GRIPPER_ID else mode
        reverse = drive & reg.DRIVE_REVERSE if servo == GRIPPER_ID else 0
        return reg.DRIVE_TIME_BASED | reverse, reg.MODES[mode]

    def set_up(self, servo: int, mode: str = "position") -> None:
        """One servo: modes, both read back; what others left; profile, read back; goal := present; torque on.

        Drive and operating mode live in the EEPROM, which is locked while the torque is on. Only if one of them is
        wrong does the torque go off, for some milliseconds.
        """
        was_on = self.get(servo, "torque_enable")
        try:
            self._choose_modes(servo, mode)
            self._mend([servo])
            self._switch_on_here(servo)
            (self.soft.discard if mode == "position" else self.soft.add)(servo)
        except BaseException:
            if was_on:
                with contextlib.suppress(BusError):
                    self._switch_on_here(servo)
            raise

    def _choose_modes(self, servo: int, mode: str) -> None:
        found = again(self.bus.read_block, [servo], MODES)[servo]
        wanted = self._wanted(servo, found[0], mode)
        if found != wanted:
            self.put(servo, "torque_enable", 0)
            self.put_all(MODES, {servo: wanted})

    def _switch_on_here(self, servo: int) -> None:
        self.slow(servo, CAREFUL_S)
        if not self.get(servo, "torque_enable"):
            self.put(servo, "goal_position", self.within_limits(servo, self.get(servo, "present_position")))
        self.put(servo, "torque_enable", 1)
        self.slow(servo)

    def soften(self, servos) -> None:
        """One after the other into the mode with limited current, each holding as it did."""
        for servo in servos:
            self.set_up(servo, "current_position")

    def stiffen(self) -> None:
        """The joints that are not in position mode back into it; what fails is raised when all have been tried."""
        for_each(sorted(self.soft), self.set_up)

    def within_limits(self, servo: int, position: int) -> int:
        """`position`, or the nearest that the servo takes as a goal."""
        return min(max(position, self.at[servo]["min_position_limit"]), self.at[servo]["max_position_limit"])

    def slow(self, servo: int, seconds: float = HOLD_S) -> None:
        """A profile of `seconds`, read back: 0, its value after a restart, is full speed."""
        total = units.MILLISECONDS.raw(seconds)
        self.put_all(PROFILE, {servo: (total // 4, total)})

    # ---- moving and standing ----

    def send(self, goals: dict[int, int], seconds: float, ramp: float, confirmed: bool = True) -> None:
        """Goal positions, to be reached in `seconds` of which the share `ramp` speeds up, all in one packet.

        Read back, unless the next one of a stream comes before that could help.
        """
        total = units.MILLISECONDS.raw(seconds)
        motions = {servo: (int(ramp * total), total, goal) for servo, goal in goals.items()}
        self.put_all(MOTION, motions) if confirmed else self.bus.write_block(MOTION, motions)

    def stand(self, servos=JOINTS) -> None:
        """They stop where they are, in three transactions. A set-point that is near stays: no sag is added.

        One that lies off by more than the weight explains, while the joint does not turn, would move it as soon as
        it is let go: it becomes the one that holds the weight just there.
        """
        if pushing := self.soft.intersection(servos):
            self.put_all(WATCHDOG, dict.fromkeys(pushing, (0,)))
        for _ in range(STALE_TRIES):
            before = self.bus.clock.now()
            state = again(self.bus.read_block, list(servos), STATE)
            if self.bus.clock.now() - before < STALE_S:
                break
        lifts, motions = self._lifts(state), {}
        for servo, (speed, present, _, aim) in state.items():
            held_up = servo in lifts and abs(speed) <= STILL and abs(aim - present - lifts[servo]) > UNEXPLAINED
            motions[servo] = self.standing(servo, present, present + lifts[servo] if held_up else aim)
        self.put_all(MOTION_PUSHED, motions)

    def _lifts(self, state) -> dict[int, int]:
        """How far (ticks) beyond where it stands the set-point of each joint is that holds its weight just there.

        Of all joints, or of none where one was not read: the weight on a joint depends on the others.
        """
        if any(servo not in state for servo in JOINTS):
            return {}
        q = [units.POSITION.value(state[servo][1]) for servo in JOINTS]
        below = sagged(q, self.payload_g)
        return {servo: units.ANGLE.raw(q[i] - below[i]) for i, servo in enumerate(JOINTS)}

    def standing(self, servo: int, present: int, aim: int | None = None) -> tuple[int, ...]:
        """What to write into `MOTION_PUSHED` for it: all its current, and to stand at `aim`, or where it is.

        A soft joint at once: its set-point is far away, and would come back slowly.
        """
        near = aim is not None and abs(aim - present) <= HOLD_SLACK
        goal = self.within_limits(servo, aim if near else present)
        seconds = 0.0 if servo in self.soft else HOLD_S
        return self.at[servo]["current_limit"], 0, 0, units.MILLISECONDS.raw(seconds), goal
