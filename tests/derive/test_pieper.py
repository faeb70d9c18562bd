"""Closed inverses from DH tables: no branch lost, none invented, in three languages; and which table has a pattern.

`OMX_SIX_POSES=100000` in the environment takes so many random poses of each arm; `OMX_SIX_PEERS=10000` compares so many
with the answers of EAIK, ssik and the robotics toolbox, in environments of their own.
"""

import json
import os
import subprocess
from math import pi

import numpy as np
import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st

import omx
from book.setup.paths import ROOT
from omx import BadInput, Chain, DHRow
from omx.analysis import Inverse
from omx.derive import Pattern, pattern, patterns, prove_equal, write_inverse
from omx.derive.pieper import Steps, triangle, turn, turned_x, wrist
from omx.generated import ik
from tests.helpers import oracles
from tests.helpers.javascript import NODE
from tests.helpers.six_joint_arms import ARMS, H, columns, configurations, gaps

POSES = int(os.environ.get("OMX_SIX_POSES", 300))
PEER_POSES = int(os.environ.get("OMX_SIX_PEERS", 20))
SAME = 1e-6  # rad or mm: answers that are nearer are one

#: What each arm's exactness is: of a hand, in mm and as entries of a rotation.
EXACT = 1e-9


@pytest.fixture(scope="module")
def inverses(tmp_path_factory):
    """The inverse of each arm, written when it is first asked for."""
    folder, made = tmp_path_factory.mktemp("inverses"), {}

    def inverse(arm, by=None):
        name = arm.name.replace(" ", "_") + (f"_by_{by.name.split()[0]}" if by else "")
        if name not in made:
            made[name] = Inverse(arm, write_inverse(name, arm, by=by, folder=folder))
        return made[name]

    return inverse


# ---- the three small problems, proved ------------------------------------------------------------------------

x, y, across, ahead, rho = sp.symbols("x y across ahead rho", real=True)


def test_the_turn_is_proved_for_both_sides():
    steps = Steps()
    sides, _ = turn(steps, across, (x, y))
    written = {symbol.name: expression for symbol, expression in steps}
    assert written["ahead"] == sp.sqrt(sp.Max(0, (sp.Symbol("rho", real=True) - across) * (rho + across)))
    facts = [(ahead, rho**2 - across**2), (rho, x**2 + y**2)]
    lengths = {sp.sqrt(x**2 + y**2): rho, sp.sqrt(across**2 + ahead**2): rho}
    for theta, forward in sides.values():
        angle = theta.subs(sp.Symbol("azimuth", real=True), written["azimuth"])
        c, s = (wave(angle).expand(trig=True).subs(lengths) for wave in (sp.cos, sp.sin))
        prove_equal(c * x + s * y, forward, facts)
        prove_equal(s * x - c * y, across, facts)


def test_the_triangle_is_proved_for_both_elbows():
    upper, fore, d = sp.symbols("upper fore d", positive=True)
    D, s = sp.symbols("D_ s_", real=True)
    steps = Steps()
    elbows = triangle(steps, "_", (x, y), upper, fore)
    written = {symbol: expression for symbol, expression in steps if symbol not in (D, s)}
    lengths = {sp.sqrt(x**2 + y**2): d, sp.sqrt(s**2 + D**2): 1}
    lengths[sp.sqrt((fore * s) ** 2 + (upper + fore * D) ** 2)] = d
    facts = [(s, 1 - D**2), (d, upper**2 + fore**2 + 2 * upper * fore * D)]
    for theta, bend in elbows.values():
        for wave, wanted in ((sp.cos, x), (sp.sin, y)):
            end = (upper * wave(theta) + fore * wave(theta + bend)).subs(written)
            prove_equal(sp.expand_trig(end).subs(lengths), wanted, facts)
    prove_equal(dict(steps)[D], (x**2 + y**2 - upper**2 - fore**2) / (2 * upper * fore))


