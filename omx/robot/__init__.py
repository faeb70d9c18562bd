"""The arm itself, virtual or real, through one class: `Robot()` needs no hardware, `Robot("auto")` finds yours."""

from .connect import NotReady, find_ports
from .driver import Driver, Reading
from .robot import Robot
from .trouble import ServoLost, ServoRestarted, Stalled, Stopped, TorqueOff

__all__ = [
    "Driver",
    "NotReady",
    "Reading",
    "Robot",
    "ServoLost",
    "ServoRestarted",
    "Stalled",
    "Stopped",
    "TorqueOff",
    "find_ports",
]
