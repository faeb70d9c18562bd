"""Starts a contender's process with the Python of its own environment, and reads its answer."""

import json
import subprocess
import sys

from book.setup import extra_envs
from book.setup.paths import ROOT, Stop, child_environment
from tests.bench.peer import Task, command
from tests.bench.peers import PEERS
from tests.bench.sheet import Size, times

TIMEOUT_S = 420


class Absent(Exception):
    """Something cannot be measured here; the message says why."""


def ask(name: str, task: Task, size: Size, here: bool = False) -> dict:
    """What a process of the contender's environment measured. Raises `Absent`."""
    environment = "" if here else PEERS[name].environment
    if environment and not (size.whole or (ROOT / "build" / f"env-{environment}" / "complete").exists()):
        raise Absent(f"build/env-{environment} is not there; the report without --quick makes it")
    if task.processors and sys.platform != "linux":
        raise Absent("the number of its threads can be set on Linux only")
    try:
        python = extra_envs.python(environment) if environment else sys.executable
    except Stop as stop:
        raise Absent(str(stop)) from None
    try:
        done = subprocess.run(command(python, name, task), cwd=ROOT, env=child_environment(), capture_output=True,
                              text=True, timeout=TIMEOUT_S, check=False)  # fmt: skip
    except subprocess.TimeoutExpired:
        raise Absent(f"it took longer than {TIMEOUT_S} s") from None
    if done.returncode:
        raise Absent((done.stderr.strip().splitlines() or ["it said nothing"])[-1][:200])
    return json.loads(done.stdout)


def verdict(line) -> str:
    """Of one of a peer's lines: by how much it was beaten, or not."""
    if line["to_ours"] > 1.0:
        return f"beaten: takes {times(line['to_ours'])} as long"
    return f"not beaten: by {times(1.0 / line['to_ours'])}"
