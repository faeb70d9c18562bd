// Draws what a live figure shows: lines and dots with axes as SVG, bytes as boxes, sentences below. Sizes in px of the page.
(function () {
  "use strict";
  const SVG = "http://www.w3.org/2000/svg";

  function shape(tag, attributes, words) {
    const node = document.createElementNS(SVG, tag);
    for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
    if (words !== undefined) node.textContent = words;
    return node;
  }

  const plain = (value) => String(value).replace("-", "\u2212");

  // A colour of the palette by its number, or any other.
  const inks = (palette) => (colour) => palette[colour] ?? colour;

  // Round numbers from low to high, about `count` of them.
  function ticks(low, high, count) {
    const raw = (high - low) / count, size = 10 ** Math.floor(Math.log10(raw)), step = size * [1, 2, 5, 10].find((m) => m * size >= raw);
    const first = Math.ceil(low / step - 1e-9);
    return Array.from({ length: Math.floor(high / step + 1e-9) - first + 1 }, (_, i) => Number(((first + i) * step).toPrecision(12)));
  }

  // What the axes hold: what the figure says, or all of its points with some room around them.
  function spans({ span, lines = [], dots = [] }) {
    if (span) return span;
    const points = [...lines, ...dots].flatMap((one) => one.points).filter((p) => p.every(Number.isFinite));
    return [0, 1].map((i) => {
      const values = points.map((p) => p[i]), low = Math.min(...values), high = Math.max(...values), room = 0.06 * (high - low) || 1;
      return [low - room, high + room];
    });
  }

  function draw(box, figure, palette, name) {
    const ink = inks(palette);
    const width = Math.max(240, box.clientWidth || 560), height = Math.min(Math.round(0.8 * width), 400);
    const type = parseFloat(getComputedStyle(box).getPropertyValue("--omx-type")) || 13; // of the numbers, px
    const margin = { left: 4.6 * type, right: 1.1 * type, top: 0.9 * type, bottom: 3.6 * type };
    const svg = shape("svg", { viewBox: `0 0 ${width} ${height}`, width, height, role: "img", "aria-label": name });
    const inner = [width - margin.left - margin.right, height - margin.top - margin.bottom];
    const range = spans(figure);
    if (figure.square) { // one scale for both axes
      const scale = Math.max(...range.map(([low, high], i) => (high - low) / inner[i]));
      range.forEach(([low, high], i) => { range[i] = [-1, 1].map((side) => 0.5 * (low + high) + 0.5 * side * scale * inner[i]); });
    }
    const at = (v, i) => (v - range[i][0]) / (range[i][1] - range[i][0]) * inner[i];
    const place = ([x, y]) => [margin.left + at(x, 0), margin.top + inner[1] - at(y, 1)];

    const axes = shape("g", { class: "omx-axes" });
    for (const x of ticks(...range[0], Math.max(4, width / 90))) {
      const [across] = place([x, range[1][0]]);
      axes.append(shape("line", { x1: across, x2: across, y1: margin.top, y2: margin.top + inner[1] }),
        shape("text", { x: across, y: height - margin.bottom + 1.3 * type, "text-anchor": "middle" }, plain(x)));
    }
    for (const y of ticks(...range[1], Math.max(4, height / 60))) {
      const [, down] = place([range[0][0], y]);
      axes.append(shape("line", { x1: margin.left, x2: width - margin.right, y1: down, y2: down }),
        shape("text", { x: margin.left - 7, y: down + 0.33 * type, "text-anchor": "end" }, plain(y)));
    }
    axes.append(shape("text", { class: "omx-title", x: margin.left + inner[0] / 2, y: height - 0.6 * type, "text-anchor": "middle" }, figure.x),
      shape("text", { class: "omx-title", transform: `translate(${type} ${margin.top + inner[1] / 2}) rotate(-90)`, "text-anchor": "middle" }, figure.y));

    const clip = `omx-clip-${Math.random().toString(36).slice(2)}`, inside = shape("clipPath", { id: clip });
    inside.append(shape("rect", { x: margin.left, y: margin.top, width: inner[0], height: inner[1] }));
    const drawn = shape("g", { "clip-path": `url(#${clip})` });
    for (const { points, colour, dash, pale } of figure.lines ?? []) {
      const known = points.filter((p) => p.every(Number.isFinite)).map((p) => place(p).map((v) => Math.max(-1e4, Math.min(1e4, v)).toFixed(1)).join());
      drawn.append(shape("polyline", { points: known.join(" "), fill: "none", stroke: ink(colour), "stroke-width": pale ? 1.4 : 2.6,
        "stroke-linejoin": "round", ...(dash && { "stroke-dasharray": "7 5" }), ...(pale && { "stroke-opacity": 0.55 }) }));
    }
    for (const { points, colour, ring, small } of figure.dots ?? []) {
      for (const point of points.filter((p) => p.every(Number.isFinite))) {
        const [cx, cy] = place(point), look = ring ? { fill: "none", stroke: ink(colour), "stroke-width": 3 } : { fill: ink(colour) };
        drawn.append(shape("circle", { cx, cy, r: small ? 2.2 : ring ? 8 : 5.5, ...look, ...(small && { "fill-opacity": 0.6 }) }));
      }
    }
    svg.append(axes, inside, drawn);
    return svg;
  }

  // What the colours mean.
  function legend(figure, palette) {
    const ink = inks(palette);
    const list = document.createElement("ul");
    list.className = "omx-legend";
    const marks = [...(figure.lines ?? []).map((one) => ["line", one]), ...(figure.dots ?? []).map((one) => ["dot", one])];
    for (const [kind, { label, colour, dash, ring }] of marks.filter(([, { label }]) => label)) {
      const mark = shape("svg", { width: 22, height: 12, "aria-hidden": "true" });
      mark.append(kind === "line"
        ? shape("line", { x1: 0, x2: 22, y1: 6, y2: 6, stroke: ink(colour), "stroke-width": 3, ...(dash && { "stroke-dasharray": "6 4" }) })
        : shape("circle", { cx: 11, cy: 6, r: 4.5, fill: ring ? "none" : ink(colour), stroke: ink(colour), "stroke-width": 2 }));
      const item = document.createElement("li");
      item.append(mark, ` ${label}`);
      list.append(item);
    }
    return list;
  }

  // A packet: its bytes in hexadecimal, those of one meaning together.
  function bytes(packet) {
    const list = document.createElement("ol");
    list.className = "omx-bytes";
    let last = null;
    for (const { name, byte } of packet) {
      if (name !== last) {
        const item = document.createElement("li"), word = document.createElement("span");
        word.textContent = name;
        item.append(document.createElement("code"), word);
        if (name === "stuffed") item.className = "omx-extra";
        list.append(item);
      }
      const code = list.lastElementChild.firstElementChild;
      code.textContent = `${code.textContent} ${byte.toString(16).padStart(2, "0")}`.trim();
      last = name;
    }
    return list;
  }

  window.OMX_CHART = {
    show(box, figure, palette, name) {
      if (figure.bytes) return box.replaceChildren(bytes(figure.bytes));
      box.replaceChildren(legend(figure, palette), draw(box, figure, palette, name));
    },
  };
})();
