"""The arm itself, virtual or real, through one class: `Robot()` needs no hardware, `Robot("auto")` finds yours."""

from .calibration import load_calibration, save_calibration
from .discovery import find_ports
from .driver import Driver, Reading
from .robot import Robot

__all__ = ["Driver", "Reading", "Robot", "find_ports", "load_calibration", "save_calibration"]
