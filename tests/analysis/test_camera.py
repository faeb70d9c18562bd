"""The pinhole camera, the pose of a mark from its corners, and the camera's own place from pictures of the hand."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import omx
from omx.analysis.camera import (
    PARTS,
    HandEye,
    Pinhole,
    hand_eye,
    homography,
    motions,
    planar_pose,
)
from omx.errors import BadInput, NotIdentifiable
from omx.rotation import from_vector, to_vector

FLAT = np.array([[-20, 20], [-20, -20], [20, -20], [20, 20]], dtype=float)
CAMERA = Pinhole.looking((180, -40, 650), (150, 0, 0))
#: A tag glued on top of the hand, a little askew: its z axis points away from the hand, -y of the tool.
TAG = np.eye(4)
TAG[:3, :3] = from_vector([0.03, -0.02, 0.04]) @ np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])
TAG[:3, 3] = -40, -30, 2


def corners(T):
    return (T @ np.column_stack((FLAT, np.zeros(4), np.ones(4))).T)[:3].T


def hands(count, pitches=(-1.0, 0.3), seed=1):
    draw = np.random.default_rng(seed)
    found = []
    while len(found) < count:
        pose = draw.uniform((120, -120, 60, pitches[0]), (240, 120, 180, pitches[1]))
        solution = omx.ik(pose)[0]
        if solution.reachable:
            found.append(omx.fk(solution.q))
    return np.array(found)


def pictures(hands, camera=CAMERA, tag=TAG):
    return np.array([camera.project(corners(T @ tag)) for T in hands])


@given(st.floats(-150, 150), st.floats(-150, 150), st.floats(0, 200))
def test_a_ray_comes_back_to_the_point_that_it_shows(x, y, z):
    assert np.allclose(CAMERA.on_plane(CAMERA.project([x, y, z]), z), [x, y, z], atol=1e-9)


def test_where_it_looks_is_the_middle_and_up_is_up():
    assert np.allclose(CAMERA.project([150, 0, 0]), [640, 480])
    assert CAMERA.project([170, 0, 0])[1] < 480  # forwards is up in the picture
    assert CAMERA.project([150, -20, 0])[0] > 640  # and the arm's right is right
    assert CAMERA.sees([[150, 0, 0], [150, 900, 0], [150, 0, 700]]).tolist() == [True, False, False]
    # twice as far is half as large: similar triangles
    near, far = (CAMERA.focal * 40 / depth for depth in (300, 600))
    straight = Pinhole.looking((0, 0, 600), (0, 0, 0))
    for height, size in ((300, near), (0, far)):
        pixels = straight.project([[0, 20, height], [0, -20, height]])
        assert np.linalg.norm(pixels[1] - pixels[0]) == pytest.approx(size)


@pytest.mark.parametrize(
    ("ask", "said"),
    [
        (lambda: CAMERA.project([150, 0, 700]), "behind the camera"),
        (lambda: CAMERA.on_plane([640, 480], 700), "does not meet the plane at 700 mm"),
        (lambda: Pinhole.looking((0, 0, 1), (0, 0, 1)), "two points"),
        (lambda: Pinhole.looking((0, 0, 1), (0, 0, 0), up=(0, 0, 1)), "direction of sight"),
        (lambda: homography(FLAT[:3], FLAT[:3]), "four pairs or more"),
        (lambda: homography([[0, 0], [1, 1], [2, 2], [0, 5]], FLAT), "on one line"),
        (lambda: hand_eye(hands(3), FLAT, np.zeros((2, 4, 2)), CAMERA), r"got \(2, 4, 2\) and \(3, 4, 4\)"),
    ],
)
def test_what_cannot_be_is_refused(ask, said):
    with pytest.raises(BadInput, match=said):
        ask()


@settings(max_examples=60, deadline=None)
@given(st.floats(-1.2, 1.2), st.floats(-1.2, 1.2), st.floats(-3, 3), st.floats(150, 900))
def test_four_corners_without_noise_give_the_pose_exactly(a, b, c, depth):
    T = np.eye(4)
    T[:3, :3] = from_vector([0, 0, c]) @ from_vector([a, 0, 0]) @ from_vector([0, b, 0]) @ np.diag([1, -1, -1])
    T[:3, 3] = 0.1 * depth, -0.2 * depth, depth
    seen = (T @ np.column_stack((FLAT, np.zeros(4), np.ones(4))).T)[:3]
    pixels = (CAMERA.K @ seen)[:2].T / seen[2][:, None]
    H = homography(FLAT, pixels)
    columns = CAMERA.K @ T[:3, [0, 1, 3]]
    assert np.allclose(H, columns / columns[2, 2], rtol=1e-6, atol=1e-6)
    assert np.allclose(planar_pose(FLAT, pixels, CAMERA.K), T, atol=1e-5)


def test_noise_costs_depth_much_more_than_place():
    """A pixel sideways is Z / f at the tag; its size tells the depth, so a pixel there is Z^2 / (f s) for side s."""
    draw, T = np.random.default_rng(2), np.diag([1.0, -1, -1, 1])
    T[:3, 3] = 0, 0, 600
    exact = CAMERA.focal * corners(T)[:, :2] / corners(T)[:, 2:] + [640, 480]
    found = np.array([planar_pose(FLAT, exact + draw.normal(0, 0.3, (4, 2)), CAMERA.K)[:3, 3] for _ in range(300)])
    sideways, depth = found[:, :2].std(), found[:, 2].std()
    assert sideways == pytest.approx(600 / 900 * 0.3 / math.sqrt(4), rel=0.2)
    # the depth is fitted to eight numbers, each pulled outwards by half a side (20 mm)
    assert depth == pytest.approx(600**2 / 900 / 20 * 0.3 / math.sqrt(8), rel=0.2)


def test_hand_eye_finds_camera_and_tag_and_says_how_well():
    T = hands(12)
    exact = hand_eye(T, FLAT, pictures(T), CAMERA)
    assert np.allclose(exact.camera.T_base_camera, CAMERA.T_base_camera, atol=1e-7)
    assert np.allclose(exact.T_tool_tag, TAG, atol=1e-7)
    draw, found = np.random.default_rng(3), []
    for _ in range(25):
        seen = pictures(T) + draw.normal(0, 0.3, (12, 4, 2))
        found.append(hand_eye(T, FLAT, seen, Pinhole(np.eye(4))))
    assert isinstance(found[0], HandEye)
    assert tuple(found[0].sigma) == PARTS
    where = np.array([one.camera.T_base_camera[:3, 3] for one in found])
    for i, axis in enumerate("xyz"):
        stated = np.mean([one.sigma[f"{axis} of the camera"] for one in found])
        assert abs(where[:, i].mean() - CAMERA.T_base_camera[i, 3]) < stated
        assert where[:, i].std() == pytest.approx(stated, rel=0.5)
    left = np.mean([one.pixels for one in found])
    assert left == pytest.approx(0.3 * math.sqrt(1 - 12 / 96), rel=0.1)


def test_a_hand_of_one_pitch_cannot_tell_the_heights_of_camera_and_tag():
    level = hands(12, pitches=(0.0, 0.0))
    with pytest.raises(NotIdentifiable, match="the height of the camera, the height of the tag"):
        hand_eye(level, FLAT, pictures(level), CAMERA)
    higher, tag = CAMERA.T_base_camera.copy(), TAG.copy()
    higher[2, 3] += 7
    tag[:3, 3] += 7 * np.array([0, -1, 0])  # up, in the frame of a level tool
    same = pictures(level, Pinhole(higher), tag)
    assert np.allclose(same, pictures(level), atol=1e-9)
    tilted = hands(12)
    assert np.abs(pictures(tilted, Pinhole(higher), tag) - pictures(tilted)).max() > 1
    assert np.linalg.matrix_rank((motions(level)[:, :3, :3] - np.eye(3)).reshape(-1, 3), tol=1e-9) == 2
    assert np.linalg.matrix_rank((motions(tilted)[:, :3, :3] - np.eye(3)).reshape(-1, 3), tol=1e-9) == 3


def test_a_turned_base_is_a_turned_camera():
    """An offset of joint 1 goes into the camera: relative to the readings, everything is found as well as before."""
    T = hands(12)
    base = np.eye(4)
    base[:3, :3] = from_vector([0, 0, 0.02])
    found = hand_eye(T, FLAT, pictures(base @ T), CAMERA)
    assert found.pixels < 1e-9
    assert np.allclose(base @ found.camera.T_base_camera, CAMERA.T_base_camera, atol=1e-7)


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-3, 1.0, math.pi - 1e-7, math.pi])
def test_a_turn_and_its_vector_are_two_names_of_one_thing(angle):
    for axis in ([1, 0, 0], [0, 0.6, -0.8], [-0.36, 0.48, 0.8]):
        R = from_vector(angle * np.array(axis))
        assert np.allclose(R.T @ R, np.eye(3), atol=1e-12)
        assert np.allclose(from_vector(to_vector(R)), R, atol=1e-6)
        assert np.linalg.norm(to_vector(R)) == pytest.approx(angle, abs=1e-6)
