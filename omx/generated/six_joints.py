"""Forward kinematics of the six-joint arm.

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
        DHRow(0.0, 200.0, 0.0, pi/2),
        DHRow(0.0, 0.0, 0.0, -pi/2),
        DHRow(0.0, 100.0, 0.0, 0.0),
    )


def transform(q1: float, q2: float, q3: float, q4: float, q5: float, q6: float) -> tuple:
    """T_0_6, rows of the 4x4 matrix. 118 operations and 12 sines and cosines."""
    s1, c1 = sin(q1), cos(q1)
    s2, c2 = sin(q2), cos(q2)
    s3, c3 = sin(q3), cos(q3)
    s4, c4 = sin(q4), cos(q4)
    s5, c5 = sin(q5), cos(q5)
    s6, c6 = sin(q6), cos(q6)
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
    nx4 = nx3*c4 + ox3*s4
    ax4 = nx3*s4 - ox3*c4
    px4 = px3 + 200*s1
    ny4 = ny3*c4 + oy3*s4
    ay4 = ny3*s4 - oy3*c4
    py4 = py3 - 200*c1
    nz4 = nz3*c4 + oz3*s4
    az4 = nz3*s4 - oz3*c4
    nx5 = nx4*c5 + s1*s5
    ax5 = s1*c5 - nx4*s5
    ny5 = ny4*c5 - c1*s5
    ay5 = -c1*c5 - ny4*s5
    az5 = -nz4*s5
    nx6 = nx5*c6 - ax4*s6
    ox6 = -ax4*c6 - nx5*s6
    px6 = 100*ax5 + px4
    ny6 = ny5*c6 - ay4*s6
    oy6 = -ay4*c6 - ny5*s6
    py6 = 100*ay5 + py4
    nz6 = nz4*c5*c6 - az4*s6
    oz6 = -az4*c6 - nz4*c5*s6
    pz6 = 100*az5 + pz3
    return (
        (nx6, ox6, ax5, px6),
        (ny6, oy6, ay5, py6),
        (nz6, oz6, az5, pz6),
        (0, 0, 0, 1),
    )


def transform_batch(q1: Array, q2: Array, q3: Array, q4: Array, q5: Array, q6: Array) -> tuple:
    """T_0_6, rows of the 4x4 matrix. Columns in, columns out; constants are plain numbers."""
    s1, c1 = sincos(q1)
    s2, c2 = sincos(q2)
    s3, c3 = sincos(q3)
    s4, c4 = sincos(q4)
    s5, c5 = sincos(q5)
    s6, c6 = sincos(q6)
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
    nx4 = nx3*c4 + ox3*s4
    ax4 = nx3*s4 - ox3*c4
    px4 = px3 + 200*s1
    ny4 = ny3*c4 + oy3*s4
    ay4 = ny3*s4 - oy3*c4
    py4 = py3 - 200*c1
    nz4 = nz3*c4 + oz3*s4
    az4 = nz3*s4 - oz3*c4
    nx5 = nx4*c5 + s1*s5
    ax5 = s1*c5 - nx4*s5
    ny5 = ny4*c5 - c1*s5
    ay5 = -c1*c5 - ny4*s5
    az5 = -nz4*s5
    nx6 = nx5*c6 - ax4*s6
    ox6 = -ax4*c6 - nx5*s6
    px6 = 100*ax5 + px4
    ny6 = ny5*c6 - ay4*s6
    oy6 = -ay4*c6 - ny5*s6
    py6 = 100*ay5 + py4
    nz6 = nz4*c5*c6 - az4*s6
    oz6 = -az4*c6 - nz4*c5*s6
    pz6 = 100*az5 + pz3
    return (
        (nx6, ox6, ax5, px6),
        (ny6, oy6, ay5, py6),
        (nz6, oz6, az5, pz6),
        (0, 0, 0, 1),
    )


def frames(q1: float, q2: float, q3: float, q4: float, q5: float, q6: float) -> tuple:
    """T_0_1 .. T_0_6, each as rows of a 4x4 matrix. 128 operations and 12 sines and cosines."""
    s1, c1 = sin(q1), cos(q1)
    s2, c2 = sin(q2), cos(q2)
    s3, c3 = sin(q3), cos(q3)
    s4, c4 = sin(q4), cos(q4)
    s5, c5 = sin(q5), cos(q5)
    s6, c6 = sin(q6), cos(q6)
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
    nx4 = nx3*c4 + ox3*s4
    ax4 = nx3*s4 - ox3*c4
    px4 = px3 + 200*s1
    ny4 = ny3*c4 + oy3*s4
    ay4 = ny3*s4 - oy3*c4
    py4 = py3 - 200*c1
    nz4 = nz3*c4 + oz3*s4
    az4 = nz3*s4 - oz3*c4
    nx5 = nx4*c5 + s1*s5
    ax5 = s1*c5 - nx4*s5
    ny5 = ny4*c5 - c1*s5
    ay5 = -c1*c5 - ny4*s5
    az5 = -nz4*s5
    nx6 = nx5*c6 - ax4*s6
    ox6 = -ax4*c6 - nx5*s6
    px6 = 100*ax5 + px4
    ny6 = ny5*c6 - ay4*s6
    oy6 = -ay4*c6 - ny5*s6
    py6 = 100*ay5 + py4
    nz6 = nz4*c5*c6 - az4*s6
    oz6 = -az4*c6 - nz4*c5*s6
    pz6 = 100*az5 + pz3
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
    T_0_4 = (
        (nx4, s1, ax4, px4),
        (ny4, -c1, ay4, py4),
        (nz4, 0, az4, pz3),
        (0, 0, 0, 1),
    )
    T_0_5 = (
        (nx5, -ax4, ax5, px4),
        (ny5, -ay4, ay5, py4),
        (nz4*c5, -az4, az5, pz3),
        (0, 0, 0, 1),
    )
    T_0_6 = (
        (nx6, ox6, ax5, px6),
        (ny6, oy6, ay5, py6),
        (nz6, oz6, az5, pz6),
        (0, 0, 0, 1),
    )
    return T_0_1, T_0_2, T_0_3, T_0_4, T_0_5, T_0_6


def frames_batch(q1: Array, q2: Array, q3: Array, q4: Array, q5: Array, q6: Array) -> tuple:
    """T_0_1 .. T_0_6, each as rows of a 4x4 matrix. Columns in, columns out; constants are plain
    numbers."""
    s1, c1 = sincos(q1)
    s2, c2 = sincos(q2)
    s3, c3 = sincos(q3)
    s4, c4 = sincos(q4)
    s5, c5 = sincos(q5)
    s6, c6 = sincos(q6)
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
    nx4 = nx3*c4 + ox3*s4
    ax4 = nx3*s4 - ox3*c4
    px4 = px3 + 200*s1
    ny4 = ny3*c4 + oy3*s4
    ay4 = ny3*s4 - oy3*c4
    py4 = py3 - 200*c1
    nz4 = nz3*c4 + oz3*s4
    az4 = nz3*s4 - oz3*c4
    nx5 = nx4*c5 + s1*s5
    ax5 = s1*c5 - nx4*s5
    ny5 = ny4*c5 - c1*s5
    ay5 = -c1*c5 - ny4*s5
    az5 = -nz4*s5
    nx6 = nx5*c6 - ax4*s6
    ox6 = -ax4*c6 - nx5*s6
    px6 = 100*ax5 + px4
    ny6 = ny5*c6 - ay4*s6
    oy6 = -ay4*c6 - ny5*s6
    py6 = 100*ay5 + py4
    nz6 = nz4*c5*c6 - az4*s6
    oz6 = -az4*c6 - nz4*c5*s6
    pz6 = 100*az5 + pz3
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
    T_0_4 = (
        (nx4, s1, ax4, px4),
        (ny4, -c1, ay4, py4),
        (nz4, 0, az4, pz3),
        (0, 0, 0, 1),
    )
    T_0_5 = (
        (nx5, -ax4, ax5, px4),
        (ny5, -ay4, ay5, py4),
        (nz4*c5, -az4, az5, pz3),
        (0, 0, 0, 1),
    )
    T_0_6 = (
        (nx6, ox6, ax5, px6),
        (ny6, oy6, ay5, py6),
        (nz6, oz6, az5, pz6),
        (0, 0, 0, 1),
    )
    return T_0_1, T_0_2, T_0_3, T_0_4, T_0_5, T_0_6
