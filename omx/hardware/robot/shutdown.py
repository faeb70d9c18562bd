"""Arms that nobody closed: what becomes of them when a cell fails, and when the program ends."""

import atexit
import contextlib
import logging
import sys
import weakref

_open = weakref.WeakSet()
_log = logging.getLogger("omx.robot")


def look_after(robot) -> None:
    """From now on a notebook cell that ends in an error makes `robot` hold, and so does the end of the program."""
    _open.add(robot)
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython else None
    if shell and _after_cell not in shell.events.callbacks["post_run_cell"]:
        shell.events.register("post_run_cell", _after_cell)


def let_go(robot) -> None:
    """It was closed as it should be."""
    _open.discard(robot)


def say_motors_on(robot, why: str) -> None:
    """One sentence for whoever leaves an arm with its motors on: that they are, and how to go on."""
    again = "Robot()" if robot.arm else f"Robot({robot.bus.name!r})"
    _log.warning(
        "%s: %s, so the arm holds, and its MOTORS ARE ON: `robot = %s` and `robot.park()` fold it and switch them off; "
        "or support the arm and switch off its power.",
        robot.bus.name, why, again,
    )  # fmt: skip


def _after_cell(result) -> None:
    """A cell that ends in an error, or is interrupted, while an arm moves makes that arm hold."""
    error = result.error_in_exec
    for robot in list(_open) if error else ():
        if robot.bus.is_open and robot.driver.moving:
            robot.driver.broken_off(error)


@atexit.register
def _at_exit() -> None:
    """A program that ends without `close`, a kernel that is restarted: nobody may be near the arm, so it holds.

    A fork of the program comes by here, too; its ports are closed.
    """
    for robot in list(_open):
        if robot.bus.is_open:
            with contextlib.suppress(Exception):
                if robot.driver.torque and not robot.arm:
                    robot.driver.halt()
                    say_motors_on(robot, "the program ended without `robot.close()`")
            with contextlib.suppress(Exception):
                robot.bus.close()
