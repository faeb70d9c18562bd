"""Odd values for every public function: whatever comes in, what comes out is an answer or a sentence.

`OMX_FUZZ=10000` in the environment asks for more examples.
"""

import inspect
import os
import warnings
from collections import Counter
from datetime import date
from fractions import Fraction
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
import sympy as sp
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import omx
from omx import analysis, collision, derive, dh, geometry, kinematics, motion, rotation
from omx.analysis import accuracy, compiled, equivalence, workspace
from omx.derive import screws
from omx.exchange import axes
from omx.motion import trajectory

EXAMPLES = int(os.environ.get("OMX_FUZZ", 300))
t, u = sp.symbols("t u", real=True)
CHAIN = omx.Chain([(0, 77, 0, -1.5), (0.2, 0, 130, 0), (0, 5, 124, 0.4), (0, 0, 9, 0, True)], [(-2, 2)] * 3 + [(0, 9)])
SYMBOLIC = omx.Chain([(t, u, 0, 0)])
FUNCTION = derive.Function("f", "A formula.", (t,), {"out": t + 1})
SECTION = workspace.section()
MOVE = motion.joint_move(omx.ZERO, omx.HOME, 1.0)
TWO_LINKS = omx.Chain([(0, 0, 2, 0), (0, 0, 1, 0)])
WRITTEN = ModuleType("two_links")
exec(derive.source("m", derive.pattern(TWO_LINKS).functions(), rows=TWO_LINKS.rows, branches=["a", "b"], doc="A test."),
     vars(WRITTEN))  # fmt: skip
INVERSE = analysis.Inverse(TWO_LINKS, WRITTEN)
WAY = motion.rounded([(200, -50, 150, 0), (200, 50, 150, 0), (180, 50, 200, 0)], 5.0, 30)
ARC = workspace.arcs.Arc((0.0, 10.0), 50.0, 0.0, 1.0)

TURN = motion.spline_path([omx.ZERO, omx.HOME], 30)


class Table:
    """Like a data frame: its iterator gives the names of its columns."""

    def __iter__(self):
        return iter((1.0, 2.0, 3.0, 4.0))

    def __array__(self, dtype=None, copy=None):
        return np.array([[0.1, 0.2, 0.3, 0.4]], dtype=dtype)


class Rude:
    """Cannot even be shown."""

    def __repr__(self):
        raise RuntimeError("no")


def masked():
    return np.ma.array([0.1, 9.0, 0.0, 0.0], mask=[0, 1, 0, 0])


#: Made anew for each call, since iterators run out.
ODD = [
    *(lambda v=v: v for v in (
        None, "", "1", "maker", b"x", True, False, 0, -1, 3, 1e-12, 0.5, 1e300, 10**400, 2**70, float("nan"), 1j,
        float("inf"), -float("inf"), Fraction(1, 3), (), [], [None], [1, 2], (1, 2, 3), (1, 2, 3, 4, 5), ["a"] * 4,
        [[1, 2], [3]], [True, 0.2, 0.3, 0.4], (1j, 0, 0, 0), (float("nan"), 0, 0, 0), [1e308] * 4, {0.0, 1.0, 2.0, 3.0},
        {"q": 1}, {1.0: 2, 2.0: 3, 3.0: 4, 4.0: 5}, frozenset({1}), t, sp.nan, sp.zoo, sp.I, sp.Eq(t, 1), sp.eye(3),
        [t, u, t, u], omx.HOME, [omx.HOME] * 3, omx.LIMITS, omx.LIMITS[:3], [(-90, 90)] * 4, [(1, -1)] * 4,
        [(-np.inf, np.inf)] * 4, omx.COURSE, omx.MAKER, omx.COURSE.replace(L3=0), CHAIN, SYMBOLIC, [CHAIN], MOVE,
        FUNCTION, [FUNCTION], omx.DHRow, omx.DHRow(0, 1, 2, 3), [(0, 1, 2, 3)] * 2, date(2020, 1, 1), Path("here"),
        Ellipsis, object, len, Table(), slice(None), range(4), "fk", {t: 1.0}, {"L2": 0.1}, {"L9": 1}, {"L2": -1},
    )),
    *(lambda s=s: np.zeros(s) for s in ((), (0,), (3,), (4,), (5,), (0, 4), (1, 4), (2, 3), (3, 4), (4, 4), (2, 3, 4))),
    lambda: np.array(["0.1"] * 4, dtype=object), lambda: np.ones(4, bool), lambda: np.ones(4, complex), masked,
    lambda: np.matrix([[1.0, 2, 3, 4]]), lambda: np.full(4, np.nan), lambda: np.array(None),
    lambda: np.float32(0.5), lambda: np.datetime64("2020-01-01"),
    lambda: np.array([1, "a", None], dtype=object), lambda: (x for x in (0.1, 0.2, 0.3, 0.4)), lambda: iter("abcd"),
    lambda: iter([[1] * 4] * 3), lambda: lambda *a, **k: None, lambda: lambda q: q, Rude,
    lambda: np.array([[0.1] * 4] * 2, dtype=">f4"), lambda: np.zeros(4, dtype=[("a", float)]),
]  # fmt: skip

