// Runs in the scene's frame, beside the unmodified MeshCat viewer: takes commands, adds a small toolbar.
// The host page calls `omxScene.apply(commands)`, each command {type, path, bytes}.
(function () {
  "use strict";
  const config = window.OMX_CONFIG || {};
  const pane = document.getElementById("meshcat-pane");
  let viewer;
  try {
    viewer = new MeshCat.Viewer(pane, false);
  } catch (error) {
    pane.textContent = "This browser offers no WebGL, so the 3-D scene cannot be drawn (" + error.message + ").";
    pane.style.font = "14px sans-serif";
    window.omxScene = { apply() {}, theme() {} };
    return;
  }

  window.onmessage = null; // the viewer's film encoder, made for a worker, would answer each message to itself, for ever
  pane.style.visibility = "hidden"; // the viewer's own blue sky, until there is a scene

  // The viewer would ask for every frame of the screen: it asks for one when there is something to draw.
  let asked = false;
  viewer.animate = () => {
    asked = true;
    requestAnimationFrame(draw);
  };
  function draw() {
    asked = false;
    viewer.animator.update();
    if (viewer.needs_render) viewer.render();
  }
  viewer.set_dirty = () => {
    viewer.needs_render = true;
    if (!asked) viewer.animate();
  };
  const animator = Object.getPrototypeOf(viewer.animator), { play: begin } = animator;
  animator.play = function () {
    begin.call(this);
    viewer.set_dirty();
  };

  viewer.renderer.domElement.addEventListener("webglcontextrestored", viewer.set_dirty);

  // Without a graphics card (virtual machines, remote desktops) soft shadows cost a third of each frame.
  const gl = viewer.renderer.getContext();
  const card = gl.getExtension("WEBGL_debug_renderer_info");
  const drawnBy = card ? String(gl.getParameter(card.UNMASKED_RENDERER_WEBGL)) : "";
  if (/swiftshader|llvmpipe|software|basic render/i.test(drawnBy)) {
    viewer.renderer.shadowMap.type = MeshCat.THREE.BasicShadowMap;
  }

  // Labels carry pictures, which arrive a moment later: by then the label may have been removed again.
  const wanted = new Set();
  const setObject = viewer.set_object.bind(viewer);
  viewer.set_object = (path, object) => {
    if (!wanted.has("/" + path.join("/"))) return;
    setObject(path, object);
    if (dark) dress();
  };

  // What looks otherwise where the page around is dark: the sky, the grid (a factor of its ink), how deep shadows are, and words.
  const DAY = { top: [255, 255, 255], bottom: [240, 243, 246], grid: 0xffffff, shadow: 0.26 };
  const NIGHT = { top: [74, 83, 94], bottom: [44, 50, 58], grid: 0x9aa0a8, shadow: 0.55 };
  let dark = document.documentElement.classList.contains("dark");
  function theme(now) {
    dark = now;
    document.documentElement.classList.toggle("dark", dark);
    dress();
  }
  function dress() {
    const { top, bottom, grid, shadow } = dark ? NIGHT : DAY;
    viewer.set_property(["Background"], "top_color", top.map((c) => c / 255));
    viewer.set_property(["Background"], "bottom_color", bottom.map((c) => c / 255));
    viewer.scene_tree.find(["meshcat", "ground"]).object.traverse(({ material }) => {
      if (material?.isShadowMaterial) material.opacity = shadow;
      else material?.color.set(grid);
    });
    relabel();
    viewer.set_dirty();
  }
  dress();

  // Words are pictures, drawn for a light stage: at night their ink is pale and their rim is dark.
  function relabel() {
    viewer.scene.traverse(({ isSprite, material, userData }) => {
      const map = isSprite && material.map, address = userData.day ?? map?.image?.src;
      if (!address?.startsWith("data:image/svg+xml;base64,") || (!dark && !userData.day)) return;
      userData.day = address;
      const picture = new Image();
      picture.onload = () => { Object.assign(map, { image: picture, needsUpdate: true }); viewer.set_dirty(); };
      picture.src = dark ? address.replace(/[^,]*$/, (svg) => btoa(atNight(atob(svg)))) : address;
    });
  }
  function atNight(svg) {
    const pale = (c) => Math.round(255 - 0.4 * (255 - parseInt(c, 16))).toString(16);
    return svg.replace('stroke="#ffffff"', 'stroke="#22262c"')
      .replace(/fill="#(..)(..)(..)"/, (_, r, g, b) => `fill="#${pale(r)}${pale(g)}${pale(b)}"`);
  }

  const properties = new Map(); // the newest of each, by path and name
  let size = 1; // of what is drawn, as a multiple of what was drawn first
  function take(command) {
    const { type, path, name, bytes } = command;
    if (type === "set_object") wanted.add(path);
    if (type === "set_property") properties.set(`${path} ${name}`, command);
    if (type === "delete") for (const p of wanted) if (p === path || p.startsWith(path + "/")) wanted.delete(p);
    try {
      viewer.handle_command_bytearray(bytes);
    } catch (error) {
      console.error("omx.display.viewer: " + type + " " + path + " failed:", error); // the rest of the scene still counts
    }
    if (viewer.camera.target) aim(viewer.camera.target);
    if (type === "set_animation") {
      if (matchMedia("(prefers-reduced-motion: reduce)").matches) viewer.animator.pause();
      showPlayer();
    }
  }

  // The viewer's controls turn about a point that no command reaches: it comes as a property of the camera.
  function aim(target) {
    viewer.controls.target.fromArray(target);
    viewer.camera.target = null;
  }

  function resize() {
    if (!pane.offsetWidth || !window.innerHeight) return;
    viewer.camera.zoom = Math.min(1, pane.offsetWidth / window.innerHeight / 1.25);
    viewer.set_3d_pane_size();
  }
  new ResizeObserver(resize).observe(document.documentElement);

  // The wheel scrolls the page until the reader clicks into the scene.
  window.addEventListener("wheel", (event) => {
    if (!document.hasFocus() && !event.ctrlKey) event.stopImmediatePropagation();
  }, { capture: true });

  // The view by keyboard: arrows turn it, plus and minus come nearer and go away.
  const TURN = Math.PI / 24, NEARER = 0.9, canvas = viewer.renderer.domElement;
  const KEYS = { ArrowLeft: [-TURN, 0, 1], ArrowRight: [TURN, 0, 1], ArrowUp: [0, -TURN, 1], ArrowDown: [0, TURN, 1],
    "+": [0, 0, NEARER], "=": [0, 0, NEARER], "-": [0, 0, 1 / NEARER] };
  canvas.tabIndex = 0;
  canvas.setAttribute("role", "application");
  canvas.setAttribute("aria-label", "The view. Arrow keys turn it, plus and minus zoom.");
  canvas.addEventListener("keydown", (event) => {
    const step = KEYS[event.key];
    if (!step || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault();
    const { target } = viewer.controls, { position } = viewer.camera;
    const place = new MeshCat.THREE.Spherical().setFromVector3(position.clone().sub(target));
    place.theta += step[0];
    place.phi = Math.min(Math.max(place.phi + step[1], 0.05), Math.PI - 0.05);
    place.radius *= step[2];
    position.setFromSpherical(place).add(target);
    viewer.controls.update();
    viewer.set_dirty();
  });

  // ---- toolbar ---------------------------------------------------------------------------------------------
  const bar = document.createElement("div");
  bar.id = "omx-bar";
  document.body.appendChild(bar);

  function button(text, title, action, before = null) {
    const b = document.createElement("button");
    b.type = "button";
    b.textContent = text;
    b.title = title;
    b.setAttribute("aria-label", title);
    b.addEventListener("click", action);
    bar.insertBefore(b, before);
    return b;
  }

  function look({ position, target }) {
    aim(target);
    viewer.camera.position.fromArray(position);
    viewer.set_dirty();
  }
  for (const [name, camera] of Object.entries(config.cameras || {})) {
    button(name, "View: " + name, () => look(camera));
  }
  const panel = viewer.gui.domElement, extras = [];
  panel.style.display = "none";
  const more = button("\u22ef", "More: keep the scene as picture, film or page, MeshCat's own panel", () => {
    const shown = panel.style.display === "none";
    panel.style.display = shown ? "" : "none";
    for (const b of extras) b.hidden = !shown;
    viewer.gui.open();
    name();
    rows.observe(panel, { childList: true, subtree: true });
  });
  const rows = new MutationObserver(name);
  function name() { // MeshCat leaves the fields of its panel without one
    for (const field of panel.querySelectorAll(":is(input, select):not([aria-label])")) {
      field.setAttribute("aria-label", field.closest("li")?.querySelector(".property-name")?.textContent || "value");
    }
  }
  const extra = (...about) => {
    const b = button(...about, more);
    b.hidden = true;
    extras.push(b);
    return b;
  };
  function save(name, url) {
    const link = document.createElement("a");
    Object.assign(link, { href: url, download: name });
    link.click();
  }
  extra("png", "Save a png picture at twice the size", () => save("scene.png", picture(2)));
  function picture(scale) {
    const { renderer } = viewer, ratio = renderer.getPixelRatio();
    renderer.setPixelRatio(scale * ratio);
    const url = viewer.capture_image();
    renderer.setPixelRatio(ratio);
    viewer.set_dirty();
    return url;
  }

  // ---- a film: once through the animation, or what the reader does until the button is pressed again -------------
  const FILM_S = 30, KINDS = ["video/webm;codecs=vp9", "video/webm", "video/mp4"];
  const kind = window.MediaRecorder && KINDS.find((name) => MediaRecorder.isTypeSupported(name));
  if (kind) extra("film", "Record a film: of the animation, or of what you do until you press this again", film);
  let recorder = null;
  function film({ currentTarget: pressed }) {
    if (recorder) return recorder.stop();
    const { animator, renderer } = viewer, animated = animator.actions.length > 0, parts = [];
    recorder = new MediaRecorder(renderer.domElement.captureStream(30), { mimeType: kind, videoBitsPerSecond: 4e6 });
    recorder.ondataavailable = ({ data }) => parts.push(data);
    const end = setTimeout(() => recorder.stop(), 1e3 * (animated ? animator.duration : FILM_S));
    recorder.onstop = () => {
      clearTimeout(end);
      recorder = null;
      pressed.setAttribute("aria-pressed", "false");
      save(`scene.${kind.slice(6).split(";")[0]}`, URL.createObjectURL(new Blob(parts, { type: kind })));
    };
    if (animated) animator.seek(0);
    if (animated && !animator.playing) play.click();
    recorder.start();
    pressed.setAttribute("aria-pressed", "true");
    requestAnimationFrame(function again() { // a scene at rest is not drawn, and would have no frames
      if (!recorder) return;
      viewer.set_dirty();
      requestAnimationFrame(again);
    });
  }

  // ---- animation -------------------------------------------------------------------------------------------
  const play = button("\u25b6", "Play or pause", () => {
    const a = viewer.animator;
    if (a.playing) a.pause(); else a.play();
    showPlaying();
  });
  const time = document.createElement("input");
  time.type = "range";
  time.step = "any";
  time.setAttribute("aria-label", "Time in the animation");
  time.addEventListener("input", () => {
    viewer.animator.pause();
    viewer.animator.seek(Number(time.value));
    showPlaying();
  });
  bar.append(time);

  function showPlayer() {
    const shown = viewer.animator.actions.length > 0;
    play.hidden = time.hidden = !shown;
    time.max = viewer.animator.duration;
    showPlaying();
  }
  function showPlaying() {
    play.textContent = viewer.animator.playing ? "\u275a\u275a" : "\u25b6";
    if (viewer.animator.playing) requestAnimationFrame(followTime);
  }
  function followTime() {
    time.value = viewer.animator.time;
    showPlaying();
  }
  showPlayer();
  resize();

  // ---- in a page without a kernel, the page around the frame speaks to it: tool.js and dh_row.js hear more -------
  const said = {
    theme(message) { theme(message.dark); },
    transforms({ nodes, visible, branch }) {
      if (viewer.animator.playing) play.click();
      const words = (path) => path.split("/").filter(Boolean);
      for (const [path, matrix] of Object.entries(nodes)) viewer.set_transform(words(path), matrix);
      for (const [path, shown] of Object.entries(visible || {})) viewer.set_property(words(path), "visible", shown);
      if (branch !== undefined) viewer.set_property(["meshcat", "arm"], "branch", branch);
      viewer.set_dirty();
    },
    draw({ commands, size: now }) { // another arm in place of this one; what was said of that, its opacity say, holds on
      for (const command of commands) take(command);
      for (const command of properties.values()) if (command.path.startsWith("/meshcat/arm")) take(command);
      for (const place of [viewer.controls.target, viewer.camera.position]) place.multiplyScalar(now / size);
      size = now;
      viewer.set_dirty();
    },
    play() { if (!viewer.animator.playing) play.click(); },
    pause() { if (viewer.animator.playing) play.click(); },
  };
  window.addEventListener("message", ({ data, source }) => {
    if (source === window.parent && source !== window && Object.hasOwn(said, data?.omx)) said[data.omx](data);
  });

  window.omxScene = {
    viewer,
    apply(commands) {
      for (const c of commands) take(c);
      pane.style.visibility = "";
    },
    picture, extra, save, theme, said,
    button: (...about) => button(...about, more), // before the dots
  };
})();
