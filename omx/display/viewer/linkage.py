"""The frames of a chain in plain floats, in metres, ready to be sent: a pose must cost microseconds."""

from math import cos, sin

import numpy as np

#: 16 floats, column by column.
IDENTITY = (1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0)
_TO_M = np.array([[1.0, 1.0, 1.0, 1e-3]] * 3 + [[1.0] * 4])


class Linkage:
    """DH rows prepared for fast numeric frames: `frames(q)` gives T_0_0 .. T_0_n as 16 floats each.

    The same numbers as `Chain.frames`, except that translations are in metres.
    """

    def __init__(self, chain):
        self._base = IDENTITY if chain.base is None else tuple(column_major(chain.base))
        self._tool = None if chain.tool is None else np.array(chain.tool) * _TO_M
        self._rows = [
            (float(r.theta), 1e-3 * float(r.d), 1e-3 * float(r.a), cos(r.alpha), sin(r.alpha), r.prismatic)
            for r in chain.rows
        ]

    def frames(self, q) -> list[tuple]:
        """One 16-tuple a frame, the base first; `q`: one value a joint, rad (mm where prismatic)."""
        xx, xy, xz, _, yx, yy, yz, _, zx, zy, zz, _, px, py, pz, _ = self._base
        out = [self._base]
        for (theta, d, a, ca, sa, prismatic), value in zip(self._rows, q, strict=True):
            if prismatic:
                d += 1e-3 * value
            else:
                theta += value
            c, s = cos(theta), sin(theta)
            ux, uy, uz = c * xx + s * yx, c * xy + s * yy, c * xz + s * yz
            vx, vy, vz = c * yx - s * xx, c * yy - s * xy, c * yz - s * xz
            px, py, pz = px + d * zx + a * ux, py + d * zy + a * uy, pz + d * zz + a * uz
            xx, xy, xz = ux, uy, uz
            yx, yy, yz = ca * vx + sa * zx, ca * vy + sa * zy, ca * vz + sa * zz
            zx, zy, zz = ca * zx - sa * vx, ca * zy - sa * vy, ca * zz - sa * vz
            out.append((xx, xy, xz, 0.0, yx, yy, yz, 0.0, zx, zy, zz, 0.0, px, py, pz, 1.0))
        if self._tool is not None:
            out[-1] = tuple((np.reshape(out[-1], (4, 4)).T @ self._tool).T.ravel().tolist())
        return out


def column_major(matrix) -> list[float]:
    """A 4x4 array in mm as 16 floats with the translation in metres."""
    flat = [float(v) for column in zip(*matrix, strict=True) for v in column]
    flat[12:15] = [1e-3 * v for v in flat[12:15]]
    return flat
