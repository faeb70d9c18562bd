"""Any chain drawn from its DH table alone: cylinders about revolute axes, boxes on prismatic ones, links between."""

import math

import numpy as np

from .mesh import Solid, ball, cone
from .threejs import METAL, Drawing

#: A link's radius as a share of the chain's reach.
SCALE = 0.026

JOINT, SLIDER, LINK, TOOL = (58, 61, 66), (72, 92, 120), (150, 155, 162), (205, 92, 30)


def drawings(chain, colour=None, opacity: float = 1.0) -> dict[int, Drawing]:
    """One drawing a frame for the joints and links of `chain`, as thick as suits its reach.

    Joint i lies on the z axis of frame i - 1 and is drawn there; the link that it moves (d along that axis, then
    a along x) is drawn in frame i, its far end. A prismatic joint is a box that its link's rod slides through.
    `colour` (three integers) paints it all.
    """
    scale = SCALE * reach(chain)
    solids = {i: Solid() for i in range(len(chain.rows) + 1)}
    for i, row in enumerate(chain.rows):
        _joint(solids[i], row.prismatic, scale)
        _link(solids[i + 1], row, _stroke(chain, i), scale)
    if chain.tool is not None:
        back = np.linalg.inv(chain.tool)
        solids[len(chain.rows)] = solids[len(chain.rows)].moved(back)
        _rod(solids[len(chain.rows)], back[:3, 3], np.zeros(3), scale)
    solids[len(chain.rows)].add(ball((0, 0, 0), 1.7 * scale, TOOL))
    painted = {i: solid if colour is None else solid.silhouette(colour) for i, solid in solids.items()}
    return {i: Drawing().solid(solid, METAL, opacity=opacity) for i, solid in painted.items()}


def reach(chain) -> float:
    """An upper bound of the distance (mm) from the base to the tool; a prismatic joint counts with its stroke."""
    fixed = sum(float(np.linalg.norm(T[:3, 3])) for T in (chain.base, chain.tool) if T is not None)
    return chain.size + fixed + sum(_stroke(chain, i) for i in range(len(chain.rows))) or 100.0


def _stroke(chain, joint: int) -> float:
    """How far (mm) a prismatic joint slides from its zero: its limits, or 100 if it has none; 0 if it turns."""
    if not chain.rows[joint].prismatic:
        return 0.0
    return max((abs(v) for v in (chain.limits or {joint: ()})[joint] if math.isfinite(v)), default=100.0)


def _joint(solid: Solid, prismatic: bool, scale: float) -> None:
    if prismatic:
        half = 2.2 * scale
        solid.box((-half, -half, -1.2 * half), (half, half, 1.2 * half), SLIDER, 0.3 * scale)
    else:
        solid.disc((0, 0), 2.2 * scale, -2.6 * scale, 2.6 * scale, JOINT, bevel=0.3 * scale)
        solid.disc((0, 0), 1.2 * scale, -2.9 * scale, 2.9 * scale, LINK, bevel=0.2 * scale)


def _link(solid: Solid, row, stroke: float, scale: float) -> None:
    """The link of one row, seen from its far frame: back along x by a, then back along the joint's axis by d."""
    a, d, alpha = float(row.a), float(row.d), float(row.alpha)
    corner = np.array((-a, 0.0, 0.0))
    axis = np.array((0.0, math.sin(alpha), math.cos(alpha)))  # the joint's axis, as the far frame sees it
    for start, end in ((corner, np.zeros(3)), (corner - (d + stroke) * axis, corner)):
        _rod(solid, start, end, scale)
    solid.add(ball(corner, 0.95 * scale, LINK))


def _rod(solid: Solid, start, end, scale: float) -> None:
    if np.linalg.norm(end - start) > 1e-6:
        solid.add(cone(start, end, 0.85 * scale, LINK, 20, 0.85 * scale))
