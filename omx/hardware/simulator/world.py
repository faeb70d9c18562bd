"""A table with things on it: the virtual arm grips them, carries, stacks, pushes and drops them, and knocks them over.

Nothing here has speed or inertia: after each small step of the arm everything is at rest again. The rules:

- What stands between the open fingers is brought to their middle as they close, and turned until its faces lie on the
  pads, unless friction jams it across its corners.
- Pads that press enough carry it. It then keeps its place in the hand, until they press too little.
- What is let go goes straight down. It stays where its centre of mass is over what is below; from more than `FALL` mm
  it comes to lie on another side.
- What a finger, the hand, the forearm or something carried runs into slides, if it is met low enough, and falls over
  if it is met higher than half its foot divided by the friction, or from above.

The arm feels the weight of what it carries, and nothing of what it pushes: the things are light.
"""

from dataclasses import replace
from math import atan, atan2, dist, pi

import numpy as np

from ...arm import FINGER_PER_RAD, OPENING_AT_ZERO
from ...arrays import as_number
from ...collision import capsules
from ...errors import BadInput
from ...generated import fk as _fk
from ...geometry import COURSE, Geometry
from .objects import MU, UP, Grasped, Thing

#: Friction between things and the table.
MU_TABLE = 0.5
#: From higher than this (mm) a thing does not land on its foot.
FALL = 25.0
#: The pads in the tool frame (mm): along the hand, and to either side of its plane; at least `LAP` of a thing's
#: middle line must be between them. The fingers are as thick as `FINGER`, outwards from the pads.
PADS, PAD_HALF, LAP, FINGER = (-42.0, 22.0), 10.0, 5.0, 12.0
#: Nearer than this (mm) counts as touching.
TOUCH = 0.1
#: The world looks at the arm every so many of its steps, and keeps what it saw every `FILM` looks.
EVERY, FILM = 10, 5
#: A square thing turned by more than this (rad) jams: the line between its corners is in both friction cones.
JAMS = pi / 4 - atan(MU)
#: So many things may give way to each other between two looks.
MOST_MOVES = 40


