"""The inverse: four branches, each with a verdict, and never a number that forward kinematics denies."""

from itertools import product
from math import degrees, dist, hypot, inf, nan, nextafter, pi, radians

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import omx
from omx import COURSE, HOME, LIMITS
from omx.analysis import compiled
from omx.kinematics import ON_AXIS, IKSolution
from tests.helpers import oracles, processes

GEOMETRIES = [COURSE, omx.MAKER, COURSE.replace("long forearm", L3=150.0), COURSE.replace("no dog-leg", delta=0.0)]
EXACT = 1e-11  # mm and rad; the contract is 1e-9 mm


def assert_every_answer_true(poses, geometry=COURSE):
    """What is called reachable is reached; the rest is NaN; the verdict on limits is that of the angles."""
    poses = np.asarray(poses, dtype=float)
    q, reachable, legal = omx.ik_batch(poses, geometry)
    assert (np.isfinite(q).all(-1) == reachable).all()
    assert (np.isnan(q).all(-1) == ~reachable).all()
    reached = omx.pose(q[reachable], geometry)
    wanted = np.broadcast_to(poses[:, None], q.shape)[reachable]
    turns = 4 * np.spacing(np.abs(wanted[:, 3]))  # a pitch of many turns is known no better
    assert (oracles.pose_gap(reached, wanted) < EXACT + turns).all()
    assert ((q[reachable] > -pi) & (q[reachable] <= pi)).all()
    low, high = np.array(LIMITS).T
    with np.errstate(invalid="ignore"):
        inside = ((q >= low - 1e-9) & (q <= high + 1e-9)).all(-1)
    assert (legal == inside).all()
    return q, reachable, legal


# ---- random configurations -----------------------------------------------------------------------------


@pytest.mark.parametrize("geometry", GEOMETRIES, ids=lambda g: g.name)
def test_fk_of_ik_is_the_pose_and_the_original_is_among_the_branches(geometry):
    q = np.concatenate([oracles.random_q(50_000), oracles.any_q(50_000, 1)])
    found, reachable, _ = assert_every_answer_true(omx.pose(q, geometry), geometry)
    gaps = np.where(reachable, oracles.angle_gap(found, q[:, None]).max(-1), inf)
    assert gaps.min(axis=1).max() < 1e-8
    assert reachable.any(axis=1).all()


def test_near_every_degenerate_place_the_answers_are_true_and_complete():
    q = np.concatenate([oracles.degenerate_q(seed) for seed in range(20)])
    _, reachable, _ = assert_every_answer_true(omx.pose(q))
    assert reachable.any(axis=1).all()  # each of these poses was made by an arm


def test_one_pose_is_a_row_of_the_batch():
    poses = np.concatenate([omx.pose(oracles.degenerate_q()), omx.pose(oracles.any_q(300)), far_and_near()])
    for pose, q, reachable, legal in zip(poses, *omx.ik_batch(poses), strict=True):
        solutions = omx.ik(pose)
        assert [s.reachable for s in solutions] == list(reachable)
        assert [s.legal for s in solutions] == list(legal)
        for solution, row in zip(solutions, q, strict=True):
            if solution.reachable:
                assert oracles.pose_gap(omx.pose(solution.q), omx.pose(row)) < EXACT
                assert all(type(angle) is float and -pi < angle <= pi for angle in solution.q)


def far_and_near(count=200, seed=3):
    rng = np.random.default_rng(seed)
    return np.column_stack([rng.uniform(-500, 500, (count, 3)), rng.uniform(-pi, pi, count)])


# ---- the four branches ---------------------------------------------------------------------------------


def test_the_order_is_front_up_front_down_back_up_back_down():
    sides = [(s.front, s.elbow_up) for s in omx.ik((200, 0, 150, 0))]
    assert sides == [(True, True), (True, False), (False, True), (False, False)]