@pytest.mark.parametrize(("k4", "k5"), [(1, 1), (1, -1), (-1, 1), (-1, -1)])
def test_the_wrist_is_proved_for_every_twist_and_both_flips(k4, k5):
    """Every rotation is one that the wrist makes; eta is the sign of sin(q5), times the choice of a flip."""

    def made(c, s):
        turns = [sp.Matrix([[c[i], -s[i], 0], [s[i], c[i], 0], [0, 0, 1]]) for i in range(3)]
        return turns[0] * turned_x(k4 * sp.pi / 2) * turns[1] * turned_x(k5 * sp.pi / 2) * turns[2]

    angles, eta = sp.symbols("u v w", real=True), sp.Symbol("eta", real=True)
    R = made([sp.cos(a) for a in angles], [sp.sin(a) for a in angles])
    steps, rows = Steps(), [DHRow(0, 0, 0, 0)] * 6
    q4, q5, q6 = wrist(steps, "", R, (k4, k5), ("q4", rows[3]), rows)["plain"]
    (s4, c4), (s5, c5), (s6, c6) = (dict(steps)[q].args for q in (q4, q5, q6))
    v = angles[1]
    first = {sp.cos(q4): eta * sp.cancel(c4 / sp.sin(v)), sp.sin(q4): eta * sp.cancel(s4 / sp.sin(v))}
    prove_equal(c4**2 + s4**2, sp.sin(v) ** 2)  # so |sin q5| is the hypotenuse, eta sin q5
    c, s = ([values[0], *(e.subs(first) for e in values[1:])] for values in ((0, c5, c6), (0, s5, s6)))
    c[0], s[0] = first[sp.cos(q4)], first[sp.sin(q4)]
    prove_equal(made(c, s), R, [(eta, 1)])


# ---- identity ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("arm", ARMS.values(), ids=ARMS)
def test_no_answer_is_lost_and_none_invented(arm, inverses):
    inverse = inverses(arm)
    for start in range(0, POSES, 10_000):
        q = configurations(arm, min(POSES - start, 10_000), seed=start)
        T = arm.fk(q)
        found = inverse.batch(T)
        lost = gaps(arm, q[:, None], found.q) > SAME
        assert not lost.any(), q[lost]
        there = ~np.isnan(found.q[..., 0])
        off = np.abs(arm.fk(np.nan_to_num(found.q)) - T[:, None]).max(axis=(-1, -2))[there]
        assert off.max() < EXACT
        if POSES > 10_000:
            print(f"{arm.name}: {len(q)} poses, {there.sum()} answers, worst {off.max():.1e}")


def test_forward_kinematics_here_is_that_of_elementary_moves():
    for arm in ARMS.values():
        rows = [(row.theta, row.d, row.a, row.alpha) for row in arm.rows]
        sliding = [i for i, row in enumerate(arm.rows) if row.prismatic]
        for q in configurations(arm, 5):
            np.testing.assert_allclose(arm.fk(q), oracles.product(rows, q, sliding)[-1], atol=1e-9)


@pytest.mark.parametrize("arm", ARMS.values(), ids=ARMS)
def test_all_answers_differ_at_a_pose_of_no_special_kind(arm, inverses):
    found = inverses(arm).batch(arm.fk(configurations(arm, 200, seed=1))).q
    for i in range(8):
        others = np.delete(found, i, axis=1)
        assert gaps(arm, found[:, i : i + 1], others).min() > SAME


def special(arm):
    """Configurations on and beside every place where a square root is 0 or an arc tangent loses its meaning."""
    q = configurations(arm, 200, seed=3)
    near = np.resize(oracles.NEAR, 200)
    straight = {"wrist straight": (4, 0.0), "wrist folded": (4, pi), "q1 at half a turn": (0, pi), "q4 too": (3, -pi)}
    places = {}
    for name, (joint, value) in straight.items():
        places[name] = q.copy()
        places[name][:, joint] = value - float(arm.rows[joint].theta) + near
    if arm.rows[2].prismatic:
        places["boom drawn in"] = q.copy()
        fixed = float(arm.rows[2].d) + np.cos(float(arm.rows[2].alpha)) * float(arm.rows[3].d)
        places["boom drawn in"][:, 2] = near - fixed
        places["boom upright"] = q.copy()
        places["boom upright"][:, 1] = np.resize([0, pi], 200) - float(arm.rows[1].theta) + near
        return places
    for name, bend in (("elbow straight", 0.0), ("elbow folded", pi)):
        places[name] = q.copy()
        third, fourth = arm.rows[2:4]
        sideways = -np.cos(float(arm.rows[1].alpha)) * np.sin(float(third.alpha)) * float(fourth.d)
        lean = 0.0 if pattern(arm).name == "three parallel axes" else np.arctan2(sideways, float(third.a))
        lean = 0.0 if sideways == 0 else lean
        places[name][:, 2] = np.cos(float(arm.rows[1].alpha)) * (bend - lean) - float(third.theta) + near
    return places


