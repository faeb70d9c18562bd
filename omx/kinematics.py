"""Forward and inverse kinematics and the Jacobian: the face of the generated formulas, for one pose or many.

Positions are in mm in the base frame (z up along the axis of joint 1), angles in rad. `pitch` is the angle of
the last link above the horizontal, -(q2 + q3 + q4). Derived in chapters 03, 05 and 07.
"""

import warnings
from functools import lru_cache
from math import nan, pi, remainder, tau
from pathlib import Path
from typing import NamedTuple

import numpy as np

from .arm import HOME, LIMITS
from .arrays import Four, as_four, as_four_or_rows, as_rows, fill, in_blocks, is_foreign, namespace, stacked, wrap
from .dh import as_limits, clipped, limit_violations
from .errors import BadInput, JointLimit, Unreachable, Violation, slip_of_unit
from .generated import CHAPTERS
from .generated import fk as _fk
from .generated import ik as _ik
from .generated import jacobian as _jacobian
from .geometry import COURSE, Geometry, as_geometry

#: cos(bend) may exceed 1 by this much before a pose counts as out of reach: rounding, below 1e-9 mm.
REACH_SLACK = 1e-13
WITHIN = 1.0 + REACH_SLACK

#: Joint angles may exceed a limit by this much (rad): rounding in the inverse.
LIMIT_SLACK = 1e-9

#: Nearer to the axis of joint 1 than this (mm), q1 is free.
ON_AXIS = 1e-10

JOINT_ANGLES = "the four joint angles in rad"
TASK_POSE = "x, y, z in mm and pitch in rad"

#: The four branches in the order in which `ik` returns them: (front, elbow_up).
BRANCHES = ((True, True), (True, False), (False, True), (False, False))


def branch_name(front: bool, elbow_up: bool) -> str:
    """A branch in words: `front, elbow up`."""
    return f"{'front' if front else 'back'}, elbow {'up' if elbow_up else 'down'}"


class Pose(NamedTuple):
    """Where the tool is: x, y, z in mm in the base frame, pitch in rad above the horizontal, in (-pi, pi]."""

    x: float
    y: float
    z: float
    pitch: float


class Branches(NamedTuple):
    """The four branches of each of many poses, in the order of `BRANCHES`.

    `q` (..., 4 branches, 4 joints) rad in (-pi, pi], NaN where out of reach; `reachable`, `legal` (..., 4 branches).
    """

    q: np.ndarray
    reachable: np.ndarray
    legal: np.ndarray


#: The end of a turn that does not belong to it: angles are in (-pi, pi].
_OPEN_END = -pi

#: Makes a Pose in half the time that calling `Pose(...)` takes.
_new = tuple.__new__


class IKSolution(Four):
    """One branch of the inverse. It can stand wherever four joint angles can: `omx.fk(solution)`.

    `q`: four angles (rad) in (-pi, pi], None where out of reach. `front`: the arm faces the target, and does not
    reach over its back. `elbow_up`: the forearm bends down from the upper arm's own direction (bend > 0); the elbow
    is above the line from shoulder to wrist if the wrist is in front of the shoulder, below it if behind.

    The verdicts are worked out when they are read, by `limits` and by what the formulas were `asked`: pose, lengths.
    """

    __slots__ = ("_asked", "_limits", "elbow_up", "front", "q")

    def __init__(self, q, front, elbow_up, limits, asked):
        self.q: tuple[float, float, float, float] | None = q
        self.front: bool = front
        self.elbow_up: bool = elbow_up
        self._limits = limits
        self._asked = asked

    @property
    def reachable(self) -> bool:
        """Is the wrist within reach?"""
        return self.q is not None

    @property
    def missing(self) -> float:
        """How far (mm) the wrist is out of reach; 0 if it is not."""
        return 0.0 if self.q is not None else _missing(self._asked)[not self.front]

    @property
    def violations(self) -> tuple[Violation, ...]:
        """Each joint that is outside its limits."""
        if self.q is None or _inside(self.q, self._limits):
            return ()
        return limit_violations(self.q, self._limits, slack=LIMIT_SLACK)

    @property
    def legal(self) -> bool:
        """Within reach, and every joint within its limits."""
        return self.q is not None and _inside(self.q, self._limits)

    @property
    def branch(self) -> str:
        """The branch in words: `front, elbow up`."""
        return branch_name(self.front, self.elbow_up)

    def _angles(self) -> tuple[float, float, float, float]:
        if self.q is None:
            raise BadInput(f"the branch `{self.branch}` has no joint angles: {self.missing:.3f} mm out of reach.")
        return self.q

    def __iter__(self):
        return iter(self._angles())

    def __len__(self) -> int:
        return 4

    def __getitem__(self, index):
        return self._angles()[index]

    def __repr__(self) -> str:
        if self.q is None:
            return f"IKSolution({self.branch}: out of reach by {self.missing:.3f} mm)"
        angles = ", ".join(f"{angle / pi * 180 + 0.0:.3f}" for angle in self.q)
        verdict = "legal" if self.legal else "; ".join(str(v) for v in self.violations)
        return f"IKSolution({self.branch}: q = ({angles}) deg, {verdict})"