def test_front_means_facing_the_target_and_up_means_that_the_forearm_bends_down():
    """Seen with the base facing right, the elbow of `up` is left of the way from shoulder to wrist: above that line
    where the wrist is in front of the shoulder, and below it where it is behind."""
    for q in oracles.random_q(200, 4):
        pose = omx.pose(q)
        for solution in omx.ik(pose):
            if not solution.reachable:
                continue
            facing = np.cos(solution.q[0] - np.arctan2(pose.y, pose.x))
            assert facing == pytest.approx(1 if solution.front else -1, abs=1e-9)
            shoulder, elbow, wrist = omx.frames(solution)[1:4, :3, 3]
            ahead = (np.cos(solution.q[0]), np.sin(solution.q[0]), 0)
            side = np.cross(wrist - shoulder, elbow - shoulder) @ np.cross(ahead, (0, 0, 1))
            assert (side > 0) == solution.elbow_up or abs(side) < 1e-6
            bend = np.angle(np.exp(1j * (solution.q[2] + pi / 2 - COURSE.delta)))
            assert (bend > 0) == solution.elbow_up or abs(bend) < 1e-6


def on_the_card(pose, front, sign):
    """The inverse as the summary of chapter 5 prints it, on one card."""
    (x, y, z, p), (L1, L2, L3, L4, delta) = pose, COURSE.values
    q1, r = (np.arctan2(y, x), hypot(x, y)) if front else (np.arctan2(y, x) + pi, -hypot(x, y))
    r_w, z_w = r - L4 * np.cos(p), z - L1 - L4 * np.sin(p)
    D = (r_w**2 + z_w**2 - L2**2 - L3**2) / (2 * L2 * L3)
    s = sign * max(0, (1 - D) * (1 + D)) ** 0.5
    q3 = np.arctan2(s, D) + delta - pi / 2
    q2 = pi / 2 - delta - np.arctan2(z_w, r_w) - np.arctan2(L3 * s, L2 + L3 * D)
    return q1, q2, q3, -p - q2 - q3


def test_the_card_of_chapter_5_is_the_inverse():
    for pose in omx.pose(oracles.random_q(200, 5)):
        for solution in filter(lambda branch: branch.reachable, omx.ik(pose)):
            card = on_the_card(pose, solution.front, 1 if solution.elbow_up else -1)
            assert oracles.angle_gap(np.array(card), solution.q).max() < 1e-7


def test_behind_the_shoulder_elbow_up_is_the_lower_elbow():
    """The four-branch figure of chapter 5: both wrists are behind the shoulder."""
    heights = [omx.frames(s)[2, 2, 3] for s in omx.ik((24, -18, 340, pi / 3))]
    assert [round(h) for h in heights] == [138, 180, 111, 204]


def test_elbows_mirror_and_keep_the_pitch():
    up, down, *_ = omx.ik((200, 50, 150, -0.4))
    straight = COURSE.delta - pi / 2
    assert oracles.angle_gap(up.q[2] - straight, straight - down.q[2]) < 1e-12
    assert oracles.angle_gap(sum(up.q[1:]), sum(down.q[1:])) < 1e-12


def test_share_of_configurations_in_which_each_branch_is_legal():
    """Of random legal configurations; every angle is wrapped into one turn before it meets its limits."""
    _, _, legal = omx.ik_batch(omx.pose(oracles.random_q(100_000)))
    assert legal.mean(axis=0) == pytest.approx([0.862, 0.044, 0.324, 0.034], abs=0.005)


def test_elbow_down_is_legal_only_when_the_arm_is_almost_straight():
    q, _, legal = omx.ik_batch(omx.pose(oracles.random_q(50_000)))
    bend = np.degrees(oracles.angle_gap(q[:, [1, 3], 2], COURSE.delta - pi / 2))[legal[:, [1, 3]]]
    assert bend.max() == pytest.approx(6.58, abs=0.02)


