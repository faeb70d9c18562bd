// Forward kinematics of the six-joint arm.
//
// Written by notebooks/10-other-arms.ipynb. Do not edit: change the chapter and run it.
// Lengths are in mm, angles in rad.

/** T_0_6, rows of the 4x4 matrix. 118 operations and 12 sines and cosines. */
export function transform(q1, q2, q3, q4, q5, q6) {
    const s1 = Math.sin(q1);
    const c1 = Math.cos(q1);
    const s2 = Math.sin(q2);
    const c2 = Math.cos(q2);
    const s3 = Math.sin(q3);
    const c3 = Math.cos(q3);
    const s4 = Math.sin(q4);
    const c4 = Math.cos(q4);
    const s5 = Math.sin(q5);
    const c5 = Math.cos(q5);
    const s6 = Math.sin(q6);
    const c6 = Math.cos(q6);
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
    const nx4 = nx3*c4 + ox3*s4;
    const ax4 = nx3*s4 - ox3*c4;
    const px4 = px3 + 200*s1;
    const ny4 = ny3*c4 + oy3*s4;
    const ay4 = ny3*s4 - oy3*c4;
    const py4 = py3 - 200*c1;
    const nz4 = nz3*c4 + oz3*s4;
    const az4 = nz3*s4 - oz3*c4;
    const nx5 = nx4*c5 + s1*s5;
    const ax5 = s1*c5 - nx4*s5;
    const ny5 = ny4*c5 - c1*s5;
    const ay5 = -c1*c5 - ny4*s5;
    const az5 = -nz4*s5;
    const nx6 = nx5*c6 - ax4*s6;
    const ox6 = -ax4*c6 - nx5*s6;
    const px6 = 100*ax5 + px4;
    const ny6 = ny5*c6 - ay4*s6;
    const oy6 = -ay4*c6 - ny5*s6;
    const py6 = 100*ay5 + py4;
    const nz6 = nz4*c5*c6 - az4*s6;
    const oz6 = -az4*c6 - nz4*c5*s6;
    const pz6 = 100*az5 + pz3;
    return [
        [nx6, ox6, ax5, px6],
        [ny6, oy6, ay5, py6],
        [nz6, oz6, az5, pz6],
        [0, 0, 0, 1],
    ];
}

/** T_0_1 .. T_0_6, each as rows of a 4x4 matrix. 128 operations and 12 sines and cosines. */
export function frames(q1, q2, q3, q4, q5, q6) {
    const s1 = Math.sin(q1);
    const c1 = Math.cos(q1);
    const s2 = Math.sin(q2);
    const c2 = Math.cos(q2);
    const s3 = Math.sin(q3);
    const c3 = Math.cos(q3);
    const s4 = Math.sin(q4);
    const c4 = Math.cos(q4);
    const s5 = Math.sin(q5);
    const c5 = Math.cos(q5);
    const s6 = Math.sin(q6);
    const c6 = Math.cos(q6);
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
    const nx4 = nx3*c4 + ox3*s4;
    const ax4 = nx3*s4 - ox3*c4;
    const px4 = px3 + 200*s1;
    const ny4 = ny3*c4 + oy3*s4;
    const ay4 = ny3*s4 - oy3*c4;
    const py4 = py3 - 200*c1;
    const nz4 = nz3*c4 + oz3*s4;
    const az4 = nz3*s4 - oz3*c4;
    const nx5 = nx4*c5 + s1*s5;
    const ax5 = s1*c5 - nx4*s5;
    const ny5 = ny4*c5 - c1*s5;
    const ay5 = -c1*c5 - ny4*s5;
    const az5 = -nz4*s5;
    const nx6 = nx5*c6 - ax4*s6;
    const ox6 = -ax4*c6 - nx5*s6;
    const px6 = 100*ax5 + px4;
    const ny6 = ny5*c6 - ay4*s6;
    const oy6 = -ay4*c6 - ny5*s6;
    const py6 = 100*ay5 + py4;
    const nz6 = nz4*c5*c6 - az4*s6;
    const oz6 = -az4*c6 - nz4*c5*s6;
    const pz6 = 100*az5 + pz3;
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
    const T_0_4 = [
        [nx4, s1, ax4, px4],
        [ny4, -c1, ay4, py4],
        [nz4, 0, az4, pz3],
        [0, 0, 0, 1],
    ];
    const T_0_5 = [
        [nx5, -ax4, ax5, px4],
        [ny5, -ay4, ay5, py4],
        [nz4*c5, -az4, az5, pz3],
        [0, 0, 0, 1],
    ];
    const T_0_6 = [
        [nx6, ox6, ax5, px6],
        [ny6, oy6, ay5, py6],
        [nz6, oz6, az5, pz6],
        [0, 0, 0, 1],
    ];
    return [T_0_1, T_0_2, T_0_3, T_0_4, T_0_5, T_0_6];
}
