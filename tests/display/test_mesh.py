"""Solids are closed, face outwards and have the volume that their primitives should have."""

import math

import numpy as np
import pytest

from omx.display.viewer.mesh import Solid, ball, circle, cone, slot, tube

GREY = (90, 90, 90)


def mesh(solid):
    points, unit, normals, colours, index = solid.arrays()
    return points * (unit * 1e3), normals / 127, colours, index.reshape(-1, 3)


def volume(solid):
    points, _, _, faces = mesh(solid)
    a, b, c = (points[faces[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def open_edges(solid):
    """Edges, by position, that are not shared by two triangles that run along them in opposite directions."""
    points, _, _, faces = mesh(solid)
    keys = np.unique(np.round(points, 2), axis=0, return_inverse=True)[1].ravel()[faces]
    edges = np.vstack((keys[:, [0, 1]], keys[:, [1, 2]], keys[:, [2, 0]]))
    edges = edges[edges[:, 0] != edges[:, 1]]
    ones, back = np.unique(edges, axis=0, return_counts=True), np.unique(edges[:, ::-1], axis=0, return_counts=True)
    return not (np.array_equal(ones[0], back[0]) and np.array_equal(ones[1], back[1]))


PRIMITIVES = {
    "box": (Solid().box((-10, 0, 5), (20, 40, 25), GREY, bevel=0.01), 30 * 40 * 20),
    "disc": (Solid().disc((5, 5), 10, -3, 7, GREY, sides=96, bevel=0.01), math.pi * 100 * 10),
    "disc across": (Solid().disc((5, 5), 10, -3, 7, GREY, "y", sides=96, bevel=0.01), math.pi * 100 * 10),
    "slot": (
        Solid().prism(slot((0, 0), (30, 0), 8, 40), 0, 5, GREY, "x", bevel=0.01),
        5 * (30 * 16 + math.pi * 64),
    ),
    "cone": (cone((0, 0, 0), (0, 0, 30), 10, GREY, 96), math.pi * 100 * 10),
    "rod": (cone((1, 2, 3), (1, 2, 33), 10, GREY, 96, 10), math.pi * 100 * 30),
    "ball": (ball((3, 0, 0), 10, GREY, 48), 4 / 3 * math.pi * 1000),
    "ring": (
        tube(np.column_stack((circle(50, 200), np.zeros(200))), 3, GREY, 48, closed=True),
        2 * math.pi**2 * 50 * 9,
    ),
}


@pytest.mark.parametrize("name", PRIMITIVES)
def test_primitive_is_closed_and_has_its_volume(name):
    solid, expected = PRIMITIVES[name]
    assert not open_edges(solid)
    assert volume(solid) == pytest.approx(expected, rel=0.01)


@pytest.mark.parametrize("name", [*PRIMITIVES, "stud"])
def test_normals_point_outwards(name):
    """Each vertex normal lies on the outer side of the triangles that use it."""
    solid = PRIMITIVES[name][0] if name in PRIMITIVES else Solid().stud((0, 0), 3, 0, 1, GREY, "x", -1)
    points, normals, _, faces = mesh(solid)
    a, b, c = (points[faces[:, k]] for k in range(3))
    across = np.cross(b - a, c - a)
    area = np.linalg.norm(across, axis=1)
    lean = np.einsum("ij,ikj->ik", across, normals[faces])[area > 1e-2]
    assert (lean > -1e-3).all()
    assert (lean.sum(axis=1) > 0).all()


def test_moving_keeps_shape_and_turns_normals():
    turn = np.array([[0, -1, 0, 5], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1.0]])
    moved = PRIMITIVES["box"][0].moved(turn)
    assert volume(moved) == pytest.approx(24000, rel=0.01)
    points = mesh(moved)[0]
    np.testing.assert_allclose((points.min(axis=0), points.max(axis=0)), [(-35, -10, 5), (5, 20, 25)], atol=1e-3)


def test_a_silhouette_has_one_colour_and_no_screws():
    solid = Solid().box((0, 0, 0), (9, 9, 9), GREY).stud((4, 4), 2, 9, 10, (1, 2, 3))
    shape = solid.silhouette((200, 10, 10))
    points, _, colours, _ = mesh(shape)
    assert points[:, 2].max() == pytest.approx(9, abs=1e-3)
    assert {tuple(c) for c in colours.tolist()} == {(200, 10, 10)}
    assert mesh(solid)[0][:, 2].max() == pytest.approx(10, abs=1e-3)


def test_positions_are_kept_to_a_hundredth_of_a_millimetre():
    solid = ball((0, 0, 0), 150, GREY)
    points, _, _, _ = mesh(solid)
    np.testing.assert_allclose(np.linalg.norm(points, axis=1), 150, atol=0.01)
