"""Solids made of a few bevelled or round primitives, merged into one mesh of triangles with a colour each vertex.

Lengths in mm. A link of the arm is one such mesh: one draw call, however many screws it has. The narrow
bevels take their normals from the faces on both sides, so edges catch the light as machined ones do.
"""

import math

import numpy as np


class Solid:
    """Triangles collected from primitives; each method adds one and returns the solid, for chaining."""

    def __init__(self):
        #: Points, normals and colours (n, 3), faces (m, 3), and whether a silhouette leaves them out.
        self._parts: list[tuple] = []

    def box(self, low, high, colour, bevel: float = 0.8) -> "Solid":
        """A box between two opposite corners `low` and `high` (3,), its edges cut by `bevel`."""
        low, high = np.minimum(low, high).astype(float), np.maximum(low, high).astype(float)
        bevel = min(bevel, 0.45 * float((high - low).min()))
        (x, y, _), (X, Y, _) = low + bevel, high - bevel
        side = np.repeat([(1, 0), (0, 1), (-1, 0), (0, -1)], 2, axis=0)
        corners = np.array([(X, y), (X, Y), (X, Y), (x, Y), (x, Y), (x, y), (x, y), (X, y)])
        return self._extruded(corners + bevel * side, side, low[2], high[2], colour, "z", bevel)

    def prism(self, outline, low: float, high: float, colour, axis: str = "z", bevel: float = 0.6) -> "Solid":
        """A convex `outline` (n, 2), anticlockwise and rounded, extruded along `axis` from `low` to `high`.

        The outline's two coordinates are the two that follow `axis` in the order x, y, z, x, y.
        """
        outline = np.asarray(outline, dtype=float)
        bevel = min(bevel, 0.45 * (high - low))
        return self._extruded(outline, _outline_normals(outline), low, high, colour, axis, bevel)

    def _extruded(self, outline, side, low: float, high: float, colour, axis: str, bevel: float) -> "Solid":
        """A prism whose `outline` (n, 2) has the normals `side` (n, 2): four rings of points, and two ends."""
        inner, up, flat = outline - bevel * side, np.ones(len(outline)), np.zeros_like(outline)
        rings = ((inner, low), (outline, low + bevel), (outline, high - bevel), (inner, high))
        points = np.vstack([np.column_stack((ring, height * up)) for ring, height in rings])
        normals = np.vstack([np.column_stack(c) for c in ((flat, -up), (side, 0 * up), (side, 0 * up), (flat, up))])
        end = _end(len(outline))
        faces = np.vstack((_walls(4, len(outline)), end[:, ::-1], end + 3 * len(outline)))
        return self.triangles(_along(axis, points), _along(axis, normals), colour, faces)

    def disc(self, centre, radius: float, low: float, high: float, colour, axis="z", sides=28, bevel=0.6) -> "Solid":
        """A round disc or rod about the line through `centre` (2,) along `axis`, from `low` to `high`."""
        return self.prism(circle(radius, sides, centre), low, high, colour, axis, bevel)

    def stud(self, centre, radius, low, high, colour, axis="z", up=1, sides=8, detail=True) -> "Solid":
        """A screw or a horn on a face: like `disc`, but without its hidden end; a `silhouette` leaves details out.

        It stands on `low` and ends at `high`; with `up` = -1 it stands on `high` and ends at `low`.
        """
        side, up_there = circle(1.0, sides), np.ones(sides)
        rim = np.asarray(centre) + radius * side
        foot, head = (low, high) if up > 0 else (high, low)
        points = np.vstack([np.column_stack((rim, height * up_there)) for height in (foot, head)])
        normals = np.vstack((np.column_stack((side, 0 * up_there)), np.tile((0.0, 0.0, up), (sides, 1))))
        faces = np.vstack((_walls(2, sides), _end(sides) + sides))
        faces = faces if up > 0 else faces[:, ::-1]
        return self.triangles(_along(axis, points), _along(axis, normals), colour, faces, detail)

    def triangles(self, points, normals, colour, faces, detail: bool = False) -> "Solid":
        """Triangles as they are: points and normals (n, 3), faces (m, 3), anticlockwise seen from outside."""
        points = np.asarray(points, dtype=float)
        colours = np.tile(np.array(colour, dtype=np.uint8), (len(points), 1))
        self._parts.append((points, np.asarray(normals, dtype=float), colours, np.asarray(faces), detail))
        return self

    def add(self, other: "Solid", matrix=None) -> "Solid":
        """Add another solid, moved by a rigid 4x4 `matrix`."""
        rotation, shift = (np.eye(3), 0.0) if matrix is None else (matrix[:3, :3], matrix[:3, 3])
        for points, normals, *rest in other._parts:
            self._parts.append((points @ rotation.T + shift, normals @ rotation.T, *rest))
        return self

    def silhouette(self, colour) -> "Solid":
        """A copy in one colour and without its screws, for a ghost."""
        out = Solid()
        for points, normals, colours, faces, detail in self._parts:
            if not detail:
                out._parts.append((points, normals, np.broadcast_to(np.uint8(colour), colours.shape), faces, False))
        return out

    def moved(self, matrix) -> "Solid":
        """A copy moved by a rigid 4x4 `matrix` (mm)."""
        return Solid().add(self, matrix)

    def arrays(self):
        """`(points, unit, normals, colours, index)` as small integers; `points * unit` are metres.

        Points (n, 3) int16, normals (n, 3) int8, colours (n, 3) uint8, index (m,) uint16 (uint32 if need be).
        """
        points, normals, colours, faces, _ = zip(*self._parts, strict=True)
        first = np.cumsum([0, *map(len, points[:-1])])
        faces = np.concatenate([f + n for f, n in zip(faces, first, strict=True)])
        points, normals, colours = map(np.concatenate, (points, normals, colours))
        unit = max(float(np.abs(points).max()), 1e-6) * 1e-3 / 32767
        points = np.rint(points * (1e-3 / unit)).astype(np.int16)
        index = faces.ravel().astype(np.uint16 if len(points) < 65536 else np.uint32)
        return points, unit, np.rint(normals * 127).astype(np.int8), colours, index


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


