"""Every number of the two labs and of the planar-arm document, to the last digit that they print; and their errata.

The textbook chapter and the Stanford arm have `test_sources_arms.py`.
"""

from math import acos, asin, atan, atan2, degrees, hypot, pi, radians, sqrt

import numpy as np
import pytest
import sympy as sp

import omx
from omx import COURSE, Chain, DHRow
from omx.derive.symbolic import dh_matrix
from tests.helpers import oracles

ASIN, ATAN = asin(24 / 130), atan2(24, 128)  # the two deltas of the labs


def rad(*angles):
    return [radians(angle) for angle in angles]


def assert_prints(values, printed):
    """Each value, rounded to the digits that stand in `printed` (strings), is what is printed."""
    for value, text in zip(values, printed, strict=True):
        digits = len(text.partition(".")[2])
        assert round(value, digits) + 0.0 == float(text), f"{value} is not printed as {text}"


# ---- lab 2: forward kinematics -------------------------------------------------------------------------

SANITY = {
    (0, 0, 0, 0): ("1 0 0  0 0 1  0 -1 0", "274 0 204.765"),
    (15, -45, -60, 90): (".933 .25 -.259  .25 .067 .966  .259 -.966 0", "15.687 4.203 336.7"),
    (-90, 15, 30, -45): ("0 0 1  -1 0 0  0 -1 0", "0 -269.932 106.519"),
}


@pytest.mark.parametrize("q", SANITY)
def test_the_sanity_table_of_lab_2(q):
    T = omx.fk(rad(*q))
    rotation, position = SANITY[q]
    printed = [float(text) for text in (*rotation.split(), *position.split())]
    computed = [round(value, 3) + 0.0 for value in (*T[:3, :3].ravel(), *T[:3, 3])]
    assert computed == printed
    np.testing.assert_allclose(oracles.arm_frames(rad(*q))[-1], T, atol=1e-12)


def test_task_space_is_position_pitch_and_yaw():
    q = rad(15, -45, -60, 90)
    x, y, _, pitch = omx.pose(q)
    assert degrees(pitch) == pytest.approx(15) == -(-45 - 60 + 90)
    assert degrees(atan2(y, x)) == pytest.approx(15)


READINGS = {
    (14.41, -44.74, -59.59, 89.47): ("17.654", "4.538", "337.095"),
    (14.41, -44.91, -59.68, 89.74): ("16.800", "4.318", "336.728"),
    (14.5, -45, -59.85, 90): ("16.099", "4.164", "336.471"),
    (-88.95, 14.5, 29.62, -44.3): ("4.974", "-270.199", "108.745"),
    (-89.21, 14.59, 29.71, -44.38): ("3.730", "-270.135", "108.195"),
    (-89.47, 14.85, 29.88, -44.47): ("2.485", "-270.022", "106.487"),
    (-89.74, 14.94, 29.97, -44.65): ("1.242", "-269.942", "106.131"),
}


@pytest.mark.parametrize(("q", "printed"), READINGS.items())
def test_readings_of_the_real_arm_agree_to_the_last_digit_once_their_ticks_are_restored(q, printed):
    """The log prints whole ticks rounded to 0.01 deg; unrestored, the rounding allows what its half does at the tip."""
    ticks = np.round(np.array(q) * 4096 / 360)
    assert np.abs(ticks * 360 / 4096 - q).max() < 0.005
    assert_prints(omx.pose(ticks * 2 * pi / 4096)[:3], printed)
    allowed = np.abs(omx.jacobian(rad(*q))[:3]).sum(axis=1) * radians(0.005) + 0.0005
    gaps = np.abs(np.array(omx.pose(rad(*q))[:3]) - np.array(printed, float))
    assert (gaps <= allowed).all()
    assert gaps.max() > 0.005


def test_erratum_row_3_of_the_table_turns_with_theta_3():
    q = rad(15, -45, -60, 90)
    misprint = oracles.product(oracles.table(*oracles.COURSE), (q[0], q[1], q[1], q[3]))[-1]
    assert np.linalg.norm(misprint[:3, 3] - omx.fk(q)[:3, 3]) > 20


