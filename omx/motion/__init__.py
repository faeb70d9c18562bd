"""Motion over time: trajectories, straight lines and where they end, velocities and iterative inverse kinematics."""

from .differential_ik import iterate, joint_velocity, manipulability, task_error, task_jacobian
from .trajectory import Trajectory, cubic, joint_move, joint_path, joint_spline, line, quintic, trapezoid

__all__ = [
    "Trajectory", "cubic", "iterate", "joint_move", "joint_path", "joint_spline", "joint_velocity", "line",
    "manipulability", "quintic", "task_error", "task_jacobian", "trapezoid",
]  # fmt: skip
