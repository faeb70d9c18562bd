"""The control loops of a servo: what its mode, its goals and its gains ask of the motor."""

from math import inf

from ...arm import STIFFNESS, TICKS_PER_TURN, TORQUE_PER_MA, ZERO_TICK
from ..dynamixel import registers as reg
from ..dynamixel import units
from ..dynamixel.registers import MODES
from .control_table import Table
from .joint import Drive

POSITION_MODES = (MODES["position"], MODES["extended"], MODES["current_position"])
FULL_PWM = 885
_P_GAIN = 800  # the factory's, at which the controller is as stiff as STIFFNESS
_QUARTER_TURN = TICKS_PER_TURN // 4


class Settings:
    """What the registers of `table` come to in Nm, rad and s: worked out after a write, looked at in every step.

    `mount`: by how much (rad) the horn was screwed on wrong; `turns`: the whole turns that the servo has counted.
    """

    def __init__(self, table: Table, mount: float, turns: int):
        self.torque_on = bool(table["torque_enable"])
        self.mode, offset = table["operating_mode"], table["homing_offset"]
        #: -1 in reverse mode: then all that has a direction is mirrored in the registers.
        self.sign = -1 if table["drive_mode"] & reg.DRIVE_REVERSE else 1
        #: The homing offset (ticks) as far as it counts: in position mode only up to a quarter turn.
        self.offset = 0 if self.mode == MODES["position"] and abs(offset) > _QUARTER_TURN else offset
        #: The tick at which the joint is at 0 rad.
        self.zero = ZERO_TICK + self.sign * mount / units.ANGLE.scale + self.offset + TICKS_PER_TURN * turns
        self.goal_pwm = table["goal_pwm"]
        self.most_pwm = min(abs(self.goal_pwm), table["pwm_limit"])
        self.push = units.CURRENT.value(table["goal_current"]) * TORQUE_PER_MA
        #: What is asked of the motor; what changes in it from step to step the controller fills in.
        self.drive = Drive()
        if self.mode in POSITION_MODES:
            self.drive.stiffness = STIFFNESS * table["position_p_gain"] / _P_GAIN
        #: Nm that the integral gain gathers in a second for each rad: the manual has P / 128 and I / 65536 every ms.
        self.gathers = STIFFNESS / _P_GAIN * 128 * table["position_i_gain"] / 65536 * 1000
        self.voltages = table["min_voltage_limit"], table["max_voltage_limit"]
        armed = self.torque_on and 0 < table["bus_watchdog"] < reg.WATCHDOG_TRIPPED
        #: After so long (s) without a packet the watchdog trips; never if it is not armed.
        self.patience = units.WATCHDOG.value(table["bus_watchdog"]) if armed else inf


class Controller:
    """Turns settings into a `Drive`; remembers what the integral gain has gathered (Nm)."""

    def __init__(self):
        self.reset()

    def reset(self):
        """Forget what was gathered."""
        self._integral = 0.0
        self.gathering = False  # whether the integral gain still works: then a joint creeps that seems to stand

    def drive(self, asked: Settings, full: float, at: float, target: float, speed: float, dt: float) -> Drive:
        """What is asked of the motor for the next `dt` s.

        `full`: the torque (Nm) that the supply allows. `at`: where the joint is (rad). `target`, `speed`: angle and
        speed (rad, rad/s) of the set-point.
        """
        mode, drive = asked.mode, asked.drive
        drive.limit = full * asked.most_pwm / FULL_PWM
        if mode in POSITION_MODES:
            drive.full = drive.limit
            if mode == MODES["current_position"]:
                drive.limit = min(drive.limit, abs(asked.push))
            if asked.gathers or self.gathering:
                self._gather(asked.gathers, target - at, drive.limit, dt)
            drive.torque, drive.target = self._integral, target
        elif mode == MODES["pwm"]:
            drive.limit, drive.torque = full, asked.sign * full * asked.goal_pwm / FULL_PWM
        elif mode == MODES["current"]:
            drive.torque = asked.sign * asked.push
        else:  # velocity
            drive.speed = speed
        return drive

    def _gather(self, rate: float, error: float, limit: float, dt: float):
        """The servo sees whole ticks: an error below half of one is none, and there the joint comes to rest."""
        before = self._integral
        if rate:
            seen = units.ANGLE.value(units.ANGLE.raw(error))
            self._integral = min(max(before + rate * seen * dt, -limit), limit)
        self.gathering = self._integral != before
