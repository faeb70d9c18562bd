"""Forward kinematics of the Stanford arm.

Written by notebooks/10-other-arms.ipynb. Do not edit: change the chapter and run it.
Lengths are in mm, angles in rad. `..._batch` is the same formula for columns: arrays of one
shape, NumPy's or those of another library that keeps to the array API standard.
"""

from math import cos, pi, sin

from omx.arrays import Array, sincos
from omx.dh import DHRow

#: The arm's lengths (mm) and angles (rad), in the order in which every function takes them.
PARAMETERS = {
    "d1": 100.0,
    "d2": 100.0,
    "d6": 100.0,
}


def dh_rows(d1: float, d2: float, d6: float) -> tuple[DHRow, ...]:
    """The DH table, a row a joint: theta or d holds the offset that the joint variable is added to."""
    return (
        DHRow(0.0, d1, 0.0, -pi/2),
        DHRow(0.0, d2, 0.0, pi/2),
        DHRow(0.0, 0.0, 0.0, 0.0, prismatic=True),
        DHRow(0.0, 0.0, 0.0, -pi/2),
        DHRow(0.0, 0.0, 0.0, pi/2),
        DHRow(0.0, d6, 0.0, 0.0),
    )


def transform(
    q1: float, q2: float, d3: float, q4: float, q5: float, q6: float,
    d1: float, d2: float, d6: float,
) -> tuple:
    """T_0_6, rows of the 4x4 matrix. 78 operations and 10 sines and cosines."""
    s1, c1 = sin(q1), cos(q1)
    s2, c2 = sin(q2), cos(q2)
    s4, c4 = sin(q4), cos(q4)
    s5, c5 = sin(q5), cos(q5)
    s6, c6 = sin(q6), cos(q6)
    px2 = -d2*s1
    px3 = d3*c1*s2 + px2
    py3 = d2*c1 + d3*s1*s2
    pz3 = d1 + d3*c2
    nx4 = c1*c2*c4 - s1*s4
    ox4 = -c1*s2
    ax4 = -c1*c2*s4 - s1*c4
    ny4 = c1*s4 + s1*c2*c4
    oy4 = -s1*s2
    ay4 = c1*c4 - s1*c2*s4
    nz4 = -s2*c4
    nx5 = nx4*c5 + ox4*s5
    ax5 = nx4*s5 - ox4*c5
    ny5 = ny4*c5 + oy4*s5
    ay5 = ny4*s5 - oy4*c5
    nz5 = nz4*c5 - c2*s5
    az5 = c2*c5 + nz4*s5
    nx6 = ax4*s6 + nx5*c6
    ox6 = ax4*c6 - nx5*s6
    px6 = d6*ax5 + px3
    ny6 = ay4*s6 + ny5*c6
    oy6 = ay4*c6 - ny5*s6
    py6 = d6*ay5 + py3
    nz6 = nz5*c6 + s2*s4*s6
    oz6 = s2*s4*c6 - nz5*s6
    pz6 = d6*az5 + pz3
    return (
        (nx6, ox6, ax5, px6),
        (ny6, oy6, ay5, py6),
        (nz6, oz6, az5, pz6),
        (0, 0, 0, 1),
    )


def transform_batch(
    q1: Array, q2: Array, d3: Array, q4: Array, q5: Array, q6: Array,
    d1: float, d2: float, d6: float,
) -> tuple:
    """T_0_6, rows of the 4x4 matrix. Columns in, columns out; constants are plain numbers."""
    s1, c1 = sincos(q1)
    s2, c2 = sincos(q2)
    s4, c4 = sincos(q4)
    s5, c5 = sincos(q5)
    s6, c6 = sincos(q6)
    px2 = -d2*s1
    px3 = d3*c1*s2 + px2
    py3 = d2*c1 + d3*s1*s2
    pz3 = d1 + d3*c2
    nx4 = c1*c2*c4 - s1*s4
    ox4 = -c1*s2
    ax4 = -c1*c2*s4 - s1*c4
    ny4 = c1*s4 + s1*c2*c4
    oy4 = -s1*s2
    ay4 = c1*c4 - s1*c2*s4
    nz4 = -s2*c4
    nx5 = nx4*c5 + ox4*s5
    ax5 = nx4*s5 - ox4*c5
    ny5 = ny4*c5 + oy4*s5
    ay5 = ny4*s5 - oy4*c5
    nz5 = nz4*c5 - c2*s5
    az5 = c2*c5 + nz4*s5
    nx6 = ax4*s6 + nx5*c6
    ox6 = ax4*c6 - nx5*s6
    px6 = d6*ax5 + px3
    ny6 = ay4*s6 + ny5*c6
    oy6 = ay4*c6 - ny5*s6
    py6 = d6*ay5 + py3
    nz6 = nz5*c6 + s2*s4*s6
    oz6 = s2*s4*c6 - nz5*s6
    pz6 = d6*az5 + pz3
    return (
        (nx6, ox6, ax5, px6),
        (ny6, oy6, ay5, py6),
        (nz6, oz6, az5, pz6),
        (0, 0, 0, 1),
    )


