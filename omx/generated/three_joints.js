// Forward kinematics of the three-joint arm.
//
// Written by notebooks/10-other-arms.ipynb. Do not edit: change the chapter and run it.
// Lengths are in mm, angles in rad.

/** T_0_3, rows of the 4x4 matrix. 53 operations and 6 sines and cosines. */
export function transform(q1, q2, q3) {
    const s1 = Math.sin(q1);
    const c1 = Math.cos(q1);
    const s2 = Math.sin(q2);
    const c2 = Math.cos(q2);
    const s3 = Math.sin(q3);
    const c3 = Math.cos(q3);
    const ox2 = -c1*s2;
    const px2 = 500*c1*c2;
    const oy2 = -s1*s2;
    const py2 = 500*s1*c2;
    const pz2 = 300 + 500*s2;
    const nx3 = c1*c2*c3 + ox2*s3;
    const ox3 = ox2*c3 - c1*c2*s3;
    const px3 = 400*c1*c2*c3 + 400*ox2*s3 + px2;
    const ny3 = s1*c2*c3 + oy2*s3;
    const oy3 = oy2*c3 - s1*c2*s3;
    const py3 = 400*s1*c2*c3 + 400*oy2*s3 + py2;
    const nz3 = c2*s3 + s2*c3;
    const oz3 = c2*c3 - s2*s3;
    const pz3 = 400*c2*s3 + 400*s2*c3 + pz2;
    return [
        [nx3, ox3, s1, px3],
        [ny3, oy3, -c1, py3],
        [nz3, oz3, 0, pz3],
        [0, 0, 0, 1],
    ];
}

/** T_0_1 .. T_0_3, each as rows of a 4x4 matrix. 57 operations and 6 sines and cosines. */
export function frames(q1, q2, q3) {
    const s1 = Math.sin(q1);
    const c1 = Math.cos(q1);
    const s2 = Math.sin(q2);
    const c2 = Math.cos(q2);
    const s3 = Math.sin(q3);
    const c3 = Math.cos(q3);
    const ox2 = -c1*s2;
    const px2 = 500*c1*c2;
    const oy2 = -s1*s2;
    const py2 = 500*s1*c2;
    const pz2 = 300 + 500*s2;
    const nx3 = c1*c2*c3 + ox2*s3;
    const ox3 = ox2*c3 - c1*c2*s3;
    const px3 = 400*c1*c2*c3 + 400*ox2*s3 + px2;
    const ny3 = s1*c2*c3 + oy2*s3;
    const oy3 = oy2*c3 - s1*c2*s3;
    const py3 = 400*s1*c2*c3 + 400*oy2*s3 + py2;
    const nz3 = c2*s3 + s2*c3;
    const oz3 = c2*c3 - s2*s3;
    const pz3 = 400*c2*s3 + 400*s2*c3 + pz2;
    const T_0_1 = [
        [c1, 0, s1, 0],
        [s1, 0, -c1, 0],
        [0, 1, 0, 300],
        [0, 0, 0, 1],
    ];
    const T_0_2 = [
        [c1*c2, ox2, s1, px2],
        [s1*c2, oy2, -c1, py2],
        [s2, c2, 0, pz2],
        [0, 0, 0, 1],
    ];
    const T_0_3 = [
        [nx3, ox3, s1, px3],
        [ny3, oy3, -c1, py3],
        [nz3, oz3, 0, pz3],
        [0, 0, 0, 1],
    ];
    return [T_0_1, T_0_2, T_0_3];
}
