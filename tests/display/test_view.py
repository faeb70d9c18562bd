"""The view: what is drawn stands where `omx.frames` says, comes and goes, and never floods the page."""

import math
import os
import subprocess
import sys
import textwrap

import numpy as np
import pytest
import umsgpack
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib import font_manager
from PIL import ImageFont

import omx
from omx.display.viewer import Camera, View, commands, threejs
from omx.display.viewer.annotations import rgb
from omx.hardware.simulator import cube, cup
from tests.helpers.scenes import Page, decoded, objects, placed

angles = st.floats(-math.pi, math.pi)
joints = st.tuples(angles, angles, angles, angles)
PRISMATIC = omx.Chain(
    [omx.DHRow(0, 100, 0, -math.pi / 2), omx.DHRow(0, 50, 0, math.pi / 2), omx.DHRow(0.3, 20, 10, 0.4, prismatic=True)],
    limits=[(-3, 3), (-3, 3), (0, 80)],
    name="a slider",
)


@pytest.fixture
def view():
    return View()


# ---- poses ---------------------------------------------------------------------------------------------


@given(joints)
@settings(max_examples=50, deadline=None)
def test_nodes_stand_where_omx_frames_says(q):
    view = test_nodes_stand_where_omx_frames_says.view
    view.q = q
    for i, T in enumerate(omx.frames(q)):
        np.testing.assert_allclose(placed(view.channel, f"/meshcat/arm/{i}"), T, atol=1e-9)


test_nodes_stand_where_omx_frames_says.view = View()


@pytest.mark.parametrize("geometry", [omx.MAKER, omx.COURSE.replace(L2=200.0)], ids=["maker", "long"])
def test_nodes_follow_the_geometry(geometry):
    view = View((0.3, -0.4, 0.5, 0.6), geometry=geometry)
    for i, T in enumerate(omx.frames(view.q, geometry)):
        np.testing.assert_allclose(placed(view.channel, f"/meshcat/arm/{i}"), T, atol=1e-9)


TURNED = np.array([[0.0, -1, 0, -12], [1, 0, 0, 5], [0, 0, 1, 40], [0, 0, 0, 1]])
FIXED = omx.Chain(PRISMATIC.rows, PRISMATIC.limits, base=TURNED, tool=np.linalg.inv(TURNED))


@pytest.mark.parametrize("chain", [PRISMATIC, FIXED], ids=["rows", "base and tool"])
@given(st.lists(st.floats(-3, 3), min_size=3, max_size=3))
@settings(max_examples=50, deadline=None)
def test_nodes_of_any_chain_stand_where_its_frames_are(chain, q):
    q[2] *= 30
    view = View.of_chain(chain, q)
    for i, T in enumerate(chain.frames(q)):
        np.testing.assert_allclose(placed(view.channel, f"/meshcat/arm/{i}"), T, atol=1e-9)


def test_a_pose_is_one_message_however_much_is_shown(view):
    view.frames(0, 1, 2, 3, 4)
    view.section([(0, 0), (100, 0), (100, 100)])
    page = Page(view.channel)
    view.q = (0.1, 0.2, 0.3, 0.4)
    assert len(page.messages) == 2
    assert len(page.messages[-1]["keys"]) == 5 + 5 + 1


def test_the_last_of_many_poses_is_shown(view):
    page = Page(view.channel)
    for k in range(500):
        view.q = (0.001 * k, 0, 0, 0)
    view.channel.flush()
    matrix = umsgpack.unpackb(page.state["set_transform", "/meshcat/arm/4", ""])["matrix"]
    np.testing.assert_allclose(1e3 * np.array(matrix[12:15]), omx.fk((0.499, 0, 0, 0))[:3, 3], atol=1e-9)


@pytest.mark.parametrize("q", [(1, 2, 3), (1, 2, 3, math.nan), "left", None, 7, [[0, 0, 0, 0]]])
def test_a_wrong_q_is_refused_and_the_arm_stays(view, q):
    with pytest.raises(omx.BadInput, match="4 finite joint values in rad"):
        view.q = q
    assert view.q == omx.HOME


def test_q_takes_what_omx_gives(view):
    solution = omx.solve_ik([200, 0, 200, 0])
    view.q = solution
    assert view.q == solution.q
    view.q = np.array([0, 0.1, 0.2, 0.3])
    assert view.q == (0, 0.1, 0.2, 0.3)
    assert all(type(v) is float for v in view.q)


