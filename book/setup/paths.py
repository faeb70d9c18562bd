"""Where the book's environment is, and whether it is ready. Standard library only, imported at every start."""

import hashlib
import os
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
NOTEBOOKS = ROOT / "notebooks"
BUILD = ROOT / "build"
ENVIRONMENT = ROOT / "environment.txt"
VENV = ROOT / ".venv"
STAMP = VENV / "set-up-complete"
WINDOWS = sys.platform == "win32"
PYTHON = VENV / "Scripts" / "python.exe" if WINDOWS else VENV / "bin" / "python"

# Without bytecode every kernel start compiles all packages anew (10 s instead of 3 s); a PYTHONPATH (ROS
# sets one) puts packages of another Python in front of the pinned ones.
UNWANTED_VARIABLES = ("PYTHONDONTWRITEBYTECODE", "PYTHONPATH", "PYTHONHOME")


class Stop(Exception):
    """Set-up or launch cannot go on; the message is the one sentence that the user sees."""


def fingerprint():
    """A hash of what the environment is made from: environment.txt and the Python in pyvenv.cfg."""
    made_from = ENVIRONMENT.read_bytes() + (VENV / "pyvenv.cfg").read_bytes()
    return hashlib.sha256(made_from).hexdigest()


def is_ready():
    """Is there a Python in .venv, and was set-up completed for today's environment.txt?"""
    try:
        return PYTHON.exists() and STAMP.read_text() == fingerprint()
    except OSError:
        return False


def child_environment():
    """The variables for everything that is started: this book's packages and no others."""
    kept = {name: value for name, value in os.environ.items() if name not in UNWANTED_VARIABLES}
    return {**kept, "VIRTUAL_ENV": str(VENV)}
