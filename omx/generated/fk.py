"""Forward kinematics of the OpenMANIPULATOR-X.

Written by notebooks/03-forward-kinematics.ipynb. Do not edit: change the chapter and run it.
Lengths are in mm, angles in rad. `..._batch` is the same formula for columns: arrays of one
shape, NumPy's or those of another library that keeps to the array API standard.
"""

from math import asin, cos, pi, remainder, sin, tau

from omx.arrays import Array, sincos, wrap
from omx.dh import DHRow

#: The arm's lengths (mm) and angles (rad), in the order in which every function takes them.
PARAMETERS = {
    "L1": 77.0,
    "L2": 130.0,
    "L3": 124.0,
    "L4": 126.0,
    "delta": asin(12/65),  # 0.185681
}


def dh_rows(L1: float, L2: float, L3: float, L4: float, delta: float) -> tuple[DHRow, ...]:
    """The DH table, a row a joint: theta or d holds the offset that the joint variable is added to."""
    return (
        DHRow(0.0, L1, 0.0, -pi/2),
        DHRow(delta - pi/2, 0.0, L2, 0.0),
        DHRow(pi/2 - delta, 0.0, L3, 0.0),
        DHRow(0.0, 0.0, L4, 0.0),
    )


def pose(
    q1: float, q2: float, q3: float, q4: float,
    L1: float, L2: float, L3: float, L4: float, delta: float,
) -> tuple[float, float, float, float]:
    """Tool position x, y, z and pitch. 19 operations and 8 sines and cosines."""
    s1, c1 = sin(q1), cos(q1)
    q23 = q2 + q3
    s23, c23 = sin(q23), cos(q23)
    q2_delta = q2 + delta
    s2_delta, c2_delta = sin(q2_delta), cos(q2_delta)
    q234 = q2 + q3 + q4
    s234, c234 = sin(q234), cos(q234)
    r = L2*s2_delta + L3*c23 + L4*c234
    z = L1 + L2*c2_delta - L3*s23 - L4*s234
    x = r*c1
    y = r*s1
    pitch = remainder(-q234, tau)
    return x, y, z, pitch


def pose_batch(
    q1: Array, q2: Array, q3: Array, q4: Array,
    L1: float, L2: float, L3: float, L4: float, delta: float,
) -> tuple[Array, Array, Array, Array]:
    """Tool position x, y, z and pitch. Columns in, columns out."""
    s1, c1 = sincos(q1)
    q23 = q2 + q3
    s23, c23 = sincos(q23)
    q2_delta = q2 + delta
    s2_delta, c2_delta = sincos(q2_delta)
    q234 = q2 + q3 + q4
    s234, c234 = sincos(q234)
    r = L2*s2_delta + L3*c23 + L4*c234
    z = L1 + L2*c2_delta - L3*s23 - L4*s234
    x = r*c1
    y = r*s1
    pitch = wrap(-q234)
    return x, y, z, pitch


def transform(
    q1: float, q2: float, q3: float, q4: float,
    L1: float, L2: float, L3: float, L4: float, delta: float,
) -> tuple:
    """T_base_tool, as rows of the 4x4 matrix. 26 operations and 8 sines and cosines."""
    s1, c1 = sin(q1), cos(q1)
    q23 = q2 + q3
    s23, c23 = sin(q23), cos(q23)
    q2_delta = q2 + delta
    s2_delta, c2_delta = sin(q2_delta), cos(q2_delta)
    q234 = q2 + q3 + q4
    s234, c234 = sin(q234), cos(q234)
    r = L2*s2_delta + L3*c23 + L4*c234
    z = L1 + L2*c2_delta - L3*s23 - L4*s234
    return (
        (c1*c234, -c1*s234, -s1, r*c1),
        (s1*c234, -s1*s234, c1, r*s1),
        (-s234, -c234, 0, z),
        (0, 0, 0, 1),
    )


