// Sliders that move an arm, or a live figure, in a page without Python. The formulas are those that the chapters derived: the
// same code generator writes them as Python and as JavaScript (omx-kinematics.js).
(function () {
  "use strict";
  const { OMX_ARM: A, OMX_FIGURES, OMX_CHART } = window;
  if (!window.OMX_KINEMATICS) return;
  const { DEG, text, columns } = A;
  const NEAREST = "nearest", SETTLE_MS = 450; // until what a figure says is spoken
  const GREEK = { theta: "\u03b8", alpha: "\u03b1" };

  function element(tag, attributes, ...children) {
    const node = document.createElement(tag);
    for (const [name, value] of Object.entries(attributes || {})) node.setAttribute(name, value);
    node.append(...children);
    return node;
  }

  // ---- one panel -------------------------------------------------------------------------------------------------

  class Panel {
    constructor(box) {
      this.box = box;
      box.omxPanel = this;
      Object.assign(this, JSON.parse(box.dataset.panel));
      this.about = JSON.parse(box.querySelector("[data-config]")?.dataset.config ?? "{}").arm; // what its scene knows of the arm
      this.pale = box.closest(".omx-robot"); // the ghost of a robot's panel is what you ask for: here the arm obeys at once
      box.dataset.kind = this.kind;
      this.controls = element("div", { class: "omx-controls" });
      box.append(this.controls);
      this.spoken = element("p", { class: "omx-spoken", role: "status" });
      this[`${this.kind}Controls`]();
      this.controls.append(this.spoken);
      addEventListener("message", ({ data, source }) => {
        if (source !== this.frame()?.contentWindow) return;
        if (data?.omx === "ready") {
          this.tell();
          this.send();
        }
        if (data?.omx === "dragged" && this.about) this.dragged(data);
      });
      this.show();
    }

    // Say it to a screen reader when the reader's hand rests. (Scenes of an arm speak for themselves.)
    speak(words) {
      clearTimeout(this.settling);
      if (this.said) this.settling = setTimeout(() => { this.spoken.textContent = words; }, SETTLE_MS);
      this.said = true; // a page that opens is quiet
    }

    frame() { return this.box.querySelector("iframe"); }

    frames(q) { return A.frames(q, this.about); }

    // The reader drags the tool in the scene, or pulls a link: the sliders follow, and the scene is told when all is done.
    dragged({ pose, q, done }) {
      if (q) this.q = q;
      if (this.pose) {
        this.pose = pose ?? A.pose(this.q, this.about);
        this.values = A.task(this.about).values(this.pose);
        if (!pose) this.choice.value = NEAREST;
        this.solve(!pose);
      }
      this.follow();
      this.write();
      if (done) this.send();
    }

    // The sliders go where the arm is.
    follow() {
      this.inputs.forEach((input, i) => {
        input.value = this.pose ? this.values[i] : this.q[i] / this.scales[i];
        input.tell();
      });
    }

    // Tell the scene; the newest position always wins, one message a repaint.
    send() {
      if (!this.frame()) return;
      this.asked ??= requestAnimationFrame(() => {
        this.asked = null;
        if (this.kind === "row") return this.post({ omx: "row", row: this.q });
        const nodes = {}, visible = {};
        if (this.pale) visible["/meshcat/ghosts"] = false;
        this.frames(this.q).forEach((T, i) => { // the axes of the frames ride on it (tool.js)
          nodes[`/meshcat/arm/${i}`] = columns(T);
          if (this.terms) visible[`/meshcat/frames/${i}`] = this.terms.shown.includes(i) || (i > 0 && i === this.lit);
        });
        if (this.section) nodes["/meshcat/section"] = columns(A.link(this.q[0], 0, 0, Math.PI / 2));
        if (this.pose) nodes["/meshcat/notes/target"] = columns(A.task(this.about).matrix(this.pose));
        (this.found || []).forEach((s, k) => {
          visible[`/meshcat/ghosts/${k}`] = s.reachable && s.index !== this.chosen?.index;
          if (s.reachable) this.frames(s.q).forEach((T, i) => { nodes[`/meshcat/ghosts/${k}/${i}`] = columns(T); });
        });
        this.post({ omx: "transforms", nodes, visible, branch: this.kept?.() });
      });
    }

    // Another arm takes the place of this one: `about` says all of it, and `messages` are what its scene has to hear, now and
    // whenever it is made again.
    become(about, messages) {
      const kinds = () => this.about.rows.map(({ prismatic }) => prismatic).join(), before = kinds();
      Object.assign(this, { about, messages });
      if (kinds() !== before) {
        this.q = about.rows.map(() => 0);
        this.controls.replaceChildren();
        this[`${this.kind}Controls`]();
        this.controls.append(this.spoken);
      }
      if (this.pose) {
        const [L1, ...links] = about.geometry, reach = Math.ceil(links.slice(0, 3).reduce((sum, v) => sum + v));
        [[-reach, reach], [-reach, reach], [-200, Math.floor(L1) + reach]].forEach(([min, max], i) => {
          Object.assign(this.inputs[i], { min, max });
          this.inputs[i].parentElement.querySelector(".omx-limits").textContent = `${text(min, 0)} to ${text(max, 0)}`;
        });
        this.solve();
      }
      this.tell();
      this.show();
    }

    tell() {
      for (const message of this.messages ?? []) this.post(message);
    }

    post(message) {
      this.frame()?.contentWindow?.postMessage(message, "*");
    }

    // A slider for each [name, unit, low, high, value, step], and room for the answer; `hear` gets the number of one that moves.
    makeSliders(rows, hear) {
      const list = element("div", { class: "omx-sliders" });
      this.inputs = rows.map((row, i) => this.slider(list, () => hear(i), ...row));
      this.answer = element("div", { class: "omx-answer" });
      this.controls.append(list, this.answer);
      return list;
    }

    // Sliders for joint values, or for a DH row, q.
    makePlainSliders(rows) {
      this.scales = rows.map(([, unit]) => (unit === "mm" ? 1 : DEG));
      return this.makeSliders(rows.map(([name, unit, low, high, step], i) => [name, unit, low, high, this.q[i] / this.scales[i], step]), () => {
        this.q = this.inputs.map((input, i) => Number(input.value) * this.scales[i]);
        this.show();
      });
    }

    slider(list, hear, word, kind, low, high, value, step = 1) {
      const name = GREEK[word] ?? word, unit = kind === "deg" ? "\u00b0" : kind;
      const input = element("input", { type: "range", min: low, max: high, step, "aria-label": unit ? `${name} in ${unit}` : name });
      input.value = value;
      const output = element("output", {}), digits = Math.min(3, (String(step).split(".")[1] ?? "").length);
      const tell = () => {
        const number = text(Number(input.value), digits);
        output.textContent = `${number}${unit === "\u00b0" || !unit ? "" : "\u2009"}${unit}`;
        input.setAttribute("aria-valuetext", `${number} ${unit}`);
      };
      input.addEventListener("input", () => { tell(); hear(); });
      input.tell = tell;
      tell();
      const limits = element("span", { class: "omx-limits" }, `${text(low, digits)} to ${text(high, digits)}`);
      list.append(element("label", {}, element("i", {}, name), input, output, limits));
      return input;
    }

    // -- joints ---------------------------------------------------------------------------------------------------

    jointsControls() {
      const rows = this.about.sliders, sliders = this.makePlainSliders(rows);
      const go = (name, q) => {
        const button = element("button", { type: "button" }, name);
        button.addEventListener("click", () => {
          this.q = [...q];
          this.follow();
          this.show();
        });
        return button;
      };
      const poses = [go("zero", rows.map(([, , low, high], i) => this.scales[i] * Math.min(Math.max(0, low), high)))];
      if (this.about.home) poses.push(go("home", this.about.home));
      sliders.append(element("p", { class: "omx-poses" }, ...poses));
      if (this.terms) this.controls.append(this.dhTable());
    }

    // Who points at a row of the table sees its frame.
    dhTable() {
      const box = element("div", { class: "omx-answer" });
      box.innerHTML = this.terms.table;
      box.querySelectorAll("tbody tr").forEach((row, i) => {
        const light = (frame) => () => { this.lit = frame; this.send(); };
        row.tabIndex = 0;
        for (const name of ["pointerenter", "focus"]) row.addEventListener(name, light(i + 1));
        for (const name of ["pointerleave", "blur"]) row.addEventListener(name, light(0));
      });
      return box;
    }

    // r and z, term by term: what each link adds, in its colour (tables.py has the same).
    sums() {
      const T = this.frames(this.q), x1 = [T[1][0][0], T[1][1][0]];
      const steps = [1, 2, 3, 4].map((i) => [0, 1, 2].map((k) => T[i][k][3] - T[i - 1][k][3]));
      const terms = { r: steps.map(([x, y]) => x * x1[0] + y * x1[1]), z: steps.map(([, , z]) => z) };
      return Object.entries(terms).map(([name, values]) => {
        const parts = [], total = text(values.reduce((sum, v) => sum + v, 0), 1);
        values.forEach((value, i) => {
          if (!this.terms.words[name][i]) return;
          const sign = value < -0.05 ? "\u2212" : parts.length ? "+" : "";
          parts.push(element("span", { style: `border-color: ${this.terms.colours[i]}` },
            element("small", {}, this.terms.words[name][i]), element("br"), `${sign} ${text(Math.abs(value), 1)}`));
        });
        return element("p", { class: "omx-sum" }, element("i", {}, name), " = ", ...parts, ` =\u00a0${total}\u00a0mm`);
      });
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
      if (this.about.geometry) values.push(`pitch = ${text(A.pose(this.q, this.about)[3] / DEG, 1)}\u00b0`);
      this.answer.replaceChildren(...(this.terms ? this.sums() : []),
        element("p", { class: "omx-values" }, ...values.map((v) => element("span", {}, v))),
        this.matrix(T, "T", "the pose T"));
    }

    // -- one DH row -----------------------------------------------------------------------------------------------

    rowControls() { this.makePlainSliders(this.sliders); }

    writeRow() {
      const link = A.link(...this.q), at = [0, 1, 2].map((i) => `${"xyz"[i]} = ${text(link[i][3], 1)}`);
      this.answer.replaceChildren(this.matrix(link, "A", "the link matrix A"));
      this.speak(`The next frame's origin is at ${at.join(", ")} mm.`);
    }

    // -- pose -----------------------------------------------------------------------------------------------------

    poseControls() {
      const task = A.task(this.about), changed = () => { this.solve(); this.show(); };
      this.pose = A.pose(this.q, this.about);
      this.values = task.values(this.pose);
      const rows = this.sliders.map((row, i) => [...row, this.values[i]]);
      const sliders = this.makeSliders(rows, (i) => {
        this.values[i] = Number(this.inputs[i].value); // the others keep what they stand for
        this.pose = task.asked(this.values);
        changed();
      });
      this.choice = element("select", {}, ...[NEAREST, ...this.about.branches].map((name) => element("option", {}, name)));
      this.choice.addEventListener("change", changed);
      sliders.append(element("label", { class: "omx-choice" }, element("i", {}, "branch"), this.choice));
      this.verdict = element("p", { role: "status" }); // spoken where it changes, not with every number below it
      this.table = element("div", {});
      this.answer.append(this.verdict, this.table);
      this.solve();
    }

    kept() { return this.choice?.value === NEAREST ? "" : this.choice?.value; }

    // The arm takes the legal branch that is nearest to where it is, or the one that was chosen; without one, it stays. It
    // stays as well where it has been `pulled`.
    solve(pulled) {
      this.found = A.branches(this.pose, this.about);
      const named = this.found.find(({ name }) => name === this.kept());
      this.chosen = named ? named.legal && named : A.nearest(this.found, this.pose, this.q, this.about);
      if (this.chosen && !pulled) this.q = this.chosen.q;
    }

    writeBranches() {
      const body = element("tbody", { role: "rowgroup" }), { rows } = this.about, slides = rows.some(({ prismatic }) => prismatic);
      for (const s of this.found) {
        const angles = s.reachable ? s.q.map((v, i) => text(rows[i].prismatic ? v : v / DEG, 1)).join("\u2002") : "\u2014";
        const cells = [s.name, angles, s.verdict].map((word, i) => element("td", { role: "cell", ...(i === 1 && { class: "omx-angles" }) }, word));
        const colour = this.about.colours.branches[s.index];
        cells[0].prepend(element("span", { style: `color: ${colour}`, "aria-hidden": "true" }, "\u25cf "));
        body.append(element("tr", { role: "row", ...(s.index === this.chosen?.index && { class: "omx-chosen" }) }, ...cells));
      }
      const names = ["branch", slides ? "q (\u00b0, mm)" : "q (\u00b0)", "verdict"].map((word) => element("th", { scope: "col", role: "columnheader" }, word));
      const head = element("thead", { role: "rowgroup" }, element("tr", { role: "row" }, ...names));
      const table = element("table", { class: "omx-branches", role: "table" }, head, body); // roles: the style makes it no table
      const free = this.chosen && this.about.inverse ? A.families(this.q, this.about).map((words) => ` Here ${words}.`).join("") : "";
      const wanted = this.kept(), stays = wanted ? `${wanted} is not legal here` : "no branch is legal here";
      const words = this.chosen ? `The arm takes ${this.chosen.name}.${free}` : `The arm stays: ${stays}.`;
      if (this.verdict.textContent !== words) this.verdict.textContent = words;
      this.table.replaceChildren(table);
    }

    // -- a live figure ---------------------------------------------------------------------------------------------

    figureControls() {
      this.plot = element("div", { class: "omx-plot" });
      this.makeSliders(this.sliders, () => this.show());
      this.answer.classList.add("omx-says");
      this.palette.forEach((ink, i) => this.box.style.setProperty(`--omx-ink-${i}`, ink));
      this.box.replaceChildren(this.plot, this.controls);
      new ResizeObserver(() => { if (![0, this.width].includes(this.plot.clientWidth)) this.write(); }).observe(this.plot);
    }

    writeFigure() {
      this.width = this.plot.clientWidth;
      const figure = OMX_FIGURES[this.figure](this.inputs.map((input) => Number(input.value)), this.data);
      const says = figure.says.filter(Boolean);
      OMX_CHART.show(this.plot, figure, this.palette, `${this.title}. ${says.join(" ")}`);
      this.answer.replaceChildren(...says.map((words) => element("p", {}, words)));
      this.speak(says.join(" "));
    }

    write() { this[{ pose: "writeBranches", row: "writeRow", joints: "writePose", figure: "writeFigure" }[this.kind]](); }

    show() {
      this.write();
      this.send();
    }
  }

  window.OMX_PANEL = Panel;
  for (const box of document.querySelectorAll(".omx-panel[data-panel]:not([data-kind])")) new Panel(box);
})();