def test_erratum_the_prelabs_first_twist_turns_the_arm_upside_down():
    rows = oracles.table(*oracles.COURSE)
    prelab = oracles.product(((0, 77, 0, pi / 2), *rows[1:]), omx.ZERO)[-1]
    assert prelab[2, 3] - 77 == pytest.approx(77 - omx.fk(omx.ZERO)[2, 3])
    np.testing.assert_allclose(oracles.link(0, 77, 0, pi / 2)[1], [0, 0, -1, 0], atol=1e-15)
    np.testing.assert_allclose(omx.COURSE.chain.matrices(omx.ZERO)[0][1], [0, 0, 1, 0], atol=1e-15)


def test_erratum_the_prelabs_table_has_neither_l4_nor_delta():
    """Without L4 its tip is the wrist, 126 mm off; without delta the tip is 24 mm off and more."""
    for lengths, gap in (((77, 130, 124, 0, ASIN), 126.0), ((77, 130, 124, 126, 0), hypot(24, 130 - 127.765))):
        tip = oracles.arm_frames(omx.ZERO, lengths)[-1][:3, 3]
        assert np.linalg.norm(tip - omx.fk(omx.ZERO)[:3, 3]) == pytest.approx(gap, abs=1e-3)


def test_erratum_the_third_row_of_a_planar_link_is_0_0_1_0():
    """Printed: (0, 1, 0, 0). With that, the third column is all zeros, and the matrix is no rotation."""
    A2 = dh_matrix(sp.Symbol("theta_2"), 0, sp.Symbol("L2"), 0)
    assert list(A2.row(2)) == [0, 0, 1, 0]
    printed = A2.copy()
    printed[2, :] = sp.Matrix([[0, 1, 0, 0]])
    assert printed[:3, :3].det() == 0
    assert A2[:3, :3].det().simplify() == 1


def test_erratum_the_prelabs_table_and_its_matrices_are_two_arms():
    """The table has the modified convention's a beside a standard alpha; the matrices are standard, without L1."""
    table = oracles.product([(0, 77, 0, pi / 2), (0, 0, 0, 0), (0, 0, 130, 0), (0, 0, 124, 0)], omx.ZERO)[-1]
    matrices = oracles.product([(0, 0, 0, pi / 2), (0, 0, 130, 0), (0, 0, 124, 0), (0, 0, 126, 0)], omx.ZERO)[-1]
    np.testing.assert_allclose(table[:3, 3], (254, 0, 77), atol=1e-12)
    np.testing.assert_allclose(matrices[:3, 3], (380, 0, 0), atol=1e-12)


def test_erratum_the_caption_of_figure_3_1_lacks_a_minus():
    as_printed, as_meant = (omx.pose(rad(15, -45, q3, 90)).z for q3 in (60, -60))
    assert_prints([as_printed, as_meant], ("30.5", "336.7"))


def test_erratum_the_targets_of_lab_3_are_cut_in_z_and_rounded_in_x_and_y():
    """(274, 0, 204), (16, 4, 336), (0, -270, 106), against the poses of lab 2's sanity table."""
    for q, whole in zip(SANITY, [(274, 0, 204), (16, 4, 336), (0, -270, 106)], strict=True):
        x, y, z = omx.fk(rad(*q))[:3, 3]
        assert (round(x), round(y), int(z)) == whole
        assert round(z) == whole[2] + 1


def test_erratum_rounded_poses_move_the_joints_by_degrees():
    q = np.array(omx.solve_ik((16, 4, 336, radians(15)), start=rad(15, -45, -60, 90)))
    moved = np.abs(np.degrees(q) - (15, -45, -60, 90))
    assert_prints(moved[[0, 2]], ("1.0", "1.9"))


QUOTED = {(15, -45, -60, 90): (14.41, -44.91, -59.68, 89.74), (-90, 15, 30, -45): (-89.47, 14.85, 29.88, -44.47)}
LAST = {(15, -45, -60, 90): (14.5, -45, -59.85, 90), (-90, 15, 30, -45): (-89.74, 14.94, 29.97, -44.65)}


def test_erratum_the_quoted_readings_are_of_an_arm_that_still_moves():
    """All eight joints are short of their targets; the log goes on, and every joint comes nearer or stays."""
    for target, quoted in QUOTED.items():
        to_go = np.subtract(target, quoted) * np.sign(target)
        assert (to_go > 0).all()
        assert (np.abs(np.subtract(target, LAST[target])) <= to_go + 1e-9).all()


