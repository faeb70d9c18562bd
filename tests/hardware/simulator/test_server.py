"""The virtual arm in a process of its own, over TCP and over a pseudo-terminal; it outlives nobody."""

import os
import socket
import subprocess
import sys
import textwrap
import time
from pathlib import Path

import pytest

from book.setup.paths import ROOT
from omx import errors
from omx.arm import ARM_IDS, JOINT_IDS
from omx.hardware.dynamixel.bus import Bus
from omx.hardware.dynamixel.sdk import Port
from omx.hardware.simulator.server import parse_fault
from omx.hardware.simulator.server_process import Served
from tests.helpers.rigs import PTY_BAUD

ENDS = [
    pytest.param(("--tcp", "0"), id="tcp"),
    pytest.param(
        ("--pty",), id="pty", marks=pytest.mark.skipif(not hasattr(os, "openpty"), reason="no pseudo-terminals")
    ),
]


def patient(name, patience_s=2.0):
    """A bus that forgives a busy machine: the server may be late."""
    return Bus(Port(name, patience_s=patience_s), baud=1_000_000 if "://" in name else PTY_BAUD)


def gone(pid, within=10.0):
    """True once no process has this id."""
    until = time.monotonic() + within
    while time.monotonic() < until:
        if not process_runs(pid):
            return True
        time.sleep(0.05)
    return False


def process_runs(pid):
    if sys.platform == "win32":
        listed = subprocess.run(["tasklist", "/FI", f"PID eq {pid}"], capture_output=True, text=True, check=False)
        return str(pid) in listed.stdout
    stat = Path(f"/proc/{pid}/stat")
    if Path("/proc").exists():
        return stat.exists() and stat.read_text().rsplit(")", 1)[1].split()[0] != "Z"
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


@pytest.mark.parametrize("end", ENDS)
def test_our_bus_drives_it(end):
    with Served(*end, "--scale", "20") as served, patient(served.name) as bus:
        assert list(bus.scan(ARM_IDS)) == list(ARM_IDS)
        bus.write(11, "torque_enable", 1)
        bus.write(11, "goal_position", 2500)
        time.sleep(0.2)
        assert bus.read(11, "present_position") == pytest.approx(2500, abs=4)
        assert len(bus.read_block(JOINT_IDS, fast=True)) == 4


@pytest.mark.parametrize("end", ENDS)
def test_clients_come_and_go(end):
    with Served(*end) as served:
        for servo in ARM_IDS:
            with patient(served.name) as bus:
                assert bus.ping(servo)


@pytest.mark.parametrize("end", ENDS)
def test_orders_on_standard_input(end):
    with Served(*end, "--fault", "wrong_model servo=12") as served:
        with patient(served.name, 0.5) as bus:
            assert bus.ping(12).model == 1060
            served.tell("dead servo=13")
            assert 13 not in bus.scan([12, 13])
            served.tell("clear")
            time.sleep(0.5)
            assert bus.ping(13) == (1020, 45)
        with pytest.raises(errors.BadInput, match="written"):
            served.tell("lost servo=thirteen")
        with pytest.raises(errors.BadInput, match="No fault"):
            served.tell("explosion")


def test_tcp_is_for_this_computer_and_for_one_client():
    with Served("--tcp", "0") as served, patient(served.name) as bus:
        assert served.name.startswith("socket://127.0.0.1:")
        bus.ping(11)
        port = int(served.name.rsplit(":", 1)[1])
        with socket.create_connection(("127.0.0.1", port), timeout=5) as second:
            assert second.recv(10) == b""
        assert bus.ping(11)


def test_a_pulled_plug_ends_the_connection():
    with Served("--tcp", "0") as served, patient(served.name) as bus:
        bus.ping(11)
        served.tell("unplugged")
        with pytest.raises(errors.PortLost):
            bus.scan(range(1, 10))


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="pseudo-terminals with a rate are a Linux thing")
def test_a_pty_knows_the_clients_baud_rate():
    with Served("--pty") as served:
        with Bus(Port(served.name, patience_s=0.1), baud=57600) as bus:
            assert not bus.scan([11])
        with patient(served.name) as bus:
            assert bus.ping(11)


def test_it_ends_with_its_standard_input():
    served = Served()
    pid = served._process.pid
    assert process_runs(pid)
    served.close()
    assert gone(pid)


def test_it_ends_with_the_program_that_started_it_even_if_that_is_killed():
    program = textwrap.dedent("""
        import time
        from omx.hardware.simulator.server_process import Served
        served = Served()
        print(served._process.pid, flush=True)
        time.sleep(60)
    """)
    starter = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True, cwd=ROOT)
    pid = int(starter.stdout.readline())
    assert process_runs(pid)
    starter.kill()
    starter.wait()
    starter.stdout.close()
    assert gone(pid)


def test_a_port_that_is_taken_is_told():
    with Served("--tcp", "0") as served, pytest.raises(errors.OmxError, match="did not start"):
        Served("--tcp", served.name.rsplit(":", 1)[1])


@pytest.mark.parametrize(
    ("text", "parsed"),
    [
        ("lost", ("lost", {})),
        ("late servo=12 count=3 value=0.1", ("late", {"servo": 12, "count": 3.0, "value": 0.1})),
        ("overload servo=12 after=0.5", ("overload", {"servo": 12, "after": 0.5})),
    ],
)
def test_faults_in_words(text, parsed):
    assert parse_fault(text) == parsed


@pytest.mark.parametrize("text", ["lost 13", "lost servo=x", "lost where=13"])
def test_faults_in_wrong_words(text):
    with pytest.raises(errors.BadInput, match="written"):
        parse_fault(text)
