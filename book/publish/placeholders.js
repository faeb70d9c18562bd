// For sites and slides: turns each placeholder into a sandboxed frame when the reader comes near, and lets go of
// frames far away when there are many. `OMX_VIEW` (written before this) holds the viewer and the frame's page.
(function () {
  "use strict";
  const MOST_FRAMES = 8;
  const filled = [];
  const root = document.documentElement;
  const isDark = () => root.dataset.theme === "dark";

  // In the frame on a slide, keys are the speaker's after a click, too; who has come by Tab keeps them. It listens before
  // the viewer does, which keeps a hand on the arm to itself.
  function giveKeysAway() {
    let clicked = false;
    window.addEventListener("pointerdown", () => { clicked = true; }, { capture: true });
    window.addEventListener("keydown", (event) => {
      if (event.key === "Tab") clicked = false;
      if (!clicked || event.ctrlKey || event.altKey || event.metaKey) return;
      event.preventDefault();
      event.stopImmediatePropagation();
      window.parent.postMessage({ omx: "key", code: event.keyCode }, "*");
    }, { capture: true });
  }

  // The frame's page for one placeholder.
  function page(box) {
    const { shell, viewer, stock, start } = OMX_VIEW;
    const config = JSON.stringify({ ...JSON.parse(box.dataset.config), dark: isDark() }).replaceAll("<", "\\u003c");
    const text = (id, data) => '<script type="text/plain" id="' + id + '">' + data + "</" + "script>";
    const keys = root.dataset.keys === "page" ? "(" + giveKeysAway + ")();" : "";
    const run = "<script>" + keys + start + "</" + "script>";
    return shell.replace("/*config*/{}", () => config)
      .replace("<!--viewer-->", () => text("scene", box.dataset.scene) + text("objects", box.dataset.objects) +
        text("stock", stock) + text("viewer", viewer) + run);
  }

  function fill(box) {
    if (box.firstElementChild) return;
    const frame = document.createElement("iframe");
    frame.setAttribute("sandbox", "allow-scripts allow-downloads");
    frame.title = box.getAttribute("aria-label") || "3-D scene";
    frame.style.cssText = "width:100%;height:100%;border:0;display:block";
    frame.srcdoc = page(box);
    box.dataset.dark = isDark();
    box.append(frame);
    reached(box, true);
    filled.push(box);
    for (const old of filled.filter((b) => !near.has(b)).slice(0, Math.max(0, filled.length - MOST_FRAMES))) {
      old.replaceChildren();
      reached(old, false);
      delete old.dataset.ready;
      filled.splice(filled.indexOf(old), 1);
    }
  }

  // Tab comes to a frame that is not there yet, and from it goes on into the scene, which is no single picture then.
  function reached(box, isThere) {
    box.tabIndex = isThere ? -1 : 0;
    box.setAttribute("role", isThere ? "group" : "img");
  }

  const near = new Set();
  const watch = new IntersectionObserver((entries) => {
    for (const { target, isIntersecting } of entries) {
      if (!isIntersecting) near.delete(target);
      else { near.add(target); fill(target); }
    }
  }, { rootMargin: "400px" });

  // A site whose reader may turn the lights off says so on its root.
  function dress(box) {
    if (box.dataset.dark === String(isDark())) return;
    box.querySelector("iframe")?.contentWindow?.postMessage({ omx: "theme", dark: isDark() }, "*");
    if (box.dataset.ready) box.dataset.dark = isDark();
  }
  new MutationObserver(() => filled.forEach(dress))
    .observe(root, { attributeFilter: ["data-theme"] });
  window.addEventListener("message", ({ data, source }) => {
    const box = data?.omx === "ready" && filled.find((b) => b.querySelector("iframe")?.contentWindow === source);
    if (!box) return;
    box.dataset.ready = "true";
    dress(box); // it may have been too late, or too early, for the last change
  });

  function begin() {
    for (const box of document.querySelectorAll(".omx-scene[data-scene]")) {
      reached(box, false);
      watch.observe(box);
    }
  }
  if (document.readyState === "loading") document.addEventListener("DOMContentLoaded", begin);
  else begin();
})();