def test_an_ik_solution_says_what_it_is():
    front, *_, back = omx.ik((200, 0, 150, 0))
    assert (front.branch, back.branch) == ("front, elbow up", "back, elbow down")
    assert front.legal
    assert "legal" in repr(front)
    assert (len(front), list(front), front[2]) == (4, list(front.q), front.q[2])
    assert not back.reachable
    assert f"out of reach by {back.missing:.3f} mm" in repr(back)
    with pytest.raises(omx.BadInput, match="back, elbow down"):
        list(back)


def test_a_solution_knows_what_was_asked():
    """All of it can be said of every one that can be made: none out of reach without knowing how far."""
    with pytest.raises(TypeError, match=r"limits.*asked"):
        IKSolution(None, True, True)
    (turned,) = (s for s in [omx.solve_ik((0, 0, 350, radians(60)), start=(1.0, 0, 0, 0))] if s.q[0] == 1.0)
    assert turned._asked


# ---- reach ---------------------------------------------------------------------------------------------


def at_wrist_distance(distance, directions, pitches):
    """Poses in front whose wrist is `distance` from the shoulder, in each direction of the arm's plane."""
    r = distance * np.cos(directions) + COURSE.L4 * np.cos(pitches)
    z = COURSE.L1 + distance * np.sin(directions) + COURSE.L4 * np.sin(pitches)
    return np.column_stack([r, np.zeros_like(r), z, pitches])[r > 1]


@pytest.mark.parametrize("sign", [1, -1], ids=["outer", "inner"])
@pytest.mark.parametrize("near", oracles.NEAR)
def test_on_the_boundary_of_reach_nothing_is_wrong(sign, near):
    rng = np.random.default_rng(5)
    edge = COURSE.L2 + COURSE.L3 if sign == 1 else COURSE.L2 - COURSE.L3
    excess = near * edge  # mm out of reach
    poses = at_wrist_distance(edge + sign * excess, rng.uniform(-pi, pi, 400), rng.uniform(-pi, pi, 400))
    _, reachable, _ = assert_every_answer_true(poses)
    if abs(excess) > 3e-10:  # the verdict is sharp; nearer than this it may be either, and true all the same
        assert (reachable[:, 0] == (excess < 0)).all()
    for pose, front in zip(poses, reachable[:, 0], strict=True):
        solution = omx.ik(pose)[0]
        assert solution.reachable == front
        assert solution.missing == (0 if front else pytest.approx(excess, abs=1e-12))


def test_a_target_far_outside_is_refused_with_the_distance_missing():
    """The lesson of the clamped cosine: (600, 0, 204, 0) has no answer, not the angles of (371, 0, 143)."""
    wrist = hypot(600 - COURSE.L4, 204 - COURSE.L1)
    for solution in omx.ik((600, 0, 204, 0)):
        assert (solution.reachable, solution.q, solution.legal, solution.violations) == (False, None, False, ())
    assert omx.ik((600, 0, 204, 0))[0].missing == pytest.approx(wrist - COURSE.L2 - COURSE.L3, abs=1e-12)
    with pytest.raises(omx.Unreachable, match=r"236\.719 mm are missing") as caught:
        omx.solve_ik((600, 0, 204, 0))
    assert caught.value.missing == pytest.approx(236.719, abs=5e-4)
    assert caught.value.nearest == pytest.approx((371.35, 0, 142.74, 0), abs=0.01)


def test_a_wrist_too_close_to_the_shoulder_is_refused_too():
    """With the hand upright over the shoulder the wrist is in its middle, 130 - 124 mm too near."""
    assert omx.ik((COURSE.L4, 0, COURSE.L1, 0))[0].missing == pytest.approx(6)
    error = refused((0, 0, COURSE.L1 + COURSE.L4, pi / 2))
    assert error.missing == pytest.approx(6)
    assert dist(error.nearest[:3], error.pose[:3]) == pytest.approx(6)


def refused(pose, geometry=COURSE):
    with pytest.raises(omx.Unreachable) as caught:
        omx.solve_ik(pose, geometry=geometry)
    return caught.value


