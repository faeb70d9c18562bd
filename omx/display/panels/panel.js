// Sliders that move an arm in a page without Python. The formulas are those that the chapters derived: the same code
// generator writes them as Python and as JavaScript (omx-kinematics.js).
(function () {
  "use strict";
  const DEG = Math.PI / 180;
  const { fk, ik } = window.OMX_KINEMATICS || {};
  const BRANCHES = ["front, elbow up", "front, elbow down", "back, elbow up", "back, elbow down"];
  const COLOURS = ["#0072b2", "#e69f00", "#009e73", "#cc79a7"]; // of the ghosts, as omx.display.viewer has them
  const GREEK = { theta: "\u03b8", alpha: "\u03b1" };
  const HOME = [0, -1.05, 0.35, 0.7];

  const text = (value, digits) => (Math.round(value * 10 ** digits) / 10 ** digits + 0).toFixed(digits).replace("-", "\u2212");

  function element(tag, attributes, ...children) {
    const node = document.createElement(tag);
    for (const [name, value] of Object.entries(attributes || {})) node.setAttribute(name, value);
    node.append(...children);
    return node;
  }

  // ---- kinematics ------------------------------------------------------------------------------------------------

  // T_0_0 .. T_0_n of any chain, from its DH rows, as rows of 4x4 matrices.
  function chainFrames(rows, q) {
    const frames = [[[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]];
    rows.forEach(({ theta, d, a, alpha, prismatic }, i) => {
      const t = prismatic ? theta : theta + q[i], s = prismatic ? d + q[i] : d;
      const [ct, st, ca, sa] = [Math.cos(t), Math.sin(t), Math.cos(alpha), Math.sin(alpha)];
      const A = [[ct, -st * ca, st * sa, a * ct], [st, ct * ca, -ct * sa, a * st], [0, sa, ca, s], [0, 0, 0, 1]];
      frames.push(frames[i].map((row) => A[0].map((_, j) => row.reduce((sum, v, k) => sum + v * A[k][j], 0))));
    });
    return frames;
  }

  const columns = (T) => [0, 1, 2, 3].flatMap((j) => [0, 1, 2, 3].map((i) => (j === 3 && i < 3 ? 1e-3 * T[i][j] : T[i][j])));

  const outside = (q, limits) => q.flatMap((angle, i) => {
    const [low, high] = limits[i];
    const excess = angle < low ? angle - low : angle > high ? angle - high : 0;
    return Math.abs(excess) > 1e-9 ? [`q${i + 1} = ${text(angle / DEG, 1)}\u00b0 is ${text(Math.abs(excess) / DEG, 1)}\u00b0 beyond its limit`] : [];
  });

  // The four branches with a verdict each, as omx.ik gives them.
  function branches(pose, geometry, limits) {
    const [frontUp, frontDown, backUp, backDown, front, back] = ik.branches(...pose, ...geometry);
    const missing = ik.missing(...pose, ...geometry);
    return [frontUp, frontDown, backUp, backDown].map((q, k) => {
      const reachable = Math.abs(k < 2 ? front : back) <= 1 + 1e-13;
      const broken = reachable ? outside(q, limits) : [];
      const verdict = reachable ? broken.join("; ") || "legal" : `out of reach, ${text(missing[k < 2 ? 0 : 1], 1)} mm missing`;
      return { name: BRANCHES[k], q, reachable, legal: reachable && !broken.length, verdict };
    });
  }

  // ---- one panel -------------------------------------------------------------------------------------------------

  class Panel {
    constructor(box) {
      this.box = box;
      Object.assign(this, { limits: null, rows: null }, JSON.parse(box.dataset.panel));
      this.pale = box.closest(".omx-robot"); // the ghost of a robot's panel is what you ask for: here the arm obeys at once
      box.dataset.kind = this.kind;
      this.controls = element("div", { class: "omx-controls" });
      box.append(this.controls);
      ({ pose: () => this.poseControls(), row: () => this.rowControls(), joints: () => this.jointControls() })[this.kind]();
      window.addEventListener("message", (event) => {
        if (event.data?.omx === "ready" && event.source === this.frame()?.contentWindow) this.send();
      });
      this.show();
    }

    frame() { return this.box.querySelector("iframe"); }

    frames(q) {
      if (this.rows) return chainFrames(this.rows, q);
      return [[[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]], ...fk.frames(...q, ...this.geometry)];
    }

    // Tell the scene; the newest position always wins, one message a repaint.
    send() {
      this.asked ??= requestAnimationFrame(() => {
        this.asked = null;
        if (this.kind === "row") return this.sendRow();
        const nodes = {}, visible = {};
        if (this.pale) visible["/meshcat/ghosts"] = false;
        this.frames(this.q).forEach((T, i) => { nodes[`/meshcat/arm/${i}`] = columns(T); });
        if (this.pose) nodes["/meshcat/notes/target"] = columns(this.targetMatrix());
        (this.found || []).forEach((s, k) => {
          visible[`/meshcat/ghosts/${k}`] = s.reachable && s !== this.chosen;
          if (s.reachable) this.frames(s.q).forEach((T, i) => { nodes[`/meshcat/ghosts/${k}/${i}`] = columns(T); });
        });
        this.post(nodes, visible);
      });
    }

    post(nodes, visible) {
      this.frame()?.contentWindow?.postMessage({ omx: "transforms", nodes, visible }, "*");
    }

    targetMatrix() {
      const [x, y, z, pitch] = this.pose;
      const yaw = Math.atan2(y, x), [c, s, cp, sp] = [Math.cos(yaw), Math.sin(yaw), Math.cos(pitch), Math.sin(pitch)];
      return [[c * cp, c * sp, -s, x], [s * cp, s * sp, c, y], [sp, -cp, 0, z], [0, 0, 0, 1]];
    }

    slider(list, name, unit, low, high, value, hear) {
      const input = element("input", { type: "range", min: low, max: high, step: 1, "aria-label": `${name} in ${unit}` });
      input.value = value;
      const output = element("output", {});
      const tell = () => {
        output.textContent = `${text(Number(input.value), 0)}${unit === "\u00b0" ? "" : "\u2009"}${unit}`;
        input.setAttribute("aria-valuetext", `${input.value} ${unit}`);
      };
      input.addEventListener("input", () => { tell(); hear(); });
      input.tell = tell;
      tell();
      const limits = element("span", { class: "omx-limits" }, `${text(low, 0)} to ${text(high, 0)}`);
      list.append(element("label", {}, element("i", {}, name), input, output, limits));
      return input;
    }

    // -- joints ---------------------------------------------------------------------------------------------------

    jointControls() {
      const sliders = element("div", { class: "omx-sliders" });
      const joints = this.q.map((_, i) => {
        const sliding = this.rows?.[i].prismatic;
        const scale = sliding ? 1 : DEG;
        const [low, high] = this.limits?.[i] || (sliding ? [0, 100] : [-Math.PI, Math.PI]);
        return { scale, low: Math.ceil(low / scale - 1e-6), high: Math.floor(high / scale + 1e-6), unit: sliding ? "mm" : "\u00b0" };
      });
      this.inputs = joints.map(({ scale, low, high, unit }, i) =>
        this.slider(sliders, this.names?.[i] || `q${i + 1}`, unit, low, high, this.q[i] / scale, () => {
          this.q = this.inputs.map((input, k) => Number(input.value) * joints[k].scale);
          this.show();
        }));
      const go = (name, q) => {
        const button = element("button", { type: "button" }, name);
        button.addEventListener("click", () => {
          this.q = [...q];
          this.inputs.forEach((input, k) => { input.value = q[k] / joints[k].scale; input.tell(); });
          this.show();
        });
        return button;
      };
      const poses = [go("zero", joints.map(({ low, high, scale }) => scale * Math.min(Math.max(0, low), high)))];
      if (this.geometry) poses.push(go("home", HOME));
      sliders.append(element("p", { class: "omx-poses" }, ...poses));
      this.answer = element("div", { class: "omx-answer" });
      this.controls.append(sliders, this.answer);
    }

    matrix(T, name, words) {
      const body = element("tbody", {});
      for (const row of T) body.append(element("tr", {}, ...row.map((v, j) => element("td", {}, text(v, j === 3 ? 1 : 3)))));
      const table = element("table", { class: "omx-matrix", "aria-label": `${words}, position in mm` }, body);
      return element("div", { class: "omx-equation" }, element("i", {}, name), " = ", table);
    }

    writePose() {
      const T = this.frames(this.q).at(-1);
      const values = ["x", "y", "z"].map((name, i) => `${name} = ${text(T[i][3], 1)} mm`);
      if (this.geometry) values.push(`pitch = ${text(fk.pose(...this.q, ...this.geometry)[3] / DEG, 1)}\u00b0`);
      this.answer.replaceChildren(element("p", { class: "omx-values" }, ...values.map((v) => element("span", {}, v))),
        this.matrix(T, "T", "the pose T"));
    }

    // -- one DH row -----------------------------------------------------------------------------------------------

    rowControls() {
      const sliders = element("div", { class: "omx-sliders" });
      const scales = this.sliders.map(([, unit]) => (unit === "mm" ? 1 : DEG));
      this.inputs = this.sliders.map(([name, unit, low, high], i) =>
        this.slider(sliders, GREEK[name] || name, unit === "mm" ? "mm" : "\u00b0", low, high, this.q[i] / scales[i], () => {
          this.q = this.inputs.map((input, k) => Number(input.value) * scales[k]);
          this.show();
        }));
      this.answer = element("div", { class: "omx-answer" });
      this.controls.append(sliders, this.answer);
    }

    sendRow() {
      const { nodes, shown } = OMX_ROW.places(...this.q);
      const there = (things, value) =>
        Object.fromEntries(Object.entries(things).map(([name, v]) => [`/meshcat/notes/${name}`, value(v)]));
      this.post(there(nodes, columns), there(shown, (v) => v));
    }

    writeRow() {
      this.answer.replaceChildren(this.matrix(OMX_ROW.link(...this.q), "A", "the link matrix A"));
    }

    // -- pose -----------------------------------------------------------------------------------------------------

    poseControls() {
      const [, L2, L3, L4] = this.geometry, reach = Math.ceil(L2 + L3 + L4);
      this.pose = fk.pose(...this.q, ...this.geometry);
      const spans = [["x", "mm", -reach, reach], ["y", "mm", -reach, reach], ["z", "mm", -200, 77 + reach], ["pitch", "\u00b0", -120, 120]];
      const sliders = element("div", { class: "omx-sliders" });
      this.inputs = spans.map(([name, unit, low, high], i) =>
        this.slider(sliders, name, unit, low, high, this.pose[i] / (i === 3 ? DEG : 1), () => {
          this.pose = this.inputs.map((input, k) => Number(input.value) * (k === 3 ? DEG : 1));
          this.solve();
          this.show();
        }));
      this.answer = element("div", { class: "omx-answer", role: "status" });
      this.controls.append(sliders, this.answer);
      this.solve();
    }

    // The arm takes the legal branch that is nearest to where it is; without one, it stays.
    solve() {
      this.found = branches(this.pose, this.geometry, this.limits);
      const way = (s) => s.q.reduce((sum, v, i) => sum + (v - this.q[i]) ** 2, 0);
      const legal = this.found.filter((s) => s.legal).sort((a, b) => way(a) - way(b));
      this.chosen = legal[0];
      if (this.chosen) this.q = this.chosen.q;
    }

    writeBranches() {
      const body = element("tbody", { role: "rowgroup" });
      for (const s of this.found) {
        const angles = s.reachable ? s.q.map((v) => text(v / DEG, 1)).join("\u2002") : "\u2014";
        const cells = [s.name, angles, s.verdict].map((word, i) => element("td", { role: "cell", ...(i === 1 && { class: "omx-angles" }) }, word));
        const colour = COLOURS[this.found.indexOf(s)];
        cells[0].prepend(element("span", { style: `color: ${colour}`, "aria-hidden": "true" }, "\u25cf "));
        body.append(element("tr", { role: "row", ...(s === this.chosen && { class: "omx-chosen" }) }, ...cells));
      }
      const names = ["branch", "q (\u00b0)", "verdict"].map((word) => element("th", { scope: "col", role: "columnheader" }, word));
      const head = element("thead", { role: "rowgroup" }, element("tr", { role: "row" }, ...names));
      const table = element("table", { class: "omx-branches", role: "table" }, head, body); // roles: the style makes it no table
      const words = this.chosen ? `The arm takes ${this.chosen.name}.` : "The arm stays: no branch is legal here.";
      this.answer.replaceChildren(element("p", {}, words), table);
    }

    show() {
      ({ pose: () => this.writeBranches(), row: () => this.writeRow(), joints: () => this.writePose() })[this.kind]();
      this.send();
    }
  }

  if (fk && ik) for (const box of document.querySelectorAll(".omx-panel[data-panel]")) new Panel(box);
})();
