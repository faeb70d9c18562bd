"""The layers of omx, read from its imports: from the own row and from rows below, never in a circle."""

import ast
import subprocess
import sys
import textwrap
from graphlib import TopologicalSorter
from importlib import import_module
from pathlib import Path

import pytest

import omx

OMX = Path(__file__).resolve().parents[1] / "omx"

# Row -> {module or package: third-party packages besides NumPy, which all may use}. CONTRIBUTING.md explains it.
JUPYTER = {"IPython", "ipywidgets", "traitlets"}
ROWS = {
    0: {
        **dict.fromkeys(("errors", "arrays", "dh", "compare", "rotation", "geometry", "generated", "agreement"), ()),
        **dict.fromkeys(("dynamixel.registers", "dynamixel.units", "dynamixel.packet", "dynamixel.clock"), ()),
        "dynamixel": (),
    },
    1: {
        **dict.fromkeys(("kinematics", "differential", "workspace", "trajectory", "accuracy", "safety"), ()),
        "fast": {"numba"},
        "dynamixel.bus": (),
        "dynamixel.sdk": {"dynamixel_sdk"},
        "dynamixel.serial_line": {"serial"},
    },
    2: {**dict.fromkeys(("doctor", "log"), ()), **dict.fromkeys(("robot", "virtual"), ("serial",))},
    3: {"view": {"meshcat", "anywidget", "umsgpack", *JUPYTER}, "plots": {"matplotlib"}, "check": ()},
    4: {"panel": {"anywidget", *JUPYTER}},
}
SIDE = {"symbolic": {"sympy"}, "codegen": {"sympy", "nbformat", "nbclient"}}  # notebooks and tests use these
SIDE_USES = {"errors", "arrays", "dh", "geometry", "symbolic", "codegen"}
LAZY = {("dh", "symbolic")}  # symbols go through the same rows; the import waits until there are some


def module_name(path):
    """`dynamixel.bus` for omx/dynamixel/bus.py, `view` for omx/view/__init__.py, '' for omx/__init__.py."""
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


def unit(name):
    """The entry of the table that a module belongs to: the longest one that its name begins with, or None."""
    units = {unit for row in ROWS.values() for unit in row} | SIDE.keys()
    parts = name.split(".")
    return next((u for n in range(len(parts), 0, -1) if (u := ".".join(parts[:n])) in units), None)


def row(unit):
    return next((number for number, units in ROWS.items() if unit in units), None)


def violations(name, imported):
    """What is wrong with the imports of one module, a sentence each."""
    ours = unit(name)
    for target, _ in imported:
        top = target.split(".")[0]
        if top == "omx":
            theirs = unit(target.removeprefix("omx").lstrip("."))
            if theirs is None and target != "omx":
                yield f"{name} imports {target}, which has no place in the table of layers"
            elif not may_import(ours, theirs):
                yield f"{name} (row {row(ours)}) imports {target} (row {row(theirs)})"
        elif top not in sys.stdlib_module_names and top != "numpy" and top not in third_party(ours):
            yield f"{name} imports {top}; its row may use {sorted(third_party(ours)) or 'NumPy only'}"


def may_import(ours, theirs):
    if ours in SIDE:
        return theirs in SIDE_USES
    if theirs in SIDE:
        return (ours, theirs) in LAZY
    return theirs is not None and row(theirs) <= row(ours)


def third_party(unit):
    return SIDE.get(unit) or next((row[unit] for row in ROWS.values() if unit in row), ())


@pytest.mark.parametrize("name", [name for name in MODULES if name])
def test_module_imports_from_its_own_row_and_below(name):
    assert unit(name), f"omx.{name} has no place in the table of layers"
    found = list(violations(name, imports(MODULES[name])))
    assert not found, "\n".join(found)


def test_the_face_of_omx_needs_rows_0_and_1_only():
    ours = [target.removeprefix("omx.") for target, _ in imports(MODULES[""]) if target.startswith("omx.")]
    assert ours
    assert all(row(unit(target)) <= 1 for target in ours)


def test_what_needs_more_comes_when_it_is_asked_for():
    assert omx.Robot is import_module("omx.robot").Robot
    top = {name for name in MODULES if name and "." not in name}
    for name in top & set(dir(omx)):
        assert getattr(omx, name) is import_module(f"omx.{name}")
    assert top - set(dir(omx)) == {"agreement", "arrays", "dh", "errors", "generated", "geometry", "kinematics"}
    with pytest.raises(AttributeError, match="Robott"):
        omx.Robott  # noqa: B018


def test_no_import_circles():
    graph = {name: {t.removeprefix("omx.") for t, top in imports(path) if top} for name, path in MODULES.items()}
    TopologicalSorter({name: targets & MODULES.keys() - {name} for name, targets in graph.items()}).prepare()


def test_lazy_imports_are_lazy():
    for ours, theirs in LAZY:
        assert (f"omx.{theirs}", True) not in set(imports(MODULES[ours]))


@pytest.mark.parametrize(
    ("name", "target"),
    [
        ("kinematics", "omx.robot"),
        ("dh", "omx.codegen"),
        ("safety", "omx.view.view"),
        ("geometry", "sympy"),
        ("view.scene", "matplotlib"),
        ("dynamixel.units", "dynamixel_sdk"),
        ("virtual.servo", "omx.panel"),
        ("codegen.emit", "omx.kinematics"),
        ("log", "omx.nowhere"),
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
    omx.solve_ik([200, 0, 100, 0], near=omx.HOME)
    print(f"{took * 1e3:.0f} ms", *sorted(set(sys.modules) - before))
"""


def test_import_omx_needs_numpy_alone_and_loads_little():
    command = [sys.executable, "-c", textwrap.dedent(ALONE)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stderr
    took, modules = done.stdout.split()[0], done.stdout.split()[2:]
    ours = {name for name in modules if name.startswith("omx")}
    print(f"import omx after numpy: {took} ms, {len(modules)} modules, of these ours: {sorted(ours)}")
    assert {row(unit(name.removeprefix("omx."))) for name in ours - {"omx"}} == {0, 1}
    assert len(modules) <= 40
