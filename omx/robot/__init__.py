"""The arm itself, virtual or real, through one class: `Robot()` needs no hardware, `Robot("auto")` finds yours."""

from .connect import NotReady, find_ports
from .driver import Driver, Reading, Stalled, Stopped, TorqueOff
from .robot import Robot

__all__ = ["Driver", "NotReady", "Reading", "Robot", "Stalled", "Stopped", "TorqueOff", "find_ports"]
