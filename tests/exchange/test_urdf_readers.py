"""What other programs make of our URDF: yourdfpy and MuJoCo, where they are installed, and pinocchio.

`tests/analysis/test_optional.py` runs this file where the first two are. Each puts the tool where the chain does, to
1e-9 mm, and takes names, limits and weights as they are meant.
"""

import io

import numpy as np
import pytest

import omx
from omx.arm import GRAVITY
from omx.hardware.gravity import torques
from tests.helpers.urdf_arms import ARMS, NEAR, poses, wanted

WEIGHED = np.random.default_rng(3).uniform(*np.array(omx.LIMITS).T, (50, 4))


def worst(found, expected):
    """The largest difference of two stacks of transforms, translations in mm."""
    return np.abs(np.asarray(found) - expected).max()


def in_mm(T):
    scaled = np.array(T, dtype=float)
    scaled[:3, 3] *= 1e3
    return scaled


def in_m(chain, q):
    return q * [1e-3 if row.prismatic else 1.0 for row in chain.rows]


@pytest.mark.parametrize("name", ARMS)
def test_pinocchio(name):
    pin = pytest.importorskip("pinocchio")
    arm, chain, maker_base = ARMS[name]
    model = pin.buildModelFromXML(omx.urdf.text(arm, maker_base=maker_base))
    data, tool, q = model.createData(), model.getFrameId("tool"), poses(chain)
    assert [*model.names][1:] == [*chain.names]
    found = []
    for row in in_m(chain, q):
        unbounded = [
            (np.cos(v), np.sin(v)) if j.nq == 2 else (v,) for v, j in zip(row, [*model.joints][1:], strict=True)
        ]
        pin.framesForwardKinematics(model, data, np.concatenate(unbounded))
        found.append(in_mm(data.oMf[tool].homogeneous))
    assert worst(found, wanted(chain, q, maker_base)) < NEAR


def test_pinocchio_weighs_the_arm_as_we_do():
    pin = pytest.importorskip("pinocchio")
    model = pin.buildModelFromXML(omx.urdf.text(omx.MAKER))
    model.gravity.linear = np.array([0, 0, -GRAVITY])
    for q in WEIGHED:
        ours = [0.0, *(-torque for torque in torques(*q[1:]))]
        np.testing.assert_allclose(pin.computeGeneralizedGravity(model, model.createData(), q), ours, atol=1e-12)


@pytest.mark.parametrize("name", ARMS)
def test_yourdfpy(name):
    yourdfpy = pytest.importorskip("yourdfpy")
    arm, chain, maker_base = ARMS[name]
    file = io.BytesIO(omx.urdf.text(arm, maker_base=maker_base).encode())
    robot, q, found = yourdfpy.URDF.load(file), poses(chain), []
    assert robot.actuated_joint_names == list(chain.names)
    for row in in_m(chain, q):
        robot.update_cfg(row)
        found.append(in_mm(robot.get_transform("tool", "base_link")))
    assert worst(found, wanted(chain, q, maker_base)) < NEAR


@pytest.mark.parametrize("name", ARMS)
def test_mujoco(name):
    mujoco = pytest.importorskip("mujoco")
    arm, chain, maker_base = ARMS[name]
    model = mujoco.MjModel.from_xml_string(omx.urdf.text(arm, maker_base=maker_base))
    data, q, found = mujoco.MjData(model), poses(chain), []
    tool = model.body("tool").id
    assert [model.joint(i).name for i in range(model.njnt)] == list(chain.names)
    for row in in_m(chain, q):
        data.qpos[:] = row
        mujoco.mj_kinematics(model, data)
        T = np.eye(4)
        T[:3, :3], T[:3, 3] = data.xmat[tool].reshape(3, 3), data.xpos[tool]
        found.append(in_mm(T))
    assert worst(found, wanted(chain, q, maker_base)) < NEAR


def test_mujoco_weighs_the_arm_as_we_do_and_sees_no_collision():
    mujoco = pytest.importorskip("mujoco")
    model = mujoco.MjModel.from_xml_string(omx.urdf.text(omx.MAKER))
    model.opt.gravity[2] = -GRAVITY
    data = mujoco.MjData(model)
    for q in WEIGHED:
        data.qpos[:] = q
        mujoco.mj_forward(model, data)
        ours = [0.0, *(-torque for torque in torques(*q[1:]))]
        np.testing.assert_allclose(data.qfrc_bias, ours, atol=1e-9)
        assert data.ncon == 0 or omx.collision.clearance(q, omx.MAKER, table=None) < 1.0
