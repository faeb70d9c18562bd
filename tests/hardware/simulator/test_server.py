"""The virtual arm in a process of its own, over TCP and over a pseudo-terminal; it outlives nobody."""

import contextlib
import os
import signal
import socket
import subprocess
import sys
import textwrap
import time
from pathlib import Path

import psutil
import pytest

from book.setup.paths import ROOT
from omx import errors
from omx.arm import ARM_IDS, JOINT_IDS
from omx.hardware.dynamixel import packet as pk
from omx.hardware.dynamixel.bus import Bus
from omx.hardware.dynamixel.sdk import Port
from omx.hardware.simulator import VirtualArm
from omx.hardware.simulator.__main__ import main
from omx.hardware.simulator.faults import Fault
from omx.hardware.simulator.server import Pace, TcpEnd, serve
from tests.helpers.rigs import PTY_BAUD
from tests.helpers.served_arm import Served

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
        assert len(bus.read_block(JOINT_IDS)) == 4


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
        with pytest.raises(errors.PortBusy, match="another program"), Bus(served.name) as other:
            other.scan(range(1, 10))
        assert bus.ping(11)


@pytest.mark.parametrize("line", [b"GET / HTTP/1.1\r\n", b"POST / HTTP/1.1\r\n\r\n", b"OPTIONS * HTTP/1.1\r\n"])
def test_a_web_page_is_hung_up_on_and_moves_nothing(line):
    torque = pk.build(11, pk.Instruction.WRITE, b"\x40\x00\x01")
    with Served("--tcp", "0") as served:
        port = int(served.name.rsplit(":", 1)[1])
        with socket.create_connection(("127.0.0.1", port), timeout=5) as page:
            page.sendall(line + torque)
            with contextlib.suppress(ConnectionError):  # what it sent was not read: the system may say so
                assert page.recv(100) == b""
        with patient(served.name) as bus:
            assert bus.read(11, "torque_enable") == 0


def test_a_client_that_never_reads_blocks_nobody():
    end = TcpEnd()
    address = ("127.0.0.1", int(end.name.rsplit(":", 1)[1]))
    with socket.create_connection(address, timeout=5) as deaf:
        end.wait(5.0)
        end.read()
        for _ in range(500):  # 32 MB, more than the system keeps
            end.write(b"\xff" * 65536)
        deaf.sendall(b"\xff")
        end.wait(5.0)
        assert end.read() == b"\xff"
    end.close()


def test_who_leaves_and_comes_back_at_once_is_let_in():
    torque = pk.build(11, pk.Instruction.WRITE, b"\x40\x00\x01")
    with Served("--tcp", "0") as served:
        address = ("127.0.0.1", int(served.name.rsplit(":", 1)[1]))
        for _ in range(20):
            with socket.create_connection(address, timeout=5) as client:
                client.sendall(torque * 300)
            with patient(served.name) as bus:
                assert bus.read(11, "torque_enable") == 1  # it was heard out


@pytest.mark.parametrize("name", ["socket://127.0.0.1", "socket://127.0.0.1:", "socket://127.0.0.1:99999", "socket://"])
def test_a_name_without_a_port_is_told(name):
    with pytest.raises(errors.PortError, match=r"127\.0\.0\.1:PORT"):
        Bus(name)


# ---- keeping up ----


def moving_arm():
    """An arm whose joint 1 turns slowly for half a minute."""
    arm = VirtualArm(settings={11: {"drive_mode": 4}})
    servo = arm.servo(11)
    for name, value in (("torque_enable", 1), ("profile_velocity", 30_000), ("goal_position", 3000)):
        servo.set(name, value)
    return arm


class HeldUp:
    """A clock that somebody else turns."""

    scale, time = 1.0, 0.0

    def now(self):
        return self.time


def test_a_server_that_was_held_up_makes_up_for_one_second_and_no_more():
    clock, arm = HeldUp(), moving_arm()
    pace = Pace(clock, arm)
    for clock.time in (0.5, 1.0, 1.5):
        arm.advance(pace.now())
        assert arm.now == clock.time
    clock.time = 600.0
    arm.advance(pace.now())
    assert arm.now == 2.5
    clock.time = 600.25
    assert pace.now() == 2.75


def test_the_arm_is_computed_while_it_moves_and_nobody_asks():
    """A second of motion takes 20 ms to compute; what is left to compute at the first question is one tick of it."""
    clock, arm, waits = HeldUp(), moving_arm(), []

    class Silent:
        baud = None

        def wait(self, seconds):
            waits.append(seconds)
            clock.time += seconds
            if clock.time > 40:
                raise KeyboardInterrupt

        def read(self):
            assert clock.time - arm.now <= 1e-9
            return b""

    with pytest.raises(KeyboardInterrupt):
        serve(Silent(), arm, clock)
    assert max(waits[:1000]) <= 0.02
    assert waits[-1] >= 0.5  # at rest it sleeps


def test_a_port_that_somebody_has_is_named_with_the_way_to_a_free_one(capsys):
    end = TcpEnd()
    taken = end.name.rpartition(":")[2]
    assert main(["--tcp", taken]) == 1
    end.close()
    assert capsys.readouterr().err.startswith(f"TCP port {taken} cannot be had: somebody has it, perhaps another")


# ---- who ends it ----

