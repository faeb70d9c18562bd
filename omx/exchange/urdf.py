"""URDF, the robot description of ROS, MuJoCo and others: out of any `Chain`, and into one::

    omx.urdf.write("arm.urdf", omx.COURSE)      # with the arm's masses, limits and shapes
    chain = omx.urdf.read("arm.urdf")           # any serial chain, joint axes of any direction

A file is in metres, everything here is in mm; angles are rad in both. Chains come back with the same transforms, to
1e-9 mm (1e-8 where nearly parallel axes put frames hundreds of metres away), and with their names and limits; shapes,
masses and motors are not read.
"""

import os
import re
from collections import Counter
from collections.abc import Sequence
from itertools import pairwise
from math import inf, isfinite
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np

from ..arm import BASE_OFFSET, FOREARM, NO_LOAD_SPEED, STALL_TORQUE, TURRET, UPPER_ARM, WRIST, ZERO
from ..arrays import shown
from ..collision import Capsule, capsules
from ..dh import Chain
from ..errors import BadInput
from ..geometry import COURSE, Geometry, as_arm
from ..rotation import from_rpy, rigid, to_rpy
from .axes import PARALLEL, from_axes

#: No file is larger; a number in a file is one that a robot may have (m, rad).
MOST_BYTES, MOST_NUMBER = 10_000_000, 1e6
NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?")
MOVING = ("revolute", "continuous", "prismatic")


# ---- out ---------------------------------------------------------------------------------------------------


def text(arm: Geometry | Chain = COURSE, *, maker_base: bool = False) -> str:
    """The URDF of an arm: links `base_link`, `link1` .. `linkn`, `tool`, and a joint between each two.

    A `Geometry` brings the arm's limits, masses and shapes, and the servos' stall torque and no-load speed; any other
    `Chain` its limits, and shapes made from its rows (effort and velocity are 0 then: not stated). `maker_base`: the
    link `base_link` stands where the maker's, and so ROS's, base frame is, 12 mm behind the axis of joint 1. Raises
    `BadInput` for what URDF cannot say: symbols, a sliding joint without ends, a turning joint with one end.
    """
    arm = as_arm(arm, numbers=True)
    if maker_base is not True and maker_base is not False:
        raise BadInput(f"`maker_base` must be True or False; got {shown(maker_base)}.")
    chain = arm if isinstance(arm, Chain) else arm.chain
    robot = ElementTree.Element("robot", name=chain.name)
    robot.append(ElementTree.Comment(" Written by omx.urdf: lengths in m, angles in rad. "))
    compiler = {"fusestatic": "false", "discardvisual": "false"}  # MuJoCo keeps the tool, and what is only to be seen
    if isinstance(arm, Chain):  # it moves nothing without a mass, and ours are not known
        compiler |= {"boundmass": "0.01", "boundinertia": "1e-05"}
    ElementTree.SubElement(ElementTree.SubElement(robot, "mujoco"), "compiler", compiler)
    _add(_add(robot, "material", name="grey"), "color", rgba="0.6 0.62 0.65 1")
    links = ["base_link", *(f"link{i}" for i in range(1, len(chain) + 1)), "tool"]
    parts = _arm_parts(arm) if isinstance(arm, Geometry) else _row_parts(chain)
    for name, part in zip(links, parts, strict=True):
        _write_link(robot, name, part)
    behind = _at((BASE_OFFSET if maker_base else 0.0, 0.0, 0.0))
    # a joint moves about its own z first: A_1 .. A_n at zero lead from one link to the next joint
    origins = [behind if chain.base is None else behind @ chain.base, *chain.matrices(np.zeros(len(chain)))]
    for i, (origin, ends) in enumerate(zip(origins, pairwise(links), strict=True)):
        _write_joint(robot, chain, i, ends, origin, isinstance(arm, Geometry))
    ElementTree.indent(robot)
    return '<?xml version="1.0"?>\n' + ElementTree.tostring(robot, encoding="unicode") + "\n"


