"""The code generator: any chain, written as source worth reading, equals the plain product of its moves."""

import ast
import importlib
import keyword
import os
import re
import shutil
import subprocess
import sys
from math import pi, tau
from pathlib import Path

import numpy as np
import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st

import omx
from book.setup.paths import ROOT
from omx import BadInput, Chain, DHRow, OmxError
from omx.derive import Function, chain_functions, numbers, source, store, wrap, write, write_chain
from omx.derive.emit import WIDTH, folded
from omx.derive.function import label
from omx.derive.module import script
from omx.derive.printer import BATCH, SCALAR, Printer
from tests.helpers import oracles
from tests.helpers.javascript import assert_javascript

ABOUT = {"notebook": "99-test", "doc": "A test."}
q1, q2, q3, q4 = Q = sp.symbols("q1:5", real=True)
a, b, delta = LENGTHS = sp.symbols("a b delta", real=True)


@pytest.fixture(autouse=True)
def scratch(tmp_path, monkeypatch):
    """Modules go to a folder of the test's own."""
    monkeypatch.setenv("OMX_GENERATED", str(tmp_path / "generated"))
    return tmp_path / "generated"


def one(output, inputs=Q, steps=(), **more):
    """A module of one function with one output."""
    return source("m", [Function("f", "A formula.", inputs, {"out": output}, steps)], **ABOUT, **more)


def run(text, name="f"):
    """The function `name` of a module's text."""
    namespace = {}
    exec(compile(text, "m.py", "exec"), namespace)
    return namespace[name]


# ---- any chain -----------------------------------------------------------------------------------------

L1, L2, L3 = sp.symbols("L1:4", positive=True)
STANFORD = [
    *(DHRow(0, 400, 0, -pi / 2), DHRow(0, 150, 0, pi / 2), DHRow(0, 0, 0, 0, prismatic=True)),
    *(DHRow(0, 0, 0, -pi / 2), DHRow(0, 0, 0, pi / 2), DHRow(0, 60, 0, 0)),
]
LINKS = {sp.Symbol(f"l{i}"): 10.0 * i for i in range(1, 5)}
CHAINS = {
    "three joints, numbers": (Chain([(0, 300, 0, pi / 2), (0, 0, 500, 0), (0, 0, 400, 0)]), {}),
    "three joints, symbols": (Chain([(0, L1, 0, sp.pi / 2), (delta, 0, L2, 0), (0, 0, L3, 0)]),
                              {L1: 77, L2: sp.sqrt(128**2 + 24**2), L3: 124.5, delta: sp.atan2(24, 128)}),
    "prismatic": (Chain([(0, 0, 50, pi / 2), (0.3, 20, 0, -pi / 6, True), (0, 0, 70, 0.4)]), {}),
    "Stanford": (Chain(STANFORD), {}),
    "twists of 30 and 60 degrees": (Chain([(0.1, 10, 20, pi / 6), (pi / 3, 5, 8, -pi / 3), (0, 1, 2, pi / 4)]), {}),
    "joints with names": (Chain([(0, 0, 9, 0), (0, 0, 0, 0, True)], names=["elbow", "boom"]), {}),
    "gantry": (Chain([(0, 0, 0, -pi / 2, True), (pi / 2, 0, 0, pi / 2, True), (0, 0, 0, 0, True)]), {}),
    "eleven joints": (Chain([(0, 0, 10, pi / 2 * (i % 2)) for i in range(11)]), {}),
    **{f"planar, {n} links": (Chain([(0, 0, link, 0) for link in list(LINKS)[:n]]), dict(list(LINKS.items())[:n]))
       for n in (1, 2, 3, 4)},
}  # fmt: skip


def plain(chain, values):
    """The rows of a chain as numbers, and which of its joints slide."""
    numbers = {symbol: float(value) for symbol, value in values.items()}
    rows = [[float(sp.sympify(e).subs(numbers)) for e in (r.theta, r.d, r.a, r.alpha)] for r in chain.rows]
    return rows, [i for i, row in enumerate(chain.rows) if row.prismatic]


@pytest.mark.parametrize("name", CHAINS)
def test_the_generated_module_is_the_product_of_elementary_moves(name):
    chain, values = CHAINS[name]
    module = write_chain("arm", chain, notebook="99-test", parameters=values)
    lengths = list(getattr(module, "PARAMETERS", {}).values())
    rows, sliding = plain(chain, values)
    assert [row.prismatic for row in module.dh_rows(*lengths)] == [row.prismatic for row in chain.rows]
    q = np.random.default_rng(1).uniform(-3, 3, (60, len(chain)))
    batch = module.transform_batch(*q.T, *lengths)
    for i, row in enumerate(q):
        expected = oracles.product(rows, row, sliding)
        for found, wanted in (
            (module.frames(*row.tolist(), *lengths), expected),
            (module.transform(*row.tolist(), *lengths), expected[-1]),
            ([[np.broadcast_to(entry, 60)[i] for entry in line] for line in batch], expected[-1]),
            (Chain(module.dh_rows(*lengths)).fk(row), expected[-1]),
        ):
            np.testing.assert_allclose(found, wanted, atol=1e-10)


