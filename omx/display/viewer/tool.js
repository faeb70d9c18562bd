// Drag the tool, or pull a link: in the scene's frame, beside scene.js. The tool has arrows for x, y, z, a ball for all three
// and a ring for each turn that the arm's inverse takes; the arm follows by the generated formulas (arm.js), the other branches
// are ghosts, and what a limit refuses turns red. A link, or the tool of an arm without an inverse, is followed by damped least
// squares. It also says what the scene shows: in words when it settles, and as a warning when the arm touches the table or itself.
(function () {
  "use strict";
  const about = window.OMX_CONFIG?.arm, stage = window.omxScene, viewer = stage?.viewer;
  if (!about || !viewer || (about.geometry && !window.OMX_KINEMATICS?.ik)) return;
  const A = window.OMX_ARM, { THREE } = MeshCat, { colours } = about, task = A.task(about);
  const SETTLE_MS = 450, ANSWER_MS = 350; // until the scene has settled; until the host has answered the last position
  const SLOP = 4; // a hand that moves by fewer pixels has only clicked
  const LINKS = about.rows.map((_, i) => i + 1), TIP = LINKS.length;
  const GHOSTLY = about.geometry ? LINKS.slice(1) : LINKS; // what turns about a vertical axis alone often stands there already

  let q = null; // of the solid arm
  let aim = null; // where the reader has led it; a robot's solid arm does not follow
  let asked = null; // the target that the handle stands for
  let found = [], chosen = null;
  let grip = null; // what is being dragged
  let wanted = false; // is it a target that somebody asked for, and not just where the arm is?
  let stopped = ""; // why a pull got no farther
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

  const handle = new THREE.Group(), targets = [];
  const scale = about.geometry ? 1 : about.reach / 320; // as large in the picture of every arm as in that of this book's
  handle.scale.setScalar(scale);
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
  const tips = [1, 2, 3, 4, 5].map((k) => A.at(A.frames(about.rows.map((row, i) => (row.prismatic ? 100 : 1) * Math.sin(k + 2 * i * k)), about).at(-1)));
  const flat = (i) => !task.given && tips.every((tip) => Math.abs(tip[i] - tips[0][i]) < 1e-6); // a planar arm never leaves its plane
  ["x", "y", "z"].forEach((name, i) => {
    if (flat(i)) return;
    const arrow = new THREE.Group();
    arrow.quaternion.setFromUnitVectors(UP, new THREE.Vector3().setComponent(i, 1));
    handle.add(arrow);
    part(name, new THREE.CylinderGeometry(0.0013, 0.0013, SIZE - 0.012).translate(0, 0.5 * SIZE + 0.002, 0), colours.axes[i], arrow);
    part(name, new THREE.ConeGeometry(0.0052, 0.016, 20).translate(0, SIZE, 0), colours.axes[i], arrow,
      new THREE.CylinderGeometry(0.009, 0.009, SIZE - 0.006).translate(0, 0.5 * SIZE + 0.012, 0));
  });
  const rings = task.rings([1, 0]).map(({ name, axis }, k) => {
    const ring = new THREE.Group(), ink = colours.axes[axis] ?? colours.ink;
    handle.add(ring);
    const circle = part(name, new THREE.TorusGeometry(RING, 0.0011, 8, 60), ink, ring, new THREE.TorusGeometry(RING, 0.007, 6, 36));
    const knob = axis === undefined && part(name, new THREE.SphereGeometry(0.0062, 16, 12), ink, ring, new THREE.SphereGeometry(0.012, 8, 6));
    for (const target of targets.slice(knob ? -2 : -1)) target.userData.ring = k;
    return { ring, circle, knob, knobTarget: knob && targets.at(-1) };
  });
  const ball = part("all", new THREE.SphereGeometry(0.0068, 16, 12), colours.ink, handle, new THREE.SphereGeometry(0.014, 8, 6));
  const front = [targets.at(-1), ...rings.map(({ knobTarget }) => knobTarget).filter(Boolean)]; // they lie before the others
  const rope = new THREE.Group(); // from the point of a link to the hand that pulls it
  const fist = part("link", new THREE.SphereGeometry(0.0068 * scale, 16, 12), colours.ink, rope);
  const thread = new THREE.Line(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({ depthTest: false, transparent: true }));
  thread.renderOrder = 30;
  thread.frustumCulled = false;
  rope.add(thread);

  const vector = (v) => new THREE.Vector3(...v);
  const turnsOf = (target) => task.rings(target).map(({ u, v, ...more }) => ({ ...more, u: vector(u), v: vector(v), axle: vector(u).cross(vector(v)) }));
  const position = () => vector(A.at(task.matrix(asked)));

  function placeHandle() {
    handle.position.copy(position()).multiplyScalar(1e-3);
    turnsOf(asked).forEach(({ u, v, axle }, k) => {
      const { ring, knob, knobTarget } = rings[k];
      ring.quaternion.setFromRotationMatrix(new THREE.Matrix4().makeBasis(u, v, axle));
      if (knob) for (const o of [knob, knobTarget]) o.position.set(RING * Math.cos(asked[3]), RING * Math.sin(asked[3]), 0);
    });
    const night = document.documentElement.classList.contains("dark"), ink = night ? "#ffffff" : colours.ink;
    const red = (refused() || stopped) && colours.refused;
    for (const mesh of [ball, fist, thread]) mesh.material.color.set(red || ink);
    rings.forEach(({ circle, knob }, k) => {
      circle.material.color.set(red || (knob ? ink : colours.axes[k]));
      if (knob) knob.material.color.set(red || ink);
    });
  }
  const refused = () => Boolean(wanted && found.length && !chosen);
  const dragging = () => Boolean(grip || waiting);

  // ---- ghosts: the arm's own links again, in the colours of the branches -------------------------------------------------

  let ghosts = null;
  function makeGhosts() {
    const root = new THREE.Group();
    ghosts = (about.branches ?? [""]).map((_, k) => {
      const colour = colours.branches[k] ?? colours.ink;
      const material = new THREE.MeshPhongMaterial({ color: colour, transparent: true, opacity: 0.3,
        polygonOffset: true, polygonOffsetFactor: 3, polygonOffsetUnits: 6 });
      const links = GHOSTLY.map((i) => {
        const link = node("arm", i).object.clone();
        link.matrixAutoUpdate = true;
        link.traverse((o) => { if (o.isMesh) Object.assign(o, { material, castShadow: false, receiveShadow: false }); });
        root.add(link);
        return link;
      });
      return { material, links, colour };
    });
    node().object.add(root);
    ghosts.root = root;
  }

  function placeGhosts() {
    const led = dragging() && (on || !follows()), shown = led || (on && !node("ghosts"));
    standBack(node("ghosts")?.object, led);
    if (ghosts) ghosts.root.visible = shown;
    if (!shown || !asked || !found.length) return;
    if (!ghosts) makeGhosts();
    const near = refused() ? closest() : null;
    found.forEach((s, k) => {
      const { links, material, colour } = ghosts[k];
      const taken = s.index === chosen?.index, seen = s.reachable && (taken ? !follows() : on);
      const T = seen && A.frames(taken ? chosen.q : s.q, about);
      links.forEach((link, i) => { link.visible = seen; if (seen) place(link, T[GHOSTLY[i]]); });
      material.color.set(s === near ? colours.refused : colour);
      material.opacity = s === near ? 0.55 : 0.3;
    });
  }

  // The host's own ghosts answer late: while the reader drags they are hidden.
  let hidden = false;
  function standBack(hosts, back) {
    if (!hosts) return;
    if (back && hosts.visible) [hidden, hosts.visible] = [true, false];
    else if (!back && hidden) [hidden, hosts.visible] = [false, true];
  }

  // A robot's solid arm stands where the robot is: only ghosts obey.
  const follows = () => node("arm")?.object.follows !== false;

  // ---- what rides on the arm: the axes of its frames, its velocity ellipse ------------------------------------------------

  let ellipse = null;
  function carryFrames() {
    for (const i of LINKS) if (node("frames", i) && node("arm", i)) place(node("frames", i).object, matrix(node("arm", i).object));
  }
  function ride() {
    carryFrames();
    const seconds = node("arm").object.ellipse;
    if (ellipse) ellipse.visible = Boolean(seconds);
    if (!seconds || !q || !about.geometry) return;
    const { centre, long, short } = A.ellipse(q, about.geometry, 1e-3 * seconds), size = Math.hypot(...short);
    const middle = vector(centre).multiplyScalar(1e-3);
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

  // A panel may keep to a branch by its name; else the nearest is taken.
  const kept = () => node("arm").object.branch;
  const closest = () => found.find(({ name }) => name === kept()) ?? A.closest(found);

  function solve() {
    found = A.branches(asked, about);
    chosen = kept() ? found.find(({ name, legal }) => legal && name === kept()) : A.nearest(found, asked, q, about);
    stopped = "";
  }

  // By its handle the tool goes where it is asked to, or the arm stays; without an inverse it comes as near as it can.
  function move(target) {
    [asked, wanted] = [target, true];
    if (task.given) solve();
    else pulled(A.pull(aim, TIP, [0, 0, 0], asked, about));
    show();
  }

  function pulled({ q: values, verdict }) {
    [aim, stopped] = [values, verdict];
    const own = branchOf(values);
    found = task.given ? A.branches(A.pose(values, about), about) : [];
    chosen = { ...(own ?? { index: 0, reachable: true }), q: values };
    if (!found.length && !follows()) found = [chosen];
  }

  function show() {
    if (chosen) aim = chosen.q;
    if (chosen && follows()) {
      q = chosen.q;
      A.frames(q, about).forEach((T, i) => place(node("arm", i).object, T));
      ride();
    }
    if (node("notes", "target")) place(node("notes", "target").object, task.matrix(asked));
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

  // The page around hears of it, and a panel there moves its sliders: what was asked for, unless a link was pulled, and where
  // the joints are then.
  function tell(done) {
    const heard = chosen ? chosen.q : null;
    window.parent.postMessage({ omx: "dragged", pose: wanted && task.given ? asked : null, q: heard, done }, "*");
  }

  // Before each repaint: has somebody else moved the arm?
  let last = "";
  const marks = () => [...LINKS.map((i) => node("arm", i)), node("notes", "target")].filter(Boolean).map((n) => n.object);
  const signature = () => marks().map((o) => `${o.position.toArray()} ${o.quaternion.toArray()}`).join() + node("arm").object.ellipse + kept();
  function follow() {
    if (gone) return carryFrames();
    if (!node("arm", TIP) || dragging()) return;
    const now = signature();
    if (now === last) return;
    last = now;
    const target = node("notes", "target")?.object;
    q = aim = A.joints([0, ...LINKS].map((i) => matrix(node("arm", i).object)), about);
    asked = target ? task.of(matrix(target)) : A.pose(q, about);
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
    rope.visible = false;
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
  function ray({ clientX, clientY }) {
    const box = canvas.getBoundingClientRect();
    return cast({ x: 2 * (clientX - box.left) / box.width - 1, y: 1 - 2 * (clientY - box.top) / box.height });
  }
  function cast(place) { // a place in the picture: from -1 to 1, y upwards
    caster.setFromCamera(place, viewer.camera);
    const local = caster.ray.clone().applyMatrix4(new THREE.Matrix4().copy(node().object.matrixWorld).invert());
    return { origin: local.origin.multiplyScalar(1e3), direction: local.direction.normalize() };
  }

  function under(event) {
    ray(event);
    const hit = (list) => caster.intersectObjects(list, false)[0]?.object.userData;
    return (on && (hit(front) || hit(targets))) || linkUnder();
  }

  // The foremost piece of the arm, if it is a link that moves; `ray` has aimed.
  function linkUnder() {
    const bodies = [0, ...LINKS].map((i) => node("arm", i)?.object).filter(Boolean);
    const hit = caster.intersectObjects(bodies, true).find(({ object }) => object.isMesh);
    if (!hit) return null;
    let body = hit.object;
    while (!bodies.includes(body)) body = body.parent;
    const link = bodies.indexOf(body), mm = (object) => object.worldToLocal(hit.point.clone()).multiplyScalar(1e3).toArray();
    return link > 0 ? { name: "link", link, point: mm(body), start: mm(node().object) } : null;
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
    const line = ray(event), from = vector(grip.start), { turn } = grip;
    if (turn && grip.edge) { // the ring is seen from its edge: along it, and as far as a point of its near side goes
      const t = along(turn.axle.clone().cross(grip.facing).normalize(), from, line);
      return t === null ? {} : { turned: -t / (1e3 * RING * scale) };
    }
    if (turn) {
      const arm = meet(turn.axle, from, line)?.sub(from);
      return arm ? { turned: Math.atan2(arm.dot(turn.v), arm.dot(turn.u)) } : {};
    }
    if (grip.name === "all") return { moved: meet(grip.facing, from, line) };
    const axis = new THREE.Vector3().setComponent("xyz".indexOf(grip.name), 1), t = along(axis, from, line);
    return { moved: t === null ? null : axis.multiplyScalar(t) };
  }

  window.addEventListener("pointerdown", (event) => {
    if (event.target !== canvas || event.button > 0) return;
    if (grip?.down) return event.stopImmediatePropagation(); // a second finger
    const hit = q && under(event);
    if (!hit) return;
    event.stopImmediatePropagation(); // the camera stays
    event.preventDefault();
    if (viewer.animator.playing) viewer.animator.pause();
    viewer.controls.enabled = false;
    const facing = cast({ x: 0, y: 0 }).direction, turn = turnsOf(asked)[hit.ring];
    grip = { start: position().toArray(), ...hit, asked, turn, facing, id: event.pointerId, down: event, edge: turn && Math.abs(turn.axle.dot(facing)) < 0.2 };
    grip.zero = hit.name !== "link" && measure(event);
    canvas.setPointerCapture(event.pointerId);
    canvas.style.cursor = "grabbing";
    draw();
  }, { capture: true });

  window.addEventListener("pointermove", (event) => {
    if (!grip) {
      if (event.target === canvas && !event.buttons) hover(under(event));
      return;
    }
    if (event.pointerId !== grip.id) return;
    event.stopImmediatePropagation();
    const { name, zero, start, down, turn } = grip;
    if (!grip.moved && name === "link" && Math.hypot(event.clientX - down.clientX, event.clientY - down.clientY) < SLOP) return;
    grip.moved = true;
    if (name === "link") return pullTo(ray(event));
    const { moved, turned } = measure(event), to = moved && zero.moved && moved.sub(zero.moved).add(vector(start)).toArray();
    if (to) move(task.placed(grip.asked, to));
    else if (turn && turned !== undefined && zero.turned !== undefined) move(task.turned(grip.asked, turn, turned - zero.turned));
  }, { capture: true });

  function pullTo({ origin, direction }) {
    const { link, point } = grip, got = A.pull(aim, link, point, origin.toArray(), about, direction.toArray());
    pulled(link > 1 ? got : { ...got, verdict: got.broken ? got.verdict : "" }); // one joint alone seldom leads under the hand
    [asked, wanted] = [A.pose(aim, about), false];
    if (!rope.parent) node().object.add(rope);
    rope.visible = true;
    fist.position.copy(vector(A.applied(A.frames(aim, about)[link], point))).multiplyScalar(1e-3);
    thread.geometry.setFromPoints([fist.position, fist.position.clone().addScaledVector(vector(got.miss), 1e-3)]);
    show();
  }

  for (const name of ["pointerup", "pointercancel"]) {
    window.addEventListener(name, (event) => {
      if (!grip || event.pointerId !== grip.id) return;
      event.stopImmediatePropagation();
      canvas.style.cursor = "";
      if (grip.name === "link" && !grip.moved) [grip, viewer.controls.enabled] = [null, true];
      else release();
    }, { capture: true });
  }

  let lit = null;
  function hover(hit) {
    canvas.style.cursor = hit ? "grab" : "";
    if ((hit?.mesh ?? null) === lit) return;
    if (lit) lit.material.opacity = 0.9;
    lit = hit?.mesh ?? null;
    if (lit) lit.material.opacity = 0.55;
    viewer.set_dirty();
  }

  // ---- keyboard ----------------------------------------------------------------------------------------------------------

  const gripBox = document.createElement("div");
  gripBox.id = "omx-grip";
  gripBox.tabIndex = 0;
  gripBox.setAttribute("role", "application");
  const TURNS = { PITCH: "plus and minus turn the pitch; ", HAND: "x, y and z choose an axis, plus and minus turn about it; " };
  gripBox.setAttribute("aria-label", `The ${task.who.toLowerCase()}. Arrow keys move it in x and y, Page Up and Page Down in z; ` +
    `${["", TURNS.PITCH][rings.length] ?? TURNS.HAND}with Shift ten times as far.`);
  document.body.append(gripBox);
  const KEYS = { ArrowUp: [1, 0, 0], ArrowDown: [-1, 0, 0], ArrowLeft: [0, 1, 0], ArrowRight: [0, -1, 0], PageUp: [0, 0, 1], PageDown: [0, 0, -1] };
  const SIGNS = { "+": 1, "=": 1, "*": 1, "-": -1, _: -1 };
  let axle = rings.length - 1; // about which plus and minus turn
  gripBox.addEventListener("keydown", (event) => {
    const step = KEYS[event.key], sign = rings.length && SIGNS[event.key], chosenAxle = rings.length === 3 ? "xyz".indexOf(event.key.toLowerCase()) : -1;
    if (!(step || sign || chosenAxle >= 0) || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault();
    event.stopPropagation();
    if (chosenAxle >= 0) {
      axle = chosenAxle;
      said.textContent = `Plus and minus turn about ${"xyz"[axle]}.`;
      hover({ mesh: rings[axle].circle });
      return;
    }
    if (viewer.animator.playing) viewer.animator.pause();
    const far = event.shiftKey ? 10 : 1;
    grip ??= { name: "key" };
    if (step) move(task.placed(asked, position().toArray().map((v, i) => Math.round(v) + far * step[i])));
    else move(task.turned(asked, task.rings(asked)[axle], far * sign * A.DEG));
    clearTimeout(gripBox.end);
    gripBox.end = setTimeout(release, 120);
  });

  function placeGrip() {
    if (!on || !asked) return;
    const at = position().multiplyScalar(1e-3).applyMatrix4(node().object.matrixWorld).project(viewer.camera);
    gripBox.style.left = `${50 + 50 * at.x}%`;
    gripBox.style.top = `${50 - 50 * at.y}%`;
  }

  // ---- words -------------------------------------------------------------------------------------------------------------

  const note = document.createElement("p"), said = document.createElement("p");
  note.id = "omx-note";
  note.hidden = true; // until it has words
  note.setAttribute("aria-hidden", "true"); // the sentence says it, too
  said.id = "omx-words";
  document.body.append(note, said);

  function problem() {
    if (refused()) {
      const near = closest();
      return near.reachable ? `${near.broken.map(A.words).join("; ")} (${near.name})` : near.verdict;
    }
    return stopped || (q ? A.touching(q, about) : "");
  }
  const fault = () => (refused() ? "the arm stays: " : stopped ? "the arm comes no nearer: " : "");

  function warn() {
    const words = fault() + problem();
    note.textContent = words && `${words[0].toUpperCase()}${words.slice(1)}.`;
    note.hidden = !words;
  }

  function branchOf(values) {
    const way = (s) => s.q.reduce((sum, v, i) => sum + A.turn(v - values[i]) ** 2, 0);
    return A.branches(A.pose(values, about), about).filter((s) => s.reachable).sort((a, b) => way(a) - way(b))[0];
  }

  function sentence() {
    const [x, y, z, ...angles] = task.values(A.pose(q, about)).map((v, i) => `${task.names[i]} = ${A.text(v, 1)}`);
    const where = `${task.who} at ${x}, ${y}, ${[`${z} mm`, ...angles.map((angle) => `${angle}\u00b0`)].join(", ")}`;
    const broken = A.violations(q, about).map(A.words).join("; "), clear = about.parts ? ", touching nothing" : "";
    const branch = branchOf(q), verdict = fault() + problem() || broken || `within its limits${clear}`;
    return `${where}; ${branch ? `${branch.name}; ` : ""}${verdict}.`;
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

  // ---- another arm -------------------------------------------------------------------------------------------------------

  // The page around has another arm and, if they were derived, its formulas. `about` null: it cannot be led by hand here.
  let gone = false;
  stage.said.arm = (told) => {
    A.learn(told.modules);
    gone = !told.about || told.about.rows.length !== TIP || A.task(told.about) !== task;
    if (!gone) Object.assign(about, told.about);
    else [q, found, chosen, note.hidden] = [null, [], null, true];
    button.hidden = gone;
    if (gone) offer(false);
    ghosts?.root.removeFromParent();
    ghosts = null;
    last = "";
    viewer.set_dirty();
  };

  // ---- on and off ----------------------------------------------------------------------------------------------------------

  let on = false;
  const button = stage.button("tool", "Drag the tool", () => offer(!on));
  function offer(shown) {
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
  stage.tool = { offer, move: (target) => { grip = { name: "code" }; move(target); release(); }, state: () => ({ q, asked, found, chosen, on, stopped }) };
  offer(Boolean(about.handle));
})();
