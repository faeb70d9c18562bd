// Small things for every page: scenes leave a picture for print, the keyboard reaches what scrolls.
(function () {
  "use strict";
  const frames = () => document.querySelectorAll(".omx-scene iframe");
  window.addEventListener("message", ({ data, source }) => {
    const frame = [...frames()].find((f) => f.contentWindow === source);
    if (!frame || !data?.omx) return;
    if (data.omx === "ready") setTimeout(() => frame.contentWindow?.postMessage({ omx: "capture" }, "*"), 400);
    if (data.omx === "captured") keep(frame, data.url);
  });

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

  // Wide tables and formulas scroll inside their box: let the keyboard reach them.
  const boxes = "div.math, .cell_output .output, .pst-scrollable-table-container, div.highlight pre";
  const reachable = () => {
    for (const box of document.querySelectorAll(boxes)) {
      if (box.scrollWidth > box.clientWidth + 1) box.tabIndex = 0;
    }
  };
  window.addEventListener("load", () => setTimeout(reachable, 300));
  window.addEventListener("resize", reachable);
})();