ANGLE = st.sampled_from([0.0, pi / 2, -pi / 2, pi / 6, -pi / 3, pi, 0.3, -1.234567890123])
LENGTH = st.sampled_from([0.0, 77.0, -12.5, 0.1, 130.2305648])


@settings(max_examples=15, deadline=None)
@given(st.lists(st.tuples(ANGLE, LENGTH, LENGTH, ANGLE, st.booleans()), min_size=1, max_size=4), st.randoms())
def test_so_is_that_of_any_chain_that_hypothesis_finds(rows, random):
    chain = Chain(rows)
    transform = run(source("m", chain_functions(chain), **ABOUT), "transform")
    q = [random.uniform(-3, 3) for _ in rows]
    np.testing.assert_allclose(transform(*q), chain.fk(q), atol=1e-10)


def test_base_and_tool_go_into_the_formulas():
    base, tool = oracles.turn_x(0.7) @ oracles.shift(L := -12.5, 30), oracles.shift(40, L) @ oracles.turn_z(1.0)
    chain = Chain([(0.1, 77, 0, -pi / 2), (0, 0, 130, 0.3)], base=base, tool=tool)
    module = write_chain("arm", chain, notebook="99-test")
    np.testing.assert_allclose(module.transform(0.4, -0.9), chain.fk([0.4, -0.9]), atol=1e-10)
    np.testing.assert_allclose(module.frames(0.4, -0.9)[0], chain.frames([0.4, -0.9])[1], atol=1e-10)


def test_a_symbol_without_a_value_is_asked_for():
    with pytest.raises(BadInput, match="the DH table uses L1, L2: give each a value"):
        write_chain("arm", Chain([(0, L1, L2, 0)], name="mine"), notebook="99-test")


# ---- any formula ---------------------------------------------------------------------------------------

x, y = q1, q2
FORMULAS = {
    "rationals": x / 3 + sp.Rational(2, 7) * y - sp.Rational(1, 2),
    "negative powers": 1 / x**2 + y**-3 + 1 / (x * y) + 2 / (x + y) ** 2,
    "roots": sp.sqrt(x**2 + y**2) / sp.sqrt(2) + (x**2 + 1) ** sp.Rational(3, 2) + (y**2 + 1) ** sp.Rational(-1, 2),
    "nested Max and Min": sp.Max(x, y, x * y, 0) - sp.Min(1, x, sp.Max(y, -2, x)),
    "arcs": sp.atan2(y, x) + sp.asin(x / 10) + sp.acos(y / 10) + sp.atan(x),
    "signs": -(x + y) * -(x - y) - (-x) ** 3 - (y - (x - 2)),
    "absolute values": abs(x - y) + abs(-x),
    "wrap": wrap(3 * x + 2 * y) + wrap(-x),
    "sines of sums": sp.sin(x + y) * sp.cos(x - y) + sp.sin(2 * x) - sp.cos(x / 3 + sp.pi / 7) + sp.tan(x),
    "floats to the last digit": x * 0.1234567890123456789 + 1e-7 * y - 3.3333333333333335,
    "constants": sp.pi * x / 3 + sp.sqrt(3) + sp.asin(sp.Rational(24, 130)),
    "powers of sums": (x + y) ** 2 * (x - y) ** 3 + 2**x,
    "whole numbers": x - 2 * sp.floor(x / 2) + sp.floor(-y),
    "cases": 2 - sp.Piecewise((x, x < y), (-y, x * y >= 1), (sp.Piecewise((1, x > 2), (y**2, True)), True)),
    "large whole numbers": sp.Piecewise((10**19, x < y), (-1, True)) * sp.Piecewise((10**10, y > x - 1), (3, True)),
    "a tower": (x**2) ** (y / 4) + (1 / (1 + x**2)) ** y,
}


