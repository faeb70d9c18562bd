"""Two DH tables: are they the same robot? The same links and axes may be written with other joint coordinates."""

from dataclasses import dataclass
from itertools import product
from math import degrees, pi

import numpy as np

from ..dh import Chain
from ..errors import BadInput

_QUARTERS = (0.0, pi / 2, pi, -pi / 2)


@dataclass(frozen=True)
class Coordinates:
    """How to drive `second` as `first` is driven by q: its joint j takes `signs[j] * q[j] + offsets[j]`."""

    first: Chain
    second: Chain
    signs: tuple[int, ...]
    offsets: tuple[float, ...]

    def __call__(self, q) -> np.ndarray:
        """Joint values of `first`, (..., n), to those of `second`."""
        return np.asarray(q, dtype=float) * self.signs + self.offsets

    def __str__(self) -> str:
        lines = []
        for name, sign, offset, row in zip(self.first.names, self.signs, self.offsets, self.first.rows, strict=True):
            shift = f" {'+' if offset > 0 else '-'} {abs(degrees(offset)):.0f} deg" if offset else ""
            if sign < 0 or offset:
                lines.append(f"{name} -> {'-' if sign < 0 else ''}{name}{shift if not row.prismatic else ''}")
        return ", ".join(lines) or "the same coordinates"


def same_robot(first: Chain, second: Chain, tolerance: float = 1e-9) -> Coordinates | None:
    """The change of joint coordinates that makes both chains one robot, or None if there is none.

    It tries every sense of every joint and every offset of quarter turns (revolute) against random configurations:
    the base and tool frames must agree to `tolerance` (mm, and the entries of the rotation). Simplest change first.
    Raises `BadInput` if the chains differ in the number or kind of their joints.
    """
    kinds = [[row.prismatic for row in chain.rows] for chain in (first, second)]
    if kinds[0] != kinds[1]:
        raise BadInput(f"`first` and `second` must have the same joints; {first!r} and {second!r} have not.")
    signs, offsets = _candidates(kinds[0])
    rng = np.random.default_rng(0)
    for _ in range(3):
        q = rng.uniform(-1.0, 1.0, len(kinds[0]))
        error = np.abs(second.fk(q * signs + offsets) - first.fk(q)).max(axis=(-2, -1))
        signs, offsets = signs[error <= tolerance], offsets[error <= tolerance]
        if not len(signs):
            return None
    return Coordinates(first, second, tuple(signs[0].astype(int).tolist()), tuple(offsets[0].tolist()))


def _candidates(prismatic: list[bool]) -> tuple[np.ndarray, np.ndarray]:
    """All (signs, offsets), those that change fewest joints first."""
    choices = [
        [(sign, offset) for sign in (1.0, -1.0) for offset in ((0.0,) if slides else _QUARTERS)] for slides in prismatic
    ]
    table = np.array(list(product(*choices)))
    changed = ((table[..., 0] < 0) | (table[..., 1] != 0)).sum(axis=1)
    table = table[np.argsort(changed, kind="stable")]
    return table[..., 0], table[..., 1]
