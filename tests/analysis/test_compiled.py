"""Batches in machine code: the same numbers as NumPy's, with numba and without it, for every generated module."""

import math
from itertools import product
from types import ModuleType

import numpy as np
import pytest
import sympy as sp

import omx
from omx.analysis import compiled
from omx.derive import Function, source
from omx.generated import fk, ik, jacobian, polynomials

RANDOM = np.random.default_rng(0)
Q = RANDOM.uniform(*np.array(omx.LIMITS).T, (2, 6000, 4))
NEAR = RANDOM.uniform((-450, -450, -250, -7), (450, 450, 550, 7), (6000, 4))  # some out of reach in front, at the back
POSES = np.vstack([omx.pose(Q[0]), NEAR, [[0.0, 0.0, 300.0, 1.0], [0.0, -0.0, 300.0, 0.3]]])
AROUND = RANDOM.uniform(-1e4, 1e4, (11_000, 1))
CORNERS = np.vstack([RANDOM.normal(size=(11_000, 2)), [*product((0.0, 1.0, -1.0), repeat=2), (1e-300, -1e-300)]])
COURSE, SHORT = omx.COURSE, omx.COURSE.replace(L2=99.0, delta=0.0)
x, y, a, b = sp.symbols("x y a b", real=True)
cases = sp.Piecewise((sp.floor(3 * x), x < y), (y**2, True)) * sp.Piecewise((a, a < b), (x, True))
f = cases + sp.Max(sp.sqrt(x), y, a) + sp.atan2(sp.sqrt(y), x) + sp.atan2(y, sp.sqrt(x))
wild = ModuleType("wild")
exec(source("m", [Function("f", "NaN, and cases.", (x, y), {"f": f})], doc="", parameters=(a, b)), vars(wild))
with np.errstate(invalid="ignore"):
    WILD = wild.f_batch(*CORNERS.T, 0.5, 2.0)
MANY = {module: compiled.compile_batch(module) for module in (fk, ik, jacobian, polynomials, wild)}


@pytest.fixture(params=["numba", "absent"], autouse=True)
def way(request, monkeypatch):
    if request.param == "numba" and not compiled.available():
        pytest.skip("numba is not installed")
    monkeypatch.setattr(compiled, "available", lambda: request.param == "numba")


def turned(a, b):
    return np.abs(np.remainder(a - b + math.pi, math.tau) - math.pi)


@pytest.mark.parametrize("threads", [1, 2, 7])
@pytest.mark.parametrize(
    ("function", "arguments", "expected"),
    [
        (compiled.pose, (Q,), omx.pose(Q)),
        (compiled.pose, (np.asfortranarray(Q), SHORT), omx.pose(Q, SHORT)),
        (compiled.pose, (2e4 * Q,), omx.pose(2e4 * Q)),
        (compiled.pose, (Q.tolist(),), omx.pose(Q)),
        (MANY[fk].transform, (Q, *COURSE.values), omx.fk(Q)),
        (MANY[fk].frames, (Q, *COURSE.values), omx.frames(Q)[..., 1:, :, :]),
        (MANY[jacobian].jacobian, (Q, *SHORT.values), omx.jacobian(Q, SHORT)),
        (MANY[polynomials].sine, (AROUND,), np.sin(AROUND[:, 0])),
        (MANY[polynomials].cosine, (AROUND,), np.cos(AROUND[:, 0])),
        (MANY[wild].f, (CORNERS, 0.5, 2.0), WILD),
        (MANY[polynomials].arc_tangent, (CORNERS,), np.arctan2(*CORNERS.T)),
    ],
)  # fmt: skip
def test_every_function_gives_what_numpy_gives(function, arguments, expected, threads):
    found = function(*arguments, threads=threads)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12 * 400, strict=True)


@pytest.mark.parametrize("limits", [omx.LIMITS, tuple((0.3 * low, 0.3 * high) for low, high in omx.LIMITS)])
def test_so_does_the_inverse_with_its_verdicts(limits):
    q, reachable, legal = compiled.ik_batch(POSES, limits=limits)
    expected = omx.ik_batch(POSES, limits=limits)
    assert (reachable == expected.reachable).all()
    assert (legal == expected.legal).all()
    assert (np.isnan(q) == ~reachable[..., None]).all()
    assert turned(q, expected.q)[reachable].max() < 1e-6  # at a straight arm rounding weighs more
    assert np.median(turned(q, expected.q)[reachable]) < 1e-15
    assert 0 < legal.mean() < reachable.mean() < 1
    up, *_, D_back = MANY[ik].branches(POSES, *COURSE.values)  # of several shapes
    assert np.array_equal(turned(up, q[:, 0]).max(axis=1) < 1e-12, reachable[:, 0])
    assert np.array_equal(np.abs(D_back) <= 1 + 1e-13, reachable[:, 2])


def test_angles_are_half_open_where_the_arm_folds_and_behind_the_base():
    """Where angles come out as half a turn: straight back, a hair to the right of it, arms straight or folded."""
    bare = COURSE.replace(L1=0.0, delta=0.0)
    reach = (bare.L2 + bare.L3 + bare.L4, bare.L2 + bare.L3 - bare.L4, bare.L2 - bare.L3 + bare.L4, 200.0)
    sides, pitches = (0.0, -0.0, 1e-20, -1e-20, -5e-324), np.arange(-4, 5) * math.pi / 2
    rows = list(product((*reach, *(-r for r in reach)), sides, (0.0, -0.0), pitches))
    q, reachable, _ = compiled.ik_batch(np.tile(rows, (16, 1)), bare)
    assert ((q > -math.pi) & (q <= math.pi))[reachable].all()
    assert (q[reachable] == math.pi).any()


@pytest.mark.parametrize(
    ("call", "told"),
    [
        (lambda: compiled.pose(np.where(Q > 1.57, math.nan, Q)), "nan"),
        (lambda: compiled.ik_batch(np.where(POSES == 300.0, math.inf, POSES)), "inf"),
        (lambda: compiled.ik_batch(POSES[0]), r"omx\.ik|`ik`"),
        (lambda: compiled.ik_batch(POSES, COURSE.replace(L3=0.0)), "a link of length 0"),
        (lambda: compiled.pose(np.ma.array(Q, mask=Q > 1.5)), "a MaskedArray"),
        (lambda: compiled.pose(Q, threads=0), "threads"),
        (lambda: compiled.pose(Q, threads=2**33), "threads"),
        (lambda: compiled.ik_batch(POSES.reshape(2, -1, 4)), r"\(N, 4\)"),
        (lambda: MANY[fk].pose(Q[..., :3], *COURSE.values), r"q1, q2, q3, q4 before 5 .*shape \(4,\)"),
        (lambda: MANY[fk].pose(Q, "long", *COURSE.values[1:]), "`L1` must be a number"),
        (lambda: MANY[fk].pose(Q, *range(9)), "nothing before 9 parameters of `pose_batch`"),
    ],
)  # fmt: skip
def test_what_is_no_batch_for_the_function_is_refused(call, told):
    with pytest.raises(omx.BadInput, match=told):
        call()