def fk(q, geometry: Geometry = COURSE) -> np.ndarray:
    """T_base_tool, (..., 4, 4), mm, for joint angles `q`, (..., 4), rad. Raises `BadInput`."""
    q = as_four_or_rows(q, "q", JOINT_ANGLES)
    if geometry is not COURSE:
        as_geometry(geometry)
    if type(q) is tuple:
        return np.array(_fk.transform(*(q + geometry.values)))
    return _batch(_fk.transform_batch, q, geometry, (4, 4))


def pose(q, geometry: Geometry = COURSE):
    """The tool's `Pose` (plain floats) for four joint angles; an (..., 4) array for `q` of shape (..., 4), rad.

    x, y, z in mm, pitch in rad, in (-pi, pi]. Raises `BadInput`.
    """
    q = as_four_or_rows(q, "q", JOINT_ANGLES)
    if geometry is not COURSE:
        as_geometry(geometry)
    if type(q) is not tuple:
        return _batch(_fk.pose_batch, q, geometry, (4,))
    found = _fk.pose(*(q + geometry.values))
    return _new(Pose, found if found[3] > _OPEN_END else (*found[:3], pi))


def frames(q, geometry: Geometry = COURSE) -> np.ndarray:
    """T_0_0 .. T_0_4, (..., 5, 4, 4), mm: the base frame, then the frame that moves with each joint."""
    q = as_four_or_rows(q, "q", JOINT_ANGLES)
    if geometry is not COURSE:
        as_geometry(geometry)
    if is_foreign(q):
        base = tuple(tuple(float(i == j) for j in range(4)) for i in range(4))
        return _batch(lambda *columns: (base, *_fk.frames_batch(*columns)), q, geometry, (5, 4, 4))
    if type(q) is not tuple:
        return geometry.chain.frames(q)
    out = np.empty((5, 4, 4))
    out[0] = np.eye(4)
    out[1:] = _fk.frames(*(q + geometry.values))
    return out


def jacobian(q, geometry: Geometry = COURSE) -> np.ndarray:
    """The geometric Jacobian, (..., 6, 4): linear rows first (mm/rad), then angular rows, base frame."""
    q = as_four_or_rows(q, "q", JOINT_ANGLES)
    if geometry is not COURSE:
        as_geometry(geometry)
    if type(q) is tuple:
        return np.array(_jacobian.jacobian(*(q + geometry.values)))
    return _batch(_jacobian.jacobian_batch, q, geometry, (6, 4))


def ik(pose, geometry: Geometry = COURSE, limits=LIMITS):
    """All four branches for a task pose [x, y, z, pitch] (mm, rad): front/up, front/down, back/up, back/down.

    One pose gives four `IKSolution`s, each with a verdict: out of reach (and by how much), or each joint limit that it
    breaks. Many poses, (..., 4), give `Branches`: arrays, of the library that the poses come from. On the
    axis of joint 1, where q1 is free, q1 is 0 in front and pi at the back; `solve_ik` chooses it. Raises `BadInput`.

    Args:
        pose: x, y, z in mm in the base frame, pitch in rad above the horizontal; (4,) or (..., 4).
        geometry: the arm's lengths.
        limits: one (low, high) in rad for each of the four joints, infinite where there is none.
    """
    target = as_four_or_rows(pose, "pose", TASK_POSE)
    if geometry is not COURSE:
        _invertible(geometry)
    if limits is not LIMITS:
        limits = as_limits(limits, 4)
    if type(target) is tuple:
        return _branches(target, geometry, limits)
    return _many(target, geometry, limits)