@pytest.mark.parametrize(("lines", "printed"), [(QUOTED, ("1.1", "2.5")), (LAST, ("0.48", "1.28"))])
def test_how_far_the_tool_of_the_real_arm_was_off(lines, printed):
    off = [np.linalg.norm((omx.fk(rad(*line)) - omx.fk(rad(*target)))[:3, 3]) for target, line in lines.items()]
    assert_prints(off, printed)
    assert np.spacing(300.0) < 1e-12, "floating-point rounding explains none of it"


def test_erratum_18751_mm_is_a_millimetre_converted_twice():
    reach = COURSE.L2 + COURSE.L3 + COURSE.L4
    assert 18751.77 / 1000 < reach < 18751.77


# ---- lab 3: inverse kinematics -------------------------------------------------------------------------

LAB_3 = COURSE.replace("lab 3's inverse", delta=ATAN)  # with L2 = 130, as its FK has it
ROUND_TRIPS = [  # target, the angles that its inverse gives, what its FK makes of them, as printed
    ((274, 0, 204, 0), (0, 0.020, 0.333, -0.353), ("274.042", "0", "203.992", "0")),
    ((16, 4, 336, 15), (14.036, -45.922, -58.12, 89.0427), ("16.034", "4.009", "336.025", "15")),
    ((0, -270, 106, 0), (-90, 15.213, 30.001, -45.214), ("0", "-270.039", "105.981", "0")),
]


def elbow_up(target, geometry):
    x, y, z, alpha = target
    return omx.ik((x, y, z, radians(alpha)), geometry)[0].q


@pytest.mark.parametrize(("target", "angles", "printed"), ROUND_TRIPS)
def test_the_sanity_table_of_lab_3_comes_from_two_deltas(target, angles, printed):
    """Its residuals are not rounding: the inverse has delta = atan2(24, 128), its FK has delta = asin(24 / 130)."""
    q = elbow_up(target, LAB_3)
    for found, angle in zip(np.degrees(q), angles, strict=True):
        assert found == pytest.approx(angle, abs=6e-4)
    x, y, z, pitch = omx.pose(q, COURSE)
    assert_prints((x, y, z, degrees(pitch)), printed)


def test_the_residuals_to_four_digits():
    tips = [omx.pose(elbow_up(target, LAB_3), COURSE) for target, _, _ in ROUND_TRIPS]
    assert_prints((tips[0].x, tips[0].z), ("274.0425", "203.992"))
    assert_prints(tips[1][:3], ("16.0342", "4.0086", "336.0250"))
    assert_prints(tips[2][:3], ("0", "-270.0389", "105.9812"))


@pytest.mark.parametrize("geometry", [COURSE, LAB_3, omx.MAKER], ids=lambda g: g.name)
def test_with_one_delta_the_round_trip_is_exact(geometry):
    for target, _, _ in ROUND_TRIPS:
        wanted = (*target[:3], radians(target[3]))
        assert oracles.pose_gap(omx.pose(elbow_up(target, geometry), geometry), wanted) < 1e-12


def test_the_two_deltas_and_the_true_dog_leg():
    assert_prints((degrees(ATAN), degrees(ASIN), hypot(128, 24)), ("10.620", "10.639", "130.231"))


def test_erratum_row_2_has_its_angles_misprinted():
    """-45 for -45.922, since the angles add up to -alpha; and 89.0243 for 89.0427."""
    q = np.degrees(elbow_up((16, 4, 336, 15), LAB_3))
    assert_prints(q, ("14.036", "-45.922", "-58.12", "89.0427"))
    assert sum(q[1:]) == pytest.approx(-15)
    assert pytest.approx(0.904, abs=1e-3) == -45 - 58.12 + 89.0243 + 15


def test_erratum_the_zeros_of_row_1_are_rounded():
    q = np.degrees(elbow_up((274, 0, 204, 0), LAB_3))
    assert_prints(q, ("0", "0.020", "0.333", "-0.353"))
    assert_prints(q, ("0", "0", "0", "-0"))


