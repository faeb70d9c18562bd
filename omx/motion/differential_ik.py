"""Inverse kinematics by velocities: the Jacobian inverted with damping, and the iteration built on it.

The task is (x, y, z, pitch). So that millimetres and radians can be weighed against each other, a radian of pitch
counts as `RADIAN_MM` millimetres; damping has then the unit mm.
"""

from dataclasses import dataclass
from math import pi, tau

import numpy as np

from ..arrays import as_rows
from ..errors import BadInput
from ..geometry import COURSE, Geometry
from ..kinematics import JOINT_ANGLES, TASK_POSE, jacobian, pose

#: How many millimetres one radian of pitch counts as: the length of the hand.
RADIAN_MM = 126.0

_WEIGHTS = np.array([1.0, 1.0, 1.0, RADIAN_MM])


@dataclass(frozen=True)
class Iteration:
    """What an iterative inverse did: the final `q` (4,) rad; `converged`; `steps`; `errors`, one (mm) a step.

    `path` (steps + 1, 4) has the joint angles after each step, the start first.
    """

    q: np.ndarray
    converged: bool
    steps: int
    errors: np.ndarray
    path: np.ndarray


def task_jacobian(q, geometry: Geometry = COURSE) -> np.ndarray:
    """d(x, y, z, pitch)/dq, (..., 4, 4): the linear rows of the Jacobian (mm/rad), then the row of the pitch."""
    J = jacobian(q, geometry)
    pitch = np.broadcast_to([0.0, -1.0, -1.0, -1.0], (*J.shape[:-2], 1, 4))
    return np.concatenate([J[..., :3, :], pitch], axis=-2)


def manipulability(q, geometry: Geometry = COURSE) -> np.ndarray:
    """|det| of the task Jacobian (mm^3/rad^3), (...): 0 where the arm is singular, = L2 L3 r |cos(q3 - delta)|."""
    return np.abs(np.linalg.det(task_jacobian(q, geometry)))


def joint_velocity(q, velocity, damping: float = 0.0, geometry: Geometry = COURSE) -> np.ndarray:
    """Joint velocities (4,) rad/s that give the tool `velocity` [x, y, z, pitch] (mm/s, rad/s) at `q` (rad).

    With `damping` (mm) > 0 the answer is the least-squares compromise between following and moving little (damped
    least squares): at most |velocity| / (2 damping), even where the arm is singular. With 0 it is exact, and
    `numpy.linalg.LinAlgError` or huge values say where it is not possible.
    """
    velocity = as_rows(velocity, "velocity", 4, "x, y, z in mm/s and pitch in rad/s")
    if not damping >= 0:
        raise BadInput(f"`damping` must be 0 mm or more; got {damping}.")
    J = task_jacobian(q, geometry) * _WEIGHTS[:, None]
    wanted = velocity * _WEIGHTS
    if damping == 0:
        return np.linalg.solve(J, wanted)
    return J.T @ np.linalg.solve(J @ J.T + damping**2 * np.eye(4), wanted)


def task_error(target, q, geometry: Geometry = COURSE) -> np.ndarray:
    """`target` minus the pose at `q`, (4,): mm, and the pitch (rad) the short way round."""
    error = np.asarray(target, dtype=float) - pose(q, geometry)
    error[3] = pi - (pi - error[3]) % tau
    return error


def iterate(
    target, start, damping: float = 1.0, steps: int = 100, tolerance: float = 1e-6, geometry: Geometry = COURSE
) -> Iteration:
    """Newton's way to the inverse: step by step from `start` (rad) towards `target` [x, y, z, pitch] (mm, rad).

    Stops when the weighed error is below `tolerance` (mm), or after `steps`. It finds one solution, near the start if
    all goes well; it does not know joint limits, and cannot tell "out of reach" from "stuck". Compare `omx.ik`.
    """
    target = as_rows(target, "target", 4, TASK_POSE)
    q = as_rows(start, "start", 4, JOINT_ANGLES).copy()
    path, errors = [q.copy()], []
    for _ in range(steps + 1):
        error = task_error(target, q, geometry)
        errors.append(float(np.linalg.norm(error * _WEIGHTS)))
        if errors[-1] < tolerance or len(path) > steps:
            break
        q = q + joint_velocity(q, error, damping, geometry)
        path.append(q.copy())
    return Iteration(q, errors[-1] < tolerance, len(path) - 1, np.array(errors), np.array(path))
