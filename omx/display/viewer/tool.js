// Drag the tool: in the scene's frame, beside scene.js. Arrows for x, y, z, a ring for the pitch and a ball for all three; the
// arm follows by the generated formulas (arm.js), the other branches are ghosts, and what a limit refuses turns red. It also
// says what the scene shows: in words when it settles, and as a warning when the arm touches the table or itself.
(function () {
  "use strict";
  const about = window.OMX_CONFIG?.arm, stage = window.omxScene, viewer = stage?.viewer;
  if (!about || !viewer || !window.OMX_KINEMATICS?.ik) return;
  const A = window.OMX_ARM, { THREE } = MeshCat, { colours } = about;
  const SETTLE_MS = 450, ANSWER_MS = 350; // until the scene has settled; until the host has answered the last position
  const MOVING = [1, 2, 3, 4];

  let q = null; // of the solid arm
  let asked = null; // the pose that the handle stands for
  let found = [], chosen = null;
  let grip = null; // what is being dragged
  let wanted = false; // is it a pose that somebody asked for, and not just where the arm is?
  let waiting = 0;

  // ---- the scene's own nodes -------------------------------------------------------------------------------------------

  function node(...path) {
    return path.reduce((at, name) => at?.children[name], viewer.scene_tree.children.meshcat);
  }
  function matrix(object) {
    object.updateMatrix();
    return A.rows(object.matrix.elements);
  }
  const place = (object, T) => new THREE.Matrix4().fromArray(A.columns(T)).decompose(object.position, object.quaternion, object.scale);

  // ---- the handle ------------------------------------------------------------------------------------------------------

  const handle = new THREE.Group(), ring = new THREE.Group(), targets = [];
  handle.add(ring);
  const UP = new THREE.Vector3(0, 1, 0), SIZE = 0.07, RING = 0.052;

  function part(name, geometry, colour, parent, fat) {
    const material = new THREE.MeshBasicMaterial({ color: colour, depthTest: false, depthWrite: false, transparent: true, opacity: 0.9 });
    const mesh = new THREE.Mesh(geometry, material);
    mesh.renderOrder = 30;
    parent.add(mesh);
    if (fat) { // what the pointer meets: fatter than what is seen, for fingers
      const target = new THREE.Mesh(fat);
      target.visible = false;
      Object.assign(target.userData, { name, mesh });
      parent.add(target);
      targets.push(target);
    }
    return mesh;
  }
  ["x", "y", "z"].forEach((name, i) => {
    const arrow = new THREE.Group();
    arrow.quaternion.setFromUnitVectors(UP, new THREE.Vector3().setComponent(i, 1));
    handle.add(arrow);
    part(name, new THREE.CylinderGeometry(0.0013, 0.0013, SIZE - 0.012).translate(0, 0.5 * SIZE + 0.002, 0), colours.axes[i], arrow);
    part(name, new THREE.ConeGeometry(0.0052, 0.016, 20).translate(0, SIZE, 0), colours.axes[i], arrow,
      new THREE.CylinderGeometry(0.009, 0.009, SIZE - 0.006).translate(0, 0.5 * SIZE + 0.012, 0));
  });
  const flat = (geometry) => geometry.rotateX(Math.PI / 2);
  const circle = part("pitch", flat(new THREE.TorusGeometry(RING, 0.0011, 8, 60)), colours.ink, ring, flat(new THREE.TorusGeometry(RING, 0.007, 6, 36)));
  const knob = part("pitch", new THREE.SphereGeometry(0.0062, 16, 12), colours.ink, ring, new THREE.SphereGeometry(0.012, 8, 6));
  const knobTarget = targets.at(-1);
  const ball = part("all", new THREE.SphereGeometry(0.0068, 16, 12), colours.ink, handle, new THREE.SphereGeometry(0.014, 8, 6));

  function placeHandle() {
    const [x, y, z, pitch] = asked;
    handle.position.set(1e-3 * x, 1e-3 * y, 1e-3 * z);
    ring.rotation.z = Math.atan2(y, x);
    for (const k of [knob, knobTarget]) k.position.set(RING * Math.cos(pitch), 0, RING * Math.sin(pitch));
    const night = document.documentElement.classList.contains("dark");
    const ink = refused() ? colours.refused : night ? "#ffffff" : colours.ink;
    for (const mesh of [ball, knob, circle]) mesh.material.color.set(ink);
  }
  const refused = () => Boolean(wanted && found.length && !chosen);
  const dragging = () => Boolean(grip || waiting);

  // ---- ghosts: the arm's own links again, in the colours of the branches -------------------------------------------------

  let ghosts = null;
  function makeGhosts() {
    const root = new THREE.Group();
    ghosts = about.branches.map((_, k) => {
      const material = new THREE.MeshPhongMaterial({ color: colours.branches[k], transparent: true, opacity: 0.3,
        polygonOffset: true, polygonOffsetFactor: 3, polygonOffsetUnits: 6 });
      const links = [2, 3, 4].map((i) => {
        const link = node("arm", i).object.clone();
        link.matrixAutoUpdate = true;
        link.traverse((o) => { if (o.isMesh) Object.assign(o, { material, castShadow: false, receiveShadow: false }); });
        root.add(link);
        return link;
      });
      return { material, links, colour: colours.branches[k] };
    });
    node().object.add(root);
    ghosts.root = root;
  }

  function placeGhosts() {
    const shown = on && (dragging() || !node("ghosts"));
    standBack(node("ghosts")?.object);
    if (ghosts) ghosts.root.visible = shown;
    if (!shown || !asked || !found.length) return;
    if (!ghosts) makeGhosts();
    const near = refused() ? A.closest(found) : null;
    found.forEach((s, k) => {
      const { links, material, colour } = ghosts[k];
      const seen = s.reachable && (s.index !== chosen?.index || !follows());
      const T = seen && A.frames(s.q, about.geometry);
      links.forEach((link, i) => { link.visible = seen; if (seen) place(link, T[i + 2]); });
      material.color.set(s === near ? colours.refused : colour);
      material.opacity = s === near ? 0.55 : 0.3;
    });
  }

  // The host's own ghosts answer late: while the reader drags they are hidden.
  let hidden = false;
  function standBack(hosts) {
    if (!hosts) return;
    if (dragging() && hosts.visible) [hidden, hosts.visible] = [true, false];
    else if (!dragging() && hidden) [hidden, hosts.visible] = [false, true];
  }

  // A robot's solid arm stands where the robot is: only ghosts obey.
  const follows = () => node("arm").object.follows !== false;

  // ---- what rides on the arm: the axes of its frames, its velocity ellipse ------------------------------------------------

  let ellipse = null;
  function ride() {
    for (const i of MOVING) if (node("frames", i)) place(node("frames", i).object, matrix(node("arm", i).object));
    const seconds = node("arm").object.ellipse;
    if (ellipse) ellipse.visible = Boolean(seconds);
    if (!seconds || !q) return;
    const { centre, long, short } = A.ellipse(q, about.geometry, 1e-3 * seconds), size = Math.hypot(...short);
    const vector = (v) => new THREE.Vector3(...v), middle = vector(centre).multiplyScalar(1e-3);
    const [a, b] = [vector(long), vector(size > 3e-4 ? short : [0, 0, 0])]; // a line where it is flat
    const points = Array.from({ length: 73 }, (_, k) => k * Math.PI / 36)
      .map((t) => middle.clone().addScaledVector(a, Math.cos(t)).addScaledVector(b, Math.sin(t)));
    const curve = size > 3e-4 ? new THREE.CatmullRomCurve3(points.slice(1), true) : new THREE.LineCurve3(points[0], points[36]);
    const tube = new THREE.TubeGeometry(curve, size > 3e-4 ? 96 : 1, 0.0013, 8, size > 3e-4);
    if (!ellipse) {
      ellipse = new THREE.Mesh(tube, new THREE.MeshBasicMaterial({ color: colours.ellipse, side: THREE.DoubleSide }));
      node().object.add(ellipse);
    }
    ellipse.geometry.dispose();
    ellipse.geometry = tube;
    ellipse.visible = true;
  }

  // ---- from a pose to the scene ------------------------------------------------------------------------------------------

  function solve() {
    found = A.branches(asked, about);
    chosen = A.nearest(found, asked, q, about);
  }

  function move(pose) {
    asked = [...pose.slice(0, 3), A.turn(pose[3])];
    wanted = true;
    solve();
    if (chosen && follows()) {
      q = chosen.q;
      A.frames(q, about.geometry).forEach((T, i) => place(node("arm", i).object, T));
      ride();
    }
    if (node("notes", "target")) place(node("notes", "target").object, A.target(asked));
    last = signature();
    tell(false);
    draw();
  }

  function draw() {
    if (node("notes", "target")) node("notes", "target").object.visible = !on; // the handle stands there
    placeHandle();
    placeGhosts();
    warn();
    settle();
    viewer.set_dirty();
  }

  // The page around hears of it; a panel there moves its sliders.
  function tell(done) {
    const heard = chosen ? chosen.q : null;
    window.parent.postMessage({ omx: "dragged", pose: asked, q: heard, done }, "*");
  }

  // Before each repaint: has somebody else moved the arm?
  let last = "";
  const marks = () => [...MOVING.map((i) => node("arm", i)), node("notes", "target")].filter(Boolean).map((n) => n.object);
  const signature = () => marks().map((o) => `${o.position.toArray()} ${o.quaternion.toArray()}`).join() + node("arm").object.ellipse;
  function follow() {
    if (!node("arm", 4) || dragging()) return;
    const now = signature();
    if (now === last) return;
    last = now;
    const target = node("notes", "target")?.object;
    q = A.joints(MOVING.map((i) => matrix(node("arm", i).object)), about.geometry);
    asked = target ? A.poseOf(matrix(target)) : A.pose(q, about.geometry);
    wanted = Boolean(target);
    solve();
    ride();
    draw();
  }
  const render = viewer.render;
  viewer.render = function () {
    follow();
    render.call(this);
    placeGrip();
  };

  // While the reader drags, what Python says about the arm waits: it answers positions that are past. The newest counts.
  const held = new Map(), apply = stage.apply;
  const ours = ({ type, path }) => type === "set_transform" && /^\/meshcat\/(arm\/|ghosts\/|notes\/target)/.test(path);
  stage.apply = (commands) => {
    const now = [];
    for (const c of commands) dragging() && ours(c) ? held.set(c.path, c) : now.push(c);
    apply(now);
  };

  function release() {
    grip = null;
    viewer.controls.enabled = true;
    tell(true);
    clearTimeout(waiting);
    waiting = setTimeout(() => {
      waiting = 0;
      apply([...held.values()]);
      held.clear();
      placeGhosts();
      viewer.set_dirty();
    }, ANSWER_MS);
    draw();
  }

  // ---- pointer -----------------------------------------------------------------------------------------------------------

  const caster = new THREE.Raycaster(), canvas = viewer.renderer.domElement;

  // The pointer's ray in the scene's frame, mm.
  function ray(event) {
    const box = canvas.getBoundingClientRect();
    caster.setFromCamera({ x: 2 * (event.clientX - box.left) / box.width - 1, y: 1 - 2 * (event.clientY - box.top) / box.height }, viewer.camera);
    const local = caster.ray.clone().applyMatrix4(new THREE.Matrix4().copy(node().object.matrixWorld).invert());
    return { origin: local.origin.multiplyScalar(1e3), direction: local.direction.normalize() };
  }

  function under(event) {
    if (!on) return null;
    ray(event);
    const hit = (list) => caster.intersectObjects(list, false)[0]?.object.userData;
    return hit(targets.slice(-1)) || hit([knobTarget]) || hit(targets); // the ball and the knob lie in front
  }

  const along = (axis, from, { origin, direction }) => { // where on the line the ray passes by
    const w = from.clone().sub(origin), b = axis.dot(direction), rest = 1 - b * b;
    return rest < 1e-3 ? null : (b * direction.dot(w) - axis.dot(w)) / rest;
  };
  const meet = (normal, point, { origin, direction }) => { // where the ray meets a plane
    const slope = normal.dot(direction);
    return Math.abs(slope) < 0.12 ? null : origin.clone().addScaledVector(direction, normal.dot(point.clone().sub(origin)) / slope);
  };

  function measure(event) {
    const line = ray(event), from = new THREE.Vector3(...grip.start);
    if (grip.name === "pitch") {
      const yaw = ring.rotation.z, hit = meet(new THREE.Vector3(-Math.sin(yaw), Math.cos(yaw), 0), from, line);
      if (!hit) return { turned: -event.clientY * A.DEG }; // the ring is seen from its edge
      const arm = hit.sub(from);
      return { turned: Math.atan2(arm.z, arm.x * Math.cos(yaw) + arm.y * Math.sin(yaw)) };
    }
    if (grip.name === "all") return { moved: meet(grip.facing, from, line) };
    const axis = new THREE.Vector3().setComponent("xyz".indexOf(grip.name), 1), t = along(axis, from, line);
    return { moved: t === null ? null : axis.multiplyScalar(t) };
  }

  window.addEventListener("pointerdown", (event) => {
    if (event.target !== canvas || event.button > 0) return;
    const hit = under(event);
    if (!hit) return;
    event.stopImmediatePropagation(); // the camera stays
    event.preventDefault();
    if (viewer.animator.playing) viewer.animator.pause();
    viewer.controls.enabled = false;
    const facing = ray({ ...middle() }).direction.clone();
    grip = { name: hit.name, start: asked.slice(0, 3), pitch: asked[3], facing, id: event.pointerId };
    grip.zero = measure(event);
    canvas.setPointerCapture(event.pointerId);
    canvas.style.cursor = "grabbing";
    draw();
  }, { capture: true });

  function middle() {
    const box = canvas.getBoundingClientRect();
    return { clientX: box.left + box.width / 2, clientY: box.top + box.height / 2 };
  }

  window.addEventListener("pointermove", (event) => {
    if (!grip) {
      if (event.target === canvas && !event.buttons) hover(under(event));
      return;
    }
    if (event.pointerId !== grip.id) return;
    event.stopImmediatePropagation();
    const { moved, turned } = measure(event), { zero, start, pitch } = grip;
    if (turned !== undefined) move([...start, pitch + turned - zero.turned]);
    else if (moved && zero.moved) move([...moved.sub(zero.moved).add(new THREE.Vector3(...start)).toArray(), pitch]);
  }, { capture: true });

  for (const name of ["pointerup", "pointercancel"]) {
    window.addEventListener(name, (event) => {
      if (!grip || event.pointerId !== grip.id) return;
      event.stopImmediatePropagation();
      canvas.style.cursor = "";
      release();
    }, { capture: true });
  }

  let lit = null;
  function hover(hit) {
    if (hit?.mesh === lit) return;
    if (lit) lit.material.opacity = 0.9;
    lit = hit?.mesh ?? null;
    if (lit) lit.material.opacity = 0.55;
    canvas.style.cursor = lit ? "grab" : "";
    viewer.set_dirty();
  }

  // ---- keyboard ----------------------------------------------------------------------------------------------------------

  const gripBox = document.createElement("div");
  gripBox.id = "omx-grip";
  gripBox.tabIndex = 0;
  gripBox.setAttribute("role", "application");
  gripBox.setAttribute("aria-label", "The tool. Arrow keys move it in x and y, Page Up and Page Down in z, plus and minus " +
    "turn the pitch; with Shift ten times as far.");
  document.body.append(gripBox);
  const KEYS = { ArrowUp: [1, 0, 0, 0], ArrowDown: [-1, 0, 0, 0], ArrowLeft: [0, 1, 0, 0], ArrowRight: [0, -1, 0, 0],
    PageUp: [0, 0, 1, 0], PageDown: [0, 0, -1, 0], "+": [0, 0, 0, 1], "=": [0, 0, 0, 1], "*": [0, 0, 0, 1],
    "-": [0, 0, 0, -1], _: [0, 0, 0, -1] };
  gripBox.addEventListener("keydown", (event) => {
    const step = KEYS[event.key];
    if (!step || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault();
    event.stopPropagation();
    if (viewer.animator.playing) viewer.animator.pause();
    const far = event.shiftKey ? 10 : 1;
    grip ??= { name: "key" };
    move(asked.map((v, i) => (i === 3 ? v + far * step[i] * A.DEG : Math.round(v) + far * step[i])));
    clearTimeout(gripBox.end);
    gripBox.end = setTimeout(release, 120);
  });

  function placeGrip() {
    if (!on || !asked) return;
    const at = new THREE.Vector3(...asked.slice(0, 3)).multiplyScalar(1e-3).applyMatrix4(node().object.matrixWorld).project(viewer.camera);
    gripBox.style.left = `${50 + 50 * at.x}%`;
    gripBox.style.top = `${50 - 50 * at.y}%`;
  }

  // ---- words -------------------------------------------------------------------------------------------------------------

  const note = document.createElement("p"), said = document.createElement("p");
  note.id = "omx-note";
  note.setAttribute("aria-hidden", "true"); // the sentence says it, too
  said.id = "omx-words";
  document.body.append(note, said);

  function problem() {
    if (refused()) {
      const near = A.closest(found);
      return near.reachable ? `${near.broken.map(A.words).join("; ")} (${near.name})` : near.verdict;
    }
    return q ? A.touching(q, about) : "";
  }

  function warn() {
    const words = problem();
    note.textContent = words && (refused() ? `The arm stays: ${words}.` : `${words[0].toUpperCase()}${words.slice(1)}.`);
    note.hidden = !words;
  }

  function sentence() {
    const [x, y, z, pitch] = A.pose(q, about.geometry), own = A.branches([x, y, z, pitch], about);
    const way = (s) => s.q.reduce((sum, v, i) => sum + A.turn(v - q[i]) ** 2, 0);
    const branch = own.filter((s) => s.reachable).sort((a, b) => way(a) - way(b))[0];
    const where = `Tool at x = ${A.text(x, 1)}, y = ${A.text(y, 1)}, z = ${A.text(z, 1)} mm, pitch = ${A.text(pitch / A.DEG, 1)}\u00b0`;
    const verdict = problem() || (branch && !branch.legal ? branch.verdict : "within its limits, touching nothing");
    return `${where}; ${branch ? `${branch.name}; ` : ""}${refused() ? "the arm stays: " : ""}${verdict}.`;
  }

  let settling = 0;
  function settle() {
    clearTimeout(settling);
    settling = setTimeout(() => {
      settling = 0;
      if (viewer.animator.playing) return;
      said.textContent = q ? sentence() : "";
      said.setAttribute("role", "status"); // from the second sentence on it is spoken: a page that opens is quiet
      placeGhosts();
      viewer.set_dirty();
    }, SETTLE_MS);
  }

  // ---- on and off ----------------------------------------------------------------------------------------------------------

  let on = false;
  const button = stage.button("tool", "Drag the tool", () => show(!on));
  function show(shown) {
    on = shown;
    handle.visible = on;
    gripBox.hidden = !on;
    button.setAttribute("aria-pressed", String(on));
    last = "";
    placeGhosts();
    viewer.set_dirty();
  }
  node()?.object ?? viewer.scene_tree.find(["meshcat"]);
  node().object.add(handle);
  stage.tool = { show, move: (pose) => { grip = { name: "code" }; move(pose); release(); }, state: () => ({ q, asked, found, chosen, on }) };
  show(Boolean(about.handle));
})();