def frames(
    q1: float, q2: float, d3: float, q4: float, q5: float, q6: float,
    d1: float, d2: float, d6: float,
) -> tuple:
    """T_0_1 .. T_0_6, each as rows of a 4x4 matrix. 96 operations and 10 sines and cosines."""
    s1, c1 = sin(q1), cos(q1)
    s2, c2 = sin(q2), cos(q2)
    s4, c4 = sin(q4), cos(q4)
    s5, c5 = sin(q5), cos(q5)
    s6, c6 = sin(q6), cos(q6)
    px2 = -d2*s1
    px3 = d3*c1*s2 + px2
    py3 = d2*c1 + d3*s1*s2
    pz3 = d1 + d3*c2
    nx4 = c1*c2*c4 - s1*s4
    ox4 = -c1*s2
    ax4 = -c1*c2*s4 - s1*c4
    ny4 = c1*s4 + s1*c2*c4
    oy4 = -s1*s2
    ay4 = c1*c4 - s1*c2*s4
    nz4 = -s2*c4
    nx5 = nx4*c5 + ox4*s5
    ax5 = nx4*s5 - ox4*c5
    ny5 = ny4*c5 + oy4*s5
    ay5 = ny4*s5 - oy4*c5
    nz5 = nz4*c5 - c2*s5
    az5 = c2*c5 + nz4*s5
    nx6 = ax4*s6 + nx5*c6
    ox6 = ax4*c6 - nx5*s6
    px6 = d6*ax5 + px3
    ny6 = ay4*s6 + ny5*c6
    oy6 = ay4*c6 - ny5*s6
    py6 = d6*ay5 + py3
    nz6 = nz5*c6 + s2*s4*s6
    oz6 = s2*s4*c6 - nz5*s6
    pz6 = d6*az5 + pz3
    T_0_1 = (
        (c1, 0, -s1, 0),
        (s1, 0, c1, 0),
        (0, -1, 0, d1),
        (0, 0, 0, 1),
    )
    T_0_2 = (
        (c1*c2, -s1, c1*s2, px2),
        (s1*c2, c1, s1*s2, d2*c1),
        (-s2, 0, c2, d1),
        (0, 0, 0, 1),
    )
    T_0_3 = (
        (c1*c2, -s1, c1*s2, px3),
        (s1*c2, c1, s1*s2, py3),
        (-s2, 0, c2, pz3),
        (0, 0, 0, 1),
    )
    T_0_4 = (
        (nx4, ox4, ax4, px3),
        (ny4, oy4, ay4, py3),
        (nz4, -c2, s2*s4, pz3),
        (0, 0, 0, 1),
    )
    T_0_5 = (
        (nx5, ax4, ax5, px3),
        (ny5, ay4, ay5, py3),
        (nz5, s2*s4, az5, pz3),
        (0, 0, 0, 1),
    )
    T_0_6 = (
        (nx6, ox6, ax5, px6),
        (ny6, oy6, ay5, py6),
        (nz6, oz6, az5, pz6),
        (0, 0, 0, 1),
    )
    return T_0_1, T_0_2, T_0_3, T_0_4, T_0_5, T_0_6


def frames_batch(
    q1: Array, q2: Array, d3: Array, q4: Array, q5: Array, q6: Array,
    d1: float, d2: float, d6: float,
) -> tuple:
    """T_0_1 .. T_0_6, each as rows of a 4x4 matrix. Columns in, columns out; constants are plain
    numbers."""
    s1, c1 = sincos(q1)
    s2, c2 = sincos(q2)
    s4, c4 = sincos(q4)
    s5, c5 = sincos(q5)
    s6, c6 = sincos(q6)
    px2 = -d2*s1
    px3 = d3*c1*s2 + px2
    py3 = d2*c1 + d3*s1*s2
    pz3 = d1 + d3*c2
    nx4 = c1*c2*c4 - s1*s4
    ox4 = -c1*s2
    ax4 = -c1*c2*s4 - s1*c4
    ny4 = c1*s4 + s1*c2*c4
    oy4 = -s1*s2
    ay4 = c1*c4 - s1*c2*s4
    nz4 = -s2*c4
    nx5 = nx4*c5 + ox4*s5
    ax5 = nx4*s5 - ox4*c5
    ny5 = ny4*c5 + oy4*s5
    ay5 = ny4*s5 - oy4*c5
    nz5 = nz4*c5 - c2*s5
    az5 = c2*c5 + nz4*s5
    nx6 = ax4*s6 + nx5*c6
    ox6 = ax4*c6 - nx5*s6
    px6 = d6*ax5 + px3
    ny6 = ay4*s6 + ny5*c6
    oy6 = ay4*c6 - ny5*s6
    py6 = d6*ay5 + py3
    nz6 = nz5*c6 + s2*s4*s6
    oz6 = s2*s4*c6 - nz5*s6
    pz6 = d6*az5 + pz3
    T_0_1 = (
        (c1, 0, -s1, 0),
        (s1, 0, c1, 0),
        (0, -1, 0, d1),
        (0, 0, 0, 1),
    )
    T_0_2 = (
        (c1*c2, -s1, c1*s2, px2),
        (s1*c2, c1, s1*s2, d2*c1),
        (-s2, 0, c2, d1),
        (0, 0, 0, 1),
    )
    T_0_3 = (
        (c1*c2, -s1, c1*s2, px3),
        (s1*c2, c1, s1*s2, py3),
        (-s2, 0, c2, pz3),
        (0, 0, 0, 1),
    )
    T_0_4 = (
        (nx4, ox4, ax4, px3),
        (ny4, oy4, ay4, py3),
        (nz4, -c2, s2*s4, pz3),
        (0, 0, 0, 1),
    )
    T_0_5 = (
        (nx5, ax4, ax5, px3),
        (ny5, ay4, ay5, py3),
        (nz5, s2*s4, az5, pz3),
        (0, 0, 0, 1),
    )
    T_0_6 = (
        (nx6, ox6, ax5, px6),
        (ny6, oy6, ay5, py6),
        (nz6, oz6, az5, pz6),
        (0, 0, 0, 1),
    )
    return T_0_1, T_0_2, T_0_3, T_0_4, T_0_5, T_0_6
