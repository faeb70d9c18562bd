"""Gravity on the joints, against the derivative of the links' potential energy."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import omx
from omx.generated import gravity as generated
from omx.hardware import gravity

angles = st.tuples(*[st.floats(-3, 3)] * 3)


def height_of(frame, along, across):
    """Height (mm) of a point `along` and `across` the x and y axes of a DH frame."""
    return (frame @ [along, across, 0.0, 1.0])[2]


def energy(q2, q3, q4):
    """Potential energy (J) of upper arm, forearm and wrist, from the DH frames of `omx`."""
    frames = omx.frames((0.0, q2, q3, q4), geometry=omx.MAKER)
    # In the DH frames of joints 2, 3, 4 the origin is the far end of the link and x points along it.
    delta, length = omx.MAKER.delta, omx.MAKER.L2
    x, z = gravity.UPPER_ARM[1]
    along, across = x * np.sin(delta) + z * np.cos(delta) - length, x * np.cos(delta) - z * np.sin(delta)
    heights = (
        height_of(frames[2], along, across),
        height_of(frames[3], gravity.FOREARM[1][0] - omx.MAKER.L3, 0.0),
        height_of(frames[4], gravity.WRIST[1][0] - omx.MAKER.L4, 0.0),
    )
    masses = (gravity.UPPER_ARM[0], gravity.FOREARM[0], gravity.WRIST[0])
    return sum(9.81 * m * h / 1000 for m, h in zip(masses, heights, strict=True))


@settings(deadline=None)
@given(angles)
def test_torque_is_minus_the_gradient_of_the_energy(q):
    step = 1e-6
    for i, torque in enumerate(gravity.torques(*q)):
        up, down = list(q), list(q)
        up[i] += step
        down[i] -= step
        assert torque == pytest.approx(-(energy(*up) - energy(*down)) / (2 * step), abs=1e-7)


def test_columns_and_single_configurations_have_the_same_torques():
    q = np.random.default_rng(5).uniform(-3, 3, (50, 3))
    columns = np.array(generated.torques_batch(*q.T, 0.2, *gravity.ARM)).T / 1000
    np.testing.assert_allclose(columns, [gravity.torques(*row, 0.2) for row in q.tolist()], atol=1e-12)


def test_a_stretched_arm_pulls_down_with_about_half_a_newton_metre():
    shoulder, elbow, wrist = gravity.torques(0.0, 0.0, 0.0)
    assert 0.4 < shoulder < 0.6
    assert shoulder > elbow > wrist > 0


@settings(deadline=None)
@given(angles)
def test_lowest_is_the_lowest_frame(q):
    frames = omx.frames((0.0, *q), geometry=omx.MAKER)
    assert gravity.lowest(*q) == pytest.approx(min(frame[2, 3] for frame in frames[2:]), abs=1e-9)
