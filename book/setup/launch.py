"""The commands of run.py: set up if need be, then become the tool that was asked for.

Standard library only. A later start adds little to the tool's own: nothing heavy is imported here, and the
tool replaces this process.
"""

import os
import subprocess
import sys
from typing import NamedTuple

from book.setup.paths import NOTEBOOKS, PYTHON, ROOT, WINDOWS, Stop, child_environment, is_ready


class Command(NamedTuple):
    """A command of run.py: it exists when `needs` does; `calls` are run by .venv's Python one by one."""

    name: str
    needs: str
    calls: tuple[str, ...]
    help: str


COMMANDS = (
    Command("lab", "notebooks", (), "open JupyterLab: lab [chapter] [JupyterLab's own options]"),
    Command("test", "tests", ("-m pytest",), "run every test: test [pytest's own options]"),
    Command("check", "notebooks", ("-m book.chapters.check",), "lint code and chapters: check [chapter]"),
    Command("new-chapter", "notebooks", ("-m book.chapters.new",), "begin a chapter: new-chapter TOPIC"),
    Command("generate", "notebooks", ("-m book.chapters.generate",), "write omx/generated anew [--check, --restore]"),
    Command("execute", "notebooks", ("-m book.chapters.execute",), "run notebooks again and store their outputs"),
    Command("student", "notebooks", ("-m book.chapters.student",), "write the copies without solutions"),
    Command("book", "book/publish/site.py", ("-m book.publish.site",), "build the site in build/site [--serve]"),
    Command("slides", "book/publish/slides.py", ("-m book.publish.slides",), "build the slides in build/slides"),
    Command("lite", "book/publish/lite.py", ("-m book.publish.lite",), "the book for a browser alone: build/lite"),
    Command("bench", "tests/bench", ("-m tests.bench",), "measure the kinematics against other code [--report]"),
    Command("doctor", "omx/hardware/doctor", ("-m omx.hardware.doctor",), "find out why the arm does not answer"),
    Command("lock", "environment.txt", (), "rewrite the lower part of environment.txt [--newest]"),
)


def main(argv):
    """Run one command line; the exit status."""
    commands = {command.name: command for command in COMMANDS if (ROOT / command.needs).exists()}
    if not argv or argv[0] in ("-h", "--help", "help"):
        print("usage: python run.py COMMAND [...]\n")
        print("\n".join(f"  {command.name:<13}{command.help}" for command in commands.values()))
        return 0
    try:
        if argv[0] not in commands:
            raise Stop(f"There is no command {argv[0]!r}; the commands are {', '.join(commands)}.")
        return run(commands[argv[0]], argv[1:])
    except Stop as stop:
        print(f"run.py: {stop}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("\nrun.py: Interrupted; the same command takes it up again.", file=sys.stderr)
        return 130


def run(command, arguments):
    """Set up if need be, then hand over to the command's tools."""
    if command.name == "lock":  # works on an environment.txt that cannot be installed, too
        from book.setup import lock

        return lock.main(arguments)
    if command.name == "generate" and "--restore" in arguments:  # the same for what a chapter has broken
        from book.setup import restore

        return restore.main()
    if not is_ready():
        from book.setup import set_up

        set_up.set_up()
    if command.name == "lab":
        return hand_over(lab_arguments(arguments))
    *first, last = (call.split() for call in command.calls)
    for call in first:
        if status := wait_for(call):
            return status
    return hand_over([*last, *arguments])


def lab_arguments(arguments):
    """JupyterLab's command line: the chapter that was asked for, on the loopback address only."""
    name = ""  # the first
    if arguments and not arguments[0].startswith("-"):
        name, *arguments = arguments
    options = [
        "--ServerApp.ip=127.0.0.1",
        f"--ServerApp.root_dir={ROOT}",
        "--LabApp.extension_manager=readonly",  # the other one asks the internet
    ]
    if sys.platform == "linux" and len(runtime_folder()) <= 50:  # a socket's path holds 108 bytes
        options.append("--KernelManager.transport=ipc")  # kernels' TCP ports collide now and then
    if not WINDOWS and os.geteuid() == 0:
        options.append("--allow-root")  # in a container; JupyterLab refuses root otherwise
    given = {argument.split("=")[0] for argument in arguments}  # JupyterLab takes each option once
    ours = [option for option in options if option.split("=")[0] not in given]
    return ["-m", "jupyterlab", *ours, *arguments, str(find_chapter(name))]


def runtime_folder():
    """Where Jupyter keeps its sockets on Linux."""
    share = os.environ.get("XDG_DATA_HOME") or os.path.expanduser("~/.local/share")
    data = os.environ.get("JUPYTER_DATA_DIR") or os.path.join(share, "jupyter")
    return os.environ.get("JUPYTER_RUNTIME_DIR") or os.path.join(data, "runtime")


def find_chapter(name):
    """The notebook of a path, a file name or its beginning: `03`, `03-forward-kinematics`, ..."""
    if os.path.isfile(name):
        return os.path.abspath(name)
    chapters = sorted(NOTEBOOKS.glob("*.ipynb"))
    found = [chapter for chapter in chapters if chapter.name.startswith(os.path.basename(name))]
    if not found:
        raise Stop(f"There is no chapter {name!r}; the chapters are {', '.join(c.stem for c in chapters)}.")
    return found[0]


def hand_over(arguments):
    """Become .venv's Python with these arguments; on Windows, where that goes wrong, wait for it."""
    if WINDOWS:
        return wait_for(arguments)
    sys.stdout.flush()
    os.chdir(ROOT)
    os.execve(PYTHON, [str(PYTHON), *arguments], child_environment())


def wait_for(arguments):
    """Run .venv's Python with these arguments in the root; its exit status."""
    process = subprocess.Popen([PYTHON, *arguments], cwd=ROOT, env=child_environment())
    while True:
        try:
            return process.wait()
        except KeyboardInterrupt:
            continue  # the child got the same Ctrl-C and decides what it means
