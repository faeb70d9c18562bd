// Jacobian of the OpenMANIPULATOR-X.
//
// Written by notebooks/07-jacobian.ipynb. Do not edit: change the chapter and run it.
// Lengths are in mm, angles in rad.

/** Geometric Jacobian, 6x4. 30 operations and 8 sines and cosines. */
export function jacobian(q1, q2, q3, q4, L1, L2, L3, L4, delta) {
    const s1 = Math.sin(q1);
    const c1 = Math.cos(q1);
    const q23 = q2 + q3;
    const s23 = Math.sin(q23);
    const c23 = Math.cos(q23);
    const q2_delta = q2 + delta;
    const s2_delta = Math.sin(q2_delta);
    const c2_delta = Math.cos(q2_delta);
    const q234 = q2 + q3 + q4;
    const s234 = Math.sin(q234);
    const c234 = Math.cos(q234);
    const r_4 = L4*c234;
    const h_4 = -L4*s234;
    const r_3 = L3*c23 + r_4;
    const h_3 = h_4 - L3*s23;
    const r_2 = L2*s2_delta + r_3;
    const h_2 = L2*c2_delta + h_3;
    return [
        [-r_2*s1, h_2*c1, h_3*c1, h_4*c1],
        [r_2*c1, h_2*s1, h_3*s1, h_4*s1],
        [0, -r_2, -r_3, -r_4],
        [0, -s1, -s1, -s1],
        [0, c1, c1, c1],
        [1, 0, 0, 0],
    ];
}
