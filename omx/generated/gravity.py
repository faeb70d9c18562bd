"""What gravity does to the joints of the OpenMANIPULATOR-X.

Written by notebooks/08-weight.ipynb. Do not edit: change the chapter and run it.
Lengths are in mm, angles in rad. `..._batch` is the same formula for columns: arrays of one
shape, NumPy's or those of another library that keeps to the array API standard.
"""

from math import cos, sin

from omx.arrays import Array, sincos


def torques(
    q2: float, q3: float, q4: float, payload: float,
    g: float, m_2: float, x_2: float, z_2: float, m_3: float, x_3: float, z_3: float, m_4: float, x_4: float,
    z_4: float, L2: float, L3: float, L4: float, delta: float,
) -> tuple[float, float, float]:
    """Torque of gravity on joints 2, 3, 4 (N mm), positive where it pitches the joint down. Masses in kg,
    g in m/s^2. 33 operations and 7 sines and cosines."""
    s2, c2 = sin(q2), cos(q2)
    q23 = q2 + q3
    s23, c23 = sin(q23), cos(q23)
    q2_delta = q2 + delta
    s2_delta = sin(q2_delta)
    q234 = q2 + q3 + q4
    s234, c234 = sin(q234), cos(q234)
    M_4 = m_4*(x_4*c234 + z_4*s234) + L4*payload*c234
    M_3 = m_3*(x_3*c23 + z_3*s23) + L3*(m_4 + payload)*c23 + M_4
    M_2 = m_2*(x_2*c2 + z_2*s2) + L2*(m_3 + m_4 + payload)*s2_delta + M_3
    on_2 = g*M_2
    on_3 = g*M_3
    on_4 = g*M_4
    return on_2, on_3, on_4


def torques_batch(
    q2: Array, q3: Array, q4: Array, payload: Array,
    g: float, m_2: float, x_2: float, z_2: float, m_3: float, x_3: float, z_3: float, m_4: float, x_4: float,
    z_4: float, L2: float, L3: float, L4: float, delta: float,
) -> tuple[Array, Array, Array]:
    """Torque of gravity on joints 2, 3, 4 (N mm), positive where it pitches the joint down. Masses in kg,
    g in m/s^2. Columns in, columns out."""
    s2, c2 = sincos(q2)
    q23 = q2 + q3
    s23, c23 = sincos(q23)
    q2_delta = q2 + delta
    s2_delta, _ = sincos(q2_delta)
    q234 = q2 + q3 + q4
    s234, c234 = sincos(q234)
    M_4 = m_4*(x_4*c234 + z_4*s234) + L4*payload*c234
    M_3 = m_3*(x_3*c23 + z_3*s23) + L3*(m_4 + payload)*c23 + M_4
    M_2 = m_2*(x_2*c2 + z_2*s2) + L2*(m_3 + m_4 + payload)*s2_delta + M_3
    on_2 = g*M_2
    on_3 = g*M_3
    on_4 = g*M_4
    return on_2, on_3, on_4
