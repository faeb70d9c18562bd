"""Round solids: tubes along a line, cones and rods, balls. Lengths in mm."""

import math

import numpy as np

from .mesh import Solid


def tube(points, radius: float, colour, sides: int = 8, closed: bool = False) -> Solid:
    """A round tube along the polyline `points` (n, 3), mm."""
    points = np.asarray(points, dtype=float)
    ahead = np.gradient(points, axis=0) if not closed else np.roll(points, -1, 0) - np.roll(points, 1, 0)
    ahead /= np.maximum(np.linalg.norm(ahead, axis=1, keepdims=True), 1e-12)
    across = _perpendicular(ahead)
    other = np.cross(ahead, across)
    angle = np.arange(sides) * (2 * math.pi / sides)
    normals = across[:, None] * np.cos(angle)[:, None] + other[:, None] * np.sin(angle)[:, None]
    rings = points[:, None] + radius * normals
    return Solid().triangles(
        rings.reshape(-1, 3), normals.reshape(-1, 3), colour, _tube_faces(len(points), sides, closed)
    )


def cone(start, end, radius: float, colour, sides: int = 16, end_radius: float = 0.0) -> Solid:
    """A cone from a disc of `radius` about `start` to `end` (3,), mm; a rod if `end_radius` equals `radius`."""
    start, end = np.asarray(start, float), np.asarray(end, float)
    ahead = (end - start) / np.linalg.norm(end - start)
    across = _perpendicular(ahead[None])[0]
    other = np.cross(ahead, across)
    angle = np.arange(sides) * (2 * math.pi / sides)
    out = across * np.cos(angle)[:, None] + other * np.sin(angle)[:, None]
    points = np.vstack((start + radius * out, end + end_radius * out, start + radius * out, end + end_radius * out))
    normals = np.vstack((out, out, np.tile(-ahead, (sides, 1)), np.tile(ahead, (sides, 1))))
    i = np.arange(sides)
    j = (i + 1) % sides
    wall = np.vstack((np.column_stack((i, j, sides + j)), np.column_stack((i, sides + j, sides + i))))
    caps = [(2 * sides, 2 * sides + k + 1, 2 * sides + k) for k in range(1, sides - 1)]
    caps += [(3 * sides, 3 * sides + k, 3 * sides + k + 1) for k in range(1, sides - 1)]
    return Solid().triangles(points, normals, colour, np.vstack((wall, caps)))


def ball(centre, radius: float, colour, rings: int = 12) -> Solid:
    """A sphere, mm."""
    lat = np.linspace(-math.pi / 2, math.pi / 2, rings + 1)
    lon = np.arange(2 * rings) * (math.pi / rings)
    out = np.stack((np.cos(lat)[:, None] * np.cos(lon), np.cos(lat)[:, None] * np.sin(lon),
                    np.repeat(np.sin(lat)[:, None], 2 * rings, 1)), axis=-1).reshape(-1, 3)  # fmt: skip
    return Solid().triangles(np.asarray(centre) + radius * out, out, colour, _tube_faces(rings + 1, 2 * rings, False))


def _perpendicular(ahead):
    """One unit vector across each of `ahead` (n, 3), turning as little as possible from one to the next."""
    across = np.empty_like(ahead)
    previous = np.eye(3)[np.argmin(np.abs(ahead[0]))]
    for i, a in enumerate(ahead):
        v = previous - a * (a @ previous)
        size = math.sqrt(v @ v)
        previous = across[i] = v / size if size > 1e-9 else across[i - 1]
    return across


def _tube_faces(n: int, sides: int, closed: bool):
    rows = np.arange(n if closed else n - 1)
    a, i = rows[:, None] * sides, np.arange(sides)
    b, j = ((rows[:, None] + 1) % n) * sides, (i + 1) % sides
    quads = np.stack((a + i, a + j, b + j, a + i, b + j, b + i), axis=-1)
    return quads.reshape(-1, 3)
