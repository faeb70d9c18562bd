"""The self-test of chapter 00: is everything here that the book needs, and does it work together?"""

import importlib
from collections.abc import Callable
from importlib.util import find_spec

import numpy as np

from .. import kinematics
from ..arm import ZERO
from ..errors import Wrong
from ..geometry import COURSE

#: The packages that the chapters need, wherever they run.
NEEDED = ("numpy", "sympy", "matplotlib", "ipywidgets", "anywidget", "meshcat")
RESTART = "choose Kernel > Restart Kernel, then run the cells again"
REPAIR = "close Jupyter and type `python run.py repair` in the book's folder: it mends what is missing or broken"


def setup() -> None:
    """Test packages, viewer, generated modules and one pose; a line each. `Wrong` lists what to do about failures."""
    tests = (("packages", _packages), ("viewer", _viewer), ("generated modules", _generated), ("kinematics", _pose))
    remedies = []
    for name, test in tests:
        said, remedy = _outcome(test)
        print(f"{'!!' if remedy else 'ok'}  {name}: {said}")
        if remedy:
            remedies.append(f"{name}: {remedy}.")
    if remedies:
        raise Wrong(" ".join(["Something is missing.", *remedies]))


def _outcome(test: Callable[[], str]) -> tuple[str, str]:
    """What a test says, and what to do if it failed."""
    try:
        return test(), ""
    except Wrong as wrong:
        return str(wrong), RESTART if kinematics.replaced() else REPAIR
    except Exception as error:  # a broken installation can fail in any way; the reader needs its name and a remedy
        return f"{type(error).__name__}: {error}", REPAIR


def _packages() -> str:
    missing = [name for name in NEEDED if find_spec(name) is None]
    if missing:
        raise Wrong(f"{', '.join(missing)} missing")
    return ", ".join(NEEDED)


def _viewer() -> str:
    """Builds a scene, and in a notebook opens its channel to the page."""
    view = importlib.import_module("omx.display.viewer").View(ZERO)  # checks import nothing of it; this one tries it
    _, buffers = view.channel.replay()
    if not buffers or not buffers[0]:
        raise Wrong("the scene is empty")
    live = view.widget.comm is not None and view.widget.comm.comm_id
    return "scene built, channel open" if live else "scene built"


def _generated() -> str:
    for name in ("fk", "ik", "jacobian"):
        importlib.import_module(f"omx.generated.{name}")
    if names := kinematics.replaced():
        raise Wrong(f"{', '.join(names)} was written anew after this notebook had imported it")
    return "fk, ik, jacobian"


def _pose() -> str:
    """The tip at zero, from the generated closed form and from the plain product of the link matrices."""
    x, y, z, pitch = kinematics.pose(ZERO)
    if not np.allclose(COURSE.chain.fk(ZERO), kinematics.fk(ZERO), atol=1e-9):
        raise Wrong("the generated module and the DH table disagree; chapter 03 writes both")
    return f"tip at zero ({x:.3f}, {y:.3f}, {z:.3f}) mm, pitch {abs(pitch):.1f} rad"