def unreachable_poses():
    return [pose for pose in far_and_near(300, 6) if not any(s.reachable for s in omx.ik(pose))]


def test_the_nearest_pose_is_reachable_at_exactly_the_distance_missing():
    for pose in unreachable_poses():
        error = refused(pose)
        assert error.pose == tuple(pose)
        assert any(s.reachable for s in omx.ik(error.nearest))
        assert dist(error.nearest[:3], pose[:3]) == pytest.approx(error.missing, abs=1e-9)
        assert error.nearest.pitch == pytest.approx(pose[3], abs=1e-12)


def test_nothing_reachable_with_this_pitch_is_nearer():
    q = oracles.any_q(20_000, 7)
    for pose in unreachable_poses()[:40]:
        q[:, 3] = -pose[3] - q[:, 1] - q[:, 2]
        tried = omx.pose(q)
        assert oracles.angle_gap(tried[:, 3], pose[3]).max() < 1e-9
        assert np.linalg.norm(tried[:, :3] - pose[:3], axis=1).min() >= refused(pose).missing - 1e-9


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("far", [1e9, 1e150, 1e200, 1e305])
def test_however_far_the_answer_is_no(far):
    for pose in ((far, 0, 0, 0), (0, -far, 0, 1), (0, 0, far, 0), (far, far, -far, 2)):
        assert not any(s.reachable for s in omx.ik(pose))
        q, reachable, _ = omx.ik_batch([pose])
        assert not reachable.any()
        assert np.isnan(q).all()
        error = refused(pose)
        assert error.missing > 1e8
        assert np.isfinite(error.nearest).all()


# ---- places where a formula could stumble --------------------------------------------------------------


def test_the_straight_arm_which_an_arc_cosine_misses():
    q = oracles.any_q(2000, 8)
    q[:, 2] = COURSE.delta - pi / 2
    poses = omx.pose(q)
    _, reachable, _ = assert_every_answer_true(poses)
    assert reachable.any(axis=1).all()


@pytest.mark.parametrize("turns", [1, -1, 1000, 10**6])
def test_a_pitch_of_many_turns_is_the_same_pitch(turns):
    pose = omx.pose(HOME)._replace(pitch=0.3)
    far = pose._replace(pitch=0.3 + turns * 2 * pi)
    for near, same in zip(omx.ik(pose), omx.ik(far), strict=True):
        assert near.reachable == same.reachable
        if near.reachable:
            np.testing.assert_allclose(same.q, near.q, atol=1e-8)
    assert_every_answer_true([far])


def test_a_pitch_beyond_all_precision_still_gets_consistent_answers():
    for pitch in (1e15, -1e16, 1e300):
        q, reachable, _ = omx.ik_batch([(200, 0, 150, pitch)])
        assert omx.pose(q[reachable])[:, :3] == pytest.approx(np.broadcast_to((200, 0, 150), (reachable.sum(), 3)))
        assert [s.reachable for s in omx.ik((200, 0, 150, pitch))] == list(reachable[0])


@pytest.mark.parametrize("x", [-200.0, -1e-5])
@pytest.mark.parametrize("y", [0.0, -0.0, 5e-324, -5e-324, -1e-300])
def test_behind_the_base_q1_is_plus_pi(x, y):
    front, *_, back = omx.ik((x, y, 250, 0.5))
    for solution, q1 in ((front, pi), (back, 0.0)):
        assert solution.q is None or solution.q[0] == pytest.approx(q1, abs=1e-12)
    q, reachable, _ = omx.ik_batch([(x, y, 250, 0.5)])
    assert (q[reachable] > -pi).all()


@pytest.mark.parametrize("x", [0.0, -0.0])
@pytest.mark.parametrize("y", [0.0, -0.0])
def test_on_the_axis_q1_is_free_and_zero(x, y):
    solutions = omx.ik((x, y, 300, 1.0))
    assert [s.q[0] for s in solutions if s.front] == [0, 0]
    assert [s.q[0] for s in solutions if not s.front] == [pi, pi]
    assert_every_answer_true([(x, y, 300, 1.0)])


