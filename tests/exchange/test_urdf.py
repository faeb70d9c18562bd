"""URDF out of a chain and into one: the same arm; joint axes of any direction; what is odd is refused by name."""

import sys
from math import inf, pi
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

import omx
from omx.errors import BadInput
from omx.exchange import urdf
from omx.rotation import from_rpy
from tests.helpers.urdf_arms import ARMS, NEAR, poses, transform, wanted

RNG = np.random.default_rng(21)


@pytest.mark.parametrize("name", ARMS)
def test_there_and_back_is_the_same_arm(name, tmp_path):
    arm, chain, maker_base = ARMS[name]
    path = omx.urdf.write(tmp_path / "arm.urdf", arm, maker_base=maker_base)
    back = omx.urdf.read(path)
    assert (back.names, back.name) == (chain.names, chain.name)
    np.testing.assert_allclose(back.limits, chain.limits, rtol=1e-15)
    q = poses(chain)
    np.testing.assert_allclose(back.fk(q), wanted(chain, q, maker_base), atol=NEAR)
    assert omx.urdf.text(arm, maker_base=maker_base) == path.read_text(encoding="utf-8")


def test_the_arms_own_table_comes_back_and_costs_no_tool():
    back = omx.urdf.parse(omx.urdf.text())
    assert back.base is back.tool is None
    for ours, theirs in zip(omx.COURSE.chain.rows, back.rows, strict=True):
        np.testing.assert_allclose(theirs.at(0.0), ours.at(0.0), atol=1e-12)


def test_the_makers_base_is_12_mm_behind():
    back = omx.urdf.parse(omx.urdf.text(omx.MAKER, maker_base=True))
    np.testing.assert_allclose(back.fk(omx.ZERO)[:3, 3], (286, 0, 204.5), atol=NEAR)


#: The maker's joints (m), with a gripper of two fingers, one of which mimics the other.
MAKER = """<robot name="theirs">
  <link name="world"/><link name="link1"/><link name="link2"/><link name="link3"/><link name="link4"/>
  <link name="link5"/><link name="tip"/><link name="left"/><link name="right"/>
  <joint name="fixed" type="fixed"><parent link="world"/><child link="link1"/></joint>
  <joint name="joint1" type="revolute"><parent link="link1"/><child link="link2"/>
    <origin xyz="0.012 0.0 0.017" rpy="0 0 0"/><axis xyz="0 0 1"/><limit lower="-3.14" upper="3.14"/></joint>
  <joint name="joint2" type="revolute"><parent link="link2"/><child link="link3"/>
    <origin xyz="0.0 0.0 0.0595"/><axis xyz="0 1 0"/><limit lower="-1.5" upper="1.5"/></joint>
  <joint name="joint3" type="revolute"><parent link="link3"/><child link="link4"/>
    <origin xyz="0.024 0 0.128"/><axis xyz="0 1 0"/><limit lower="-1.5" upper="1.4"/></joint>
  <joint name="joint4" type="revolute"><parent link="link4"/><child link="link5"/>
    <origin xyz="0.124 0 0"/><axis xyz="0 1 0"/><limit lower="-1.7" upper="1.97"/></joint>
  <joint name="end" type="fixed"><parent link="link5"/><child link="tip"/><origin xyz="0.126 0 0"/></joint>
  <joint name="slide" type="prismatic"><parent link="link5"/><child link="left"/><axis xyz="0 1 0"/>
    <origin xyz="0.0817 0.021 0"/><limit lower="-0.01" upper="0.019"/></joint>
  <joint name="other" type="prismatic"><parent link="link5"/><child link="right"/><axis xyz="0 -1 0"/>
    <mimic joint="slide"/><limit lower="-0.01" upper="0.019"/></joint>
</robot>"""


