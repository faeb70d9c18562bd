"""What gravity does to the arm: the torque on each joint, from the masses and lengths of the links.

The virtual arm falls by it; the driver balances an arm with it, and knows by it how much current a joint may need.
"""

from math import cos, sin

from ..arm import FOREARM, GRAVITY, HOLDING_MA, STIFFNESS, TORQUE_PER_MA, UPPER_ARM, WRIST
from ..errors import BadInput, TooHeavy
from ..geometry import MAKER

_MM = 1e-3
#: The most that the arm is meant to carry (g): the maker's payload.
MOST_GRAMS = 500.0
_ELBOW = (MAKER.L2 * sin(MAKER.delta), MAKER.L2 * cos(MAKER.delta))


def _forward(at: tuple[float, float], s: float, c: float) -> float:
    """How far forward (mm) the point `at` is after its link has pitched down by the angle with this sine, cosine."""
    return at[0] * c + at[1] * s


def torques(q2: float, q3: float, q4: float, payload_kg: float = 0.0) -> tuple[float, float, float]:
    """Torque (Nm) of gravity on joints 2, 3, 4, positive when it pitches the joint down. Joint 1 feels none.

    Each link's weight acts at its lever arm: how far forward of the joint its centre of mass lies. A payload hangs
    between the finger tips, where the tool frame is.
    """
    s2, c2 = sin(q2), cos(q2)
    s23, c23 = sin(q2 + q3), cos(q2 + q3)
    s234, c234 = sin(q2 + q3 + q4), cos(q2 + q3 + q4)
    elbow, wrist = _forward(_ELBOW, s2, c2), MAKER.L3 * c23
    upper = UPPER_ARM[0] * _forward(UPPER_ARM[1], s2, c2)
    fore = _forward(FOREARM[1], s23, c23)
    end = WRIST[0] + payload_kg
    on_4 = WRIST[0] * _forward(WRIST[1], s234, c234) + payload_kg * MAKER.L4 * c234
    on_3 = FOREARM[0] * fore + end * wrist + on_4
    on_2 = upper + FOREARM[0] * (elbow + fore) + end * (elbow + wrist) + on_4
    return GRAVITY * _MM * on_2, GRAVITY * _MM * on_3, GRAVITY * _MM * on_4


def lowest(q2: float, q3: float, q4: float) -> float:
    """Height (mm) above the table of the lowest of elbow, wrist and tool."""
    elbow = MAKER.L1 + MAKER.L2 * cos(q2 + MAKER.delta)
    wrist = elbow - MAKER.L3 * sin(q2 + q3)
    return min(elbow, wrist, wrist - MAKER.L4 * sin(q2 + q3 + q4))


def holding_currents(q, payload_g: float = 0.0) -> tuple[float, float, float, float]:
    """The currents (mA) with which the four motors hold the arm still at `q` (rad), friction left out."""
    _, q2, q3, q4 = q
    return 0.0, *(-torque / TORQUE_PER_MA for torque in torques(q2, q3, q4, payload_g / 1000))


def sagged(q, payload_g: float = 0.0) -> tuple[float, float, float, float]:
    """Where the arm stands (rad) when it is told to stand at `q`: each servo gives way under its load, as a spring."""
    loads = 0.0, *torques(*q[1:], payload_g / 1000)
    return tuple(angle + torque / STIFFNESS for angle, torque in zip(q, loads, strict=True))


def payload(grams) -> float:
    """`grams` as a number, if the arm may carry that much at all; raises `BadInput`."""
    if not (isinstance(grams, (int, float)) and 0 <= grams <= MOST_GRAMS):
        raise BadInput(f"`payload_g` must be 0 .. {MOST_GRAMS:.0f} g, what the maker allows; got {grams!r}.")
    return float(grams)


def check_payload(way, payload_g: float, start=None) -> None:
    """Raise `TooHeavy` if a joint could not hold `payload_g` for long somewhere on `way`, configurations (N, 4) in rad.

    The limit is heat: a servo that holds `HOLDING_MA` for good warms to just under where the driver warns. An arm that
    starts beyond it may go where it is less.
    """
    already = () if start is None else holding_currents(start, payload_g)
    most_mA = max([HOLDING_MA, *map(abs, already)])
    worst, joint, q = max((abs(mA), i, q) for q in way for i, mA in enumerate(holding_currents(q, payload_g)))
    if worst > most_mA * (1 + 1e-9):
        empty = abs(holding_currents(q)[joint])
        most_g = (HOLDING_MA - empty) / (worst - empty) * payload_g
        raise TooHeavy(joint + 1, worst, HOLDING_MA, payload_g, max(most_g, 0.0), q)