def textbook_ik(target, geometry, elbow, clamp=False):
    """The lab's formulas as printed, in degrees; `clamp` cuts the cosines off at 1, as a public solution does."""
    x, y, z, alpha = target
    L1, L2, L3, L4, delta = geometry.values
    r_w = hypot(x, y) - L4 * np.cos(radians(alpha))
    z_w = z - L1 - L4 * np.sin(radians(alpha))
    d_w, mu = hypot(r_w, z_w), degrees(atan2(z_w, r_w))
    cosines = (L2**2 + L3**2 - d_w**2) / (2 * L2 * L3), (d_w**2 + L2**2 - L3**2) / (2 * d_w * L2)
    beta, gamma = (degrees(acos(min(max(c, -1.0), 1.0) if clamp else c)) for c in cosines)
    q2 = 90 - degrees(delta) - elbow * gamma - mu
    q3 = 90 + degrees(delta) - elbow * beta
    return degrees(atan2(y, x)), q2, q3, -alpha - q2 - q3


@pytest.mark.parametrize(("elbow", "branch"), [(1, 0), (-1, 1)], ids=["up", "down"])
def test_the_labs_formulas_are_the_front_branches(elbow, branch):
    """Elbow down wants its q3 wrapped, which the lab leaves out."""
    for target in [(*tip[:3], degrees(tip[3])) for tip in omx.pose(oracles.random_q(300))]:
        solution = omx.ik((*target[:3], radians(target[3])))[branch]
        if solution.reachable:
            gaps = oracles.angle_gap(np.radians(textbook_ik(target, COURSE, elbow)), solution.q)
            assert gaps.max() < 1e-6


def test_elbow_downs_q3_needs_the_wrap():
    q3 = textbook_ik((300, 0, 150, 0), COURSE, elbow=-1)[2]
    assert q3 > 180
    assert degrees(omx.ik((300, 0, 150, 0))[1].q[2]) == pytest.approx(q3 - 360)


def test_the_arc_cosine_form_fails_on_the_straight_arm_where_ours_does_not():
    q = oracles.random_q(2000)
    q[:, 2] = COURSE.delta - pi / 2
    failed = 0
    for tip in omx.pose(q):
        assert any(solution.reachable for solution in omx.ik(tip))
        try:
            textbook_ik((*tip[:3], degrees(tip[3])), COURSE, 1)
        except ValueError:  # the cosine is 1 + 2e-15
            failed += 1
    assert failed > 200


def test_erratum_theta_1_wants_the_arc_tangent_of_two_arguments():
    assert degrees(omx.ik((-150, -100, 200, 0))[0].q[0]) == pytest.approx(degrees(atan(100 / 150)) - 180)
    assert degrees(omx.ik((-100, -100, 200, 0))[0].q[0]) == pytest.approx(degrees(atan(1)) - 180)  # printed: 45


@pytest.mark.parametrize("q1", [-2.0, 0.0, 0.7])
def test_erratum_q1_is_free_above_the_base(q1):
    """At x = y = 0 the arc tangent says nothing, and the joint stays where it is."""
    high = omx.solve_ik((0, 0, 400, radians(90)), start=(q1, 0, -1.0, 0))
    assert high.q[0] == pytest.approx(q1)


def test_erratum_clamping_before_testing_gives_legal_angles_of_another_place():
    q = rad(*textbook_ik((600, 0, 204, 0), COURSE, 1, clamp=True))
    assert not COURSE.chain.violations(q)
    assert_prints(omx.pose(q)[:3], ("371", "0", "143"))
    with pytest.raises(omx.Unreachable, match=r"236\.719 mm are missing"):
        omx.solve_ik((600, 0, 204, 0))
    assert sqrt(474**2 + 127**2) - 254 == pytest.approx(236.719, abs=5e-4)


def test_erratum_the_inverse_of_a_measured_pose_agrees_with_any_angles_at_all():
    """Figure 1 against figure 2: IK(FK(q)) = q for angles out of a hat, so their agreement says nothing of the arm."""
    for q in oracles.random_q(200):
        assert oracles.angle_gap(omx.solve_ik(omx.pose(q), start=q).q, q).max() < 1e-6


WAYPOINTS = [(25, -100, 150, -60), (150, 80, 300, 0), (250, -115, 75, -45), (25, -100, 150, -60)]


