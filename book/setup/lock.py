"""Rewrite the lower part of environment.txt: all that the upper part needs, for every system. Standard library only.

python run.py lock             keep versions that still fit
python run.py lock --newest    move every pin, above and below, to the newest version
"""

import os
import re
import shutil
import subprocess
import tempfile
from pathlib import Path

from book.setup.installers import ask, installer_environment
from book.setup.paths import ENVIRONMENT, PYTHON, Stop, package_of

MARK = "# ---- "
OLDEST_PYTHON = "3.11"


def main(arguments):
    if set(arguments) - {"--newest"}:
        raise Stop("lock takes no argument but --newest.")
    newest = bool(arguments)
    upper, lower = halves(ENVIRONMENT.read_text(encoding="utf-8"))
    pins = resolve([unpin(line) for line in upper] if newest else upper, lower, newest)
    if newest:
        upper = [repin(line, pins) for line in upper]
    chosen = {package_of(line) for line in upper}
    lower = [line for line in pins if package_of(line) not in chosen]
    partial = ENVIRONMENT.with_suffix(".part")
    partial.write_text("\n".join(upper + lower) + "\n", encoding="utf-8", newline="\n")
    os.replace(partial, ENVIRONMENT)
    print(f"environment.txt: {len(chosen - {''})} packages by hand, {len(lower)} that they need.")
    return 0


def halves(text):
    """The lines up to and with the marked one, and those below it."""
    lines = text.splitlines()
    for number, line in enumerate(lines, 1):
        if line.startswith(MARK):
            return lines[:number], lines[number:]
    raise Stop(f"environment.txt has no line that begins with {MARK!r}; restore it from the repository.")


def resolve(wanted, known, newest):
    """The requirement lines, each with a version and a marker, that uv finds for the wanted ones."""
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder, "wanted.txt"), Path(folder, "locked.txt")
        source.write_text("\n".join(wanted) + "\n", encoding="utf-8")
        target.write_text("\n".join(known) + "\n", encoding="utf-8")  # uv keeps the versions it finds here
        options = ["--universal", "--python-version", OLDEST_PYTHON, "--no-annotate", "--no-header", "--quiet"]
        command = [*uv(), "pip", "compile", source, "--output-file", target, *options]
        if newest:
            command.append("--upgrade")
        if subprocess.call(command, env=installer_environment(command)):
            raise Stop("The versions cannot be resolved (see above); environment.txt is as it was.")
        return [line for line in target.read_text(encoding="utf-8").splitlines() if package_of(line)]


def uv():
    """uv from the PATH, or from an environment, which need not fit environment.txt any more."""
    if found := shutil.which("uv"):
        return [found]
    if not ask("-m", "uv", "--version")[0]:
        from book.setup import set_up

        set_up.set_up()
    return [PYTHON, "-m", "uv"]


def unpin(line):
    """A requirement without its version: `name==version ; marker` -> `name ; marker`."""
    return re.sub(r"==[^ ;#]+", "", line) if package_of(line) else line


def repin(line, pins):
    """A requirement with the version that was found for it; its marker and comment stay."""
    versions = [re.search(r"==([^ ;]+)", pin)[1] for pin in pins if package_of(pin) == package_of(line)]
    return re.sub(r"==[^ ;#]+", "==" + versions[-1], line) if package_of(line) and versions else line
