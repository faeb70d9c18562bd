"""Jacobian of the OpenMANIPULATOR-X.

Written by notebooks/07-jacobian.ipynb. Do not edit: change the chapter and run it.
Lengths are in mm, angles in rad. `..._batch` is the same formula for columns: arrays of one
shape, NumPy's or those of another library that keeps to the array API standard.
"""

from math import cos, sin

from omx.arrays import Array, sincos


def jacobian(
    q1: float, q2: float, q3: float, q4: float,
    L1: float, L2: float, L3: float, L4: float, delta: float,
) -> tuple:
    """Geometric Jacobian, 6x4. 30 operations and 8 sines and cosines."""
    s1, c1 = sin(q1), cos(q1)
    q23 = q2 + q3
    s23, c23 = sin(q23), cos(q23)
    q2_delta = q2 + delta
    s2_delta, c2_delta = sin(q2_delta), cos(q2_delta)
    q234 = q2 + q3 + q4
    s234, c234 = sin(q234), cos(q234)
    r_4 = L4*c234
    h_4 = -L4*s234
    r_3 = L3*c23 + r_4
    h_3 = h_4 - L3*s23
    r_2 = L2*s2_delta + r_3
    h_2 = L2*c2_delta + h_3
    return (
        (-r_2*s1, h_2*c1, h_3*c1, h_4*c1),
        (r_2*c1, h_2*s1, h_3*s1, h_4*s1),
        (0, -r_2, -r_3, -r_4),
        (0, -s1, -s1, -s1),
        (0, c1, c1, c1),
        (1, 0, 0, 0),
    )


def jacobian_batch(
    q1: Array, q2: Array, q3: Array, q4: Array,
    L1: float, L2: float, L3: float, L4: float, delta: float,
) -> tuple:
    """Geometric Jacobian, 6x4. Columns in, columns out; constants are plain numbers."""
    s1, c1 = sincos(q1)
    q23 = q2 + q3
    s23, c23 = sincos(q23)
    q2_delta = q2 + delta
    s2_delta, c2_delta = sincos(q2_delta)
    q234 = q2 + q3 + q4
    s234, c234 = sincos(q234)
    r_4 = L4*c234
    h_4 = -L4*s234
    r_3 = L3*c23 + r_4
    h_3 = h_4 - L3*s23
    r_2 = L2*s2_delta + r_3
    h_2 = L2*c2_delta + h_3
    return (
        (-r_2*s1, h_2*c1, h_3*c1, h_4*c1),
        (r_2*c1, h_2*s1, h_3*s1, h_4*s1),
        (0, -r_2, -r_3, -r_4),
        (0, -s1, -s1, -s1),
        (0, c1, c1, c1),
        (1, 0, 0, 0),
    )
