"""Running notebooks: outputs are stored on success only, failures name the cell, kernels go away."""

import psutil
import pytest

from book.chapters import execute, generate, normalise
from book.setup import paths
from tests.helpers.chapter import code, markdown


def notebook(tmp_path, *sources):
    path = tmp_path / "scratch.ipynb"
    cells = [markdown("# Scratch"), *(s if isinstance(s, dict) else code(s) for s in sources)]
    normalise.write(path, normalise.normalise({"cells": cells, "nbformat": 4}))
    return path


def test_outputs_are_stored_and_a_second_run_changes_nothing(tmp_path, capsys):
    path = notebook(tmp_path, "import pathlib", f"print(pathlib.Path.cwd().name == {tmp_path.name!r})")
    assert execute.main([str(path)]) == 0
    assert "outputs stored" in capsys.readouterr().out
    assert normalise.read(path)["cells"][2]["outputs"][0]["text"] == ["True\n"]
    assert execute.main([str(path)]) == 0
    assert "nothing changed" in capsys.readouterr().out


def test_a_failing_cell_is_named_and_the_file_stays(tmp_path, capsys):
    path = notebook(tmp_path, "print(1)", "x = 0\n1 / x")
    before = path.read_bytes()
    assert execute.main([str(path)]) == 1
    said = capsys.readouterr().err
    assert "scratch.ipynb failed at cell 3" in said
    assert "    1 / x" in said
    assert "ZeroDivisionError: division by zero" in said
    assert "\x1b[" not in said
    assert path.read_bytes() == before


def test_an_endless_cell_is_stopped(tmp_path, capsys):
    path = notebook(tmp_path, "import time\nwhile True:\n    time.sleep(0.01)")
    assert execute.main(["--timeout", "3", str(path)]) == 1
    assert "Stopped after 3 s" in capsys.readouterr().err


def test_a_dying_kernel_is_told(tmp_path):
    with pytest.raises(execute.Failed, match="The kernel died"):
        execute.run(notebook(tmp_path, "import os; os._exit(1)"))


@pytest.mark.skipif(paths.WINDOWS, reason="there Ctrl-C is no signal to a process")
@pytest.mark.parametrize("way", ["execute", "generate"])
@pytest.mark.parametrize(
    "when", ["press()\ntime.sleep(60)", "import atexit\natexit.register(press)"], ids=["runs", "ends"]
)
def test_ctrl_c_ends_the_kernel_and_is_said_in_a_sentence(tmp_path, monkeypatch, capfd, way, when):
    cell = "import os, signal, time\nprint(os.getpid(), file=open('kernel', 'w'), flush=True)\n"
    press = "def press():\n    os.kill(os.getppid(), signal.SIGINT)\n    time.sleep(0.3)\n"
    path = notebook(tmp_path, cell + press + when)
    monkeypatch.setattr(generate, "NOTEBOOKS", tmp_path)
    run = {"execute": lambda: execute.main([str(path)]), "generate": lambda: generate.run_notebook(path.stem, tmp_path)}
    assert paths.in_a_sentence(run[way])() == 130
    assert capfd.readouterr().err.endswith("run.py: Interrupted.\n")
    assert not psutil.pid_exists(int((tmp_path / "kernel").read_text()))


def test_deliberate_errors_are_stored(tmp_path):
    path = notebook(tmp_path, code("int('x')", tags=["raises-exception"]), "print('on')")
    assert execute.main([str(path)]) == 0
    error, text = (cell["outputs"][0] for cell in normalise.read(path)["cells"][1:])
    assert error["ename"] == "ValueError"
    assert text["text"] == ["on\n"]


def test_no_process_and_no_folder_stays(tmp_path, monkeypatch):
    path = notebook(tmp_path, "import os; print(os.getpid())")
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    ran = execute.run(path)
    assert not psutil.pid_exists(int(ran.cells[1].outputs[0].text))
    assert [p.name for p in tmp_path.iterdir()] == ["scratch.ipynb"]
