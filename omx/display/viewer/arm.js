// Arms without Python: the generated formulas (OMX_KINEMATICS, or those of a chapter's own arm) with verdicts, sentences and
// gaps. Lengths in mm, angles in rad; a matrix is a list of rows. `about` is what arm_data.py writes: rows, limits, branches.
(function () {
  "use strict";
  const DEG = Math.PI / 180, REACH_SLACK = 1e-13, MISSING_SLACK = 1e-9, LIMIT_SLACK = 1e-9, ON_AXIS = 1e-10, NEAR = 1e-7;
  const SLIDE = 100; // so many mm of a slide count as one rad of a turn
  const { fk, ik, jacobian } = window.OMX_KINEMATICS || {};
  const IDENTITY = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]];

  const text = (value, digits) => (Math.round(value * 10 ** digits) / 10 ** digits + 0).toFixed(digits).replace("-", "\u2212");
  const turn = (angle) => angle - 2 * Math.PI * Math.ceil(angle / (2 * Math.PI) - 0.5); // into (-pi, pi]

  // ---- matrices ------------------------------------------------------------------------------------------------------

  const at = (T) => [T[0][3], T[1][3], T[2][3]];
  const column = (T, j) => [T[0][j], T[1][j], T[2][j]];
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

  const frames = (q, about) => (about.geometry ? [IDENTITY, ...fk.frames(...q, ...about.geometry)] : chainFrames(about, q));

  // As the viewer wants a matrix: column by column, the translation in metres. And back.
  const columns = (T) => [0, 1, 2, 3].flatMap((j) => [0, 1, 2, 3].map((i) => (j === 3 && i < 3 ? 1e-3 * T[i][j] : T[i][j])));
  const rows = (m) => [0, 1, 2, 3].map((i) => [0, 1, 2, 3].map((j) => (j === 3 && i < 3 ? 1e3 : 1) * m[4 * j + i]));

  // The tool's frame at a task pose: in the vertical plane through the base axis.
  function target([x, y, z, pitch]) {
    const yaw = Math.atan2(y, x), [c, s, cp, sp] = [Math.cos(yaw), Math.sin(yaw), Math.cos(pitch), Math.sin(pitch)];
    return [[c * cp, c * sp, -s, x], [s * cp, s * sp, c, y], [sp, -cp, 0, z], [0, 0, 0, 1]];
  }
  const poseOf = (T) => [T[0][3], T[1][3], T[2][3], Math.atan2(T[2][0], -T[2][1])];

  // The joint values that put all frames where they are.
  const back = ([x, y, z]) => { // the inverse of a rigid transform
    const R = [0, 1, 2].map((j) => [x[j], y[j], z[j]]);
    return [...R.map((row) => [...row, -(row[0] * x[3] + row[1] * y[3] + row[2] * z[3])]), IDENTITY[3]];
  };
  const joints = (T, { rows, tool }) => rows.map(({ theta, d, prismatic }, i) => {
    const far = tool && i === rows.length - 1 ? product(T[i + 1], back(tool)) : T[i + 1], A = product(back(T[i]), far);
    return prismatic ? A[2][3] - d : turn(Math.atan2(A[1][0], A[0][0]) - theta);
  });

  // ---- what is asked of an arm ---------------------------------------------------------------------------------------

  // Roll, pitch and yaw, as omx/rotation.py has them.
  function toRpy(R) {
    const level = Math.hypot(R[0][0], R[1][0]), pitch = Math.atan2(-R[2][0], level);
    if (level < 1e-13) return [0, pitch, Math.atan2(-R[0][1], R[1][1])];
    const yaw = Math.atan2(R[1][0], R[0][0]), [c, s] = [Math.cos(yaw), Math.sin(yaw)];
    return [Math.atan2(s * R[0][2] - c * R[1][2], c * R[1][1] - s * R[0][1]), pitch, yaw];
  }
  const fromRpy = (angles) => angles.reduce((T, angle, axis) => HAND.turned(T, { axis }, angle), IDENTITY);

  // A target: its numbers as sliders have them (mm, degrees), the frame that it stands for, and how it is moved and turned.
  // A ring turns about the axis u x v.
  const PITCH = {
    who: "Tool", names: ["x", "y", "z", "pitch"], matrix: target, of: poseOf, given: (asked) => asked,
    values: ([x, y, z, pitch]) => [x, y, z, pitch / DEG], asked: ([x, y, z, pitch]) => [x, y, z, pitch * DEG],
    placed: (asked, point) => [...point, asked[3]], turned: (asked, _, angle) => [...asked.slice(0, 3), turn(asked[3] + angle)],
    rings([x, y]) {
      const yaw = Math.atan2(y, x);
      return [{ name: "pitch", u: [Math.cos(yaw), Math.sin(yaw), 0], v: [0, 0, 1] }];
    },
  };
  const HAND = {
    who: "Hand", names: ["x", "y", "z", "roll", "pitch", "yaw"], matrix: (T) => T, of: (T) => T,
    given: (T) => [0, 1, 2, 3].flatMap((j) => column(T, j)),
    values: (T) => [...at(T), ...toRpy(T).map((v) => v / DEG)],
    asked: (values) => HAND.placed(fromRpy(values.slice(3).map((v) => v * DEG)), values),
    placed: (T, point) => T.map((row, i) => (i < 3 ? [...row.slice(0, 3), point[i]] : row)),
    turned(T, { axis }, angle) {
      const [c, s, u, v] = [Math.cos(angle), Math.sin(angle), (axis + 1) % 3, (axis + 2) % 3], out = T.map((row) => [...row]);
      for (const j of [0, 1, 2]) [out[u][j], out[v][j]] = [c * T[u][j] - s * T[v][j], s * T[u][j] + c * T[v][j]];
      return out;
    },
    rings: () => [0, 1, 2].map((axis) => ({ name: "xyz"[axis], axis, u: IDENTITY[(axis + 1) % 3].slice(0, 3), v: IDENTITY[(axis + 2) % 3].slice(0, 3) })),
  };
  const POINT = {
    who: "Tool", names: ["x", "y", "z"], matrix: (point) => IDENTITY.map((row, i) => [...row.slice(0, 3), i < 3 ? point[i] : 1]), of: at,
    values: (point) => point, asked: (point) => point, placed: (_, point) => [...point], rings: () => [],
  };
  const task = ({ geometry, inverse, rows }) => (geometry ? PITCH : inverse && rows.length === 6 ? HAND : POINT);
  const pose = (q, about) => (about.geometry ? fk.pose(...q, ...about.geometry) : task(about).of(frames(q, about).at(-1)));

  // The velocity ellipse: centre and half axes (mm) of where the tip gets in `seconds`, pitch held, when joints 2 and 3 share
  // a speed of 1 rad/s. What joint 4 does follows: it undoes their turn.
  function ellipse(q, geometry, seconds) {
    const [u, v] = [1, 2].map((i) => [0, 1, 2].map((k) => {
      const row = jacobian.jacobian(...q, ...geometry)[k];
      return seconds * (row[i] - row[3]);
    }));
    const turn = 0.5 * Math.atan2(2 * dot(u, v), dot(u, u) - dot(v, v)), [c, s] = [Math.cos(turn), Math.sin(turn)];
    return { centre: fk.pose(...q, ...geometry).slice(0, 3), long: u.map((a, k) => c * a + s * v[k]), short: u.map((a, k) => c * v[k] - s * a) };
  }

  // ---- another arm ---------------------------------------------------------------------------------------------------

  // Other formulas take the place of those that are here: modules as expressions (assets.py), by name.
  function learn(modules) {
    for (const [name, code] of Object.entries(modules)) {
      window.OMX_KINEMATICS[name] = Object.assign(window.OMX_KINEMATICS[name] ?? {}, new Function(`return ${code}`)());
    }
  }

  // This book's arm with other lengths: its rows, and the parts that can meet, as omx/collision.py has them in their frames.
  function resized(about, geometry) {
    const [L1, L2, L3, L4, delta] = geometry, palm = 69 - L4;
    const c = L2 * Math.cos(delta) ** 2 - L2, s = -L2 * Math.cos(delta) * Math.sin(delta);
    const reaches = [[[0, 0, 15], [0, 0, L1 - 25]], [[-L2, 0, 0], [c, s, 0]], [[c, s, 0], [0, 0, 0]], [[-L3, 0, 0], [0, 0, 0]],
      [[-L4, 0, 0], [palm, 0, 0]], [[palm, 0, 0], [22, 0, 0]]];
    const rows = [{ d: L1 }, { a: L2 }, { a: L3 }, { a: L4 }].map((length, i) => ({ ...about.rows[i], ...length }));
    const parts = about.parts.map((part, i) => ({ ...part, a: reaches[i][0], b: reaches[i][1] }));
    return { ...about, geometry, rows, parts };
  }

  // ---- the inverse ---------------------------------------------------------------------------------------------------

  // Each joint beyond its limit, and by how much (rad, mm).
  const ends = ({ limits }, i) => [limits?.[i][0] ?? -Infinity, limits?.[i][1] ?? Infinity];
  const violations = (q, about) => q.flatMap((value, joint) => {
    const [low, high] = ends(about, joint), excess = Math.max(low - value, value - high);
    return excess > LIMIT_SLACK ? [{ joint, value, excess, name: about.names[joint], slides: about.rows[joint].prismatic }] : [];
  });
  const inUnit = (value, slides) => (slides ? `${text(value, 1)}\u2009mm` : `${text(value / DEG, 1)}\u00b0`);
  const words = ({ name, value, excess, slides }) => `${name} = ${inUnit(value, slides)} is ${inUnit(excess, slides)} beyond its limit`;

  // Every branch with a verdict, as `omx.ik` and `omx.analysis.Inverse` give them; none for an arm without an inverse.
  function branches(asked, about) {
    const given = task(about).given?.(asked).map((v) => v + 0); // + 0: no minus zero, which would turn q1 by pi
    return given ? (about.geometry ? ours : written)(given, about).map((branch, index) => judged({ ...branch, index, name: about.branches[index] }, about)) : [];
  }

  const upright = (q, { rows }) => q.map((v, i) => (v === -Math.PI && !rows[i].prismatic ? Math.PI : v));
  function written(asked, about) {
    about.module ??= new Function(`return ${about.inverse}`)();
    const given = [...asked, ...about.lengths], gaps = about.module.missing(...given);
    return about.module.branches(...given).map((q, k) => ({ q: upright(q, about), reachable: gaps[k] <= MISSING_SLACK, missing: gaps[k] }));
  }

  function ours(asked, about) {
    const given = [...asked, ...about.geometry];
    const [frontUp, frontDown, backUp, backDown, front, back] = ik.branches(...given);
    const missing = ik.missing(...given);
    return [frontUp, frontDown, backUp, backDown].map((angles, k) => {
      const reachable = Math.abs(k < 2 ? front : back) <= 1 + REACH_SLACK;
      return { q: upright(angles, about), reachable, missing: missing[k < 2 ? 0 : 1] };
    });
  }

  function judged(branch, about) {
    const broken = branch.reachable ? violations(branch.q, about) : [];
    const verdict = branch.reachable ? broken.map(words).join("; ") || "legal" : `out of reach, ${text(branch.missing, 1)} mm missing`;
    return { ...branch, broken, legal: branch.reachable && !broken.length, verdict };
  }

  // The legal branch with the least way to go from q, as `omx.solve_ik` and `HandPanel` choose it; undefined if there is none.
  function nearest(found, asked, q, about) {
    const apart = (v, i) => (about.geometry ? v - q[i] : about.rows[i].prismatic ? (v - q[i]) / SLIDE : turn(v - q[i]));
    const way = (s) => s.q.reduce((sum, v, i) => sum + apart(v, i) ** 2, 0);
    if (about.geometry && Math.max(Math.abs(asked[0]), Math.abs(asked[1])) <= ON_AXIS) { // on the axis q1 is free: it stays
      const [low, high] = about.limits[0], q1 = turn(Math.min(Math.max(turn(q[0]), low), high));
      found = found.slice(0, 2).map((s) => judged({ ...s, q: [q1, ...s.q.slice(1)] }, about));
    }
    return found.filter((s) => s.legal).sort((a, b) => way(a) - way(b))[0];
  }

  // Of branches that are not legal, the one that comes closest.
  function closest(found) {
    const excess = (s) => (s.reachable ? Math.max(...s.broken.map((v) => v.excess / (v.slides ? SLIDE : 1))) : 1e3 + s.missing);
    return [...found].sort((a, b) => excess(a) - excess(b))[0];
  }

  // What is free at q, in words, as `omx.analysis.Inverse` tells it for a hand: two axes on one line, or one through the wrist.
  function families(q, about) {
    const { rows, names } = about, T = frames(q, about), z = T.map((F) => column(F, 2)), o = T.map(at);
    const size = NEAR * rows.reduce((sum, { a, d }) => sum + Math.abs(a) + Math.abs(d), 0);
    const aligned = (i, j) => Math.hypot(...cross(z[i - 1], z[j - 1])) < NEAR;
    const passes = (i, point) => Math.hypot(...cross(minus(point, o[i - 1]), z[i - 1])) < size;
    const follow = (i) => `${names[i - 1]} is free, and others follow`;
    const found = [1, 2].filter((i) => (i === 1 || (rows[4].d === 0 && rows[3].a === 0)) && passes(i, o[5])).map(follow);
    if (aligned(4, 6) && passes(4, o[5]) && passes(6, o[4])) {
      const same = dot(z[3], z[5]) > 0, total = same ? q[3] + q[5] : q[3] - q[5];
      found.push(`only ${names[3]} ${same ? "+" : "\u2212"} ${names[5]} = ${text(total / DEG, 2)}\u00b0 is fixed`);
    } else if (aligned(2, 6) && aligned(2, 3) && aligned(3, 4)) found.push(follow(6));
    return found;
  }

  // ---- a link under the reader's hand --------------------------------------------------------------------------------

  // Joint values that bring a point of a link (mm, in its frame) nearest to `goal`, from q: damped least squares over the
  // joints before it, in small steps; a joint that pushes on beyond its limit is held there. And what is in the way. With a
  // `sight` (3,) the goal is the line through it, of which a hand on a screen does not know how deep it reaches.
  function pull(q, link, point, goal, about, sight) {
    const near = approach(q, link, point, goal, about, sight);
    if (near.gap < 0.5) return { ...near, verdict: "" };
    const free = approach(q, link, point, goal, { ...about, limits: null }, sight);
    const broken = free.gap < near.gap - 0.5 ? violations(free.q, about) : [];
    return { ...near, broken: broken.length > 0, verdict: broken.map(words).join("; ") || `out of reach, ${text(near.gap, 1)} mm missing` };
  }

  const STEPS = 40, STEP = 0.08, DAMPING = 0.01, STIFF = 10; // the middle two, and the most damping, as shares of the arm's reach
  function approach(q, link, point, goal, about, sight = [0, 0, 0]) {
    const across = (v) => v.map((x, i) => x - dot(v, sight) * sight[i]);
    const look = (q) => {
      const T = frames(q, about), here = applied(T[link], point), miss = across(minus(goal, here));
      return { q, T, here, miss, gap: Math.hypot(...miss) };
    };
    let now = look(q), damping = DAMPING;
    for (let k = 0; k < STEPS && now.gap > 1e-3 && damping < STIFF; k++) {
      const { T, here, miss, gap } = now;
      const J = about.rows.slice(0, link).map(({ prismatic }, i) =>
        across(prismatic ? column(T[i], 2).map((v) => SLIDE * v) : cross(column(T[i], 2), minus(here, at(T[i])))));
      const next = look(stepped(now.q, J, miss.map((v) => v * Math.min(1, STEP * about.reach / gap)), damping * about.reach, about));
      if (next.gap < gap - 1e-4) [now, damping] = [next, Math.max(DAMPING, damping / 4)];
      else damping *= 4;
    }
    return now;
  }

  // One step; joints that it would take beyond a limit stop there, and the others make up for them.
  function stepped(q, J, miss, damping, about) {
    const unit = (i) => (about.rows[i].prismatic ? SLIDE : 1), fixed = new Map();
    for (;;) {
      const rest = minus(miss, [0, 1, 2].map((k) => [...fixed].reduce((sum, [i, by]) => sum + J[i][k] * by, 0)));
      const free = J.filter((_, i) => !fixed.has(i)), entry = (i, k) => free.reduce((sum, c) => sum + c[i] * c[k], i === k ? damping ** 2 : 0);
      const force = solved([0, 1, 2].map((i) => [0, 1, 2].map((k) => entry(i, k))), rest); // (J J^T + damping^2)^-1 of what is left
      const step = q.map((_, i) => fixed.get(i) ?? (J[i] ? dot(J[i], force) : 0));
      const beyond = step.findIndex((by, i) => J[i] && !fixed.has(i) && q[i] + unit(i) * by !== clipped(q[i] + unit(i) * by, about, i));
      if (beyond < 0) return q.map((v, i) => clipped(v + unit(i) * step[i], about, i));
      fixed.set(beyond, (clipped(q[beyond] + unit(beyond) * step[beyond], about, beyond) - q[beyond]) / unit(beyond));
    }
  }

  const clipped = (v, about, i) => Math.min(Math.max(v, ends(about, i)[0]), ends(about, i)[1]);
  const applied = (T, p) => [0, 1, 2].map((k) => dot(T[k], p) + T[k][3]);
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];

  // x with M x = v, by elimination with the largest pivot; not finite where M is singular.
  function solved(M, v) {
    const rows = M.map((row, i) => [...row, v[i]]), n = v.length;
    for (let k = 0; k < n; k++) {
      const best = rows.slice(k).reduce((at, row, i) => (Math.abs(row[k]) > Math.abs(rows[at][k]) ? k + i : at), k);
      [rows[k], rows[best]] = [rows[best], rows[k]];
      for (let i = 0; i < n; i++) {
        const factor = rows[i][k] / rows[k][k];
        if (i !== k) rows[i] = rows[i].map((m, j) => m - factor * rows[k][j]);
      }
    }
    return rows.map((row, i) => row[n] / row[i]);
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
    const T = frames(q, about);
    const parts = about.parts.map(({ name, frame, a, b, radius }) => ({ name, radius, a: applied(T[frame], a), b: applied(T[frame], b) }));
    const pairs = about.pairs.map(([i, j]) =>
      [parts[i].name, parts[j].name, distance(parts[i], parts[j]) - parts[i].radius - parts[j].radius]);
    return [...pairs, ...about.over.map((i) => [parts[i].name, "table", Math.min(parts[i].a[2], parts[i].b[2]) - parts[i].radius])];
  }

  // One sentence about what touches, worst first; nothing if the arm is clear.
  function touching(q, about) {
    const worst = about.parts && gaps(q, about).filter(([, , gap]) => gap < 0).sort((a, b) => a[2] - b[2])[0];
    if (!worst) return "";
    const [one, other, gap] = worst, mm = `${text(-gap, 0)}\u2009mm`;
    return other === "table" ? `${one} ${mm} below the table` : `${one} and ${other} overlap by ${mm}`;
  }

  window.OMX_ARM = { DEG, IDENTITY, text, turn, minus, solved, product, link, chainFrames, frames, pose, columns, rows, at, target, poseOf, joints,
    ellipse, task, branches, nearest, closest, families, violations, words, inUnit, pull, applied, gaps, touching, learn, resized };
})();