@pytest.mark.parametrize("arm", ARMS.values(), ids=ARMS)
def test_at_special_places_every_answer_is_one_and_one_is_where_the_hand_came_from(arm, inverses):
    for place, q in special(arm).items():
        T = arm.fk(q)
        found = inverses(arm).batch(T)
        there = ~np.isnan(found.q[..., 0])
        assert there.any(axis=1).all(), place
        off = np.abs(arm.fk(np.nan_to_num(found.q)) - T[:, None]).max(axis=(-1, -2))
        assert off[there].max() < EXACT, place
        if "wrist" not in place and "drawn" not in place:  # there, infinitely many answers are as good
            assert gaps(arm, q[:, None], found.q).max() < 1e-4, place


@pytest.mark.parametrize("arm", ARMS.values(), ids=ARMS)
def test_what_is_missing_is_how_far_the_nearest_answer_leaves_the_hand_from_its_place(arm, inverses):
    T = arm.fk(configurations(arm, 300, seed=4))
    T[:, :3, 3] *= np.random.default_rng(4).uniform(0, 2.5, (300, 1))
    module = inverses(arm).module
    q = np.array([[np.broadcast_to(v, 300) for v in one] for one in module.branches_batch(*columns(T))])
    missing = np.array([np.broadcast_to(gap, 300) for gap in module.missing_batch(*columns(T))]).T
    there = arm.fk(q.transpose(2, 0, 1))
    assert np.abs(there[..., :3, :3] - T[:, None, :3, :3]).max() < EXACT
    off = np.linalg.norm(there[..., :3, 3] - T[:, None, :3, 3], axis=-1)
    np.testing.assert_allclose(missing, off, atol=1e-7)
    assert (missing > 1).any()
    assert (missing == 0).any()


@pytest.mark.parametrize("arm", ARMS.values(), ids=ARMS)
def test_one_pose_many_and_javascript_agree(arm, inverses, tmp_path):
    module = inverses(arm).module
    T = arm.fk(configurations(arm, 40, seed=5))
    T[20:, :3, 3] *= 1.7
    many = np.array([[np.broadcast_to(v, 40) for v in one] for one in module.branches_batch(*columns(T))])
    many_gaps = np.array([np.broadcast_to(gap, 40) for gap in module.missing_batch(*columns(T))])
    poses = np.array(columns(T)).T.tolist()
    told = {"scalar": [[module.branches(*pose), module.missing(*pose), module.BRANCHES] for pose in poses]}
    if NODE is not None:
        script = tmp_path / "inverse.mjs"
        script.write_text((ROOT / module.__file__).with_suffix(".js").read_text())
        (tmp_path / "ask.mjs").write_text(
            f"import * as arm from './inverse.mjs';\nconst poses = {json.dumps(poses)};\n"
            "console.log(JSON.stringify(poses.map((p) => [arm.branches(...p), arm.missing(...p), arm.BRANCHES])));"
        )
        done = subprocess.run([NODE, tmp_path / "ask.mjs"], capture_output=True, text=True, timeout=60, check=True)
        told["JavaScript"] = json.loads(done.stdout)
    slides = np.array([row.prismatic for row in arm.rows])
    for answers in told.values():
        apart = np.abs(np.array([one[0] for one in answers]) - many.transpose(2, 0, 1))
        assert np.where(slides, apart, np.minimum(apart, np.abs(apart - 2 * pi))).max() < 1e-7
        np.testing.assert_allclose([one[1] for one in answers], many_gaps.T, atol=1e-9)
        assert tuple(answers[0][2]) == pattern(arm).branches