def test_every_waypoint_of_lab_3_is_legal():
    q = omx.HOME
    for x, y, z, alpha in WAYPOINTS:
        q = omx.solve_ik((x, y, z, radians(alpha)), start=q)
        assert (q.front, q.elbow_up) == (True, True)
        assert oracles.pose_gap(omx.pose(q), (x, y, z, radians(alpha))) < 1e-12


def test_erratum_the_path_between_the_waypoints_is_no_triangle():
    corners = [np.array(omx.solve_ik((*w[:3], radians(w[3])), start=omx.HOME)) for w in WAYPOINTS]
    bulges = []
    for a, b, start, end in zip(corners, corners[1:], WAYPOINTS, WAYPOINTS[1:], strict=False):
        way = omx.pose(a + np.linspace(0, 1, 101)[:, None] * (b - a))[:, :3] - start[:3]
        side = np.subtract(end, start)[:3] / np.linalg.norm(np.subtract(end, start)[:3])
        bulges.append(np.linalg.norm(way - np.outer(way @ side, side), axis=1).max())
    assert_prints(bulges, ("72", "57", "49"))


# ---- planar arms of n links ----------------------------------------------------------------------------


def articulations(x, lengths):
    """f~(x) of the document, a row for each articulation: its position and its direction."""
    lower = np.tril(np.ones((len(x), len(x))))
    links = lower @ np.diag(lengths)
    return np.column_stack([links @ np.cos(lower @ x), links @ np.sin(lower @ x), lower @ x])


def tip(x, lengths):
    """f(x) of the document."""
    lower = np.tril(np.ones((len(x), len(x))))
    return np.array([lengths @ np.cos(lower @ x), lengths @ np.sin(lower @ x), np.sum(x)])


def test_three_links_at_60_degrees():
    np.testing.assert_allclose(tip(np.radians([60, 60, 60]), np.array([2, 2, 1])), [-1, 2 * sqrt(3), pi], atol=1e-15)


@pytest.mark.parametrize("links", [1, 2, 3, 4, 7])
def test_the_matrix_form_is_a_chain_of_planar_rows(links):
    rng = np.random.default_rng(links)
    lengths, x = rng.uniform(1, 100, links), rng.uniform(-3, 3, links)
    frames = Chain([DHRow(0, 0, length, 0) for length in lengths]).frames(x)[1:]
    found = articulations(x, lengths)
    directions = np.column_stack([np.cos(found[:, 2]), np.sin(found[:, 2])])
    np.testing.assert_allclose(frames[:, :2, 3], found[:, :2], atol=1e-12)
    np.testing.assert_allclose(frames[:, :2, 0], directions, atol=1e-13)
    np.testing.assert_allclose(tip(x, lengths), found[-1], atol=1e-12)


def test_two_links_at_60_degrees():
    """The figure of a two-link arm: elbow at (1, 1.732), tip right above the base, 3.464 high."""
    found = articulations(np.radians([60, 60]), np.array([2, 2]))
    np.testing.assert_allclose(found, [[1, sqrt(3), pi / 3], [0, 2 * sqrt(3), 2 * pi / 3]], atol=1e-14)


def test_erratum_the_program_computes_every_articulation_and_no_direction():
    """What is printed gives two numbers a link; the tip is three numbers, and the last row holds two of them."""
    x, lengths = np.radians([60, 60, 60]), np.array([2, 2, 1])
    printed = articulations(x, lengths)[:, :2]
    assert printed.shape == (3, 2)
    assert tip(x, lengths).shape == (3,)
    np.testing.assert_allclose(printed[-1], tip(x, lengths)[:2], atol=1e-14)
    assert np.abs(printed[:-1] - tip(x, lengths)[:2]).max() > 0.5


def test_the_arm_is_a_planar_arm_of_three_links_turned_and_lifted():
    L1, L2, L3, L4, delta = COURSE.values
    for q1, q2, q3, q4 in oracles.random_q(200):
        x = np.array([pi / 2 - delta - q2, -(pi / 2 - delta) - q3, -q4])
        r, z, pitch = tip(x, np.array([L2, L3, L4]))
        expected = (r * np.cos(q1), r * np.sin(q1), L1 + z, pitch)
        assert oracles.pose_gap(omx.pose((q1, q2, q3, q4)), expected) < 1e-12
