"""Roll, pitch, yaw: there and back, also where two of them become one."""

import numpy as np
import pytest
import sympy as sp

import omx
from omx.errors import BadInput
from omx.rotation import from_rpy, from_vector, to_rpy, to_vector

RNG = np.random.default_rng(2)


def test_the_convention_is_rz_ry_rx():
    a, b, c = sp.symbols("a b c")
    product = sp.rot_ccw_axis3(c) * sp.rot_ccw_axis2(b) * sp.rot_ccw_axis1(a)
    for roll, pitch, yaw in RNG.uniform(-3, 3, (10, 3)):
        expected = np.array(product.subs({a: roll, b: pitch, c: yaw})).astype(float)
        np.testing.assert_allclose(from_rpy(roll, pitch, yaw), expected, atol=1e-12)


def test_every_rotation_is_recovered():
    angles = RNG.uniform(-np.pi, np.pi, (500, 3))
    angles[::5, 1] = np.pi / 2  # gimbal lock, exactly and nearly
    angles[1::5, 1] = -np.pi / 2 + 10.0 ** RNG.uniform(-16, -1, 100)
    for row in angles:
        R = from_rpy(*row)
        np.testing.assert_allclose(from_rpy(*to_rpy(R)), R, atol=2e-13)


def test_at_gimbal_lock_roll_is_0():
    assert to_rpy(from_rpy(0.4, np.pi / 2, 0.1)).roll == 0.0


def test_a_transform_of_the_arm_is_taken_as_it_is():
    T = omx.fk((0.3, 0.1, 0.2, 0.4))
    np.testing.assert_allclose(from_rpy(*to_rpy(T)), T[:3, :3], atol=1e-12)


@pytest.mark.parametrize("R", [np.eye(2), np.zeros((3, 3)), np.diag([1.0, 1.0, -1.0]), 2 * np.eye(3)])
def test_what_is_no_rotation_is_refused(R):
    with pytest.raises(BadInput, match="`R`"):
        to_rpy(R)


@pytest.mark.parametrize("angle", [0.0, 1e-13, 1e-9, 1e-3, 1.0, 3.0, np.pi - 1e-7, np.pi - 1e-10, np.pi])
def test_a_vector_is_a_turn_and_comes_back(angle):
    for axis in [*np.eye(3), *-np.eye(3), *RNG.normal(size=(20, 3))]:
        axis = axis / np.linalg.norm(axis)
        R = from_vector(angle * axis)
        np.testing.assert_allclose(R.T @ R, np.eye(3), atol=1e-12)
        np.testing.assert_allclose(R @ axis, axis, atol=1e-12)
        np.testing.assert_allclose(np.trace(R), 1 + 2 * np.cos(angle), atol=1e-12)
        found = to_vector(R)
        np.testing.assert_allclose(from_vector(found), R, atol=2e-7)
        if angle < 3.1:
            np.testing.assert_allclose(found, angle * axis, atol=1e-12)


def test_a_vector_turns_about_an_axis_as_angles_do():
    for angle in RNG.uniform(-3, 3, 10):
        np.testing.assert_allclose(from_vector([0, 0, angle]), from_rpy(0, 0, angle), atol=1e-14)
        np.testing.assert_allclose(from_vector([0, angle, 0]), from_rpy(0, angle, 0), atol=1e-14)
        np.testing.assert_allclose(from_vector([angle, 0, 0]), from_rpy(angle, 0, 0), atol=1e-14)


@pytest.mark.parametrize("wrong", [np.eye(4), np.ones(3), [np.eye(3)] * 2, None])
def test_a_vector_wants_one_matrix(wrong):
    with pytest.raises(BadInput):
        to_vector(wrong)
