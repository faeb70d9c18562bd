"""The commands of run.py: set up if need be, then become the tool that was asked for.

Standard library only. A later start adds little to the tool's own: nothing heavy is imported here, and the
tool replaces this process.
"""

import difflib
import os
import subprocess
import sys
from typing import NamedTuple

from book.setup.paths import PYTHON, ROOT, WINDOWS, Stop, child_environment, has_home, is_ready, own_home


class Command(NamedTuple):
    """A command of run.py: it exists when `needs` does; `calls` are run by .venv's Python one by one."""

    name: str
    needs: str
    calls: tuple[str, ...]
    help: str


COMMANDS = (
    Command("lab", "notebooks", ("-m book.reader.lab",), "open the book: lab [chapter] [JupyterLab's own options]"),
    Command("update", "notebooks", ("-m book.reader.folder update",), "bring in a new edition and keep all answers"),
    Command("reset", "notebooks", ("-m book.reader.folder reset",), "a chapter as it was; yours is kept: reset 03"),
    Command("solution", "notebooks", ("-m book.reader.solutions",), "show the solution of an exercise: solution 3.1"),
    Command("handin", "notebooks", ("-m book.reader.handin",), "a chapter and its results as one HTML file: handin 03"),
    Command(
        "export", "book/reader/export.py", ("-m book.reader.export",), "the arm as a file for ROS, MuJoCo: export urdf"
    ),
    Command("test", "tests", ("-m pytest -n 2",), "run every test: test [pytest's own options, or lite]"),
    Command("check", "book/chapters/check.py", ("-m book.chapters.check",), "lint code and chapters: check [chapter]"),
    Command("new-chapter", "book/chapters/new.py", ("-m book.chapters.new",), "begin a chapter: new-chapter TOPIC"),
    Command("generate", "notebooks", ("-m book.chapters.generate",), "write omx/generated anew [--check, --restore]"),
    Command("execute", "tests", ("-m book.chapters.execute",), "run notebooks again and store their outputs"),
    Command("student", "book/chapters/edition.py", ("-m book.chapters.edition",), "sheets for students [--edition]"),
    Command("book", "book/publish/site.py", ("-m book.publish.site",), "build the site in build/site [--serve]"),
    Command("slides", "book/publish/slides.py", ("-m book.publish.slides",), "build the slides in build/slides"),
    Command("lite", "book/publish/lite.py", ("-m book.publish.lite",), "the book for a browser alone: build/lite"),
    Command("bench", "tests/bench", ("-m tests.bench",), "measure the kinematics against other code [--report]"),
    Command("doctor", "omx/hardware/doctor", ("-m omx.hardware.doctor",), "find out why the arm does not answer"),
    Command("repair", "environment.txt", (), "look whether all packages are whole, and mend them"),
    Command("lock", "book/setup/lock.py", (), "rewrite the lower part of environment.txt [--newest]"),
)

#: What `--help` prints behind a command's name, at once; the other commands have a parser that answers.
USAGE = {
    "lab": """ [CHAPTER] [--author] [JupyterLab's own options]

Opens JupyterLab on your own copies of the chapters, in work/; the first time it sets everything up.

  CHAPTER       03, or words of its name: forward; the first one if left out
  --author      the chapters themselves, with their solutions
  --no-browser  only say the address; `lab --help-all` lists all options of JupyterLab""",
    "update": """ [FOLDER]

Brings in a new edition, by git where this is a checkout. What you wrote in work/ stays, carried over cell by cell.

  FOLDER        another copy of the book: your work there comes along""",
    "reset": """ CHAPTER [CHAPTER ...]

Gives a chapter out again, as it was; yours is kept in work/earlier. For example: reset 03""",
    "solution": """ EXERCISE

Prints the solution of an exercise. For example: solution 3.1""",
    "test": """ [lite] [pytest's own options]

Runs every test: units, stored outputs, conventions, browser. `test tests -k ik` runs some.

  lite          every chapter in a browser's Python
  all other options are pytest's; `python -m pytest --help`, by .venv's Python, lists them""",
    "check": """ [CHAPTER ...]

Lints code and chapters in seconds: ruff, the types of the mathematics, the conventions of all chapters or of some.""",
    "new-chapter": """ TOPIC

Writes the skeleton of the next chapter. For example: new-chapter light-and-shadow""",
    "generate": """ [--check | --ship | --restore]

Runs the chapters that write omx/generated.

  --check       only compare, write nothing
  --ship        write, and make it what is restored later
  --restore     run nothing, put back what the book ships""",
    "repair": """

Looks whether all packages of .venv are whole, and installs what is missing.""",
    "lock": """ [--newest]

Rewrites the lower part of environment.txt; versions that still fit stay.

  --newest      move every pin to its newest version""",
}


