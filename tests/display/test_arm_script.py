"""The arm in JavaScript is Python's: branches, verdicts, the choice among them, gaps, and joint angles from frames."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

import omx
from omx import Chain, HandPanel, JointPanel, View, collision
from omx.analysis import Inverse
from omx.analysis.inverse import families
from omx.arm import HOME, LIMITS, ZERO
from omx.derive import write_chain, write_inverse
from omx.display.viewer.arm_data import arm_data, chain_data
from omx.display.viewer.assets import as_expression
from omx.rotation import from_rpy, from_vector, to_rpy
from tests.helpers.javascript import flat, in_node
from tests.helpers.six_joint_arms import ARMS, configurations

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


def arm(about):
    return f"const A = window.OMX_ARM, about = {json.dumps(about)};"


def asked(expression, arguments, geometry=omx.COURSE):
    return in_node(expression, arguments, arm(arm_data(geometry)))


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
    about = JointPanel(View.of_chain(chain)).view._config()["arm"]
    qs = RNG.uniform(-2, 2, (20, 3)).tolist()
    told = in_node("[A.frames(a, about), A.joints(A.frames(a, about), about)]", qs, arm(about))
    for (frames, joints), q in zip(told, qs, strict=True):
        np.testing.assert_allclose(frames, chain.frames(q), atol=1e-9)
        assert joints == pytest.approx(q, abs=1e-12)


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
    found = asked("A.joints(A.frames(a, about), about)", LEGAL)
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


# ---- six joints, by a chapter's own module ---------------------------------------------------------------------

BEND = [(-3.0, 3.0), (-1.6, 1.6), (100.0, 300.0), (-3.0, 3.0), (-0.5, 0.5), (-3.0, 3.0)]


@pytest.fixture(scope="module", params=["Stanford", "UR5"])
def inverse(request, tmp_path_factory):
    rows, folder = ARMS[request.param].rows, tmp_path_factory.mktemp("written")
    limits = BEND if request.param == "Stanford" else [(-3.0, 3.0)] * 6
    module = write_inverse(f"js_{request.param}", Chain(rows), folder=folder)
    return Inverse(Chain(rows, limits, name=request.param), module)


def test_a_hands_branches_verdicts_and_choice_are_pythons(inverse):
    """Legal hands, hands anywhere, and hands out of reach; which branch is taken, and which comes closest."""
    low, high = np.array(inverse.chain.limits).T
    legal = low + (high - low) * RNG.random((25, 6))
    far = inverse.chain.fk(configurations(inverse.chain, 10, 7))
    far[:, :3, 3] *= 3
    targets = np.concatenate([inverse.chain.fk(legal), inverse.chain.fk(configurations(inverse.chain, 25, 5)), far])
    about, near = chain_data(inverse.chain, inverse.chain.limits, inverse), 0.5 * (low + high)
    script = f"{arm(about)} const near = {near.tolist()}, chosen = (found, a) => A.nearest(found, a, near, about);"
    script += "const all = (found, a) => [found, chosen(found, a), A.closest(found)];"
    told = in_node("all(A.branches(a, about), a)", targets.tolist(), script)
    panel = HandPanel(inverse, near)
    for T, (ours, taken, closest) in zip(targets, told, strict=True):
        for js, py in zip(ours, inverse(T), strict=True):
            assert (js["name"], js["reachable"], js["legal"]) == (py.branch, py.reachable, py.legal)
            assert js["missing"] == pytest.approx(py.missing, abs=1e-9) or py.reachable
            assert [v["name"] for v in js["broken"]] == [v.joint for v in py.violations]
            assert [v["excess"] for v in js["broken"]] == pytest.approx([v.excess for v in py.violations], abs=1e-9)
            if py.reachable:
                apart = np.subtract(js["q"], py.q)
                assert np.abs(np.where(inverse._slides, apart, np.exp(1j * apart) - 1)).max() < 1e-9
        panel._q = tuple(near)
        panel.target = T
        if taken:
            assert panel.q == pytest.approx(taken["q"], abs=1e-9)
            assert panel.message == ""
        else:
            assert f"Nearest is {closest['name']}: " in panel.message


def test_roll_pitch_and_yaw_are_pythons():
    angles = RNG.uniform((-180, -90, -180), (180, 90, 180), (30, 3)).tolist()
    angles += [[20, 90, 10], [0, -90, 170], [180, 0, 0]]
    about = {"rows": [{}] * 6, "inverse": "{}"}
    hands = in_node("A.task(about).asked([10, 20, 30, ...a])", angles, arm(about))
    for T, rpy in zip(hands, angles, strict=True):
        np.testing.assert_allclose(np.array(T)[:3, :3], from_rpy(*np.radians(rpy)), atol=1e-12)
        assert np.array(T)[:, 3].tolist() == [10, 20, 30, 1]
    for values, T in zip(in_node("A.task(about).values(a)", hands, arm(about)), hands, strict=True):
        assert values == pytest.approx([10, 20, 30, *np.degrees(to_rpy(np.array(T)))], abs=1e-9)


def test_a_ring_turns_the_hand_about_its_axis():
    script = arm({"rows": [{}] * 6, "inverse": "{}"}) + "const task = A.task(about), rings = task.rings();"
    told = in_node("[rings[a].u, rings[a].v, task.turned(A.IDENTITY, rings[a], 0.3)]", [0, 1, 2], script)
    for (u, v, turned), axis in zip(told, np.eye(3), strict=True):
        assert np.cross(u, v).tolist() == axis.tolist()
        np.testing.assert_allclose(np.array(turned)[:3, :3], from_vector(0.3 * axis), atol=1e-12)


def test_what_is_free_is_told_as_python_tells_it(inverse):
    straight = configurations(inverse.chain, 8, 3) * [1, 1, 1, 1, 0, 1]
    drawn_in = configurations(inverse.chain, 4, 4) * [1, 1, 0, 1, 1, 1]
    qs = [*straight, *drawn_in, *configurations(inverse.chain, 8, 6)]
    told = in_node("A.families(a, about)", np.array(qs).tolist(), arm(chain_data(inverse.chain, None, inverse)))
    assert any(told)
    for q, ours in zip(qs, told, strict=True):
        words = [w.replace("\u2212", "-").replace("\u00b0", " deg") for w in ours]
        assert words == [family.text for family in families(inverse.chain, q)]


# ---- a link that is pulled -------------------------------------------------------------------------------------

PULLED = {
    "ours": (arm_data(omx.COURSE), omx.COURSE.chain, LIMITS),
    "Stanford": (None, ARMS["Stanford"], BEND),
    "planar": (None, Chain([(0, 0, 200, 0), (0, 0, 150, 0), (0, 0, 80, 0)]), [(-1.0, 1.0)] * 3),
    "SCARA": (None, Chain([(0, 300, 250, 0), (0, 0, 200, math.pi), (0, 0, 0, 0, True)]), [(-2, 2), (-2, 2), (0, 150)]),
}


@pytest.mark.parametrize("name", PULLED)
def test_a_pulled_link_follows_within_limits_and_says_what_holds_it(name):
    """Goals that the link can have are met; no joint leaves its limits; what is said of one that cannot is true."""
    about, chain, limits = PULLED[name]
    about = about or chain_data(chain, limits)
    low, high = np.array(limits).T
    cases = []
    for k in range(60):
        q, other = (low + (high - low) * RNG.random(len(chain)) for _ in range(2))
        link, point = 1 + k % len(chain), RNG.uniform(-30, 30, 3)
        goal = (chain.frames(q + 0.1 * (other - q))[link] @ [*point, 1])[:3]
        cases.append([q.tolist(), link, point.tolist(), (goal + (k % 3 == 2) * RNG.uniform(-400, 400, 3)).tolist()])
    verdicts = set()
    for (q, link, point, goal), ours in zip(cases, in_node("A.pull(...a, about)", cases, arm(about)), strict=True):
        now = np.array(ours["q"])
        assert (now >= low).all()
        assert (now <= high).all()
        assert now[link:].tolist() == q[link:], "the joints beyond the link stand still"
        gap = np.linalg.norm((chain.frames(now)[link] @ [*point, 1])[:3] - goal)
        assert ours["gap"] == pytest.approx(gap, abs=1e-6)
        assert gap <= np.linalg.norm((chain.frames(q)[link] @ [*point, 1])[:3] - goal) + 1e-6
        assert bool(ours["verdict"]) == (gap >= 0.5)
        verdicts.add(ours["verdict"].split(" is ")[-1].split(" mm ")[0] if ours["verdict"] else "")
    met = [not ours for ours in verdicts]
    assert any(met)
    assert not all(met)


def test_a_pull_against_a_limit_names_the_joint_and_by_how_much():
    about, chain, _ = arm_data(omx.COURSE), *PULLED["ours"][1:]
    beyond = np.array(HOME)
    beyond[0] = math.pi + 0.2
    q, point = [math.pi - 0.1, *HOME[1:]], [0, 0, 0]
    goal = chain.fk(beyond)[:3, 3]
    (told,) = in_node("A.pull(...a, about)", [[q, 4, point, goal.tolist()]], arm(about))
    assert told["q"][0] == pytest.approx(LIMITS[0][1])
    assert told["verdict"].startswith("q1 = ")
    excess = float(told["verdict"].split(" is ")[1].split("\u00b0")[0])
    assert excess == pytest.approx(math.degrees(math.pi + 0.2 - LIMITS[0][1]), abs=1)


def test_an_arm_with_other_lengths_is_pythons():
    """A page with other lengths knows its table, and warns of what touches, before any Python has seen them."""
    low, high = (20, 60, 60, 80, -0.3), (120, 200, 200, 250, 0.5)
    names = ("L1", "L2", "L3", "L4", "delta")
    some = [dict(zip(names, RNG.uniform(low, high), strict=True)) | {"delta": omx.COURSE.delta} for _ in range(20)]
    arms = [omx.COURSE, *(omx.COURSE.replace(**lengths) for lengths in some)]
    for arm, ours in zip(arms, asked("A.resized(about, a)", [list(arm.values) for arm in arms]), strict=True):
        theirs = arm_data(arm)
        assert ours["geometry"] == theirs["geometry"]
        for row, other in zip(ours["rows"], theirs["rows"], strict=True):
            assert row == pytest.approx(other, abs=1e-12)
        for part, other in zip(ours["parts"], theirs["parts"], strict=True):
            assert {**part, "a": 0, "b": 0} == {**other, "a": 0, "b": 0}
            assert flat([part["a"], part["b"]]) == pytest.approx(flat([other["a"], other["b"]]), abs=1e-8)


def test_formulas_that_are_learnt_take_the_place_of_those_that_were_there(tmp_path):
    rows = omx.COURSE.chain.rows
    module = write_chain("fk", omx.Chain([*rows[:3], replace(rows[3], a=200)]), folder=tmp_path)
    text = as_expression((tmp_path / "fk.js").read_text(encoding="utf-8"))
    learnt = "(window.OMX_ARM.learn(a), window.OMX_KINEMATICS.fk.transform(0.1, 0.2, 0.3, 0.4))"
    (matrix,) = in_node(learnt, [{"fk": text}])
    assert flat(matrix) == pytest.approx(flat(module.transform(0.1, 0.2, 0.3, 0.4)), abs=1e-9)
