"""The panel of a six-joint arm's hand: all branches shown, one taken, and why none can be."""

import html
import math
import re

import numpy as np
import pytest

from omx import BadInput, Chain, HandPanel, JointLimit
from omx.analysis import Inverse
from omx.derive import write_inverse
from tests.helpers.scenes import decoded
from tests.helpers.six_joint_arms import ARMS

Q = np.array([0.4, 0.5, 220.0, 0.5, 0.3, -0.8])
LIMITS = [(-math.pi, math.pi), (-math.pi / 2, math.pi / 2), (100, 300), *[(-math.pi, math.pi)] * 3]


@pytest.fixture(scope="module")
def inverse(tmp_path_factory):
    rows = ARMS["Stanford"].rows
    module = write_inverse("panelled", Chain(rows), folder=tmp_path_factory.mktemp("panel"))
    return Inverse(Chain(rows, LIMITS, name="Stanford"), module)


@pytest.fixture
def panel(inverse):
    return HandPanel(inverse, Q)


def said(panel):
    return [
        html.unescape(re.sub(r"<[^>]*>", " ", box.value)).replace("\u2212", "-") for box in (panel._text, panel._notice)
    ]


def test_it_begins_where_the_arm_is_and_shows_every_branch(panel, inverse):
    np.testing.assert_allclose(panel.q, Q)
    np.testing.assert_allclose(panel.target, inverse.chain.fk(Q))
    table, notice = said(panel)
    assert all(branch in table for branch in inverse.branches)
    assert table.count("22.9, 28.6, 220.0, 28.6, 17.2, -45.8") == 1, "every joint, and a slide in mm"
    assert notice.strip() == ""
    assert len(panel.solutions) == 8


def test_a_slider_moves_the_hand_and_the_arm_takes_the_nearest_legal_branch(panel, inverse):
    height = panel.sliders[2].value
    panel.sliders[2].value = height + 30
    assert panel.target[2, 3] == pytest.approx(height + 30)
    np.testing.assert_allclose(inverse.chain.fk(panel.q), panel.target, atol=1e-9)
    assert panel.view.q == pytest.approx(panel.q)
    legal = [s for s in panel.solutions if s.legal]
    assert min(np.abs(np.subtract(s.q, panel.q)).max() for s in legal) < 1e-12
    assert np.abs(np.subtract(panel.q, Q))[[0, 1, 3, 4, 5]].max() < 0.5


def test_a_branch_can_be_kept_to_and_says_why_it_cannot_be_had(panel, inverse):
    panel.branch = "front, out, flip"
    assert panel.q[4] == pytest.approx(-0.3)
    np.testing.assert_allclose(inverse.chain.fk(panel.q), panel.target, atol=1e-9)
    before = panel.q
    panel.branch = "front, in, flip"
    assert panel.q == before
    assert panel.message.startswith("The arm stays. With front, in, flip: q2 = -151.35 deg is 61.35 deg below")


def test_out_of_reach_the_arm_stays_and_comes_back(panel):
    before, T = panel.q, panel.target.copy()
    inside = np.eye(4)
    inside[:3, 3] = 10, 0, 300
    panel.target = inside
    assert panel.q == before
    assert "No branch is legal. Nearest is front, out, no flip: out of reach, 90.0 mm missing." in said(panel)[1]
    panel.target = T
    np.testing.assert_allclose(panel.q, Q, atol=1e-9)


def test_what_is_free_is_told(panel):
    straight = Q * [1, 1, 1, 1, 0, 1]
    panel.q = straight
    np.testing.assert_allclose(panel.q, straight)
    assert "only q4 + q6 = -17.19 deg is fixed" in said(panel)[1]


def test_wrong_arguments_are_refused(inverse, panel):
    with pytest.raises(BadInput, match="of six joints"):
        HandPanel(None, Q)
    with pytest.raises(JointLimit, match="d3"):
        panel.q = Q * [1, 1, 2, 1, 1, 1]
    with pytest.raises(BadInput, match="no pose"):
        panel.target = np.zeros((4, 4))
    assert repr(panel).startswith("HandPanel: ")


def test_a_dragged_hand_asks_for_its_pose_and_a_pulled_link_says_where_the_joints_are(panel, inverse):
    """What the page sends: a target by the handle, or no target, and the joint values of a pull."""
    hear = panel.view.widget._on_message
    T = inverse.chain.fk(Q * 1.05)
    hear(None, {"event": "dragged", "pose": T.tolist(), "q": (Q * 1.05).tolist()}, [])
    np.testing.assert_allclose(panel.target, T)
    np.testing.assert_allclose(panel.q, Q * 1.05, atol=1e-9)
    panel.branch = "front, out, flip"
    pulled = Q * 0.95
    hear(None, {"event": "dragged", "pose": None, "q": pulled.tolist()}, [])
    np.testing.assert_allclose(panel.q, pulled)
    np.testing.assert_allclose(panel.target, inverse.chain.fk(pulled))
    assert panel.branch == "nearest"
    assert panel.sliders[0].value == pytest.approx(panel.target[0, 3])


def test_the_scene_knows_the_generated_inverse_and_the_branch_that_is_kept(panel, inverse):
    about = panel.view._config()["arm"]
    assert about["handle"] is True
    assert about["branches"] == list(inverse.branches)
    assert len(about["colours"]["branches"]) == 8
    assert "function branches(" in about["inverse"]
    assert "export" not in about["inverse"]
    panel.branch = "front, out, flip"
    kept = decoded(panel.view.channel)[("set_property", "/meshcat/arm", "branch")]
    assert kept["value"] == "front, out, flip"
    told = panel.page_data()["panel"]
    assert told["kind"] == "pose"
    assert ["roll", "deg", -180] in [[*row[:3]] for row in told["sliders"]]
