"""Single servos, set up and brought to a stand: every step repeated if its answer is lost, and read back.

Nothing here leaves a servo limp that was not: what fails, or is interrupted, half-way switches it on again first.
"""

import contextlib
import math

from ...arm import GRIPPER_ID, JOINT_IDS
from ...errors import BusCorrupt, BusError, BusTimeout, ServoRefused
from ..dynamixel import registers as reg
from ..dynamixel import units
from ..dynamixel.bus import Bus

HOLD_S = 0.2
#: A joint that is farther (ticks) from its own set-point than this is being held up by something.
HOLD_SLACK = units.ANGLE.raw(math.radians(3.0))
PROFILE = reg.block("profile_acceleration", "profile_velocity")
MODES = reg.block("drive_mode", "operating_mode")
JOINTS = JOINT_IDS


def again(call, *args, times: int = 2):
    """`call(*args)`, up to `times` times while its answer is lost or damaged. For what does no harm twice."""
    for left in reversed(range(times)):
        try:
            return call(*args)
        except (BusTimeout, BusCorrupt):
            if not left:
                raise


class Servos:
    """What is done to one servo, or to all joints, of `bus`. Raw values, but for seconds."""

    def __init__(self, bus: Bus):
        self.bus = bus

    def get(self, servo: int, name: str) -> int:
        """A register, asked for three times if need be."""
        return again(self.bus.read, servo, name, times=3)

    def put(self, servo: int, name: str, value: int) -> None:
        """A register, confirmed."""
        again(self.bus.write, servo, name, value, times=3)

    def of_joints(self, name: str) -> dict[int, int]:
        """One register of the four joints."""
        return again(self.bus.read_all, JOINTS, name)

    def set_up(self, servo: int, mode: str, on: bool) -> None:
        """Drive mode, operating mode, both read back; profile, read back; goal := present; torque. In this order.

        Drive and operating mode live in the EEPROM, which is locked while the torque is on. Only if one of them is
        wrong does the torque go off, for some milliseconds.
        """
        was_on = self.get(servo, "torque_enable")
        push = self.get(servo, "present_current") if was_on else 0
        try:
            self._choose_modes(servo, mode)
            if self.get(servo, "bus_watchdog"):
                self.put(servo, "bus_watchdog", 0)
            self.slow(servo)
            if not self.get(servo, "torque_enable"):
                self._goal_here(servo, mode, push)
            if on:
                self.put(servo, "torque_enable", 1)
        except BaseException:
            if was_on:
                self.catch(servo)
            raise

    def _choose_modes(self, servo: int, mode: str) -> None:
        drive = self.get(servo, "drive_mode")
        reverse = drive & reg.DRIVE_REVERSE if servo == GRIPPER_ID else 0
        wanted = {"drive_mode": reg.DRIVE_TIME_BASED | reverse, "operating_mode": reg.MODES[mode]}
        if drive == wanted["drive_mode"] and self.get(servo, "operating_mode") == wanted["operating_mode"]:
            return
        self.put(servo, "torque_enable", 0)
        for name, value in wanted.items():
            self.put(servo, name, value)
            if (found := self.get(servo, name)) != value:
                raise ServoRefused(self.bus.name, f"take {name} = {value}", servo, 0, f"it reads back {found}")

    def _goal_here(self, servo: int, mode: str, push: int) -> None:
        """The goal that keeps a servo where it is; after a change of mode the goal current is the *greatest*."""
        if mode == "position":
            self.put(servo, "goal_position", self.here(servo))
        elif mode == "velocity":
            self.put(servo, "goal_velocity", 0)
        else:
            self.put(servo, "goal_current", push)

    def here(self, servo: int) -> int:
        """Where it is, as a goal that it takes."""
        return self._within_limits(servo, self.get(servo, "present_position"))

    def _within_limits(self, servo: int, position: int) -> int:
        return min(max(position, self.get(servo, "min_position_limit")), self.get(servo, "max_position_limit"))

    def slow(self, servo: int, seconds: float = HOLD_S) -> None:
        """A profile of `seconds`, read back: 0, its value after a restart, is full speed."""
        total = units.MILLISECONDS.raw(seconds)
        for name, value in _profile(total):
            self.put(servo, name, value)
        if again(self.bus.read_block, [servo], PROFILE)[servo] != (total // 4, total):
            raise ServoRefused(self.bus.name, "take its motion profile", servo, 0, "it reads back another one")

    def slow_all(self, seconds: float) -> None:
        """The same for the joints, in five transactions: a trapezoid with a quarter of the time at either end."""
        total = units.MILLISECONDS.raw(seconds)
        for _ in range(3):
            for name, value in _profile(total):
                self.bus.write_all(name, dict.fromkeys(JOINTS, value))
            found = again(self.bus.read_block, JOINTS, PROFILE)
            wrong = {servo: got for servo, got in found.items() if got != (total // 4, total)}
            if not wrong:
                return
        servo, got = next(iter(wrong.items()))
        raise ServoRefused(self.bus.name, "take its motion profile", servo, 0, f"it reads back {got}")

    def send(self, goals: dict[int, int]) -> None:
        """Goal positions, all in one packet, read back: nobody confirms a packet to all."""
        for _ in range(3):
            self.bus.write_all("goal_position", goals)
            found = self.of_joints("goal_position")
            wrong = [servo for servo in goals if found[servo] != goals[servo]]
            if not wrong:
                return
        raise ServoRefused(self.bus.name, f"go to {goals[wrong[0]]}", wrong[0], 0, "its goal stays what it was")

    def hold(self, servo: int) -> None:
        """Stand still where it is, in position mode with the torque on."""
        present, aim = self.get(servo, "present_position"), self.get(servo, "position_trajectory")
        if abs(aim - present) <= HOLD_SLACK:  # holding what it aims at, it does not sag a little more each time
            present = aim
        self.put(servo, "profile_acceleration", 0)
        self.put(servo, "profile_velocity", units.MILLISECONDS.raw(HOLD_S))
        self.put(servo, "goal_position", self._within_limits(servo, present))

    def catch(self, servo: int) -> bool:
        """Switch a servo on again where it is, whatever its mode. True if it then has torque."""
        with contextlib.suppress(BusError):
            if not self.get(servo, "torque_enable"):
                number = self.get(servo, "operating_mode")
                mode = next((name for name, value in reg.MODES.items() if value == number), "position")
                if mode not in ("velocity", "current"):
                    self.slow(servo)
                    mode = "position"
                self._goal_here(servo, mode, 0)
                self.put(servo, "torque_enable", 1)
            return True
        return False


def _profile(total: int):
    return ("profile_acceleration", 0), ("profile_velocity", total), ("profile_acceleration", total // 4)
