"""Arms that nobody closed: what becomes of them when a cell fails, and when the program ends."""

import atexit
import contextlib
import sys
import weakref

_open = weakref.WeakSet()


def look_after(robot) -> None:
    """From now on: a notebook cell that ends in an error makes `robot` hold, the end of the program parks it."""
    _open.add(robot)
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython else None
    if shell and _after_cell not in shell.events.callbacks["post_run_cell"]:
        shell.events.register("post_run_cell", _after_cell)


def let_go(robot) -> None:
    """It was closed as it should be."""
    _open.discard(robot)


def _after_cell(result) -> None:
    """A cell that ends in an error, or is interrupted, while an arm moves makes that arm hold."""
    for robot in list(_open) if result.error_in_exec else ():
        if robot.bus.is_open and robot.driver.moving:
            robot.driver.halt()


@atexit.register
def _at_exit() -> None:
    """A program that ends without `close`: a real arm holds and parks; a virtual one has nothing to fall."""
    for robot in list(_open):
        with contextlib.suppress(Exception):
            if robot.arm is None:
                robot.__exit__(SystemExit, None, None)
            else:
                robot.bus.close()