class World:
    """`things` on the table of the virtual `arm`, whose true lengths are those of `geometry`.

    `world["red"]` is one `Thing` as it is now; `held` the name of the one in the hand, or None.
    """

    def __init__(self, arm, things=(), geometry: Geometry = COURSE):
        if arm is None:
            raise BadInput("a World needs a virtual arm, `Robot().arm`; on the real one the table is real, too.")
        self.arm, self.geometry = arm, geometry
        self._things: dict[str, Thing] = {}
        self._held: Thing | None = None
        self._grasp = np.eye(4)  # of what is held, in the tool frame
        self._gap: Thing | None = None  # what stands between the fingers
        self._leaving: Thing | None = None  # what stood there, and the fingers have not come clear of yet
        self._moved: list[Thing] = []  # what has just come to another place, where something may be in its way
        self._film: list[tuple] = []
        self._looks = 0
        for thing in things:
            self.add(thing)
        arm.catch_up()
        arm.world = self

    def __getitem__(self, name: str) -> Thing:
        self.arm.catch_up()
        if name not in self._things:
            raise BadInput(f"there is no {name!r} on the table, but {', '.join(self._things) or 'nothing'}.")
        return self._things[name]

    @property
    def things(self) -> tuple[Thing, ...]:
        """Everything on the table or in the hand, as it is now."""
        self.arm.catch_up()
        return tuple(self._things.values())

    @property
    def held(self) -> str | None:
        """The name of what the hand carries."""
        self.arm.catch_up()
        return self._held.name if self._held else None

    def add(self, thing: Thing) -> None:
        """Put one more thing on the table; `BadInput` where another one stands."""
        if not isinstance(thing, Thing):
            raise BadInput(f"`things` are made by `cube` and `cup`; got {thing!r}.")
        for other in self._things.values():
            if other.name == thing.name:
                raise BadInput(f"there is a {thing.name!r} on the table already.")
            if (other.distances(thing.skin()) < 0).any() or (thing.distances(other.skin()) < 0).any():
                raise BadInput(f"{thing.name!r} would stand where {other.name!r} is.")
        self._things[thing.name] = thing

    def film(self) -> tuple[np.ndarray, np.ndarray, dict[str, np.ndarray]]:
        """What was seen since the last film: joints (N, 4) rad, the fingers' travel (N,) mm, a T (N, 4, 4) a thing.

        About ten pictures a second, while something moved.
        """
        self.arm.catch_up()
        seen, self._film = self._film or [self._picture()], []
        names = [name for name in self._things if all(name in poses for _, _, poses in seen)]
        return (np.array([q for q, _, _ in seen]), np.array([travel for _, travel, _ in seen]),
                {name: np.array([poses[name] for _, _, poses in seen]) for name in names})  # fmt: skip

    def between(self, q, opening: float) -> str | None:
        """The name of what fingers that are `opening` mm apart stand around without touching it, at angles `q` (rad).

        The angles are the true ones. None: there is nothing, or a finger would come down on it.
        """
        opening = as_number(opening, "opening", "the distance of the pads in mm", 0, 100)
        T, _ = self._hand(q)
        fingers = _fingers(T, opening)
        for thing in self._things.values():
            if self._within(thing, T) and self._free(thing, T, opening):
                return None if (thing.distances(fingers) < FINGER / 2 - TOUCH).any() else thing.name
        return None

    # ---- one look ----

    def look(self, between: Grasped | None) -> Grasped | None:
        """What the arm's last steps did to the things; returns what is between the fingers now."""
        q = [joint.link for joint in self.arm.joints[:4]]
        opening = OPENING_AT_ZERO + 2 * FINGER_PER_RAD * self.arm.joints[4].angle
        T, parts = self._hand(q)
        if self._held:
            between = self._go_on_holding(between, T)
        elif self._gap and between is not None and between.carried:
            self._close_on(self._gap, T, opening)
            self._held, self._grasp = self._gap, np.linalg.inv(T) @ self._gap.T
        if self._held is None:
            between = self._stand_between(between, T, opening)
        self._run_into(T, opening, parts)
        self._make_room()
        self._looks += 1
        if self._looks % FILM == 0:
            self._film.append(self._picture())
        return between

    def _hand(self, q):
        """T_base_tool, and the arm's capsules."""
        T = np.array(_fk.frames(*q, *self.geometry.values)[3], dtype=float)
        return T, capsules(tuple(q), self.geometry)

    def _picture(self):
        joints = self.arm.joints
        poses = {name: thing.T.copy() for name, thing in self._things.items()}
        return [joint.link for joint in joints[:4]], FINGER_PER_RAD * joints[4].angle, poses

    # ---- in the hand ----

    def _go_on_holding(self, between, T):
        thing = self._held
        if between is None or not between.carried:
            self._held = None
            self._gap = thing if between is not None else None
            self._drop(thing)
            return between
        riders, before = self._pile(thing), np.linalg.inv(thing.T)
        thing.T = T @ self._grasp
        if thing.bottom < 0:
            self._slide_up(T, -thing.bottom)
        for rider in riders:
            rider.T = thing.T @ before @ rider.T
        between.mass_g = sum(one.mass_g for one in (thing, *riders))
        return between

    def _slide_up(self, T, by: float) -> None:
        """The table, or what stands on it, pushes the thing up between the pads."""
        self._held.T[2, 3] += by
        self._grasp = np.linalg.inv(T) @ self._held.T

    def _stand_between(self, between, T, opening):
        if self._gap and not self._within(self._gap, T):
            self._leaving, self._gap, between = self._gap, None, None
        if self._gap is None:
            around = (t for t in self._things.values() if self._within(t, T) and self._free(t, T, opening))
            self._gap = next(around, None)
            between = Grasped(0.0, self._gap.mass_g) if self._gap else None
        if self._gap:
            self._close_on(self._gap, T, opening)
            between.width = self._width(self._gap, T)
        return between

    def _within(self, thing: Thing, T) -> bool:
        return self._lap(thing, T) >= LAP

    @staticmethod
    def _lap(thing: Thing, T) -> float:
        """How much (mm) of the thing's middle line is between the pads, however far they are apart."""
        down = UP * thing.half(UP)
        a, b = ((end - T[:3, 3]) @ T[:3, :3] for end in (thing.T[:3, 3] - down, thing.T[:3, 3] + down))
        low, high = 0.0, 1.0
        for start, way, (least, most) in zip(a[:2], (b - a)[:2], (PADS, (-PAD_HALF, PAD_HALF)), strict=True):
            if abs(way) < 1e-9:
                if not least <= start <= most:
                    return 0.0
                continue
            ends = sorted(((least - start) / way, (most - start) / way))
            low, high = max(low, ends[0]), min(high, ends[1])
        return max(high - low, 0.0) * 2 * thing.half(UP)

    @staticmethod
    def _free(thing: Thing, T, opening: float) -> bool:
        across = T[:3, 2]
        off = abs((thing.T[:3, 3] - T[:3, 3]) @ across)
        return off + thing.half(across) <= opening / 2 + TOUCH

    def _close_on(self, thing: Thing, T, opening: float) -> None:
        """The pads push the thing to their middle, and turn it as far as they have come."""
        across = T[:3, 2]
        turn = _askew(thing, across)
        if 2 * thing.half(across) > opening and abs(turn) < JAMS:
            low, high = 0.0, 1.0  # the share of the turn that is left
            for _ in range(20):
                share = (low + high) / 2
                wide = 2 * _turned(thing, (share - 1) * turn).half(across)
                low, high = (low, share) if wide > opening else (share, high)
            thing.turn(UP, (low - 1) * turn)
        off = (thing.T[:3, 3] - T[:3, 3]) @ across
        room = max(opening / 2 - thing.half(across), 0.0)
        if abs(off) > room:
            self._shift(thing, across * (np.copysign(room, off) - off))

    @staticmethod
    def _width(thing: Thing, T) -> float:
        """How wide it is for the pads once it has turned as far as it will."""
        across = T[:3, 2]
        turn = _askew(thing, across)
        return 2 * (_turned(thing, -turn) if abs(turn) < JAMS else thing).half(across)

    # ---- on the table ----

    def _shift(self, thing: Thing, way) -> None:
        for one in (thing, *self._pile(thing)):
            one.T[:3, 3] += way
            self._moved.append(one)

    def _on(self, thing: Thing) -> list[Thing]:
        """What stands directly on it."""
        return [
            one
            for one in self._things.values()
            if one is not thing and one is not self._held and abs(one.bottom - thing.top) < 1 and _over(one, thing)
        ]

    def _pile(self, thing: Thing) -> list[Thing]:
        """Everything that stands on it, directly or not."""
        return [one for first in self._on(thing) for one in (first, *self._pile(first))]

    def _drop(self, thing: Thing) -> None:
        """Let it go where it is: it goes down onto what is below its centre of mass, and stays if it can."""
        x, y, _ = thing.at
        others = [one for one in self._things.values() if one not in (thing, self._held)]
        below = [one for one in others if one.top <= thing.bottom + 2 and one.covers(x, y)]
        ground = max((one.top for one in below), default=0.0)
        fall = thing.bottom - ground
        leaning = self._level(thing)
        thing.T[2, 3] = ground + thing.half(UP)
        edge = next((one for one in others if one not in below and _over(thing, one) and one.top > ground + 1), None)
        outwards = _flat(thing.at) if edge is None else _flat(thing.at - edge.at)
        if edge is not None or fall > FALL or leaning:
            self._topple(thing, outwards)
        else:
            self._moved.append(thing)  # as it came down a rim of what stands here may have run into its side
            self._settle_pile(thing)

    @staticmethod
    def _level(thing: Thing) -> bool:
        """Put it flat on the side that is lowest; True if it leaned too far to stay there."""
        R = thing.T[:3, :3]
        axis = R[:, int(np.abs(R[2]).argmax())]
        axis = axis * np.copysign(1.0, axis[2])
        lean = atan2(np.hypot(axis[0], axis[1]), axis[2])
        over = np.cross(axis, UP)
        size = np.linalg.norm(over)
        if size > 1e-9:
            thing.turn(over / size, lean)
        return lean > atan(thing.half(_flat(axis)) / thing.half(UP)) if size > 1e-9 else False

    def _settle_pile(self, thing: Thing) -> None:
        """Does each thing below carry what is on it? If the common centre of mass is beside it, that falls off."""
        while (below := next((one for one in self._things.values() if thing in self._on(one)), None)) is not None:
            pile = self._pile(below)
            centre = sum(one.mass_g * one.at for one in pile) / max(sum(one.mass_g for one in pile), 1e-9)
            if not below.covers(*centre[:2]):
                for one in reversed(pile):
                    self._topple(one, _flat(centre - below.at))
                return
            thing = below

    def _topple(self, thing: Thing, way) -> None:
        """It falls over towards `way` (3,), horizontal, and lies on the table; what is round and lies there rolls."""
        if not thing.round:  # over one of the edges of its foot
            sides = [s * thing.T[:3, i] for i in range(3) for s in (1, -1) if abs(thing.T[2, i]) < 0.5]
            way = _flat(max(sides, key=lambda side: side @ way))
        riders = self._pile(thing)
        foot, high = thing.half(way), float(thing.T[2, 3])  # from higher up it comes to lie farther away
        if not thing.round or abs(thing.T[2, 2]) > 0.5:
            thing.turn(np.cross(UP, way), pi / 2)
        thing.T[:3, 3] += way * (foot + high)
        thing.T[2, 3] = thing.half(UP)
        self._moved.append(thing)
        for rider in riders:
            self._topple(rider, way)

    # ---- pushed ----

    def _run_into(self, T, opening: float, parts) -> None:
        """The fingers, the hand, the forearm and what is carried move what is in their way."""
        if self._leaving and self._lap(self._leaving, T) == 0:
            self._leaving = None
        bodies = [(_fingers(T, opening), FINGER / 2, T[:3, 3], opening / 2 + 60), *map(_along, parts[3:5])]
        if self._held:
            held = self._held
            bodies.append((held.skin(), 1.0, held.T[:3, 3], held.width + held.height))
        for thing in list(self._things.values()):
            if thing is self._held:
                continue
            for i, (points, radius, middle, reach) in enumerate(bodies):
                near = dist(thing.T[:3, 3], middle) < reach + thing.width + thing.height
                if near and not (i == 0 and thing in (self._gap, self._leaving, *self._carried())):
                    self._push_away(thing, points, radius, T if i == 3 else None)

    def _make_room(self) -> None:
        """What has moved falls if nothing is below it any more, and moves what it has run into."""
        for _ in range(MOST_MOVES):
            if not self._moved:
                break
            thing = self._moved.pop(0)
            if thing.bottom > 1 and not any(thing in self._on(other) for other in self._things.values()):
                self._drop(thing)
            for other in self._things.values():
                near = dist(thing.T[:3, 3], other.T[:3, 3]) < thing.width + thing.height + other.width + other.height
                if near and other not in (thing, self._held) and (depth := _overlap(thing, other)) is not None:
                    self._shift(other, depth)
        self._moved.clear()

    def _carried(self) -> list[Thing]:
        return self._pile(self._held) if self._held else []

    def _push_away(self, thing: Thing, points, radius: float, T=None) -> None:
        """Balls of `radius` about `points` move the thing, or knock it over; `T` if they are those of what is held."""
        for _ in range(6):
            distances = thing.distances(points)
            deepest = int(distances.argmin())
            depth = radius - distances[deepest]
            if depth <= TOUCH:
                return
            out = thing.ways_out(points)
            if abs(out[deepest, 2]) < 0.7:  # of all that touch it, the lowest pushes: there it slides most easily
                touching = np.flatnonzero(distances < distances[deepest] + 5 * TOUCH)
                deepest = int(touching[points[touching, 2].argmin()])
            if out[deepest, 2] > 0.7 and T is not None:  # what is held comes down on it
                self._slide_up(T, depth)
                return
            way = _flat(-out[deepest] if abs(out[deepest, 2]) < 0.7 else thing.at - points[deepest])
            met = points[deepest, 2] - thing.bottom
            if out[deepest, 2] > 0.7 or met > thing.half(way) / MU_TABLE:
                self._topple(thing, way)
                return
            self._shift(thing, way * depth)


