"""JupyterHub with the book's settings, really: two users at once, each with an arm, a scene and a book of their own."""

import json
from concurrent.futures import ThreadPoolExecutor

import psutil
import pytest
import requests

from tests.helpers.lab import run_in_kernel

ANGLES = {"ada": (30, -40, 20, 25), "ben": (-60, -20, 35, -10)}
#: All users run this at the same time, each with angles of their own.
MOVE = """
import numpy as np
from omx.hardware.robot import Robot
from omx.display.viewer import View
robot = Robot()
robot.write_motor_state(True)
robot.move_to({angles}, seconds=1.5)
view = View(robot.q)
view
"""
LOOK = """
import json, os, ipykernel, omx
drawn = np.frombuffer(view.channel.log["set_transform", "/meshcat/arm/4", ""][-16 * 9:], np.uint8).tolist()
print(json.dumps(dict(
    arm=np.degrees(robot.q).tolist(), scene=np.degrees(view.q).tolist(), drawn=drawn, pid=os.getpid(),
    book=os.path.dirname(os.path.dirname(omx.__file__)), limit=os.environ["MEM_LIMIT"],
    transport=json.load(open(ipykernel.get_connection_file()))["transport"])))
"""
#: What a chapter does when a student edits the DH table: it writes the generated module again.
REWRITE = """
import omx.generated.fk as fk, pathlib
path = pathlib.Path(fk.__file__)
path.write_text(path.read_text() + "EDITED = True\\n")
"""


@pytest.fixture(scope="module")
def users(hub):
    """Both users, with a server and a kernel each, all started in the same moment."""

    def enter(name):
        user = hub.login(name).start()
        return name, (user, user.kernel())

    return at_once(enter, ANGLES)


def at_once(action, things):
    """The results of `action` for each of `things`, all begun together, as a dict of what it returns."""
    with ThreadPoolExecutor(len(things)) as pool:
        return dict(pool.map(action, things))


def run(users, code, name):
    return run_in_kernel(*users[name], code)


@pytest.fixture(scope="module")
def seen(users):
    """What each user sees after both have moved their arms at the same time."""
    at_once(lambda name: (name, run(users, MOVE.format(angles=ANGLES[name]), name)), ANGLES)
    return {name: json.loads(run(users, LOOK, name)) for name in ANGLES}


def test_each_user_has_an_arm_and_a_scene_of_their_own(seen):
    for name, angles in ANGLES.items():
        assert seen[name]["arm"] == pytest.approx(angles, abs=1.0)
        assert seen[name]["scene"] == pytest.approx(angles, abs=1.0)
    assert seen["ada"]["drawn"] != seen["ben"]["drawn"]
    assert seen["ada"]["pid"] != seen["ben"]["pid"]


def test_what_one_user_does_the_other_does_not_see(users, seen):
    run(users, "robot.move_to([0, -20, 20, 0], seconds=2); view.q = robot.q", "ada")
    after = {name: json.loads(run(users, LOOK, name)) for name in ANGLES}
    assert after["ada"]["arm"] == pytest.approx((0, -20, 20, 0), abs=1.0)
    assert after["ada"]["drawn"] != seen["ada"]["drawn"]
    assert after["ben"]["arm"] == pytest.approx(seen["ben"]["arm"], abs=0.1)
    assert after["ben"]["drawn"] == seen["ben"]["drawn"]


def test_an_edited_chapter_moves_nobody_elses_arm(users, seen):
    run(users, REWRITE, "ada")
    edited = "import importlib, omx.generated.fk as fk; importlib.reload(fk); print(hasattr(fk, 'EDITED'))"
    assert [run(users, edited, name).strip() for name in ANGLES] == ["True", "False"]
    assert seen["ada"]["book"] != seen["ben"]["book"]


def test_kernels_talk_over_sockets_and_nothing_listens_to_the_network(hub, seen):
    assert {user["transport"] for user in seen.values()} == {"ipc"}
    listening = hub.listening()
    assert {address.ip for addresses in listening.values() for address in addresses} == {"127.0.0.1"}
    kernels = [listening.pop(user["pid"]) for user in seen.values()]
    assert [len(addresses) for addresses in kernels] == [1, 1], "more than ipykernel's pipe for its children's output"
    ports = [address.port for addresses in listening.values() for address in addresses]
    assert set(hub.ports.values()) <= set(ports)
    assert len(ports) == 3 + len(ANGLES), "the hub, its proxy's two, and one for each user's server"


def test_servers_have_the_limits_and_end_when_they_are_idle(hub, seen):
    assert {user["limit"] for user in seen.values()} == {str(2**30)}
    servers = [psutil.Process(user["pid"]).parent() for user in seen.values()]
    for server in servers:
        assert any("cull_idle_timeout=" in argument for argument in server.cmdline())
        assert any("shutdown_no_activity_timeout=" in argument for argument in server.cmdline())
    assert len({server.pid for server in servers}) == len(ANGLES)


def test_nobody_reaches_the_server_of_another(users):
    ada, ben = users["ada"][0], users["ben"][0]
    assert [kernel["id"] for kernel in ada.ask("kernels")[1]] == [users["ada"][1]]
    answer = requests.get(f"{ben.url}/api/kernels", headers={"Authorization": f"token {ada.token}"}, timeout=30)
    assert answer.status_code == 403


def test_a_stopped_hub_leaves_no_process(hub, seen):
    processes = hub.tree()
    assert {user["pid"] for user in seen.values()} <= {process.pid for process in processes}
    assert hub.stop() == []
    assert not [process for process in processes if process.is_running()]
