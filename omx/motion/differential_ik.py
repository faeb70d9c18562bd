"""Inverse kinematics by velocities: the Jacobian inverted with damping, and the iteration built on it.

The task is (x, y, z, pitch). So that millimetres and radians can be weighed against each other, a radian counts as
`RADIAN_MM` millimetres; damping has then the unit mm.
"""

from dataclasses import dataclass

import numpy as np

from .. import kinematics
from ..arrays import as_count, as_number, as_rows, wrap
from ..dh import Chain
from ..errors import BadInput
from ..geometry import COURSE, Geometry, as_arm
from ..kinematics import JOINT_ANGLES, TASK_POSE
from ..rotation import to_vector

#: How many millimetres one radian of pitch counts as: the length of the hand.
RADIAN_MM = 126.0

_WEIGHTS = np.array([1.0, 1.0, 1.0, RADIAN_MM])


@dataclass(frozen=True)
class Iteration:
    """What an iterative inverse did: the final `q` (joints,) rad; `converged`; `steps`; `errors`, one (mm) a step.

    `path` (steps + 1, joints) has the joint values after each step, the start first.
    """

    q: np.ndarray
    converged: bool
    steps: int
    errors: np.ndarray
    path: np.ndarray


def task_jacobian(q, geometry: Geometry = COURSE) -> np.ndarray:
    """d(x, y, z, pitch)/dq, (..., 4, 4): the linear rows of the Jacobian (mm/rad), then the row of the pitch."""
    J = kinematics.jacobian(q, geometry)
    pitch = np.broadcast_to([0.0, -1.0, -1.0, -1.0], (*J.shape[:-2], 1, 4))
    return np.concatenate([J[..., :3, :], pitch], axis=-2)


def manipulability(q, geometry: Geometry = COURSE) -> np.ndarray:
    """|det| of the task Jacobian (mm^3/rad^3), (...): 0 where the arm is singular, = L2 L3 r |cos(q3 - delta)|."""
    return np.abs(np.linalg.det(task_jacobian(q, geometry)))


def joint_velocity(q, velocity, damping: float = 0.0, geometry: Geometry = COURSE) -> np.ndarray:
    """Joint velocities (..., 4) rad/s that give the tool `velocity` at `q`, one for each or one for all.

    With `damping` > 0 the answer is the least-squares compromise between following and moving little (damped least
    squares): at most |velocity| / (2 damping), even where the arm is singular. With 0 it is exact, and
    `numpy.linalg.LinAlgError` or huge values say where it is not possible. Raises `BadInput`.

    Args:
        q: joint angles (..., 4), rad.
        velocity: of x, y, z (mm/s) and pitch (rad/s), (..., 4).
        damping: in mm, 0 or more.
        geometry: the arm's lengths.
    """
    velocity = as_rows(velocity, "velocity", 4, "x, y, z in mm/s and pitch in rad/s")
    damping = as_number(damping, "damping", "0 to 1e100 mm", low=0.0, high=1e100)
    J = task_jacobian(q, geometry) * _WEIGHTS[:, None]
    _one_for_each(J.shape[:-2], "q", velocity.shape[:-1], "velocity")
    return damped(J, velocity * _WEIGHTS, damping)


def task_error(pose, q, geometry: Geometry = COURSE) -> np.ndarray:
    """`pose` minus the pose at `q`, (..., 4): mm, and the pitch (rad) the short way round; half a turn counts up."""
    pose = as_rows(pose, "pose", 4, TASK_POSE)
    here = np.asarray(kinematics.pose(q, geometry))
    _one_for_each(pose.shape[:-1], "pose", here.shape[:-1], "q")
    error = pose - here
    error[..., 3] = wrap(error[..., 3])
    return error