PYTHON = [sys.executable, "-m", "omx.hardware.simulator", "--tcp", "0"]


@pytest.mark.skipif(sys.platform == "win32", reason="signals")
@pytest.mark.parametrize("by", [signal.SIGINT, signal.SIGTERM])
def test_without_standard_input_it_serves_until_a_signal(by):
    with subprocess.Popen(PYTHON, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True, cwd=ROOT) as process:
        with patient(process.stdout.readline().strip()) as bus:
            assert bus.ping(11)
            assert process.poll() is None
        process.send_signal(by)
        assert process.wait(10) == 0


def test_where_standard_input_ends_at_once_it_ends_at_once():
    for _ in range(3):  # the end may come before it serves
        done = subprocess.run([*PYTHON, "--stdin"], stdin=subprocess.DEVNULL, capture_output=True, cwd=ROOT, timeout=30)
        assert (done.returncode, done.stderr) == (0, b"")


def test_it_ends_with_whoever_reads_what_it_says():
    process = subprocess.Popen([*PYTHON, "--stdin"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, cwd=ROOT)
    process.stdout.readline()
    process.stdout.close()
    process.stdin.write(b"clear\n")
    process.stdin.flush()
    assert process.wait(10) == 0
    process.stdin.close()


@pytest.mark.skipif(sys.platform == "win32", reason="a shell")
@pytest.mark.parametrize("how", ["{} <&- &", "nohup {} </dev/null 2>/dev/null &", "{} & wait"])
def test_a_shell_may_start_it_in_any_way(how):
    command = f"{how.format(' '.join(PYTHON))} echo $!" if how.endswith("&") else f"echo $$; exec {' '.join(PYTHON)}"
    with subprocess.Popen(["sh", "-c", command], stdout=subprocess.PIPE, text=True, cwd=ROOT) as shell:
        said = {shell.stdout.readline().strip(), shell.stdout.readline().strip()}
        pid = int(next(line for line in said if line.isdecimal()))
        with patient(next(line for line in said if "://" in line)) as bus:
            assert bus.ping(11)
        os.kill(pid, signal.SIGTERM)
        assert gone(pid)


@pytest.mark.skipif(not hasattr(os, "openpty"), reason="terminals")
def test_in_the_background_of_a_terminal_it_is_not_stopped():
    """A shell with job control at a terminal: whoever reads from it in the background is stopped by the system."""
    master, slave = os.openpty()
    jobs = f"set -m; {' '.join(PYTHON)} & wait $!"
    login = (
        "import fcntl, os, termios; os.setsid(); fcntl.ioctl(0, termios.TIOCSCTTY, 0); "
        f"os.execvp('bash', ['bash', '-c', {jobs!r}])"
    )
    shell = subprocess.Popen([sys.executable, "-c", login], stdin=slave, stdout=slave, stderr=slave, cwd=ROOT)
    os.close(slave)
    name = ""
    while "://" not in name or not name.endswith("\n"):
        name += os.read(master, 1000).decode()
    with patient(next(word for word in name.split() if "://" in word)) as bus:
        assert bus.ping(11)
        (server,) = psutil.Process(shell.pid).children()
        assert server.status() != psutil.STATUS_STOPPED
    server.terminate()
    shell.wait(10)
    os.close(master)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--tcp", "70000"], "0 .. 65535"),
        (["--tcp", "0", "--scale", "0"], "scale"),
        (["--tcp", "0", "--q", "nan", "0", "0", "0"], "stops"),
        (["--tcp", "0", "--q", "9", "9", "9", "9"], "stops"),
        (["--tcp", "0", "--set", "12"], "names no register"),
        (["--tcp", "0", "--set", "9", "id=3"], "takes a servo"),
        (["--tcp", "0", "--set", "12", "homing_ofset=3"], "homing_offset"),
        (["--tcp", "0", "--set", "12", "id=900"], "252"),
        (["--tcp", "0", "--payload", "501"], "500"),
        (["--tcp", "0", "--backlash", "nan"], "backlash_deg"),
        ([], "--tcp"),
    ],
)
def test_bad_options_are_one_sentence(arguments, said, capsys):
    try:
        code = main(arguments)
    except SystemExit as end:
        code = end.code
    told = capsys.readouterr().err
    assert code
    assert said in told
    assert told.count("\n") == 1


def test_registers_at_the_start():
    settings = ("--set", "all", "drive_mode=4", "--set", "12", "homing_offset=-400")
    with Served("--tcp", "0", *settings) as served, patient(served.name) as bus:
        assert set(bus.read_all(ARM_IDS, "drive_mode").values()) == {4}
        assert bus.read(12, "homing_offset") == -400


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
        from tests.helpers.served_arm import Served
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
    ("text", "fault"),
    [
        ("lost", Fault("lost")),
        ("late servo=12 count=3 value=0.1", Fault("late", 12, count=3.0, value=0.1)),
        ("overload servo=12 after=0.5", Fault("overload", 12, after=0.5)),
    ],
)
def test_faults_in_words(text, fault):
    assert VirtualArm().faults.inject_text(text) == fault


@pytest.mark.parametrize("text", ["lost 13", "lost servo=x", "lost where=13"])
def test_faults_in_wrong_words(text):
    with pytest.raises(errors.BadInput, match="written"):
        VirtualArm().faults.inject_text(text)
