"""Independent authorities for the kinematics: elementary 4x4 moves multiplied with NumPy, and pinocchio.

Nothing here uses the formulas of omx: the DH table of the lab is typed in again, and every link matrix is the
product of its four moves. Lengths in mm, angles in rad.
"""

from math import asin, cos, pi, sin

import numpy as np
import pytest

import omx

#: The lengths as the lab prints them: L1, L2, L3, L4, delta.
COURSE = (77.0, 130.0, 124.0, 126.0, asin(24 / 130))

#: How near to a degenerate place the tests go.
NEAR = (0.0, 1e-15, -1e-15, 1e-12, -1e-12, 1e-9, -1e-9, 1e-6, -1e-6, 1e-3, -1e-3)


def turn_z(angle):
    return np.array([[cos(angle), -sin(angle), 0, 0], [sin(angle), cos(angle), 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])


def turn_x(angle):
    return np.array([[1, 0, 0, 0], [0, cos(angle), -sin(angle), 0], [0, sin(angle), cos(angle), 0], [0, 0, 0, 1]])


def shift(x=0.0, z=0.0):
    return np.array([[1, 0, 0, x], [0, 1, 0, 0], [0, 0, 1, z], [0, 0, 0, 1]], dtype=float)


def link(theta, d, a, alpha):
    """A_i, standard convention: Rz(theta) Tz(d) Tx(a) Rx(alpha)."""
    return turn_z(theta) @ shift(z=d) @ shift(x=a) @ turn_x(alpha)


def table(L1, L2, L3, L4, delta):
    """The lab's DH table: (theta offset, d, a, alpha) of each joint."""
    return ((0, L1, 0, -pi / 2), (delta - pi / 2, 0, L2, 0), (pi / 2 - delta, 0, L3, 0), (0, 0, L4, 0))


def product(rows, q, prismatic=()):
    """T_0_1 .. T_0_n of a table at one configuration; `prismatic` holds the indices of sliding joints."""
    T, frames = np.eye(4), []
    for i, ((theta, d, a, alpha), variable) in enumerate(zip(rows, q, strict=True)):
        moved = (theta, d + variable) if i in prismatic else (theta + variable, d)
        T = T @ link(*moved, a, alpha)
        frames.append(T)
    return frames


def arm_frames(q, lengths=COURSE):
    """T_0_1 .. T_0_4 of the arm at one configuration."""
    return product(table(*lengths), q)


def task_pose(T):
    """(x, y, z, pitch) of the tool frame: the pitch is that of its x axis, positive upwards."""
    return np.array([*T[:3, 3], np.arctan2(T[2, 0], -T[2, 1])])


def angle_gap(a, b):
    """The smallest turn between two angles, elementwise."""
    return np.abs((np.asarray(a) - b + pi) % (2 * pi) - pi)


def pose_gap(a, b):
    """How far apart two task poses (..., 4) are: mm, and rad for the pitch, whichever is more."""
    a, b = np.asarray(a), np.asarray(b)
    return np.maximum(np.abs(a[..., :3] - b[..., :3]).max(-1), angle_gap(a[..., 3], b[..., 3]))


def pinocchio_arm(rows, prismatic=()):
    """(pinocchio, model, data, tool frame id) of a table; the test is skipped where pinocchio is missing."""
    pin = pytest.importorskip("pinocchio")
    model, parent, fixed = pin.Model(), 0, np.eye(4)
    for i, row in enumerate(rows):
        joint = pin.JointModelPZ() if i in prismatic else pin.JointModelRZ()
        parent = model.addJoint(parent, joint, pin.SE3(fixed), f"joint {i + 1}")
        fixed = link(*row)
    tool = model.addFrame(pin.Frame("tool", parent, 0, pin.SE3(fixed), pin.FrameType.OP_FRAME))
    return pin, model, model.createData(), tool


def random_q(count, seed=0, limits=omx.LIMITS):
    """Configurations (count, 4) spread evenly within limits."""
    low, high = np.array(limits).T
    return np.random.default_rng(seed).uniform(low, high, (count, 4))


def any_q(count, seed=0):
    """Configurations (count, 4) spread evenly over every angle, legal or not."""
    return random_q(count, seed, [(-pi, pi)] * 4)


def degenerate_q(seed=0):
    """Configurations on and very near the places where formulas break, some legal and some not."""
    delta = COURSE[4]
    special = {
        "straight": (2, delta - pi / 2),
        "folded": (2, delta + pi / 2),
        "half a turn of q1": (0, pi),
        "half a turn back": (0, -pi),
        **{f"q{j + 1} at {end}": (j, limit) for j in range(4) for end, limit in enumerate(omx.LIMITS[j])},
    }
    rows = []
    for number, (joint, value) in enumerate(special.values()):
        q = any_q(len(NEAR), seed + number)
        q[:, joint] = value + np.array(NEAR)
        rows.append(q)
    return np.concatenate([*rows, over_the_axis(seed)])


def over_the_axis(seed=0):
    """Configurations whose tool is on, or very near, the axis of joint 1."""
    _, L2, L3, L4, delta = COURSE
    q = any_q(400, seed)
    cosine = -(L2 * np.sin(q[:, 1] + delta) + L3 * np.cos(q[:, 1] + q[:, 2])) / L4
    q = q[np.abs(cosine) < 1]
    q[:, 3] = np.arccos(cosine[np.abs(cosine) < 1]) - q[:, 1] - q[:, 2]
    return q + np.resize(NEAR, len(q))[:, None] * [0, 0, 0, 1]
