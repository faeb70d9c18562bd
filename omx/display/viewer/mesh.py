"""Solids made of a few bevelled primitives, merged into one mesh of triangles with a colour each vertex.

Lengths in mm. A link of the arm is one such mesh: one draw call, however many screws it has. The narrow
bevels take their normals from the faces on both sides, so edges catch the light as machined ones do.
"""

import math

import numpy as np

AXES = {"x": 0, "y": 1, "z": 2}


class Solid:
    """Triangles collected from primitives; each method adds one and returns the solid, for chaining."""

    def __init__(self):
        self._points: list = []
        self._normals: list = []
        self._colours: list = []
        self._faces: list = []
        self._detail: list[bool] = []

    def box(self, low, high, colour, bevel: float = 0.8) -> "Solid":
        """A box between two opposite corners `low` and `high` (3,), its edges cut by `bevel`."""
        low, high = np.minimum(low, high).astype(float), np.maximum(low, high).astype(float)
        bevel = min(bevel, 0.45 * float((high - low).min()))
        points, normals = [], []
        for corner in np.ndindex(2, 2, 2):
            outer, sign = np.where(corner, high, low), np.where(corner, 1.0, -1.0)
            for axis in range(3):
                cut = sign * bevel
                cut[axis] = 0.0
                points.append(outer - cut)
                normals.append(sign * (np.arange(3) == axis))
        return self.triangles(points, normals, colour, _BOX_FACES)

    def prism(self, outline, low: float, high: float, colour, axis: str = "z", bevel: float = 0.6) -> "Solid":
        """A convex `outline` (n, 2), anticlockwise and rounded, extruded along `axis` from `low` to `high`.

        The outline's two coordinates are the two that follow `axis` in the order x, y, z, x, y.
        """
        outline = np.asarray(outline, dtype=float)
        n, bevel = len(outline), min(bevel, 0.45 * (high - low))
        side = _outline_normals(outline)
        inner, up = outline - bevel * side, np.ones(n)
        flat = np.zeros((n, 2))
        points = [np.column_stack(c) for c in ((inner, low * up), (outline, (low + bevel) * up),
                                               (outline, (high - bevel) * up), (inner, high * up))]  # fmt: skip
        normals = [np.column_stack(c) for c in ((flat, -up), (side, 0 * up), (side, 0 * up), (flat, up))]
        order = [(AXES[axis] + 1) % 3, (AXES[axis] + 2) % 3, AXES[axis]]
        back = np.argsort(order)
        return self.triangles(np.vstack(points)[:, back], np.vstack(normals)[:, back], colour, _prism_faces(n))

    def disc(self, centre, radius: float, low: float, high: float, colour, axis="z", sides=28, bevel=0.6) -> "Solid":
        """A round disc or rod about the line through `centre` (2,) along `axis`, from `low` to `high`."""
        return self.prism(circle(radius, sides, centre), low, high, colour, axis, bevel)

    def stud(self, centre, radius, low, high, colour, axis="z", up=1, sides=8, detail=True) -> "Solid":
        """A screw or a horn on a face: like `disc`, but without its hidden end; a `silhouette` leaves details out.

        It stands on `low` and ends at `high`; with `up` = -1 it stands on `high` and ends at `low`.
        """
        n, side = sides, circle(1.0, sides)
        rim = np.asarray(centre) + radius * side
        foot, head = (low, high) if up > 0 else (high, low)
        order = [(AXES[axis] + 1) % 3, (AXES[axis] + 2) % 3, AXES[axis]]
        back = np.argsort(order)
        points = np.vstack([np.column_stack((rim, np.full(n, h))) for h in (foot, head)])[:, back]
        normals = np.vstack((np.column_stack((side, np.zeros(n))), np.tile((0.0, 0.0, up), (n, 1))))[:, back]
        i, k = np.arange(n), np.arange(1, n - 1)
        j = (i + 1) % n
        faces = np.vstack((np.column_stack((i, j, n + j)), np.column_stack((i, n + j, n + i)),
                           np.column_stack((0 * k, k, k + 1)) + n))  # fmt: skip
        return self.triangles(points, normals, colour, faces if up > 0 else faces[:, ::-1], detail)

    def triangles(self, points, normals, colour, faces, detail: bool = False) -> "Solid":
        """Triangles as they are: points and normals (n, 3), faces (m, 3), anticlockwise seen from outside."""
        points = np.asarray(points, dtype=float)
        colours = np.tile(np.array(colour, dtype=np.uint8), (len(points), 1))
        self._append(points, np.asarray(normals, dtype=float), colours, np.asarray(faces), detail)
        return self

    def add(self, other: "Solid", matrix=None) -> "Solid":
        """Add another solid, moved by a rigid 4x4 `matrix`."""
        rotation, shift = (np.eye(3), 0.0) if matrix is None else (matrix[:3, :3], matrix[:3, 3])
        for points, normals, colours, faces, detail in other._parts():
            self._append(points @ rotation.T + shift, normals @ rotation.T, colours, faces, detail)
        return self

    def silhouette(self, colour) -> "Solid":
        """A copy in one colour and without its screws, for a ghost."""
        out = Solid()
        for points, normals, colours, faces, detail in self._parts():
            if not detail:
                out._append(points, normals, np.broadcast_to(np.uint8(colour), colours.shape), faces, False)
        return out

    def moved(self, matrix) -> "Solid":
        """A copy moved by a rigid 4x4 `matrix` (mm)."""
        return Solid().add(self, matrix)

    def arrays(self):
        """`(points, unit, normals, colours, index)` as small integers; `points * unit` are metres.

        Points (n, 3) int16, normals (n, 3) int8, colours (n, 3) uint8, index (m,) uint16 (uint32 if need be).
        """
        points, normals, colours, faces = self._stacked()
        unit = max(float(np.abs(points).max()), 1e-6) * 1e-3 / 32767
        points = np.rint(points * (1e-3 / unit)).astype(np.int16)
        index = faces.ravel().astype(np.uint16 if len(points) < 65536 else np.uint32)
        return points, unit, np.rint(normals * 127).astype(np.int8), colours, index

    def bounds(self):
        """The box around the solid, mm: two corners (3,)."""
        points = self._stacked()[0]
        return points.min(axis=0), points.max(axis=0)

    def _append(self, points, normals, colours, faces, detail) -> None:
        for kept, new in ((self._points, points), (self._normals, normals), (self._colours, colours),
                          (self._faces, faces), (self._detail, detail)):  # fmt: skip
            kept.append(new)

    def _parts(self):
        return list(zip(self._points, self._normals, self._colours, self._faces, self._detail, strict=True))

    def _stacked(self):
        first = np.cumsum([0] + [len(p) for p in self._points[:-1]])
        faces = np.concatenate([f + n for f, n in zip(self._faces, first, strict=True)])
        return *(np.concatenate(a) for a in (self._points, self._normals, self._colours)), faces