@pytest.mark.parametrize("name", FORMULAS)
def test_scalar_batch_lambdified_and_sympy_agree(name):
    text = one(FORMULAS[name], (x, y))
    scalar, batch = run(text), run(text, "f_batch")
    lambdified = sp.lambdify((x, y), FORMULAS[name], "numpy")
    points = np.random.default_rng(2).uniform(-3, 3, (40, 2))
    exact = [float(FORMULAS[name].subs({x: sp.Float(p[0], 30), y: sp.Float(p[1], 30)}).evalf(25)) for p in points[:6]]
    one_by_one = [scalar(*p) for p in points.tolist()]
    np.testing.assert_allclose(one_by_one[:6], exact, rtol=1e-13, atol=1e-13)
    np.testing.assert_allclose(batch(*points.T), one_by_one, rtol=1e-13, atol=1e-13)
    np.testing.assert_allclose(lambdified(*points.T), one_by_one, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("module", ["fk", "ik", "jacobian"])
def test_the_arms_own_modules_agree_with_their_batch_forms(module):
    module = importlib.import_module(f"omx.generated.{module}")
    rng = np.random.default_rng(3)
    poses = np.column_stack([rng.uniform(-300, 300, (50, 3)), rng.uniform(-3, 3, 50)])
    arguments = poses if module.__name__.endswith("ik") else oracles.any_q(50)
    for name in [name for name in dir(module) if name.endswith("_batch")]:
        batch = getattr(module, name)(*arguments.T, *oracles.COURSE)
        for i, row in enumerate(arguments.tolist()):
            picked = [np.broadcast_to(e, 50)[i] for e in flat(batch)]
            gaps = np.abs(np.subtract(picked, flat(getattr(module, name[:-6])(*row, *oracles.COURSE))))
            assert np.minimum(gaps, np.abs(gaps - tau)).max() < 1e-9


def flat(value):
    return [leaf for item in value for leaf in flat(item)] if isinstance(value, tuple) else [value]


def test_outputs_may_be_numbers_rows_tables_and_nested():
    outputs = {"s": x, "row": (x, 2), "single": [y], "table": sp.Matrix([[x, 0], [0, y]]), "deep": ((x,), (y, (x, y)))}
    f = run(source("m", [Function("f", "All kinds.", (x, y), outputs)], **ABOUT))
    assert f(1.5, 2.5) == (1.5, (1.5, 2), (2.5,), ((1.5, 0), (0, 2.5)), ((1.5,), (2.5, (1.5, 2.5))))


def test_one_output_is_returned_by_itself():
    assert run(one(x + 1))(2, 0, 0, 0) == 3
    assert run(one((x,)))(2, 0, 0, 0) == (2,)
    assert run(one(sp.Matrix([x, y])))(2, 3, 0, 0) == ((2,), (3,))
    assert run(one(5, ()))() == 5


# ---- source worth reading ------------------------------------------------------------------------------


def long_sum():
    return sum(sp.Symbol(f"length_{i}") * sp.sin(q1 + i * q2) for i in range(1, 12))


def difficult():
    """Texts that are hard to lay out."""
    lengths = {sp.Symbol(f"length_{i}"): i for i in range(1, 12)}
    doc = 'A backslash \\theta, three quotes """ and a very long line. ' * 4
    many = {f"output_number_{i}": x + i for i in range(30)}
    return {
        "a long sum": one(long_sum(), parameters=lengths),
        "long entries": one(sp.Matrix([[long_sum(), long_sum() ** 2], [x, 0]]), parameters=lengths),
        "many outputs": source("m", [Function("f", "Many.", Q, many)], **ABOUT),
        "a docstring": source("m", [Function("f", doc, (x,), {"out": x})], notebook="99-test", doc=doc),
        "scalar only": one(sp.sin(x), batch=False),
    }


@pytest.fixture(scope="module")
def texts():
    """Modules of many kinds, to be read by ruff and by rules."""
    found = difficult()
    for name, (chain, values) in CHAINS.items():
        found[name] = source("m", chain_functions(chain), **ABOUT, parameters=values, rows=chain.rows)
    return found | {name: one(formula, (x, y)) for name, formula in FORMULAS.items()}


@pytest.fixture(scope="module")
def ruff():
    if not shutil.which("ruff", path=str(Path(sys.executable).parent)):
        pytest.skip("ruff is not installed")
    return [sys.executable, "-m", "ruff", "check", "--no-cache", "."]


def test_ruff_finds_nothing_in_any_generated_text(ruff, texts, tmp_path):
    folder = tmp_path / "omx" / "generated"
    folder.mkdir(parents=True)
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    for name in ("__init__.py", "arrays.py", "dh.py"):  # so that ruff knows whose module omx is
        (folder.parent / name).touch()
    for i, text in enumerate(texts.values()):
        (folder / f"m{i}.py").write_text(text, encoding="utf-8")
    found = subprocess.run(ruff, cwd=tmp_path, capture_output=True, text=True, timeout=60)
    assert found.returncode == 0, found.stdout
    (folder / "bad.py").write_text("import os\n")
    assert subprocess.run(ruff, cwd=tmp_path, capture_output=True, timeout=60).returncode == 1


def test_names_are_names_and_every_import_is_used(texts):
    for text in texts.values():
        tree = ast.parse(text)
        names = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}
        assert not [name for name in names if re.fullmatch(r"x\d+|_?tmp\d*|Dummy.*|_.+", name)]
        imports = [node for node in tree.body if isinstance(node, (ast.Import, ast.ImportFrom))]
        assert {alias.asname or alias.name for node in imports for alias in node.names} <= names