# ---- what is added, and removed ------------------------------------------------------------------------


def test_frames_come_and_go(view):
    view.frames(0, 2, 4)
    assert objects(view.channel, "/meshcat/frames") == {f"/meshcat/frames/{i}" for i in (0, 2, 4)}
    view.q = (0.5, 0, 0, 0)
    np.testing.assert_allclose(placed(view.channel, "/meshcat/frames/4"), omx.fk(view.q), atol=1e-9)
    view.frames()
    assert objects(view.channel, "/meshcat/frames") == set()
    with pytest.raises(omx.BadInput, match="frames 0 to 4"):
        view.frames(5)


def test_frames_are_labelled(view):
    view.frames(3)
    images = decoded(view.channel)["set_object", "/meshcat/frames/3", ""]["object"]["images"]
    assert len(images) == 4, "x, y, z and the frame's own name"
    assert all(image["url"].startswith("data:image/svg+xml;base64,") for image in images)


def test_a_label_has_room_for_every_letter():
    font = ImageFont.truetype(font_manager.findfont(font_manager.FontProperties(family="DejaVu Sans", weight=700)), 46)
    for letter in (chr(code) for code in (*range(0x20, 0x7F), *range(0x391, 0x3CA)) if chr(code) not in "_\u03a2"):
        assert font.getlength(letter) - 1 <= threejs.LETTER, letter
    _, ratio = threejs._svg("gamma", "#000000")
    assert 64 * ratio > font.getlength("gamma") + 14, "with its halo"


def shown_ghosts(view):
    commands = decoded(view.channel)
    roots = {path.split("/")[3] for path in objects(view.channel, "/meshcat/ghosts/")}
    return {
        int(k)
        for k in roots
        if commands.get(("set_property", f"/meshcat/ghosts/{k}", "visible"), {"value": True})["value"]
    }


def test_ghosts_come_move_and_go(view):
    qs = [(0, 0, 0, 0), None, (0.5, 0, 0, 0)]
    view.ghosts(qs)
    assert shown_ghosts(view) == {0, 2}
    np.testing.assert_allclose(placed(view.channel, "/meshcat/ghosts/2/4"), omx.fk(qs[2]), atol=1e-9)
    view.ghosts([(0.1, 0, 0, 0)])
    assert shown_ghosts(view) == {0}
    np.testing.assert_allclose(placed(view.channel, "/meshcat/ghosts/0/4"), omx.fk((0.1, 0, 0, 0)), atol=1e-9)
    view.ghosts([])
    assert objects(view.channel, "/meshcat/ghosts") == set()


def test_moving_ghosts_sends_no_objects_again(view):
    view.ghosts([(0, 0, 0, 0)] * 4)
    page = Page(view.channel)
    view.ghosts([(0.1, 0, 0, 0)] * 4)
    view.channel.flush()
    assert {kind for message in page.messages[1:] for kind, _, _ in message["keys"]} == {"set_transform"}


def test_ghosts_take_the_branches_of_ik(view):
    view.ghosts(omx.ik([300, 0, 100, 0]))
    assert shown_ghosts(view) == {k for k, s in enumerate(omx.ik([300, 0, 100, 0])) if s.reachable}
    view.ghosts(omx.ik([600, 0, 100, 0]))
    assert shown_ghosts(view) == set()


def test_a_target_is_where_the_tool_would_be(view):
    q = (0.4, -0.2, 0.3, 0.5)
    view.target(omx.pose(q))
    np.testing.assert_allclose(placed(view.channel, "/meshcat/notes/target"), omx.fk(q), atol=1e-6)
    view.target(omx.fk(omx.HOME))
    np.testing.assert_allclose(placed(view.channel, "/meshcat/notes/target"), omx.fk(omx.HOME), atol=1e-9)
    view.target(None)
    assert objects(view.channel, "/meshcat/notes") == set()
    with pytest.raises(omx.BadInput):
        view.target([1, 2, 3])


def test_the_trail_follows_the_tool_and_can_be_removed(view):
    view.trail()
    assert objects(view.channel, "/meshcat/trail") == set(), "one point makes no line"
    for k in range(100):
        view.q = (0.02 * k, -0.5, 0.2, 0.3)
    assert len(objects(view.channel, "/meshcat/trail")) > 3
    view.trail(False)
    view.q = omx.ZERO
    assert objects(view.channel, "/meshcat/trail") == set()


