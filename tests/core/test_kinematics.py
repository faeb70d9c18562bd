"""Forward kinematics and the Jacobian: against the plain DH product, pinocchio and differences, scalar and batch."""

import ast
import inspect
from math import nan, pi

import numpy as np
import pytest

import omx
from omx.generated import fk, gravity, ik, jacobian
from tests.helpers import oracles

GEOMETRIES = {"course": oracles.COURSE, "maker": omx.MAKER.values}
Q = np.concatenate([oracles.random_q(300), oracles.any_q(300, 1), oracles.degenerate_q()])


def geometry_of(name):
    return {"course": omx.COURSE, "maker": omx.MAKER}[name]


# ---- against authorities -------------------------------------------------------------------------------


@pytest.mark.parametrize("name", GEOMETRIES)
def test_every_frame_is_the_product_of_its_elementary_moves(name):
    for q in Q:
        expected = oracles.arm_frames(q, GEOMETRIES[name])
        frames = omx.frames(q, geometry_of(name))
        np.testing.assert_array_equal(frames[0], np.eye(4))
        np.testing.assert_allclose(frames[1:], expected, atol=5e-13)
        np.testing.assert_allclose(omx.fk(q, geometry_of(name)), expected[-1], atol=5e-13)


def test_the_pose_is_the_last_column_and_the_hands_elevation():
    expected = [oracles.task_pose(oracles.arm_frames(q)[-1]) for q in Q]
    assert oracles.pose_gap(omx.pose(Q), expected).max() < 5e-13


def test_pinocchio_agrees_on_poses_and_jacobians():
    pin, model, data, tool = oracles.pinocchio_arm(oracles.table(*oracles.COURSE))
    transforms, jacobians = omx.fk(Q), omx.jacobian(Q)
    for q, T, J in zip(Q, transforms, jacobians, strict=True):
        expected = pin.computeFrameJacobian(model, data, q, tool, pin.LOCAL_WORLD_ALIGNED)
        pin.framesForwardKinematics(model, data, q)
        np.testing.assert_allclose(T, data.oMf[tool].homogeneous, atol=5e-13)
        np.testing.assert_allclose(J, expected, atol=5e-13)


# ---- the Jacobian --------------------------------------------------------------------------------------


def test_linear_rows_are_the_derivative_of_the_position():
    h = 1e-4  # central differences: h^2 from the formula, 1e-13 / h from rounding
    steps = h * np.eye(4)
    ahead, behind = (omx.pose(Q[:, None] + sign * steps)[..., :3] for sign in (1, -1))
    differences = np.swapaxes((ahead - behind) / (2 * h), 1, 2)
    np.testing.assert_allclose(omx.jacobian(Q)[:, :3], differences, atol=1e-5)


def test_angular_rows_turn_the_rotation_matrix():
    h = 1e-4
    for j in range(4):
        step = h * np.eye(4)[j]
        R, ahead, behind = (omx.fk(q)[:, :3, :3] for q in (Q, Q + step, Q - step))
        spin = (ahead - behind) / (2 * h) @ np.swapaxes(R, 1, 2)
        w = np.stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]], axis=-1)
        np.testing.assert_allclose(omx.jacobian(Q)[:, 3:, j], w, atol=1e-7)


def task_jacobian(q):
    """d(x, y, z, pitch)/dq: the linear rows, and a pitch that every joint but the first turns down."""
    J = omx.jacobian(q)
    return np.concatenate([J[..., :3, :], np.broadcast_to([[0.0, -1, -1, -1]], (*J.shape[:-2], 1, 4))], axis=-2)


def test_the_determinant_is_that_of_the_closed_form():
    """det = -L2 L3 r cos(q3 - delta)."""
    L2, L3, delta = omx.COURSE.L2, omx.COURSE.L3, omx.COURSE.delta
    r = np.einsum("ij,ij->i", omx.fk(Q)[:, :2, 3], np.column_stack([np.cos(Q[:, 0]), np.sin(Q[:, 0])]))
    det = np.linalg.det(task_jacobian(Q))
    np.testing.assert_allclose(det, -L2 * L3 * r * np.cos(Q[:, 2] - delta), atol=1e-6)


