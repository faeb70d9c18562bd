// A deck: formulas first, then units of text, code and pictures fill slides of --width x --height pixels (deck.css), then
// reveal.js takes over; or, with ?print=slides, four or notes, the same slides lie on pages.
(async function () {
  "use strict";
  const style = getComputedStyle(document.documentElement);
  const size = (name) => parseFloat(style.getPropertyValue(name));
  const WIDTH = size("--width"), HEIGHT = size("--height"), EDGE = size("--edge"), BOTTOM = HEIGHT - size("--foot");
  const TYPE = [[36, 34], [33, 32], [30, 30], [28, 28], [26, 26]]; // px of prose and of code, largest first
  const TOO_SMALL = [[26, 24], [26, 22], [26, 20], [26, 18]]; // where nothing can be parted: slide_lint.py names it
  const MOST_WORDS = 75, FEW_WORDS = 20, SMALLEST_EQUATION = 28, CODE = 26, PRINTED = 22;
  const LETTERS = 1.22; // a figure's letters have 14.7 px; so many times as large, the last row can read them
  const TEXT = "p, li, td, th, h1, h2, h3";
  const printing = new URLSearchParams(location.search).get("print");

  await MathJax.startup.promise;
  await MathJax.typesetPromise();
  await Promise.all([...document.images].map((image) => image.decode().catch(() => {})));

  function element(tag, className, ...children) {
    const node = document.createElement(tag);
    node.className = className;
    node.append(...children);
    return node;
  }

  // ---- what is on a slide --------------------------------------------------------------------------------------

  const unseen = ".note, aside, .omx-scene, .omx-plot, .omx-controls, .omx-note, mjx-container, table.part + table.part thead";
  const onScreen = (node) => !node.closest(unseen);
  const texts = (section) => [...section.querySelectorAll(TEXT)].filter(onScreen);
  function words(section) {
    const counted = texts(section).map((node) => {
      const copy = node.cloneNode(true);
      for (const inner of copy.querySelectorAll("mjx-container, ul, ol")) inner.remove();
      return copy.textContent;
    });
    return counted.join(" ").split(/[\s\u2009]+/).filter((word) => /\p{L}/u.test(word)).length;
  }
  const blocks = (section) => [...section.querySelectorAll(".unit > .piece > *, .again, .echo")];
  const pictures = (section) => [...section.querySelectorAll(".omx-scene, img, .figure")].filter((p) => !p.parentElement.closest(".omx-scene"));
  const panel = (section) => section.querySelector(".omx-panel");
  const bottom = (section) => Math.max(0, ...blocks(section).map((b) => b.getBoundingClientRect().bottom)) - section.getBoundingClientRect().top +
    (section.querySelector("table.part") ? 40 : 0); // one table again, its columns are as wide as all rows ask: a line more

  // ---- making one slide fit ------------------------------------------------------------------------------------

  function fits(section, must = false) {
    section.className = "";
    section.removeAttribute("style");
    if (!must && words(section) > MOST_WORDS) return false;
    if (panel(section)) return above(section, must);
    const [picture, more] = pictures(section);
    if (picture && !must && section.querySelector(".code")) return false; // each wants the whole width
    if (picture && !more) return beside(section) || above(section, must);
    return picture ? above(section, must) : inType(section, must);
  }

  // The largest type in which everything stays on the slide.
  function inType(section, must, widest = WIDTH - 2 * EDGE, scale = 0.5) {
    return [...TYPE, ...(must ? TOO_SMALL : [])].some(([px, code]) => {
      section.style.fontSize = `${px}px`;
      return narrow(section, widest, code) >= scale && bottom(section) <= BOTTOM;
    });
  }

  // Wide formulas and tables get smaller type, long lines of code somewhat, and then a new line; the worst block's scale.
  function narrow(section, room, most) {
    let worst = 1;
    const code = [...section.querySelectorAll(".code pre")], printed = [...section.querySelectorAll("pre")].filter((pre) => !pre.closest(".code"));
    for (const group of [code, ...printed.map((pre) => [pre])]) {
      for (const pre of group) pre.classList.remove("wrapped");
      for (const pre of group) pre.style.fontSize = `${most}px`;
      const px = Math.max(Math.min(group === code ? CODE : PRINTED, most), most * Math.min(1, ...group.map((pre) => 0.995 * pre.clientWidth / pre.scrollWidth)));
      for (const pre of group) {
        pre.style.fontSize = `${px}px`;
        if (pre.scrollWidth <= pre.clientWidth + 1) continue;
        pre.classList.add("wrapped");
        worst = 0.8;
      }
    }
    for (const block of section.querySelectorAll(".formula, table")) {
      if (!onScreen(block)) continue;
      block.classList.remove("broken");
      let scale = shrunk(block, room);
      if (block.matches(".equation") && parseFloat(block.style.fontSize || SMALLEST_EQUATION) < SMALLEST_EQUATION) {
        block.classList.add("broken"); // at its equals sign
        scale = shrunk(block, room);
      }
      worst = Math.min(worst, scale);
    }
    return worst;
  }
  function shrunk(block, room) {
    block.style.fontSize = "";
    let scale = 1;
    for (let tries = 0; tries < 3; tries++) {
      const need = block.matches("table") ? block.offsetWidth : Math.max(block.scrollWidth, widthOf(block));
      const most = block.matches("table") ? room : block.clientWidth;
      if (need <= most + 1) break;
      scale *= most / need;
      block.style.fontSize = `${parseFloat(getComputedStyle(block).fontSize) * (most / need) * 0.985}px`;
    }
    return scale;
  }
  const widthOf = (formula) => Math.max(0, ...[...formula.querySelectorAll("svg")].map((svg) => svg.getBoundingClientRect().width));

  // One picture stands at the right, as large as the words at its left allow.
  function beside(section) {
    const [picture] = pictures(section);
    if (section.querySelector(".code, table")) return false;
    section.classList.add("beside");
    const room = WIDTH - 2 * EDGE, heading = [...section.querySelectorAll("h1, h2, h3, .again")].at(-1);
    for (const share of shapeOf(picture) ? [0.66, 0.61, 0.56] : [0.6, 0.54, 0.5]) {
      section.style.fontSize = `${TYPE[0][0]}px`;
      const top = (heading ? heading.getBoundingClientRect().bottom - section.getBoundingClientRect().top : size("--top")) + 12;
      const height = BOTTOM - top, shape = shapeOf(picture);
      const width = shape ? Math.min(share * room, height / shape) : share * room;
      if (shape && width === share * room && width / picture.getAttribute("width") < LETTERS) return leave();
      section.style.setProperty("--picture-width", `${width}px`);
      section.style.setProperty("--picture-height", `${shape ? width * shape : Math.min(height, width * 0.85)}px`);
      section.style.setProperty("--picture-top", `${top}px`);
      section.style.setProperty("--text-width", `${room - width - 28}px`);
      if (inType(section, false, room - width - 28, 0.85)) return true;
    }
    return leave();
    function leave() {
      section.classList.remove("beside");
      return false;
    }
  }
  const shapeOf = (picture) => picture.naturalWidth ? picture.naturalHeight / picture.naturalWidth : 0;

  // Below the words a picture, or a scene beside its sliders, takes the room that they leave, if one can see something.
  function above(section, must) {
    const [picture] = pictures(section), many = pictures(section).length;
    const least = must ? 200 : panel(section) || !shapeOf(picture) ? 330 : Math.min(LETTERS * picture.getAttribute("width") * shapeOf(picture), 420);
    for (const [px, code] of TYPE) {
      section.style.fontSize = `${px}px`;
      section.style.setProperty("--picture-height", "0px");
      if (narrow(section, WIDTH - 2 * EDGE, code) < 0.5 && !must) continue;
      const beside = panel(section)?.offsetHeight ?? 0; // sliders take no room below
      const room = (BOTTOM - bottom(section) + beside) / (beside ? 1 : many);
      section.style.setProperty("--picture-height", `${Math.max(120, Math.min(room - 6, 560))}px`);
      if (room >= least && bottom(section) <= BOTTOM + 2) return true;
    }
    return false;
  }

  // ---- filling slides with units -------------------------------------------------------------------------------

  function fill(first) {
    const waiting = [...first.children];
    let here = first;
    here.replaceChildren();
    while (waiting.length) {
      const unit = waiting.shift();
      here.append(unit);
      if (fits(here)) continue;
      if (here.querySelectorAll(".unit").length > 1) {
        unit.remove();
        fits(here, true);
        if (isAfterthought(unit)) {
          onlySay(unit, here);
          continue;
        }
        here = next(here, unit);
        if (fits(here)) continue;
      }
      const rest = cut(here, unit);
      if (!rest) {
        if (!fits(here, true)) here.dataset.small = "true";
        continue;
      }
      waiting.unshift(rest);
    }
  }

  // A slide that goes on: the heading again, and before code, formulas and pictures the sentence that leads to them.
  function next(here, unit) {
    const following = element("section", "");
    const heading = [...here.querySelectorAll("h1, h2, h3, .again")].at(-1);
    if (heading) following.append(element("p", "again", ...copyOf(heading)));
    const start = unit.querySelector(".piece > *");
    if (start && !start.matches(`${TEXT}, ul, ol, table, blockquote`)) {
      const lead = texts(here).filter((t) => t.matches("p, li") && !t.matches(".again, .title")).at(-1);
      if (lead?.matches("p") || (lead && start.matches(".code"))) following.append(element("p", "echo", ...copyOf(lead.querySelector(".last") ?? lead)));
    }
    following.append(unit);
    unit.querySelector(".piece")?.classList.remove("fragment"); // a slide does not begin empty
    here.after(following);
    return following;
  }
  const copyOf = (node) => [...node.cloneNode(true).childNodes];

  // A short remark after the last thing to see is no slide of its own: it is said.
  const isAfterthought = (unit) => !unit.querySelector("h1, h2, h3, pre, table, .formula, img, .omx-scene, .omx-plot, strong, .predict") && words(unit) <= FEW_WORDS;
  function onlySay(unit, section) {
    const note = unit.querySelector(".note") ?? element("div", "note");
    if (!note.querySelector(".say")) note.append(element("div", "say", ...unit.querySelectorAll(":scope > .piece > *")));
    [...section.querySelectorAll(".unit")].at(-1).append(note);
  }

  // Move what does not fit to a new unit, from a place where a break does least harm; null where there is nothing to part.
  function cut(section, unit) {
    apart(unit);
    const rest = element("div", "unit"), atoms = [...unit.querySelectorAll(":scope > .piece > *")];
    const counts = atoms.map((node) => !heads(node)), shares = atoms.map((node) => node.offsetHeight);
    let kept = atoms.length;
    const move = () => {
      const atom = atoms[--kept], piece = atom.parentElement;
      if (rest.firstElementChild?.from !== piece) rest.prepend(Object.assign(piece.cloneNode(false), { from: piece }));
      rest.firstElementChild.prepend(atom);
      if (!piece.children.length) piece.remove();
    };
    const least = Math.max(1, counts.indexOf(true) + 1);
    while (kept > least && !fits(section)) move();
    if (kept === atoms.length) return null;
    const enough = (i) => atoms.slice(0, i).some((node) => !heads(node) && (!node.matches("p") || node.textContent.length > 100));
    const good = (i) => enough(i) && !heads(atoms[i - 1]) && !leads(atoms[i - 1], atoms[i]) && !isOne(atoms[i - 1], atoms[i]);
    const isResult = (i) => atoms[i - 1].matches(".code") && !atoms[i].matches(".code"); // what code printed may follow it
    let best = kept;
    while (best > least && !good(best)) best--;
    if (!good(best)) best = isResult(kept) ? kept : evenly(atoms, kept, shares);
    if (isFirstRow(atoms, best)) best = beforeTable(atoms, best - 1) || best;
    while (kept > best) move();
    fits(section, true);
    return rest;
  }
  const heads = (node) => node.matches("h1, h2, h3, .title");
  const leads = (node, next) => (node.matches("p, blockquote.lead") && !next.matches("p")) || (node.matches(".code") && !next.matches("p"));
  const isOne = (node, next) => (node.matches(".part") && next.matches(".part") && node.tagName === next.tagName);
  // One row of a table is none: it goes along with the others, and so does what announces it, if that leaves something.
  const isFirstRow = (atoms, i) => i > 1 && isOne(atoms[i - 1], atoms[i]) && atoms[i - 1].matches("table") && !atoms[i - 2].matches("table");
  function beforeTable(atoms, i) {
    while (i > 0 && atoms[i - 1].matches("p") && atoms[i - 1].textContent.trim().endsWith(":")) i--;
    return atoms.slice(0, i).every(heads) ? 0 : i;
  }
  // Where a break is in the middle of a list, both halves get as much.
  function evenly(atoms, kept, heights) {
    let [start, end] = [kept, kept];
    while (start > 0 && isOne(atoms[start - 1], atoms[kept])) start--;
    while (end < atoms.length && isOne(atoms[end], atoms[kept])) end++;
    const upTo = (i) => heights.slice(start, i).reduce((a, b) => a + b, 0);
    let half = start + 1;
    while (half < kept && upTo(half) < upTo(end) / 2) half++;
    return end - start < 2 ? kept : Math.min(kept, half);
  }

  // Lists, tables and long quotations can part between their items.
  function apart(unit) {
    unit.querySelectorAll(".piece > .code").forEach(partCode);
    for (const list of unit.querySelectorAll(".piece > blockquote > :is(ul, ol)")) part(list, [...list.children]);
    for (const list of unit.querySelectorAll(".piece > :is(ul, ol, table, blockquote, .formulas)")) {
      part(list, [...(list.querySelector("tbody") ?? list).children].filter((item) => !item.matches("thead")));
    }
  }
  function partCode(code) {
    const lines = [...code.querySelectorAll(".line")], starts = lines.filter((line, i) => !i || line.matches(".begins"));
    if (starts.length < 2) return;
    code.replaceWith(...starts.map((start, i) => {
      const piece = code.cloneNode(true), upTo = lines.indexOf(starts[i + 1] ?? null);
      piece.querySelector("pre").replaceChildren(...lines.slice(lines.indexOf(start), upTo < 0 ? lines.length : upTo));
      piece.classList.add("part");
      return piece;
    }));
  }
  function part(list, items) {
    if (items.length < 2) return;
    const head = list.matches("table") ? list.querySelector("thead") : null;
    const parts = items.map((item, i) => {
      const piece = list.cloneNode(false);
      piece.append(...(head ? [head.cloneNode(true)] : []), item);
      if (list.matches("ol")) piece.start = (list.start || 1) + i;
      piece.classList.add("part");
      if (list.matches("blockquote") && item.matches("p")) piece.classList.add("lead");
      return piece;
    });
    list.replaceWith(...parts);
  }

  // What has stayed beside its neighbours is one list, one table again.
  function together(section) {
    for (const kind of [".code", "blockquote", "ul", "ol", "table", ".formulas"]) {
      for (const node of section.querySelectorAll(`${kind}.part`)) {
        const before = node.previousElementSibling;
        if (!before?.matches(`${kind}.part`)) continue;
        const into = before.querySelector("pre") ?? before, from = node.querySelector("pre") ?? node;
        into.append(...[...from.children].filter((child) => !child.matches("thead")));
        node.remove();
      }
    }
    for (const table of section.querySelectorAll("table.part")) table.classList.remove("part");
  }

  // What follows a step on its slide comes with that step: nothing is answered before it has been shown.
  function inSteps(section) {
    let step = -1;
    for (const piece of section.querySelectorAll(".piece")) {
      if (piece.matches(".fragment")) step++;
      if (step < 0) continue;
      piece.classList.add("fragment");
      piece.dataset.fragmentIndex = step;
    }
  }

  // MathJax measures in ex, which a browser rounds to its pixels: a slide shown larger or smaller would cut what just fits.
  function inPixels(formulas) {
    const sizes = [...formulas].map((svg) => [svg, parseFloat(getComputedStyle(svg).width), parseFloat(svg.getAttribute("width"))]);
    for (const [svg, width, ex] of sizes) {
      if (!(width > 0)) continue;
      const scaled = (length) => `${parseFloat(length) * width / ex}px`;
      svg.style.verticalAlign = scaled(svg.style.verticalAlign || 0);
      for (const side of ["width", "height"]) svg.setAttribute(side, scaled(svg.getAttribute(side)));
    }
  }

  // ---- notes ---------------------------------------------------------------------------------------------------

  function tellNotes(slides) {
    const seconds = slides.map((slide) => [...slide.querySelectorAll(".note")].reduce((sum, note) => sum + Number(note.dataset.seconds || 0), 0));
    const whole = Math.round(seconds.reduce((a, b) => a + b, 0) / 60);
    let start = 0;
    slides.forEach((slide, i) => {
      const minutes = seconds[i] < 60 ? "less than a minute" : `about ${Math.round(seconds[i] / 60)} min`;
      const clock = element("p", "clock", `Slide ${i + 1} of ${slides.length}: ${minutes}, from minute ${Math.floor(start / 60)} of ${whole}.`);
      start += seconds[i];
      const notes = [...slide.querySelectorAll(".note")];
      slide.append(element("aside", "notes", clock, ...notes.flatMap((note) => [...note.children])));
      for (const note of notes) note.remove();
      // The speaker's window has not MathJax's style, which hides what a screen reader reads.
      for (const twin of slide.querySelectorAll(".notes mjx-assistive-mml")) {
        twin.style.cssText = "position: absolute; width: 1px; height: 1px; overflow: hidden; clip-path: inset(50%)";
      }
    });
  }

  // ---- on paper ------------------------------------------------------------------------------------------------

  // The printer (handout.py) asks for each layout in turn. WebGL leaves a blank in print, and never draws the same bytes
  // twice: the picture that was drawn with the page stands in for each scene.
  function onPaper(slides) {
    const said = slides.map((slide) => slide.querySelector("aside.notes"));
    const page = element("style", ""), main = document.querySelector("main");
    const sizes = { slides: `${WIDTH}px ${HEIGHT}px; margin: 0`, four: "A4 landscape; margin: 11mm", notes: "A4; margin: 14mm" };
    for (const node of [...said, document.querySelector("link[href$='reveal.css']"), ...document.querySelectorAll(".omx-poses")]) node.remove();
    document.head.append(page);
    main.className = "sheets";
    for (const box of document.querySelectorAll(".omx-scene[data-poster]")) {
      box.replaceChildren(Object.assign(new Image(), { src: `data:image/webp;base64,${box.dataset.poster}`, alt: box.getAttribute("aria-label") }));
    }
    window.omxLay = (layout) => {
      document.documentElement.className = document.body.className = `on-paper print-${layout}`;
      page.textContent = `@page { size: ${sizes[layout]}; }`;
      main.replaceChildren(...slides.map((slide, i) => {
        const frame = element("div", "frame", element("div", "reveal", element("div", "slides", slide)));
        const left = element("div", "left", frame, element("p", "number", `${i + 1} / ${slides.length}`));
        return element("article", "sheet", left, ...(layout === "notes" ? [element("div", "said", ...copyOf(said[i]))] : []));
      }));
      return Promise.all([...document.images].map((image) => image.decode().catch(() => {})));
    };
    return omxLay(printing);
  }

  // ---- keys ----------------------------------------------------------------------------------------------------

  // A clicker's keys are always the speaker's: what a hand has touched lets go of the keyboard, and a scene hands its keys on.
  function keepKeys() {
    const letGo = () => setTimeout(() => document.activeElement?.closest(".slides")?.contains(document.activeElement) &&
      !document.activeElement.matches("iframe") && document.activeElement.blur());
    for (const end of ["pointerup", "pointercancel"]) window.addEventListener(end, letGo);
    window.addEventListener("keydown", (event) => {
      const step = { PageDown: () => Reveal.next(), PageUp: () => Reveal.prev() }[event.key];
      if (!step || event.ctrlKey || event.altKey || event.metaKey) return;
      event.preventDefault();
      event.stopImmediatePropagation();
      step();
    }, { capture: true });
    window.addEventListener("message", ({ data, source }) => {
      if (data?.omx === "key" && [...document.querySelectorAll("iframe")].some((f) => f.contentWindow === source)) Reveal.triggerKey(data.code);
    });
  }

  const leaves = () => [...document.querySelectorAll(".slides > section > section")];
  for (const section of leaves()) fill(section);
  for (const section of leaves()) {
    together(section);
    inSteps(section);
    if (!fits(section)) fits(section, true);
  }
  inPixels([...document.querySelectorAll(".slides mjx-container svg")].filter((svg) => !svg.closest(".note")));
  tellNotes(leaves());
  document.body.classList.remove("measuring");
  if (printing) await onPaper(leaves());
  else {
    keepKeys();
    await Reveal.initialize({
      width: WIDTH, height: HEIGHT, margin: 0.03, center: false, hash: true, slideNumber: "c/t", transition: "none",
      plugins: [RevealNotes], controlsTutorial: false, overview: true,
    });
  }
  document.body.dataset.ready = "true";
})();
