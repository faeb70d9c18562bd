"""Runs in the reader's browser, in a worker beside the page (book/static/edit.js), in Python as it lies in `lite/`.

The chapter's own derivation, with the lines that its reader changed, is run by the package as in a notebook; what it
writes and the arm that it makes go back to the page. Nothing here derives, writes or draws by itself.
"""

import difflib
import math
import time
from pathlib import Path
from types import ModuleType

import omx
from omx.derive.store import GENERATED
from omx.display.viewer import View
from omx.display.viewer.arm_data import arm_data, chain_data
from omx.display.viewer.arm_model import is_our_arm
from omx.display.viewer.assets import as_expression
from omx.generated import CHAPTERS
from omx.kinematics import stale


def again(chapters, limits=None, ghosts=0):
    """Run what `editable_lines.py` took of the chapters: what they write, and the arm; or `refused`, in a sentence.

    `limits`: those of the joints, if the arm is a chain. `ghosts`: how many pale arms the page's scene holds.
    """
    start = time.perf_counter()
    try:
        modules = [run(chapter) for chapter in chapters]
        arm = arm_of(modules, limits, ghosts)
    except Exception as error:  # a reader may write anything
        return {"refused": sentence(error)}
    files = [file for module in modules for file in texts(module)]
    return {"files": files, "arm": arm, "seconds": time.perf_counter() - start}


def run(chapter):
    """The module that a chapter writes, freshly loaded."""
    names = {"__name__": "__main__", "display": lambda *_: None}
    for piece in chapter["pieces"]:
        what = piece.get("edit", chapter["name"])
        exec(compile(piece["code"], f"<{what}>", "exec"), names)
    found = [value for value in names.values() if isinstance(value, ModuleType)]
    return next(module for module in found if module.__name__.rpartition(".")[2] == chapter["module"])


def texts(module):
    """The two files of a module, Python and JavaScript: where they stand, and their text."""
    path = Path(module.__file__)
    place = "omx/generated/" if path.parent == GENERATED else ""
    return [
        {"name": f"{place}{file.name}", "text": file.read_text(encoding="utf-8")}
        for file in (path, path.with_suffix(".js"))
    ]


def sentence(error):
    """What was wrong, as the package says it; of Python's own errors the kind and, if it has one, the line."""
    if isinstance(error, omx.OmxError):
        return str(error)
    if isinstance(error, SyntaxError):
        return f"Line {error.lineno} of {error.filename.strip('<>')} cannot be read: {error.msg}."
    return f"{type(error).__name__}: {error}"


def difference(before, after):
    """The lines that are gone (`-`), new (`+`) and beside them (` `), as pairs; `@` where some are left out."""
    lines = difflib.unified_diff(before.splitlines(), after.splitlines(), n=2, lineterm="")
    return [(line[0], "" if line[0] == "@" else line[1:]) for line in list(lines)[2:]]


def arm_of(modules, limits, ghosts):
    """The arm of the first module as the page wants it: all about it, its formulas, and the commands that draw it."""
    first, *_ = modules
    if first.__name__ == "omx.generated.fk":
        arm = omx.Geometry("your arm", **first.PARAMETERS)
        view = View(geometry=arm)
        view.ghosts([omx.HOME] * ghosts)
        about = arm_data(arm) if is_our_arm(arm) else chain_data(arm.chain, arm.chain.limits)
    else:
        rows = first.dh_rows(*getattr(first, "PARAMETERS", {}).values())
        chain = omx.Chain(rows, as_limits(limits, len(rows)))
        view = View.of_chain(chain)
        about = chain_data(chain, chain.limits)
    own = [module for module in modules if module.__name__.startswith("omx.generated.")]
    return {
        "about": about,
        "stale": bool(own) and CHAPTERS["ik"][:2] in stale(),
        "modules": {module.__name__.rpartition(".")[2]: as_expression(texts(module)[1]["text"]) for module in own},
        "commands": [
            {"type": kind, "path": path, "bytes": data}
            for (kind, path, _), data in view.channel.log.items()
            if kind == "set_object" and path.startswith(("/meshcat/arm", "/meshcat/ghosts"))
        ],
    }


def as_limits(limits, joints):
    """The page's limits, where None is no end; none at all for another number of joints."""
    if not limits or len(limits) != joints:
        return None
    return [(-math.inf if low is None else low, math.inf if high is None else high) for low, high in limits]