@pytest.mark.parametrize("q1", [0.0, 1.0, -2.5, pi, -pi, 4.0, 100.0])
def test_on_the_axis_solve_ik_takes_q1_from_near(q1):
    pose = (0, 0, 350, radians(60))
    solution = omx.solve_ik(pose, start=(q1, 0, 0, 0))
    assert oracles.angle_gap(solution.q[0], q1) < 1e-12
    assert oracles.pose_gap(omx.pose(solution), pose) < EXACT
    assert solution.legal


def test_on_the_axis_q1_keeps_to_its_limits():
    limits = ((-1.0, 1.0), *LIMITS[1:])
    assert omx.solve_ik((0, 0, 350, radians(60)), start=(2.0, 0, 0, 0), limits=limits).q[0] == 1.0


def test_just_off_the_axis_q1_points_at_the_target():
    solution = omx.solve_ik((1e-6, 1e-6, 350, radians(60)), start=(1.0, 0, 0, 0))
    assert oracles.angle_gap(solution.q[0], pi / 4) < 1e-9


# ---- limits --------------------------------------------------------------------------------------------


def test_a_configuration_exactly_at_its_limits_is_legal():
    ends = np.array(LIMITS)
    for corner in np.ndindex(2, 2, 2, 2):
        q = ends[range(4), corner]
        legal = [s for s in omx.ik(omx.pose(q)) if s.legal]
        assert any(oracles.angle_gap(s.q, q).max() < 1e-9 for s in legal)


def test_the_verdicts_agree_with_one_another_at_the_edge_of_a_limit_and_in_another_process():
    """They are worked out when they are read: `legal` without a loop, and wherever the solution has gone."""
    narrow = [(low + 0.1, high - 0.1) for low, high in LIMITS]
    asked = [*omx.pose(oracles.any_q(300)).tolist(), *omx.pose(oracles.random_q(100)).tolist(), [600, 0, 204, 0]]
    answers = [omx.ik(pose, limits=narrow) for pose in asked]
    kinds = set()
    for pose, solutions, others in zip(asked, answers, processes.there_and_back(answers), strict=True):
        for s, other in zip(solutions, others, strict=True):
            assert s.legal == (s.reachable and not s.violations)
            assert s.reachable == (s.q is not None) == (s.missing == 0)
            assert (repr(other), other.missing, other.violations) == (repr(s), s.missing, s.violations)
            kinds.add((s.reachable, s.legal))
            if s.reachable:
                for j, beyond in product(range(4), (0.5e-9, 2e-9)):
                    edge = [(a - 1, a + 1) for a in s.q]
                    edge[j] = (s.q[j] - 1, s.q[j] - beyond)
                    (again,) = (t for t in omx.ik(pose, limits=edge) if t.branch == s.branch)
                    assert again.legal == (not again.violations) == (beyond < 1e-9)
    assert kinds == {(True, True), (True, False), (False, False)}


def test_beyond_a_limit_the_verdict_names_joint_value_and_limit():
    for joint in (1, 2, 3):
        for end, limit in enumerate(LIMITS[joint]):
            q = np.array([0.1, 0.2, -0.1, 0.3])
            q[joint] = limit + (1e-6 if end else -1e-6)
            solution = min((s for s in omx.ik(omx.pose(q)) if s.reachable), key=lambda s: max(np.abs(s.q - q)))
            (violation,) = solution.violations
            assert (violation.joint, violation.limit) == (f"q{joint + 1}", limit)
            assert violation.value == pytest.approx(q[joint])
            assert violation.excess == pytest.approx(1e-6, rel=1e-3)
            assert not solution.legal