def main(argv):
    """Run one command line; the exit status."""
    open_streams()
    commands = {command.name: command for command in COMMANDS if (ROOT / command.needs).exists()}
    try:
        if not argv or argv[0] in ("-h", "--help", "help"):
            listed = "\n".join(f"  {command.name:<13}{command.help}" for command in commands.values())
            print(f"usage: python run.py COMMAND [...]\n\n{listed}", flush=True)
            return 0
        if argv[0] not in commands:
            near = difflib.get_close_matches(argv[0], commands, 1, 0.7)
            meant = f"; did you mean {near[0]!r}? `python run.py`" if near else ". `python run.py`"
            raise Stop(f"There is no command {argv[0]!r}{meant} lists them all.")
        if argv[0] in USAGE and {"-h", "--help"} & set(argv[1:]):  # a question needs no set-up
            print("usage: python run.py", argv[0] + USAGE[argv[0]])
            return 0
        return run(commands[argv[0]], argv[1:])
    except Stop as stop:
        print(f"run.py: {stop}", file=sys.stderr)
        return 1
    except OSError as error:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # what is left unsaid must not be an error again at the end
        if not isinstance(error, BrokenPipeError):  # whoever read along has gone
            print(f"run.py: It stops here ({error}).", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("\nrun.py: Interrupted; the same command takes it up again.", file=sys.stderr)
        return 130


def open_streams():
    """Give closed standard streams a place to go, and let odd letters in a path pass on any terminal."""
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the lowest free number, which is this one
    for name in ("stdin", "stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, "r" if name == "stdin" else "w", encoding="utf-8"))  # noqa: SIM115
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")


def run(command, arguments):
    """Set up if need be, then hand over to the command's tools."""
    if command.name == "lock":  # works on an environment.txt that cannot be installed, too
        from book.setup import lock

        return lock.main(arguments)
    if command.name == "generate" and "--restore" in arguments:  # the same for what a chapter has broken
        from book.setup import restore

        return restore.main()
    if command.name == "update" and "--carry-over" not in arguments:
        from book.setup import update

        update.pull()
        return update.go_on(arguments)  # with the code that has just come
    if command.name == "repair" or not is_ready():
        from book.setup import set_up

        set_up.set_up(repair=command.name == "repair")
    if command.name == "repair":
        return 0
    if command.name == "doctor":
        from book.setup import set_up

        set_up.must_import("numpy", "serial", "dynamixel_sdk")
    arguments = [os.path.abspath(word) if os.path.isfile(word) else word for word in arguments]  # tools start in ROOT
    if command.name == "test" and arguments[:1] == ["lite"]:  # every chapter in a browser's Python, for some minutes
        arguments = ["tests/browser/lite_chapters.py", *arguments[1:]]
    *first, last = (call.split() for call in command.calls)
    for call in first:
        if status := wait_for(call):
            return status
    return hand_over([*last, *arguments])


def hand_over(arguments):
    """Become .venv's Python with these arguments; on Windows, where that goes wrong, wait for it."""
    if WINDOWS:
        return wait_for(arguments)
    sys.stdout.flush()
    if not (has_home() or has_home(own_home())):
        raise Stop("Neither your home folder nor .venv can be written: let HOME name a folder that can.")
    os.chdir(ROOT)
    try:
        os.execve(PYTHON, [str(PYTHON), *arguments], child_environment())
    except OSError as error:
        raise Stop(f"{PYTHON} does not start ({error.strerror}); `python run.py repair` mends it.") from error


def wait_for(arguments):
    """Run .venv's Python with these arguments in the root; its exit status."""
    process = subprocess.Popen([PYTHON, *arguments], cwd=ROOT, env=child_environment())
    while True:
        try:
            return process.wait()
        except KeyboardInterrupt:
            continue  # the child got the same Ctrl-C and decides what it means