@pytest.mark.parametrize("place", ["straight", "folded", "over the axis"])
def test_the_arm_is_singular_where_the_determinant_says(place):
    q = oracles.any_q(50)
    if place == "over the axis":
        q = oracles.over_the_axis()[:: len(oracles.NEAR)]
    else:
        q[:, 2] = omx.COURSE.delta + {"straight": -pi / 2, "folded": pi / 2}[place]
    singular = np.linalg.svd(task_jacobian(q), compute_uv=False)[:, -1]
    assert singular.max() < 1e-12


# ---- one and many --------------------------------------------------------------------------------------


def test_one_configuration_is_a_row_of_the_batch():
    assert oracles.pose_gap(omx.pose(Q), [omx.pose(q) for q in Q]).max() < 5e-13
    for function in (omx.fk, omx.frames, omx.jacobian):
        np.testing.assert_allclose(function(Q), [function(q) for q in Q], atol=5e-13)


SHAPES = {"pose": (4,), "fk": (4, 4), "frames": (5, 4, 4), "jacobian": (6, 4)}


@pytest.mark.parametrize(("name", "shape"), SHAPES.items())
def test_leading_axes_are_kept(name, shape):
    q = oracles.random_q(24).reshape(2, 3, 4, 4)
    out = getattr(omx, name)(q)
    assert out.shape == (2, 3, 4, *shape)
    np.testing.assert_allclose(out[1, 2, 3], getattr(omx, name)(q[1, 2, 3]), atol=1e-12)


def test_a_batch_of_one_is_still_a_batch():
    assert omx.pose([[0.0, 0, 0, 0]]).shape == (1, 4)


def test_a_batch_longer_than_a_block_has_no_seam():
    q = oracles.random_q(2 * 8192 + 3)
    np.testing.assert_allclose(omx.pose(q)[8190:8195], omx.pose(q[8190:8195]), atol=1e-12)


def test_strided_and_reversed_views_are_read_right():
    q = oracles.random_q(100)
    np.testing.assert_array_equal(omx.pose(q[::-3]), omx.pose(q[::-3].copy()))
    np.testing.assert_array_equal(omx.pose(np.asfortranarray(q)), omx.pose(q))


# ---- the scalar path -----------------------------------------------------------------------------------

EXACT = (0.25, -0.5, 0.75, 0.125)  # the same numbers in float32


@pytest.mark.parametrize(
    "q",
    [EXACT, list(EXACT), np.array(EXACT), np.array(EXACT, np.float32), [np.float32(a) for a in EXACT],
     [np.float64(a) for a in EXACT], (np.array(EXACT)[0], *EXACT[1:])],
    ids=["tuple", "list", "array", "float32", "list of float32", "list of float64", "mixed"],
)  # fmt: skip
def test_four_numbers_of_any_kind_give_a_pose_of_plain_floats(q):
    pose = omx.pose(q)
    assert type(pose) is omx.Pose
    assert [type(value) for value in pose] == [float] * 4
    assert pose == omx.pose(EXACT)


@pytest.mark.parametrize("q", [(1, 0, -1, 2), np.array([1, 0, -1, 2]), [1, 0.0, -1, 2]])
def test_whole_numbers_are_angles_too(q):
    assert omx.pose(q) == omx.pose((1.0, 0.0, -1.0, 2.0))


def test_an_ik_solution_stands_for_its_angles():
    solution = omx.ik((200, 50, 150, -0.3))[0]
    assert omx.pose(solution) == omx.pose(solution.q)
    np.testing.assert_array_equal(omx.fk(solution), omx.fk(solution.q))


def scalar_functions():
    for module in (fk, ik, jacobian, gravity):
        for name, function in inspect.getmembers(module, inspect.isfunction):
            if function.__module__ == module.__name__ and not name.endswith("_batch") and name != "dh_rows":
                yield pytest.param(function, id=f"{module.__name__.split('.')[-1]}.{name}")


