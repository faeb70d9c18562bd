"""A virtual OpenMANIPULATOR-X behind the wire: it speaks the servos' own protocol, byte for byte.

`VirtualArm` is the mechanics and the five servos; `VirtualPort` is a port to it inside this process; and
`python -m omx.virtual` serves it to other programs.
"""

from ..dynamixel.clock import Clock, SteppedClock
from .arm import VirtualArm
from .port import VirtualPort

__all__ = ["Clock", "SteppedClock", "VirtualArm", "VirtualPort"]
