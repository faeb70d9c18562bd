// What gravity does to the joints of the OpenMANIPULATOR-X.
//
// Written by notebooks/08-weight.ipynb. Do not edit: change the chapter and run it.
// Lengths are in mm, angles in rad.

/** Torque of gravity on joints 2, 3, 4 (N mm), positive where it pitches the joint down. Masses in kg, g in m/s^2. 33 operations and 7 sines and cosines. */
export function torques(q2, q3, q4, payload, g, m_2, x_2, z_2, m_3, x_3, z_3, m_4, x_4, z_4, L2, L3, L4, delta) {
    const s2 = Math.sin(q2);
    const c2 = Math.cos(q2);
    const q23 = q2 + q3;
    const s23 = Math.sin(q23);
    const c23 = Math.cos(q23);
    const q2_delta = q2 + delta;
    const s2_delta = Math.sin(q2_delta);
    const q234 = q2 + q3 + q4;
    const s234 = Math.sin(q234);
    const c234 = Math.cos(q234);
    const M_4 = m_4*(x_4*c234 + z_4*s234) + L4*payload*c234;
    const M_3 = m_3*(x_3*c23 + z_3*s23) + L3*(m_4 + payload)*c23 + M_4;
    const M_2 = m_2*(x_2*c2 + z_2*s2) + L2*(m_3 + m_4 + payload)*s2_delta + M_3;
    const on_2 = g*M_2;
    const on_3 = g*M_3;
    const on_4 = g*M_4;
    return [on_2, on_3, on_4];
}