def test_both_patterns_of_the_textbooks_arm_give_the_same_answers(inverses):
    arm = ARMS["textbook"]
    first, second = patterns(arm)
    assert (first.name, second.name) == ("spherical wrist", "three parallel axes")
    assert pattern(arm) == first
    T = arm.fk(configurations(arm, 300, seed=6))
    one, other = (inverses(arm, by).batch(T).q for by in (first, second))
    assert max(gaps(arm, one, other).max(), gaps(arm, other, one).max()) < 1e-9
    with pytest.raises(BadInput, match="`by` must be one of the patterns of UR5"):
        write_inverse("ur", ARMS["UR5"], by=first)


def test_lengths_may_have_names(tmp_path, inverses):
    d1, a2, a3, d4, d6 = lengths = sp.symbols("d1 a2 a3 d4 d6", positive=True)
    rows = [(0, d1, 0, H), (0, 0, a2, 0), (0, 0, a3, 0), (0, d4, 0, H), (0, 0, 0, -H), (0, d6, 0, 0)]
    values = dict(zip(lengths, (300, 500, 400, 200, 100), strict=True))
    module = write_inverse("named", Chain([DHRow(*row) for row in rows]), folder=tmp_path, parameters=values)
    arm = ARMS["textbook"]
    T = arm.fk(configurations(arm, 50))
    np.testing.assert_allclose(
        Inverse(arm, module).batch(T).q, inverses(arm).batch(T).q, atol=1e-9, err_msg="numbers and names"
    )


@pytest.mark.parametrize("name", ["textbook", "Stanford", "UR5"])
def test_a_fixed_base_and_tool_are_in_the_formulas(name, tmp_path):
    base = oracles.turn_z(0.4) @ oracles.turn_x(pi / 2) @ oracles.shift(12, 30)
    tool = oracles.turn_x(0.3) @ oracles.shift(9, 50)
    arm = Chain(ARMS[name].rows, name=name, base=base, tool=tool)
    inverse = Inverse(arm, write_inverse("mounted", arm, folder=tmp_path))
    q = configurations(arm, 100, seed=11)
    found = inverse.batch(arm.fk(q)).q
    assert gaps(arm, q[:, None], found).max() < SAME
    there = ~np.isnan(found[..., 0])
    assert np.abs(arm.fk(np.nan_to_num(found)) - arm.fk(q)[:, None])[there].max() < EXACT
    with pytest.raises(BadInput, match="written for another arm"):
        Inverse(Chain(arm.rows, name=name), inverse.module)
    assert "leave base and tool off" in str(pattern(Chain(omx.COURSE.chain.rows, tool=tool)))


@settings(max_examples=8, deadline=None)
@given(
    st.sampled_from(("elbow", "slide", "parallel")),
    st.lists(st.sampled_from([-1.0, 1.0]), min_size=5, max_size=5),
    st.lists(st.sampled_from([0.0, H, -H, pi, 0.4]), min_size=6, max_size=6),
    st.lists(st.sampled_from([0.0, 12.5, -40.0, 130.0]), min_size=8, max_size=8),
    st.sampled_from([0.0, 0.3, -H, pi]),
)
def test_so_do_all_tables_of_the_patterns_that_hypothesis_finds(kind, signs, offsets, lengths, last):
    e1, e2, e3, e4, e5 = signs
    d1, d2, d3, d4, d6, a1, a3, a6 = lengths
    flat = {1.0: 0.0, -1.0: pi}
    third = {
        "elbow": (offsets[2], d3, a3 + 90, e3 * H),
        "slide": (offsets[2], d3, 0, flat[e3], True),
        "parallel": (offsets[2], d3, a3 + 200, flat[e3]),
    }[kind]
    second = (offsets[1], d2, 0, e2 * H) if kind == "slide" else (offsets[1], d2, 250, flat[e2])
    rows = [
        *((offsets[0], d1, a1, e1 * H), second, third, (offsets[3], d4, 0, e4 * H)),
        *((offsets[4], d6 if kind == "parallel" else 0, 0, e5 * H), (offsets[5], d6, a6, last)),
    ]
    arm = Chain([DHRow(*row) for row in rows])
    branches, missing = (run_scalar(function) for function in pattern(arm).functions())
    for q in configurations(arm, 4, seed=7):
        T = arm.fk(q)
        answers, beyond = np.array(branches(*columns(T))), np.array(missing(*columns(T)))
        reached = answers[beyond < 1e-9]
        assert gaps(arm, q[None, None], reached[None]).max() < SAME
        np.testing.assert_allclose(arm.fk(reached), np.broadcast_to(T, (len(reached), 4, 4)), atol=EXACT)