def write(path, arm: Geometry | Chain = COURSE, *, maker_base: bool = False) -> Path:
    """Write the URDF of an arm to `path`, and return the path. Arguments and errors are those of `text`."""
    if not isinstance(path, (str, os.PathLike)) or not str(path):
        raise BadInput(f"`path` must be the path of a file; got {shown(path)}.")
    described = text(arm, maker_base=maker_base)
    try:
        Path(path).write_text(described, encoding="utf-8", newline="\n")
    except (OSError, ValueError) as error:
        raise BadInput(f"cannot write {path}: {error}.") from None
    return Path(path)


class Part(NamedTuple):
    """What a link has beside its place: shapes (what, sizes in mm, origin (4, 4) mm), and mass, centre, inertia."""

    shapes: Sequence[tuple[str, tuple[float, ...], np.ndarray]] = ()
    mass: float = 0.0  # kg
    centre: np.ndarray = np.zeros(3)  # mm
    inertia: np.ndarray = np.zeros((3, 3))  # kg m^2
    touches: bool = False


def _write_joint(robot, chain: Chain, i: int, ends: tuple[str, str], origin, servos: bool) -> None:
    """Joint i + 1, about the z axis of its own frame; behind the last the fixed one to the tool."""
    moving = i < len(chain)
    name = chain.names[i] if moving else "tool_joint"
    low, high = (chain.limits[i] if chain.limits else (-inf, inf)) if moving else (0.0, 0.0)
    slides = moving and chain.rows[i].prismatic
    free = not isfinite(low) and not isfinite(high)
    if moving and not (isfinite(low) and isfinite(high)) and (slides or not free):
        raise BadInput(
            f"{name} of {chain.name} has the limits ({low:g}, {high:g}): URDF wants both ends of a joint that "
            f"{'slides' if slides else 'does not turn freely'}. Give the Chain limits."
        )
    kind = "fixed" if not moving else "prismatic" if slides else "continuous" if free else "revolute"
    joint = _add(robot, "joint", name=name, type=kind)
    _add(joint, "parent", link=ends[0])
    _add(joint, "child", link=ends[1])
    _add(joint, "origin", xyz=_exact(*(1e-3 * origin[:3, 3])), rpy=_exact(*to_rpy(origin)))
    if moving:
        _add(joint, "axis", xyz="0 0 1")
        unit = 1e-3 if slides else 1.0
        stops = {} if free else {"lower": _exact(unit * low), "upper": _exact(unit * high)}
        effort, velocity = (STALL_TORQUE, NO_LOAD_SPEED) if servos else (0.0, 0.0)
        _add(joint, "limit", **stops, effort=_short(effort), velocity=_short(velocity))


def _write_link(robot, name: str, part: Part) -> None:
    link = _add(robot, "link", name=name)
    if part.mass:
        inertial = _add(link, "inertial")
        _add(inertial, "origin", xyz=_exact(*(1e-3 * part.centre).round(15)), rpy="0 0 0")
        _add(inertial, "mass", value=_short(part.mass))
        pairs = {f"i{a}{b}": (i, j) for i, a in enumerate("xyz") for j, b in enumerate("xyz") if j >= i}
        _add(inertial, "inertia", **{key: _short(part.inertia[at]) for key, at in pairs.items()})
    for role in ("visual", "collision") if part.touches else ("visual",):
        for what, sizes, origin in part.shapes:
            element = _add(link, role)
            _add(element, "origin", xyz=_short(*(1e-3 * origin[:3, 3])), rpy=_short(*to_rpy(origin)))
            keys = {"cylinder": ("radius", "length"), "sphere": ("radius",)}[what]
            _add(
                _add(element, "geometry"), what,
                **{key: _short(1e-3 * size) for key, size in zip(keys, sizes, strict=True)},
            )  # fmt: skip
            if role == "visual":
                _add(element, "material", name="grey")


