// Forward kinematics of the Stanford arm.
//
// Written by notebooks/10-other-arms.ipynb. Do not edit: change the chapter and run it.
// Lengths are in mm, angles in rad.

export const PARAMETERS = {
    d1: 100,
    d2: 100,
    d6: 100,
};

/** T_0_6, rows of the 4x4 matrix. 78 operations and 10 sines and cosines. */
export function transform(q1, q2, d3, q4, q5, q6, d1, d2, d6) {
    const s1 = Math.sin(q1);
    const c1 = Math.cos(q1);
    const s2 = Math.sin(q2);
    const c2 = Math.cos(q2);
    const s4 = Math.sin(q4);
    const c4 = Math.cos(q4);
    const s5 = Math.sin(q5);
    const c5 = Math.cos(q5);
    const s6 = Math.sin(q6);
    const c6 = Math.cos(q6);
    const px2 = -d2*s1;
    const px3 = d3*c1*s2 + px2;
    const py3 = d2*c1 + d3*s1*s2;
    const pz3 = d1 + d3*c2;
    const nx4 = c1*c2*c4 - s1*s4;
    const ox4 = -c1*s2;
    const ax4 = -c1*c2*s4 - s1*c4;
    const ny4 = c1*s4 + s1*c2*c4;
    const oy4 = -s1*s2;
    const ay4 = c1*c4 - s1*c2*s4;
    const nz4 = -s2*c4;
    const nx5 = nx4*c5 + ox4*s5;
    const ax5 = nx4*s5 - ox4*c5;
    const ny5 = ny4*c5 + oy4*s5;
    const ay5 = ny4*s5 - oy4*c5;
    const nz5 = nz4*c5 - c2*s5;
    const az5 = c2*c5 + nz4*s5;
    const nx6 = ax4*s6 + nx5*c6;
    const ox6 = ax4*c6 - nx5*s6;
    const px6 = d6*ax5 + px3;
    const ny6 = ay4*s6 + ny5*c6;
    const oy6 = ay4*c6 - ny5*s6;
    const py6 = d6*ay5 + py3;
    const nz6 = nz5*c6 + s2*s4*s6;
    const oz6 = s2*s4*c6 - nz5*s6;
    const pz6 = d6*az5 + pz3;
    return [
        [nx6, ox6, ax5, px6],
        [ny6, oy6, ay5, py6],
        [nz6, oz6, az5, pz6],
        [0, 0, 0, 1],
    ];
}

/** T_0_1 .. T_0_6, each as rows of a 4x4 matrix. 96 operations and 10 sines and cosines. */
export function frames(q1, q2, d3, q4, q5, q6, d1, d2, d6) {
    const s1 = Math.sin(q1);
    const c1 = Math.cos(q1);
    const s2 = Math.sin(q2);
    const c2 = Math.cos(q2);
    const s4 = Math.sin(q4);
    const c4 = Math.cos(q4);
    const s5 = Math.sin(q5);
    const c5 = Math.cos(q5);
    const s6 = Math.sin(q6);
    const c6 = Math.cos(q6);
    const px2 = -d2*s1;
    const px3 = d3*c1*s2 + px2;
    const py3 = d2*c1 + d3*s1*s2;
    const pz3 = d1 + d3*c2;
    const nx4 = c1*c2*c4 - s1*s4;
    const ox4 = -c1*s2;
    const ax4 = -c1*c2*s4 - s1*c4;
    const ny4 = c1*s4 + s1*c2*c4;
    const oy4 = -s1*s2;
    const ay4 = c1*c4 - s1*c2*s4;
    const nz4 = -s2*c4;
    const nx5 = nx4*c5 + ox4*s5;
    const ax5 = nx4*s5 - ox4*c5;
    const ny5 = ny4*c5 + oy4*s5;
    const ay5 = ny4*s5 - oy4*c5;
    const nz5 = nz4*c5 - c2*s5;
    const az5 = c2*c5 + nz4*s5;
    const nx6 = ax4*s6 + nx5*c6;
    const ox6 = ax4*c6 - nx5*s6;
    const px6 = d6*ax5 + px3;
    const ny6 = ay4*s6 + ny5*c6;
    const oy6 = ay4*c6 - ny5*s6;
    const py6 = d6*ay5 + py3;
    const nz6 = nz5*c6 + s2*s4*s6;
    const oz6 = s2*s4*c6 - nz5*s6;
    const pz6 = d6*az5 + pz3;
    const T_0_1 = [
        [c1, 0, -s1, 0],
        [s1, 0, c1, 0],
        [0, -1, 0, d1],
        [0, 0, 0, 1],
    ];
    const T_0_2 = [
        [c1*c2, -s1, c1*s2, px2],
        [s1*c2, c1, s1*s2, d2*c1],
        [-s2, 0, c2, d1],
        [0, 0, 0, 1],
    ];
    const T_0_3 = [
        [c1*c2, -s1, c1*s2, px3],
        [s1*c2, c1, s1*s2, py3],
        [-s2, 0, c2, pz3],
        [0, 0, 0, 1],
    ];
    const T_0_4 = [
        [nx4, ox4, ax4, px3],
        [ny4, oy4, ay4, py3],
        [nz4, -c2, s2*s4, pz3],
        [0, 0, 0, 1],
    ];
    const T_0_5 = [
        [nx5, ax4, ax5, px3],
        [ny5, ay4, ay5, py3],
        [nz5, s2*s4, az5, pz3],
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
