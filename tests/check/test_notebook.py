"""In a kernel: a check cell never shows a traceback, a passed one its tick, and progress stays in one local file."""

import json

import pytest
from jupyter_client.manager import start_new_kernel

from omx.check import passed
from tests.helpers.chapter import chapter, code, markdown

SECOND = [
    markdown("### Exercise 7.2 · Half of it\n\n*Difficulty 2 of 5, about 10 minutes.*", tags=["exercise"]),
    code("half = 3.0", tags=["solution"]),
    code("check.value(half, 3.0, 'half')", tags=["check"]),
]


CELLS = [*chapter(), *SECOND]
#: The id of the last check.
CHECK = f"cell-{len(CELLS) - 1}"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with one notebook of two exercises."""
    made = tmp_path_factory.mktemp("work")
    cells = [{**cell, "id": f"cell-{n}"} for n, cell in enumerate(CELLS)]
    (made / "07-lines.ipynb").write_text(json.dumps({"cells": cells}), encoding="utf-8")
    (made / "broken.ipynb").write_text("{}")
    return made


@pytest.fixture(scope="module")
def run(folder):
    """Run a cell as JupyterLab does, with its id; (error as shown, printed text, displayed text)."""
    manager, client = start_new_kernel(cwd=str(folder))

    def run(code, cell=CHECK):
        message = client.session.msg("execute_request", {"code": code, "silent": False, "store_history": True})
        message["metadata"]["cellId"] = cell
        client.shell_channel.send(message)
        error, printed, shown = "", "", ""
        while True:
            reply = client.get_iopub_msg(timeout=60)
            if reply["parent_header"].get("msg_id") != message["header"]["msg_id"]:
                continue
            content = reply["content"]
            if reply["msg_type"] == "error":
                error = "\n".join(content["traceback"])
            printed += content["text"] if reply["msg_type"] == "stream" else ""
            shown += content["data"]["text/plain"] if reply["msg_type"] == "display_data" else ""
            if reply["msg_type"] == "status" and content["execution_state"] == "idle":
                return error, printed, shown

    run("import numpy as np\nimport omx\nfrom omx import check")
    yield run
    client.stop_channels()
    manager.shutdown_kernel(now=True)


@pytest.mark.parametrize(
    ("cell", "sentence"),
    [
        ("f = lambda: None\na, b = f()\ncheck.value(a, 1)", "TypeError: cannot unpack non-iterable NoneType"),
        ("half = ...\ncheck.that(half > 3, 'no')", "Not yet. half is still the TODO"),
        ("half = ...\ncheck.that(half == 3, '`half` must be a number')", "Not yet. half is still the TODO"),
        ("half = None\ncheck.that(half > 3, 'no')", "Not yet. half is None."),
        ("check.value(omx.pose([1, 2]).x, 3)", "With your answer the check comes to this: `q` must be the four"),
        (
            "def g():\n    raise NotImplementedError('Exercise 7.2 is still to do.')\ncheck.that(g(), '')",
            "still to do.",
        ),
        ("check.value(1, 7, 'half')", "Not yet. half is not right. It is too small."),
        (
            "check.value(1 / 0, 2)",
            "The check stops with ZeroDivisionError: division by zero, in its line `check.value(1",
        ),
    ],
)
def test_a_check_cell_shows_one_sentence(run, cell, sentence):
    error, _, shown = run(cell)
    assert sentence in error
    assert error.startswith("Not yet. ")
    assert len(error.splitlines()) == 1
    assert not shown


def test_a_check_says_where_to_look_when_the_cell_of_the_answer_has_stopped(run):
    run("half = 3.0")
    for stops in ("half = 1 / 0", "half = (3.0", "half = missing"):
        run(stops, "cell-0")
        for wanted in (7.0, 3.0):  # the older answer was right, too: no tick for a cell that does not run
            error, printed, _ = run(f"check.value(half, {wanted}, 'half')")
            assert error.startswith("Not yet. The cell that makes half stopped with an error.")
            assert not printed
    run("half = 2.0", "cell-0")
    error, _, _ = run("check.value(half, 7.0, 'half')")
    assert "too small" in error


def test_a_cell_that_python_cannot_read_shows_its_line_alone(run):
    for cell in ("def half():\nreturn 3.0", "half = (3.0", "half = 3.0)"):
        error, _, _ = run(cell, "cell-0")
        assert "Traceback" not in error
        assert "IPython" not in error
        assert "Error" in error.splitlines()[-1]
    run("half = 3.0", "cell-0")


def test_a_check_cell_says_each_thing_once(run):
    assert run("for _ in range(3):\n    check.that(True, 'no', 'caught')")[1] == "Correct: caught.\n"
    assert run("check.that(True, 'no', 'caught')")[1] == "Correct: caught.\n"


def test_a_cell_without_checks_shows_its_errors_in_full_and_ours_shortly(run):
    error, _, _ = run("1 / 0")
    assert "Traceback" in error
    error, _, _ = run("def mine(q):\n    return omx.fk(q)\n\nmine([1, 2])")
    assert "line 4:   mine([1, 2])\nline 2 of mine:   return omx.fk(q)\nBadInput: `q` must be" in error
    assert "site-packages" not in error
    assert "kinematics" not in error


def test_a_passed_check_has_a_tick_and_is_kept_on_this_disk(run, folder):
    assert run("check.value(3.0, 3.0, 'half')")[1:] == ("Correct: half.\n", "✓ 1 of 2 exercises of this chapter done.")
    assert json.loads((folder / passed.FILE).read_text())[CHECK] is True
    assert list(passed.progress(folder).values()) == [[False, True]]
    run("check.value(2.0, 3.0, 'half')")
    assert list(passed.progress(folder).values()) == [[False, False]]


def test_a_folder_that_cannot_be_written_stops_nobody(tmp_path):
    assert passed.record("cell", True, tmp_path / "missing") == ""
