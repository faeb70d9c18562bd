"""The generated modules belong together; if not, the reader is told which chapter to run."""

import os
import shutil
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

import omx
from book.chapters import generate
from book.setup.restore import restore
from omx.generated import CHAPTERS, NEEDED, fk, ik, jacobian
from omx.kinematics import stale, warn_if_stale

#: The chapters that must follow another DH table.
BEHIND = [CHAPTERS["ik"][:2], CHAPTERS["jacobian"][:2]]


def test_what_is_checked_in_belongs_together():
    assert stale() == []
    warn_if_stale()  # warnings are errors nowhere, so be sure that there is none


def longer_hand(*arguments):
    """The forward kinematics of an arm whose last DH row was edited: 30 mm longer."""
    *q, L1, L2, L3, L4, delta = arguments
    return fk.pose(*q, L1, L2, L3, L4 + 30, delta)


def test_an_edited_row_is_noticed_in_both():
    assert stale(SimpleNamespace(PARAMETERS=fk.PARAMETERS, pose=longer_hand)) == BEHIND


def test_an_edited_length_is_not_a_reason():
    assert stale(SimpleNamespace(PARAMETERS={**fk.PARAMETERS, "L2": 150.5}, pose=fk.pose)) == []


def test_another_parameter_is_noticed():
    def pose(*arguments):
        return fk.pose(*arguments[:-1])

    assert stale(SimpleNamespace(PARAMETERS={**fk.PARAMETERS, "a1": 12.0}, pose=pose)) == BEHIND


def test_only_the_chapter_that_is_behind_is_named():
    old = SimpleNamespace(jacobian=lambda *a: tuple(tuple(2 * x for x in row) for row in jacobian.jacobian(*a)))
    assert stale(fk, ik, old) == BEHIND[1:]


def test_the_warning_names_the_chapters(monkeypatch):
    monkeypatch.setattr("omx.kinematics.stale", lambda: BEHIND)
    with pytest.warns(UserWarning, match=" and ".join(BEHIND)):
        warn_if_stale()


# ---- what a chapter or an editor may leave behind --------------------------------------------------------

LEFT = {
    "a length of 0": ("fk", lambda text: text.replace('"L2": 130.0', '"L2": 0.0')),
    "a length beyond all numbers": ("fk", lambda text: text.replace("130.0", "inf")),
    "nothing": ("fk", lambda text: ""),
    "no file": ("fk", None),
    "a slip of the keyboard": ("fk", lambda text: text.replace("def pose(", "def pose")),
    "a function less": ("ik", lambda text: text.replace("def branches_batch(", "def other(")),
    "an import that is none": ("jacobian", lambda text: text.replace("from math import", "from maths import")),
}
ASKED = "import omx; print(omx.pose(omx.ZERO).x, omx.ik([200, 0, 150, 0])[0].legal, omx.jacobian(omx.ZERO)[2, 1])"


@pytest.fixture(scope="module")
def copied(tmp_path_factory):
    """A copy of the package."""
    root = tmp_path_factory.mktemp("damaged")
    shutil.copytree(Path(omx.__file__).parent, root / "omx", ignore=shutil.ignore_patterns("__pycache__"))
    return root


@pytest.mark.parametrize("damage", LEFT)
def test_importing_goes_on_whatever_a_chapter_has_left_and_restoring_mends_it(copied, damage):
    name, spoil = LEFT[damage]
    generated = copied / "omx" / "generated"
    path = generated / f"{name}.py"
    text = path.read_text()
    path.unlink() if spoil is None else path.write_text(spoil(text))
    command = [sys.executable, "-c", ASKED]
    environment = {**os.environ, "PYTHONPATH": str(copied), "PYTHONDONTWRITEBYTECODE": "1"}
    done = subprocess.run(command, cwd=copied, env=environment, capture_output=True, text=True, timeout=60)
    assert done.stdout == "274.0 True -274.0\n", done.stderr
    assert f"omx/generated/{name}.py cannot be used" in done.stderr
    assert "run.py generate --restore" in done.stderr
    assert restore(generated) == [f"{name}.py"]
    assert path.read_text() == text
    assert restore(generated) == []


def test_each_module_is_written_by_the_chapter_that_may_write_it():
    assert {path.stem: notebook for path, notebook in generate.sources().items()} == CHAPTERS


def test_the_modules_that_are_shipped_are_those_that_the_chapters_write():
    generated = Path(omx.__file__).parent / "generated"
    for name in [f"{module}.{kind}" for module in NEEDED for kind in ("py", "js")]:
        same = (generated / name).read_bytes() == (generated / "shipped" / name).read_bytes()
        assert same, f"{name} is not what would be restored: python run.py generate --ship"
