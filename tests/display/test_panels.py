"""Panels: sliders within the limits, the newest value wins, and the arm stays at its last legal pose."""

import asyncio
import html
import json
import math
import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import omx
from omx.display.panels import JointPanel, PosePanel, tables
from omx.display.panels.panel import Later
from omx.display.viewer import View
from omx.display.viewer.scene import SCENE
from tests.helpers.scenes import Clock, Page, decoded, objects, placed

SLIDER = omx.Chain([omx.DHRow(0, 50, 0, 1.0), omx.DHRow(0, 20, 0, 0, prismatic=True)], limits=[(-1, 1), (5, 60)])


def text_of(box):
    """The words of an HTML box."""
    return html.unescape(re.sub(r"<[^>]*>", " ", box.value)).replace("\u2212", "-")


# ---- joints --------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("limits", "ends"),
    [
        ([(-math.pi / 6, math.pi / 6), (5, 60)], [(-30, 30), (5, 60)]),
        (np.array([[-math.pi / 12, 2 * math.pi / 3], [-0.33, 0.33]]), [(-15, 120), (-0.33, 0.33)]),
        ([(math.radians(10.2), math.radians(10.8)), (100, 300)], [(10.2, 10.8), (100, 300)]),
        ([(-math.inf, math.inf), (0, math.inf)], [(-180, 180), (0, 100)]),
        ([(0.5, math.inf), (-math.inf, -20)], [(29, 180), (-21, -20)]),
    ],
)
def test_sliders_serve_any_limits_that_a_chain_has(limits, ends):
    """Whole degrees are not lost to rounding, short ranges stay, endless joints get ends, and zero may be outside."""
    chain = omx.Chain(SLIDER.rows, limits=limits)
    panel = JointPanel(View.of_chain(chain))
    for slider, (low, high) in zip(panel.sliders, ends, strict=True):
        assert slider.min == pytest.approx(low, abs=1) if low == 29 else slider.min == pytest.approx(low)
        assert slider.max == pytest.approx(high)
        assert slider.min <= slider.value <= slider.max
    chain.check(panel.q)
    for slider in panel.sliders:
        slider.value = slider.max
        slider.value = slider.min
    chain.check(panel.q)


def test_sliders_keep_to_the_limits():
    panel = JointPanel()
    for slider, (low, high) in zip(panel.sliders, omx.LIMITS, strict=True):
        assert math.radians(slider.min) >= low - 1e-12
        assert math.radians(slider.max) <= high + 1e-12
        assert slider.max - slider.min > math.degrees(high - low) - 2.01


def test_a_slider_moves_the_arm_and_tells_the_pose():
    panel = JointPanel(q=omx.ZERO)
    panel.sliders[0].value = 90
    assert panel.q == panel.view.q == (math.pi / 2, 0, 0, 0)
    np.testing.assert_allclose(placed(panel.view.channel, "/meshcat/arm/4"), omx.fk(panel.q), atol=1e-9)
    panel.sliders[1].value = 10
    numbers = text_of(panel._text)
    _, y, z, pitch = omx.pose(panel.q)
    for value in (y, z, math.degrees(pitch)):
        assert f"{value:.1f}" in numbers


def test_setting_q_moves_sliders_and_arm_exactly():
    panel = JointPanel()
    assert panel.q == omx.HOME
    assert [slider.value for slider in panel.sliders] == pytest.approx(np.degrees(omx.HOME))
    panel.q = (0.1, 0.2, 0.3, 0.4)
    assert panel.view.q == (0.1, 0.2, 0.3, 0.4), "not rounded to the sliders' steps"
    assert panel.sliders[3].value == pytest.approx(math.degrees(0.4))


def test_the_page_may_round_its_sliders_without_moving_the_arm():
    panel = JointPanel()
    panel.q = q = tuple(omx.ik([200, 0, 100, 0])[0].q)
    for told in (omx.HOME, q):  # a page answers values between two steps so, and late, when cells run one after another
        for slider, value in zip(panel.sliders, np.degrees(told), strict=True):
            slider.value = round(value)
        assert panel.q == panel.view.q == q
    panel.sliders[0].value = 20
    assert panel.q == (math.radians(20), *q[1:]), "the other joints stay where they are"
    panel.sliders[1].value = round(math.degrees(q[1])) + 1
    assert panel.q[1] == math.radians(round(math.degrees(q[1])) + 1)


def test_q_outside_the_limits_is_refused_and_nothing_moves():
    panel = JointPanel()
    with pytest.raises(omx.JointLimit, match="q2"):
        panel.q = (0, 2.0, 0, 0)
    assert panel.q == panel.view.q == omx.HOME
    assert panel.sliders[1].value == pytest.approx(math.degrees(omx.HOME[1]))