def run_scalar(function):
    """A generated function of one pose, from its text."""
    from omx.derive import source

    namespace = {}
    exec(compile(source("m", [function], doc="A test.", batch=False), "m.py", "exec"), namespace)
    return namespace[function.name]


# ---- fewer joints -------------------------------------------------------------------------------------------


def test_of_this_books_arm_it_is_the_inverse_of_chapter_04(tmp_path):
    module = write_inverse("ours", omx.COURSE.chain, folder=tmp_path)
    poses = np.random.default_rng(8).uniform([-400, -400, -200, -3], [400, 400, 500, 3], (2000, 4)).T
    *theirs, _, _ = ik.branches_batch(*poses, *omx.COURSE.values)
    for ours, chapters in zip(module.branches_batch(*poses), theirs, strict=True):
        assert oracles.angle_gap(ours, chapters).max() < 1e-12
    front, _, back, _ = module.missing_batch(*poses)
    np.testing.assert_allclose((front, back), ik.missing_batch(*poses, *omx.COURSE.values), atol=1e-9)


SMALL = {
    "three joints": [(0, 300, 0, H), (0, 0, 500, 0), (0, 0, 400, 0)],
    "PincherX": [(0, 89.45, 0, -H), (-1.2, 0, 105.95, 0), (1.2, 0, 100, 0), (0, 0, 109.15, 0)],
    "shoulder beside the axis": [(0.2, 100, 20, H), (0.1, 30, 200, pi), (0.4, 5, 180, 0), (0.3, 2, 60, H)],
    "SCARA": [(0, 300, 250, 0), (0, 0, 200, pi), (0, 0, 0, 0, True), (0, 0, 0, 0)],
    "SCARA, slide last": [(0.2, 300, 250, pi), (0, 10, 200, 0), (0.3, 0, 50, pi), (0.4, 5, 0, 0.7, True)],
    "SCARA, slide first": [(0.6, 300, 0, pi, True), (0, 10, 200, 0), (0.3, 0, 50, pi), (0.4, 5, 20, 0.7)],
    "SCARA, slide second": [(0.2, 300, 90, pi), (0.6, 10, 0, pi, True), (0.3, 0, 50, 0), (0.4, 5, 20, 0)],
    "planar": [(0, 0, 2, 0), (0, 0, 2, 0), (0, 0, 1, 0)],
    "two links": [(0, 0, 2, 0), (0, 0, 2, 0)],
}


def task(arm, q, names):
    """What a hand's inverse is asked for: place, and pitch or yaw."""
    T = arm.fk(q)
    q1 = q[:, 0] + float(arm.rows[0].theta)
    forward = np.cos(q1) * T[:, 0, 0] + np.sin(q1) * T[:, 1, 0]
    values = {"x": T[:, 0, 3], "y": T[:, 1, 3], "z": T[:, 2, 3]}
    values |= {"pitch": np.arctan2(T[:, 2, 0], forward), "yaw": np.arctan2(T[:, 1, 0], T[:, 0, 0])}
    return np.stack([values[name] for name in names], axis=-1)


@pytest.mark.parametrize("name", SMALL)
def test_arms_with_fewer_joints_come_back_to_where_they_were(name, inverses):
    arm = Chain([DHRow(*row) for row in SMALL[name]], name=name.replace(",", ""))
    inverse = inverses(arm)
    code = inverse.module.branches.__code__
    q = configurations(arm, 300, seed=9)
    target = task(arm, q, code.co_varnames[: code.co_argcount])
    found = inverse.batch(target)
    assert gaps(arm, q[:, None], found.q).max() < SAME
    there = ~np.isnan(found.q[..., 0])
    off = arm.fk(np.nan_to_num(found.q)) - arm.fk(q)[:, None]
    assert np.abs(off[..., :3, 3])[there].max() < EXACT


# ---- which pattern, or why none -------------------------------------------------------------------------------

