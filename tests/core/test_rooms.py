"""The rooms of omx, read from its imports: what each may import, and never in a circle."""

import ast
import subprocess
import sys
import textwrap
from graphlib import TopologicalSorter
from importlib import import_module
from pathlib import Path

import pytest

import omx

OMX = Path(omx.__file__).parent

SMALL = {"", "errors", "arm", "geometry", "dh", "rotation", "kinematics", "collision", "arrays", "generated"}
JUPYTER = {"IPython", "ipywidgets", "traitlets", "anywidget"}

# Room -> (rooms that it may import from, third-party packages besides NumPy). CONTRIBUTING.md says what lives there.
ROOMS = {
    "derive": ({"small"}, {"sympy", "mpmath"}),
    "motion": ({"small"}, set()),
    "analysis": ({"small"}, {"numba", "llvmlite"}),
    "exchange": ({"small"}, set()),
    "hardware": ({"small", "motion"}, set()),
    "display": ({"small", "motion", "analysis"}, {"meshcat", "umsgpack", "matplotlib", *JUPYTER}),
    "check": ({"small", "derive"}, set()),
    "small": (set(), set()),
}
#: Parts of rooms that may do more than their room.
MORE = {
    "hardware.dynamixel": (set(), {"dynamixel_sdk", "serial", "pyodide"}),
    "display.panels": ({"hardware"}, set()),
}
#: Imported once there is a symbol, or an array that is not NumPy's: both go through the same formulas as numbers.
LAZY = {("dh", "sympy"), ("arrays", "array_api_compat")}


def module_name(path):
    """`hardware.log` for omx/hardware/log.py, `display` for omx/display/__init__.py, '' for omx/__init__.py."""
    parts = path.relative_to(OMX).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {module_name(path): path for path in sorted(OMX.rglob("*.py"))}


def imports(path, modules=MODULES):
    """(absolute name, is it at the top of the module?) of everything that a file of omx imports."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    package = ["omx", *path.relative_to(OMX).parent.parts]
    for node in ast.walk(tree):
        at_top = node in tree.body
        if isinstance(node, ast.Import):
            yield from ((alias.name, at_top) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] if node.level else []
            origin = ".".join([*base, *([node.module] if node.module else [])])
            for alias in node.names:
                inner = f"{origin}.{alias.name}"
                yield (inner if inner.removeprefix("omx.") in modules else origin), at_top


def room(name):
    """The room of a module by its name: "small" for the small module, None for what has no room."""
    first = name.split(".")[0]
    return "small" if first in SMALL else first if first in ROOMS else None


def may_use(name):
    """(rooms, third-party packages) that the module `name` may import."""
    rooms, packages = ROOMS[room(name)]
    for part, (more_rooms, more_packages) in MORE.items():
        if name == part or name.startswith(part + "."):
            rooms, packages = rooms | more_rooms, packages | more_packages
    return rooms | {room(name)}, packages


def violations(name, imported):
    """What is wrong with the imports of one module, a sentence each."""
    rooms, packages = may_use(name)
    for target, at_top in imported:
        top = target.split(".")[0]
        if top == "omx":
            theirs = room(target.removeprefix("omx").lstrip("."))
            if theirs not in rooms:
                yield f"{name} ({room(name)}) imports {target} ({theirs}); it may import from {sorted(rooms)}"
        elif not at_top and (name, top) in LAZY:
            continue
        elif top not in sys.stdlib_module_names | {"numpy"} | packages:
            yield f"{name} imports {top}; its room may use {sorted(packages) or 'NumPy only'}"


@pytest.mark.parametrize("name", [name for name in MODULES if name])
def test_module_imports_what_its_room_may(name):
    assert room(name), f"omx.{name} has no place in the table of rooms"
    found = list(violations(name, imports(MODULES[name])))
    assert not found, "\n".join(found)


def test_the_face_of_omx_is_the_small_module():
    ours = [target.removeprefix("omx.") for target, _ in imports(MODULES[""]) if target.startswith("omx.")]
    assert ours
    assert all(room(name) == "small" for name in ours)


def test_what_needs_more_comes_when_it_is_asked_for():
    for name, where in omx._LATER.items():
        assert getattr(omx, name) is not None, where
    assert omx.Robot is import_module("omx.hardware.robot").Robot
    assert omx.trajectory is import_module("omx.motion.trajectory")
    with pytest.raises(AttributeError, match="Robott"):
        omx.Robott  # noqa: B018


def test_every_error_is_on_the_face():
    errors = {name for name, value in vars(import_module("omx.errors")).items() if isinstance(value, type)}
    assert {name for name in errors if issubclass(getattr(omx.errors, name), Exception)} <= set(omx.__all__)


def test_no_import_circles():
    """Imports inside functions count, too: they hide a circle, they do not cut it."""
    graph = {name: {t.removeprefix("omx.") for t, _ in imports(path)} for name, path in MODULES.items()}
    TopologicalSorter({name: targets & MODULES.keys() - {name} for name, targets in graph.items()}).prepare()


@pytest.mark.parametrize(
    ("name", "target"),
    [
        ("kinematics", "omx.hardware.robot"),
        ("dh", "omx.derive.symbolic"),
        ("hardware.safety", "omx.display.viewer.view"),
        ("geometry", "sympy"),
        ("display.viewer.scene", "omx.hardware.robot"),
        ("hardware.simulator.servo", "dynamixel_sdk"),
        ("hardware.simulator.servo", "omx.display.panels"),
        ("derive.emit", "omx.motion"),
        ("hardware.log", "omx.nowhere"),
    ],
)
def test_a_wrong_import_is_caught(name, target):
    assert list(violations(name, [(target, True)]))


ALONE = """
    import sys, time

    class OnlyNumPy:
        def find_spec(self, name, path=None, target=None):
            if name.split(".")[0] not in sys.stdlib_module_names | {"omx", "numpy"}:
                raise ImportError(f"{name} is blocked")

    sys.meta_path.insert(0, OnlyNumPy())
    import numpy
    before, start = set(sys.modules), time.perf_counter()
    import omx
    took = time.perf_counter() - start
    omx.solve_ik([200, 0, 100, 0], start=omx.HOME)
    print(f"{took * 1e3:.0f} ms", *sorted(set(sys.modules) - before))
"""


def test_import_omx_needs_numpy_alone_and_loads_little():
    command = [sys.executable, "-c", textwrap.dedent(ALONE)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stderr
    took, modules = done.stdout.split()[0], done.stdout.split()[2:]
    ours = {name for name in modules if name.startswith("omx")}
    print(f"import omx after numpy: {took} ms, {len(modules)} modules, of these ours: {sorted(ours)}")
    assert {room(name.removeprefix("omx.")) for name in ours - {"omx"}} == {"small"}
    assert len(modules) <= 40
