"""What gravity does to the arm: the torque on each joint, from the masses and lengths of the links."""

from math import cos, sin

from ...arm import FOREARM, GRAVITY, UPPER_ARM, WRIST
from ...geometry import MAKER

_MM = 1e-3
_ELBOW = (MAKER.L2 * sin(MAKER.delta), MAKER.L2 * cos(MAKER.delta))


def _forward(at: tuple[float, float], s: float, c: float) -> float:
    """How far forward (mm) the point `at` is after its link has pitched down by the angle with this sine, cosine."""
    return at[0] * c + at[1] * s


def torques(q2: float, q3: float, q4: float) -> tuple[float, float, float]:
    """Torque (Nm) of gravity on joints 2, 3, 4, positive when it pitches the joint down. Joint 1 feels none.

    Each link's weight acts at its lever arm: how far forward of the joint its centre of mass lies.
    """
    s2, c2 = sin(q2), cos(q2)
    s23, c23 = sin(q2 + q3), cos(q2 + q3)
    s234, c234 = sin(q2 + q3 + q4), cos(q2 + q3 + q4)
    elbow, wrist = _forward(_ELBOW, s2, c2), MAKER.L3 * c23
    upper = UPPER_ARM[0] * _forward(UPPER_ARM[1], s2, c2)
    fore = _forward(FOREARM[1], s23, c23)
    hand = _forward(WRIST[1], s234, c234)
    on_4 = WRIST[0] * hand
    on_3 = FOREARM[0] * fore + WRIST[0] * (wrist + hand)
    on_2 = upper + FOREARM[0] * (elbow + fore) + WRIST[0] * (elbow + wrist + hand)
    return GRAVITY * _MM * on_2, GRAVITY * _MM * on_3, GRAVITY * _MM * on_4


def lowest(q2: float, q3: float, q4: float) -> float:
    """Height (mm) above the table of the lowest of elbow, wrist and tool."""
    elbow = MAKER.L1 + MAKER.L2 * cos(q2 + MAKER.delta)
    wrist = elbow - MAKER.L3 * sin(q2 + q3)
    return min(elbow, wrist, wrist - MAKER.L4 * sin(q2 + q3 + q4))