def test_other_limits_give_other_verdicts():
    pose = omx.pose((0.5, 0.2, -0.3, 0.4))
    assert omx.ik(pose)[0].legal
    narrow = [(-0.4, 0.4), (-0.1, 0.1), (-1, 1), (-1, 1)]
    assert [v.joint for v in omx.ik(pose, limits=narrow)[0].violations] == ["q1", "q2"]
    assert not omx.ik_batch([pose], limits=narrow)[2].any()
    assert all(s.legal for s in omx.ik(pose, limits=[(-inf, inf)] * 4) if s.reachable)


def test_solve_ik_reports_the_branch_that_comes_closest_to_legal():
    pose = omx.pose((0.0, -1.45, 1.6, 0.0))
    with pytest.raises(omx.JointLimit, match=r"no legal branch; nearest is front, elbow up: q3 = 91\.67 deg") as caught:
        omx.solve_ik(pose)
    (violation,) = caught.value.violations
    assert (violation.joint, violation.limit) == ("q3", 1.4)
    assert caught.value.nearest == pytest.approx((0.0, -1.45, 1.4, 0.0), abs=1e-9)
    worst = [max(v.excess for v in s.violations) for s in omx.ik(pose) if s.reachable]
    assert violation.excess == min(worst)


# ---- the nearest solution ------------------------------------------------------------------------------


def test_solve_ik_takes_the_legal_solution_nearest_to_the_start():
    for q, near in zip(oracles.random_q(200, 9), oracles.random_q(200, 10), strict=True):
        solution = omx.solve_ik(omx.pose(q), start=near)
        others = [s for s in omx.ik(omx.pose(q)) if s.legal]
        assert solution.q in [s.q for s in others]
        assert dist(solution, near) <= min(dist(s, near) for s in others) + 1e-12


def test_solve_ik_returns_to_where_the_arm_is():
    for q in oracles.random_q(300, 11):
        assert oracles.angle_gap(omx.solve_ik(omx.pose(q), start=q).q, q).max() < 1e-7


@settings(max_examples=200, deadline=None)
@given(*(st.floats(-450, 450) for _ in range(3)), st.floats(-10, 10))
def test_solve_ik_answers_truly_or_says_why_not(x, y, z, pitch):
    answer = attempt((x, y, z, pitch))
    if isinstance(answer, omx.Unreachable):
        assert answer.missing > 0
    elif isinstance(answer, omx.JointLimit):
        assert all(v.excess > 0 for v in answer.violations)
        assert not COURSE.chain.violations(answer.nearest)
    else:
        assert oracles.pose_gap(omx.pose(answer), (x, y, z, pitch)) < EXACT + 2 * ON_AXIS
        assert not COURSE.chain.violations(answer.q)


def attempt(pose):
    """The solution, or the reason why there is none."""
    try:
        return omx.solve_ik(pose)
    except (omx.Unreachable, omx.JointLimit) as reason:
        return reason


# ---- mistakes ------------------------------------------------------------------------------------------

BAD = {
    "three numbers": (200, 0, 150),
    "NaN": (200, nan, 150, 0),
    "infinity": (200, inf, 150, 0),
    "strings": ("200", "0", "150", "0"),
    "None": None,
    "complex": (200j, 0, 0, 0),
    "truth values": (True, False, True, False),
    "empty": [],
    "ragged": [[1, 2, 3, 4], [1]],
    "a number too large": (10**400, 0, 0, 0),
}


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("mistake", BAD)
@pytest.mark.parametrize(("function", "name"), [(omx.ik, "pose"), (omx.solve_ik, "pose"), (omx.ik_batch, "poses")])
def test_a_bad_pose_is_refused_by_name(function, name, mistake):
    with pytest.raises(omx.BadInput, match=f"`{name}` must be x, y, z in mm and pitch in rad, shape"):
        function(BAD[mistake])


def test_one_pose_is_not_a_matrix():
    with pytest.raises(omx.BadInput, match=r"shape \(4,\); got shape \(4, 4\)"):
        omx.solve_ik(np.eye(4))


