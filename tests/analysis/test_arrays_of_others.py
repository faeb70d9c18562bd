"""One source, every array: the same formulas on the arrays of other libraries, equal to NumPy, same kind out.

Runs where those libraries are: `tests/analysis/test_optional.py` makes such an environment. Dask's arrays are lazy,
those of array_api_strict refuse whatever the standard does not promise, JAX's can be compiled and differentiated.
"""

import inspect
from types import ModuleType

import numpy as np
import pytest
import sympy as sp

import omx
from omx.arrays import of_rows, where
from omx.derive import Function, source
from omx.generated import fk, gravity, ik, jacobian, polynomials

Q = np.random.default_rng(3).uniform(-1.4, 1.4, (5, 7, 4))
POSES = np.concatenate(
    [omx.pose(Q.reshape(-1, 4)), [[900.0, 0.0, 100.0, 0.3], [0.0, 0.0, 300.0, 1.5], [100.0, 0.0, 80.0, 9.0]]]
)
KINDS = ("jax", "dask", "array_api_strict", "torch", "cupy")
FUNCTIONS = {"pose": omx.pose, "fk": omx.fk, "frames": omx.frames, "jacobian": omx.jacobian}


@pytest.fixture(params=KINDS)
def kind(request):
    """(makes an array of this library from NumPy's, brings one back)"""
    library = pytest.importorskip(request.param, reason=f"{request.param} is not installed")
    if request.param == "jax":
        library.config.update("jax_enable_x64", True)
        return library.numpy.asarray, np.asarray
    if request.param == "dask":
        array = pytest.importorskip("dask.array")
        return (lambda a: array.from_array(a, chunks=(3,) * (a.ndim - 1) + (4,))), lambda a: a.compute()
    if request.param == "torch":
        device = "cuda" if library.cuda.is_available() else "cpu"
        return (lambda a: library.asarray(a, device=device)), lambda a: a.cpu().numpy()
    if request.param == "cupy":
        return library.asarray, library.asnumpy
    return library.asarray, np.from_dlpack


@pytest.mark.parametrize("name", FUNCTIONS)
def test_the_forward_functions_are_those_of_numpy(kind, name):
    there, back = kind
    q = there(Q)
    found = FUNCTIONS[name](q)
    assert type(found) is type(q)
    np.testing.assert_allclose(back(found), FUNCTIONS[name](Q), atol=1e-12 * 400)


def test_the_four_branches_are_those_of_numpy(kind):
    there, back = kind
    expected = omx.ik_batch(POSES)
    found = omx.ik_batch(there(POSES))
    for ours, theirs in zip(expected[1:], found[1:], strict=True):
        np.testing.assert_array_equal(back(theirs), ours)
    gap = back(found[0]) - expected[0]
    assert np.nanmax(np.abs(np.arctan2(np.sin(gap), np.cos(gap)))) < 1e-12
    np.testing.assert_array_equal(np.isnan(back(found[0])), np.isnan(expected[0]))


def test_another_geometry_and_other_limits_go_along(kind):
    there, back = kind
    np.testing.assert_allclose(back(omx.pose(there(Q), omx.MAKER)), omx.pose(Q, omx.MAKER), atol=1e-9)
    narrow = ((-1.0, 1.0),) * 4
    np.testing.assert_array_equal(
        back(omx.ik_batch(there(POSES), limits=narrow)[2]), omx.ik_batch(POSES, limits=narrow)[2]
    )


t, L1, L2 = sp.symbols("t L1 L2", positive=True)
SHORTER = sp.Piecewise((L1, L1 < L2), (L2, True))
CASES = {
    "out": t * SHORTER + sp.Max(t, L1, L2) + sp.Piecewise((3, t < L1), (-1, True)) + sp.sqrt(L2),
    "length": SHORTER,
}
lengths = ModuleType("omx.generated.lengths")
exec(source("m", [Function("f", "Cases.", (t,), CASES)], doc="A test.", parameters=(L1, L2)), vars(lengths))


