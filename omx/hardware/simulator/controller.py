"""The control loops of a servo: what its mode, its goals and its gains ask of the motor."""

from ...arm import STIFFNESS, TORQUE_PER_MA
from ..dynamixel import units
from ..dynamixel.registers import MODES
from .control_table import Table
from .joint import Drive

POSITION_MODES = (MODES["position"], MODES["extended"], MODES["current_position"])
FULL_PWM = 885
_P_GAIN = 800  # the factory's, at which the controller is as stiff as STIFFNESS


class Controller:
    """Turns registers into a `Drive`; remembers what the integral gain has gathered (Nm)."""

    def __init__(self):
        self.reset()

    def reset(self):
        """Forget what was gathered."""
        self._integral = 0.0
        self.gathering = False  # whether the integral gain still works: then a joint creeps that seems to stand

    def drive(self, table: Table, full: float, sign: int, at: float, goal: tuple[float, float], dt: float) -> Drive:
        """What is asked of the motor for the next `dt` s.

        `full`: the torque (Nm) that the supply allows. `at`: where the joint is (rad). `goal`: angle and speed (rad,
        rad/s) of the set-point. `sign`: -1 in reverse mode, where pushes are mirrored.
        """
        mode = table["operating_mode"]
        limit = full * min(abs(table["goal_pwm"]), table["pwm_limit"]) / FULL_PWM
        push = units.CURRENT.value(table["goal_current"]) * TORQUE_PER_MA
        if mode == MODES["pwm"]:
            return Drive(full, torque=sign * full * table["goal_pwm"] / FULL_PWM)
        if mode == MODES["current"]:
            return Drive(limit, torque=sign * push)
        target, speed = goal
        if mode == MODES["velocity"]:
            return Drive(limit, speed=speed)
        voltage = limit
        if mode == MODES["current_position"]:
            limit = min(limit, abs(push))
        self._gather(table["position_i_gain"], target - at, limit, dt)
        return Drive(limit, self._integral, STIFFNESS * table["position_p_gain"] / _P_GAIN, target, full=voltage)

    def _gather(self, gain: int, error: float, limit: float, dt: float):
        """The manual's scales: P / 128 of the error, and I / 65536 of it every millisecond.

        The servo sees whole ticks: an error below half of one is none, and there the joint comes to rest.
        """
        before = self._integral
        if gain:
            rate = STIFFNESS / _P_GAIN * 128 * gain / 65536 * 1000
            seen = units.ANGLE.value(units.ANGLE.raw(error))
            self._integral = min(max(before + rate * seen * dt, -limit), limit)
        self.gathering = self._integral != before
