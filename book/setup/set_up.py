"""Make .venv from environment.txt, or repair it. Standard library only.

The stamp that calls it complete is written last, and by renaming; whatever was cut short before that is
taken up by the next run.
"""

import importlib.util
import json
import os
import shutil
import sys
from pathlib import Path

from book.setup.file_lock import one_at_a_time
from book.setup.installers import Failed, ask, call, explain
from book.setup.paths import (
    ENVIRONMENT,
    LEFT_OUT,
    PYTHON,
    ROOT,
    STAMP,
    VENV,
    WINDOWS,
    Stop,
    fingerprint,
    installed,
    is_ready,
    missing,
    requirements,
)

STARTS = "import sys; sys.exit(sys.prefix == sys.base_prefix or sys.version_info < (3, 11))"
SITE_PACKAGES = "import sysconfig; print(sysconfig.get_path('purelib'))"
LAB_SETTINGS = {"@jupyterlab/apputils-extension:notification": {"fetchNews": "false", "checkForUpdates": False}}
INCOMPLETE = """
import csv, importlib.metadata, os
for package in importlib.metadata.distributions():
    rows = list(csv.reader((package.read_text("RECORD") or "").splitlines()))
    sizes = {os.fspath(package.locate_file(row[0])): row[2] for row in rows}
    if not rows or any(s and not (os.path.exists(p) and os.path.getsize(p) == int(s)) for p, s in sizes.items()):
        print(package.name or package.locate_file(""))
"""


def set_up(repair=False):
    """Make or complete .venv, one process at a time; `repair` looks at it even where it is called complete.

    Raises `Stop` with the one sentence to show.
    """
    if unfit := unfit_path(str(ROOT)):
        raise Stop(f"The book's folder, {str(ROOT)!a}, {unfit}: give the folder another name or place.")
    try:
        if not is_text(ENVIRONMENT):
            raise Stop("environment.txt is missing beside run.py, or is no text; restore it from the repository.")
        with one_at_a_time(ENVIRONMENT, "Another set-up is at work in this folder; waiting for it ...") as lock:
            if VENV.is_file() or (VENV.is_symlink() and not VENV.exists()):
                VENV.unlink()
            if repair or not is_ready():
                why = reason(repair)
                clear(STAMP)
                build(lock, why)
    except OSError as error:
        raise Stop(explain(error)) from error


def build(lock, why):
    """Complete the .venv that is there, or make it from nothing, and stamp it; `why` is told in the first case."""
    if not (ask("-c", STARTS)[0] and completed(lock, why)):
        say(f"Setting up the book in .venv with Python {sys.version_info[0]}.{sys.version_info[1]}, once ...")
        make_venv()
        install(lock)
        if incomplete := incomplete_packages():
            raise Stop(f"Some packages did not arrive whole ({incomplete}); run the same command again.")
    link_package()
    quieten_lab()
    partial = STAMP.with_suffix(".part")
    clear(partial)
    partial.write_text("\n".join([fingerprint(), *installed()]), encoding="utf-8")
    os.replace(partial, STAMP)
    say("Set-up complete.")


def clear(path):
    """Remove what is at this path, whatever it is."""
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    path.unlink(missing_ok=True)


def reason(repair):
    """Why a .venv that is there is looked at."""
    if gone := missing():
        packages = ", ".join(name.removesuffix(".dist-info").replace("-", " ") for name in gone)
        return f"Completing .venv: {packages} is missing, or was replaced by another version."
    if repair:
        return "Looking at .venv: whatever is missing or not whole is put in its place."
    return "Completing .venv: environment.txt has changed, or an earlier set-up was cut short."


def is_text(path):
    """Is there a file of UTF-8 at this path?"""
    try:
        return path.is_file() and bool(path.read_text(encoding="utf-8"))
    except ValueError:
        return False


def unfit_path(path):
    """Why no environment can be made at this path, or ''."""
    if os.pathsep in path:
        return f"has a `{os.pathsep}` in its path, which divides the entries of PATH"
    try:
        path.encode("utf-8")
    except UnicodeEncodeError:
        return "has bytes in its path that are no UTF-8"
    return "has a name of two lines" if "\n" in path or "\r" in path else ""


