// Forward kinematics of the OpenMANIPULATOR-X.
//
// Written by notebooks/03-forward-kinematics.ipynb. Do not edit: change the chapter and run it.
// Lengths are in mm, angles in rad.

export const PARAMETERS = {
    L1: 77,
    L2: 130,
    L3: 124,
    L4: 126,
    delta: Math.asin(12/65),
};

const wrap = (angle) => angle - 2*Math.PI*Math.ceil(angle/(2*Math.PI) - 0.5);

/** Tool position x, y, z and pitch. 19 operations and 8 sines and cosines. */
export function pose(q1, q2, q3, q4, L1, L2, L3, L4, delta) {
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
    const r = L2*s2_delta + L3*c23 + L4*c234;
    const z = L1 + L2*c2_delta - L3*s23 - L4*s234;
    const x = r*c1;
    const y = r*s1;
    const pitch = wrap(-q234);
    return [x, y, z, pitch];
}

/** T_base_tool, as rows of the 4x4 matrix. 26 operations and 8 sines and cosines. */
export function transform(q1, q2, q3, q4, L1, L2, L3, L4, delta) {
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
    const r = L2*s2_delta + L3*c23 + L4*c234;
    const z = L1 + L2*c2_delta - L3*s23 - L4*s234;
    return [
        [c1*c234, -c1*s234, -s1, r*c1],
        [s1*c234, -s1*s234, c1, r*s1],
        [-s234, -c234, 0, z],
        [0, 0, 0, 1],
    ];
}

/** T_0_1 .. T_0_4, each as rows of a 4x4 matrix. 47 operations and 8 sines and cosines. */
export function frames(q1, q2, q3, q4, L1, L2, L3, L4, delta) {
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
    const r_2 = L2*s2_delta;
    const z_2 = L1 + L2*c2_delta;
    const r_3 = L3*c23 + r_2;
    const z_3 = z_2 - L3*s23;
    const r_4 = L4*c234 + r_3;
    const z_4 = z_3 - L4*s234;
    const T_0_1 = [
        [c1, 0, -s1, 0],
        [s1, 0, c1, 0],
        [0, -1, 0, L1],
        [0, 0, 0, 1],
    ];
    const T_0_2 = [
        [c1*s2_delta, c1*c2_delta, -s1, r_2*c1],
        [s1*s2_delta, s1*c2_delta, c1, r_2*s1],
        [c2_delta, -s2_delta, 0, z_2],
        [0, 0, 0, 1],
    ];
    const T_0_3 = [
        [c1*c23, -c1*s23, -s1, r_3*c1],
        [s1*c23, -s1*s23, c1, r_3*s1],
        [-s23, -c23, 0, z_3],
        [0, 0, 0, 1],
    ];
    const T_0_4 = [
        [c1*c234, -c1*s234, -s1, r_4*c1],
        [s1*c234, -s1*s234, c1, r_4*s1],
        [-s234, -c234, 0, z_4],
        [0, 0, 0, 1],
    ];
    return [T_0_1, T_0_2, T_0_3, T_0_4];
}
