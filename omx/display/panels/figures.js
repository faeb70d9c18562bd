// The live figures: what each one shows for the positions of its sliders. A figure takes them (in the sliders' units) and
// its data, and gives lines, dots, bytes and sentences for chart.js. The kinematics are the generated formulas.
(function () {
  "use strict";
  const { OMX_ARM: A, OMX_KINEMATICS: K } = window, { DEG, text, minus, solved } = A;
  const norm = (v) => Math.hypot(...v), flat = (points) => points.map((p) => p.slice(0, 2)), place = (p) => p.slice(0, 3);
  const mix = (a, b, s) => a.map((v, i) => v + s * (b[i] - v));
  const times = (M, v) => M.map((row) => row.reduce((sum, m, i) => sum + m * v[i], 0));
  const steps = (low, high, count) => Array.from({ length: count + 1 }, (_, i) => low + (high - low) * i / count);

  // What leads from the straight line through a and b to a point, as a length.
  function beside(point, a, b) {
    const way = minus(b, a), size = norm(way), out = minus(point, a);
    const share = out.reduce((sum, v, i) => sum + v * way[i], 0) / (size * size || 1);
    return norm(out.map((v, i) => v - share * way[i]));
  }

  // The servo's answer to "your speed and your position", byte by byte.
  function answer([servo, speed, position], { header, status, divisor, speed_unit, tick, zero }) {
    const part = (name, ...bytes) => bytes.map((byte) => ({ name, byte }));
    const little = (number, count) => steps(0, count - 1, count - 1).map((i) => (number >> (8 * i)) & 0xff);
    const body = [];
    for (const one of [...part("answer", status), ...part("error", 0), ...part("speed", ...little(speed, 4)), ...part("position", ...little(position, 4))]) {
      body.push(one);
      if ([3, 2, 1].every((back, i) => body.at(-back)?.byte === header[i])) body.push({ name: "stuffed", byte: header[2] });
    }
    const packet = [...part("header", ...header), ...part("servo", servo), ...part("length", ...little(body.length + 2, 2)), ...body];
    let remainder = 0;
    for (const { byte } of packet) {
      remainder ^= byte << 8;
      for (let bit = 0; bit < 8; bit++) remainder = (remainder << 1) ^ (remainder & 0x8000 ? divisor : 0);
    }
    const extra = body.filter(({ name }) => name === "stuffed").length;
    return {
      bytes: [...packet, ...part("checksum", ...little(remainder, 2))],
      says: [`Servo ${servo} turns at ${text(speed * speed_unit, 1)} deg/s and stands at ${text((position - zero) * tick, 2)} deg.`,
        extra ? "The data hold ff ff fd: one fd is stuffed in behind it, and the length counts it." : "Nothing is stuffed."],
    };
  }

  // A log of the arm seen from above: where the tool was sent, and where it was.
  function log([time], { t, measured, commanded, corners, starts, arm }) {
    const tool = (q_deg) => place(A.pose(q_deg.map((v) => v * DEG), arm));
    const at = t.findLastIndex((moment) => moment <= time + 1e-9), side = starts.findLastIndex((start) => start <= t[at] + 1e-9);
    const way = measured.map(tool), [here, sent] = [way[at], tool(commanded[at])];
    const off = minus(measured[at], commanded[at]), most = off.reduce((k, v, i) => (Math.abs(v) > Math.abs(off[k]) ? i : k), 0);
    return {
      x: "x (mm)", y: "y (mm)", square: true,
      lines: [{ label: "straight sides", points: flat(corners), colour: 0, dash: true }, { label: "measured", points: flat(way.slice(0, at + 1)), colour: 4 },
        { points: flat(way.slice(at)), colour: 4, pale: true }],
      dots: [{ label: "where it was sent", points: flat([sent]), colour: 2, ring: true }, { label: "where it is", points: flat([here]), colour: 4 }],
      says: [`After ${text(time, 1)} s the tool is ${text(norm(minus(here, sent)), 1)} mm from where it was sent; q${most + 1} lacks most, ${text(Math.abs(off[most]), 2)} deg.`,
        `It is ${text(beside(here, corners[side], corners[side + 1]), 1)} mm beside the straight side ${side + 1}.`],
    };
  }

  // Straight in space and straight in joint space, seen from above.
  function ways([x, y, z], { start, pitch, arm }) {
    const first = A.pose(start, arm), goal = [x, y, z, pitch], way = minus(goal, first);
    way[3] = A.turn(way[3]);
    const straight = [first], N = 100;
    let q = start, blocked = "";
    for (let i = 1; i <= N && !blocked; i++) {
      const asked = mix(first, first.map((v, k) => v + way[k]), i / N), found = A.branches(asked, arm), next = A.nearest(found, asked, q, arm);
      if (!next) blocked = A.closest(found).verdict;
      else if (Math.max(...minus(next.q, q).map(Math.abs)) > 0.5) blocked = "a joint would jump";
      else straight.push(asked), (q = next.q);
    }
    const end = A.nearest(A.branches(goal, arm), goal, start, arm)?.q;
    const bent = end ? steps(0, 1, N).map((s) => A.pose(mix(start, end, s), arm)) : [];
    const bulge = Math.max(0, ...bent.map((p) => beside(place(p), place(first), place(goal))));
    const near = Math.min(...straight.map((p) => Math.hypot(p[0], p[1])));
    return {
      x: "x (mm)", y: "y (mm)", square: true, span: [[-20, 270], [-195, 195]],
      lines: [{ label: "straight in space", points: flat(straight), colour: 0 }, { label: "straight in joint space", points: flat(bent), colour: 4, dash: true }],
      dots: [{ label: "start", points: flat([first]), colour: 0 }, { label: "goal", points: flat([goal]), colour: 2, ring: true }, { label: "axis of joint 1", points: [[0, 0]], colour: "currentColor" }],
      says: [end ? `The joint move bulges ${text(bulge, 1)} mm from the line.` : `No joint move: ${A.closest(A.branches(goal, arm)).verdict}.`,
        blocked ? `The line ends after ${text(100 * (straight.length - 1) / N, 0)} %: ${blocked}.` : `The line passes ${text(near, 0)} mm from the axis of joint 1.`],
    };
  }

  // Many arms with joints a little off: where their tips are, and what the Jacobian says.
  function cloud([sigma_deg, shoulder, elbow], { draws, arm }) {
    const sigma = sigma_deg * DEG, q = [0, shoulder * DEG, elbow * DEG, 0];
    const tip = (p) => place(A.pose(p, arm)), nominal = tip(q);
    const off = draws.map((draw) => minus(tip(q.map((v, i) => v + sigma * draw[i])), nominal));
    const J = K.jacobian.jacobian(...q, ...arm.geometry).slice(0, 3), [out, , up] = J;
    const dot = (a, b) => a.reduce((sum, v, i) => sum + v * b[i], 0) * sigma * sigma;
    const [a, b, c] = [dot(out, out), dot(out, up), dot(up, up)], turn = 0.5 * Math.atan2(2 * b, a - c);
    const size = (sign) => Math.sqrt(Math.max(0, 0.5 * (a + c) + sign * Math.hypot(0.5 * (a - c), b)));
    const rim = steps(0, 2 * Math.PI, 60).map((s) => {
      const [u, v] = [2 * size(1) * Math.cos(s), 2 * size(-1) * Math.sin(s)];
      return [u * Math.cos(turn) - v * Math.sin(turn), u * Math.sin(turn) + v * Math.cos(turn)];
    });
    const rms = Math.sqrt(off.reduce((sum, v) => sum + norm(v) ** 2, 0) / off.length), formula = sigma * norm(J.flat());
    return {
      x: "error along x (mm)", y: "error along z (mm)", square: true, span: [[-12, 12], [-12, 12]],
      lines: [{ label: "two sigma, by the Jacobian", points: rim, colour: 4 }],
      dots: [{ label: `${draws.length} arms`, points: off.map(([x, , z]) => [x, z]), colour: 0, small: true }],
      says: [`RMS error of the tip: ${text(rms, 2)} mm drawn, ${text(formula, 2)} mm by the formula.`],
    };
  }

  // Outward, near the straight arm: the fastest joint, with and without damping.
  function damping([gap_deg, lambda], { straight, outward, radian_mm, limit_deg, arm }) {
    const weights = [1, 1, 1, radian_mm];
    function move(gap, damp) {
      const q = [straight[0], straight[1], straight[2] + gap * DEG, straight[3]];
      const J = [...K.jacobian.jacobian(...q, ...arm.geometry).slice(0, 3), [0, -1, -1, -1]].map((row, i) => row.map((v) => v * weights[i]));
      const turned = J.map((_, i) => J.map((row) => row[i])), inner = J.map((row, i) => times(J, row).map((v, j) => v + (i === j ? damp * damp : 0)));
      const wanted = outward.map((v, i) => v * weights[i]), qd = damp ? times(turned, solved(inner, wanted)) : solved(J, wanted);
      return { fastest: Math.max(...qd.map(Math.abs)) / DEG, got: times(J, qd).map((v, i) => v / weights[i]) };
    }
    const gaps = steps(-40, 40, 160).map((gap) => (gap === 0 ? 0.01 : gap)), curve = (damp) => gaps.map((gap) => [gap, move(gap, damp).fastest]);
    const speed = norm(outward), { fastest, got } = move(gap_deg, lambda);
    const along = got.reduce((sum, v, i) => sum + v * outward[i], 0) / speed, here = `${text(gap_deg, 1)}\u00b0 from straight`, real = fastest < 1e6;
    return {
      x: "elbow, from straight (deg)", y: "fastest joint (deg/s)", span: [[-40, 40], [0, 400]],
      lines: [{ label: "no damping", points: curve(0), colour: 0 }, { label: `damping ${text(lambda, 1)} mm`, points: curve(lambda), colour: 4 },
        { label: "the servo's limit", points: [[-40, limit_deg], [40, limit_deg]], colour: "currentColor", dash: true }],
      dots: [{ points: [[gap_deg, fastest]], colour: 4 }],
      says: [real ? `${here}: the fastest joint turns at ${text(fastest, 1)} deg/s.` : `${here} nothing but damping helps: the inverse does not exist.`,
        real ? `The tool gets ${text(along, 1)} mm/s of ${text(speed, 0)}, and the hand tilts at ${text(got[3] / DEG, 1)} deg/s.` : ""],
    };
  }

  window.OMX_FIGURES = { answer, log, ways, cloud, damping };
})();
