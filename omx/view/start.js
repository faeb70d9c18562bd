// In a frame without a kernel: unpack the viewer and the scene that stand in this page, and show them.
(async function () {
  "use strict";
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

  const code = document.createElement("script");
  code.textContent = await unpack("viewer").text();
  document.body.append(code);
  const known = new Map();
  if (document.getElementById("stock")) {
    for (const [[name], bytes] of await takeApart("stock")) known.set(name, bytes);
  }
  const commands = await takeApart("scene", known);
  window.omxScene.apply(commands.map(([[type, path], bytes]) => ({ type, path, bytes })));
  document.body.dataset.ready = "true";
  window.parent.postMessage({ omx: "ready" }, "*"); // the page may now move it
})();
