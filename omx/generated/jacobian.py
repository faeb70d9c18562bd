"""Jacobian of the OpenMANIPULATOR-X.

Written by notebooks/05-jacobian.ipynb. Do not edit: change the chapter and run it.
Lengths are in mm, angles in rad. `..._batch` is the same formula for columns (NumPy arrays of one shape).
"""

from math import cos, sin

import numpy as np

from omx.arrays import sincos


def jacobian(
    q1: float, q2: float, q3: float, q4: float,
    L1: float, L2: float, L3: float, L4: float, delta: float,
) -> tuple:
    """Geometric Jacobian, 6x4. 35 operations and 8 sines and cosines."""
    s1, c1 = sin(q1), cos(q1)
    q23 = q2 + q3
    s23, c23 = sin(q23), cos(q23)
    q2_delta = q2 + delta
    s2_delta, c2_delta = sin(q2_delta), cos(q2_delta)
    q234 = q2 + q3 + q4
    s234, c234 = sin(q234), cos(q234)
    u = -L3*s23 - L4*s234
    v = L3*c23 + L4*c234
    h = L2*c2_delta + u
    r = L2*s2_delta + v
    return (
        (-r*s1, h*c1, u*c1, -L4*c1*s234),
        (r*c1, h*s1, u*s1, -L4*s1*s234),
        (0, -r, -v, -L4*c234),
        (0, -s1, -s1, -s1),
        (0, c1, c1, c1),
        (1, 0, 0, 0),
    )


def jacobian_batch(
    q1: np.ndarray, q2: np.ndarray, q3: np.ndarray, q4: np.ndarray,
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
    u = -L3*s23 - L4*s234
    v = L3*c23 + L4*c234
    h = L2*c2_delta + u
    r = L2*s2_delta + v
    return (
        (-r*s1, h*c1, u*c1, -L4*c1*s234),
        (r*c1, h*s1, u*s1, -L4*s1*s234),
        (0, -r, -v, -L4*c234),
        (0, -s1, -s1, -s1),
        (0, c1, c1, c1),
        (1, 0, 0, 0),
    )
