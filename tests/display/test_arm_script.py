"""The arm in JavaScript is Python's: branches, verdicts, the choice among them, gaps, and joint angles from frames."""

import json
import math

import numpy as np
import pytest

import omx
from omx import JointPanel, View, collision
from omx.arm import HOME, LIMITS, ZERO
from omx.display.viewer.arm_data import arm_data
from tests.helpers.javascript import flat, in_node

RNG = np.random.default_rng(12)
LOW, HIGH = np.array(LIMITS).T
LEGAL = (LOW + (HIGH - LOW) * RNG.random((60, 4))).tolist()
#: Legal poses, poses anywhere, the boundary of reach, both sides of the half turn, the axis of joint 1.
POSES = [
    *[list(omx.pose(q)) for q in LEGAL],
    *(RNG.uniform((-400, -400, -150, -3), (400, 400, 450, 3), (120, 4)).tolist()),
    *([380, 0, 77, 0], [379.9, 0, 77, 0], [-200, 0, 100, 0], [-200, -1e-9, 100, 0], [-200, -0.0, 100, 0]),
    *([0, 0, 330, 1.2], [0, 0, 300, 0.5], [274, 0, 204.8, 7.0]),
]


def asked(expression, arguments, geometry=omx.COURSE):
    about = f"const A = window.OMX_ARM, about = {json.dumps(arm_data(geometry))};"
    return in_node(expression, arguments, about)


@pytest.mark.parametrize("geometry", [omx.COURSE, omx.MAKER], ids=["course", "maker"])
def test_the_four_branches_have_pythons_angles_and_verdicts(geometry):
    for pose, ours in zip(POSES, asked("A.branches(a, about)", POSES, geometry), strict=True):
        for js, py in zip(ours, omx.ik(pose, geometry), strict=True):
            assert (js["name"], js["reachable"], js["legal"]) == (py.branch, py.reachable, py.legal), pose
            assert [f"q{v['joint'] + 1}" for v in js["broken"]] == [v.joint for v in py.violations]
            assert [v["excess"] for v in js["broken"]] == pytest.approx([v.excess for v in py.violations], abs=1e-9)
            if py.reachable:
                assert js["q"] == pytest.approx(py.q, abs=1e-9), pose
            else:
                assert js["missing"] == pytest.approx(py.missing, abs=1e-9)


@pytest.mark.parametrize("near", [HOME, (2.0, 0.3, -0.2, 0.5), (-3.0, -0.5, 0.8, -0.4)])
def test_the_arm_takes_the_branch_that_python_takes(near):
    found = asked(f"A.nearest(A.branches(a, about), a, {list(near)}, about) ?? null", POSES)
    for pose, ours in zip(POSES, found, strict=True):
        try:
            chosen = omx.solve_ik(pose, near)
        except omx.OmxError:
            assert ours is None, pose
        else:
            assert ours["q"] == pytest.approx(chosen.q, abs=1e-9), pose


def test_the_frames_of_any_chain_are_pythons():
    chain = omx.Chain([(0.1, 20, 5, 0.3), (0, 7, 30, -1.2), (0, 4, 0, 0.5, True)], base=omx.fk(HOME), tool=omx.fk(ZERO))
    data = JointPanel(View.of_chain(chain))._static_data()
    qs = RNG.uniform(-2, 2, (20, 3)).tolist()
    for ours, q in zip(
        in_node("A.chainFrames(data, a)", qs, f"const A = window.OMX_ARM, data = {json.dumps(data)};"), qs, strict=True
    ):
        np.testing.assert_allclose(ours, chain.frames(q), atol=1e-9)


def test_gaps_to_the_table_and_to_itself_are_pythons():
    anywhere = [*RNG.uniform(-math.pi, math.pi, (150, 4)).tolist(), list(HOME), list(ZERO)]
    pairs, gaps = collision.gaps(np.array(anywhere))
    for ours, column in zip(asked("A.gaps(a, about)", anywhere), gaps.T, strict=True):
        assert [tuple(names) for *names, _ in ours] == pairs
        assert [gap for *_, gap in ours] == pytest.approx(column, abs=1e-7)
    words = asked("A.touching(a, about)", anywhere)
    assert [bool(sentence) for sentence in words] == [not ok for ok in collision.clear(np.array(anywhere))]


def test_the_worst_contact_is_told_in_words():
    below, folded, clear = asked("A.touching(a, about)", [[0, 0.68, 0.7, 0], [0, -1.5, 1.4, 1.9], list(HOME)])
    assert below.endswith("mm below the table")
    assert "overlap" in folded or "below the table" in folded
    assert clear == ""


def test_joint_angles_come_back_from_the_frames():
    found = asked("A.joints(fk.frames(...a, ...about.geometry), about.geometry)", LEGAL)
    for q, ours in zip(LEGAL, found, strict=True):
        assert ours == pytest.approx(q, abs=1e-12)


def test_the_velocity_ellipse_is_that_of_the_jacobian():
    stretched = [0.4, 0.9, omx.COURSE.delta - math.pi / 2, -0.3]
    qs = [*LEGAL, stretched]
    for q, found in zip(qs, asked("A.ellipse(a, about.geometry, 0.15)", qs), strict=True):
        J = omx.jacobian(q)[:3]
        held = 0.15 * (J[:, 1:3] - J[:, 3:])
        axes = np.column_stack([found["long"], found["short"]])
        assert found["centre"] == pytest.approx(omx.pose(q)[:3], abs=1e-9)
        np.testing.assert_allclose(axes @ axes.T, held @ held.T, atol=1e-8)  # the same ellipse
        assert axes[:, 0] @ axes[:, 1] == pytest.approx(0, abs=1e-8)
        np.testing.assert_allclose(np.linalg.norm(axes, axis=0), np.linalg.svd(held, compute_uv=False), atol=1e-6)


def test_a_matrix_survives_the_way_to_the_viewer():
    q = LEGAL[0]
    (ours,) = asked("A.rows(A.columns(fk.transform(...a, ...about.geometry)))", [q])
    assert flat(ours) == pytest.approx(omx.fk(q).ravel(), abs=1e-12)
    (pose,) = asked("A.poseOf(A.target(a))", [[120.0, -80.0, 200.0, -2.5]])
    assert pose == pytest.approx([120.0, -80.0, 200.0, -2.5])
