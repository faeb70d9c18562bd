"""What is optional is tested all the same: with numba and dask, or MuJoCo, in environments of their own.

Without a package index it cannot be made: then this is skipped, but on CI it fails.
"""

import contextlib
import subprocess
from xml.etree import ElementTree

import psutil
import pytest

from book.setup import extra_envs
from book.setup.paths import ROOT, Stop
from tests.conftest import ON_CI

MODULES = ("tests/analysis/test_compiled.py", "tests/analysis/test_workspace_maps.py")
ARRAYS = "tests/analysis/test_arrays_of_others.py"
READERS = "tests/exchange/test_urdf_readers.py"
MARK = "OMX_OPTIONAL_RUN"
TIMEOUT_S = 600  # it takes half a minute on a machine that is not busy


@pytest.fixture(scope="module")
def python():
    try:
        return extra_envs.python("fast")
    except Stop as stop:
        (pytest.fail if ON_CI else pytest.skip)(str(stop))


@pytest.fixture(scope="module")
def cases(python, tmp_path_factory):
    """Every test of the modules, run where numba and dask are: name -> why it was skipped, or None."""
    return run_in("fast", python, MODULES, tmp_path_factory.mktemp("optional"))


def run_in(name, python, modules, folder):
    """The modules' tests in an environment of their own: name -> why it was skipped, or None."""
    report = folder / "report.xml"
    command = [python, "-m", "pytest", "-q", "-p", "no:cacheprovider", f"--junitxml={report}", *modules]
    run = subprocess.run(
        command, cwd=ROOT, env={**extra_envs.variables(name), MARK: str(report)}, capture_output=True, text=True,
        timeout=TIMEOUT_S, check=False,
    )  # fmt: skip
    assert run.returncode == 0, run.stdout[-5000:] + run.stderr[-2000:]
    assert psutil.wait_procs(marked(str(report)), timeout=15)[1] == [], "the run has left processes behind"
    found = ElementTree.parse(report).iter("testcase")
    return {case.get("name"): skipped_because(case) for case in found}


def marked(value):
    """The processes that were started with the mark."""
    found = []
    for process in psutil.process_iter():
        with contextlib.suppress(psutil.Error):
            if process.environ().get(MARK) == value:
                found.append(process)
    return found


def skipped_because(case):
    skipped = case.find("skipped")
    return None if skipped is None else skipped.get("message")


def test_the_environment_has_the_versions_of_environment_txt(python):
    show = "from importlib.metadata import version; print(*map(version, ('numba', 'dask', 'distributed')))"
    told = subprocess.run([python, "-c", show], capture_output=True, text=True, timeout=60, check=True).stdout.split()
    numba, dask = (requirement.split("==")[1] for requirement in extra_envs.requirements("fast"))
    assert told == [numba, dask, dask]


def test_nothing_is_skipped_for_want_of_numba_or_dask(cases, capsys):
    assert [name for name, why in cases.items() if why and "not installed" in why] == []
    ran = [name for name, why in cases.items() if why is None]
    with capsys.disabled():
        print(f"\nwith numba and dask: {len(ran)} tests passed, {len(cases) - len(ran)} had nothing to test")


def test_a_dask_cluster_counted(cases):
    assert cases["test_counts_do_not_depend_on_a_cluster_that_listens_on_the_loopback_address"] is None


def test_the_formulas_serve_the_arrays_of_jax_dask_and_the_standard(tmp_path):
    """JAX, Dask and the strict form of the array API standard: nothing is skipped where they are."""
    try:
        cases = run_in("arrays", extra_envs.python("arrays"), [ARRAYS], tmp_path)
    except Stop as stop:
        (pytest.fail if ON_CI else pytest.skip)(str(stop))
    assert len(cases) > 20
    assert [name for name, why in cases.items() if why and "[torch" not in name and "[cupy" not in name] == []


def test_yourdfpy_and_mujoco_read_the_urdf_that_we_write(tmp_path):
    try:
        cases = run_in("urdf", extra_envs.python("urdf"), [READERS], tmp_path)
    except Stop as stop:
        (pytest.fail if ON_CI else pytest.skip)(str(stop))
    assert len(cases) > 12
    assert [name for name, why in cases.items() if why and "pinocchio" not in name] == []
