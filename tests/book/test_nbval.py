"""The comparison of stored outputs has eyes: it sees what changed, and only that; its kernels leave quietly."""

import os
import subprocess
import sys
from pathlib import Path

import psutil
import pytest

from book.chapters import execute, normalise
from book.setup.paths import ROOT
from tests.helpers.chapter import code, markdown

GOODBYE = """import atexit, os, pathlib
assert os.path.isdir(os.environ["OMX_GENERATED"])
pathlib.Path("pid").write_text(str(os.getpid()))
_ = atexit.register(pathlib.Path("goodbye").touch)"""
CELLS = {
    "number": "print(6 * 7, 'mm')",
    "beside a figure": "import matplotlib.pyplot as plt\nprint('drawn')\nplt.plot([0, 1])\nplt.show()",
    "beside a widget": "import ipywidgets\nprint('shown')\nipywidgets.IntSlider()",
    "latex": "import sympy\nsympy.Symbol('x')**2",
    "new output": "a = 6",
    "lost output": "print(6)",
    "kernel": GOODBYE,
}
EXERCISE = [
    markdown("### Exercise 99.1 \N{MIDDLE DOT} half of it", tags=["exercise"]),
    code("half = 21", tags=["solution"]),
    code("from omx import check\ncheck.value(half, 21, 'half')", tags=["check"]),
]
EDITS = (  # what a stored notebook holds, what it holds after the edit
    ('"42 mm', '"41 mm'),
    ('"drawn', '"draw'),
    ('"shown', '"show'),
    ("x^{2}", "x^{3}"),
    ('"a = 6"', '"a = 6; print(a)"'),
    ('"print(6)"', '"b = 6"'),
    ("check.value(half, 21, 'half')", "check.that(half != 42, 'Half.', 'half')"),  # of wrong answers it refuses one
)


def validate(path):
    """Run pytest with this book's settings on one notebook; (exit status, output)."""
    command = [sys.executable, "-m", "pytest", "-c", str(ROOT / "pyproject.toml")]
    command += ["--color=no", "-p", "no:cacheprovider", str(path)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=120, check=False)
    return done.returncode, done.stdout + done.stderr


@pytest.fixture(scope="module")
def stored(tmp_path_factory):
    """A notebook of all these cells, executed and stored."""
    path = tmp_path_factory.mktemp("nbval") / "scratch.ipynb"
    cells = [markdown("# Scratch"), *map(code, CELLS.values()), *EXERCISE]
    normalise.write(path, normalise.normalise({"cells": cells, "nbformat": 4}))
    execute.execute(path)
    return path


def test_an_unchanged_notebook_passes_and_its_kernel_leaves_politely(stored):
    (stored.parent / "goodbye").unlink(missing_ok=True)
    status, said = validate(stored)
    assert status == 0, said
    assert f"{len(CELLS) + 2} passed" in said
    assert (stored.parent / "goodbye").exists()
    assert not psutil.pid_exists(int((stored.parent / "pid").read_text()))


def test_each_stale_output_fails(stored, tmp_path):
    text = stored.read_text()
    for old, new in EDITS:
        assert text.count(old) == 1
        text = text.replace(old, new)
    stale = tmp_path / "stale.ipynb"
    stale.write_text(text)
    status, said = validate(stale)
    assert status == 1, said
    assert f"{len(EDITS)} failed, {len(CELLS) + 2 - len(EDITS)} passed" in said
    assert "Unexpected output" in said
    assert "Missing output" in said
    assert "this wrong answer is accepted: half: sign" in said
    assert "this wrong answer is accepted: half: twice" not in said


def test_notebooks_write_modules_into_a_scratch_folder_only():
    folder = Path(os.environ["OMX_GENERATED"])
    assert folder.is_dir()
    assert ROOT not in folder.parents
