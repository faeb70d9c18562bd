// The notebook page's end of the channel (an anywidget): keeps each scene's log, and shows it in frames.
const MOST_FRAMES = 8; // browsers drop the oldest of about 16 WebGL contexts; we let go of unseen ones first

// anywidget hands `initialize` and `render` different model objects, so what they share is kept by our own key.
const shared = (globalThis.omxView ??= { bundles: new Map(), scenes: new Map(), frames: [] });

// ---- the viewer, unpacked once a page ----------------------------------------------------------------------

async function viewerUrl(model) {
  const bundle = await bundleOf(model), key = bundle.get("key");
  if (!shared.bundles.has(key)) shared.bundles.set(key, unpack(bundle.get("data")));
  return shared.bundles.get(key);
}

async function bundleOf(model) {
  const id = model.get("bundle").replace("IPY_MODEL_", "");
  for (let tries = 0; tries < 100; tries++) { // on a reload, widgets arrive in any order
    const found = await (async () => model.widget_manager.get_model(id))().catch(() => null);
    if (found) return found;
    await new Promise((resolve) => setTimeout(resolve, 50));
  }
  throw new Error("the viewer's code did not arrive");
}

async function unpack(data) {
  const stream = new Blob([data]).stream().pipeThrough(new DecompressionStream("gzip"));
  const source = await new Response(stream).text();
  return URL.createObjectURL(new Blob([source], { type: "text/javascript" }));
}

async function base64(blob) {
  const reader = new FileReader();
  await new Promise((resolve) => { reader.onload = resolve; reader.readAsDataURL(blob); });
  return reader.result.split(",")[1];
}

// The sliders of a panel: what stands beside a handle is its name, too, for those who do not see it.
function nameSliders(output) {
  for (const slider of output?.querySelectorAll(".widget-slider") ?? []) {
    slider.querySelector(".noUi-handle")?.setAttribute("aria-label", slider.querySelector(".widget-label").textContent);
  }
}

// ---- the theme of the page: JupyterLab and others say it on its body -----------------------

function isDark() {
  const light = document.body.dataset.jpThemeLight;
  return light ? light === "false" : /dark/.test(document.body.dataset.vscodeThemeKind ?? "");
}

// ---- a scene: the log of commands, and the frames that show it ---------------------------------------------

class Scene {
  constructor() {
    this.seq = -1;
    this.log = new Map();
    this.frames = new Set();
  }

  // A message of the kernel: false if one before it was missed.
  take(content, data) {
    if (content.replay) {
      if (content.seq <= this.seq) return true;
      this.log.clear();
    } else if (content.seq > this.seq + 1) {
      return false;
    }
    this.seq = Math.max(this.seq, content.seq);
    const commands = split(content, data);
    for (const command of commands) remember(this.log, command);
    for (const key of this.log.keys()) if (key.startsWith("delete\n/meshcat/")) this.log.delete(key);
    for (const frame of this.frames) content.replay ? frame.restart() : frame.queue(commands);
    return true;
  }
}

function split(content, data) {
  const bytes = new Uint8Array(data.buffer, data.byteOffset, data.byteLength);
  let at = 0;
  return content.keys.map(([type, path, name], i) => {
    const start = at;
    at += content.sizes[i];
    return { type, path, name, bytes: bytes.slice(start, at) };
  });
}

// Only the newest command of a kind for a path counts, at the place where it was last written.
function remember(log, command) {
  const { type, path, name } = command;
  if (type === "delete") {
    for (const [key, c] of log) if (c.path === path || c.path.startsWith(path + "/")) log.delete(key);
  }
  const key = type + "\n" + path + "\n" + name;
  log.delete(key);
  log.set(key, command);
}

// ---- a frame: one live viewer in the page ------------------------------------------------------------------

class Frame {
  constructor(scene, model, el) {
    Object.assign(this, { scene, model, el, iframe: null, waiting: new Map(), asked: 0 });
    this.watch = new IntersectionObserver((e) => this.onSeen(e.at(-1).isIntersecting), { rootMargin: "400px" });
    this.watch.observe(el);
    this.theme = new MutationObserver(() => this.used?.theme(isDark()));
    this.theme.observe(document.body, { attributeFilter: ["data-jp-theme-light", "data-vscode-theme-kind"] });
    this.hear = ({ data, source }) => {
      if (source === this.iframe?.contentWindow && data?.omx === "dragged") this.dragged(data);
    };
    window.addEventListener("message", this.hear);
    scene.frames.add(this);
  }

  onSeen(seen) {
    this.seen = seen;
    nameSliders(this.el.closest(".jp-OutputArea-output"));
    if (!seen) return;
    shared.frames = shared.frames.filter((f) => f !== this).concat(this);
    if (!this.iframe) this.start();
    const spare = shared.frames.filter((f) => !f.seen);
    while (shared.frames.length > MOST_FRAMES && spare.length) spare.shift().stop();
  }