def test_a_trail_grows_only_as_the_tool_moves(view):
    view.trail()
    view.q = (0.2, 0, 0, 0)
    before = view.channel.log
    for _ in range(50):
        view.q = (0.2, 0, 0, 0)
    assert view.channel.log == before


def test_the_section_turns_with_joint_1(view):
    view.q = (math.pi / 2, 0, 0, 0)
    view.section([(0, 0), (300, 0), (300, 200)], ([(0, 0), (9, 0), (9, 9)], [[(1, 1), (2, 1), (2, 2)]]))
    plane = placed(view.channel, "/meshcat/section")
    np.testing.assert_allclose(plane @ [300, 200, 0, 1], [0, 300, 200, 1], atol=1e-9)
    view.q = (0, 0, 0, 0)
    np.testing.assert_allclose(placed(view.channel, "/meshcat/section") @ [300, 200, 0, 1], [300, 0, 200, 1], atol=1e-9)
    view.section()
    assert objects(view.channel, "/meshcat/section") == set()


def test_the_camera_steps_back_for_a_tall_section(view):
    near = view._config()["cameras"]["side"]
    view.section([(0, 0), (300, 0), (300, 300)])
    assert view._config()["cameras"]["side"] == near
    view.section([(-370, -190), (380, -190), (0, 460)])
    place = view._config()["cameras"]["side"]
    away = np.linalg.norm(np.subtract(place["position"], place["target"]))
    half = np.radians(28 / 2)
    assert place["target"][1] == pytest.approx(0.135)
    assert away * np.tan(half) >= 1.05 * 0.325


def test_marks_come_and_go_by_name(view):
    view.arrow("d", (0, 0, 0), (0, 0, 77), label="d_1")
    view.arc("t", (0, 0, 0), (40, 0, 0), (0, 40, 0), label="\u03b8_1")
    view.axis("turn", (0, 0, 77), (0, 1, 0), label="S_2")
    view.triad("f", omx.fk(omx.ZERO), index=4)
    view.label("w", "tool", (100, 0, 0))
    view.path([(0, 0, 0), (10, 0, 0), (10, 10, 0)], name="way")
    names = {"d", "t", "turn", "f", "w", "way"}
    assert objects(view.channel, "/meshcat/notes") == {f"/meshcat/notes/{name}" for name in names}
    view.remove("d")
    view.remove("never there")
    assert objects(view.channel, "/meshcat/notes") == {f"/meshcat/notes/{name}" for name in names - {"d"}}


@pytest.mark.parametrize(
    "wrong",
    [
        lambda v: v.path([(0, 0, 0)]),
        lambda v: v.path([(0, 0), (1, 1)]),
        lambda v: v.arrow("a", (0, 0), (1, 0, 0)),
        lambda v: v.axis("a", (0, 0, 0), (0, 0, 0)),
        lambda v: v.triad("t", np.eye(3)),
        lambda v: v.label("a/b", "word", (0, 0, 0)),
        lambda v: v.label(5, "word", (0, 0, 0)),
        lambda v: v.label("nan", "word", (0, 0, math.nan)),
        lambda v: v.animate([omx.HOME]),
        *(lambda v, s=s: v.animate([omx.HOME, omx.ZERO], seconds=s) for s in (-1, 0, math.inf, math.nan, 1e9)),
        lambda v: v.animate([omx.HOME, omx.ZERO], gripper=[0, math.nan]),
        lambda v: v.arrow("a", (0, 0, 0), (1, 0, 0), radius=math.nan),
        lambda v: v.axis("a", (0, 0, 0), (1, 0, 0), length=math.nan),
        lambda v: v.arc("a", (0, 0, 0), (0, 0, 0), (1, 0, 0)),
        lambda v: v.triad("t", np.eye(4), size=-1),
        lambda v: v.path([(0, 0, 0), (1, 1, 1)], radius=math.inf),
        *(lambda v, g=g: setattr(v, "gripper", g) for g in (math.nan, 1e30)),
        *(lambda v, o=o: setattr(v, "opacity", o) for o in (math.inf, -5)),
        *(lambda v, h=h: View(height=h) for h in ("x", math.nan, -3)),
    ],
)
def test_wrong_arguments_are_named(view, wrong):
    before = view.channel.log
    with pytest.raises(omx.BadInput, match=r"must|shape"):
        wrong(view)
    assert view.channel.log == before


