"""Inverse kinematics of the OpenMANIPULATOR-X.

Written by notebooks/05-inverse-kinematics.ipynb. Do not edit: change the chapter and run it.
Lengths are in mm, angles in rad. `..._batch` is the same formula for columns: arrays of one
shape, NumPy's or those of another library that keeps to the array API standard.
"""

from math import atan2, cos, pi, remainder, sin, sqrt, tau

from omx.arrays import Array, namespace, sincos, wrap


def branches(
    x: float, y: float, z: float, pitch: float,
    L1: float, L2: float, L3: float, L4: float, delta: float,
) -> tuple:
    """Joint angles of the four branches, and D = cos(bend) of the front and the back: out of reach where
    |D| > 1. 109 operations and 2 sines and cosines."""
    s_pitch, c_pitch = sin(pitch), cos(pitch)
    r = sqrt(x*x + y*y)
    z_w = z - L1 - L4*s_pitch
    q1_front = atan2(y, x)
    q1_back = remainder(pi + q1_front, tau)
    r_w_front = r - L4*c_pitch
    D_front = (r_w_front*r_w_front + z_w*z_w - L2*L2 - L3*L3)/(2*L2*L3)
    s_front = sqrt(max(0.0, (1 - D_front)*(1 + D_front)))
    mu_front = atan2(z_w, r_w_front)
    gamma_front = atan2(L3*s_front, L2 + L3*D_front)
    bend_front = atan2(s_front, D_front)
    q2_front_up = remainder(pi/2 - delta - gamma_front - mu_front, tau)
    q3_front_up = remainder(delta + bend_front - pi/2, tau)
    q4_front_up = remainder(-pitch - q2_front_up - q3_front_up, tau)
    q2_front_down = remainder(pi/2 + gamma_front - delta - mu_front, tau)
    q3_front_down = remainder(delta - pi/2 - bend_front, tau)
    q4_front_down = remainder(-pitch - q2_front_down - q3_front_down, tau)
    r_w_back = -L4*c_pitch - r
    D_back = (r_w_back*r_w_back + z_w*z_w - L2*L2 - L3*L3)/(2*L2*L3)
    s_back = sqrt(max(0.0, (1 - D_back)*(1 + D_back)))
    mu_back = atan2(z_w, r_w_back)
    gamma_back = atan2(L3*s_back, L2 + L3*D_back)
    bend_back = atan2(s_back, D_back)
    q2_back_up = remainder(pi/2 - delta - gamma_back - mu_back, tau)
    q3_back_up = remainder(delta + bend_back - pi/2, tau)
    q4_back_up = remainder(-pitch - q2_back_up - q3_back_up, tau)
    q2_back_down = remainder(pi/2 + gamma_back - delta - mu_back, tau)
    q3_back_down = remainder(delta - pi/2 - bend_back, tau)
    q4_back_down = remainder(-pitch - q2_back_down - q3_back_down, tau)
    front_up = (q1_front, q2_front_up, q3_front_up, q4_front_up)
    front_down = (q1_front, q2_front_down, q3_front_down, q4_front_down)
    back_up = (q1_back, q2_back_up, q3_back_up, q4_back_up)
    back_down = (q1_back, q2_back_down, q3_back_down, q4_back_down)
    return front_up, front_down, back_up, back_down, D_front, D_back


