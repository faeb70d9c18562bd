"""The arm drawn from primitives: the maker's sizes where the lengths are the course's, and any lengths at all."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

import omx
from omx.display.viewer import arm_model as arm
from omx.display.viewer.arm_model import arm_drawings, ghost_drawings

GEOMETRIES = [
    omx.COURSE,
    omx.MAKER,
    omx.COURSE.replace(L2=200.0, L3=60.0),
    omx.COURSE.replace(L2=45.0),
    omx.COURSE.replace(delta=0.9),
    omx.COURSE.replace(L1=150.0, L4=90.0),
]


def bounds(solid):
    """The box around the solid, mm: two corners (3,)."""
    points = np.vstack([points for points, *_ in solid._parts])
    return points.min(axis=0), points.max(axis=0)


def in_base(geometry, q=omx.ZERO):
    """Each link's bounding box in the base frame at `q`, mm."""
    frames = geometry.chain.frames(q)
    return [bounds(solid.moved(T)) for solid, T in zip(arm.links(geometry), frames, strict=True)]


def test_the_servo_is_an_xm430():
    low, high = bounds(arm.servo())
    size = high - low
    assert size[0] == pytest.approx(46.5)
    assert size[1] == pytest.approx(28.5)
    assert 34 < size[2] < 41, "34 deep, and a horn on both sides"
    assert high[0] == pytest.approx(11.25), "the horn's axis is 11.25 from one end"


def test_the_base_plate_is_the_makers():
    low, high = bounds(arm.plate())
    np.testing.assert_allclose((high - low)[:2], (350, 300))
    assert low[2] == -8


def test_links_fill_the_makers_bounding_boxes():
    """At the zero pose each link of the course's arm spans what the maker's meshes span, to about a screw's head."""
    _base, turret, upper, forearm, wrist = in_base(omx.COURSE)
    assert turret[1][2] == pytest.approx(77 + 11.25, abs=4), "servo 2 ends above the shoulder"
    assert upper[1][0] == pytest.approx(24 + 11.25, abs=8), "the dog-leg carries servo 3 forward"
    assert upper[1][2] == pytest.approx(77 + 128 + 14.25, abs=3)
    assert forearm[1][0] == pytest.approx(24 + 124 + 11.25, abs=3)
    assert wrist[1][1] - wrist[0][1] == pytest.approx(128, abs=2), "the front plate is 128 wide"


def test_the_fingers_end_beyond_the_tool_and_leave_42_mm():
    left, right = (bounds(finger) for finger in arm.fingers(omx.COURSE))
    for low, high in (left, right):
        assert low[0] < 0 < high[0] == pytest.approx(21.7)
    # In the tool's frame z points to the left.
    assert left[0][2] == pytest.approx(19, abs=2.5)
    assert right[1][2] == pytest.approx(-left[0][2])


@pytest.mark.parametrize("geometry", GEOMETRIES, ids=lambda g: ", ".join(f"{v:g}" for v in g.values))
@pytest.mark.parametrize("q", [omx.ZERO, omx.HOME, (0.7, 0.4, -0.3, 0.2)])
def test_each_link_reaches_from_joint_to_joint(geometry, q):
    """Both joints of a moving link lie inside its drawing (its box, in the link's own frame, holds them)."""
    frames = geometry.chain.frames(q)
    solids = arm.links(geometry)
    for i in (2, 3):
        to_link = np.linalg.inv(frames[i])
        low, high = bounds(solids[i])
        for joint in (frames[i - 1][:3, 3], frames[i][:3, 3]):
            here = to_link[:3, :3] @ joint + to_link[:3, 3]
            assert (here >= low - 1e-6).all()
            assert (here <= high + 1e-6).all()


def test_links_join_at_the_joints_axes():
    """Neighbours overlap about their common joint: no gap at any pose, since both are symmetric about its axis."""
    for i, (one, two) in enumerate(zip(in_base(omx.COURSE), in_base(omx.COURSE)[1:], strict=False)):
        gap = np.maximum(one[0], two[0]) - np.minimum(one[1], two[1])
        assert (gap < 1.5).all(), f"links {i} and {i + 1} are {gap.max():.1f} mm apart"


def test_an_arm_with_other_lengths_by_name_is_drawn_as_a_chain():
    other = SimpleNamespace(chain=omx.Chain([omx.DHRow(0, 10, 20, 0)]), length=3.0)
    assert len(arm_drawings(other.chain, other)) == 2
    assert len(ghost_drawings(other.chain, other, (1, 2, 3))) == 2


def test_delta_leans_the_elbow_forward():
    assert in_base(omx.COURSE.replace(delta=math.radians(20)))[2][1][0] > in_base(omx.COURSE)[2][1][0]