def test_an_arrow_of_no_length_is_none(view):
    view.arrow("v", (0, 0, 0), (0, 0, 50))
    view.arrow("v", (0, 0, 0), (0, 0, 0))
    assert objects(view.channel, "/meshcat/notes") == set()


def test_the_gripper_opens_both_ways(view):
    view.gripper = 10
    assert placed(view.channel, "/meshcat/arm/4/left")[2, 3] == pytest.approx(10)
    assert placed(view.channel, "/meshcat/arm/4/right")[2, 3] == pytest.approx(-10)


# ---- camera and background -----------------------------------------------------------------------------


def eye(view):
    commands = decoded(view.channel)
    path = "/Cameras/default/rotated/<object>"
    x, z, minus_y = np.subtract(*(commands["set_property", path, name]["value"] for name in ("position", "target")))
    return np.array((x, -minus_y, z))


@pytest.mark.parametrize("camera", Camera)
def test_camera_presets_look_from_where_they_say(camera):
    view = View(camera=camera)
    along = eye(view) / np.linalg.norm(eye(view))
    np.testing.assert_allclose(along, np.array(camera.value) / np.linalg.norm(camera.value), atol=1e-9)
    assert view.camera is camera


def test_a_camera_must_be_a_camera(view):
    with pytest.raises(ValueError, match="left"):
        view.camera = "left"


# ---- chains --------------------------------------------------------------------------------------------


def test_any_chain_is_drawn_from_its_table_alone():
    view = View.of_chain(PRISMATIC, (0.1, 0.2, 30))
    assert objects(view.channel, "/meshcat/arm") == {f"/meshcat/arm/{i}" for i in range(4)}
    view.q = (0.5, -0.5, 60)
    for i, T in enumerate(PRISMATIC.frames(view.q)):
        np.testing.assert_allclose(placed(view.channel, f"/meshcat/arm/{i}"), T, atol=1e-9)
    view.frames(0, 3)
    view.ghosts([(0, 0, 10)])
    with pytest.raises(omx.BadInput, match="3 finite"):
        view.q = omx.HOME


def test_prismatic_joints_are_boxes_and_revolute_ones_cylinders():
    """A box has few vertices, a cylinder many; the rod of the slider is long enough for its stroke."""
    from omx.display.viewer import arm_model

    box, cylinder = arm_model.Solid(), arm_model.Solid()
    arm_model._joint(box, True, 5.0)
    arm_model._joint(cylinder, False, 5.0)
    assert len(box.arrays()[0]) < len(cylinder.arrays()[0]) / 3
    assert arm_model.reach(FIXED) == pytest.approx(arm_model.reach(PRISMATIC) + 2 * math.hypot(12, 5, 40))
    drawn = arm_model.chain_drawings(FIXED)
    assert set(drawn) == {0, 1, 2, 3}
    rod = arm_model.Solid()
    arm_model._link(rod, omx.DHRow(0, 20, 0, 0, prismatic=True), 80.0, 5.0)
    points, unit, *_ = rod.arrays()
    assert 1e3 * unit * points[:, 2].min() == pytest.approx(-100, abs=5)


# ---- animation -----------------------------------------------------------------------------------------


def tracks(view):
    command = decoded(view.channel)["set_animation", "", ""]
    found = {}
    for played in command["animations"]:
        for track in played["clip"]["tracks"]:
            values = np.frombuffer(track["values"].data, np.float32)
            found[played["path"], track["name"]] = values.reshape(-1, 3 if track["name"] == ".position" else 4)
    return command, found


