"""A reader's own arm to the end: with other lengths, chapters run on, or stop at a sentence that says whose arm it is.

The suite tries a few chapters; `OMX_ALL_ARMS=1` all of them.
"""

import os
import re
import shutil

import pytest

from book.chapters import execute
from book.setup import names
from book.setup.paths import ROOT
from omx import errors
from omx.arm import COURSE_LENGTHS, MAKER_LENGTHS
from omx.generated import fk

ARMS = {
    "maker": (MAKER_LENGTHS, "lab-ik"),
    "long hand": ({"L4": 186.0}, "start-here"),
    "all new": ({"L1": 75.0, "L2": 128.0, "L3": 120.0, "L4": 140.0, "delta": 0.19}, "planar-arms"),
}
ALL = os.environ.get("OMX_ALL_ARMS")
TRIED = [(arm, path) for arm, (_, few) in ARMS.items() for path in names.chapters() if ALL or few in path.stem]
KNOWN = {name for name, kind in vars(errors).items() if isinstance(kind, type) and issubclass(kind, errors.OmxError)}


@pytest.fixture(scope="module")
def packages(tmp_path_factory):
    """A copy of `omx` for each arm, with what chapter 03 writes for it: other PARAMETERS, the same formulas."""
    made = {}
    for arm, (lengths, _) in ARMS.items():
        made[arm] = tmp_path_factory.mktemp("arm")
        shutil.copytree(ROOT / "omx", made[arm] / "omx", ignore=shutil.ignore_patterns("__pycache__"))
        path = made[arm] / "omx" / "generated" / "fk.py"
        text = path.read_text(encoding="utf-8")
        for name, value in lengths.items():
            text, count = re.subn(rf'(?m)^    "{name}": .*$', f'    "{name}": {value!r},', text)
            assert count == 1
        path.write_text(text, encoding="utf-8")
    return made


@pytest.mark.parametrize(("arm", "path"), TRIED, ids=[f"{arm}-{path.stem[:2]}" for arm, path in TRIED])
def test_a_chapter_with_a_readers_arm_stops_nowhere_without_a_sentence(arm, path, packages, tmp_path):
    env = {**os.environ, "PYTHONPATH": str(packages[arm]), "OMX_GENERATED": str(tmp_path)}
    stopped = []
    for cell in execute.run(path, allow_errors=True, env=env).cells:
        stopped += [output for output in cell.get("outputs", []) if output.output_type == "error"]
    bare = [f"{error.ename} in {error.traceback}" for error in stopped if error.ename == "AssertionError"]
    assert not bare, "write `assert ... or omx.other_arm()`, where a claim is the course's arm's alone"
    if stopped:  # what follows a stop may lack its names; Run All stops there
        assert stopped[0].ename in KNOWN
        assert "Your arm is not the course's" in stopped[0].traceback[-1]
    if arm == "maker":
        assert not stopped


def test_the_course_is_what_chapter_03_writes():
    assert pytest.approx(COURSE_LENGTHS, abs=1e-15) == fk.PARAMETERS
    assert errors.OmxError.note == ""