def completed(lock, why):
    """Install what the .venv that is there still lacks; False when it must be made from nothing."""
    say(why)
    try:
        install(lock)
    except Failed as failed:
        if failed.full or failed.unreachable:
            raise
        say(f"That did not work: {failed.last_line}")
        return False
    incomplete = incomplete_packages()
    if incomplete:
        say(f"Some of its packages are not whole: {incomplete}")
    return not incomplete


def make_venv():
    """A new .venv in place of whatever is there; a link to another disk stays a link."""
    if not (shutil.which("uv") or importlib.util.find_spec("ensurepip")):
        raise Stop(no_ensurepip())
    try:
        import venv
    except ImportError as error:
        raise Stop(no_ensurepip()) from error
    venv.EnvBuilder(clear=True, with_pip=False, symlinks=not WINDOWS).create(VENV.resolve())


def install(lock):
    """Install environment.txt: with uv from the PATH or an earlier set-up, else the pinned uv, else plain pip."""
    uv = shutil.which("uv")
    if uv and tried([uv], lock):
        return
    own = [PYTHON, "-m", "uv"]
    has_uv = ask("-m", "uv", "--version")[0]
    if has_uv and tried(own, lock):
        return
    pip = [*with_pip(lock), "install", "--disable-pip-version-check", "--retries=2", "--timeout=20", *beside()]
    if not has_uv:
        call([*pip, pinned("uv")], lock)
        if tried(own, lock):
            return
    call([*pip, "-r", requirements()], lock)


def with_pip(lock):
    """The command of .venv's own pip, which is put there if need be."""
    if not ask("-m", "pip", "--version")[0]:
        if not importlib.util.find_spec("ensurepip"):
            raise Stop(no_ensurepip())
        call([PYTHON, "-m", "ensurepip", "--default-pip"], lock)
    return [PYTHON, "-m", "pip"]


def tried(uv, lock):
    """Install environment.txt with this uv; False when it could not, so that pip must."""
    say("Installing the packages with uv; the first time this takes a minute ...")
    try:
        call([*uv, "pip", "install", *beside(), "--python", PYTHON, "-r", requirements()], lock)
    except Failed as failed:
        if failed.full:
            raise
        say(f"uv could not: {failed.last_line}\nTrying another way, which takes longer ...")
        return False
    return True


def beside():
    """The options to install from the folder `wheels` of a student's edition, and from nowhere else, if it is there."""
    wheels = ROOT / "wheels"
    return ["--no-index", "--find-links", str(wheels)] if wheels.is_dir() else []


def pinned(package):
    """The requirement of a package in environment.txt, version and all."""
    for line in ENVIRONMENT.read_text(encoding="utf-8").splitlines():
        if line.startswith(package + "=="):
            return line.split("#")[0].strip()
    raise Stop(f"environment.txt does not pin {package}; restore that file from the repository.")


def incomplete_packages():
    """The packages whose files are not all there (an installer was killed), as a list in words, or ''."""
    worked, names = ask("-c", INCOMPLETE)
    return ", ".join(names.split()) if worked else "they cannot be listed"


def must_import(*modules):
    """Raise `Stop` where .venv's Python cannot import one of these."""
    for module in modules:
        if not ask("-c", f"import {module}")[0]:
            raise Stop(f"{module} is in .venv and cannot be imported; `python run.py repair` mends it.")


def link_package():
    """Make `import omx` work from any folder: a .pth with the way from site-packages to here.

    It does what an editable install does, without a build; the relative way survives a moved folder. Its second line
    spares every start of Jupyter a second: see `LEFT_OUT`.
    """
    packages = Path(ask("-c", SITE_PACKAGES)[1])
    way = os.path.relpath(ROOT, packages)  # Python takes it word for word, links or not
    (packages / "omx.pth").write_text(f"{way}\n{LEFT_OUT}\n", encoding="utf-8")


def quieten_lab():
    """JupyterLab shall neither ask the internet for news and updates nor the reader whether it may."""
    settings = VENV / "share" / "jupyter" / "lab" / "settings"
    settings.mkdir(parents=True, exist_ok=True)
    (settings / "overrides.json").write_text(json.dumps(LAB_SETTINGS, indent=1) + "\n")


def no_ensurepip():
    return (
        f"This Python ({sys.executable}) comes without ensurepip and cannot make an environment: on Debian and "
        "Ubuntu type `sudo apt install python3-venv`, elsewhere install uv or a complete Python, then run the same "
        "command again."
    )


def say(text):
    print(text, flush=True)
