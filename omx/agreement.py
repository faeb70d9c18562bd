"""Do the generated modules belong together? A reader who edits the DH table has to run chapters 04 and 05 as well."""

import warnings
from math import remainder, tau

from .generated import fk, ik, jacobian
from .geometry import HOME

_STEP = 1e-6


def stale(fk=fk, ik=ik, jacobian=jacobian) -> list[str]:
    """The chapters to run again, because what they wrote is for another DH table than that of `fk`."""
    values = tuple(fk.PARAMETERS.values())
    wrong = []
    for chapter, agrees, module in (("04", _inverse_agrees, ik), ("05", _jacobian_agrees, jacobian)):
        try:
            good = agrees(fk, module, values)
        except TypeError:  # the table has other parameters
            good = False
        if not good:
            wrong.append(chapter)
    return wrong


def warn_if_stale() -> None:
    """Say once, on import, which chapters must be run for `omx.ik` and `omx.jacobian` to be right."""
    chapters = stale()
    if chapters:
        warnings.warn(
            f"chapter 03 has written another DH table than chapter {' and '.join(chapters)} was run with: until you "
            f"run {'it' if len(chapters) == 1 else 'them'} again, omx.ik and omx.jacobian may answer for the old arm.",
            stacklevel=3,
        )


def _inverse_agrees(fk, ik, values) -> bool:
    """One of the four branches of a pose of the arm is where the pose came from."""
    branches = ik.branches(*fk.pose(*HOME, *values), *values)[:4]
    return any(all(abs(remainder(a - b, tau)) < 1e-6 for a, b in zip(q, HOME, strict=True)) for q in branches)


def _jacobian_agrees(fk, jacobian, values) -> bool:
    """The columns of the Jacobian are differences of the position."""
    J = jacobian.jacobian(*HOME, *values)
    for j in range(4):
        more, less = ([q + s * _STEP * (i == j) for i, q in enumerate(HOME)] for s in (1, -1))
        ends = zip(fk.pose(*more, *values)[:3], fk.pose(*less, *values)[:3], strict=True)
        if any(abs((a - b) / (2 * _STEP) - J[i][j]) > 1e-3 for i, (a, b) in enumerate(ends)):
            return False
    return True
