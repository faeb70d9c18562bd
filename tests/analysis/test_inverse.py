"""All answers with their verdicts: reach, limits, and what is free where axes fall on one line."""

from math import pi

import numpy as np
import pytest

import omx
from omx import BadInput, Chain, DHRow
from omx.analysis import Inverse
from omx.derive import write_inverse
from tests.helpers import processes
from tests.helpers.six_joint_arms import ARMS, H, configurations, gaps

#: The limits of the web page on the Stanford arm; one of its units is 100 mm here.
LIMITS = [(-pi, pi), (-H, H), (100, 300), (-pi, pi), np.radians([-25, 25]), (-pi, pi)]
#: The three configurations that it simulates, with the slide at 6.
SIMULATED = np.radians([(-90, 90, 0, 45, 25, 90), (180, 0, 0, 45, 25, 0), (90, -45, 0, 45, -25, 45)])
SIMULATED[:, 2] = 600.0


@pytest.fixture(scope="module")
def modules(tmp_path_factory):
    folder = tmp_path_factory.mktemp("modules")
    return {name: write_inverse(name.replace(" ", "_"), arm, folder=folder) for name, arm in ARMS.items()}


def limited(name, limits=None):
    return Chain(ARMS[name].rows, limits, name=name)


def test_the_three_simulated_poses_are_found_again_and_refused_for_their_slide(modules):
    arm = limited("Stanford", LIMITS)
    inverse, long_boom = Inverse(arm, modules["Stanford"]), limited("Stanford", [*LIMITS[:2], (100, 600), *LIMITS[3:]])
    for q in SIMULATED:
        solutions = inverse(arm.fk(q))
        assert [s.branch for s in solutions] == list(inverse.branches)
        assert all(s.reachable and not s.legal for s in solutions)
        same = [s for s in solutions if gaps(arm, np.array([[s.q]]), q[None, None])[0] < 1e-6]
        assert len(same) == (2 if q[1] == 0 else 1)  # an upright boom: front and back are one
        released = dict(zip(inverse.branches, Inverse(long_boom, modules["Stanford"])(arm.fk(q)), strict=True))
        for s in same:
            assert [str(v) for v in s.violations] == ["d3 = 600.00 mm is 300.00 mm above its limit 300.00 mm"]
            assert released[s.branch].legal
        for s in solutions:
            broken = {v.joint for v in s.violations}
            assert broken == {
                name for name, v, (low, high) in zip(arm.names, s.q, LIMITS, strict=True)
                if not low - 1e-9 <= v <= high + 1e-9
            }  # fmt: skip


@pytest.mark.parametrize("name", ARMS)
def test_many_targets_get_the_verdicts_of_each(name, modules):
    limits = [(100, 300) if row.prismatic else (-2.0, 2.5) for row in ARMS[name].rows]
    arm = limited(name, limits)
    inverse = Inverse(arm, modules[name])
    T = arm.fk(configurations(arm, 30, seed=1))
    T[10:, :3, 3] *= 1.5
    many = inverse.batch(T)
    assert many.q.shape == (30, 8, 6)
    for i, target in enumerate(T):
        for j, solution in enumerate(inverse(target)):
            assert solution.legal == many.legal[i, j]
            assert solution.reachable == (not np.isnan(many.q[i, j, 0]))
            assert solution.missing == pytest.approx(many.missing[i, j], abs=1e-9)
            if solution.reachable:
                np.testing.assert_allclose(solution.q, many.q[i, j], atol=1e-7)
    assert many.legal.any()
    np.testing.assert_array_equal(inverse.batch(T.reshape(5, 6, 4, 4)).legal, many.legal.reshape(5, 6, 8))


def test_a_straight_wrist_leaves_a_line_of_answers_and_every_one_is_an_answer(modules):
    for name, bend, sign, fixed in (("textbook", 0.0, "+", -0.4), ("Stanford", pi, "-", 1.4)):
        arm = ARMS[name]
        q = np.array([0.3, 0.7, 0.9 if name == "textbook" else 220.0, 0.5, bend, -0.9])
        T = arm.fk(q)
        found = Inverse(arm, modules[name])(T)
        assert len(found) == 8
        families = [s for s in found if s.families]
        for s in families:
            (family,) = s.families
            assert family.free == "q4"
            for shift in (-2.0, 0.1, 1.0):
                moved = np.array(s.q) + shift * np.array(family.along)
                np.testing.assert_allclose(arm.fk(moved), T, atol=1e-9)
            assert f"only q4 {sign} q6 = " in family.text or "only q4" in family.text
            assert s.families[0].text in repr(s)
        line = [s for s in families if np.allclose(s.q[:3], q[:3], atol=1e-6)]
        assert line
        for s in line:
            (family,) = s.families
            shift = (q[3] - s.q[3]) * np.array(family.along)
            assert gaps(arm, (np.array(s.q) + shift)[None, None], q[None, None])[0] < 1e-6
            total = q[3] + q[5] if sign == "+" else q[3] - q[5]
            assert np.isclose(np.cos(total), np.cos(fixed))
            assert f"only q4 {sign} q6 = " in family.text