def test_the_makers_own_joints_are_omx_maker_in_their_frames():
    theirs, q = omx.urdf.parse(MAKER, tip="tip"), np.array(poses(omx.MAKER.chain))
    into_their_tool = transform((0, 0, 0), (pi / 2, 0, 0))  # R_urdf = R_dh Rx(90 deg)
    ours = transform((12, 0, 0), (0, 0, 0)) @ omx.MAKER.chain.fk(q) @ into_their_tool
    np.testing.assert_allclose(theirs.fk(q), ours, atol=NEAR)
    assert theirs.names == ("joint1", "joint2", "joint3", "joint4")
    with pytest.raises(BadInput, match=r"branches at the link 'link5' \(tip, left, right\): say which way, by `tip`"):
        omx.urdf.parse(MAKER)
    left = omx.urdf.parse(MAKER, base="link5", tip="left")
    assert left.limits == ((-10.0, 19.0),)
    np.testing.assert_allclose(left.fk([5.0])[:3, 3], (81.7, 26, 0), atol=NEAR)
    with pytest.raises(BadInput, match="joint 'other' mimics another"):
        omx.urdf.parse(MAKER, tip="right")


def test_a_second_base_is_no_way_to_go():
    second = '<link name="base"/><joint name="also" type="fixed"><parent link="world"/><child link="base"/></joint>'
    arm = MAKER[: MAKER.index('  <joint name="slide"')].replace('<link name="left"/><link name="right"/>', second)
    assert omx.urdf.parse(arm + "</robot>").names == ("joint1", "joint2", "joint3", "joint4")
    hand = (
        '<link name="left"/><joint name="pad" type="fixed"><parent link="link5"/><child link="left"/></joint></robot>'
    )
    with pytest.raises(BadInput, match=r"branches at the link 'link5' \(tip, left\)"):
        omx.urdf.parse(arm + hand)


def test_ten_thousand_parts_are_no_burden():
    links = "".join(f'<link name="l{i}"/>' for i in range(3001))
    joints = "".join(
        f'<joint name="j{i}" type="fixed"><parent link="l{i}"/><child link="l{i + 1}"/></joint>' for i in range(2200)
    )
    with pytest.raises(BadInput, match=r"has 801 first links|nothing moves"):
        omx.urdf.parse(f"<robot>{links}{joints}</robot>")


def some_robot(seed):
    """The text of a URDF with fixed and moving joints at any angle, and its transform by Rodrigues."""
    random, parts, steps = np.random.default_rng(seed), ['<robot name="some"><link name="l0"/>'], []
    for i in range(random.integers(2, 9)):
        kind = ("fixed", "continuous", "prismatic")[int(random.integers(0, 3))] if i else "continuous"
        xyz, rpy, axis = random.uniform(-0.4, 0.4, 3), random.uniform(-3, 3, 3), random.uniform(-2, 2, 3)
        parts.append(
            f'<link name="l{i + 1}"/><joint name="j{i}" type="{kind}"><parent link="l{i}"/><child link="l{i + 1}"/>'
            f'<origin xyz="{" ".join(map(repr, xyz.tolist()))}" rpy="{" ".join(map(repr, rpy.tolist()))}"/>'
            f'<axis xyz="{" ".join(map(repr, axis.tolist()))}"/>'
            '<limit lower="-1" upper="1" effort="0" velocity="0"/></joint>'
        )
        steps.append((kind, transform(1e3 * xyz, rpy), axis / np.linalg.norm(axis)))

    def fk(q):
        T, values = np.eye(4), iter(q)
        for kind, origin, u in steps:
            moved = np.eye(4)
            if kind == "continuous":
                angle, W = next(values), np.cross(np.eye(3), u)
                moved[:3, :3] = np.eye(3) + np.sin(angle) * W + (1 - np.cos(angle)) * W @ W
            elif kind == "prismatic":
                moved[:3, 3] = next(values) * u
            T = T @ origin @ moved
        return T

    return "".join([*parts, "</robot>"]), fk