def circle(radius: float, sides: int = 28, centre=(0.0, 0.0)):
    """A circle as an outline (sides, 2)."""
    angle = np.arange(sides) * (2 * math.pi / sides)
    return np.column_stack((np.cos(angle), np.sin(angle))) * radius + np.asarray(centre)


def slot(start, end, radius: float, sides: int = 10, end_radius: float | None = None):
    """Two half circles about `start` and `end` (2,), joined: the outline of a link or of a rounded plate."""
    start, end = np.asarray(start, float), np.asarray(end, float)
    heading = math.atan2(*(end - start)[::-1])
    outline = []
    for centre, r, first in ((end, end_radius or radius, -0.5), (start, radius, 0.5)):
        angle = heading + math.pi * (first + np.arange(sides + 1) / sides)
        outline.append(centre + r * np.column_stack((np.cos(angle), np.sin(angle))))
    return np.vstack(outline)


def _outline_normals(outline):
    edge = np.roll(outline, -1, 0) - outline
    edge /= np.linalg.norm(edge, axis=1, keepdims=True)
    mean = edge + np.roll(edge, 1, 0)
    mean /= np.linalg.norm(mean, axis=1, keepdims=True)
    return np.column_stack((mean[:, 1], -mean[:, 0]))


def _prism_faces(n: int):
    i = np.arange(n)
    j = (i + 1) % n
    faces = []
    for ring in range(3):
        a, b = ring * n, (ring + 1) * n
        faces += [np.column_stack((a + i, a + j, b + j)), np.column_stack((a + i, b + j, b + i))]
    k = np.arange(1, n - 1)
    faces += [np.column_stack((0 * k, k + 1, k)), np.column_stack((0 * k, k, k + 1)) + 3 * n]
    return np.vstack(faces)


def _box_faces():
    """Six faces, twelve bevels and eight corners, over 24 vertices numbered 3 * corner + axis of the normal."""

    def vertex(corner, axis):
        return 3 * (4 * corner[0] + 2 * corner[1] + corner[2]) + axis

    def corners(fixed):
        free = [a for a in range(3) if a not in fixed]
        for bits in np.ndindex(*(2,) * len(free)):
            corner = dict(fixed) | dict(zip(free, bits, strict=True))
            yield [corner[a] for a in range(3)]

    patches = []
    for axis in range(3):
        for side in (0, 1):
            a, b, c, d = corners({axis: side})
            patches.append([vertex(k, axis) for k in (a, b, d, c)])
    for one, two in ((0, 1), (1, 2), (0, 2)):
        for bits in np.ndindex(2, 2):
            a, b = corners({one: bits[0], two: bits[1]})
            patches.append([vertex(a, one), vertex(b, one), vertex(b, two), vertex(a, two)])
    for corner in np.ndindex(2, 2, 2):
        patches.append([vertex(corner, axis) for axis in range(3)])
    return _outward(patches)


def _outward(patches):
    """Split patches of box vertices into triangles, each anticlockwise seen from outside."""
    centres = np.array([np.where(c, 1.0, -1.0) for c in np.ndindex(2, 2, 2) for _ in range(3)])
    centres += 0.5 * np.tile(np.eye(3), (8, 1)) * np.sign(centres)
    faces = []
    for patch in patches:
        for k in range(1, len(patch) - 1):
            a, b, c = patch[0], patch[k], patch[k + 1]
            normal = np.cross(centres[b] - centres[a], centres[c] - centres[a])
            faces.append((a, b, c) if normal @ centres[[a, b, c]].sum(axis=0) > 0 else (a, c, b))
    return np.array(faces)


_BOX_FACES = _box_faces()
