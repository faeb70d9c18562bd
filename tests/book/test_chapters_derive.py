"""A reader's own arm: chapter 03 with an edited length and DH rows, then 04 and 05, in a copy of the package."""

import json
import os
import shutil
import subprocess
import sys

import pytest

import omx
from book.chapters import execute, normalise
from omx.derive.store import GENERATED

DERIVATIONS = ("03-forward-kinematics", "05-inverse-kinematics", "07-jacobian")

#: What a reader changes in chapter 03: a length, an offset, and a hand that carries a tool of 20 mm.
EDITS = (
    ("L2: 130,", "L2: 150,"),
    ("DHRow(theta=0, d=0, a=L4, alpha=0)", "DHRow(theta=0.1, d=0, a=L4 + 20, alpha=0)"),
)

#: Run in the copy: what it has become, told as JSON.
LOOK = """
import json
import numpy as np
import omx
from omx import check
from omx.display.viewer import View

qs = check.configurations(30)
h = 1e-5 * np.eye(4)
slopes = [np.transpose([(omx.fk(q + d) - omx.fk(q - d))[:3, 3] / 2e-5 for d in h]) for q in qs]
found = omx.ik_batch(omx.pose(qs))[0]
away = np.abs(np.angle(np.exp(1j * (found - qs[:, None]))))
print(json.dumps({
    "L2": omx.COURSE.L2,
    "tip": omx.pose(omx.ZERO),
    "view": repr(View(omx.ZERO)),
    "fk": float(np.abs(omx.fk(qs) - omx.COURSE.chain.fk(qs)).max()),
    "ik": float(np.nanmin(away.max(axis=2), axis=1).max()),
    "jacobian": float(np.abs(omx.jacobian(qs)[:, :3] - slopes).max()),
}))
"""


def before_the_exercises(notebook):
    """The chapter without its exercises, whose solutions are for the course's arm."""
    first = next(i for i, cell in enumerate(notebook["cells"]) if "".join(cell["source"]).startswith("## Exercises"))
    return {**notebook, "cells": notebook["cells"][:first]}


@pytest.fixture(scope="module")
def edited(tmp_path_factory):
    """What the copy says about itself after its three derivations have run with the edits."""
    root = tmp_path_factory.mktemp("reader")
    shutil.copytree(GENERATED.parent, root / "omx", ignore=shutil.ignore_patterns("__pycache__"))
    (root / "notebooks").mkdir()
    environment = {key: value for key, value in os.environ.items() if key != "OMX_GENERATED"}
    environment["PYTHONPATH"] = str(root)
    for name in DERIVATIONS:
        text = (normalise.NOTEBOOKS / f"{name}.ipynb").read_text(encoding="utf-8")
        for old, new in EDITS if name == DERIVATIONS[0] else ():
            assert text.count(old) == 1, f"chapter 03 does not hold `{old}` exactly once"
            text = text.replace(old, new)
        path = root / "notebooks" / f"{name}.ipynb"
        path.write_text(json.dumps(before_the_exercises(json.loads(text))), encoding="utf-8")
        execute.run(path, env=environment)
    command = [sys.executable, "-c", LOOK]
    done = subprocess.run(command, cwd=root, env=environment, capture_output=True, text=True, timeout=120, check=True)
    return json.loads(done.stdout)


def test_the_new_length_and_rows_are_what_course_means(edited):
    assert edited["L2"] == 150
    own = omx.COURSE.replace(L2=150, L4=146)
    x, y, z, pitch = omx.pose((0, 0, 0, 0.1), own)
    assert edited["tip"] == pytest.approx([x, y, z, pitch], abs=1e-9)
    assert f"tool at x = {x:.1f}, y = 0.0, z = {z:.1f} mm" in edited["view"]


def test_the_chapters_after_it_follow(edited):
    assert edited["fk"] < 1e-9
    assert edited["ik"] < 1e-6
    assert edited["jacobian"] < 1e-4


def test_the_checked_in_arm_is_untouched(edited):
    assert omx.pose(omx.ZERO).x == pytest.approx(274)
    assert omx.COURSE.L2 == 130