def tube(points, radius: float, colour, sides: int = 8, closed: bool = False) -> Solid:
    """A round tube along the polyline `points` (n, 3), mm."""
    points = np.asarray(points, dtype=float)
    ahead = np.gradient(points, axis=0) if not closed else np.roll(points, -1, 0) - np.roll(points, 1, 0)
    ahead /= np.maximum(np.linalg.norm(ahead, axis=1, keepdims=True), 1e-12)
    normals = _around(ahead, sides)
    rings = points[:, None] + radius * normals
    faces = _walls(len(points), sides, closed)
    return Solid().triangles(rings.reshape(-1, 3), normals.reshape(-1, 3), colour, faces)


def cone(start, end, radius: float, colour, sides: int = 16, end_radius: float = 0.0) -> Solid:
    """A cone from a disc of `radius` about `start` to `end` (3,), mm; a rod if `end_radius` equals `radius`."""
    start, end = np.asarray(start, float), np.asarray(end, float)
    ahead = (end - start) / np.linalg.norm(end - start)
    out = _around(ahead[None], sides)[0]
    points = np.tile(np.vstack((start + radius * out, end + end_radius * out)), (2, 1))
    normals = np.vstack((out, out, np.tile(-ahead, (sides, 1)), np.tile(ahead, (sides, 1))))
    faces = np.vstack((_walls(2, sides), _end(sides)[:, ::-1] + 2 * sides, _end(sides) + 3 * sides))
    return Solid().triangles(points, normals, colour, faces)


def ball(centre, radius: float, colour, rings: int = 12) -> Solid:
    """A sphere, mm."""
    lat = np.linspace(-math.pi / 2, math.pi / 2, rings + 1)[:, None]
    level = np.tile(circle(1.0, 2 * rings), (rings + 1, 1, 1))
    out = np.dstack((np.cos(lat)[:, None] * level, np.tile(np.sin(lat), 2 * rings))).reshape(-1, 3)
    return Solid().triangles(np.asarray(centre) + radius * out, out, colour, _walls(rings + 1, 2 * rings))


def _along(axis: str, points):
    """Points (n, 3), two coordinates of an outline and a height, with the height along `axis`."""
    return np.roll(points, "xyz".index(axis) + 1, axis=1)


def _around(ahead, sides: int):
    """Unit vectors (n, sides, 3) around each direction of `ahead` (n, 3)."""
    across = _perpendicular(ahead)
    u, v = circle(1.0, sides).T[..., None]
    return across[:, None] * u + np.cross(ahead, across)[:, None] * v


def _perpendicular(ahead):
    """One unit vector across each of `ahead` (n, 3), turning as little as possible from one to the next."""
    across = np.empty_like(ahead)
    previous = np.eye(3)[np.argmin(np.abs(ahead[0]))]
    for i, a in enumerate(ahead):
        v = previous - a * (a @ previous)
        size = math.sqrt(v @ v)
        previous = across[i] = v / size if size > 1e-9 else across[i - 1]
    return across


def _walls(rings: int, sides: int, closed: bool = False):
    """Triangles between each ring of points and the next; if `closed`, between the last and the first, too."""
    rows = np.arange(rings if closed else rings - 1)
    a, i = rows[:, None] * sides, np.arange(sides)
    b, j = ((rows[:, None] + 1) % rings) * sides, (i + 1) % sides
    quads = np.stack((a + i, a + j, b + j, a + i, b + j, b + i), axis=-1)
    return quads.reshape(-1, 3)


def _end(sides: int):
    """Triangles that fill a ring of points."""
    k = np.arange(1, sides - 1)
    return np.column_stack((0 * k, k, k + 1))