def test_named_poses():
    panel = JointPanel()
    buttons = {b.description: b for b in panel.children[1].children[0].children[-1].children}
    buttons["zero"].click()
    assert panel.q == omx.ZERO
    buttons["home"].click()
    assert panel.q == omx.HOME


def test_zero_is_the_nearest_legal_value_where_zero_is_not_legal():
    panel = JointPanel(View.of_chain(SLIDER, (0.5, 30)))
    (button,) = panel.children[1].children[0].children[-1].children
    button.click()
    assert panel.q == (0, SLIDER.limits[1][0])
    assert SLIDER.limits[1][0] > 0


def test_narrower_limits_can_be_given():
    panel = JointPanel(q=omx.ZERO, limits=[(-0.5, 0.5)] * 4)
    assert {(s.min, s.max) for s in panel.sliders} == {(-28, 28)}
    with pytest.raises(omx.JointLimit):
        panel.q = omx.HOME


def test_any_chain_has_its_panel():
    panel = JointPanel(View.of_chain(SLIDER, (0, 30)))
    assert (panel.sliders[1].min, panel.sliders[1].max, panel.sliders[1].value) == (5, 60, 30)
    panel.sliders[1].value = 40
    assert panel.q == (0, 40)
    np.testing.assert_allclose(placed(panel.view.channel, "/meshcat/arm/2"), SLIDER.fk((0, 40)), atol=1e-9)


def test_a_view_can_be_shared_by_two_panels():
    view = View()
    one, two = JointPanel(view), JointPanel(view)
    one.sliders[0].value = 20
    two.sliders[0].value = 40
    assert view.q[0] == pytest.approx(math.radians(40))


# ---- no flooding ---------------------------------------------------------------------------------------


def test_a_flood_of_slider_events_costs_few_messages():
    panel = JointPanel(q=omx.ZERO)
    clock = panel.view.channel._clock = Clock()
    page = Page(panel.view.channel)
    for k in range(1000):
        clock.now += 0.001
        panel.sliders[0].value = 0.1 * k
    panel.view.channel.flush()
    assert len(page.messages) < 70
    np.testing.assert_allclose(placed(panel.view.channel, "/meshcat/arm/4"), omx.fk(panel.q), atol=1e-9)
    assert panel.q[0] == pytest.approx(math.radians(99.9))


def test_numbers_are_written_once_for_many_moves_and_after_them():
    async def flood():
        moves, written = [], []
        later = Later(lambda: written.append(len(moves)), 0.01)
        for k in range(50):
            moves.append(k)
            later()
        at_once = list(written)
        await asyncio.sleep(0.1)
        return at_once, written

    assert asyncio.run(flood()) == ([], [50])
    written = []
    Later(lambda: written.append(1), 10.0)()
    assert written == [1], "nothing could call later"


# ---- commands that are a ghost alone ---------------------------------------------------------------------


def test_commands_are_shown_as_a_ghost():
    """With a real arm the command is a ghost, and the solid arm stands where the arm reports that it is."""
    panel = JointPanel(q=omx.ZERO)
    panel.command_a_ghost()
    panel.sliders[0].value = 30
    assert panel.view.q == omx.ZERO
    np.testing.assert_allclose(placed(panel.view.channel, "/meshcat/ghosts/0/4"), omx.fk(panel.q), atol=1e-9)
    panel.view.q = (0.1, 0, 0, 0)
    assert panel.q[0] == pytest.approx(math.radians(30)), "what is measured changes no command"


def test_a_pose_panel_shows_its_solution_the_same_way():
    panel = PosePanel()
    panel.command_a_ghost()
    panel.pose = (200, 0, 200, 0)
    assert panel.q == omx.solve_ik((200, 0, 200, 0), omx.HOME).q
    assert panel.view.q == omx.HOME


# ---- poses ---------------------------------------------------------------------------------------------


def test_a_pose_slider_moves_the_tool_there():
    panel = PosePanel()
    x, y, z, _pitch = panel.pose
    panel.sliders[1].value = 50
    np.testing.assert_allclose(omx.fk(panel.view.q)[:3, 3], (x, 50, z), atol=1e-6)
    assert y == 0
    assert panel.message == ""


poses = st.tuples(st.floats(-380, 380), st.floats(-380, 380), st.floats(-200, 450), st.floats(-2, 2))


@given(st.lists(poses, min_size=1, max_size=5))
@settings(max_examples=40, deadline=None)
def test_the_arm_is_at_the_pose_or_stays_where_it_was_legal(asked):
    panel = test_the_arm_is_at_the_pose_or_stays_where_it_was_legal.panel
    for pose in asked:
        before = panel.view.q
        panel.pose = pose
        legal = any(s.legal for s in omx.ik(pose))
        assert (panel.message == "") is legal
        if legal:
            np.testing.assert_allclose(omx.fk(panel.view.q)[:3, 3], pose[:3], atol=1e-6)
        else:
            assert panel.view.q == before
        panel.view.geometry.chain.check(panel.view.q)


