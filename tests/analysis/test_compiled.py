"""Batches in machine code: the same numbers as NumPy's, with numba and without it, for every generated module."""

import math
from itertools import product

import numpy as np
import pytest

import omx
from omx.analysis import compiled
from omx.generated import fk, ik, jacobian, polynomials

LENGTHS = omx.COURSE.values


@pytest.fixture(params=["numba", "absent"])
def way(request, monkeypatch):
    if request.param == "numba" and not compiled.available():
        pytest.skip("numba is not installed")
    monkeypatch.setattr(compiled, "available", lambda: request.param == "numba")


def joints(*shape, seed=0):
    low, high = np.array(omx.LIMITS).T
    return np.random.default_rng(seed).uniform(low, high, (*shape, 4))


def poses(count, seed=3):
    """Reachable poses, and poses anywhere near: some out of reach in front, at the back, or both."""
    near = np.random.default_rng(seed).uniform((-450, -450, -250, -7), (450, 450, 550, 7), (count // 2, 4))
    return np.vstack([omx.pose(joints(count - count // 2, seed=seed)), near])


def turned(a, b):
    """The difference of two angles, whole turns not counted."""
    return np.abs(np.remainder(a - b + math.pi, math.tau) - math.pi)


@pytest.mark.parametrize(
    ("polynomial", "function", "end"),
    [
        (polynomials.sine, math.sin, math.pi / 2),
        (polynomials.cosine, math.cos, math.pi / 2),
        (polynomials.arc_tangent, math.atan, math.tan(math.pi / 8)),
    ],
    ids=["sine", "cosine", "arc tangent"],
)
def test_polynomial_is_right_to_the_last_bits_in_its_range_only(polynomial, function, end):
    for t in np.linspace(-end, end, 2001).tolist():
        assert polynomial(t) == pytest.approx(function(t), abs=4e-16)
    assert abs(polynomial(3 * end) - function(3 * end)) > 1e-9


def test_functions_agree_with_those_of_math():
    pytest.importorskip("numba", reason="numba is not installed")
    functions = compiled._functions()
    for x in np.random.default_rng(1).uniform(-compiled.RANGE[0], compiled.RANGE[0], 300).tolist():
        assert functions["sin"](x) == pytest.approx(math.sin(x), abs=1e-14)
        assert functions["cos"](x) == pytest.approx(math.cos(x), abs=1e-14)
        assert turned(functions["remainder"](x, math.tau), x) < 1e-13
    corners = [*product((0.0, 1.0, -1.0), repeat=2), (1e-300, -1e-300)]
    for y, x in [*np.random.default_rng(2).normal(size=(300, 2)).tolist(), *corners]:
        assert functions["atan2"](y, x) == pytest.approx(math.atan2(y, x), abs=1e-15)


@pytest.mark.parametrize("shape", [(), (1,), (2, 3), (512,), (5001,)])
@pytest.mark.parametrize("geometry", [omx.COURSE, omx.COURSE.replace(L2=99.0, delta=0.0)], ids=lambda g: g.name)
def test_pose_is_that_of_numpy(way, shape, geometry):
    q = joints(*shape)
    found, expected = compiled.pose(q, geometry), np.asarray(omx.pose(q, geometry))
    assert found.shape == expected.shape
    assert np.abs(found - expected)[..., :3].max() < 1e-12
    assert turned(found[..., 3], expected[..., 3]).max() < 1e-14


def test_angles_beyond_the_range_and_a_transposed_batch_are_right_all_the_same(way):
    q = np.asfortranarray(joints(700) * 1e3)
    assert compiled.pose(q)[:, :3] == pytest.approx(omx.pose(q)[:, :3], abs=1e-9)


@pytest.mark.parametrize("limits", [omx.LIMITS, tuple((0.3 * low, 0.3 * high) for low, high in omx.LIMITS)])
def test_ik_is_that_of_numpy(way, limits):
    far = [[0.0, 0.0, 300.0, 1.0], [0.0, -0.0, 300.0, 0.3], [1e12, 0.0, 0.0, 0.0], [1e200, 1e200, 0.0, 0.0]]
    targets = np.vstack([poses(5000), far])
    q, reachable, legal = compiled.ik_batch(targets, limits=limits)
    q_numpy, reachable_numpy, legal_numpy = omx.ik_batch(targets, limits=limits)
    assert (reachable == reachable_numpy).all()
    assert (legal == legal_numpy).all()
    assert (np.isnan(q) == ~reachable[..., None]).all()
    assert turned(q, q_numpy)[reachable].max() < 1e-6  # at a straight arm rounding weighs more
    assert np.median(turned(q, q_numpy)[reachable]) < 1e-15
    assert 0 < legal.mean() < reachable.mean() < 1


def test_angles_are_half_open_where_the_arm_folds_and_behind_the_base(way):
    """Where angles come out as half a turn: straight back, a hair to the right of it, arms straight or folded."""
    bare = omx.COURSE.replace(L1=0.0, delta=0.0)
    reach = (bare.L2 + bare.L3 + bare.L4, bare.L2 + bare.L3 - bare.L4, bare.L2 - bare.L3 + bare.L4, 200.0)
    sides, pitches = (0.0, -0.0, 1e-20, -1e-20, -5e-324), np.arange(-4, 5) * math.pi / 2
    q, reachable, _ = compiled.ik_batch(
        list(product((*reach, *(-r for r in reach)), sides, (0.0, -0.0), pitches)), bare
    )
    assert ((q > -math.pi) & (q <= math.pi))[reachable].all()
    assert (q[reachable] == math.pi).any()


def test_every_function_of_a_generated_module_is_compiled(way):
    q = joints(2, 300)
    forward, velocity, inverse = (compiled.compile_batch(module) for module in (fk, jacobian, ik))
    assert forward.transform(q, *LENGTHS) == pytest.approx(omx.fk(q), abs=1e-12 * 400)
    assert forward.frames(q, *LENGTHS) == pytest.approx(omx.frames(q)[..., 1:, :, :], abs=1e-12 * 400)
    assert velocity.jacobian(q, *LENGTHS) == pytest.approx(omx.jacobian(q), abs=1e-12 * 400)
    *branches, front, _ = inverse.branches(omx.pose(q), *LENGTHS)
    assert [branch.shape for branch in branches] == [(2, 300, 4)] * 4
    assert (np.abs(front) <= 1 + 1e-13).mean() > 0.5
    with pytest.raises(omx.BadInput, match=r"shape \(4,\)"):
        forward.pose(np.zeros((3, 5)), *LENGTHS)
    with pytest.raises(omx.BadInput, match="9 arguments; got rows and 9 parameters"):
        forward.pose(q, *range(9))


@pytest.mark.parametrize("threads", [2, 3, 7])
def test_threads_change_nothing(way, threads):
    q, targets = joints(900), poses(900)
    assert (compiled.pose(q, threads=threads) == compiled.pose(q, threads=1)).all()
    assert compiled.pose(q[:2], threads=threads) == pytest.approx(omx.pose(q[:2]), abs=1e-12)
    several, one = (compiled.ik_batch(targets, threads=number) for number in (threads, 1))
    assert all(np.array_equal(a, b, equal_nan=a.dtype == np.float64) for a, b in zip(several, one, strict=True))


def test_results_written_past_the_caches_are_those_that_stay_in_them():
    pytest.importorskip("numba", reason="numba is not installed")
    rows, piece = compiled.CACHED // (16 * 8) + 5, 50_000
    targets = omx.pose(joints(rows))
    whole = compiled.ik_batch(targets)
    pieces = zip(*(compiled.ik_batch(targets[k : k + piece]) for k in range(0, rows, piece)), strict=True)
    assert all(np.array_equal(a, np.concatenate(b), equal_nan=a.ndim == 3) for a, b in zip(whole, pieces, strict=True))


def test_float32_errs_by_less_than_a_ten_thousandth_of_a_mm(way):
    q, targets = joints(5000), poses(5000)
    found = compiled.pose(q.astype(np.float32), dtype=np.float32)
    assert found.dtype == np.float32
    assert np.abs(found - omx.pose(q))[:, :3].max() < 1e-4
    angles, (exact, reachable, _) = compiled.ik_batch(targets, dtype=np.float32)[0], compiled.ik_batch(targets)
    assert angles.dtype == np.float32
    assert turned(angles, exact)[reachable].max() < 2e-7


@pytest.mark.parametrize("bad", [math.nan, math.inf, [1.0, 2.0, 3.0], np.empty((0, 4)), "home", np.zeros((3, 5))])
def test_what_is_no_batch_of_numbers_is_refused(way, bad):
    if isinstance(bad, float):
        bad = np.where(np.arange(2800).reshape(700, 4) == 2600, bad, 0.1)
    for function in (compiled.pose, compiled.ik_batch):
        with pytest.raises(omx.BadInput):
            function(bad)
    with pytest.raises(omx.BadInput, match=r"omx\.ik"):
        compiled.ik_batch([200.0, 0.0, 100.0, 0.0])


def test_what_has_no_inverse_or_no_limits_is_refused(way):
    """As by `omx.ik_batch`: without a look, the compiled loop would give verdicts."""
    for wrong, told in (
        ({"geometry": omx.COURSE.replace(L2=-130.0)}, "L2 must not be below 0"),
        ({"geometry": omx.COURSE.replace(L3=0.0)}, "a link of length 0"),
        ({"geometry": omx.COURSE.chain}, "`geometry` must be a Geometry"),
        ({"limits": omx.LIMITS[:3]}, "`limits` must be 4 pairs"),
        ({"limits": [(-90, 90)] * 4}, "degrees"),
    ):
        with pytest.raises(omx.BadInput, match=told):
            compiled.ik_batch(poses(10), **wrong)
    with pytest.raises(omx.BadInput, match="`geometry` must be a Geometry"):
        compiled.pose(joints(3), omx.COURSE.chain)


@pytest.mark.parametrize("options", [{"threads": 0}, {"threads": -2}, {"dtype": np.int64}])
def test_impossible_options_are_refused(way, options):
    with pytest.raises(omx.BadInput, match=next(iter(options))):
        compiled.pose(joints(10), **options)
