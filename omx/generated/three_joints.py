"""Forward kinematics of the three-joint arm.

Written by notebooks/10-other-arms.ipynb. Do not edit: change the chapter and run it.
Lengths are in mm, angles in rad. `..._batch` is the same formula for columns: arrays of one
shape, NumPy's or those of another library that keeps to the array API standard.
"""

from math import cos, pi, sin

from omx.arrays import Array, sincos
from omx.dh import DHRow


def dh_rows() -> tuple[DHRow, ...]:
    """The DH table, a row a joint: theta or d holds the offset that the joint variable is added to."""
    return (
        DHRow(0.0, 300.0, 0.0, pi/2),
        DHRow(0.0, 0.0, 500.0, 0.0),
        DHRow(0.0, 0.0, 400.0, 0.0),
    )


def transform(q1: float, q2: float, q3: float) -> tuple:
    """T_0_3, rows of the 4x4 matrix. 53 operations and 6 sines and cosines."""
    s1, c1 = sin(q1), cos(q1)
    s2, c2 = sin(q2), cos(q2)
    s3, c3 = sin(q3), cos(q3)
    ox2 = -c1*s2
    px2 = 500*c1*c2
    oy2 = -s1*s2
    py2 = 500*s1*c2
    pz2 = 300 + 500*s2
    nx3 = c1*c2*c3 + ox2*s3
    ox3 = ox2*c3 - c1*c2*s3
    px3 = 400*c1*c2*c3 + 400*ox2*s3 + px2
    ny3 = s1*c2*c3 + oy2*s3
    oy3 = oy2*c3 - s1*c2*s3
    py3 = 400*s1*c2*c3 + 400*oy2*s3 + py2
    nz3 = c2*s3 + s2*c3
    oz3 = c2*c3 - s2*s3
    pz3 = 400*c2*s3 + 400*s2*c3 + pz2
    return (
        (nx3, ox3, s1, px3),
        (ny3, oy3, -c1, py3),
        (nz3, oz3, 0, pz3),
        (0, 0, 0, 1),
    )


def transform_batch(q1: Array, q2: Array, q3: Array) -> tuple:
    """T_0_3, rows of the 4x4 matrix. Columns in, columns out; constants are plain numbers."""
    s1, c1 = sincos(q1)
    s2, c2 = sincos(q2)
    s3, c3 = sincos(q3)
    ox2 = -c1*s2
    px2 = 500*c1*c2
    oy2 = -s1*s2
    py2 = 500*s1*c2
    pz2 = 300 + 500*s2
    nx3 = c1*c2*c3 + ox2*s3
    ox3 = ox2*c3 - c1*c2*s3
    px3 = 400*c1*c2*c3 + 400*ox2*s3 + px2
    ny3 = s1*c2*c3 + oy2*s3
    oy3 = oy2*c3 - s1*c2*s3
    py3 = 400*s1*c2*c3 + 400*oy2*s3 + py2
    nz3 = c2*s3 + s2*c3
    oz3 = c2*c3 - s2*s3
    pz3 = 400*c2*s3 + 400*s2*c3 + pz2
    return (
        (nx3, ox3, s1, px3),
        (ny3, oy3, -c1, py3),
        (nz3, oz3, 0, pz3),
        (0, 0, 0, 1),
    )


def frames(q1: float, q2: float, q3: float) -> tuple:
    """T_0_1 .. T_0_3, each as rows of a 4x4 matrix. 57 operations and 6 sines and cosines."""
    s1, c1 = sin(q1), cos(q1)
    s2, c2 = sin(q2), cos(q2)
    s3, c3 = sin(q3), cos(q3)
    ox2 = -c1*s2
    px2 = 500*c1*c2
    oy2 = -s1*s2
    py2 = 500*s1*c2
    pz2 = 300 + 500*s2
    nx3 = c1*c2*c3 + ox2*s3
    ox3 = ox2*c3 - c1*c2*s3
    px3 = 400*c1*c2*c3 + 400*ox2*s3 + px2
    ny3 = s1*c2*c3 + oy2*s3
    oy3 = oy2*c3 - s1*c2*s3
    py3 = 400*s1*c2*c3 + 400*oy2*s3 + py2
    nz3 = c2*s3 + s2*c3
    oz3 = c2*c3 - s2*s3
    pz3 = 400*c2*s3 + 400*s2*c3 + pz2
    T_0_1 = (
        (c1, 0, s1, 0),
        (s1, 0, -c1, 0),
        (0, 1, 0, 300),
        (0, 0, 0, 1),
    )
    T_0_2 = (
        (c1*c2, ox2, s1, px2),
        (s1*c2, oy2, -c1, py2),
        (s2, c2, 0, pz2),
        (0, 0, 0, 1),
    )
    T_0_3 = (
        (nx3, ox3, s1, px3),
        (ny3, oy3, -c1, py3),
        (nz3, oz3, 0, pz3),
        (0, 0, 0, 1),
    )
    return T_0_1, T_0_2, T_0_3


def frames_batch(q1: Array, q2: Array, q3: Array) -> tuple:
    """T_0_1 .. T_0_3, each as rows of a 4x4 matrix. Columns in, columns out; constants are plain
    numbers."""
    s1, c1 = sincos(q1)
    s2, c2 = sincos(q2)
    s3, c3 = sincos(q3)
    ox2 = -c1*s2
    px2 = 500*c1*c2
    oy2 = -s1*s2
    py2 = 500*s1*c2
    pz2 = 300 + 500*s2
    nx3 = c1*c2*c3 + ox2*s3
    ox3 = ox2*c3 - c1*c2*s3
    px3 = 400*c1*c2*c3 + 400*ox2*s3 + px2
    ny3 = s1*c2*c3 + oy2*s3
    oy3 = oy2*c3 - s1*c2*s3
    py3 = 400*s1*c2*c3 + 400*oy2*s3 + py2
    nz3 = c2*s3 + s2*c3
    oz3 = c2*c3 - s2*s3
    pz3 = 400*c2*s3 + 400*s2*c3 + pz2
    T_0_1 = (
        (c1, 0, s1, 0),
        (s1, 0, -c1, 0),
        (0, 1, 0, 300),
        (0, 0, 0, 1),
    )
    T_0_2 = (
        (c1*c2, ox2, s1, px2),
        (s1*c2, oy2, -c1, py2),
        (s2, c2, 0, pz2),
        (0, 0, 0, 1),
    )
    T_0_3 = (
        (nx3, ox3, s1, px3),
        (ny3, oy3, -c1, py3),
        (nz3, oz3, 0, pz3),
        (0, 0, 0, 1),
    )
    return T_0_1, T_0_2, T_0_3