def branches_batch(
    x: Array, y: Array, z: Array, pitch: Array,
    L1: float, L2: float, L3: float, L4: float, delta: float,
) -> tuple:
    """Joint angles of the four branches, and D = cos(bend) of the front and the back: out of reach where
    |D| > 1. Columns in, columns out."""
    xp = namespace(x, y, z, pitch)
    s_pitch, c_pitch = sincos(pitch)
    r = xp.sqrt(x*x + y*y)
    z_w = z - L1 - L4*s_pitch
    q1_front = xp.atan2(y, x)
    q1_back = wrap(pi + q1_front)
    r_w_front = r - L4*c_pitch
    D_front = (r_w_front*r_w_front + z_w*z_w - L2*L2 - L3*L3)/(2*L2*L3)
    s_front = xp.sqrt(xp.maximum(0.0, (1 - D_front)*(1 + D_front)))
    mu_front = xp.atan2(z_w, r_w_front)
    gamma_front = xp.atan2(L3*s_front, L2 + L3*D_front)
    bend_front = xp.atan2(s_front, D_front)
    q2_front_up = wrap(pi/2 - delta - gamma_front - mu_front)
    q3_front_up = wrap(delta + bend_front - pi/2)
    q4_front_up = wrap(-pitch - q2_front_up - q3_front_up)
    q2_front_down = wrap(pi/2 + gamma_front - delta - mu_front)
    q3_front_down = wrap(delta - pi/2 - bend_front)
    q4_front_down = wrap(-pitch - q2_front_down - q3_front_down)
    r_w_back = -L4*c_pitch - r
    D_back = (r_w_back*r_w_back + z_w*z_w - L2*L2 - L3*L3)/(2*L2*L3)
    s_back = xp.sqrt(xp.maximum(0.0, (1 - D_back)*(1 + D_back)))
    mu_back = xp.atan2(z_w, r_w_back)
    gamma_back = xp.atan2(L3*s_back, L2 + L3*D_back)
    bend_back = xp.atan2(s_back, D_back)
    q2_back_up = wrap(pi/2 - delta - gamma_back - mu_back)
    q3_back_up = wrap(delta + bend_back - pi/2)
    q4_back_up = wrap(-pitch - q2_back_up - q3_back_up)
    q2_back_down = wrap(pi/2 + gamma_back - delta - mu_back)
    q3_back_down = wrap(delta - pi/2 - bend_back)
    q4_back_down = wrap(-pitch - q2_back_down - q3_back_down)
    front_up = (q1_front, q2_front_up, q3_front_up, q4_front_up)
    front_down = (q1_front, q2_front_down, q3_front_down, q4_front_down)
    back_up = (q1_back, q2_back_up, q3_back_up, q4_back_up)
    back_down = (q1_back, q2_back_down, q3_back_down, q4_back_down)
    return front_up, front_down, back_up, back_down, D_front, D_back


def missing(
    x: float, y: float, z: float, pitch: float,
    L1: float, L2: float, L3: float, L4: float, delta: float,
) -> tuple[float, float]:
    """How far (mm) the wrist is out of reach: front, back; 0 within reach. 34 operations and 2 sines and
    cosines."""
    s_pitch, c_pitch = sin(pitch), cos(pitch)
    r = sqrt(x*x + y*y)
    z_w = z - L1 - L4*s_pitch
    d_w_front = sqrt((r - L4*c_pitch)**2 + z_w*z_w)
    d_w_back = sqrt((-L4*c_pitch - r)**2 + z_w*z_w)
    front = max(max(0.0, abs(L2 - L3) - d_w_front), d_w_front - L2 - L3)
    back = max(max(0.0, abs(L2 - L3) - d_w_back), d_w_back - L2 - L3)
    return front, back


def missing_batch(
    x: Array, y: Array, z: Array, pitch: Array,
    L1: float, L2: float, L3: float, L4: float, delta: float,
) -> tuple[Array, Array]:
    """How far (mm) the wrist is out of reach: front, back; 0 within reach. Columns in, columns out."""
    xp = namespace(x, y, z, pitch)
    s_pitch, c_pitch = sincos(pitch)
    r = xp.sqrt(x*x + y*y)
    z_w = z - L1 - L4*s_pitch
    d_w_front = xp.sqrt((r - L4*c_pitch)**2 + z_w*z_w)
    d_w_back = xp.sqrt((-L4*c_pitch - r)**2 + z_w*z_w)
    front = xp.maximum(xp.maximum(0.0, abs(L2 - L3) - d_w_front), d_w_front - L2 - L3)
    back = xp.maximum(xp.maximum(0.0, abs(L2 - L3) - d_w_back), d_w_back - L2 - L3)
    return front, back
