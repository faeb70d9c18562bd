"""The arm's lengths by name, and its chain. Chapter 03 derives and writes the DH table."""

from functools import cached_property
from math import isclose, nan
from typing import TYPE_CHECKING

from .arm import COURSE_LENGTHS, LIMITS, MAKER_LENGTHS
from .arrays import as_number, shown
from .dh import Chain, as_chain
from .errors import BadInput, OmxError
from .generated import fk as _fk

#: No length (mm) of an arm is larger: its square, and that of a place beyond it, stay finite.
LONGEST = 1e6


class Geometry:
    """Named lengths (mm) and angles (rad) of an arm, read as attributes: `COURSE.L2`. Immutable.

    `values` holds them in the order in which the generated functions take them. `backwards`: the lengths L... below 0,
    with which an arm has forward kinematics, but no inverse here.
    """

    name: str
    values: tuple[float, ...]
    backwards: tuple[str, ...]
    _lengths: dict[str, float]

    if TYPE_CHECKING:  # a reader's table may have other lengths than L1 .. L4 and delta

        def __getattr__(self, key: str) -> float: ...

    def __init__(self, name: str, **lengths: float):
        if not isinstance(name, str):
            raise BadInput(f"a geometry's name must be a text; got {shown(name)}.")
        wrong = sorted(set(lengths) ^ set(_fk.PARAMETERS))
        if wrong:
            wanted = ", ".join(_fk.PARAMETERS)
            raise BadInput(f"geometry `{name}` must give {wanted}; wrong or missing: {', '.join(wrong)}.")
        ordered = {key: _as_length(lengths[key], key) for key in _fk.PARAMETERS}
        backwards = tuple(key for key, value in ordered.items() if key.startswith("L") and value < 0)
        self.__dict__.update(ordered, name=name, values=tuple(ordered.values()), backwards=backwards, _lengths=ordered)

    def __setattr__(self, key, value):
        raise AttributeError(f"a Geometry does not change; make another with .replace({key}={value!r}).")

    def __delattr__(self, key):
        raise AttributeError(f"a Geometry does not change; {key} stays.")

    def __repr__(self) -> str:
        return self.__dict__.get("shown") or str(self)  # `geometry=omx.COURSE` in a signature, not five numbers

    def __str__(self) -> str:
        return f"Geometry({self.name!r}, {', '.join(f'{key}={value:g}' for key, value in self._lengths.items())})"

    def _repr_pretty_(self, printer, cycle) -> None:
        printer.text(str(self))

    def __eq__(self, other) -> bool:
        return isinstance(other, Geometry) and self.values == other.values

    def __hash__(self) -> int:
        return hash(self.values)

    def replace(self, name: str | None = None, **lengths: float) -> "Geometry":
        """A copy with some lengths changed."""
        return Geometry(name if name is not None else f"{self.name}, changed", **(self._lengths | lengths))

    @cached_property
    def chain(self) -> Chain:
        """The DH table with these lengths, as a `Chain` with the arm's joint limits."""
        return Chain(_fk.dh_rows(*self.values), limits=LIMITS, name="OpenMANIPULATOR-X")


def as_geometry(value) -> Geometry:
    """`value`, if it is a `Geometry`; `BadInput` otherwise."""
    if isinstance(value, Geometry):
        return value
    raise BadInput(
        "`geometry` must be a Geometry, such as omx.COURSE, omx.MAKER or omx.COURSE.replace(L4=150); got "
        f"{shown(value)}. (Joint angles come before it: omx.solve_ik(pose, start), omx.fk(q).)"
    )


def as_arm(value, numbers: bool = False) -> Geometry | Chain:
    """`value`, if it is a `Geometry` or a `Chain`, this without symbols where `numbers` are wanted; else `BadInput`."""
    return as_chain(value, "geometry", numbers) if isinstance(value, Chain) else as_geometry(value)


def _as_length(value, key: str) -> float:
    return as_number(value, key, f"a finite number in {'rad' if key == 'delta' else 'mm'}", -LONGEST, LONGEST)


#: The lengths that the course's drawing gives, and that chapter 03 wrote.
COURSE = Geometry("course", **_fk.PARAMETERS)
COURSE.__dict__["shown"] = "omx.COURSE"

#: The maker's lengths. A reader's own table may do without some of them: it must not stop `import omx`.
MAKER = COURSE.replace("maker", **{key: value for key, value in MAKER_LENGTHS.items() if key in _fk.PARAMETERS})


def _differences() -> str:
    """What chapter 03 has been given instead of the course's lengths, in words; '' for the course's own."""
    values = COURSE._lengths
    return ", ".join(
        f"{key} = {values[key]:g} instead of {course:.6g}" if key in values else f"no {key}"
        for key, course in COURSE_LENGTHS.items()
        if not isclose(values.get(key, nan), course, abs_tol=1e-9)
    )


#: What every error of ours ends with in a notebook whose arm is not the course's.
OmxError.note = (
    f"(Your arm is not the course's: {found}. The points and numbers of the text are made for the course's.)"
    if (found := _differences())
    else ""
)


def other_arm() -> bool:
    """Has chapter 03 written another arm than the course's? Then say that what the text claims need not hold for it.

    For claims: `assert x < 1 or omx.other_arm()`.
    """
    if OmxError.note:
        print("This comparison is the course's arm's alone, and does not hold here.", OmxError.note)
    return bool(OmxError.note)