test_the_arm_is_at_the_pose_or_stays_where_it_was_legal.panel = PosePanel()


def test_out_of_reach_says_how_much_is_missing():
    panel = PosePanel()
    panel.pose = (600, 0, 204, 0)
    with pytest.raises(omx.Unreachable) as caught:
        omx.solve_ik((600, 0, 204, 0))
    assert f"{caught.value.missing:.3f} mm are missing" in panel.message
    panel.branch = "front, elbow up"
    assert f"{caught.value.missing:.3f} mm are missing" in panel.message
    assert panel.message.startswith("The arm stays.")
    assert panel.message in text_of(panel._notice)
    assert text_of(panel._text).count("out of reach") == 4


def test_a_broken_limit_is_named_with_its_excess():
    panel = PosePanel()
    panel.pose = (60, 0, 10, 0)
    assert re.search(r"q\d = -?\d+\.\d\d deg is \d+\.\d\d deg (above|below) its limit", panel.message)
    assert panel.view.q == omx.HOME


def test_each_branch_has_its_ghost_and_its_verdict():
    panel = PosePanel()
    panel.pose = (60, 0, 300, 0.6)
    solutions = panel.solutions
    chosen = omx.solve_ik(panel.pose, omx.HOME)
    assert panel.view.q == chosen.q
    for k, solution in enumerate(solutions):
        if solution.reachable and solution.branch != chosen.branch:
            T = placed(panel.view.channel, f"/meshcat/ghosts/{k}/4")
            np.testing.assert_allclose(T, omx.fk(solution.q), atol=1e-9)
    panel._write()
    table = text_of(panel._text)
    for solution in solutions:
        assert solution.branch in table
        assert tables.verdict(solution) in table


def test_a_branch_can_be_kept():
    panel = PosePanel()
    panel.pose = (20, 0, 330, 0.4)
    others = [s for s in panel.solutions if s.legal and s.q != panel.view.q]
    assert others, "this pose has two legal branches"
    panel.branch = others[0].branch
    np.testing.assert_allclose(panel.view.q, others[0].q)
    panel.branch = "front, elbow down"
    assert "front, elbow down" in panel.message
    np.testing.assert_allclose(panel.view.q, others[0].q)


def test_setting_q_asks_for_its_pose():
    panel = PosePanel()
    panel.q = (0.3, -0.4, 0.2, 0.5)
    assert panel.pose == pytest.approx(omx.pose((0.3, -0.4, 0.2, 0.5)))
    assert panel.view.q == (0.3, -0.4, 0.2, 0.5)
    assert panel.sliders[0].value == pytest.approx(panel.pose[0])


def test_a_wrong_pose_is_refused():
    panel = PosePanel()
    before = panel.pose
    for wrong in ((1, 2, 3), (1, 2, 3, math.nan)):
        with pytest.raises(omx.BadInput):
            panel.pose = wrong
    assert panel.pose == before


# ---- the tool, dragged in the scene -----------------------------------------------------------------------


def drag(view, pose):
    """What a page says when the reader drags the tool to `pose`."""
    try:
        q = list(omx.solve_ik(pose, view.q).q)
    except omx.OmxError:
        q = None
    view.widget._on_message(None, {"event": "dragged", "pose": list(pose), "q": q}, [])
    return q


REACHED, BEYOND = (200.0, 60.0, 150.0, -0.4), (500.0, 0.0, 150.0, 0.0)


@pytest.mark.parametrize("kind", [View, JointPanel, PosePanel])
def test_a_dragged_tool_moves_view_and_sliders(kind):
    shown = kind()
    view = getattr(shown, "view", shown)
    q = drag(view, REACHED)
    assert view.q == pytest.approx(q)
    if kind is JointPanel:
        assert [s.value for s in shown.sliders] == pytest.approx(np.degrees(q))
    if kind is PosePanel:
        assert shown.pose == pytest.approx(REACHED)
        assert [s.value for s in shown.sliders][:3] == list(REACHED[:3])
    drag(view, BEYOND)
    assert view.q == pytest.approx(q), "the arm stays"
    if kind is PosePanel:
        assert "out of reach" in shown.message


def test_where_commands_are_a_ghost_it_alone_is_dragged():
    """A robot's solid arm stands where the robot is: the page is told."""
    panel = JointPanel()
    before = panel.view.q
    panel.command_a_ghost()
    told = decoded(panel.view.channel)[("set_property", "/meshcat/arm", "follows")]
    assert told["value"] is False
    q = drag(panel.view, REACHED)
    assert panel.q == pytest.approx(q)
    assert panel.view.q == before


