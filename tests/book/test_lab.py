"""`run.py lab`, really: JupyterLab answers on 127.0.0.1 and nowhere else, and leaves no process behind."""

import signal
from pathlib import Path

import psutil
import pytest

from book.chapters import normalise
from book.reader.saving import WIDGET
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


def test_the_start_ends_with_the_chapters_address_and_how_to_stop(lab, kernel):
    lab.ask(f"contents/{FIRST.relative_to(paths.ROOT).as_posix()}")
    run_in_kernel(lab, kernel, "1")
    lab.log.flush()
    said = Path(lab.log.name).read_text(encoding="utf-8").splitlines()
    first = FIRST.relative_to(paths.ROOT).as_posix()
    assert said[0].startswith(f"The book: {lab.url}/lab/tree/{first}?token=")
    assert said[0].endswith("(to stop it: Ctrl-C here, twice)")
    assert not said[1:], "a reader's terminal shows no warning that means nothing"


def test_saving_a_chapter_that_was_run_leaves_its_file_as_it_is(lab):
    """Through the server, as the browser saves: a checkout stays clean, so that an update is never in the way."""
    before, path = FIRST.read_bytes(), f"contents/{FIRST.relative_to(paths.ROOT).as_posix()}"
    model = lab.ask(path)
    for count, cell in enumerate(c for c in model["content"]["cells"] if c["cell_type"] == "code"):
        cell["execution_count"] = count + 7
        cell["outputs"].append({"output_type": "display_data", "metadata": {}, "data": {WIDGET: {"model_id": "1"}}})
    model["content"]["metadata"]["language_info"]["version"] = "3.11.99"
    try:
        lab.ask(path, {"type": "notebook", "content": model["content"]}, method="PUT")
        assert FIRST.read_bytes() == before
    finally:
        FIRST.write_bytes(before)


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
