// A reader changes a line of a chapter on its page, and the page derives again. One file, twice: in the page, and in a worker
// where the browser edition's Python runs the chapter's own derivation (derive_again.py); where that lies, the page's link to
// its notebook there says, and nothing is asked of anybody else. Another number needs no symbols: the formulas take lengths as
// arguments, a chain is a product of numbers, and the JavaScript that every page has answers at once. (MicroPython, 0.2 MB,
// would do that, too, but the formulas are here already, in the language of the page.)
(function () {
  "use strict";
  if (typeof document === "undefined") return inTheWorker();
  const HERE = document.currentScript.src;
  let A = null;
  const PYTHON = "../static/pyodide/"; // seen from where the link leads
  const SETTLE_MS = 250; // after the last key
  const KEPT = "omx-your-arm"; // in this tab, until it is closed: the reader's lines, by chapter and cell
  const LENGTH = /\b(\w+)(: *)(-?\d*\.?\d+)(?=\s*[,}])/g, ROW = /DHRow\(([^()]*)\)/g;
  const COLUMNS = ["theta", "d", "a", "alpha"];
  const NO_PYTHON = "No Python lies beside this page, so it cannot derive: other numbers answer here all the same, and for all " +
    "else change this cell in JupyterLab, or in the browser edition, and run the chapter.";

  function element(tag, attributes, ...children) {
    const node = document.createElement(tag);
    for (const [name, value] of Object.entries(attributes || {})) node.setAttribute(name, value);
    node.append(...children);
    return node;
  }

  class Editor {
    constructor(box) {
      this.chapters = JSON.parse(box.dataset.recipe);
      const panels = [...document.querySelectorAll(".omx-panel[data-panel]")];
      this.panel = panels.filter((p) => p.compareDocumentPosition(box) & Node.DOCUMENT_POSITION_FOLLOWING).at(-1).omxPanel;
      this.first = this.panel.about;
      this.fields = this.chapters.flatMap(({ name, pieces }) =>
        pieces.filter((piece) => piece.edit).map((piece) => this.field(name, piece)));
      this.go = element("button", { type: "button" }, "Derive again");
      this.back = element("button", { type: "button" }, "The book's arm");
      this.said = element("p", { role: "status", class: "omx-said" });
      this.result = element("div", { class: "omx-written" });
      this.go.addEventListener("click", () => this.derive());
      this.back.addEventListener("click", () => this.restore());
      box.append(element("p", {}, element("strong", {}, "Your arm. "), "Change a number or a row, and derive again: the " +
        "chapter's own cells run in this page, with your lines."), ...this.fields.map(({ box: lines }) => lines),
        element("p", { class: "omx-poses" }, this.go, this.back), this.said, this.result);
      this.bringAlong();
    }

    // ---- the same arm on the next page -------------------------------------------------------------------------------------

    // The lines that the reader changed before, here or on another page, if the book still has the cells that they were.
    bringAlong() {
      const kept = stored();
      let brought = false;
      for (const { name, piece, area } of this.fields) {
        const { book, mine } = kept[name] ?? {};
        if (book !== piece.code) continue;
        area.value = mine;
        brought = true;
      }
      if (!brought) return;
      this.answerAtOnce();
      if (this.said.dataset.kind) return; // no arm: that has been said
      const toCome = this.numbers() ? "" : " \u201cDerive again\u201d makes the scene above that arm.";
      this.say(`These lines are yours, as you left them in this tab: \u201cThe book's arm\u201d brings the shipped ones back.${toCome}`);
    }

    keep() {
      const kept = stored();
      for (const { name, piece, area } of this.fields) {
        delete kept[name];
        if (area.value !== piece.code) kept[name] = { book: piece.code, mine: area.value };
      }
      try {
        sessionStorage.setItem(KEPT, JSON.stringify(kept));
      } catch { /* a browser that keeps nothing: then each page begins with the book's arm */ }
    }

    // The lines of one cell, as the chapter has them.
    field(chapter, piece) {
      const lines = piece.code.split("\n"), id = `omx-edit-${piece.edit}`;
      const area = element("textarea", { id, rows: lines.length, spellcheck: "false", autocapitalize: "off",
        autocomplete: "off", wrap: "off" });
      area.value = piece.code;
      const from = this.chapters.length > 1 ? ` of chapter ${Number(chapter.slice(0, 2))}` : "";
      area.addEventListener("input", () => {
        clearTimeout(this.typing);
        this.typing = setTimeout(() => this.answerAtOnce(), SETTLE_MS);
      });
      area.addEventListener("keydown", (event) => {
        if (event.key !== "Enter" || !(event.ctrlKey || event.metaKey || event.shiftKey)) return;
        event.preventDefault();
        this.derive();
      });
      const label = element("label", { for: id }, element("code", {}, piece.edit), from);
      return { name: `${chapter}/${piece.edit}`, piece, area, box: element("div", {}, label, area) };
    }

    say(words, kind = "") {
      this.said.textContent = words;
      this.said.dataset.kind = kind;
    }

    // ---- at once, without symbols ----------------------------------------------------------------------------------------

    // The arm of these lines, if only numbers were changed: lengths, or rows of a chain; null if Python must read them.
    numbers() {
      const { geometry, rows } = this.first, lengths = {};
      const blank = (text) => (geometry ? text : text.replace(ROW, "DHRow()")).replace(LENGTH, "$1$2");
      for (const { piece, area } of this.fields) {
        if (blank(area.value) !== blank(piece.code)) return null;
        for (const [, name, , value] of area.value.matchAll(LENGTH)) lengths[name] = Number(value);
      }
      if (geometry) return A.resized(this.first, this.lengthNames().map((name, i) => lengths[name] ?? geometry[i]));
      const words = (text) => [...text.matchAll(ROW)].map(([, row]) => row.split(",").map((word) => word.trim()));
      const [{ piece, area }] = this.fields, before = words(piece.code), after = words(area.value);
      const value = (word, i, k) => // a number, a length by its name, or the book's own words
        [word ? Number(word) : NaN, lengths[word], word === before[i][k] ? rows[i][COLUMNS[k]] : NaN].find(Number.isFinite);
      const entries = (row, i) => COLUMNS.map((name, k) => [name, value(row[k], i, k)]);
      const table = after.map((row, i) => ({ ...rows[i], ...Object.fromEntries(entries(row, i)) }));
      const rest = (all) => all.map((row) => row.slice(COLUMNS.length).join()).join(";");
      const good = ({ theta, d, a, alpha }) =>
        Number.isFinite(d + a) && Math.max(Math.abs(theta), Math.abs(alpha)) <= 2 * Math.PI; // rad, not degrees
      return rest(before) === rest(after) && table.every(good) ? { ...this.first, rows: table } : null;
    }

    lengthNames() { return Object.keys(window.OMX_KINEMATICS.fk.PARAMETERS); }

    answerAtOnce() {
      const arm = this.numbers();
      this.keep();
      this.result.replaceChildren();
      if (!arm) return this.say("");
      const short = this.lengthNames().map((name, i) => [name, arm.geometry?.[i]]).filter(([name, v]) => name[0] === "L" && v <= 0)
        .map((pair) => pair.join(" = "));
      if (short.length) return this.say(`${short.join(", ")} mm makes no arm: every length must be more than 0.`, "refused");
      this.stretch(arm);
      const [x, y, z] = this.panel.frames(this.panel.q.map(() => 0)).at(-1).slice(0, 3).map((row) => A.text(row[3], 1));
      this.say(`With these numbers the tool at zero is at x = ${x}, y = ${y}, z = ${z} mm.`);
    }

    // The parts of the book's arm are pulled to the new lengths, each along its link, until Python draws them.
    stretch(arm) {
      if (this.book && this.shown !== this.book.arm) this.show(this.book.arm);
      const nodes = {}, ratio = (now, before) => (now && before ? now / before : 1);
      const pull = (path, x, y, z) => { nodes[`${path}/<object>`] = [x, 0, 0, 0, 0, y, 0, 0, 0, 0, z, 0, 0, 0, 0, 1]; };
      const messages = [...this.redrawn ?? [], { omx: "transforms", nodes }];
      if (arm.geometry) {
        const [L1, L2, L3, L4] = arm.geometry.map((v, i) => ratio(v, this.first.geometry[i]));
        [[1, 1, L1], [2, L2, 1], [3, L3, 1], [4, L4, 1]].forEach(([i, x, y]) => {
          pull(`/meshcat/arm/${i}`, x, y, 1);
          for (const { index } of this.panel.found ?? []) if (i > 1) pull(`/meshcat/ghosts/${index}/${i}`, x, y, 1);
        });
      } else {
        arm.rows.forEach(({ a, d, alpha }, i) => { // a lies along x, d along the joint's axis: y or z, as the twist is
          const before = this.first.rows[i], along = ratio(d, before.d), level = Math.abs(Math.sin(alpha)) > 0.7;
          pull(`/meshcat/arm/${i + 1}`, ratio(a, before.a), level ? along : 1, level ? 1 : along);
        });
      }
      this.panel.become(arm, [...messages, { omx: "arm", about: arm, modules: {} }]);
    }

    restore() {
      for (const { piece, area } of this.fields) area.value = piece.code;
      this.keep();
      this.result.replaceChildren();
      if (this.book) this.show(this.book.arm);
      else this.stretch(this.first);
      this.say("This is the book's arm again.");
    }

    // ---- by the chapter's own derivation ----------------------------------------------------------------------------------

    async derive() {
      if (this.busy) return;
      clearTimeout(this.typing);
      this.busy = true;
      this.go.setAttribute("aria-disabled", "true");
      this.keep();
      try {
        const mine = this.fields.map(({ area }) => area.value);
        this.worker ??= await this.start();
        if (!this.worker) return this.say(NO_PYTHON);
        this.book ??= await this.ask(this.fields.map(({ piece }) => piece.code), "The book's arm is derived first, to compare \u2026");
        const found = await this.ask(mine, "Your arm is derived \u2026");
        this.result.replaceChildren();
        if (found.refused) return this.say(found.refused, "refused");
        this.show(found.arm);
        this.report(found);
      } catch (error) {
        this.worker = null;
        this.say(`Python stopped: ${error.message ?? error}`, "refused");
      } finally {
        this.busy = false;
        this.go.removeAttribute("aria-disabled");
      }
    }

    // The worker, if Python is to be had; null if it is not.
    async start() {
      const link = document.querySelector("a.omx-run");
      if (!link || location.protocol === "file:") return null;
      const base = new URL(PYTHON, link.href).href, list = await (await fetch(`${base}pyodide-lock.json`)).json();
      const worker = new Worker(HERE);
      worker.postMessage({ base, wheel: list.packages.omx.file_name, driver: new URL("derive_again.py", HERE).href });
      return worker;
    }

    // One question to the worker: the chapters with these lines.
    ask(lines, words) {
      const given = [...lines];
      const chapters = this.chapters.map((chapter) => ({ ...chapter,
        pieces: chapter.pieces.map((piece) => (piece.edit ? { ...piece, code: given.shift() } : piece)) }));
      const before = this.book?.files.map(({ text }) => text) ?? [];
      return new Promise((resolve, reject) => {
        this.worker.onerror = (event) => reject(new Error(event.message));
        this.worker.onmessage = ({ data }) => {
          if (data.ready) this.say(words);
          else if (data.said) this.say(data.said);
          else if (data.failed) reject(new Error(data.failed));
          else resolve(data);
        };
        this.worker.postMessage({ chapters, before, limits: this.first.limits ?? undefined, ghosts: this.panel.found?.length ?? 0 });
      });
    }

    // The page's scene becomes that arm.
    show(arm) {
      A.learn(arm.modules);
      const { about, modules } = arm, size = about.geometry ? 1 : about.reach / this.book.arm.about.reach;
      const roots = [...new Set(arm.commands.map(({ path }) => path.split("/").slice(0, 3).join("/")))];
      this.redrawn = [{ omx: "draw", commands: [...roots.map(gone), ...arm.commands], size },
        { omx: "arm", about: arm.stale ? null : about, modules }]; // of a stale inverse the tool cannot be dragged
      this.shown = arm;
      this.panel.become(about, this.redrawn);
    }

    // What changed in the files, line by line.
    report({ files, seconds }) {
      const python = files.filter(({ name }) => name.endsWith(".py"));
      for (const { name, lines, text } of python) {
        const count = lines.filter(([sign]) => sign === "+").length;
        const news = count ? `${count} ${count === 1 ? "line is" : "lines are"} new` : "the same, to the byte";
        const title = element("p", { class: "omx-file" }, element("code", {}, name), `: ${news}`);
        const code = element("pre", { tabindex: "0", "aria-label": `What changed in ${name}` });
        for (const [sign, line] of lines) {
          const row = `${sign === "@" ? "\u22ee" : sign} ${line}\n`;
          code.append(sign === "+" ? element("ins", {}, row) : sign === "-" ? element("del", {}, row) : row);
        }
        const whole = element("details", {}, element("summary", {}, "The whole module"), element("pre", { tabindex: "0" }, text));
        this.result.append(title, ...(count ? [code] : []), whole);
      }
      const proved = this.chapters.some(({ pieces }) => pieces.some(({ code }) => code.includes("prove_equal(")));
      this.say(`Derived again${proved ? ", with its proofs," : ""} in ${A.text(seconds, 1)} s. The arm above is yours.`);
    }
  }

  function stored() {
    try {
      return JSON.parse(sessionStorage.getItem(KEPT)) ?? {};
    } catch {
      return {};
    }
  }

  // MeshCat's command to delete, as its messages are packed.
  function gone(path) {
    const words = ["type", "delete", "path", path].map((word) => new TextEncoder().encode(word));
    return { type: "delete", path, bytes: Uint8Array.from([0x82, ...words.flatMap((word) => [0xa0 + word.length, ...word])]) };
  }

  document.addEventListener("DOMContentLoaded", () => { // the panels are there
    A = window.OMX_ARM;
    for (const box of document.querySelectorAll(".omx-edit[data-recipe]")) new Editor(box);
  });

  // ---- in the worker ------------------------------------------------------------------------------------------------------

  function inTheWorker() {
    let python = null;
    self.onmessage = async ({ data }) => {
      try {
        if (data.base) return void (python = start(data));
        const again = await python;
        self.postMessage({ ready: true });
        self.postMessage(again(data));
      } catch (error) {
        self.postMessage({ failed: String(error.message ?? error).trim().split("\n").at(-1) });
      }
    };

    async function start({ base, wheel, driver }) {
      const say = (said) => self.postMessage({ said });
      say("Python is fetched from this site: 22 MB, the first time \u2026");
      importScripts(`${base}pyodide.js`);
      const pyodide = await loadPyodide({ indexURL: base, stdout() {}, stderr() {} });
      await pyodide.loadPackage(["numpy", "sympy", "u-msgpack-python"], { messageCallback() {} });
      say("Python has begun and reads the package \u2026");
      pyodide.unpackArchive(await (await fetch(base + wheel)).arrayBuffer(), "wheel");
      const names = pyodide.toPy({});
      pyodide.runPython(await (await fetch(driver)).text(), { globals: names });
      const plain = (value) => value.toJs({ dict_converter: Object.fromEntries });
      return ({ chapters, before, limits, ghosts }) => {
        const found = plain(names.get("again")(pyodide.toPy(chapters), pyodide.toPy(limits), ghosts));
        found.files?.forEach((file, i) => { file.lines = before.length ? plain(names.get("difference")(before[i], file.text)) : []; });
        return found;
      };
    }
  }
})();