@pytest.mark.parametrize(
    "module", [fk, ik, jacobian, gravity, polynomials, lengths], ids=lambda module: module.__name__[14:]
)
def test_every_generated_function_takes_them(kind, module):
    """Also what is computed of lengths alone, which are plain numbers, and what tells cases apart."""
    there, back = kind
    for name in (name for name in dir(module) if name.endswith("_batch")):
        batch = getattr(module, name)
        names = inspect.signature(batch).parameters.values()
        numbers = {p.name: fk.PARAMETERS.get(p.name, 2.0) for p in names if p.annotation is float}
        inputs = [p.name for p in names if p.annotation is not float]
        columns = dict(zip(inputs, np.ascontiguousarray(POSES.T), strict=False))
        others = batch(**numbers, **{name: there(column) for name, column in columns.items()})
        for one, other in zip(leaves(batch(**numbers, **columns)), leaves(others), strict=True):
            found = back(other) if hasattr(other, "shape") else other
            np.testing.assert_allclose(found, one, atol=1e-9, err_msg=name)
            assert np.asarray(found).dtype in (np.float64, int)


def test_a_function_of_columns_becomes_one_of_rows(kind):
    there, back = kind
    for batch, expected in ((fk.transform_batch, omx.fk(Q)), (jacobian.jacobian_batch, omx.jacobian(Q))):
        np.testing.assert_allclose(back(of_rows(batch)(there(Q), *omx.COURSE.values)), expected, atol=1e-9)
    *branches, D, _ = of_rows(ik.branches_batch)(there(POSES), *omx.COURSE.values)
    assert [tuple(branch.shape) for branch in branches] == [(len(POSES), 4)] * 4
    assert tuple(D.shape) == (len(POSES),)
    with pytest.raises(omx.BadInput, match=r"q1, q2, q3 before 6 parameters of `pose_batch`, shape \(3,\)"):
        of_rows(fk.pose_batch)(there(Q), *omx.COURSE.values, 1.0)


def leaves(results):
    return [leaf for part in results for leaf in leaves(part)] if isinstance(results, tuple) else [results]


def test_a_choice_between_numbers_is_as_exact_as_numpys(kind):
    there, back = kind
    found = back(where(there(Q) > 0, 0.1, 0.0))
    assert found.dtype == np.float64
    np.testing.assert_array_equal(found, np.where(Q > 0, 0.1, 0.0))


def test_lengths_without_an_inverse_are_refused(kind):
    there, _ = kind
    with pytest.raises(omx.BadInput, match="a link of length 0"):
        omx.ik_batch(there(POSES), omx.COURSE.replace(L3=0.0))


def test_a_wrong_shape_is_named(kind):
    there, _ = kind
    with pytest.raises(omx.BadInput, match=r"got shape \(5, 7, 3\)"):
        omx.pose(there(np.ascontiguousarray(Q[..., :3])) if there.__name__ != "<lambda>" else there(Q)[..., :3])


# ---- JAX: compiled, mapped, differentiated ----


@pytest.fixture
def jax():
    jax = pytest.importorskip("jax", reason="jax is not installed")
    jax.config.update("jax_enable_x64", True)
    return jax


def test_the_derivative_of_the_generated_pose_is_the_jacobian(jax):
    slopes = jax.vmap(jax.jacfwd(omx.pose))(jax.numpy.asarray(Q.reshape(-1, 4)))
    np.testing.assert_allclose(slopes[:, :3], omx.jacobian(Q.reshape(-1, 4))[:, :3], atol=1e-12 * 400)
    np.testing.assert_allclose(slopes[:, 3], np.broadcast_to([0, -1, -1, -1], (35, 4)), atol=1e-12)


def test_compiling_and_mapping_change_nothing(jax):
    q = jax.numpy.asarray(Q.reshape(-1, 4))
    for function in FUNCTIONS.values():
        np.testing.assert_allclose(jax.jit(function)(q), function(q), atol=1e-9)
        np.testing.assert_allclose(jax.vmap(function)(q), function(q), atol=1e-9)
    compiled = jax.jit(omx.ik_batch)(jax.numpy.asarray(POSES))
    for one, other in zip(compiled, omx.ik_batch(POSES), strict=True):
        np.testing.assert_allclose(one, other, atol=1e-9)


def test_the_way_through_the_inverse_and_back_has_derivative_one(jax):
    """d FK(IK(p)) / dp = 1, by the chain rule through both generated modules."""
    there_and_back = jax.vmap(jax.jacfwd(lambda p: omx.pose(omx.ik_batch(p)[0][0])))
    inner = POSES[:35][omx.ik_batch(POSES[:35])[1][:, 0]]
    np.testing.assert_allclose(
        there_and_back(jax.numpy.asarray(inner)), np.broadcast_to(np.eye(4), (len(inner), 4, 4)), atol=1e-6
    )