def test_joint_axes_of_any_direction_are_read():
    pin = pytest.importorskip("pinocchio")
    for seed in range(30):
        described, fk = some_robot(seed)
        chain = omx.urdf.parse(described)
        model = pin.buildModelFromXML(described)
        data, slides = model.createData(), [row.prismatic for row in chain.rows]
        for q in np.random.default_rng(seed).uniform(-2, 2, (10, len(chain))):
            q = np.where(slides, 100 * q, q)
            theirs = [v for value, s in zip(q, slides, strict=True)
                      for v in ((1e-3 * value,) if s else (np.cos(value), np.sin(value)))]  # fmt: skip
            pin.framesForwardKinematics(model, data, np.array(theirs))
            T = data.oMf[model.nframes - 1].homogeneous * ([[1, 1, 1, 1e3]] * 3 + [[1, 1, 1, 1]])
            np.testing.assert_allclose(chain.fk(q), fk(q), atol=NEAR)
            np.testing.assert_allclose(chain.fk(q), T, atol=NEAR)


def test_rounded_quarter_turns_are_refused_or_taken_as_meant():
    rounded = MAKER.replace('<origin xyz="0.124 0 0"/>', '<origin xyz="0.124 0 0" rpy="0 0 0.0000037"/>')
    with pytest.raises(BadInput, match=r"joints 3 and 4 are 3.7e-06 rad from parallel"):
        omx.urdf.parse(rounded, tip="tip")
    exact, taken = omx.urdf.parse(MAKER, tip="tip"), omx.urdf.parse(rounded, tip="tip", tolerance=1e-5)
    q = poses(omx.MAKER.chain)
    np.testing.assert_allclose(taken.fk(q), exact.fk(q), atol=126 * 3.8e-6)


@pytest.mark.parametrize(
    ("chain", "message"),
    [
        (omx.Chain([(0, sp.Symbol("L"), 0, 0)]), "has symbols in it"),
        (omx.Chain([(0, 5, 0, 0, True)]), "d1 of chain has the limits .*a joint that slides. Give the Chain limits"),
        (omx.Chain([(0, 5, 0, 0)], [(0, inf)]), "q1 of chain has the limits .*does not turn freely"),
        ("arm", "`geometry` must be a Geometry"),
    ],
)
def test_what_urdf_cannot_say_is_refused_by_name(chain, message):
    with pytest.raises(BadInput, match=message):
        omx.urdf.text(chain)


def test_a_remark_may_speak_of_anything():
    remark = "<!-- a <!DOCTYPE in a remark -->"
    ours = omx.urdf.text().partition("<robot")
    q = [0.1, 0.2, 0.3, 0.4]
    np.testing.assert_array_equal(
        omx.urdf.parse(remark + "<robot" + ours[2]).fk(q), omx.urdf.parse(omx.urdf.text()).fk(q)
    )


def with_joint(change, old='type="revolute"', count=1):
    return MAKER.replace(old, change, count)


