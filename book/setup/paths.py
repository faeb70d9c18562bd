"""Where the book's environment is, and whether it is ready. Standard library only, imported at every start."""

import contextlib
import errno
import functools
import hashlib
import os
import re
import sys
from pathlib import Path

from book.setup.settings import is_foreign

ROOT = Path(__file__).resolve().parents[2]
NOTEBOOKS = ROOT / "notebooks"
BUILD = ROOT / "build"
WORK = ROOT / "work"  # the reader's own: copies of the chapters, with their answers
ENVIRONMENT = ROOT / "environment.txt"
HASHES = ROOT / "book" / "setup" / "hashes.txt"  # the same pins with the hashes of their files, by `run.py lock`
VENV = ROOT / ".venv"
STAMP = VENV / "set-up-complete"
WINDOWS = sys.platform == "win32"
PYTHON = VENV / "Scripts" / "python.exe" if WINDOWS else VENV / "bin" / "python"

# Without bytecode every kernel start compiles all packages anew (10 s instead of 3 s); a PYTHONPATH (ROS
# sets one) puts packages of another Python in front of the pinned ones; without the current folder no tool of the
# book is found, without docstrings JupyterLab does not start, and an old kernel at home must not pass for ours.
UNWANTED_VARIABLES = (
    *("PYTHONDONTWRITEBYTECODE", "PYTHONPATH", "PYTHONHOME", "PYTHONSAFEPATH", "PYTHONOPTIMIZE"),
    "JUPYTER_PREFER_ENV_PATH",
)

# No room: on the disk, or in the share of it that a user, or a file, may take.
FULL = (errno.ENOSPC, errno.EFBIG, getattr(errno, "EDQUOT", errno.ENOSPC))


class Stop(Exception):
    """Set-up or launch cannot go on; the message is the one sentence that the user sees."""


def in_a_sentence(main):
    """A tool's `main` that ends with a sentence for a `Stop` or an OSError and the status 1, not a traceback."""

    @functools.wraps(main)
    def told(*arguments):
        status, said = 1, ""
        try:
            status = main(*arguments) or 0
        except Stop as stop:
            said = stop
        except OSError as error:
            said = in_words(error)
        except KeyboardInterrupt:
            status, said = 130, "Interrupted."
        try:
            if sys.stdout:  # it may be closed
                sys.stdout.flush()
        except OSError as error:
            os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # what is left unsaid must not be an error again at the end
            status, said = 1, said or in_words(error)
        if said:
            print(f"run.py: {said}", file=sys.stderr)
        return status

    return told


def in_words(error):
    """What an OSError of a tool means for who typed it; nothing where whoever read along has gone."""
    if isinstance(error, BrokenPipeError):
        return ""
    if error.errno in FULL:
        return "The disk is full; make room and type the same again."
    if error.filename is None:
        return error
    if error.errno in (errno.EACCES, errno.EPERM, errno.EROFS):
        return (
            f"{error.filename} cannot be opened ({error.strerror}): type this as its owner, or in a copy of your own."
        )
    if error.errno in (errno.EEXIST, errno.ENOTDIR, errno.EISDIR):
        return f"{error.filename} is in the way ({error.strerror}): move it elsewhere and type the same again."
    return error


@contextlib.contextmanager
def whole(path):
    """A path to write to, which takes the place of `path` then; where writing fails nothing of it is left."""
    partial = path.with_name(path.name + ".part")
    try:
        yield partial
        os.replace(partial, path)
    finally:
        with contextlib.suppress(OSError):
            partial.unlink(missing_ok=True)


#: A line of our .pth files. In every start of Jupyter jsonschema imports this, if it can, to check international
#: addresses, of which nothing here has one; and that builds 39 parsers, which takes nearly a second.
LEFT_OUT = "import sys; sys.modules['rfc3987_syntax'] = None"


def fingerprint():
    """A hash of what the environment is made from: environment.txt, the Python in pyvenv.cfg, and what is left out."""
    made_from = ENVIRONMENT.read_bytes() + (VENV / "pyvenv.cfg").read_bytes() + LEFT_OUT.encode()
    return hashlib.sha256(made_from).hexdigest()


def package_of(line):
    """The normalised name of the package that a requirement line asks for, '' for other lines."""
    found = re.match(r"[A-Za-z0-9][A-Za-z0-9._-]*", line)
    return re.sub(r"[._-]+", "-", found.group()).lower() if found else ""


def pins(path):
    """The (package, version) pairs that a requirements file pins."""
    lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
    return {
        (package_of(line), re.search(r"==([^ ;]*)", line)[1]) for line in lines if package_of(line) and "==" in line
    }


def requirements():
    """The file to install from: with hashes, so that no other file passes for a package, where they are up to date."""
    return HASHES if HASHES.exists() and pins(HASHES) == pins(ENVIRONMENT) else ENVIRONMENT


def installed():
    """The folders `NAME-VERSION.dist-info` in .venv that belong to packages which environment.txt pins."""
    pinned = {package_of(line) for line in ENVIRONMENT.read_text(encoding="utf-8").splitlines()} - {""}
    folders = VENV.glob("Lib/site-packages/*.dist-info" if WINDOWS else "lib/python3*/site-packages/*.dist-info")
    return sorted(path.name for path in folders if package_of(path.name.split("-")[0]) in pinned)


def missing():
    """What set-up installed and is not there as it was: its dist-info folders; None without a complete set-up."""
    try:
        first, *wanted = STAMP.read_text(encoding="utf-8").splitlines()
        if first == fingerprint() and PYTHON.is_file() and os.access(PYTHON, os.X_OK):
            return sorted(set(wanted) - set(installed()))
    except (OSError, ValueError):
        pass
    return None


def is_ready():
    """Was set-up completed for today's environment.txt, and is all that it installed still there?"""
    return missing() == []


def child_environment():
    """The variables for everything that is started: this book's packages and no others, and a home to write to."""
    kept = {name: value for name, value in os.environ.items() if not (name in UNWANTED_VARIABLES or is_foreign(name))}
    home = {} if WINDOWS or has_home() else {"HOME": str(own_home())}
    return {**kept, **home, "VIRTUAL_ENV": str(VENV)}


def has_home(home="~"):
    """Is there a home folder that can be written? Jupyter and the installers keep their settings in it."""
    home = os.path.expanduser(home)
    return os.path.isdir(home) and os.access(home, os.W_OK)


def own_home():
    """A home folder in .venv, for who has none."""
    home = VENV / "home"
    with contextlib.suppress(OSError):  # set-up says what cannot be written
        home.mkdir(parents=True, exist_ok=True)
    return home