def transform_batch(
    q1: Array, q2: Array, q3: Array, q4: Array,
    L1: float, L2: float, L3: float, L4: float, delta: float,
) -> tuple:
    """T_base_tool, as rows of the 4x4 matrix. Columns in, columns out; constants are plain numbers."""
    s1, c1 = sincos(q1)
    q23 = q2 + q3
    s23, c23 = sincos(q23)
    q2_delta = q2 + delta
    s2_delta, c2_delta = sincos(q2_delta)
    q234 = q2 + q3 + q4
    s234, c234 = sincos(q234)
    r = L2*s2_delta + L3*c23 + L4*c234
    z = L1 + L2*c2_delta - L3*s23 - L4*s234
    return (
        (c1*c234, -c1*s234, -s1, r*c1),
        (s1*c234, -s1*s234, c1, r*s1),
        (-s234, -c234, 0, z),
        (0, 0, 0, 1),
    )


def frames(
    q1: float, q2: float, q3: float, q4: float,
    L1: float, L2: float, L3: float, L4: float, delta: float,
) -> tuple:
    """T_0_1 .. T_0_4, each as rows of a 4x4 matrix. 47 operations and 8 sines and cosines."""
    s1, c1 = sin(q1), cos(q1)
    q23 = q2 + q3
    s23, c23 = sin(q23), cos(q23)
    q2_delta = q2 + delta
    s2_delta, c2_delta = sin(q2_delta), cos(q2_delta)
    q234 = q2 + q3 + q4
    s234, c234 = sin(q234), cos(q234)
    r_2 = L2*s2_delta
    z_2 = L1 + L2*c2_delta
    r_3 = L3*c23 + r_2
    z_3 = z_2 - L3*s23
    r_4 = L4*c234 + r_3
    z_4 = z_3 - L4*s234
    T_0_1 = (
        (c1, 0, -s1, 0),
        (s1, 0, c1, 0),
        (0, -1, 0, L1),
        (0, 0, 0, 1),
    )
    T_0_2 = (
        (c1*s2_delta, c1*c2_delta, -s1, r_2*c1),
        (s1*s2_delta, s1*c2_delta, c1, r_2*s1),
        (c2_delta, -s2_delta, 0, z_2),
        (0, 0, 0, 1),
    )
    T_0_3 = (
        (c1*c23, -c1*s23, -s1, r_3*c1),
        (s1*c23, -s1*s23, c1, r_3*s1),
        (-s23, -c23, 0, z_3),
        (0, 0, 0, 1),
    )
    T_0_4 = (
        (c1*c234, -c1*s234, -s1, r_4*c1),
        (s1*c234, -s1*s234, c1, r_4*s1),
        (-s234, -c234, 0, z_4),
        (0, 0, 0, 1),
    )
    return T_0_1, T_0_2, T_0_3, T_0_4


def frames_batch(
    q1: Array, q2: Array, q3: Array, q4: Array,
    L1: float, L2: float, L3: float, L4: float, delta: float,
) -> tuple:
    """T_0_1 .. T_0_4, each as rows of a 4x4 matrix. Columns in, columns out; constants are plain
    numbers."""
    s1, c1 = sincos(q1)
    q23 = q2 + q3
    s23, c23 = sincos(q23)
    q2_delta = q2 + delta
    s2_delta, c2_delta = sincos(q2_delta)
    q234 = q2 + q3 + q4
    s234, c234 = sincos(q234)
    r_2 = L2*s2_delta
    z_2 = L1 + L2*c2_delta
    r_3 = L3*c23 + r_2
    z_3 = z_2 - L3*s23
    r_4 = L4*c234 + r_3
    z_4 = z_3 - L4*s234
    T_0_1 = (
        (c1, 0, -s1, 0),
        (s1, 0, c1, 0),
        (0, -1, 0, L1),
        (0, 0, 0, 1),
    )
    T_0_2 = (
        (c1*s2_delta, c1*c2_delta, -s1, r_2*c1),
        (s1*s2_delta, s1*c2_delta, c1, r_2*s1),
        (c2_delta, -s2_delta, 0, z_2),
        (0, 0, 0, 1),
    )
    T_0_3 = (
        (c1*c23, -c1*s23, -s1, r_3*c1),
        (s1*c23, -s1*s23, c1, r_3*s1),
        (-s23, -c23, 0, z_3),
        (0, 0, 0, 1),
    )
    T_0_4 = (
        (c1*c234, -c1*s234, -s1, r_4*c1),
        (s1*c234, -s1*s234, c1, r_4*s1),
        (-s234, -c234, 0, z_4),
        (0, 0, 0, 1),
    )
    return T_0_1, T_0_2, T_0_3, T_0_4
