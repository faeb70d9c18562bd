"""Environments beside .venv, for what would disturb it (JupyterLite, JupyterHub) or is optional (numba).

Each is a line `#: NAME requirement ...` in environment.txt, made on demand in build/env-NAME. It sees the book's
own packages behind its own.
"""

import hashlib
import os
import re
import subprocess
import sys
import sysconfig

from book.setup.file_lock import one_at_a_time
from book.setup.installers import Failed, installer_environment
from book.setup.paths import ENVIRONMENT, LEFT_OUT, ROOT, WINDOWS, Stop, child_environment


def requirements(name):
    """The requirements of an environment, from environment.txt."""
    found = re.search(rf"^#: {name} +(.+)$", ENVIRONMENT.read_text(encoding="utf-8"), re.M)
    if found is None:
        raise Stop(f"environment.txt has no line `#: {name} ...`; restore that file from the repository.")
    return found[1].split("  #")[0].split()


def python(name):
    """The Python of the environment `name`, made if need be. Raises `Stop`."""
    folder = ROOT / "build" / f"env-{name}"
    there = folder / ("Scripts/python.exe" if WINDOWS else "bin/python")
    wanted = requirements(name)
    stamp, text = folder / "complete", hashlib.sha256(" ".join([*wanted, sys.version]).encode()).hexdigest()

    def is_made():
        return there.exists() and stamp.exists() and stamp.read_text() == text

    if not is_made():
        with one_at_a_time(ENVIRONMENT):
            if not is_made():
                print(f"Making build/env-{name} with {', '.join(wanted)} ...", flush=True)
                make(folder, there, wanted)
                stamp.write_text(text)
    return there


def variables(name):
    """The variables for a process of the environment `name`: its own commands come first on the PATH."""
    commands = str(python(name).parent)
    return {**child_environment(), "PATH": commands + os.pathsep + os.environ.get("PATH", "")}


def make(folder, there, wanted):
    uv = [sys.executable, "-m", "uv"]
    call([*uv, "venv", "--quiet", "--clear", "--python", sys.executable, str(folder)])
    call([*uv, "pip", "install", "--quiet", "--python", str(there), *wanted])
    asked = subprocess.run([there, "-c", "import sysconfig; print(sysconfig.get_path('purelib'))"], capture_output=True,
                           text=True, check=True)  # fmt: skip
    own = asked.stdout.strip()
    lines = [str(ROOT), sysconfig.get_path("purelib"), sysconfig.get_path("platlib"), LEFT_OUT]
    with open(os.path.join(own, "book.pth"), "w", encoding="utf-8") as file:
        file.write("\n".join(dict.fromkeys(lines)) + "\n")


def call(command):
    done = subprocess.run(command, env=installer_environment(command), capture_output=True, text=True, check=False)
    if done.returncode:
        failed = Failed((done.stderr or done.stdout).splitlines())
        if failed.full:
            raise failed
        why = "the package index cannot be reached" if failed.unreachable else failed.last_line
        raise Stop(f"Making an environment failed ({why}); check the network and try again.")