@pytest.mark.parametrize("function", list(scalar_functions()))
def test_the_scalar_formulas_use_the_math_module_alone(function):
    tree = ast.parse(inspect.getsource(function))
    called = {node.func.id for node in ast.walk(tree) if isinstance(node, ast.Call)}
    allowed = {"sin", "cos", "atan2", "sqrt", "remainder"}
    assert called <= allowed | {"abs", "max", "min"}
    assert all(function.__globals__[name].__module__ == "math" for name in called & allowed)


def test_the_pitch_is_in_the_half_open_interval():
    for total in (pi, -pi, 3 * pi, -3 * pi, 7 * pi):
        assert omx.pose((0, 0, 0, total)).pitch == pytest.approx(pi, abs=1e-14)
    q = np.zeros((5, 4))
    q[:, 3] = np.array([1, -1, 3, -3, 7]) * pi
    pitch = np.concatenate([omx.pose(q)[:, 3], omx.pose(oracles.any_q(100_000) * 3)[:, 3]])
    assert (pitch > -pi).all()
    assert (pitch <= pi).all()


def test_a_pitch_of_many_turns_is_that_of_one():
    assert omx.pose((0, 0.5 + 2e3 * pi, 0, 0)).pitch == pytest.approx(-0.5, abs=1e-11)


# ---- mistakes ------------------------------------------------------------------------------------------

BAD = {
    "three angles": [1, 2, 3],
    "five columns": np.zeros((7, 5)),
    "NaN": (0.0, nan, 0.0, 0.0),
    "NaN in a batch": [[0, 0, 0, 0], [0, 0, 0, nan]],
    "infinity": (0, 0, 0, float("inf")),
    "a string": "1234",
    "strings": ("1", "2", "3", "4"),
    "None": None,
    "Nones": [None] * 4,
    "complex": (1j, 0, 0, 0),
    "truth values": [True] * 4,
    "empty": [],
    "empty batch": np.empty((0, 4)),
    "ragged": [[1, 2, 3, 4], [1]],
    "one number": 1.0,
    "columns": [[1], [2], [3], [4]],
    "an array of columns": np.zeros((4, 1)),
    "a number too large": (10**400, 0, 0, 0),
}


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("mistake", BAD)
@pytest.mark.parametrize("function", [omx.pose, omx.fk, omx.frames, omx.jacobian])
def test_bad_angles_are_refused_by_name_with_both_shapes(function, mistake):
    with pytest.raises(omx.BadInput, match=r"`q` must be the four joint angles in rad, shape \(4,\) or \(\.\.\., 4\)"):
        function(BAD[mistake])


def test_finite_numbers_whose_sum_is_not_are_still_numbers():
    assert all(np.isfinite(omx.pose((1e305, 1e305, -1e305, -1e305))))


#: What the arguments of the public functions are called; book/notation.md says it in words.
OTHER_NAMES = {"near", "q0", "q1", "target", "arm", "goal_q", "poses", "end_pose", "robot"}


def test_one_thing_has_one_name_in_every_signature():
    rooms = (omx, omx.motion, omx.analysis, omx.analysis.workspace, omx.analysis.accuracy, omx.collision)
    functions = {f"{room.__name__}.{name}": value for room in rooms for name, value in vars(room).items()}
    functions = {name: f for name, f in functions.items() if inspect.isfunction(f) and not f.__name__.startswith("_")}
    assert len(functions) > 40
    wrong = {name: OTHER_NAMES & inspect.signature(f).parameters.keys() for name, f in functions.items()}
    del wrong["omx.ik_batch"]  # its name is older, and says that it takes a table
    assert not {name: found for name, found in wrong.items() if found}


@pytest.mark.parametrize("function", [omx.ik, omx.solve_ik, omx.motion.line, omx.pose, omx.analysis.workspace.section])
def test_a_signature_can_be_read(function, monkeypatch):
    monkeypatch.delattr(function, "__signature__", raising=False)  # Sphinx leaves its own on what it documents
    text = str(inspect.signature(function))
    assert "= omx.COURSE" in text
    assert len(text) < 340
    assert "3.14" not in text