def solve_ik(pose, start=HOME, geometry: Geometry = COURSE, limits=LIMITS) -> IKSolution:
    """The legal solution whose joints have the least way to go from `start` (rad).

    Raises `Unreachable` (how far, and the nearest reachable pose), `JointLimit` (the branch that comes closest to its
    limits, and by how much each joint exceeds them), or `BadInput`. On the axis of joint 1, q1 is that of `start`.

    Args:
        pose: x, y, z in mm in the base frame, pitch in rad above the horizontal; (4,).
        start: where the joints are now, (4,) rad.
        geometry: the arm's lengths.
        limits: one (low, high) in rad for each of the four joints, infinite where there is none.
    """
    target = as_four(pose, "pose", TASK_POSE)
    start = as_four(start, "start", JOINT_ANGLES)
    if geometry is not COURSE:
        _invertible(geometry)
    if limits is not LIMITS:
        limits = as_limits(limits, 4)
    solutions = _branches(target, geometry, limits)
    if max(abs(target[0]), abs(target[1])) <= ON_AXIS:
        solutions = [_turned(s, start[0], limits) for s in solutions[:2]]  # the others are these, half a turn on
    legal = [s for s in solutions if s.legal]
    if legal:
        return min(legal, key=lambda s: sum((a - b) ** 2 for a, b in zip(s.q, start, strict=True)))
    reachable = [s for s in solutions if s.reachable]
    if reachable:
        least = min(reachable, key=lambda s: max(v.excess for v in s.violations))
        asked = slip_of_unit(target)
        none = f"no legal branch.{asked} Nearest is" if asked else "no legal branch; nearest is"
        raise JointLimit(least.violations, clipped(least.q, limits), f"{none} {least.branch}")
    raise _unreachable(target, solutions, geometry)


def ik_batch(poses, geometry: Geometry = COURSE, limits=LIMITS) -> Branches:
    """`ik` for a table of poses (N, 4): q (N, 4 branches, 4 joints), reachable (N, 4), legal (N, 4)."""
    if is_foreign(poses):
        return ik(poses, geometry, limits)
    poses = as_rows(poses, "poses", 4, TASK_POSE)
    if poses.ndim != 2:
        raise BadInput(f"`poses` must have shape (N, 4); got {poses.shape}. For one pose use `ik`.")
    if geometry is not COURSE:
        _invertible(geometry)
    return _many(poses, geometry, as_limits(limits, 4))


def _many(poses, geometry, limits) -> Branches:
    """The branches of poses (..., 4), NumPy's or of another library, computed on columns."""
    _branches(HOME, geometry, limits)  # says so if these lengths have no inverse
    if is_foreign(poses):
        return Branches(*_ik_foreign(poses, geometry, limits))
    rows = poses.reshape(-1, 4)
    q = np.empty((4, 4, len(rows)))  # columns, each written in one run
    reachable = np.empty((4, len(rows)), dtype=bool)
    legal = np.empty((4, len(rows)), dtype=bool)
    for piece, columns in in_blocks(rows):
        _ik_block(columns, geometry, limits, q[..., piece], reachable[:, piece], legal[:, piece])
    found = q.transpose(2, 0, 1), reachable.T, legal.T
    return Branches(*(part.reshape(*poses.shape[:-1], *part.shape[1:]) for part in found))


def _invertible(geometry) -> None:
    """`BadInput` for an arm with a length below 0: what is within reach of it is another ring."""
    if as_geometry(geometry).backwards:
        raise BadInput(f"{geometry} has no inverse here: {', '.join(geometry.backwards)} must not be below 0.")


def _asked(target, geometry):
    """What the formulas take of a pose and the lengths.

    No minus zero, which would turn q1 by pi, and a pitch within one turn: of a large pitch the formulas' q4 and sines
    round differently; both must speak of the same angle.
    """
    x, y, z, pitch = target
    return (x + 0.0, y + 0.0, z, remainder(pitch, tau), *geometry.values)


