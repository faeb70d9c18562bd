// Small things for every page: scenes leave a picture for print, the keyboard reaches what scrolls.
(function () {
  "use strict";
  const frames = () => document.querySelectorAll(".omx-scene iframe");
  window.addEventListener("message", ({ data, source }) => {
    const frame = [...frames()].find((f) => f.contentWindow === source);
    if (!frame || !data?.omx) return;
    if (data.omx === "ready") setTimeout(() => picture(frame), 400);
    if (data.omx === "captured") keep(frame, data.url);
  });

  // Paper is white, whatever the theme.
  function picture(frame) {
    const dark = document.documentElement.dataset.theme === "dark";
    const say = (message) => frame.contentWindow?.postMessage(message, "*");
    if (dark) say({ omx: "theme", dark: false });
    say({ omx: "capture" });
    if (dark) say({ omx: "theme", dark: true });
  }

  // WebGL prints as an empty box: a picture of the scene stands in for it.
  function keep(frame, url) {
    let picture = frame.parentElement.querySelector("img.omx-print");
    if (!picture) {
      picture = document.createElement("img");
      picture.className = "omx-print";
      picture.alt = frame.title;
      frame.parentElement.append(picture);
    }
    picture.src = url;
  }

  // What the theme leaves unnamed, or names otherwise than it reads.
  document.querySelectorAll("summary[aria-label], button.search-button-field[aria-label]").forEach((b) => {
    if (b.innerText.trim()) b.removeAttribute("aria-label");
  });
  document.querySelectorAll("summary").forEach((s) => {
    if (!s.innerText.trim()) s.setAttribute("aria-label", "Show or hide the pages below");
  });

  // Wide tables and formulas scroll inside their box: let the keyboard reach them.
  const boxes = "div.math, mjx-container, .cell_output .output, .pst-scrollable-table-container, div.highlight pre, .omx-answer";
  const reachable = () => {
    for (const box of document.querySelectorAll(boxes)) {
      if (box.scrollWidth > box.clientWidth + 1 && getComputedStyle(box).overflowX !== "visible") box.tabIndex = 0;
    }
  };

  // Code a little too wide for the column gets a little smaller type; on a phone it scrolls.
  const SMALLEST = 0.83;
  const narrow = () => {
    for (const block of document.querySelectorAll("div.cell_input pre, div.cell_output pre")) {
      block.style.fontSize = "";
      const { paddingLeft, paddingRight, fontSize } = getComputedStyle(block);
      const padding = parseFloat(paddingLeft) + parseFloat(paddingRight);
      const share = (block.clientWidth - padding) / (block.scrollWidth - padding);
      if (share < 1 && share > SMALLEST) block.style.fontSize = `${parseFloat(fontSize) * share * 0.995}px`;
    }
  };
  window.addEventListener("load", async () => {
    await window.MathJax?.startup?.promise;
    narrow();
    reachable();
    document.body.dataset.settled = "true";
  });
  window.addEventListener("resize", () => { narrow(); reachable(); });
})();
