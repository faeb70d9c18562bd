// Inverse kinematics of the OpenMANIPULATOR-X.
//
// Written by notebooks/05-inverse-kinematics.ipynb. Do not edit: change the chapter and run it.
// Lengths are in mm, angles in rad.

const wrap = (angle) => angle - 2*Math.PI*Math.ceil(angle/(2*Math.PI) - 0.5);

/** Joint angles of the four branches, and D = cos(bend) of the front and the back: out of reach where |D| > 1. 109 operations and 2 sines and cosines. */
export function branches(x, y, z, pitch, L1, L2, L3, L4, delta) {
    const s_pitch = Math.sin(pitch);
    const c_pitch = Math.cos(pitch);
    const r = Math.sqrt(x*x + y*y);
    const z_w = z - L1 - L4*s_pitch;
    const q1_front = Math.atan2(y, x);
    const q1_back = wrap(Math.PI + q1_front);
    const r_w_front = r - L4*c_pitch;
    const D_front = (r_w_front*r_w_front + z_w*z_w - L2*L2 - L3*L3)/(2*L2*L3);
    const s_front = Math.sqrt(Math.max(0.0, (1 - D_front)*(1 + D_front)));
    const mu_front = Math.atan2(z_w, r_w_front);
    const gamma_front = Math.atan2(L3*s_front, L2 + L3*D_front);
    const bend_front = Math.atan2(s_front, D_front);
    const q2_front_up = wrap(Math.PI/2 - delta - gamma_front - mu_front);
    const q3_front_up = wrap(delta + bend_front - Math.PI/2);
    const q4_front_up = wrap(-pitch - q2_front_up - q3_front_up);
    const q2_front_down = wrap(Math.PI/2 + gamma_front - delta - mu_front);
    const q3_front_down = wrap(delta - Math.PI/2 - bend_front);
    const q4_front_down = wrap(-pitch - q2_front_down - q3_front_down);
    const r_w_back = -L4*c_pitch - r;
    const D_back = (r_w_back*r_w_back + z_w*z_w - L2*L2 - L3*L3)/(2*L2*L3);
    const s_back = Math.sqrt(Math.max(0.0, (1 - D_back)*(1 + D_back)));
    const mu_back = Math.atan2(z_w, r_w_back);
    const gamma_back = Math.atan2(L3*s_back, L2 + L3*D_back);
    const bend_back = Math.atan2(s_back, D_back);
    const q2_back_up = wrap(Math.PI/2 - delta - gamma_back - mu_back);
    const q3_back_up = wrap(delta + bend_back - Math.PI/2);
    const q4_back_up = wrap(-pitch - q2_back_up - q3_back_up);
    const q2_back_down = wrap(Math.PI/2 + gamma_back - delta - mu_back);
    const q3_back_down = wrap(delta - Math.PI/2 - bend_back);
    const q4_back_down = wrap(-pitch - q2_back_down - q3_back_down);
    const front_up = [q1_front, q2_front_up, q3_front_up, q4_front_up];
    const front_down = [q1_front, q2_front_down, q3_front_down, q4_front_down];
    const back_up = [q1_back, q2_back_up, q3_back_up, q4_back_up];
    const back_down = [q1_back, q2_back_down, q3_back_down, q4_back_down];
    return [front_up, front_down, back_up, back_down, D_front, D_back];
}

/** How far (mm) the wrist is out of reach: front, back; 0 within reach. 34 operations and 2 sines and cosines. */
export function missing(x, y, z, pitch, L1, L2, L3, L4, delta) {
    const s_pitch = Math.sin(pitch);
    const c_pitch = Math.cos(pitch);
    const r = Math.sqrt(x*x + y*y);
    const z_w = z - L1 - L4*s_pitch;
    const d_w_front = Math.sqrt(Math.pow(r - L4*c_pitch, 2) + z_w*z_w);
    const d_w_back = Math.sqrt(Math.pow(-L4*c_pitch - r, 2) + z_w*z_w);
    const front = Math.max(Math.max(0.0, Math.abs(L2 - L3) - d_w_front), d_w_front - L2 - L3);
    const back = Math.max(Math.max(0.0, Math.abs(L2 - L3) - d_w_back), d_w_back - L2 - L3);
    return [front, back];
}