def iterate(
    pose, start, damping: float = 1.0, steps: int = 100, tolerance: float = 1e-6, geometry: Geometry | Chain = COURSE
) -> Iteration:
    """Newton's way to the inverse: step by step from `start` towards `pose`, for this arm or any `Chain`.

    It finds one solution, near the start if all goes well; it does not know joint limits, and cannot tell "out of
    reach" from "stuck". Compare `omx.ik`. Raises `BadInput`.

    Args:
        pose: where the tool should be. For a `Geometry` x, y, z (mm) and pitch (rad), (4,). For a `Chain` the tip's
            position alone, (3,) mm, or position and rotation, a transform (4, 4).
        start: joint values (joints,), rad (mm where prismatic).
        damping: in mm, 0 or more; see `joint_velocity`.
        steps: the most steps to take.
        tolerance: stop when the error, a radian weighed as 126 mm, is below this (mm).
        geometry: the arm.
    """
    arm = as_arm(geometry)
    damping = as_number(damping, "damping", "0 to 1e100 mm", low=0.0, high=1e100)
    steps, tolerance = as_count(steps, "steps", 0), as_number(tolerance, "tolerance", "0 mm or more", low=0.0)
    task = _chain_task(pose, arm) if isinstance(arm, Chain) else _pose_task(pose, arm)
    joints = len(arm) if isinstance(arm, Chain) else 4
    wanted = "one joint value for each joint" if joints != 4 else JOINT_ANGLES
    q = as_rows(start, "start", joints, wanted, many=False).copy()
    path, errors = [q.copy()], []
    for _ in range(steps + 1):
        error, J = task(q)
        errors.append(float(np.linalg.norm(error)))
        if errors[-1] < tolerance or len(path) > steps:
            break
        q = q + damped(J, error, damping)
        if not np.isfinite(q).all():
            raise BadInput("the steps grow beyond all numbers: start somewhere else, or with more `damping`.")
        path.append(q.copy())
    return Iteration(q, errors[-1] < tolerance, len(path) - 1, np.array(errors), np.array(path))


def _pose_task(pose, geometry):
    """q -> the weighed error of x, y, z, pitch and its Jacobian."""
    pose = as_rows(pose, "pose", 4, TASK_POSE, many=False)
    return lambda q: (
        task_error(pose, q, geometry) * _WEIGHTS,
        task_jacobian(q, geometry) * _WEIGHTS[:, None],
    )


def _chain_task(pose, chain: Chain):
    """q -> the error of a chain's tip (mm), and of its rotation, if that is asked for, and the Jacobian."""
    if np.shape(pose) == (4, 4):
        goal = as_rows(pose, "pose", 4, "a transform (4, 4)")
        point, rotation = goal[:3, 3], goal[:3, :3]
    else:
        wanted = f"the tip's x, y, z in mm, or a transform (4, 4), for {chain!r}"
        point, rotation = as_rows(pose, "pose", 3, wanted, many=False), None

    def task(q):
        T, J = chain.fk(q), chain.jacobian(q)
        if rotation is None:
            return point - T[:3, 3], J[:3]
        turn = to_vector(rotation @ T[:3, :3].T)
        weights = np.repeat([1.0, RADIAN_MM], 3)
        return np.concatenate([point - T[:3, 3], turn]) * weights, J * weights[:, None]

    return task


def damped(J, wanted, damping: float = 0.0) -> np.ndarray:
    """The joint steps for the task steps `wanted` (..., m); the least ones where J (..., m, n) is not square."""
    if damping == 0 and J.shape[-1] == J.shape[-2]:
        return np.linalg.solve(J, wanted[..., None])[..., 0]
    if damping == 0:
        return (np.linalg.pinv(J) @ wanted[..., None])[..., 0]
    turned = np.swapaxes(J, -1, -2)
    inner = J @ turned + damping**2 * np.eye(J.shape[-2])
    return (turned @ np.linalg.solve(inner, wanted[..., None]))[..., 0]


def _one_for_each(first: tuple, name: str, second: tuple, other: str) -> None:
    try:
        np.broadcast_shapes(first, second)
    except ValueError:
        raise BadInput(
            f"`{name}` and `{other}` must have a row for each other, or one for all; got {first} and {second} rows."
        ) from None
