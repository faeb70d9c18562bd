"""A live figure shows in the page what Python computes, for positions all over its sliders."""

import json
import math
import re

import numpy as np
import pytest

import omx
from omx.analysis.accuracy import tip_error
from omx.display.panels import LiveFigure, live_figure
from omx.display.viewer.scene import SCENE
from omx.hardware.dynamixel import packet as pk
from omx.hardware.dynamixel import units
from omx.motion import differential_ik, joint_move, line
from tests.helpers.javascript import in_node

RNG = np.random.default_rng(7)
SCRIPT = (live_figure._HERE / "figures.js").read_text(encoding="utf-8")


def shown(figure, positions):
    """What a LiveFigure shows for each of the positions of its sliders."""
    data = f"{SCRIPT}\nconst data = {json.dumps(figure.data['data'])};"
    return in_node(f"window.OMX_FIGURES.{figure.data['figure']}(a, data)", positions, data)


def lines(seen):
    """The lines of a figure by their labels, (N, 2) each."""
    return {one.get("label"): np.array(one["points"], float) for one in seen["lines"]}


def numbers(sentence):
    return [float(word) for word in re.findall(r"-?\d+(?:\.\d+)?", sentence.replace("\u2212", "-"))]


def test_the_bytes_of_an_answer_are_the_buss():
    figure = LiveFigure(
        "answer", {"servo": (11, 14, 11), "speed": (-20, 20, -1), "position": (0, 4095, 2045)}, "The answer",
        header=pk.HEADER, status=pk.Instruction.STATUS, divisor=0x18005, tick=360 / 4096, zero=2048,
        speed_unit=math.degrees(units.VELOCITY.scale),
    )  # fmt: skip
    anywhere = RNG.integers((11, -20, 0), (15, 21, 4096), (60, 3)).tolist()
    positions = [[11, -1, 2045], [12, -1, 0xFD], [13, 0, 0], *anywhere]
    for (servo, speed, position), seen in zip(positions, shown(figure, positions), strict=True):
        data = speed.to_bytes(4, "little", signed=True) + position.to_bytes(4, "little")
        assert bytes(one["byte"] for one in seen["bytes"]) == pk.build_status(servo, 0, data)
        extra = len(pk.stuff(bytes((pk.Instruction.STATUS, 0)) + data)) - 10
        assert sum(one["name"] == "stuffed" for one in seen["bytes"]) == extra
        told = numbers(seen["says"][0])
        assert told[1] == pytest.approx(math.degrees(units.VELOCITY.value(speed)), abs=0.051)
        assert told[2] == pytest.approx(math.degrees(units.POSITION.value(position)), abs=0.0051)


WAYPOINTS = np.array([[25, -100, 150, -60], [150, 80, 300, 0], [250, -115, 75, -45], [25, -100, 150, -60]], float)


