// Jacobian of the OpenMANIPULATOR-X.
//
// Written by notebooks/05-jacobian.ipynb. Do not edit: change the chapter and run it.
// Lengths are in mm, angles in rad.

/** Geometric Jacobian, 6x4. 35 operations and 8 sines and cosines. */
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
    const u = -L3*s23 - L4*s234;
    const v = L3*c23 + L4*c234;
    const h = L2*c2_delta + u;
    const r = L2*s2_delta + v;
    return [
        [-r*s1, h*c1, u*c1, -L4*c1*s234],
        [r*c1, h*s1, u*s1, -L4*s1*s234],
        [0, -r, -v, -L4*c234],
        [0, -s1, -s1, -s1],
        [0, c1, c1, c1],
        [1, 0, 0, 0],
    ];
}
