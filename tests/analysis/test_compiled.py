"""Batches in machine code: the same numbers as NumPy's, with numba, without it, and with its code run as Python."""

import math
from functools import cache
from itertools import product

import numpy as np
import pytest

import omx
from omx.analysis import compiled
from omx.generated import polynomials

COUNT = 5000  # several rounds, the last one cut short

#: How the loops run: by numba, by nothing (the fall-back), or as the plain Python that numba would compile.
WAYS = ["numba", "absent", "python"]


@pytest.fixture(params=WAYS)
def way(request, monkeypatch):
    if request.param == "numba" and not compiled.available():
        pytest.skip("numba is not installed")
    monkeypatch.setattr(compiled, "available", lambda: request.param != "absent")
    if request.param != "python":
        yield request.param
        return
    monkeypatch.setattr(compiled, "_compile", lambda function, **options: function)
    for name in ("_functions", "_loops"):  # caches of their own, so that what numba compiled is kept
        monkeypatch.setattr(compiled, name, cache(getattr(compiled, name).__wrapped__))
    with np.errstate(all="ignore"):  # compiled code does not warn
        yield request.param


def random_joints(count, seed=0):
    low, high = np.array(omx.LIMITS).T
    return np.random.default_rng(seed).uniform(low, high, (count, 4))


def size(way):
    return 600 if way == "python" else COUNT


def turned(a, b):
    """The difference of two angles, whole turns not counted."""
    return np.abs(np.remainder(a - b + math.pi, math.tau) - math.pi)


# ---- the polynomials -------------------------------------------------------------------------------------


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


def test_functions_agree_with_those_of_math(way):
    if way == "absent":
        pytest.skip("nothing is compiled")
    functions = compiled._functions()
    for x in np.random.default_rng(1).uniform(-compiled.RANGE[0], compiled.RANGE[0], 300).tolist():
        assert functions["sin"](x) == pytest.approx(math.sin(x), abs=1e-14)
        assert functions["cos"](x) == pytest.approx(math.cos(x), abs=1e-14)
        assert turned(functions["remainder"](x, math.tau), x) < 1e-13
    for y, x in np.random.default_rng(2).normal(size=(300, 2)).tolist():
        assert functions["atan2"](y, x) == pytest.approx(math.atan2(y, x), abs=1e-15)


@pytest.mark.parametrize(("y", "x"), [(0, 0), (0, 1), (0, -1), (1, 0), (-1, 0), (1, 1), (-1, -1), (1e-300, -1e-300)])
def test_arc_tangent_in_every_direction(way, y, x):
    if way == "absent":
        pytest.skip("nothing is compiled")
    assert compiled._functions()["atan2"](float(y), float(x)) == pytest.approx(math.atan2(y, x), abs=1e-15)


# ---- forward ---------------------------------------------------------------------------------------------


def test_pose_is_that_of_numpy(way):
    q = random_joints(size(way))
    found, expected = compiled.pose(q), omx.pose(q)
    assert np.abs(found - expected)[:, :3].max() < 1e-12
    assert turned(found[:, 3], expected[:, 3]).max() < 1e-14


@pytest.mark.parametrize("geometry", [omx.MAKER, omx.COURSE.replace(L2=99.0, delta=0.0)], ids=lambda g: g.name)
def test_pose_of_another_arm(way, geometry):
    q = random_joints(200)
    assert compiled.pose(q, geometry)[:, :3] == pytest.approx(omx.pose(q, geometry)[:, :3], abs=1e-12)


