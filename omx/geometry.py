"""The arm's lengths, joint limits and named poses: data only. The DH table comes from the chapter that derives it."""

from functools import cached_property
from math import atan2, hypot

from .dh import Chain
from .errors import BadInput
from .generated import fk as _fk

#: Joint limits (rad), from the maker's current URDF: one (low, high) a joint.
LIMITS = ((-3.141592653589793, 3.141592653589793), (-1.5, 1.5), (-1.5, 1.4), (-1.7, 1.97))

#: All joints at zero: the tool points forward, (274, 0, 204.765) mm.
ZERO = (0.0, 0.0, 0.0, 0.0)

#: The maker's home pose: the arm folded back over itself, tool level.
HOME = (0.0, -1.05, 0.35, 0.70)


class Geometry:
    """Named lengths (mm) and angles (rad) of an arm, read as attributes: `COURSE.L2`. Immutable.

    `values` holds them in the order in which the generated functions take them.
    """

    def __init__(self, name: str, **lengths: float):
        unknown = set(lengths) ^ set(_fk.PARAMETERS)
        if unknown:
            wanted = ", ".join(_fk.PARAMETERS)
            raise BadInput(f"geometry `{name}` must give {wanted}; wrong or missing: {', '.join(sorted(unknown))}.")
        values = {key: float(lengths[key]) for key in _fk.PARAMETERS}
        self.__dict__.update(values, name=name, values=tuple(values.values()))

    def __setattr__(self, key, value):
        raise AttributeError(f"a Geometry does not change; make another with .replace({key}={value!r}).")

    def __repr__(self) -> str:
        lengths = ", ".join(f"{key}={value:g}" for key, value in zip(_fk.PARAMETERS, self.values, strict=True))
        return f"Geometry({self.name!r}, {lengths})"

    def __eq__(self, other) -> bool:
        return isinstance(other, Geometry) and self.values == other.values

    def __hash__(self) -> int:
        return hash(self.values)

    def replace(self, name: str | None = None, **lengths: float) -> "Geometry":
        """A copy with some lengths changed."""
        same = dict(zip(_fk.PARAMETERS, self.values, strict=True))
        return Geometry(name or f"{self.name}, changed", **(same | lengths))

    @cached_property
    def chain(self) -> Chain:
        """The DH table with these lengths, as a `Chain` with the arm's joint limits."""
        return Chain(_fk.dh_rows(*self.values), limits=LIMITS, name="OpenMANIPULATOR-X")


#: The lengths that the course's drawing gives, and that chapter 03 wrote.
COURSE = Geometry("course", **_fk.PARAMETERS)

#: The maker's URDF: a shoulder 0.5 mm lower and an upper arm whose dog-leg is 128 up, 24 forward.
MAKER = COURSE.replace("maker", L1=76.5, L2=hypot(128, 24), delta=atan2(24, 128))
