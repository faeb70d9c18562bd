"""Collision: distances between capsules, and where the capsules of the arm are."""

import numpy as np
import pytest

import omx
from omx.collision import Capsule, capsules, distance

RNG = np.random.default_rng(11)


def random_capsule():
    return Capsule("any", tuple(RNG.uniform(-100, 100, 3)), tuple(RNG.uniform(-100, 100, 3)), 1.0)


def test_the_distance_of_two_segments_is_the_smallest_over_all_their_points():
    grid = np.linspace(0, 1, 201)
    for _ in range(50):
        one, other = random_capsule(), random_capsule()
        first = np.array(one.a) + np.outer(grid, np.subtract(one.b, one.a))
        second = np.array(other.a) + np.outer(grid, np.subtract(other.b, other.a))
        sampled = np.linalg.norm(first[:, None] - second[None], axis=2).min()
        exact = distance(one, other)
        assert exact <= sampled + 1e-9
        assert exact == pytest.approx(sampled, abs=1.5)


@pytest.mark.parametrize(
    "other",
    [((0, 0, 5), (10, 0, 5)), ((20, 0, 0), (30, 0, 0)), ((5, 3, 0), (5, 3, 0)), ((0, 4, 0), (0, 9, 0))],
    ids=["parallel", "in line", "a point", "across an end"],
)
def test_the_distance_of_degenerate_segments(other):
    expected = {(0, 0, 5): 5.0, (20, 0, 0): 10.0, (5, 3, 0): 3.0, (0, 4, 0): 4.0}[other[0]]
    one = Capsule("x", (0.0, 0.0, 0.0), (10.0, 0.0, 0.0), 1.0)
    two = Capsule("y", tuple(map(float, other[0])), tuple(map(float, other[1])), 1.0)
    assert distance(one, two) == pytest.approx(expected)
    assert distance(two, one) == pytest.approx(expected)


def test_the_capsules_follow_the_dog_leg():
    upper_arm, elbow, forearm = capsules(omx.ZERO)[1:4]
    np.testing.assert_allclose(upper_arm.b, (0, 0, 77 + 130 * np.cos(omx.COURSE.delta)), atol=1e-9)
    np.testing.assert_allclose(elbow.b, (24, 0, 77 + 130 * np.cos(omx.COURSE.delta)), atol=1e-9)
    np.testing.assert_allclose(forearm.b, (148, 0, elbow.b[2]), atol=1e-9)