def test_the_layout_is_tidy(texts):
    for text in texts.values():
        assert text.endswith("\n")
        assert all(len(line) <= WIDTH and not line.endswith(" ") for line in text.splitlines())
        assert "Written by notebooks/99-test.ipynb" in text


def test_sines_and_cosines_come_first_then_steps_then_results():
    r = sp.Symbol("r", real=True)
    reach = a * sp.sin(q2 + delta) + b * sp.cos(q2 + q3) + b * sp.cos(q2 + q3 + q4)
    function = Function("tip", "The tip.", Q, {"x": r * sp.cos(q1), "y": r * sp.sin(q1)}, [(r, reach)])
    text = source("m", [function], **ABOUT, parameters=LENGTHS, batch=False)
    assert text[text.index("    s1") :].splitlines() == [
        "    s1, c1 = sin(q1), cos(q1)",
        "    q23 = q2 + q3",
        "    c23 = cos(q23)",
        "    q2_delta = q2 + delta",
        "    s2_delta = sin(q2_delta)",
        "    q234 = q2 + q3 + q4",
        "    c234 = cos(q234)",
        "    r = a*s2_delta + b*c23 + b*c234",
        "    x = r*c1",
        "    y = r*s1",
        "    return x, y",
    ]


def test_the_docstring_counts_the_arithmetic_that_is_written():
    text = one(a * sp.sin(q1 + q2) - sp.sqrt(b), parameters=(a, b), batch=False)
    assert '"""A formula. 4 operations and 1 sines and cosines."""' in text  # +, *, -, sqrt


def test_the_sine_of_a_step_is_computed_behind_that_step():
    turned, far = sp.symbols("turned far", real=True)
    steps = [(turned, sp.atan2(q2, q1)), (far, sp.cos(turned) * q1 + sp.sin(turned + q3))]
    text = one(far + sp.cos(q1), Q, steps)
    lines = [line.split(" = ")[0].strip() for line in text.split("def f_batch")[0].splitlines() if " = " in line]
    assert lines == ["c1", "turned", "c_turned", "q3_turned", "s3_turned", "far"]
    value = 0.3 * np.cos(np.arctan2(0.7, 0.3)) + np.sin(np.arctan2(0.7, 0.3) - 1.1) + np.cos(0.3)
    for name, values in (("f", (0.3, 0.7, -1.1, 0.0)), ("f_batch", np.array([[0.3], [0.7], [-1.1], [0.0]]))):
        assert run(text, name)(*values) == pytest.approx(value, abs=1e-14)


def test_a_result_that_a_step_computes_is_not_computed_again():
    r = sp.Symbol("r", real=True)
    text = one(sp.Matrix([(x + y) ** 2 + 1, x]), (x, y), [(r, (x + y) ** 2)], batch=False)
    assert "    r = (q1 + q2)**2\n" in text
    assert "(1 + r,)" in text


def test_a_step_that_is_a_number_replaces_nothing():
    two = sp.Symbol("two")
    assert "x*x" in one(two + sp.Symbol("x") ** 2, [sp.Symbol("x")], [(two, 2)], batch=False)


def test_steps_that_no_result_needs_are_left_out():
    r, unused, through = sp.symbols("r unused through")
    text = one(r, (x,), [(through, x + 1), (unused, sp.sin(x)), (r, through**2)], batch=False)
    assert "unused" not in text
    assert "sin(" not in text
    assert run(text)(2.0) == 9.0


def test_long_sums_are_broken_before_their_signs():
    lines = folded("    total = ", " + ".join(f"term_number_{i}*factor" for i in range(12)))
    assert lines[0] == "    total = ("
    assert lines[-1] == "    )"
    assert all(line.lstrip().startswith("+ ") for line in lines[2:-1])
    assert all(len(line) <= WIDTH for line in lines)


