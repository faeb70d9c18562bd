"""What the notebooks write: the arm's formulas. Never edited by hand.

A reader's chapter 03 writes here, too. Whatever it has written, `import omx` goes on: a module that cannot be used is
replaced, with a warning, by the one in `shipped`, for as long as this Python runs.
"""

import warnings
from importlib import import_module
from types import ModuleType

#: The modules that `omx` is made of, and the chapters that write them.
CHAPTERS = {
    "fk": "03-forward-kinematics",
    "ik": "05-inverse-kinematics",
    "jacobian": "07-jacobian",
    "gravity": "08-weight",
    "polynomials": "21-very-many-poses",
}

#: What the package itself calls in each of them.
NEEDED = {
    "fk": ("PARAMETERS", "dh_rows", "pose", "pose_batch", "transform", "transform_batch", "frames", "frames_batch"),
    "ik": ("branches", "branches_batch", "missing"),
    "jacobian": ("jacobian", "jacobian_batch"),
    "gravity": ("torques", "torques_batch"),
}


def _usable(name: str) -> ModuleType:
    """The module of this name; the shipped one, with a warning, where it is damaged."""
    try:
        module = import_module(f"{__name__}.{name}")
        missing = [needed for needed in NEEDED[name] if not hasattr(module, needed)]
        if missing:
            raise AttributeError(f"it has no {', '.join(missing)}")
        if name == "fk":
            _try(module)
        return module
    except Exception as reason:  # what a chapter wrote, or an editor left, may fail in any way
        warnings.warn(
            f"omx/generated/{name}.py cannot be used ({type(reason).__name__}: {reason}). The module that the book "
            f"ships is used instead. To mend it, run notebooks/{CHAPTERS[name]}.ipynb again with sound numbers, or "
            "type `python run.py generate --restore`.",
            stacklevel=2,
        )
        return import_module(f"{__name__}.shipped.{name}")


def _try(fk: ModuleType) -> None:
    """Once through the table and the formulas; raises whatever they raise."""
    values = [float(value) for value in fk.PARAMETERS.values()]
    if not all(abs(value) < 1e6 for value in values):
        raise ValueError(f"PARAMETERS must hold finite numbers; it holds {fk.PARAMETERS}")
    if not all(value > 0 for name, value in fk.PARAMETERS.items() if name[0] == "L"):
        raise ValueError(f"every length must be more than 0; PARAMETERS is {fk.PARAMETERS}")
    fk.dh_rows(*values)
    fk.pose(*[0.1] * 4, *values)


fk, ik, jacobian, gravity = map(_usable, NEEDED)
