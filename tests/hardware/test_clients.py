"""Programs that know nothing of omx drive the virtual arm, over a pseudo-terminal and over TCP.

Each client has an environment of its own, made once beside this one with the versions that environment.txt names.
Without a package index they cannot be made: then these tests are skipped, but on CI they fail.
"""

import contextlib
import json
import os
import subprocess
import sys
import venv
from pathlib import Path

import pytest

from book.setup.paths import ENVIRONMENT, ROOT
from tests.helpers.served_arm import Served

CLIENTS = ROOT / "tests/helpers/clients"
PTY = sys.platform.startswith("linux")  # on macOS pseudo-terminals do not take the servos' rate


def pin(package):
    """The pin of a client, from the lines of environment.txt that begin with `# client`."""
    lines = ENVIRONMENT.read_text(encoding="utf-8").splitlines()
    pins = [line.split()[2] for line in lines if line.startswith("# client ")]
    found = [pin for pin in pins if pin.split("==")[0] == package]
    assert len(found) == 1, f"environment.txt must name one version of {package}: `# client {package}==X`"
    return found[0]


def python_with(requirement):
    """The Python of an environment that holds `requirement` and nothing else."""
    home = Path(sys.prefix) / "clients" / requirement.replace("==", "-")
    python = home / ("Scripts/python.exe" if sys.platform == "win32" else "bin/python")
    done = home / "complete"
    if not done.exists():
        venv.create(home, with_pip=True, clear=True)
        install = [str(python), "-m", "pip", "install", "--quiet", "--disable-pip-version-check", requirement]
        made = subprocess.run(install, capture_output=True, text=True, timeout=300, check=False)
        if made.returncode:
            told = f"{requirement} cannot be installed here: {made.stderr.strip().splitlines()[-1:]}"
            (pytest.fail if os.environ.get("CI") else pytest.skip)(told)
        done.touch()
    return str(python)


def drive(python, script, end):
    """What the client printed, after driving a virtual arm behind `end`."""
    with contextlib.ExitStack() as stack:
        name = stack.enter_context(Served(*end)).name
        if script.startswith("rustypot") and "://" in name:
            from tests.helpers.clients.bridge import pty_to

            name = stack.enter_context(pty_to(name))
        run = subprocess.run([python, CLIENTS / script, name], capture_output=True, text=True, timeout=90, check=False)
    assert run.returncode == 0, run.stderr
    return json.loads(run.stdout)


def check(seen):
    """What every client must have seen."""
    for goal, position in zip(seen["goals"], seen["positions"], strict=True):
        assert position == pytest.approx(goal, abs=12)  # 1 deg: the arm sags
    assert seen["positions"] == seen["fast"] == seen["singly"]
    assert seen["locked"] == 7  # access error: the EEPROM is locked while torque is on
    assert seen["after_reboot"] == [0, 4]
    assert seen["after_reset"] == 0


ENDS = [
    pytest.param(("--pty",), id="pty", marks=pytest.mark.skipif(not PTY, reason="no pseudo-terminals")),
    pytest.param(("--tcp", "0"), id="tcp"),
]


@pytest.mark.parametrize("end", ENDS)
def test_the_makers_sdk(end):
    seen = drive(sys.executable, "sdk_client.py", end)
    check(seen)
    assert seen["models"] == [1020] * 5
    assert seen["broadcast"] == [11, 12, 13, 14, 15]
    assert seen["bulk"] == seen["fast_bulk"] == [2100, 25]
    assert (seen["before_action"], seen["after_action"], seen["indirect"]) == (2100, 2050, 2050)


@pytest.mark.parametrize("end", ENDS)
def test_dynamixel_python(end):
    seen = drive(python_with(pin("dynamixel-python")), "dynamixel_python_client.py", end)
    check(seen)
    assert seen["pings"] == [{"model_number": 1020, "firmware_version": 45}] * 5
    assert seen["broadcast"] == [11, 12, 13, 14, 15]
    assert seen["bulk"] == seen["fast_bulk"] == [2100, 25]
    assert (seen["before_action"], seen["after_action"], seen["indirect"]) == (2100, 2050, 2050)


@pytest.mark.skipif(not PTY, reason="rustypot opens serial ports only, and this system has no pseudo-terminals")
@pytest.mark.parametrize("end", ENDS)
def test_rustypot(end):
    seen = drive(python_with(pin("rustypot")), "rustypot_client.py", end)
    check(seen)
    assert seen["pings"] == [True] * 5
    assert seen["models"] == [1020] * 5
    assert seen["broadcast"] == [[servo, 1020] for servo in (11, 12, 13, 14, 15)]
    assert seen["indirect"] == seen["positions"][0]
