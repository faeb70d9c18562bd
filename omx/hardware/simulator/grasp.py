"""Something between the fingers: how hard they press it, and when it slips out."""

from dataclasses import dataclass

from ...arm import FINGER_PER_RAD, GRAVITY, GRIP_TORQUE_PER_N, OPENING_AT_ZERO
from ...arrays import as_number

#: How much of the pads' pressure carries weight: rubber on wood, paper or most plastics, on the safe side.
MU = 0.5


@dataclass
class Grasped:
    """An object of `width` (mm) and `mass_g` that gives way by 1 mm for each `stiffness` (N) on either side.

    A hand holds it up until the fingers press hard enough to carry it. From then on the arm feels its weight; if the
    fingers press too little for that, it is lost.
    """

    width: float
    mass_g: float = 0.0
    stiffness: float = 200.0
    carried: bool = False

    def __post_init__(self):
        for name, least in (("width", 0.0), ("mass_g", 0.0), ("stiffness", 0.1)):
            as_number(getattr(self, name), name, f"a number of at least {least:g}", least)

    def pressed(self, servo_angle: float) -> float:
        """The force (N) of either pad on it, at an angle (rad) of the gripper's servo."""
        opening = OPENING_AT_ZERO + 2 * FINGER_PER_RAD * servo_angle
        return max(self.width - opening, 0.0) / 2 * self.stiffness

    def balance(self, torque: float) -> float:
        """The angle (rad) of the gripper's servo at which it is pressed with `torque` (Nm)."""
        opening = self.width - 2 * max(torque, 0.0) / GRIP_TORQUE_PER_N / self.stiffness
        return (opening - OPENING_AT_ZERO) / (2 * FINGER_PER_RAD)

    def slips(self, force: float) -> bool:
        """Whether pads that press with `force` (N) are too weak to carry it."""
        return 2 * MU * force < self.mass_g / 1000 * GRAVITY
