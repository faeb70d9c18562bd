// Where the marks of a DH row stand: `places` of omx/display/viewer/dh_row_view.py once more, for pages without Python. Lengths in mm,
// angles in rad; a matrix is a list of rows.
(function () {
  "use strict";
  const { link, product } = window.OMX_ARM;
  const ARC = 75, HEAD = 10.4, ROD = 100, PIECES = [128, 64, 32, 16, 8, 4, 2, 1];
  const FLIP = diagonal(1, -1, -1);
  const ALONG_X = [[0, 0, 1, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1]];
  const ABOUT_X = [[0, 0, 1, 0], [0, -1, 0, 0], [1, 0, 0, 0], [0, 0, 0, 1]];

  function diagonal(x, y, z) { return [[x, 0, 0, 0], [0, y, 0, 0], [0, 0, z, 0], [0, 0, 0, 1]]; }
  function shift(x, y, z) { return [[1, 0, 0, x], [0, 1, 0, y], [0, 0, 1, z], [0, 0, 0, 1]]; }
  function turn(angle) { return link(angle, 0, 0, 0); }
  // An arrow along z of `frame`: its rod is stretched, its head is pushed to the end.
  function arrow(name, frame, length) {
    const head = Math.min(0.4 * Math.abs(length), HEAD), rod = Math.max(Math.abs(length) - head, 1e-3);
    return {
      [name]: length > 0 ? frame : product(frame, FLIP),
      [`${name}/rod`]: diagonal(1, 1, rod / ROD),
      [`${name}/head`]: product(shift(0, 0, rod), diagonal(1, 1, Math.max(head, 1e-3) / HEAD)),
    };
  }

  // An arc about z of `frame`, from its x on: whole pieces one after the other, and a head.
  function arc(name, frame, angle) {
    const size = Math.abs(angle), middle = 1.18 * ARC;
    const nodes = { [name]: angle > 0 ? frame : product(frame, FLIP) };
    nodes[`${name}/to`] = nodes[`${name}/head`] = turn(size);
    nodes[`${name}/name`] = shift(middle * Math.cos(size / 2), middle * Math.sin(size / 2), 0);
    let start = 0;
    for (const piece of PIECES) {
      nodes[`${name}/${piece}`] = turn(start * Math.PI / 180);
      start += degrees(angle) & piece;
    }
    return nodes;
  }

  // Of how many whole degrees an arc is, when its head takes the last two.
  function degrees(angle) { return Math.max(0, Math.floor(Math.abs(angle) * 180 / Math.PI + 1e-9) - 2); }

  // Where each mark of the row stands, by its name, and which are shown.
  function places(theta, d, a, alpha) {
    const lifted = link(theta, d, 0, 0), shifted = link(theta, d, a, 0), end = link(theta, d, a, alpha);
    const nodes = { next_axis: end, last: end }, shown = {};
    for (const [name, frame, length] of [["d", diagonal(1, 1, 1), d], ["a", product(lifted, ALONG_X), a]]) {
      Object.assign(nodes, arrow(name, frame, length));
      shown[name] = shown[`${name}_name`] = Math.abs(length) >= 1;
    }
    const middle = (T, U) => [0, 1, 2].map((i) => 0.5 * (T[i][3] + U[i][3]));
    const [x, y, z] = middle(diagonal(1, 1, 1), lifted), [u, v, w] = middle(lifted, shifted);
    nodes.d_name = shift(x - 14, y - 14, z);
    nodes.a_name = shift(u, v, w + 13);
    for (const [name, frame, turned] of [["theta", diagonal(1, 1, 1), theta], ["alpha", product(shifted, ABOUT_X), alpha]]) {
      const angle = Math.atan2(Math.sin(turned), Math.cos(turned));
      Object.assign(nodes, arc(name, frame, angle));
      shown[name] = Math.abs(angle) > 0.02;
      shown[`${name}/head`] = Math.abs(angle) > 0.1;
      for (const piece of PIECES) shown[`${name}/${piece}`] = Boolean(degrees(angle) & piece);
    }
    return { nodes, shown };
  }

  window.OMX_ROW = { places };
})();
