// The marks of a DH row in a page without Python: what dh_row_view.py draws, here for the row that the page around tells.
// Lengths in mm, angles in rad; a matrix is a list of rows.
(function () {
  "use strict";
  const about = window.OMX_CONFIG?.row, stage = window.omxScene, viewer = stage?.viewer;
  if (!about || !viewer) return;
  const { link, product, columns, IDENTITY } = window.OMX_ARM, { THREE } = MeshCat;
  const ALONG_X = [[0, 0, 1, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1]];
  const ABOUT_X = [[0, 0, 1, 0], [0, -1, 0, 0], [1, 0, 0, 0], [0, 0, 0, 1]];

  function mesh(geometry, color) {
    const out = new THREE.Mesh(geometry, new THREE.MeshBasicMaterial({ color, depthTest: false, depthWrite: false, transparent: true }));
    out.renderOrder = 11;
    return out;
  }

  // An arrow along z.
  function arrow(length) {
    const head = Math.min(0.4 * length, 10.4), rod = length - head;
    return [mesh(new THREE.CylinderGeometry(1.6, 1.6, rod, 12).rotateX(Math.PI / 2).translate(0, 0, rod / 2), about.along),
      mesh(new THREE.ConeGeometry(4.16, head, 16).rotateX(Math.PI / 2).translate(0, 0, rod + head / 2), about.along)];
  }

  // An arc about z, from x on, between two thin lines.
  function arc(angle) {
    const R = about.arc, rest = Math.max(angle - 4.4 / R, 0.02);
    const line = (at) => mesh(new THREE.CylinderGeometry(0.6, 0.6, 1.1 * R, 8).rotateZ(-Math.PI / 2).translate(0.55 * R, 0, 0).rotateZ(at), about.pale);
    const head = angle > 0.1 ? [mesh(new THREE.ConeGeometry(2.64, 4.4, 16).translate(R, -2.2, 0).rotateZ(angle), about.about)] : [];
    return [line(0), line(angle), mesh(new THREE.TorusGeometry(R, 1.1, 8, 64, rest), about.about), ...head];
  }

  function mark(name, size, parts, frame, middle) {
    const group = new THREE.Group(), T = IDENTITY.map((row, i) => [...row.slice(0, 3), middle[i] ?? 1]);
    for (const part of parts) group.add(part);
    group.scale.setScalar(1e-3);
    if (size < 0) group.rotation.x = Math.PI;
    viewer.scene_tree.find(["meshcat", "notes", name, "<object>"]).set_object(group);
    for (const [path, place] of [[name, frame], [`${name}_name`, T]]) {
      viewer.set_transform(["meshcat", "notes", path], columns(place));
      viewer.set_property(["meshcat", "notes", path], "visible", parts.length > 0);
    }
  }

  stage.said.row = ({ row }) => {
    const [theta, d, a, alpha] = row, lifted = link(theta, d, 0, 0), shifted = link(theta, d, a, 0);
    for (const name of ["last", "next_axis"]) viewer.set_transform(["meshcat", "notes", name], columns(link(...row)));
    const [x, y, z] = [0, 1, 2].map((i) => lifted[i][3]), [u, v, w] = [0, 1, 2].map((i) => shifted[i][3]);
    const lengths = [["d", d, IDENTITY, [x / 2 - 14, y / 2 - 14, z / 2]],
      ["a", a, product(lifted, ALONG_X), [(x + u) / 2, (y + v) / 2, (z + w) / 2 + 13]]];
    for (const [name, length, ...where] of lengths) mark(name, length, Math.abs(length) < 1 ? [] : arrow(Math.abs(length)), ...where);
    for (const [name, value, frame] of [["theta", theta, IDENTITY], ["alpha", alpha, product(shifted, ABOUT_X)]]) {
      const angle = Math.atan2(Math.sin(value), Math.cos(value)), [p, q] = [Math.cos(angle / 2), Math.sin(angle / 2)];
      const middle = [0, 1, 2].map((i) => 1.18 * about.arc * (p * frame[i][0] + q * frame[i][1]) + frame[i][3]);
      mark(name, angle, Math.abs(angle) < 0.02 ? [] : arc(Math.abs(angle)), frame, middle);
    }
    viewer.set_dirty();
  };
})();
