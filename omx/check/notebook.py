"""What checks do in a notebook beyond printing: short errors in check cells, a tick, and the reader's progress.

Installed once in the kernel that imports `omx.check`; nothing happens outside a kernel, and nothing leaves this disk.
"""

import ast
import linecache
import re
import sys
import traceback

from ..errors import OmxError, Wrong
from . import answers, passed
from .functions import hint, told
from .validation import present, shortened

CHECKS = re.compile(r"\bcheck\.(?!setup\b|variant\b|student\b)\w+\(")
LINE = 100
#: The names whose cell stopped with an error when it was run last: what they hold is an older answer, or nothing.
stopped: set[str] = set()


def install() -> None:
    """Let the running kernel, if there is one, show short errors in check cells and keep the progress."""
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    if shell is None or not hasattr(shell, "kernel") or getattr(shell, "_omx_checks", False):
        return
    shell._omx_checks = True
    shell.set_custom_exc((Exception,), _shown)
    shell.events.register("pre_run_cell", _before_a_cell)
    shell.events.register("post_run_cell", _after_a_cell)
    _before_a_cell()


def _shown(shell, kind, error, trace, tb_offset=None):
    """IPython's handler of errors: one sentence if a check cell stopped with anything but its own sentence."""
    cell = _cell_of(trace)  # '' where Python could not read the cell at all: then IPython shows its line alone
    older = answers.older if is_check(cell) else ""
    if is_check(cell) and isinstance(error, Wrong) and "still the TODO" in (todo := _unanswered(trace)):
        older = older or todo  # whatever the check makes of the dots
    if not older and (isinstance(error, Wrong) or not is_check(cell)):
        shell.showtraceback((kind, error, trace), tb_offset=tb_offset, running_compiled_code=bool(cell))
        return
    told = Wrong(older or explained(error))
    shell._showtraceback(Wrong, told, told._render_traceback_())


def names(cell: str, context: type) -> set[str]:
    """The names that a cell reads (`ast.Load`), or makes (`ast.Store`): its own, not those inside its functions."""
    try:
        body = ast.parse(cell).body
    except SyntaxError:
        return set(re.findall(r"^(?:def )?(\w+)\s*[=(]", cell, re.M)) if context is ast.Store else set()
    made = {statement.name for statement in body if isinstance(statement, (ast.FunctionDef, ast.ClassDef))}
    seen = [statement for statement in body if context is ast.Load or not hasattr(statement, "name")]
    used = {
        node.id for s in seen for node in ast.walk(s) if isinstance(node, ast.Name) and isinstance(node.ctx, context)
    }
    return used | made if context is ast.Store else used


def _older(cell: str) -> str:
    """A sentence on the first answer of a check's cell whose own cell has stopped; '' if there is none."""
    for name in sorted(stopped & names(cell, ast.Load)) if is_check(cell) else ():
        return (
            f"The cell that makes {name} stopped with an error. Put that right first; "
            "this check saw what was there before."
        )
    return ""


def is_check(cell: str) -> bool:
    """Is this the source of a cell that checks an answer?"""
    return bool(CHECKS.search(cell))


def explained(error: Exception) -> str:
    """One sentence for an error that is not the check's own: where the answer stops, and what to look at."""
    if isinstance(error, NotImplementedError):
        return str(error) or "Something that the check uses is still the TODO."
    if todo := _unanswered(error.__traceback__):
        return todo
    if isinstance(error, OmxError):
        return f"With your answer the check comes to this: {shortened(str(error), 300)}"
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if of_a_cell(frame.filename)]
    said = shortened(told(error), LINE)
    if not frames:
        return f"The check stops with {said}."
    first, last = frames[0], frames[-1]
    line = f", in its line `{shortened(last.line or '', LINE)}`" if last.line else ""
    who = "The check stops" if last.filename == first.filename else f"{last.name} stops"
    return f"{who} with {said}{line}. {hint(error)}".rstrip()


def _unanswered(trace) -> str:
    """A sentence on the first name in the line of the check that is None or still a TODO; '' if there is none."""
    cells = [(frame, number) for frame, number in traceback.walk_tb(trace) if of_a_cell(frame.f_code.co_filename)]
    if not cells:
        return ""
    frame = cells[0][0]
    for name in frame.f_code.co_names:
        try:
            present(frame.f_globals.get(name, 0), name)
        except Wrong as wrong:
            return str(wrong)
    return ""


def of_a_cell(filename: str) -> bool:
    return "ipykernel_" in filename or (filename.startswith("<") and not filename.startswith("<frozen"))


def _cell_of(trace) -> str:
    """The source of the cell in which an error came up to IPython."""
    frames = (frame for frame in traceback.extract_tb(trace) if of_a_cell(frame.filename))
    first = next(frames, None)
    return "".join(linecache.getlines(first.filename)) if first else ""


def _before_a_cell(info=None) -> None:
    answers.said = set()
    answers.older = _older(getattr(info, "raw_cell", None) or "")


def _after_a_cell(result) -> None:
    if not is_check(result.info.raw_cell or ""):
        (stopped.difference_update if result.success else stopped.update)(names(result.info.raw_cell or "", ast.Store))
    cell = getattr(result.info, "cell_id", None)
    if not cell or not is_check(result.info.raw_cell or ""):
        return
    done = passed.record(cell, bool(result.success))
    if result.success and done:
        shell = sys.modules["IPython"].get_ipython()
        html = f'<span style="color:#1a7f37;font-weight:600">&#10003;</span> {done}'
        shell.display_pub.publish({"text/html": html, "text/plain": f"\N{CHECK MARK} {done}"})