def test_an_animation_passes_through_the_frames(view):
    qs = [omx.HOME, (0.8, 0.2, 0.2, 0.5), (-0.8, 0.2, 0.2, 0.5)]
    view.frames(4)
    view.animate(qs, seconds=3)
    command, found = tracks(view)
    assert command["options"] == {"play": True, "repetitions": math.inf}
    tool = found["/meshcat/arm/4", ".position"]
    np.testing.assert_allclose(1e3 * tool[[0, len(tool) // 2, -1]], omx.fk(qs)[:, :3, 3], atol=1e-3)
    assert ("/meshcat/frames/4", ".quaternion") in found
    turns = found["/meshcat/arm/4", ".quaternion"]
    assert (np.einsum("ij,ij->i", turns[1:], turns[:-1]) > 0.9).all(), "no jump of sign: it would spin the wrong way"
    assert view.q == omx.HOME


def test_things_and_fingers_move_with_the_arm(view):
    things = [cube("red", (150, 0)), cup("cup", (100, 80), colour="no colour")]
    view.things(things)
    drawn = objects(view.channel, "/meshcat/notes")
    assert {"/meshcat/notes/red", "/meshcat/notes/cup"} <= drawn
    things[0].T[:3, 3] = 10, 20, 30
    view.things(things)
    assert objects(view.channel, "/meshcat/notes") == drawn
    np.testing.assert_allclose(placed(view.channel, "/meshcat/notes/red")[:3, 3], (10, 20, 30), atol=1e-6)
    way = np.array([np.eye(4), things[0].T])
    view.animate([omx.HOME, omx.ZERO], seconds=1, gripper=[19, -5], things={"red": way})
    _, found = tracks(view)
    np.testing.assert_allclose(1e3 * found["/meshcat/notes/red", ".position"], way[:, :3, 3], atol=1e-3)
    left, right = (1e3 * found[f"/meshcat/arm/4/{name}", ".position"][:, 2] for name in ("left", "right"))
    np.testing.assert_allclose((left, right), ((19, -5), (-19, 5)), atol=1e-4)
    with pytest.raises(omx.BadInput, match="'blue', which is not in this scene"):
        view.animate([omx.HOME, omx.ZERO], things={"blue": way})


def test_setting_q_ends_the_animation(view):
    view.animate([omx.HOME, omx.ZERO])
    view.q = omx.ZERO
    assert tracks(view)[0]["animations"] == []


def test_quaternions_are_those_of_the_matrices():
    rng = np.random.default_rng(5)
    turns = rng.normal(size=(200, 4))
    turns /= np.linalg.norm(turns, axis=1, keepdims=True)
    x, y, z, w = turns.T
    matrices = np.moveaxis(
        np.array(
            [
                [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
            ]
        ),
        2,
        0,
    )
    found = commands.quaternions(matrices)
    assert np.abs(np.einsum("ij,ij->i", found, turns)) == pytest.approx(1, abs=1e-12)


# ---- what a cell shows ---------------------------------------------------------------------------------


def test_the_text_of_a_view_is_a_sentence_and_always_the_same(view):
    text = (
        "OpenMANIPULATOR-X at q = (0.0, -60.2, 20.1, 40.1) deg, tool at x = 122.0, y = 0.0, z = 241.3 mm, "
        "pitch = 0.0 deg"
    )
    assert repr(view) == repr(View()) == text
    view.q = (-1e-9, -1e-9, 0, 0)
    assert "-0.0" not in repr(view)
    slider = "a slider at (0.0 deg, 0.0 deg, 0.0 mm), tool at x = 9.6, y = 53.0, z = 120.0 mm"
    assert repr(View.of_chain(PRISMATIC)) == slider


def test_importing_the_view_needs_no_server():
    """Neither pyzmq nor tornado, which a kernel in the browser lacks; nor `meshcat`'s Python side."""
    code = """
        import sys
        for name in ("zmq", "tornado", "meshcat.visualizer"):
            sys.modules[name] = None
        from omx.display.viewer import View
        view = View()
        view.q = (0.1, 0.2, 0.3, 0.4)
        view.widget
        assert "<iframe" in view.static_html()
    """
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(code)], capture_output=True, text=True, timeout=60, check=False,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(
    ("colour", "numbers"),
    [("red", (200, 50, 43)), ("Blue", (0, 114, 178)), ("#fff", (255, 255, 255)), ("#0072B2", (0, 114, 178))],
)
def test_a_colour_by_name_or_by_digits(colour, numbers):
    assert rgb(colour) == numbers
    View().arrow("a", (0, 0, 0), (0, 0, 100), colour=colour)


@pytest.mark.parametrize("colour", ["#12", "rgb(1,2,3)", "", None, 3, (1, 2, 3), [True] * 3])
def test_what_is_no_colour_is_named(colour):
    with pytest.raises(omx.BadInput, match="`colour` must be"):
        View().path([(0, 0, 0), (0, 0, 9)], colour=colour)


def test_a_camera_by_name_and_all_four_names_for_another():
    view = View(camera="side")
    assert view.camera is omx.Camera.SIDE
    for wrong in ("up", None, 3):
        with pytest.raises(omx.BadInput, match=r"omx.Camera.ISO, omx.Camera.SIDE, omx.Camera.FRONT, omx.Camera.TOP"):
            view.camera = wrong
