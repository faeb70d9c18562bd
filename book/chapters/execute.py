"""Run notebooks from top to bottom and store their normalised outputs.

    python -m book.chapters.execute                        # every chapter
    python -m book.chapters.execute notebooks/03-*.ipynb   # these
    python -m book.chapters.execute --dry-run              # run, store nothing

A notebook that fails is left as it was; the cell that failed is printed with its error.
"""

import argparse
import asyncio
import json
import logging
import re
import sys
import time
from pathlib import Path

import nbformat
from nbclient import NotebookClient
from nbclient.exceptions import CellExecutionError, CellTimeoutError, DeadKernelError

from book.chapters import normalise
from book.chapters.kernels import SocketKernelManager
from book.setup.paths import Stop, in_a_sentence

CELL_TIMEOUT_S = 120
START_TIMEOUT_S = 120
ANSI = re.compile(r"\x1b\[[0-9;]*m")


class Failed(Exception):
    """A notebook stopped at a cell: `path`, `number` of the cell (from 1), its `source`, the `reason`."""

    def __init__(self, path, number, source, reason):
        self.path, self.number, self.source, self.reason = path, number, source, reason
        shown = "\n".join("    " + line for line in source.splitlines())
        super().__init__(f"{path} failed at cell {number}:\n\n{shown}\n\n{reason}")


class Client(NotebookClient):
    """nbclient answers Ctrl-C by ending the kernel, and meets that as an error of many kinds: here it is Ctrl-C."""

    ended, _end = 0, None

    async def _async_cleanup_kernel(self):
        self.ended += 1
        self._end = self._end or asyncio.ensure_future(super()._async_cleanup_kernel())
        await self._end

    def run(self, options):
        """Execute the notebook in a kernel that is started with `options`."""
        try:
            self.execute(**options)
        except BaseException as error:
            if self.ended > 1 or isinstance(error, asyncio.CancelledError):  # while the kernel works, or starts
                logging.getLogger("asyncio").disabled = True  # it would tell of each task that met a closed socket
                raise KeyboardInterrupt from error
            raise
        if self.ended > 1:  # when the kernel was ending anyway
            raise KeyboardInterrupt


def run(path, cwd=None, timeout_s=CELL_TIMEOUT_S, allow_errors=False, env=None):
    """Execute the notebook file in a fresh kernel and return it, outputs raw (a NotebookNode).

    `cwd` is the kernel's folder, by default the notebook's own; `env` replaces the kernel's environment.
    Raises `Failed` at the first error in a cell without the tag raises-exception, unless `allow_errors`.
    """
    at = {"number": 0, "cell": None}
    client = Client(
        nbformat.reads(json.dumps(normalise.read(path)), as_version=4),
        timeout=timeout_s,
        startup_timeout=START_TIMEOUT_S,
        kernel_name="python3",
        kernel_manager_class=SocketKernelManager,
        allow_errors=allow_errors,
        resources={"metadata": {"path": str(cwd or Path(path).resolve().parent)}},
        on_cell_start=lambda cell, cell_index: at.update(number=cell_index + 1, cell=cell),
    )
    try:
        client.run({} if env is None else {"env": env})
    except CellTimeoutError as error:
        raise Failed(path, at["number"], at["cell"].source, f"Stopped after {timeout_s} s.") from error
    except DeadKernelError as error:
        raise Failed(path, at["number"], at["cell"].source, "The kernel died in this cell.") from error
    except CellExecutionError as error:
        raise Failed(path, at["number"], at["cell"].source, traceback_of(at["cell"], error)) from error
    return client.nb


def traceback_of(cell, error):
    """The traceback that the cell shows, without colours."""
    for output in cell.outputs:
        if output.output_type == "error":
            return ANSI.sub("", "\n".join(output.traceback))
    return f"{error.ename}: {error.evalue}"


def execute(path, timeout_s=CELL_TIMEOUT_S, dry_run=False):
    """Run one notebook and store its outputs in normal form; True when the file changed."""
    notebook = normalise.normalise(run(path, timeout_s=timeout_s))
    return False if dry_run else normalise.write(path, notebook)


@in_a_sentence
def main(argv=None):
    parser = argparse.ArgumentParser("python run.py execute", description=__doc__.split("\n")[0])
    parser.add_argument("notebooks", nargs="*", help="default: every chapter")
    parser.add_argument("--timeout", type=int, default=CELL_TIMEOUT_S, metavar="S", help="seconds for a cell")
    parser.add_argument("--dry-run", action="store_true", help="run, store nothing")
    options = parser.parse_args(argv)
    failed = 0
    for path in normalise.chapters(options.notebooks):
        start = time.perf_counter()
        try:
            changed = execute(path, options.timeout, options.dry_run)
        except (Failed, Stop) as error:
            failed += 1
            print(error, file=sys.stderr)
            continue
        took = time.perf_counter() - start
        stored = "outputs stored" if changed else "nothing changed"
        print(f"{path}: ran in {took:.1f} s, {stored}", flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