def _arm_parts(geometry: Geometry) -> list[Part]:
    """The OpenMANIPULATOR-X: shapes are those of `omx.collision`, masses those of `omx.arm`.

    An inertia is that of a solid cylinder in the place of the link: near enough to move, too coarse to control by.
    """
    frames = geometry.chain.frames(ZERO)
    shapes: list[list] = [[] for _ in range(6)]
    ends: list[list] = [[] for _ in range(6)]
    of_link = {"base": 0, "turret": 1, "upper arm": 2, "elbow": 2, "forearm": 3, "hand": 4, "fingers": 4}
    turret = Capsule("turret", (0.0, 0.0, geometry.L1 - 20.0), (0.0, 0.0, geometry.L1), 18.0)
    for name, a, b, radius in (*capsules(ZERO, geometry), turret):
        i = of_link[name]
        into = np.linalg.inv(frames[max(i - 1, 0)])
        a, b = (into[:3, :3] @ point + into[:3, 3] for point in (a, b))
        shapes[i].append(_rod(a, b, radius))
        ends[i] += [a, b]
        if i > 1:  # the others stand upright, with flat ends
            shapes[i] += [("sphere", (radius,), _at(point)) for point in (a, b)]
    parts = [Part(shapes[0], touches=True)]
    for i, (mass, (forward, up)) in enumerate((TURRET, UPPER_ARM, FOREARM, WRIST), start=1):
        into, joint = np.linalg.inv(frames[i - 1]), frames[i - 1][:3, 3] if i > 1 else np.zeros(3)
        centre = into[:3, :3] @ (joint + np.array((forward, 0.0, up))) + into[:3, 3]
        parts.append(Part(shapes[i], mass, centre, _inertia(mass, ends[i][-1] - ends[i][0], shapes[i][0][1][0]), i > 1))
    return [*parts, Part()]


def _row_parts(chain: Chain) -> list[Part]:
    """Any chain: a short cylinder about the axis of each joint, and rods along d and a of its row. No masses."""
    size = chain.size or 100.0
    thin, thick = 0.02 * size, 0.045 * size
    parts = [Part()]
    for row, T in zip(chain.rows, chain.matrices(np.zeros(len(chain))), strict=True):
        corner, end = np.array((0.0, 0.0, float(row.d))), T[:3, 3]
        shapes = [("cylinder", (thick, 2.4 * thick), np.eye(4))]
        shapes += [_rod(a, b, thin) for a, b in ((np.zeros(3), corner), (corner, end)) if np.linalg.norm(b - a) > 1e-6]
        parts.append(Part(shapes))
    return [*parts, Part([("sphere", (1.5 * thin,), np.eye(4))])]


def _rod(a, b, radius: float):
    """A cylinder from `a` to `b` (mm): URDF's stands upright about its middle."""
    z = (b - a) / np.linalg.norm(b - a)
    x = np.cross(np.eye(3)[np.argmin(np.abs(z))], z)
    x /= np.linalg.norm(x)
    upright = rigid(np.column_stack((x, np.cross(z, x), z)), 0.5 * (a + b))
    return "cylinder", (radius, float(np.linalg.norm(b - a))), upright


def _at(point) -> np.ndarray:
    return rigid(np.eye(3), point)


def _inertia(mass: float, along, radius: float) -> np.ndarray:
    """Of a solid cylinder (kg m^2) of this mass (kg), axis (mm) and radius (mm), about its middle."""
    length, radius = 1e-3 * float(np.linalg.norm(along)), 1e-3 * radius
    u = along / np.linalg.norm(along)
    lengthwise, across = 0.5 * mass * radius**2, mass * (3 * radius**2 + length**2) / 12
    return across * np.eye(3) + (lengthwise - across) * np.outer(u, u)


def _add(parent, tag: str, **attributes) -> ElementTree.Element:
    return ElementTree.SubElement(parent, tag, attributes)


def _exact(*values: float) -> str:
    """Numbers to their last digit, for what moves."""
    return " ".join(repr(float(value) + 0.0) for value in values)


def _short(*values: float) -> str:
    """Numbers to six digits, for what is to be seen, and for masses."""
    return " ".join(f"{round(float(value), 12) + 0.0:.6g}" for value in values)


# ---- in ----------------------------------------------------------------------------------------------------


