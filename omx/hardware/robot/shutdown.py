"""Arms that nobody closed: when a cell fails, when nobody has them any more, and when the program ends."""

import contextlib
import logging
import sys
import weakref

from ..simulator.virtual_port import NAME as VIRTUAL

_open = weakref.WeakSet()
_log = logging.getLogger("omx.robot")


def look_after(robot) -> None:
    """From now on `robot` holds where a notebook cell ends in an error, where nobody has it any more, and at the end.

    At the end of the program, that is, or where a kernel is restarted: nobody may be near the arm, so it does not park.
    """
    _open.add(robot)
    weakref.finalize(robot, _left, robot.driver)
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython else None
    if shell and _after_cell not in shell.events.callbacks["post_run_cell"]:
        shell.events.register("post_run_cell", _after_cell)


def say_motors_on(driver, why: str) -> None:
    """One sentence for whoever leaves an arm with its motors on: that they are, and how to go on."""
    name = driver.bus.name
    _log.warning(
        "%s: %s, so the arm holds, and its MOTORS ARE ON: `robot = %s` and `robot.park()` fold it and switch them off; "
        "or support the arm and switch off its power.",
        name, why, "Robot()" if name == VIRTUAL else f"Robot({name!r})",
    )  # fmt: skip


def _after_cell(result) -> None:
    """A cell that ends in an error while an arm moves makes it hold; one that is interrupted its fingers, too."""
    error = result.error_in_exec
    for robot in list(_open) if error else ():
        if robot.bus.is_open and (robot.driver.moving or robot.driver.gripper.moving):
            robot.driver.broken_off(error)


def _left(driver) -> None:
    """Nobody closed it. A virtual arm goes with its program; a fork of the program comes by here, its ports closed."""
    if driver.bus.is_open:
        with contextlib.suppress(Exception):
            if driver.torque and driver.bus.name != VIRTUAL:
                driver.halt()
                say_motors_on(driver, "the program left it without `robot.close()`")
        with contextlib.suppress(Exception):
            driver.bus.close()
