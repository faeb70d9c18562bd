#!/usr/bin/env python3
"""The one launcher of the book.

    python run.py lab          open the book in JupyterLab; the first time this sets everything up
    python run.py test         run every test
    python run.py              list all commands

It needs Python 3.11 or newer and nothing else. This file itself stays readable for any Python, so that
one that is too old can say so; the work is done in book/setup/launch.py.
"""

import os
import subprocess
import sys

OLDEST = (3, 11)
NEWER = ("3.14", "3.13", "3.12", "3.11")


def too_old():
    """The sentence for a Python that is too old; it names a newer one when this machine has it."""
    found = [number for number in NEWER if starts("python" + number)]
    if found:
        hint = "this machine has a newer one: type python" + found[0] + " run.py"
    elif sys.platform == "win32":
        hint = "install a newer one and type py -3 run.py"
    else:
        hint = "install a newer one and start run.py with it"
    sentence = "This is Python {}.{} ({}), but the book needs {}.{} or newer; {}."
    return sentence.format(sys.version_info[0], sys.version_info[1], sys.executable, OLDEST[0], OLDEST[1], hint)


def starts(command):
    """Does this command start? A name on the PATH may be an empty shim."""
    with open(os.devnull, "w") as nowhere:
        try:
            return subprocess.call([command, "-c", ""], stdout=nowhere, stderr=nowhere) == 0
        except OSError:
            return False


if __name__ == "__main__":
    if sys.version_info[:2] < OLDEST:
        sys.exit("run.py: " + too_old())
    sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))  # left out by PYTHONSAFEPATH, -P and -I
    from book.setup import launch

    sys.exit(launch.main(sys.argv[1:]))