def test_other_families_are_told_by_the_joint_that_is_free(modules):
    stanford, puma, ur = ARMS["Stanford"], ARMS["PUMA 560"], ARMS["UR5"]
    q = np.array([0.3, 0.7, 0.0, 0.5, 0.8, -0.9])  # the boom drawn in until the wrist is on axis 2
    for s in Inverse(stanford, modules["Stanford"])(stanford.fk(q)):
        assert "q2 is free, and others follow" in [family.text for family in s.families]
    q = np.array([0.3, 0.7, -0.4, 0.5, 0.0, -0.9])
    told = [s.families[0].text for s in Inverse(ur, modules["UR5"])(ur.fk(q)) if s.families]
    assert told
    assert set(told) == {"q6 is free, and others follow"}
    for s in Inverse(puma, modules["PUMA 560"])(puma.fk(q + 0.3)):
        assert s.families == ()


def test_a_wrist_over_the_shoulder_leaves_joint_1_free(tmp_path):
    rows = [(0, 300, 0, H), (0, 0, 500, 0), (0, 0, 400, -H), (0, 0, 0, H), (0, 0, 0, -H), (0, 100, 0, 0)]
    rows[2], rows[3] = (0, 0, 0, H), (0, 400, 0, -H)
    arm = Chain([DHRow(*row) for row in rows])
    inverse = Inverse(arm, write_inverse("centred", arm, folder=tmp_path))
    T = np.eye(4)
    T[:3, 3] = 0, 0, 1000
    found = [s for s in inverse(T) if s.reachable]
    assert found
    for s in found:
        assert s.families[0].text == "q1 is free, and others follow"
        np.testing.assert_allclose(arm.fk(s.q), T, atol=1e-9)


def test_fewer_joints_and_what_is_out_of_reach(tmp_path):
    ours = omx.COURSE.chain
    inverse = Inverse(ours, write_inverse("ours", ours, folder=tmp_path))
    target = [24, -18, 340, np.radians(60)]
    for mine, theirs in zip(inverse(target), omx.ik(target), strict=True):
        np.testing.assert_allclose(mine.q, theirs.q, atol=1e-12)
        assert mine.legal == theirs.legal
    far = inverse([600, 0, 204, 0])
    assert repr(far[0]) == "Solution(front, elbow up: out of reach by 236.719 mm)"
    assert not any(s.reachable for s in far)
    assert inverse([0, 0, 340, 0.5])[0].families[0].text == "q1 is free"


@pytest.mark.parametrize(
    ("target", "told"),
    [
        (np.eye(4)[:3], r"shape \(4, 4\)"),
        (2 * np.eye(4), "this matrix is no pose"),
        (np.diag([1, 1, -1, 1]), "this matrix is no pose"),
        (np.diag([1, 1, 1, 2]), "this matrix is no pose"),
        ([1, 2, 3], r"shape \(4,\)"),
        (np.full((4, 4), np.nan), "all finite"),
        (np.stack([np.eye(4)] * 2), "for many use `batch`"),
        (None, "T_base_tool"),
    ],
)
def test_what_is_no_target_is_refused(target, told, modules):
    with pytest.raises(BadInput, match=told):
        Inverse(ARMS["textbook"], modules["textbook"])(target)


def test_a_module_of_another_arm_is_refused(modules):
    with pytest.raises(BadInput, match="was written for another arm than UR5"):
        Inverse(ARMS["UR5"], modules["textbook"])
    with pytest.raises(BadInput, match="must be one that"):
        Inverse(ARMS["UR5"], omx)
    with pytest.raises(BadInput, match="`chain` must be"):
        Inverse(None, omx)
    assert repr(Inverse(ARMS["UR5"], modules["UR5"])) == "Inverse('UR5', 8 branches)"


def test_a_solution_keeps_its_verdicts_in_another_process(modules):
    arm = Chain(ARMS["textbook"].rows, limits=[(-1, 1)] * 6, name="textbook")
    solutions = Inverse(arm, modules["textbook"])(arm.fk([0.3, 0.7, 0.9, 0.5, 0.0, -0.9]))
    for s, other in zip(solutions, processes.there_and_back(solutions), strict=True):
        assert (repr(other), other.violations, other.families) == (repr(s), s.violations, s.families)
        assert other == s
