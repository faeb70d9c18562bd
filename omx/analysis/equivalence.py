"""Two DH tables: are they the same robot? The same links and axes may be written with other joint coordinates."""

from dataclasses import dataclass
from itertools import product
from math import degrees, pi, tau

import numpy as np

from ..arrays import as_number, as_rows, wrap
from ..dh import Chain, as_chain
from ..errors import BadInput

#: What counts as the same if no tolerance is given, as a share of the arm's length: 0.04 mm for ours.
SHARE = 1e-4

#: Axes that are further apart than this, in rad and as a share of the arm's length, are other axes: tables are rounded.
OTHER = 0.02

#: How near to a multiple of 15 deg an offset is meant to be one: as a share of it, in exact and in rounded tables.
ROUNDING, ROUNDED = 1e-9, 2e-3

#: Where the search for a joint's offset begins, the steps that it takes, and how many partial answers are kept.
STARTS, STEPS, KEPT = np.arange(8) * pi / 4, 25, 64


@dataclass(frozen=True)
class Coordinates:
    """How to drive `second` as `first` is driven by q: its joint j takes `signs[j] * q[j] + offsets[j]`.

    `gap` (mm) is the largest distance between the two tools that was seen; a turn counts as it would at arm's length.
    """

    first: Chain
    second: Chain
    signs: tuple[int, ...]
    offsets: tuple[float, ...]
    gap: float = 0.0

    def __call__(self, q) -> np.ndarray:
        """Joint values of `first`, (..., n), to those of `second`."""
        q = as_rows(q, "q", len(self.first), f"the joint values of {self.first.name}")
        return q * self.signs + self.offsets

    def __str__(self) -> str:
        parts = []
        for name, sign, offset, row in zip(self.first.names, self.signs, self.offsets, self.first.rows, strict=True):
            size = abs(offset) if row.prismatic else abs(degrees(offset))
            number = f"{size:.2f}".rstrip("0").rstrip(".")
            shift = f" {'+' if offset > 0 else '-'} {number} {'mm' if row.prismatic else 'deg'}" if offset else ""
            if sign < 0 or offset:
                parts.append(f"{name} -> {'-' if sign < 0 else ''}{name}{shift}")
        text = ", ".join(parts) or "the same coordinates"
        return text if self.gap < 1e-6 else f"{text}; the same arm within {self.gap:.2g} mm"


def same_robot(first: Chain, second: Chain, tolerance: float | None = None) -> Coordinates | None:
    """The change of joint coordinates that makes both chains one robot, or None if there is none.

    The offset of every joint is solved for, in either sense of the joint, from the axes that the tables describe; then
    the tool frames are compared at random configurations. The simplest change is returned. `tolerance` (mm): how far
    the tools may be apart, 1/10000 of the arm's length if left out. Raises `BadInput` if the chains differ in the
    number or kind of their joints, or hold symbols.
    """
    first, second = as_chain(first, "first", numbers=True), as_chain(second, "second", numbers=True)
    prismatic = np.array([row.prismatic for row in first.rows])
    if prismatic.tolist() != [row.prismatic for row in second.rows]:
        raise BadInput(f"`first` and `second` must have the same joints; {first!r} and {second!r} have not.")
    size = max(first.size, second.size, 1e-9)
    tolerance = SHARE * size if tolerance is None else as_number(tolerance, "tolerance", "0 mm or more", low=0.0)
    found = []
    for signs, offsets in _candidates(first, second, prismatic, size):
        offsets = _tidy(offsets, prismatic, size, ROUNDING)
        gap = _gap(first, second, signs, offsets, size)
        if gap > 1e-9 * size:  # rounded tables: the same arm nearly, and then with plain offsets, if these will do
            plain = _tidy(offsets, prismatic, size, ROUNDED)
            wider = _gap(first, second, signs, plain, size)
            offsets, gap = (plain, wider) if wider <= tolerance else (offsets, gap)
        if gap <= tolerance:
            changed = int(np.sum((signs < 0) | (offsets != 0)))
            order = (changed, int(np.sum(signs < 0)), float(np.abs(offsets).sum()), -float(offsets.sum()))
            found.append((order, signs.astype(int).tolist(), offsets.tolist(), gap))
    if not found:
        return None
    _, signs, offsets, gap = min(found)
    return Coordinates(first, second, tuple(signs), tuple(offsets), gap)


def _candidates(first: Chain, second: Chain, prismatic, size: float):
    """(signs, offsets) for which the axes of `second`, and its tool, lie where those of `first` do at zero.

    Joint by joint: the axis of joint i depends on the offsets of the joints before it. Each partial answer is kept
    until a later axis rules it out; the last step brings in the tool.
    """
    n = len(prismatic)
    wanted, _ = _axes(first, np.zeros((1, n)), prismatic, size)
    signs, offsets = np.ones((1, n)), np.zeros((1, n))
    for i in range(n + 1):
        signs, offsets = _tried(signs, offsets, i, prismatic)
        goal = wanted[:, : i + 1] if i < n else wanted
        offsets, error = _solved(second, offsets, signs, goal, prismatic, size)
        good = error < OTHER
        signs, offsets = _distinct(signs[good], offsets[good], prismatic, size)
        if not len(signs):
            return
    yield from zip(signs, offsets, strict=True)


