"""Run uv and pip, and say in one sentence what went wrong. Standard library only."""

import contextlib
import errno
import platform
import shutil
import subprocess
import sys

from book.setup import settings
from book.setup.paths import FULL, PYTHON, ROOT, VENV, WINDOWS, Stop, child_environment

LOG = VENV / "set-up.log"
#: In a student's edition: the system that the packages beside it were made for.
MADE_FOR = ROOT / "wheels" / "made-for.txt"
FULL_SIGNS = ("no space left", "errno 28", "os error 28", "os error 112", "quota exceeded")
NETWORK_SIGNS = (
    "name resolution",
    "name or service not known",
    "getaddrinfo",
    "dns error",
    "error sending request",
    "failed to fetch",
    "connection error",
    "newconnectionerror",
    "connection refused",
    "connection broken",
    "network is unreachable",
    "timed out",
    "proxyerror",
)
UNTRUSTED_SIGNS = ("certificate verify failed", "invalid peer certificate")


class Failed(Stop):
    """An installer failed: `last_line` of what it said; was the disk `full`, the index `untrusted`, `unreachable`?"""

    def __init__(self, output):
        text = "\n".join(output).lower()
        lines = [line.strip() for line in output if line.strip()]
        self.last_line = lines[-1][:200] if lines else "it said nothing"
        self.full = any(sign in text for sign in FULL_SIGNS)
        self.untrusted = any(sign in text for sign in UNTRUSTED_SIGNS)
        self.unreachable = not self.full and (self.untrusted or any(sign in text for sign in NETWORK_SIGNS))
        super().__init__(self.sentence())

    def sentence(self):
        if self.full:
            return disk_full()
        if self.untrusted:
            return (
                "The packages could not be downloaded because the package index shows a certificate that is not "
                "trusted here, as in a network that reads along: let SSL_CERT_FILE and PIP_CERT name the file of the "
                "certificate that your institution gives out, and run the same command again."
            )
        if self.unreachable:
            return (
                "The packages could not be downloaded because the package index cannot be reached: check the "
                "network connection (or the proxy) and run the same command again."
            )
        made_for = MADE_FOR.read_text(encoding="utf-8").strip() if MADE_FOR.is_file() else this_system()
        if made_for != this_system():
            return (
                f"The packages in {MADE_FOR.parent} were made for {made_for}, and this is {this_system()} "
                f"({self.last_line}): take that Python, or delete that folder and run the same command again with a "
                "network."
            )
        return (
            f"Installing the packages failed ({self.last_line}); all that was said is in {LOG}, and the same "
            "command tries again."
        )


def this_system():
    return f"Python {'.'.join(platform.python_version_tuple()[:2])} on {platform.system()} {platform.machine()}"


def call(command, lock):
    """Run an installer; show its current line on a terminal and keep all of it in the log.

    The child inherits the lock, so that a second set-up waits for it even when this process is killed.
    """
    process = subprocess.Popen(
        command,
        cwd=ROOT,
        env=installer_environment(command),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        pass_fds=() if WINDOWS else (lock.fileno(),),
    )
    output = []
    try:
        for line in process.stdout:
            output.append(line.decode("utf-8", "replace").rstrip())
            show_progress(output[-1])
        status = process.wait()
    finally:
        if process.poll() is None:
            process.kill()
            process.wait()
        process.stdout.close()
        show_progress("")
        keep(command, output)
    if status:
        raise Failed(output)


def installer_environment(command):
    """The variables for uv or pip: of the user's settings the index, the proxy and the certificate, no others."""
    ours = child_environment()
    if command[1:3] != ["-m", "pip"]:
        return {**ours, **settings.for_uv()}
    listing = [PYTHON, "-m", "pip", "config", "list"]  # in the variables that the user gave, to find the user's files
    listed = subprocess.run(listing, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False)
    return {**ours, **settings.for_pip(listed.stdout)}


def keep(command, output):
    """Add an installer's output to the log; a log that cannot be written must not hide the failure."""
    with contextlib.suppress(OSError), open(LOG, "a", encoding="utf-8") as file:
        file.write("$ " + " ".join(map(str, command)) + "\n" + "\n".join(output) + "\n")


def show_progress(line):
    if sys.stderr.isatty():
        print(f"\r{line.strip()[:76]:76}", end="\r", file=sys.stderr, flush=True)


def ask(*arguments):
    """(worked, what it printed) of .venv's Python with these arguments; its errors are not shown."""
    try:
        done = subprocess.run([PYTHON, *arguments], env=child_environment(), capture_output=True, check=False)
    except OSError:
        return False, ""
    return done.returncode == 0, done.stdout.decode("utf-8", "replace").strip()


def explain(error):
    """One sentence for an OSError during set-up."""
    if error.errno in FULL:
        return disk_full()
    if error.errno in (errno.EACCES, errno.EPERM, errno.EROFS):
        return (
            f"{error.filename or VENV} cannot be written ({error.strerror}): close what uses .venv (JupyterLab, an "
            "activated shell) or move the book into a folder of yours, and run the same command again."
        )
    return f"Set-up failed ({error}); run the same command again. If it ends so once more, delete {VENV} before."


def disk_full():
    free = shutil.disk_usage(ROOT).free // 2**20
    return (
        f"The disk is full: the environment needs about 1200 MB in {VENV} and in the installer's cache in your "
        f"home folder, and {free} MB are free here; make room and run the same command again."
    )