def read(path, *, base: str | None = None, tip: str | None = None, tolerance: float = PARALLEL) -> Chain:
    """The serial chain in a URDF file, from the link `base` (the file's first, if left out) to the link `tip`.

    `tip` may be left out where there is one way only; what branches off the way, such as fingers, is left out. The
    chain's results are told in the frame of the base link, and its tool is the frame of the tip link. `tolerance` is
    that of `from_axes`. Raises `BadInput` for a file that is not URDF, and for what a DH table cannot say: floating
    and planar joints, joints that mimic another, neighbouring axes that are nearly parallel.
    """
    if not isinstance(path, (str, os.PathLike)) or not str(path):
        raise BadInput(f"`path` must be the path of a URDF file; got {shown(path)}.")
    try:
        with open(path, "rb") as file:
            data = file.read(MOST_BYTES + 1)
        described = data.decode("utf-8-sig")
    except (OSError, ValueError) as error:
        raise BadInput(f"cannot read {path}: {error}.") from None
    return parse(described, base=base, tip=tip, tolerance=tolerance)


def parse(described: str, *, base: str | None = None, tip: str | None = None, tolerance: float = PARALLEL) -> Chain:
    """The serial chain in the text of a URDF; the other arguments are those of `read`."""
    robot = _tree(described)
    joints = robot.findall("joint")
    _names(joints, "joints")
    way = [_Joint.of(joint) for joint in _way(joints, _names(robot.findall("link"), "links"), base, tip)]
    T = np.eye(4)
    moving, directions, points = [], [], []
    for joint in way:
        T = T @ joint.origin
        if joint.kind in MOVING:
            moving.append(joint)
            directions.append(T[:3, :3] @ joint.axis)
            points.append(T[:3, 3])
    if not moving:
        raise BadInput(
            f"nothing moves between {base or 'the base'} and {tip or 'the tip'}: all joints there are fixed."
        )
    return from_axes(
        directions, points, T, [joint.kind == "prismatic" for joint in moving],
        limits=[joint.limits for joint in moving], names=[joint.name for joint in moving],
        name=robot.get("name") or "robot", tolerance=tolerance,
    )  # fmt: skip


class _Joint(NamedTuple):
    name: str
    kind: str
    origin: np.ndarray
    axis: np.ndarray
    limits: tuple[float, float]

    @classmethod
    def of(cls, element) -> "_Joint":
        """One joint of a file, in mm; `BadInput` for what no chain here can do."""
        name, kind = element.get("name"), element.get("type")
        where = f"joint {name!r}"
        if kind not in (*MOVING, "fixed"):
            raise BadInput(f"{where} is {kind!r}: a DH table knows joints that turn and joints that slide.")
        if element.find("mimic") is not None:
            raise BadInput(f"{where} mimics another: in a DH table each joint has a value of its own.")
        origin, axis = _told(element, "origin"), _told(element, "axis")
        turn, place = (_three(origin.get(key, "0 0 0"), f"{key} of {where}") for key in ("rpy", "xyz"))
        direction = _three(axis.get("xyz", "1 0 0"), f"the axis of {where}")
        if kind in MOVING and not np.linalg.norm(direction) > 1e-6:
            raise BadInput(f"the axis of {where} points nowhere: {axis.get('xyz')!r}.")
        limits = _limits(element.find("limit"), kind, where)
        return cls(name, kind, rigid(from_rpy(*turn), 1e3 * place), direction, limits)


def _told(element, tag: str) -> dict[str, str]:
    """The attributes of the first `tag` in an element; none where there is no such tag."""
    found = element.find(tag)
    return {} if found is None else found.attrib


def _limits(limit, kind: str, where: str) -> tuple[float, float]:
    if kind in ("continuous", "fixed"):
        return (-inf, inf)
    if limit is None:
        raise BadInput(f"{where} is {kind} and has no <limit>.")
    unit = 1e3 if kind == "prismatic" else 1.0
    low, high = (unit * _one(limit.get(end, "0"), f"{end} of {where}") for end in ("lower", "upper"))
    return low, high