def _tried(signs, offsets, i: int, prismatic):
    """Every partial answer with joint i in both senses, and with starts for the offset of the joint before it."""
    starts = STARTS if i and not prismatic[i - 1] else STARTS[:1]
    senses = (1.0, -1.0) if i < len(prismatic) else (1.0,)
    which, sense, start = map(list, zip(*product(range(len(signs)), senses, starts), strict=True))
    signs, offsets = signs[which], offsets[which]
    if i < len(prismatic):
        signs[:, i] = sense
    if i:
        offsets[:, i - 1] = start
    return signs, offsets


def _solved(chain: Chain, offsets, signs, wanted, prismatic, size: float):
    """Gauss and Newton from each of the `offsets` (m, n): the offsets and how far (m,) the axes are from `wanted`.

    `wanted` (1, k, 6): axes as (direction, moment), the last row the tool's if there is one more than joints.
    """
    n, count = len(prismatic), wanted.shape[1]
    sense = np.ones((len(signs), count))
    sense[:, : min(count, n)] = signs[:, :count][:, :n]
    unknown = min(count - 1, n) if count <= n else n
    for _ in range(STEPS):
        axes, slopes = _axes(chain, offsets, prismatic, size, count, unknown)
        error = axes * sense[..., None] - wanted
        if not unknown:
            break
        J = (slopes * sense[..., None, None]).reshape(len(offsets), -1, unknown)
        step = -(np.linalg.pinv(J, rcond=1e-6) @ error.reshape(len(offsets), -1, 1))[..., 0]
        offsets = offsets.copy()
        offsets[:, :unknown] += np.where(prismatic[:unknown], size * step, np.clip(step, -1.0, 1.0))
        if np.abs(step).max() < 1e-14:
            break
    axes, _ = _axes(chain, offsets, prismatic, size, count, unknown)
    return offsets, np.abs(axes * sense[..., None] - wanted).max(axis=(1, 2))


def _axes(chain: Chain, q, prismatic, size: float, count: int | None = None, unknown: int = 0):
    """The joint axes at q (m, n) as screws (m, count, 6), lengths as shares of `size`, and their slopes by q.

    A screw is (direction, moment), of a prismatic joint (0, direction). Beyond the joints come three rows for the tool:
    its x axis, its z axis and its origin, each with a zero.
    """
    frames = chain.frames(q)
    z, p = frames[:, :-1, :3, 2], frames[:, :-1, :3, 3] / size
    slides = prismatic[:, None]
    screws = np.concatenate([np.where(slides, 0.0, z), np.where(slides, z, np.cross(p, z))], axis=-1)
    tool = frames[:, -1, :3]
    zero = np.zeros((len(q), 3))
    rows = [np.concatenate([part, zero], axis=-1) for part in (tool[..., 0], tool[..., 2], tool[..., 3] / size)]
    everything = np.concatenate([screws, np.stack(rows, axis=1)], axis=1)[:, :count]
    if not unknown:
        return everything, None
    slopes = np.zeros((*everything.shape, unknown))
    n = len(prismatic)
    for j in range(unknown):  # a joint turns what comes after it
        w, v = screws[:, j : j + 1, :3], screws[:, j : j + 1, 3:]
        later = everything[:, j + 1 : n]
        slopes[:, j + 1 : n, :3, j] = np.cross(w, later[..., :3])
        slopes[:, j + 1 : n, 3:, j] = np.cross(w, later[..., 3:]) + np.cross(v, later[..., :3])
        if everything.shape[1] > n:
            slopes[:, n:, :3, j] = np.cross(w, everything[:, n:, :3])
            slopes[:, n + 2, :3, j] += v[:, 0]
    return everything, slopes


def _distinct(signs, offsets, prismatic, size: float):
    """The partial answers without repetitions, those with the smallest offsets first, `KEPT` at most."""
    turned = np.where(prismatic, offsets, wrap(offsets))
    rounded = np.round(np.where(prismatic, turned / size, np.exp(1j * turned)), 3)
    keys = [(tuple(s), tuple(r)) for s, r in zip(signs.tolist(), rounded.tolist(), strict=True)]
    order = sorted(range(len(keys)), key=lambda i: (float(np.sum(signs[i] < 0)), float(np.abs(turned[i]).sum())))
    kept = list({keys[i]: i for i in reversed(order)}.values())[::-1][:KEPT]
    return signs[kept], turned[kept]


def _tidy(offsets, prismatic, size: float, near: float):
    """Offsets in (-pi, pi], those that are 0, or a multiple of 15 deg, but for `near` (a share of 15 deg) made so."""
    turned = np.where(prismatic, offsets, wrap(offsets))
    step = np.where(prismatic, size, tau / 24)
    whole = np.where(prismatic, 0.0, np.round(turned / step) * step)
    tidy = np.where(np.abs(turned - whole) < near * step, whole, turned)
    return np.where(~prismatic & (tidy == -pi), pi, tidy) + 0.0


def _gap(first: Chain, second: Chain, signs, offsets, size: float) -> float:
    """The largest distance (mm) between the tools at random configurations."""
    q = np.random.default_rng(0).uniform(-2.0, 2.0, (64, len(signs)))
    apart = second.fk(q * signs + offsets) - first.fk(q)
    return float(max(np.linalg.norm(apart[:, :3, 3], axis=1).max(), size * np.abs(apart[:, :3, :3]).max()))
