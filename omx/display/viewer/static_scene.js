// In a frame without a kernel: unpack the viewer and the scene that stand in this page, and show them.
(async function () {
  "use strict";
  const whole = "<!DOCTYPE html>\n" + document.documentElement.outerHTML; // as it came, for the reader to keep
  function unpack(id) {
    const packed = Uint8Array.from(atob(document.getElementById(id).textContent), (c) => c.charCodeAt(0));
    return new Response(new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip")));
  }

  // A head of rows, each ending with the length of its bytes, or with the name of known bytes; then the bytes.
  async function takeApart(id, known) {
    const data = await unpack(id).arrayBuffer();
    const size = new DataView(data).getUint32(0, true);
    const head = JSON.parse(new TextDecoder().decode(new Uint8Array(data, 4, size)));
    let at = 4 + size;
    return head.map((row) => {
      const last = row.pop();
      if (typeof last === "string") return [row, known.get(last)];
      at += last;
      return [row, new Uint8Array(data.slice(at - last, at))];
    });
  }

  document.documentElement.classList.toggle("dark", Boolean(window.OMX_CONFIG.dark));

  const code = document.createElement("script");
  code.textContent = await unpack("viewer").text();
  document.body.append(code);
  const known = new Map();
  for (const id of ["stock", "objects"]) {
    if (!document.getElementById(id)) continue;
    for (const [[name], bytes] of await takeApart(id)) known.set(name, bytes);
  }
  const scene = await takeApart("scene", known), { viewer } = window.omxScene;
  window.omxScene.apply(scene.map(([[type, path, name], bytes]) => ({ type, path, name, bytes })));
  if (window.OMX_POSED) window.omxScene.said.transforms(window.OMX_POSED);
  window.omxScene.extra?.("html", "Save this scene as one HTML file", () => {
    const posed = JSON.stringify({ nodes: places(viewer.scene_tree.children.meshcat, "/meshcat") });
    const page = whole.replace("window.OMX_CONFIG =", () => `window.OMX_POSED = ${posed}; window.OMX_CONFIG =`);
    window.omxScene.save("scene.html", URL.createObjectURL(new Blob([page], { type: "text/html" })));
  });
  function places({ object, children }, path) { // where every node stands now
    object.updateMatrix();
    const below = Object.entries(children).filter(([name]) => !name.startsWith("<"));
    return Object.assign({ [path]: object.matrix.elements }, ...below.map(([name, node]) => places(node, `${path}/${name}`)));
  }
  document.body.dataset.ready = "true";
  window.parent.postMessage({ omx: "ready" }, "*"); // the page may now move it
})();
