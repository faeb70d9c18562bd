"""`run.py lab`, really: JupyterLab answers on 127.0.0.1 and nowhere else, and leaves no process behind."""

import signal

import psutil
import pytest

from book.chapters import normalise
from book.setup import paths
from tests.helpers.lab import run_in_kernel, running_lab

FIRST = sorted(normalise.NOTEBOOKS.glob("*.ipynb"))[0]
SCENE = "import omx.display.viewer\nview = omx.display.viewer.View()\nview"


@pytest.fixture(scope="module")
def lab(tmp_path_factory):
    with running_lab(tmp_path_factory.mktemp("lab")) as lab:
        yield lab


@pytest.fixture
def kernel(lab):
    """The id of a kernel on the first chapter, as a browser would start it."""
    path = FIRST.relative_to(paths.ROOT).as_posix()
    body = {"path": path, "name": FIRST.name, "type": "notebook", "kernel": {"name": "python3"}}
    session = lab.ask("sessions", body)
    return session["kernel"]["id"]


def test_a_chapter_with_a_scene_opens_no_port(lab, kernel):
    pid, folder = run_in_kernel(lab, kernel, "import os\nprint(os.getpid(), os.path.basename(os.getcwd()))").split()
    assert folder == "notebooks"
    assert int(pid) in {process.pid for process in lab.tree()}
    before = lab.listening()  # the server's port and the kernel's own
    assert ("127.0.0.1", lab.port) in before
    run_in_kernel(lab, kernel, SCENE)
    assert lab.listening() == before
    assert {address for address, _ in before} == {"127.0.0.1"}


def test_a_killed_kernel_leaves_no_process(lab, kernel):
    pid = int(run_in_kernel(lab, kernel, f"{SCENE}\nimport os\nprint(os.getpid())"))
    process = psutil.Process(pid)
    below = process.children(recursive=True)
    process.send_signal(signal.SIGKILL if not paths.WINDOWS else signal.SIGTERM)
    _, left = psutil.wait_procs([process, *below], timeout=10)
    assert not left


def test_a_stopped_lab_leaves_no_process(tmp_path):
    with running_lab(tmp_path) as lab:
        lab.ask("kernels", {"name": "python3"})
        processes = lab.tree()
        assert len(processes) >= 2
        assert lab.stop() == []
    assert not [process for process in processes if process.is_running()]