def test_a_log_shows_where_the_tool_was_and_was_sent():
    plan = [omx.HOME]
    for pose in WAYPOINTS:
        plan.append(omx.solve_ik([*pose[:3], math.radians(pose[3])], start=plan[-1]).q)
    plan = np.degrees(plan[1:])
    t = np.linspace(0, 18, 91)
    side = np.minimum(t // 6, 2).astype(int)
    measured = np.array([plan[k] + (s / 6 - k) * (plan[k + 1] - plan[k]) for k, s in zip(side, t, strict=True)])
    commanded = plan[side + 1]
    figure = LiveFigure("log", {"time (s)": (0, 18, 4, 0.1)}, "The log", t=t, measured=measured,
                        commanded=commanded, corners=WAYPOINTS[:, :3], starts=[0, 6, 12])  # fmt: skip
    moments = [0, 3.05, 6, 9.9, 17.7, 18]
    tools = np.array(omx.pose(np.radians(measured)))[:, :3]
    for moment, seen in zip(moments, shown(figure, [[m] for m in moments]), strict=True):
        at = int(np.searchsorted(t, moment + 1e-9) - 1)
        way = seen["lines"][1]["points"] + seen["lines"][2]["points"][1:]
        np.testing.assert_allclose(way, tools[:, :2], atol=1e-3)
        sent, here = (np.array(dot["points"][0]) for dot in seen["dots"])
        wanted = omx.pose(np.radians(commanded[at]))[:3]
        np.testing.assert_allclose(here, tools[at, :2], atol=1e-3)
        np.testing.assert_allclose(sent, wanted[:2], atol=1e-3)
        a, b = WAYPOINTS[side[at], :3], WAYPOINTS[side[at] + 1, :3]
        beside = np.linalg.norm(np.cross(tools[at] - a, b - a)) / np.linalg.norm(b - a)
        off = np.abs(measured[at] - commanded[at])
        _, away, joint, lacks = numbers(seen["says"][0])
        assert away == pytest.approx(np.linalg.norm(tools[at] - wanted), abs=0.051)
        assert lacks == pytest.approx(off.max(), abs=0.0051)
        assert off[int(joint) - 1] == pytest.approx(off.max(), abs=1e-6)
        assert numbers(seen["says"][1])[0] == pytest.approx(beside, abs=0.051)


def evenly(u):
    """A scaling: the way grows as the time does."""
    return u, 1 + 0 * u, 0 * u


def way_of(start, pose):
    """Why the straight line ends early, or None; its poses."""
    try:
        return None, line(start, pose, 1.0, scaling=evenly).poses()
    except omx.PathBlocked as stop:
        return stop, None


def test_both_ways_are_those_of_the_trajectories():
    start = omx.solve_ik([25, -100, 150, math.radians(-60)]).q
    figure = LiveFigure("ways", {"x (mm)": (60, 250, 150), "y (mm)": (-180, 180, 80), "z (mm)": (50, 350, 300)},
                        "Two ways", start=start, pitch=0)  # fmt: skip
    goals = [[150, 80, 300], *RNG.uniform((60, -180, 50), (250, 180, 350), (25, 3)).round().tolist(), [250, 180, 350]]
    driven = 0
    for goal, seen in zip(goals, shown(figure, goals), strict=True):
        drawn = lines(seen)
        try:
            end = omx.solve_ik([*goal, 0], start=start).q
        except omx.OmxError:
            assert len(drawn["straight in joint space"]) == 0
            assert seen["says"][0].startswith("No joint move")
            continue
        bent = np.array(joint_move(start, end, 1.0, scaling=evenly).poses())[:, :3]
        np.testing.assert_allclose(drawn["straight in joint space"], bent[:, :2], atol=1e-3)
        way = bent[-1] - bent[0]
        bulge = np.linalg.norm(np.cross(bent - bent[0], way), axis=1).max() / np.linalg.norm(way)
        assert numbers(seen["says"][0])[0] == pytest.approx(bulge, abs=0.051)
        stop, straight = way_of(start, [*goal, 0])
        if stop:
            assert numbers(seen["says"][1])[0] == pytest.approx(100 * stop.fraction, abs=1.6)
            continue
        driven += 1
        np.testing.assert_allclose(drawn["straight in space"], straight[:, :2], atol=1e-3)
        assert numbers(seen["says"][1])[0] == pytest.approx(np.hypot(*straight[:, :2].T).min(), abs=0.51)
    assert driven > 10


def test_the_cloud_is_drawn_from_the_forward_kinematics_and_its_rim_from_the_jacobian():
    draws = RNG.standard_normal((200, 4))
    figure = LiveFigure("cloud", {"sigma (deg)": (0.05, 1, 0.5, 0.05), "q2": (-90, 90, 0), "q3": (-80, 80, 0)}, "Tips",
                        draws=draws)  # fmt: skip
    positions = [[0.5, 0, 0], [1, -40, 60], [0.05, 60, -79], [0.3, 34, -79.39]]
    for (sigma, q2, q3), seen in zip(positions, shown(figure, positions), strict=True):
        q = np.radians([0, q2, q3, 0])
        off = np.array(omx.pose(q + math.radians(sigma) * draws))[:, :3] - omx.pose(q)[:3]
        np.testing.assert_allclose(seen["dots"][0]["points"], off[:, [0, 2]], atol=1e-6)
        drawn, formula = numbers(seen["says"][0])
        assert drawn == pytest.approx(np.sqrt((off**2).sum(axis=1).mean()), abs=0.0051)
        sigmas = dict.fromkeys(("o1", "o2", "o3", "o4"), math.radians(sigma))
        assert formula == pytest.approx(tip_error(q, sigmas), abs=0.0051)
        J = omx.jacobian(q)[[0, 2]] * math.radians(sigma)
        rim = np.array(seen["lines"][0]["points"])
        covariance = J @ J.T  # a rim of two sigma: x (J J^T)^-1 x = 4
        np.testing.assert_allclose((rim.T * np.linalg.solve(covariance, rim.T)).sum(axis=0), 4, rtol=1e-6)


def test_damping_is_that_of_the_module():
    straight = np.array([0.0, 0.6, omx.COURSE.delta - math.pi / 2, 0.4])
    lean = straight[1] + omx.COURSE.delta
    outward = 30 * np.array([math.sin(lean), 0, math.cos(lean), 0])

    def bent(gap):
        return straight + np.radians([0, 0, gap, 0])

    figure = LiveFigure(
        "damping", {"from straight (deg)": (-40, 40, 3, 0.5), "damping (mm)": (0, 30, 10)}, "Speeds",
        straight=straight, outward=outward, radian_mm=differential_ik.RADIAN_MM, limit_deg=275,
    )  # fmt: skip
    positions = [[3, 10], [30, 0], [-12.5, 4], [0, 10], [0.5, 30], [0, 0]]
    for (gap, damping), seen in zip(positions, shown(figure, positions), strict=True):
        q = bent(gap)
        if not gap and not damping:
            assert "does not exist" in seen["says"][0]
            continue
        qd = differential_ik.joint_velocity(q, outward, damping=damping)
        got = differential_ik.task_jacobian(q) @ qd
        assert numbers(seen["says"][0])[1] == pytest.approx(math.degrees(np.abs(qd).max()), abs=0.051)
        assert numbers(seen["says"][1])[0] == pytest.approx(got @ outward / 30, abs=0.051)
        assert numbers(seen["says"][1])[2] == pytest.approx(math.degrees(got[3]), abs=0.051)
        curve = lines(seen)[f"damping {damping:.1f} mm"]
        ours = [differential_ik.joint_velocity(bent(g), outward, damping=damping) for g in curve[:, 0]]
        np.testing.assert_allclose(curve[:, 1], np.degrees(np.abs(ours).max(axis=1)), rtol=1e-4)


def test_a_figure_says_what_it_cannot_be():
    with pytest.raises(omx.BadInput, match="answer, log, ways, cloud, damping"):
        LiveFigure("clouds", {}, "Tips")
    with pytest.raises(omx.BadInput, match="must start between 0 and 30"):
        LiveFigure("damping", {"damping (mm)": (0, 30, 40)}, "Speeds")


def test_a_figure_is_a_widget_and_a_mark_with_its_words_for_the_site(monkeypatch):
    figure = LiveFigure("cloud", {"sigma (deg)": (0, 1, 0.5, 0.05)}, "Tips", draws=[[0, 0, 0, 0.5]])
    assert repr(figure) == "Live figure: Tips; sigma 0.5 °"
    assert "application/vnd.jupyter.widget-view+json" in figure._repr_mimebundle_()
    monkeypatch.setenv("OMX_VIEW", "data")
    assert figure._repr_mimebundle_()[SCENE] == {"title": repr(figure), "panel": figure.data}