def test_many_poses_give_arrays_in_the_shape_of_the_poses():
    poses = omx.pose(oracles.random_q(24, 5)).reshape(2, 3, 4, 4)
    found, table = omx.ik(poses), omx.ik_batch(poses.reshape(-1, 4))
    assert found.q.shape == (2, 3, 4, 4, 4)
    for part, flat in zip(found, table, strict=True):
        np.testing.assert_array_equal(part.reshape(flat.shape), flat)


@pytest.mark.parametrize("link", ["L2", "L3"])
@pytest.mark.parametrize("pose", [(200, 0, 150, 0), [(200, 0, 150, 0)]])
def test_an_arm_without_a_link_has_no_inverse_and_says_so(link, pose):
    with pytest.raises(omx.BadInput, match="has no inverse: a link of length 0"):
        omx.ik(pose, omx.COURSE.replace(**{link: 0}))


@pytest.mark.parametrize("function", [omx.ik, omx.solve_ik])
def test_an_arm_with_a_length_below_0_has_none_either(function):
    """It would answer in reach, but its missing distance would be that of another ring."""
    backwards = COURSE.replace(L2=-130.0)
    assert omx.pose(HOME, backwards)
    with pytest.raises(omx.BadInput, match="has no inverse here: L2 must not be below 0"):
        function((200, 0, 150, 0), geometry=backwards)
    for batch in (omx.ik_batch, compiled.ik_batch):
        with pytest.raises(omx.BadInput, match="L2 must not be below 0"):
            batch([(200, 0, 150, 0)], backwards)


def test_the_start_must_be_four_angles():
    with pytest.raises(omx.BadInput, match=r"`start` must be the four joint angles in rad, .* got shape \(2,\)"):
        omx.solve_ik((200, 0, 150, 0), start=(0, 0))


@pytest.mark.parametrize("poses", [(200, 0, 150, 0), np.zeros((2, 2, 4)), np.empty((0, 4))])
def test_a_batch_of_poses_has_two_axes_and_at_least_one_row(poses):
    with pytest.raises(omx.BadInput, match="`poses`"):
        omx.ik_batch(poses)


@pytest.mark.parametrize("limits", [None, 3, LIMITS[:3], [(1, -1)] * 4, [(0, nan)] * 4, "no", [(0, 1, 2)] * 4])
@pytest.mark.parametrize("function", [omx.ik, omx.solve_ik, omx.ik_batch])
def test_bad_limits_are_refused_by_name(function, limits):
    pose = (200, 0, 150, 0)
    with pytest.raises(omx.BadInput, match="`limits` must be 4 pairs"):
        function([pose] if function is omx.ik_batch else pose, limits=limits)


def test_degrees_are_not_radians():
    """A pitch of 45 means 45 rad; its remainder is what the answer has."""
    solution = omx.solve_ik((200, 0, 150, 45.0), limits=[(-pi, pi)] * 4)
    assert degrees(omx.pose(solution).pitch) == pytest.approx(degrees(45) % 360 - 360 * (degrees(45) % 360 > 180))


def test_angles_just_short_of_half_a_turn_stay_where_they_are():
    almost = nextafter(pi, 0)
    assert omx.pose((almost, 0, 0, 0)).x == pytest.approx(-274, abs=1e-9)
    assert omx.ik(omx.pose((almost, 0, 0, 0)))[0].q[0] == pytest.approx(pi, abs=1e-12)


@pytest.mark.parametrize(
    ("pose", "asked"),
    [
        ([0.2, 0, 0.1, 0], "metres? They are wanted in mm"),
        ([200, 0, 100, 45], "degrees? It is wanted in rad"),
        ([900, 0, 0, 90], "degrees? It is wanted in rad"),
        ([900, 0, 0, 0], ""),
        ([0, 0, 0, 0], ""),
    ],
)
def test_a_slip_of_unit_is_asked_for(pose, asked):
    with pytest.raises((omx.JointLimit, omx.Unreachable)) as refused:
        omx.solve_ik(pose)
    assert ("?" in str(refused.value)) == bool(asked)
    assert asked in str(refused.value)
