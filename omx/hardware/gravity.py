"""What gravity does to the arm: the torque on each joint, from the masses and lengths of the links.

The virtual arm falls by it; the driver balances an arm with it, and knows by it how much current a joint may need. The
formula is that of the chapter on weight.
"""

from math import cos, sin

from ..arm import FOREARM, GRAVITY, HOLDING_MA, STIFFNESS, TORQUE_PER_MA, UPPER_ARM, WRIST
from ..arrays import as_number
from ..errors import TooHeavy
from ..generated import gravity
from ..geometry import MAKER

#: The most that the arm is meant to carry (g): the maker's payload.
MOST_GRAMS = 500.0
_LINKS = [number for mass, centre in (UPPER_ARM, FOREARM, WRIST) for number in (mass, *centre)]
#: The arm as the formula takes it: g, mass (kg) and centre (mm) of each link, and the maker's lengths.
ARM = (GRAVITY, *_LINKS, MAKER.L2, MAKER.L3, MAKER.L4, MAKER.delta)


def torques(q2: float, q3: float, q4: float, payload_kg: float = 0.0) -> tuple[float, float, float]:
    """Torque (Nm) of gravity on joints 2, 3, 4, positive when it pitches the joint down. Joint 1 feels none.

    A payload hangs between the finger tips, where the tool frame is.
    """
    on_2, on_3, on_4 = gravity.torques(q2, q3, q4, payload_kg, *ARM)
    return on_2 / 1000, on_3 / 1000, on_4 / 1000


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
    return as_number(grams, "payload_g", f"0 .. {MOST_GRAMS:.0f} g, what the maker allows", 0, MOST_GRAMS)


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
