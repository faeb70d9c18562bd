"""A pytest plugin: one run of each chapter for everybody, which the site, the slides and the other tests use again.

`install` teaches nbval to run a chapter as the site does, with its scenes as data, and to keep the outputs once every
cell has passed. Stored outputs are compared with the eyes of the normaliser: no figures, widgets or scenes. What
accepts the right answers of an exercise must then refuse wrong ones, in the same kernel: `trials.py` tries them.
"""

import json
import os
import tempfile
from unittest import mock

import nbformat
from nbformat import NotebookNode
from nbval import kernel, plugin

from book.chapters import normalise
from book.chapters.kernels import BlockingSocketKernelManager
from book.publish import runs
from tests.helpers import exercises

#: For all wrong answers of one exercise; they take seconds.
TRIAL_TIMEOUT_S = 300

_set_up, _tear_down = plugin.IPyNbFile.setup, plugin.IPyNbFile.teardown
_message, _run, _compare = (
    plugin.IPyNbFile.get_kernel_message,
    plugin.IPyNbCell.runtest,
    plugin.IPyNbCell.compare_outputs,
)


def pytest_configure(config):
    """Keep the checked-in modules out of every notebook's reach, and let kernels keep their bytecode."""
    install()
    config.generated = tempfile.TemporaryDirectory(prefix="omx-generated-")
    os.environ["OMX_GENERATED"] = config.generated.name
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)


def pytest_unconfigure(config):
    os.environ.pop("OMX_GENERATED", None)
    config.generated.cleanup()


def pytest_collection_modifyitems(items):
    """Let nbval look at every cell, and give a kernel on a busy machine time to say what it printed."""
    for item in items:
        if isinstance(item, plugin.IPyNbCell):
            item.output_timeout = 30
            if item.cell.execution_count is None and not item.cell.outputs:
                item.cell.execution_count = 0  # stored without outputs, so it must have none; nbval would skip it


def install():
    """Put all of this in the place of nbval's own."""
    kernel.KernelManager = BlockingSocketKernelManager
    kernel.RunningKernel.stop = stop_politely
    plugin.coalesce_streams = joined
    plugin.IPyNbFile.setup, plugin.IPyNbFile.teardown = set_up, tear_down
    plugin.IPyNbFile.get_kernel_message = get_message
    plugin.IPyNbCell.runtest, plugin.IPyNbCell.compare_outputs = run_cell, compare_as_stored


def is_chapter(file):
    return file.path.parent == normalise.NOTEBOOKS


def set_up(file):
    file.passed, file.displays = {}, {}
    file.jobs = exercises.jobs(normalise.read(file.path)["cells"])
    with mock.patch.dict(os.environ, runs.variables(file.path) if is_chapter(file) else {}):
        _set_up(file)


def run_cell(cell):
    number, job = cell.cell_num, cell.parent.jobs.get(cell.cell_num)
    if number in cell.parent.jobs:
        told_by(cell.parent.kernel, f"remember({'after' if job else 'before'!r})")
    _run(cell)
    if job:
        faults, table = json.loads(told_by(cell.parent.kernel, f"tried({json.dumps(job)!r})"))
        print(job["title"], *table, sep="\n")
        if faults:
            cell.raise_cell_error(f"{job['title']}: the check does not refuse as it should", "\n".join(faults))
    cell.parent.passed[number] = cell.test_outputs


def told_by(kernel, call):
    """What a function of `trials.py` prints in the kernel; names, history and outputs of the chapter stay the same."""
    asked = kernel.kc.execute(f"__import__('tests.helpers.trials').helpers.trials.{call}", silent=True)
    kernel.await_reply(asked, timeout=TRIAL_TIMEOUT_S)
    said = []
    while True:
        message = kernel.get_message("iopub", timeout=30)
        if message["parent_header"].get("msg_id") != asked:
            continue
        if message["msg_type"] == "error":
            raise RuntimeError("\n".join(message["content"]["traceback"]))
        if message["msg_type"] == "stream":
            said.append(message["content"]["text"])
        elif message["content"].get("execution_state") == "idle":
            return "".join(said)


def tear_down(file):
    """End the kernel; keep the run of a chapter of which every cell has passed."""
    _tear_down(file)
    if is_chapter(file):
        notebook = nbformat.read(file.path, as_version=4)
        cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
        if len(file.passed) == len(cells):
            for number, cell in enumerate(cells):
                cell.outputs = file.passed[number]
            runs.keep(file.path, notebook)


def get_message(file, timeout=None, stream="iopub"):
    """A message of the kernel; one that changes an earlier output is worked into that, as a page does."""
    while True:
        message = _message(file, timeout, stream)
        content = message["content"]
        display = content.get("transient", {}).get("display_id")
        if message["msg_type"] == "update_display_data":
            if display in file.displays:
                file.displays[display].update(content["data"])
            continue
        if message["msg_type"] == "display_data":
            content["data"] = file.displays[display] = NotebookNode(content["data"])
        return message


def stop_politely(kernel):
    """Let the kernel run its exit handlers (arms let go of their ports) instead of killing it."""
    kernel.km.shutdown_kernel(now=False)
    kernel.kc.stop_channels()
    del kernel.km


def compare_as_stored(cell, test, ref, skip_compare=None):
    """Compare what the normaliser would store of a cell's outputs."""
    return _compare(cell, joined(normalise.clean_outputs(json.loads(json.dumps(test)))), ref, skip_compare)


def joined(outputs):
    """Outputs as nbformat reads them back: neighbouring pieces of one stream joined, texts as one string."""
    joined = [nbformat.from_dict(output) for output in normalise.join_streams(outputs)]
    for output in joined:
        if "data" in output:
            output["data"] = {
                mime: normalise.text_of(v) if isinstance(v, list) else v for mime, v in output.data.items()
            }
    return joined