@pytest.mark.parametrize(
    ("described", "message"),
    [
        ("", "is not XML"),
        ("<robot>", "is not XML"),
        ("<mujoco/>", "describes a <mujoco>, not a <robot>"),
        ('<!DOCTYPE robot [<!ENTITY a "aaaa">]><robot name="&a;"/>', "has a DOCTYPE"),
        ('<!DOCTYPE robot SYSTEM "file:///etc/passwd"><robot/>', "has a DOCTYPE"),
        ("<robot>" + "<a>" * 100_000 + "</a>" * 100_000 + "</robot>", "has 0 first links"),
        ("<robot>" + " " * 10_000_001 + "</robot>", "more than 10000000 bytes"),
        ("<robot/>", "has 0 first links"),
        ('<robot><link name="a"/></robot>', "nothing moves between"),
        ('<robot><link name="a"/><link name="b"/></robot>', r"has 2 first links \(a, b\): give `base`"),
        ('<robot><link name="a"/><link name="a"/></robot>', "links must have different names; 'a'"),
        (with_joint('type="floating"'), "joint 'joint1' is 'floating'"),
        (with_joint('type="planar"'), "joint 'joint1' is 'planar'"),
        (with_joint("", 'type="revolute"'), "joint 'joint1' is None"),
        (with_joint("", '<limit lower="-3.14" upper="3.14"/>'), "joint 'joint1' is revolute and has no <limit>"),
        (with_joint('xyz="0 0 0"', 'xyz="0 0 1"'), "the axis of joint 'joint1' points nowhere"),
        (with_joint('xyz="0 1"', 'xyz="0 0 1"'), "the axis of joint 'joint1' must be three numbers"),
        (with_joint('rpy="0 0 nan"', 'rpy="0 0 0"'), "rpy of joint 'joint1' must be a number .* it is 'nan'"),
        (with_joint('rpy="0 0 1e400"', 'rpy="0 0 0"'), "it is '1e400'"),
        (with_joint('rpy="0 0 1_0"', 'rpy="0 0 0"'), "it is '1_0'"),
        (with_joint('rpy="0 0 ${pi}"', 'rpy="0 0 0"'), "Run xacro on the file first"),
        (with_joint('upper="-9"', 'upper="3.14"'), r"`limits`\[0\] is"),
        (with_joint('upper="180"', 'upper="3.14"'), r"`limits`\[0\] is .*degrees"),
        (with_joint('name="joint2"', 'name="joint1"'), "joints must have different names; 'joint2'"),
        (with_joint('<child link="nowhere"/>', '<child link="tip"/>'), "joint 'end' has the child 'nowhere'"),
        (with_joint("", '<parent link="link5"/>'), "joint 'end' has the parent None"),
        (with_joint('<child link="left"/>', '<child link="tip"/>'), "hangs on two joints"),
        (with_joint('<child link="world"/>', '<child link="tip"/>'), "nothing moves between the base and tip"),
        (with_joint('<parent link="right"/>', '<parent link="link1"/>'), "nothing moves|no way leads from .*'tip'"),
        (None, "must be a text"),
        (b"<robot/>", "must be a text"),
    ],
)
def test_what_is_no_urdf_or_no_chain_is_refused_by_name(described, message):
    with pytest.raises(BadInput, match=message):
        omx.urdf.parse(
            described, tip=None if described and isinstance(described, str) and "tip" not in described else "tip"
        )


def test_a_file_is_read_as_text_and_never_fetches_anything(tmp_path):
    path = tmp_path / "arm.urdf"
    for content, message in ((b"\xff\xfe<", "cannot read"), (MAKER.encode("utf-16"), "cannot read|not XML")):
        path.write_bytes(content)
        with pytest.raises(BadInput, match=message):
            omx.urdf.read(path)
    with pytest.raises(BadInput, match="cannot read"):
        omx.urdf.read(tmp_path / "none.urdf")
    path.write_text("\ufeff" + MAKER, encoding="utf-8")
    assert len(omx.urdf.read(path, tip="tip")) == 4
    for odd in (None, "", 5, b"x"):
        with pytest.raises(BadInput, match="`path` must be"):
            omx.urdf.read(odd)
        with pytest.raises(BadInput, match="`path` must be"):
            omx.urdf.write(odd)


def test_masses_centres_and_inertias_are_those_of_links():
    """Each inertia is a body's: positive, and no axis heavier than the other two together."""
    tensors = [part.inertia for part in urdf._arm_parts(omx.COURSE) if part.mass]
    assert len(tensors) == 4
    for I in tensors:
        a, b, c = np.linalg.eigvalsh(I)
        assert 1e-6 < a <= b <= c <= a + b < 1e-3


def test_urdf_comes_when_it_is_asked_for():
    assert omx.urdf is urdf
    assert "omx.exchange" in sys.modules
    assert Path(urdf.__file__).parent.name == "exchange"


def test_a_rotation_is_told_in_three_angles_exactly():
    R = from_rpy(0.3, pi / 2 - 1e-8, 1.0)
    T = np.eye(4)
    T[:3, :3] = R
    back = omx.urdf.parse(omx.urdf.text(omx.Chain([(0, 1, 2, 0.5)], [(-1, 1)], base=T)))
    np.testing.assert_allclose(back.fk([0.2]), T @ omx.Chain([(0, 1, 2, 0.5)]).fk([0.2]), atol=1e-12)