@lru_cache(maxsize=4)
def _missing(asked) -> tuple[float, float]:
    """How far (mm) front and back are out of reach: two branches have the same, and want it one after the other."""
    return _ik.missing(*asked)


def _branches(target, geometry, limits):
    asked = _asked(target, geometry)
    try:
        *angles, D_front, D_back = _ik.branches(*asked)
    except ZeroDivisionError:
        raise BadInput(f"{geometry} has no inverse: a link of length 0 makes the formulas divide by 0.") from None
    solutions = []
    for q, (front, elbow_up) in zip(angles, BRANCHES, strict=True):
        if not abs(D_front if front else D_back) <= WITHIN:
            q = None
        elif -pi in q:
            q = tuple(pi if angle == -pi else angle for angle in q)
        solutions.append(IKSolution(q, front, elbow_up, limits, asked))
    return tuple(solutions)


def _inside(q, limits) -> bool:
    """No violations, decided without a loop."""
    (low1, high1), (low2, high2), (low3, high3), (low4, high4) = limits
    q1, q2, q3, q4 = q
    return (
        low1 - LIMIT_SLACK <= q1 <= high1 + LIMIT_SLACK
        and low2 - LIMIT_SLACK <= q2 <= high2 + LIMIT_SLACK
        and low3 - LIMIT_SLACK <= q3 <= high3 + LIMIT_SLACK
        and low4 - LIMIT_SLACK <= q4 <= high4 + LIMIT_SLACK
    )


def _turned(solution: IKSolution, q1: float, limits) -> IKSolution:
    """The solution with q1 as near as its limits allow: for poses on the axis of joint 1, where q1 is free."""
    if solution.q is None:
        return solution
    low, high = limits[0]
    first = remainder(min(max(remainder(q1, tau), low), high), tau)
    q = (first if first > -pi else pi, *solution.q[1:])
    return IKSolution(q, solution.front, solution.elbow_up, limits, solution._asked)


def _unreachable(target, solutions, geometry) -> Unreachable:
    """The error with the pose that the wrist reaches when it stretches (or folds) towards the target."""
    best = min(solutions, key=lambda s: s.missing)
    angles = _ik.branches(*_asked(target, geometry))[solutions.index(best)]
    return Unreachable(Pose(*target), best.missing, pose(angles, geometry))


def _batch(function, q, geometry: Geometry, shape: tuple[int, ...]):
    """What a generated batch function gives for `q` (..., 4): (..., *shape), of the library that `q` comes from."""
    if is_foreign(q):
        columns = [q[..., j] for j in range(4)]
        return stacked(function(*columns, *geometry.values), columns[0])
    rows = q.reshape(-1, 4)
    out = np.empty((len(rows), *shape))
    for piece, columns in in_blocks(rows):
        fill(out[piece], function(*columns, *geometry.values))
    return out.reshape(*q.shape[:-1], *shape)


def _ik_foreign(poses, geometry: Geometry, limits):
    """`ik_batch` for an array (..., 4) of another library: without blocks, and without a look at its values."""
    xp = namespace(poses)
    x, y, z, pitch = (poses[..., j] for j in range(4))
    *angles, D_front, D_back = _ik.branches_batch(x + 0.0, y + 0.0, z, wrap(pitch), *geometry.values)
    within = {front: xp.abs(D) <= WITHIN for front, D in ((True, D_front), (False, D_back))}
    q, legal = [], []
    for (front, _), (q1, *rest) in zip(BRANCHES, angles, strict=True):
        joints = (xp.where(q1 == -pi, pi, q1), *rest)
        inside = within[front]
        for angle, (low, high) in zip(joints, limits, strict=True):
            inside = inside & (angle >= low - LIMIT_SLACK) & (angle <= high + LIMIT_SLACK)
        q.append(tuple(xp.where(within[front], angle, nan) for angle in joints))
        legal.append(inside)
    reachable = tuple(within[front] for front, _ in BRANCHES)
    return stacked(tuple(q), x), stacked(reachable, x), stacked(tuple(legal), x)