def _one(value: str, what: str) -> float:
    if NUMBER.fullmatch(value.strip()) and abs(number := float(value)) <= MOST_NUMBER:
        return number
    hint = " Run xacro on the file first." if "${" in value else ""
    raise BadInput(f"{what} must be a number that a robot may have, in m or rad; it is {shown(value)}.{hint}")


def _three(value: str, what: str) -> np.ndarray:
    words = value.split()
    if len(words) != 3:
        raise BadInput(f"{what} must be three numbers; it is {shown(value)}.")
    return np.array([_one(word, what) for word in words])


def _names(elements, what: str) -> list[str]:
    names = [element.get("name") or "" for element in elements]
    twice = sorted(name for name, count in Counter(names).items() if count > 1 or not name)
    if twice:
        raise BadInput(f"the file's {what} must have different names; {twice[0]!r} is none, or stands there twice.")
    return names


def _way(joints, links: list[str], base: str | None, tip: str | None) -> list:
    """The elements of the joints from `base` to `tip`, in order."""
    known = set(links)
    ends = [_end(joint, "parent", known) for joint in joints], [_end(joint, "child", known) for joint in joints]
    into = {child: (parent, joint) for parent, child, joint in zip(*ends, joints, strict=True)}
    if len(into) < len(joints):
        raise BadInput("a link of the file hangs on two joints: only chains without loops have a DH table.")
    roots = [link for link in links if link not in into]
    for name, value in (("base", base), ("tip", tip)):
        if value is not None and value not in known:
            raise BadInput(f"`{name}` must be a link of the file, one of {', '.join(links[:20])}; got {shown(value)}.")
    if base is None and len(roots) != 1:
        raise BadInput(f"the file has {len(roots)} first links ({', '.join(roots[:5])}): give `base`.")
    base = roots[0] if base is None else base
    if tip is None:
        tip = _only_tip(into, base)
    way: list = []
    link = tip
    while link != base:
        if link not in into or len(way) > len(joints):
            raise BadInput(f"no way leads from the link {base!r} to the link {tip!r}.")
        link, joint = into[link]
        way.append(joint)
    return way[::-1]


def _end(joint, tag: str, links: set[str]) -> str:
    link = _told(joint, tag).get("link")
    if link not in links:
        raise BadInput(f"joint {joint.get('name')!r} has the {tag} {link!r}, which is no link of the file.")
    return link


def _only_tip(into: dict, base: str) -> str:
    """The last link of the only way from `base`; `BadInput` where it branches.

    In front of the first moving joint, what leads to none is no way: many files have a second base there.
    """
    ahead: dict = {}
    for child, (parent, _) in into.items():
        ahead.setdefault(parent, []).append(child)
    lead_on: set = set()
    for child, (_, joint) in into.items():
        link = child if joint.get("type") != "fixed" else base
        while link != base and link in into and link not in lead_on:
            lead_on.add(link)
            link = into[link][0]
    link, moved = base, False
    for _ in into:
        ways = ahead.get(link, [])
        ways = ways if moved else [way for way in ways if way in lead_on] or ways
        if len(ways) > 1:
            raise BadInput(f"the file branches at the link {link!r} ({', '.join(ways)}): say which way, by `tip`.")
        if not ways:
            break
        link = ways[0]
        moved = moved or into[link][1].get("type") != "fixed"
    return link


def _tree(described) -> ElementTree.Element:
    if not isinstance(described, str):
        raise BadInput(f"a URDF must be a text; got {shown(described)}.")
    if len(described) > MOST_BYTES:
        raise BadInput(f"the file has more than {MOST_BYTES} bytes: not a robot's description.")
    if "<!DOCTYPE" in re.sub("<!--.*?-->", "", described, flags=re.DOTALL):
        raise BadInput("the file has a DOCTYPE: URDF has none, and it may define entities, so it is not read.")
    try:
        robot = ElementTree.fromstring(described)
    except (ElementTree.ParseError, ValueError) as error:
        raise BadInput(f"the file is not XML: {error}.") from None
    if robot.tag != "robot":
        raise BadInput(f"the file describes a <{robot.tag}>, not a <robot>.")
    return robot
