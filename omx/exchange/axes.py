"""From joint axes, lines in space, to a DH table: what files and screws say, as a `Chain`."""

import warnings
from math import atan2, cos, pi, sin

import numpy as np

from ..arrays import as_number, as_rows, shown
from ..dh import Chain, DHRow, as_transform, link_matrix
from ..errors import BadInput
from ..rotation import rigid

#: Axes nearer to parallel than this (rad) are parallel, unless the caller says otherwise: rounding, and no more.
PARALLEL = 1e-13
#: Axes nearer to each other than this (mm) meet.
TOUCHING = 1e-10
#: An axis in the table may be as far as this (mm) from where it was asked for, a metre away; and no frame farther away
#: (mm), since numbers there have too few digits left.
OFF, FARTHEST = 1e-9, 1e6


def from_axes(
    directions, points, tool, prismatic=(), limits=None, names=None, name: str = "chain", tolerance: float = PARALLEL
) -> Chain:
    """The chain whose joint axes, with all joints at zero, are the lines through `points` along `directions`.

    Where the lines leave a DH table free choices, x points as much as it can where the x before it does, and frames
    on parallel axes stand at one height. Raises `BadInput`, also for neighbouring axes that are nearly parallel: their
    common normal is far away, and a DH table says badly what they are.

    Args:
        directions: one (3,) a joint, of any length but 0; a joint turns about it by the right-hand rule, or slides.
        points: one (3,) a joint, mm: any point of its axis.
        tool: the tool's transform with all joints at zero, (4, 4), mm.
        prismatic: which joints slide, True or False for each; none if left out.
        limits, names, name: as `Chain` takes them.
        tolerance: axes nearer to parallel than this (rad) are taken as parallel.
    """
    z, p = _columns(directions, "directions"), _columns(points, "points")
    tool = as_transform(tool, "tool")
    tolerance = as_number(tolerance, "tolerance", "an angle in rad, 0 .. 0.1", 0.0, 0.1)
    slides = _truths(prismatic, len(z))
    if len(p) != len(z) or tool is None:
        raise BadInput(f"`points` must be as many as `directions`, with a `tool`; got {len(p)} and {len(z)}.")
    z = z / np.linalg.norm(z, axis=1, keepdims=True)
    base = T = _first_frame(z[0], p[0])
    rows = []
    for i in range(1, len(z)):
        row = _to_next(T, z[i], p[i], tolerance, i)
        rows.append(DHRow(*row, prismatic=slides[i - 1]))
        T = T @ link_matrix(*row)
    last, rest = _to_tool(np.linalg.inv(T) @ tool)
    rows.append(DHRow(*last, prismatic=slides[-1]))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # no table has been read: there is none to take for Craig's
        return Chain(rows, limits, names, name, None if np.array_equal(base, np.eye(4)) else base, rest)


def _first_frame(z, p) -> np.ndarray:
    """Frame 0: on the first axis, beside the base's origin, its x as near to the base's x as can be."""
    x = np.eye(3)[0] if abs(z[0]) < 0.9 else np.eye(3)[1]
    x = x - (x @ z) * z
    x = x / np.linalg.norm(x)
    return rigid(np.column_stack((x, np.cross(z, x), z)), p - (p @ z) * z) + 0.0


def _to_next(T, z, p, tolerance: float, joint: int) -> tuple[float, float, float, float]:
    """theta, d, a, alpha from frame `T` to the common normal's foot on the axis (z, p)."""
    x_before, _, z_before, origin = T[:3].T
    across, cosine, to = np.cross(z_before, z), float(z_before @ z), p - origin
    sine = float(np.linalg.norm(across))
    if sine <= tolerance:
        normal = to - (to @ z_before) * z_before
        a = float(np.linalg.norm(normal))
        x = normal / a if a > TOUCHING else x_before
        return _angle(x_before, x, z_before), 0.0, a if a > TOUCHING else 0.0, 0.0 if cosine > 0 else pi
    d = float(np.cross(to, z) @ across) / sine**2
    x = across / sine
    a = float(to @ x)
    if a < -TOUCHING or (abs(a) <= TOUCHING and x @ x_before < -1e-12):
        x, a = -x, -a
    row = (_angle(x_before, x, z_before), d, a if abs(a) > TOUCHING else 0.0, atan2(float(across @ x), cosine))
    there = T @ link_matrix(*row)
    off = np.linalg.norm(np.cross(p - there[:3, 3], z)) + 1e3 * np.linalg.norm(there[:3, 2] - z)
    if off > OFF or abs(d) > FARTHEST:
        raise BadInput(
            f"the axes of joints {joint} and {joint + 1} are {sine:.1e} rad from parallel: their common normal is "
            f"{abs(d) / 1e3:.3g} m away, and a DH table says badly what they are. Round the angles (1.5708 is not "
            f"pi/2), or give a `tolerance` (rad) of more than {sine:.1e} to take them as parallel."
        )
    return row


def _to_tool(M) -> tuple[tuple[float, float, float, float], np.ndarray | None]:
    """The last row, and what is left of the way to the tool `M`: nothing, where a DH row can say it all."""
    theta = atan2(M[1, 0], M[0, 0])
    c, s = cos(theta), sin(theta)
    if abs(M[2, 0]) < 1e-13 and abs(c * M[1, 3] - s * M[0, 3]) < 1e-10:
        return (theta, float(M[2, 3]), float(c * M[0, 3] + s * M[1, 3]), atan2(M[2, 1], M[2, 2])), None
    return (0.0, 0.0, 0.0, 0.0), M


def _angle(start, end, about) -> float:
    """The turn from `start` to `end`, both at right angles to the unit vector `about`."""
    return atan2(float(np.cross(start, end) @ about), float(start @ end)) + 0.0


def _columns(value, name: str) -> np.ndarray:
    rows = as_rows(value, name, 3, "one x, y, z a joint")
    if rows.ndim != 2 or (name == "directions" and not rows.any(axis=1).all()):
        raise BadInput(f"`{name}` must be one x, y, z a joint, and a direction not 0; got {shown(value)}.")
    return rows


def _truths(value, joints: int) -> list[bool]:
    flags = list(value) if np.iterable(value) and not isinstance(value, str) else [None]
    flags = flags or [False] * joints
    if len(flags) != joints or any(flag not in (True, False) for flag in flags):
        raise BadInput(f"`prismatic` must be {joints} times True or False; got {shown(value)}.")
    return [bool(flag) for flag in flags]
