"""A virtual OpenMANIPULATOR-X behind the wire: it speaks the servos' own protocol, byte for byte.

`VirtualArm` is the mechanics and the five servos; `VirtualPort` is a port to it inside this process;
`World` is a table with things on it; and `python -m omx.hardware.simulator` serves it to other programs.
"""

from ..clock import Clock, SteppedClock
from .objects import Thing, cube, cup
from .virtual_arm import VirtualArm
from .virtual_port import VirtualPort
from .world import World

__all__ = ["Clock", "SteppedClock", "Thing", "VirtualArm", "VirtualPort", "World", "cube", "cup"]