@pytest.mark.parametrize(
    ("angle", "expected"),
    [
        (q1, "1"),
        (q3 + q2, "23"),
        (q2 + q3 + q4, "234"),
        (q1 - q2, "1m2"),
        (q2 + delta, "2_delta"),
        (sp.Symbol("pitch"), "_pitch"),
        (q1 + sp.pi / 6, "1_pi_6"),
        (q1 - 0.5, "1_m0p5"),
        (2 * q1, "_2q1"),
        (sp.Symbol("q12"), "_12"),
        (q1 + sp.Symbol("q12"), "_1_12"),
    ],
)
def test_angles_have_short_names(angle, expected):
    assert label(angle) == expected


def test_joint_twelve_is_not_joints_one_and_two():
    q12 = sp.Symbol("q12", real=True)
    f = run(one(sp.sin(q12) + sp.sin(q1 + q2), (q1, q2, q12)))
    assert f(0.1, 0.2, 0.7) == pytest.approx(np.sin(0.7) + np.sin(0.3))


# ---- the same bytes ------------------------------------------------------------------------------------

HASHED = """
import sympy as sp
from tests.derive.test_codegen import Function, CHAINS, FORMULAS, chain_functions, difficult, one, source
chain, values = CHAINS["three joints, symbols"]
print(source("m", chain_functions(chain), notebook="n", doc="d", parameters=values, rows=chain.rows))
print(source("m", chain_functions(CHAINS["Stanford"][0]), notebook="n", doc="d"))
print(*difficult().values(), *(one(formula) for formula in FORMULAS.values()))
"""


def test_the_text_does_not_depend_on_the_hash_seed():
    runs = []
    for seed in ("0", "1", "2"):
        environment = {**os.environ, "PYTHONHASHSEED": seed, "PYTHONPATH": str(ROOT)}
        command = [sys.executable, "-c", HASHED]
        runs.append(subprocess.Popen(command, cwd=ROOT, env=environment, stdout=subprocess.PIPE, text=True))
    texts = [process.communicate(timeout=120)[0] for process in runs]
    assert [process.returncode for process in runs] == [0, 0, 0]
    assert len(set(texts)) == 1
    assert len(texts[0]) > 10_000


# ---- mistakes ------------------------------------------------------------------------------------------

stray, r, z = sp.symbols("stray r z")
MISTAKES = {
    "an unknown symbol": (lambda: one(stray), r"`f`, output `out`: unknown symbol `stray`. Known here: q1, q2, q3, q4"),
    "the same name with other assumptions": (lambda: one(sp.Symbol("q1")), "unknown symbol `q1`.*other assumptions"),
    "an unknown symbol in a step": (lambda: one(r, Q, [(r, stray)]), "step `r`: unknown symbol `stray`"),
    "a step used before it is computed": (lambda: one(r, Q, [(r, stray), (stray, x)]), "unknown symbol `stray`"),
    "an unknown function": (lambda: one(sp.exp(x)), r"cannot write `exp\(q1\)` as code; the functions .* atan2"),
    "cases by another condition": (lambda: one(sp.Piecewise((x, sp.Eq(x, y)), (y, True))), "cannot write `Eq.* as the"),
    "cases by a symbol": (lambda: one(sp.Piecewise((x, z), (y, True)), (x, y, z)), "cannot write `z` as the"),
    "cases that leave some out": (lambda: one(sp.Piecewise((x, x > 0))), r"its last case must be for all the rest"),
    "an undefined function": (lambda: one(sp.Function("g")(x)), r"cannot write `g\(q1\)`"),
    "infinity": (lambda: one(sp.oo), "cannot write `oo`"),
    "a complex number": (lambda: one(sp.I * x), "cannot write `I`"),
    "two functions of one name": (lambda: source("m", [F, F], **ABOUT), "two functions would be called `f`"),
    "a function called like another's batch": (
        lambda: source("m", [F, Function("f_batch", "", Q, {"out": x})], **ABOUT), "would be called `f_batch`"),
    "a step called like an input": (lambda: one(x, Q, [(q1, x)]), "inputs, parameters or steps are called `q1`"),
    "two steps of one name": (lambda: one(r, Q, [(r, x), (r, y)]), "are called `r`"),
    "a parameter called like an input": (lambda: one(x, Q, parameters=[sp.Symbol("q1")]), "are called `q1`"),
    "an output called like an input": (lambda: source("m", [SWAPPED], **ABOUT), "the output `q1` has the name of"),
    "a parameter called like a cosine": (
        lambda: one(sp.cos(q1), Q, parameters=[sp.Symbol("c1")]), r"cos\(q1\) is written as `c1`"),
    "a step called like a sine": (
        lambda: one(sp.sin(q1) + r, Q, [(sp.Symbol("s1"), x), (r, x)]), r"sin\(q1\) is written as `s1`"),
    "a step called like a sum of angles": (
        lambda: one(sp.sin(q2 + q3) + r, Q, [(sp.Symbol("q23"), x), (r, x)]), r"q2 \+ q3 is written as `q23`"),
    "a symbol called like a word of the module": (
        lambda: one(x, (x, sp.Symbol("tau"))), "`tau` is used by the generated"),
    "a symbol that is a keyword": (lambda: one(x, (x, sp.Symbol("lambda"))), "`lambda` is used"),
    "a symbol that is no name": (lambda: one(x, (x, sp.Symbol(r"\alpha"))), "is no name in code"),
    "an output that is no name": (lambda: source("m", [Function("f", "", Q, {"p x": x})], **ABOUT), "output `p x`"),
    "strings for symbols": (lambda: one(x, ["q1", x]), "must be SymPy symbols; got 'q1'"),
    "no outputs": (lambda: source("m", [Function("f", "", Q, {})], **ABOUT), "has no outputs"),
    "a module that is no name": (lambda: source("my arm", [F], **ABOUT), "the module: `my arm` is no name in code"),
    "a module elsewhere": (lambda: source("../arm", [F], **ABOUT), "the module: `../arm` is no name in code"),
    "a parameter without a number": (
        lambda: one(x, Q, parameters={a: sp.Symbol("b")}), "parameter `a` must have a real"),
    "a parameter that is infinite": (lambda: one(x, Q, parameters={a: float("inf")}), "parameter `a`"),
    "a parameter that is None": (lambda: one(x, Q, parameters={a: None}), "parameter `a` .* got None"),
    "a table with unknown symbols": (lambda: one(x, Q, rows=[DHRow(0, stray, 0, 0)]), "the DH table uses stray"),
}  # fmt: skip
F = Function("f", "A formula.", Q, {"out": x})
SWAPPED = Function("f", "Would compute q2 from the new q1.", (q1, q2), {"q1": q2, "q2": q1})


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_named_before_anything_is_written(mistake):
    attempt, message = MISTAKES[mistake]
    with pytest.raises(BadInput, match=message):
        attempt()


