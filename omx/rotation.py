"""A rotation matrix as three angles, roll, pitch, yaw, or as a vector: an axis times an angle.

Convention of the angles: R = Rz(yaw) Ry(pitch) Rx(roll). Read from left to right, these are turns about the axes of the
moving frame (z, then the new y, then the newest x); read from right to left, about the fixed axes x, y, z.
"""

import math
from typing import NamedTuple

import numpy as np

from .arrays import as_number, as_rows
from .errors import BadInput


class RPY(NamedTuple):
    """Roll about x, pitch about y, yaw about z, in rad; pitch in [-pi/2, pi/2], the others in (-pi, pi]."""

    roll: float
    pitch: float
    yaw: float


def from_rpy(roll: float, pitch: float, yaw: float) -> np.ndarray:
    """`Rz(yaw) Ry(pitch) Rx(roll)`, (3, 3)."""
    roll, pitch, yaw = (as_number(v, n, "an angle in rad") for v, n in ((roll, "roll"), (pitch, "pitch"), (yaw, "yaw")))
    cr, sr, cp, sp = math.cos(roll), math.sin(roll), math.cos(pitch), math.sin(pitch)
    cy, sy = math.cos(yaw), math.sin(yaw)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def to_rpy(R) -> RPY:
    """Roll, pitch and yaw of `R`, a (3, 3) rotation or a (4, 4) transform.

    At pitch = +-90 deg only yaw - roll (or their sum) is determined; roll is 0 then. The three make `R` again to
    1e-13, also beside such a place. Raises `BadInput` if `R` is not a rotation (to 1e-6).
    """
    columns = 4 if np.shape(R)[-1:] == (4,) else 3
    R = as_rows(R, "R", columns, "a rotation (3, 3) or a transform (4, 4)")
    if R.shape not in ((3, 3), (4, 4)):
        raise BadInput(f"`R` must be a rotation (3, 3) or a transform (4, 4); got shape {R.shape}.")
    R = R[:3, :3]
    if not (np.allclose(R.T @ R, np.eye(3), atol=1e-6) and np.linalg.det(R) > 0):
        raise BadInput("`R` must be a rotation: orthonormal columns and determinant +1; this matrix is not.")
    level = math.hypot(R[0, 0], R[1, 0])
    pitch = math.atan2(-R[2, 0], level)
    if level < 1e-13:
        return RPY(0.0, pitch, math.atan2(-R[0, 1], R[1, 1]))
    yaw = math.atan2(R[1, 0], R[0, 0])
    cy, sy = math.cos(yaw), math.sin(yaw)  # roll from what the yaw leaves: near +-90 deg the two must fit each other
    return RPY(math.atan2(sy * R[0, 2] - cy * R[1, 2], cy * R[1, 1] - sy * R[0, 1]), pitch, yaw)


def rigid(rotation, place) -> np.ndarray:
    """The transform (4, 4) that turns by `rotation` (3, 3) and then shifts by `place` (3,), mm."""
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = rotation, place
    return T


def from_vector(vector) -> np.ndarray:
    """The rotation (3, 3) about `vector` (3,) by its length (rad): Rodrigues' formula."""
    vector = as_rows(vector, "vector", 3, "an axis times an angle in rad", many=False)
    angle = float(np.linalg.norm(vector))
    x, y, z = vector / angle if angle > 1e-12 else vector
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + (math.sin(angle) * K + (1 - math.cos(angle)) * K @ K if angle > 1e-12 else K)


def to_vector(R) -> np.ndarray:
    """Axis times angle (3,), rad, of a rotation (3, 3): the short way, and for half a turn either of the two."""
    R = as_rows(R, "R", 3, "a rotation matrix (3, 3)")
    if R.shape != (3, 3):
        raise BadInput(f"`R` must be a rotation matrix (3, 3); got shape {R.shape}.")
    axis = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    sine, cosine = 0.5 * np.linalg.norm(axis), 0.5 * (np.trace(R) - 1.0)
    if sine < 1e-9 and cosine < 0:
        outer = 0.5 * (R + np.eye(3))
        column = outer[:, int(np.argmax(np.diag(outer)))]
        return np.pi * column / np.linalg.norm(column)
    return axis * (0.5 if sine < 1e-9 else 0.5 * math.atan2(sine, cosine) / sine)
