"""Six-joint arms for tests: the book's own, well-known ones, and odd ones that use every column of the table."""

from math import pi

import numpy as np

from omx.dh import Chain, DHRow

H = pi / 2


def chain(name, *rows):
    return Chain([DHRow(*row) for row in rows], name=name)


ARMS = {
    arm.name: arm
    for arm in (
        chain(
            "textbook", (0, 300, 0, H), (0, 0, 500, 0), (0, 0, 400, 0), (0, 200, 0, H), (0, 0, 0, -H), (0, 100, 0, 0)
        ),
        chain(
            "Stanford", (0, 100, 0, -H), (0, 100, 0, H), (0, 0, 0, 0, True), (0, 0, 0, -H), (0, 0, 0, H),
            (0, 100, 0, 0),
        ),
        chain(
            "UR5", (0, 89.2, 0, H), (0, 0, -425, 0), (0, 0, -392.25, 0), (0, 109.15, 0, H), (0, 94.65, 0, -H),
            (0, 82.3, 0, 0),
        ),
        chain(
            "PUMA 560", (0, 0, 0, H), (0, 0, 431.8, 0), (0, 150.05, 20.3, -H), (0, 431.8, 0, H), (0, 0, 0, -H),
            (0, 0, 0, 0),
        ),
        chain(
            "odd elbow", (0.3, 290, 50, -H), (-H, 10, 270, pi), (0.2, 20, 70, H), (0.7, 302, 0, -H), (0.4, 0, 0, -H),
            (pi, 72, 5, 0.3),
        ),
        chain(
            "odd slide", (0.3, 290, 50, -H), (-H, 10, 0, -H), (0.2, 20, 0, pi, True), (0.7, 302, 0, -H),
            (0.4, 0, 0, -H), (pi, 72, 5, 0.3),
        ),
        chain(
            "odd parallel", (0.3, 290, 50, -H), (-H, 10, 270, pi), (0.2, 20, 70, pi), (0.7, 302, 15, -H),
            (0.4, 30, 0, -H), (pi, 72, 5, 0.3),
        ),
    )
}  # fmt: skip


def configurations(arm, count, seed=0):
    """Joint values (count, 6) spread over every angle, and over 800 mm where a joint slides."""
    half = np.where([row.prismatic for row in arm.rows], 400.0, pi)
    return np.random.default_rng(seed).uniform(-half, half, (count, len(arm)))


def columns(T):
    """The twelve numbers of hands (..., 4, 4), as generated inverses take them."""
    return [T[..., i, j] for j in range(4) for i in range(3)]


def gaps(arm, a, b):
    """How far each of the answers `a` (N, m, n) is from its nearest of `b` (N, k, n): rad, or mm; NaN rows drop out."""
    slides = [row.prismatic for row in arm.rows]
    apart = np.abs(a[:, :, None] - b[:, None])
    apart = np.where(slides, apart, np.abs((apart + pi) % (2 * pi) - pi)).max(axis=-1)
    nearest = np.where(np.isnan(apart), np.inf, apart).min(axis=2)
    return nearest[~np.isnan(a[..., 0])]
