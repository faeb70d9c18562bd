"""Things on a table, cubes and cups: where they are, what shape they have, how fingers press them. Lengths in mm."""

from dataclasses import dataclass, field
from math import cos, hypot, pi, radians, sin

import numpy as np

from ...arm import FINGER_PER_RAD, GRAVITY, GRIP_TORQUE_PER_N, OPENING_AT_ZERO
from ...arrays import as_number, as_word
from ...errors import BadInput
from ...rotation import from_vector

UP = np.array([0.0, 0.0, 1.0])
#: How much of the pads' pressure carries weight: rubber on wood, paper or most plastics, on the safe side.
MU = 0.5


@dataclass
class Thing:
    """A box, or where it is `round` a cylinder, `width` wide and `height` high, of `mass_g`.

    `T` (4, 4) in the base frame: its origin is the thing's middle, its z axis leads from foot to top.
    """

    name: str
    width: float
    height: float
    mass_g: float
    round: bool
    colour: str
    T: np.ndarray = field(repr=False)

    @property
    def at(self) -> np.ndarray:
        """Where its middle is (3,)."""
        return self.T[:3, 3].copy()

    @property
    def bottom(self) -> float:
        """The height of its lowest point."""
        return float(self.T[2, 3]) - self.half(UP)

    @property
    def top(self) -> float:
        """The height of its highest point."""
        return float(self.T[2, 3]) + self.half(UP)

    @property
    def standing(self) -> bool:
        """Does it stand on its foot?"""
        return bool(self.T[2, 2] > 0.99)

    @property
    def tag(self) -> np.ndarray:
        """The corners (4, 3) of the square tag on its top, as wide as fits, anticlockwise from its left far corner."""
        h = self.width / 2 / (hypot(1, 1) if self.round else 1)
        corners = np.array([[-h, h], [-h, -h], [h, -h], [h, h]])
        return (self.T @ np.column_stack((corners, np.full(4, self.height / 2), np.ones(4))).T)[:3].T

    def half(self, direction) -> float:
        """How far it reaches from its middle along a unit vector (3,)."""
        x, y, z = np.abs(self.T[:3, :3].T @ direction)
        across = hypot(x, y) if self.round else x + y
        return float((self.width * across + self.height * z) / 2)

    def covers(self, x: float, y: float) -> bool:
        """Is the point (x, y) above or below it?"""
        return bool(self.distances(np.array([[x, y, self.T[2, 3]]]))[0] <= 1e-9)

    def distances(self, points) -> np.ndarray:
        """The distances (N,) of `points` (N, 3) from its surface, negative inside."""
        _, _, beyond = self._beyond(points)
        far = np.sqrt((np.maximum(beyond, 0.0) ** 2).sum(axis=1))
        return np.where(far > 0, far, beyond.max(axis=1))

    def ways_out(self, points) -> np.ndarray:
        """The directions (N, 3) in which `points` (N, 3) come clear of it soonest, or are away from it."""
        local, sizes, beyond = self._beyond(points)
        outside = np.maximum(beyond, 0.0)
        inside = beyond == beyond.max(axis=1)[:, None]
        way = np.where(outside.any(axis=1)[:, None], outside, inside.astype(float))
        signs = np.where(local < 0, -1.0, 1.0)
        flat = signs[:, :2] * way[:, :2]
        if self.round:
            flat = local[:, :2] / np.maximum(sizes, 1e-12) * way[:, :1]
        way = np.column_stack((flat, signs[:, 2] * way[:, -1]))
        way /= np.maximum(np.linalg.norm(way, axis=1), 1e-12)[:, None]
        return way @ self.T[:3, :3].T

    def _beyond(self, points) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """`points` (N, 3) in its own frame, how far they are from its axes, and how far beyond its sides and ends."""
        local = (points - self.T[:3, 3]) @ self.T[:3, :3]
        sizes = np.hypot(local[:, 0], local[:, 1])[:, None] if self.round else np.abs(local[:, :2])
        return local, sizes, np.column_stack((sizes - self.width / 2, np.abs(local[:, 2]) - self.height / 2))

    def skin(self) -> np.ndarray:
        """Points (N, 3) all over it, a millimetre below its surface."""
        w, h = self.width / 2 - 1, self.height / 2 - 1
        angles = np.arange(8) * pi / 4
        reach = np.where(np.arange(8) % 2, 1.0 if self.round else hypot(1, 1), 1.0) * w
        rim = np.column_stack((reach * np.cos(angles), reach * np.sin(angles)))
        rings = [np.column_stack((rim, np.full(8, z))) for z in (-h, 0.0, h)]
        local = np.vstack((*rings, [[0, 0, -h], [0, 0, h]]))
        return local @ self.T[:3, :3].T + self.T[:3, 3]

    def turn(self, axis, angle: float) -> None:
        """Turn it about its middle, `angle` (rad) about the unit vector `axis`."""
        self.T[:3, :3] = from_vector(angle * np.asarray(axis)) @ self.T[:3, :3]


def cube(name: str, at, side: float = 30.0, mass_g: float = 20.0, colour: str | None = None, yaw_deg: float = 0.0):
    """A cube of wood on the table at `at` (x, y), turned by `yaw_deg`."""
    return _thing(name, at, side, side, mass_g, False, colour, yaw_deg)


def cup(name: str, at, diameter: float = 50.0, height: float = 60.0, mass_g: float = 30.0, colour: str | None = None):
    """A cup on the table at `at` (x, y), upright and closed: a round thing."""
    return _thing(name, at, diameter, height, mass_g, True, colour, 0.0)


def _thing(name, at, width, height, mass_g, is_round, colour, yaw_deg) -> Thing:
    as_word(name)
    if np.shape(at) != (2,):
        raise BadInput(f"`at` must be x and y on the table, in mm; got {at!r}.")
    x, y = (as_number(value, "at", "x and y on the table, in mm") for value in at)
    width, height = (as_number(value, "size", "a length of 5 .. 200 mm", 5, 200) for value in (width, height))
    mass_g = as_number(mass_g, "mass_g", "a mass of 0 .. 2000 g", 0, 2000)
    yaw = radians(as_number(yaw_deg, "yaw_deg", "an angle in degrees"))
    T = np.eye(4)
    T[:2, :2] = [[cos(yaw), -sin(yaw)], [sin(yaw), cos(yaw)]]
    T[:3, 3] = x, y, height / 2
    return Thing(name, width, height, mass_g, is_round, colour or name, T)


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