def _askew(thing: Thing, across) -> float:
    """By how much (rad, -pi/4 .. pi/4) its faces are turned from the pads; 0 for what is round to them."""
    if thing.round and thing.standing:
        return 0.0
    side = next(thing.T[:3, i] for i in range(3) if abs(thing.T[2, i]) < 0.5)
    turn = atan2(side[1], side[0]) - atan2(across[1], across[0])
    return (turn + pi / 4) % (pi / 2) - pi / 4


def _turned(thing: Thing, angle: float) -> Thing:
    turned = replace(thing, T=thing.T.copy())
    turned.turn(UP, angle)
    return turned


def _over(one: Thing, other: Thing) -> bool:
    """Do they overlap, seen from above?"""
    points = one.skin()
    points[:, 2] = other.T[2, 3]
    return bool((other.distances(points) < 0).any())


def _overlap(one: Thing, other: Thing) -> np.ndarray | None:
    """The shortest horizontal way (3,) by which `other` comes clear of `one`; None if it is."""
    if (other.distances(one.skin()) > 1 - TOUCH).all() and (one.distances(other.skin()) > 1 - TOUCH).all():
        return None
    apart = other.at - one.at
    ways = [
        _flat(apart),
        *(_flat(thing.T[:3, i]) for thing in (one, other) for i in range(3) if abs(thing.T[2, i]) < 0.5),
    ]
    depths = [one.half(way) + other.half(way) - abs(apart @ way) for way in ways]
    best = int(np.argmin(depths))
    return ways[best] * np.copysign(depths[best], apart @ ways[best])


def _flat(way) -> np.ndarray:
    """The horizontal direction of `way`; forwards if it has none."""
    size = np.hypot(way[0], way[1])
    return np.array([way[0] / size, way[1] / size, 0.0]) if size > 1e-9 else np.array([1.0, 0.0, 0.0])


def _fingers(T, opening: float) -> np.ndarray:
    """The middles of the balls that the two fingers are made of, (N, 3)."""
    local = _BLADE.copy()
    local[:, 2] *= opening / 2 + FINGER / 2
    return local @ T[:3, :3].T + T[:3, 3]


#: The balls of both fingers in the tool frame; the last column says on which side.
_BLADE = np.array([(x, y, side) for x in np.arange(-40, 17, 8) for y in (-6, -3, 0, 3, 6) for side in (1, -1)], float)


def _along(part) -> tuple[np.ndarray, float, np.ndarray, float]:
    """A capsule as balls: their middles (N, 3) and their radius; its own middle, and how far it reaches from there."""
    a, b = np.array(part.a), np.array(part.b)
    long = dist(a, b)
    points = a + np.linspace(0, 1, max(2, int(long / 10)))[:, None] * (b - a)
    return points, part.radius, (a + b) / 2, long / 2 + part.radius
