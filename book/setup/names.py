"""One rule for how a chapter is named on a command line. Standard library only.

A path opens that file; all else is a chapter's number (`3`, `03`) or words of its name (`forward`).
"""

import os
import re
from pathlib import Path

from book.setup.paths import NOTEBOOKS, Stop

FILE_NAME = re.compile(r"\d\d-[a-z0-9]+(-[a-z0-9]+)*\.ipynb")  # not the `-Copy1` that JupyterLab makes


def chapters():
    """The paths of all chapters, in order."""
    return [path for path in sorted(NOTEBOOKS.glob("*.ipynb")) if FILE_NAME.fullmatch(path.name)]


def chapter(name, folder=NOTEBOOKS):
    """The path that a name on the command line means; a chapter's, in `folder`, unless the name is a path.

    Raises `Stop` where nothing, or more than one, fits.
    """
    if os.path.isfile(name):
        return Path(os.path.abspath(name))
    if os.path.basename(name) != name or name.startswith("."):
        raise Stop(f"There is no file {name!r}; a chapter is named by its number or words of its name: 03, forward.")
    paths, word = chapters(), re.sub(r"[\s_]+", "-", name.lower().removesuffix(".ipynb"))
    rules = (
        lambda stem: word == stem,
        lambda stem: word.isdecimal() and int(word) == int(stem[:2]),
        lambda stem: not word.isdecimal() and word in stem,
    )
    found = next((hits for rule in rules if (hits := [path for path in paths if rule(path.stem)])), [])
    if len(found) == 1:
        return Path(folder, found[0].name)
    told = ", ".join(path.stem for path in found or paths)
    if found:
        raise Stop(f"{name!r} fits more than one chapter: {told}.")
    raise Stop(f"There is no chapter {name!r}; the chapters are {told}.")