# ---- what a cell shows ---------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", [JointPanel, PosePanel])
def test_the_text_of_a_panel_is_a_sentence_and_always_the_same(kind):
    assert repr(kind()) == repr(kind()) == f"{kind.__name__}: {View()!r}"


@pytest.mark.parametrize("kind", [JointPanel, PosePanel])
def test_a_panel_shows_a_widget_or_data(kind, monkeypatch):
    panel = kind()
    data = panel._repr_mimebundle_()
    assert data["application/vnd.jupyter.widget-view+json"]["model_id"] == panel.model_id
    monkeypatch.setenv("OMX_VIEW", "data")
    told = json.loads(json.dumps(kind()._repr_mimebundle_()[SCENE], allow_nan=False))
    assert told["panel"].keys() >= {"kind", "q"}
    assert told["log"]


def test_numbers_are_written_without_minus_zero():
    assert tables.number(-0.0001, 1) == "0.0"
    assert tables.number(-1.26, 1) == "\u22121.3"
    assert "&lt;b&gt;" in tables.notice("<b>")


# ---- the formula beside the picture ------------------------------------------------------------------------------


@given(st.tuples(*(st.floats(low, high) for low, high in omx.LIMITS)))
@settings(max_examples=30, deadline=None)
def test_the_terms_of_r_and_z_are_those_of_the_chapter_and_add_up(q):
    q1, q2, q3, q4 = q
    lengths = omx.COURSE
    shares = tables.term_values(omx.frames(q))
    q23, q234, lean = q2 + q3, q2 + q3 + q4, q2 + lengths.delta
    assert shares["r"] == pytest.approx(
        [0, lengths.L2 * math.sin(lean), lengths.L3 * math.cos(q23), lengths.L4 * math.cos(q234)], abs=1e-9
    )
    assert shares["z"] == pytest.approx(
        [lengths.L1, lengths.L2 * math.cos(lean), -lengths.L3 * math.sin(q23), -lengths.L4 * math.sin(q234)], abs=1e-9
    )
    x, y, z, _ = omx.pose(q)
    assert sum(shares["r"]) == pytest.approx(x * math.cos(q1) + y * math.sin(q1), abs=1e-9)
    assert sum(shares["z"]) == pytest.approx(z, abs=1e-9)


@pytest.mark.parametrize("times", [1, 2])
def test_a_slider_changes_the_terms_and_a_row_shows_its_frame_beside_those_of_the_reader(times):
    view = View()
    view.frames(0)
    for _ in range(times):
        panel = JointPanel(view, terms=True)
    before = text_of(panel._text)
    panel.sliders[3].value = -30
    after = text_of(panel._text)
    assert "L4 cos(q2 + q3 + q4)" in after
    assert [a == b for a, b in zip(before.split("="), after.split("="), strict=False)].count(False) >= 2

    def seen():
        commands = decoded(view.channel)
        return [i for i in range(5) if commands["set_property", f"/meshcat/frames/{i}", "visible"]["value"]]

    for lit, frames in ((3, [0, 3]), (0, [0])):
        panel._terms.lit = lit
        assert seen() == frames
    assert objects(view.channel, "/meshcat/frames") == {f"/meshcat/frames/{i}" for i in range(5)}, "a page shows them"


def test_the_line_along_a_link_ends_where_its_joints_are():
    """Bones ride on their links: seen from frame i, from its origin back to that of frame i - 1."""
    view = View()
    view.bones()
    for q in (omx.HOME, (0.7, 0.3, -0.4, 0.2)):
        frames = omx.frames(q)
        for i, row in enumerate(view.chain.rows, 1):
            back = np.linalg.inv(frames[i]) @ frames[i - 1][:, 3]
            corner = np.array((-row.a, -row.d * math.sin(row.alpha), -row.d * math.cos(row.alpha)))
            assert back[:3] == pytest.approx(corner, abs=1e-9)
    assert [path for kind, path, _ in view.channel.log if path.endswith("/bone")] == [
        f"/meshcat/arm/{i}/bone" for i in range(1, 5)
    ]


def test_terms_are_for_our_arm_alone():
    with pytest.raises(omx.errors.BadInput, match="another chain"):
        JointPanel(View.of_chain(SLIDER), terms=True)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: View(geometry=omx.COURSE.chain), "is shown by View.of_chain"),
        (lambda: View(geometry="course"), "must be a Geometry"),
        (lambda: View.of_chain(omx.COURSE), "`chain` must be an omx.Chain"),
        (lambda: JointPanel(omx.COURSE.chain), "`view` must be a View"),
        (lambda: PosePanel(omx.COURSE.chain), "`view` must be a View"),
        (lambda: PosePanel(View.of_chain(omx.Chain([(0, 1, 2, 0)]))), "shows this book's arm"),
    ],
)
def test_an_arm_where_a_view_is_wanted_is_refused_by_name(make, said):
    with pytest.raises(omx.BadInput, match=said):
        make()