def _ik_block(columns, geometry, limits, q, reachable, legal) -> None:
    """Fill q (4, 4, n), reachable and legal (4, n) for one block of poses, (4, n)."""
    x, y, z, pitch = columns
    if np.abs(pitch).max() > tau:
        pitch = np.fmod(pitch, tau)
    with np.errstate(over="ignore"):  # poses so far away that their squares overflow are out of reach
        *angles, D_front, D_back = _ik.branches_batch(x + 0.0, y + 0.0, z, pitch, *geometry.values)  # as in `_asked`
    within = {front: np.abs(D) <= WITHIN for front, D in ((True, D_front), (False, D_back))}
    blank = {front: np.where(reached, 0.0, np.nan) for front, reached in within.items()}
    for b, ((front, _), joints) in enumerate(zip(BRANCHES, angles, strict=True)):
        joints[0][joints[0] == -pi] = pi  # the arc tangent's range is closed at both ends
        reachable[b] = legal[b] = within[front]
        for column, angle, (low, high) in zip(q[b], joints, limits, strict=True):
            np.add(angle, blank[front], out=column)  # NaN where out of reach
            legal[b] &= angle >= low - LIMIT_SLACK
            legal[b] &= angle <= high + LIMIT_SLACK


# ---- do the generated modules belong together? ----

_STEP = 1e-6  # rad


def stale(fk=_fk, ik=_ik, jacobian=_jacobian) -> list[str]:
    """The chapters to run again, because what they wrote is for another DH table than that of `fk`."""
    values = tuple(fk.PARAMETERS.values())
    wrong = []
    for name, agrees, module in (("ik", _inverse_agrees, ik), ("jacobian", _jacobian_agrees, jacobian)):
        try:
            good = agrees(fk, module, values)
        except Exception:  # the table has other parameters, or lengths that the formulas divide by
            good = False
        if not good:
            wrong.append(CHAPTERS[name][:2])
    return wrong


def warn_if_stale() -> None:
    """Say once, on import, which chapters must be run for `omx.ik` and `omx.jacobian` to be right."""
    chapters = stale()
    if chapters:
        old, them = " and ".join(chapters), "it" if len(chapters) == 1 else "them"
        warnings.warn(
            f"chapter {CHAPTERS['fk'][:2]} has written another DH table than chapter {old} was run with: "
            f"until you run {them} again, omx.ik and omx.jacobian may answer for the old arm.",
            stacklevel=3,
        )


def _inverse_agrees(fk, ik, values) -> bool:
    """One of the four branches of a pose of the arm is where the pose came from."""
    branches = ik.branches(*fk.pose(*HOME, *values), *values)[:4]
    return any(all(abs(remainder(a - b, tau)) < 1e-6 for a, b in zip(q, HOME, strict=True)) for q in branches)


def _jacobian_agrees(fk, jacobian, values) -> bool:
    """The columns of the Jacobian are differences of the position."""

    def place(q):
        return np.array(fk.pose(*q, *values)[:3])

    columns = [(place(HOME + step) - place(HOME - step)) / (2 * _STEP) for step in _STEP * np.eye(4)]
    return np.allclose(np.transpose(columns), jacobian.jacobian(*HOME, *values)[:3], rtol=0, atol=1e-3)


# ---- has a chapter written another arm since? ----


def _on_disk() -> dict[str, bytes | None]:
    """The generated modules as files: name -> bytes, None where one is gone."""
    found = {}
    for module in (_fk, _ik, _jacobian):
        path = Path(str(module.__file__))
        found[path.stem] = path.read_bytes() if path.exists() else None
    return found


_IMPORTED = _on_disk()
_TOLD: dict[str, bytes | None] = {}


def replaced() -> list[str]:
    """The generated modules that are not on disk any more as this Python has imported them."""
    return [name for name, text in _on_disk().items() if text != _IMPORTED[name]]


def warn_if_replaced() -> None:
    """Say that this notebook still has the old arm, once for each time that a chapter writes another one."""
    names = replaced()
    if names and _on_disk() != _TOLD:
        _TOLD.update(_on_disk())
        warnings.warn(
            f"omx.generated.{' and '.join(names)} was written anew after this notebook had imported it, so you still "
            "see the old arm here. Choose Kernel > Restart Kernel, then run the cells again.",
            stacklevel=3,
        )