  async start() {
    const iframe = (this.iframe = document.createElement("iframe"));
    iframe.title = this.model.get("title");
    Object.assign(iframe.style, { border: "0", width: "100%", height: "100%", display: "block" });
    const url = await viewerUrl(this.model);
    if (this.iframe !== iframe) return;
    iframe.srcdoc = this.model.get("config").shell
      .replace("<!--viewer-->", `<script src="${url}"></script>`);
    // Moving the output cell in the page reloads the frame: then, too, it starts from the log.
    iframe.addEventListener("load", () => this.restart());
    this.el.replaceChildren(iframe);
  }

  restart() {
    const live = this.iframe?.contentWindow?.omxScene;
    if (!live) return;
    if (this.used === live) return this.iframe.contentWindow.location.reload();
    this.used = live;
    this.waiting.clear();
    live.theme(isDark());
    live.apply([...this.scene.log.values()]);
    live.extra?.("html", "Save this scene as one HTML file", async () => {
      const page = new Blob([await this.page()], { type: "text/html" });
      live.save("scene.html", URL.createObjectURL(page));
    });
    this.el.dataset.ready = "true";
  }

  // The scene as it stands, as a page that needs nothing else; static_scene.js says how it is laid out.
  async page() {
    const { shell, start } = this.model.get("config"), commands = [...this.scene.log.values()], text = new TextEncoder();
    const head = text.encode(JSON.stringify(commands.map(({ bytes, ...key }) => [...Object.values(key), bytes.length])));
    const scene = [new Uint32Array([head.length]), head, ...commands.map(({ bytes }) => bytes)];
    const packed = await new Response(new Blob(scene).stream().pipeThrough(new CompressionStream("gzip"))).blob();
    const bundle = await bundleOf(this.model);
    const plain = (id, data) => `<script type="text/plain" id="${id}">${data}</${"script"}>`;
    const data = plain("scene", await base64(packed)) + plain("viewer", await base64(new Blob([bundle.get("data")])));
    return shell.replace("<!--viewer-->", () => `${data}<script>${start}</${"script"}>`);
  }

  // Where the reader drags the tool: the newest of every 40 ms, and the last one always.
  dragged({ pose, q, done }) {
    this.told ??= setTimeout(() => this.tellKernel(), 40);
    this.newest = { event: "dragged", pose, q };
    if (done) this.tellKernel();
  }

  tellKernel() {
    clearTimeout(this.told);
    this.told = null;
    this.model.send(this.newest);
  }

  // Commands wait for the next repaint, the newest of each kind only.
  queue(commands) {
    for (const command of commands) remember(this.waiting, command);
    if (!this.asked) this.asked = requestAnimationFrame(() => this.paint());
  }

  paint() {
    this.asked = 0;
    if (!this.used) return this.waiting.clear();
    this.used.apply([...this.waiting.values()]);
    this.waiting.clear();
  }

  stop() {
    shared.frames = shared.frames.filter((f) => f !== this);
    this.used?.viewer?.renderer.forceContextLoss();
    this.iframe?.remove();
    this.iframe = this.used = null;
    delete this.el.dataset.ready;
  }

  end() {
    this.watch.disconnect();
    this.theme.disconnect();
    window.removeEventListener("message", this.hear);
    this.stop();
    this.scene.frames.delete(this);
  }
}

// ---- anywidget ---------------------------------------------------------------------------------------------

function sceneOf(model) {
  const key = model.get("key");
  if (!shared.scenes.has(key)) {
    const scene = new Scene();
    shared.scenes.set(key, scene);
    const first = model.get("scene");
    scene.take(first, first.data);
  }
  return shared.scenes.get(key);
}

function initialize({ model }) {
  const scene = sceneOf(model);
  const hello = () => model.send({ event: "hello", seq: scene.seq });
  const onMessage = (content, buffers) => {
    if (!scene.take(content, buffers[0])) hello();
  };
  model.on("msg:custom", onMessage);
  hello(); // what was sent while this script was loading has been missed
  return () => {
    model.off("msg:custom", onMessage);
    shared.scenes.delete(model.get("key"));
  };
}

function render({ model, el }) {
  const scene = sceneOf(model);
  const box = document.createElement("div");
  box.className = "omx-scene";
  Object.assign(box.style, { width: "100%", overflow: "hidden", resize: "vertical", minHeight: "120px" });
  // A small screen keeps room for the sliders below.
  const fit = () => { box.style.height = `min(${model.get("height")}px, 45vh)`; };
  fit();
  model.on("change:height", fit);
  el.append(box);
  const frame = new Frame(scene, model, box);
  return () => {
    model.off("change:height", fit);
    frame.end();
  };
}

export default { initialize, render };