WRIST = [(0, 200, 0, H), (0, 0, 0, -H), (0, 100, 0, 0)]
ELBOW = [(0, 300, 0, H), (0, 0, 500, 0), (0, 0, 400, 0)]
NONE = {
    "seven joints": ([(0, 0, 100, H)] * 7, "7 joints, and a hand needs six"),
    "five joints": ([(0, 0, 100, H)] * 5, "with 5 joints it needs axes that are all parallel"),
    "axes 4 and 5 apart": ([(0, 30, 100, H)] * 6, "axes 4 and 5 are 100 mm apart"),
    "axes 5 and 6 apart": ([(0, 0, 0, H), *ELBOW[:2], WRIST[0], (0, 0, 7, H), WRIST[2]], "axes 5 and 6 are 7 mm apart"),
    "a wrist that misses": (
        [(0, 0, 9, H), (0, 0, 9, H), (0, 0, 9, H), WRIST[0], (0, 5, 0, H), WRIST[2]],
        "axis 6 misses the crossing of axes 4 and 5 by 5 mm",
    ),
    "a slanting wrist": ([*ELBOW[:2], (0, 0, 9, H), (0, 0, 0, 1.0), (0, 0, 0, 1.0), WRIST[2]], "not at right angles"),
    "a wrist that is none": ([*ELBOW[:2], (0, 0, 9, H), (0, 0, 0, 0), (0, 0, 0, H), WRIST[2]], "axes 4 and 5 are par"),
    "first axes meet": (
        [(0, 0, 0, H), (0, 0, 0, H), (0, 0, 0, H), (0, 10, 20, H), (0, 3, 30, H), (0, 0, 4, 0)],
        "axes 1, 2 and 3 meet in one point, which is Pieper's condition, but not at the wrist",
    ),
    "last axes parallel": (
        [(0, 0, 9, H), (0, 3, 9, H), (0, 0, 9, H), (0, 10, 20, 0), (0, 3, 30, 0), (0, 0, 4, 0)],
        "axes 4, 5 and 6 are parallel, which is Pieper's condition, but not",
    ),
    "a quartic": ([ELBOW[0], (0, 20, 300, H), (0, 10, 40, H), *WRIST], "as Pieper asks, but axes 2 and 3 are not par"),
    "a slanting shoulder": ([(0, 0, 0, 1.0), *ELBOW[1:], *WRIST], "axes 1 and 2 are not at a right angle"),
    "a cylinder": ([(0, 300, 0, 0), (0, 0, 0, -H, True), (0, 0, 0, 0, True), *WRIST], "but joint 2 slides"),
    "a wrist off the boom": ([ELBOW[0], (0, 0, 0, H), (0, 0, 0, H, True), *WRIST], "not on the line of the slide"),
    "a boom beside the axis": ([ELBOW[0], (0, 0, 5, H), (0, 0, 0, 0, True), *WRIST], "does not pass axis 2"),
    "no forearm": ([*ELBOW[:2], (0, 0, 0, 0), *WRIST], "has no length"),
    "a sliding wrist": ([*ELBOW, WRIST[0], (0, 0, 0, -H, True), WRIST[2]], "a joint of the wrist slides"),
    "a gantry": ([(0, 0, 0, 0, True)] * 3, "0 of them turns and 3 slides"),
    "a crooked slide": ([(0, 0, 9, 0), (0, 0, 9, 0), (0, 0, 3, 0, True), (0, 0, 0, 0)], "shifts sideways"),
    "two axes in one": ([(0, 0, 0, 0), (0, 0, 9, 0), (0, 0, 3, 0)], "one and the same"),
    "no plane": ([ELBOW[0], ELBOW[0], ELBOW[1], ELBOW[2]], "the axes from 2 to 4 are not all parallel"),
    "a slanting turn": ([(0, 0, 0, 0.4), ELBOW[1], ELBOW[2]], "neither parallel nor at a right angle"),
    "a slide in the plane": ([ELBOW[0], (0, 0, 9, 0, True), ELBOW[1]], "a joint slides"),
    "a flat shoulder": ([ELBOW[0], (0, 0, 0, 0), ELBOW[1]], "has no length"),
}  # fmt: skip