#: A sound value for each parameter, by its name.
SOUND = {
    **dict.fromkeys(("q", "start", "goal", "near"), omx.HOME),
    "pose": (200.0, 0.0, 150.0, 0.0), "poses": [(200.0, 0.0, 150.0, 0.0)] * 2, "waypoints": [omx.ZERO, omx.HOME],
    "velocity": (1.0, 2.0, 3.0, 0.1), "seconds": 0.3, "points": [(100.0, 200.0), (0.0, 50.0)], "R": np.eye(3),
    "sigmas": {"L2": 0.1}, "bounds": {"o1": 0.01}, "name": "m", "functions": [FUNCTION], "doc": "A test.",
    "chain": CHAIN, "first": CHAIN, "second": CHAIN, "rows": [(0, 1, 2, 0.3)] * 2, "row": omx.DHRow(0, 1, 2, 0.3),
    "left": sp.sin(t) ** 2, "right": 1 - sp.cos(t) ** 2, "difference": t - t, "expression": sp.sin(t) + u,
    "values": {t: 1, u: 2}, "theta": t, "d": 1, "a": 2, "alpha": 0.5, "roll": 0.1, "pitch": 0.2, "yaw": 0.3,
    "inputs": (t,), "outputs": {"out": t}, "samples": 20, "value": omx.HOME, "lengths": {}, "u": np.linspace(0, 1, 5),
    "limits": omx.LIMITS, "joints": 4,
    "other": motion.joint_move(omx.HOME, omx.ZERO, 1.0), "geometry": omx.COURSE, "low": 0.0, "high": 90.0, "done": 1,
    "total": 2, "angle": 0.3, "parameters": (), "key": "L2", "step": 40.0, "pitches": 8, "index": 0, "stop": 0.5,
    "corners": [(200, -50, 150, 0), (200, 50, 150, 0)], "error": 5.0, "way": WAY, "allowed": motion.Allowed(),
    "w": (0, 0, 1), "direction": (0, 1, 0), "twist": (0, 0, 0, 0, 0, 1), "twists": [(0, 0, 0, 0, 0, 1)] * 4,
    "directions": [(0, 0, 1), (0, 1, 0)], "tool": np.eye(4), "described": omx.urdf.text(),
    "arm": CHAIN, "path": "arm.urdf", "zero": np.eye(4), "T": np.eye(4), "progress": None,
    "random": np.random.default_rng(0), "columns": 4, "wanted": "numbers",
    "target": (0.5, 1.0), "targets": [(0.5, 1.0)] * 3, "vector": (0.1, -0.2, 0.3),
    "trials": 20, "chance": 0.5, "place": (150.0, 30.0),
    "above": 95.0, "sure": 0.9, "z": 40.0,
}  # fmt: skip
SOUND_FOR = {
    **{name: {"path": TURN} for name in ("fastest", "controllable", "torque_lines")},
    "calibrate": {"q": np.random.default_rng(1).uniform(-1, 1, (12, 4)), "points": np.ones((12, 3))},
    "Inverse": {"chain": TWO_LINKS, "module": WRITTEN}, "write_inverse": {"chain": TWO_LINKS},
    "chain_functions": {"chain": omx.Chain([(0, 1, 2, 0.3)])}, "write_chain": {"chain": omx.Chain([(0, 1, 2, 0.3)])},
    "part": {"start": 0.1}, "at": {"seconds": 0.1}, "centres": {"step": 5.0}, "clipped": {"q": omx.HOME},
    "evaluated": {"expression": t + 1, "at": [{t: 1.0}]}, "real_points": {"expressions": [t + 1]},
    "Section.contains": {}, "from_axes": {"points": np.zeros((2, 3))}, "exact_angle": {"value": 1.5},
    "as_geometry": {"value": omx.COURSE}, "wrap": {"angle": t},
    "as_arm": {"value": CHAIN}, "as_expression": {"value": t}, "exp_twist": {"q": 0.5},
    "as_transform": {"value": np.eye(4)},
    "trapezoid": {"ramp": 0.2}, "show": {"name": "A_1"}, "gather": {"expression": sp.sin(t) * sp.cos(u)},
}  # fmt: skip


def public(module):
    """The functions and classes that a module offers, by name."""
    names = getattr(module, "__all__", None) or [name for name in vars(module) if not name.startswith("_")]
    for name in names:
        value = getattr(module, name)
        ours = getattr(value, "__module__", "").startswith("omx.") and not name.startswith("_")
        if ours and callable(value) and not (isinstance(value, type) and issubclass(value, Exception)):
            yield name, value