@pytest.mark.parametrize("shape", [(4,), (1, 4), (2, 3, 4), (512, 4), (513, 4)])
def test_pose_keeps_the_shape(way, shape):
    q = random_joints(math.prod(shape) // 4).reshape(shape)
    assert compiled.pose(q).shape == shape
    assert compiled.pose(q) == pytest.approx(np.asarray(omx.pose(q)), abs=1e-12)


def test_angles_beyond_the_range_are_right_all_the_same(way):
    q = random_joints(700) * 1e3
    assert compiled.pose(q)[:, :3] == pytest.approx(omx.pose(q)[:, :3], abs=1e-9)


def test_pitch_is_half_open(way):
    q = [[0.0, -math.pi, 0.0, 0.0], [0.0, math.pi, 0.0, 0.0]]
    pitch = compiled.pose(q)[:, 3]
    assert turned(pitch, math.pi).max() < 1e-14
    assert (pitch > -math.pi).all()


def test_a_transposed_batch(way):
    q = np.asfortranarray(random_joints(100))
    assert compiled.pose(q) == pytest.approx(omx.pose(q), abs=1e-12)


# ---- inverse ---------------------------------------------------------------------------------------------


def poses(count, seed=3):
    """Reachable poses, and poses anywhere near: some out of reach in front, at the back, or both."""
    random = np.random.default_rng(seed)
    near = random.uniform((-450, -450, -250, -7), (450, 450, 550, 7), (count // 2, 4))
    return np.vstack([omx.pose(random_joints(count - count // 2, seed)), near])


def test_ik_is_that_of_numpy(way):
    targets = poses(size(way))
    q, reachable, legal = compiled.ik_batch(targets)
    q_numpy, reachable_numpy, legal_numpy = omx.ik_batch(targets)
    assert (reachable == reachable_numpy).all()
    assert (legal == legal_numpy).all()
    assert (np.isnan(q) == ~reachable[..., None]).all()
    assert turned(q, q_numpy)[reachable].max() < 1e-6  # at a straight arm rounding weighs more
    assert np.median(turned(q, q_numpy)[reachable]) < 1e-15
    assert 0 < legal.mean() < reachable.mean() < 1


def test_there_and_back_again(way):
    targets = poses(size(way))
    q, reachable, _ = compiled.ik_batch(targets)
    back = omx.pose(q[reachable])
    wanted = np.broadcast_to(targets[:, None], q.shape)[reachable]
    assert np.abs(back - wanted)[:, :3].max() < 1e-10
    assert turned(back[:, 3], wanted[:, 3]).max() < 1e-13


def test_limits_count(way):
    targets = poses(400)
    tight = tuple((0.3 * low, 0.3 * high) for low, high in omx.LIMITS)
    assert (compiled.ik_batch(targets, limits=tight)[2] == omx.ik_batch(targets, limits=tight)[2]).all()


def test_targets_on_the_axis_and_far_away(way):
    targets = [[0.0, 0.0, 300.0, 1.0], [0.0, -0.0, 300.0, 0.3], [1e12, 0.0, 0.0, 0.0], [1e200, 1e200, 0.0, 0.0]]
    q, reachable, legal = compiled.ik_batch(targets)
    expected = omx.ik_batch(targets)
    assert (reachable == expected[1]).all()
    assert (legal == expected[2]).all()
    assert turned(q, expected[0])[reachable].max() < 1e-12


def test_angles_are_half_open_where_the_arm_folds_and_behind_the_base(way):
    """Where angles come out as half a turn: straight back, a hair to the right of it, arms straight or folded."""
    bare = omx.COURSE.replace(L1=0.0, delta=0.0)
    reach = (bare.L2 + bare.L3 + bare.L4, bare.L2 + bare.L3 - bare.L4, bare.L2 - bare.L3 + bare.L4, 200.0)
    sides = (0.0, -0.0, 1e-20, -1e-20, -5e-324)
    pitches = np.arange(-4, 5) * math.pi / 2
    targets = list(product((*reach, *(-r for r in reach)), sides, (0.0, -0.0), pitches))
    q, reachable, _ = compiled.ik_batch(targets, bare)
    q_numpy, reachable_numpy, _ = omx.ik_batch(targets, bare)
    for angles, reached in ((q, reachable), (q_numpy, reachable_numpy)):
        assert ((angles > -math.pi) & (angles <= math.pi))[reached].all()
    assert (q[reachable] == math.pi).any()


# ---- threads, float32, mistakes --------------------------------------------------------------------------


@pytest.mark.parametrize("threads", [1, 2, 3, 7])
def test_threads_change_nothing(way, threads):
    q, targets = random_joints(size(way)), poses(size(way))
    assert (compiled.pose(q, threads=threads) == compiled.pose(q, threads=1)).all()
    several, one = (compiled.ik_batch(targets, threads=number) for number in (threads, 1))
    for found, expected in zip(several, one, strict=True):
        assert np.array_equal(found, expected, equal_nan=found.dtype == np.float64)


def test_more_threads_than_rows(way):
    q = random_joints(2)
    assert compiled.pose(q, threads=5) == pytest.approx(omx.pose(q), abs=1e-12)


def test_float32_errs_by_less_than_a_ten_thousandth_of_a_mm(way):
    q = random_joints(size(way))
    found = compiled.pose(q.astype(np.float32), dtype=np.float32)
    assert found.dtype == np.float32
    assert np.abs(found - omx.pose(q))[:, :3].max() < 1e-4
    targets = poses(size(way))
    angles = compiled.ik_batch(targets, dtype=np.float32)[0]
    exact, reachable, _ = compiled.ik_batch(targets)
    assert angles.dtype == np.float32
    assert turned(angles, exact)[reachable].max() < 2e-7


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_numbers_that_are_none_are_refused(way, bad):
    q = random_joints(700)
    q[650, 2] = bad
    with pytest.raises(omx.BadInput, match="finite"):
        compiled.pose(q)
    with pytest.raises(omx.BadInput, match="finite"):
        compiled.ik_batch(q)


@pytest.mark.parametrize("bad", [[1.0, 2.0, 3.0], np.empty((0, 4)), "home", [[None] * 4], np.zeros((3, 5))])
def test_what_is_no_batch_is_refused(way, bad):
    with pytest.raises(omx.BadInput):
        compiled.pose(bad)
    with pytest.raises(omx.BadInput):
        compiled.ik_batch(bad)


@pytest.mark.parametrize("options", [{"threads": 0}, {"threads": -2}, {"dtype": np.int64}])
def test_impossible_options_are_refused(way, options):
    if way == "absent" and "threads" in options:
        pytest.skip("nothing is shared out")
    with pytest.raises(omx.BadInput, match=next(iter(options))):
        compiled.pose(random_joints(10), **options)


def test_one_pose_is_sent_to_ik(way):
    with pytest.raises(omx.BadInput, match=r"omx\.ik"):
        compiled.ik_batch([200.0, 0.0, 100.0, 0.0])