def test_a_name_that_is_taken_but_not_needed_is_no_mistake():
    assert run(one(sp.sin(q1), Q, parameters=[sp.Symbol("c1")]))(0.5, 0, 0, 0, 9) == np.sin(0.5)


def test_no_keyword_gets_through():
    for word in keyword.kwlist:
        with pytest.raises(BadInput, match=word):
            one(x, (x, sp.Symbol(word)))


# ---- files ---------------------------------------------------------------------------------------------


def wrote(value, name="arm"):
    return write(name, [Function("f", "A formula.", (x,), {"out": x + value})], **ABOUT, parameters={a: value})


def test_write_returns_the_module_and_leaves_two_files(scratch):
    module = wrote(5)
    assert module.f(1.0, 0.0) == 6.0
    assert module.PARAMETERS == {"a": 5.0}
    assert sorted(path.name for path in scratch.iterdir() if path.is_file()) == ["arm.js", "arm.py"]
    assert (scratch / "arm.py").read_bytes().count(b"\r") == 0


def test_a_rewrite_within_the_same_second_is_seen():
    """Same size, same second: stale bytecode would pass for the new text."""
    assert [wrote(value).f(0.0, 0.0) for value in (1, 2, 3)] == [1, 2, 3]


def test_an_unchanged_module_is_not_touched(scratch):
    wrote(5)
    os.utime(scratch / "arm.py", (1, 1))
    wrote(5)
    assert (scratch / "arm.py").stat().st_mtime == 1
    wrote(6)
    assert (scratch / "arm.py").stat().st_mtime > 1


def test_a_mistake_leaves_the_old_module(scratch):
    wrote(5)
    before = (scratch / "arm.py").read_bytes()
    with pytest.raises(BadInput):
        wrote(stray)
    assert (scratch / "arm.py").read_bytes() == before


@pytest.mark.parametrize("call", ["replace", "write"])
def test_a_failing_disk_leaves_the_old_module_and_no_litter(scratch, monkeypatch, call):
    wrote(5)
    before = {path.name: path.read_bytes() for path in scratch.iterdir() if path.is_file()}

    def fail(path, *_, **__):
        Path(path).touch()
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(*{"replace": (store.os, "replace"), "write": (Path, "write_text")}[call], fail)
    with pytest.raises(OmxError, match=r"cannot write .*arm\.py: No space left on device. What was there is unchanged"):
        wrote(6)
    assert {path.name: path.read_bytes() for path in scratch.iterdir() if path.is_file()} == before


def test_a_folder_that_cannot_be_is_named(scratch):
    scratch.parent.mkdir(exist_ok=True)
    scratch.write_text("a file where the folder should be")
    with pytest.raises(OmxError, match="cannot write"):
        wrote(5)


