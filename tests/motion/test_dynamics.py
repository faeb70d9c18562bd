"""The torques of a motion, against pinocchio's recursive Newton-Euler and the gravity that a chapter derives."""

import numpy as np
import pytest

import omx
from omx.arm import FOREARM, UPPER_ARM, WRIST
from omx.errors import BadInput
from omx.hardware import gravity
from omx.motion import motor_torques


def pinocchio_torques(motions, payload_kg):
    """Torques (N, 4) of a model of turning joints and point masses, typed in from the maker's drawing (m, kg)."""
    pin = pytest.importorskip("pinocchio")
    model, parent = pin.Model(), 0
    places = np.array([(0, 0, 0), (0, 0, 76.5), (24, 0, 128), (124, 0, 0)]) / 1000
    axes = (pin.JointModelRZ, pin.JointModelRY, pin.JointModelRY, pin.JointModelRY)
    for name, (place, axis) in enumerate(zip(places, axes, strict=True)):
        parent = model.addJoint(parent, axis(), pin.SE3(np.eye(3), place), f"joint {name}")
        if name:
            mass, (x, z) = (UPPER_ARM, FOREARM, WRIST)[name - 1]
            point = pin.Inertia(mass, np.array([x, 0, z]) / 1000, np.zeros((3, 3)))
            model.appendBodyToJoint(parent, point, pin.SE3.Identity())
    load = pin.Inertia(payload_kg, np.array([0.126, 0, 0]), np.zeros((3, 3)))
    model.appendBodyToJoint(parent, load, pin.SE3.Identity())
    data = model.createData()
    return np.array([pin.rnea(model, data, *motion) for motion in motions])


def test_torques_are_those_of_the_newton_euler_recursion():
    motions = np.random.default_rng(3).uniform(-3, 3, (500, 3, 4))
    ours = motor_torques(*motions.swapaxes(0, 1), payload_g=250)
    np.testing.assert_allclose(ours, pinocchio_torques(motions, 0.25), atol=1e-12)


def test_at_rest_they_undo_the_weight():
    q = np.random.default_rng(4).uniform(*np.array(omx.LIMITS).T, (100, 4))
    weight = [gravity.torques(*row[1:], 0.2) for row in q]
    np.testing.assert_allclose(motor_torques(q, payload_g=200)[:, 1:], -np.array(weight), atol=1e-12)
    assert np.abs(motor_torques(q)[:, 0]).max() == 0


@pytest.mark.parametrize("grams", [-1, float("nan"), "200"])
def test_a_payload_has_a_mass(grams):
    with pytest.raises(BadInput, match="payload_g"):
        motor_torques(omx.HOME, payload_g=grams)
