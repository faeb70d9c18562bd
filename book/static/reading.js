// Small things for every page: what is printed, and the keyboard reaches what scrolls.
(function () {
  "use strict";
  // WebGL prints as an empty box: the picture that was drawn with the page stands in for it.
  for (const box of document.querySelectorAll(".omx-scene[data-poster]")) {
    const picture = document.createElement("img");
    Object.assign(picture, { className: "omx-print", alt: "", src: `data:image/webp;base64,${box.dataset.poster}` });
    box.after(picture);
  }
  // Paper is white, whatever the theme.
  const root = document.documentElement;
  let theme = "light";
  window.addEventListener("beforeprint", () => {
    theme = root.dataset.theme;
    root.dataset.theme = "light";
  });
  window.addEventListener("afterprint", () => { root.dataset.theme = theme; });

  // What the theme leaves unnamed, or names otherwise than it reads.
  document.querySelectorAll("summary[aria-label], button.search-button-field[aria-label]").forEach((b) => {
    if (b.innerText.trim()) b.removeAttribute("aria-label");
  });
  document.querySelectorAll("summary").forEach((s) => {
    if (!s.innerText.trim()) s.setAttribute("aria-label", "Show or hide the pages below");
  });

  // Wide tables and formulas scroll inside their box: let the keyboard reach them.
  const boxes = "div.math, span.math, mjx-container, .cell_output .output, .pst-scrollable-table-container, div.highlight pre, .omx-answer";
  const reachable = () => {
    for (const box of document.querySelectorAll(boxes)) {
      const slack = box.matches("span.math") ? 20 : 1; // a formula in a line is measured a little too wide
      if (box.scrollWidth > box.clientWidth + slack && getComputedStyle(box).overflowX !== "visible") box.tabIndex = 0;
    }
  };

  // Code, or a formula, a little too wide for the column gets a little smaller; on a phone it scrolls.
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
  const fit = () => {
    for (const formula of document.querySelectorAll("mjx-container[display]")) {
      formula.classList.remove("omx-fit");
      formula.classList.toggle("omx-fit", formula.clientWidth / formula.scrollWidth > SMALLEST);
    }
  };
  window.addEventListener("load", async () => {
    await window.MathJax?.startup?.promise;
    narrow();
    fit();
    reachable();
    document.body.dataset.settled = "true";
  });
  window.addEventListener("resize", () => { narrow(); fit(); reachable(); });
})();