def test_inside_the_package_the_loaded_module_is_replaced(scratch, monkeypatch):
    """What other modules hold as `omx.generated.arm` is the new formula at once."""
    scratch.mkdir()
    monkeypatch.setattr(store, "GENERATED", scratch)
    monkeypatch.setitem(store.CHAPTERS, "scratch_arm", ABOUT["notebook"])
    monkeypatch.setattr(omx.generated, "__path__", [*omx.generated.__path__, str(scratch)])
    held = wrote(1, "scratch_arm")
    try:
        assert held.__name__ == "omx.generated.scratch_arm"
        assert wrote(2, "scratch_arm") is held
        assert held.f(0.0, 0.0) == 2
    finally:
        del sys.modules["omx.generated.scratch_arm"]


def test_a_chapter_of_the_book_writes_into_the_package_and_nobody_else_does(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("OMX_GENERATED", "here")
    assert store.place("fk", "03-forward-kinematics") == store.place("scara", None) == tmp_path / "here"
    monkeypatch.delenv("OMX_GENERATED")
    assert store.place("fk", "03-forward-kinematics") == ROOT / "omx" / "generated"
    assert store.place("fk", None) == store.place("scara", "mine") == tmp_path
    with pytest.raises(BadInput, match="`fk` is the module of notebooks/03-forward-kinematics"):
        write_chain("fk", Chain([(0, 77, 0, 0)]), notebook="mine")
    with pytest.raises(BadInput, match="`folder`"):
        write("scara", [F], doc="A test.", folder=ROOT / "omx" / "generated")
    assert write("scara", [F], doc="A test.").f(3.0, 0, 0, 0) == 3.0
    assert {path.name for path in tmp_path.glob("*.*")} == {"scara.py", "scara.js"}


def test_no_file_is_replaced_that_another_has_written(tmp_path):
    """A reader's own file, another chapter's module, a module that Python imports; one's own, and an empty one, are."""
    about = {"doc": "A test.", "folder": tmp_path}
    (tmp_path / "mine.py").write_text("print('by hand')\n")
    (tmp_path / "empty.py").touch()
    for name in ("mine", "random", "numpy"):
        with pytest.raises(BadInput, match=r"choose another name"):
            write(name, [F], **about)
    write("empty", [F], **about)
    write("empty", [F], **about)
    write("chapter", [F], notebook="98-other", **about)
    for notebook in ("99-test", None):
        with pytest.raises(BadInput, match=r"the module of notebooks/98-other.ipynb"):
            write("chapter", [F], notebook=notebook, **about)


@pytest.mark.parametrize("length", [0, -124, 0.0])
def test_lengths_that_make_no_arm_are_refused_before_anything_is_written(scratch, length):
    wanted = {sp.Symbol("L2"): 130, sp.Symbol("L3"): length}
    with pytest.raises(BadInput, match=r"L3 = .* makes no arm"):
        write("fk", [F], **ABOUT, parameters=wanted)
    assert not list(scratch.parent.rglob("*.py"))


def test_both_files_are_replaced_or_neither(scratch):
    wrote(5)
    before = (scratch / "arm.py").read_bytes()
    (scratch / "arm.js").unlink()
    (scratch / "arm.js").mkdir()
    with pytest.raises(OmxError, match=r"cannot write .*arm\.js.* What was there is unchanged"):
        wrote(6)
    assert (scratch / "arm.py").read_bytes() == before
    assert not list(scratch.glob("*.new"))


def test_many_joints_and_many_outputs_are_javascript_too(scratch):
    """Their return lines are folded."""
    chain = Chain([(0, 0, 20, 0)] * 15)
    module = write_chain("many", chain)
    q = np.linspace(-1, 1, 15)
    np.testing.assert_allclose(module.transform(*q), chain.fk(q), atol=1e-9)
    write("long", [Function("f", "Many.", Q, {f"jacobian_x_{i}_of_many": i * x for i in range(12)})], **ABOUT)
    assert_javascript(scratch / "many.js")
    assert_javascript(scratch / "long.js")


NOT_A_NAME = [
    "do", "case", "default", "static", "void", "super", "null", "eval", "arguments", "public", "enum", "typeof",
    "undefined", "NaN", "__debug__", "__init__", "\u00b5", "\uff58", "\u017fin", "a b", "1a", "",
]  # fmt: skip
ROLES = {
    "input": lambda name: one(sp.Symbol(name or " "), [sp.Symbol(name or " ")]),
    "parameter": lambda name: one(x, Q, parameters=[sp.Symbol(name or " ")]),
    "step": lambda name: one(sp.Symbol(name or " "), Q, [(sp.Symbol(name or " "), x + 1)]),
    "output": lambda name: source("m", [Function("f", "", Q, {name: x})], **ABOUT),
    "function": lambda name: source("m", [Function(name, "", Q, {"out": x})], **ABOUT),
    "module": lambda name: source(name, [F], **ABOUT),
}


@pytest.mark.parametrize("role", ROLES)
def test_a_name_that_one_of_the_languages_cannot_read_is_refused_in_every_role(role):
    for name in NOT_A_NAME:
        with pytest.raises(BadInput, match="choose another"):
            ROLES[role](name)


@pytest.mark.parametrize("notebook", ['x"""\nimport os\n"""', "a/b", "", 3, "x.ipynb"])
def test_a_notebooks_name_puts_nothing_into_a_module(notebook):
    with pytest.raises(BadInput, match="`notebook` must be a chapter's name"):
        source("m", [F], notebook=notebook, doc="d")


@pytest.mark.parametrize("doc", ["nul \0 byte", 'quotes """ and \\', "a lone \ud800", "*/ end", "two\nlines\x0c"])
def test_any_text_can_be_a_docstring(doc, scratch):
    module = write("m", [Function("f", doc, (x,), {"out": x})], notebook="99-test", doc=doc)
    assert module.f(2.0) == 2.0
    assert_javascript(scratch / "m.js")


@pytest.mark.parametrize(
    "value", [sp.Integer(10) ** 400 * x, x * sp.Float("1e400"), sp.Rational(1, 10**400) + x, sp.Pow(-2, x)]
)
def test_no_number_is_written_that_code_cannot_hold(value):
    with pytest.raises(BadInput, match="cannot write"):
        one(value)


def test_a_parameter_is_a_symbol_also_where_no_function_takes_it():
    with pytest.raises(BadInput, match="`parameters` are SymPy symbols, each with its value; got 'L2'"):
        source("m", [], parameters={"L2": 0.1}, **ABOUT)


def test_text_is_never_evaluated():
    for attempt in (lambda: one("__import__('os')"), lambda: numbers("__import__('os').getpid()", {})):
        with pytest.raises(BadInput, match="an expression or a number is wanted"):
            attempt()


# ---- the printers --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("expression", "scalar", "batch"),
    [
        (sp.Max(x, y, 0), "max(max(0.0, q1), q2)", "xp.maximum(xp.maximum(0.0, q1), q2)"),
        (wrap(x), "remainder(q1, tau)", "wrap(q1)"),
        (x**2 / (2 * a * b), "q1*q1/(2*a*b)", "q1*q1/(2*a*b)"),
        (sp.Piecewise((x, x < y), (0, True)), "q1 if q1 < q2 else 0.0", "where(q1 < q2, q1, 0.0)"),
        (sp.Piecewise((a, a < b), (x, True)) - 1, "(a if a < b else q1) - 1", "(a if a < b else q1) - 1"),
        (sp.Max(x, a, b, 1), "max(max(max(1.0, a), b), q1)", "xp.maximum(max(max(1.0, a), b), q1)"),
        (sp.sqrt(a + 2) * sp.sqrt(x), "sqrt(2 + a)*sqrt(q1)", "sqrt(2 + a)*xp.sqrt(q1)"),
        (sp.atan2(y, x), "atan2(q2, q1)", "xp.atan2(q2, q1)"),
        (sp.pi / 2 - delta, "pi/2 - delta", "pi/2 - delta"),
        (0.1 + x, "q1 + 0.1", "q1 + 0.1"),
    ],
)
def test_each_dialect_has_its_words(expression, scalar, batch):
    for dialect, code in ((SCALAR, scalar), (BATCH, batch)):
        assert Printer(dialect, LENGTHS).code(expression) == code


def test_javascript_computes_the_same(tmp_path):
    node = shutil.which("node")
    if not node:
        pytest.skip("node is not installed")
    points = np.random.default_rng(4).uniform(-3, 3, (10, 2)).tolist()
    formulas = enumerate(FORMULAS.items())
    functions = [Function(f"f{i}", name, (x, y), {"out": formula}) for i, (name, formula) in formulas]
    (tmp_path / "m.mjs").write_text(script(functions, doc="A test."))
    calls = f"[{', '.join(f'm.f{i}' for i in range(len(functions)))}].map((f) => {points}.map((p) => f(...p)))"
    program = f"import('./m.mjs').then((m) => console.log(JSON.stringify({calls})))"
    done = subprocess.run([node, "-e", program], cwd=tmp_path, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    for found, formula in zip(ast.literal_eval(done.stdout), FORMULAS.values(), strict=True):
        expected = [run(one(formula, (x, y)))(*p) for p in points]
        np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12)
