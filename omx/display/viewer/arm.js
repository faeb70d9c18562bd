// The arm without Python: the generated formulas (OMX_KINEMATICS) with verdicts, sentences and gaps. Lengths in mm, angles
// in rad; a matrix is a list of rows. `about` is what arm_data.py writes: lengths, limits, branches, parts.
(function () {
  "use strict";
  const DEG = Math.PI / 180, REACH_SLACK = 1e-13, LIMIT_SLACK = 1e-9, ON_AXIS = 1e-10;
  const { fk, ik, jacobian } = window.OMX_KINEMATICS || {};
  const IDENTITY = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]];

  const text = (value, digits) => (Math.round(value * 10 ** digits) / 10 ** digits + 0).toFixed(digits).replace("-", "\u2212");
  const turn = (angle) => angle - 2 * Math.PI * Math.ceil(angle / (2 * Math.PI) - 0.5); // into (-pi, pi]

  // ---- matrices ------------------------------------------------------------------------------------------------------

  const product = (A, B) => A.map((row) => B[0].map((_, j) => row.reduce((sum, v, k) => sum + v * B[k][j], 0)));

  // The link matrix A of a DH row.
  function link(theta, d, a, alpha) {
    const [ct, st, ca, sa] = [Math.cos(theta), Math.sin(theta), Math.cos(alpha), Math.sin(alpha)];
    return [[ct, -st * ca, st * sa, a * ct], [st, ct * ca, -ct * sa, a * st], [0, sa, ca, d], [0, 0, 0, 1]];
  }

  // T_0_0 .. T_0_n of any chain, from its DH rows; the first is its base, the last carries its tool.
  const chainFrames = ({ rows, base = IDENTITY, tool }, q) => rows.reduce((frames, { theta, d, a, alpha, prismatic }, i) => {
    const A = prismatic ? link(theta, d + q[i], a, alpha) : link(theta + q[i], d, a, alpha);
    return [...frames, product(frames[i], tool && i === rows.length - 1 ? product(A, tool) : A)];
  }, [base]);

  const frames = (q, geometry) => [IDENTITY, ...fk.frames(...q, ...geometry)];
  const pose = (q, geometry) => fk.pose(...q, ...geometry);

  // As the viewer wants a matrix: column by column, the translation in metres. And back.
  const columns = (T) => [0, 1, 2, 3].flatMap((j) => [0, 1, 2, 3].map((i) => (j === 3 && i < 3 ? 1e-3 * T[i][j] : T[i][j])));
  const rows = (m) => [0, 1, 2, 3].map((i) => [0, 1, 2, 3].map((j) => (j === 3 && i < 3 ? 1e3 : 1) * m[4 * j + i]));

  // The tool's frame at a task pose: in the vertical plane through the base axis.
  function target([x, y, z, pitch]) {
    const yaw = Math.atan2(y, x), [c, s, cp, sp] = [Math.cos(yaw), Math.sin(yaw), Math.cos(pitch), Math.sin(pitch)];
    return [[c * cp, c * sp, -s, x], [s * cp, s * sp, c, y], [sp, -cp, 0, z], [0, 0, 0, 1]];
  }
  const poseOf = (T) => [T[0][3], T[1][3], T[2][3], Math.atan2(T[2][0], -T[2][1])];

  // The joint angles that put the four moving frames where they are.
  function joints([T1, T2, T3, T4], geometry) {
    const q12 = Math.atan2(-T2[2][1], T2[2][0]) - geometry[4];
    const q123 = Math.atan2(-T3[2][0], -T3[2][1]), q1234 = Math.atan2(-T4[2][0], -T4[2][1]);
    return [Math.atan2(T1[1][0], T1[0][0]), q12, q123 - q12, q1234 - q123].map(turn);
  }

  // The velocity ellipse: centre and half axes (mm) of where the tip gets in `seconds`, pitch held, when joints 2 and 3 share
  // a speed of 1 rad/s. What joint 4 does follows: it undoes their turn.
  function ellipse(q, geometry, seconds) {
    const [u, v] = [1, 2].map((i) => [0, 1, 2].map((k) => {
      const row = jacobian.jacobian(...q, ...geometry)[k];
      return seconds * (row[i] - row[3]);
    }));
    const turn = 0.5 * Math.atan2(2 * dot(u, v), dot(u, u) - dot(v, v)), [c, s] = [Math.cos(turn), Math.sin(turn)];
    return { centre: pose(q, geometry).slice(0, 3), long: u.map((a, k) => c * a + s * v[k]), short: u.map((a, k) => c * v[k] - s * a) };
  }

  // ---- the inverse ---------------------------------------------------------------------------------------------------

  // Each joint beyond its limit, and by how much (rad).
  const violations = (q, limits) => q.flatMap((angle, i) => {
    const [low, high] = limits[i], excess = Math.max(low - angle, angle - high);
    return excess > LIMIT_SLACK ? [{ joint: i, angle, excess }] : [];
  });
  const words = ({ joint, angle, excess }) =>
    `q${joint + 1} = ${text(angle / DEG, 1)}\u00b0 is ${text(excess / DEG, 1)}\u00b0 beyond its limit`;

  // The four branches with a verdict each, as `omx.ik` gives them.
  function branches(asked, about) {
    const given = [...asked.map((v) => v + 0), ...about.geometry]; // + 0: no minus zero, which would turn q1 by pi
    const [frontUp, frontDown, backUp, backDown, front, back] = ik.branches(...given);
    const missing = ik.missing(...given);
    return [frontUp, frontDown, backUp, backDown].map((angles, k) => {
      const reachable = Math.abs(k < 2 ? front : back) <= 1 + REACH_SLACK;
      const q = angles.map((v) => (v === -Math.PI ? Math.PI : v));
      return judged({ name: about.branches[k], index: k, q, reachable, missing: missing[k < 2 ? 0 : 1] }, about);
    });
  }

  function judged(branch, about) {
    const broken = branch.reachable ? violations(branch.q, about.limits) : [];
    const verdict = branch.reachable ? broken.map(words).join("; ") || "legal" : `out of reach, ${text(branch.missing, 1)} mm missing`;
    return { ...branch, broken, legal: branch.reachable && !broken.length, verdict };
  }

  // The legal branch with the least way to go from q, as `omx.solve_ik` chooses it; undefined if there is none.
  function nearest(found, asked, q, about) {
    const way = (s) => s.q.reduce((sum, v, i) => sum + (v - q[i]) ** 2, 0);
    if (Math.max(Math.abs(asked[0]), Math.abs(asked[1])) <= ON_AXIS) { // on the axis q1 is free: it stays
      const [low, high] = about.limits[0], q1 = turn(Math.min(Math.max(turn(q[0]), low), high));
      found = found.slice(0, 2).map((s) => judged({ ...s, q: [q1, ...s.q.slice(1)] }, about));
    }
    return found.filter((s) => s.legal).sort((a, b) => way(a) - way(b))[0];
  }

  // Of branches that are not legal, the one that comes closest.
  function closest(found) {
    const excess = (s) => (s.reachable ? Math.max(...s.broken.map((v) => v.excess)) : 1e3 + s.missing);
    return [...found].sort((a, b) => excess(a) - excess(b))[0];
  }

  // ---- how near the arm comes to the table and to itself -------------------------------------------------------------

  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const minus = (a, b) => a.map((v, i) => v - b[i]);
  const clip = (v) => Math.min(Math.max(v, 0), 1);

  // The shortest distance between two segments, as omx/collision.py has it.
  function distance(one, other) {
    const u = minus(one.b, one.a), v = minus(other.b, other.a), w = minus(one.a, other.a);
    const [a, b, c, d, e] = [dot(u, u), dot(u, v), dot(v, v), dot(u, w), dot(v, w)];
    const denominator = a * c - b * b;
    let s = denominator > 1e-9 * a * c ? clip((b * e - c * d) / denominator) : 0;
    const t = c > 0 ? clip((b * s + e) / c) : 0;
    s = a > 0 ? clip((b * t - d) / a) : 0;
    const gap = [0, 1, 2].map((i) => w[i] + s * u[i] - t * v[i]);
    return Math.sqrt(dot(gap, gap));
  }

  // What can meet, and the gap (mm, negative where they overlap).
  function gaps(q, about) {
    const T = frames(q, about.geometry);
    const at = (i, p) => [0, 1, 2].map((k) => dot(T[i][k], p) + T[i][k][3]);
    const parts = about.parts.map(({ name, frame, a, b, radius }) => ({ name, radius, a: at(frame, a), b: at(frame, b) }));
    const pairs = about.pairs.map(([i, j]) =>
      [parts[i].name, parts[j].name, distance(parts[i], parts[j]) - parts[i].radius - parts[j].radius]);
    return [...pairs, ...about.over.map((i) => [parts[i].name, "table", Math.min(parts[i].a[2], parts[i].b[2]) - parts[i].radius])];
  }

  // One sentence about what touches, worst first; nothing if the arm is clear.
  function touching(q, about) {
    const worst = gaps(q, about).filter(([, , gap]) => gap < 0).sort((a, b) => a[2] - b[2])[0];
    if (!worst) return "";
    const [one, other, gap] = worst, mm = `${text(-gap, 0)}\u2009mm`;
    return other === "table" ? `${one} ${mm} below the table` : `${one} and ${other} overlap by ${mm}`;
  }

  window.OMX_ARM = { DEG, IDENTITY, text, turn, product, link, chainFrames, frames, pose, columns, rows, target, poseOf, joints, ellipse,
    branches, nearest, closest, words, gaps, touching };
})();