@pytest.mark.filterwarnings("ignore:.*after Craig:UserWarning")
@pytest.mark.parametrize("name", NONE)
def test_a_table_without_a_pattern_is_told_why(name, tmp_path):
    rows, told = NONE[name]
    arm = Chain([DHRow(*row) for row in rows], name="mine")
    found = pattern(arm)
    assert isinstance(found, Pattern)
    assert not found
    assert found.name == "none"
    assert told in str(found)
    with pytest.raises(BadInput, match="mine has no inverse of this kind: "):
        write_inverse("mine", arm, folder=tmp_path)
    assert not list(tmp_path.iterdir())


FOUND = {
    "textbook": (ARMS["textbook"], "spherical wrist", (4, 5, 6), 8),
    "Stanford": (ARMS["Stanford"], "spherical wrist", (4, 5, 6), 8),
    "UR5": (ARMS["UR5"], "three parallel axes", (2, 3, 4), 8),
    "ours": (omx.COURSE.chain, "shoulder and plane", (2, 3, 4), 4),
    "SCARA": (Chain([DHRow(*row) for row in SMALL["SCARA"]]), "all axes parallel", (1, 2, 3, 4), 2),
}


@pytest.mark.parametrize("name", FOUND)
def test_a_table_with_a_pattern_is_told_which(name):
    arm, called, axes, branches = FOUND[name]
    found = pattern(arm)
    assert found
    assert (found.name, found.axes, len(found.branches)) == (called, axes, branches)


def test_rounded_tables_are_seen_through_and_twists_must_be_numbers():
    rows = [list(row) for row in (*ELBOW, *WRIST)]
    rows[4][2] = 500 * (0.1 + 0.2 - 0.3)
    assert pattern(Chain([DHRow(*row) for row in rows])).name == "spherical wrist"
    with pytest.raises(BadInput, match="alpha of row 2 of chain is beta; a pattern needs twists in numbers"):
        pattern(Chain([DHRow(0, 1, 0, H), DHRow(0, 0, 1, sp.Symbol("beta"))]))
    with pytest.raises(BadInput, match=r"must be an omx\.Chain"):
        pattern([1, 2])


# ---- others ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("peer", "name"),
    [*((peer, arm) for peer in ("eaik", "ssik") for arm in ("textbook", "UR5"))]
    + [("toolbox", arm) for arm in ("textbook", "UR5", "Stanford")],
)
def test_others_have_the_same_answers(peer, name, inverses, tmp_path):
    folder = ROOT / "build" / f"env-peer-{peer}"
    python = next((p for p in (folder / "bin/python", folder / "Scripts/python.exe") if p.exists()), None)
    asked = peer != "toolbox" or "OMX_SIX_PEERS" in os.environ  # the toolbox derives for a minute
    if python is None or not (folder / "complete").exists() or not asked:
        pytest.skip(f"build/env-peer-{peer} is not there, or takes too long; ask for it with OMX_SIX_PEERS=100")
    arm = ARMS[name]
    T = arm.fk(configurations(arm, PEER_POSES, seed=10))
    rows = [[row.theta, row.d, row.a, row.alpha, row.prismatic] for row in arm.rows]
    np.savez(tmp_path / "asked.npz", rows=np.array(rows, float), poses=T)
    command = [python, "-m", "tests.helpers.six_joint_peers", peer, tmp_path / "asked.npz"]
    subprocess.run(command, cwd=ROOT, check=True, timeout=36_000)
    theirs, ours = np.load(f"{tmp_path / 'asked.npz'}.out.npz")["q"], inverses(arm).batch(T).q
    only_ours, theirs_too = gaps(arm, ours, theirs), gaps(arm, theirs, ours)
    near = 1e-4 if peer == "toolbox" else SAME  # what it has under a square root it has with half of all digits
    counts = f"{len(only_ours)} answers of ours, {len(theirs_too)} of theirs, which lack {(only_ours > near).sum()}"
    print(f"{name}, {peer}: {counts}; worst {theirs_too.max():.1e}")
    assert theirs_too.max() < near
    if peer != "toolbox":  # of 231,202 answers it loses 219, none of them near to another one
        assert only_ours.max() < near
