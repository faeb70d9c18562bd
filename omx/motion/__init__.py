"""Motion over time: trajectories, straight lines and where they end, velocities and iterative inverse kinematics.

Paths without times, the torques that a motion asks for, and the fastest timing within limits.
"""

from .differential_ik import iterate, joint_velocity, manipulability, task_error, task_jacobian
from .dynamics import motor_torques
from .paths import Path, in_joints, rounded, spline_path
from .time_optimal import Allowed, controllable, fastest, torque_lines
from .trajectory import Trajectory, cubic, joint_move, legs, line, quintic, trapezoid

__all__ = [
    "Allowed", "Path", "Trajectory", "controllable", "cubic", "fastest", "in_joints", "iterate", "joint_move",
    "joint_velocity", "legs", "line", "manipulability", "motor_torques", "quintic", "rounded", "spline_path",
    "task_error", "task_jacobian", "torque_lines", "trapezoid",
]  # fmt: skip
