"""The control loops of a servo: what its mode, its goals and its gains ask of the motor."""

from ...arm import STALL_TORQUE, SUPPLY_VOLTS
from ..dynamixel import units
from ..dynamixel.registers import MODES
from .joint import COAST, STIFFNESS, TORQUE_PER_MA, Drive

POSITION_MODES = (MODES["position"], MODES["extended"], MODES["current_position"])
_FULL_PWM = 885
_P_GAIN = 800  # the factory's, at which the controller is as stiff as STIFFNESS


class Controller:
    """Turns registers into a `Drive`; remembers what the integral gain has gathered (Nm)."""

    def __init__(self, servo):
        self._servo = servo
        self._integral = 0.0

    def reset(self):
        """Forget what was gathered."""
        self._integral = 0.0

    def drive(self, now: float, dt: float) -> Drive:
        """What is asked of the motor for the next `dt` s."""
        servo, table = self._servo, self._servo.table
        if not servo.torque_on or not servo.powered:
            return COAST
        mode, sign = table["operating_mode"], servo.sign
        full = STALL_TORQUE * servo.volts / SUPPLY_VOLTS
        limit = full * min(abs(table["goal_pwm"]), table["pwm_limit"]) / _FULL_PWM
        push = units.CURRENT.value(table["goal_current"]) * TORQUE_PER_MA
        if mode == MODES["pwm"]:
            return Drive(full, torque=sign * full * table["goal_pwm"] / _FULL_PWM)
        if mode == MODES["current"]:
            return Drive(limit, torque=sign * push)
        position, speed = servo.trajectory.at(now)
        if mode == MODES["velocity"]:
            return Drive(limit, speed=sign * units.ANGLE.value(speed))
        if mode == MODES["current_position"]:
            limit = min(limit, abs(push))
        return self._position(servo.angle_at(position), limit, dt)

    def _position(self, target: float, limit: float, dt: float) -> Drive:
        table = self._servo.table
        gain = table["position_i_gain"]
        if gain:  # the manual's scales: P / 128 of the error, and I / 65536 of it every millisecond
            rate = STIFFNESS / _P_GAIN * 128 * gain / 65536 * 1000
            gathered = self._integral + rate * (target - self._servo.joint.angle) * dt
            self._integral = min(max(gathered, -limit), limit)
        return Drive(limit, self._integral, STIFFNESS * table["position_p_gain"] / _P_GAIN, target)

    @property
    def gathering(self) -> bool:
        """True if the integral gain is at work: then the joint creeps even when it seems to stand."""
        return self._servo.torque_on and bool(self._servo.table["position_i_gain"])
