"""The fastest timing: closed forms where there are any, limits kept and used up everywhere, and TOPP-RA beside it.

`OMX_TOPPRA=300` compares more paths than the suite does.
"""

import json
import os
import subprocess

import numpy as np
import pytest

import omx
from book.setup import extra_envs
from book.setup.paths import ROOT, Stop
from omx.errors import BadInput, OmxError
from omx.motion import Allowed, Path, controllable, fastest, in_joints, motor_torques, rounded, spline_path

POINTS = np.array([omx.ZERO, (0.5, -0.5, 0.3, 0.4), (1.0, 0.2, -0.3, 0.2), (1.4, -0.4, 0.6, -0.2)])
CORNERS = [(150, -80, 150, 0), (200, 80, 150, 0), (220, 0, 250, 0)]
ALLOWED = Allowed(speed=(1.0, 1.2, 1.1, 2.0), acceleration=5.0, torque=(2.0, 0.75, 0.56, 0.4), payload_g=50)
PATHS = {
    "spline": spline_path(POINTS, 400),
    "corners": in_joints(rounded(CORNERS, 4.0, 400), omx.HOME),
}


@pytest.fixture(params=PATHS.values(), ids=PATHS)
def path(request):
    return request.param


@pytest.mark.parametrize("way", [0.05, 0.5, 2.0])
def test_one_joint_makes_the_trapezoid_or_the_triangle(way):
    speed, acceleration = 1.0, 4.0
    path = spline_path([(0, 0, 0, 0), (way, 0, 0, 0)], 2001)
    cruises = way > speed**2 / acceleration
    wanted = way / speed + speed / acceleration if cruises else 2 * np.sqrt(way / acceleration)
    assert fastest(path, Allowed(speed, acceleration)).seconds == pytest.approx(wanted, rel=1e-4)


def test_limits_are_kept_and_at_every_step_one_of_them_is_used_up(path):
    motion = fastest(path, ALLOWED)
    assert np.abs(motion.qd).max(axis=1).max() <= max(ALLOWED.speed) + 1e-9
    torques = motor_torques(motion.q, motion.qd, motion.qdd, ALLOWED.payload_g)
    used = np.hstack([motion.qd / ALLOWED.speed, motion.qdd / ALLOWED.acceleration, torques / ALLOWED.torque])
    assert np.abs(used).max() <= 1 + 1e-6
    step = (
        np.diff(path.s) * 2
    )  # the same at the end of each step, where the acceleration is still that of its beginning
    x = (np.linalg.norm(motion.qd, axis=1) / np.linalg.norm(path.dq, axis=1)) ** 2
    u = (np.diff(x) / step)[:, None]
    qdd = path.dq[1:] * u + path.ddq[1:] * x[1:, None]
    after = motor_torques(path.q[1:], motion.qd[1:], qdd, ALLOWED.payload_g)
    ends = np.hstack([qdd / ALLOWED.acceleration, after / ALLOWED.torque, motion.qd[1:] / ALLOWED.speed])
    assert np.abs(ends).max() <= 1 + 1e-6
    assert np.maximum(np.abs(used[:-1]).max(axis=1), np.abs(ends).max(axis=1)).min() > 1 - 1e-4
    np.testing.assert_allclose(motion.qd[[0, -1]], 0, atol=1e-12)


def test_speed_acceleration_and_torque_each_decide_somewhere():
    motion = fastest(PATHS["spline"], ALLOWED)
    torques = motor_torques(motion.q, motion.qd, motion.qdd, ALLOWED.payload_g)
    for used in (motion.qd / ALLOWED.speed, motion.qdd / ALLOWED.acceleration, torques / ALLOWED.torque):
        assert np.abs(used).max() > 1 - 1e-3


def test_it_keeps_to_the_speeds_from_which_it_can_still_brake_and_brakes_along_them(path):
    motion, (_, high) = fastest(path, ALLOWED), controllable(path, ALLOWED)
    x = (np.linalg.norm(motion.qd, axis=1) / np.linalg.norm(path.dq, axis=1)) ** 2
    assert (x <= high * (1 + 1e-9) + 1e-12).all()
    pieces = np.count_nonzero(np.isclose(x[1:-1], high[1:-1], rtol=1e-6))
    assert pieces > 20, "it brakes along the ceiling"


def test_the_unit_of_s_does_not_matter(path):
    unit = 137.0
    other = Path(path.s * unit, path.q, path.dq / unit, path.ddq / unit**2)
    assert fastest(other, ALLOWED).seconds == pytest.approx(fastest(path, ALLOWED).seconds, rel=1e-8)


def test_more_allowed_is_never_slower(path):
    seconds = [fastest(path, Allowed(1.0, a, 0.8)).seconds for a in (1, 2, 5, 20, 100)]
    assert (np.diff(seconds) < 0).all()


def test_a_joint_too_weak_to_stand_still_is_named():
    with pytest.raises(OmxError, match=r"joint 3 would need 0\.\d\d Nm to stand still, and 0\.30 Nm are allowed"):
        fastest(PATHS["corners"], Allowed(1.0, 5.0, 0.3))


@pytest.mark.parametrize(
    ("wrong", "name"),
    [({"speed": 0}, "speed"), ({"acceleration": (1, 2, 3)}, "acceleration"), ({"torque": "much"}, "torque"),
     ({"speed": [(1, 2, 3, 4)]}, "speed"), ({"payload_g": -1}, "payload_g")],
)  # fmt: skip
def test_bounds_are_above_zero(wrong, name):
    with pytest.raises(BadInput, match=name):
        Allowed(**wrong)


def test_it_times_paths_only():
    with pytest.raises(BadInput, match="Path of joints"):
        fastest(omx.motion.joint_move(omx.ZERO, omx.HOME, 1.0), ALLOWED)


def test_topp_ra_finds_the_same_speeds():
    try:
        python = extra_envs.python("peer-toppra")
    except Stop as stop:
        pytest.skip(str(stop))
    command = [python, "-m", "tests.helpers.toppra_timing", os.environ.get("OMX_TOPPRA", "8")]
    env = extra_envs.variables("peer-toppra")
    done = subprocess.run(command, cwd=ROOT, env=env, capture_output=True, text=True, timeout=900, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    found = json.loads(done.stdout)
    print(found)
    assert max(found["slower"], found["faster"]) < 1e-6
    assert found["speeds"] < 1e-5