MODULES = (
    kinematics, dh, geometry, rotation, collision, derive, screws, motion, trajectory, accuracy, equivalence, workspace,
    workspace.arcs, workspace.section, workspace.reach, workspace.maps, workspace.sampling, analysis, axes,
)  # fmt: skip
#: Left out: what makes no promise about its arguments (helpers of `omx` itself), and what only holds data.
HELPERS = {
    "Arc", "ArmSection", "BranchMap", "Branches", "Calibration", "Capsule", "Coordinates", "Counts", "Executor",
    "Four", "Grid", "IKSolution", "Iteration", "Limits", "Path", "Pattern", "PitchMap", "Pose", "RPY", "Section",
    "Solution", "Trajectory", "Violation", "as_chain", "as_count", "as_floats", "as_four", "as_four_or_rows",
    "as_limits", "as_number", "as_rows", "as_transform", "as_word", "boundary_loops", "capsules", "clipped",
    "cpu_count", "directions", "distance", "evaluated", "exact_angle", "fill", "gaps", "in_blocks", "in_line",
    "is_foreign", "joints", "limit_violations", "link_matrix", "link_rows", "namespace", "real_points", "rigid",
    "shown", "slip_of_unit", "solve_along", "stacked", "stale", "usable", "warn_if_stale", "wrap",
}  # fmt: skip
METHODS = {
    f"{label}.{name}": getattr(thing, name)
    for label, thing, names in (
        ("Chain", CHAIN, ("fk", "frames", "matrices", "jacobian", "violations", "check")),
        ("symbolic Chain", SYMBOLIC, ("fk", "frames", "matrices", "jacobian", "violations", "check")),
        ("Geometry", omx.COURSE, ("replace",)),
        ("Trajectory", MOVE, ("at", "then", "poses")),
        ("Section", SECTION, ("contains", "distance", "fill", "polygons")),
        ("Arc", ARC, ("points", "distance")),
        ("urdf", omx.urdf, ("text", "parse", "write")),
        ("Inverse", INVERSE, ("__call__", "batch")),
        ("compiled", compiled, ("pose", "ik_batch")),
    )
    for name in names
}  # fmt: skip
CALLABLES = {
    **{name: value for module in MODULES for name, value in public(module) if name not in HELPERS},
    **METHODS,
}
ENDS: Counter = Counter()


@pytest.fixture(autouse=True)
def aside(tmp_path_factory, monkeypatch):
    """What is written goes nowhere."""
    monkeypatch.chdir(tmp_path_factory.mktemp("fuzz"))


def arguments(data, name, function):
    """Sound arguments with one to three odd ones among them, by name."""
    parameters = [p for p in inspect.signature(function).parameters.values() if p.name != "self"]
    given, kinds = {}, (inspect.Parameter.VAR_KEYWORD, inspect.Parameter.VAR_POSITIONAL)
    for p in parameters:
        if p.kind not in kinds and (p.default is p.empty or p.name in ("geometry", "limits")):
            given[p.name] = SOUND_FOR.get(name, {}).get(p.name, SOUND.get(p.name))
    if "geometry" in given and name in ("iterate",):
        given["geometry"] = omx.COURSE
    plain = [p.name for p in parameters if p.kind not in kinds]
    for chosen in data.draw(st.lists(st.sampled_from(plain), min_size=1, max_size=3)) if plain else ():
        given[chosen] = data.draw(st.sampled_from(ODD))()
    named = {p.name for p in parameters if p.kind is not p.POSITIONAL_ONLY}
    return [v for k, v in given.items() if k not in named], {k: v for k, v in given.items() if k in named}


def told(error) -> bool:
    """Is it one of ours, or a TypeError or ValueError that says something?"""
    if isinstance(error, (omx.OmxError, np.linalg.LinAlgError)):
        return bool(str(error))
    return isinstance(error, (TypeError, ValueError)) and len(str(error).split()) >= 3


@settings(max_examples=EXAMPLES, deadline=None, suppress_health_check=list(HealthCheck), database=None)
@given(st.sampled_from(sorted(CALLABLES)), st.data())
def test_whatever_comes_in_an_answer_or_a_sentence_comes_out(name, data):
    function = CALLABLES[name]
    positional, named = arguments(data, name, function)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            function(*positional, **named)
            ENDS["an answer"] += 1
        except Exception as error:
            if not told(error):
                raise AssertionError(f"{name}(*{positional}, **{named})") from error
            ENDS[type(error).__name__] += 1


def test_every_public_function_has_sound_arguments_to_begin_with():
    """So that the odd ones meet code that would have gone on without them."""
    for name, function in CALLABLES.items():
        parameters = inspect.signature(function).parameters.values()
        needed = [
            p.name for p in parameters if p.default is p.empty and p.kind not in (p.VAR_KEYWORD, p.VAR_POSITIONAL)
        ]
        given = {p: SOUND_FOR.get(name, {}).get(p, SOUND.get(p)) for p in needed}
        if name != "Geometry" and not name.startswith("symbolic"):
            function(**given)
